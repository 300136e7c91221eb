#include "hand_written.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

#define HAND_WRITTEN_TEXT(x) #x
#define HAND_WRITTEN_STRING(x) HAND_WRITTEN_TEXT(x)

namespace hand_written {
namespace {

constexpr int leaf_size = 10;

template <class Scalar, int D>
struct Adaptor {
  const Points<Scalar, D>& points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  Scalar kdtree_get_pt(std::size_t i, std::size_t d) const { return points[i][d]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

template <class Scalar, int D>
using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<Scalar, Adaptor<Scalar, D>>,
                                        Adaptor<Scalar, D>, D, std::uint32_t>;

constexpr int terms(int dimension, int degree) {
  int n = 1;
  for (int i = 1; i <= dimension; ++i) n = n * (degree + i) / i;
  return n;
}

// 1, x, y, z, x^2, xy, xz, y^2, yz, z^2
template <class Scalar, int D, int Degree>
Eigen::Matrix<Scalar, terms(D, Degree), 1> basis(const Eigen::Matrix<Scalar, D, 1>& x) {
  Eigen::Matrix<Scalar, terms(D, Degree), 1> b;
  b[0] = 1;
  for (int d = 0; d < D; ++d) b[1 + d] = x[d];
  if constexpr (Degree == 2) {
    int n = 1 + D;
    for (int d = 0; d < D; ++d)
      for (int e = d; e < D; ++e) b[n++] = x[d] * x[e];
  }
  return b;
}

// 1/6 ((2 - s)^3 - 4 (1 - s)^3) with s = 2 q, powers of what is positive only.
template <class Scalar>
Scalar cubic_b_spline(Scalar q) {
  const Scalar a = std::max(2 - 2 * q, Scalar(0)), b = std::max(1 - 2 * q, Scalar(0));
  return (a * a * a - 4 * b * b * b) / 6;
}

}  // namespace

template <class Scalar, int D>
Neighbours<Scalar> search(const Points<Scalar, D>& sources, const Points<Scalar, D>& targets, int k,
                          int threads) {
  const Adaptor<Scalar, D> adaptor{sources};
  Tree<Scalar, D> tree(D, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(leaf_size));
  tree.buildIndex();
  const auto n = static_cast<std::ptrdiff_t>(targets.size());
  Neighbours<Scalar> found{k, Array<std::uint32_t>(new std::uint32_t[targets.size() * k]),
                           Array<Scalar>(new Scalar[targets.size() * k])};
#pragma omp parallel for schedule(dynamic, 256) num_threads(threads)
  for (std::ptrdiff_t t = 0; t < n; ++t) {
    nanoflann::KNNResultSet<Scalar, std::uint32_t> result(k);
    result.init(&found.index[t * k], &found.distance2[t * k]);
    tree.findNeighbors(result, targets[t].data(), nanoflann::SearchParams());
  }
  return found;
}

template <class Scalar, int D, int Degree>
Array<Scalar> construct(const Points<Scalar, D>& sources, const Points<Scalar, D>& targets,
                        const Neighbours<Scalar>& neighbours, int threads) {
  constexpr int N = terms(D, Degree);
  constexpr int most = 64;  // neighbours
  using Vector = Eigen::Matrix<Scalar, N, 1>;
  using Point = Eigen::Matrix<Scalar, D, 1>;
  const int k = neighbours.k;
  const auto n = static_cast<std::ptrdiff_t>(targets.size());
  Array<Scalar> coefficients(new Scalar[targets.size() * k]);
#pragma omp parallel for schedule(dynamic, 256) num_threads(threads)
  for (std::ptrdiff_t t = 0; t < n; ++t) {
    const Point x = Eigen::Map<const Point>(targets[t].data());
    const Scalar scale = 1 / (Scalar(1.5) * std::sqrt(neighbours.distance2[t * k + k - 1]));
    Eigen::Matrix<Scalar, N, N> moments = Eigen::Matrix<Scalar, N, N>::Zero();
    Vector b[most];
    Scalar w[most];
    for (int j = 0; j < k; ++j) {
      const auto p = neighbours.index[t * k + j];
      const Point offset = (Eigen::Map<const Point>(sources[p].data()) - x) * scale;
      w[j] = cubic_b_spline(offset.norm());
      b[j] = basis<Scalar, D, Degree>(offset);
      // The whole square: faster here than rankUpdate or loops over the lower triangle, which
      // vectorise badly at these sizes.
      moments.noalias() += (w[j] * b[j]) * b[j].transpose();
    }
    const Vector c = moments.ldlt().solve(Vector::Unit(0));
    for (int j = 0; j < k; ++j) coefficients[t * k + j] = w[j] * b[j].dot(c);
  }
  return coefficients;
}

template <class Scalar>
void apply(const Neighbours<Scalar>& neighbours, const Scalar* coefficients, const Scalar* u,
           std::size_t targets, Scalar* out, int threads) {
  const int k = neighbours.k;
  const auto n = static_cast<std::ptrdiff_t>(targets);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (std::ptrdiff_t t = 0; t < n; ++t) {
    Scalar sum = 0;
    for (int j = 0; j < k; ++j) sum += coefficients[t * k + j] * u[neighbours.index[t * k + j]];
    out[t] = sum;
  }
}

const char* eigen_version() {
  return HAND_WRITTEN_STRING(EIGEN_WORLD_VERSION) "." HAND_WRITTEN_STRING(
      EIGEN_MAJOR_VERSION) "." HAND_WRITTEN_STRING(EIGEN_MINOR_VERSION);
}

int nanoflann_version() {
  return NANOFLANN_VERSION;
}

#define INSTANTIATE(S, D)                                                                  \
  template Neighbours<S> search<S, D>(const Points<S, D>&, const Points<S, D>&, int, int); \
  template Array<S> construct<S, D, 1>(const Points<S, D>&, const Points<S, D>&,           \
                                       const Neighbours<S>&, int);                         \
  template Array<S> construct<S, D, 2>(const Points<S, D>&, const Points<S, D>&,           \
                                       const Neighbours<S>&, int);
INSTANTIATE(double, 2)
INSTANTIATE(double, 3)
INSTANTIATE(float, 2)
INSTANTIATE(float, 3)
template void apply(const Neighbours<double>&, const double*, const double*, std::size_t, double*,
                    int);
template void apply(const Neighbours<float>&, const float*, const float*, std::size_t, float*, int);

}  // namespace hand_written
