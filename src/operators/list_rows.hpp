// Some of the targets, and their rows in a list of neighbours.
#pragma once

#include <cstddef>
#include <vector>

#include "recon/neighbourhood/neighbour_list.hpp"
#include "recon/neighbourhood/support_tensor.hpp"
#include "recon/points/point_cloud.hpp"

namespace recon::detail {

template <class Scalar>
PointCloud<Scalar> subset(const PointCloud<Scalar>& points,
                          const std::vector<std::size_t>& chosen) {
  return points.permuted(std::vector<std::uint32_t>(chosen.begin(), chosen.end()));
}

// How many numbers a list has in the tensors of a target and of an entry, and in the support of an
// entry.
struct NumbersOf {
  std::size_t of_target = 0, of_entry = 0;
  bool pair_support = false;

  template <class Scalar>
  explicit NumbersOf(const NeighbourList<Scalar>& list) : pair_support(!list.pair_support.empty()) {
    if (list.targets() > 0) of_target = list.tensor.size() / list.targets();
    if (!list.indices.empty()) of_entry = list.pair_tensor.size() / list.indices.size();
  }
};

// Appends a row of a list to another, which has such tensors and supports of its entries: balls of
// the target's radius where the first has none.
template <class Scalar>
void append_row(const NeighbourList<Scalar>& from, std::size_t row, const NumbersOf& numbers,
                NeighbourList<Scalar>& to) {
  const std::int64_t begin = from.offsets[row], end = from.offsets[row + 1];
  const auto append = [](const auto& all, std::int64_t first, std::int64_t last, auto& out) {
    out.insert(out.end(), all.begin() + first, all.begin() + last);
  };
  append(from.indices, begin, end, to.indices);
  if (!from.shifts.empty()) append(from.shifts, begin, end, to.shifts);
  to.offsets.push_back(static_cast<std::int64_t>(to.indices.size()));
  to.support.push_back(from.support[row]);
  if (numbers.pair_support && !from.pair_support.empty())
    append(from.pair_support, begin, end, to.pair_support);
  else if (numbers.pair_support)
    to.pair_support.insert(to.pair_support.end(), static_cast<std::size_t>(end - begin),
                           from.support[row]);
  const auto of_target = static_cast<std::int64_t>(numbers.of_target),
             of_entry = static_cast<std::int64_t>(numbers.of_entry),
             target = static_cast<std::int64_t>(row);
  if (of_target > 0 && !from.tensor.empty())
    append(from.tensor, target * of_target, (target + 1) * of_target, to.tensor);
  else if (of_target > 0)
    append_ball(from.support[row], numbers.of_target, to.tensor);
  if (of_entry > 0 && !from.pair_tensor.empty())
    append(from.pair_tensor, begin * of_entry, end * of_entry, to.pair_tensor);
  for (std::int64_t e = begin; of_entry > 0 && from.pair_tensor.empty() && e < end; ++e)
    append_ball(from.support[row], numbers.of_entry, to.pair_tensor);
}

// The list in which target rows[i] (ascending) has the neighbours and the support of target i of
// `other` where take[i].
template <class Scalar>
NeighbourList<Scalar> with_rows(const NeighbourList<Scalar>& list,
                                const std::vector<std::size_t>& rows,
                                const NeighbourList<Scalar>& other, const std::vector<bool>& take) {
  NeighbourList<Scalar> merged;
  merged.support_factor = list.support_factor;
  const NumbersOf numbers(list);
  std::size_t next = 0;
  for (std::size_t t = 0; t < list.targets(); ++t) {
    const bool is_row = next < rows.size() && rows[next] == t;
    if (is_row && take[next])
      append_row(other, next, numbers, merged);
    else
      append_row(list, t, numbers, merged);
    next += is_row;
  }
  return merged;
}

// The list in which the targets `rows` (ascending) have their supports and no neighbours.
template <class Scalar>
NeighbourList<Scalar> without_neighbours(const NeighbourList<Scalar>& list,
                                         const std::vector<std::size_t>& rows) {
  NeighbourList<Scalar> nothing;
  const std::size_t numbers = NumbersOf(list).of_target;
  for (const std::size_t t : rows) {
    nothing.offsets.push_back(0);
    nothing.support.push_back(list.support[t]);
    const auto tensor = list.tensor.begin() + static_cast<std::ptrdiff_t>(t * numbers);
    nothing.tensor.insert(nothing.tensor.end(), tensor,
                          tensor + static_cast<std::ptrdiff_t>(numbers));
  }
  return with_rows(list, rows, nothing, std::vector<bool>(rows.size(), true));
}

}  // namespace recon::detail
