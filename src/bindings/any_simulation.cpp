#include "bindings/any_simulation.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <type_traits>
#include <utility>

#include "bindings/named_options.hpp"
#include "recon/runs/ledger.hpp"
#include "recon/runs/read_problem.hpp"
#include "recon/runs/run.hpp"
#include "recon/runs/simulation.hpp"

namespace recon::bindings {
namespace {

template <class T>
struct Entry;  // one entry of an array of particles or nodes
template <>
struct Entry<double> {
  static void add(ParticleArrayView&) {}
};
template <>
struct Entry<std::int32_t> {
  static void add(ParticleArrayView& view) { view.integers = true; }
};
template <int D>
struct Entry<mpm::Vector<D>> {
  static void add(ParticleArrayView& view) {
    view.shape.push_back(D);
    view.strides.push_back(sizeof(double));
  }
};
template <int D>
struct MatrixEntry {
  static void add(ParticleArrayView& view) {  // Eigen's matrices are column-major
    view.shape.insert(view.shape.end(), {D, D});
    view.strides.insert(view.strides.end(),
                        {std::ptrdiff_t{sizeof(double)}, std::ptrdiff_t{D * sizeof(double)}});
  }
};
template <>
struct Entry<mpm::Matrix<2>> : MatrixEntry<2> {};
template <>
struct Entry<mpm::Matrix<3>> : MatrixEntry<3> {};
template <class T, std::size_t N>
struct Entry<std::array<T, N>> {
  static void add(ParticleArrayView& view) {
    view.shape.push_back(N);
    view.strides.push_back(sizeof(T));
    Entry<T>::add(view);
  }
};

// `each` entries of the array belong to one particle.
template <class T>
ParticleArrayView view_of(const std::vector<T>& array, std::size_t each) {
  ParticleArrayView view;
  view.data = array.data();
  view.shape.push_back(each > 0 ? array.size() / each : 0);
  view.strides.push_back(static_cast<std::ptrdiff_t>(each * sizeof(T)));
  if (each > 1) {
    view.shape.push_back(each);
    view.strides.push_back(sizeof(T));
  }
  Entry<T>::add(view);
  return view;
}

}  // namespace

struct AnySimulation::Base {
  std::string title, method;
  double end = 0;

  virtual ~Base() = default;
  virtual int dimension() const = 0;
  virtual std::size_t size() const = 0;
  virtual double time() const = 0;
  virtual long long steps() const = 0;
  virtual double choose_step() const = 0;
  virtual void step(double dt) = 0;
  virtual void map() = 0;
  virtual bool mapped() const = 0;
  virtual void run_until(double time, const std::function<void()>& go_on) = 0;
  virtual ParticleArrayView particles(std::string_view name) const = 0;
  virtual std::vector<std::string> particle_arrays() const = 0;
  virtual ParticleArrayView nodes(std::string_view name) const = 0;
  virtual Grid grid() const = 0;
  virtual std::vector<std::pair<std::string, double>> account() const = 0;
};

namespace {

template <int D>
class Held : public AnySimulation::Base {
 public:
  explicit Held(mpm::ProblemFile<D> file)
      : simulation_(std::move(file.problem)), limits_(file.limits) {
    title = std::move(file.title);
    method = simulation_.problem().method.name;
    end = simulation_.problem().time.end;
  }

  int dimension() const override { return D; }
  std::size_t size() const override { return simulation_.particles().size(); }
  double time() const override { return simulation_.time(); }
  long long steps() const override { return simulation_.steps(); }
  double choose_step() const override { return simulation_.choose_step().dt; }
  void step(double dt) override { simulation_.step(dt); }
  void map() override { simulation_.map(); }
  bool mapped() const override { return simulation_.mapped(); }
  void run_until(double time, const std::function<void()>& go_on) override {
    mpm::run_until(simulation_, time, go_on, limits_);
  }

  ParticleArrayView particles(std::string_view name) const override {
    ParticleArrayView found;
    bool is_there = false;
    simulation_.particles().arrays(kept(),
                                   [&](const mpm::ParticleArray& array, const auto& values) {
                                     if (name != array.name || (values.empty() && array.kept))
                                       return;
                                     found = view_of(values, array.per_particle);
                                     is_there = true;
                                   });
    if (!is_there) refuse_name("array of the particles", name, particle_arrays());
    return found;
  }

  std::vector<std::string> particle_arrays() const override {
    std::vector<std::string> names;
    simulation_.particles().arrays(kept(),
                                   [&](const mpm::ParticleArray& array, const auto& values) {
                                     if (!array.kept || !values.empty())
                                       names.emplace_back(array.name);
                                   });
    return names;
  }

  ParticleArrayView nodes(std::string_view name) const override {
    const mpm::Nodes<D>& nodes = simulation_.nodes();
    if (name == "mass") return view_of(nodes.mass, 1);
    if (name == "velocity") return view_of(nodes.velocity, 1);
    if (name == "force") return view_of(nodes.force, 1);
    refuse_name("array of the nodes", name, std::vector<std::string>{"mass", "velocity", "force"});
  }

  AnySimulation::Grid grid() const override {
    AnySimulation::Grid out;
    const StructuredGrid<double>& nodes = simulation_.problem().grid.nodes();
    for (int d = 0; d < D; ++d) {
      out.origin.push_back(nodes.origin[d]);
      out.spacing.push_back(nodes.spacing[d]);
      out.counts.push_back(nodes.counts[d]);
    }
    return out;
  }

  // The names and numbers that ledger.csv has.
  std::vector<std::pair<std::string, double>> account() const override {
    const std::string names = mpm::ledger_header(),
                      row = mpm::ledger_row(mpm::account(simulation_));
    std::vector<std::pair<std::string, double>> out;
    std::size_t name = 0, number = 0;
    while (name < names.size()) {
      const std::size_t comma = std::min(names.find(',', name), names.size());
      double value = 0;
      std::from_chars(row.data() + number, row.data() + row.size(), value);
      out.emplace_back(names.substr(name, comma - name), value);
      name = comma + 1;
      number = std::min(row.find(',', number), row.size() - 1) + 1;
    }
    return out;
  }

 private:
  mpm::Kept kept() const { return simulation_.problem().kept(); }

  mpm::Simulation<D> simulation_;
  mpm::Limits limits_;
};

}  // namespace

AnySimulation::AnySimulation(const std::filesystem::path& path,
                             std::span<const std::string> settings)
    : own_(std::visit(
          []<int D>(mpm::ProblemFile<D>&& file) -> std::unique_ptr<Base> {
            return std::make_unique<Held<D>>(std::move(file));
          },
          mpm::read_problem(path, settings))) {}

AnySimulation::~AnySimulation() = default;

int AnySimulation::dimension() const {
  return own_->dimension();
}
std::size_t AnySimulation::size() const {
  return own_->size();
}
double AnySimulation::time() const {
  return own_->time();
}
long long AnySimulation::steps() const {
  return own_->steps();
}
double AnySimulation::end() const {
  return own_->end;
}
const std::string& AnySimulation::title() const {
  return own_->title;
}
std::string AnySimulation::method() const {
  return own_->method;
}
double AnySimulation::choose_step() const {
  return own_->choose_step();
}
void AnySimulation::step(double dt) {
  own_->step(dt);
}
void AnySimulation::map() {
  own_->map();
}
bool AnySimulation::mapped() const {
  return own_->mapped();
}

ParticleArrayView AnySimulation::particles(std::string_view name) const {
  return own_->particles(name);
}
std::vector<std::string> AnySimulation::particle_arrays() const {
  return own_->particle_arrays();
}
ParticleArrayView AnySimulation::nodes(std::string_view name) const {
  return own_->nodes(name);
}
AnySimulation::Grid AnySimulation::grid() const {
  return own_->grid();
}
std::vector<std::pair<std::string, double>> AnySimulation::account() const {
  return own_->account();
}

void AnySimulation::run_until(double time, const std::function<void()>& go_on) {
  recon::detail::require(std::isfinite(time) && time >= own_->time(), "time", time,
                         "must be finite and not before the present time");
  own_->run_until(time, go_on);
}

}  // namespace recon::bindings
