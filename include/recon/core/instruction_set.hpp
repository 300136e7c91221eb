// Which vector instructions the compiled kernels use, found out while the program runs.
//
// The kernels are compiled once for every instruction set that the build knows (on x86-64: generic,
// AVX2 with FMA, AVX-512), each several targets at a time. The best one that this processor has is
// taken; another can be asked for, to compare them. Results of different sets agree to rounding,
// not to the bit: wider sets fuse multiplications and additions.
#pragma once

#include <cstdint>
#include <iterator>
#include <span>
#include <string_view>

namespace recon {

enum class InstructionSet : std::uint8_t {
  automatic,  // the best one available
  generic,    // what the compiler was told for the whole library: on x86-64 SSE2
  avx2,       // x86-64-v3: AVX2, FMA, BMI2
  avx512      // x86-64-v4: AVX-512 F, BW, CD, DQ, VL
};

constexpr std::string_view name_of(InstructionSet set) {
  constexpr std::string_view names[] = {"automatic", "generic", "avx2", "avx512"};
  const auto place = static_cast<std::size_t>(set);
  return place < std::size(names) ? names[place] : "unknown";
}

// The sets that this build holds and this processor has, the best one last;
// `generic` is among them.
std::span<const InstructionSet> available_instruction_sets();

// `automatic` becomes the best one available; throws InvalidArgument for one that is not available.
InstructionSet resolved(InstructionSet set);

}  // namespace recon
