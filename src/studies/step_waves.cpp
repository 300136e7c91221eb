#include "recon/studies/step_waves.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "recon/core/error.hpp"
#include "recon/mpm/step.hpp"

namespace recon::mpm {
namespace {

using Complex = std::complex<double>;

constexpr double small = 1e-5;     // disturbances, of both signs: what is not linear is below 1e-9
constexpr int margin = 4;          // cells between the body and the border of the grid
constexpr double rounding = 1e-6;  // of a response over the disturbance
constexpr double not_growing = 1.001;

// A body of so many cells along each axis, without stress, that moves along x.
template <int D>
class Patch {
 public:
  Patch(const Method& method, int cells, int per_cell, double courant, double offset, double speed)
      : dt_(courant), problem_(problem(method, cells)), step_(problem_) {
    Particles<D>& particles = problem_.particles;
    const int along = cells * per_cell;
    int count = 1;
    for (int d = 0; d < D; ++d) count *= along;
    for (int p = 0; p < count; ++p) {
      Vector<D> X;
      for (int d = 0, rest = p; d < D; ++d, rest /= along)
        X[d] = margin + (rest % along + 0.5) / per_cell;
      X[0] += offset;
      particles.add(X, Matrix<D>::Identity() * (0.5 / per_cell), 1, 0);
      particles.v.back()[0] = speed;
    }
    step_ = Step<D>(problem_);
    state_ = start(problem_);
    state_.last_dt = dt_;
    modes_ = state_.particles.modes.size() / state_.particles.size();
  }

  std::size_t particles() const { return state_.particles.size(); }
  const std::vector<Vector<D>>& places() const { return state_.particles.x; }
  Eigen::Index per_particle() const {
    return D + D * (D + 1) / 2 + D * D + D * static_cast<Eigen::Index>(modes_);
  }

  // What a step makes of a disturbance of one variable of one particle: the variables of all
  // particles, one after the other, over the size of the disturbance.
  Eigen::VectorXd response(std::size_t particle, Eigen::Index variable) {
    return (after(particle, variable, small) - after(particle, variable, -small)) / (2 * small);
  }

 private:
  static Problem<D> problem(const Method& method, int cells) {
    Problem<D> problem;
    // An even number of cells, for elements of 2 x 2.
    const double upper = 2 * margin + cells + cells % 2;
    problem.grid = Grid<D>(Vector<D>::Zero(), Vector<D>::Constant(upper), 1.0);
    problem.materials = {LinearElastic{Lame{0, 0.5}}};
    problem.densities = {1};
    problem.method = method;
    problem.threads = 1;
    return problem;
  }

  Eigen::VectorXd after(std::size_t particle, Eigen::Index variable, double disturbance) {
    State<D> state = state_;
    variables(state.particles, particle, [&](Eigen::Index k, double& value, double* mirror) {
      if (k != variable) return;
      value += disturbance;
      if (mirror) *mirror += disturbance;
    });
    step_(state, dt_);
    Eigen::VectorXd all(static_cast<Eigen::Index>(particles()) * per_particle());
    for (std::size_t p = 0; p < particles(); ++p)
      variables(state.particles, p, [&](Eigen::Index k, double& value, double*) {
        all[static_cast<Eigen::Index>(p) * per_particle() + k] = value;
      });
    return all;
  }

  // Calls each(number, value, mirror) for the variables of a particle; a shear stress stands in the
  // matrix twice.
  template <class Each>
  void variables(Particles<D>& of, std::size_t p, Each each) const {
    Eigen::Index k = 0;
    for (int d = 0; d < D; ++d) each(k++, of.v[p][d], nullptr);
    for (int d = 0; d < D; ++d)
      for (int e = d; e < D; ++e)
        each(k++, of.stress[p](d, e), e == d ? nullptr : &of.stress[p](e, d));
    for (int d = 0; d < D; ++d)
      for (int e = 0; e < D; ++e) each(k++, of.L[p](d, e), nullptr);
    for (std::size_t m = 0; m < modes_; ++m)
      for (int d = 0; d < D; ++d) each(k++, of.modes[p * modes_ + m][d], nullptr);
  }

  double dt_;
  Problem<D> problem_;
  Step<D> step_;
  State<D> state_;
  std::size_t modes_ = 0;
};

double radius_of(const Eigen::MatrixXcd& matrix) {
  return Eigen::ComplexEigenSolver<Eigen::MatrixXcd>(matrix, false)
      .eigenvalues()
      .cwiseAbs()
      .maxCoeff();
}

// The phases of a period of cells: multiples of pi / n, of which waves and their mirrors along x
// are one.
template <int D>
std::vector<Vector<D>> phases(int n) {
  std::vector<Vector<D>> all;
  const double unit = std::numbers::pi / n;
  for (int i = 0; i <= n; ++i) {
    if constexpr (D == 1)
      all.push_back(Vector<1>(i * unit));
    else
      for (int j = i == 0 || i == n ? 0 : 1 - n; j <= n; ++j)
        all.push_back(Vector<2>(i * unit, j * unit));
  }
  return all;
}

// Offsets along x of the steps that cross a cell: none lies on a plane of nodes.
double offset_of(int step, int steps_per_cell) {
  return steps_per_cell > 0 ? (step + 0.37) / steps_per_cell : 0;
}
double speed_of(double courant, int steps_per_cell) {
  return steps_per_cell > 0 ? 1 / (steps_per_cell * courant) : 0;
}

template <int D>
double radius_without_end(const Method& method, int per_cell, double courant, int steps_per_cell) {
  std::vector<StepSymbol<D>> steps;
  for (int s = 0; s < std::max(1, steps_per_cell); ++s)
    steps.emplace_back(method, per_cell, courant, offset_of(s, steps_per_cell),
                       speed_of(courant, steps_per_cell));
  double most = 0;
  for (const Vector<D>& theta : phases<D>(D == 1 ? 8 : 4)) {
    Eigen::MatrixXcd product = Eigen::MatrixXcd::Identity(steps[0].size(), steps[0].size());
    for (const StepSymbol<D>& step : steps) product = step.at(theta) * product;
    most = std::max(most, radius_of(product));
  }
  return most;
}

template <int D>
double radius_of_free_body(const Method& method, int per_cell, double courant, int steps_per_cell,
                           int body_cells) {
  Eigen::MatrixXd product;
  for (int s = 0; s < std::max(1, steps_per_cell); ++s) {
    Patch<D> body(method, body_cells, per_cell, courant, offset_of(s, steps_per_cell),
                  speed_of(courant, steps_per_cell));
    const Eigen::Index n = static_cast<Eigen::Index>(body.particles()) * body.per_particle();
    Eigen::MatrixXd step(n, n);
    for (Eigen::Index k = 0; k < n; ++k)
      step.col(k) =
          body.response(static_cast<std::size_t>(k / body.per_particle()), k % body.per_particle());
    product = s == 0 ? step : Eigen::MatrixXd(step * product);
  }
  return Eigen::EigenSolver<Eigen::MatrixXd>(product, false).eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace

template <int D>
StepSymbol<D>::StepSymbol(const Method& method, int per_cell, double courant, double offset,
                          double speed) {
  recon::detail::require(per_cell > 0, "particles per cell and axis", per_cell, "must be positive");
  recon::detail::require(courant > 0, "courant", courant, "must be positive");
  period_ = is_element(method.basis) ? 2 : 1;
  int in_period = 1;
  for (int d = 0; d < D; ++d) in_period *= period_ * per_cell;
  // The patch is `reach` periods wide on each side of the one in its middle. A response that comes
  // near its border would see the end of the body.
  for (int reach = 4 + 2 * (D == 1);; reach += 4) {
    Patch<D> patch(method, (2 * reach + 1) * period_, per_cell, courant, offset, speed);
    per_particle_ = patch.per_particle();
    size_ = in_period * per_particle_;
    const int along = (2 * reach + 1) * period_ * per_cell, in_one = period_ * per_cell;
    // The number of the period of a particle, from the middle, and its number there.
    const auto place = [&](int p, Vector<D>& period) {
      int number = 0;
      for (int d = 0, rest = p, factor = 1; d < D; ++d, rest /= along, factor *= in_one) {
        const int at = rest % along;
        period[d] = at / in_one - reach;
        number += factor * (at % in_one);
      }
      return number;
    };
    std::vector<int> middle(static_cast<std::size_t>(in_period));
    std::vector<Block> found;
    places_.assign(middle.size(), Vector<D>::Zero());
    int periods = 1;
    for (int d = 0; d < D; ++d) periods *= 2 * reach + 1;
    found.resize(static_cast<std::size_t>(periods),
                 {Vector<D>::Zero(), Eigen::MatrixXd::Zero(size_, size_)});
    const auto block = [&](const Vector<D>& period) -> Block& {
      std::size_t number = 0;
      for (int d = D - 1; d >= 0; --d)
        number = number * static_cast<std::size_t>(2 * reach + 1) +
                 static_cast<std::size_t>(period[d] + reach);
      return found[number];
    };
    const int count = static_cast<int>(patch.particles());
    for (int p = 0; p < count; ++p) {
      Vector<D> period;
      const int number = place(p, period);
      block(period).cells = period * period_;
      if (period.isZero()) {
        middle[static_cast<std::size_t>(number)] = p;
        places_[static_cast<std::size_t>(number)] = patch.places()[static_cast<std::size_t>(p)];
      }
    }
    double at_border = 0;
    for (int k = 0; k < size_; ++k) {
      const Eigen::VectorXd response = patch.response(
          static_cast<std::size_t>(middle[static_cast<std::size_t>(k / per_particle_)]),
          k % per_particle_);
      for (int p = 0; p < count; ++p) {
        Vector<D> period;
        const int number = place(p, period);
        const auto part = response.segment(p * per_particle_, per_particle_);
        block(period).response.block(number * per_particle_, k, per_particle_, 1) = part;
        if (period.cwiseAbs().maxCoeff() * period_ > reach * period_ - 3)
          at_border = std::max(at_border, part.cwiseAbs().maxCoeff());
      }
    }
    if (at_border < rounding) {
      for (Block& each : found)
        if (each.response.cwiseAbs().maxCoeff() > 0) blocks_.push_back(std::move(each));
      return;
    }
    if (reach > 40)
      recon::detail::throw_invalid("method", method.name,
                                   "carries a disturbance farther than 40 cells in a step");
  }
}

template <int D>
Eigen::MatrixXcd StepSymbol<D>::at(const Vector<D>& theta) const {
  Eigen::MatrixXcd sum = Eigen::MatrixXcd::Zero(size_, size_);
  // What is `cells` away from a disturbance sees it there: z'_0 = sum_c J(from c to 0) z_c.
  for (const Block& each : blocks_)
    sum += std::exp(Complex(0, -theta.dot(each.cells))) * each.response;
  return sum;
}

template <int D>
Eigen::VectorXcd StepSymbol<D>::wave(const Vector<D>& theta) const {
  Eigen::VectorXcd z = Eigen::VectorXcd::Zero(size_);
  for (std::size_t p = 0; p < places_.size(); ++p)
    z[static_cast<Eigen::Index>(p) * per_particle_] =
        std::exp(Complex(0, theta.dot(places_[p] - places_[0])));
  return z;
}

StepWave step_wave(const Method& method, int per_cell, double courant, double kh) {
  recon::detail::require(kh > 0 && kh <= std::numbers::pi, "k h", kh, "must be in (0, pi]");
  const StepSymbol<1> symbol(method, per_cell, courant);
  const Vector<1> theta(kh);
  const Eigen::ComplexEigenSolver<Eigen::MatrixXcd> solver(symbol.at(theta));
  const Eigen::VectorXcd wave = symbol.wave(theta);
  // The parts of the eigenvectors in the wave, and what of them is velocity like it after half a
  // period of a wave without dispersion.
  const Eigen::VectorXcd parts = solver.eigenvectors().fullPivLu().solve(wave);
  double most = -1;
  Complex lambda = 1;
  for (Eigen::Index k = 0; k < parts.size(); ++k) {
    const Complex each = solver.eigenvalues()[k];
    if (std::abs(each - 1.0) < 1e-6) continue;  // unseen by the grid
    const double part = std::abs(parts[k] * wave.dot(solver.eigenvectors().col(k))) *
                        std::pow(std::abs(each), std::numbers::pi / (courant * kh));
    if (part > most) {
      most = part;
      lambda = each;
    }
  }
  const double turn = std::abs(std::arg(lambda));
  return {turn / (courant * kh),
          turn > 0 ? 1 - std::pow(std::abs(lambda), 2 * std::numbers::pi / turn) : 1.0};
}

double spectral_radius(const Method& method, int dimension, int per_cell, double courant,
                       int steps_per_cell, bool free, int body_cells) {
  recon::detail::require(dimension == 1 || dimension == 2, "dimension", dimension,
                         "must be 1 or 2");
  recon::detail::require(steps_per_cell >= 0, "steps per cell", steps_per_cell,
                         "must not be negative");
  recon::detail::require(body_cells > 0, "cells of the body", body_cells, "must be positive");
  if (free)
    return dimension == 1
               ? radius_of_free_body<1>(method, per_cell, courant, steps_per_cell, body_cells)
               : radius_of_free_body<2>(method, per_cell, courant, steps_per_cell, body_cells);
  return dimension == 1 ? radius_without_end<1>(method, per_cell, courant, steps_per_cell)
                        : radius_without_end<2>(method, per_cell, courant, steps_per_cell);
}

double largest_step_by_eigenvalues(const Method& method, int dimension, int per_cell, bool free) {
  const auto stable = [&](double courant) {
    try {
      return spectral_radius(method, dimension, per_cell, courant, 0, free) <= not_growing;
    } catch (const Failure&) {
      return false;
    }
  };
  double low = 0, high = 4;
  while (high - low > 0.005) {
    const double middle = (low + high) / 2;
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

template class StepSymbol<1>;
template class StepSymbol<2>;

}  // namespace recon::mpm
