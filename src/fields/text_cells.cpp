#include "recon/fields/text_cells.hpp"

#include <algorithm>

namespace recon {

std::string_view TextCells::word(std::size_t number) const {
  const std::uint64_t begin = number == 0 ? 0 : ends_[number - 1];
  return std::string_view(words_).substr(begin, ends_[number] - begin);
}

void TextCells::add(std::uint32_t row, std::string_view text) {
  constexpr std::size_t sought = 64;
  std::size_t number = cells_.empty() ? 0 : cells_.back().word;
  if (cells_.empty() || word(number) != text) {
    const std::size_t known = std::min(ends_.size(), sought);
    for (number = 0; number < known && word(number) != text;) ++number;
    if (number == known) {
      number = ends_.size();
      words_ += text;
      ends_.push_back(words_.size());
    }
  }
  cells_.push_back({row, static_cast<std::uint32_t>(number)});
}

std::optional<std::string_view> TextCells::at(std::uint32_t row) const {
  const auto cell =
      std::lower_bound(cells_.begin(), cells_.end(), row,
                       [](const Cell& each, std::uint32_t wanted) { return each.row < wanted; });
  if (cell == cells_.end() || cell->row != row) return std::nullopt;
  return word(cell->word);
}

void TextCells::keep_rows(const std::vector<bool>& kept) {
  std::size_t next = 0;
  std::uint32_t row = 0, new_row = 0;
  for (const Cell& cell : cells_) {
    for (; row < cell.row; ++row) new_row += kept[row] ? 1 : 0;
    if (kept[row]) cells_[next++] = {new_row, cell.word};
  }
  cells_.resize(next);
}

}  // namespace recon
