// The cells of a column that are no numbers, by row, in little memory.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace recon {

class TextCells {
 public:
  // Rows in rising order.
  void add(std::uint32_t row, std::string_view text);

  bool empty() const { return cells_.empty(); }
  std::size_t size() const { return cells_.size(); }
  std::uint32_t row(std::size_t cell) const { return cells_[cell].row; }
  std::string_view text(std::size_t cell) const { return word(cells_[cell].word); }

  // The text in a row, or nothing.
  std::optional<std::string_view> at(std::uint32_t row) const;

  // Drops the cells for which drop(row, text) is true.
  template <class Drop>
  void erase_if(const Drop& drop) {
    std::erase_if(cells_, [&](const Cell& cell) { return drop(cell.row, word(cell.word)); });
  }
  // Drops the cells of rows whose entry of `kept` is false, and renumbers the rows that remain.
  void keep_rows(const std::vector<bool>& kept);

 private:
  struct Cell {
    std::uint32_t row, word;
  };
  std::string_view word(std::size_t number) const;

  std::vector<Cell> cells_;
  // The distinct texts one behind another, and where each ends. Repeated labels are stored once.
  // Where there are many different texts, a new one is compared with the first of them only.
  std::string words_;
  std::vector<std::uint64_t> ends_;
};

}  // namespace recon
