// Space cut into boxes, one for each rank.
#pragma once

#include <vector>

#include "recon/mpm/nodes.hpp"

namespace recon::mpm {

// Cut so that of the given places each box has as many as any other, to one: recursive bisection
// across the longest axis of those that are cut. The same on every rank.
template <int D>
class Boxes {
 public:
  Boxes(const std::vector<Vector<D>>& places, int ranks);
  int rank_of(const Vector<D>& x) const;
  // The cells of a grid that belong to the boxes, for each rank: each cell belongs to one, and those of
  // a box are a window, in which there may be none.
  std::vector<Window<D>> windows(const Grid<D>& grid) const;

 private:
  // Below `at` the next cut is number `lower`, else `upper`; the number of a leaf is -1 - rank.
  struct Cut {
    int axis;
    double at;
    int lower, upper;
  };
  int cut(const std::vector<Vector<D>>& places, std::vector<std::size_t>& order, std::size_t begin,
          std::size_t end, int first_rank, int ranks);
  std::vector<Cut> cuts_;
  int root_, ranks_;
};

}  // namespace recon::mpm
