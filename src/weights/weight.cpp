#include "recon/weights/weight.hpp"

#include <array>
#include <vector>

#include "recon/core/error.hpp"
#include "recon/core/names.hpp"
#include "weights/weight_function.hpp"

namespace recon {
namespace {

struct Named {
  Weight weight;
  std::string_view name;
};

constexpr std::array named{
    Named{Weight::linear_b_spline, "linear"},
    Named{Weight::quadratic_b_spline, "quadratic"},
    Named{Weight::cubic_b_spline, "cubic"},
    Named{Weight::quartic_b_spline, "quartic"},
    Named{Weight::quintic_b_spline, "quintic"},
    Named{Weight::wendland_c0, "wendland_c0"},
    Named{Weight::wendland_c2, "wendland_c2"},
    Named{Weight::wendland_c4, "wendland_c4"},
    Named{Weight::wendland_c6, "wendland_c6"},
    Named{Weight::gaussian, "gaussian"},
    Named{Weight::inverse_distance, "inverse_distance"},
};

constexpr auto weights = [] {
  std::array<Weight, named.size()> all{};
  for (std::size_t i = 0; i < named.size(); ++i) all[i] = named[i].weight;
  return all;
}();

double natural_support_of(Weight weight) {
  switch (weight) {
    case Weight::linear_b_spline:
      return 1;
    case Weight::quadratic_b_spline:
      return 1.5;
    case Weight::cubic_b_spline:
      return 2;
    case Weight::quartic_b_spline:
      return 2.5;
    case Weight::quintic_b_spline:
      return 3;
    default:
      return 0;
  }
}

WeightFunction make(Weight weight) {
  switch (weight) {
    case Weight::linear_b_spline:
      return BSpline<1>{};
    case Weight::quadratic_b_spline:
      return BSpline<2>{};
    case Weight::cubic_b_spline:
      return BSpline<3>{};
    case Weight::quartic_b_spline:
      return BSpline<4>{};
    case Weight::quintic_b_spline:
      return BSpline<5>{};
    case Weight::wendland_c0:
      return Wendland<0>{};
    case Weight::wendland_c2:
      return Wendland<2>{};
    case Weight::wendland_c4:
      return Wendland<4>{};
    case Weight::wendland_c6:
      return Wendland<6>{};
    case Weight::gaussian:
      return Gaussian{};
    case Weight::inverse_distance:
      return InverseDistance{};
  }
  detail::throw_invalid("weight", static_cast<int>(weight),
                        "must be an enumerator of recon::Weight");
}

}  // namespace

std::span<const Weight> all_weights() {
  return weights;
}

std::string_view name_of(Weight weight) {
  for (const Named& entry : named)
    if (entry.weight == weight) return entry.name;
  return "unknown";
}

Weight weight_named(std::string_view name) {
  std::vector<std::string> names;
  for (const Named& entry : named) {
    if (entry.name == name) return entry.weight;
    names.emplace_back(entry.name);
  }
  detail::throw_invalid("weight", name, suggest(name, names));
}

WeightFunction::WeightFunction(Weight weight) : WeightFunction(make(weight)) {
  named_ = weight;
}

template <class Scalar>
WeightFunction::Function<Scalar> WeightFunction::function(
    [[maybe_unused]] InstructionSet set) const {
  if (named_) return RECON_DISPATCH(set, weight_function<Scalar>)(*named_);
  if constexpr (std::is_same_v<Scalar, float>)
    return evaluate_float_;
  else
    return evaluate_double_;
}
template WeightFunction::Function<float> WeightFunction::function<float>(InstructionSet) const;
template WeightFunction::Function<double> WeightFunction::function<double>(InstructionSet) const;

double natural_support(const WeightFunction& weight) {
  return weight.named() ? natural_support_of(*weight.named()) : 0;
}

}  // namespace recon
