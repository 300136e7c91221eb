#include "recon/mpm/checkpoint.hpp"

#include <hdf5.h>

#include "recon/io/atomic_file.hpp"

namespace recon::mpm {
namespace {

// An HDF5 handle that closes itself.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// While it lives the HDF5 library does not print.
class Silence {
 public:
  Silence() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Silence() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

// A text of up to 63 letters.
constexpr std::size_t text_size = 64;
hid_t text_type() {
  static const hid_t type = [] {
    const hid_t made = H5Tcopy(H5T_C_S1);
    H5Tset_size(made, text_size);
    return made;
  }();
  return type;
}

struct Writer {
  const std::filesystem::path& path;
  hid_t file;

  void check(bool good) const {
    if (!good) throw FileError(path, 0, "could not be written");
  }
  void put(const char* name, const void* data, hid_t type, hsize_t rows, hsize_t columns) const {
    const hsize_t size[2] = {rows, columns};
    const Handle space(H5Screate_simple(2, size, nullptr), H5Sclose);
    const Handle set(H5Dcreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                     H5Dclose);
    check(set >= 0 && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
  }
  template <class T>
  void operator()(const char* name, const std::vector<T>& values) const {
    if constexpr (std::is_same_v<T, std::int32_t>)
      put(name, values.data(), H5T_NATIVE_INT32, values.size(), 1);
    else
      put(name, values.data(), H5T_NATIVE_DOUBLE, values.size(), sizeof(T) / sizeof(double));
  }
  void attribute(const char* name, const void* value, hid_t type) const {
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle at(H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(at >= 0 && H5Awrite(at, type, value) >= 0);
  }
  void attribute(const char* name, double value) const {
    attribute(name, &value, H5T_NATIVE_DOUBLE);
  }
  void attribute(const char* name, const std::string& value) const {
    char text[text_size] = {};  // as many bytes are written, whatever the length
    value.copy(text, text_size - 1);
    attribute(name, text, text_type());
  }
};

struct Reader {
  const std::filesystem::path& path;
  hid_t file;
  std::size_t particles;

  void check(bool good, const std::string& what) const {
    if (!good) throw FileError(path, 0, what);
  }
  template <class T>
  void operator()(const char* name, std::vector<T>& values, bool of_particles = true) const {
    constexpr bool whole = std::is_same_v<T, std::int32_t>;
    const hsize_t columns = whole ? 1 : sizeof(T) / sizeof(double);
    const Handle set(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
    check(set >= 0, std::string("has no data set '") + name + "': no checkpoint of this problem");
    const Handle space(H5Dget_space(set), H5Sclose);
    hsize_t size[2] = {0, 0};
    check(H5Sget_simple_extent_ndims(space) == 2, std::string(name) + " is no table");
    H5Sget_simple_extent_dims(space, size, nullptr);
    check((size[0] == particles || !of_particles) && size[1] == columns,
          std::string(name) + " is " + std::to_string(size[0]) + " x " + std::to_string(size[1]) +
              ", the problem needs " + std::to_string(particles) + " x " + std::to_string(columns));
    values.resize(size[0]);
    check(H5Dread(set, whole ? H5T_NATIVE_INT32 : H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                  values.data()) >= 0,
          std::string(name) + " could not be read");
  }
  void attribute(const char* name, void* value, hid_t type) const {
    const Handle at(H5Aopen(file, name, H5P_DEFAULT), H5Aclose);
    check(at >= 0 && H5Aread(at, type, value) >= 0,
          std::string("has no attribute '") + name + "': no checkpoint of a run");
  }
  double number(const char* name) const {
    double value = 0;
    attribute(name, &value, H5T_NATIVE_DOUBLE);
    return value;
  }
  std::string text(const char* name) const {
    char value[text_size + 1] = {};
    attribute(name, value, text_type());
    return value;
  }
};

// Calls each(name, array) for all that a checkpoint holds.
template <class Each, class AnyParticles>
void for_all_arrays(const Each& each, AnyParticles& particles) {
  each("X", particles.X);
  each("x", particles.x);
  each("v", particles.v);
  each("F", particles.F);
  each("L", particles.L);
  each("stress", particles.stress);
  each("half_edges", particles.half_edges);
  each("mass", particles.mass);
  each("volume0", particles.volume0);
  each("energy", particles.energy);
  each("body", particles.body);
}

}  // namespace

template <int D>
void write_checkpoint(const std::filesystem::path& path, const Simulation<D>& simulation,
                      const RunState& state) {
  const Silence silence;
  AtomicFile atomic(path);
  {
    const Handle file(
        H5Fcreate(atomic.temporary().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
    const Writer write{path, file};
    write.check(file >= 0);
    const Particles<D>& particles = simulation.particles();
    for_all_arrays(write, particles);
    if (!particles.corners.empty()) write("corners", particles.corners);
    if (!particles.modes.empty()) write("modes", particles.modes);
    write("frame_times", state.frame_times);
    write.attribute("dimension", D);
    write.attribute("method", simulation.problem().method.name);
    write.attribute("time", simulation.time());
    write.attribute("steps", static_cast<double>(simulation.steps()));
    write.attribute("last_dt", simulation.last_step());
    write.attribute("start_kinetic", state.start.kinetic);
    write.attribute("start_node_kinetic", state.start.node_kinetic);
    write.attribute("start_strain", state.start.strain);
    write.check(H5Fflush(file, H5F_SCOPE_GLOBAL) >= 0);
  }
  atomic.commit();
}

template <int D>
RunState read_checkpoint(const std::filesystem::path& path, Simulation<D>& simulation) {
  const Silence silence;
  if (!std::filesystem::exists(path)) throw FileError(path, 0, "no such file");
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  const Reader read{path, file, simulation.particles().size()};
  read.check(file >= 0, "is no HDF5 file, so no checkpoint");
  const auto dimension = static_cast<int>(read.number("dimension"));
  read.check(dimension == D, "is a checkpoint in " + std::to_string(dimension) +
                                 " dimensions, the problem has " + std::to_string(D));
  const std::string method = read.text("method");
  read.check(method == simulation.problem().method.name,
             "is a checkpoint of the method '" + method + "', the problem has '" +
                 simulation.problem().method.name + "'");
  Particles<D> particles;
  for_all_arrays(read, particles);
  if (!simulation.particles().corners.empty()) read("corners", particles.corners);
  if (!simulation.particles().modes.empty()) {
    read("modes", particles.modes, false);
    read.check(particles.modes.size() == simulation.particles().modes.size(),
               "has " + std::to_string(particles.modes.size()) +
                   " coefficients of modes, the problem needs " +
                   std::to_string(simulation.particles().modes.size()));
  }
  simulation.restore(std::move(particles), read.number("time"),
                     static_cast<std::int64_t>(read.number("steps")), read.number("last_dt"));
  RunState state;
  read("frame_times", state.frame_times, false);
  state.start.kinetic = read.number("start_kinetic");
  state.start.node_kinetic = read.number("start_node_kinetic");
  state.start.strain = read.number("start_strain");
  return state;
}

#define RECON_INSTANTIATE(D)                                                         \
  template void write_checkpoint(const std::filesystem::path&, const Simulation<D>&, \
                                 const RunState&);                                   \
  template RunState read_checkpoint(const std::filesystem::path&, Simulation<D>&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
