#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <cmath>
#include <numbers>

#include "recon/io/read.hpp"
#include "recon/runs/forecast.hpp"
#include "runs/bodies.hpp"
#include "runs/material_keys.hpp"
#include "runs/problem_reader.hpp"

namespace recon::mpm {
namespace {

using Words = std::vector<std::string>;

template <int D>
class BodyReader {
 public:
  explicit BodyReader(ProblemReader<D>& reader)
      : reader_(reader), file_(reader.file()), problem_(reader.problem()) {}

  void read() {
    const auto bodies = file_.tables("body");
    if (bodies.empty()) file_.fail("body", "a [[body]] is needed");
    for (const TomlTable& body : bodies) {
      const int number = static_cast<int>(problem_.materials.size());
      double density = 0;
      problem_.materials.push_back(material(body, density));
      problem_.densities.push_back(density);
      const std::size_t before = problem_.particles.size();
      fill(body, density, number);
      if (problem_.particles.size() == before)
        body.fail("shape", "no particle lies in the body and the grid");
      if (body.has("velocity")) set_velocity(body, before);
      body.finish();
    }
  }

 private:
  // The material of `table`, or that of the whole file.
  Material material(const TomlTable& table, double& density) const {
    const TomlTable keys =
        table.has("material") ? table.table("material") : file_.table("material");
    Lame elastic;
    const double young = keys.number("young"), poisson = keys.number("poisson");
    checked(keys, "young", [&] { elastic = Lame::from(young, poisson); });
    density = keys.number("density");
    checked(keys, "density", [&] { validate_density(density); });
    Words names;
    for_each_material([&]<class M>(const M&) { names.emplace_back(M::name); });
    const std::string kind = keys.choice("kind", names);
    Material made;
    for_each_material([&]<class M>(M material) {
      if (M::name != kind) return;
      static_cast<Lame&>(material) = elastic;
      if constexpr (requires { M::parameters(); })
        for (const auto& [key, member] : M::parameters()) material.*member = keys.number(key);
      made = material;
    });
    keys.finish();
    checked(keys, "kind", [&] { validate_material(made); });
    return made;
  }

  void fill(const TomlTable& body, double density, int number) {
    const Grid<D>& grid = problem_.grid;
    const std::string shape =
        body.choice("shape", Words{"box", "disk", "ring", "polygon", "file"}, true);
    if (shape == "file") return fill_from_file(body, density, number);
    const int n = body.integer("particles", 2, 1, 100);
    const std::string layout = body.choice("layout", Words{"cell", "jittered", "polar", "body"});
    const double jitter = layout == "jittered" ? body.number("jitter", 0.5) : 0;
    if (jitter < 0 || jitter > 1) body.fail("jitter", "must lie between 0 and 1");
    Region<D> region;
    if (shape == "box") {
      const Vector<D> lower = reader_.vector(body, "lower"), upper = reader_.vector(body, "upper");
      if (!(lower.array() < upper.array()).all()) body.fail("upper", "must be above lower");
      region = {lower, upper, [=](const Vector<D>& X) {
                  return (X.array() > lower.array()).all() && (X.array() < upper.array()).all();
                }};
    } else if (shape == "polygon") {
      region = polygon(body);
    } else {
      const Vector<D> centre = reader_.vector(body, "centre");
      const double outer = body.number(shape == "disk" ? "radius" : "outer");
      const double inner = shape == "disk" ? 0 : body.number("inner");
      if (!(outer > inner && inner >= 0))
        body.fail(shape == "disk" ? "radius" : "outer", "must be above the inner radius");
      region = {centre.array() - outer, centre.array() + outer, [=](const Vector<D>& X) {
                  const double R = (X - centre).norm();
                  return R >= inner && R <= outer;
                }};
      if (layout == "polar") return fill_polar(body, centre, inner, outer, density, number);
    }
    if (layout == "polar") body.fail("layout", "'polar' is for rings and disks");
    if (layout == "body" && shape != "box") body.fail("layout", "'body' is for boxes");
    checked(body, "shape", [&] {
      require_in_grid(grid, region.lower, region.upper);
      const bool own = layout == "body";  // in cells of the spacing, from the body's lower corner
      fill_cells(own ? Grid<D>(region.lower, region.upper, grid.h() / n) : grid, region,
                 own ? 1 : n, jitter, density, number, most_particles(), problem_.particles);
    });
  }

  // That there is memory for, and numbers.
  double most_particles() const {
    const double memory =
        reader_.out().limits.memory > 0 ? reader_.out().limits.memory : available_memory();
    return std::min(memory / bytes_of_particle<D>(problem_.kept()), 4294967294.0) -
           static_cast<double>(problem_.particles.size());
  }

  void fill_polar(const TomlTable& body, const Vector<D>& centre, double inner, double outer,
                  double density, int number) {
    if constexpr (D == 2) {
      const double h = problem_.grid.h(), n = body.integer("particles", 2, 1, 100);
      const double around = body.number("angular", n * std::numbers::pi * (inner + outer));
      if (!(around > 0)) body.fail("angular", "must be positive");
      Sector sector;
      double part = 1;  // of the circle
      if (body.has("angles")) {
        const std::vector<double> degrees = body.numbers("angles", 2);
        part = (degrees[1] - degrees[0]) / 360;
        if (!(part > 0 && part <= 1 && std::abs(degrees[0]) <= 360))
          body.fail("angles",
                    "must be two angles in degrees, from -360 to 360, of which the second "
                    "is above the first by at most 360");
        sector = {degrees[0] * std::numbers::pi / 180, degrees[1] * std::numbers::pi / 180};
      }
      const auto [lower, upper] = box_of(centre, inner, outer, sector);
      checked(body, "shape",
              [&, &low = lower, &up = upper] { require_in_grid(problem_.grid, low, up); });
      fill_ring(centre, inner, outer, sector,
                std::max(1, static_cast<int>(std::lround(n * (outer - inner) / h))),
                std::max(part == 1 ? 3 : 1, static_cast<int>(std::lround(part * around / h))),
                density, number, problem_.particles);
    } else {
      (void)centre, (void)inner, (void)outer, (void)density, (void)number;
      body.fail("layout", "'polar' is for 2-D");
    }
  }

  static Region<D> polygon(const TomlTable& body) {
    namespace bg = boost::geometry;
    using Point = bg::model::d2::point_xy<double>;
    if constexpr (D == 2) {
      bg::model::polygon<Point> shape;
      try {
        bg::read_wkt(body.text("wkt"), shape);
      } catch (const bg::exception& error) {
        body.fail("wkt", std::string("no polygon in WKT: ") + error.what());
      }
      bg::correct(shape);
      std::string reason;
      if (!bg::is_valid(shape, reason)) body.fail("wkt", reason);
      bg::model::box<Point> box;
      bg::envelope(shape, box);
      return {{box.min_corner().x(), box.min_corner().y()},
              {box.max_corner().x(), box.max_corner().y()},
              [shape](const Vector<2>& X) { return bg::within(Point(X[0], X[1]), shape); }};
    } else {
      body.fail("shape", "polygons are for 2-D");
    }
  }

  void fill_from_file(const TomlTable& body, double density, int number) {
    const std::filesystem::path name = body.text("file");
    const ParticleTable table =
        read_particles(name.is_absolute() ? name : reader_.path().parent_path() / name);
    const auto positions = table.positions(D);
    std::vector<double> volumes(table.size());
    if (body.has("volume"))
      std::fill(volumes.begin(), volumes.end(), body.number("volume"));
    else
      volumes = table.column("volume");
    for (std::size_t p = 0; p < table.size(); ++p) {
      if (!(volumes[p] > 0))
        body.fail("file", "volume of " + table.describe_row(p) + " must be positive");
      Vector<D> X;
      for (int d = 0; d < D; ++d) X[d] = positions(p, d);
      if (!problem_.grid.contains(X))
        body.fail("file", "position of " + table.describe_row(p) + " must lie in the grid");
      problem_.particles.add(X, Matrix<D>::Identity() * (std::pow(volumes[p], 1.0 / D) / 2),
                             density, number);
    }
  }

  // And its gradient, by central differences.
  void set_velocity(const TomlTable& body, std::size_t first) {
    Particles<D>& particles = problem_.particles;
    const auto velocity = reader_.expressions(body, "velocity");
    const double step = 1e-4 * problem_.grid.h();
    const auto at = [&](const Vector<D>& X) {
      Vector<D> v;
      for (int d = 0; d < D; ++d) v[d] = velocity[d](variables<D>(X, X, 0));
      return v;
    };
    const bool constant = std::all_of(velocity.begin(), velocity.end(),
                                      [](const Expression& e) { return e.is_constant(); });
    checked(body, "velocity", [&] {
      for (std::size_t p = first; p < particles.size(); ++p) {
        particles.v[p] = at(particles.X[p]);
        for (int d = 0; d < D && !constant; ++d) {
          const Vector<D> aside = step * Vector<D>::Unit(d);
          particles.L[p].col(d) =
              (at(particles.X[p] + aside) - at(particles.X[p] - aside)) / (2 * step);
        }
      }
    });
  }

  ProblemReader<D>& reader_;
  const TomlTable& file_;
  Problem<D>& problem_;
};

}  // namespace

template <int D>
void read_bodies(ProblemReader<D>& reader) {
  BodyReader<D>(reader).read();
}
template void read_bodies(ProblemReader<1>&);
template void read_bodies(ProblemReader<2>&);
template void read_bodies(ProblemReader<3>&);

}  // namespace recon::mpm
