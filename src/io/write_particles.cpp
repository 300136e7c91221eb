#include "recon/io/write_particles.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/lower_case.hpp"
#include "csv_text.hpp"
#include "formats.hpp"
#include "h5md_file.hpp"
#include "number_text.hpp"
#include "read_array.hpp"
#include "recon/core/error.hpp"
#include "recon/core/names.hpp"
#include "recon/fields/utf8.hpp"
#include "recon/io/atomic_file.hpp"
#include "recon/io/write.hpp"
#include "recon/points/make_view.hpp"

namespace recon {

namespace fs = std::filesystem;
using detail::append_number;
using detail::ReadArray;
using detail::require;

// What all formats are asked for.
class ParticleWriter::Format {
 public:
  explicit Format(const fs::path& path) : path_(path) {}
  virtual ~Format() = default;
  virtual void add(const ParticleTable& table) = 0;
  virtual void commit() = 0;
  std::size_t frames = 0;
  std::vector<std::string> notes;

  static std::unique_ptr<Format> make(const fs::path& path, ParticleFormat format);

 protected:
  void note(const std::string& text) {
    if (std::find(notes.begin(), notes.end(), text) == notes.end()) notes.push_back(text);
  }
  void note_repeated(const ParticleTable& table) {
    for (const std::string& name : table.repeated_names())
      note("left out: " + name + ", the name of several columns");
  }
  // The columns that are no coordinates, numbers and, if `texts`, texts.
  std::vector<std::string> others(const ParticleTable& table, bool texts) {
    std::vector<std::string> names;
    const std::vector<std::string> axes = table.all_coordinates();
    const std::vector<std::string> holding_text = table.text_columns();
    for (const std::string& name : table.all_names()) {
      if (std::find(axes.begin(), axes.end(), name) != axes.end()) continue;
      const bool is_text =
          std::find(holding_text.begin(), holding_text.end(), name) != holding_text.end();
      if (is_text && !texts)
        note("left out: " + name + ", which holds texts");
      else
        names.push_back(name);
    }
    note_repeated(table);
    return names;
  }
  fs::path path_;
};

namespace {

// Where the particles are in space: 0 along an axis that has no column.
std::vector<double> positions_of(const ParticleTable& table) {
  const std::vector<std::string> names = table.all_coordinates();
  std::vector<double> positions(table.size() * max_dimension, 0.0);
  std::array<bool, max_dimension> taken{};
  for (std::size_t d = 0; d < names.size(); ++d) {
    int axis = axis_of_coordinate(names[d]).value_or(static_cast<int>(d));
    if (taken[axis]) axis = static_cast<int>(d);
    taken[axis] = true;
    const std::vector<double>& values = table.column(names[d]);
    for (std::size_t i = 0; i < values.size(); ++i)
      positions[i * max_dimension + static_cast<std::size_t>(axis)] = values[i];
  }
  return positions;
}

// Without blanks, where these part cells.
std::string as_word(std::string_view text, std::string_view also = "") {
  std::string word(text);
  for (char& c : word)
    if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || also.find(c) != std::string_view::npos)
      c = '_';
  return word.empty() ? "NA" : word;
}

void append_real(std::string& line, double value) {
  if (std::isnan(value))
    line += "nan";
  else
    append_number(line, value);
}

// Columns of a table, row by row.
class Cells {
 public:
  void add(const ParticleTable& table, const std::string& name) {
    numbers_.push_back(&table.raw_column(name));
    texts_.push_back(&table.texts(name));
  }
  std::size_t count() const { return numbers_.size(); }
  // Appends what stands in a column: a number, or a text as `as_cell` makes a cell of it.
  template <class AsCell>
  void append(std::string& line, std::size_t row, std::size_t column, const AsCell& as_cell) const {
    if (const auto text = texts_[column]->at(static_cast<std::uint32_t>(row)))
      line += as_cell(*text);
    else
      append_real(line, (*numbers_[column])[row]);
  }
  // Appends a whole row.
  template <class AsCell>
  void append(std::string& line, std::size_t row, char between, const AsCell& as_cell) const {
    for (std::size_t c = 0; c < count(); ++c) {
      if (c > 0) line += between;
      append(line, row, c, as_cell);
    }
  }

 private:
  std::vector<const std::vector<double>*> numbers_;
  std::vector<const TextCells*> texts_;
};

std::string as_plain_word(std::string_view text) {
  return as_word(text);
}

// --- CSV -----------------------------------------------------------------------------------------

class CsvParticles : public ParticleWriter::Format {
 public:
  explicit CsvParticles(const fs::path& path) : Format(path), file_(path) {}

  void add(const ParticleTable& table) override {
    const std::vector<std::string> names = table.all_names();
    note_repeated(table);
    std::string line;
    Cells cells;
    for (const std::string& name : names) {
      line += (line.empty() ? "" : ",") + detail::csv_name(name);
      cells.add(table, name);
    }
    file_.write(line + "\n");
    for (std::size_t i = 0; i < table.size(); ++i) {
      line.clear();
      cells.append(line, i, ',', detail::csv_text);
      file_.write(line += '\n');
    }
  }
  void commit() override { file_.commit(); }

 private:
  AtomicFile file_;
};

// --- VTP -----------------------------------------------------------------------------------------

class VtpParticles : public ParticleWriter::Format {
 public:
  explicit VtpParticles(const fs::path& path) : Format(path) { const AtomicFile probe(path); }

  void add(const ParticleTable& table) override {
    const std::vector<double> positions = positions_of(table);
    FieldSet fields;
    fields.step = table.step;
    fields.time = table.time;
    for (ReadArray& array : detail::arrays_of(table, others(table, false))) {
      constexpr double most = 2147483647;
      const bool small = std::all_of(array.values.begin(), array.values.end(),
                                     [](double value) { return std::abs(value) <= most; });
      fields.add(to_utf8(array.name), array.components, std::move(array.values),
                 array.whole && small ? NumberType::int32 : NumberType::float64);
    }
    write_vtp(path_, points_of_flat(positions, max_dimension), fields);
  }
  void commit() override {}
};

// --- extended XYZ --------------------------------------------------------------------------------

class XyzParticles : public ParticleWriter::Format {
 public:
  explicit XyzParticles(const fs::path& path) : Format(path), file_(path) {}

  void add(const ParticleTable& table) override {
    const std::vector<double> positions = positions_of(table);
    std::vector<std::string> names = others(table, true);
    const std::string species = species_of(names);
    if (species != "type") std::erase(names, species);  // types stay numbers, too
    const std::vector<std::string> texts = table.text_columns();
    std::vector<std::string> words, numbers;
    for (const std::string& name : names)
      (std::find(texts.begin(), texts.end(), name) != texts.end() ? words : numbers)
          .push_back(name);
    const std::vector<ReadArray> arrays = detail::arrays_of(table, numbers);

    Cells kind, cells;
    if (!species.empty()) kind.add(table, species);
    for (const std::string& word : words) cells.add(table, word);
    std::string text = std::to_string(table.size()) + "\n" + comment(table, words, arrays) + "\n";
    for (std::size_t i = 0; i < table.size(); ++i) {
      if (species.empty()) text += 'X';
      kind.append(text, i, ' ', as_plain_word);
      for (std::size_t d = 0; d < max_dimension; ++d)
        append(text, positions[i * max_dimension + d]);
      for (std::size_t c = 0; c < cells.count(); ++c) {
        text += ' ';
        cells.append(text, i, c, as_plain_word);
      }
      for (const ReadArray& array : arrays) {
        const auto count = static_cast<std::size_t>(array.components);
        for (std::size_t c = 0; c < count; ++c) append(text, array.values[i * count + c]);
      }
      file_.write(text += '\n');
      text.clear();
    }
    file_.write(text);
  }
  void commit() override { file_.commit(); }

 private:
  static std::string species_of(const std::vector<std::string>& names) {
    for (const char* name : {"element", "species", "type"})
      if (std::find(names.begin(), names.end(), name) != names.end()) return name;
    return "";
  }
  static void append(std::string& text, double value) {
    text += ' ';
    append_real(text, value);
  }
  std::string named(const std::string& name) {
    std::string word = as_word(name, ":\"'={}");
    if (word != name) note("renamed: " + name + " to " + word);
    return word;
  }

  std::string comment(const ParticleTable& table, const std::vector<std::string>& words,
                      const std::vector<ReadArray>& arrays) {
    std::string line;
    const std::array<bool, max_dimension> periodic = table.periodic_edges();
    if (const std::optional<SimulationCell> cell = table.source_cell()) {
      line += "Lattice=\"";
      for (int i = 0; i < max_dimension * max_dimension; ++i) {
        if (i > 0) line += ' ';
        append_number(line, cell->edges[i / max_dimension][i % max_dimension]);
      }
      line += "\" ";
      if (cell->origin != std::array<double, max_dimension>{}) {
        line += "Origin=\"";
        for (int d = 0; d < max_dimension; ++d) {
          if (d > 0) line += ' ';
          append_number(line, cell->origin[d]);
        }
        line += "\" ";
      }
    }
    line += std::string("pbc=\"") + (periodic[0] ? "T " : "F ") + (periodic[1] ? "T " : "F ") +
            (periodic[2] ? "T" : "F") + "\" Properties=species:S:1:pos:R:3";
    for (const std::string& word : words) line += ":" + named(word) + ":S:1";
    for (const ReadArray& array : arrays)
      line += ":" + named(array.name) + (array.whole ? ":I:" : ":R:") +
              std::to_string(array.components);
    if (table.step) line += " Step=" + std::to_string(*table.step);
    if (table.time) {
      line += " Time=";
      append_number(line, *table.time);
    }
    return line;
  }

  AtomicFile file_;
};

// --- LAMMPS dumps --------------------------------------------------------------------------------

class DumpParticles : public ParticleWriter::Format {
 public:
  explicit DumpParticles(const fs::path& path) : Format(path), file_(path) {}

  void add(const ParticleTable& table) override {
    const std::vector<std::string> names = table.all_names();
    note_repeated(table);
    const std::vector<std::string> axes = table.all_coordinates();
    for (const std::string& axis : axes) table.column(axis);  // throws for what is no coordinate
    const auto in_dump = [&](const std::string& name) {
      const auto at = std::find(axes.begin(), axes.end(), name);
      const bool known = name.size() <= 2 && axis_of_coordinate(name).has_value();
      if (at == axes.end() || known) return as_word(name);
      const int place = static_cast<int>(at - axes.begin());
      return std::string(1, "xyz"[axis_of_coordinate(name).value_or(place)]);
    };
    std::string text;
    if (frames == 0 && !table.units.empty()) text += "ITEM: UNITS\n" + as_word(table.units) + "\n";
    if (table.time) {
      text += "ITEM: TIME\n";
      append_number(text, *table.time);
      text += '\n';
    }
    text += "ITEM: TIMESTEP\n" +
            std::to_string(table.step.value_or(static_cast<std::int64_t>(frames))) +
            "\nITEM: NUMBER OF ATOMS\n" + std::to_string(table.size()) + "\n" + box(table) +
            "ITEM: ATOMS";
    Cells cells;
    for (const std::string& name : names) {
      const std::string word = in_dump(name);
      if (word != name) note("renamed: " + name + " to " + word);
      text += ' ' + word;
      cells.add(table, name);
    }
    file_.write(text += '\n');
    for (std::size_t i = 0; i < table.size(); ++i) {
      text.clear();
      cells.append(text, i, ' ', as_plain_word);
      file_.write(text += '\n');
    }
  }
  void commit() override { file_.commit(); }

 private:
  // A table without a box gets one around the particles, shrink-wrapped.
  std::string box(const ParticleTable& table) {
    std::array<bool, max_dimension> periodic = table.periodic_edges();
    std::optional<SimulationCell> cell = table.source_cell();
    const std::string flags = cell ? flags_of(periodic) : " ss ss ss";
    if (!cell) {
      const std::vector<double> positions = positions_of(table);
      cell.emplace();
      if (table.size() > 0) {
        const Box<double> around = bounding_box(points_of_flat(positions, max_dimension));
        for (int d = 0; d < max_dimension; ++d) {
          cell->origin[d] = around.lower[d];
          cell->edges[d][d] = around.extent(d);
        }
      }
    }
    std::string text;
    const auto& e = cell->edges;
    bool restricted = true;
    for (int i = 0; i < max_dimension; ++i)
      for (int d = i; d < max_dimension; ++d)
        restricted = restricted && (d > i ? e[i][d] == 0 : e[i][d] > 0);
    if (detail::is_orthogonal(*cell)) {
      text = "ITEM: BOX BOUNDS" + flags + "\n";
      for (int d = 0; d < max_dimension; ++d)
        add_line(text, {cell->origin[d], cell->origin[d] + e[d][d]});
    } else if (restricted) {
      const double xy = e[1][0], xz = e[2][0], yz = e[2][1];
      text = "ITEM: BOX BOUNDS xy xz yz" + flags + "\n";
      add_line(text, {cell->origin[0] + std::min({0.0, xy, xz, xy + xz}),
                      cell->origin[0] + e[0][0] + std::max({0.0, xy, xz, xy + xz}), xy});
      add_line(text, {cell->origin[1] + std::min(0.0, yz),
                      cell->origin[1] + e[1][1] + std::max(0.0, yz), xz});
      add_line(text, {cell->origin[2], cell->origin[2] + e[2][2], yz});
    } else {
      text = "ITEM: BOX BOUNDS abc origin" + flags + "\n";
      for (int i = 0; i < max_dimension; ++i)
        add_line(text, {e[i][0], e[i][1], e[i][2], cell->origin[i]});
    }
    return text;
  }
  static std::string flags_of(const std::array<bool, max_dimension>& periodic) {
    std::string text;
    for (const bool each : periodic) text += each ? " pp" : " ff";
    return text;
  }
  static void add_line(std::string& text, std::initializer_list<double> numbers) {
    const char* blank = "";
    for (const double number : numbers) {
      text += blank;
      append_number(text, number);
      blank = " ";
    }
    text += '\n';
  }

  AtomicFile file_;
};

// --- H5MD ----------------------------------------------------------------------------------------

class H5mdParticles : public ParticleWriter::Format {
 public:
  explicit H5mdParticles(const fs::path& path) : Format(path), file_(path) {}

  void add(const ParticleTable& table) override {
    detail::H5mdFrame frame;
    frame.step = table.step.value_or(static_cast<std::int64_t>(frames));
    frame.time = table.time;
    frame.cell = table.source_cell();
    frame.periodic = table.periodic_edges();
    frame.arrays.push_back({"position", max_dimension, positions_of(table), {}});
    for (ReadArray& array : detail::arrays_of(table, others(table, false))) {
      for (char& c : array.name)
        if (c == '/') c = '_';
      if (array.name == "box" || array.name == "position" || array.name == ".") array.name += "_";
      frame.arrays.push_back(std::move(array));
    }
    if (!frames_.empty()) require_like_first(frame);
    frames_.push_back(std::move(frame));
  }
  void commit() override {
    file_.write(detail::h5md_image(path_, frames_));
    file_.commit();
  }

 private:
  void require_like_first(detail::H5mdFrame& frame) const {
    const detail::H5mdFrame& first = frames_.front();
    require(frame.arrays[0].values.size() == first.arrays[0].values.size(), "number of particles",
            frame.arrays[0].values.size() / max_dimension,
            "must be that of the first frame in H5MD");
    require(frame.cell.has_value() == first.cell.has_value() && frame.periodic == first.periodic,
            "box of a frame", "another",
            "must be there, and periodic, as in the first frame in H5MD");
    require(frame.arrays.size() == first.arrays.size(), "number of columns", frame.arrays.size(),
            "must be that of the first frame in H5MD");
    for (std::size_t a = 0; a < frame.arrays.size(); ++a)
      require(frame.arrays[a].name == first.arrays[a].name &&
                  frame.arrays[a].components == first.arrays[a].components,
              "column", frame.arrays[a].name,
              "must stand in the first frame, too, and in the same place, in H5MD");
  }
  AtomicFile file_;
  std::vector<detail::H5mdFrame> frames_;
};

}  // namespace

std::unique_ptr<ParticleWriter::Format> ParticleWriter::Format::make(const fs::path& path,
                                                                     ParticleFormat format) {
  switch (format) {
    case ParticleFormat::vtp:
      return std::make_unique<VtpParticles>(path);
    case ParticleFormat::xyz:
      return std::make_unique<XyzParticles>(path);
    case ParticleFormat::lammps_dump:
      return std::make_unique<DumpParticles>(path);
    case ParticleFormat::h5md:
      return std::make_unique<H5mdParticles>(path);
    default:
      return std::make_unique<CsvParticles>(path);
  }
}

const std::vector<std::string>& particle_format_names() {
  static const std::vector<std::string> names{"csv", "vtp", "xyz", "dump", "h5md"};
  return names;
}

ParticleFormat particle_format(std::string_view name) {
  const std::vector<std::string>& names = particle_format_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    detail::throw_invalid("format", name, "is not known; " + suggest(name, names));
  return static_cast<ParticleFormat>(found - names.begin());
}

ParticleFormat particle_format_of(const fs::path& path) {
  constexpr std::array<std::pair<const char*, ParticleFormat>, 8> known{
      {{".csv", ParticleFormat::csv},
       {".vtp", ParticleFormat::vtp},
       {".xyz", ParticleFormat::xyz},
       {".extxyz", ParticleFormat::xyz},
       {".dump", ParticleFormat::lammps_dump},
       {".lammpstrj", ParticleFormat::lammps_dump},
       {".h5", ParticleFormat::h5md},
       {".h5md", ParticleFormat::h5md}}};
  const std::string own = detail::lower_case(path.extension().string());
  std::vector<std::string> extensions;
  for (const auto& [extension, format] : known) {
    if (own == extension) return format;
    extensions.emplace_back(extension);
  }
  throw FileError(path, 0,
                  own.empty()
                      ? "the name has no extension; particles are written as .csv, .vtp, .xyz, "
                        ".dump or .h5"
                      : "'" + own + "' is no extension of particles that are written (" +
                            suggest(own, extensions) + ")");
}

bool has_frames(ParticleFormat format) {
  return format != ParticleFormat::csv && format != ParticleFormat::vtp;
}

ParticleWriter::ParticleWriter(const fs::path& path)
    : ParticleWriter(path, particle_format_of(path)) {}
ParticleWriter::ParticleWriter(const fs::path& path, ParticleFormat format)
    : format_(Format::make(path, format)), several_(has_frames(format)) {}
ParticleWriter::~ParticleWriter() = default;
ParticleWriter::ParticleWriter(ParticleWriter&&) noexcept = default;
ParticleWriter& ParticleWriter::operator=(ParticleWriter&&) noexcept = default;

void ParticleWriter::add(const ParticleTable& table) {
  require(several_ || format_->frames == 0, "number of frames", format_->frames + 1,
          "must be 1 in this format; xyz, dump and h5md have several");
  format_->add(table);
  ++format_->frames;
}

void ParticleWriter::commit() {
  require(format_->frames > 0, "number of frames", 0, "must be 1 at least");
  format_->commit();
}

const std::vector<std::string>& ParticleWriter::notes() const {
  return format_->notes;
}

void write_particles(const fs::path& path, const ParticleTable& table) {
  ParticleWriter writer(path);
  writer.add(table);
  writer.commit();
}

}  // namespace recon
