// XYZ files, from seeds of that kind.
#include <cstddef>
#include <cstdint>

#include "reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  recon::fuzz::read({reinterpret_cast<const char*>(data), size});
  return 0;
}
