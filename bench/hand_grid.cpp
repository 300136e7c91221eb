#include "hand_grid.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>

namespace hand_written {
namespace {

typedef double Eight __attribute__((vector_size(64)));
Eight all(double a) {
  return Eight{a, a, a, a, a, a, a, a};
}
Eight load(const double* from) {
  Eight v;
  std::memcpy(&v, from, sizeof(v));
  return v;
}

// Moments of a node: 1; r_d; r_d r_e, d <= e; then for each component u and u r_d.
constexpr int moments = 22, first_square = 4, first_velocity = 10;
constexpr int together = 3;  // products in registers at once
constexpr int products = (moments + together - 1) / together * together;
constexpr int most = 32;  // particles of one block

// Weights at the nodes -1, 0, 1, 2 of a cell, at f in [0, 1) from its lower face.
std::array<double, 4> spline(double f) {
  const double g = 1 - f;
  return {g * g * g / 6, 2.0 / 3 - f * f * (1 - f / 2), 2.0 / 3 - g * g * (1 - g / 2),
          f * f * f / 6};
}

// Sums of some particles of a cell at its 64 nodes, node x + 4 y + 16 z.
struct Block {
  alignas(64) double weight[most][64];
  alignas(64) double product[most][products];
  alignas(64) double sum[products][64];

  // f: place in the cell, from 0 to 1.
  void set(int i, const std::array<double, 3>& f, const std::array<double, 3>& u) {
    const auto wx = spline(f[0]), wy = spline(f[1]), wz = spline(f[2]);
    double* w = weight[i];
    for (int z = 0; z < 4; ++z)
      for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) *w++ = wz[z] * wy[y] * wx[x];
    double* q = product[i];
    double r[3];
    q[0] = 1;
    int n = first_square;
    for (int d = 0; d < 3; ++d) q[1 + d] = r[d] = f[d] - 0.5;
    for (int d = 0; d < 3; ++d)
      for (int e = d; e < 3; ++e) q[n++] = r[d] * r[e];
    for (int c = 0; c < 3; ++c) {
      q[n++] = u[c];
      for (int d = 0; d < 3; ++d) q[n++] = u[c] * r[d];
    }
    while (n < products) q[n++] = 0;
  }

  void multiply(int count, bool first) {
    for (int q = 0; q < products; q += together) {
      Eight part[together][8];
      for (int j = 0; j < together; ++j)
        for (int v = 0; v < 8; ++v) part[j][v] = first ? all(0) : load(sum[q + j] + 8 * v);
      for (int i = 0; i < count; ++i)
        for (int v = 0; v < 8; ++v) {
          const Eight w = load(weight[i] + 8 * v);
          for (int j = 0; j < together; ++j) part[j][v] += all(product[i][q + j]) * w;
        }
      for (int j = 0; j < together; ++j) std::memcpy(sum[q + j], part[j], sizeof(part[j]));
    }
  }

  // From offsets from the cell's centre to those from each node.
  void shift() {
    for (int v = 0; v < 8; ++v) {
      Eight by[3];
      for (int l = 0; l < 8; ++l) {
        const int node = 8 * v + l;
        by[0][l] = 1.5 - (node & 3);
        by[1][l] = 1.5 - (node >> 2 & 3);
        by[2][l] = 1.5 - (node >> 4);
      }
      const auto at = [&](int q) { return load(sum[q] + 8 * v); };
      const auto put = [&](int q, Eight value) { std::memcpy(sum[q] + 8 * v, &value, 64); };
      const Eight one = at(0);
      for (int d = 0, q = first_square; d < 3; ++d)
        for (int e = d; e < 3; ++e, ++q)
          put(q, at(q) + by[d] * at(1 + e) + by[e] * (at(1 + d) + by[d] * one));
      for (int d = 0; d < 3; ++d) put(1 + d, at(1 + d) + by[d] * one);
      for (int c = 0; c < 3; ++c)
        for (int d = 0; d < 3; ++d) {
          const int u = first_velocity + 4 * c;
          put(u + 1 + d, at(u + 1 + d) + by[d] * at(u));
        }
    }
  }
};

// Rows of nodes along x with all their moments: [z][y][moment][x]; nodes -1 to cells + 1, padded.
struct Slab {
  int from = 0, planes = 0;  // planes of nodes, the first of which is number `from`, from node -1
  std::size_t row = 0, plane = 0;
  std::unique_ptr<double[]> memory;

  void make(int first, int count, int along) {
    from = first;
    planes = count;
    row = (static_cast<std::size_t>(along) + 7) / 8 * 8 + 8;
    plane = static_cast<std::size_t>(along) * moments * row;
    memory.reset(new double[plane * static_cast<std::size_t>(count)]());
  }
  double* at(int z, int y) {
    return memory.get() + static_cast<std::size_t>(z - from) * plane +
           static_cast<std::size_t>(y) * moments * row;
  }
};

// The velocities at eight nodes from their moments.
void solve(const Eight* m, Eight* velocity) {
  constexpr int entry[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};
  Eight scaled[4][4], inverse[4];  // L D, and 1 / D
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j <= i; ++j) {
      Eight s = m[entry[i][j]];
      for (int k = 0; k < j; ++k) s -= scaled[i][k] * scaled[j][k] * inverse[k];
      scaled[i][j] = s;
      if (i == j) inverse[i] = 1 / s;
    }
  for (int c = 0; c < 3; ++c) {
    Eight a[4];
    for (int i = 0; i < 4; ++i) {
      a[i] = m[first_velocity + 4 * c + i];
      for (int j = 0; j < i; ++j) a[i] -= scaled[i][j] * a[j];
      a[i] *= inverse[i];
    }
    for (int i = 3; i >= 0; --i)
      for (int j = i + 1; j < 4; ++j) a[i] -= scaled[j][i] * inverse[i] * a[j];
    velocity[c] = a[0];
  }
}

}  // namespace

std::vector<std::array<double, 3>> velocity_on_grid(const std::vector<std::array<double, 3>>& x,
                                                    const std::vector<std::array<double, 3>>& u,
                                                    int cells, int threads) {
  const std::size_t n = x.size(), along = static_cast<std::size_t>(cells);
  const std::size_t cell_count = along * along * along;
  std::unique_ptr<std::uint32_t[]> cell_of(new std::uint32_t[n]), order(new std::uint32_t[n]);
#pragma omp parallel for num_threads(threads)
  for (std::size_t p = 0; p < n; ++p) {
    std::size_t cell = 0;
    for (int d = 2; d >= 0; --d)
      cell = cell * along +
             static_cast<std::size_t>(std::clamp(static_cast<int>(x[p][d] * cells), 0, cells - 1));
    cell_of[p] = static_cast<std::uint32_t>(cell);
  }
  std::vector<std::uint32_t> begin(cell_count + 2, 0);
  for (std::size_t p = 0; p < n; ++p) ++begin[cell_of[p] + 2];
  for (std::size_t c = 2; c < begin.size(); ++c) begin[c] += begin[c - 1];
  for (std::size_t p = 0; p < n; ++p)
    order[begin[cell_of[p] + 1]++] = static_cast<std::uint32_t>(p);

  const int rows = cells + 3;  // of nodes, with one beyond each face
  std::vector<Slab> slabs(static_cast<std::size_t>(threads));
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int t = 0; t < threads; ++t) {
    Slab& slab = slabs[static_cast<std::size_t>(t)];
    const int from = cells * t / threads, to = cells * (t + 1) / threads;
    slab.make(from, to - from + 3, rows);
    Block block;
    for (int z = from; z < to; ++z)
      for (int y = 0; y < cells; ++y)
        for (int c = 0; c < cells; ++c) {
          const std::size_t cell =
              (static_cast<std::size_t>(z) * along + static_cast<std::size_t>(y)) * along +
              static_cast<std::size_t>(c);
          const std::uint32_t end = begin[cell + 1];
          if (begin[cell] == end) continue;
          for (std::uint32_t p = begin[cell]; p < end; p += most) {
            const int count = static_cast<int>(std::min<std::uint32_t>(most, end - p));
            for (int i = 0; i < count; ++i) {
              const auto& at = x[order[p + static_cast<std::uint32_t>(i)]];
              block.set(i, {at[0] * cells - c, at[1] * cells - y, at[2] * cells - z},
                        u[order[p + static_cast<std::uint32_t>(i)]]);
            }
            block.multiply(count, p == begin[cell]);
          }
          block.shift();
          for (int node = 0; node < 64; node += 4) {
            double* to_row = slab.at(z + (node >> 4), y + (node >> 2 & 3)) + c;
            for (int q = 0; q < moments; ++q)
              for (int l = 0; l < 4; ++l)
                to_row[static_cast<std::size_t>(q) * slab.row + static_cast<std::size_t>(l)] +=
                    block.sum[q][node + l];
          }
        }
  }

  const int nodes = cells + 1;
  std::vector<std::array<double, 3>> velocity(static_cast<std::size_t>(nodes) *
                                              static_cast<std::size_t>(nodes) *
                                              static_cast<std::size_t>(nodes));
#pragma omp parallel for num_threads(threads)
  for (int z = 0; z < nodes; ++z)
    for (int y = 0; y < nodes; ++y)
      for (int i = 0; i < nodes; i += 8) {
        Eight m[moments], v[3];
        for (Eight& one : m) one = all(0);
        for (Slab& slab : slabs) {
          if (z + 1 < slab.from || z + 1 >= slab.from + slab.planes) continue;
          const double* from = slab.at(z + 1, y + 1) + i + 1;
          for (int q = 0; q < moments; ++q)
            m[q] += load(from + static_cast<std::size_t>(q) * slab.row);
        }
        solve(m, v);
        auto* to = &velocity[(static_cast<std::size_t>(z) * static_cast<std::size_t>(nodes) +
                              static_cast<std::size_t>(y)) *
                                 static_cast<std::size_t>(nodes) +
                             static_cast<std::size_t>(i)];
        for (int l = 0; l < 8 && i + l < nodes; ++l)
          for (int c = 0; c < 3; ++c) to[l][c] = v[c][l];
      }
  return velocity;
}

}  // namespace hand_written
