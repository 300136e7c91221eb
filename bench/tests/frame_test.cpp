// The frame of the benchmarks: what it writes, what it calls met, and what it does with nonsense.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "checks.hpp"
#include "memory.hpp"
#include "report.hpp"
#include "summary.hpp"
#include "timing.hpp"

namespace recon_bench {
namespace {

namespace fs = std::filesystem;

const double nan = std::nan("");

// An empty folder, removed at the end.
class BenchFrame : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::path(testing::TempDir()) /
             ("recon_bench_" +
              std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  static void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
  static std::string read(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }

  fs::path folder;
};

TEST_F(BenchFrame, TablesSurviveCsv) {
  Table table("words", {"a", "b"});
  table.add({"plain", "with, comma"});
  table.add({"", "two words"});
  table.write_csv(folder);
  const Table again = read_table(folder / "words.csv");
  EXPECT_EQ(again.columns(), table.columns());
  EXPECT_EQ(again.rows(), table.rows());
  EXPECT_THROW(table.add({"one cell"}), std::invalid_argument);
  EXPECT_THROW(read_table(folder / "missing.csv"), std::runtime_error);
}

TEST_F(BenchFrame, RatiosArePairwise) {
  // The second round ran on a machine three times as slow: no ratio may notice.
  const Times fast{{1, 3, 1}}, slow{{2, 6, 2}};
  EXPECT_DOUBLE_EQ(speedup(fast, slow), 2);
  EXPECT_DOUBLE_EQ(slow.best(), 2);
  EXPECT_DOUBLE_EQ(median_of({4, 1, 3, 2}), 2.5);
  EXPECT_TRUE(std::isnan(median_of({})));
  EXPECT_TRUE(std::isnan(speedup(Times{}, slow)));
  EXPECT_TRUE(std::isnan(Times{}.best()));
}

TEST_F(BenchFrame, WhatIsNotMeasuredIsNotMet) {
  Summary summary;
  summary.at_least("w", "ratio", 1, 5, 5, 5);
  summary.at_least("w", "ratio", nan, nan, nan, 5);
  summary.at_most("w", "share", 1, 1, 1.6, 1.5);
  summary.at_most("w", "share", nan, nan, nan, 1.5);
  summary.note("w", "other", 1, 2, 2);
  EXPECT_EQ(summary.aims(), 4);
  EXPECT_EQ(summary.met(), 1);
  EXPECT_EQ(summary.table().rows()[0].back(), "yes");
  EXPECT_EQ(summary.table().rows()[1].back(), "no");
  EXPECT_EQ(summary.table().rows()[4].back(), "-");
  const std::vector<std::string> columns{"workload", "quantity", "recon", "reference",
                                         "ratio",    "goal",     "met"};
  EXPECT_EQ(summary.table().columns(), columns);
}

TEST_F(BenchFrame, NonsenseIsAWrongAnswer) {
  Checks checks;
  EXPECT_TRUE(checks.within(0.5, "good"));
  EXPECT_FALSE(checks.within(1.5, "too far"));
  EXPECT_FALSE(checks.within(nan, "not a number"));
  EXPECT_EQ(checks.done(), 3);
  EXPECT_EQ(checks.failures().size(), 2u);
  EXPECT_DOUBLE_EQ(checks.worst(), 0.5);
}

TEST_F(BenchFrame, ContestsRunInTurn) {
  Context context;
  context.quick = true;
  Stopwatch stopwatch(context);
  std::string order;
  int prepared = 0;
  const auto work = [&](char name) {
    return [&order, name] {
      order += name;
      volatile double x = 0;
      for (int i = 0; i < 20000000; ++i) x = x + 1;
    };
  };
  const auto times =
      stopwatch.run("turns", {{"a", work('a'), [&] { ++prepared; }}, {"b", work('b')}}, 0.01);
  ASSERT_EQ(times.size(), 2u);
  EXPECT_GE(times[0].seconds.size(), 3u);
  EXPECT_EQ(times[0].seconds.size(), times[1].seconds.size());
  EXPECT_GT(times[0].best(), 0);
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i % 2 ? 'b' : 'a') << order;
  EXPECT_EQ(2 * static_cast<std::size_t>(prepared), order.size());
  stopwatch.write_json(folder / "speed.json");
  const std::string json = read(folder / "speed.json");
  EXPECT_NE(json.find("turns/a"), std::string::npos);
  EXPECT_NE(json.find("turns/b"), std::string::npos);
}

TEST_F(BenchFrame, ADraftAppearsWholeOrNotAtAll) {
  const fs::path target = folder / "results";
  fs::create_directories(target);
  write(target / "report.md", "old");
  fs::path draft_folder;
  {
    Draft draft(target);
    draft_folder = draft.folder();
    write(draft.folder() / "report.md", "half");
  }
  EXPECT_EQ(read(target / "report.md"), "old");
  EXPECT_FALSE(fs::exists(draft_folder));
  {
    Draft draft(target);
    write(draft.folder() / "report.md", "new");
    draft.publish();
  }
  EXPECT_EQ(read(target / "report.md"), "new");
  EXPECT_FALSE(fs::exists(draft_folder));
}

TEST_F(BenchFrame, HeapIsCounted) {
  std::vector<double> kept;
  const HeapUse use = heap_use([&] {
    const std::vector<double> passing(100000);
    kept.resize(50000 + static_cast<std::size_t>(passing[0]));
  });
  EXPECT_NEAR(static_cast<double>(use.peak), 1.2e6, 1e4);
  EXPECT_NEAR(static_cast<double>(use.after), 4e5, 1e4);
}

}  // namespace
}  // namespace recon_bench
