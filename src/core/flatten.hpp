// RECON_FLATTEN after the parameters of a lambda: whatever its body calls is inlined, also where
// the compiler has inlined so much already that it would stop. Not under sanitizers, whose checks
// would make a function of that size take minutes to compile.
#pragma once

#if defined(__SANITIZE_ADDRESS__)
#define RECON_FLATTEN
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define RECON_FLATTEN
#endif
#endif

#ifndef RECON_FLATTEN
#define RECON_FLATTEN __attribute__((flatten))
#endif
