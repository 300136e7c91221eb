// XYZ, plain and extended.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recon/io/read.hpp"
#include "recon/io/write_particles.hpp"
#include "temporary.hpp"

namespace {

using recon::ParticleTable;
using recon::read_particles;
using recon::read_particles_of;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string extended =
    "2\nLattice=\"4 0 0 0 5 0 0 0 6\" Origin=\"-2 0 1\" pbc=\"T F T\" Time=0.5 "
    "Properties=species:S:1:pos:R:3:id:I:1:velo:R:3:fixed:L:1 Step=7 note='a b'\n"
    "Fe -1 2 3 11 0.1 0.2 0.3 T\nO 1 2.5 4 12 -0.1 -0.2 -0.3 F\n"
    "1\nLattice=\"4 0 0 0 5 0 0 0 6\" Properties=species:S:1:pos:R:3 Step=8\nFe 0 0 0\n";

TEST(Xyz, Extended) {
  EXPECT_EQ(recon::list_frames_of(extended).size(), 2u);
  const ParticleTable table = read_particles_of(extended, {.frame = 0});
  EXPECT_THAT(table.names(), ElementsAre("x", "y", "z", "id", "vx", "vy", "vz", "fixed"));
  EXPECT_THAT(table.text_columns(), ElementsAre("element"));
  EXPECT_THAT(table.column("vy"), ElementsAre(0.2, -0.2));
  EXPECT_THAT(table.column("fixed"), ElementsAre(1, 0));
  EXPECT_EQ(table.step, 7);
  EXPECT_EQ(table.time, 0.5);
  EXPECT_EQ(table.box().lower, (std::array<double, 3>{-2, 0, 1}));
  EXPECT_EQ(table.box().upper, (std::array<double, 3>{2, 5, 7}));
  EXPECT_EQ(table.domain().periodic, (std::array<bool, 3>{true, false, true}));
  const ParticleTable second = read_particles_of(extended, {.step = 8});
  EXPECT_EQ(second.periodic_edges(), (std::array<bool, 3>{true, true, true}));
  EXPECT_THAT(second.remarks, testing::Contains(HasSubstr("no pbc")));
}

TEST(Xyz, PlainAndTilted) {
  const ParticleTable plain =
      read_particles_of("2\nanything = at \"all\nH 0 1 2 0.5\nH 3 4 5 0.25\n");
  EXPECT_THAT(plain.column("column_5"), ElementsAre(0.5, 0.25));
  EXPECT_FALSE(plain.has_box());
  const ParticleTable tilted =
      read_particles_of("1\nLattice=\"4 0 0 1 5 0 0 0 6\" Properties=pos:R:3\n1 2 3\n");
  ASSERT_TRUE(tilted.cell());
  EXPECT_EQ(tilted.cell()->edges[1][0], 1);
}

TEST(Xyz, WhatIsWrongIsNamed) {
  const auto expect = [](const std::string& text, std::size_t line, const std::string& part) {
    test::expect_file_error([&] { read_particles_of(text); }, line, part);
  };
  const std::string properties = "1\nProperties=species:S:1:pos:R:3";
  expect("2\n\nH 0 0 0\n", 3, "after 1 of the 2 particles");
  expect("1\n\nH 0 0\n", 3, "3 cells");
  expect(properties + "\nH 0 0 0 0\n", 3, "the frame at line 1 has 4 columns");
  expect(properties + ":q\nH 0 0 0\n", 2, "name:type:columns");
  expect(properties + ":q:X:1\nH 0 0 0\n", 2, "one of the types S, R, I, L");
  expect(properties + ":q:R:-1\nH 0 0 0\n", 2, "from 1 to 10000");
  expect(properties + ":q:R:999999999999\nH 0 0 0\n", 2, "from 1 to 10000");
  expect(properties + ":q:L:1\nH 0 0 0 1\n", 3, "neither T nor F");
  expect(properties + " Lattice=\"1 0 0 0 1 0 0 0\"\nH 0 0 0\n", 2, "Lattice needs 9 numbers");
  expect(properties + " Lattice=\"1 0 0 0 1 0 0 0 x\"\nH 0 0 0\n", 2, "'x' is no finite number");
  expect(properties + " Lattice=\"1 0 0 0 1 0 0 0 0\"\nH 0 0 0\n", 2, "must have a length");
  expect(properties + " Lattice=\"1e308 0 0 0 1 0 0 0 1\" Origin=\"1e308 0 0\"\nH 0 0 0\n", 1,
         "must be finite");
  expect(properties + " pbc=\"T F\"\nH 0 0 0\n", 2, "three letters");
  expect(properties + " pbc=\"T F\nH 0 0 0\n", 2, "does not end on this line");
  expect(properties + " Time=soon\nH 0 0 0\n", 2, "Time needs 1");
  expect(properties + " Step=1.5\nH 0 0 0\n", 2, "no whole number");
  expect("1\n\nH 0 0 0\nmore\n", 4, "the number of particles");
  expect("99999999999999\n\nH 0 0 0\n", 3, "after 1 of the 99999999999999");
  // A run that was stopped: the frames before are whole.
  const auto cut = extended.substr(0, extended.size() - 12);
  EXPECT_EQ(recon::list_frames_of(cut).size(), 1u);
}

// Whatever is read is written so that it reads back: to XYZ, to a dump, and to H5MD and back.
TEST(WriteParticles, ReadsBackToTheBit) {
  const test::TemporaryFolder folder;
  const std::string tilted =
      "2\nLattice=\"4 0 0 1 5 0 0.25 0.5 6\" Origin=\"-2 0 1\" pbc=\"T F T\" Time=0.1 "
      "Properties=species:S:1:pos:R:3:id:I:1:velo:R:3:q:R:1 Step=7\n"
      "Fe -1 0.1 3 11 0.1 0.2 0.3 1e-300\nO 1 2.5 4 12 -0.1 -0.2 -0.3 nan\n";
  for (const std::string& text : {extended, tilted})
    for (const std::string name : {"a.xyz", "a.dump", "a.h5"}) {
      const ParticleTable table = read_particles_of(text, {.frame = 0});
      recon::write_particles(folder / name, table);
      const ParticleTable back = read_particles(folder / name);
      EXPECT_EQ(back.step, table.step) << name;
      EXPECT_EQ(back.time, table.time) << name;
      EXPECT_EQ(back.periodic_edges(), table.periodic_edges()) << name;
      EXPECT_EQ(back.source_cell()->origin, table.source_cell()->origin) << name;
      EXPECT_EQ(back.source_cell()->edges, table.source_cell()->edges) << name;
      for (const std::string& column : table.names())
        for (std::size_t i = 0; i < table.size(); ++i)
          EXPECT_TRUE(back.raw_column(column)[i] == table.raw_column(column)[i] ||
                      std::isnan(table.raw_column(column)[i]))
              << name << " " << column;
      const bool texts = name != std::string("a.h5");
      EXPECT_EQ(back.has("element"), texts) << name;
    }
}

TEST(WriteParticles, NamesThatAFormatHasNoPlaceFor) {
  const test::TemporaryFolder folder;
  const ParticleTable table = read_particles_of(
      "id,type,Points:0,Points:1,Points:2,\"v [m/s]\",label\n1,2,0.5,1.5,2.5,3,a b\n", {}, "a.csv");
  for (const std::string name : {"a.xyz", "a.dump"}) {
    recon::write_particles(folder / name, table);
    const ParticleTable back = read_particles(folder / name);
    EXPECT_EQ(back.column("z")[0], 2.5) << name;
    EXPECT_EQ(back.column("type")[0], 2) << name;
    EXPECT_EQ(back.column("v_[m/s]")[0], 3) << name;
    EXPECT_THAT(back.describe_text("label"), HasSubstr("'a_b'")) << name;
  }
  test::expect_invalid([&] { read_particles_of("x\n1\n", {.group = "atoms"}); },
                       "is for HDF5 files only");
}

TEST(WriteParticles, SeriesAndRefusals) {
  const test::TemporaryFolder folder;
  for (const std::string name : {"a.xyz", "a.dump"}) {
    recon::ParticleWriter writer(folder / name);
    for (int frame = 0; frame < 2; ++frame)
      writer.add(read_particles_of(extended, {.frame = frame}));
    EXPECT_FALSE(std::filesystem::exists(folder / name));
    writer.commit();
    ASSERT_EQ(recon::list_frames(folder / name).size(), 2u) << name;
    EXPECT_EQ(recon::list_frames(folder / name)[1].step, 8) << name;
  }
  const ParticleTable first = read_particles_of(extended, {.frame = 0}),
                      second = read_particles_of(extended, {.frame = 1});
  recon::ParticleWriter csv(folder / "b.csv"), h5md(folder / "b.h5");
  csv.add(first);
  test::expect_invalid([&] { csv.add(second); }, "must be 1 in this format");
  h5md.add(first);
  EXPECT_THAT(h5md.notes(), ElementsAre("left out: element, which holds texts"));
  test::expect_invalid([&] { h5md.add(second); }, "number of particles");
  test::expect_invalid([&] { recon::ParticleWriter(folder / "c.xyz").commit(); },
                       "number of frames");
  test::expect_file_error([&] { recon::ParticleWriter(folder / "c.xxx"); }, 0, "no extension");
  EXPECT_EQ(folder.entries(), 2u);
}

}  // namespace
