#include "recon/neighbourhood/r_tree.hpp"

#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <iterator>

#include "core/instantiate.hpp"
#include "neighbourhood/query.hpp"

namespace recon {

namespace {

using detail::require;

namespace bg = boost::geometry;
namespace bgi = boost::geometry::index;

template <class Scalar, int D>
using BoostPoint = bg::model::point<Scalar, D, bg::cs::cartesian>;

template <class Scalar, std::size_t D>
auto to_boost(const std::array<Scalar, D>& x) {
  BoostPoint<Scalar, static_cast<int>(D)> p;
  bg::set<0>(p, x[0]);
  if constexpr (D > 1) bg::set<1>(p, x[1]);
  if constexpr (D > 2) bg::set<2>(p, x[2]);
  return p;
}

template <class Point>
auto to_boost_box(const Point& lower, const Point& upper) {
  return bg::model::box(to_boost(lower), to_boost(upper));
}

// An output iterator that calls a function with every value of the tree.
template <class Function>
struct Call {
  using iterator_category = std::output_iterator_tag;
  using value_type = void;
  using difference_type = std::ptrdiff_t;
  using pointer = void;
  using reference = void;
  Function* function;

  Call& operator*() { return *this; }
  Call& operator++() { return *this; }
  Call operator++(int) { return *this; }
  template <class Value>
  Call& operator=(const Value& value) {
    (*function)(value.second);
    return *this;
  }
};

}  // namespace

template <class S, int D>
struct RTree<S, D>::Tree {
  using Value = std::pair<BoostPoint<S, D>, ParticleIndex>;

  std::vector<Point> points;  // by index
  std::vector<bool> present;  // is there a particle of this index?
  bgi::rtree<Value, bgi::quadratic<16>> index;

  Tree() = default;
  explicit Tree(const PointCloud<S>& cloud)
      : points(detail::gathered<D>(cloud)), present(points.size(), true) {
    std::vector<Value> values(points.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = value(static_cast<ParticleIndex>(i));
    index = decltype(index)(values);  // packed
  }

  Value value(ParticleIndex i) const { return {to_boost(points[i]), i}; }

  // take(index) for all particles that satisfy a predicate of Boost.Geometry.
  template <class Predicate, class Take>
  void visit(const Predicate& predicate, Take take) const {
    index.query(predicate, Call<Take>{&take});
  }

  // The box of the ball: everything within the radius, and corners.
  static auto around(const Point& x, S radius) {
    const S half = reach(radius);
    Point lower, upper;
    for (int d = 0; d < D; ++d) {
      lower[d] = x[d] - half;
      upper[d] = x[d] + half;
    }
    return to_boost_box(lower, upper);
  }

  void require_present(ParticleIndex i) const {
    require(i < points.size() && present[i], "particle", i, "must be in the tree");
  }
};

template <class S, int D>
RTree<S, D>::RTree() : tree_(std::make_unique<Tree>()) {}
template <class S, int D>
RTree<S, D>::RTree(const PointCloud<S>& points) : tree_(std::make_unique<Tree>(points)) {}
template <class S, int D>
RTree<S, D>::RTree(RTree&&) noexcept = default;
template <class S, int D>
RTree<S, D>& RTree<S, D>::operator=(RTree&&) noexcept = default;
template <class S, int D>
RTree<S, D>::~RTree() = default;

template <class S, int D>
std::size_t RTree<S, D>::size() const {
  return tree_->index.size();
}

template <class S, int D>
void RTree<S, D>::within(const Point& x, S radius, Found& found) const {
  detail::require_query_point(x);
  detail::require_radius(radius);
  found.clear();
  tree_->visit(bgi::intersects(Tree::around(x, radius)), [&](ParticleIndex i) {
    const S distance2 = squared_distance(x, tree_->points[i]);
    if (distance2 <= radius * radius) found.push_back({i, distance2});
  });
  detail::sort_by_index(found);
}

template <class S, int D>
void RTree<S, D>::nearest(const Point& x, std::size_t k, Found& found) const {
  nearest_within(x, k, std::numeric_limits<S>::max(), found);
}

template <class S, int D>
void RTree<S, D>::nearest_within(const Point& x, std::size_t k, S radius, Found& found) const {
  detail::require_query_point(x);
  detail::require_radius(radius);
  found.clear();
  k = std::min(k, size());
  if (k == 0) return;
  const S radius2 = radius * radius;
  // One more than asked for: if it is clearly farther than the k-th, nothing else can tie with
  // that.
  const auto take = [&](ParticleIndex i) {
    found.push_back({i, squared_distance(x, tree_->points[i])});
  };
  const unsigned ask = static_cast<unsigned>(k) + 1;
  if (std::isfinite(radius2))
    tree_->visit(bgi::nearest(to_boost(x), ask) && bgi::intersects(Tree::around(x, radius)), take);
  else
    tree_->visit(bgi::nearest(to_boost(x), ask), take);
  std::sort(found.begin(), found.end(), detail::nearer<S>);
  if (found.size() > k && !(found[k].distance2 > detail::widened(found[k - 1].distance2))) {
    const S kth = std::sqrt(detail::widened(found[k - 1].distance2));
    detail::NearestSet<S> set(found, k, radius2);
    tree_->visit(bgi::intersects(Tree::around(x, kth)),
                 [&](ParticleIndex i) { set.offer(i, squared_distance(x, tree_->points[i])); });
    set.sort();
  }
  while (found.size() > k || (!found.empty() && found.back().distance2 > radius2)) found.pop_back();
}

template <class S, int D>
void RTree<S, D>::in_box(const Point& lower, const Point& upper, Found& found) const {
  detail::require_finite(lower, "lower corner");
  detail::require_finite(upper, "upper corner");
  found.clear();
  for (int d = 0; d < D; ++d)
    if (!(lower[d] <= upper[d])) return;
  tree_->visit(bgi::intersects(to_boost_box(lower, upper)), [&](ParticleIndex i) {
    if (detail::inside(tree_->points[i], lower, upper)) found.push_back({i, 0});
  });
  detail::sort_by_index(found);
}

template <class S, int D>
bool RTree<S, D>::contains(ParticleIndex particle) const {
  return particle < tree_->points.size() && tree_->present[particle];
}

template <class S, int D>
void RTree<S, D>::insert(ParticleIndex particle, const Point& x) {
  detail::require_query_point(x);
  require(!contains(particle), "particle", particle, "must not be in the tree already");
  require(particle < std::numeric_limits<ParticleIndex>::max(), "particle", particle,
          "must be smaller than 2^32 - 1");
  if (particle >= tree_->points.size()) {
    tree_->points.resize(particle + std::size_t{1});
    tree_->present.resize(particle + std::size_t{1}, false);
  }
  tree_->points[particle] = x;
  tree_->index.insert(tree_->value(particle));
  tree_->present[particle] = true;
}

template <class S, int D>
void RTree<S, D>::erase(ParticleIndex particle) {
  tree_->require_present(particle);
  tree_->index.remove(tree_->value(particle));
  tree_->present[particle] = false;
}

template <class S, int D>
void RTree<S, D>::move(ParticleIndex particle, const Point& x) {
  detail::require_query_point(x);
  erase(particle);
  insert(particle, x);
}

#define RECON_INSTANTIATE(S, D) template class RTree<S, D>
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE

}  // namespace recon
