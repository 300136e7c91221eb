#include "recon/runs/checkpoint.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cmath>
#include <system_error>

#include "core/entries.hpp"
#include "recon/io/atomic_file.hpp"
#include "runs/identity.hpp"
#include "runs/sealed_file.hpp"

namespace recon::mpm {
namespace {

// How a number stands in the file, and in memory.
template <class T>
struct Kind {
  static constexpr hsize_t columns = sizeof(T) / sizeof(double);
  static hid_t file() { return H5T_IEEE_F64LE; }
  static hid_t memory() { return H5T_NATIVE_DOUBLE; }
};
template <>
struct Kind<std::int32_t> {
  static constexpr hsize_t columns = 1;
  static hid_t file() { return H5T_STD_I32LE; }
  static hid_t memory() { return H5T_NATIVE_INT32; }
};
template <>
struct Kind<char> {
  static constexpr hsize_t columns = 1;
  static hid_t file() { return H5T_STD_U8LE; }
  static hid_t memory() { return H5T_NATIVE_UINT8; }
};

struct Writer {
  const std::filesystem::path& path;
  hid_t file;

  void check(bool good) const {
    if (!good) throw FileError(path, 0, "could not be written");
  }
  template <class T>
  void put(const char* name, const T* data, std::size_t rows) const {
    const hsize_t size[2] = {rows, Kind<T>::columns};
    const Handle space(H5Screate_simple(2, size, nullptr), H5Sclose);
    const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_obj_track_times(creation, false);  // the same bytes for the same state
    const Handle set(
        H5Dcreate2(file, name, Kind<T>::file(), space, H5P_DEFAULT, creation, H5P_DEFAULT),
        H5Dclose);
    check(set >= 0 && (rows == 0 ||
                       H5Dwrite(set, Kind<T>::memory(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0));
  }
  template <class T>
  void operator()(const char* name, const std::vector<T>& values) const {
    put(name, values.data(), values.size());
  }
  void attribute(const char* name, double value) const {
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle at(H5Acreate2(file, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT),
                    H5Aclose);
    check(at >= 0 && H5Awrite(at, H5T_NATIVE_DOUBLE, &value) >= 0);
  }
};

// Everything is of the type and size that Writer gave it, or refused before memory is taken for it.
struct Reader {
  const std::filesystem::path& path;
  hid_t file;
  std::uint64_t file_size;

  void check(bool good, const std::string& what) const {
    if (!good) throw FileError(path, 0, what);
  }
  // rows: as many as there must be, or at most with `fewer`.
  template <class Values>
  void read(const char* name, Values& values, std::size_t rows, bool fewer = false) const {
    using T = typename Values::value_type;
    const std::string text(name);
    H5L_info_t link{};
    check(H5Lget_info(file, name, &link, H5P_DEFAULT) >= 0 && link.type == H5L_TYPE_HARD,
          "has no data set '" + text + "'");
    const Handle set(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
    check(set >= 0, "'" + text + "' is no data set");
    const Handle type(H5Dget_type(set), H5Tclose), space(H5Dget_space(set), H5Sclose),
        creation(H5Dget_create_plist(set), H5Pclose);
    check(type >= 0 && space >= 0 && creation >= 0 && H5Tequal(type, Kind<T>::file()) > 0 &&
              H5Pget_layout(creation) == H5D_CONTIGUOUS && H5Pget_external_count(creation) == 0 &&
              H5Sget_simple_extent_type(space) == H5S_SIMPLE,
          "'" + text + "' is of a type that no checkpoint has");
    hsize_t size[2] = {0, 0};
    check(H5Sget_simple_extent_ndims(space) == 2 &&
              H5Sget_simple_extent_dims(space, size, nullptr) == 2,
          "'" + text + "' is no table");
    check((fewer ? size[0] <= rows : size[0] == rows) && size[1] == Kind<T>::columns &&
              (size[0] == 0 ||
               (size[0] <= file_size && H5Dget_storage_size(set) == size[0] * sizeof(T))),
          "'" + text + "' is " + std::to_string(size[0]) + " x " + std::to_string(size[1]) +
              ", not " + (fewer ? "at most " : "") + std::to_string(rows) + " x " +
              std::to_string(Kind<T>::columns));
    values.resize(size[0]);
    check(size[0] == 0 ||
              H5Dread(set, Kind<T>::memory(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
          "'" + text + "' could not be read");
  }
  // `known`: a number that is not known (NaN) is none.
  double number(const char* name, bool known = true) const {
    const std::string text(name);
    const Handle at(H5Aopen(file, name, H5P_DEFAULT), H5Aclose);
    check(at >= 0, "has no attribute '" + text + "'");
    const Handle type(H5Aget_type(at), H5Tclose), space(H5Aget_space(at), H5Sclose);
    check(type >= 0 && space >= 0 && H5Tequal(type, H5T_IEEE_F64LE) > 0 &&
              H5Sget_simple_extent_type(space) == H5S_SCALAR,
          "the attribute '" + text + "' is no number");
    double value = 0;
    check(H5Aread(at, H5T_NATIVE_DOUBLE, &value) >= 0 &&
              (std::isfinite(value) || (!known && std::isnan(value))),
          "the attribute '" + text + "' is no finite number");
    return value;
  }
};

constexpr std::size_t most_frames = 1000001;

// What the particles of a run are, and those of this problem.
template <int D>
void check_particles(const Reader& read, const Particles<D>& found, const Problem<D>& problem,
                     const Particles<D>& now) {
  const auto bad = [&](std::size_t p, const std::string& what) {
    throw FileError(read.path, 0, "particle " + std::to_string(p) + ": " + what);
  };
  found.arrays(problem.kept(), [&](const ParticleArray& array, const auto& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!recon::detail::entries_finite(values[i]))
        bad(i / array.per_particle, std::string(array.name) + " is not finite");
  });
  // The particles of the problem are made anew in each run, perhaps with other roundings.
  constexpr double same = 1e-9;
  const double length = same * problem.grid.h();
  for (std::size_t p = 0; p < found.size(); ++p) {
    if (found.body[p] != now.body[p])
      bad(p, "is of body " + std::to_string(std::int64_t{found.body[p]} + 1) +
                 " in the checkpoint, of body " + std::to_string(std::int64_t{now.body[p]} + 1) +
                 " now");
    if (!((found.X[p] - now.X[p]).norm() <= length) ||
        !((found.half_edges[p] - now.half_edges[p]).norm() <= length))
      bad(p, "its place at the start or its size is another one than in the checkpoint");
    if (!(std::abs(found.mass[p] - now.mass[p]) <= same * now.mass[p]) ||
        !(std::abs(found.volume0[p] - now.volume0[p]) <= same * now.volume0[p]))
      bad(p, "its mass or volume at the start is another one than in the checkpoint");
    if (!problem.grid.contains(found.x[p])) bad(p, "it is outside of the grid");
    const double J = found.F[p].determinant();
    if (!(J > 0) || !std::isfinite(J)) bad(p, "det F is not positive");
  }
}

}  // namespace

template <int D>
void write_checkpoint(const std::filesystem::path& path, const Simulation<D>& simulation,
                      const Formulas& formulas, const RunState& state) {
  write_checkpoint(path, simulation.problem(), simulation.state(), formulas, state);
}

template <int D>
void write_checkpoint(const std::filesystem::path& path, const Problem<D>& problem,
                      const State<D>& of, const Formulas& formulas, const RunState& state) {
  const QuietHdf5 quiet;
  AtomicFile atomic(path);
  int error = 0;
  {
    const Handle file(create_hdf5(atomic.descriptor(), error), H5Fclose);
    const Writer write{path, file};
    write.check(file >= 0);
    const std::string identity = to_text(identity_of(problem, of.particles, formulas));
    write.put("problem", identity.data(), identity.size());
    of.particles.arrays(problem.kept(), [&](const ParticleArray& array, const auto& values) {
      if (array.per_particle > 0) write(array.name, values);
    });
    write("frame_times", state.frame_times);
    write.attribute("time", of.time);
    write.attribute("steps", static_cast<double>(of.steps));
    write.attribute("last_dt", of.last_dt);
    write.attribute("start_kinetic", state.start.kinetic);
    write.attribute("start_node_kinetic", state.start.node_kinetic);
    write.attribute("start_strain", state.start.strain);
    write.attribute("work", state.work);
  }
  if (error == 0) error = write_seal(atomic.descriptor());
  if (error != 0)
    throw FileError(path, 0, "cannot write: " + std::generic_category().message(error));
  atomic.commit();
}

template <int D>
RunState read_checkpoint(const std::filesystem::path& path, Simulation<D>& simulation,
                         const Formulas& formulas) {
  const QuietHdf5 quiet;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) throw FileError(path, 0, "no such file");
  if (!std::filesystem::is_regular_file(path, ignored)) throw FileError(path, 0, "is no file");
  struct Descriptor {
    int number;
    ~Descriptor() {
      if (number >= 0) close(number);
    }
  } const opened{open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (opened.number < 0)
    throw FileError(path, 0, "cannot read: " + std::generic_category().message(errno));
  check_seal(path, opened.number);

  const Handle file(open_hdf5(opened.number), H5Fclose);
  const Reader read{path, file, std::filesystem::file_size(path)};
  read.check(file >= 0, "what the seal holds is not HDF5");
  const Problem<D>& problem = simulation.problem();
  std::string identity;
  read.read("problem", identity, read.file_size, true);
  const std::string differs =
      difference(identity_from(identity), identity_of(problem, simulation.particles(), formulas));
  if (!differs.empty()) throw FileError(path, 0, "is a checkpoint of another problem: " + differs);

  Particles<D> particles;
  const std::size_t count = simulation.particles().size();
  particles.arrays(problem.kept(), [&](const ParticleArray& array, auto& values) {
    if (array.per_particle > 0) read.read(array.name, values, count * array.per_particle);
  });
  check_particles(read, particles, problem, simulation.particles());

  RunState state;
  read.read("frame_times", state.frame_times, most_frames, true);
  const double time = read.number("time"), steps = read.number("steps"),
               last_dt = read.number("last_dt");
  read.check(time >= 0 && last_dt >= 0, "has a time or step below zero");
  read.check(steps >= 0 && steps < 0x1p53 && steps == std::floor(steps),
             "has a number of steps that is none");
  double before = -1;
  for (const double each : state.frame_times) {
    read.check(std::isfinite(each) && each > before && each <= time,
               "has frames at times out of order");
    before = each;
  }
  state.start.kinetic = read.number("start_kinetic");
  state.start.node_kinetic = read.number("start_node_kinetic");
  state.start.strain = read.number("start_strain");
  state.work = read.number("work", false);
  simulation.restore(std::move(particles), time, static_cast<std::int64_t>(steps), last_dt);
  return state;
}

#define RECON_INSTANTIATE(D)                                                                       \
  template void write_checkpoint(const std::filesystem::path&, const Simulation<D>&,               \
                                 const Formulas&, const RunState&);                                \
  template void write_checkpoint(const std::filesystem::path&, const Problem<D>&, const State<D>&, \
                                 const Formulas&, const RunState&);                                \
  template RunState read_checkpoint(const std::filesystem::path&, Simulation<D>&, const Formulas&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
