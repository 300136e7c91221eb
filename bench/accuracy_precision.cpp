// Float or double: what it saves, and where the errors of float begin to show.
#include "accuracy.hpp"
#include "accuracy_measure.hpp"
#include "accuracy_report.hpp"

namespace recon_bench {
namespace {

template <class Scalar, int D>
Setting<Scalar, D> rounded_setting(const Setting<double, D>& s) {
  return {rounded<Scalar, D>(s.points), rounded<Scalar, D>(s.targets), s.spacing};
}

template <class Scalar>
const char* scalar_name() {
  return sizeof(Scalar) == sizeof(float) ? "float" : "double";
}

template <class Scalar>
void add_rows(const Context& context, const Setting<double, 3>& all, Table& table) {
  const auto s = rounded_setting<Scalar>(all);
  for (int degree = 0; degree <= 4; ++degree)
    for (const auto solver : {recon::Solver::moment_matrix, recon::Solver::gram_schmidt}) {
      if (degree == 0 && solver == recon::Solver::gram_schmidt) continue;
      const auto k = static_cast<std::size_t>(2 * recon::monomial_count(3, degree) + 1);
      const recon::Options options{
          .degree = degree, .neighbours = recon::Nearest{k}, .solver = solver};
      const auto a = accuracy_of(std::string(scalar_name<Scalar>()) + ", degree " +
                                     std::to_string(degree) + ", " + solver_name(solver),
                                 s, options);
      const Cost c = cost_of(s, options, context.threads, timing_budget(context));
      table.add({std::to_string(degree), solver_name(solver, degree), scalar_name<Scalar>(),
                 number(a.rms_value), number(a.rms_gradient), number(a.residual), number(a.reduced),
                 number(a.handed_over), number(c.construct), number(c.construct_parallel),
                 number(c.apply), number(a.bytes)});
    }
}

// Errors against the spacing: rounding ends the convergence.
struct Floors {
  Table table{"accuracy_float_floor",
              {"degree", "spacing", "RMS error double", "RMS error float",
               "RMS gradient error double", "RMS gradient error float", "reduced % float"}};
  recon::LinePlot plot;
};

void find_floor(const Context& context, int degree, Floors& floors) {
  recon::Curve curves[4];
  const char* names[] = {"value, double", "value, float", "gradient, double", "gradient, float"};
  for (int i = 0; i < 4; ++i) curves[i].name = names[i];
  using Meshes = std::vector<std::size_t>;
  for (const std::size_t per_axis :
       context.quick ? Meshes{20, 80, 320} : Meshes{20, 40, 80, 160, 320, 640}) {
    const auto s = make_setting<2>(CloudKind::jittered, per_axis, context.quick ? 200 : 2000);
    const auto k = static_cast<std::size_t>(2 * recon::monomial_count(2, degree) + 1);
    const recon::Options options{.degree = degree, .neighbours = recon::Nearest{k}};
    const std::string name = "degree " + std::to_string(degree) + ", " + std::to_string(per_axis) +
                             " particles per axis";
    const auto fine = accuracy_of(name + ", double", s, options);
    const auto coarse = accuracy_of(name + ", float", rounded_setting<float>(s), options);
    floors.table.add({std::to_string(degree), number(s.spacing), number(fine.rms_value),
                      number(coarse.rms_value), number(fine.rms_gradient),
                      number(coarse.rms_gradient), number(coarse.reduced)});
    const double errors[] = {fine.rms_value, coarse.rms_value, fine.rms_gradient,
                             coarse.rms_gradient};
    for (int i = 0; i < 4; ++i) {
      curves[i].x.push_back(s.spacing);
      curves[i].y.push_back(errors[i]);
    }
  }
  if (degree == 2) floors.plot.curves.assign(curves, curves + 4);
}

}  // namespace

Section precision_study(const Context& context) {
  Table table("accuracy_precision", {"degree", "solver", "precision", "RMS error",
                                     "RMS gradient error", "residual", "reduced %", "handed over %",
                                     "construct us", "construct us parallel", "apply us", "bytes"});
  const auto s = make_setting<3>(CloudKind::random, 20, context.quick ? 300 : 4000);
  add_rows<double>(context, s, table);
  add_rows<float>(context, s, table);
  Floors floors;
  floors.plot =
      log_log_plot("2-D, jittered particles, degree 2", "particle spacing / width of the domain",
                   "RMS error (value: field of size 1; gradient: 1/length)");
  for (const int degree : {1, 2, 4}) find_floor(context, degree, floors);
  Section section{
      "Float or double",
      "First table: 3-D, random particles, the nearest 2 terms + 1. Second: 2-D, jittered "
      "particles, finer and finer; data and coordinates are rounded to float, too.",
      {table, floors.table},
      {}};
  add_picture(section, context, "accuracy_precision", floors.plot);
  return section;
}

}  // namespace recon_bench
