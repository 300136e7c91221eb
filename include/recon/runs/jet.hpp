// Numbers that carry their first and second derivatives with respect to N variables.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace recon::mpm {

template <int N>
struct Jet {
  using First = Eigen::Matrix<double, N, 1>;
  using Second = Eigen::Matrix<double, N, N>;

  double value = 0;
  First first = First::Zero();
  Second second = Second::Zero();

  Jet() = default;
  Jet(double constant) : value(constant) {}  // NOLINT: constants mix with jets
  // The variable with number i and this value.
  static Jet variable(double value, int i) {
    Jet x(value);
    x.first[i] = 1;
    return x;
  }
  // The jet of f(x), from the value of f and its first two derivatives at x.value.
  static Jet chain(const Jet& x, double f, double df, double ddf) {
    Jet out(f);
    out.first = df * x.first;
    out.second = df * x.second + ddf * x.first * x.first.transpose();
    return out;
  }

  friend Jet operator+(Jet a, const Jet& b) {
    a.value += b.value;
    a.first += b.first;
    a.second += b.second;
    return a;
  }
  friend Jet operator-(const Jet& a) { return chain(a, -a.value, -1, 0); }
  friend Jet operator-(const Jet& a, const Jet& b) { return a + (-b); }
  friend Jet operator*(const Jet& a, const Jet& b) {
    Jet out(a.value * b.value);
    out.first = a.value * b.first + b.value * a.first;
    out.second = a.value * b.second + b.value * a.second + a.first * b.first.transpose() +
                 b.first * a.first.transpose();
    return out;
  }
  friend Jet operator/(const Jet& a, const Jet& b) {
    const double r = 1 / b.value;
    return a * chain(b, r, -r * r, 2 * r * r * r);
  }
  friend Jet sin(const Jet& a) {
    const double s = std::sin(a.value);
    return chain(a, s, std::cos(a.value), -s);
  }
  friend Jet cos(const Jet& a) {
    const double c = std::cos(a.value);
    return chain(a, c, -std::sin(a.value), -c);
  }
  friend Jet sqrt(const Jet& a) {
    const double r = std::sqrt(a.value);
    return chain(a, r, 0.5 / r, -0.25 / (r * a.value));
  }
};

}  // namespace recon::mpm
