#include "fix_recon_grid.hpp"

#include <atom.h>
#include <comm.h>
#include <compute.h>
#include <domain.h>
#include <error.h>
#include <memory.h>
#include <modify.h>
#include <region.h>
#include <update.h>
#include <utils.h>

#include <chrono>
#include <cmath>
#include <cstring>

#include "recon/io/picture.hpp"
#include "recon/operators/kernel_sum.hpp"
#include "recon/recon.hpp"

namespace LAMMPS_NS {

// With a literal LAMMPS would format it, by a library that its headers come without.
void FixReconGrid::fail(const std::string& what) const {
  error->all(FLERR, what);
}

// What is known at the nodes, and the operator that made it.
struct FixReconGrid::Fields {
  recon::StructuredGrid<double> grid;
  recon::Reconstruction fit;
  Eigen::MatrixXd density, velocity, stress;
  std::vector<int> atoms;  // of the group, where not all are: their numbers in LAMMPS' arrays
};

FixReconGrid::FixReconGrid(LAMMPS* lammps, int count, char** words) : Fix(lammps, count, words) {
  if (count < 5) fail("Illegal fix recon/grid command: N and spacing are missing");
  nevery = utils::inumeric(FLERR, words[3], false, lammps);
  spacing_ = utils::numeric(FLERR, words[4], false, lammps);
  if (nevery <= 0) fail("Fix recon/grid: N must be positive");
  radius_ = 2 * spacing_;
  read_words(count, words);
  vector_flag = 1;
  size_vector = 6;
  global_freq = 1;
  extvector = 1;
  peratom_flag = 1;
  size_peratom_cols = 3;
  peratom_freq = 1;
  grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  for (int i = 0; i < atom->nlocal; ++i) set_arrays(i);
}

FixReconGrid::~FixReconGrid() {
  atom->delete_callback(id, Atom::GROW);
  memory->destroy(array_atom);
}

void FixReconGrid::read_words(int count, char** words) {
  for (int i = 5; i < count; ++i) {
    const std::string key = words[i];
    const auto next = [&] {
      if (++i >= count) fail("Fix recon/grid: " + key + " needs a value");
      return words[i];
    };
    if (key == "radius") {
      radius_ = utils::numeric(FLERR, next(), false, lmp);
    } else if (key == "degree") {
      degree_ = utils::inumeric(FLERR, next(), false, lmp);
    } else if (key == "stress") {
      stress_ = next();
      if (stress_.rfind("c_", 0) != 0) fail("Fix recon/grid: stress needs c_ID");
      stress_.erase(0, 2);
    } else if (key == "drag") {
      drag_ = utils::numeric(FLERR, next(), false, lmp);
      region_ = next();
    } else if (key == "out") {
      name_ = next();
    } else if (key == "picture") {
      picture_ = true;
    } else {
      fail("Fix recon/grid: unknown keyword " + key);
    }
  }
  if (picture_ && name_.empty()) fail("Fix recon/grid: picture needs out");
}

int FixReconGrid::setmask() {
  return FixConst::INITIAL_INTEGRATE | FixConst::POST_FORCE | FixConst::FINAL_INTEGRATE |
         FixConst::END_OF_STEP;
}

void FixReconGrid::init() {
  if (comm->nprocs > 1) fail("Fix recon/grid runs on one process");
  if (domain->triclinic) fail("Fix recon/grid needs an orthogonal box");
  if (!stress_.empty()) {
    const int number = modify->find_compute(stress_);
    if (number < 0 || modify->compute[number]->size_peratom_cols != 6)
      fail("Fix recon/grid: there is no compute stress/atom " + stress_);
    modify->compute[number]->addstep(update->ntimestep);
  }
  if (!region_.empty() && domain->find_region(region_) < 0)
    fail("Fix recon/grid: there is no region " + region_);
  half_step_ = 0.5 * update->dt;
}

void FixReconGrid::setup(int) {
  end_of_step();
  post_force(0);
}

// The atoms move by half a step with the force of the last post_force, twice a step; so does the
// account of what the nodes give.
void FixReconGrid::initial_integrate(int) {
  for (int d = 0; d < 3; ++d) impulse_[d] += half_step_ * applied_[d];
}
void FixReconGrid::final_integrate() {
  initial_integrate(0);
}

void FixReconGrid::post_force(int) {
  for (int i = 0; i < atom->nlocal; ++i)
    for (int d = 0; d < 3; ++d) atom->f[i][d] += array_atom[i][d];
  std::copy_n(held_, 3, applied_);
}

void FixReconGrid::end_of_step() {
  const auto begin = std::chrono::steady_clock::now();
  try {
    reconstruct();
  } catch (const std::exception& trouble) {
    fail(std::string("Fix recon/grid: ") + trouble.what());
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  seconds += taken.count();
  ++frames;
}

void FixReconGrid::reconstruct() {
  const int dimension = domain->dimension;
  recon::PeriodicDomain<double> periods;
  recon::Box<double> box = recon::Box<double>::empty(dimension);
  for (int d = 0; d < dimension; ++d) {
    periods.periodic[d] = domain->periodicity[d] != 0;
    periods.lower[d] = box.lower[d] = domain->boxlo[d];
    periods.upper[d] = box.upper[d] = domain->boxhi[d];
  }
  // LAMMPS has the atoms in rows of three numbers, one behind another: no copy is made.
  const auto count = static_cast<std::size_t>(atom->nlocal);
  constexpr std::ptrdiff_t row = 3 * sizeof(double);
  const std::array<const void*, 3> first{&atom->x[0][0], &atom->x[0][1], &atom->x[0][2]};
  const recon::PointsView<double> points(count, dimension, first, {row, row, row});
  const recon::FieldView<double> velocity(count, dimension, &atom->v[0][0], row, sizeof(double));
  std::vector<double> mass(count);
  for (std::size_t i = 0; i < count; ++i)
    mass[i] = atom->rmass ? atom->rmass[i] : atom->mass[atom->type[i]];

  Fields fields;
  fields.grid = recon::covering_grid(box, spacing_, periods);
  const auto nodes = fields.grid.nodes();
  const recon::Sources sources(points, {.domain = periods});
  fields.fit = recon::reconstruct(sources, nodes.view(),
                                  {.degree = degree_, .neighbours = recon::Radius{radius_}});
  fields.velocity = fields.fit.apply(velocity);
  const auto sums =
      recon::kernel_operator<double>(sources, nodes.view(), {.support = recon::Radius{radius_}});
  fields.density = sums.apply(recon::field_of(mass));
  if (!stress_.empty()) {
    Compute* const compute = modify->compute[modify->find_compute(stress_)];
    if (compute->invoked_peratom != update->ntimestep) compute->compute_peratom();
    fields.stress = sums.apply(recon::FieldView<double>(count, 6, &compute->array_atom[0][0],
                                                        6 * sizeof(double), sizeof(double)));
    compute->addstep(update->ntimestep + nevery);
  }
  force_atoms(fields);
  if (!name_.empty()) write(fields);
}

void FixReconGrid::force_atoms(const Fields& fields) {
  if (drag_ == 0) return;
  const int dimension = domain->dimension;
  Region* const region = domain->regions[domain->find_region(region_)];
  region->prematch();
  double volume = 1;
  for (int d = 0; d < dimension; ++d) volume *= fields.grid.spacing[d];
  const auto nodes = fields.grid.nodes();
  Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(fields.velocity.rows(), 3);
  for (Eigen::Index n = 0; n < pull.rows(); ++n) {
    double at[3] = {0, 0, 0};
    for (int d = 0; d < dimension; ++d) at[d] = nodes.view()(static_cast<std::size_t>(n), d);
    // Where no atom is near there is no velocity, and nothing to pull at.
    if (!region->match(at[0], at[1], at[2]) || !fields.velocity.row(n).allFinite()) continue;
    pull.row(n).head(dimension) = -drag_ * fields.density(n, 0) * volume * fields.velocity.row(n);
  }
  const Eigen::MatrixXd of_atoms = fields.fit.apply_transpose(recon::field_of(pull));
  for (int d = 0; d < 3; ++d) {
    held_[d] = pull.col(d).sum();
    for (int i = 0; i < atom->nlocal; ++i) array_atom[i][d] = of_atoms(i, d);
  }
}

void FixReconGrid::write(const Fields& fields) const {
  recon::FieldSet set;
  set.step = update->ntimestep;
  set.time = static_cast<double>(update->ntimestep) * update->dt;
  const auto add = [&](const std::string& name, const Eigen::MatrixXd& values,
                       recon::FieldKind kind) {
    std::vector<double> rows;
    for (Eigen::Index n = 0; n < values.rows(); ++n)
      for (Eigen::Index c = 0; c < values.cols(); ++c) rows.push_back(values(n, c));
    set.add(name, static_cast<int>(values.cols()), std::move(rows), recon::NumberType::float64,
            kind);
  };
  add("density", fields.density, recon::FieldKind::scalars);
  add("velocity", fields.velocity, recon::FieldKind::vector);
  if (fields.stress.size() > 0) {
    // LAMMPS has xx, yy, zz, xy, xz, yz; a tensor of nine is the same in two dimensions and three.
    constexpr std::array<int, 9> places{0, 3, 4, 3, 1, 5, 4, 5, 2};
    Eigen::MatrixXd tensor(fields.stress.rows(), 9);
    for (Eigen::Index c = 0; c < 9; ++c)
      tensor.col(c) = fields.stress.col(places[static_cast<std::size_t>(c)]);
    add("stress", tensor, recon::FieldKind::tensor);
  }
  const recon::FitReports& report = fields.fit.report();
  std::vector<double> status(report.size());
  for (std::size_t n = 0; n < status.size(); ++n) status[n] = static_cast<double>(report[n].status);
  set.add("status", 1, status, recon::NumberType::int32);

  const std::string stem = name_ + "_" + std::to_string(update->ntimestep);
  recon::write_vti(stem + ".vti", fields.grid, set);
  series_.push_back({*set.time, std::filesystem::path(stem + ".vti").filename()});
  recon::write_pvd(name_ + ".pvd", series_);
  if (!picture_ || fields.grid.dimension != 2) return;
  recon::HeatMap map;
  map.title = "step " + std::to_string(update->ntimestep);
  std::vector<double> along(set["density"].size());
  for (std::size_t n = 0; n < along.size(); ++n)
    along[n] = fields.velocity(static_cast<Eigen::Index>(n), 0);
  map.panels.push_back({"velocity along x", fields.grid, along, {}});
  map.columns = 1;
  map.colour_label = "velocity";
  recon::draw(stem + ".png", map);
}

double FixReconGrid::compute_vector(int n) {
  return n < 3 ? impulse_[n] : applied_[n - 3];
}

double FixReconGrid::memory_usage() {
  return 3.0 * atom->nmax * sizeof(double);
}

void FixReconGrid::grow_arrays(int atoms) {
  memory->grow(array_atom, atoms, 3, "recon/grid:force");
}

void FixReconGrid::copy_arrays(int from, int to, int) {
  std::copy_n(array_atom[from], 3, array_atom[to]);
}

void FixReconGrid::set_arrays(int i) {
  std::fill_n(array_atom[i], 3, 0.0);
}

int FixReconGrid::pack_exchange(int i, double* buffer) {
  std::copy_n(array_atom[i], 3, buffer);
  return 3;
}

int FixReconGrid::unpack_exchange(int i, double* buffer) {
  std::copy_n(buffer, 3, array_atom[i]);
  return 3;
}

}  // namespace LAMMPS_NS
