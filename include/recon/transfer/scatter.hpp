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
#pragma once

#include <algorithm>
#include <atomic>
#include <concepts>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "recon/core/parallel.hpp"
#include "recon/transfer/domain_functions.hpp"

namespace recon {

// The functions of the grid that a loop over particles in D dimensions uses: those of
// point_functions.hpp with points, those of domain_functions.hpp with domains, or your own.
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

[[noreturn]] void throw_rows(std::size_t particle, int first, int last);

}  // namespace detail

// The loop that scatter() is made of, for functions of your own making: calls add(p, scratch) for
// every particle p, where rows(p) gives the first and the last index, of the last axis, of the
// nodes that p adds to. Scratch is default-constructed once per slab. Throws InvalidArgument for
// rows that are negative or in the wrong order. threads <= 0: default_threads().
template <class Scratch, class Rows, class Add>
void scatter_by_rows(std::size_t particles, int threads, const Rows& rows, const Add& add) {
  constexpr std::size_t block = 4096;
  constexpr int thinnest = 4;
  detail::SlabOrder slab_order(particles);
  const std::span<std::uint32_t> first_rows = slab_order.first_rows();
  std::atomic<int> span{thinnest}, last_row{0};
  parallel_blocks(particles, block, threads, [&](std::size_t begin, std::size_t end) {
    int most = 0, last = 0;
    for (std::size_t p = begin; p < end; ++p) {
      const std::pair<int, int> touched = rows(p);
      if (touched.first < 0 || touched.second < touched.first) [[unlikely]]
        detail::throw_rows(p, touched.first, touched.second);
      first_rows[p] = static_cast<std::uint32_t>(touched.first);
      most = std::max(most, touched.second - touched.first);
      last = std::max(last, touched.second);
    }
    for (int seen = span; seen < most && !span.compare_exchange_weak(seen, most);) {
    }
    for (int seen = last_row; seen < last && !last_row.compare_exchange_weak(seen, last);) {
    }
  });
  const int thickness = span;
  const std::size_t slabs = static_cast<std::size_t>(last_row / thickness) + 1;
  slab_order.sort(static_cast<std::uint32_t>(thickness), slabs, threads);
  const std::span<const std::uint32_t> begin = slab_order.begin(), order = slab_order.order();
  for (std::size_t colour = 0; colour < 2; ++colour)
    parallel_blocks((slabs + 1 - colour) / 2, 1, threads, [&](std::size_t from, std::size_t to) {
      Scratch scratch;
      for (std::size_t s = 2 * from + colour; s < 2 * to + colour && s < slabs; s += 2)
        for (std::uint32_t i = begin[s]; i < begin[s + 1]; ++i) add(order[i], scratch);
    });
}

// Calls add(p, at) for every particle p, with `at` the nodes that it sees (NodeFunctions): add may
// write to nodal arrays at these nodes, and to what belongs to p alone. domain_of(p) is the point
// of p, or its domain. Throws what the functions throw: InvalidArgument for points that are not
// finite.
template <int D, class Functions, class DomainOf, class Add>
requires NodalFunctions<Functions, D, std::invoke_result_t<const DomainOf&, std::size_t>>
void scatter(const CartesianGrid<D>& grid, const Functions& functions, std::size_t particles,
             const DomainOf& domain_of, const Add& add, int threads = 0) {
  using Nodes = typename Functions::template Nodes<D>;
  scatter_by_rows<Nodes>(
      particles, threads,
      [&](std::size_t p) { return functions.nodes_along(grid, domain_of(p), D - 1); },
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
  constexpr std::size_t block = 1024;
  parallel_blocks(particles, block, threads, [&](std::size_t begin, std::size_t end) {
    typename Functions::template Nodes<D> at;
    for (std::size_t p = begin; p < end; ++p) {
      functions.at(grid, domain_of(p), at);
      take(p, std::as_const(at));
    }
  });
}

}  // namespace recon
