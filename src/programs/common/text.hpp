// Words and numbers: lists as the command line has them, numbers as a reader likes them.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace recon::program {

// "vx,vy" gives {"vx", "vy"}; blanks around a word do not count, and a word in double quotes may
// hold the separator ("" inside for one quote). No words for an empty text.
std::vector<std::string> split(std::string_view text, char separator = ',');

// The number that the whole text is, whatever the locale; nothing if it is none or not finite.
std::optional<double> to_number(std::string_view text);

// With `digits` significant digits and no trailing zeros.
std::string number(double value, int digits = 5);
// By a printf format; "-" for NaN.
std::string or_dash(double value, const char* format);
// With separators between thousands: 1,234,567.
std::string count(std::size_t value);
// "1 particle", "2 particles".
std::string counted(std::size_t value, const std::string& noun);
// "x", "x and y", "x, y and z".
std::string enumeration(std::span<const std::string> words);

// A range of numbers, with figures that tell its ends apart: "-1.5 .. 3", "500000.01 .. 500000.02".
std::string range(double lower, double upper);
// One of the numbers from lower to upper, with as many figures as these.
std::string number_within(double value, double lower, double upper);
// 16 digits that stand for a text (FNV-1a), to tell whether it is the same as before.
std::string hash(std::string_view text);
// In quotes where a shell would make something else of it.
std::string shell_word(const std::string& text);

}  // namespace recon::program
