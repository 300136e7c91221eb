// Other programs (bench/peers.py runs them), and recon on the same points beside them.
#include <cmath>
#include <optional>

#include "cloud.hpp"
#include "lab.hpp"
#include "report.hpp"

namespace recon_bench {
namespace {

constexpr CloudSetting settings[] = {{3, 0, 8}, {3, 0, 20}, {3, 1, 8}, {3, 1, 20}, {3, 2, 20}};

void add_recon(Lab& lab, const Cloud<double, 3>& cloud, const CloudSetting& setting, Table& table) {
  const ReconCall call{.degree = setting.degree,
                       .k = static_cast<std::size_t>(setting.k),
                       .threads = lab.context.threads};
  std::optional<recon::Reconstruction> fit;
  std::vector<double> out(cloud.targets.size());
  const std::vector<Contestant> all{{"recon",
                                     [&] {
                                       fit.emplace(call.reconstruct(cloud));
                                       fit->apply(recon::field_of(cloud.u), recon::field_of(out));
                                     },
                                     [&] { fit.reset(); }}};
  const auto times = lab.stopwatch.run("peers/recon " + setting.name(), all, 0.1);
  double sum = 0;
  for (std::size_t t = 0; t < out.size(); ++t)
    sum += std::pow(out[t] - Cloud<double, 3>::field(cloud.targets[t]), 2);
  const double targets = static_cast<double>(out.size());
  table.add({"recon", "degree " + std::to_string(setting.degree) + ", gram_schmidt",
             std::to_string(cloud.sources.size()), std::to_string(cloud.targets.size()),
             std::to_string(setting.k), number(times[0].best() / targets * 1e6),
             number(std::sqrt(sum / targets)),
             "search included; " + std::to_string(lab.context.threads) + " threads"});
}

}  // namespace

Section run_peers(Lab& lab, const std::string& file) {
  progress("recon beside other programs");
  Section section{
      "Other programs",
      "Measured by bench/peers.py on the sources of the 3-D cloud and its targets, or the "
      "first of them; the error is that of the product of sines. What can be compared, and "
      "what not, stands in the column `note`.",
      {},
      {}};
  Table table = read_table(file);
  const Cloud<double, 3> cloud(cloud_size);
  for (const CloudSetting& setting : settings) add_recon(lab, cloud, setting, table);
  section.tables = {table};
  return section;
}

}  // namespace recon_bench
