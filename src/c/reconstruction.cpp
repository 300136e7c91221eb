#include <array>
#include <string_view>

#include "c/handles.hpp"
#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/operators/kernel_sum.hpp"

namespace {

using recon::c::field_of;
using recon::c::guarded;
using recon::c::made_by;
using recon::c::points_of;
using recon::c::span_of;
using recon::c::there;
using recon::detail::throw_invalid;

template <class Fit>
using ScalarOf = std::conditional_t<std::is_same_v<std::decay_t<Fit>, recon::ReconstructionF> ||
                                        std::is_same_v<std::decay_t<Fit>, recon::SourcesF>,
                                    float, double>;

template <class Map>
struct Kind;
template <class S>
struct Kind<recon::CsrOperator<S>> {
  using Scalar = S;
  static constexpr bool mixes = false;
};
template <class S>
struct Kind<recon::VectorOperator<S>> {
  using Scalar = S;
  static constexpr bool mixes = true;
};

recon::Options options_of(const recon_options* options) {
  return options ? options->finished() : recon::Options();
}

// Calls with a number of the precision of the array.
template <class Call>
void in_precision_of(const recon_array& array, Call&& call) {
  if (array.number == RECON_FLOAT)
    call(1.0F);
  else if (array.number == RECON_DOUBLE)
    call(1.0);
  else
    throw_invalid("number of an array", static_cast<int>(array.number),
                  "must be RECON_DOUBLE or RECON_FLOAT");
}

template <class Scalar>
recon::StructuredGrid<Scalar> grid_of(const recon_grid& grid) {
  recon::StructuredGrid<Scalar> out;
  out.dimension = grid.dimension;
  for (int d = 0; d < recon::max_dimension; ++d) {
    out.origin[d] = static_cast<Scalar>(grid.origin[d]);
    out.spacing[d] = static_cast<Scalar>(grid.spacing[d]);
    out.counts[d] = grid.counts[d];
  }
  out.validate();
  return out;
}

// A fit from points or Sources, with the list of the options if they have one.
template <class Scalar, class From>
void fit_from(recon_fit& made, const From& from, const recon::PointsView<Scalar>& targets,
              const recon_options* options) {
  using Fit = recon::BasicReconstruction<Scalar>;
  const recon::Options all = options_of(options);
  if (options && options->list)
    made.fit.emplace<Fit>(from, targets, recon::c::list_as<Scalar>(*options->list), all);
  else
    made.fit.emplace<Fit>(from, targets, all);
}

recon::AnyFunctional functional_named(std::string_view name) {
  using F = recon::Functional;
  if (name == "value") return F::value;
  if (name == "gradient") return F::gradient;
  if (name == "diffuse_gradient") return F::gradient.with(recon::Derivative::diffuse);
  if (name == "hessian") return F::hessian;
  if (name == "laplacian") return F::laplacian;
  if (name == "divergence") return F::divergence;
  if (name == "curl") return F::curl;
  if (name == "strain_rate") return F::strain_rate;
  recon::bindings::refuse_name(
      "operator", name,
      std::vector<std::string>{"value", "gradient", "diffuse_gradient", "hessian", "laplacian",
                               "divergence", "curl", "strain_rate"});
}

template <class Map>
int components_of(const Map& map, int of_field) {
  if constexpr (Kind<Map>::mixes)
    return of_field == map.inputs() ? map.outputs() : 0;
  else
    return of_field > 0 ? of_field * map.blocks() : 0;
}

double member(const recon::FitReport& report, std::string_view name) {
  if (name == "neighbours") return report.neighbours;
  if (name == "rank") return report.rank;
  if (name == "degree") return report.degree;
  if (name == "status") return static_cast<double>(report.status);
  if (name == "solver") return static_cast<double>(report.solver);
  if (name == "gradient_rank") return report.gradient_rank;
  if (name == "hessian_rank") return report.hessian_rank;
  if (name == "smallest_pivot") return static_cast<double>(report.smallest_pivot);
  if (name == "amplification") return static_cast<double>(report.amplification);
  return static_cast<double>(report.gradient_amplification);
}

void require_member(std::string_view name) {
  static const std::vector<std::string> all{
      "neighbours",    "rank",         "degree",         "status",        "solver",
      "gradient_rank", "hessian_rank", "smallest_pivot", "amplification", "gradient_amplification",
      "support"};
  for (const std::string& known : all)
    if (name == known) return;
  recon::bindings::refuse_name("member of the report", name, all);
}

}  // namespace

// ---- particles that are kept
// -----------------------------------------------------------------------

recon_status recon_sources_new(recon_array points, const recon_options* options,
                               recon_sources** sources) {
  return made_by(sources, [&] {
    auto made =
        std::make_unique<recon_sources>(recon_sources{recon::Sources(recon::PointsView<double>())});
    in_precision_of(points, [&]<class Scalar>(Scalar) {
      made->sources.emplace<recon::BasicSources<Scalar>>(points_of<Scalar>(points, "points"),
                                                         options_of(options).sources());
    });
    return made;
  });
}

recon_status recon_sources_update(recon_sources* sources, recon_array points,
                                  const double* particle_weights) {
  return guarded([&] {
    std::visit(
        [&](auto& own) {
          using Scalar = ScalarOf<decltype(own)>;
          const auto view = points_of<Scalar>(points, "points");
          if (particle_weights)
            own.update(view, {particle_weights, view.size()});
          else
            own.update(view);
        },
        there(sources, "sources").sources);
  });
}

size_t recon_sources_size(const recon_sources* sources) {
  return sources ? std::visit([](const auto& own) { return own.size(); }, sources->sources) : 0;
}

void recon_sources_free(recon_sources* sources) {
  delete sources;
}

recon_status recon_kernel_sum(const recon_sources* sources, recon_array targets,
                              recon_array amounts, const recon_options* options, recon_array out) {
  return guarded([&] {
    std::visit(
        [&](const auto& own) {
          using Scalar = ScalarOf<decltype(own)>;
          const recon::Options all = options_of(options);
          recon::KernelOptions kernel;
          kernel.weight = all.weight;
          if (all.form) kernel.form = *all.form;
          if (all.neighbours) kernel.support = *all.neighbours;
          kernel.search = all.search;
          kernel.threads = all.threads;
          kernel.instruction_set = all.instruction_set;
          const auto view = points_of<Scalar>(targets, "targets");
          const auto field = field_of<Scalar>(amounts, "amounts");
          recon::kernel_operator<Scalar>(own, view, kernel)
              .apply(field, span_of<Scalar>(out, view.size(), field.components()));
        },
        there(sources, "sources").sources);
  });
}

// ---- reconstructions
// ---------------------------------------------------------------------------------

recon_status recon_reconstruct(recon_array points, recon_array targets,
                               const recon_options* options, recon_fit** fit) {
  return made_by(fit, [&] {
    auto made = std::make_unique<recon_fit>();
    in_precision_of(points, [&]<class Scalar>(Scalar) {
      fit_from<Scalar>(*made, points_of<Scalar>(points, "points"),
                       points_of<Scalar>(targets, "targets"), options);
    });
    return made;
  });
}

recon_status recon_reconstruct_at_nodes(recon_array points, recon_grid grid,
                                        const recon_options* options, recon_fit** fit) {
  return made_by(fit, [&] {
    auto made = std::make_unique<recon_fit>();
    in_precision_of(points, [&]<class Scalar>(Scalar) {
      if (options && options->list)
        throw_invalid("neighbours", "a list of the caller's",
                      "must be a rule for a grid: give its nodes as targets");
      made->fit.emplace<recon::BasicReconstruction<Scalar>>(
          points_of<Scalar>(points, "points"), grid_of<Scalar>(grid), options_of(options));
    });
    return made;
  });
}

recon_status recon_reconstruct_from(const recon_sources* sources, recon_array targets,
                                    const recon_options* options, recon_fit** fit) {
  return made_by(fit, [&] {
    auto made = std::make_unique<recon_fit>();
    std::visit(
        [&](const auto& own) {
          using Scalar = ScalarOf<decltype(own)>;
          fit_from<Scalar>(*made, own, points_of<Scalar>(targets, "targets"), options);
        },
        there(sources, "sources").sources);
    return made;
  });
}

recon_status recon_fit_update(recon_fit* fit, recon_array targets) {
  return guarded([&] {
    std::visit(
        [&](auto& own) { own.update(points_of<ScalarOf<decltype(own)>>(targets, "targets")); },
        there(fit, "fit").fit);
  });
}

void recon_fit_free(recon_fit* fit) {
  delete fit;
}

size_t recon_fit_targets(const recon_fit* fit) {
  return fit ? std::visit([](const auto& own) { return own.values().rows(); }, fit->fit) : 0;
}

size_t recon_fit_particles(const recon_fit* fit) {
  return fit ? std::visit([](const auto& own) { return own.values().columns(); }, fit->fit) : 0;
}

recon_status recon_fit_apply(const recon_fit* fit, recon_array field, recon_array out) {
  return recon_fit_apply_limited(fit, field, nullptr, out);
}

recon_status recon_fit_apply_limited(const recon_fit* fit, recon_array field, const char* limit,
                                     recon_array out) {
  return guarded([&] {
    recon::Apply how;
    if (limit) how.limit = recon::bindings::limit_of(limit);
    std::visit(
        [&](const auto& own) {
          using Scalar = ScalarOf<decltype(own)>;
          const auto view = field_of<Scalar>(field);
          own.apply(view, span_of<Scalar>(out, own.values().rows(), view.components()), how);
        },
        there(fit, "fit").fit);
  });
}

recon_status recon_fit_apply_transpose(const recon_fit* fit, recon_array field, recon_array out) {
  return guarded([&] {
    std::visit(
        [&](const auto& own) {
          using Scalar = ScalarOf<decltype(own)>;
          const auto view = field_of<Scalar>(field);
          own.apply_transpose(view,
                              span_of<Scalar>(out, own.values().columns(), view.components()));
        },
        there(fit, "fit").fit);
  });
}

recon_status recon_fit_report(const recon_fit* fit, const char* name, double* out, size_t count) {
  return guarded([&] {
    const std::string_view asked = &there(name, "name");
    require_member(asked);
    std::visit(
        [&](const auto& own) {
          const recon::FitReports& reports = own.report();
          if (count != reports.size())
            throw_invalid("count", count,
                          "must be the number of targets, " + std::to_string(reports.size()));
          if (count > 0) there(out, "out");
          for (std::size_t t = 0; t < count; ++t)
            out[t] = asked == "support" ? static_cast<double>(own.support(t))
                                        : member(reports[t], asked);
        },
        there(fit, "fit").fit);
  });
}

recon_status recon_fit_operator(const recon_fit* fit, const char* name, recon_operator** op) {
  return made_by(op, [&] {
    const std::array functionals{functional_named(&there(name, "name"))};
    auto made = std::make_unique<recon_operator>();
    std::visit(
        [&](const auto& own) {
          auto all = own.operators(functionals);
          std::visit([&](auto& one) { made->op = std::move(one); }, all.front());
        },
        there(fit, "fit").fit);
    return made;
  });
}

void recon_operator_free(recon_operator* op) {
  delete op;
}

int recon_operator_components(const recon_operator* op, int of_field) {
  return op ? std::visit([&](const auto& map) { return components_of(map, of_field); }, op->op) : 0;
}

recon_status recon_operator_apply(const recon_operator* op, recon_array field, recon_array out) {
  return guarded([&] {
    std::visit(
        [&](const auto& map) {
          using Map = std::decay_t<decltype(map)>;
          using Scalar = typename Kind<Map>::Scalar;
          const auto view = field_of<Scalar>(field);
          const int components = components_of(map, view.components());
          // What does not fit the operator is refused by it, in its words.
          map.apply(view, components > 0 ? span_of<Scalar>(out, map.rows(), components)
                                         : span_of<Scalar>(out, map.rows(), out.components));
        },
        there(op, "op").op);
  });
}

recon_status recon_operator_apply_transpose(const recon_operator* op, recon_array field,
                                            recon_array out) {
  return guarded([&] {
    std::visit(
        [&](const auto& map) {
          using Scalar = typename Kind<std::decay_t<decltype(map)>>::Scalar;
          const auto view = field_of<Scalar>(field);
          map.apply_transpose(view, span_of<Scalar>(out, map.columns(), out.components));
        },
        there(op, "op").op);
  });
}

recon_status recon_operator_add(recon_operator* op, double factor, const recon_operator* other) {
  return guarded([&] {
    std::visit(
        [&](auto& left, const auto& right) {
          using Left = std::decay_t<decltype(left)>;
          if constexpr (!std::is_same_v<Left, std::decay_t<decltype(right)>>) {
            throw_invalid("operators", "of different kinds or precision",
                          "must be alike to be added");
          } else if constexpr (Kind<Left>::mixes) {
            throw_invalid("operators", "divergence, curl or strain_rate",
                          "cannot be added: they mix components");
          } else {
            Left scaled = right;
            scaled *= static_cast<typename Kind<Left>::Scalar>(factor);
            left += scaled;
          }
        },
        there(op, "op").op, there(other, "other").op);
  });
}

recon_status recon_on_grid(recon_array points, recon_array field, recon_grid grid,
                           const recon_options* options, recon_array out, const char* gradients,
                           recon_array gradients_out) {
  return guarded([&] {
    in_precision_of(points, [&]<class Scalar>(Scalar) {
      if (options && options->list)
        throw_invalid("neighbours", "a list of the caller's", "must be a rule for a grid");
      const auto nodes = grid_of<Scalar>(grid);
      const auto view = field_of<Scalar>(field);
      recon::GridApply apply;
      if (gradients) apply.gradients = recon::bindings::derivative_of(gradients);
      const auto values = span_of<Scalar>(out, nodes.size(), view.components());
      const int slopes_each = view.components() * nodes.dimension;
      const recon::FieldSpan<Scalar> slopes =
          gradients ? span_of<Scalar>(gradients_out, nodes.size(), slopes_each, "gradients_out")
                    : recon::FieldSpan<Scalar>();
      const auto made = recon::reconstruct_on_grid(points_of<Scalar>(points, "points"), {view},
                                                   nodes, options_of(options), apply);
      for (std::size_t n = 0; n < nodes.size(); ++n) {
        const auto row = static_cast<Eigen::Index>(n);
        for (int c = 0; c < view.components(); ++c) values(n, c) = made.values()(row, c);
        for (int c = 0; gradients && c < slopes_each; ++c) slopes(n, c) = made.gradients()(row, c);
      }
    });
  });
}
