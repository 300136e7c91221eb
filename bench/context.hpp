// What every study is told, and where its results go.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "table.hpp"

namespace recon_bench {

struct Context {
  bool quick = false;  // everything within two minutes: smaller workloads, fewer repetitions
  int threads = 2;
  std::filesystem::path out = "out/bench";
  bool smoke = false;  // every case once on a tiny workload, for its checks; times mean nothing
};

// One part of the report: a title, a few sentences, tables and pictures (file names in
// Context::out, without suffix: <name>.png and <name>.svg).
struct Section {
  std::string title, text;
  std::vector<Table> tables;
  std::vector<std::string> pictures;
};

}  // namespace recon_bench
