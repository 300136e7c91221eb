#include "runs/sealed_file.hpp"

#include <H5FDpublic.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <vector>

#include "recon/io/error.hpp"

namespace recon::mpm {
namespace {

// ---- bytes of a descriptor ---------------------------------------------------------------------
// 0 or errno.
int write_all(int descriptor, std::uint64_t at, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t count = pwrite(descriptor, bytes, size, static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return count < 0 ? errno : EIO;
    bytes += count;
    at += static_cast<std::uint64_t>(count);
    size -= static_cast<std::size_t>(count);
  }
  return 0;
}

// Zeros stand for what lies beyond the end. False where reading fails.
bool read_all(int descriptor, std::uint64_t at, char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t count = pread(descriptor, bytes, size, static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    if (count == 0) {
      std::memset(bytes, 0, size);
      return true;
    }
    bytes += count;
    at += static_cast<std::uint64_t>(count);
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

// ---- an HDF5 file driver whose writes never fail ------------------------------------------------
struct Target {
  int descriptor;
  int* error;  // null: for reading
};

// What HDF5 knows a file by: begins with its own part.
struct DriverFile {
  H5FD_t base{};
  Target target{};
  haddr_t allocated = 0, end = 0;
};

DriverFile* of(H5FD_t* file) {
  return reinterpret_cast<DriverFile*>(file);
}
const DriverFile* of(const H5FD_t* file) {
  return reinterpret_cast<const DriverFile*>(file);
}

H5FD_t* driver_open(const char*, unsigned, hid_t access, haddr_t) {
  const auto* target = static_cast<const Target*>(H5Pget_driver_info(access));
  struct stat status {};
  if (!target || fstat(target->descriptor, &status) != 0) return nullptr;
  auto* file = new DriverFile;
  file->target = *target;
  file->end = static_cast<haddr_t>(status.st_size);
  return &file->base;
}

herr_t driver_close(H5FD_t* file) {
  delete of(file);
  return 0;
}

int driver_compare(const H5FD_t* a, const H5FD_t* b) {
  return of(a)->target.descriptor - of(b)->target.descriptor;
}

herr_t driver_query(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t driver_allocated(const H5FD_t* file, H5FD_mem_t) {
  return of(file)->allocated;
}

herr_t driver_allocate(H5FD_t* file, H5FD_mem_t, haddr_t size) {
  of(file)->allocated = size;
  return 0;
}

haddr_t driver_end(const H5FD_t* file, H5FD_mem_t) {
  return of(file)->end;
}

herr_t driver_read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* buffer) {
  const Target& target = of(file)->target;
  if (target.error && *target.error != 0) return -1;
  return read_all(target.descriptor, at, static_cast<char*>(buffer), size) ? 0 : -1;
}

herr_t driver_write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size,
                    const void* buffer) {
  DriverFile& own = *of(file);
  if (!own.target.error) return -1;
  if (*own.target.error == 0)
    *own.target.error =
        write_all(own.target.descriptor, at, static_cast<const char*>(buffer), size);
  own.end = std::max(own.end, at + size);
  return 0;
}

herr_t driver_truncate(H5FD_t* file, hid_t, hbool_t) {
  DriverFile& own = *of(file);
  if (!own.target.error || own.end == own.allocated) return 0;
  if (*own.target.error == 0 &&
      ftruncate(own.target.descriptor, static_cast<off_t>(own.allocated)) != 0)
    *own.target.error = errno;
  own.end = own.allocated;
  return 0;
}

hid_t driver() {
  static const hid_t id = [] {
    static H5FD_class_t methods{};
    methods.name = "recon";
    methods.maxaddr = (static_cast<haddr_t>(1) << 62);
    methods.fc_degree = H5F_CLOSE_STRONG;
    methods.fapl_size = sizeof(Target);
    methods.open = driver_open;
    methods.close = driver_close;
    methods.cmp = driver_compare;
    methods.query = driver_query;
    methods.get_eoa = driver_allocated;
    methods.set_eoa = driver_allocate;
    methods.get_eof = driver_end;
    methods.read = driver_read;
    methods.write = driver_write;
    methods.truncate = driver_truncate;
    for (H5FD_mem_t& each : methods.fl_map) each = H5FD_MEM_SUPER;
    return H5FDregister(&methods);
  }();
  return id;
}

// ---- the seal -----------------------------------------------------------------------------------
constexpr char first_line[] = "recon-mpm checkpoint, format ";
constexpr int format = 3;

// Of all after the seal; false where reading fails.
bool seal_of(int descriptor, std::array<char, seal_size>& seal) {
  std::uint64_t hash = 14695981039346656037u, length = 0;
  std::vector<char> bytes(1 << 18);
  struct stat status {};
  if (fstat(descriptor, &status) != 0) return false;
  const auto size = static_cast<std::uint64_t>(status.st_size);
  length = size > seal_size ? size - seal_size : 0;
  for (std::uint64_t at = 0; at < length; at += bytes.size()) {
    if (!read_all(descriptor, seal_size + at, bytes.data(), bytes.size())) return false;
    const std::size_t words =
        static_cast<std::size_t>((std::min<std::uint64_t>(bytes.size(), length - at) + 7) / 8);
    for (std::size_t w = 0; w < words; ++w) {
      std::uint64_t word = 0;
      for (std::size_t b = 0; b < 8; ++b)
        word |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[8 * w + b])) << (8 * b);
      hash = (hash ^ word) * 1099511628211u;
      hash ^= hash >> 32;
    }
  }
  seal.fill(0);
  std::snprintf(seal.data(), seal.size(), "%s%d\nbytes %" PRIu64 "\nchecksum %016" PRIx64 "\n",
                first_line, format, length, hash);
  return true;
}

}  // namespace

hid_t create_hdf5(int descriptor, int& error) {
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  const Target target{descriptor, &error};
  // The format of HDF5 1.8 has checksums of its own for all but the numbers.
  if (H5Pset_userblock(creation, seal_size) < 0 || H5Pset_obj_track_times(creation, false) < 0 ||
      H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18) < 0 ||
      H5Pset_driver(access, driver(), &target) < 0)
    return -1;
  return H5Fcreate("checkpoint", H5F_ACC_TRUNC, creation, access);
}

hid_t open_hdf5(int descriptor) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  const Target target{descriptor, nullptr};
  if (H5Pset_driver(access, driver(), &target) < 0) return -1;
  return H5Fopen("checkpoint", H5F_ACC_RDONLY, access);
}

int write_seal(int descriptor) {
  std::array<char, seal_size> seal;
  if (!seal_of(descriptor, seal)) return errno;
  return write_all(descriptor, 0, seal.data(), seal.size());
}

void check_seal(const std::filesystem::path& path, int descriptor) {
  std::array<char, seal_size> found, right;
  if (!read_all(descriptor, 0, found.data(), found.size()) || !seal_of(descriptor, right))
    throw FileError(path, 0, "could not be read");
  const std::string_view start(found.data(), found.size());
  if (start.starts_with("\x89HDF\r\n\x1a\n"))
    throw FileError(path, 0,
                    "is an HDF5 file without the seal that checkpoints have (format " +
                        std::to_string(format) +
                        "), perhaps of an earlier version: the run must begin anew");
  if (!start.starts_with(first_line)) throw FileError(path, 0, "is no checkpoint");
  int other = format;
  std::from_chars(found.data() + std::strlen(first_line), found.data() + found.size(), other);
  if (other != format)
    throw FileError(path, 0,
                    "is a checkpoint of format " + std::to_string(other) +
                        ", this version reads format " + std::to_string(format));
  if (found != right)
    throw FileError(path, 0,
                    "is damaged: its length or checksum is not the one it was sealed with");
}

}  // namespace recon::mpm
