#include "recon/core/names.hpp"

#include <algorithm>

#include "core/lower_case.hpp"

namespace recon {

std::size_t edit_distance(std::string_view first, std::string_view second) {
  const std::string a = detail::lower_case(first), b = detail::lower_case(second);
  // Three rows of the dynamic programme: two above (for swaps), one above, current.
  std::vector<std::size_t> above2(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) above[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substitution = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, substitution});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], above2[j - 2] + 1);
    }
    std::swap(above2, above);
    std::swap(above, row);
  }
  return above[b.size()];
}

std::vector<std::string> nearest_names(std::string_view word,
                                       std::span<const std::string> candidates, std::size_t most) {
  std::vector<std::pair<std::size_t, std::string>> near;
  const std::string wanted = detail::lower_case(word);
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    const std::size_t longer = std::max(word.size(), candidate.size());
    const std::string name = detail::lower_case(candidate);
    const bool contained =
        wanted.size() >= 3 && (name.find(wanted) != std::string::npos ||
                               (name.size() >= 3 && wanted.find(name) != std::string::npos));
    if (distance <= std::max<std::size_t>(1, longer / 3) || contained)
      near.emplace_back(distance, candidate);
  }
  std::stable_sort(near.begin(), near.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(most, near.size()); ++i) names.push_back(near[i].second);
  return names;
}

std::string suggest(std::string_view word, std::span<const std::string> candidates) {
  const std::vector<std::string> near = nearest_names(word, candidates);
  std::string text;
  if (!near.empty()) {
    text = "did you mean ";
    for (std::size_t i = 0; i < near.size(); ++i)
      text += (i == 0 ? "'" : i + 1 == near.size() ? " or '" : ", '") + near[i] + "'";
    return text + "?";
  }
  for (const std::string& candidate : candidates)
    text += (text.empty() ? "valid: " : ", ") + candidate;
  return text;
}

}  // namespace recon
