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

// How many entries of the arrays that not every run needs belong to one particle; of all other
// arrays it is one.
struct Kept {
  std::size_t corners = 0;  // 1 for CPDI2
  std::size_t modes = 0;    // of the maps affine and polynomial
  std::size_t history = 0;  // of the material that needs most
};

// An array of the particles in the list of all.
struct ParticleArray {
  const char* name;
  std::size_t per_particle = 1;  // entries, those of one particle consecutive
  bool kept = false;             // one of Kept: made at the start where it is not given
};

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
  std::vector<double> history;  // variables of materials that remember (material.hpp), else empty

  // Calls each(ParticleArray, array) for every array. This is the one list of them: validation,
  // checkpoints, the forecast of memory and whatever else goes through all arrays use it.
  template <class Each>
  void arrays(const Kept& kept, Each&& each) {
    list(*this, kept, each);
  }
  template <class Each>
  void arrays(const Kept& kept, Each&& each) const {
    list(*this, kept, each);
  }

  std::size_t size() const { return x.size(); }
  double volume(std::size_t p) const { return F[p].determinant() * volume0[p]; }
  double density(std::size_t p) const { return mass[p] / volume(p); }

  ParallelepipedDomain<D> parallelepiped(std::size_t p) const {
    return {x[p], F[p] * half_edges[p]};
  }
  // Where the place X_p + offset of the reference domain is now: x_p + F offset, and with tracked
  // corners the place between them that has the same parts of the edges on both sides. The place
  // of offset 0 is x_p.
  Vector<D> place(std::size_t p, const Vector<D>& offset) const {
    if (corners.empty() || offset.isZero()) return x[p] + F[p] * offset;
    const Vector<D> xi = half_edges[p].inverse() * offset;
    Vector<D> at = Vector<D>::Zero();
    for (std::size_t a = 0; a < corner_count; ++a) {
      double part = 1;
      for (int d = 0; d < D; ++d) part *= (a >> d & 1 ? 1 + xi[d] : 1 - xi[d]) / 2;
      at += part * corners[p][a];
    }
    return at;
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

 private:
  template <class Self, class Each>
  static void list(Self& of, const Kept& kept, Each& each) {
    each(ParticleArray{"x"}, of.x);
    each(ParticleArray{"X"}, of.X);
    each(ParticleArray{"v"}, of.v);
    each(ParticleArray{"F"}, of.F);
    each(ParticleArray{"L"}, of.L);
    each(ParticleArray{"stress"}, of.stress);
    each(ParticleArray{"half_edges"}, of.half_edges);
    each(ParticleArray{"mass"}, of.mass);
    each(ParticleArray{"volume0"}, of.volume0);
    each(ParticleArray{"energy"}, of.energy);
    each(ParticleArray{"body"}, of.body);
    each(ParticleArray{"corners", kept.corners, true}, of.corners);
    each(ParticleArray{"modes", kept.modes, true}, of.modes);
    each(ParticleArray{"history", kept.history, true}, of.history);
  }
};

}  // namespace recon::mpm
