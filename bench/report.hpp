// The files of a run: report.md, summary.csv, a CSV per table.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "checks.hpp"
#include "context.hpp"
#include "summary.hpp"

namespace recon_bench {

// A table read from a CSV file that bench/peers.py wrote.
Table read_table(const std::filesystem::path& file);

void write_report(const Context& context,
                  const std::vector<std::pair<std::string, std::string>>& machine,
                  const Summary& summary, const Checks& checks,
                  const std::vector<Section>& sections);

// A folder beside `target` to write into; publish() moves its files there, and the destructor
// removes it. So a run that fails leaves what was there before.
class Draft {
 public:
  explicit Draft(std::filesystem::path target);
  ~Draft();
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  void publish();

 private:
  std::filesystem::path target_, folder_;
};

}  // namespace recon_bench
