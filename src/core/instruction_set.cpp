#include "recon/core/instruction_set.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "recon/core/error.hpp"

namespace recon {

std::span<const InstructionSet> available_instruction_sets() {
  static const auto sets = [] {
    struct {
      std::array<InstructionSet, 3> list{InstructionSet::generic};
      std::size_t size = 1;
    } found;
#ifdef RECON_AVX2_SET
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
        __builtin_cpu_supports("bmi2"))
      found.list[found.size++] = InstructionSet::avx2;
#endif
#ifdef RECON_AVX512_SET
    if (found.size == 2 && __builtin_cpu_supports("avx512f") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
      found.list[found.size++] = InstructionSet::avx512;
#endif
    return found;
  }();
  return {sets.list.data(), sets.size};
}

InstructionSet resolved(InstructionSet set) {
  const auto sets = available_instruction_sets();
  if (set == InstructionSet::automatic) return sets.back();
  if (std::find(sets.begin(), sets.end(), set) == sets.end()) {
    std::string rule = "must be available on this processor and in this build:";
    for (const InstructionSet one : sets) rule += " " + std::string(name_of(one));
    detail::throw_invalid("instruction_set", name_of(set), rule);
  }
  return set;
}

}  // namespace recon
