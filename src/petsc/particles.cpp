#include "recon/petsc/particles.hpp"

#include <petscdmswarm.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "petsc/call.hpp"

namespace recon::petsc {
namespace {

using detail::require;

// Sums of these tell sets of ids apart, but for one chance in 2^64.
std::uint64_t mixed(std::int64_t id) {
  auto z = static_cast<std::uint64_t>(id) + 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

std::vector<double> numbers_of(const std::vector<ParticleArray>& arrays) {
  std::vector<double> numbers{static_cast<double>(arrays.size())};
  for (const ParticleArray& array : arrays) {
    numbers.push_back(array.components);
    for (const char letter : array.name) numbers.push_back(letter);
  }
  return numbers;
}

}  // namespace

struct Particles::Data {
  DistributedGrid grid;
  PeriodicDomain<double> domain;
  std::vector<ParticleArray> arrays;
  Outside outside;
  Owned<DM, DMDestroy> dm;
  std::array<std::int64_t, 2>
      census{};  // the number of particles of all ranks, the sum of mixed ids
  std::int64_t next_id = 0;

  Data(const DistributedGrid& grid_, const std::vector<ParticleArray>& arrays_, Outside outside_)
      : grid(grid_), domain(grid_.domain()), arrays(arrays_), outside(outside_) {}

  const Communicator& ranks() const { return grid.communicator(); }
  int dimension() const { return grid.all().dimension; }

  std::size_t size() const {
    PetscInt count = 0;
    RECON_PETSC(DMSwarmGetLocalSize(dm, &count));
    return static_cast<std::size_t>(count);
  }

  // An array as it lies at present.
  template <class Number>
  Number* array(const char* name) const {
    void* data = nullptr;
    RECON_PETSC(DMSwarmGetField(dm, name, nullptr, nullptr, &data));
    void* found = data;
    RECON_PETSC(DMSwarmRestoreField(dm, name, nullptr, nullptr, &data));
    return static_cast<Number*>(found);
  }

  const ParticleArray& named(const std::string& name) const {
    std::string names;
    for (const ParticleArray& one : arrays) {
      if (one.name == name) return one;
      names += (names.empty() ? "" : ", ") + one.name;
    }
    detail::throw_invalid("array of the particles", name,
                          "must be one of those that they have: " + names);
  }

  // Is a point in the box, as far as that matters? Counts it where it is not, and may stay.
  template <class Name>
  void judge(const std::array<double, max_dimension>& x, const Name& name,
             std::int64_t& beyond) const {
    bool out = false;
    for (int d = 0; d < dimension(); ++d) {
      if (!std::isfinite(x[d])) detail::throw_invalid(name(d), x[d], "must be finite");
      if (domain.periodic[d]) continue;
      const StructuredGrid<double>& all = grid.all();
      const double last = all.coordinate(all.counts[d] - 1, d);
      if (x[d] >= all.origin[d] && x[d] <= last) continue;
      out = true;
      if (outside == Outside::stop)
        detail::throw_invalid(name(d), x[d],
                              "must be within the box of the grid, " +
                                  detail::to_text(all.origin[d]) + " to " + detail::to_text(last));
    }
    beyond += out;
  }

  std::array<std::int64_t, 2> counted() const {
    const std::size_t count = size();
    const auto* ids = array<std::int64_t>("id");
    std::uint64_t sum = 0;
    for (std::size_t p = 0; p < count; ++p) sum += mixed(ids[p]);
    std::array<std::uint64_t, 2> mine{count, sum}, all{};
    RECON_MPI(MPI_Allreduce(mine.data(), all.data(), 2, MPI_UINT64_T, MPI_SUM, ranks().get()));
    return {static_cast<std::int64_t>(all[0]), static_cast<std::int64_t>(all[1])};
  }

  Migration migrate();
};

Migration Particles::Data::migrate() {
  Migration done;
  std::int64_t leaving = 0, beyond = 0;
  std::size_t count = 0;
  double* x = nullptr;
  std::vector<int> rank_of;
  ranks().together([&] {
    count = size();
    x = array<double>("x");
    const auto* ids = array<std::int64_t>("id");
    rank_of.resize(count);
    const auto axes = static_cast<std::size_t>(dimension());
    std::vector<double> wrapped(x, x + count * axes);
    for (std::size_t p = 0; p < count; ++p) {
      std::array<double, max_dimension> at{};
      std::copy_n(x + p * axes, axes, at.begin());
      const auto name = [&](int d) {
        return "coordinate " + std::string(1, "xyz"[d]) + " of the particle with the id " +
               std::to_string(ids[p]);
      };
      judge(at, name, beyond);
      for (int d = 0; d < dimension(); ++d) wrapped[p * axes + d] = at[d] = domain.wrap(at[d], d);
      rank_of[p] = grid.rank_of(at);
      leaving += rank_of[p] != ranks().rank();
    }
    std::copy(wrapped.begin(), wrapped.end(), x);
  });
  std::array<long long, 2> mine{leaving, beyond}, all{};
  RECON_MPI(MPI_Allreduce(mine.data(), all.data(), 2, MPI_LONG_LONG, MPI_SUM, ranks().get()));
  done.moved = all[0];
  done.outside = all[1];
  done.sent = leaving;
  if (done.moved == 0) return done;

  std::copy(rank_of.begin(), rank_of.end(), array<PetscInt>(DMSwarmField_rank));
  RECON_PETSC(DMSwarmMigrate(dm, PETSC_TRUE));
  done.received = static_cast<std::int64_t>(size() + static_cast<std::size_t>(leaving) - count);
  const std::array<std::int64_t, 2> now = counted();
  if (now != census)
    throw Error("DMSwarmMigrate", 0,
                "particles were lost or duplicated: there were " + std::to_string(census[0]) +
                    ", there are " + std::to_string(now[0]) +
                    (now[0] == census[0] ? " with other ids" : ""));
  return done;
}

Particles::Particles(const DistributedGrid& grid, const std::vector<ParticleArray>& arrays,
                     Outside outside)
    : data_(std::make_shared<Data>(grid, arrays, outside)) {
  const auto check = [&] {
    std::set<std::string> names{"x", "id"};
    require(outside == Outside::stop || outside == Outside::keep, "outside",
            static_cast<int>(outside), "must be stop or keep");
    for (const ParticleArray& array : arrays) {
      require(!array.name.empty() && array.name.rfind("DMSwarm", 0) != 0,
              "name of an array of the particles", array.name,
              "must not be empty or begin as PETSc's own names do");
      require(names.insert(array.name).second, "name of an array of the particles", array.name,
              "must not be said twice, and not be x or id");
      require(array.components >= 1, "components of an array of the particles", array.components,
              "must be at least 1");
    }
  };
  double print = static_cast<double>(outside);
  for (const double number : numbers_of(arrays)) print = std::fmod(print * 131 + number, 1e15 + 37);
  grid.communicator().together(check, "arrays of the particles", {print});

  Owned<DM, DMDestroy>& dm = data_->dm;
  RECON_PETSC(DMCreate(grid.communicator().get(), dm.out()));
  RECON_PETSC(DMSetType(dm, DMSWARM));
  RECON_PETSC(DMSetDimension(dm, data_->dimension()));
  RECON_PETSC(DMSwarmSetType(dm, DMSWARM_BASIC));
  RECON_PETSC(DMSwarmInitializeFieldRegister(dm));
  RECON_PETSC(DMSwarmRegisterPetscDatatypeField(dm, "x", data_->dimension(), PETSC_DOUBLE));
  RECON_PETSC(DMSwarmRegisterPetscDatatypeField(dm, "id", 1, PETSC_INT64));
  for (const ParticleArray& array : arrays)
    RECON_PETSC(
        DMSwarmRegisterPetscDatatypeField(dm, array.name.c_str(), array.components, PETSC_DOUBLE));
  RECON_PETSC(DMSwarmFinalizeFieldRegister(dm));
  RECON_PETSC(DMSwarmSetLocalSizes(dm, 0, 16));
}

Migration Particles::add(const PointsView<double>& points,
                         const std::vector<FieldView<double>>& values) {
  Data& data = *data_;
  const int dimension = data.dimension();
  data.ranks().together([&] {
    require(points.dimension() == dimension, "dimension of the points", points.dimension(),
            "must be that of the grid");
    require(values.size() == data.arrays.size(), "fields of new particles", values.size(),
            "must be one for each array");
    for (std::size_t a = 0; a < values.size(); ++a) {
      const std::string name = "of the array " + data.arrays[a].name;
      if (values[a].size() != points.size())
        detail::throw_invalid("values " + name, values[a].size(), "must be one for each point");
      if (values[a].components() != data.arrays[a].components)
        detail::throw_invalid("components " + name, values[a].components(),
                              "must be those that the array was made with");
    }
    std::int64_t beyond = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      std::array<double, max_dimension> x{};
      for (int d = 0; d < dimension; ++d) x[d] = points(p, d);
      data.judge(
          x, [&](int d) { return detail::coordinate_name(p, d, "new particles"); }, beyond);
    }
    to_petsc_int(data.size() + points.size(), "particles of a rank");
  });

  const std::size_t before = data.size();
  const auto count = static_cast<long long>(points.size());
  long long first = 0;
  RECON_MPI(MPI_Exscan(&count, &first, 1, MPI_LONG_LONG, MPI_SUM, data.ranks().get()));
  if (data.ranks().rank() == 0) first = 0;
  RECON_PETSC(DMSwarmAddNPoints(data.dm, static_cast<PetscInt>(count)));
  double* x = data.array<double>("x");
  auto* ids = data.array<std::int64_t>("id");
  for (std::size_t p = 0; p < points.size(); ++p) {
    for (int d = 0; d < dimension; ++d)
      x[(before + p) * static_cast<std::size_t>(dimension) + d] = points(p, d);
    ids[before + p] = data.next_id + first + static_cast<std::int64_t>(p);
  }
  for (std::size_t a = 0; a < values.size(); ++a) {
    const int components = data.arrays[a].components;
    double* to = data.array<double>(data.arrays[a].name.c_str()) +
                 before * static_cast<std::size_t>(components);
    for (std::size_t p = 0; p < points.size(); ++p)
      for (int c = 0; c < components; ++c) *to++ = values[a](p, c);
  }
  data.next_id += data.ranks().sum(count);
  data.census = data.counted();
  return data.migrate();
}

Migration Particles::migrate() {
  return data_->migrate();
}
const DistributedGrid& Particles::grid() const {
  return data_->grid;
}
std::size_t Particles::size() const {
  return data_->size();
}
std::int64_t Particles::total() const {
  return data_->census[0];
}

std::span<double> Particles::x() {
  return {data_->array<double>("x"), size() * static_cast<std::size_t>(data_->dimension())};
}
PointsView<double> Particles::points() const {
  const auto stride = static_cast<std::ptrdiff_t>(sizeof(double)) * data_->dimension();
  const double* x = data_->array<double>("x");
  std::array<const void*, max_dimension> first{};
  for (int d = 0; d < data_->dimension() && size() > 0; ++d) first[d] = x + d;
  return {size(), data_->dimension(), first, {stride, stride, stride}};
}
std::span<const std::int64_t> Particles::ids() const {
  return {data_->array<std::int64_t>("id"), size()};
}
std::span<double> Particles::array(const std::string& name) {
  const int components = data_->named(name).components;
  return {data_->array<double>(name.c_str()), size() * static_cast<std::size_t>(components)};
}
FieldView<double> Particles::field(const std::string& name) const {
  const int components = data_->named(name).components;
  return {size(), components, data_->array<double>(name.c_str()),
          static_cast<std::ptrdiff_t>(sizeof(double)) * components, sizeof(double)};
}
DM Particles::dm() const {
  return data_->dm;
}

}  // namespace recon::petsc
