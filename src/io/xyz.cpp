// XYZ: for each frame the number of particles on a line, a line of comment, and a line for each
// particle. Extended (libAtoms, ASE, OVITO) the comment is a list of key=value pairs:
//
//   Lattice="ax ay az bx by bz cx cy cz" Properties=species:S:1:pos:R:3 pbc="T T F" Time=0.5
//
// Values with blanks stand in double or single quotes or braces. Keys are told apart whatever their
// case. Properties is a list of name:type:columns with the types S (text), R (real), I (whole) and
// L (T or F, which become 1 and 0).
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "column_parser.hpp"
#include "core/lower_case.hpp"
#include "formats.hpp"

namespace recon::detail {

namespace {

struct XyzFrame {
  FrameInfo info;
  std::vector<char> types;  // of the columns
  std::optional<SimulationCell> cell;
  std::array<bool, max_dimension> periodic{true, true, true};
  bool has_periods = false;
  std::vector<std::string> remarks;
};

using Pairs = std::map<std::string, std::string, std::less<>>;

// The key=value pairs of a comment; words without '=' are passed over.
Pairs read_pairs(const TextFile& file, std::string_view line) {
  Pairs pairs;
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  std::size_t at = 0;
  while (at < line.size()) {
    while (at < line.size() && is_blank(line[at])) ++at;
    const std::size_t begin = at;
    while (at < line.size() && line[at] != '=' && !is_blank(line[at])) ++at;
    const std::string key = lower_case(line.substr(begin, at - begin));
    if (at >= line.size() || line[at] != '=') continue;
    ++at;
    const char open = at < line.size() ? line[at] : ' ';
    const char close = open == '{' ? '}' : open;
    std::string value;
    if (open == '"' || open == '\'' || open == '{') {
      const std::size_t end = line.find(close, at + 1);
      if (end == std::string_view::npos)
        file.fail("the value of " + quote(key) + " does not end on this line");
      value = line.substr(at + 1, end - at - 1);
      at = end + 1;
    } else {
      const std::size_t from = at;
      while (at < line.size() && !is_blank(line[at])) ++at;
      value = line.substr(from, at - from);
    }
    if (!key.empty() && !pairs.emplace(key, value).second)
      file.fail("the key " + quote(key) + " stands twice in the comment");
  }
  return pairs;
}

std::vector<double> read_numbers(const TextFile& file, const std::string& key,
                                 std::string_view text, std::size_t wanted) {
  std::vector<std::string_view> words;
  split_at_blanks(text, words);
  std::vector<double> numbers;
  for (const std::string_view word : words) {
    const std::optional<double> value = parse_number(word);
    if (!value || !std::isfinite(*value))
      file.fail(quote(word) + " is no finite number: " + key + " needs " + std::to_string(wanted));
    numbers.push_back(*value);
  }
  if (numbers.size() != wanted)
    file.fail(key + " needs " + std::to_string(wanted) + " numbers, it has " +
              std::to_string(numbers.size()));
  return numbers;
}

std::array<bool, max_dimension> read_periods(const TextFile& file, std::string_view text) {
  std::vector<std::string_view> words;
  split_at_blanks(text, words);
  std::array<bool, max_dimension> periodic{};
  if (words.size() != max_dimension) file.fail("pbc needs three letters T or F");
  for (std::size_t d = 0; d < max_dimension; ++d) {
    const std::string word = lower_case(words[d]);
    const bool yes = word == "t" || word == "true" || word == "1";
    if (!yes && word != "f" && word != "false" && word != "0")
      file.fail(quote(words[d]) + " is neither T nor F: pbc needs three of these");
    periodic[d] = yes;
  }
  return periodic;
}

SimulationCell read_cell(const TextFile& file, const Pairs& pairs, const std::string& lattice) {
  SimulationCell cell;
  const std::vector<double> edges = read_numbers(file, "Lattice", lattice, 9);
  for (std::size_t i = 0; i < 9; ++i) cell.edges[i / 3][i % 3] = edges[i];
  if (const auto origin = pairs.find("origin"); origin != pairs.end()) {
    const std::vector<double> corner = read_numbers(file, "Origin", origin->second, 3);
    std::copy(corner.begin(), corner.end(), cell.origin.begin());
  }
  return cell;
}

// The columns that Properties names, as name:type:columns:name:type:columns...
void read_properties(const TextFile& file, const std::string& text, XyzFrame& frame) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ':')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  if (parts.size() % 3 != 0)
    file.fail("Properties needs name:type:columns for each property, it is " + quote(text));
  std::vector<std::string> names;
  for (std::size_t p = 0; p < parts.size(); p += 3) {
    const std::string& type = parts[p + 1];
    const std::optional<std::int64_t> columns = parse_integer(parts[p + 2]);
    if (parts[p].empty() || type.size() != 1 || std::string_view("SRIL").find(type) > 3)
      file.fail(quote(parts[p] + ":" + type) +
                " in Properties: a name and one of the types S, R, I, L is needed");
    constexpr std::int64_t most = 10000;
    if (!columns || *columns < 1 || *columns > most)
      file.fail(quote(parts[p + 2]) + " columns of " + quote(parts[p]) +
                " in Properties: a number from 1 to 10000 is needed");
    for (int c = 0; c < *columns; ++c) {
      const bool is_element = parts[p] == "species" && *columns == 1;
      names.push_back(is_element ? "element"
                                 : column_name(parts[p], c, static_cast<int>(*columns)));
      frame.types.push_back(type[0]);
    }
    if (names.size() > static_cast<std::size_t>(most))
      file.fail("Properties names more than 10000 columns");
  }
  frame.info.columns = to_utf8(names, frame.remarks);
}

void read_comment(const TextFile& file, std::string_view line, XyzFrame& frame) {
  // A comment that is no list of pairs is none of our business.
  const std::string head = lower_case(line);
  const bool extended =
      head.find("properties=") != std::string::npos || head.find("lattice=") != std::string::npos;
  if (!extended) return;
  const Pairs pairs = read_pairs(file, line);
  const auto value = [&](const char* key) -> const std::string* {
    const auto found = pairs.find(key);
    return found == pairs.end() ? nullptr : &found->second;
  };
  if (const std::string* properties = value("properties"))
    read_properties(file, *properties, frame);
  if (const std::string* lattice = value("lattice")) frame.cell = read_cell(file, pairs, *lattice);
  if (const std::string* periods = value("pbc")) {
    frame.periodic = read_periods(file, *periods);
    frame.has_periods = true;
  }
  if (const std::string* time = value("time"))
    frame.info.time = read_numbers(file, "Time", *time, 1)[0];
  for (const char* key : {"step", "timestep"}) {
    const std::string* step = value(key);
    if (step == nullptr) continue;
    frame.info.step = parse_integer(trim(*step));
    if (!frame.info.step) file.fail(quote(*step) + " is no whole number: " + key + " needs one");
  }
  if (!frame.cell) return;
  for (std::size_t e = 0; e < max_dimension; ++e) {
    const auto& edge = frame.cell->edges[e];
    const double length = std::hypot(edge[0], edge[1], edge[2]);
    if (!std::isfinite(length) || (frame.periodic[e] && length == 0))
      file.fail("an edge of a periodic Lattice must have a length");
  }
}

// The line of a particle, of which `done` were there before.
void particle_line(TextFile& file, const XyzFrame& frame, std::size_t done,
                   std::vector<std::string_view>& cells) {
  std::string_view line;
  if (!file.next(line))
    file.fail("the file ends after " + std::to_string(done) + " of the " +
              std::to_string(frame.info.particles) + " particles of the frame at line " +
              std::to_string(frame.info.line));
  split_at_blanks(line, cells);
  if (cells.size() != frame.info.columns.size())
    file.fail("the line has " + std::to_string(cells.size()) + " cells, the frame at line " +
              std::to_string(frame.info.line) + " has " +
              std::to_string(frame.info.columns.size()) + " columns");
}

// Plain XYZ tells its columns by its first particle: element, x, y, z, and numbers without a name.
void name_plain_columns(TextFile& file, XyzFrame& frame) {
  const TextFile::Mark before = file.mark();
  std::vector<std::string_view> cells;
  std::string_view line;
  if (file.next(line)) split_at_blanks(line, cells);
  if (frame.info.particles > 0 && cells.size() < 4)
    file.fail("XYZ needs element, x, y and z on the line of a particle, there are " +
              std::to_string(cells.size()) + " cells");
  const std::size_t count = frame.info.particles > 0 ? cells.size() : 4;
  file.go_to(before);
  for (std::size_t c = 0; c < count; ++c) {
    constexpr std::array<const char*, 4> names{"element", "x", "y", "z"};
    frame.info.columns.push_back(c < 4 ? names[c] : "column_" + std::to_string(c + 1));
    frame.types.push_back(c == 0 ? 'S' : 'R');
  }
}

std::optional<std::size_t> count_on(std::string_view line) {
  const std::optional<std::int64_t> count = parse_integer(trim(line));
  if (!count || *count < 0) return {};
  return static_cast<std::size_t>(*count);
}

// What a cell of a type may hold; logical values become numbers.
std::string_view cell_of(const TextFile& file, const std::string& name, char type,
                         std::string_view text) {
  if (type != 'L') return text;
  if (text == "T" || text == "True" || text == "true") return "1";
  if (text == "F" || text == "False" || text == "false") return "0";
  file.fail(quote(text) + " is neither T nor F: " + quote(name) + " is of type L");
}

class XyzFrames : public TextFrames {
 public:
  XyzFrames(TextFile& file, const ReadOptions& options) : TextFrames(file), options_(&options) {}
  const FrameInfo& info() const override { return frame_.info; }
  bool is_series() const override { return true; }

  void skip() override {
    std::vector<std::string_view> cells;
    for (std::size_t i = 0; i < frame_.info.particles; ++i) particle_line(file(), frame_, i, cells);
  }

  ParticleTable read() override {
    ColumnParser parser(file(), frame_.info.columns);
    parser.reserve(frame_.info.particles / static_cast<std::size_t>(options_->parts) + 1);
    std::vector<std::string_view> cells;
    for (std::size_t i = 0; i < frame_.info.particles; ++i) {
      particle_line(file(), frame_, i, cells);
      if (!options_->takes(i)) continue;
      for (std::size_t c = 0; c < cells.size(); ++c)
        parser.add_cell(c, cell_of(file(), frame_.info.columns[c], frame_.types[c], cells[c]));
      parser.end_row();
    }
    ParticleTable table = std::move(parser).finish(options_->missing);
    table.step = frame_.info.step;
    table.time = frame_.info.time;
    table.remarks.insert(table.remarks.end(), frame_.remarks.begin(), frame_.remarks.end());
    if (!frame_.cell) return table;
    set_cell_or_box(table, *frame_.cell, frame_.periodic);
    if (!frame_.has_periods)
      table.remarks.push_back(
          "the comment of the frame has a Lattice and no pbc: taken as periodic");
    return table;
  }

 private:
  bool find() override {
    XyzFrame next;
    std::string_view line;
    do {
      if (!file().next(line)) return false;
    } while (trim(line).empty());
    next.info.line = file().line_number();
    const std::optional<std::size_t> count = count_on(line);
    if (!count)
      file().fail(quote(line) + (found() == 0 ? "" : " behind a frame") +
                  ": XYZ needs the number of particles on this line");
    next.info.particles = *count;
    if (!file().next(line)) file().fail("the file ends where XYZ has a comment");
    read_comment(file(), line, next);
    if (next.info.columns.empty()) name_plain_columns(file(), next);
    frame_ = std::move(next);
    return true;
  }

  const ReadOptions* options_;
  XyzFrame frame_;
};

}  // namespace

bool is_xyz(TextFile& file) {
  const TextFile::Mark start = file.mark();
  std::string_view line;
  const bool counts = file.next(line) && count_on(line).has_value();
  file.go_to(start);
  return counts;
}

std::unique_ptr<FrameSource> xyz_frames(TextFile& file, const ReadOptions& options) {
  return std::make_unique<XyzFrames>(file, options);
}

}  // namespace recon::detail
