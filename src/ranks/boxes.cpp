#include "ranks/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace recon::mpm {

template <int D>
Boxes<D>::Boxes(const std::vector<Vector<D>>& places, int ranks) : ranks_(ranks) {
  std::vector<std::size_t> order(places.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  root_ = cut(places, order, 0, order.size(), 0, ranks);
}

template <int D>
int Boxes<D>::rank_of(const Vector<D>& x) const {
  int next = root_;
  while (next >= 0) {
    const Cut& cut = cuts_[static_cast<std::size_t>(next)];
    next = x[cut.axis] < cut.at ? cut.lower : cut.upper;
  }
  return -1 - next;
}

template <int D>
std::vector<Window<D>> Boxes<D>::windows(const Grid<D>& grid) const {
  std::vector<Window<D>> of(static_cast<std::size_t>(ranks_));
  const auto divide = [&](const auto& self, int next, const Window<D>& cells) -> void {
    if (next < 0) {
      of[static_cast<std::size_t>(-1 - next)] = cells;
      return;
    }
    const Cut& cut = cuts_[static_cast<std::size_t>(next)];
    const auto axis = static_cast<std::size_t>(cut.axis);
    const double plane = std::round((cut.at - grid.lower()[cut.axis]) / grid.h());
    const int at = static_cast<int>(std::clamp(plane, static_cast<double>(cells.first[axis]),
                                               static_cast<double>(cells.last[axis])));
    Window<D> lower = cells, upper = cells;
    lower.last[axis] = upper.first[axis] = at;
    self(self, cut.lower, lower);
    self(self, cut.upper, upper);
  };
  divide(divide, root_, Window<D>::of(grid));
  return of;
}

template <int D>
int Boxes<D>::cut(const std::vector<Vector<D>>& places, std::vector<std::size_t>& order,
                  std::size_t begin, std::size_t end, int first_rank, int ranks) {
  if (ranks == 1) return -1 - first_rank;
  Vector<D> least = Vector<D>::Zero(), most = Vector<D>::Zero();
  if (begin < end) least = most = places[order[begin]];
  for (std::size_t i = begin; i < end; ++i) {
    least = least.cwiseMin(places[order[i]]);
    most = most.cwiseMax(places[order[i]]);
  }
  Eigen::Index axis = 0;
  (most - least).maxCoeff(&axis);
  const int below = ranks / 2;
  const std::size_t middle =
      begin + (end - begin) * static_cast<std::size_t>(below) / static_cast<std::size_t>(ranks);
  const auto before = [&](std::size_t a, std::size_t b) {
    return places[a][axis] != places[b][axis] ? places[a][axis] < places[b][axis] : a < b;
  };
  using Offset = std::ptrdiff_t;
  std::sort(order.begin() + static_cast<Offset>(begin), order.begin() + static_cast<Offset>(end),
            before);
  double at = least[axis];
  if (middle > begin && middle < end)
    at = (places[order[middle - 1]][axis] + places[order[middle]][axis]) / 2;
  // A row of particles at the same place along the axis stays together.
  std::size_t cut_at = begin;
  while (cut_at < end && places[order[cut_at]][axis] < at) ++cut_at;
  const auto here = cuts_.size();
  cuts_.push_back({static_cast<int>(axis), at, 0, 0});
  const int lower = cut(places, order, begin, cut_at, first_rank, below);
  const int upper = cut(places, order, cut_at, end, first_rank + below, ranks - below);
  cuts_[here].lower = lower;
  cuts_[here].upper = upper;
  return static_cast<int>(here);
}

template class Boxes<1>;
template class Boxes<2>;
template class Boxes<3>;

}  // namespace recon::mpm
