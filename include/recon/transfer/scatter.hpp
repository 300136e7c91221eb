// Sums from particles into nodes, and values of nodes at particles, on several threads.
//
// ```cpp
//   const recon::CartesianGrid<3> grid({0, 0, 0}, {1, 1, 1}, h);
//   const recon::SplineFunctions<2> spline;
//   const auto place = [&](std::size_t p) { return grains[p].position; };
//   std::vector<double> count(grid.size());
//   std::vector<std::array<double, 3>> flow(grid.size());
//   recon::scatter(grid, spline, grains.size(), place, [&](std::size_t p, const auto& at) {
//     at.add(count, 1.0);                 // sum_p S_ip
//     at.add(flow, grains[p].velocity);   // sum_p S_ip v_p
//   });
//   std::vector<double> crowd(grains.size());
//   recon::gather(grid, spline, grains.size(), place,
//                 [&](std::size_t p, const auto& at) { crowd[p] = at.value(count); });
// ```
//
// The nodes are summed without locks and without copies of the grid, always in the same order, so
// that results are the same bits for any number of threads: the rows of the last axis are cut into
// slabs that are thicker than any particle reaches. A particle belongs to the slab of its first
// row, and touches that and the next: so all even slabs can go at once, and then all odd ones, each
// in the order of its particles. The cost is O(particles + rows), and 16 bytes a particle.
//
// Points and domains of all particles are checked before the first call of add or take: where one
// is refused, nothing has been written. What add and take put in is known to them alone. An amount
// that is not finite is refused (node_functions.hpp), but others have been added by then. Fields are
// checked as a whole before anything is written:
//
// ```cpp
//   const recon::CartesianGrid<3> grid({0, 0, 0}, {1, 1, 1}, h);
//   const auto place = [&](std::size_t p) { return grains[p].position; };
//   std::vector<std::array<double, 3>> flow(grid.size());
//   recon::scatter(grid, recon::LinearFunctions{}, place,
//                  recon::field_of(grains, &Grain::velocity), recon::field_of(flow));
// ```
//
// Messages begin with the number of the particle: "particle 31: coordinate y = nan: must be
// finite". Of several it is the first one.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "recon/core/parallel.hpp"
#include "recon/points/view.hpp"
#include "recon/transfer/domain_functions.hpp"

namespace recon {

// The functions of the grid that a loop over particles in D dimensions uses: those of
// point_functions.hpp with points, those of domain_functions.hpp with domains, or your own. These
// may have check(grid, domain), which throws what at() would throw; without it the loops ask
// nodes_along() of every axis beforehand.
template <class F, int D, class Domain>
concept NodalFunctions = requires(const F& functions, const CartesianGrid<D>& grid,
                                  const Domain& domain, typename F::template Nodes<D>& out) {
  functions.at(grid, domain, out);
  { functions.nodes_along(grid, domain, 0) } -> std::convertible_to<std::pair<int, int>>;
};

static_assert(NodalFunctions<LinearFunctions, 1, std::array<double, 1>> &&
              NodalFunctions<SplineFunctions<3>, 3, SpaceVector<3>> &&
              NodalFunctions<MomentSplineFunctions, 2, SpaceVector<2>> &&
              NodalFunctions<EightNodeFunctions, 2, SpaceVector<2>> &&
              NodalFunctions<GimpFunctions, 2, BoxDomain<2>> &&
              NodalFunctions<Cpdi1Functions, 3, ParallelepipedDomain<3>> &&
              NodalFunctions<Cpdi2Functions, 2, CornerDomain<2>>);

namespace detail {

class CountingSort;

// The particles by slabs of rows.
class SlabOrder {
 public:
  explicit SlabOrder(std::size_t particles);
  ~SlabOrder();
  std::span<std::uint32_t> first_rows() { return first_rows_; }  // to be written before sort()
  void sort(std::uint32_t thickness, std::size_t slabs, int threads);
  std::span<const std::uint32_t> order() const { return order_; }  // in a slab ascending
  std::span<const std::uint32_t> begin() const { return begin_; }  // of each slab, and the end

 private:
  std::unique_ptr<CountingSort> sort_;
  std::span<std::uint32_t> first_rows_;
  std::span<const std::uint32_t> order_, begin_;
};

[[noreturn]] void throw_rows(int first, int last);
// The same error with the number of the particle before it.
[[noreturn]] void throw_for_particle(std::size_t particle, const InvalidArgument& error);
[[noreturn]] void throw_amount(std::size_t particle, double value, std::size_t component);

// Calls work(p) for p = at(begin), ..., at(end - 1). What it refuses is charged to p.
template <class Index, class At, class Work>
void for_particles(Index begin, Index end, const At& at, const Work& work) {
  Index i = begin;
  try {
    for (; i < end; ++i) work(at(i));
  } catch (const InvalidArgument& error) {
    throw_for_particle(at(i), error);
  }
}

template <int D, class Functions, class Domain>
void check_domain(const CartesianGrid<D>& grid, const Functions& functions, const Domain& domain) {
  if constexpr (requires { functions.check(grid, domain); })
    functions.check(grid, domain);
  else
    for (int d = 0; d < D; ++d) functions.nodes_along(grid, domain, d);
}

}  // namespace detail

// The loop that scatter() is made of, for functions of your own making: add() calls add(p, scratch)
// for every particle p, where rows(p) gives the first and the last index, of the last axis, of the
// nodes that p adds to. Scratch is default-constructed once per slab. All calls of rows() come before
// the first of add(); for several sums at the same places they need not be repeated. Throws
// InvalidArgument for rows that are negative or in the wrong order. threads <= 0: default_threads().
class ScatterByRows {
 public:
  template <class Rows>
  ScatterByRows(std::size_t particles, int threads, const Rows& rows)
      : threads_(threads), order_(particles) {
    constexpr std::size_t block = 4096;
    constexpr int thinnest = 4;
    const std::span<std::uint32_t> first_rows = order_.first_rows();
    std::atomic<int> span{thinnest}, last_row{0};
    parallel_blocks(particles, block, threads, [&](std::size_t begin, std::size_t end) {
      int most = 0, last = 0;
      detail::for_particles(
          begin, end, [](std::size_t p) { return p; },
          [&](std::size_t p) {
            const std::pair<int, int> touched = rows(p);
            if (touched.first < 0 || touched.second < touched.first) [[unlikely]]
              detail::throw_rows(touched.first, touched.second);
            first_rows[p] = static_cast<std::uint32_t>(touched.first);
            most = std::max(most, touched.second - touched.first);
            last = std::max(last, touched.second);
          });
      for (int seen = span; seen < most && !span.compare_exchange_weak(seen, most);) {
      }
      for (int seen = last_row; seen < last && !last_row.compare_exchange_weak(seen, last);) {
      }
    });
    const int thickness = span;
    slabs_ = static_cast<std::size_t>(last_row / thickness) + 1;
    order_.sort(static_cast<std::uint32_t>(thickness), slabs_, threads);
  }

  template <class Scratch, class Add>
  void add(const Add& add) const {
    const std::span<const std::uint32_t> begin = order_.begin(), order = order_.order();
    for (std::size_t colour = 0; colour < 2; ++colour)
      parallel_blocks(
          (slabs_ + 1 - colour) / 2, 1, threads_, [&](std::size_t from, std::size_t to) {
            Scratch scratch;
            for (std::size_t s = 2 * from + colour; s < 2 * to + colour && s < slabs_; s += 2)
              detail::for_particles(
                  begin[s], begin[s + 1], [&](std::uint32_t i) { return order[i]; },
                  [&](std::uint32_t p) { add(p, scratch); });
          });
  }

 private:
  int threads_;
  std::size_t slabs_ = 0;
  detail::SlabOrder order_;
};

// The same for one sum.
template <class Scratch, class Rows, class Add>
void scatter_by_rows(std::size_t particles, int threads, const Rows& rows, const Add& add) {
  ScatterByRows(particles, threads, rows).add<Scratch>(add);
}

// Calls add(p, at) for every particle p, with `at` the nodes that it sees (NodeFunctions): add may
// write to nodal arrays at these nodes, and to what belongs to p alone. domain_of(p) is the point
// of p, or its domain. Throws what the functions throw: InvalidArgument for points that are not
// finite.
template <int D, class Functions, class DomainOf, class Add>
requires NodalFunctions<Functions, D, std::invoke_result_t<const DomainOf&, std::size_t>>
void scatter(const CartesianGrid<D>& grid, const Functions& functions, std::size_t particles,
             const DomainOf& domain_of, const Add& add, int threads = 0) {
  detail::require_dimension<std::invoke_result_t<const DomainOf&, std::size_t>, D>();
  using Nodes = typename Functions::template Nodes<D>;
  scatter_by_rows<Nodes>(
      particles, threads,
      [&](std::size_t p) {
        decltype(auto) domain = domain_of(p);
        detail::check_domain(grid, functions, domain);
        return functions.nodes_along(grid, domain, D - 1);
      },
      [&](std::size_t p, Nodes& at) {
        functions.at(grid, domain_of(p), at);
        add(p, std::as_const(at));
      });
}

// Calls take(p, at) for every particle p; take may write to what belongs to p alone.
template <int D, class Functions, class DomainOf, class Take>
requires NodalFunctions<Functions, D, std::invoke_result_t<const DomainOf&, std::size_t>>
void gather(const CartesianGrid<D>& grid, const Functions& functions, std::size_t particles,
            const DomainOf& domain_of, const Take& take, int threads = 0) {
  detail::require_dimension<std::invoke_result_t<const DomainOf&, std::size_t>, D>();
  constexpr std::size_t block = 1024;
  const auto for_all = [&](const auto& loop) { parallel_blocks(particles, block, threads, loop); };
  const auto itself = [](std::size_t p) { return p; };
  for_all([&](std::size_t begin, std::size_t end) {
    detail::for_particles(begin, end, itself, [&](std::size_t p) {
      detail::check_domain(grid, functions, domain_of(p));
    });
  });
  for_all([&](std::size_t begin, std::size_t end) {
    typename Functions::template Nodes<D> at;
    detail::for_particles(begin, end, itself, [&](std::size_t p) {
      functions.at(grid, domain_of(p), at);
      take(p, std::as_const(at));
    });
  });
}

namespace detail {

// Calls found(i, c) for the first number of a field that is not finite, if any.
template <class Scalar, class Found>
void find_not_finite(const BasicFieldView<Scalar>& field, int threads, const Found& found) {
  constexpr std::size_t block = 4096;
  recon::parallel_blocks(field.size(), block, threads, [&](std::size_t begin, std::size_t end) {
    double zero = 0;  // and NaN where any number is not finite
    for (std::size_t i = begin; i < end; ++i)
      for (int c = 0; c < field.components(); ++c)
        zero += static_cast<double>(field(i, c) - field(i, c));
    for (std::size_t i = begin; i < end && zero != 0; ++i)
      for (int c = 0; c < field.components(); ++c)
        if (!std::isfinite(field(i, c))) return found(i, c);
  });
}

template <class Scalar>
void require_finite_nodes(const BasicFieldView<Scalar>& nodes, int threads, const char* rule) {
  find_not_finite(nodes, threads, [&](std::size_t i, int c) {
    throw_nodal(static_cast<std::uint32_t>(i), static_cast<double>(nodes(i, c)),
                static_cast<std::size_t>(c), rule);
  });
}

// Component c of nodal data.
template <class Scalar>
auto column(const BasicFieldView<Scalar>& nodes, int c) {
  return [&nodes, c](std::uint32_t i) -> Scalar& { return nodes(i, c); };
}

}  // namespace detail

// nodes(i, c) += sum_p S_ip amounts(p, c), for the particles p of the field of amounts. All is
// checked before anything is written; a sum that overflows is named afterwards.
template <int D, class Functions, class DomainOf, class Amount, class Nodal>
requires NodalFunctions<Functions, D, std::invoke_result_t<const DomainOf&, std::size_t>>
void scatter(const CartesianGrid<D>& grid, const Functions& functions, const DomainOf& domain_of,
             const BasicFieldView<Amount>& amounts, const BasicFieldView<Nodal>& nodes,
             int threads = 0) {
  static_assert(!std::is_const_v<Nodal>, "the nodal data are written to");
  detail::require(nodes.size() == grid.size(), "size of the nodal data", nodes.size(),
                  "must be the number of nodes");
  detail::require(nodes.components() == amounts.components(), "components of the nodal data",
                  nodes.components(), "must be those of the amounts");
  detail::require_finite_nodes(nodes, threads, "must be finite");
  detail::find_not_finite(amounts, threads, [&](std::size_t p, int c) {
    detail::throw_amount(p, static_cast<double>(amounts(p, c)), static_cast<std::size_t>(c));
  });
  scatter(
      grid, functions, amounts.size(), domain_of,
      [&](std::size_t p, const auto& at) {
        for (int c = 0; c < amounts.components(); ++c)
          at.add(detail::column(nodes, c), amounts(p, c), trusted);
      },
      threads);
  detail::require_finite_nodes(nodes, threads, "overflows: the amounts are too large");
}

// out(p, c) = sum_i S_ip nodes(i, c), for the points p of `out`. All is checked before anything is
// written, but for sums that overflow.
template <int D, class Functions, class DomainOf, class Nodal, class Out>
requires NodalFunctions<Functions, D, std::invoke_result_t<const DomainOf&, std::size_t>>
void gather(const CartesianGrid<D>& grid, const Functions& functions, const DomainOf& domain_of,
            const BasicFieldView<Nodal>& nodes, const BasicFieldView<Out>& out, int threads = 0) {
  static_assert(!std::is_const_v<Out>, "the output is written to");
  detail::require(nodes.size() == grid.size(), "size of the nodal data", nodes.size(),
                  "must be the number of nodes");
  detail::require(nodes.components() == out.components(), "components of the output",
                  out.components(), "must be those of the nodal data");
  // Nodes may hold anything where no particle sees them, so only the particles can tell.
  std::atomic<bool> finite{true};
  detail::find_not_finite(nodes, threads, [&](std::size_t, int) { finite = false; });
  if (!finite)
    gather(
        grid, functions, out.size(), domain_of,
        [&](std::size_t, const auto& at) {
          for (std::size_t k = 0; k < at.size(); ++k)
            for (int c = 0; c < nodes.components() && at.S[k] != 0; ++c)
              if (const Nodal value = nodes(at.node[k], c); !std::isfinite(value))
                detail::throw_nodal(at.node[k], static_cast<double>(value),
                                    static_cast<std::size_t>(c), "must be finite");
        },
        threads);
  gather(
      grid, functions, out.size(), domain_of,
      [&](std::size_t p, const auto& at) {
        for (int c = 0; c < nodes.components(); ++c) {
          const auto value = at.value(detail::column(nodes, c));
          out(p, c) = static_cast<Out>(value);
          if (!std::isfinite(out(p, c))) [[unlikely]]  // beyond the range of the output
            detail::throw_invalid("particle " + std::to_string(p) + ": component " +
                                      std::to_string(c) + " of the output",
                                  value, "must be in the range of its numbers");
        }
      },
      threads);
}

}  // namespace recon
