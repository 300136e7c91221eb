// Delimited text with a line of column names.
#include <algorithm>
#include <deque>
#include <utility>

#include "column_parser.hpp"
#include "formats.hpp"

namespace recon::detail {

namespace {

constexpr const char* example =
    "; the line before the numbers must name the columns, for example: x,y,z,mass";

struct Cell {
  std::string_view text;
  bool quoted;
};

// Cells of a line; views into the line or, where "" stood for a quote, into `unescaped`.
class Splitter {
 public:
  explicit Splitter(const TextFile& file) : file_(&file) {}
  char delimiter = ' ';

  const std::vector<Cell>& split(std::string_view line) {
    cells_.clear();
    unescaped_.clear();
    const bool blanks = delimiter == ' ';
    std::size_t at = 0;
    for (;;) {
      while (at < line.size() && is_padding(line[at])) ++at;
      if (blanks && at == line.size()) return cells_;
      if (at < line.size() && line[at] == '"') {
        at = add_quoted(line, at);
      } else {
        const std::size_t end = std::min(
            line.size(), blanks ? line.find_first_of(" \t", at) : line.find(delimiter, at));
        cells_.push_back({trim(line.substr(at, end - at)), false});
        at = end;
      }
      if (blanks) continue;
      if (at == line.size()) return cells_;
      ++at;  // the delimiter
    }
  }

 private:
  bool is_padding(char c) const { return c == ' ' || (c == '\t' && delimiter != '\t'); }

  std::size_t add_quoted(std::string_view line, std::size_t begin) {
    std::size_t at = line.find('"', begin + 1);
    bool escaped = false;
    while (at != std::string_view::npos && at + 1 < line.size() && line[at + 1] == '"') {
      escaped = true;
      at = line.find('"', at + 2);
    }
    if (at == std::string_view::npos) file_->fail("a quoted cell does not end on this line");
    std::string_view text = line.substr(begin + 1, at - begin - 1);
    if (escaped) {
      std::string& plain = unescaped_.emplace_back();
      for (std::size_t i = 0; i < text.size(); ++i) {
        plain += text[i];
        if (text[i] == '"') ++i;
      }
      text = plain;
    }
    cells_.push_back({text, true});
    ++at;
    while (at < line.size() && is_padding(line[at])) ++at;
    const bool ends = at == line.size() || line[at] == delimiter || delimiter == ' ';
    if (!ends) file_->fail("after a quoted cell a delimiter or the end of the line must follow");
    return at;
  }

  const TextFile* file_;
  std::vector<Cell> cells_;
  std::deque<std::string> unescaped_;
};

// The strongest delimiter that stands outside quotes: semicolon, tab, comma, else blanks.
char find_delimiter(std::string_view line) {
  constexpr std::string_view delimiters = ";\t,";
  std::size_t best = delimiters.size();
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (!quoted) best = std::min(best, delimiters.find(c));
  }
  return best < delimiters.size() ? delimiters[best] : ' ';
}

bool looks_like_number(const Cell& cell) {
  return !cell.quoted && !cell.text.empty() &&
         std::string_view("+-.0123456789").find(cell.text[0]) != std::string_view::npos &&
         parse_number(cell.text).has_value();
}

bool has_number(const std::vector<Cell>& cells) {
  for (const Cell& cell : cells)
    if (looks_like_number(cell)) return true;
  return false;
}

struct Header {
  std::vector<std::string> names;
  std::size_t line = 0;
  TextFile::Mark rows{};  // where the rows begin
};

std::vector<std::string> names_of(const TextFile& file, const std::vector<Cell>& cells) {
  std::vector<std::string> names;
  for (const Cell& cell : cells) {
    for (const char c : cell.text)
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
        file.fail("a column name holds a control character: " + quote(cell.text));
    names.push_back(cell.text.empty() ? "column_" + std::to_string(names.size() + 1)
                                      : std::string(cell.text));
  }
  return names;
}

// The first line that is no comment names the columns or, where it is a row of numbers, the comment
// right before it does.
Header read_header(TextFile& file, Splitter& splitter) {
  std::string comment;
  std::size_t comment_line = 0;
  std::string_view line;
  TextFile::Mark before = file.mark();
  for (;; before = file.mark()) {
    if (!file.next(line)) file.fail(std::string("the file ends without a header line") + example);
    const std::string_view text = trim(line);
    if (text.empty()) continue;
    if (text[0] != '#') break;
    comment = text.substr(std::min(text.size(), text.find_first_not_of('#')));
    comment_line = file.line_number();
  }
  if (line.starts_with("LAMMPS"))
    file.fail("this looks like a LAMMPS data file; write a dump (write_dump) instead");

  Header header;
  splitter.delimiter = find_delimiter(line);
  const std::vector<Cell> first = splitter.split(line);
  if (!has_number(first)) {
    header.names = names_of(file, first);
    header.line = file.line_number();
    header.rows = file.mark();
    return header;
  }
  const std::size_t count = first.size();
  const std::string number(first.front().text);
  const std::vector<Cell>& names = splitter.split(comment);
  if (trim(comment).empty() || has_number(names) || names.size() != count)
    file.fail(quote(number) + " stands where the header line must be" + example);
  header.names = names_of(file, names);
  header.line = comment_line;
  header.rows = before;
  return header;
}

// Calls row(cells) for each row.
template <class Row>
void for_each_row(TextFile& file, Splitter& splitter, const Header& header, Row&& row) {
  file.go_to(header.rows);
  std::string_view line;
  while (file.next(line)) {
    const std::string_view text = trim(line);
    if (text.empty() || text[0] == '#') continue;
    const std::vector<Cell>& cells = splitter.split(line);
    if (cells.size() != header.names.size())
      file.fail("the line has " + std::to_string(cells.size()) + " cells, the header (line " +
                std::to_string(header.line) + ") names " + std::to_string(header.names.size()) +
                " columns");
    row(cells);
  }
}

}  // namespace

bool DelimitedFrame::next() {
  return !std::exchange(done_, true);
}

void DelimitedFrame::skip() {
  Splitter splitter(*file_);
  const Header header = read_header(*file_, splitter);
  const ColumnParser parser(*file_, header.names);  // checks the names
  info_.columns = header.names;
  info_.line = header.line;
  for_each_row(*file_, splitter, header, [&](const auto&) { ++info_.particles; });
}

ParticleTable DelimitedFrame::read() {
  Splitter splitter(*file_);
  const Header header = read_header(*file_, splitter);
  info_.columns = header.names;
  info_.line = header.line;
  ColumnParser parser(*file_, header.names);
  for_each_row(*file_, splitter, header, [&](const std::vector<Cell>& cells) {
    for (std::size_t c = 0; c < cells.size(); ++c) parser.add_cell(c, cells[c].text);
    parser.end_row();
  });
  ParticleTable table = std::move(parser).finish();
  info_.particles = table.size();
  return table;
}

}  // namespace recon::detail
