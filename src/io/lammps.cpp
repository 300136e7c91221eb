// LAMMPS text dumps (docs.lammps.org/dump.html). A frame is a series of sections "ITEM: <name>":
//
//   UNITS, TIME (both optional), TIMESTEP, NUMBER OF ATOMS, BOX BOUNDS <flags>, ATOMS <columns>
//
// of which ATOMS is the last. UNITS stands in the first frame only and holds for all.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "column_parser.hpp"
#include "formats.hpp"

namespace recon::detail {

namespace {

struct Frame {
  FrameInfo info;
  SimulationCell cell;
  Box<double> box;  // the same where it has no tilt
  bool orthogonal = true, has_box = false, has_count = false, has_flags = false;
  std::vector<std::string> remarks;
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
void read_flags(TextFile& file, std::span<const std::string_view> flags, Frame& frame) {
  constexpr const char* rule =
      "ITEM: BOX BOUNDS takes two boundary letters of p, f, s, m for each of three axes, "
      "like 'pp pp fm'";
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

using Bounds = std::array<std::array<double, 4>, max_dimension>;

// lower, upper of an orthogonal box.
void set_orthogonal(TextFile& file, const Bounds& bounds, Frame& frame) {
  for (int d = 0; d < max_dimension; ++d) {
    const double extent = bounds[d][1] - bounds[d][0];
    if (extent < 0 || (frame.periodic[d] && extent == 0) || !std::isfinite(extent))
      file.fail(file.line_number() - 2 + static_cast<std::size_t>(d),
                std::string("the box needs lower < upper along ") + "xyz"[d]);
    frame.cell.origin[d] = frame.box.lower[d] = bounds[d][0];
    frame.cell.edges[d][d] = extent;
    frame.box.upper[d] = bounds[d][1];
  }
}

// Of a restricted triclinic box: the lower and upper bounds of the box around it, and its tilts xy,
// xz, yz. The edges are (lx, 0, 0), (xy, ly, 0), (xz, yz, lz).
void set_restricted(TextFile& file, const Bounds& bounds, Frame& frame) {
  const double xy = bounds[0][2], xz = bounds[1][2], yz = bounds[2][2];
  Bounds inner = bounds;
  inner[0][0] -= std::min({0.0, xy, xz, xy + xz});
  inner[0][1] -= std::max({0.0, xy, xz, xy + xz});
  inner[1][0] -= std::min(0.0, yz);
  inner[1][1] -= std::max(0.0, yz);
  set_orthogonal(file, inner, frame);
  frame.orthogonal = xy == 0 && xz == 0 && yz == 0;
  frame.cell.edges[1][0] = xy;
  frame.cell.edges[2][0] = xz;
  frame.cell.edges[2][1] = yz;
}

// Of a general triclinic box: in each line one edge, and a coordinate of the corner.
void set_general(TextFile& file, const Bounds& bounds, Frame& frame) {
  frame.orthogonal = false;
  for (int e = 0; e < max_dimension; ++e) {
    std::copy_n(bounds[e].begin(), max_dimension, frame.cell.edges[e].begin());
    frame.cell.origin[e] = bounds[e][3];
    const double length = std::hypot(bounds[e][0], bounds[e][1], bounds[e][2]);
    if (!std::isfinite(length) || (frame.periodic[e] && length == 0))
      file.fail(file.line_number() - 2 + static_cast<std::size_t>(e),
                "an edge of a periodic box must have a length");
  }
}

void read_box(TextFile& file, std::span<const std::string_view> words, Frame& frame) {
  const bool restricted =
      words.size() >= 3 && words[0] == "xy" && words[1] == "xz" && words[2] == "yz";
  const bool general = words.size() >= 2 && words[0] == "abc" && words[1] == "origin";
  read_flags(file, words.subspan(restricted ? 3 : general ? 2 : 0), frame);
  std::size_t numbers = restricted ? 3 : general ? 4 : 2;
  Bounds bounds{};
  std::vector<std::string_view> cells;
  for (int d = 0; d < max_dimension; ++d) {
    split_at_blanks(section_line(file, "BOX BOUNDS"), cells);
    if (d == 0 && words.empty() && cells.size() == 3) numbers = 3;  // triclinic, of before 2010
    if (cells.size() != numbers)
      file.fail(numbers == 2   ? "ITEM: BOX BOUNDS needs two numbers, lower and upper"
                : numbers == 3 ? "ITEM: BOX BOUNDS needs three numbers: lower, upper, tilt"
                               : "ITEM: BOX BOUNDS abc origin needs four numbers: an edge of the "
                                 "box, and a coordinate of its corner");
    for (std::size_t i = 0; i < numbers; ++i)
      bounds[d][i] = read_finite(file, "BOX BOUNDS", cells[i]);
  }
  frame.cell = {};
  frame.box = Box<double>::empty(max_dimension);
  frame.orthogonal = true;
  if (numbers == 2) set_orthogonal(file, bounds, frame);
  if (numbers == 3) set_restricted(file, bounds, frame);
  if (numbers == 4) set_general(file, bounds, frame);
  frame.has_box = true;
}

void read_columns(TextFile& file, const std::vector<std::string_view>& words,
                  const std::vector<std::string>& names, Frame& frame) {
  if (!frame.info.step) file.fail("the frame has no ITEM: TIMESTEP before its atoms");
  if (!frame.has_count) file.fail("the frame has no ITEM: NUMBER OF ATOMS before its atoms");
  if (!frame.has_box) file.fail("the frame has no ITEM: BOX BOUNDS before its atoms");
  if (words.empty() && names.empty())
    file.fail(
        "ITEM: ATOMS names no columns (a dump of before 2010); name them on this line or by the "
        "option columns, the default then was: ITEM: ATOMS id type xs ys zs");
  if (!names.empty())
    frame.info.columns = names;
  else
    frame.info.columns = to_utf8({words.begin(), words.end()}, frame.remarks);
}

// Reads up to and including the line ITEM: ATOMS; false at the end of the file.
bool read_header(TextFile& file, const std::vector<std::string>& names, Frame& frame) {
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
      read_box(file, std::span(words).subspan(2), frame);
    } else if (words.size() >= 1 && words[0] == "ATOMS") {
      read_columns(file, {words.begin() + 1, words.end()}, names, frame);
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
  file.fail("the line has " + std::to_string(cells) + " cells, for " +
            std::to_string(frame.info.columns.size()) + " columns that are named");
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

// Scaled coordinates into lengths: (x, y, z) = origin + xs a + ys b + zs c with the edges a,
// b, c of the box, as columns of their own. Where an edge is needed whose coordinate is not
// there, none is.
void add_unscaled(ParticleTable& table, const SimulationCell& cell) {
  std::string done;
  const std::vector<std::string> repeated = table.repeated_names();
  const auto usable = [&](const std::string& name) {
    return table.has(name) && std::find(repeated.begin(), repeated.end(), name) == repeated.end();
  };
  for (const std::string suffix : {"s", "su"}) {
    for (int d = 0; d < max_dimension; ++d) {
      const std::string axis(1, "xyz"[d]), plain = suffix == "s" ? axis : axis + "u";
      if (!usable(axis + suffix) || table.has(plain)) continue;
      std::vector<double> values(table.size(), cell.origin[d]);
      std::string from;
      bool known = true;
      for (int e = 0; e < max_dimension; ++e) {
        const double edge = cell.edges[e][d];
        if (edge == 0 && e != d) continue;
        const std::string scaled = "xyz"[e] + suffix;
        known = known && usable(scaled);
        if (!known) break;
        const std::vector<double>& factor = table.raw_column(scaled);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] += factor[i] * edge;
        from += (from.empty() ? "" : " and ") + scaled;
      }
      if (!known) continue;
      table.add_column(plain, std::move(values));
      done += (done.empty() ? "" : ", ") + plain + " from " + from;
    }
  }
  if (!done.empty()) table.remarks.push_back("scaled by the box: " + done);
}

ParticleTable read_atoms(TextFile& file, const Frame& frame, const ReadOptions& options) {
  ColumnParser parser(file, frame.info.columns);
  parser.reserve(frame.info.particles / static_cast<std::size_t>(options.parts) + 1);
  std::vector<std::string_view> cells;
  for (std::size_t i = 0; i < frame.info.particles; ++i) {
    const std::string_view text = atom_line(file, frame, i);
    if (!options.takes(i) && file.line_is_closed()) continue;
    split_at_blanks(text, cells);
    require_cells(file, frame, cells.size());
    if (!options.takes(i)) continue;  // the last line of a file that may be cut
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
  return std::move(parser).finish(options.missing);
}

class LammpsFrames : public TextFrames {
 public:
  LammpsFrames(TextFile& file, const ReadOptions& options) : TextFrames(file), options_(&options) {}
  const FrameInfo& info() const override { return frame_.info; }
  bool is_series() const override { return true; }
  void skip() override { skip_atoms(file(), frame_); }

  ParticleTable read() override {
    ParticleTable table = read_atoms(file(), frame_, *options_);
    table.step = frame_.info.step;
    table.time = frame_.info.time;
    table.units = frame_.info.units;
    if (frame_.orthogonal)
      table.set_box(frame_.box, frame_.periodic);
    else
      table.set_cell(frame_.cell, frame_.periodic);
    add_unscaled(table, frame_.cell);
    table.remarks.insert(table.remarks.end(), frame_.remarks.begin(), frame_.remarks.end());
    if (!frame_.has_flags)
      table.remarks.push_back("ITEM: BOX BOUNDS has no boundary flags: taken as periodic nowhere");
    return table;
  }

 private:
  bool find() override {
    Frame next;
    next.info.units = frame_.info.units;
    if (!read_header(file(), options_->columns, next)) return false;
    frame_ = std::move(next);
    return true;
  }

  const ReadOptions* options_;
  Frame frame_;
};

}  // namespace

std::unique_ptr<FrameSource> lammps_frames(TextFile& file, const ReadOptions& options) {
  return std::make_unique<LammpsFrames>(file, options);
}

}  // namespace recon::detail
