#include "recon/runs/view.hpp"

#include <algorithm>

namespace recon::mpm {

template <int D>
void View<D>::require_mapped(const char* what) const {
  recon::detail::require(mapped_, what, "of nodes of another time", "needs a map() before");
}

template <int D>
std::optional<std::size_t> View<D>::place_of(std::size_t number) const {
  if (!numbers_) return number;
  const auto found = std::lower_bound(numbers_->begin(), numbers_->end(), number);
  if (found == numbers_->end() || *found != number) return {};
  return static_cast<std::size_t>(found - numbers_->begin());
}

template <int D>
std::vector<double> View<D>::of_all(std::vector<double> of_this_part) const {
  return gather_ ? gather_(of_this_part) : of_this_part;
}

template <int D>
void View<D>::sum(std::span<double> numbers) const {
  if (!gather_) return;
  const std::vector<double> all = gather_({numbers.begin(), numbers.end()});
  std::copy_n(all.begin(), numbers.size(), numbers.begin());
  for (std::size_t i = numbers.size(); i < all.size(); ++i) numbers[i % numbers.size()] += all[i];
}

template class View<1>;
template class View<2>;
template class View<3>;

}  // namespace recon::mpm
