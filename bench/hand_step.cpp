#include "hand_step.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace hand_written {
namespace {

// The nearest place inside of the cell, as recon has it.
constexpr double hair = 1e-14;

typedef std::int64_t FourBits __attribute__((vector_size(32)));
typedef std::int64_t EightBits __attribute__((vector_size(64)));

template <class Lanes>
Lanes loaded(const double* from) {
  Lanes out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

// log x = 2 artanh((m - 1) / (m + 1)) + k log 2 with x = m 2^k, m from sqrt(1/2) to sqrt(2): eleven
// terms of the series are exact to rounding. For positive numbers that are not tiny.
template <class Lanes>
Lanes log_of(Lanes x) {
  using Bits = std::conditional_t<sizeof(Lanes) == sizeof(FourBits), FourBits, EightBits>;
  constexpr std::int64_t root_half = 0x3fe6a09e667f3bcd;
  Bits bits;
  std::memcpy(&bits, &x, sizeof bits);
  const Bits k = (bits - root_half) >> 52;  // floor(log2(x sqrt(2)))
  bits -= k << 52;
  Lanes m;
  std::memcpy(&m, &bits, sizeof m);
  const Lanes s = (m - 1) / (m + 1), s2 = s * s;
  Lanes sum = Lanes{} + 1.0 / 21;
  for (int n = 19; n > 0; n -= 2) sum = sum * s2 + 1.0 / n;
  return 2 * s * sum + __builtin_convertvector(k, Lanes) * 0.693147180559945309417;
}

}  // namespace

template <int D>
MpmStep<D>::MpmStep(int cells, const std::vector<Place>& x, const std::vector<Place>& v,
                    double volume, double density, double lambda, double mu)
    : cells_(cells),
      count_(x.size()),
      h_(1.0 / cells),
      mass_(density * volume),
      volume_(volume),
      lambda_(lambda),
      mu_(mu),
      energy_(count_),
      number_(count_) {
  std::size_t nodes = 1;
  for (int d = 0; d < D; ++d) {
    cell_count_ *= static_cast<std::size_t>(cells);
    nodes *= static_cast<std::size_t>(cells) + 1;
  }
  for (int d = 0; d < D; ++d) {
    x_[d].resize(count_);
    v_[d].resize(count_);
    for (std::size_t p = 0; p < count_; ++p) {
      x_[d][p] = x[p][d];
      v_[d][p] = v[p][d];
    }
  }
  for (int i = 0; i < D * D; ++i) {
    F_[i].assign(count_, i / D == i % D);
    pull_[i].assign(count_, 0);
  }
  std::iota(number_.begin(), number_.end(), 0u);
  node_mass_.resize(nodes);
  for (auto* each : {&momentum_, &force_, &velocity_, &acceleration_}) each->resize(nodes);
  sort();
}

template <int D>
std::vector<typename MpmStep<D>::Place> MpmStep<D>::in_order(
    const std::array<Numbers, D>& of) const {
  std::vector<Place> all(count_);
  for (std::size_t p = 0; p < count_; ++p)
    for (int d = 0; d < D; ++d) all[number_[p]][d] = of[d][p];
  return all;
}

template <int D>
std::size_t MpmStep<D>::cell_of(std::size_t p) const {
  std::size_t cell = 0;
  for (int d = D - 1; d >= 0; --d)
    cell = cell * static_cast<std::size_t>(cells_) +
           static_cast<std::size_t>(std::clamp(static_cast<int>(x_[d][p] / h_), 0, cells_ - 1));
  return cell;
}

template <int D>
void MpmStep<D>::sort() {
  std::vector<std::uint32_t> cell(count_), to(count_);
  first_.assign(cell_count_ + 1, 0);
  for (std::size_t p = 0; p < count_; ++p) {
    cell[p] = static_cast<std::uint32_t>(cell_of(p));
    ++first_[cell[p] + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t p = 0; p < count_; ++p) to[p] = next[cell[p]]++;
  const auto move = [&](auto& values) {
    auto sorted = values;
    for (std::size_t p = 0; p < count_; ++p) sorted[to[p]] = values[p];
    values.swap(sorted);
  };
  for (auto* of : {&x_, &v_})
    for (Numbers& each : *of) move(each);
  for (auto* of : {&F_, &pull_})
    for (Numbers& each : *of) move(each);
  move(energy_);
  move(number_);
}

template <int D>
void MpmStep<D>::look(std::size_t cell, std::array<std::uint32_t, corners>& node,
                      Place& low) const {
  const auto along = static_cast<std::size_t>(cells_);
  std::size_t base = 0, stride = 1;
  std::array<std::size_t, D> strides;
  for (int d = 0; d < D; ++d, cell /= along, stride *= along + 1) {
    low[d] = static_cast<double>(cell % along);
    base += cell % along * stride;
    strides[d] = stride;
  }
  for (int b = 0; b < corners; ++b) {
    std::size_t at = base;
    for (int d = 0; d < D; ++d) at += b >> d & 1 ? strides[d] : 0;
    node[b] = static_cast<std::uint32_t>(at);
  }
}

template <int D>
void MpmStep<D>::add_cell(std::size_t cell) {
  std::array<std::uint32_t, corners> node;
  Place low;
  look(cell, node, low);
  Lanes lower[D], sign[D];  // the functions are lower + sign xi
  for (int d = 0; d < D; ++d)
    for (int b = 0; b < corners; ++b) {
      lower[d][b] = b >> d & 1 ? 0 : 1;
      sign[d][b] = b >> d & 1 ? 1 : -1;
    }
  const double per_h = 1 / h_;
  Lanes mass = {}, momentum[D] = {}, force[D] = {};
  for (std::size_t p = first_[cell]; p < first_[cell + 1]; ++p) {
    Lanes N[D], S = Lanes{} + 1;
    for (int d = 0; d < D; ++d) {
      const double xi = std::clamp(x_[d][p] * per_h - low[d], hair, 1 - hair);
      N[d] = lower[d] + sign[d] * xi;
      S *= N[d];
    }
    mass += S;
    for (int d = 0; d < D; ++d) momentum[d] += S * v_[d][p];
    for (int e = 0; e < D; ++e) {
      Lanes G = sign[e] * per_h;
      for (int d = 0; d < D; ++d)
        if (d != e) G *= N[d];
      for (int d = 0; d < D; ++d) force[d] += G * pull_[d * D + e][p];
    }
  }
  for (int b = 0; b < corners; ++b) {
    node_mass_[node[b]] += mass_ * mass[b];
    for (int d = 0; d < D; ++d) {
      momentum_[node[b]][d] += mass_ * momentum[d][b];
      force_[node[b]][d] += force[d][b];
    }
  }
}

template <int D>
void MpmStep<D>::move_cell(std::size_t cell, double dt, double kick, bool& left) {
  std::array<std::uint32_t, corners> node;
  Place low;
  look(cell, node, low);
  Place velocity[corners], acceleration[corners];
  for (int b = 0; b < corners; ++b) {
    velocity[b] = velocity_[node[b]];
    acceleration[b] = acceleration_[node[b]];
  }
  const double per_h = 1 / h_;
  const std::size_t end = first_[cell + 1];
  for (std::size_t begin = first_[cell]; begin < end; begin += corners) {
    const auto there = static_cast<int>(std::min<std::size_t>(corners, end - begin));
    const bool full = there == corners;
    // Lanes beyond the last particle repeat it.
    const auto load = [&](const Numbers& from) -> Lanes {
      if (full) return loaded<Lanes>(&from[begin]);
      Lanes out = {};
      for (int l = 0; l < corners; ++l)
        out[l] = from[begin + static_cast<std::size_t>(std::min(l, there - 1))];
      return out;
    };
    const auto store = [&](Numbers& to, const Lanes& values) {
      std::memcpy(&to[begin], &values, sizeof(double) * static_cast<std::size_t>(there));
    };
    Lanes x[D], upper[D];
    for (int d = 0; d < D; ++d) {
      x[d] = load(x_[d]);
      Lanes xi = x[d] * per_h - low[d];
      xi = xi < hair ? Lanes{} + hair : xi;
      upper[d] = xi > 1 - hair ? Lanes{} + (1 - hair) : xi;
    }
    Lanes v[D] = {}, a[D] = {}, L[D][D] = {};
    for (int b = 0; b < corners; ++b) {
      Lanes N[D], S = Lanes{} + 1;
      for (int d = 0; d < D; ++d) {
        N[d] = b >> d & 1 ? upper[d] : 1 - upper[d];
        S *= N[d];
      }
      for (int d = 0; d < D; ++d) {
        v[d] += S * velocity[b][d];
        a[d] += S * acceleration[b][d];
      }
      for (int e = 0; e < D; ++e) {
        Lanes G = Lanes{} + (b >> e & 1 ? per_h : -per_h);
        for (int d = 0; d < D; ++d)
          if (d != e) G *= N[d];
        for (int d = 0; d < D; ++d) L[d][e] += G * velocity[b][d];
      }
    }
    Lanes before[D][D], F[D][D];
    for (int i = 0; i < D * D; ++i) before[i / D][i % D] = load(F_[i]);
    for (int i = 0; i < D; ++i)
      for (int j = 0; j < D; ++j) {
        Lanes rate = {};
        for (int k = 0; k < D; ++k) rate += L[i][k] * before[k][j];
        F[i][j] = before[i][j] + dt * rate;
        store(F_[i * D + j], F[i][j]);
      }
    Lanes J;
    if constexpr (D == 2)
      J = F[0][0] * F[1][1] - F[0][1] * F[1][0];
    else
      J = F[0][0] * (F[1][1] * F[2][2] - F[1][2] * F[2][1]) -
          F[0][1] * (F[1][0] * F[2][2] - F[1][2] * F[2][0]) +
          F[0][2] * (F[1][0] * F[2][1] - F[1][1] * F[2][0]);
    const Lanes log_J = log_of(J);
    Lanes trace = {};
    for (int i = 0; i < D; ++i)
      for (int j = i; j < D; ++j) {
        Lanes b = {};
        for (int k = 0; k < D; ++k) b += F[i][k] * F[j][k];
        Lanes kirchhoff = mu_ * b;
        if (i == j) {
          trace += b;
          kirchhoff += lambda_ * log_J - mu_;
        }
        const Lanes pull = -volume_ * kirchhoff;  // the volume is J of the reference's
        store(pull_[i * D + j], pull);
        if (i != j) store(pull_[j * D + i], pull);
      }
    store(energy_,
          volume_ * (lambda_ / 2 * log_J * log_J + mu_ * ((trace - double(D)) / 2 - log_J)));
    for (int d = 0; d < D; ++d) {
      x[d] += dt * v[d];
      store(x_[d], x[d]);
      store(v_[d], load(v_[d]) + kick * a[d]);
      const Lanes at = x[d] * per_h - low[d];
      const auto out = (at < 0.0) | (at >= 1.0);
      for (int l = 0; l < there; ++l) left |= out[l] != 0;
    }
  }
}

// Calls work(cell) for all cells: for the even slabs, and then for the odd ones.
template <int D>
template <class Work>
void MpmStep<D>::for_slabs(int threads, const Work& work) const {
  constexpr int thickness = 2;
  const std::size_t layer = cell_count_ / static_cast<std::size_t>(cells_);
  const int slabs = (cells_ + thickness - 1) / thickness;
  for (int colour = 0; colour < 2; ++colour) {
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int slab = colour; slab < slabs; slab += 2) {
      const auto begin = static_cast<std::size_t>(slab * thickness);
      const auto end = static_cast<std::size_t>(std::min(cells_, (slab + 1) * thickness));
      for (std::size_t cell = begin * layer; cell < end * layer; ++cell) work(cell);
    }
  }
}

template <int D>
void MpmStep<D>::operator()(double dt, int threads) {
  const double kick = (last_dt_ + dt) / 2;
  last_dt_ = dt;
  const auto nodes = static_cast<std::ptrdiff_t>(node_mass_.size());
#pragma omp parallel for num_threads(threads)
  for (std::ptrdiff_t i = 0; i < nodes; ++i) {
    node_mass_[i] = 0;
    momentum_[i] = force_[i] = {};
  }
  for_slabs(threads, [&](std::size_t cell) { add_cell(cell); });
#pragma omp parallel for num_threads(threads)
  for (std::ptrdiff_t i = 0; i < nodes; ++i)
    for (int d = 0; d < D; ++d) {
      acceleration_[i][d] = node_mass_[i] > 0 ? force_[i][d] / node_mass_[i] : 0;
      velocity_[i][d] =
          node_mass_[i] > 0 ? momentum_[i][d] / node_mass_[i] + kick * acceleration_[i][d] : 0;
    }
  bool left = false;
  const auto all = static_cast<std::ptrdiff_t>(cell_count_);
#pragma omp parallel for num_threads(threads) schedule(static) reduction(|| : left)
  for (std::ptrdiff_t cell = 0; cell < all; ++cell) {
    bool some = false;
    move_cell(static_cast<std::size_t>(cell), dt, kick, some);
    left = left || some;
  }
  if (left) sort();
}

template class MpmStep<2>;
template class MpmStep<3>;

}  // namespace hand_written
