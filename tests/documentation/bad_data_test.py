#!/usr/bin/env python3
"""Each row of README's table "What happens to bad data" names its tests here, and they exist.

bad_data_test.py CTEST BUILD: the tests are those that `CTEST --test-dir BUILD -N` lists.
A row that is added, dropped or reworded fails until the table below says which tests hold it.
"""
import pathlib
import re
import subprocess
import sys

README = pathlib.Path(__file__).resolve().parents[2] / "README.md"

TESTS = {
    "NaN or infinity in a coordinate, or in a field where a target needs it":
        ["operators.Fields.NumbersThatAreNotFiniteAreNamed", "operators.Fields.NumbersThatNoTargetNeedsDoNotMatter",
         "operators.UnneededData.OnTheBorderOfASupportMayBeAnything",
         "operators.Reconstruct.BadInputIsNamed", "grid.GridInput.BadInputIsNamed",
         "fields.ParticleTable.NanIsNeverHandedOut", "io.Lammps.NanIsReportedWhenUsed"],
    "a point, domain or field of `scatter` and `gather` that is not finite":
        ["transfer.Transfer.RefusesDomainsBeforeAnythingIsWritten", "transfer.TransferData.AmountsThatAreNotFiniteAreNamed",
         "transfer.TransferData.NodalDataThatAreNotFiniteAreNamedWhereTheyAreSeen",
         "transfer.TransferData.FieldsAreCheckedBeforeAnythingIsWritten"],
    "sizes that disagree, a negative radius, an unknown name":
        ["operators.Reconstruct.BadInputIsNamed", "neighbourhood.NeighbourRules.WrongValuesAreNamed",
         "core.Names.SuggestsTheNearestOrListsAll", "programs.MistakesTest.MisspeltNames"],
    "a weight that is negative, NaN or infinite where it is called":
        ["operators.BadWeights.AreErrorsWithQAndW", "operators.BadWeightProducts.AreErrors",
         "grid.GridWeights.BadOnesAreErrors", "weights.Weights.BadValuesAreNamed"],
    "data near the largest number":
        ["operators.HugeData.ConstantsStayConstants", "operators.HugeData.ResultsThatDoNotExistAreErrors",
         "operators.HugeData.TransposesAreFiniteOrSayWhere", "grid.GridExtremes.HugeConstantsStayConstants"],
    "lengths whose squares underflow or overflow":
        ["operators.Underflow.TinyLengthsAreRefused", "shape.TemplateInterface.BadSupportIsNamed"],
    "a broken line in a file":
        ["io.Lammps.BrokenLines", "io.Delimited.RaggedRows", "programs.MistakesTest.Inputs"],
    "text, `NA`, empty cells or a name used twice in a column":
        ["io.Delimited.ColumnsAreTypedWhenTheyAreUsed", "io.Lammps.ColumnsAreTypedWhenTheyAreUsed",
         "io.Delimited.EmptyAndNanCells", "io.Delimited.MissingValues", "programs.FilesTest.MissingValues",
         "programs.FilesTest.ColumnsThatNobodyAsksFor"],
    "a file that ends within a frame":
        ["io.Lammps.TheLastFrameIsCut", "io.Lammps.ACutGzipStreamEndsTheLastFrame",
         "programs.FilesTest.ATruncatedFile"],
    "bytes behind gzip data, or a damaged gzip stream":
        ["io.Read.CutAndDamagedGzip", "io.Read.SurvivesDamagedGzip"],
    "a VTK, XYZ or HDF5 file that is cut, damaged or promises more than it holds":
        ["io.ReadVtk.LegacyWhatIsWrongIsNamed", "io.ReadVtk.XmlWhatIsWrongIsNamed", "io.Xyz.WhatIsWrongIsNamed",
         "io.other_formats_hdf5"],
    "HDF5 with several groups of particles, or with links into other files":
        ["io.other_formats_hdf5"],
    "an array or a text that a format has no place for":
        ["io.WriteParticles.NamesThatAFormatHasNoPlaceFor", "programs.ConvertTest.AnyFormatToAnyFormat"],
    "a triclinic box":
        ["io.Lammps.RestrictedTriclinicBoxes", "io.Lammps.GeneralTriclinicBoxes",
         "fields.ParticleTable.TriclinicBoxes", "programs.FilesTest.TriclinicBoxes"],
    "a full disk, a signal while a file is written":
        ["programs.FilesTest.FullDisks", "programs.FilesTest.Signals", "io.AtomicFile.Signals",
         "programs.MpmProgram.AFullDiskIsAnError", "programs.MpmProgram.ASignalSavesTheRun"],
    "one coordinate the same for all particles":
        ["fields.ParticleTable.AConstantCoordinateCountsAsNone", "programs.MapTest.ConstantZMeansTwoDimensions",
         "programs.MapTest.AnyTwoCoordinatesMakeTwoDimensions"],
    "several particles at one place":
        ["programs.InfoTest.CountsCoincidentParticles", "operators.Reproduction.EverySolverOnEveryCloudWithRadius",
         "operators.ParticleWeights.CountLikeCopies"],
    "fewer neighbours than the degree needs":
        ["operators.PeerFailures.FewerNeighboursThanTerms", "operators.Reproduction.EverySolverOnEveryCloudWithRadius"],
    "particles on a line, a plane, a sphere":
        ["local_solve.GramSchmidt.RankOfKnownClouds", "operators.PeerFailures.CollinearSupportIsFinite",
         "papers.Tran2019.ALineOfPointsKeepsTheQuadraticAlongIt"],
    "a sheet or line whose thickness is noise":
        ["operators.ThinClouds.NoSlopeAcrossASheet", "operators.ThinClouds.ValuesStayAsTheyAre",
         "operators.ThinClouds.CurvedSheet", "grid.GridThinClouds.NoSlopeAcrossASheet"],
    "a target far outside the particles":
        ["operators.TooFar.ByTheDistanceToTheNearestParticle", "operators.TooFar.DenseParticlesHaveNone",
         "programs.MapTest.TargetsTooFarFromAllParticles", "operators.DenseCluster.ExtrapolationIsStillDropped",
         "papers.Tran2019.Figure2TheGuardLowersTheDegreeFarFromThePoints"],
    "a step, a hole or a free surface, where a fit overshoots its data":
        ["operators.Limits.ValuesAreTheNearestInTheRangeOfTheirData", "operators.Limits.AStepGetsNoNewExtremum",
         "grid.GridLimits.ValuesAreTheNearestInTheRangeOfTheirData", "programs.MapTest.ValuesStayNearTheirData",
         "programs.MapTest.LimitedValuesAreCounted", "programs.OutsideTest.CloudsThatDoNotFillTheirBox"],
    "no particle in the support":
        ["operators.Reconstruct.NoSupportIsFilledOrNearest", "grid.GridInput.NoFieldsNoParticlesAndAFillValue",
         "programs.MapTest.WithoutSupport"],
    "a nearly singular moment matrix":
        ["operators.PeerFailures.SingularMomentMatrixIsNoticed"],
    "particles near a curve or a thin bowl, degree 2 or more":
        ["operators.RandomClouds.HessiansOfQuadraticsAreRightOrNone", "operators.ThinClouds.HessianOfAlmostFlatBowls"],
    "too few particles for all second derivatives, or particles on a circle":
        ["operators.HessianRank.CountsTheTermsThatAreKept"],
    "a functional of your own that gives NaN or leaves a number unwritten":
        ["operators.OwnFunctionalOptions.MistakesAreNamed"],
    "an option that sums over the cells of a grid cannot honour":
        ["grid.GridMomentsRefuse.WhatGoesByLists", "grid.GridByLists.EveryOptionIsHonouredInEveryPart"],
    "a search that recon was built without":
        ["consumer.without_trees"],
    "an operator scaled or added beyond the largest number":
        ["operators.OperatorArithmetic.RefusesEntriesThatOverflow"],
    "a fit, operator or report of `Sources` that have been updated":
        ["operators.Sources.WhatWasMadeBeforeAnUpdateIsRefused"],
    "a support tensor that is not symmetric, finite and positive definite, or whose half axes differ by more than 1e5 (in float 1e3)":
        ["neighbourhood.EllipsoidRules.WhatIsWrongIsNamed", "neighbourhood.EllipsoidRules.OfFloatAreRounder",
         "neighbourhood.SupportTensors.OfWrongHalfAxesAreRefused", "neighbourhood.OwnTensorList.WhatIsWrongIsNamed",
         "operators.EllipsoidPattern.WhatIsWrongIsNamed"],
    "a consistent mass that the particles do not determine":
        ["transfer.MassMatrixErrors.NameTheNode", "mpm.ConsistentMassFailures.NameANode"],
    "a value that is no number in a `--json` summary":
        ["programs.HabitsTest.WhatIsNoNumberIsNull"],
    "a grid whose neighbouring nodes would coincide, or that has no cells":
        ["points.StructuredGrids.NeighbouringNodesHavePlacesOfTheirOwn",
         "transfer.GridErrors.NeighbouringNodesHavePlacesOfTheirOwn", "transfer.GridErrors.AGridWithoutCellsIsNamed"],
    "a kernel sum with a radius whose 1/rho^D is no normal number":
        ["operators.KernelSums.KeepTheirDigitsOrNameTheRadius"],
    "a support smaller than the grid's spacing in a kernel sum":
        ["programs.MapTest.SumsAreCompared"],
    "a condition with an unknown column, an assignment, or `0 < x < 5`":
        ["programs.WhereTest.Mistakes"],
    "a body of the material point method across the border of the grid":
        ["runs.MpmFiles.BodiesLieInTheGrid", "mpm.Problems.AreChecked"],
    "a wall between the nodes without room for images beyond it, of which only a part is held, or that moves":
        ["mpm.ImagesOfParticles.RefuseWhatTheyCannotBe", "runs.MpmFiles.WhatAFileSaysIsCheckedByTheProblem"],
    "a step that does not move the clock, more steps or memory than there is":
        ["mpm.States.AreOfOneTime", "runs.MpmFiles.TooMuchIsRefusedWithNumbers",
         "programs.MistakesTest.MoreMemoryThanThereIs"],
    "a step longer than the method bears, a method known to break there":
        ["programs.MpmProgram.StabilityLimits", "studies.Stability.LimitFollowsFromTheMaps",
         "mpm.Elements.WithStressBreakWhenAMassChangesItsSign"],
    "choices of a method that do not go together, unknown words in a composition":
        ["mpm.Methods.SayWhyChoicesAreRefused", "runs.Composition.IsARowWithOtherChoices", "runs.MpmFiles.MethodsAreComposed"],
    "a point of another dimension than the grid's in `scatter` and `gather`":
        ["structure.scatter_of_another_dimension_is_refused_arrays",
         "structure.scatter_of_another_dimension_is_refused_eigen",
         "structure.scatter_of_another_dimension_is_refused_one_point"],
    "a checkpoint that is damaged, or of another problem":
        ["runs.MpmCheckpoint.BelongsToItsProblem", "runs.MpmCheckpoint.DamageIsFound",
         "runs.MpmCheckpoint.ContentsAreCheckedBeforeTheyAreUsed", "runs.MpmCheckpoint.ChangedCopiesDoNotCrash"],
}


def rows_of_readme():
    section = README.read_text(encoding="utf-8").split("## What happens to bad data", 1)[1].split("\n## ", 1)[0]
    rows = [line.split("|")[1].strip() for line in section.splitlines() if line.startswith("|")]
    return rows[2:]  # without the header and the line below it


def listed_tests(ctest, build):
    text = subprocess.run([ctest, "--test-dir", build, "-N"], check=True, capture_output=True, text=True).stdout
    # Typed and value-parametrised tests, "name<0>" and "Mpm/name/mpm", count by their name.
    return {match[1] for match in re.finditer(r"^ *Test +#\d+: ([\w.-]+(?:/\w+\.\w+)?)", text, re.MULTILINE)}


def main():
    ctest, build = sys.argv[1:]
    rows, known = rows_of_readme(), listed_tests(ctest, build)
    wrong = [f"README's row without tests: {row}" for row in rows if not TESTS.get(row)]
    wrong += [f"no row of README: {row}" for row in TESTS if row not in rows]
    wrong += [f"no such test: {test} ({row})" for row, tests in TESTS.items() for test in tests if test not in known]
    if not rows or not known:
        wrong.append(f"{len(rows)} rows and {len(known)} tests were found")
    print("\n".join(wrong) if wrong else f"{len(rows)} rows, {sum(map(len, TESTS.values()))} tests")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
