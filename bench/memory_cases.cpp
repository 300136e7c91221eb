// Bytes of heap per target.
#include <optional>

#include "cloud.hpp"
#include "hand_written.hpp"
#include "lab.hpp"
#include "memory.hpp"

namespace recon_bench {
namespace {

constexpr double beyond_goal = 32;  // bytes

constexpr recon::Solver solvers[] = {recon::Solver::moment_matrix, recon::Solver::gram_schmidt};

template <int D, int Degree>
void measure(Lab& lab, const CloudSetting& setting, Table& table) {
  const Cloud<double, D> cloud(lab.context.smoke ? smoke_cloud_size : cloud_size);
  const double targets = static_cast<double>(cloud.targets.size());
  const auto row = [&](const std::string& what, const HeapUse& use) {
    table.add({setting.name(), what, number(static_cast<double>(use.peak) / targets),
               number(static_cast<double>(use.after) / targets)});
  };
  std::optional<recon::Reconstruction> fit;
  for (const recon::Solver solver : solvers) {
    const ReconCall call{.degree = Degree,
                         .k = static_cast<std::size_t>(setting.k),
                         .threads = lab.context.threads,
                         .solver = solver};
    const std::string with = " " + std::string(name_of(solver));
    // The list is made inside, for it becomes part of the operator.
    const auto list = call.find(cloud);
    row("recon construct" + with, heap_use([&] { fit.emplace(call.construct(cloud, list)); }));
    fit.reset();
    const HeapUse all = heap_use([&] { fit.emplace(call.reconstruct(cloud)); });
    row("recon all" + with, all);
    if (solver == recon::Solver::moment_matrix) {
      const double entries = 12 * static_cast<double>(fit->values().entries()) / targets;
      const double beyond = static_cast<double>(all.after) / targets - entries;
      lab.summary.at_most(setting.name(), "memory kept per target beyond entries of 12 bytes",
                          beyond, beyond_goal, beyond / beyond_goal, 1);
    }
    fit.reset();
  }
  hand_written::Neighbours<double> list;
  hand_written::Array<double> phi;
  row("hand all", heap_use([&] {
        list = hand_written::search<double, D>(cloud.sources, cloud.targets, setting.k,
                                               lab.context.threads);
        phi = hand_written::construct<double, D, Degree>(cloud.sources, cloud.targets, list,
                                                         lab.context.threads);
      }));
}

}  // namespace

Section run_memory(Lab& lab) {
  progress("memory");
  Section section{
      "Memory",
      "Bytes of heap per target of the cloud (100,000 targets; 200,000 sources, whose copies count "
      "too), beyond the caller's own points and field: the most at once, and what stays. The "
      "neighbour "
      "list that construct is given is counted, as it becomes part of the operator.",
      {},
      {}};
  Table table("memory", {"workload", "what", "peak bytes per target", "kept bytes per target"});
  measure<3, 2>(lab, cloud_settings[0], table);
  measure<3, 1>(lab, cloud_settings[1], table);
  measure<2, 2>(lab, cloud_settings[2], table);
  measure<2, 1>(lab, cloud_settings[3], table);
  section.tables = {table};
  return section;
}

}  // namespace recon_bench
