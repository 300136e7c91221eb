#include "programs/common/errors.hpp"

#include <cstdio>
#include <new>

namespace recon::program {

Failure failure() {
  try {
    throw;
  } catch (const ProgramError& error) {
    return {error.code(), error.what()};
  } catch (const InvalidArgument& error) {
    return {wrong_usage, error.what()};
  } catch (const std::bad_alloc&) {
    return {internal_error, "out of memory; a larger spacing needs less"};
  } catch (const std::exception& error) {
    return {internal_error, error.what()};
  }
}

void say(const std::string& program, const std::string& what) {
  std::fflush(stdout);
  std::fprintf(stderr, "%s: %s\n", program.c_str(), what.c_str());
}

}  // namespace recon::program
