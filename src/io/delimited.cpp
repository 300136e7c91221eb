// Delimited text with a line of column names.
#include <algorithm>
#include <array>
#include <deque>
#include <utility>

#include "column_parser.hpp"
#include "formats.hpp"
#include "recon/fields/utf8.hpp"

namespace recon::detail {

namespace {

constexpr const char* example =
    "; the line before the numbers must name the columns, for example x,y,z,mass, or the option "
    "columns must";

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

bool is_comment(std::string_view text) {
  return text[0] == '#' || text[0] == '%';
}

// The next line that is neither blank nor a comment; false at the end of the file.
bool next_row(TextFile& file, std::string_view& line) {
  while (file.next(line)) {
    const std::string_view text = trim(line);
    if (!text.empty() && !is_comment(text)) return true;
  }
  return false;
}

struct Header {
  std::vector<std::string> names;
  std::size_t line = 0;   // 0 where the names are not from the file
  TextFile::Mark rows{};  // where the rows begin
  std::vector<std::string> remarks;
};

std::vector<std::string> names_of(const TextFile& file, const std::vector<Cell>& cells,
                                  std::vector<std::string>& remarks) {
  std::vector<std::string> names;
  for (const Cell& cell : cells) {
    for (const char c : cell.text)
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
        file.fail("a column name holds a control character: " + quote(cell.text));
    names.push_back(cell.text.empty() ? "column_" + std::to_string(names.size() + 1)
                                      : std::string(cell.text));
  }
  return to_utf8(names, remarks);
}

// Do these cells say that no cell has a value, rather than in which unit they are?
bool are_gaps(const std::vector<Cell>& cells, const std::vector<std::string>& missing) {
  constexpr std::array<std::string_view, 9> gaps{"",     "NA",   "N/A", "na", "null",
                                                 "NULL", "None", "-",   "?"};
  return std::all_of(cells.begin(), cells.end(), [&](const Cell& cell) {
    return std::find(gaps.begin(), gaps.end(), cell.text) != gaps.end() ||
           std::find(missing.begin(), missing.end(), cell.text) != missing.end();
  });
}

// A first row without a number, before one that has some, is no particle: it holds units.
void pass_over_units(TextFile& file, Splitter& splitter, const ReadOptions& options,
                     Header& header) {
  const auto no_number = [](const std::vector<Cell>& cells) {
    return std::none_of(cells.begin(), cells.end(),
                        [](const Cell& cell) { return parse_number(cell.text).has_value(); });
  };
  file.go_to(header.rows);
  std::string_view line;
  if (!next_row(file, line)) return;
  const std::vector<Cell>& units = splitter.split(line);
  if (units.size() != header.names.size() || !no_number(units) || are_gaps(units, options.missing))
    return;
  std::string text =
      "line " + std::to_string(file.line_number()) + " holds no number and is taken for units: ";
  for (std::size_t c = 0; c < units.size() && text.size() < 200; ++c)
    text += (c > 0 ? ", " : "") + header.names[c] + " [" + recon::to_utf8(units[c].text) + "]";
  const TextFile::Mark behind = file.mark();
  if (!next_row(file, line) || no_number(splitter.split(line))) return;
  header.remarks.push_back(text);
  header.rows = behind;
}

// The first line that is no comment names the columns or, where it is a row of numbers, the comment
// right before it does.
Header read_header(TextFile& file, Splitter& splitter, const ReadOptions& options) {
  std::string comment;
  std::size_t comment_line = 0;
  std::string_view line;
  TextFile::Mark before = file.mark();
  for (;; before = file.mark()) {
    if (!file.next(line)) file.fail(std::string("the file ends without a header line") + example);
    const std::string_view text = trim(line);
    if (text.empty()) continue;
    if (!is_comment(text)) break;
    comment = text.substr(std::min(text.size(), text.find_first_not_of("#%")));
    comment_line = file.line_number();
  }
  if (line.starts_with("LAMMPS"))
    file.fail("this looks like a LAMMPS data file; write a dump (write_dump) instead");

  Header header;
  splitter.delimiter = find_delimiter(line);
  if (!options.columns.empty()) {
    header.names = options.columns;
    header.rows = before;
    return header;
  }
  const std::vector<Cell> first = splitter.split(line);
  if (!has_number(first)) {
    header.names = names_of(file, first, header.remarks);
    header.line = file.line_number();
    header.rows = file.mark();
    return header;
  }
  const std::size_t count = first.size();
  const std::string number(first.front().text);
  const std::vector<Cell>& names = splitter.split(comment);
  if (trim(comment).empty() || has_number(names) || names.size() != count)
    file.fail(quote(number) + " stands where the header line must be" + example);
  header.names = names_of(file, names, header.remarks);
  header.line = comment_line;
  header.rows = before;
  return header;
}

// Calls begin(header) and then row(cells) for each row.
template <class Begin, class Row>
Header for_each_row(TextFile& file, const ReadOptions& options, const Begin& begin,
                    const Row& row) {
  Splitter splitter(file);
  Header header = read_header(file, splitter, options);
  pass_over_units(file, splitter, options, header);
  file.go_to(header.rows);
  begin(header);
  std::string_view line;
  while (next_row(file, line)) {
    const std::vector<Cell>& cells = splitter.split(line);
    if (cells.size() != header.names.size())
      file.fail("the line has " + std::to_string(cells.size()) + " cells, the " +
                (header.line > 0 ? "header (line " + std::to_string(header.line) + ") names "
                                 : std::string("option columns names ")) +
                std::to_string(header.names.size()) + " columns");
    row(cells);
  }
  return header;
}

class DelimitedFrame : public TextFrames {
 public:
  DelimitedFrame(TextFile& file, const ReadOptions& options)
      : TextFrames(file), options_(&options) {}
  const FrameInfo& info() const override { return info_; }
  bool is_series() const override { return false; }

  void skip() override {
    for_each_row(
        file(), *options_, [&](const Header& header) { note(header); },
        [&](const auto&) { ++info_.particles; });
  }

  ParticleTable read() override {
    std::optional<ColumnParser> parser;
    std::size_t rows = 0;
    const Header header = for_each_row(
        file(), *options_,
        [&](const Header& begun) {
          note(begun);
          parser.emplace(file(), begun.names);
        },
        [&](const std::vector<Cell>& cells) {
          if (!options_->takes(rows++)) return;
          for (std::size_t c = 0; c < cells.size(); ++c) parser->add_cell(c, cells[c].text);
          parser->end_row();
        });
    ParticleTable table = std::move(*parser).finish(options_->missing);
    table.remarks.insert(table.remarks.end(), header.remarks.begin(), header.remarks.end());
    info_.particles = rows;
    return table;
  }

 private:
  bool find() override {
    info_ = {};
    return found() == 0;
  }
  void note(const Header& header) {
    info_.columns = header.names;
    info_.line = header.line;
  }

  const ReadOptions* options_;
  FrameInfo info_;
};

}  // namespace

std::unique_ptr<FrameSource> delimited_frame(TextFile& file, const ReadOptions& options) {
  return std::make_unique<DelimitedFrame>(file, options);
}

}  // namespace recon::detail
