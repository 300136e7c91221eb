// Sources: particles in the memory of a GPU, copied and ordered in space there.
//
// ```cpp
//   recon::cuda::Sources<3> sources({x_p, particle_count}, {.domain = box}, stream);
//   recon::cuda::Reconstruction<3> fit(sources, {x_t, target_count}, {.degree = 2});
//   fit.apply({u_p, particle_count}, {u_t, target_count});
// ```
//
// They are what recon::Sources are (neighbourhood/sources.hpp): the same order of cells, a copy of
// the positions, the caller's numbers in all that is asked and answered. Supports may be stretched,
// and the domain periodic; particles have no weights of their own.
//
// All work goes to the stream that is given, in the order of the calls, and nobody waits for it:
// the positions must stay as they are until the stream has come past the call. Memory is taken from
// the stream's pool (cudaMallocAsync) by the constructor, and by an update only for more particles
// than there ever were. The stream must live as long as the Sources and all that is made of them.
//
// Coordinates that are not finite are found on the GPU. Asking for them would mean to wait, so it
// is done by check() alone: it waits, and throws what recon::Sources throw. Without it targets near
// such particles miss them, and nothing else happens.
//
// Memory: 16 D + 20 bytes for each particle (double), and up to 16 for the cells. Sources are for
// particles of one density, up to a factor of a hundred or so: there are cells, and no trees.
//
// One object is not for several threads at once.
#pragma once

#include <cstdint>
#include <memory>

#include "recon/cuda/view.hpp"
#include "recon/neighbourhood/sources.hpp"

namespace recon::cuda {

class Device;
template <class Executor, int D, class T>
class SourcesOn;

// D = 1, 2, 3; T = double or float.
template <int D, class T = double>
class Sources {
 public:
  // Throws InvalidArgument for options outside their range and for particle_weights, and Error
  // where there is no GPU or no memory.
  explicit Sources(const Points<D, T>& points, const SourcesOptions& options = {},
                   Stream stream = nullptr);

  // The particles are where `points` says; there may be more or fewer. What was made of the
  // positions before is stale: a Reconstruction refuses to be used until its own update().
  void update(const Points<D, T>& points);

  // Waits, and throws InvalidArgument for a coordinate that is not finite, naming the particle and
  // the axis, and for coordinates whose squares overflow; Error where the work itself failed.
  void check() const;

  std::size_t size() const;
  // On the GPU, valid until the next update: the caller's number of the particle at each place.
  const std::uint32_t* order() const;

  // What the compiled parts of recon read.
  const std::shared_ptr<SourcesOn<Device, D, T>>& on_device() const { return on_device_; }

 private:
  std::shared_ptr<SourcesOn<Device, D, T>> on_device_;
};

}  // namespace recon::cuda
