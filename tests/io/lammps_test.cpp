#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "recon/core/error.hpp"
#include "recon/io/read.hpp"
#include "temporary.hpp"

namespace {

using recon::list_frames;
using recon::ParticleTable;
using recon::read_particles;
using test::expect_file_error;
using test::TemporaryFolder;

std::string frame(int step, const std::string& columns, const std::string& atoms, int count,
                  const std::string& bounds = " pp ff fs") {
  return "ITEM: TIMESTEP\n" + std::to_string(step) + "\nITEM: NUMBER OF ATOMS\n" +
         std::to_string(count) + "\nITEM: BOX BOUNDS" + bounds +
         "\n-1 3\n0 2\n-5.0e-1 1e+1\nITEM: ATOMS " + columns + "\n" + atoms;
}

const std::string two_atoms = "7 0.5 1.5 2 1e-3\n3 -1 0.25 4 -2\n";

class Lammps : public testing::Test {
 protected:
  ParticleTable read(const std::string& text, int number = -1) {
    return read_particles(folder.file("a.dump", text), {.frame = number});
  }
  void expect_error(const std::string& text, std::size_t line, const std::string& part) {
    expect_file_error([&] { read(text); }, line, part);
  }
  TemporaryFolder folder;
};

TEST_F(Lammps, ReadsAFrame) {
  const ParticleTable table = read(frame(40, "id x y z vx", two_atoms, 2));
  EXPECT_EQ(table.size(), 2u);
  EXPECT_EQ(table.step, 40);
  EXPECT_FALSE(table.time);
  EXPECT_EQ(table.names(), (std::vector<std::string>{"id", "x", "y", "z", "vx"}));
  EXPECT_EQ(table.column("id"), (std::vector<double>{7, 3}));  // order of the file
  EXPECT_EQ(table.column("vx"), (std::vector<double>{1e-3, -2}));
  EXPECT_EQ(table.dimension(), 3);
  EXPECT_EQ(table.box().lower, (std::array<double, 3>{-1, 0, -0.5}));
  EXPECT_EQ(table.box().upper, (std::array<double, 3>{3, 2, 10}));
  EXPECT_EQ(table.domain().periodic, (std::array<bool, 3>{true, false, false}));
  EXPECT_EQ(table.describe_row(1), "row 1 (id 3, line 11)");
  EXPECT_TRUE(table.remarks.empty());
}

TEST_F(Lammps, ColumnsMayStandInAnyOrder) {
  const ParticleTable table = read(frame(0, "vx z y x c_e[1]", "9 3 2 1 8\n", 1));
  EXPECT_EQ(table.positions(3)(0, 0), 1);
  EXPECT_EQ(table.positions(3)(0, 2), 3);
  EXPECT_EQ(table.column("c_e[1]")[0], 8);
}

TEST_F(Lammps, UnitsAndTime) {
  const std::string text = "ITEM: UNITS\nsi\nITEM: TIME\n0.125\n" +
                           frame(1, "id x y z vx", two_atoms, 2) + "ITEM: TIME\n0.25\n" +
                           frame(2, "id x y z vx", two_atoms, 2);
  EXPECT_EQ(read(text, 0).time, 0.125);
  EXPECT_EQ(read(text, 1).time, 0.25);
  EXPECT_EQ(read(text, 1).units, "si");
  const auto frames = list_frames(folder / "a.dump");
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].line, 16u);
  EXPECT_EQ(frames[1].step, 2);
  EXPECT_EQ(frames[1].particles, 2u);
}

TEST_F(Lammps, ScaledCoordinatesAreUnscaled) {
  const ParticleTable table = read(frame(0, "id xs ys zs", "1 0.25 0.5 0\n2 1 0 1\n", 2));
  EXPECT_EQ(table.column("x"), (std::vector<double>{0, 3}));
  EXPECT_EQ(table.column("y"), (std::vector<double>{1, 0}));
  EXPECT_EQ(table.column("z"), (std::vector<double>{-0.5, 10}));
  EXPECT_EQ(table.remarks.size(), 1u);
  const ParticleTable unwrapped = read(frame(0, "xsu ysu zsu", "1.5 0.5 0\n-1 0 1\n", 2));
  EXPECT_EQ(unwrapped.column("xu"), (std::vector<double>{5, -5}));
  EXPECT_EQ(unwrapped.coordinates(), (std::vector<std::string>{"xu", "yu", "zu"}));
}

TEST_F(Lammps, PlainCoordinatesGoBeforeScaledOnes) {
  const ParticleTable table = read(frame(0, "xs x y z", "0.5 77 1 1\n0.5 78 1 2\n", 2));
  EXPECT_EQ(table.column("x"), (std::vector<double>{77, 78}));
}

TEST_F(Lammps, ConstantZMeansTwoDimensions) {
  const ParticleTable table = read(frame(0, "x y z", "1 2 0\n2 3 0\n", 2, " pp pp pp"));
  EXPECT_EQ(table.dimension(), 2);
  EXPECT_EQ(table.positions().dimension(), 2);
  EXPECT_FALSE(table.domain().periodic[2]);
  EXPECT_TRUE(table.domain(3).periodic[2]);
  EXPECT_EQ(table.box().dimension, 2);
}

TEST_F(Lammps, AllBoundaryFlags) {
  for (const char* flags : {" pp pp pp", " ff fs fm", " sf ss sm", " mf ms mm"})
    EXPECT_EQ(read(frame(0, "x y z", "1 2 0\n", 1, flags)).domain(3).periodic[0],
              std::string(flags) == " pp pp pp");
}

TEST_F(Lammps, WithoutFlagsNotPeriodicAndSaid) {
  const ParticleTable table = read(frame(0, "x y z", "1 2 0\n", 1, ""));
  EXPECT_FALSE(table.domain(3).any());
  ASSERT_EQ(table.remarks.size(), 1u);
  EXPECT_NE(table.remarks[0].find("no boundary flags"), std::string::npos);
}

TEST_F(Lammps, WindowsLineEndsAndBlankEnd) {
  std::string text = frame(3, "id x y z vx", two_atoms, 2), windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(read(windows + "\r\n \r\n").column("vx"), (std::vector<double>{1e-3, -2}));
  text.pop_back();  // last line without an end
  EXPECT_EQ(read(text).column("vx"), (std::vector<double>{1e-3, -2}));
}

TEST_F(Lammps, ColumnsAreTypedWhenTheyAreUsed) {
  const ParticleTable table =
      read(frame(0, "id element type x y z id", "1 Fe 1 1 2 3 1\n2 O C2 2 1 4 2\n", 2));
  EXPECT_EQ(table.positions()(1, 2), 4);
  EXPECT_EQ(table.text_columns(), (std::vector<std::string>{"element", "type"}));
  EXPECT_EQ(table.repeated_names(), (std::vector<std::string>{"id"}));
  EXPECT_EQ(table.remarks.size(), 2u);
  test::expect_invalid([&] { table.column("element"); }, "(id 1, line 10) of a.dump");
  test::expect_invalid([&] { table.column("type"); },
                       "(id 2, line 11) of a.dump, frame 0, step 0 = 'C2'");
  test::expect_invalid([&] { table.column("id"); }, "several columns");
}

TEST_F(Lammps, NamesFromTheOptions) {
  const auto path = folder.file("a.dump", frame(0, "", "1 2 3\n", 1));
  EXPECT_EQ(read_particles(path, {.columns = {"x", "y", "q"}}).column("q")[0], 3);
  expect_file_error([&] { read_particles(path); }, 9, "names no columns");
}

std::string triclinic(const std::string& bounds, const std::string& columns,
                      const std::string& atoms) {
  return "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS " + bounds +
         "ITEM: ATOMS " + columns + "\n" + atoms;
}

TEST_F(Lammps, RestrictedTriclinicBoxes) {
  // lx = 6, ly = 5, lz = 4, xy = 1.5, xz = -2, yz = 0.5 from (0, -1, 2): the bounds are those of
  // the box around it.
  const std::string bounds = "xy xz yz pp pp ff\n-2 7.5 1.5\n-1 4.5 -2\n2 6 0.5\n";
  const ParticleTable table = read(triclinic(bounds, "xs ys zs", "0.5 0.5 0.25\n"));
  EXPECT_EQ(table.column("x")[0], 0 + 0.5 * 6 + 0.5 * 1.5 + 0.25 * -2);
  EXPECT_EQ(table.column("y")[0], -1 + 0.5 * 5 + 0.25 * 0.5);
  EXPECT_EQ(table.column("z")[0], 2 + 0.25 * 4);
  EXPECT_EQ(table.box(3).lower, (std::array<double, 3>{-2, -1, 2}));
  EXPECT_EQ(table.box(3).upper, (std::array<double, 3>{7.5, 4.5, 6}));
  EXPECT_EQ(table.domain(3).periodic, (std::array<bool, 3>{true, false, false}));
  EXPECT_EQ(table.domain(3).lower[0], 0);
  EXPECT_EQ(table.domain(3).upper[0], 6);
  EXPECT_NE(table.remarks.at(0).find("its periods along b = (1.5, 5, 0)"), std::string::npos);
  // Two of three scaled coordinates are not enough where all edges lean.
  EXPECT_FALSE(read(triclinic(bounds, "xs ys zu", "0.5 0.5 0.25\n")).has("x"));

  const ParticleTable fixed =
      read(triclinic("xy xz yz ff ff ff\n-2 7.5 1.5\n-1 4.5 -2\n2 6 0.5\n", "x y z", "1 2 3\n"));
  EXPECT_FALSE(fixed.domain(3).any());
  EXPECT_TRUE(fixed.remarks.empty());
  const ParticleTable upright =
      read(triclinic("xy xz yz pp pp pp\n0.1 0.3 0\n-1 4 0\n2 6 0\n", "x y z", "1 2 3\n"));
  EXPECT_EQ(upright.box(3).upper[0], 0.3);
  EXPECT_EQ(upright.domain(3).periodic, (std::array<bool, 3>{true, true, true}));
  EXPECT_FALSE(upright.cell());
  EXPECT_TRUE(upright.remarks.empty());
}

TEST_F(Lammps, GeneralTriclinicBoxes) {
  const std::string bounds = "abc origin pp pp pp\n3 4 0 -1\n-4 3 0 0\n0 0 2 5\n";
  const ParticleTable table = read(triclinic(bounds, "xs ys zs vx", "0.5 1 0.25 7\n"));
  EXPECT_EQ(table.column("x")[0], -1 + 0.5 * 3 + 1 * -4);
  EXPECT_EQ(table.column("y")[0], 0 + 0.5 * 4 + 1 * 3);
  EXPECT_EQ(table.column("z")[0], 5.5);
  EXPECT_EQ(table.box(3).lower, (std::array<double, 3>{-5, 0, 5}));
  EXPECT_EQ(table.box(3).upper, (std::array<double, 3>{2, 7, 7}));
  EXPECT_EQ(table.domain(3).periodic, (std::array<bool, 3>{false, false, true}));
  EXPECT_NE(table.remarks.at(0).find("a = (3, 4, 0), b = (-4, 3, 0)"), std::string::npos);
}

TEST_F(Lammps, BrokenTriclinicBoxes) {
  expect_error(triclinic("xy xz yz pp pp pp\n0 6\n0 6 0\n0 6 0\n", "x", "1\n"), 6, "three numbers");
  expect_error(triclinic("xy xz yz pp pp\n0 6 0\n0 6 0\n0 6 0\n", "x", "1\n"), 5, "boundary");
  expect_error(triclinic("xy xz yz pp pp pp\n0 1 2\n0 6 0\n0 6 0\n", "x", "1\n"), 6, "along x");
  expect_error(triclinic("abc origin pp pp pp\n1 0 0 0\n0 1 0\n0 0 1 0\n", "x", "1\n"), 7,
               "four numbers");
  expect_error(triclinic("abc origin pp pp pp\n1 0 0 0\n0 0 0 0\n0 0 1 0\n", "x", "1\n"), 7,
               "must have a length");
  expect_error(triclinic("abc origin pp pp pp\n1 0 nan 0\n0 1 0 0\n0 0 1 0\n", "x", "1\n"), 6,
               "no finite number");
}

TEST_F(Lammps, NoAtomsIsAFrameToo) {
  EXPECT_EQ(read(frame(0, "id x y z", "", 0)).size(), 0u);
}

TEST_F(Lammps, NanIsReportedWhenUsed) {
  const ParticleTable table = read(frame(0, "id x y z vx", "7 1 2 3 nan\n8 1 inf 4 0\n", 2));
  EXPECT_TRUE(std::isnan(table.raw_column("vx")[0]));
  test::expect_invalid([&] { table.column("vx"); },
                       "column vx, row 0 (id 7, line 10) of a.dump, frame 0, step 0 = nan");
  test::expect_invalid([&] { table.positions(); }, "column y, row 1 (id 8, line 11)");
}

const std::string three_frames = "ITEM: TIME\n0.1\n" + frame(10, "x y z", "1 0 0\n", 1) +
                                 "ITEM: TIME\n0.2\n" + frame(20, "x y z", "2 0 0\n2 0 1\n", 2) +
                                 "ITEM: TIME\n0.3\n" + frame(30, "x y z", "3 0 0\n", 1);

TEST_F(Lammps, WalksThroughTheFrames) {
  for (const bool gzip : {false, true}) {
    const auto path = gzip ? folder.gzip("a.gz", three_frames) : folder.file("a", three_frames);
    recon::FrameReader frames(path);
    for (int number = 0; number < 3; ++number) {
      EXPECT_EQ(frames.position(), static_cast<std::size_t>(number));
      const std::optional<ParticleTable> table = frames.next();
      ASSERT_TRUE(table);
      EXPECT_EQ(table->step, 10 * (number + 1));
      EXPECT_EQ(table->column("x")[0], number + 1);
      EXPECT_EQ(table->source, path.filename().string() + ", frame " + std::to_string(number) +
                                   ", step " + std::to_string(10 * (number + 1)));
      constexpr std::array lines{12, 24, 37};
      EXPECT_EQ(table->describe_row(0), "row 0 (line " + std::to_string(lines[number]) + ")");
      EXPECT_TRUE(table->remarks.empty());
    }
    EXPECT_FALSE(frames.next());
    EXPECT_FALSE(frames.next());
    EXPECT_EQ(frames.cut(), "");
    EXPECT_EQ(frames.progress(), 1.0);
  }
}

TEST_F(Lammps, PassesOverFrames) {
  recon::FrameReader frames(folder.file("a", three_frames));
  EXPECT_EQ(frames.skip()->step, 10);
  EXPECT_EQ(frames.next()->step, 20);
  EXPECT_EQ(frames.skip()->time, 0.3);
  EXPECT_FALSE(frames.skip());
}

TEST_F(Lammps, ReadsFromMemory) {
  EXPECT_EQ(recon::list_frames_of(three_frames).size(), 3u);
  for (const int number : {1, -2}) {
    const ParticleTable table = recon::read_particles_of(three_frames, {.frame = number}, "bytes");
    EXPECT_EQ(table.step, 20);
    EXPECT_EQ(table.source, "bytes, frame 1, step 20");
  }
  const std::string zipped = test::bytes_of(folder.gzip("a.gz", three_frames));
  EXPECT_EQ(recon::read_particles_of(zipped).step, 30);
  expect_file_error([] { recon::read_particles_of("ITEM: TIMESTEP\nx\n"); }, 2, "memory:2: 'x'");
}

TEST_F(Lammps, FramesByStepAndTime) {
  const auto path = folder.file("a.dump", three_frames);
  EXPECT_EQ(read_particles(path, {.step = 20}).column("x")[1], 2);
  EXPECT_EQ(read_particles(path, {.time = 0.3}).step, 30);
  EXPECT_EQ(read_particles(path, {.time = 0.1 + 1e-13}).step, 10);
  expect_file_error([&] { read_particles(path, {.step = 25}); }, 0,
                    "step 25 was asked for, the file has 10, 20, 30");
  expect_file_error([&] { read_particles(path, {.time = 0.15}); }, 0, "0.20000000000000001, 0.2");
  test::expect_invalid([&] { read_particles(path, {.frame = 0, .step = 10}); }, "at most one");
  const auto timeless = folder.file("b.dump", frame(10, "x y z", "1 0 0\n", 1));
  expect_file_error([&] { read_particles(timeless, {.time = 1}); }, 0, "the file tells none");
  const auto twice = folder.file("c.dump", three_frames + frame(20, "x y z", "4 0 0\n", 1));
  expect_file_error([&] { read_particles(twice, {.step = 20}); }, 0, "that of frames 1, 3");
  EXPECT_EQ(read_particles(twice, {.step = 30}).column("x")[0], 3);
  const auto text = folder.file("a.csv", "x,y\n1,2\n");
  expect_file_error([&] { read_particles(text, {.step = 0}); }, 0, "the file tells none");
}

// Wherever the file ends within the third frame, the first two are there.
TEST_F(Lammps, TheLastFrameIsCut) {
  const std::size_t third = three_frames.find("ITEM: TIME\n0.3");
  for (std::size_t length = third + 1; length + 6 < three_frames.size(); ++length) {
    for (const bool gzip : {false, true}) {
      std::string bytes = three_frames.substr(0, length);
      const auto path = gzip ? folder.gzip("a.gz", bytes) : folder.file("a.dump", bytes);
      EXPECT_EQ(list_frames(path).size(), 2u) << length;
      const ParticleTable last = read_particles(path);
      EXPECT_EQ(last.step, 20) << length;
      ASSERT_EQ(last.remarks.size(), 1u) << length;
      EXPECT_NE(last.remarks[0].find("frame 2 is cut off"), std::string::npos) << last.remarks[0];
      EXPECT_TRUE(read_particles(path, {.frame = 0}).remarks.empty());
      EXPECT_THROW(read_particles(path, {.frame = 2}), recon::FileError) << length;
      expect_file_error([&] { read_particles(path, {.frame = 3}); }, 0, "the file has 2 frames");
      expect_file_error([&] { read_particles(path, {.step = 30}); }, 0, "frame 2 is cut off");
      recon::FrameReader frames(path);
      EXPECT_TRUE(frames.next() && frames.next());
      EXPECT_EQ(frames.cut(), "");
      EXPECT_FALSE(frames.next());
      EXPECT_NE(frames.cut(), "");
    }
  }
}

TEST_F(Lammps, ACutGzipStreamEndsTheLastFrame) {
  std::string atoms;
  std::mt19937 random(1);
  for (int i = 0; i < 3000; ++i) atoms += std::to_string(random()) + " 0 1\n";
  const std::string whole = test::bytes_of(
      folder.gzip("a.gz", frame(1, "x y z", atoms, 3000) + frame(2, "x y z", atoms + atoms, 6000)));
  const auto path = folder.file("a.gz", whole.substr(0, whole.size() * 3 / 4));
  ASSERT_EQ(list_frames(path).size(), 1u);
  EXPECT_NE(read_particles(path).remarks.at(0).find("cut off"), std::string::npos);
  expect_file_error([&] { read_particles(path, {.frame = 1}); }, 0, "cut off");
}

// A bad line that is followed by others is no cut, wherever it is.
TEST_F(Lammps, ABadFrameIsNoCutOne) {
  expect_error(three_frames.substr(0, three_frames.size() - 6) + "3 0\n", 37, "has 2 cells");
  expect_error(three_frames + "ITEM: TIMESTEP\nx\n", 39, "'x' is no whole number");
}

TEST_F(Lammps, TheLastLineBreakIsMissing) {
  const std::string text = three_frames.substr(0, three_frames.size() - 1);
  for (const int number : {-1, 2}) {
    const ParticleTable table = read(text, number);
    ASSERT_EQ(table.remarks.size(), 1u);
    EXPECT_NE(table.remarks[0].find("no line break"), std::string::npos);
  }
  EXPECT_TRUE(read(text, 0).remarks.empty());
}

TEST_F(Lammps, ChoosesFrames) {
  const std::string text = frame(10, "x y z", "1 0 0\n", 1) +
                           frame(20, "x y z", "2 0 0\n2 0 1\n", 2) +
                           frame(30, "x y z", "3 0 0\n", 1);
  EXPECT_EQ(read(text, 0).step, 10);
  EXPECT_EQ(read(text, 1).step, 20);
  EXPECT_EQ(read(text, -1).step, 30);
  EXPECT_EQ(read(text, -3).step, 10);
  EXPECT_EQ(read(text, 1).source, "a.dump, frame 1, step 20");
  for (const int wrong : {3, -4, 1000000, -1000000})
    expect_file_error([&] { read(text, wrong); }, 0, "the file has 3 frames (0 to 2");
}

TEST_F(Lammps, BrokenLines) {
  expect_error(frame(0, "x y z", "1 2 3\n4 5\n", 2), 11, "has 2 cells, for 3 columns");
  expect_error(frame(0, "x y z", "1 2 3\n4 5 6 7\n", 2), 11, "has 4 cells");
  expect_error(frame(0, "x y z", "1 2 3\n\n", 2), 11, "has 0 cells");
  for (const std::string bad : {"5q", "oops", "0x5", "1e999", "1,5", "-", "+-1", "1e"}) {
    const ParticleTable table = read(frame(0, "x y z", "1 2 3\n4 " + bad + " 6\n", 2));
    EXPECT_EQ(table.column("x"), (std::vector<double>{1, 4}));
    test::expect_invalid([&] { table.positions(); },
                         "row 1 (line 11) of a.dump, frame 0, step 0 = '" + bad + "'");
  }
  EXPECT_EQ(read(frame(0, "x y z", "1 +2 -1e-999\n", 1)).column("z")[0], 0);
}

TEST_F(Lammps, WrongNumberOfAtoms) {
  expect_error(frame(0, "x y z", "1 2 3\n", 2), 10, "the file ends after 1 of the 2 atoms");
  expect_error(frame(0, "x y z", "1 2 3\n4 5 6\n", 1), 11, "ITEM:");
  expect_error(frame(0, "x y z", "1 2 3\n", 3) + frame(1, "x y z", "1 2 3\n", 1), 11,
               "a new section begins after 1 of the 3 atoms of the frame at line 1");
  expect_error(frame(0, "x y z", "", 2000000000), 9, "the file ends after 0 of the 2000000000");
  expect_error(frame(0, "x y z", "", -2), 4, "must not be negative");
}

TEST_F(Lammps, AFrameBeforeADamagedOneCanBeRead) {
  const std::string text = frame(0, "x y z", "1 2 3\n", 1) + frame(5, "x y z", "1 2 3\n", 2);
  EXPECT_EQ(read(text, 0).step, 0);
  expect_file_error([&] { read(text, 1); }, 20,
                    "the file ends after 1 of the 2 atoms of the frame at line 11");
  const std::string middle = text + frame(9, "x y z", "1 2 3\n", 1);
  EXPECT_EQ(read(middle, 0).step, 0);
  expect_error(middle, 21, "a new section begins after 1 of the 2 atoms");
}

TEST_F(Lammps, BrokenHeaders) {
  expect_error("ITEM: TIMESTEP\n1.5\n", 2, "'1.5' is no whole number");
  expect_error("ITEM: TIMESTEP\n", 1, "the file ends where ITEM: TIMESTEP needs a line");
  expect_error("ITEM: TIMESTEP\nITEM: NUMBER OF ATOMS\n", 2, "ITEM: TIMESTEP needs a line");
  expect_error("ITEM: TIMESTEP\n1\n", 2, "ends in the header");
  expect_error("ITEM: TIMESTEP\n1\nfoo\n", 3, "'foo' where a line ITEM: was expected");
  expect_error("ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n1\n", 3, "'NUMBER OF ENTRIES'");
  expect_error("ITEM: TIMESTEP\n1\nITEM: ATOMS x\n", 3, "no ITEM: NUMBER OF ATOMS");
  expect_error("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x\n", 3, "no ITEM: TIMESTEP");
  expect_error("ITEM: TIMESTEP\n1\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x\n", 5,
               "no ITEM: BOX BOUNDS");
  expect_error(frame(0, "", "1 2 3\n", 1), 9, "names no columns");
  expect_error(frame(0, "x", "1\n", 1, " pp pp"), 5, "two boundary letters");
  expect_error(frame(0, "x", "1\n", 1, " pp pf ff"), 5, "'pf' is no boundary");
  expect_error(frame(0, "x", "1\n", 1, " pp qq ff"), 5, "'qq' is no boundary");
  std::string text = frame(0, "x y z", "1 2 3\n", 1);
  text.replace(text.find("-1 3"), 4, "-1");
  expect_error(text, 6, "two numbers");
  text.replace(text.find("\n0 2"), 4, "\n2 0");
  text.replace(text.find("-1\n"), 2, "0 1");
  expect_error(text, 7, "lower < upper along y");
  text.replace(text.find("0 1"), 3, "0 nan");
  expect_error(text, 6, "'nan' is no finite number");
}

TEST_F(Lammps, Chute) {
  const std::filesystem::path path = std::string(RECON_SOURCE_DIR) + "/examples/data/chute.dump.gz";
  const auto frames = list_frames(path);
  ASSERT_EQ(frames.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(frames[i].step, 25000 + 5000 * static_cast<int>(i));
    EXPECT_EQ(frames[i].particles, 3000u);
    EXPECT_EQ(frames[i].columns.size(), 12u);
  }
  const ParticleTable first = read_particles(path, {.frame = 0});
  EXPECT_EQ(first.size(), 3000u);
  const std::vector<std::pair<std::string, double>> row{{"id", 1},
                                                        {"radius", 0.5},
                                                        {"mass", 0.523598776},
                                                        {"x", -1.63520144},
                                                        {"y", 1.77387327},
                                                        {"z", 0.498408458},
                                                        {"vx", 0.0131622062},
                                                        {"vy", 0.0239875346},
                                                        {"vz", -0.00866529065},
                                                        {"fx", 0.271347989},
                                                        {"fy", 0.293132156},
                                                        {"fz", 0.106359234}};
  for (const auto& [name, value] : row) EXPECT_EQ(first.column(name)[0], value) << name;
  EXPECT_EQ(first.dimension(), 3);
  EXPECT_EQ(first.domain().periodic, (std::array<bool, 3>{true, true, false}));
  EXPECT_EQ(first.box().lower, (std::array<double, 3>{-10, -10, -0.5}));
  EXPECT_EQ(first.box().upper, (std::array<double, 3>{10, 10, 16}));
  const ParticleTable last = read_particles(path);
  EXPECT_EQ(last.step, 50000);
  EXPECT_EQ(last.column("x")[0], -8.19476307);
  EXPECT_EQ(last.source, "chute.dump.gz, frame 5, step 50000");
}

}  // namespace
