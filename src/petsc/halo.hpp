// The particles of other ranks that a rank's targets need, and the messages for their data.
#pragma once

#include <petscsf.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "petsc/call.hpp"
#include "recon/points/domain.hpp"
#include "recon/points/view.hpp"

namespace recon::petsc {

// The box of a rank's targets, enlarged: what it needs of the others.
struct Need {
  std::array<double, max_dimension> lower{}, upper{};
  double any = 0;  // 0: it has no targets
};

// The particles that a rank works with stand in the order of their global ids: those of lower ranks,
// its own, those of higher ranks.
class Halo {
 public:
  // Each rank gets the particles of all others of which an image lies in its Need. Collective.
  Halo(const Communicator& ranks, const PointsView<double>& own, const Need& need,
       const PeriodicDomain<double>& domain);

  const Communicator& ranks() const { return ranks_; }
  std::size_t own() const { return own_; }
  std::size_t all() const { return ids_.size(); }
  std::size_t before() const { return before_; }
  std::int64_t total() const { return total_; }  // particles of all ranks
  std::span<const std::int64_t> ids() const { return ids_; }
  int rounds = 1;

  // Data of the own particles, `width` numbers each, to all places; and sums back.
  std::vector<double> spread(std::span<const double> own, int width) const;
  std::vector<double> gather(std::span<const double> all, int width) const;

 private:
  Communicator ranks_;
  std::size_t own_ = 0, before_ = 0;
  std::int64_t total_ = 0;
  std::vector<std::int64_t> ids_;
  Owned<PetscSF, PetscSFDestroy> messages_;
};

}  // namespace recon::petsc
