// RTree where recon is built without Boost: an error that names the option of the build. There is
// no tree, so that nothing beyond the constructors can be called.
#include "core/instantiate.hpp"
#include "recon/core/error.hpp"
#include "recon/neighbourhood/r_tree.hpp"

namespace recon {

namespace {

[[noreturn]] void throw_left_out() {
  detail::throw_invalid("search", "r_tree",
                        "needs Boost.Geometry, and recon was built with RECON_WITH_BOOST=OFF");
}

}  // namespace

template <class S, int D>
struct RTree<S, D>::Tree {};

template <class S, int D>
RTree<S, D>::RTree() {
  throw_left_out();
}
template <class S, int D>
RTree<S, D>::RTree(const PointCloud<S>&) {
  throw_left_out();
}
template <class S, int D>
RTree<S, D>::RTree(RTree&&) noexcept = default;
template <class S, int D>
RTree<S, D>& RTree<S, D>::operator=(RTree&&) noexcept = default;
template <class S, int D>
RTree<S, D>::~RTree() = default;

template <class S, int D>
std::size_t RTree<S, D>::size() const {
  return 0;
}
template <class S, int D>
void RTree<S, D>::within(const Point&, S, Found&) const {}
template <class S, int D>
void RTree<S, D>::nearest(const Point&, std::size_t, Found&) const {}
template <class S, int D>
void RTree<S, D>::nearest_within(const Point&, std::size_t, S, Found&) const {}
template <class S, int D>
void RTree<S, D>::in_box(const Point&, const Point&, Found&) const {}
template <class S, int D>
bool RTree<S, D>::contains(ParticleIndex) const {
  return false;
}
template <class S, int D>
void RTree<S, D>::insert(ParticleIndex, const Point&) {}
template <class S, int D>
void RTree<S, D>::erase(ParticleIndex) {}
template <class S, int D>
void RTree<S, D>::move(ParticleIndex, const Point&) {}

#define RECON_INSTANTIATE(S, D) template class RTree<S, D>
RECON_FOR_EACH_SCALAR_AND_DIMENSION(RECON_INSTANTIATE);
#undef RECON_INSTANTIATE

}  // namespace recon
