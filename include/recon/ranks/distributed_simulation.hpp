// A simulation whose particles are spread over the ranks of an MPI program.
//
// ```cpp
//   const recon::petsc::Session session(argc, argv);
//   recon::mpm::DistributedSimulation<2> simulation(PETSC_COMM_WORLD, problem);
//   while (simulation.time() < end) simulation.step(simulation.choose_step().dt);
//   const recon::mpm::Particles<2> all = simulation.gather().particles;  // on rank 0
// ```
//
// Space is cut into one box for each rank so that all have as many particles as the others at the
// start (recursive bisection across the longest axis of what is cut). A particle belongs to the rank
// in whose box it lies, and goes to another one at the end of a step. Each rank makes steps with
// its own particles and copies of others as far as they reach (mpm/parts.hpp), on the nodes of the box
// around these (seen_by()), of which those are right that its own particles see.
//
// The motion is that of one rank to rounding; it is the same bits for any number of threads, and
// from any state that gather() has given for the same number of ranks.
//
// All functions but those that are said to be of one rank are collective (petsc/communicator.hpp).
// What a rank throws, all throw: Failure with the number that the particle has in the problem, and
// "rank 3: " in front of its reason; InvalidArgument; anything else as runtime_error. After a failed
// step nothing but restore() is of use.
//
// Every rank is given the whole problem, and lets go of the particles that are not its own. On one
// rank all is as in Simulation, to the bit.
// Refused, by InvalidArgument: what Problem::validate() and require_parts() refuse.
#pragma once

#include <memory>

#include "recon/petsc/communicator.hpp"
#include "recon/runs/frames.hpp"
#include "recon/runs/ledger.hpp"

namespace recon::mpm {

// What this rank has sent since its simulation began: messages to single ranks, their bytes, and
// the rounds in which all ranks took part. Of the last step: how many copies it had.
struct Traffic {
  std::int64_t messages = 0, bytes = 0, rounds = 0;
  std::size_t copies = 0;
  std::int64_t migrated = 0;  // particles that went to another rank
};

template <int D>
class DistributedSimulation {
 public:
  DistributedSimulation(const petsc::Communicator& ranks, Problem<D> problem);
  DistributedSimulation(MPI_Comm ranks, Problem<D> problem);
  ~DistributedSimulation();

  // Of one rank: its own particles and after them copies, if any (State::own()), and the numbers
  // that the own ones have in the problem, which ascend.
  const State<D>& part() const;
  const std::vector<std::uint32_t>& numbers() const;
  const Step<D>& stepper() const;
  Traffic traffic() const;
  // What measures see (runs/view.hpp): its functions are collective, and throw as together().
  View<D> view() const;
  const petsc::Communicator& ranks() const;
  const Problem<D>& problem() const { return stepper().problem(); }
  // The same on all ranks.
  double time() const { return part().time; }
  std::int64_t steps() const { return part().steps; }
  std::size_t particles() const;  // of all ranks
  // The first node of negative mass, and the first whose mass changed its sign.
  const MassSigns& signs() const;

  // The step that the rule of the problem gives, and the number of the particle that limits it.
  TimeStep choose_step() const;
  // As in Simulation: the nodes of this state, once for each state, and the step.
  void map();
  void step(double dt);

  // The ledger of the state that map() computed last, as account() has it, on all ranks.
  Ledger account(const std::optional<Ledger>& start = {}, const std::optional<Ledger>& before = {});

  // Writes the state that map() computed last as the frame after those at `times` (runs/frames.hpp), in
  // pieces: each rank the own particles, nodes and cells of its box, NAME_particles_0007_RANK.vtp
  // and so on, and the first one NAME_particles_0007.pvtp, NAME_nodes_0007.pvti,
  // NAME_cells_0007.pvti, which name them, and the lists NAME_particles.pvd. Fits are there where
  // material is: at nodes that particles see, and in cells that hold some; those of one process may be
  // a cell farther out. All ranks see the folder, and have the same times.
  void write_frame(const std::filesystem::path& folder, const std::string& name,
                   std::vector<double>& times, const FrameOptions& options = {});

  // The state of all particles, in the order of the problem, on rank 0; on all others one without
  // particles.
  State<D> gather() const;
  // Goes on from the state of all particles, which each rank is given.
  void restore(const State<D>& whole);

 private:
  class Exchange;
  std::unique_ptr<Exchange> exchange_;
};

extern template class DistributedSimulation<1>;
extern template class DistributedSimulation<2>;
extern template class DistributedSimulation<3>;

}  // namespace recon::mpm
