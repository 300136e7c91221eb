// Orders of convergence by degree, of values and of exact and diffuse gradients.
#include "accuracy.hpp"
#include "accuracy_measure.hpp"
#include "accuracy_report.hpp"
#include "accuracy_slope.hpp"

namespace recon_bench {
namespace {

struct Errors {
  std::vector<double> h, value, exact, diffuse;
};

template <int D>
Errors refine(CloudKind kind, int degree, const std::vector<std::size_t>& meshes,
              std::size_t targets) {
  Errors errors;
  for (const std::size_t per_axis : meshes) {
    auto s = make_setting<D>(kind, per_axis, targets);
    for (auto& x : s.targets)  // so far inside that no support leaves the domain
      for (double& c : x) c = 0.25 + c / 2;
    const auto k = static_cast<std::size_t>(5 * recon::monomial_count(D, degree));
    const recon::Options options{.degree = degree,
                                 .neighbours = recon::Radius{radius_for<D>(k, s.spacing)}};
    const std::string name = std::string(name_of(kind)) + " cloud, degree " +
                             std::to_string(degree) + ", " + std::to_string(per_axis) +
                             " particles per axis";
    const auto a = accuracy_of(name, s, options);
    const auto d = accuracy_of(name, s, options, recon::Derivative::diffuse);
    errors.h.push_back(s.spacing);
    errors.value.push_back(a.rms_value);
    errors.exact.push_back(a.rms_gradient);
    errors.diffuse.push_back(d.rms_gradient);
  }
  return errors;
}

struct Pictures {
  recon::LinePlot values, gradients;
};

template <int D>
void measure(const std::vector<std::size_t>& meshes, std::size_t targets, Table& table,
             Pictures* pictures) {
  for (const CloudKind kind : {CloudKind::regular, CloudKind::jittered})
    for (int degree = 0; degree <= 4; ++degree) {
      const Errors e = refine<D>(kind, degree, meshes, targets);
      const double order = slope(e.h, e.value);
      // Shepard loses its order where the particles around a target are not symmetric.
      if (degree > 0 && !(order > degree + 0.6))
        fail("orders", "degree " + std::to_string(degree) + " converges with order " +
                           number(order) + " in " + std::to_string(D) + "-D");
      table.add({std::to_string(D), name_of(kind), std::to_string(degree), number(order),
                 number(slope(e.h, e.exact)), degree ? number(slope(e.h, e.diffuse)) : "-",
                 number(e.h.back()), number(e.value.back()), number(e.exact.back()),
                 degree ? number(e.diffuse.back()) : "-"});
      if (!pictures || kind != CloudKind::jittered) continue;
      const std::string name = "degree " + std::to_string(degree);
      pictures->values.curves.push_back({name, e.h, e.value});
      pictures->gradients.curves.push_back({name, e.h, e.exact});
    }
}

}  // namespace

Section order_study(const Context& context) {
  Table table("accuracy_orders",
              {"dimension", "cloud", "degree", "order of values", "order of exact gradients",
               "order of diffuse gradients", "finest spacing", "RMS error", "RMS gradient error",
               "RMS diffuse gradient error"});
  const std::string x_label = "particle spacing / width of the domain";
  Pictures pictures{
      log_log_plot("2-D, jittered particles: values", x_label, "RMS error of a field of size 1"),
      log_log_plot("2-D, jittered particles: exact gradients", x_label,
                   "RMS error of the gradient, 1/length")};
  const std::size_t targets = context.quick ? 200 : 2000;
  using Meshes = std::vector<std::size_t>;
  measure<1>(Meshes{40, 80, 160, 320}, targets, table, nullptr);
  measure<2>(context.quick ? Meshes{20, 40, 80} : Meshes{20, 40, 80, 160, 320}, targets, table,
             &pictures);
  measure<3>(context.quick ? Meshes{12, 24} : Meshes{12, 16, 24, 32, 48}, targets, table, nullptr);
  Section section{
      "Orders of convergence",
      "Supports of one radius, with about 5 particles per term; targets so far inside that no "
      "support is cut off. Slopes of the RMS error over the spacing by least squares over all "
      "meshes; errors "
      "on the finest. Gradients: exact, the derivative of what is returned; diffuse, the slope of "
      "the local polynomial.",
      {table},
      {}};
  add_picture(section, context, "accuracy_orders", pictures.values);
  add_picture(section, context, "accuracy_orders_gradient", pictures.gradients);
  return section;
}

}  // namespace recon_bench
