// VTK files that are written by hand. tests/io/other_formats.py has those that VTK itself writes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recon/io/read.hpp"
#include "recon/io/write.hpp"
#include "recon/points/make_view.hpp"
#include "temporary.hpp"

namespace {

using recon::ParticleTable;
using recon::read_particles_of;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string legacy =
    "# vtk DataFile Version 3.0\na title\nASCII\nDATASET UNSTRUCTURED_GRID\n"
    "FIELD FieldData 2\nTIME 1 1 double\n0.5\nCYCLE 1 1 int\n40\n"
    "POINTS 3 float\n0 0 1  1 0 1\n0 1 1\nCELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n"
    "CELL_DATA 1\nSCALARS area float\nLOOKUP_TABLE default\n0.5\n"
    "POINT_DATA 3\nSCALARS a%20b int 2\nLOOKUP_TABLE default\n1 2 3 4 5 6\n"
    "METADATA\nINFORMATION 0\n\nVECTORS velocity double\n1 2 3\n4 5 6\n7 8 9\n"
    "FIELD more 2\nx 1 3 float\n7 8 9\nlabel 1 3 string\none\ntwo\nthree\n";

TEST(ReadVtk, LegacyText) {
  const ParticleTable table = read_particles_of(legacy);
  EXPECT_THAT(table.names(),
              ElementsAre("x", "y", "z", "a b_x", "a b_y", "vx", "vy", "vz", "data_x"));
  EXPECT_THAT(table.column("a b_y"), ElementsAre(2, 4, 6));
  EXPECT_THAT(table.column("vz"), ElementsAre(3, 6, 9));
  EXPECT_THAT(table.column("data_x"), ElementsAre(7, 8, 9));
  EXPECT_EQ(table.dimension(), 2);
  EXPECT_EQ(table.time, 0.5);
  EXPECT_EQ(table.step, 40);
  EXPECT_THAT(table.remarks, testing::Contains(HasSubstr("label holds texts")));
}

TEST(ReadVtk, LegacyGridAndBinary) {
  const ParticleTable grid = read_particles_of(
      "# vtk DataFile Version 2.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 1\n"
      "ORIGIN 1 2 3\nSPACING 0.5 1 1\nPOINT_DATA 4\nSCALARS p float 1\nLOOKUP_TABLE default\n1 2 3 "
      "4\n");
  EXPECT_THAT(grid.column("x"), ElementsAre(1, 1.5, 1, 1.5));
  EXPECT_THAT(grid.column("y"), ElementsAre(2, 2, 3, 3));
  using namespace std::string_literals;
  const ParticleTable binary = read_particles_of(
      "# vtk DataFile Version 2.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 1 short\n"
      "\x00\x01\xff\xff\x01\x00\nPOINT_DATA 1\nSCALARS s unsigned_char\nLOOKUP_TABLE default\n\xfe\n"s);
  EXPECT_THAT(binary.column("x"), ElementsAre(1));
  EXPECT_THAT(binary.column("y"), ElementsAre(-1));
  EXPECT_THAT(binary.column("z"), ElementsAre(256));
  EXPECT_THAT(binary.column("s"), ElementsAre(254));
}

TEST(ReadVtk, LegacyWhatIsWrongIsNamed) {
  const auto expect = [](const std::string& text, std::size_t line, const std::string& part) {
    test::expect_file_error([&] { read_particles_of(text); }, line, part);
  };
  const std::string head = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n";
  expect("# vtk DataFile Version 3.0\nt\nOCTAL\n", 3, "ASCII or BINARY");
  expect("# vtk DataFile Version 3.0\nt\nASCII\nDATASET RECTILINEAR_GRID\n", 4, "is not read");
  expect(head, 4, "no POINTS");
  expect(head + "POINTS -1 float\n", 5, "not negative");
  expect(head + "POINTS 99999999999999999 float\n", 5, "promises more points");
  expect(head + "POINTS 1 quad\n0 0 0\n", 5, "'quad' is none");
  expect(head + "POINTS 1 float\n0 0\n", 6, "the file ends");
  expect(head + "POINTS 2 float\n0 0 0\n0 zero 0\n", 7, "'zero' is no number: POINTS");
  const std::string points = head + "POINTS 1 float\n0 0 0\n";
  expect(points + "POINT_DATA 2\nSCALARS a float\nLOOKUP_TABLE default\n1 2\n", 7,
         "for 2 points, there are 1");
  expect(points + "POINT_DATA 1\nSCALARS a float 0\nLOOKUP_TABLE default\n", 9, "at least one");
  expect(points + "POINT_DATA 1\nSCALARS a float\nLOOKUP_TABLE default\n", 9, "a needs 1 numbers");
  expect(points + "POINT_DATA 1\nFIELD f 1\na 1 2 float\n1 2\n", 10, "a has 2 tuples for 1");
  expect(points + "SURPRISE 1\n", 7, "no section");
  expect(head + "POINT_DATA 1\n", 5, "before POINTS");
  expect(
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n"
      "DIMENSIONS 9999999 9999999 9999999\nPOINT_DATA 1\n",
      6, "promises more points");
}

const std::string xml =
    "<?xml version=\"1.0\"?>\n<!-- <Piece> -->\n<VTKFile type=\"UnstructuredGrid\" byte_order="
    "\"LittleEndian\" header_type=\"UInt32\">\n<UnstructuredGrid>\n<FieldData>\n<DataArray "
    "type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">2.5</DataArray>\n"
    "</FieldData>\n"
    "<Piece NumberOfPoints=\"2\" NumberOfCells=\"0\">\n<PointData>\n<DataArray type=\"Int32\" "
    "Name=\"a &amp; b\" format=\"ascii\">7 8</DataArray>\n</PointData>\n<Points><DataArray "
    "type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">\n0 0 0 1 0 "
    "0\n</DataArray></Points>"
    "\n<Cells></Cells></Piece>\n"
    // base64 of the length 8 and two Int32, 9 and 10, in one stream
    "<Piece NumberOfPoints=\"2\"><PointData><DataArray type=\"Int32\" Name=\"a &amp; b\" "
    "format=\"binary\">CAAAAAkAAAAKAAAA</DataArray></PointData><Points><DataArray type=\"Float32\" "
    "NumberOfComponents=\"3\" format=\"ascii\">2 0 0 3 0 0</DataArray></Points></Piece>\n"
    "</UnstructuredGrid>\n</VTKFile>\n";

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ReadVtk, XmlInPieces) {
  const ParticleTable table = read_particles_of(xml);
  EXPECT_THAT(table.column("x"), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(table.column("a & b"), ElementsAre(7, 8, 9, 10));
  EXPECT_EQ(table.time, 2.5);
}

// Points in several files, of which one has none.
TEST(ReadVtk, PointsInSeveralFiles) {
  const test::TemporaryFolder folder;
  const auto write = [&](const char* name, std::vector<double> x, const char* field = "mass",
                         std::int64_t step = 7, std::optional<double> time = {}) {
    recon::FieldSet fields;
    fields.step = step;
    fields.time = time;
    fields.add(field, 1, x);
    const std::vector<double> y(x.size(), 2);
    std::array<std::vector<double>, 3> axes{x, y, {}};
    recon::write_vtp(folder.path() / name, recon::points_of_axes(axes, 2), fields);
    return fields;
  };
  write("a_0.vtp", {1, 2});
  write("a_1.vtp", {});
  const recon::FieldSet fields = write("a_2.vtp", {5});
  const auto all = folder.path() / "a.pvtp";
  recon::write_pvtp(all, 2, {"a_0.vtp", "a_1.vtp", "a_2.vtp"}, fields);
  const ParticleTable table = recon::read_particles(all);
  EXPECT_THAT(table.column("x"), ElementsAre(1, 2, 5));
  EXPECT_THAT(table.column("y"), ElementsAre(2, 2, 2));
  EXPECT_THAT(table.column("mass"), ElementsAre(1, 2, 5));
  EXPECT_EQ(table.step, 7);
  const auto expect = [&](const std::string& part) {
    try {
      recon::read_particles(all);
      ADD_FAILURE() << part;
    } catch (const recon::FileError& error) {
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
  };
  write("a_1.vtp", {4}, "weight");
  expect("the piece has no array 'mass' of 1 components, which PPointData names");
  write("a_1.vtp", {4}, "mass", 8);
  expect("the piece is of the step 8, and what was read before it of 7");
  write("a_1.vtp", {4}, "mass", 7, 0.5);
  write("a_2.vtp", {4}, "mass", 7, 0.25);
  expect("the piece is of the time 0.25, and what was read before it of 0.5");
  recon::write_pvtp(all, 2, {"a_0.vtp", "a_1.vtp", "./a_0.vtp"}, fields);
  expect("names the piece './a_0.vtp' again");
  std::filesystem::create_symlink("a_0.vtp", folder.path() / "link.vtp");
  recon::write_pvtp(all, 2, {"a_0.vtp", "link.vtp"}, fields);
  expect("names the piece 'link.vtp' again");
  recon::write_pvtp(all, 2, {"a_0.vtp", "no.vtp"}, fields);
  std::ofstream(folder.path() / "no.vtp") << "\x89HDF\r\n";
  expect("names a piece that is no XML file of VTK");
  recon::FieldSet more = fields;
  more.add("volume", 1, {1});
  recon::write_pvtp(all, 2, {"a_0.vtp", "a_1.vtp"}, more);
  expect("the piece has no array 'volume' of 1 components, which PPointData names");
  recon::write_pvtp(all, 2, {"a_0.vtp", "nowhere.vtp"}, fields);
  expect("nowhere.vtp");
  recon::write_pvtp(all, 2, {"a_0.vtp", "a.pvtp"}, fields);
  expect("name one of these");  // itself
  recon::write_pvtp(all, 2, {""}, fields);
  expect("name of a file as its Source");
  recon::write_pvtp(all, 2, {}, fields);
  expect("no Piece");
  test::expect_file_error([&] { read_particles_of(test::bytes_of(all)); }, 2, "name one of these");
}

TEST(ReadVtk, XmlWhatIsWrongIsNamed) {
  const auto expect = [](const std::string& from, const std::string& to, std::size_t line,
                         const std::string& part) {
    test::expect_file_error([&] { read_particles_of(changed(xml, from, to)); }, line, part);
  };
  expect("type=\"UnstructuredGrid\"", "type=\"PUnstructuredGrid\"", 3, "in other files");
  expect("type=\"UnstructuredGrid\"", "type=\"Collection\"", 3, "collection (.pvd)");
  expect("header_type", "compressor=\"vtkLZ4DataCompressor\" header_type", 3, "vtkLZ4");
  expect("7 8<", "7<", 10, "'a & b' has 1 numbers, its points need 2");
  expect("7 8<", "7 eight<", 10, "'eight' is no number: the array 'a & b'");
  expect("Name=\"a &amp; b\"", "Name=\"a &copy; b\"", 10, "entity");
  expect("type=\"Int32\"", "type=\"Int33\"", 10, "unknown type 'Int33'");
  expect("UInt32", "UInt33", 3, "header_type 'UInt33'");
  expect("LittleEndian", "MiddleEndian", 3, "byte_order");
  expect("format=\"binary\"", "format=\"hex\"", 16, "unknown format 'hex'");
  expect("CAAAAAkAAAAKAAAA", "CAAAAAkA", 16, "ends too early");
  expect("CAAAAAkAAAAKAAAA", "CAAAAA*AAAAKAAAA", 16, "ends too early");
  expect("CAAAAAkAAAAKAAAA", "DAAAAAkAAAAKAAAA", 16, "has 12 bytes, its points need 8");
  expect("format=\"binary\"", "format=\"appended\" offset=\"9\"", 16, "behind the end");
  expect("NumberOfPoints=\"2\"", "NumberOfPoints=\"-2\"", 8, "not negative");
  expect("NumberOfPoints=\"2\"", "NumberOfPoints=\"99999999999\"", 8, "2^32 - 2");
  expect("\"Float32\" NumberOfComponents=\"3\"", "\"Float32\" NumberOfComponents=\"2\"", 12,
         "Points need 3");
  expect("</Piece>\n<Piece", "</Piece>\n<Piece x", 16, "has no value");
  expect("</UnstructuredGrid>", "</Grid>", 17, "closes what was not opened");
  expect("</UnstructuredGrid>\n</VTKFile>\n", "", 17, "ends within <UnstructuredGrid>");
  expect("<!-- <Piece> -->", "<!DOCTYPE x>", 2, "document type");
}

}  // namespace
