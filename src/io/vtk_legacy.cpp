// Legacy VTK files (VTK File Formats, "Simple Legacy Formats"), versions 1 to 5.1:
//
//   # vtk DataFile Version x.y
//   a title
//   ASCII or BINARY (numbers with the most significant byte first)
//   DATASET <kind>, points, cells
//   POINT_DATA n, and arrays; CELL_DATA n, and arrays
//
// Points and their data are read, everything else is passed over.
#include <algorithm>
#include <cctype>

#include "formats.hpp"
#include "vtk_numbers.hpp"

namespace recon::detail {

namespace {

using Words = std::vector<std::string_view>;

std::string upper(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return out;
}

// Names have %20 for a blank, and so on.
std::string decoded(std::string_view name) {
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i) {
    int code = 0;
    const char* const digits = name.data() + i + 1;
    const bool escaped = name[i] == '%' && i + 2 < name.size() &&
                         std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2;
    out += escaped ? static_cast<char>(code) : name[i];
    if (escaped) i += 2;
  }
  return out;
}

class LegacyReader {
 public:
  LegacyReader(std::string_view bytes, const std::filesystem::path& path)
      : bytes_(bytes), path_(&path) {}

  VtkPoints read() {
    read_header();
    Words words;
    while (next_words(words)) read_section(words);
    if (!has_points_) fail("the file has no POINTS");
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const auto begin = bytes_.begin();
    const auto lines = std::count(begin, begin + static_cast<std::ptrdiff_t>(line_begin_), '\n');
    throw FileError(*path_, binary_ ? 0 : static_cast<std::size_t>(lines) + 1, what);
  }

  // --- lines and words ---------------------------------------------------------------------------
  bool next_line(std::string_view& line) {
    if (at_ >= bytes_.size()) return false;
    line_begin_ = at_;
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    line = bytes_.substr(at_, end - at_);
    at_ = std::min(end + 1, bytes_.size());
    if (line.ends_with('\r')) line.remove_suffix(1);
    return true;
  }
  // The words of the next line that is not blank.
  bool next_words(Words& words) {
    std::string_view line;
    while (next_line(line)) {
      split_at_blanks(line, words);
      if (!words.empty()) return true;
    }
    return false;
  }
  // The first word of the next line that is not blank, which is not taken.
  std::string peek() {
    const std::size_t at = at_, begin = line_begin_;
    Words words;
    std::string word = next_words(words) ? upper(words[0]) : "";
    at_ = at;
    line_begin_ = begin;
    return word;
  }
  std::uint64_t count(const Words& words, std::size_t place) const {
    const std::optional<std::int64_t> value =
        place < words.size() ? parse_integer(words[place]) : std::nullopt;
    if (!value || *value < 0)
      fail(std::string(words[0]) + " needs a whole number that is not negative as its word " +
           std::to_string(place + 1));
    return static_cast<std::uint64_t>(*value);
  }
  NumberFormat format(const Words& words, std::size_t place) const {
    const auto found = place < words.size() ? legacy_number(words[place]) : std::nullopt;
    if (!found)
      fail(std::string(words[0]) + " needs the type of its numbers as its word " +
           std::to_string(place + 1) +
           (place < words.size() ? ", " + quote(words[place]) + " is none" : ""));
    return *found;
  }

  // --- numbers -----------------------------------------------------------------------------------
  std::vector<double> numbers(const std::string& name, std::uint64_t wanted, NumberFormat format) {
    std::vector<double> values;
    const std::uint64_t left = bytes_.size() - at_;
    if (wanted > left || (binary_ && wanted > left / format.size))
      fail(name + " needs " + std::to_string(wanted) + " numbers, the file ends before that");
    if (binary_) {
      const std::size_t size = static_cast<std::size_t>(wanted) * format.size;
      if (!append_numbers(bytes_.substr(at_, size), format, is_little_endian(), values))
        out_.remarks.push_back(name + " has whole numbers beyond 2^53, which are rounded");
      at_ += size;
      return values;
    }
    values.reserve(static_cast<std::size_t>(wanted));
    while (values.size() < wanted) {
      const auto is_blank = [](char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; };
      while (at_ < bytes_.size() && is_blank(bytes_[at_])) ++at_;
      const std::size_t begin = at_;
      while (at_ < bytes_.size() && !is_blank(bytes_[at_])) ++at_;
      if (begin < bytes_.size()) line_begin_ = begin;
      const std::string_view word = bytes_.substr(begin, at_ - begin);
      const std::optional<double> value = parse_number(word);
      if (word.empty())
        fail(name + " needs " + std::to_string(wanted) + " numbers, the file ends after " +
             std::to_string(values.size()));
      if (!value) fail(quote(word) + " is no number: " + name + " needs one");
      values.push_back(*value);
    }
    return values;
  }
  // Bits of binary files are packed; each array begins with a byte of its own.
  std::vector<double> bits(const std::string& name, std::uint64_t wanted) {
    if (!binary_) return numbers(name, wanted, {NumberKind::natural, 1});
    const std::vector<double> packed =
        numbers(name, wanted / 8 + (wanted % 8 != 0), {NumberKind::natural, 1});
    std::vector<double> values;
    for (std::size_t i = 0; i < wanted; ++i)
      values.push_back(static_cast<int>(packed[i / 8]) >> (7 - i % 8) & 1);
    return values;
  }

  // --- sections ----------------------------------------------------------------------------------
  void read_header() {
    std::string_view line;
    next_line(line);
    if (!next_line(line)) fail("the file ends where the title must be");
    Words words;
    if (!next_words(words)) fail("the file ends where ASCII or BINARY must be");
    const std::string kind = upper(words[0]);
    if (kind != "ASCII" && kind != "BINARY")
      fail(quote(words[0]) + " where ASCII or BINARY must be");
    binary_ = kind == "BINARY";
  }

  void read_section(const Words& words) {
    const std::string key = upper(words[0]);
    if (key == "DATASET") return read_kind(words);
    if (key == "POINTS") return read_points(words);
    if (key == "DIMENSIONS" || key == "ORIGIN" || key == "SPACING" || key == "ASPECT_RATIO")
      return read_grid(key, words);
    if (key == "POINT_DATA" || key == "CELL_DATA") {
      of_points_ = key == "POINT_DATA";
      in_data_ = true;
      tuples_ = count(words, 1);
      if (of_points_ && !has_points_) make_grid();
      if (of_points_ && tuples_ != size())
        fail("POINT_DATA is for " + std::to_string(tuples_) + " points, there are " +
             std::to_string(size()));
      return;
    }
    if (key == "METADATA") return skip_metadata();
    if (key == "FIELD") return read_field(words);
    if (key == "CELL_TYPES") {
      numbers(key, count(words, 1), {NumberKind::whole, 4});
      return;
    }
    if (key == "CELLS" || key == "VERTICES" || key == "LINES" || key == "POLYGONS" ||
        key == "TRIANGLE_STRIPS")
      return skip_cells(key, words);
    if (in_data_) return read_attribute(key, words);
    fail(quote(words[0]) + " is no section that is known here");
  }

  void read_kind(const Words& words) {
    kind_ = words.size() > 1 ? upper(words[1]) : "";
    for (const char* known :
         {"POLYDATA", "UNSTRUCTURED_GRID", "STRUCTURED_GRID", "STRUCTURED_POINTS"})
      if (kind_ == known) return;
    fail("DATASET " + (words.size() > 1 ? quote(words[1]) : "") +
         " is not read: POLYDATA, UNSTRUCTURED_GRID, STRUCTURED_GRID and STRUCTURED_POINTS are");
  }

  void set_points(std::vector<double> points) {
    if (points.size() / 3 >= std::numeric_limits<std::uint32_t>::max() - 1)
      fail("more points than a table of particles can number, 2^32 - 2");
    out_.points = std::move(points);
    has_points_ = true;
  }
  std::size_t size() const { return out_.points.size() / 3; }

  void read_points(const Words& words) {
    if (has_points_) fail("POINTS stands twice");
    const std::uint64_t points = count(words, 1);
    if (points > bytes_.size()) fail("POINTS promises more points than the file has bytes");
    set_points(numbers("POINTS", 3 * points, format(words, 2)));
  }

  void read_grid(const std::string& key, const Words& words) {
    for (std::size_t d = 0; d < 3; ++d) {
      const std::optional<double> value =
          d + 1 < words.size() ? parse_number(words[d + 1]) : std::nullopt;
      if (!value) fail(key + " needs three numbers");
      if (key == "DIMENSIONS") dimensions_[d] = count(words, d + 1);
      if (key == "ORIGIN") origin_[d] = *value;
      if (key == "SPACING" || key == "ASPECT_RATIO") spacing_[d] = *value;
    }
  }
  // The nodes of structured points, of which data must follow: they take no more memory than these.
  void make_grid() {
    if (kind_ != "STRUCTURED_POINTS") fail("POINT_DATA stands before POINTS");
    std::uint64_t nodes = 1;
    for (const std::uint64_t along : dimensions_) {
      if (along == 0 || along > bytes_.size() || nodes > bytes_.size() / along)
        fail("DIMENSIONS promises more points than the file has bytes");
      nodes *= along;
    }
    std::vector<double> points;
    for (std::uint64_t k = 0; k < dimensions_[2]; ++k)
      for (std::uint64_t j = 0; j < dimensions_[1]; ++j)
        for (std::uint64_t i = 0; i < dimensions_[0]; ++i) {
          points.push_back(origin_[0] + static_cast<double>(i) * spacing_[0]);
          points.push_back(origin_[1] + static_cast<double>(j) * spacing_[1]);
          points.push_back(origin_[2] + static_cast<double>(k) * spacing_[2]);
        }
    set_points(std::move(points));
  }

  void skip_metadata() {
    std::string_view line;
    while (next_line(line) && !trim(line).empty()) {
    }
  }

  // Up to version 4 one list of whole numbers; from 5 on offsets and connectivity.
  void skip_cells(const std::string& key, const Words& words) {
    const std::uint64_t first = count(words, 1), second = count(words, 2);
    if (peek() != "OFFSETS") {
      numbers(key, second, {NumberKind::whole, 4});
      return;
    }
    for (const auto& [part, wanted] : {std::pair{"OFFSETS", first}, {"CONNECTIVITY", second}}) {
      Words line;
      if (!next_words(line) || upper(line[0]) != part)
        fail(key + " needs " + part + " and its numbers");
      numbers(key + " " + part, wanted, format(line, 1));
    }
  }

  void add(std::string name, std::uint64_t components, std::vector<double> values) {
    if (!of_points_) return;
    constexpr std::uint64_t most = 10000;
    if (components > most) fail(name + " has more than 10000 components");
    out_.arrays.push_back({std::move(name), static_cast<int>(components), std::move(values), {}});
  }

  // An array of `components` for each point or cell; `place`: of its type among the words.
  void read_array(const Words& words, std::uint64_t components, std::size_t place) {
    if (words.size() < 2) fail(std::string(words[0]) + " needs a name");
    const std::string name = decoded(words[1]);
    add(name, components, read_values(name, components, tuples_, words, place));
  }
  std::vector<double> read_values(const std::string& name, std::uint64_t components,
                                  std::uint64_t tuples, const Words& words, std::size_t place) {
    if (components == 0 || components > bytes_.size() || tuples > 8 * bytes_.size() / components)
      fail(name + " needs at least one component, and no more numbers than the file has bytes");
    const std::uint64_t wanted = components * tuples;
    if (place < words.size() && upper(words[place]) == "BIT") return bits(name, wanted);
    return numbers(name, wanted, format(words, place));
  }

  void read_attribute(const std::string& key, const Words& words) {
    if (key == "SCALARS") {
      const std::uint64_t components = words.size() > 3 ? count(words, 3) : 1;
      const std::string name(words.size() > 1 ? words[1] : "");
      const std::string type(words.size() > 2 ? words[2] : "");
      if (name.empty()) fail("SCALARS needs a name");
      if (peek() == "LOOKUP_TABLE") {
        std::string_view line;
        while (next_line(line) && trim(line).empty()) {
        }
      }
      return read_array({"SCALARS", name, type}, components, 2);
    }
    if (key == "VECTORS" || key == "NORMALS") return read_array(words, 3, 2);
    if (key == "TENSORS") return read_array(words, 9, 2);
    if (key == "TENSORS6") return read_array(words, 6, 2);
    if (key == "GLOBAL_IDS" || key == "PEDIGREE_IDS" || key == "EDGE_FLAGS")
      return read_array(words, 1, 2);
    if (key == "TEXTURE_COORDINATES") return read_array(words, count(words, 2), 3);
    if (key == "COLOR_SCALARS") {
      const std::string name(words.size() > 1 ? words[1] : "");
      return read_array({"COLOR_SCALARS", name, binary_ ? "unsigned_char" : "float"},
                        count(words, 2), 2);
    }
    if (key == "LOOKUP_TABLE") {
      const std::uint64_t colours = count(words, 2);
      if (colours > bytes_.size()) fail("LOOKUP_TABLE promises more than the file has bytes");
      numbers(key, 4 * colours, {NumberKind::natural, 1});
      return;
    }
    fail(quote(words[0]) + " is no attribute that is known");
  }

  void read_field(const Words& words) {
    for (std::uint64_t left = count(words, 2); left > 0; --left) {
      Words array;
      while (peek() == "METADATA") {
        next_words(array);
        skip_metadata();
      }
      if (!next_words(array)) fail("the file ends within FIELD");
      if (array.size() != 4)
        fail("an array of FIELD needs its name, components, tuples and type on one line");
      const std::string name = decoded(array[0]);
      const std::uint64_t components = count(array, 1), tuples = count(array, 2);
      if (upper(array[3]) == "STRING") {
        skip_texts(name, components, tuples);
        continue;
      }
      std::vector<double> values = components * tuples == 0
                                       ? std::vector<double>()
                                       : read_values(name, components, tuples, array, 3);
      if (!in_data_) {
        note(name, values);
        continue;
      }
      if (of_points_ && tuples != size())
        fail(name + " has " + std::to_string(tuples) + " tuples for " + std::to_string(size()) +
             " points");
      if (components > 0) add(name, components, std::move(values));
    }
  }
  void skip_texts(const std::string& name, std::uint64_t components, std::uint64_t tuples) {
    if (binary_) fail(name + " holds texts, which are not read from binary files");
    std::string_view line;
    if (tuples > bytes_.size() || components > bytes_.size()) fail(name + " ends too early");
    for (std::uint64_t i = 0; i < components * tuples; ++i)
      if (!next_line(line)) fail(name + " ends too early");
    if (in_data_ && of_points_) out_.remarks.push_back(name + " holds texts and is left out");
  }
  // What is known about the data as a whole.
  void note(const std::string& name, const std::vector<double>& values) {
    if (values.size() != 1 || !std::isfinite(values[0])) return;
    if (name == "TimeValue" || name == "TIME") out_.time = values[0];
    constexpr double most = 9007199254740992;  // 2^53
    if ((name == "step" || name == "CYCLE") && std::abs(values[0]) <= most &&
        values[0] == std::floor(values[0]))
      out_.step = static_cast<std::int64_t>(values[0]);
  }

  std::string_view bytes_;
  const std::filesystem::path* path_;
  std::size_t at_ = 0, line_begin_ = 0;
  bool binary_ = false, has_points_ = false, in_data_ = false, of_points_ = false;
  std::string kind_;
  std::array<std::uint64_t, 3> dimensions_{};
  std::array<double, 3> origin_{}, spacing_{1, 1, 1};
  std::uint64_t tuples_ = 0;
  VtkPoints out_;
};

}  // namespace

VtkPoints read_legacy_vtk(std::string_view bytes, const std::filesystem::path& path) {
  return LegacyReader(bytes, path).read();
}

}  // namespace recon::detail
