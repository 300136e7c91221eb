#include "vtk_numbers.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <new>

namespace recon::detail {

namespace {

struct Named {
  std::string_view name;
  NumberFormat format;
};
using enum NumberKind;
constexpr std::array legacy_names{
    Named{"char", {whole, 1}},
    Named{"signed_char", {whole, 1}},
    Named{"unsigned_char", {natural, 1}},
    Named{"short", {whole, 2}},
    Named{"unsigned_short", {natural, 2}},
    Named{"int", {whole, 4}},
    Named{"unsigned_int", {natural, 4}},
    Named{"long", {whole, 8}},
    Named{"unsigned_long", {natural, 8}},
    Named{"float", {real, 4}},
    Named{"double", {real, 8}},
    Named{"vtkidtype", {whole, 4}},
    Named{"vtktypeint64", {whole, 8}},
    Named{"vtktypeuint64", {natural, 8}},
};
constexpr std::array xml_names{
    Named{"Int8", {whole, 1}},     Named{"UInt8", {natural, 1}},  Named{"Int16", {whole, 2}},
    Named{"UInt16", {natural, 2}}, Named{"Int32", {whole, 4}},    Named{"UInt32", {natural, 4}},
    Named{"Int64", {whole, 8}},    Named{"UInt64", {natural, 8}}, Named{"Float32", {real, 4}},
    Named{"Float64", {real, 8}},
};

template <class T>
bool append_as(std::string_view bytes, bool swapped, std::vector<double>& values) {
  bool exact = true;
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    char raw[sizeof(T)];
    std::memcpy(raw, bytes.data() + at, sizeof raw);
    if (swapped) std::reverse(raw, raw + sizeof raw);
    T number;
    std::memcpy(&number, raw, sizeof raw);
    values.push_back(static_cast<double>(number));
    if constexpr (std::is_integral_v<T> && sizeof(T) == 8) {
      constexpr T most = T{1} << 53;
      exact = exact && number <= most;
      if constexpr (std::is_signed_v<T>) exact = exact && number >= -most;
    }
  }
  return exact;
}

int value_of(char letter) {
  if (letter >= 'A' && letter <= 'Z') return letter - 'A';
  if (letter >= 'a' && letter <= 'z') return letter - 'a' + 26;
  if (letter >= '0' && letter <= '9') return letter - '0' + 52;
  return letter == '+' ? 62 : letter == '/' ? 63 : -1;
}

}  // namespace

std::optional<NumberFormat> legacy_number(std::string_view name) {
  std::string lower(name);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  for (const Named& each : legacy_names)
    if (each.name == lower) return each.format;
  return {};
}

std::optional<NumberFormat> xml_number(std::string_view name) {
  for (const Named& each : xml_names)
    if (each.name == name) return each.format;
  return {};
}

bool append_numbers(std::string_view bytes, NumberFormat format, bool swapped,
                    std::vector<double>& values) {
  values.reserve(values.size() + bytes.size() / format.size);
  if (format.kind == real)
    return format.size == 4 ? append_as<float>(bytes, swapped, values)
                            : append_as<double>(bytes, swapped, values);
  const bool is_signed = format.kind == whole;
  switch (format.size) {
    case 1:
      return is_signed ? append_as<std::int8_t>(bytes, swapped, values)
                       : append_as<std::uint8_t>(bytes, swapped, values);
    case 2:
      return is_signed ? append_as<std::int16_t>(bytes, swapped, values)
                       : append_as<std::uint16_t>(bytes, swapped, values);
    case 4:
      return is_signed ? append_as<std::int32_t>(bytes, swapped, values)
                       : append_as<std::uint32_t>(bytes, swapped, values);
    default:
      return is_signed ? append_as<std::int64_t>(bytes, swapped, values)
                       : append_as<std::uint64_t>(bytes, swapped, values);
  }
}

bool is_little_endian() {
  return std::endian::native == std::endian::little;
}

bool ByteCursor::decode_quad() {
  std::array<int, 4> quad{};
  std::size_t letters = 0, pads = 0;
  while (letters + pads < 4) {
    if (at_ == text_.size()) return false;
    const char letter = text_[at_++];
    if (letter == ' ' || letter == '\n' || letter == '\r' || letter == '\t') continue;
    if (letter == '=' && letters >= 2) {
      ++pads;
      continue;
    }
    const int value = value_of(letter);
    if (value < 0 || pads > 0) return false;
    quad[letters++] = value;
  }
  const int bits = quad[0] << 18 | quad[1] << 12 | quad[2] << 6 | quad[3];
  for (std::size_t byte = 0; byte < 3 - pads; ++byte)
    decoded_ += static_cast<char>(bits >> (16 - 8 * byte) & 0xff);
  return true;
}

std::optional<std::string> ByteCursor::read(std::uint64_t count) {
  if (!base64_) {
    if (count > text_.size() - at_) return {};
    const std::size_t from = at_;
    at_ += static_cast<std::size_t>(count);
    return std::string(text_.substr(from, static_cast<std::size_t>(count)));
  }
  while (decoded_.size() < count)
    if (!decode_quad()) return {};
  std::string bytes = decoded_.substr(0, static_cast<std::size_t>(count));
  decoded_.erase(0, static_cast<std::size_t>(count));
  return bytes;
}

std::optional<std::string> inflate_bytes(std::string_view compressed, std::uint64_t expected) {
  // zlib makes at most 1032 bytes of one: what promises more is damaged, and gets no memory.
  if (expected > 1032 * static_cast<std::uint64_t>(compressed.size()) + 64) return {};
  std::string bytes(static_cast<std::size_t>(expected), '\0');
  uLongf size = static_cast<uLongf>(expected);
  const int code = uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                              reinterpret_cast<const Bytef*>(compressed.data()),
                              static_cast<uLong>(compressed.size()));
  if (code == Z_MEM_ERROR) throw std::bad_alloc();
  if (code != Z_OK || size != expected) return {};
  return bytes;
}

}  // namespace recon::detail
