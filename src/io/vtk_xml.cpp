// VTK XML files (VTK File Formats, "XML File Formats"): PolyData, UnstructuredGrid, StructuredGrid
// and ImageData in one or more pieces, the first two also in several files (.pvtp, .pvtu); arrays as
// text, in base64, or appended, raw or in base64, plain or compressed by zlib.
//
// A plain array is its length in bytes and then the numbers; a compressed one is the number of
// blocks, their size before compression, that of the last one if it is smaller (else 0), the
// compressed sizes, and then the blocks. These numbers are of the type header_type.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "formats.hpp"
#include "recon/fields/utf8.hpp"
#include "vtk_numbers.hpp"

namespace recon::detail {

namespace {

struct Element {
  std::string name;
  std::map<std::string, std::string, std::less<>> attributes;
  bool closes = false, empty = false;
  std::size_t begin = 0;  // of the tag; what is inside begins behind it

  std::string operator[](std::string_view key) const {
    const auto found = attributes.find(key);
    return found == attributes.end() ? "" : found->second;
  }
};

bool is_blank(char c) {
  return c == ' ' || c == '\n' || c == '\t' || c == '\r';
}

class XmlReader {
 public:
  XmlReader(std::string_view bytes, const std::filesystem::path& path, OpenFile open)
      : bytes_(bytes), path_(&path), open_(std::move(open)) {}

  VtkPoints read() {
    read_tags();
    if (pieces_.empty()) fail(0, "the file has no Piece with points");
    for (const Array& array : field_data_) note(array);
    for (const Piece& piece : pieces_) has_other_files() ? add_file(piece) : add(piece);
    return std::move(out_);
  }

 private:
  struct Array {
    Element tag;
    std::size_t begin = 0, end = 0;  // of the text inside
  };
  struct Piece {
    Element tag;
    std::vector<Array> point_data, points;
  };

  [[noreturn]] void fail(std::size_t at, const std::string& what) const {
    const auto begin = bytes_.begin();
    const auto lines = std::count(begin, begin + static_cast<std::ptrdiff_t>(at), '\n');
    throw FileError(*path_, static_cast<std::size_t>(lines) + 1, what);
  }

  // --- tags --------------------------------------------------------------------------------------
  std::string unescaped(std::string_view text, std::size_t at) const {
    constexpr std::array<std::pair<std::string_view, char>, 5> known{
        {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}}};
    std::string out;
    while (!text.empty()) {
      if (text[0] != '&') {
        out += text[0];
        text.remove_prefix(1);
        continue;
      }
      const auto entity = std::find_if(known.begin(), known.end(), [&](const auto& each) {
        return text.starts_with(each.first);
      });
      if (entity == known.end()) fail(at, "an entity of XML that is not known: " + quote(text));
      out += entity->second;
      text.remove_prefix(entity->first.size());
    }
    return out;
  }

  // The next tag; comments and declarations are passed over.
  bool next_tag(Element& tag) {
    for (;;) {
      at_ = bytes_.find('<', at_);
      if (at_ == std::string_view::npos) return false;
      const std::string_view rest = bytes_.substr(at_);
      const bool comment = rest.starts_with("<!--");
      if (!comment && rest.starts_with("<!")) fail(at_, "a document type is not read");
      if (!comment && !rest.starts_with("<?")) break;
      const std::string_view end = comment ? "-->" : "?>";
      const std::size_t behind = bytes_.find(end, at_);
      if (behind == std::string_view::npos) fail(at_, "the file ends within a comment");
      at_ = behind + end.size();
    }
    tag = {};
    tag.begin = at_++;
    const auto peek = [&] {
      if (at_ >= bytes_.size()) fail(tag.begin, "the file ends within a tag");
      return bytes_[at_];
    };
    const auto skip_blanks = [&] {
      while (is_blank(peek())) ++at_;
    };
    if (peek() == '/') {
      tag.closes = true;
      ++at_;
    }
    while (!is_blank(peek()) && peek() != '>' && peek() != '/') tag.name += bytes_[at_++];
    for (;;) {
      skip_blanks();
      if (peek() == '/') {
        tag.empty = true;
        ++at_;
        continue;
      }
      if (peek() == '>') break;
      std::string key;
      while (!is_blank(peek()) && peek() != '=' && peek() != '>') key += bytes_[at_++];
      skip_blanks();
      if (peek() != '=') fail(tag.begin, "the attribute " + quote(key) + " has no value");
      ++at_;
      skip_blanks();
      const char mark = peek();
      if (mark != '"' && mark != '\'')
        fail(tag.begin, "the value of " + quote(key) + " needs quotes");
      const std::size_t end = bytes_.find(mark, at_ + 1);
      if (end == std::string_view::npos)
        fail(tag.begin, "the value of " + quote(key) + " does not end");
      tag.attributes[key] = unescaped(bytes_.substr(at_ + 1, end - at_ - 1), tag.begin);
      at_ = end + 1;
    }
    ++at_;
    return true;
  }

  void read_tags() {
    std::vector<std::string> open;
    Element tag;
    while (next_tag(tag)) {
      const std::string parent = open.empty() ? "" : open.back();
      if (tag.closes) {
        if (open.empty() || open.back() != tag.name)
          fail(tag.begin, "</" + tag.name + "> closes what was not opened");
        open.pop_back();
        continue;
      }
      if (open.empty() && tag.name != "VTKFile")
        fail(tag.begin, "VTKFile must be the outermost tag");
      if (tag.name == "VTKFile") read_file_tag(tag);
      if (tag.name == "AppendedData") return read_appended(tag);
      if (tag.name == "Piece" && parent == kind_) pieces_.push_back({tag, {}, {}});
      if (tag.name == kind_ && kind_ == "ImageData") image_ = tag;
      if (tag.name == "DataArray" || tag.name == "Array") read_array_tag(tag, parent);
      if (tag.name == "PDataArray" && parent == "PPointData") promised_.push_back({tag});
      if (tag.name == "Array" || tag.name == "DataArray") {
        if (!tag.empty && !skip_text(tag.name)) fail(tag.begin, "<" + tag.name + "> does not end");
        continue;
      }
      if (!tag.empty) open.push_back(tag.name);
    }
    if (!open.empty()) fail(bytes_.size(), "the file ends within <" + open.back() + ">");
  }
  // Goes behind the end of an array.
  bool skip_text(const std::string& name) {
    const std::string end = "</" + name;
    const std::size_t found = bytes_.find(end, at_);
    if (found == std::string_view::npos) return false;
    at_ = std::min(bytes_.find('>', found), bytes_.size() - 1) + 1;
    return true;
  }

  void read_file_tag(const Element& tag) {
    kind_ = tag["type"];
    const bool known = kind_ == "PolyData" || kind_ == "UnstructuredGrid" ||
                       kind_ == "StructuredGrid" || kind_ == "ImageData";
    if (kind_ == "Collection")
      fail(tag.begin, "is a collection (.pvd): name one of the files that it lists");
    if (kind_.starts_with('P') && kind_ != "PolyData" && !(has_other_files() && open_))
      fail(tag.begin,
           "is of type " + quote(kind_) + ", whose points are in other files: name one of these");
    if (!known && !has_other_files())
      fail(tag.begin,
           "VTK files of type " + quote(kind_) +
               " are not read: PolyData, UnstructuredGrid, StructuredGrid and ImageData are");
    const std::string order = tag["byte_order"], header = tag["header_type"],
                      compressor = tag["compressor"];
    if (!order.empty() && order != "LittleEndian" && order != "BigEndian")
      fail(tag.begin, "the byte_order " + quote(order) + " is not known");
    if (!header.empty() && header != "UInt32" && header != "UInt64")
      fail(tag.begin, "the header_type " + quote(header) + " is not known");
    swapped_ = (order == "BigEndian") == is_little_endian();
    header_size_ = header == "UInt64" ? 8 : 4;
    compressed_ = !compressor.empty();
    if (compressed_ && compressor != "vtkZLibDataCompressor")
      fail(tag.begin,
           "is compressed by " + quote(compressor) + "; only vtkZLibDataCompressor is read");
  }

  void read_appended(const Element& tag) {
    const std::size_t mark = bytes_.find('_', at_);
    if (mark == std::string_view::npos) fail(tag.begin, "AppendedData has no '_' before its bytes");
    appended_ = bytes_.substr(mark + 1);
    appended_base64_ = tag["encoding"] != "raw";
    if (appended_base64_) appended_ = appended_.substr(0, appended_.find('<'));
  }

  void read_array_tag(const Element& tag, const std::string& parent) {
    const std::size_t end = tag.empty ? at_ : std::min(bytes_.find('<', at_), bytes_.size());
    const Array array{tag, at_, end};
    if (parent == "FieldData") field_data_.push_back(array);
    if (pieces_.empty()) return;
    if (parent == "PointData") pieces_.back().point_data.push_back(array);
    if (parent == "Points") pieces_.back().points.push_back(array);
  }

  // --- numbers -----------------------------------------------------------------------------------
  std::uint64_t whole_number(const Element& tag, std::string_view key,
                             std::uint64_t otherwise) const {
    const std::string text = tag[key];
    if (text.empty()) return otherwise;
    const std::optional<std::int64_t> value = parse_integer(trim(text));
    if (!value || *value < 0)
      fail(tag.begin,
           std::string(key) + "=" + quote(text) + " is no whole number that is not negative");
    return static_cast<std::uint64_t>(*value);
  }

  std::uint64_t read_header(ByteCursor& cursor, const Array& array) const {
    const std::optional<std::string> bytes = cursor.read(header_size_);
    if (!bytes) fail(array.tag.begin, called(array) + " ends too early");
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < header_size_; ++i) {
      const std::size_t from = swapped_ == is_little_endian() ? header_size_ - 1 - i : i;
      value |= std::uint64_t{static_cast<unsigned char>((*bytes)[from])} << (8 * i);
    }
    return value;
  }

  std::string called(const Array& array) const { return "the array " + quote(array.tag["Name"]); }

  // The numbers of an array, which must be `wanted`.
  std::vector<double> numbers(const Array& array, std::uint64_t wanted) {
    const Element& tag = array.tag;
    const std::optional<NumberFormat> format = xml_number(tag["type"]);
    if (!format)
      fail(tag.begin, called(array) + " has numbers of an unknown type " + quote(tag["type"]));
    const std::string kind = tag["format"];
    std::string_view text = bytes_.substr(array.begin, array.end - array.begin);
    if (kind == "ascii") return ascii_numbers(array, text, wanted);
    if (kind != "binary" && kind != "appended")
      fail(tag.begin, called(array) + " has the unknown format " + quote(kind));
    bool base64 = true;
    if (kind == "appended") {
      const std::uint64_t offset = whole_number(tag, "offset", 0);
      if (offset > appended_.size())
        fail(tag.begin, called(array) + " begins behind the end of the file");
      text = appended_.substr(static_cast<std::size_t>(offset));
      base64 = appended_base64_;
    }
    constexpr std::uint64_t most = std::uint64_t{1} << 48;
    if (wanted > most) fail(tag.begin, called(array) + " promises more numbers than any file has");
    ByteCursor cursor(text, base64);
    const std::string bytes = compressed_ ? inflated(array, cursor, wanted * format->size)
                                          : plain(array, cursor, wanted * format->size);
    std::vector<double> values;
    if (!append_numbers(bytes, *format, swapped_, values))
      out_.remarks.push_back(tag["Name"] + " has whole numbers beyond 2^53, which are rounded");
    return values;
  }

  [[noreturn]] void fail_size(const Array& array, std::uint64_t there, std::uint64_t wanted) const {
    fail(array.tag.begin, called(array) + " has " + std::to_string(there) +
                              " bytes, its points need " + std::to_string(wanted));
  }
  std::string plain(const Array& array, ByteCursor& cursor, std::uint64_t wanted) const {
    const std::uint64_t size = read_header(cursor, array);
    if (size != wanted) fail_size(array, size, wanted);
    std::optional<std::string> bytes = cursor.read(size);
    if (!bytes) fail(array.tag.begin, called(array) + " ends too early");
    return std::move(*bytes);
  }
  std::string inflated(const Array& array, ByteCursor& cursor, std::uint64_t wanted) const {
    const std::uint64_t blocks = read_header(cursor, array), size = read_header(cursor, array),
                        last = read_header(cursor, array);
    const bool sound = size <= std::max<std::uint64_t>(wanted, std::uint64_t{1} << 32) &&
                       last <= size && blocks <= bytes_.size();
    const std::uint64_t full = last == 0 ? blocks : blocks - 1;
    if (!sound || (blocks == 0) != (wanted == 0) ||
        (blocks > 0 && (wanted < last || (size == 0 ? full != 0 : (wanted - last) / size != full) ||
                        wanted - last != full * size)))
      fail_size(array, blocks == 0 ? 0 : full * size + last, wanted);
    std::vector<std::uint64_t> sizes;
    for (std::uint64_t b = 0; b < blocks; ++b) sizes.push_back(read_header(cursor, array));
    std::string bytes;
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const std::optional<std::string> block = cursor.read(sizes[b]);
      if (!block) fail(array.tag.begin, called(array) + " ends too early");
      const std::optional<std::string> whole =
          inflate_bytes(*block, b + 1 == blocks && last > 0 ? last : size);
      if (!whole)
        fail(array.tag.begin,
             called(array) + " is damaged: block " + std::to_string(b) + " is not what zlib makes");
      bytes += *whole;
    }
    return bytes;
  }
  std::vector<double> ascii_numbers(const Array& array, std::string_view text,
                                    std::uint64_t wanted) const {
    std::vector<double> values;
    std::size_t at = 0;
    for (;;) {
      while (at < text.size() && is_blank(text[at])) ++at;
      if (at == text.size()) break;
      const std::size_t begin = at;
      while (at < text.size() && !is_blank(text[at])) ++at;
      const std::string_view word = text.substr(begin, at - begin);
      const std::optional<double> value = parse_number(word);
      if (!value)
        fail(array.begin + begin, quote(word) + " is no number: " + called(array) + " needs one");
      values.push_back(*value);
    }
    if (values.size() != wanted)
      fail(array.tag.begin, called(array) + " has " + std::to_string(values.size()) +
                                " numbers, its points need " + std::to_string(wanted));
    return values;
  }

  // --- what is read ------------------------------------------------------------------------------
  std::uint64_t components_of(const Array& array) const {
    const std::uint64_t components = whole_number(array.tag, "NumberOfComponents", 1);
    constexpr std::uint64_t most = 10000;
    if (components < 1 || components > most)
      fail(array.tag.begin, called(array) + " needs 1 to 10000 components");
    return components;
  }

  void note(const Array& array) {
    const std::string name = array.tag["Name"];
    if (name != "TimeValue" && name != "step" && name != "TIME" && name != "CYCLE") return;
    if (array.tag["NumberOfTuples"] != "1" && !array.tag["NumberOfTuples"].empty()) return;
    const double value = numbers(array, 1)[0];
    if (!std::isfinite(value)) fail(array.tag.begin, called(array) + " is not finite");
    if (name == "TimeValue" || name == "TIME") {
      out_.time = value;
      return;
    }
    constexpr double most = 9007199254740992;  // 2^53
    if (std::abs(value) > most || value != std::floor(value))
      fail(array.tag.begin, called(array) + " is no whole number below 2^53");
    out_.step = static_cast<std::int64_t>(value);
  }

  std::array<std::uint64_t, 6> extent_of(const Element& tag,
                                         std::array<std::int64_t, 3>& lower) const {
    std::vector<std::string_view> words;
    const std::string text = tag["Extent"];
    split_at_blanks(text, words);
    std::array<std::uint64_t, 6> counts{};
    if (words.size() != 6) fail(tag.begin, "Extent=" + quote(text) + " needs six whole numbers");
    for (std::size_t d = 0; d < 3; ++d) {
      const auto from = parse_integer(words[2 * d]), to = parse_integer(words[2 * d + 1]);
      constexpr std::int64_t most = std::int64_t{1} << 40;
      if (!from || !to || *from < -most || *to > most || *to < *from)
        fail(tag.begin,
             "Extent=" + quote(text) + " needs a lower and an upper index along each axis");
      lower[d] = *from;
      counts[d] = static_cast<std::uint64_t>(*to - *from) + 1;
    }
    return counts;
  }

  std::uint64_t nodes_of(const Element& tag) const {
    std::array<std::int64_t, 3> lower{};
    const auto counts = extent_of(tag, lower);
    std::uint64_t nodes = 1;
    for (std::size_t d = 0; d < 3; ++d) {
      constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
      if (counts[d] > most || nodes > most / counts[d])
        fail(tag.begin, "more points than a table of particles can number, 2^32 - 2");
      nodes *= counts[d];
    }
    return nodes;
  }

  // The nodes of an image, after its data, which take as much memory.
  std::vector<double> image_nodes(const Element& tag) const {
    std::array<std::array<double, 3>, 2> grid{{{0, 0, 0}, {1, 1, 1}}};
    const std::array<const char*, 2> keys{"Origin", "Spacing"};
    for (std::size_t k = 0; k < 2; ++k) {
      const std::string text = image_[keys[k]];
      std::vector<std::string_view> words;
      split_at_blanks(text, words);
      if (words.size() != 3) fail(image_.begin, std::string(keys[k]) + " needs three numbers");
      for (std::size_t d = 0; d < 3; ++d) {
        const std::optional<double> value = parse_number(words[d]);
        if (!value || !std::isfinite(*value))
          fail(image_.begin, quote(words[d]) + " is no finite number: " + keys[k] + " needs one");
        grid[k][d] = *value;
      }
    }
    const std::string direction = image_["Direction"];
    if (!direction.empty()) {
      std::vector<std::string_view> words;
      split_at_blanks(direction, words);
      bool turned = words.size() != 9;
      for (std::size_t i = 0; i < words.size() && !turned; ++i)
        turned = parse_number(words[i]) != std::optional<double>(i % 4 == 0 ? 1 : 0);
      if (turned) fail(image_.begin, "an image that is turned (Direction) is not read");
    }
    std::array<std::int64_t, 3> lower{};
    const auto counts = extent_of(tag, lower);
    std::vector<double> nodes;
    std::array<std::uint64_t, 3> at{};
    for (at[2] = 0; at[2] < counts[2]; ++at[2])
      for (at[1] = 0; at[1] < counts[1]; ++at[1])
        for (at[0] = 0; at[0] < counts[0]; ++at[0])
          for (std::size_t d = 0; d < 3; ++d)
            nodes.push_back(grid[0][d] +
                            static_cast<double>(lower[d] + static_cast<std::int64_t>(at[d])) *
                                grid[1][d]);
    return nodes;
  }

  void require_room(const Piece& piece, std::uint64_t points) const {
    if (points + out_.points.size() / 3 >= std::numeric_limits<std::uint32_t>::max() - 1)
      fail(piece.tag.begin, "more points than a table of particles can number, 2^32 - 2");
  }

  // Of points, each of which is in one of the files.
  bool has_other_files() const { return kind_ == "PPolyData" || kind_ == "PUnstructuredGrid"; }

  void add_file(const Piece& piece) {
    const std::string source = piece.tag["Source"];
    if (source.empty()) fail(piece.tag.begin, "the piece needs the name of a file as its Source");
    const std::filesystem::path path = path_->parent_path() / source;
    std::string bytes;
    try {
      bytes = open_(path);
    } catch (const FileError& error) {
      fail(piece.tag.begin, "names a piece that cannot be read: " + std::string(error.what()));
    }
    if (!bytes.starts_with('<')) fail(piece.tag.begin, "names a piece that is no XML file of VTK");
    VtkPoints more = XmlReader(bytes, path, {}).read();
    require_room(piece, more.points.size() / 3);
    require_new(piece, path);
    require_same(piece, "step", more.step, out_.step);
    require_same(piece, "time", more.time, out_.time);
    if (!more.points.empty())
      for (const Array& array : promised_) require_array(piece, array, more.arrays);
    const bool first = &piece == &pieces_.front();
    if (first) out_.remarks = std::move(more.remarks);
    append(more.points);
    join(piece, std::move(more.arrays), more.points.empty());
  }
  // No file is a piece twice.
  void require_new(const Piece& piece, const std::filesystem::path& path) {
    std::error_code none;
    if (!files_.insert(std::filesystem::weakly_canonical(path, none)).second)
      fail(piece.tag.begin, "names the piece " + quote(piece.tag["Source"]) + " again");
  }
  // All pieces are of one time and step, where they say which.
  template <class Number>
  void require_same(const Piece& piece, const char* what, const std::optional<Number>& its,
                    std::optional<Number>& of_all) const {
    if (!of_all) of_all = its;
    if (its && *its != *of_all)
      fail(piece.tag.begin, std::string("the piece is of the ") + what + " " + to_text(*its) +
                                ", and what was read before it of " + to_text(*of_all));
  }
  void require_array(const Piece& piece, const Array& promised,
                     const std::vector<ReadArray>& arrays) const {
    if (promised.tag["type"] == "String") return;
    const std::string name = recon::to_utf8(promised.tag["Name"]);
    const auto components = static_cast<int>(components_of(promised));
    for (const ReadArray& each : arrays)
      if (each.name == name && each.components == components) return;
    fail(piece.tag.begin, "the piece has no array " + quote(name) + " of " +
                              std::to_string(components) + " components, which PPointData names");
  }

  void add(const Piece& piece) {
    const bool by_extent = kind_ == "ImageData" || kind_ == "StructuredGrid";
    const std::uint64_t points =
        by_extent ? nodes_of(piece.tag) : whole_number(piece.tag, "NumberOfPoints", 0);
    require_room(piece, points);
    std::vector<ReadArray> arrays;
    for (const Array& array : piece.point_data) {
      const std::string name = recon::to_utf8(array.tag["Name"]);
      if (array.tag["type"] == "String") {
        if (&piece == &pieces_.front())
          out_.remarks.push_back(name + " holds texts and is left out");
        continue;
      }
      const std::uint64_t components = components_of(array);
      ReadArray read{name, static_cast<int>(components), numbers(array, components * points), {}};
      for (std::uint64_t c = 0; c < components; ++c)
        read.component_names.push_back(array.tag["ComponentName" + std::to_string(c)]);
      arrays.push_back(std::move(read));
    }
    if (kind_ == "ImageData") {
      if (arrays.empty()) fail(piece.tag.begin, "the piece has no data at its points");
      append(image_nodes(piece.tag));
    } else if (points > 0 || !piece.points.empty()) {
      if (piece.points.size() != 1) fail(piece.tag.begin, "the piece needs one array of Points");
      const Array& array = piece.points.front();
      if (components_of(array) != 3) fail(array.tag.begin, "Points need 3 components");
      append(numbers(array, 3 * points));
    }
    join(piece, std::move(arrays), points == 0);
  }
  // Puts the data of a piece behind those that are there.
  void join(const Piece& piece, std::vector<ReadArray> arrays, bool none) {
    if (&piece == &pieces_.front()) {
      out_.arrays = std::move(arrays);
      return;
    }
    if (none) return;
    for (ReadArray& into : out_.arrays) {
      const auto same = std::find_if(arrays.begin(), arrays.end(), [&](const ReadArray& each) {
        return each.name == into.name && each.components == into.components;
      });
      if (same == arrays.end())
        fail(piece.tag.begin, "the piece has no array " + quote(into.name) + " like the first one");
      into.values.insert(into.values.end(), same->values.begin(), same->values.end());
    }
  }
  void append(const std::vector<double>& points) {
    out_.points.insert(out_.points.end(), points.begin(), points.end());
  }

  std::string_view bytes_, appended_;
  const std::filesystem::path* path_;
  OpenFile open_;
  std::size_t at_ = 0, header_size_ = 4;
  bool swapped_ = false, compressed_ = false, appended_base64_ = false;
  std::string kind_;
  Element image_;
  std::vector<Array> field_data_;
  std::vector<Piece> pieces_;
  std::vector<Array> promised_;            // of the pieces in other files
  std::set<std::filesystem::path> files_;  // that have been read
  VtkPoints out_;
};

}  // namespace

VtkPoints read_xml_vtk(std::string_view bytes, const std::filesystem::path& path,
                       const OpenFile& open) {
  return XmlReader(bytes, path, open).read();
}

}  // namespace recon::detail
