// A simulation of a problem file in as many dimensions as the file says.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace recon::bindings {

// Where an array of the particles lies: entry (p, i, j, ...) at data + p * strides[0] + i *
// strides[1] + ... bytes. Numbers are double, or 32-bit integers.
struct ParticleArrayView {
  const void* data = nullptr;
  bool integers = false;
  std::vector<std::size_t> shape;
  std::vector<std::ptrdiff_t> strides;
};

class AnySimulation {
 public:
  // Throws FileError for what is wrong with the file, InvalidArgument for a problem that cannot be
  // run.
  AnySimulation(const std::filesystem::path& path, std::span<const std::string> settings);
  ~AnySimulation();

  int dimension() const;
  std::size_t size() const;  // particles
  double time() const;
  long long steps() const;
  double end() const;  // of the problem; infinity where it has none
  const std::string& title() const;
  std::string method() const;
  double choose_step() const;
  // Throw as Simulation does.
  void step(double dt);
  void map();
  bool mapped() const;
  // Steps of the problem's rule until this time, to rounding. `go_on`, if there is one, is called
  // between the steps; what it throws ends the run there.
  void run_until(double time, const std::function<void()>& go_on = {});

  // What particles carry, as it lies in memory until the next step: x, X, v, F, L, stress,
  // half_edges, mass, volume0, energy, body, and what the method keeps. Throws InvalidArgument for
  // another name.
  ParticleArrayView particles(std::string_view name) const;
  std::vector<std::string> particle_arrays() const;

  // The nodes as map() or step() made them last: mass, velocity, force, in the order of the grid.
  ParticleArrayView nodes(std::string_view name) const;
  // origin, spacing and number of nodes along each axis.
  struct Grid {
    std::vector<double> origin, spacing;
    std::vector<std::size_t> counts;
  };
  Grid grid() const;

  // The account of the state that map() computed last, by name (ledger.hpp).
  std::vector<std::pair<std::string, double>> account() const;

  struct Base;

 private:
  std::unique_ptr<Base> own_;
};

}  // namespace recon::bindings
