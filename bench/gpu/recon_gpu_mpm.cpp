// recon-gpu-mpm: the step of the material point method on the GPU of this machine, checked against
// Step on the processor, and timed. Writes <out>/steps.md, and prints it.
//
//   recon-gpu-mpm [<out> [cells [steps]]]     out/gpu, 64 and 60 by default
//
// For each method that has a form for a GPU first a cube of 10^3 cells with 2^3 particles in each
// takes 20 steps on both: the exit status is 1 where a number of an array of particles differs by
// more than 1e-12 of the largest one there, or where a second run has other bits. Then a cube of
// `cells`^3 cells with 8 particles in each takes the given number of steps in one go, of which the
// last half is timed. The exit status is 77 where there is no GPU.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "gpu.hpp"
#include "gpu/on_gpu.hpp"
#include "recon/gpu/run.hpp"
#include "recon/mpm/step.hpp"

namespace recon::mpm {
namespace {

// A cube between walls that swings.
Problem<3> cube(const Method& method, int cells) {
  Problem<3> problem;
  problem.grid = Grid<3>(Vector<3>::Zero(), Vector<3>::Ones(), 1.0 / cells);
  problem.materials = {NeoHookean{Lame::from(1e7, 0.3)}};
  problem.densities = {1000};
  problem.method = method;
  const double edge = problem.grid.h() / 2, speed = 5;
  for (int k = 0; k < 2 * cells; ++k)
    for (int j = 0; j < 2 * cells; ++j)
      for (int i = 0; i < 2 * cells; ++i) {
        const Vector<3> x = edge * (Vector<3>(i, j, k) + Vector<3>::Constant(0.5));
        problem.particles.add(x, Matrix<3>::Identity() * (edge / 2), 1000, 0);
        for (int d = 0; d < 3; ++d)
          problem.particles.v.back()[d] = speed * std::sin(std::numbers::pi * x[d]);
      }
  for (int axis = 0; axis < 3; ++axis)
    for (const double at : {0.0, 1.0}) {
      Boundary<3> wall;
      wall.axis = axis;
      wall.at = at;
      wall.velocity[static_cast<std::size_t>(axis)] = 0.0;
      problem.boundaries.push_back(wall);
    }
  return problem;
}

struct Difference {
  double largest = 0;  // as a part of the largest number of the array
  bool same_bits = true;
};

Difference difference(const Problem<3>& problem, const Particles<3>& a, const Particles<3>& b) {
  Difference found;
  const Kept kept = problem.kept();
  a.arrays(kept, [&]<class T>(const ParticleArray& array, const std::vector<T>& mine) {
    b.arrays(kept, [&]<class U>(const ParticleArray& other, const std::vector<U>& its) {
      if constexpr (std::is_same_v<T, U> && !std::is_same_v<T, std::int32_t>) {
        if (std::strcmp(array.name, other.name) != 0) return;
        const auto* const x = reinterpret_cast<const double*>(mine.data());
        const auto* const y = reinterpret_cast<const double*>(its.data());
        const std::size_t count = mine.size() * sizeof(T) / sizeof(double);
        found.same_bits = found.same_bits && std::memcmp(x, y, count * sizeof(double)) == 0;
        double most = 1e-12, off = 0;
        for (std::size_t i = 0; i < count; ++i) {
          most = std::max({most, std::abs(x[i]), std::abs(y[i])});
          off = x[i] - y[i] == x[i] - y[i] ? std::max(off, std::abs(x[i] - y[i])) : HUGE_VAL;
        }
        found.largest = std::max(found.largest, off / most);
      }
    });
  });
  return found;
}

State<3> on_gpu(const Problem<3>& problem, int steps) {
  State<3> s = start(problem);
  const auto step = make_on_gpu<3>(Plan<3>(problem));
  step->put(s);
  for (int k = 0; k < steps; ++k)
    if (step->step(step->choose_step().dt)) break;
  step->bring(s);
  return s;
}

double seconds() {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

int check_and_time(const std::string& gpu, const std::filesystem::path& folder, int cells,
                   int steps) {
  bool right = true;
  std::ostringstream text;
  const auto say = [&](const std::string& line) {
    text << line;
    std::fputs(line.c_str(), stdout);
    std::fflush(stdout);
  };
  const std::size_t edge = 2 * static_cast<std::size_t>(cells);
  say("# Steps of the material point method on " + gpu +
      "\n\nNanoseconds a particle and step, of " + std::to_string(edge * edge * edge) +
      " particles, 8 in a cell; before it, the largest difference from Step on the processor after "
      "20 "
      "steps of 8,000 particles, as a part of the largest number of its array.\n\n"
      "| method | ns | difference | the same bits again |\n| --- | --- | --- | --- |\n");
  for (const std::string& name : methods_on_gpu()) {
    const Problem<3> small = cube(method_named(name), 10);
    State<3> here = start(small);
    Step<3> step(small);
    for (int k = 0; k < 20; ++k) step(here, choose_step(small, here.particles).dt);
    const State<3> there = on_gpu(small, 20), again = on_gpu(small, 20);
    const Difference off = difference(small, here.particles, there.particles);
    const bool same = difference(small, there.particles, again.particles).same_bits;
    const bool good = off.largest <= 1e-12 && same && there.steps == here.steps;
    right = right && good;
    const Problem<3> large = cube(method_named(name), cells);
    State<3> s = start(large);
    const auto timed = make_on_gpu<3>(Plan<3>(large));
    timed->put(s);
    double began = 0;
    for (int k = 0; k < steps; ++k) {
      if (k == steps / 2) began = seconds();
      if (timed->step(timed->choose_step().dt)) {
        right = false;
        break;
      }
    }
    const double each = (seconds() - began) / (steps - steps / 2);
    char line[160];
    std::snprintf(line, sizeof line, "| %s | %.3f | %.1e | %s |\n", name.c_str(),
                  each / static_cast<double>(s.particles.size()) * 1e9, off.largest,
                  !good  ? "WRONG"
                  : same ? "yes"
                         : "NO");
    say(line);
  }
  say(right ? "\nAll were right.\n" : "\nSOME WERE WRONG.\n");
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "steps.md") << text.str();
  return right ? 0 : 1;
}

}  // namespace
}  // namespace recon::mpm

int main(int argc, char** argv) {
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) {
    std::puts("no GPU: the step was built, and not run");
    return 77;
  }
  try {
    return recon::mpm::check_and_time(
        recon_gpu::this_machine().name, argc > 1 ? argv[1] : "out/gpu",
        argc > 2 ? std::atoi(argv[2]) : 64, argc > 3 ? std::atoi(argv[3]) : 60);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "recon-gpu-mpm: %s\n", error.what());
    return 1;
  }
}
