// The same calls with each instruction set that this processor and this build have.
#include <optional>

#include "answers.hpp"
#include "cloud.hpp"
#include "flops.hpp"
#include "lab.hpp"

namespace recon_bench {
namespace {

constexpr CloudSetting setting{3, 2, 20};
constexpr recon::Solver solvers[] = {recon::Solver::moment_matrix, recon::Solver::gram_schmidt};

template <class Scalar>
void time_scalar(Lab& lab, const std::string& scalar, Table& table) {
  const Cloud<Scalar, 3> cloud(lab.context.smoke ? smoke_cloud_size : cloud_size);
  const auto sets = recon::available_instruction_sets();
  const auto call = [&](recon::InstructionSet set, recon::Solver solver) {
    return ReconCall{.degree = setting.degree,
                     .k = static_cast<std::size_t>(setting.k),
                     .threads = lab.context.threads,
                     .solver = solver,
                     .set = set};
  };
  using Fit = recon::BasicReconstruction<Scalar>;
  const auto generic = recon::InstructionSet::generic;
  const auto list = call(generic, solvers[0]).find(cloud);
  recon::NeighbourList<Scalar> found, copy;
  std::optional<Fit> fit;
  std::vector<Scalar> out(cloud.targets.size());

  // A row for a stage; the times of all sets against those of the generic one.
  const auto stage = [&](const std::string& name, bool good, auto contestant) {
    std::vector<Contestant> all;
    for (const auto set : sets) all.push_back(contestant(set));
    std::vector<Times> times(all.size());
    if (good) times = lab.stopwatch.run("instruction_set/" + scalar + "/" + name, all, 0.5);
    for (std::size_t i = 0; i < all.size(); ++i)
      table.add(
          {scalar, name, std::string(name_of(sets[i])),
           good ? number(times[i].best() / static_cast<double>(out.size()) * 1e6) : wrong_answer,
           number(speedup(times[i], times[0]))});
  };

  bool good = true;
  for (const auto set : sets) {
    const auto other = call(set, solvers[0]).find(cloud);
    good = lab.checks.hold(other.indices == list.indices && other.support == list.support,
                           "search with " + std::string(name_of(set)) + ": other neighbours") &&
           good;
  }
  stage("search", good, [&](recon::InstructionSet set) {
    return Contestant{std::string(name_of(set)),
                      [&, set] { found = call(set, solvers[0]).find(cloud); }, [&] { found = {}; }};
  });
  for (const recon::Solver solver : solvers) {
    const std::string with = " " + std::string(name_of(solver));
    std::vector<Scalar> reference(out.size());
    call(generic, solver)
        .construct(cloud, list)
        .apply(recon::field_of(cloud.u), recon::field_of(reference));
    good = true;
    for (const auto set : sets) {
      const Fit other = call(set, solver).construct(cloud, list);
      other.apply(recon::field_of(cloud.u), recon::field_of(out));
      good = lab.checks.within(compare_values<Scalar>(out, reference, other.report(), terms(3, 2)),
                               "construct" + with + " with " + std::string(name_of(set))) &&
             good;
    }
    stage("construct" + with, good, [&, solver](recon::InstructionSet set) {
      return Contestant{
          std::string(name_of(set)),
          [&, set, solver] { fit.emplace(call(set, solver).construct(cloud, std::move(copy))); },
          [&] {
            fit.reset();
            copy = list;
          }};
    });
    stage("all" + with, good, [&, solver](recon::InstructionSet set) {
      return Contestant{std::string(name_of(set)),
                        [&, set, solver] {
                          fit.emplace(call(set, solver).reconstruct(cloud));
                          fit->apply(recon::field_of(cloud.u), recon::field_of(out));
                        },
                        [&] { fit.reset(); }};
    });
  }
}

}  // namespace

Section run_instruction_sets(Lab& lab) {
  Section section{
      "Instruction sets",
      "Cloud, " + setting.name() +
          ": recon's kernels with each instruction set in turn, and how many times faster "
          "than the generic one each is.",
      {},
      {}};
  if constexpr (has_instruction_set<recon::Options>) {
    progress("instruction sets");
    Table table("instruction_sets",
                {"scalar", "stage", "instruction set", "us per target", "ratio"});
    time_scalar<double>(lab, "double", table);
    time_scalar<float>(lab, "float", table);
    section.tables = {table};
  } else {
    section.text += " This version of recon does not let one choose.";
  }
  return section;
}

}  // namespace recon_bench
