#include "runs/problem_reader.hpp"

#include <algorithm>
#include <cmath>

#include "core/brief.hpp"

namespace recon::mpm {
namespace {

// A value or a list of them as a text that does not depend on how numbers are written.
std::string text_of(const toml::node& node) {
  if (const toml::array* array = node.as_array()) {
    std::string text;
    for (const toml::node& each : *array) text += (text.empty() ? "" : ", ") + text_of(each);
    return "[" + text + "]";
  }
  if (node.is_number()) return recon::detail::brief(node.value_or(0.0), 12);
  return "'" + node.value_or(std::string()) + "'";
}

}  // namespace

template <int D>
void ProblemReader<D>::note(const TomlTable& table, std::string_view key) {
  if (const toml::node* node = table.raw().get(key))
    out_.formulas[table.full(key)] = text_of(*node);
}

template <int D>
Expression ProblemReader<D>::expression(const TomlTable& table, std::string_view key,
                                        const toml::node& node, const std::string& needed) const {
  if (const auto number = node.value<double>(); number && !node.is_boolean()) {
    if (!std::isfinite(*number)) table.fail_at(node, key, "must be finite");
    return *number;
  }
  const auto text = node.value_exact<std::string>();
  if (!text) table.fail_at(node, key, "a number or an expression in quotes is needed");
  try {
    return {*text, constants_};
  } catch (const std::invalid_argument& error) {
    table.fail_at(node, key, needed.empty() ? error.what() : error.what() + (" " + needed));
  }
}

template <int D>
std::array<Expression, D> ProblemReader<D>::expressions(const TomlTable& table,
                                                        std::string_view key) {
  note(table, key);
  std::array<Expression, D> all;
  int d = 0;
  for (const toml::node* node : table.elements(key, D)) all[d++] = expression(table, key, *node);
  return all;
}

template <int D>
void ProblemReader<D>::read_constants() {
  const TomlTable table = file_.table("constants");
  std::vector<std::string> open;
  for (const auto& [key, node] : table.raw()) open.emplace_back(key.str());
  for (bool last_try = false; !open.empty();) {
    std::vector<std::string> later;
    for (const std::string& key : open) {
      try {
        const toml::node& node = *table.elements(key, 1).front();
        const auto text = node.value_exact<std::string>();
        std::map<std::string, double> with_it = constants_;
        with_it[key] = text ? Formula(*text, {}, constants_)({}) : table.number(key);
        Formula("0", Expression::variable_names(), with_it);  // is the name one for formulas?
        constants_ = std::move(with_it);
        note(table, key);
      } catch (const std::invalid_argument& error) {
        if (last_try) table.fail(key, error.what());
        later.push_back(key);
      }
    }
    last_try = later.size() == open.size();
    open = std::move(later);
  }
}

template class ProblemReader<1>;
template class ProblemReader<2>;
template class ProblemReader<3>;

}  // namespace recon::mpm
