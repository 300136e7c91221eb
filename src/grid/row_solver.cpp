#include <cmath>
#include <limits>

#include "core/instantiate.hpp"
#include "grid/node_fit.hpp"
#include "recon/basis/monomials.hpp"
#include "recon/local_solve/fill_report.hpp"

namespace recon {
namespace {

constexpr std::int8_t not_safe = -2;  // FitReport::degree of nodes that still want a fit

}  // namespace

template <class Scalar>
NodeFits<Scalar>::NodeFits(const GridPlan<Scalar>& plan, bool with_gradients)
    : values(plan.grid.size(), plan.components),
      gradients(with_gradients ? plan.grid.size() : 0,
                with_gradients ? plan.components * plan.dimension() : 0),
      reports(plan.grid.size()) {}

template <class Scalar>
std::vector<std::size_t> NodeFits<Scalar>::unsafe() const {
  std::vector<std::size_t> nodes;
  for (std::size_t i = 0; i < reports.size(); ++i)
    if (reports[i].degree == not_safe) nodes.push_back(i);
  return nodes;
}

template <class Scalar>
RowSolver<Scalar>::RowSolver(const GridPlan<Scalar>& plan, const LaneLayout& lanes,
                             NodeFits<Scalar>& fits)
    : plan_(plan),
      lanes_(lanes),
      fits_(fits),
      out_size_(static_cast<std::size_t>(NodeRow<Scalar>::head +
                                         plan.components *
                                             (fits.has_gradients() ? 1 + plan.dimension() : 1))),
      noise_(static_cast<std::size_t>(lanes.groups * lanes.lanes)),
      out_(static_cast<std::size_t>(lanes.groups * lanes.lanes) * out_size_) {
  with_shape(plan, [&](auto d, auto r) { full_ = detail::report_of<Monomials<d, r>>({}); });
  full_.hessian_rank = 0;
}

template <class Scalar>
void RowSolver<Scalar>::set_noise(const FinishedRow<Scalar>& row) {
  std::fill_n(noise_.data(), lanes_.groups * lanes_.lanes, Scalar(1));
  for (std::int64_t i = 0; i < row.width; ++i)
    noise_.data()[lanes_.entry(i) * lanes_.lanes + lanes_.lane(i)] =
        node_noise(plan_, {static_cast<std::size_t>(row.first + i), static_cast<std::size_t>(row.j),
                           static_cast<std::size_t>(row.k)});
}

template <class Scalar>
void RowSolver<Scalar>::operator()(const FinishedRow<Scalar>& row) {
  set_noise(row);
  NodeRow<Scalar> nodes{};
  nodes.groups = lanes_.groups;
  nodes.components = plan_.components;
  nodes.gradients = fits_.has_gradients();
  nodes.tolerances = plan_.options.tolerances;
  for (int d = 0; d < plan_.dimension(); ++d)
    nodes.inverse_rho[d] = static_cast<Scalar>(1 / plan_.axes[d].rho);
  nodes.row = row.moments;
  nodes.noise = noise_.data();
  nodes.out = out_.data();
  plan_.kernel.solve(nodes);

  const auto lanes = static_cast<std::size_t>(lanes_.lanes);
  const auto quantities = static_cast<std::size_t>(plan_.quantities());
  const std::size_t first = plan_.node(row.first, row.j, row.k);
  for (std::int64_t i = 0; i < row.width; ++i) {
    const std::size_t entry = lanes_.entry(i), lane = lanes_.lane(i);
    const Scalar* moments = row.moments + entry * quantities * lanes + lane;
    take(first + static_cast<std::size_t>(i), out_.data() + entry * out_size_ * lanes + lane,
         static_cast<std::size_t>(moments[0]), moments[lanes]);
  }
}

// Have sums and results neither overflowed nor become so small that they lost digits?
template <class Scalar>
bool RowSolver<Scalar>::in_range(const Scalar* out, Scalar weight_sum) const {
  using Limits = std::numeric_limits<Scalar>;
  const auto lanes = static_cast<std::size_t>(lanes_.lanes);
  if (!(weight_sum >= Limits::min() / Limits::epsilon() && weight_sum <= Limits::max()))
    return false;
  Scalar sum = 0;  // of x - x, which is NaN for what is not finite
  for (std::size_t i = NodeRow<Scalar>::head; i < out_size_; ++i)
    sum += out[i * lanes] - out[i * lanes];
  return sum == 0;
}

// count: neighbours.
template <class Scalar>
void RowSolver<Scalar>::take(std::size_t node, const Scalar* out, std::size_t count,
                             Scalar weight_sum) {
  const auto lanes = static_cast<std::size_t>(lanes_.lanes);
  const auto at = static_cast<Eigen::Index>(node);
  FitReport& report = fits_.reports[node];
  const int dimension = fits_.has_gradients() ? plan_.dimension() : 0;
  if (out[0] != 0 && in_range(out, weight_sum)) {
    report = full_;
    detail::set_numbers(
        {Solver::moment_matrix, static_cast<std::uint32_t>(count), static_cast<float>(out[lanes]),
         static_cast<float>(out[2 * lanes]), static_cast<float>(out[3 * lanes])},
        report);
    out += NodeRow<Scalar>::head * lanes;
    for (int c = 0; c < plan_.components; ++c) {
      fits_.values(at, c) = *out;
      out += lanes;
      for (int d = 0; d < dimension; ++d, out += lanes)
        fits_.gradients(at, c * dimension + d) = *out;
    }
    return;
  }
  report = {};
  if (!(weight_sum <= 0)) report.degree = not_safe;
  const auto fill = static_cast<Scalar>(plan_.options.fill_value);
  for (int c = 0; c < plan_.components; ++c) fits_.values(at, c) = fill;
  for (int c = 0; c < plan_.components * dimension; ++c) fits_.gradients(at, c) = fill;
}

RECON_FLOAT(template struct NodeFits<float>;)
template struct NodeFits<double>;
RECON_FLOAT(template class RowSolver<float>;)
template class RowSolver<double>;

}  // namespace recon
