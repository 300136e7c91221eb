#include "recon/petsc/distributed_grid.hpp"

#include <petscdmda.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "petsc/call.hpp"
#include "recon/grid/reconstruct_on_grid.hpp"

namespace recon::petsc {

using detail::require;

using OwnedDm = Owned<DM, DMDestroy>;
using OwnedVec = Owned<Vec, VecDestroy>;
using Index = std::array<std::int64_t, max_dimension>;

// The memory of one exchange: a DMDA and a vector of its owned nodes.
struct Exchange {
  OwnedDm dm;
  OwnedVec owned;
};

struct DistributedGrid::Data {
  Communicator ranks_of;  // before what lives on it
  StructuredGrid<double> all, owned, piece;
  DistributedGridOptions options;
  std::array<std::vector<std::int64_t>, max_dimension> starts;  // of each rank, and the end
  std::array<int, max_dimension> here{};                        // the place of this rank
  Index owned_begin{}, piece_begin{};
  std::map<int, Exchange> exchanges;  // by the numbers at a node

  Data(Communicator communicator, const StructuredGrid<double>& grid,
       const DistributedGridOptions& how,
       std::array<std::vector<std::int64_t>, max_dimension> begins)
      : ranks_of(std::move(communicator)), all(grid), options(how), starts(std::move(begins)) {
    int rest = ranks_of.rank();
    owned = piece = all;
    for (int d = 0; d < max_dimension; ++d) {
      here[d] = rest % options.ranks[d];
      rest /= options.ranks[d];
      if (d >= all.dimension) continue;
      const auto nodes = static_cast<std::int64_t>(all.counts[d]);
      const std::int64_t begin = starts[d][here[d]], end = starts[d][here[d] + 1];
      const bool periodic = options.periodic[d];
      const std::int64_t first =
          periodic ? begin - options.ghosts : std::max<std::int64_t>(0, begin - options.ghosts);
      const std::int64_t last =
          periodic ? end + options.ghosts : std::min(nodes, end + options.ghosts);
      owned_begin[d] = begin;
      piece_begin[d] = first;
      owned.counts[d] = static_cast<std::size_t>(end - begin);
      piece.counts[d] = static_cast<std::size_t>(last - first);
      owned.origin[d] = all.origin[d] + static_cast<double>(begin) * all.spacing[d];
      piece.origin[d] = all.origin[d] + static_cast<double>(first) * all.spacing[d];
    }
  }

  int rank_at(const std::array<int, max_dimension>& place) const {
    return (place[2] * options.ranks[1] + place[1]) * options.ranks[0] + place[0];
  }

  Exchange& exchange(int per_node);
};

namespace {

// Boxes of nodes as even as they can be; the last ranks have one more where the division leaves a rest.
std::vector<std::int64_t> even_starts(std::int64_t nodes, int ranks) {
  std::vector<std::int64_t> starts{0};
  const std::int64_t each = nodes / ranks, rest = nodes % ranks;
  for (int r = 0; r < ranks; ++r) starts.push_back(starts.back() + each + (r >= ranks - rest));
  return starts;
}

// Throws unless each rank has as many nodes along the axis as there are ghosts, and one.
void require_width(const std::vector<std::int64_t>& starts, int d,
                   const DistributedGridOptions& options) {
  const std::int64_t least = std::max(1, options.ghosts);
  if (options.ranks[d] == 1 && !options.periodic[d]) return;
  for (std::size_t r = 0; r + 1 < starts.size(); ++r)
    if (starts[r + 1] - starts[r] < least)
      detail::throw_invalid(std::string("nodes of one rank along axis ") + "xyz"[d],
                            starts[r + 1] - starts[r],
                            "must be at least the number of ghosts, " + std::to_string(least) +
                                ": fewer ranks along this axis, or more nodes");
}

// The ranks along each axis with the smallest surface of a piece; none fits: zeros.
std::array<int, max_dimension> smallest_surface(const StructuredGrid<double>& grid, int ranks,
                                                const DistributedGridOptions& options) {
  std::array<int, max_dimension> best{};
  double least = std::numeric_limits<double>::infinity();
  const auto fits = [&](int d, int count) {
    if (d >= grid.dimension) return count == 1;
    const auto width = static_cast<std::int64_t>(grid.counts[d]) / count;
    return width >= 1 && ((count == 1 && !options.periodic[d]) || width >= options.ghosts);
  };
  for (int i = 1; i <= ranks; ++i) {
    if (ranks % i != 0 || !fits(0, i)) continue;
    for (int j = 1; j <= ranks / i; ++j) {
      const int k = ranks / i / j;
      if (ranks / i % j != 0 || !fits(1, j) || !fits(2, k)) continue;
      const std::array<int, max_dimension> tried{i, j, k};
      double surface = 0;
      for (int d = 0; d < grid.dimension; ++d) {
        double face = tried[d] == 1 ? 0 : options.periodic[d] ? 2 : std::min(2, tried[d] - 1);
        for (int e = 0; e < grid.dimension; ++e)
          if (e != d) face *= static_cast<double>(grid.counts[e]) / tried[e];
        surface += face;
      }
      if (surface < least) {
        least = surface;
        best = tried;
      }
    }
  }
  return best;
}

void require_ranks(const StructuredGrid<double>& grid, int size, DistributedGridOptions& options) {
  require(options.ghosts >= 0 && options.ghosts <= 64, "ghosts", options.ghosts,
          "must be 0 to 64 layers");
  bool chosen = true;
  for (int d = 0; d < max_dimension; ++d) {
    if (d >= grid.dimension) {
      require(!options.periodic[d], "periodic axis", d, "must be an axis of the grid");
      require(options.ranks[d] == 0 || options.ranks[d] == 1, "ranks along an axis beyond the grid",
              options.ranks[d], "must be 1, or not said");
      options.ranks[d] = 1;
      continue;
    }
    require(options.ranks[d] >= 0, "ranks along an axis", options.ranks[d], "must not be negative");
    chosen = chosen && options.ranks[d] == 0;
  }
  if (chosen) {
    options.ranks = smallest_surface(grid, size, options);
    require(options.ranks[0] > 0, "number of ranks", size,
            "must divide the nodes into boxes that are as wide as the ghosts along each axis");
    return;
  }
  std::int64_t product = 1;
  for (int d = 0; d < grid.dimension; ++d) product *= options.ranks[d];
  require(product == size, "product of the ranks along the axes", product,
          "must be the number of ranks of the communicator");
}

}  // namespace

Exchange& DistributedGrid::Data::exchange(int per_node) {
  if (const auto found = exchanges.find(per_node); found != exchanges.end()) return found->second;
  ranks_of.together(
      [&] {
        require(per_node >= 1, "numbers at a node", per_node, "must be at least 1");
        const double numbers = static_cast<double>(all.size()) * per_node;
        require(numbers <= static_cast<double>(PETSC_MAX_INT), "numbers at all nodes", numbers,
                "must be within the range of PETSc's integers: a PETSc with 64-bit indices");
      },
      "numbers at a node", {static_cast<double>(per_node)});
  Exchange made;
  const auto boundary = [&](int d) {
    return options.periodic[d] ? DM_BOUNDARY_PERIODIC : DM_BOUNDARY_NONE;
  };
  const auto count = [&](int d) { return static_cast<PetscInt>(all.count(d)); };
  RECON_PETSC(DMDACreate(ranks_of.get(), made.dm.out()));
  RECON_PETSC(DMSetDimension(made.dm, all.dimension));
  RECON_PETSC(DMDASetSizes(made.dm, count(0), count(1), count(2)));
  RECON_PETSC(DMDASetBoundaryType(made.dm, boundary(0), boundary(1), boundary(2)));
  RECON_PETSC(DMDASetDof(made.dm, per_node));
  RECON_PETSC(DMDASetStencilType(made.dm, DMDA_STENCIL_BOX));
  RECON_PETSC(DMDASetStencilWidth(made.dm, options.ghosts));
  RECON_PETSC(DMDASetNumProcs(made.dm, options.ranks[0], options.ranks[1], options.ranks[2]));
  std::array<std::vector<PetscInt>, max_dimension> widths;
  for (int d = 0; d < max_dimension; ++d)
    for (int r = 0; r < options.ranks[d]; ++r)
      widths[d].push_back(d < all.dimension ? static_cast<PetscInt>(starts[d][r + 1] - starts[d][r])
                                            : 1);
  const auto axis = [&](int d) { return d < all.dimension ? widths[d].data() : nullptr; };
  RECON_PETSC(DMDASetOwnershipRanges(made.dm, axis(0), axis(1), axis(2)));
  RECON_PETSC(DMSetUp(made.dm));
  RECON_PETSC(DMCreateGlobalVector(made.dm, made.owned.out()));
  return exchanges.emplace(per_node, std::move(made)).first->second;
}

DistributedGrid::DistributedGrid(MPI_Comm comm, const StructuredGrid<double>& grid,
                                 const DistributedGridOptions& options) {
  Communicator communicator(comm);
  DistributedGridOptions how = options;
  std::array<std::vector<std::int64_t>, max_dimension> starts{};
  const auto same = [](const auto& values, int d) { return static_cast<double>(values[d]); };
  communicator.together(
      [&] {
        grid.validate();
        require_ranks(grid, communicator.size(), how);
        for (int d = 0; d < grid.dimension; ++d) {
          starts[d] = even_starts(static_cast<std::int64_t>(grid.counts[d]), how.ranks[d]);
          require_width(starts[d], d, how);
        }
      },
      "grid, periodic axes, ghosts or ranks along the axes",
      {static_cast<double>(grid.dimension), static_cast<double>(options.ghosts),
       same(grid.origin, 0), same(grid.origin, 1), same(grid.origin, 2), same(grid.spacing, 0),
       same(grid.spacing, 1), same(grid.spacing, 2), same(grid.counts, 0), same(grid.counts, 1),
       same(grid.counts, 2), same(options.periodic, 0), same(options.periodic, 1),
       same(options.periodic, 2), same(options.ranks, 0), same(options.ranks, 1),
       same(options.ranks, 2)});
  data_ = std::make_shared<Data>(std::move(communicator), grid, how, std::move(starts));
}

DistributedGrid DistributedGrid::cells() const {
  StructuredGrid<double> grid = all();
  std::array<std::vector<std::int64_t>, max_dimension> starts = data_->starts;
  communicator().together([&] {
    for (int d = 0; d < grid.dimension; ++d) {
      grid.origin[d] += grid.spacing[d] / 2;
      if (!periodic()[d]) {
        require(grid.counts[d] >= 2, "grid nodes along an axis", grid.counts[d],
                "must be at least 2 to have cells between them");
        --grid.counts[d];
        --starts[d].back();
      }
      require_width(starts[d], d, data_->options);
    }
  });
  return DistributedGrid(
      std::make_shared<Data>(data_->ranks_of, grid, data_->options, std::move(starts)));
}

const Communicator& DistributedGrid::communicator() const {
  return data_->ranks_of;
}
const StructuredGrid<double>& DistributedGrid::all() const {
  return data_->all;
}
const StructuredGrid<double>& DistributedGrid::owned() const {
  return data_->owned;
}
const StructuredGrid<double>& DistributedGrid::piece() const {
  return data_->piece;
}
const Index& DistributedGrid::owned_begin() const {
  return data_->owned_begin;
}
const Index& DistributedGrid::piece_begin() const {
  return data_->piece_begin;
}
int DistributedGrid::ghosts() const {
  return data_->options.ghosts;
}
const std::array<bool, max_dimension>& DistributedGrid::periodic() const {
  return data_->options.periodic;
}
const std::array<int, max_dimension>& DistributedGrid::ranks() const {
  return data_->options.ranks;
}

PeriodicDomain<double> DistributedGrid::domain() const {
  PeriodicDomain<double> domain;
  for (int d = 0; d < all().dimension; ++d) {
    if (!periodic()[d]) continue;
    domain.periodic[d] = true;
    domain.lower[d] = all().origin[d];
    domain.upper[d] = all().coordinate(all().counts[d], d);
  }
  return domain;
}

double DistributedGrid::place(double coordinate, int axis) const {
  return (coordinate - all().origin[axis]) / all().spacing[axis];
}

int DistributedGrid::rank_of(const std::array<double, max_dimension>& x) const {
  std::array<int, max_dimension> at{};
  for (int d = 0; d < all().dimension; ++d) {
    const auto nodes = static_cast<double>(all().counts[d]);
    double cell = std::floor(place(x[d], d));
    if (periodic()[d]) cell -= std::floor(cell / nodes) * nodes;
    cell = std::clamp(cell, 0.0, nodes - 1);
    const std::vector<std::int64_t>& starts = data_->starts[d];
    const auto next =
        std::upper_bound(starts.begin() + 1, starts.end() - 1, static_cast<std::int64_t>(cell));
    at[d] = static_cast<int>(next - starts.begin()) - 1;
  }
  return data_->rank_at(at);
}

std::vector<double> DistributedGrid::sum(std::span<const double> piece, int per_node) const {
  const NodeValues one{piece, per_node};
  return std::move(sum(std::span(&one, 1)).front());
}

std::vector<std::vector<double>> DistributedGrid::sum(std::span<const NodeValues> arrays) const {
  const std::size_t nodes = piece().size();
  int width = 0;
  for (const NodeValues& array : arrays) width += array.per_node;
  communicator().together(
      [&] {
        for (const NodeValues& array : arrays) {
          require(array.per_node >= 1, "numbers at a node", array.per_node, "must be at least 1");
          require(array.values.size() == nodes * static_cast<std::size_t>(array.per_node),
                  "numbers of this rank's piece", array.values.size(),
                  "must be per_node for each node of piece()");
        }
      },
      "numbers at a node", {static_cast<double>(width)});
  std::vector<std::vector<double>> sums;
  if (arrays.empty()) return sums;

  // One array is sent as it lies, several as if they were one.
  std::vector<double> packed;
  const double* from = arrays[0].values.data();
  if (arrays.size() > 1) {
    packed.resize(nodes * static_cast<std::size_t>(width));
    double* to = packed.data();
    for (std::size_t i = 0; i < nodes; ++i)
      for (const NodeValues& array : arrays) {
        const auto count = static_cast<std::size_t>(array.per_node);
        to = std::copy_n(array.values.data() + i * count, count, to);
      }
    from = packed.data();
  }
  Exchange& exchange = data_->exchange(width);
  OwnedVec ghosted;
  RECON_PETSC(VecCreateSeqWithArray(PETSC_COMM_SELF, width, static_cast<PetscInt>(nodes) * width,
                                    from, ghosted.out()));
  RECON_PETSC(VecSet(exchange.owned, 0));
  RECON_PETSC(DMLocalToGlobalBegin(exchange.dm, ghosted, ADD_VALUES, exchange.owned));
  RECON_PETSC(DMLocalToGlobalEnd(exchange.dm, ghosted, ADD_VALUES, exchange.owned));

  const double* at = nullptr;
  RECON_PETSC(VecGetArrayRead(exchange.owned, &at));
  for (const NodeValues& array : arrays) {
    const auto count = static_cast<std::size_t>(array.per_node);
    std::vector<double>& out = sums.emplace_back(owned().size() * count);
    for (std::size_t i = 0; i < owned().size(); ++i)
      std::copy_n(at + i * static_cast<std::size_t>(width), count, out.data() + i * count);
    at += count;
  }
  at -= width;
  RECON_PETSC(VecRestoreArrayRead(exchange.owned, &at));
  return sums;
}

std::vector<double> DistributedGrid::fill(std::span<const double> owned_values,
                                          int per_node) const {
  communicator().together(
      [&] {
        require(per_node >= 1, "numbers at a node", per_node, "must be at least 1");
        require(owned_values.size() == owned().size() * static_cast<std::size_t>(per_node),
                "numbers of this rank's nodes", owned_values.size(),
                "must be per_node for each node of owned()");
      },
      "numbers at a node", {static_cast<double>(per_node)});
  Exchange& exchange = data_->exchange(per_node);
  double* to = nullptr;
  RECON_PETSC(VecGetArray(exchange.owned, &to));
  std::copy(owned_values.begin(), owned_values.end(), to);
  RECON_PETSC(VecRestoreArray(exchange.owned, &to));
  std::vector<double> piece_values(piece().size() * static_cast<std::size_t>(per_node));
  OwnedVec ghosted;
  RECON_PETSC(VecCreateSeqWithArray(PETSC_COMM_SELF, per_node,
                                    static_cast<PetscInt>(piece_values.size()), piece_values.data(),
                                    ghosted.out()));
  RECON_PETSC(DMGlobalToLocalBegin(exchange.dm, exchange.owned, INSERT_VALUES, ghosted));
  RECON_PETSC(DMGlobalToLocalEnd(exchange.dm, exchange.owned, INSERT_VALUES, ghosted));
  return piece_values;
}

Traffic DistributedGrid::traffic(int per_node) const {
  const DistributedGridOptions& options = data_->options;
  Traffic traffic;
  std::set<int> others;
  std::array<int, max_dimension> step{};
  // The ghosts on each of the 3^D - 1 sides and corners, and whose they are.
  for (int side = 0; side < 27; ++side) {
    step = {side % 3 - 1, side / 3 % 3 - 1, side / 9 - 1};
    std::int64_t nodes = 1;
    std::array<int, max_dimension> at{};
    for (int d = 0; d < max_dimension; ++d) {
      if (d >= all().dimension) {
        nodes *= step[d] == 0;
        continue;
      }
      const int ranks = options.ranks[d];
      const int next = data_->here[d] + step[d];
      if (!options.periodic[d] && (next < 0 || next >= ranks)) nodes = 0;
      at[d] = (next + ranks) % ranks;
      nodes *= step[d] == 0 ? static_cast<std::int64_t>(owned().counts[d]) : options.ghosts;
    }
    const int other = data_->rank_at(at);
    if (nodes == 0 || other == communicator().rank()) continue;
    others.insert(other);
    traffic.bytes += nodes * per_node * static_cast<std::int64_t>(sizeof(double));
  }
  traffic.messages = static_cast<std::int64_t>(others.size());
  return traffic;
}

DM DistributedGrid::dm(int per_node) const {
  return data_->exchange(per_node).dm;
}

}  // namespace recon::petsc
