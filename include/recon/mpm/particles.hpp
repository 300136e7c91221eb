// What the particles of all bodies carry from step to step.
//
// A particle is a piece of material with reference volume `volume0` and mass `mass`. Its domain is
// a parallelepiped about x with half edges F * half_edges (columns; Gong 2015, eq. 6.21); CPDI2
// tracks the corners themselves. Corner number a of a domain lies on the positive side of half edge
// d where bit d of a is set.
#pragma once

#include <Eigen/LU>
#include <array>
#include <cstdint>
#include <vector>

#include "recon/mpm/types.hpp"
#include "recon/transfer/domain_functions.hpp"

namespace recon::mpm {

template <int D>
struct Particles {
  static constexpr int corner_count = 1 << D;
  using Corners = DomainCorners<D>;

  std::vector<Vector<D>> X, x;        // reference and current position, length
  std::vector<Vector<D>> v;           // velocity half a step before the current time, length / time
  std::vector<Matrix<D>> F;           // deformation gradient dx / dX
  std::vector<Matrix<D>> L;           // velocity gradient d v_i / d x_j, 1 / time
  std::vector<Matrix<D>> stress;      // Cauchy stress, force / area
  std::vector<Matrix<D>> half_edges;  // of the reference domain
  std::vector<double> mass, volume0;
  std::vector<double> energy;      // strain energy of the particle
  std::vector<std::int32_t> body;  // number of its body
  std::vector<Corners> corners;    // of CPDI2 only, else empty
  // The coefficients of the polynomials about the particle that its velocity field has beyond v;
  // those of one particle are consecutive. Only for the maps affine (apic) and polynomial
  // (polypic), else empty
  std::vector<Vector<D>> modes;

  std::size_t size() const { return x.size(); }
  double volume(std::size_t p) const { return F[p].determinant() * volume0[p]; }
  double density(std::size_t p) const { return mass[p] / volume(p); }

  ParallelepipedDomain<D> parallelepiped(std::size_t p) const {
    return {x[p], F[p] * half_edges[p]};
  }
  // The corners of the parallelepiped of a particle.
  Corners domain(std::size_t p) const { return corners_of(parallelepiped(p)); }

  // Adds a particle that is at rest and undeformed.
  void add(const Vector<D>& at, const Matrix<D>& half, double density, int of_body) {
    X.push_back(at);
    x.push_back(at);
    v.push_back(Vector<D>::Zero());
    F.push_back(Matrix<D>::Identity());
    L.push_back(Matrix<D>::Zero());
    stress.push_back(Matrix<D>::Zero());
    half_edges.push_back(half);
    volume0.push_back((1 << D) * std::abs(half.determinant()));
    mass.push_back(density * volume0.back());
    energy.push_back(0);
    body.push_back(of_body);
  }
};

}  // namespace recon::mpm
