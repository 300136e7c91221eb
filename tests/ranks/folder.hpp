#pragma once

#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>

#include "petsc/petsc_support.hpp"

namespace recon::mpm::test {

// An empty folder that all ranks see; the first one makes and removes it.
class Folder {
 public:
  Folder() {
    std::array<char, 512> name{};
    const std::string pattern =
        (std::filesystem::temp_directory_path() / "recon-test-XXXXXX").string();
    std::memcpy(name.data(), pattern.data(), std::min(pattern.size(), name.size() - 1));
    if (recon::testing::world().rank() == 0 && mkdtemp(name.data()) == nullptr) name[0] = 0;
    MPI_Bcast(name.data(), static_cast<int>(name.size()), MPI_CHAR, 0,
              recon::testing::world().get());
    path = name.data();
  }
  ~Folder() {
    MPI_Barrier(recon::testing::world().get());
    if (recon::testing::world().rank() == 0) std::filesystem::remove_all(path);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::filesystem::path path;
};

}  // namespace recon::mpm::test
