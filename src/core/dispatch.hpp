// One function for several instruction sets.
//
// Files named *.simd.cpp are compiled once per set (cmake/ReconTargets.cmake), with RECON_SET being
// the name of the set. What they define stands in the namespace recon::RECON_SET:
//
//   // sum.hpp                                        // sum.simd.cpp
//   RECON_FOR_EACH_SET(float sum(const float*, int))  namespace recon::RECON_SET { float sum(...)
//   {...} } RECON_DISPATCH(set, sum)(x, n);                   // set: resolved(InstructionSet)
//
// A template or inline function of ordinary types that such a file instantiates is a danger: the
// linker keeps one copy for the whole program, perhaps the one with instructions that the processor
// lacks. Kernels are therefore templates over Pack types (core/pack.hpp), which differ by set, or
// stand in that namespace; the test structure.no_shared_symbols looks for others.
#pragma once

#include "recon/core/instruction_set.hpp"

#ifdef RECON_X86_SETS
#define RECON_FOR_EACH_SET(...) \
  namespace generic {           \
  __VA_ARGS__;                  \
  }                             \
  namespace avx2 {              \
  __VA_ARGS__;                  \
  }                             \
  namespace avx512 {            \
  __VA_ARGS__;                  \
  }
#define RECON_DISPATCH(set, ...)                                   \
  ((set) == ::recon::InstructionSet::avx512 ? &avx512::__VA_ARGS__ \
   : (set) == ::recon::InstructionSet::avx2 ? &avx2::__VA_ARGS__   \
                                            : &generic::__VA_ARGS__)
#else
#define RECON_FOR_EACH_SET(...) \
  namespace generic {           \
  __VA_ARGS__;                  \
  }
#define RECON_DISPATCH(set, ...) (&generic::__VA_ARGS__)
#endif
