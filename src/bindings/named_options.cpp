#include "bindings/named_options.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "recon/core/names.hpp"

namespace recon::bindings {
namespace {

using detail::require;
using detail::throw_invalid;

// What an option is said with. `other`: with an array, a function or an object, or in several ways.
enum class Said { number, text, other };
struct Known {
  std::string_view name;
  Said with;
};

constexpr std::array known{
    Known{"degree", Said::number},
    Known{"weight", Said::text},
    Known{"form", Said::text},
    Known{"particle_weights", Said::other},
    Known{"neighbours", Said::other},
    Known{"solver", Said::text},
    Known{"stretch", Said::other},
    Known{"domain", Said::other},
    Known{"search", Said::text},
    Known{"visible", Said::other},
    Known{"max_distance", Said::number},
    Known{"grow", Said::other},
    Known{"grow.steps", Said::number},
    Known{"grow.factor", Said::number},
    Known{"unsupported", Said::text},
    Known{"fill_value", Said::number},
    Known{"tolerances", Said::other},
    Known{"tolerances.rank", Said::number},
    Known{"tolerances.leverage", Said::number},
    Known{"tolerances.gradient_extent", Said::number},
    Known{"threads", Said::number},
    Known{"instruction_set", Said::text},
    Known{"progress", Said::other},
    Known{"method", Said::text},
    Known{"radius", Said::number},
    Known{"nearest", Said::number},
};

const Known& find(std::string_view name) {
  for (const Known& option : known)
    if (option.name == name) return option;
  std::vector<std::string> names;
  for (const Known& option : known) names.emplace_back(option.name);
  refuse_name("option", name, names);
}

int whole_int(const char* argument, double number) {
  require(number == std::floor(number) && std::abs(number) <= 1e9, argument, number,
          "must be a whole number of at most 1e9");
  return static_cast<int>(number);
}

template <class Enumerator, std::size_t N>
Enumerator named(const char* argument, std::string_view name,
                 const std::array<std::pair<std::string_view, Enumerator>, N>& table) {
  for (const auto& [text, enumerator] : table)
    if (text == name) return enumerator;
  std::vector<std::string> valid;
  for (const auto& [text, enumerator] : table) valid.emplace_back(text);
  refuse_name(argument, name, valid);
}

template <class Enumerator, class... Rest>
constexpr auto table(std::pair<std::string_view, Enumerator> first, Rest... rest) {
  return std::array<std::pair<std::string_view, Enumerator>, 1 + sizeof...(Rest)>{first, rest...};
}
template <class Enumerator>
constexpr std::pair<std::string_view, Enumerator> row(std::string_view name,
                                                      Enumerator enumerator) {
  return {name, enumerator};
}

}  // namespace

void refuse_name(const char* argument, std::string_view name, std::span<const std::string> valid) {
  throw_invalid(argument, "'" + std::string(name) + "'", "is not known; " + suggest(name, valid));
}

void require_option(std::string_view name) {
  find(name);
}

std::size_t whole_number(const char* argument, double number) {
  require(number == std::floor(number) && number >= 0 && number <= 9e15, argument, number,
          "must be a whole number, 0 or more");
  return static_cast<std::size_t>(number);
}

Weight weight_of(std::string_view name) {
  std::vector<std::string> valid, shorter;
  for (const Weight weight : all_weights()) {
    const std::string_view text = name_of(weight);
    const bool spline = natural_support(weight) > 0;
    const std::string full = spline ? std::string(text) + "_b_spline" : std::string(text);
    if (name == text || name == full) return weight;
    valid.push_back(full);
    shorter.emplace_back(text);
  }
  const bool is_shorter =
      nearest_names(name, valid).empty() && !nearest_names(name, shorter).empty();
  refuse_name("weight", name, is_shorter ? shorter : valid);
}

WeightForm form_of(std::string_view name) {
  static constexpr auto names =
      table(row("radial", WeightForm::radial), row("tensor_product", WeightForm::tensor_product));
  return named("form", name, names);
}

Solver solver_of(std::string_view name) {
  static constexpr auto names =
      table(row("moment_matrix", Solver::moment_matrix), row("gram_schmidt", Solver::gram_schmidt),
            row("qr", Solver::qr), row("svd", Solver::svd));
  return named("solver", name, names);
}

SearchMethod search_of(std::string_view name) {
  static constexpr auto names =
      table(row("automatic", SearchMethod::automatic), row("kd_tree", SearchMethod::kd_tree),
            row("r_tree", SearchMethod::r_tree), row("cell_grid", SearchMethod::cell_grid),
            row("brute_force", SearchMethod::brute_force));
  return named("search", name, names);
}

Unsupported unsupported_of(std::string_view name) {
  static constexpr auto names =
      table(row("fill", Unsupported::fill), row("nearest", Unsupported::nearest));
  return named("unsupported", name, names);
}

InstructionSet instruction_set_of(std::string_view name) {
  static constexpr auto names =
      table(row("automatic", InstructionSet::automatic), row("generic", InstructionSet::generic),
            row("avx2", InstructionSet::avx2), row("avx512", InstructionSet::avx512));
  return named("instruction_set", name, names);
}

Derivative derivative_of(std::string_view name) {
  static constexpr auto names =
      table(row("diffuse", Derivative::diffuse), row("exact", Derivative::exact));
  return named("derivative", name, names);
}

Limit limit_of(std::string_view name) {
  static constexpr auto names =
      table(row("none", Limit::none), row("range", Limit::range), row("relaxed", Limit::relaxed));
  return named("limit", name, names);
}

PairSupport pair_support_of(std::string_view name) {
  static constexpr auto names =
      table(row("particle", PairSupport::particle), row("mean", PairSupport::mean),
            row("larger", PairSupport::larger));
  return named("support", name, names);
}

void NamedOptions::said(std::string_view name) {
  said_.emplace(find(name).name);
}

void NamedOptions::set(std::string_view name, double number) {
  const Known& option = find(name);
  if (option.with != Said::number)
    throw_invalid(std::string(name), number,
                  option.with == Said::text ? "must be a text, the name of an enumerator"
                                            : "cannot be said with a number");
  said_.emplace(name);
  if (name == "degree")
    options.degree = whole_int("degree", number);
  else if (name == "max_distance")
    options.max_distance = number;
  else if (name == "grow.steps")
    options.grow.steps = whole_int("grow.steps", number);
  else if (name == "grow.factor")
    options.grow.factor = number;
  else if (name == "fill_value")
    options.fill_value = number;
  else if (name == "tolerances.rank")
    options.tolerances.rank = number;
  else if (name == "tolerances.leverage")
    options.tolerances.leverage = number;
  else if (name == "tolerances.gradient_extent")
    options.tolerances.gradient_extent = number;
  else if (name == "threads")
    options.threads = whole_int("threads", number);
  else if (name == "radius")
    radius_ = number;
  else
    nearest_ = whole_number("nearest", number);
}

void NamedOptions::set(std::string_view name, std::string_view text) {
  const Known& option = find(name);
  if (option.with != Said::text)
    throw_invalid(std::string(name), "'" + std::string(text) + "'",
                  option.with == Said::number ? "must be a number" : "cannot be said with a text");
  said_.emplace(name);
  if (name == "weight") {
    options.weight = weight_of(text);
  } else if (name == "form") {
    options.form = form_of(text);
  } else if (name == "solver") {
    options.solver = solver_of(text);
  } else if (name == "search") {
    options.search = search_of(text);
  } else if (name == "unsupported") {
    options.unsupported = unsupported_of(text);
  } else if (name == "instruction_set") {
    options.instruction_set = instruction_set_of(text);
  } else {
    const std::array<std::string, 3> methods{"shepard", "mls", "imls"};
    if (std::find(methods.begin(), methods.end(), text) == methods.end())
      refuse_name("method", text, methods);
    method_ = text;
  }
}

Options NamedOptions::finished() const {
  Options all = options;
  if (!method_.empty()) {
    if (said_.contains("solver"))
      throw_invalid("method", "'" + method_ + "'", "stands for a solver: say one of both");
    if (method_ == "shepard") {
      require(all.degree == 0 || !said_.contains("degree"), "degree", all.degree,
              "must be 0 for the method 'shepard', a weighted mean; 'mls' and 'imls' have degrees");
      all.degree = 0;
    } else {
      all.solver = method_ == "mls" ? Solver::moment_matrix : Solver::gram_schmidt;
    }
  }
  for (const char* shorter : {"radius", "nearest"})
    if (said_.contains(shorter) && said_.contains("neighbours"))
      throw_invalid(shorter, "given",
                    "stands for neighbours, which are given too: say one of both");
  if (nearest_ && radius_)
    all.neighbours = NearestWithin(*nearest_, *radius_);
  else if (nearest_)
    all.neighbours = Nearest(*nearest_);
  else if (radius_)
    all.neighbours = Radius{*radius_};
  return all;
}

}  // namespace recon::bindings
