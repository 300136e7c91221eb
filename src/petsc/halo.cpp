#include "petsc/halo.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace recon::petsc {
namespace {

// A type of MPI that is so many doubles.
class Doubles {
 public:
  explicit Doubles(int count) {
    RECON_MPI(MPI_Type_contiguous(count, MPI_DOUBLE, &type_));
    RECON_MPI(MPI_Type_commit(&type_));
  }
  ~Doubles() { MPI_Type_free(&type_); }
  Doubles(const Doubles&) = delete;
  Doubles& operator=(const Doubles&) = delete;
  operator MPI_Datatype() const { return type_; }

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

bool needs(const Need& need, const PointsView<double>& points, std::size_t p,
           const PeriodicDomain<double>& domain) {
  for (int d = 0; d < points.dimension(); ++d) {
    const double x = points(p, d);
    if (!domain.periodic[d]) {
      if (x < need.lower[d] || x > need.upper[d]) return false;
      continue;
    }
    const double period = domain.period(d), width = need.upper[d] - need.lower[d];
    if (width >= period) continue;
    const double above = x - need.lower[d];
    if (above - std::floor(above / period) * period > width) return false;
  }
  return true;
}

}  // namespace

Halo::Halo(const Communicator& ranks, const PointsView<double>& own, const Need& need,
           const PeriodicDomain<double>& domain)
    : ranks_(ranks), own_(own.size()) {
  const auto size = static_cast<std::size_t>(ranks.size());
  const int rank = ranks.rank();
  const MPI_Comm comm = ranks.get();
  constexpr int numbers = sizeof(Need) / sizeof(double);
  std::vector<Need> of_rank(size);
  std::vector<long long> counts(size);
  const auto count = static_cast<long long>(own_);
  RECON_MPI(MPI_Allgather(&need, numbers, MPI_DOUBLE, of_rank.data(), numbers, MPI_DOUBLE, comm));
  RECON_MPI(MPI_Allgather(&count, 1, MPI_LONG_LONG, counts.data(), 1, MPI_LONG_LONG, comm));
  std::vector<std::int64_t> first_id(size + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), first_id.begin() + 1);
  total_ = first_id.back();

  std::vector<int> given, to_each(size, 0), from_each(size, 0);
  ranks.together([&] {
    to_petsc_int(own_, "particles of a rank");
    for (std::size_t r = 0; r < size; ++r) {
      if (static_cast<int>(r) == rank || of_rank[r].any == 0) continue;
      const std::size_t before = given.size();
      for (std::size_t p = 0; p < own_; ++p)
        if (needs(of_rank[r], own, p, domain)) given.push_back(static_cast<int>(p));
      to_each[r] = static_cast<int>(given.size() - before);
    }
    to_petsc_int(given.size(), "particles that a rank gives to others");
  });
  RECON_MPI(MPI_Alltoall(to_each.data(), 1, MPI_INT, from_each.data(), 1, MPI_INT, comm));
  std::vector<int> to_first(size, 0), from_first(size, 0);
  for (std::size_t r = 1; r < size; ++r) {
    to_first[r] = to_first[r - 1] + to_each[r - 1];
    from_first[r] = from_first[r - 1] + from_each[r - 1];
  }
  std::int64_t got_count = 0;
  for (const int n : from_each) got_count += n;
  ranks.together([&] {
    to_petsc_int(static_cast<std::size_t>(got_count) + own_, "particles that a rank works with");
  });
  std::vector<int> got(static_cast<std::size_t>(got_count));
  RECON_MPI(MPI_Alltoallv(given.data(), to_each.data(), to_first.data(), MPI_INT, got.data(),
                          from_each.data(), from_first.data(), MPI_INT, comm));

  std::vector<PetscInt> places;
  std::vector<PetscSFNode> owners;
  before_ = static_cast<std::size_t>(from_first[static_cast<std::size_t>(rank)]);
  for (std::size_t r = 0; r < size; ++r) {
    if (static_cast<int>(r) == rank)
      for (std::size_t p = 0; p < own_; ++p)
        ids_.push_back(first_id[r] + static_cast<std::int64_t>(p));
    for (int i = 0; i < from_each[r]; ++i) {
      const int p = got[static_cast<std::size_t>(from_first[r] + i)];
      places.push_back(static_cast<PetscInt>(ids_.size()));
      owners.push_back({static_cast<PetscInt>(r), static_cast<PetscInt>(p)});
      ids_.push_back(first_id[r] + p);
    }
  }
  RECON_PETSC(PetscSFCreate(comm, messages_.out()));
  RECON_PETSC(PetscSFSetGraph(messages_, static_cast<PetscInt>(own_),
                              static_cast<PetscInt>(places.size()), places.data(),
                              PETSC_COPY_VALUES, owners.data(), PETSC_COPY_VALUES));
  RECON_PETSC(PetscSFSetUp(messages_));
}

std::vector<double> Halo::spread(std::span<const double> own, int width) const {
  std::vector<double> all(ids_.size() * static_cast<std::size_t>(width));
  std::copy(own.begin(), own.end(),
            all.begin() + static_cast<std::ptrdiff_t>(before_ * static_cast<std::size_t>(width)));
  const Doubles type(width);
  RECON_PETSC(PetscSFBcastBegin(messages_, type, own.data(), all.data(), MPI_REPLACE));
  RECON_PETSC(PetscSFBcastEnd(messages_, type, own.data(), all.data(), MPI_REPLACE));
  return all;
}

std::vector<double> Halo::gather(std::span<const double> all, int width) const {
  const auto numbers = static_cast<std::size_t>(width);
  const auto mine = all.subspan(before_ * numbers, own_ * numbers);
  std::vector<double> own(mine.begin(), mine.end());
  const Doubles type(width);
  RECON_PETSC(PetscSFReduceBegin(messages_, type, all.data(), own.data(), MPI_SUM));
  RECON_PETSC(PetscSFReduceEnd(messages_, type, all.data(), own.data(), MPI_SUM));
  return own;
}

}  // namespace recon::petsc
