// The seal of a checkpoint, made anew for contents that were changed: written from its description
// (src/mpm/sealed_file.hpp), not with its code.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

namespace recon::test {

inline constexpr std::size_t seal_size = 512;

inline std::string sealed(std::string bytes) {
  if (bytes.size() < seal_size) return bytes;
  std::uint64_t hash = 14695981039346656037u;
  for (std::size_t at = seal_size; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    for (std::size_t b = 0; b < 8 && at + b < bytes.size(); ++b)
      word += std::uint64_t{static_cast<unsigned char>(bytes[at + b])} << (8 * b);
    hash = (hash ^ word) * 1099511628211u;
    hash ^= hash >> 32;
  }
  char text[seal_size] = {};
  std::snprintf(text, sizeof text, "recon-mpm checkpoint, format 3\nbytes %zu\nchecksum %016llx\n",
                bytes.size() - seal_size, static_cast<unsigned long long>(hash));
  return bytes.replace(0, seal_size, text, seal_size);
}

}  // namespace recon::test
