// The tree of KdTree where recon is built without nanoflann: a balanced k-d tree.
//
// Every node halves its particles along the longest edge of their bounding box, so that the tree
// needs no pointers: the children of node i are 2 i + 1 and 2 i + 2. Building costs O(n log n).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "neighbourhood/query.hpp"

namespace recon::detail {

template <class S, int D>
class PlainTree {
 public:
  using Point = std::array<S, D>;

  explicit PlainTree(const std::vector<Point>& x) {
    places_.reserve(x.size());
    for (std::size_t i = 0; i < x.size(); ++i)
      places_.push_back({x[i], static_cast<ParticleIndex>(i)});
    std::size_t leaves = 1;
    while (leaves * leaf_size < x.size()) leaves *= 2;
    nodes_.resize(leaves - 1);
    if (!x.empty()) box_ = build(0, 0, places_.size());
  }

  std::size_t size() const { return places_.size(); }

  // take(index, x_p, distance2) for at least all particles not farther than bound(), a squared
  // distance that may shrink on the way. There must be a particle.
  template <class Take, class Bound>
  void visit(const Point& x, const Take& take, const Bound& bound) const {
    Point outside;
    S distance2 = 0;
    for (int d = 0; d < D; ++d) {
      outside[d] = std::max({S(0), box_.lower[d] - x[d], x[d] - box_.upper[d]});
      distance2 += outside[d] * outside[d];
    }
    if (distance2 <= bound()) visit(0, 0, places_.size(), x, outside, distance2, take, bound);
  }

 private:
  static constexpr std::size_t leaf_size = 12;

  struct Place {
    Point x;
    ParticleIndex index;
  };
  struct Bounds {
    Point lower, upper;
  };
  struct Node {
    int axis;
    S left_upper, right_lower;  // where the left half ends and the right half begins, on the axis
  };

  Bounds build(std::size_t node, std::size_t begin, std::size_t end) {
    Bounds box{places_[begin].x, places_[begin].x};
    for (std::size_t p = begin; p < end; ++p)
      for (int d = 0; d < D; ++d) {
        box.lower[d] = std::min(box.lower[d], places_[p].x[d]);
        box.upper[d] = std::max(box.upper[d], places_[p].x[d]);
      }
    if (node >= nodes_.size()) return box;
    int axis = 0;
    for (int d = 1; d < D; ++d)
      if (box.upper[d] - box.lower[d] > box.upper[axis] - box.lower[axis]) axis = d;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t p) { return places_.begin() + static_cast<std::ptrdiff_t>(p); };
    std::nth_element(at(begin), at(middle), at(end),
                     [axis](const Place& a, const Place& b) { return a.x[axis] < b.x[axis]; });
    const S left_upper = build(2 * node + 1, begin, middle).upper[axis];
    const S right_lower = build(2 * node + 2, middle, end).lower[axis];
    nodes_[node] = {axis, left_upper, right_lower};
    return box;
  }

  // `outside` is how far x lies outside of the node along each axis, distance2 the sum of squares.
  template <class Take, class Bound>
  void visit(std::size_t node, std::size_t begin, std::size_t end, const Point& x,
             const Point& outside, S distance2, const Take& take, const Bound& bound) const {
    if (node >= nodes_.size()) {
      for (std::size_t p = begin; p < end; ++p)
        take(places_[p].index, places_[p].x, squared_distance(x, places_[p].x));
      return;
    }
    const auto [axis, left_upper, right_lower] = nodes_[node];
    const std::size_t middle = begin + (end - begin) / 2;
    const S to_left = x[axis] - left_upper, to_right = right_lower - x[axis];
    const bool left_first = to_left < to_right;
    if (left_first)
      visit(2 * node + 1, begin, middle, x, outside, distance2, take, bound);
    else
      visit(2 * node + 2, middle, end, x, outside, distance2, take, bound);
    Point beyond = outside;
    beyond[axis] = std::max(outside[axis], left_first ? to_right : to_left);
    const S beyond2 = distance2 - outside[axis] * outside[axis] + beyond[axis] * beyond[axis];
    if (!(beyond2 <= bound())) return;
    if (left_first)
      visit(2 * node + 2, middle, end, x, beyond, beyond2, take, bound);
    else
      visit(2 * node + 1, begin, middle, x, beyond, beyond2, take, bound);
  }

  std::vector<Place> places_;  // those of a node side by side
  std::vector<Node> nodes_;    // all but the leaves
  Bounds box_{};
};

}  // namespace recon::detail
