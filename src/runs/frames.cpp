#include "recon/runs/frames.hpp"

#include <charconv>
#include <cstdio>
#include <string_view>
#include <utility>

#include "recon/core/names.hpp"
#include "recon/io/write.hpp"
#include "runs/frame_fields.hpp"
#include "runs/particle_values.hpp"

namespace recon::mpm {
namespace {

// a.vtp of a.pvtp, and the way back.
std::filesystem::path other_form(std::filesystem::path file) {
  const std::string extension = file.extension().string();
  const bool pieces = extension.starts_with(".p");
  return file.replace_extension(pieces ? "." + extension.substr(2) : ".p" + extension.substr(1));
}

constexpr std::pair<const char*, const char*> kinds[] = {
    {"particles", ".vtp"}, {"nodes", ".vti"}, {"cells", ".vti"}};

std::filesystem::path frame_list(const std::filesystem::path& folder, const std::string& name,
                                 const char* kind) {
  return folder / (name + "_" + kind + ".pvd");
}

void remove_file(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::remove(file, error);
  if (error) throw FileError(file, 0, "cannot be removed: " + error.message());
}

FieldSet fields_at(double time, std::int64_t step) {
  FieldSet fields;
  fields.time = time;
  fields.step = step;
  return fields;
}

// get(i) is a number, or a vector of the problem's dimension.
template <class Get>
std::vector<double> column(std::size_t count, const Get& get) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    if constexpr (std::is_arithmetic_v<decltype(get(i))>) {
      values.push_back(static_cast<double>(get(i)));
    } else {
      const auto value = get(i);
      values.insert(values.end(), value.data(), value.data() + value.size());
    }
  }
  return values;
}

void add_reports(FieldSet& fields, std::size_t count, const FitReports& fit,
                 const std::vector<std::uint32_t>& place) {
  std::vector<double> degree(count, -1), rank(count, 0), neighbours(count, 0);
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const std::size_t at = place.empty() ? i : place[i];
    degree[at] = fit[i].degree;
    rank[at] = fit[i].rank;
    neighbours[at] = static_cast<double>(fit[i].neighbours);
  }
  fields.add("fit_degree", 1, std::move(degree), NumberType::int32);
  fields.add("fit_rank", 1, std::move(rank), NumberType::int32);
  fields.add("fit_neighbours", 1, std::move(neighbours), NumberType::int32);
}

// Of the fits, whose stress is that of the problem's own directions.
template <int D>
void add_fits(FieldSet& fields, std::size_t rows, const Cells<D>& cells) {
  const auto add = [&](const std::string& field, Eigen::Index at) {
    fields.add(field, 1, column(rows, [&](std::size_t c) {
                 return cells.values(static_cast<Eigen::Index>(c), at);
               }));
  };
  Eigen::Index at = 0;
  add("density", at++);
  for (int r = 0; r < D; ++r)
    for (int c = r; c < D; ++c) add(std::string("stress_") + "xyz"[r] + "xyz"[c], at++);
}

}  // namespace

std::string frame_file(const std::string& name, const char* kind, std::size_t number,
                       const char* extension, int piece) {
  char digits[24];
  std::snprintf(digits, sizeof digits, "_%04zu", number);
  return name + "_" + kind + digits + (piece < 0 ? "" : "_" + std::to_string(piece)) + extension;
}

void write_frame_list(const std::filesystem::path& folder, const std::string& name,
                      const char* kind, const char* extension, const std::vector<double>& times,
                      std::size_t first) {
  std::vector<TimedFile> files;
  for (std::size_t i = first; i < times.size(); ++i) {
    const std::filesystem::path file = frame_file(name, kind, i, extension);
    std::error_code none;
    for (const auto& form : {file, other_form(file)}) {
      if (!std::filesystem::exists(folder / form, none)) continue;
      files.push_back({times[i], form});
      break;
    }
  }
  write_pvd(frame_list(folder, name, kind), files);
}

std::vector<std::filesystem::path> frames_in(const std::filesystem::path& folder,
                                             const std::string& name, std::size_t first) {
  std::vector<std::filesystem::path> found;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    const std::string file = entry.path().filename().string();
    for (const auto& [kind, extension] : kinds) {
      const std::string begin = name + "_" + kind + "_";
      if (!file.starts_with(begin)) continue;
      // NUMBER, or NUMBER_PIECE, and one of two extensions.
      const char* const end = file.data() + file.size();
      std::size_t number = 0, piece = 0;
      auto read = std::from_chars(file.data() + begin.size(), end, number);
      if (read.ec != std::errc()) continue;
      if (read.ptr != end && *read.ptr == '_') read = std::from_chars(read.ptr + 1, end, piece);
      const std::string_view rest(read.ptr, end);
      const bool whole = rest == extension || rest == ".p" + std::string(extension + 1);
      if (read.ec == std::errc() && whole && number >= first) found.push_back(entry.path());
    }
  }
  return found;
}

void begin_frames(const std::filesystem::path& folder, const std::string& name,
                  const std::vector<double>& times, std::size_t first_listed) {
  const bool any = times.size() > first_listed;
  for (const auto& file : frames_in(folder, name, any ? times.size() : 0)) remove_file(file);
  for (const auto& [kind, extension] : kinds) {
    const std::filesystem::path list = frame_list(folder, name, kind);
    std::error_code none;
    if (!std::filesystem::exists(list, none)) continue;
    if (any)
      write_frame_list(folder, name, kind, extension, times, first_listed);
    else
      remove_file(list);
  }
}

bool has_cell_frame(const Method& method) {
  return method.quadrature != Quadrature::particles;
}

template <int D>
FieldSet particle_frame(const View<D>& view, const std::vector<std::string>& names) {
  const Particles<D>& particles = view.particles();
  auto known = particle_fields_of(view.problem(), particles);
  known.at("id").put = [&view](std::size_t p, double* to) {
    *to = static_cast<double>(view.number_of(p));
  };
  FieldSet out = fields_at(view.state().time, view.state().steps);
  for (const std::string& name : names) {
    const auto field = known.find(name);
    if (field == known.end())
      throw InvalidArgument("field of the particles", name, suggest(name, particle_fields()));
    const auto components = static_cast<std::size_t>(field->second.components);
    std::vector<double> values(view.state().own() * components);
    for (std::size_t p = 0; p < view.state().own(); ++p)
      field->second.put(p, &values[p * components]);
    out.add(name, field->second.components, std::move(values), field->second.type,
            field->second.kind);
  }
  return out;
}

template <int D>
FieldSet node_frame(const View<D>& view) {
  view.require_mapped("frame");
  const Nodes<D>& nodes = view.nodes();
  const std::size_t count = nodes.grid.size();
  FieldSet fields = fields_at(view.state().time, view.state().steps);
  fields.add("mass", 1, nodes.mass);
  const auto add_vector = [&](const char* field, const std::vector<Vector<D>>& values) {
    fields.add(field, D, column(count, [&](std::size_t i) { return values[i]; }),
               NumberType::float64, FieldKind::vector);
  };
  add_vector("velocity", nodes.velocity);
  add_vector("force", nodes.force);
  if (is_fit(view.problem().method.velocity))
    add_reports(fields, count, nodes.fit, nodes.fit_nodes);
  if (view.problem().method.quadrature == Quadrature::nodal_cells)
    add_fits(fields, count, view.step().cells());
  return fields;
}

template <int D>
FieldSet cell_frame(const View<D>& view) {
  view.require_mapped("frame");
  const Cells<D>& cells = view.step().cells();
  FieldSet fields = fields_at(view.state().time, view.state().steps);
  if (view.problem().method.quadrature == Quadrature::cells) {
    add_fits(fields, cells.fill.size(), cells);
    add_reports(fields, cells.fill.size(), cells.fit, {});
  }
  fields.add("fill", 1, cells.fill);
  return fields;
}

template <int D>
void write_frame(const std::filesystem::path& folder, const std::string& name,
                 const Simulation<D>& simulation, std::vector<double>& times,
                 const FrameOptions& options) {
  write_frame_of(folder, name, View<D>(simulation), times, options);
}

template <int D>
void write_frame_of(const std::filesystem::path& folder, const std::string& name,
                    const View<D>& view, std::vector<double>& times, const FrameOptions& options) {
  const StructuredGrid<double>& grid = view.problem().grid.nodes();
  const bool with_cells = has_cell_frame(view.problem().method);
  const auto file = [&](const char* kind, const char* extension) {
    return folder / frame_file(name, kind, times.size(), extension);
  };
  view.require_mapped("frame");
  write_vtp(file("particles", ".vtp"), points_of(view.particles().x),
            particle_frame(view, options.fields));
  write_vti(file("nodes", ".vti"), grid, node_frame(view));
  if (with_cells) write_vti(file("cells", ".vti"), cell_centres(grid), cell_frame(view));
  times.push_back(view.state().time);
  const auto list = [&](const char* kind, const char* extension) {
    write_frame_list(folder, name, kind, extension, times, options.first_listed);
  };
  list("particles", ".vtp");
  list("nodes", ".vti");
  if (with_cells) list("cells", ".vti");
}

#define RECON_INSTANTIATE(D)                                                                     \
  template FieldSet particle_frame(const View<D>&, const std::vector<std::string>&);             \
  template FieldSet node_frame(const View<D>&);                                                  \
  template FieldSet cell_frame(const View<D>&);                                                  \
  template void write_frame(const std::filesystem::path&, const std::string&,                    \
                            const Simulation<D>&, std::vector<double>&, const FrameOptions&);    \
  template void write_frame_of(const std::filesystem::path&, const std::string&, const View<D>&, \
                               std::vector<double>&, const FrameOptions&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
