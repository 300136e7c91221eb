// Which quadrature: that over particles leaves everything to them.
#include "mpm/cell_quadrature.hpp"

namespace recon::mpm {
namespace {

template <int D>
class ParticleQuadrature : public QuadraturePolicy<D> {
 public:
  FromParticles over_cells(const State<D>&, const std::vector<Vector<D>>&, Cells<D>&,
                           Nodes<D>&) const override {
    return {};
  }
};

}  // namespace

template <int D>
std::unique_ptr<const QuadraturePolicy<D>> make_quadrature(const Problem<D>& problem) {
  const Quadrature quadrature = problem.method.quadrature;
  if (is_cell(quadrature)) return over_cells(problem);
  if (is_gauss(quadrature)) return at_gauss_points(problem);
  return std::make_unique<ParticleQuadrature<D>>();
}

template std::unique_ptr<const QuadraturePolicy<1>> make_quadrature(const Problem<1>&);
template std::unique_ptr<const QuadraturePolicy<2>> make_quadrature(const Problem<2>&);
template std::unique_ptr<const QuadraturePolicy<3>> make_quadrature(const Problem<3>&);

}  // namespace recon::mpm
