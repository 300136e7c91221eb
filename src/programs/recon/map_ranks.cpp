#include "map_ranks.hpp"

#ifdef RECON_PROGRAMS_HAVE_RANKS

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <optional>

#include "frames.hpp"
#include "outputs.hpp"
#include "piece_files.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/started.hpp"
#include "programs/common/text.hpp"
#include "recon/io/write.hpp"
#include "recon/petsc/reconstruct.hpp"
#include "source.hpp"
#include "summary.hpp"

namespace recon::program {

namespace {

namespace fs = std::filesystem;

// Brings rows of `width` numbers to the ranks that `owner` names; they come in the order of the
// ranks that had them.
std::vector<double> bring(const petsc::Communicator& all, const std::vector<double>& rows,
                          std::size_t width, const std::vector<int>& owner) {
  const auto ranks = static_cast<std::size_t>(all.size());
  std::vector<int> sent(ranks, 0), got(ranks), from(ranks + 1, 0), to(ranks + 1, 0);
  for (const int one : owner) ++sent[static_cast<std::size_t>(one)];
  MPI_Alltoall(sent.data(), 1, MPI_INT, got.data(), 1, MPI_INT, all.get());
  std::partial_sum(sent.begin(), sent.end(), from.begin() + 1);
  std::partial_sum(got.begin(), got.end(), to.begin() + 1);
  std::vector<double> in_order(rows.size()), brought(static_cast<std::size_t>(to.back()) * width);
  std::vector<int> next(from);
  for (std::size_t row = 0; row < owner.size(); ++row)
    std::copy_n(
        &rows[row * width], width,
        &in_order[static_cast<std::size_t>(next[static_cast<std::size_t>(owner[row])]++) * width]);
  MPI_Datatype whole_row;
  MPI_Type_contiguous(static_cast<int>(width), MPI_DOUBLE, &whole_row);
  MPI_Type_commit(&whole_row);
  MPI_Alltoallv(in_order.data(), sent.data(), from.data(), whole_row, brought.data(), got.data(),
                to.data(), whole_row, all.get());
  MPI_Type_free(&whole_row);
  return brought;
}

// What is found by default from all particles at once, and what fits across ranks do not have.
void require_possible(const MapOptions& options, const std::string& ranks) {
  std::vector<std::string> missing, beyond;
  if (!options.spacing) missing.push_back("--spacing H");
  if (!options.fit.k && !options.fit.radius) missing.push_back("--radius R (or --k K)");
  if (options.fit.max_distance != "none") missing.push_back("--max-distance none");
  if (!missing.empty())
    fail_usage("on " + ranks + " say also " + enumeration(missing) +
               ": the defaults are found from all particles at once");
  if (is_series(options.input)) beyond.push_back("several frames");
  if (options.average) beyond.push_back("--average");
  if (options.targets != "grid") beyond.push_back("--targets");
  if (!options.picture.file.empty()) beyond.push_back("--picture");
  if (options.json) beyond.push_back("--json");
  if (options.input.file == "-") beyond.push_back("the standard input");
  if (options.fit.unsupported == "nearest") beyond.push_back("--unsupported nearest");
  if (!beyond.empty())
    fail_usage(enumeration(beyond) + " is for one process; this one was started with others, on " +
               ranks);
  if (options.outputs.size() != 1 || fs::path(options.outputs[0]).extension() != ".pvti")
    fail_usage("on " + ranks + " one --out FILE.pvti is written, and a .vti file of each rank");
}

// The planes of nodes of a rank, across the axis with most nodes: `begin` to `end`, and one more for
// the cells between it and the next rank.
struct Slab {
  int axis = 0;
  std::size_t begin = 0, end = 0, shown = 0;

  Slab(const StructuredGrid<double>& grid, int rank, int ranks) {
    for (int d = 1; d < grid.dimension; ++d)
      if (grid.counts[d] > grid.counts[axis]) axis = d;
    const std::size_t n = grid.counts[axis], r = static_cast<std::size_t>(rank);
    begin = n * r / static_cast<std::size_t>(ranks);
    end = n * (r + 1) / static_cast<std::size_t>(ranks);
    shown = begin == end ? end : std::min(end + 1, n);
  }
  GridPiece piece(const StructuredGrid<double>& grid, std::size_t from, std::size_t to) const {
    GridPiece one;
    for (int d = 0; d < grid.dimension; ++d) one.counts[d] = grid.counts[d];
    one.first[axis] = from;
    one.counts[axis] = to - from;
    return one;
  }
};

// Each particle to the rank whose slab it lies in, so that others need it only beside its borders.
// What is not used any more does not go with it.
void bring_home(const petsc::Communicator& ranks, const StructuredGrid<double>& grid, int axis,
                const MapOptions& options, const FieldPlan& plan, Particles& particles) {
  std::vector<std::string> names = particles.axes;
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const PlannedField& field : plan)
    for (const std::string& column : field.columns) add(column);
  if (!options.fit.weight_by.empty()) add(options.fit.weight_by);
  const std::size_t width = names.size(), own = particles.size();
  std::vector<double> rows(own * width);
  for (std::size_t c = 0; c < width; ++c) {
    const std::vector<double>& column = particles.table.column(names[c]);
    for (std::size_t p = 0; p < own; ++p) rows[p * width + c] = column[p];
  }
  std::vector<int> owner(own);
  for (std::size_t p = 0; p < own; ++p) {
    const double plane =
        (rows[p * width + static_cast<std::size_t>(axis)] - grid.origin[axis]) / grid.spacing[axis];
    const auto planes = static_cast<double>(grid.counts[axis]);
    owner[p] = static_cast<int>(std::clamp(plane / planes, 0.0, 1.0) * ranks.size());
    owner[p] = std::min(owner[p], ranks.size() - 1);
  }
  const std::vector<double> brought = bring(ranks, rows, width, owner);
  ParticleTable home;
  home.source = particles.table.source;
  home.step = particles.table.step;
  home.time = particles.table.time;
  home.remarks = particles.table.remarks;
  for (std::size_t c = 0; c < width; ++c) {
    std::vector<double> column;
    column.reserve(brought.size() / width);
    for (std::size_t at = c; at < brought.size(); at += width) column.push_back(brought[at]);
    home.add_column(names[c], std::move(column));
  }
  home.set_coordinates(particles.axes);
  particles.table = std::move(home);
}

// Columns that hold text in some of the parts.
std::vector<std::string> text_in_some_parts(const Everyone& ranks, const ParticleTable& table) {
  const std::vector<std::string> here = table.text_columns();
  std::vector<std::string> all = table.names(), found;
  all.insert(all.end(), here.begin(), here.end());
  std::sort(all.begin(), all.end());
  for (const std::string& name : all)
    if (ranks.sum(std::find(here.begin(), here.end(), name) != here.end() ? 1 : 0) > 0)
      found.push_back(name);
  return found;
}

// Nodes of a piece, the first axis fastest, as the whole grid has them to the bit.
struct PieceNodes {
  std::array<std::vector<double>, max_dimension> x;
  std::vector<std::size_t> plane;  // along the axis of the slab

  PieceNodes(const StructuredGrid<double>& grid, const GridPiece& piece, int axis) {
    std::array<std::size_t, max_dimension> i{};
    for (std::size_t n = 0; n < piece.size(); ++n) {
      for (int d = 0; d < grid.dimension; ++d)
        x[d].push_back(grid.coordinate(piece.first[d] + i[d], d));
      plane.push_back(piece.first[axis] + i[axis]);
      for (int d = 0; d < max_dimension && ++i[d] == piece.counts[d]; ++d) i[d] = 0;
    }
  }
};

// Sums and extremes of the summaries of all ranks.
FitSummary of_all(const Everyone& ranks, const FitSummary& own) {
  FitSummary all;
  for (const auto count :
       {&FitSummary::targets, &FitSummary::full, &FitSummary::reduced, &FitSummary::nearest,
        &FitSummary::no_support, &FitSummary::too_far, &FitSummary::handed_over})
    all.*count = ranks.sum(own.*count);
  const double neighbours = own.mean_neighbours * static_cast<double>(own.targets);
  all.mean_neighbours =
      static_cast<double>(ranks.sum(static_cast<std::size_t>(std::llround(neighbours)))) /
      static_cast<double>(all.targets);
  const double fewest = own.targets > 0 ? static_cast<double>(own.fewest_neighbours)
                                        : std::numeric_limits<double>::max();
  all.fewest_neighbours = static_cast<std::size_t>(ranks.least(fewest));
  all.most_neighbours =
      static_cast<std::size_t>(ranks.greatest(static_cast<double>(own.most_neighbours)));
  all.smallest_pivot = ranks.least(own.smallest_pivot);
  all.largest_amplification = ranks.greatest(own.largest_amplification);
  return all;
}

// The range of the values of all ranks that count.
FieldRange of_all(const Everyone& ranks, const NamedField& field, int component,
                  const std::vector<bool>& counts) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  FieldRange range{infinity, -infinity};
  const FieldView<double> values = field.view();
  for (std::size_t t = 0; t < counts.size(); ++t) {
    if (!counts[t]) continue;
    const double value = values(t, component);
    range.missing += std::isnan(value) ? 1 : 0;
    range.least = std::fmin(range.least, value);
    range.greatest = std::fmax(range.greatest, value);
  }
  return {ranks.least(range.least), ranks.greatest(range.greatest), ranks.sum(range.missing)};
}

}  // namespace

void map_on_ranks(const MapOptions& options, const Method& method, const Launch& launch) {
  const Everyone& ranks = launch.everyone();
  ranks.together(
      [&] { require_possible(options, counted(static_cast<std::size_t>(ranks.size()), "rank")); });
  const fs::path out = options.outputs[0];
  ranks.together([&] {
    if (ranks.rank() == 0) check_files(options.outputs, inputs_of(options));
  });
  const PieceFiles files(out, ranks);

  ParticleTable read;
  ranks.together([&] {
    ReadOptions how = read_options(options.input);
    how.part = ranks.rank();
    how.parts = ranks.size();
    read = with_exit_code(wrong_input, [&] { return read_source(options.input.file, how); });
  });
  require_same_input(ranks, options.input.file);
  Particles particles = make_particles(std::move(read), options.input, ranks);
  particles.text_elsewhere = text_in_some_parts(ranks, particles.table);
  ranks.together([&] { check_weight_by(options.fit, particles); });
  FieldPlan plan;
  ranks.together([&] { plan = plan_fields(particles, options.fields, options.components); });
  FitOptions fit;
  StructuredGrid<double> grid;
  ranks.together([&] {
    if (has_sums(plan))
      fail_usage("density, number_density and solid_fraction are for one process");
    grid = with_exit_code(wrong_usage, [&] {
      return covering_grid(particles.region, *options.spacing, particles.grid_domain);
    });
    if (!std::is_sorted(particles.letters.begin(), particles.letters.end()) ||
        !std::string("xyz").starts_with(particles.letters))
      fail_usage("coordinates other than x, x,y or x,y,z are for one process");
  });

  const std::size_t read_here = particles.size();
  const Slab slab(grid, ranks.rank(), ranks.size());
  bring_home(launch.ranks(), grid, slab.axis, options, plan, particles);
  ranks.together([&] {
    fit = fit_options(options.fit, method, particles);
    fit.threads = threads_of_a_rank(fit.threads);
  });

  // Some targets at a time, so that memory does not grow with them; each time costs an index of the
  // particles.
  const std::size_t plane = grid.size() / grid.counts[slab.axis];
  const std::size_t most_targets = std::max<std::size_t>(200'000, particles.size());
  const std::size_t step = std::max<std::size_t>(1, most_targets / plane);
  const auto turns = static_cast<std::size_t>(ranks.greatest(
      std::ceil(static_cast<double>(slab.shown - slab.begin) / static_cast<double>(step))));
  Progress progress("mapping", turns, options.quiet || ranks.rank() > 0);
  std::optional<MappedFields> made;
  ranks.together(
      [&] { made.emplace(particles, plan, options.gradient, (slab.shown - slab.begin) * plane); });
  MappedFields& fields = *made;
  std::vector<bool>
      counts;  // of each target: whether it is not of the plane that the next rank has
  for (std::size_t turn = 0; turn < turns; ++turn) {
    const std::size_t from = std::min(slab.begin + turn * step, slab.shown);
    const std::size_t to = std::min(from + step, slab.shown);
    // What recon::petsc refuses on one rank, it refuses on all.
    ranks.together([&] {
      const PieceNodes nodes(grid, slab.piece(grid, from, to), slab.axis);
      const petsc::Reconstruction at(launch.ranks().get(), particles.positions(),
                                     points_of_axes(nodes.x, grid.dimension), fit);
      Eigen::MatrixXd values, slopes;
      LimitCount limited;
      limited.components.resize(nodes.plane.size());
      if (const auto& data = fields.data()) {
        values = at.apply(data->view(), {.limit = fit.limit, .count = &limited});
        if (options.gradient) slopes = at.gradient().apply(data->view());
      }
      fields.add(at.report().all(), values, slopes, limited);
      for (const std::size_t at_plane : nodes.plane) counts.push_back(at_plane < slab.end);
    });
    progress.advance(1);
  }
  const std::size_t components =
      fields.data() ? static_cast<std::size_t>(fields.data()->components) : 0;
  const Mapped mapped = fields.result(method.solver);

  files.write(
      slab.begin < slab.end,
      [&](const fs::path& piece) {
        write_vti_piece(piece, grid, slab.piece(grid, slab.begin, slab.shown), mapped.fields);
      },
      [&] {
        std::vector<GridPieceFile> pieces;
        for (int rank = 0; rank < ranks.size(); ++rank)
          if (const Slab its(grid, rank, ranks.size()); its.begin < its.end)
            pieces.push_back({its.piece(grid, its.begin, its.shown), piece_name(out, rank)});
        write_pvti(out, grid, pieces, mapped.fields);
      });

  std::vector<FitReport> own;
  LimitCount limited;
  for (std::size_t t = 0; t < counts.size(); ++t) {
    if (!counts[t]) continue;
    own.push_back(mapped.reports[t]);
    limited.components.push_back(mapped.limited.components[t]);
  }
  limited.total();
  limited.targets = ranks.sum(limited.targets);
  limited.values = ranks.sum(limited.values);
  const FitSummary summary = of_all(ranks, FitReports(std::move(own), method.solver).summary());
  std::vector<FieldRange> found;
  for (const NamedField& field : mapped.fields) {
    if (field.name == report_names().front()) break;
    for (int c = 0; c < field.components; ++c) found.push_back(of_all(ranks, field, c, counts));
  }
  const auto particles_of = [&](bool most) {
    const auto own_count = static_cast<double>(read_here);
    return count(
        static_cast<std::size_t>(most ? ranks.greatest(own_count) : ranks.least(own_count)));
  };
  const std::string least = particles_of(false), most = particles_of(true);
  if (options.quiet || ranks.rank() > 0) return;
  std::printf("%s\n", particles.describe().c_str());
  print_remarks(particles.table);
  print_line("ranks", std::to_string(ranks.size()) + ", which have read " +
                          (least == most ? least : least + " to " + most) + " particles each");
  print_line("method", describe_method(method, options.fit));
  print_line("support", describe_support(options.fit, method, particles, false));
  print_line("targets", "grid of " + counted(grid.size(), "node"));
  const std::size_t valued = summary.targets - summary.no_support - summary.too_far;
  print_fit(summary, limited, components * valued, options.fit);
  std::size_t next = 0;
  print_fields(
      mapped.fields, [&](const NamedField&, int) { return found[next++]; }, grid.size());
  print_line("time", number(progress.seconds(), 2) + " s");
  print_written({out.string()}, "and a .vti file of each rank beside it");
}

}  // namespace recon::program

#else

namespace recon::program {

void map_on_ranks(const MapOptions&, const Method&, const Launch&) {}  // there are none

}  // namespace recon::program

#endif
