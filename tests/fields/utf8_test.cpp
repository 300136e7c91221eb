#include "recon/fields/utf8.hpp"

#include <gtest/gtest.h>

#include "recon/fields/text_cells.hpp"

namespace {

using recon::is_utf8;
using recon::to_utf8;

TEST(Utf8, WellFormed) {
  for (const char* text :
       {"", "v", "v\xc2\xb2", "\xe2\x82\xac", "\xf0\x9f\x98\x80", "\xed\x9f\xbf"})
    EXPECT_TRUE(is_utf8(text)) << text;
}

TEST(Utf8, Malformed) {
  for (const char* text :
       {"v\xb2", "\xc2", "\xc2v", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80", "\xff",
        "\xf4\x90\x80\x80", "\xf8\x88\x80\x80\x80", "\xef\xbf\xbe", "\xe2\x82"})
    EXPECT_FALSE(is_utf8(text)) << text;
}

TEST(Utf8, OtherBytesAreWindows1252) {
  EXPECT_EQ(to_utf8("v\xb2"), "v\xc2\xb2");
  EXPECT_EQ(to_utf8("\x80 \xe9"), "\xe2\x82\xac \xc3\xa9");
  EXPECT_EQ(to_utf8("v\xc2\xb2"), "v\xc2\xb2");
  std::string all;
  for (int byte = 1; byte < 256; ++byte) all += static_cast<char>(byte);
  EXPECT_TRUE(is_utf8(to_utf8(all)));
}

TEST(TextCells, ManyDifferentTexts) {
  recon::TextCells cells;
  for (std::uint32_t row = 0; row < 1000; ++row)
    cells.add(2 * row, row % 3 == 0 ? "Fe" : "name" + std::to_string(row));
  EXPECT_EQ(cells.at(0), "Fe");
  EXPECT_EQ(cells.at(1996), "name998");
  EXPECT_EQ(cells.at(1998), "Fe");
  EXPECT_FALSE(cells.at(1));
  std::vector<bool> kept(2000, true);
  kept[0] = kept[1] = kept[6] = false;
  cells.keep_rows(kept);
  EXPECT_EQ(cells.size(), 998u);
  EXPECT_EQ(cells.at(0), "name1");
  EXPECT_EQ(cells.at(1993), "name998");
}

}  // namespace
