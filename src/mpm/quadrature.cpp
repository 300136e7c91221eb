// Quadratures over the cells of the grid, of density, stress, momentum and body force that are fitted
// to the particles: their fits, and one loop over the points of the cells.
//
// A cell counts with the part of it that holds material: 1 where the cell and all its neighbours
// hold particles (or lie beyond the grid), 0 where it holds none, else the part that the volumes of
// its particles fill, at most 1. So a body ends where its particles end, and inside it nothing
// depends on how particles are spread over cells. For taylor_cells and gauss_cells the particles
// are the points of quadrature in all cells but those that count as full.
#include "core/counting_sort.hpp"
#include "mpm/cellwise.hpp"
#include "mpm/policies.hpp"
#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/transfer/cell_polynomial.hpp"

namespace recon::mpm {
namespace {

// What is fitted: a row for each particle with its density, the stress (row after row of its upper
// triangle), b (the body force per mass, unless that is empty), and, where the quadrature
// reconstructs it, density times velocity.
template <int D>
struct PointData {
  using Rows = RowsOfParticles;
  static constexpr int stresses = D * (D + 1) / 2;
  bool body_force, momentum;
  Rows rows;

  PointData(const Particles<D>& particles, const std::vector<Vector<D>>& b, bool with_momentum,
            int threads)
      : body_force(!b.empty()),
        momentum(with_momentum),
        rows(static_cast<Eigen::Index>(particles.size()),
             1 + stresses + (body_force ? D : 0) + (momentum ? D : 0)) {
    const auto fill = [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) {
        double* out = rows.row(static_cast<Eigen::Index>(p)).data();
        const double density = particles.density(p);
        *out++ = density;
        for (int r = 0; r < D; ++r)
          for (int c = r; c < D; ++c) *out++ = particles.stress[p](r, c);
        for (int d = 0; d < D && body_force; ++d) *out++ = b[p][d];
        for (int d = 0; d < D && momentum; ++d) *out++ = density * particles.v[p][d];
      }
    };
    parallel_blocks(particles.size(), particles_per_block, threads, fill);
  }
  // How the columns change their signs in mirrors.
  std::vector<Parity> parities() const {
    std::vector<Parity> of{scalar_parity};
    for (int r = 0; r < D; ++r)
      for (int c = r; c < D; ++c) of.push_back(tensor_parity(r, c));
    for (const bool has : {body_force, momentum})
      for (int d = 0; d < D && has; ++d) of.push_back(vector_parity(d));
    return of;
  }
  FieldView<double> field() const {
    return {static_cast<std::size_t>(rows.rows()), static_cast<int>(rows.cols()), rows.data(),
            rows.cols() * static_cast<std::ptrdiff_t>(sizeof(double)), sizeof(double)};
  }

  // Adds the contributions of a point with this volume and these values to the nodes: rho N_i to
  // the mass, rho b N_i - sigma grad N_i to the force, rho v N_i to the momentum; each times the
  // volume.
  template <class At>
  void add_point(const At& shape, double volume, const double* values, Nodes<D>& nodes) const {
    const double mass = volume * *values++;
    Matrix<D> stress;
    for (int r = 0; r < D; ++r)
      for (int c = r; c < D; ++c) stress(r, c) = stress(c, r) = *values++;
    Vector<D> push = Vector<D>::Zero(), carried = Vector<D>::Zero();
    for (int d = 0; d < D && body_force; ++d) push[d] = mass * *values++;
    for (int d = 0; d < D && momentum; ++d) carried[d] = volume * *values++;
    shape.add(nodes.mass, mass, trusted);
    shape.add(nodes.force, push, trusted);
    shape.add_gradient(nodes.force, Matrix<D>(-volume * stress), trusted);
    if (momentum) shape.add(nodes.momentum, carried, trusted);
  }
};

// The polynomials of cells that keep mass and momentum (transfer/cell_polynomial.hpp).
template <int D>
class TaylorFits {
 public:
  // Of these places and volumes, one for each row of the data.
  TaylorFits(const Grid<D>& grid, int threads, const std::vector<Vector<D>>& places,
             const std::vector<double>& volumes, const PointData<D>& data)
      : grid_(grid),
        places_(places),
        volumes_(volumes),
        data_(data),
        conserved_(static_cast<std::size_t>(data.rows.cols()), true) {
    const std::span<std::uint32_t> cell = by_cell_.keys(places.size());
    for (std::size_t p = 0; p < places.size(); ++p)
      cell[p] = static_cast<std::uint32_t>(grid_.cell_number(places[p]));
    by_cell_.sort(grid_.cell_count(), threads);
    std::fill_n(conserved_.begin() + 1, PointData<D>::stresses + (data.body_force ? D : 0), false);
  }

  // The values at x in cell c; cells are asked one after the other.
  Eigen::RowVectorXd operator()(std::size_t c, const Vector<D>& x) {
    if (c != cell_) fit(c);
    cell_ = c;
    return in_cell_(x);
  }

 private:
  void fit(std::size_t c) {
    const std::size_t first = by_cell_.first()[c], count = by_cell_.first()[c + 1] - first;
    std::vector<Vector<D>> x;
    Eigen::MatrixXd u(count, data_.rows.cols());
    Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(u.cols());
    for (const std::size_t p : by_cell_.order().subspan(first, count)) {
      const auto row = static_cast<Eigen::Index>(x.size());
      u.row(row) = data_.rows.row(static_cast<Eigen::Index>(p));
      mean += volumes_[p] / std::pow(grid_.h(), D) * u.row(row);
      x.push_back(places_[p]);
    }
    in_cell_.fit(grid_, c, x, u, mean, conserved_);
  }

  const Grid<D>& grid_;
  const std::vector<Vector<D>>& places_;
  const std::vector<double>& volumes_;
  const PointData<D>& data_;
  recon::detail::CountingSort by_cell_;
  std::vector<bool> conserved_;
  CellPolynomial<D> in_cell_;
  std::size_t cell_ = static_cast<std::size_t>(-1);
};

// The places and volumes of particles and of their images that give to the nodes.
template <int D>
struct Volumes {
  std::vector<Vector<D>> places;
  std::vector<double> volumes;

  Volumes(const Particles<D>& particles, const ImageParticles<D>& images)
      : places(with_places(particles.x, images.of)), volumes(particles.size()) {
    for (std::size_t p = 0; p < volumes.size(); ++p) volumes[p] = particles.volume(p);
    for (const Image<D>& image : images.of) volumes.push_back(volumes[image.of]);
  }
};

template <int D>
class CellQuadrature : public QuadraturePolicy<D> {
 public:
  explicit CellQuadrature(const Problem<D>& problem)
      : QuadraturePolicy<D>(problem), images_(images_of(problem, true)) {}

  FromParticles over_cells(const State<D>& s, const std::vector<Vector<D>>& b, Cells<D>& cells,
                           Nodes<D>& nodes) const override {
    const Problem<D>& problem = this->problem_;
    const Grid<D>& grid = nodes.grid;
    const Quadrature kind = problem.method.quadrature;
    PointData<D> data(s.particles, b, is_gauss(kind), problem.threads);
    const CellPoints<D> points(grid, kind == Quadrature::cells ? 1 : 2);
    const Volumes<D> giving(s.particles, nodes.images);
    fill(grid, giving, cells.fill);
    // Fits see all images; the polynomials of single cells have nothing beyond planes of symmetry.
    std::vector<Vector<D>> with_images;
    if (!images_.empty()) {
      const auto seen =
          kind == Quadrature::taylor_cells ? nodes.images.of : images_.of(s.particles.x);
      with_images = with_places(s.particles.x, seen);
      append_rows(data.rows, seen, data.parities());
    }
    const std::vector<Vector<D>>& places = with_images.empty() ? s.particles.x : with_images;
    const auto fit = [&](const StructuredGrid<double>& targets, Weight weight) {
      return reconstruct_on_grid(
          points_of(places), {data.field()}, targets,
          {.degree = problem.method.degree, .weight = weight, .threads = problem.threads});
    };
    // One fit at the centres or nodes, which the cells keep.
    const auto keep = [&](GridReconstruction made) {
      cells.fit = made.report();
      cells.values = std::move(made).values();
    };
    const auto row_of = [](const Eigen::MatrixXd& values, std::size_t i) {
      return values.row(static_cast<Eigen::Index>(i));
    };

    if (kind == Quadrature::cells) {  // degrees above 2 want more particles than a quadratic sees
      keep(fit(cell_centres(grid.nodes()),
               problem.method.degree <= 2 ? Weight::quadratic_b_spline : Weight::cubic_b_spline));
      integrate(data, points, cells, nodes,
                [&](std::size_t c, std::size_t, Row& row) { row = row_of(cells.values, c); });
    } else if (kind == Quadrature::nodal_cells) {  // linear between the nodes
      keep(fit(grid.nodes(), Weight::cubic_b_spline));
      LinearFunctions::Nodes<D> shape;
      integrate(data, points, cells, nodes, [&](std::size_t c, std::size_t g, Row& row) {
        LinearFunctions{}.at(grid, points.at(c, g), shape);
        row.setZero(cells.values.cols());
        for (std::size_t k = 0; k < shape.size(); ++k)
          row += shape.S[k] * row_of(cells.values, shape.node[k]);
      });
    } else if (kind == Quadrature::taylor_cells) {
      TaylorFits<D> taylor(grid, problem.threads, giving.places, giving.volumes, data);
      integrate(data, points, cells, nodes,
                [&](std::size_t c, std::size_t g, Row& row) { row = taylor(c, points.at(c, g)); });
    } else {  // one fit for each Gauss point of all cells
      std::vector<GridReconstruction> fits;
      for (std::size_t g = 0; g < points.per_cell(); ++g) {
        StructuredGrid<double> targets = cell_centres(grid.nodes());
        for (int d = 0; d < D; ++d) targets.origin[d] = grid.lower()[d] + points.place(g)[d];
        fits.push_back(fit(targets, Weight::cubic_b_spline));
      }
      integrate(data, points, cells, nodes,
                [&](std::size_t c, std::size_t g, Row& row) { row = row_of(fits[g].values(), c); });
    }
    if (is_cell(kind)) return {.mass_and_force = false};
    return {.full = &cells.fill};
  }

 private:
  using Row = Eigen::RowVectorXd;
  Images<D> images_;

  // The parts of the cells that count.
  void fill(const Grid<D>& grid, const Volumes<D>& giving, std::vector<double>& part) const {
    const std::vector<double> volume =
        sums_in_cells(grid, giving.places, [&](std::size_t p) { return giving.volumes[p]; });
    part.assign(volume.size(), 0);
    for (std::size_t c = 0; c < volume.size(); ++c) {
      const bool inside = volume[c] > 0 && is_inside(grid, volume, c);
      if (inside || is_cell(this->problem_.method.quadrature))
        part[c] = part_that_counts(volume[c], inside, std::pow(grid.h(), D));
    }
  }

  // values(c, g, row) makes the row of data at point g of cell c.
  void integrate(const PointData<D>& data, const CellPoints<D>& points, const Cells<D>& cells,
                 Nodes<D>& nodes,
                 const std::function<void(std::size_t, std::size_t, Row&)>& values) const {
    const Problem<D>& problem = this->problem_;
    const bool consistent = problem.method.mass == MassMatrix::consistent;
    with_shape(problem.method, [&](auto shape_of) {
      if constexpr (is_product<D, decltype(shape_of)>) {
        typename decltype(shape_of)::template Nodes<D> shape;
        Row row;
        for (std::size_t c = 0; c < cells.fill.size(); ++c)
          for (std::size_t g = 0; g < points.per_cell() && cells.fill[c] > 0; ++g) {
            const double volume = cells.fill[c] * points.volume();
            shape_of.functions.at(nodes.grid, points.at(c, g), shape);
            values(c, g, row);
            data.add_point(shape, volume, row.data(), nodes);
            if (consistent) add_mass(shape, volume * row[0], nodes.mass_entries);
          }
      }
    });
  }
};

// Particles stand for the cells: nothing is summed here, but their gradients and volumes are those
// of the cells from now on (functions_of() in policies.hpp).
template <int D>
class AdjointCells : public QuadraturePolicy<D> {
 public:
  using QuadraturePolicy<D>::QuadraturePolicy;

  FromParticles over_cells(const State<D>& s, const std::vector<Vector<D>>&, Cells<D>& cells,
                           Nodes<D>& nodes) const override {
    const Problem<D>& problem = this->problem_;
    const Volumes<D> giving(s.particles, nodes.images);
    nodes.weights.fill(nodes.grid, problem.method.basis == Basis::cell_linear ? 1 : 2,
                       giving.places, giving.volumes, problem.threads);
    cells.fill = nodes.weights.fitted();
    return {};
  }
};

}  // namespace

template <int D>
std::unique_ptr<const QuadraturePolicy<D>> make_quadrature(const Problem<D>& problem) {
  if (problem.method.quadrature == Quadrature::particles)
    return std::make_unique<QuadraturePolicy<D>>(problem);
  if (problem.method.quadrature == Quadrature::adjoint_cells)
    return std::make_unique<AdjointCells<D>>(problem);
  return std::make_unique<CellQuadrature<D>>(problem);
}

#define RECON_INSTANTIATE(D) \
  template std::unique_ptr<const QuadraturePolicy<D>> make_quadrature(const Problem<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
