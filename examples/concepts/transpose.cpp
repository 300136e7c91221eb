// The transpose: what goes from nodes to particles keeps force, torque and power.
//
// phi_p(x_i) are the coefficients that make a nodal value of particle values. Their transpose takes
// nodal forces f_i to particles, F_p = sum_i phi_p(x_i) f_i. As degree 1 reproduces 1, x and y,
//     sum_p F_p = sum_i f_i ,  sum_p x_p x F_p = sum_i x_i x f_i ,  sum_p F_p.v_p = sum_i f_i.v_i .
// With degree 0 only the first and the last hold.
#include <recon/points/generate.hpp>
#include <recon/recon.hpp>

#include <cmath>
#include <cstdio>

struct Sums {
  double force = 0, torque = 0, power = 0;
};

Sums sums_over(const std::vector<std::array<double, 2>>& x, const Eigen::MatrixXd& f,
               const Eigen::MatrixXd& v) {
  Sums sums;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sums.force += f(i, 0);
    sums.torque += x[i][0] * f(i, 1) - x[i][1] * f(i, 0);
    sums.power += f.row(i).dot(v.row(i));
  }
  return sums;
}

int main() {
  const auto particles = recon::jittered_points<double, 2>(20, 0.3, 1);
  const auto nodes = recon::regular_points<double, 2>(8);
  Eigen::MatrixXd velocity(particles.size(), 2), force(nodes.size(), 2);
  for (std::size_t p = 0; p < particles.size(); ++p)
    velocity.row(p) << std::sin(3 * particles[p][1]), std::cos(2 * particles[p][0]);
  for (std::size_t i = 0; i < nodes.size(); ++i) force.row(i) << 1 + nodes[i][1], 4 * nodes[i][0];

  for (const int degree : {0, 1}) {
    const auto fit = recon::reconstruct(recon::points_of(particles), recon::points_of(nodes),
                                        {.degree = degree});
    const Sums at_nodes = sums_over(nodes, force, fit.apply(recon::field_of(velocity)));
    const Sums at_particles =
        sums_over(particles, fit.apply_transpose(recon::field_of(force)), velocity);
    std::printf("degree %d: force %.4f and %.4f, torque %.4f and %.4f, power %.4f and %.4f\n",
                degree, at_nodes.force, at_particles.force, at_nodes.torque, at_particles.torque,
                at_nodes.power, at_particles.power);
  }
}

// Output
// degree 0: force 96.0000 and 96.0000, torque 31.7500 and 31.9636, power 91.0938 and 91.0938
// degree 1: force 96.0000 and 96.0000, torque 31.7500 and 31.7500, power 90.9621 and 90.9621
