// Numbers as VTK files hold them: ten types, in either order of bytes, in base64, in blocks that
// zlib has compressed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace recon::detail {

enum class NumberKind { whole, natural, real };
struct NumberFormat {
  NumberKind kind = NumberKind::real;
  std::size_t size = 8;  // bytes
};

// The format of a name in legacy files (float, unsigned_char, vtkIdType, ...) or in XML (Float32,
// UInt8, ...); nothing for another. Legacy files keep vtkIdType in 4 bytes.
std::optional<NumberFormat> legacy_number(std::string_view name);
std::optional<NumberFormat> xml_number(std::string_view name);

// Appends the numbers that the bytes hold. `swapped`: in the other order than this machine's.
// Returns whether all of them are exact as double.
bool append_numbers(std::string_view bytes, NumberFormat format, bool swapped,
                    std::vector<double>& values);

bool is_little_endian();

// Bytes one after another, from bytes as they are or from base64, where blanks do not count and
// padding may stand between parts that were encoded one by one.
class ByteCursor {
 public:
  ByteCursor(std::string_view text, bool base64) : text_(text), base64_(base64) {}
  // The next `count` bytes, or nothing where there are not that many or what is there is no base64.
  // Memory grows with the bytes that are there, not with `count`.
  std::optional<std::string> read(std::uint64_t count);

 private:
  bool decode_quad();

  std::string_view text_;
  bool base64_;
  std::size_t at_ = 0;
  std::string decoded_;  // bytes of base64 that were not yet given away
};

// What zlib has compressed to `compressed`: just `expected` bytes, or nothing.
std::optional<std::string> inflate_bytes(std::string_view compressed, std::uint64_t expected);

}  // namespace recon::detail
