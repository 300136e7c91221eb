// LAMMPS text dumps (docs.lammps.org/dump.html). A frame is a series of sections "ITEM: <name>":
//
//   UNITS, TIME (both optional), TIMESTEP, NUMBER OF ATOMS, BOX BOUNDS <flags>, ATOMS <columns>
//
// of which ATOMS is the last. UNITS stands in the first frame only and holds for all.
#include <algorithm>
#include <array>
#include <cmath>

#include "column_parser.hpp"
#include "formats.hpp"

namespace recon::detail {

namespace {

struct Frame {
  FrameInfo info;
  Box<double> box;
  bool has_box = false, has_count = false, has_flags = false;
  std::array<bool, max_dimension> periodic{};
};

bool is_item(std::string_view line) {
  return line.starts_with("ITEM:");
}

std::string_view section_line(TextFile& file, const std::string& section) {
  std::string_view line;
  if (!file.next(line)) file.fail("the file ends where ITEM: " + section + " needs a line");
  if (is_item(line)) file.fail("ITEM: " + section + " needs a line before the next ITEM:");
  return trim(line);
}

std::int64_t read_integer(TextFile& file, const std::string& section) {
  const std::string_view text = section_line(file, section);
  const std::optional<std::int64_t> value = parse_integer(text);
  if (!value) file.fail(quote(text) + " is no whole number: ITEM: " + section + " needs one");
  return *value;
}

double read_finite(TextFile& file, const std::string& section, std::string_view text) {
  const std::optional<double> value = parse_number(text);
  if (!value || !std::isfinite(*value))
    file.fail(quote(text) + " is no finite number: ITEM: " + section + " needs one");
  return *value;
}

// Boundary flags, two letters an axis: p periodic, f fixed, s shrink-wrapped, m shrink-wrapped with
// a minimum. Dumps of before 2010 have none.
void read_flags(TextFile& file, const std::vector<std::string_view>& flags, Frame& frame) {
  constexpr const char* rule =
      "ITEM: BOX BOUNDS takes two boundary letters of p, f, s, m for each of three axes, "
      "like 'pp pp fm'";
  for (const std::string_view flag : flags)
    if (flag == "xy" || flag == "xz" || flag == "yz" || flag == "abc" || flag == "origin")
      file.fail("the box is triclinic; recon reads orthogonal boxes only");
  if (flags.empty()) return;
  if (flags.size() != max_dimension) file.fail(rule);
  for (std::size_t d = 0; d < max_dimension; ++d) {
    const std::string_view flag = flags[d];
    const bool known = flag.size() == 2 &&
                       flag.find_first_not_of("pfsm") == std::string_view::npos &&
                       (flag[0] == 'p') == (flag[1] == 'p');
    if (!known) file.fail(quote(flag) + " is no boundary: " + rule);
    frame.periodic[d] = flag[0] == 'p';
  }
  frame.has_flags = true;
}

void read_box(TextFile& file, const std::vector<std::string_view>& flags, Frame& frame) {
  read_flags(file, flags, frame);
  frame.box = Box<double>::empty(max_dimension);
  std::vector<std::string_view> cells;
  for (int d = 0; d < max_dimension; ++d) {
    split_at_blanks(section_line(file, "BOX BOUNDS"), cells);
    if (cells.size() == 3)
      file.fail("three numbers mean a triclinic box; recon reads orthogonal boxes only");
    if (cells.size() != 2) file.fail("ITEM: BOX BOUNDS needs two numbers, lower and upper");
    frame.box.lower[d] = read_finite(file, "BOX BOUNDS", cells[0]);
    frame.box.upper[d] = read_finite(file, "BOX BOUNDS", cells[1]);
    const double extent = frame.box.extent(d);
    if (extent < 0 || (frame.periodic[d] && extent == 0) || !std::isfinite(extent))
      file.fail(std::string("the box needs lower < upper along ") + "xyz"[d]);
  }
  frame.has_box = true;
}

void read_columns(TextFile& file, const std::vector<std::string_view>& words, Frame& frame) {
  if (!frame.info.step) file.fail("the frame has no ITEM: TIMESTEP before its atoms");
  if (!frame.has_count) file.fail("the frame has no ITEM: NUMBER OF ATOMS before its atoms");
  if (!frame.has_box) file.fail("the frame has no ITEM: BOX BOUNDS before its atoms");
  if (words.empty())
    file.fail(
        "ITEM: ATOMS names no columns (a dump of before 2010); name them on this line, the default "
        "then was: ITEM: ATOMS id type xs ys zs");
  frame.info.columns.assign(words.begin(), words.end());
}

// Reads up to and including the line ITEM: ATOMS; false at the end of the file.
bool read_header(TextFile& file, Frame& frame) {
  std::string_view line;
  do {
    if (!file.next(line)) return false;
  } while (trim(line).empty());
  frame.info.line = file.line_number();
  std::vector<std::string_view> words;
  for (;;) {
    if (!is_item(line))
      file.fail(quote(line) +
                " where a line ITEM: was expected (does ITEM: NUMBER OF ATOMS hold?)");
    const std::string section(trim(line.substr(5)));
    split_at_blanks(section, words);
    if (section == "TIMESTEP") {
      frame.info.step = read_integer(file, section);
    } else if (section == "TIME") {
      frame.info.time = read_finite(file, section, section_line(file, section));
    } else if (section == "UNITS") {
      frame.info.units = section_line(file, section);
    } else if (section == "NUMBER OF ATOMS") {
      const std::int64_t count = read_integer(file, section);
      if (count < 0) file.fail(std::to_string(count) + " atoms: the number must not be negative");
      frame.info.particles = static_cast<std::size_t>(count);
      frame.has_count = true;
    } else if (section.starts_with("BOX BOUNDS")) {
      read_box(file, {words.begin() + 2, words.end()}, frame);
    } else if (words.size() >= 1 && words[0] == "ATOMS") {
      read_columns(file, {words.begin() + 1, words.end()}, frame);
      return true;
    } else {
      file.fail("ITEM: " + quote(section) +
                " is not known: a dump of atoms has UNITS, TIME, TIMESTEP, NUMBER OF ATOMS, BOX "
                "BOUNDS and ATOMS");
    }
    if (!file.next(line)) file.fail("the file ends in the header of a frame, before ITEM: ATOMS");
  }
}

// The next line of atoms, of which `done` were there before.
std::string_view atom_line(TextFile& file, const Frame& frame, std::size_t done) {
  std::string_view line;
  const auto promised = [&] {
    return std::to_string(done) + " of the " + std::to_string(frame.info.particles) +
           " atoms of the frame at line " + std::to_string(frame.info.line);
  };
  if (!file.next(line)) file.fail("the file ends after " + promised());
  if (is_item(line)) file.fail("a new section begins after " + promised());
  return line;
}

void require_cells(const TextFile& file, const Frame& frame, std::size_t cells) {
  if (cells == frame.info.columns.size()) return;
  file.fail("the line has " + std::to_string(cells) + " cells, ITEM: ATOMS names " +
            std::to_string(frame.info.columns.size()) + " columns");
}

void skip_atoms(TextFile& file, const Frame& frame) {
  std::vector<std::string_view> cells;
  for (std::size_t i = 0; i < frame.info.particles; ++i) {
    const std::string_view line = atom_line(file, frame, i);
    if (file.line_is_closed()) continue;
    split_at_blanks(line, cells);  // the last line of a file that may be cut
    require_cells(file, frame, cells.size());
  }
}

// x = lower + xs (upper - lower), as a column of its own.
void add_unscaled(ParticleTable& table, const Box<double>& box) {
  std::string done;
  for (const std::string suffix : {"s", "su"}) {
    for (int d = 0; d < max_dimension; ++d) {
      const std::string axis(1, "xyz"[d]), scaled = axis + suffix;
      const std::string plain = suffix == "s" ? axis : axis + "u";
      if (!table.has(scaled) || table.has(plain)) continue;
      std::vector<double> values = table.raw_column(scaled);
      for (double& value : values) value = box.lower[d] + value * box.extent(d);
      table.add_column(plain, std::move(values));
      done += (done.empty() ? "" : ", ") + plain + " from " + scaled;
    }
  }
  if (!done.empty()) table.remarks.push_back("scaled by the box: " + done);
}

ParticleTable read_atoms(TextFile& file, const Frame& frame) {
  ColumnParser parser(file, frame.info.columns);
  parser.reserve(frame.info.particles);
  std::vector<std::string_view> cells;
  for (std::size_t i = 0; i < frame.info.particles; ++i) {
    split_at_blanks(atom_line(file, frame, i), cells);
    require_cells(file, frame, cells.size());
    for (std::size_t c = 0; c < cells.size(); ++c) parser.add_cell(c, cells[c]);
    parser.end_row();
  }
  const TextFile::Mark behind = file.mark();
  std::string_view line;
  while (file.next(line)) {
    if (trim(line).empty()) continue;
    const bool cut_item = !file.line_is_closed() && std::string_view("ITEM:").starts_with(line);
    if (!is_item(line) && !cut_item)
      file.fail("the frame goes on after its " + std::to_string(frame.info.particles) +
                " atoms; a line ITEM: was expected");
    break;
  }
  file.go_to(behind);
  return std::move(parser).finish();
}

}  // namespace

struct LammpsFrames::Header : Frame {};

LammpsFrames::LammpsFrames(TextFile& file) : file_(&file), header_(new Header) {}
LammpsFrames::~LammpsFrames() = default;

bool LammpsFrames::next() {
  auto header = std::make_unique<Header>();
  header->info.units = header_->info.units;
  if (!read_header(*file_, *header)) return false;
  header_ = std::move(header);
  return true;
}

const FrameInfo& LammpsFrames::info() const {
  return header_->info;
}

void LammpsFrames::skip() {
  skip_atoms(*file_, *header_);
}

ParticleTable LammpsFrames::read() {
  const Frame& frame = *header_;
  ParticleTable table = read_atoms(*file_, frame);
  table.step = frame.info.step;
  table.time = frame.info.time;
  table.units = frame.info.units;
  table.set_box(frame.box, frame.periodic);
  add_unscaled(table, frame.box);
  if (!frame.has_flags)
    table.remarks.push_back("ITEM: BOX BOUNDS has no boundary flags: taken as periodic nowhere");
  return table;
}

}  // namespace recon::detail
