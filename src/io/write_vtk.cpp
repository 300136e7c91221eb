// VTK XML files with inline binary data (kitware.github.io/vtk-examples, "VTK XML file formats"):
//
//   <DataArray ... format="binary">[base64 of the length in bytes as UInt64, and of the numbers]
//
// Not appended, raw or in base64: since the security update of 2024 to expat (CVE-2023-52425),
// ParaView 5.11 of Debian 12 fails on such files, also on those that it has written itself, as
// other VTK of that time does that parses with the system's expat.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "escaped.hpp"
#include "number_text.hpp"
#include "recon/fields/utf8.hpp"
#include "recon/io/atomic_file.hpp"
#include "recon/io/write.hpp"

namespace recon {

namespace {

template <class Number>
void append_little_endian(std::string& bytes, Number number) {
  char raw[sizeof number];
  std::memcpy(raw, &number, sizeof number);
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw, raw + sizeof raw);
  bytes.append(raw, sizeof raw);
}

const char* type_name(NumberType type) {
  switch (type) {
    case NumberType::float32:
      return "Float32";
    case NumberType::int32:
      return "Int32";
    default:
      return "Float64";
  }
}

std::size_t type_size(NumberType type) {
  return type == NumberType::float64 ? 8 : 4;
}

constexpr std::string_view base64_letters =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

// The two letters of each twelve bits.
constexpr auto base64_pairs = [] {
  std::array<std::array<char, 2>, 4096> pairs{};
  for (std::size_t i = 0; i < pairs.size(); ++i)
    pairs[i] = {base64_letters[i >> 6], base64_letters[i & 63]};
  return pairs;
}();

// Bytes as base64, in pieces.
class Base64 {
 public:
  explicit Base64(AtomicFile& file) : file_(&file) {}

  // All but the last one or two bytes, which wait for more.
  void add(std::string& bytes) {
    const std::size_t triples = bytes.size() / 3;
    text_.resize(4 * triples);
    for (std::size_t t = 0; t < triples; ++t) {
      const auto* const from = reinterpret_cast<const unsigned char*>(bytes.data()) + 3 * t;
      const unsigned first = from[0] << 4 | from[1] >> 4, second = (from[1] & 15u) << 8 | from[2];
      std::memcpy(text_.data() + 4 * t, base64_pairs[first].data(), 2);
      std::memcpy(text_.data() + 4 * t + 2, base64_pairs[second].data(), 2);
    }
    file_->write(text_);
    bytes.erase(0, 3 * triples);
  }
  void finish(std::string& bytes) {
    add(bytes);
    if (bytes.empty()) return;
    const auto first = static_cast<unsigned char>(bytes[0]);
    const auto second = bytes.size() > 1 ? static_cast<unsigned char>(bytes[1]) : 0u;
    text_ = {base64_letters[first >> 2], base64_letters[(first & 3u) << 4 | second >> 4],
             bytes.size() > 1 ? base64_letters[(second & 15u) << 2] : '=', '='};
    file_->write(text_);
  }

 private:
  AtomicFile* file_;
  std::string text_;
};

class VtkFile {
 public:
  VtkFile(const std::filesystem::path& path, const std::string& kind) : file_(path), kind_(kind) {
    xml("<?xml version=\"1.0\"?>\n<VTKFile type=\"" + kind +
        "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n");
  }

  void xml(const std::string& text) { file_.write(text); }

  // An array of `count` numbers of `size` bytes, which append(bytes, i) appends to the bytes.
  template <class Append>
  void array(const std::string& attributes, const char* type, std::size_t count, std::size_t size,
             Append append) {
    xml("<DataArray type=\"" + std::string(type) + "\" " + attributes + " format=\"binary\">\n");
    Base64 out(file_);
    std::string bytes;
    append_little_endian(bytes, static_cast<std::uint64_t>(count * size));
    for (std::size_t i = 0; i < count; ++i) {
      append(bytes, i);
      if (bytes.size() >= (1 << 14)) out.add(bytes);
    }
    out.finish(bytes);
    xml("\n</DataArray>\n");
  }

  void commit() {
    xml("</" + kind_ + ">\n</VTKFile>\n");
    file_.commit();
  }

 private:
  AtomicFile file_;
  std::string kind_;
};

void describe_time(VtkFile& file, const FieldSet& fields) {
  if (!fields.step && !fields.time) return;
  file.xml("<FieldData>\n");
  if (fields.step)
    file.array("Name=\"step\" NumberOfTuples=\"1\"", "Int64", 1, 8,
               [step = *fields.step](std::string& bytes, std::size_t) {
                 append_little_endian(bytes, step);
               });
  if (fields.time)
    file.array("Name=\"TimeValue\" NumberOfTuples=\"1\"", "Float64", 1, 8,
               [time = *fields.time](std::string& bytes, std::size_t) {
                 append_little_endian(bytes, time);
               });
  file.xml("</FieldData>\n");
}

void append_bytes_of(std::string& bytes, double value, NumberType type) {
  switch (type) {
    case NumberType::int32:
      return append_little_endian(bytes, static_cast<std::int32_t>(value));
    case NumberType::float32:
      return append_little_endian(bytes, static_cast<float>(value));
    default:
      return append_little_endian(bytes, value);
  }
}

// Name and components, as they are written.
std::string attributes_of(const NamedField& field, const ComponentPlaces& places) {
  const int written = places.places > 0 ? places.places : field.components;
  std::string attributes = "Name=\"" + detail::escaped(field.name) + "\" NumberOfComponents=\"" +
                           std::to_string(written) + "\"";
  for (int place = 0; place < places.places; ++place)
    attributes += " ComponentName" + std::to_string(place) + "=\"" +
                  name_of_place(place, places.places) + "\"";
  return attributes;
}

// Vectors and tensors have the components of 3-D, as filters for arrows, warps and stream lines
// want them; those that the data do not have are 0.
void describe_fields(VtkFile& file, const FieldSet& fields, int dimension) {
  file.xml("<PointData>\n");
  for (const NamedField& field : fields) {
    const ComponentPlaces places = component_places(field, dimension);
    const auto count =
        static_cast<std::size_t>(places.places > 0 ? places.places : field.components);
    const auto components = static_cast<std::size_t>(field.components);
    file.array(attributes_of(field, places), type_name(field.type), field.size() * count,
               type_size(field.type),
               [&field, places, count, components](std::string& bytes, std::size_t i) {
                 if (places.places == 0) return append_bytes_of(bytes, field.values[i], field.type);
                 const int from = places.from[i % count];
                 append_bytes_of(bytes,
                                 from < 0 ? 0.0 : field.values[i / count * components + from],
                                 field.type);
               });
  }
  file.xml("</PointData>\n");
}

// WholeExtent, Origin and Spacing of a grid; Extent of a piece of it.
std::string attributes_of(const StructuredGrid<double>& grid) {
  std::string extent, origin, spacing;
  for (int d = 0; d < max_dimension; ++d) {
    const bool used = d < grid.dimension;
    for (std::string* list : {&extent, &origin, &spacing})
      if (d > 0) *list += ' ';
    extent.append("0 ").append(std::to_string(used ? grid.counts[d] - 1 : 0));
    detail::append_number(origin, used ? grid.origin[d] : 0.0);
    detail::append_number(spacing, used ? grid.spacing[d] : 1.0);
  }
  return "WholeExtent=\"" + extent + "\" Origin=\"" + origin + "\" Spacing=\"" + spacing + "\"";
}
std::string extent_of(const GridPiece& piece) {
  std::string extent;
  for (int d = 0; d < max_dimension; ++d)
    extent += (d > 0 ? " " : "") + std::to_string(piece.first[d]) + " " +
              std::to_string(piece.first[d] + piece.counts[d] - 1);
  return "Extent=\"" + extent + "\"";
}

// What the fields of pieces are called.
void name_fields(VtkFile& file, const FieldSet& fields, int dimension) {
  file.xml("<PPointData>\n");
  for (const NamedField& field : fields)
    file.xml("<PDataArray type=\"" + std::string(type_name(field.type)) + "\" " +
             attributes_of(field, component_places(field, dimension)) + "/>\n");
  file.xml("</PPointData>\n");
}
std::string source_of(const std::filesystem::path& file) {
  const std::string name = file.generic_string();
  detail::require(is_utf8(name), "name of the file of a piece", to_utf8(name), "must be UTF-8");
  return "Source=\"" + detail::escaped(name) + "\"";
}

void require_piece(const StructuredGrid<double>& grid, const GridPiece& piece) {
  for (int d = 0; d < max_dimension; ++d) {
    const std::size_t there = d < grid.dimension ? grid.counts[d] : 1;
    if (piece.counts[d] >= 1 && piece.first[d] < there && piece.counts[d] <= there - piece.first[d])
      continue;
    detail::throw_invalid(
        "nodes of a piece along axis " + std::to_string(d),
        std::to_string(piece.counts[d]) + " from " + std::to_string(piece.first[d]),
        "must be at least one, of the " + std::to_string(there) + " of the grid");
  }
}

}  // namespace

void write_vti(const std::filesystem::path& path, const StructuredGrid<double>& grid,
               const FieldSet& fields) {
  GridPiece all;
  for (int d = 0; d < grid.dimension; ++d) all.counts[d] = grid.counts[d];
  write_vti_piece(path, grid, all, fields);
}

void write_vti_piece(const std::filesystem::path& path, const StructuredGrid<double>& grid,
                     const GridPiece& piece, const FieldSet& fields) {
  grid.validate();
  require_piece(grid, piece);
  fields.require_size(piece.size());
  VtkFile file(path, "ImageData");
  file.xml("<ImageData " + attributes_of(grid) + ">\n");
  describe_time(file, fields);
  file.xml("<Piece " + extent_of(piece) + ">\n");
  describe_fields(file, fields, grid.dimension);
  file.xml("</Piece>\n");
  file.commit();
}

void write_pvti(const std::filesystem::path& path, const StructuredGrid<double>& grid,
                const std::vector<GridPieceFile>& pieces, const FieldSet& fields) {
  grid.validate();
  for (const GridPieceFile& one : pieces) require_piece(grid, one.piece);
  VtkFile file(path, "PImageData");
  file.xml("<PImageData " + attributes_of(grid) + " GhostLevel=\"0\">\n");
  describe_time(file, fields);
  name_fields(file, fields, grid.dimension);
  for (const GridPieceFile& one : pieces)
    file.xml("<Piece " + extent_of(one.piece) + " " + source_of(one.file) + "/>\n");
  file.commit();
}

void write_pvtp(const std::filesystem::path& path, int dimension,
                const std::vector<std::filesystem::path>& pieces, const FieldSet& fields) {
  VtkFile file(path, "PPolyData");
  file.xml("<PPolyData GhostLevel=\"0\">\n");
  describe_time(file, fields);
  name_fields(file, fields, dimension);
  file.xml(
      "<PPoints>\n<PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n"
      "</PPoints>\n");
  for (const std::filesystem::path& piece : pieces) file.xml("<Piece " + source_of(piece) + "/>\n");
  file.commit();
}

void write_vtp(const std::filesystem::path& path, const PointsView<double>& points,
               const FieldSet& fields) {
  fields.require_size(points.size());
  bounding_box(points);  // throws for a coordinate that is not finite
  const std::string count = std::to_string(points.size());
  VtkFile file(path, "PolyData");
  file.xml("<PolyData>\n");
  describe_time(file, fields);
  file.xml("<Piece NumberOfPoints=\"" + count + "\" NumberOfVerts=\"" + count +
           "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n");
  describe_fields(file, fields, points.dimension());
  file.xml("<Points>\n");
  file.array("Name=\"Points\" NumberOfComponents=\"3\"", "Float64", 3 * points.size(), 8,
             [points](std::string& bytes, std::size_t i) {
               const int axis = static_cast<int>(i % 3);
               append_little_endian(bytes, axis < points.dimension() ? points(i / 3, axis) : 0.0);
             });
  file.xml("</Points>\n<Verts>\n");
  const auto number = [](std::string& bytes, std::size_t i) {
    append_little_endian(bytes, static_cast<std::int64_t>(i));
  };
  file.array("Name=\"connectivity\"", "Int64", points.size(), 8, number);
  file.array("Name=\"offsets\"", "Int64", points.size(), 8,
             [number](std::string& bytes, std::size_t i) { number(bytes, i + 1); });
  file.xml("</Verts>\n</Piece>\n");
  file.commit();
}

}  // namespace recon
