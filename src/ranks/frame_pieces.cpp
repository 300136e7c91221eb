#include "ranks/frame_pieces.hpp"

#include <algorithm>
#include <limits>

#include "mpm/policies.hpp"
#include "recon/io/write.hpp"
#include "runs/frame_fields.hpp"

namespace recon::mpm {
namespace {

// The points first, ..., first + counts - 1 along each axis: nodes or cells of the whole grid.
template <int D>
struct Lattice {
  std::array<int, D> first{}, counts{};

  // The nodes of these cells, and the cells; `more`: also those beside the upper faces, as far as
  // the grid has them, so that pieces share points.
  static Lattice of_nodes(const Window<D>& window) {
    Lattice nodes;
    for (std::size_t d = 0; d < D; ++d) {
      nodes.first[d] = window.first[d];
      const int cells = window.last[d] - window.first[d];
      nodes.counts[d] = cells > 0 ? cells + 1 : 0;
    }
    return nodes;
  }
  static Lattice of_cells(const Window<D>& window, const Grid<D>& grid, bool more) {
    Lattice cells;
    for (std::size_t d = 0; d < D; ++d) {
      cells.first[d] = window.first[d];
      cells.counts[d] = window.last[d] - window.first[d];
      if (more && cells.counts[d] > 0 && window.last[d] < grid.cells(static_cast<int>(d)))
        ++cells.counts[d];
    }
    return cells;
  }

  std::size_t size() const {
    std::size_t size = 1;
    for (const int count : counts) size *= static_cast<std::size_t>(count);
    return size;
  }
  std::size_t number(const std::array<int, D>& index) const {
    std::size_t number = 0;
    for (std::size_t d = D; d-- > 0;)
      number = number * static_cast<std::size_t>(counts[d]) +
               static_cast<std::size_t>(index[d] - first[d]);
    return number;
  }
  // Calls each(index) for the points that both have.
  template <class Each>
  void for_common(const Lattice& other, const Each& each) const {
    std::array<int, D> from, to;
    for (std::size_t d = 0; d < D; ++d) {
      from[d] = std::max(first[d], other.first[d]);
      to[d] = std::min(first[d] + counts[d], other.first[d] + other.counts[d]);
      if (from[d] >= to[d]) return;
    }
    for (std::array<int, D> at = from;;) {
      each(at);
      std::size_t d = 0;
      for (; d < D; ++d) {
        if (++at[d] < to[d]) break;
        at[d] = from[d];
      }
      if (d == D) return;
    }
  }
  GridPiece piece() const {
    GridPiece piece;
    for (std::size_t d = 0; d < D; ++d) {
      piece.first[d] = static_cast<std::size_t>(first[d]);
      piece.counts[d] = static_cast<std::size_t>(counts[d]);
    }
    return piece;
  }
};

// What a field is where no particle is.
double nothing(const std::string& field) {
  if (field == "fit_degree") return -1;
  return field == "density" || field.starts_with("stress_")
             ? std::numeric_limits<double>::quiet_NaN()
             : 0;
}

// Fields at points of which each rank has some and knows those that are marked; brought to the pieces
// of all ranks. Where several know a point, that of the lowest rank counts.
template <int D>
class Brought {
 public:
  Brought(const FieldSet& fields, const Lattice<D>& have, const std::vector<char>& known,
          const std::vector<Lattice<D>>& pieces, Votes& votes, Messages<D>& messages) {
    std::vector<std::vector<double>> out(pieces.size());
    std::size_t width = 1;
    for (const NamedField& field : fields) width += static_cast<std::size_t>(field.components);
    for (std::size_t r = 0; r < pieces.size(); ++r)
      have.for_common(pieces[r], [&](const std::array<int, D>& at) {
        const std::size_t here = have.number(at);
        if (!known[here]) return;
        out[r].push_back(static_cast<double>(pieces[r].number(at)));
        for (const NamedField& field : fields) {
          const auto each = static_cast<std::size_t>(field.components);
          for (std::size_t c = 0; c < each; ++c) out[r].push_back(field.values[here * each + c]);
        }
      });
    const std::size_t count = pieces[static_cast<std::size_t>(votes.ranks().rank())].size();
    told_.assign(count, 0);
    for (const NamedField& field : fields)
      values_.emplace_back(count * static_cast<std::size_t>(field.components), nothing(field.name));
    votes.vote();
    for (const std::vector<double>& rows : messages.send(out))
      for (auto row = rows.begin(); row != rows.end(); row += static_cast<std::ptrdiff_t>(width)) {
        const auto point = static_cast<std::size_t>(*row);
        if (told_.at(point)) continue;
        told_[point] = 1;
        auto value = row + 1;
        std::size_t f = 0;
        for (const NamedField& field : fields) {
          const auto each = static_cast<std::size_t>(field.components);
          std::copy_n(value, each, &values_[f++][point * each]);
          value += static_cast<std::ptrdiff_t>(each);
        }
      }
    head_.step = fields.step;
    head_.time = fields.time;
    for (const NamedField& field : fields)
      described_.push_back({field.name, field.components, field.type, field.kind});
  }
  bool is_told(std::size_t point) const { return told_[point] != 0; }
  std::vector<double>& values(std::string_view name) {
    for (std::size_t f = 0; f < described_.size(); ++f)
      if (described_[f].name == name) return values_[f];
    throw std::logic_error("no such field");
  }
  FieldSet fields() && {
    for (std::size_t f = 0; f < described_.size(); ++f)
      head_.add(described_[f].name, described_[f].components, std::move(values_[f]),
                described_[f].type, described_[f].kind);
    return std::move(head_);
  }

 private:
  struct Described {
    std::string name;
    int components;
    NumberType type;
    FieldKind kind;
  };
  FieldSet head_;
  std::vector<Described> described_;
  std::vector<std::vector<double>> values_;
  std::vector<char> told_;
};

// Calls each(particles, p) for the own particles and for their images that give to nodes.
template <int D, class Each>
void for_own(const View<D>& view, const Each& each) {
  const ImageParticles<D>& images = view.nodes().images;
  for (std::size_t p = 0; p < view.state().own(); ++p) each(view.particles(), p);
  for (std::size_t i = 0; i < images.of.size(); ++i)
    if (images.of[i].of < view.state().own()) each(images.particles, i);
}

// The nodes that own particles see: copies reach far enough for all that they have (parts.hpp).
template <int D>
std::vector<char> seen_nodes(const View<D>& view) {
  const Nodes<D>& nodes = view.nodes();
  std::vector<char> seen(nodes.grid.size(), 0);
  with_shape(view.problem().method, [&](auto shape_of) {
    for_own(view, [&](const Particles<D>& particles, std::size_t p) {
      Lattice<D> box, all;
      for (int d = 0; d < D; ++d) {
        const auto [first, last] = shape_of.nodes_along(nodes.grid, particles, p, d);
        box.first[static_cast<std::size_t>(d)] = first;
        box.counts[static_cast<std::size_t>(d)] = last - first + 1;
        all.counts[static_cast<std::size_t>(d)] = nodes.grid.cells(d) + 1;
      }
      all.for_common(box, [&](const std::array<int, D>& at) { seen[nodes.grid.number(at)] = 1; });
    });
  });
  return seen;
}

// The cells in which they lie.
template <int D>
std::vector<char> filled_cells(const View<D>& view) {
  std::vector<char> filled(view.nodes().grid.cell_count(), 0);
  for_own(view, [&](const Particles<D>& particles, std::size_t p) {
    filled[view.nodes().grid.cell_number(particles.x[p])] = 1;
  });
  return filled;
}

// Velocities that are held are known at all nodes.
template <int D>
void hold(const View<D>& view, const Window<D>& window, Brought<D>& nodes) {
  const Grid<D> part = window.part_of(view.problem().grid);
  const double time = view.state().time - view.problem().method.velocity_lag(view.state().last_dt);
  std::vector<double>& velocity = nodes.values("velocity");
  for (const HeldComponent<D>& held : view.step().policies().boundaries.held_in(part, window.first))
    if (!nodes.is_told(held.node))
      velocity[held.node * D + static_cast<std::size_t>(held.axis)] =
          (*held.velocity)(held.x, time);
}

}  // namespace

template <int D>
void write_frame_pieces(const std::filesystem::path& folder, const std::string& name,
                        const View<D>& view, const Boxes<D>& boxes, Votes& votes,
                        Messages<D>& messages, std::vector<double>& times,
                        const FrameOptions& options) {
  view.require_mapped("frame");
  const Grid<D>& grid = view.problem().grid;
  const Nodes<D>& nodes = view.nodes();
  const int rank = votes.ranks().rank();
  const auto mine = static_cast<std::size_t>(rank);
  const std::vector<Window<D>> windows = boxes.windows(grid);
  const bool with_cells = has_cell_frame(view.problem().method);
  const auto file = [&](const char* kind, const char* extension, int piece = -1) {
    return frame_file(name, kind, times.size(), extension, piece);
  };

  const FieldSet particles = particle_frame(view, options.fields);
  const FieldSet here = node_frame(view),
                 here_in_cells = with_cells ? cell_frame(view) : FieldSet{};
  std::vector<Lattice<D>> of_nodes, of_cells;
  for (const Window<D>& window : windows) {
    of_nodes.push_back(Lattice<D>::of_nodes(window));
    of_cells.push_back(Lattice<D>::of_cells(window, grid, true));
  }
  Brought<D> at_nodes(here, Lattice<D>::of_nodes(nodes.window), seen_nodes(view), of_nodes, votes,
                      messages);
  if (of_nodes[mine].size() > 0) hold(view, windows[mine], at_nodes);
  const FieldSet node_fields = std::move(at_nodes).fields();
  FieldSet cell_fields;
  if (with_cells) {
    cell_fields = Brought<D>(here_in_cells, Lattice<D>::of_cells(nodes.window, grid, false),
                             filled_cells(view), of_cells, votes, messages)
                      .fields();
  }
  const std::vector<double> counts = view.of_all({static_cast<double>(view.state().own())});

  // Pieces first, then the files that name them, by one rank.
  if (counts[mine] > 0) {
    const auto own = std::span(view.particles().x).first(view.state().own());
    write_vtp(folder / file("particles", ".vtp", rank), points_of(own), particles);
  }
  if (of_nodes[mine].size() > 0)
    write_vti_piece(folder / file("nodes", ".vti", rank), grid.nodes(), of_nodes[mine].piece(),
                    node_fields);
  if (with_cells && of_cells[mine].size() > 0)
    write_vti_piece(folder / file("cells", ".vti", rank), cell_centres(grid.nodes()),
                    of_cells[mine].piece(), cell_fields);
  votes.vote();
  const double time = view.state().time;
  if (rank == 0) {
    std::vector<std::filesystem::path> of_particles;
    for (std::size_t r = 0; r < counts.size(); ++r)
      if (counts[r] > 0) of_particles.push_back(file("particles", ".vtp", static_cast<int>(r)));
    write_pvtp(folder / file("particles", ".pvtp"), D, of_particles, particles);
    const auto name_pieces = [&](const char* kind, const StructuredGrid<double>& all,
                                 const std::vector<Lattice<D>>& lattices, const FieldSet& fields) {
      std::vector<GridPieceFile> pieces;
      for (std::size_t r = 0; r < lattices.size(); ++r)
        if (lattices[r].size() > 0)
          pieces.push_back({lattices[r].piece(), file(kind, ".vti", static_cast<int>(r))});
      write_pvti(folder / file(kind, ".pvti"), all, pieces, fields);
    };
    name_pieces("nodes", grid.nodes(), of_nodes, node_fields);
    if (with_cells) name_pieces("cells", cell_centres(grid.nodes()), of_cells, cell_fields);
  }
  times.push_back(time);
  if (rank != 0) return;
  const auto list = [&](const char* kind, const char* extension) {
    write_frame_list(folder, name, kind, extension, times, options.first_listed);
  };
  list("particles", ".pvtp");
  list("nodes", ".pvti");
  if (with_cells) list("cells", ".pvti");
}

#define RECON_INSTANTIATE(D)                                                              \
  template void write_frame_pieces(const std::filesystem::path&, const std::string&,      \
                                   const View<D>&, const Boxes<D>&, Votes&, Messages<D>&, \
                                   std::vector<double>&, const FrameOptions&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
