// What holds for all formats: gzip, missing and foreign files, and files damaged at random.
#include <gtest/gtest.h>

#include <random>

#include "recon/core/error.hpp"
#include "recon/io/read.hpp"
#include "temporary.hpp"

namespace {

using recon::read_particles;
using test::bytes_of;
using test::expect_file_error;
using test::TemporaryFolder;

const std::string small_dump =
    "ITEM: UNITS\nlj\nITEM: TIME\n0.5\nITEM: TIMESTEP\n10\nITEM: NUMBER OF ATOMS\n2\n"
    "ITEM: BOX BOUNDS pp pp ff\n0 1\n0 1\n0 2.5\nITEM: ATOMS id element xs ys zs vx\n"
    "1 Fe 0.5 0.25 0.125 1e-3\n2 O 0.75 0.5 1 -2.5E+2\n"
    "ITEM: TIME\n0.75\nITEM: TIMESTEP\n20\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp ff\n"
    "0 1\n0 1\n0 2.5\nITEM: ATOMS id element xs ys zs vx\n1 Fe 0.5 0.25 0.125 nan\n";
const std::string tilted_dump =
    "ITEM: TIMESTEP\n10\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS xy xz yz pp pp ff\n"
    "0 1 0.5\n0 1 -1\n0 2.5 0\nITEM: ATOMS id xs ys zs vx\n1 0.5 0.25 0.125 NA\n"
    "ITEM: TIMESTEP\n20\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS abc origin pp pp ff\n"
    "1 0 0 5\n.5 1 0 6\n0 0 1 7\nITEM: ATOMS id xs ys zs vx\n1 0.5 0.25 0.125 1\n";
const std::string small_csv =
    "% made by hand\n\"x\",y,\"p \"\"q\"\" [Pa]\",kind\n1,2,3.5,a\n\n# b\n2,,1e-3,b\n\"4\",5,6,c\n";

const std::string small_xyz =
    "2\nLattice=\"4 0 0 0.5 5 0 0 0 6\" pbc=\"T F T\" Properties=species:S:1:pos:R:3:fixed:L:1 "
    "Time=0.5\nFe -1 2 3 T\nO 1 2.5 4 F\n1\nplain\nH 0 0 0\n";
const std::string small_vtk =
    "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n0 0 1 1 0 1\n"
    "VERTICES 1 3\n2 0 1\nPOINT_DATA 2\nSCALARS p int 2\nLOOKUP_TABLE default\n1 2 3 4\n"
    "FIELD f 1\nq 1 2 bit\n0 1\n";
const std::string small_vtu =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\">\n"
    "<UnstructuredGrid><Piece NumberOfPoints=\"2\"><PointData><DataArray type=\"Int32\" Name=\"a\" "
    "format=\"binary\">CAAAAAkAAAAKAAAA</DataArray></PointData><Points><DataArray type=\"Float32\" "
    "NumberOfComponents=\"3\" format=\"ascii\">2 0 0 3 0 0</DataArray></Points></Piece>"
    "</UnstructuredGrid></VTKFile>\n";

// Rows with their number as `id`, in each format.
std::vector<std::pair<std::string, std::string>> numbered_files(int rows) {
  std::string lines, xyz, points, ids;
  for (int i = 0; i < rows; ++i) {
    const std::string id = std::to_string(i), x = std::to_string(0.5 * i);
    lines += id + " " + x + " 0.25 1\n";
    xyz += "Fe " + x + " 0.25 1 " + id + "\n";
    points += x + " 0.25 1\n";
    ids += id + "\n";
  }
  const std::string n = std::to_string(rows);
  return {{"a.dump", "ITEM: TIMESTEP\n1\nITEM: NUMBER OF ATOMS\n" + n +
                         "\nITEM: BOX BOUNDS pp pp pp\n0 900\n0 1\n0 2\nITEM: ATOMS id x y z\n" +
                         lines},
          {"a.txt", "id x y z\n" + lines},
          {"a.xyz", n + "\nProperties=species:S:1:pos:R:3:id:I:1\n" + xyz},
          {"a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS " + n +
                        " double\n" + points + "POINT_DATA " + n +
                        "\nSCALARS id double\nLOOKUP_TABLE default\n" + ids}};
}

TEST(ReadParts, TogetherAreAllRowsOnce) {
  const TemporaryFolder folder;
  for (const int rows : {1, 256, 700, 1536})
    for (const auto& [name, text] : numbered_files(rows)) {
      const auto path = folder.file(name, text);
      for (const int parts : {1, 2, 3}) {
        std::vector<int> seen(static_cast<std::size_t>(rows), 0);
        for (int part = 0; part < parts; ++part) {
          const auto table = read_particles(path, {.part = part, .parts = parts});
          ASSERT_TRUE(table.has("id")) << name;
          EXPECT_LE(table.size(), static_cast<std::size_t>(rows / parts + 256)) << name;
          const auto id = table.raw_column("id"), x = table.raw_column("x");
          for (std::size_t i = 0; i < table.size(); ++i) {
            EXPECT_EQ(x[i], 0.5 * id[i]);
            ++seen[static_cast<std::size_t>(id[i])];
          }
        }
        EXPECT_EQ(seen, std::vector<int>(static_cast<std::size_t>(rows), 1)) << name << parts;
      }
      EXPECT_EQ(recon::list_frames(path, {.part = 0, .parts = 2}).at(0).particles,
                static_cast<std::size_t>(rows));
    }
}

TEST(ReadParts, LinesAreThoseOfTheFile) {
  const TemporaryFolder folder;
  std::string text = "x,v\n";
  for (int i = 0; i < 600; ++i) text += "1," + std::string(i == 400 ? "oh" : "2") + "\n";
  const auto path = folder.file("a.csv", text);
  EXPECT_NO_THROW(read_particles(path, {.part = 0, .parts = 2}).column("v"));
  const auto other = read_particles(path, {.part = 1, .parts = 2});
  EXPECT_EQ(other.describe_text("v"), "'oh' on line 402");
}

TEST(ReadParts, OfNoParts) {
  const TemporaryFolder folder;
  const auto path = folder.file("a.csv", "x\n1\n");
  EXPECT_THROW(read_particles(path, {.part = 0, .parts = 0}), recon::InvalidArgument);
  EXPECT_THROW(read_particles(path, {.part = 2, .parts = 2}), recon::InvalidArgument);
  EXPECT_THROW(read_particles(path, {.part = -1, .parts = 2}), recon::InvalidArgument);
}

TEST(Read, GzipIsUndone) {
  const TemporaryFolder folder;
  const auto path = folder.gzip("a.txt", "x,y\n1,2\n");  // by content, not by name
  EXPECT_EQ(read_particles(path).column("y")[0], 2);
}

TEST(Read, CutAndDamagedGzip) {
  const TemporaryFolder folder;
  std::string text = "x,y\n";
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) text += std::to_string(random()) + "," + std::to_string(i) + "\n";
  const std::string whole = bytes_of(folder.gzip("a.gz", text));
  for (const std::size_t length : {whole.size() - 1, whole.size() / 2, std::size_t{30}})
    expect_file_error([&] { read_particles(folder.file("cut.gz", whole.substr(0, length))); }, 0,
                      "cut off");
  std::string damaged = whole;
  damaged[damaged.size() - 6] = static_cast<char>(damaged[damaged.size() - 6] ^ 1);  // checksum
  expect_file_error([&] { read_particles(folder.file("bad.gz", damaged)); }, 0, "damaged");
}

TEST(Read, GzipInSeveralMembers) {
  const TemporaryFolder folder;
  const std::string one = bytes_of(folder.gzip("a", "x,y\n1,2\n")),
                    two = bytes_of(folder.gzip("b", "3,4\n"));
  EXPECT_EQ(read_particles(folder.file("c", one + two)).column("y"), (std::vector<double>{2, 4}));
  EXPECT_EQ(read_particles(folder.file("c", one + std::string(1000, '\0'))).size(), 1u);
  for (const std::string& behind : {std::string("3,4\n"), std::string("3"), std::string("\x1f"),
                                    std::string(5, '\0') + "x", std::string(300000, '\0') + two})
    expect_file_error([&] { read_particles(folder.file("c", one + behind)); }, 0,
                      "followed by other bytes");
  expect_file_error([&] { read_particles(folder.file("c", one + two.substr(0, 7))); }, 0,
                    "cut off");
}

TEST(Read, NumbersBeyondDouble) {
  const TemporaryFolder folder;
  const auto value = [&](const std::string& text) {
    return read_particles(folder.file("a", "x,y\n1," + text + "\n")).column("y")[0];
  };
  const std::string zeros(400, '0');
  EXPECT_EQ(value("1" + zeros + "e-400"), 1);
  EXPECT_EQ(value("0." + zeros + "1e+401"), 1);
  EXPECT_EQ(value("1" + zeros + "e-800"), 0);
  EXPECT_EQ(value("-0." + zeros + "1"), 0);
  EXPECT_EQ(value("0." + zeros + "1e-99999999999999999999"), 0);
  EXPECT_EQ(value("0e999999999999"), 0);
  for (const std::string& text :
       {"1" + zeros + "e-10", "-1" + zeros, "0." + zeros + "1e+800", "1" + zeros + ".5",
        std::string("1e99999999999999999999"), "1" + zeros + "e-0"})
    EXPECT_ANY_THROW(value(text)) << text;
}

TEST(Read, MissingFiles) {
  const TemporaryFolder folder;
  folder.file("chute.dump", "x\n1\n");
  expect_file_error([&] { read_particles(folder / "chut.dump"); }, 0, "did you mean 'chute.dump'?");
  expect_file_error([&] { read_particles(folder / "zzzzzz"); }, 0, "no such file");
  expect_file_error([&] { read_particles(folder.path() / "none" / "a"); }, 0,
                    "there is no directory");
  expect_file_error([&] { read_particles(folder.path()); }, 0, "is a directory");
  expect_file_error([&] { read_particles("/dev/null"); }, 0, "no ordinary file");
}

TEST(Read, ForeignFiles) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& text, std::size_t line, const std::string& part) {
    expect_file_error([&] { read_particles(folder.file("a", text)); }, line, part);
  };
  expect("", 0, "is empty");
  expect("<?xml version=\"1.0\"?>\n<html>", 0, "no VTK file");
  expect("BZh91AY", 0, "bzip2");
  expect("\x28\xb5\x2f\xfd rest", 0, "zstd");
  expect("LAMMPS data file via write_data\n\n3000 atoms\n", 1, "write_dump");
  expect(std::string("x,y\n1,\0,2\n", 11), 2, "NUL byte");
  expect(std::string(100, '\0'), 1, "binary");
}

// Reading damaged data ends in one of two ways: a table, or an exception that says what is wrong.
void read_all(const std::string& bytes) {
  try {
    for (std::size_t f = 0; f < recon::list_frames_of(bytes).size(); ++f) {
      auto table = recon::read_particles_of(bytes, {.frame = static_cast<int>(f)});
      for (const std::string& name : table.names())
        EXPECT_EQ(table.raw_column(name).size(), table.size());
      const auto points = table.positions();
      EXPECT_EQ(points.size(), table.size());
      table.domain().validate(points.dimension());
      table.declare_missing("1");
      table.leave_out_missing(table.names());
    }
  } catch (const recon::FileError& error) {
    EXPECT_FALSE(std::string(error.what()).empty());
  } catch (const recon::InvalidArgument& error) {
    EXPECT_FALSE(std::string(error.what()).empty());
  }
}

TEST(Read, SurvivesDamage) {
  std::mt19937 random(7);
  const std::string letters = "0123456789 \n\t\r,;\"#.eE+-ITEM:naf\xff\x01";
  for (const std::string& valid :
       {small_dump, tilted_dump, small_csv, small_xyz, small_vtk, small_vtu}) {
    for (std::size_t length = 0; length <= valid.size(); ++length)
      read_all(valid.substr(0, length));
    for (int round = 0; round < 300; ++round) {
      std::string text = valid;
      for (int change = 0; change <= round % 3; ++change) {
        const std::size_t at = random() % text.size();
        const char letter = letters[random() % letters.size()];
        if (round % 4 == 0)
          text.erase(at, 1 + random() % 5);
        else if (round % 4 == 1)
          text.insert(at, 1, letter);
        else
          text[at] = letter;
      }
      read_all(text);
    }
  }
}

TEST(Read, SurvivesDamagedGzip) {
  const TemporaryFolder folder;
  const std::string valid = bytes_of(folder.gzip("a.gz", small_dump));
  std::mt19937 random(11);
  for (std::size_t length = 0; length < valid.size(); ++length) read_all(valid.substr(0, length));
  for (int round = 0; round < 200; ++round) {
    std::string bytes = valid;
    bytes[random() % bytes.size()] = static_cast<char>(random());
    read_all(bytes);
  }
}

}  // namespace
