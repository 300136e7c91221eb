// The nearest valid names to a misspelt one, for error messages.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace recon {

// The number of insertions, deletions, substitutions and swaps of adjacent letters that turn `a`
// into `b` (optimal string alignment distance), ignoring case. Cost O(|a| |b|).
std::size_t edit_distance(std::string_view a, std::string_view b);

// At most `most` of the candidates that are near enough to `word` to be a slip of it, nearest
// first: edit distance at most a third of the longer of the two, or one contained in the other.
std::vector<std::string> nearest_names(std::string_view word,
                                       std::span<const std::string> candidates,
                                       std::size_t most = 3);

// A hint for a message: "did you mean 'vx' or 'vy'?", or "valid: vx, vy, vz" where nothing is near.
// Never empty unless there are no candidates.
std::string suggest(std::string_view word, std::span<const std::string> candidates);

}  // namespace recon
