// HDF5 files behind a seal: 512 bytes of text before them with a length and a checksum of all that
// follows, so that a damaged file is found out before the HDF5 library sees it.
//
//   recon-mpm checkpoint, format 3
//   bytes 9136
//   checksum 0123456789abcdef
//
// followed by zeros. The checksum is that of the bytes after the seal as little-endian words of 64
// bits, the last one filled up with zeros: h = (h ^ word) 1099511628211, then h ^= h >> 32, from
// h = 14695981039346656037. Each step is one to one, so that no change within one word goes unseen.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "io/hdf5.hpp"

namespace recon::mpm {

constexpr std::uint64_t seal_size = 512;  // a size that HDF5 allows for a user block

using detail::Handle;
using detail::QuietHdf5;

// A new file that HDF5 writes to an open descriptor, behind the place of the seal. HDF5 1.10
// crashes after a write that failed, so failures are hidden from it: `error` keeps the first errno,
// and a file with an error must be thrown away.
hid_t create_hdf5(int descriptor, int& error);
// Opens the file behind the seal for reading.
hid_t open_hdf5(int descriptor);

// Writes the seal for the bytes that follow it. Returns the first errno, or 0.
int write_seal(int descriptor);
// Throws FileError unless the file has a seal of this format that fits what follows.
void check_seal(const std::filesystem::path& path, int descriptor);

}  // namespace recon::mpm
