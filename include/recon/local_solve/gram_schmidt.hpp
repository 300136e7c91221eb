// Graded Gram-Schmidt: the improved moving least squares (IMLS) of Tran et al. (2019, eq. 17-19),
// made robust to every degenerate neighbourhood.
//
// The terms of the basis, times sqrt(w_p), are orthonormalised degree by degree, the constant
// first; each is projected twice ("twice is enough"), because one pass in rounding error loses the
// orthogonality that everything else relies on. Where all terms are clearly independent this is all
// there is to do.
//
// Where they are not, the degrees are worked through again as whole blocks. Of the block of
// degree k, less its part in the lower degrees, the singular directions are found. A direction
// is dropped when
//   - its independent part is at most `rank` (or the rounding of the coordinates) times its size:
//     the particles do not resolve it, as y on a line of particles y = const; or
//   - the leverage of it, together with the directions of comparable size (singular values within a
//     factor of two of the next), exceeds `leverage`: the target lies so far outside the particles
//     in this direction that the fit would amplify noise by that factor. The factor is
//     sum_p |phi_p| over what these directions add to the phi_p; |P(0)| sqrt(sum w) / ||P|| bounds
//     it, and is all that is formed where that is enough. Far from a dense cluster that has most of
//     the weight the bound is several times too large. Nothing is dropped for its leverage where
//     sum_p |phi_p| of all that is resolved, or of what is kept so far and these directions, stays
//     within the limit.
//
// The other directions are kept, and the next degree follows. So the constant is never lost
// (partition of unity survives anything), and a cloud on a line is still reproduced to the asked
// degree along the line. Dropping singular directions instead of single monomials makes the result
// independent of the choice of axes: the directions dropped in degree k are the leading forms of
// the polynomials that vanish on the particles, and with the monomials scaled by sqrt(k! / alpha!)
// what is kept is the complement in an inner product that rotations leave alone. A linear direction
// that is dropped takes its products with it: the higher degrees are built from the kept linear
// directions only.
//
// Cost: 4 n m^2 multiplications for n particles and m terms; the block path about three times that.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "recon/basis/monomials.hpp"
#include "recon/core/memory.hpp"
#include "recon/core/sums.hpp"
#include "recon/local_solve/fill_report.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/local_solve/orthonormal_fit.hpp"
#include "recon/local_solve/regular_gram_schmidt.hpp"

namespace recon {

namespace detail {

constexpr double factorial_of(int n) {
  double product = 1;  // no recursion: threads of a GPU have a stack whose size is known beforehand
  for (int i = n; i > 1; --i) product *= i;
  return product;
}

// The factor sqrt(k! / alpha!): with it a rotation of the axes acts on the monomials of degree k as
// an orthogonal matrix.
template <std::size_t D>
constexpr double rotation_scale(const std::array<std::uint8_t, D>& exponents) {
  double scale = 1;
  int k = 0;
  for (const int e : exponents) {
    scale /= factorial_of(e);
    k += e;
  }
  return square_root(scale * factorial_of(k));
}

// The number of terms in the largest of the blocks of B, less the first.
template <class B>
constexpr int largest_block() {
  int most = 0;
  for (int k = 1; k <= B::degree; ++k) most = std::max(most, B::begin(k + 1) - B::begin(k));
  return most;
}

}  // namespace detail

// jet_order: that of the Taylor coefficients which are kept (OrthonormalFit); other bases than
// monomials have those up to 2. Memory: core/memory.hpp.
template <class T, Basis B, int jet_order = 2, class Memory = Growing>
class GramSchmidt {
  static constexpr int block = detail::largest_block<B>();
  using Regular = RegularGramSchmidt<T, B, jet_order, Memory, block>;

 public:
  static constexpr int D = B::dimension;
  static_assert(jet_order == 2 || detail::is_monomials<B>);
  using Result = typename Regular::Result;

  // What is taken from a Workspace for this many particles.
  static constexpr std::size_t bytes_for(int most) { return Regular::bytes_for(most); }

  constexpr explicit GramSchmidt(FitTolerances tolerances = {}, Memory memory = {})
      : tolerances_(tolerances), regular_(tolerances, memory) {}

  // Orthonormalises the basis on the cloud. It never fails: the report says what could not be kept.
  constexpr FitReport fit(const LocalCloud<T, D>& cloud) {
    detail::FitNumbers numbers{Solver::gram_schmidt, static_cast<std::uint32_t>(cloud.size)};
    detail::Kept kept_terms = detail::all_terms<B>();
    bool regular = regular_.fit(cloud);
    if (cloud.size == 0) return detail::report_of<B>(numbers, {});
    weight_sum_ = regular_.weight_sum();
    const T limit = T(tolerances_.leverage);
    if (!regular && regular_.independent()) regular = kept().absolute_sum() <= limit;
    if (regular) {
      numbers.smallest_pivot = detail::to_float(regular_.smallest_pivot());
    } else {
      // The limit is on what the whole fit amplifies. Single directions are dropped only where that
      // is too much. Otherwise the result would depend on whether the monomials were clearly
      // independent, which depends on the choice of axes.
      const detail::Thresholds<T> thresholds(tolerances_, cloud.noise);
      const bool within = fit_blocks(cloud, thresholds, false, kept_terms, numbers);
      if (!within && !(kept().absolute_sum() <= limit))
        fit_blocks(cloud, thresholds, true, kept_terms, numbers);
    }
    T amplification = detail::square_root(T(weight_sum_ * kept().christoffel()));
    if (amplification > limit) amplification = kept().absolute_sum();
    numbers.amplification = detail::to_float(amplification);
    FitReport report = detail::report_of<B>(numbers, kept_terms);
    const int linear = regular || !detail::is_monomials<B> ? D : kept_terms[1] - flat_;
    std::array<const T*, D> flattened{};
    for (int f = 0; f < flat_; ++f) flattened[f] = flat_slopes_[f].data();
    kept().template resolve_gradient<B>(
        weight_sum_, tolerances_, linear, report,
        std::span<const T* const>(flattened.data(), regular ? 0 : static_cast<std::size_t>(flat_)));
    return report;
  }

  constexpr const Result& result() const { return regular_.result(); }
  constexpr Result& result() { return regular_.result(); }

  constexpr void shape_functions(const LocalCloud<T, D>& cloud, const ShapeArrays<T, D>& out) {
    kept().shape_functions(cloud, out);
  }

 private:
  constexpr Result& kept() { return regular_.result(); }
  using Jet = typename Result::Jet;

  static constexpr T dot(const T* a, const T* b, int n) {
    return detail::sum_of<T>(n, [&](int p) { return a[p] * b[p]; });
  }

  // Works through the degrees, each as a block of singular directions. limited: directions whose
  // leverage exceeds the limit are dropped. Returns whether there was none.
  constexpr bool fit_blocks(const LocalCloud<T, D>& cloud, const detail::Thresholds<T>& thresholds,
                            bool limited, detail::Kept& kept_terms, detail::FitNumbers& numbers) {
    const int n = cloud.size;
    const T* root = kept().root_weights();
    const T root_sum = detail::square_root(weight_sum_);
    kept().clear();
    kept_terms = {};
    flat_ = 0;
    axes_ = {};
    for (int d = 0; d < D; ++d) axes_[d][d] = T(1);
    slopes_ = axes_;

    T* constant = kept().next_column();
    T* constant_jet = kept().next_jet();
    for (int p = 0; p < n; ++p) constant[p] = root[p];
    std::fill_n(constant_jet, kept().jets, T(0));
    constant_jet[0] = T(1);
    scale(constant, constant_jet, T(1) / root_sum, n);
    kept().keep();
    kept_terms[0] = 1;

    bool within = true;
    T smallest = T(1), drop = thresholds.drop;
    T floor = T(detail::rounding_margin) * cloud.noise *
              root_sum;  // the size that rounding of the coordinates alone produces
    for (int k = 1; k <= B::degree && kept().rank() < n; ++k) {
      const int columns = fill_block(cloud, k, kept_terms[1]);
      const int lower = kept().rank();
      std::fill_n(removed_.data(), columns * B::size, T(0));
      for (int c = 0; c < columns; ++c)
        for (int pass = 0; pass < 2; ++pass)
          kept().project_out(block_column(c), block_jets_[c].data(), lower,
                             removed_.data() + c * B::size);
      make_orthogonal(columns, lower, n);

      std::array<int, B::size> order{};
      std::array<T, B::size> size{};
      for (int c = 0; c < columns; ++c) {
        order[c] = c;
        size[c] = detail::square_root(dot(block_column(c), block_column(c), n));
      }
      for (int c = 1; c < columns; ++c)  // a few; std::stable_sort would allocate
        for (int i = c; i > 0 && size[order[i]] > size[order[i - 1]]; --i)
          std::swap(order[i], order[i - 1]);
      T shortest = size[order[0]];
      for (int i = 0; i < columns && kept().rank() < n;) {
        // Directions of comparable size are kept or dropped together, since it is arbitrary which
        // of them is which.
        int end = i;
        T leverage2 = T(0);
        do {
          const T share = block_jets_[order[end]][0] * root_sum / size[order[end]];
          leverage2 += share * share;
          ++end;
        } while (end < columns && T(2) * size[order[end]] > size[order[end - 1]]);
        const bool inside = leverage2 <= T(tolerances_.leverage * tolerances_.leverage) ||
                            added_sum(order.data() + i, order.data() + end, size, n, 0) <=
                                T(tolerances_.leverage) ||
                            added_sum(order.data() + i, order.data() + end, size, n,
                                      kept().rank()) <= T(tolerances_.leverage);
        within = within && inside;
        for (; i < end; ++i) {
          const int c = order[i];
          const T* removed = removed_.data() + c * B::size;
          const T whole = detail::square_root(T(size[c] * size[c] + dot(removed, removed, lower)));
          const bool resolved = size[c] > drop * whole && size[c] > floor;
          if ((limited && !inside) || !resolved || kept().rank() >= n) continue;
          if (!keep_direction(block_column(c), block_jets_[c], size[c], n)) continue;
          for (int f = 0; f < flat_; ++f)
            flat_slopes_[f][kept().rank() - 1] =
                -dot(removed, flat_slopes_[f].data(), lower) / size[c];
          ++kept_terms[k];
          shortest = detail::smaller(size[c], shortest);
          smallest = detail::smaller(T((size[c] / whole) * (size[c] / whole)), smallest);
        }
      }
      if (k == 1) {
        if (kept_terms[1] == 0) break;
        if constexpr (detail::is_monomials<B>) find_axes(kept_terms[1]);
        // In the higher degrees rounding counts relative to the thinnest kept extent of the cloud,
        // and sizes are powers of that extent: only the relative test makes sense.
        drop =
            detail::larger(T(T(detail::rounding_margin) * cloud.noise * root_sum / shortest), drop);
        floor = T(0);
      }
    }
    numbers.smallest_pivot = detail::to_float(smallest);
    return within;
  }

  // Sets the coordinates for the degrees after the linear block: the directions kept in it, which
  // are the linear coefficients in the jets of its columns. Where the particles extend too little
  // along a direction for a slope, derivatives along it are left out from here on: at a thickness
  // of 1e-12 they would be of the order of 1e24, and all others would be lost in their rounding.
  constexpr void find_axes(int linear_directions) {
    const T limit2 = detail::gradient_limit2<T>(tolerances_, B::degree);
    for (int i = 0; i < linear_directions; ++i) {
      const T* jet = kept().jet(1 + i);
      T norm2 = T(0);
      for (int d = 0; d < D; ++d) norm2 += jet[1 + d] * jet[1 + d];
      for (int d = 0; d < D; ++d) axes_[i][d] = jet[1 + d] / detail::square_root(norm2);
      slopes_[i] = axes_[i];
      if (weight_sum_ * norm2 <= limit2) continue;
      slopes_[i].fill(T(0));
      kept().flatten(1 + i);
      std::array<T, B::size>& slope = flat_slopes_[flat_++];
      slope.fill(T(0));
      slope[1 + i] = T(1);
    }
  }

  // The columns of one degree in the block path.
  constexpr T* block_column(int c) { return kept().spare_column(c); }

  // Forms the columns sqrt(w_p) m(xi_p) of degree k with their jets; the monomials of degree 2 and
  // more are in the coordinates along the kept linear directions. Returns how many there are.
  constexpr int fill_block(const LocalCloud<T, D>& cloud, int k, int linear_directions) {
    const int n = cloud.size;
    const T* root = kept().root_weights();
    const int begin = B::begin(k), end = B::begin(k + 1);

    if constexpr (detail::is_monomials<B>) {
      const int variables = k == 1 ? D : linear_directions;
      const auto& axes = axes_;
      int columns = 0;
      std::array<int, B::size> chosen;
      for (int j = begin; j < end; ++j) {
        bool uses_kept = true;
        for (int d = variables; d < D; ++d) uses_kept = uses_kept && B::exponents_of(j)[d] == 0;
        if (!uses_kept) continue;
        chosen[columns] = j;
        block_jets_[columns++] = rotated_jet(B::exponents_of(j), k, slopes_);
      }
      for (int p = 0; p < n; ++p) {
        const std::array<T, D> xi = cloud.at(p);
        std::array<T, D> along{};
        for (int i = 0; i < variables; ++i)
          for (int d = 0; d < D; ++d) along[i] += axes[i][d] * xi[d];
        std::array<T, B::size> values;
        B::evaluate(along, values.data());
        for (int c = 0; c < columns; ++c) block_column(c)[p] = root[p] * values[chosen[c]];
      }
      for (int c = 0; c < columns; ++c)
        scale(block_column(c), block_jets_[c].data(),
              T(detail::rotation_scale(B::exponents_of(chosen[c]))), n);
      return columns;
    } else {
      for (int p = 0; p < n; ++p) {
        std::array<T, B::size> values;
        B::evaluate(cloud.at(p), values.data());
        for (int j = begin; j < end; ++j) block_column(j - begin)[p] = root[p] * values[j];
      }
      for (int j = begin; j < end; ++j)
        for (int a = 0; a < kept().jets; ++a) block_jets_[j - begin][a] = T(B::origin(j, a));
      return end - begin;
    }
  }

  // The Taylor coefficients at the target of the monomial with these exponents in the
  // rotated coordinates.
  template <class Exponents>
  static constexpr Jet rotated_jet(const Exponents& exponents, int k,
                                   const std::array<std::array<T, D>, D>& axes) {
    return k <= jet_order ? Monomials<D, jet_order>::of_forms(exponents, axes) : Jet{};
  }

  // One-sided Jacobi (Hestenes 1958): turns pairs of block columns until all are orthogonal; they
  // are then the singular directions times their singular values. Their jets and the parts removed
  // from them are turned in the same way.
  constexpr void make_orthogonal(int columns, int lower, int n) {
    using std::abs;
    const T tolerance = T(4) * std::numeric_limits<T>::epsilon();
    for (int sweep = 0; sweep < 30; ++sweep) {
      bool done = true;
      for (int a = 0; a < columns; ++a)
        for (int b = a + 1; b < columns; ++b) {
          T *x = block_column(a), *y = block_column(b);
          const T xx = dot(x, x, n), yy = dot(y, y, n), xy = dot(x, y, n);
          if (!(T(abs(xy)) > T(tolerance * detail::square_root(xx) * detail::square_root(yy))))
            continue;
          done = false;
          const T zeta = (yy - xx) / (T(2) * xy);
          const T t = (zeta >= T(0) ? T(1) : T(-1)) /
                      (T(abs(zeta)) + detail::square_root(T(T(1) + zeta * zeta)));
          const T c = T(1) / detail::square_root(T(T(1) + t * t)), s = c * t;
          const auto turn = [c, s](T* u, T* v, int count) {
            for (int i = 0; i < count; ++i) {
              const T first = u[i];
              u[i] = c * first - s * v[i];
              v[i] = s * first + c * v[i];
            }
          };
          turn(x, y, n);
          turn(block_jets_[a].data(), block_jets_[b].data(), kept().jets);
          turn(removed_.data() + a * B::size, removed_.data() + b * B::size, lower);
        }
      if (done) return;
    }
  }

  // The sum of |phi_p| over the particles, each phi_p being made of the first `rank` kept columns
  // and these directions of the block only.
  template <class Sizes>
  constexpr T added_sum(const int* first, const int* last, const Sizes& size, int n, int rank) {
    using std::abs;
    return detail::sum_of<T>(n, [&](int p) {
      T part = T(0);
      for (int j = 0; j < rank; ++j) part += kept().column(j)[p] * kept().jet(j)[0];
      for (const int* c = first; c != last; ++c)
        part += block_column(*c)[p] / size[*c] * (block_jets_[*c][0] / size[*c]);
      return T(T(abs(part)) * kept().root_weights()[p]);
    });
  }

  // Appends a direction of the given size, after removing once more its parts in all kept columns.
  // Returns false where nothing is left.
  constexpr bool keep_direction(const T* direction, Jet direction_jet, T size, int n) {
    T* column = kept().next_column();
    detail::copy_numbers(direction, n, column);
    scale(column, direction_jet.data(), T(1) / size, n);
    kept().project_out(column, direction_jet.data(), kept().rank());
    const T left = dot(column, column, n);
    if (!(left > T(0.25))) return false;
    scale(column, direction_jet.data(), T(1) / detail::square_root(left), n);
    detail::copy_numbers(direction_jet.data(), Result::jets, kept().next_jet());
    kept().keep();
    return true;
  }

  static constexpr void scale(T* column, T* jet, T factor, int n) {
    for (int p = 0; p < n; ++p) column[p] *= factor;
    for (int a = 0; a < Result::jets; ++a) jet[a] *= factor;
  }

  FitTolerances tolerances_;
  Regular regular_;
  T weight_sum_ = T(0);
  // Of the columns of one degree: their parts in the lower degrees, B::size numbers each, and jets.
  std::array<T, static_cast<std::size_t>(block) * B::size> removed_{};
  std::array<Jet, block> block_jets_{};
  // The axes of the block's coordinates as rows (the identity for the linear block); and the same
  // with zeros for the `flat_` axes along which nothing is differentiated, but for the slopes of
  // the kept columns, each in a unit of its own.
  std::array<std::array<T, D>, D> axes_{}, slopes_{};
  int flat_ = 0;
  std::array<std::array<T, B::size>, D> flat_slopes_{};
};

}  // namespace recon
