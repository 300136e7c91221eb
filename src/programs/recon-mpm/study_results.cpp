#include "study_results.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <set>

#include "example_problems.hpp"
#include "programs/common/text.hpp"
#include "recon/io/atomic_file.hpp"

namespace recon::program {
namespace {

std::string plain(std::string text) {
  for (char& c : text)
    if (c == '\t' || c == '\n') c = ' ';
  return text;
}

}  // namespace

ResultFile::ResultFile(const std::filesystem::path& folder, const Study& study) : study_(&study) {
  if (folder.empty()) return;
  path_ = folder / (study.name + ".txt");
  if (std::filesystem::exists(path_)) read();
}

std::string ResultFile::mark(const std::string& variant) const {
  std::string text = study_->kind + "\n" + study_->norm + "\n";
  if (!study_->problem.empty()) text += example_problem(study_->problem);
  for (const std::string& each : study_->settings) text += "\n" + each;
  for (const Variant& each : study_->variants)
    if (each.name == variant)
      for (const std::string& setting : each.settings) text += "\n" + setting;
  for (const Probe& each : study_->probes) {
    text += "\n" + each.name + "\n" + each.of + "\n" + each.component + "\n" + each.take;
    for (const double value : {static_cast<double>(each.body), each.from, each.until, each.level})
      text += "\n" + number(value, 17);
    for (const double value : each.at) text += "\n" + number(value, 17);
  }
  return hash(text);
}

void ResultFile::read() {
  std::ifstream file(path_);
  std::string line;
  for (std::size_t n = 1; std::getline(file, line); ++n) {
    if (line.starts_with("#")) continue;
    std::vector<std::string> words(1);
    for (const char c : line)
      if (c == '\t')
        words.emplace_back();
      else
        words.back() += c;
    const auto grid = words.size() == 6 ? to_number(words[3]) : std::nullopt;
    if (!grid) throw FileError(path_, n, "is no line of results");
    if (words[0] != mark(words[1])) continue;
    Measured& run = runs_[{words[1], words[2], static_cast<int>(*grid)}];
    if (words[4] == "stopped" || words[4] == "refused") {
      run.note = words[5];
      run.refused = words[4] == "refused";
    } else if (words[4] != "run")
      run.add(words[4], to_number(words[5]).value_or(std::numeric_limits<double>::quiet_NaN()));
  }
}

void ResultFile::write() const {
  if (path_.empty()) return;
  AtomicFile file(path_);
  file.write("# Results of the study " + study_->name +
             ": mark, variant, method, grid, quantity, value.\n");
  for (const auto& [key, run] : runs_) {
    const std::string start = mark(key.variant) + "\t" + key.variant + "\t" + key.method + "\t" +
                              std::to_string(key.grid) + "\t";
    file.write(start + "run\t1\n");
    for (const auto& [name, value] : run.numbers)
      file.write(start + name + "\t" + number(value, 17) + "\n");
    if (!run.note.empty())
      file.write(start + (run.refused ? "refused" : "stopped") + "\t" + plain(run.note) + "\n");
  }
  file.commit();
}

void ResultFile::add(const RunKey& key, const Measured& measured) {
  runs_[key] = measured;
  write();
}

std::vector<RunKey> runs_on(const Study& study, const std::vector<int>& grids) {
  std::vector<RunKey> runs;
  for (const Variant& variant : study.variants)
    for (const std::string& method : study.methods) {
      const auto& only = variant.methods;
      if (!only.empty() && std::find(only.begin(), only.end(), method) == only.end()) continue;
      for (const int grid : grids) runs.push_back({variant.name, method, grid});
    }
  return runs;
}

std::vector<int> joined(const std::vector<int>& a, const std::vector<int>& b) {
  std::set<int> all(a.begin(), a.end());
  all.insert(b.begin(), b.end());
  return {all.begin(), all.end()};
}

}  // namespace recon::program
