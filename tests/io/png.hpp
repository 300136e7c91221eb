// Decodes the PNG files that gnuplot writes (8 bits, RGB or RGBA, not interlaced), for tests.
#pragma once

#include <zlib.h>

#include <array>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace test {

struct Image {
  std::size_t width = 0, height = 0, channels = 0;
  std::vector<unsigned char> data;
  std::array<int, 3> pixel(std::size_t x, std::size_t y) const {
    const unsigned char* at = &data.at((y * width + x) * channels);
    return {at[0], at[1], at[2]};
  }
};

inline std::size_t big_endian(const std::string& bytes, std::size_t at) {
  std::size_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
  return value;
}

// The predictor of filter 4 (Paeth): whichever neighbour is nearest to left + above - corner.
inline int paeth(int left, int above, int corner) {
  const int guess = left + above - corner;
  const int a = std::abs(guess - left), b = std::abs(guess - above), c = std::abs(guess - corner);
  return a <= b && a <= c ? left : b <= c ? above : corner;
}

inline Image decode_png(const std::string& bytes) {
  if (!bytes.starts_with("\x89PNG\r\n\x1a\n")) throw std::runtime_error("no PNG signature");
  Image image;
  std::string packed;
  for (std::size_t at = 8; at < bytes.size();) {
    const std::size_t length = big_endian(bytes, at);
    const std::string kind = bytes.substr(at + 4, 4);
    if (kind == "IHDR") {
      image.width = big_endian(bytes, at + 8);
      image.height = big_endian(bytes, at + 12);
      const int depth = bytes[at + 16], colours = bytes[at + 17], interlaced = bytes[at + 20];
      if (depth != 8 || (colours != 2 && colours != 6) || interlaced != 0)
        throw std::runtime_error("a kind of PNG that this decoder does not know");
      image.channels = colours == 2 ? 3 : 4;
    }
    if (kind == "IDAT") packed += bytes.substr(at + 8, length);
    at += length + 12;
  }
  const std::size_t line = image.width * image.channels;
  std::vector<unsigned char> raw((line + 1) * image.height);
  uLongf size = raw.size();
  if (uncompress(raw.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size()) !=
          Z_OK ||
      size != raw.size())
    throw std::runtime_error("damaged PNG data");
  image.data.resize(line * image.height);
  for (std::size_t y = 0; y < image.height; ++y) {
    const int filter = raw[y * (line + 1)];
    for (std::size_t i = 0; i < line; ++i) {
      unsigned char* out = &image.data[y * line + i];
      const int left = i >= image.channels ? out[-static_cast<std::ptrdiff_t>(image.channels)] : 0;
      const int above = y > 0 ? *(out - line) : 0;
      const int corner = y > 0 && i >= image.channels ? *(out - line - image.channels) : 0;
      const int guess = filter == 1   ? left
                        : filter == 2 ? above
                        : filter == 3 ? (left + above) / 2
                        : filter == 4 ? paeth(left, above, corner)
                                      : 0;
      *out = static_cast<unsigned char>(raw[y * (line + 1) + 1 + i] + guess);
    }
  }
  return image;
}

}  // namespace test
