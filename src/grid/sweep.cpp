#include "grid/sweep.hpp"

#include <algorithm>

#include "core/instantiate.hpp"
#include "grid/aligned_array.hpp"
#include "grid/row_gather.hpp"
#include "recon/core/parallel.hpp"

namespace recon {
namespace {

constexpr int most_groups = 12;
constexpr double tile_bytes = 1e6;  // of moments

std::int64_t divided_up(std::int64_t a, std::int64_t b) {
  return (a + b - 1) / b;
}

// Tiles: their numbers along the axes and their largest sizes, in nodes.
struct Tiles {
  std::array<std::int64_t, max_dimension> number, size;
  std::size_t count() const { return static_cast<std::size_t>(number[0] * number[1] * number[2]); }
};

template <class Scalar>
Tiles choose_tiles(const GridPlan<Scalar>& plan, const LaneLayout& lanes) {
  const int threads = plan.options.threads > 0 ? plan.options.threads : default_threads();
  const auto n = plan.stencil();
  Tiles tiles;
  tiles.size[0] = lanes.width;
  tiles.number[0] = divided_up(plan.axes[0].nodes, lanes.width);
  const double row_bytes = static_cast<double>(sizeof(Scalar)) * n[2] * plan.quantities() *
                           lanes.lanes * (lanes.groups + n[0] - 1);
  const auto fitting = static_cast<std::int64_t>(tile_bytes / row_bytes);
  tiles.size[1] = std::max<std::int64_t>({fitting, 2 * n[1], 1});
  tiles.size[2] = std::max<std::int64_t>(plan.axes[2].nodes, 1);
  // Enough tiles for all threads, but none so thin that most of its work is its border's.
  for (const int d : {1, 2}) {
    const std::int64_t nodes = plan.axes[d].nodes;
    const std::int64_t others = d == 1 ? tiles.number[0] : tiles.number[0] * tiles.number[1];
    const std::int64_t wanted = divided_up(2 * threads, others);
    const std::int64_t most = std::max<std::int64_t>(1, nodes / (4 * n[d]));
    tiles.number[d] = std::max(divided_up(nodes, tiles.size[d]), std::min(wanted, most));
    tiles.size[d] = divided_up(nodes, tiles.number[d]);
    tiles.number[d] = divided_up(nodes, tiles.size[d]);
  }
  return tiles;
}

template <class Scalar>
class TileSweep {
 public:
  TileSweep(const ParticleData<Scalar>& particles, const ParticleBins& bins,
            const GridPlan<Scalar>& plan, const LaneLayout& lanes,
            const std::array<std::int64_t, max_dimension>& begin,
            const std::array<std::int64_t, max_dimension>& end)
      : plan_(plan),
        lanes_(lanes),
        begin_(begin),
        end_(end),
        n_(plan.stencil()),
        gather_(particles, bins, plan, lanes, begin[0]),
        row_size_(static_cast<std::size_t>(plan.quantities() * lanes.lanes) *
                  static_cast<std::size_t>(lanes.groups + n_[0] - 1)),
        moments_(row_size_ * static_cast<std::size_t>(n_[2] * (end[1] - begin[1]))),
        work_(plan.kernel.work_size(plan.components, n_)),
        rows_(static_cast<std::size_t>(n_[1] * n_[2])) {}

  // Cell (j, k) of a row touches the nodes j - n + 1 .. j, k - n + 1 .. k.
  void run(const RowSink<Scalar>& done) {
    for (std::int64_t k = begin_[2]; k < end_[2] + n_[2] - 1; ++k) {
      for (std::int64_t j = begin_[1]; j < end_[1] + n_[1] - 1; ++j) add_row(j, k);
      const std::int64_t complete = k - n_[2] + 1;
      if (complete < begin_[2]) continue;
      for (std::int64_t j = begin_[1]; j < end_[1]; ++j) {
        Scalar* row = row_of(j, complete);
        if (carries(row)) take_carried(row);
        merge_lanes(row);
        done({begin_[0], end_[0] - begin_[0], j, complete, row});
        std::fill_n(row, row_size_, Scalar(0));
      }
    }
  }

 private:
  // Where row (j, k) of nodes stands.
  Scalar* row_of(std::int64_t j, std::int64_t k) {
    return moments_.data() + row_size_ * static_cast<std::size_t>(
                                             (k % n_[2]) * (end_[1] - begin_[1]) + j - begin_[1]);
  }

  void add_row(std::int64_t j, std::int64_t k) {
    for (int c = 0; c < n_[2]; ++c)
      for (int b = 0; b < n_[1]; ++b) {
        const std::int64_t node_j = j - n_[1] + 1 + b, node_k = k - n_[2] + 1 + c;
        const bool own =
            node_j >= begin_[1] && node_j < end_[1] && node_k >= begin_[2] && node_k < end_[2];
        rows_[static_cast<std::size_t>(c * n_[1] + b)] = own ? row_of(node_j, node_k) : nullptr;
      }
    CellRow<Scalar> row{};
    row.groups = lanes_.groups;
    row.components = plan_.components;
    row.stencil = n_;
    for (int d = 0; d < max_dimension; ++d) row.offset[d] = plan_.node_offsets[d].data();
    row.form = plan_.form;
    row.weight = plan_.weight;
    row.weight_state = plan_.options.weight.state();
    row.least_weight = plan_.least_weight;
    row.rows = rows_.data();
    row.work = work_.data();
    for (gather_.start(j, k); gather_.next();) {
      row.begin = gather_.begin();
      row.particles = gather_.slots();
      plan_.kernel.add(row);
      if (gather_.more()) carry();
    }
  }

  // Sums of very many particles: after each portion of a long row of cells but the last, what the
  // nodes have got goes over to sums in double. Where there is one portion only, there are none.
  void carry() {
    if (carried_.empty()) {
      carried_.resize(row_size_ * static_cast<std::size_t>(n_[2] * (end_[1] - begin_[1])));
      carries_.resize(carried_.size() / row_size_);
    }
    for (Scalar* row : rows_) {
      if (!row) continue;
      const auto at = static_cast<std::size_t>(row - moments_.data());
      carries_[at / row_size_] = true;
      double* to = carried_.data() + at;
      for (std::size_t i = 0; i < row_size_; ++i) to[i] += static_cast<double>(row[i]);
      std::fill_n(row, row_size_, Scalar(0));
    }
  }
  bool carries(const Scalar* row) const {
    return !carries_.empty() &&
           carries_[static_cast<std::size_t>(row - moments_.data()) / row_size_];
  }
  void take_carried(Scalar* row) {
    const auto at = static_cast<std::size_t>(row - moments_.data());
    carries_[at / row_size_] = false;
    double* from = carried_.data() + at;
    for (std::size_t i = 0; i < row_size_; ++i)
      row[i] = static_cast<Scalar>(from[i] + static_cast<double>(row[i]));
    std::fill_n(from, row_size_, 0.0);
  }

  // Entry (g >= G, l) is the node (g - G, l + 1); from the last, for stencils wider than a segment.
  void merge_lanes(Scalar* row) const {
    const int lanes = lanes_.lanes, quantities = plan_.quantities();
    const std::size_t entry = static_cast<std::size_t>(quantities * lanes);
    for (int g = lanes_.groups + n_[0] - 2; g >= lanes_.groups; --g) {
      const Scalar* from = row + static_cast<std::size_t>(g) * entry;
      Scalar* to = row + static_cast<std::size_t>(g - lanes_.groups) * entry;
      for (int q = 0; q < quantities; ++q, from += lanes, to += lanes)
        for (int l = 0; l + 1 < lanes; ++l) to[l + 1] += from[l];
    }
  }

  const GridPlan<Scalar>& plan_;
  LaneLayout lanes_;
  std::array<std::int64_t, max_dimension> begin_, end_;
  std::array<int, max_dimension> n_;
  RowGather<Scalar> gather_;
  std::size_t row_size_;
  AlignedArray<Scalar> moments_, work_;
  std::vector<Scalar*> rows_;
  std::vector<double> carried_;  // laid out as moments_; empty until needed
  std::vector<bool> carries_;    // which rows have something there
};

}  // namespace

template <class Scalar>
LaneLayout LaneLayout::of(const GridPlan<Scalar>& plan) {
  const int lanes = plan.kernel.lanes, n = plan.axes[0].stencil;
  const std::int64_t nodes = plan.axes[0].nodes;
  // As few tiles as the longest segments allow, and segments no longer than these need.
  const std::int64_t longest = std::max<std::int64_t>(most_groups * lanes - n + 1, lanes);
  const std::int64_t tiles = divided_up(nodes, longest);
  const auto groups = static_cast<int>(divided_up(divided_up(nodes, tiles) + n - 1, lanes));
  return {lanes, groups, n, std::int64_t{groups} * lanes - n + 1};
}

template <class Scalar>
void sweep(const ParticleData<Scalar>& particles, const ParticleBins& bins,
           const GridPlan<Scalar>& plan, const Progress& progress,
           const std::function<RowSink<Scalar>()>& make_done) {
  const LaneLayout lanes = LaneLayout::of(plan);
  const Tiles tiles = choose_tiles(plan, lanes);
  const auto sweep_tile = [&](std::size_t tile, std::size_t) {
    std::array<std::int64_t, max_dimension> begin, end;
    for (int d = 0; d < max_dimension; ++d) {
      const std::int64_t at = static_cast<std::int64_t>(tile) % tiles.number[d];
      tile /= static_cast<std::size_t>(tiles.number[d]);
      begin[d] = at * tiles.size[d];
      end[d] = std::min(begin[d] + tiles.size[d], plan.axes[d].nodes);
    }
    TileSweep<Scalar>(particles, bins, plan, lanes, begin, end).run(make_done());
  };
  parallel_blocks(tiles.count(), 1, plan.options.threads, progress, sweep_tile);
}

RECON_FLOAT(template LaneLayout LaneLayout::of(const GridPlan<float>&);)
template LaneLayout LaneLayout::of(const GridPlan<double>&);
RECON_FLOAT(template void sweep(const ParticleData<float>&, const ParticleBins&,
                                const GridPlan<float>&, const Progress&,
                                const std::function<RowSink<float>()>&);)
template void sweep(const ParticleData<double>&, const ParticleBins&, const GridPlan<double>&,
                    const Progress&, const std::function<RowSink<double>()>&);

}  // namespace recon
