// Operators of functionals: which derivatives they need, and what each takes of them.
#include <algorithm>
#include <array>
#include <utility>

#include "core/instantiate.hpp"
#include "operators/fit_problem.hpp"
#include "recon/operators/reconstruct.hpp"

namespace recon {
namespace {

// Where the numbers of a functional come from.
enum class Source { values, diffuse_slopes, exact_slopes, second_derivatives, polynomial };

Source source_of(const detail::ComponentFunctional& functional) {
  const auto* built_in = std::get_if<Functional>(&functional);
  if (!built_in || built_in->order() > 2) return Source::polynomial;
  if (built_in->order() == 2) return Source::second_derivatives;
  if (built_in->order() == 0) return Source::values;
  detail::require_derivative(built_in->slopes());
  return built_in->slopes() == Derivative::exact ? Source::exact_slopes : Source::diffuse_slopes;
}

// The place of a derivative in d/dx, d/dy, d/dz, or in xx, xy, xz, yy, yz, zz.
int place_of(const Functional::Powers& derivative, int dimension) {
  std::array<int, 2> axes{};
  int order = 0;
  for (int d = 0; d < dimension; ++d)
    for (int n = 0; n < derivative[d]; ++n) axes[order++] = d;
  const int a = axes[0];
  return order == 1 ? a : a * dimension - a * (a - 1) / 2 + axes[1] - a;
}

// `width` numbers per entry become one for each of the sums, of those at some places.
template <class Scalar>
Array<Scalar> sums_of(const Array<Scalar>& from, int width,
                      const std::vector<std::vector<int>>& sums) {
  const std::size_t entries = from.size() / static_cast<std::size_t>(width);
  Array<Scalar> values(entries * sums.size());
  for (std::size_t e = 0; e < entries; ++e)
    for (std::size_t i = 0; i < sums.size(); ++i) {
      Scalar sum = 0;
      for (const int place : sums[i]) sum += from[e * static_cast<std::size_t>(width) + place];
      values[e * sums.size() + i] = sum;
    }
  return values;
}

// Whether these sums are all numbers of the source, as they are.
bool is_all(const std::vector<std::vector<int>>& sums, int width) {
  for (std::size_t i = 0; i < sums.size(); ++i)
    if (sums[i] != std::vector<int>{static_cast<int>(i)}) return false;
  return static_cast<int>(sums.size()) == width;
}

}  // namespace

template <class Scalar>
std::vector<CsrOperator<Scalar>> BasicReconstruction<Scalar>::operators_of(
    std::span<const detail::ComponentFunctional> functionals) const {
  const auto& pattern = problem_->pattern();
  pattern->require_current();
  const int D = dimension();

  // The places, among the numbers of its source, that each number of a functional is the sum of.
  std::vector<Source> sources;
  std::vector<std::vector<std::vector<int>>> places;
  std::vector<OwnFunctional::Action> asked;
  int own_numbers = 0;
  for (const auto& functional : functionals) {
    const auto* built_in = std::get_if<Functional>(&functional);
    sources.push_back(source_of(functional));
    auto& sums = places.emplace_back();
    if (sources.back() == Source::polynomial) {
      asked.push_back((built_in ? built_in->at({{}}) : std::get<OwnFunctional>(functional)).in(D));
      for (int i = 0; i < asked.back().numbers; ++i) sums.push_back({own_numbers++});
      continue;
    }
    for (const auto& sum : built_in->derivatives(D)) {
      if (sources.back() == Source::values) continue;
      auto& places_of_sum = sums.emplace_back();
      for (const Functional::Powers& derivative : sum)
        places_of_sum.push_back(place_of(derivative, D));
    }
  }

  const auto wanted = [&](Source source) {
    return std::find(sources.begin(), sources.end(), source) != sources.end();
  };
  const bool exact = wanted(Source::exact_slopes), diffuse = wanted(Source::diffuse_slopes),
             second = wanted(Source::second_derivatives);
  Array<Scalar> exact_slopes, diffuse_slopes, second_derivatives, of_polynomial;
  if (exact)
    problem_->derivatives(Derivative::exact, &exact_slopes, second ? &second_derivatives : nullptr);
  if (diffuse || (second && !exact))
    problem_->derivatives(Derivative::diffuse, diffuse ? &diffuse_slopes : nullptr,
                          second && !exact ? &second_derivatives : nullptr);
  if (!asked.empty()) of_polynomial = problem_->functionals(asked);

  std::vector<CsrOperator<Scalar>> made;
  for (std::size_t i = 0; i < functionals.size(); ++i) {
    if (sources[i] == Source::values) {
      made.push_back(values_);
      continue;
    }
    Array<Scalar>& from = sources[i] == Source::exact_slopes     ? exact_slopes
                          : sources[i] == Source::diffuse_slopes ? diffuse_slopes
                          : sources[i] == Source::polynomial     ? of_polynomial
                                                                 : second_derivatives;
    const int width = sources[i] == Source::second_derivatives ? D * (D + 1) / 2
                      : sources[i] == Source::polynomial       ? own_numbers
                                                               : D;
    // Moved out where no later functional needs them.
    const bool last = std::find(sources.begin() + static_cast<std::ptrdiff_t>(i) + 1, sources.end(),
                                sources[i]) == sources.end();
    Array<Scalar> values = !is_all(places[i], width) ? sums_of(from, width, places[i])
                           : last                    ? std::move(from)
                                                     : from;
    made.push_back(CsrOperator<Scalar>(pattern, std::move(values),
                                       static_cast<int>(places[i].size()), fill(),
                                       problem_->options().threads));
  }
  return made;
}

#define RECON_INSTANTIATE(S)                                                 \
  template std::vector<CsrOperator<S>> BasicReconstruction<S>::operators_of( \
      std::span<const detail::ComponentFunctional>) const
RECON_FLOAT(RECON_INSTANTIATE(float);)
RECON_INSTANTIATE(double);
#undef RECON_INSTANTIATE

}  // namespace recon
