// LAMMPS as a library, with recon's grid in its scripts: `fix ... recon/grid` is known to the
// scripts that this program runs, though LAMMPS was built without it.
//
//   example_lammps SCRIPT [NAME=VALUE ...]     variables of the script, as lmp -var has them
//
// The script sets up, and has a variable `steps`; where other forces push along x, `pushed` is the
// momentum that they give. At the end the program says what the coupling took, and compares the
// change of the atoms' momentum with the impulse that the grid's nodes have lost. Exit status 1
// where they differ by more than rounding.
#include <lammps.h>
#include <library.h>
#include <modify.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "fix_recon_grid.hpp"

namespace {

using LAMMPS_NS::FixReconGrid;
using LAMMPS_NS::LAMMPS;

LAMMPS_NS::Fix* make_fix(LAMMPS* lammps, int count, char** words) {
  return new FixReconGrid(lammps, count, words);
}

// The atoms as they lie in LAMMPS: positions, velocities and masses are looked at, never copied.
std::array<double, 3> momentum_of(void* lammps) {
  const int atoms = lammps_extract_setting(lammps, "nlocal");
  auto* const velocity = static_cast<double**>(lammps_extract_atom(lammps, "v"));
  auto* const mass = static_cast<double*>(lammps_extract_atom(lammps, "mass"));
  auto* const type = static_cast<int*>(lammps_extract_atom(lammps, "type"));
  std::array<double, 3> sum{};
  for (int i = 0; i < atoms; ++i)
    for (std::size_t d = 0; d < 3; ++d) sum[d] += mass[type[i]] * velocity[i][d];
  return sum;
}

FixReconGrid* find_fix(void* lammps) {
  LAMMPS_NS::Modify* const modify = static_cast<LAMMPS*>(lammps)->modify;
  for (int i = 0; i < modify->nfix; ++i)
    if (auto* const found = dynamic_cast<FixReconGrid*>(modify->fix[i])) return found;
  return nullptr;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: example_lammps SCRIPT [NAME=VALUE ...]\n");
    return 2;
  }
  std::vector<std::string> words{"lammps", "-log", "none", "-screen", "none"};
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    const std::size_t equals = word.find('=');
    words.insert(words.end(), {"-var", word.substr(0, equals),
                               equals == std::string::npos ? "" : word.substr(equals + 1)});
  }
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  void* const lammps =
      lammps_open_no_mpi(static_cast<int>(arguments.size()), arguments.data(), nullptr);
  (*static_cast<LAMMPS*>(lammps)->modify->fix_map)["recon/grid"] = make_fix;

  // The script sets up; the run is ours, so that the momentum before it is known.
  lammps_file(lammps, argv[1]);
  const std::array<double, 3> before = momentum_of(lammps);
  const auto begin = std::chrono::steady_clock::now();
  lammps_command(lammps, "run ${steps}");
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  const std::array<double, 3> after = momentum_of(lammps);
  std::printf("%.0f atoms: %.2f s", lammps_get_natoms(lammps), taken.count());

  bool balanced = true;
  if (FixReconGrid* const fix = find_fix(lammps)) {
    std::printf(", of these %.2f s for %d frames of the grid\n", fix->seconds, fix->frames);
    // What other forces of the script have given, if it says so.
    auto* const by_others = static_cast<double*>(lammps_extract_variable(lammps, "pushed", "all"));
    const double pushed = by_others == nullptr ? 0 : *by_others;
    lammps_free(by_others);
    const double gained = after[0] - before[0], given = fix->compute_vector(0);
    std::printf("momentum along x: %+.10f, given by the grid %+.10f, by others %+.10f\n", gained,
                given, pushed);
    balanced = std::abs(gained - given - pushed) <=
               1e-10 * (std::abs(before[0]) + std::abs(given) + std::abs(pushed));
  } else {
    std::printf(" without the grid\n");
  }
  lammps_close(lammps);
  return balanced ? 0 : 1;
}
