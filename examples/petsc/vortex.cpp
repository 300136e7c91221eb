// Particles that move between ranks, and their velocity at the nodes of a grid: a step counts its
// messages, and measures itself.
//
//   mpirun -n 4 example_vortex_on_ranks [nodes along an axis] [particles in a cell] [steps]
//
// A line for each run, from the first rank: the messages and bytes are those of the rank with the
// most, in the sum over ghosts of one step; the seconds are those of one step, of the slowest rank.
#include <petscsys.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>

#include "recon/petsc/particles.hpp"
#include "recon/petsc/reconstruct_on_grid.hpp"

int main(int argc, char** argv) {
  using namespace recon;
  const petsc::Session session(argc, argv);
  const auto argument = [&](int i, int otherwise) {
    return argc > i ? std::atoi(argv[i]) : otherwise;
  };
  const int nodes = argument(1, 33), per_cell = argument(2, 8), steps = argument(3, 10);
  const auto count = static_cast<std::size_t>(nodes);
  const double h = 1.0 / (nodes - 1);
  const petsc::DistributedGrid grid(
      PETSC_COMM_WORLD, {.dimension = 3, .spacing = {h, h, h}, .counts = {count, count, count}});
  const petsc::Communicator& ranks = grid.communicator();

  // Each rank fills its own box, as even as random numbers are.
  std::mt19937_64 random(static_cast<unsigned>(ranks.rank()));
  std::uniform_real_distribution<double> part(0, 1);
  std::vector<std::array<double, 3>> points(grid.owned().size() *
                                            static_cast<std::size_t>(per_cell));
  for (auto& x : points)
    for (int d = 0; d < 3; ++d) {
      const double lower = grid.owned().origin[d];
      const double upper = lower + static_cast<double>(grid.owned().counts[d]) * h;
      x[d] = std::min(1.0, lower + part(random) * (upper - lower));
    }
  const auto velocity_at = [](const double* x) {
    using std::numbers::pi;
    return std::array<double, 3>{std::sin(pi * x[0]) * std::cos(pi * x[1]),
                                 -std::cos(pi * x[0]) * std::sin(pi * x[1]), 0};
  };
  std::vector<std::array<double, 3>> velocity;
  for (const auto& x : points) velocity.push_back(velocity_at(x.data()));
  petsc::Particles particles(grid, {{"velocity", 3}});
  particles.add(points_of(points), {field_of(velocity)});

  double fitting = 0, moving = 0, worst = 0;
  std::int64_t moved = 0;
  for (int step = 0; step < steps; ++step) {
    const double begin = MPI_Wtime();
    const GridReconstruction fit =
        petsc::reconstruct_on_grid(particles.points(), {particles.field("velocity")}, grid);
    const double middle = MPI_Wtime();
    const auto x = particles.x(), v = particles.array("velocity");
    for (std::size_t p = 0; p < particles.size(); ++p) {
      for (std::size_t d = 0; d < 3; ++d)
        x[3 * p + d] = std::clamp(x[3 * p + d] + 0.3 * h * v[3 * p + d], 0.0, 1.0);
      const auto now = velocity_at(&x[3 * p]);
      std::copy(now.begin(), now.end(), &v[3 * p]);
    }
    moved += particles.migrate().moved;
    fitting += middle - begin;
    moving += MPI_Wtime() - middle;
    for (std::size_t i = 0; i < fit.size(); ++i)
      if (fit.report()[i].degree < 1) worst = 1;
  }
  const int per_node = 1 + 10 + 3 * 4;  // count, moments, right-hand sides: degree 1 in 3-D
  const petsc::Traffic traffic = grid.traffic(per_node);
  const double messages = ranks.largest(static_cast<double>(traffic.messages));
  const double bytes = ranks.largest(static_cast<double>(traffic.bytes));
  fitting = ranks.largest(fitting / steps);
  moving = ranks.largest(moving / steps);
  const bool reduced = ranks.largest(worst) > 0;
  if (ranks.rank() == 0)
    std::printf(
        "ranks %d  nodes %d^3  particles %lld  messages %.0f  bytes %.0f  moved/step %.1f  "
        "fit %.4f s  move %.4f s%s\n",
        ranks.size(), nodes, static_cast<long long>(particles.total()), messages, bytes,
        static_cast<double>(moved) / steps, fitting, moving, reduced ? "  (nodes reduced)" : "");
}
