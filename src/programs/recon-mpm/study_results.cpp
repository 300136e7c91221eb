#include "study_results.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <map>
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

constexpr std::string_view no_number = "nan";  // as number() writes it

std::string line_of(const std::string& quantity, const std::string& value) {
  return quantity + "\t" + value + "\n";
}

std::string run_text(const RunKey& key) {
  return "the run of " + (key.variant.empty() ? "" : key.variant + ", ") + key.method + " on " +
         std::to_string(key.grid);
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
  const auto refuse = [&](std::size_t line, const std::string& what) {
    throw FileError(path_, line, what + ": delete its lines to have it made anew");
  };
  std::set<RunKey> known;
  for (const RunKey& key :
       runs_on(*study_, joined(study_->quick, joined(study_->paper, study_->finer))))
    known.insert(key);
  struct Written {
    std::size_t line;  // of the sum
    std::string sum, text;
  };
  std::map<RunKey, Written> written;
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
    const RunKey key{words[1], words[2], static_cast<int>(*grid)};
    if (words[0] != mark(key.variant) || !known.contains(key)) continue;
    const std::string &quantity = words[4], &value = words[5];
    if (quantity == "run") {
      if (!written.emplace(key, Written{n, value, ""}).second)
        refuse(n, run_text(key) + " stands there twice");
      runs_[key];
      continue;
    }
    const auto begun = written.find(key);
    if (begun == written.end()) refuse(n, run_text(key) + " has no beginning");
    begun->second.text += line_of(quantity, value);
    Measured& run = runs_[key];
    if (quantity == "stopped" || quantity == "refused") {
      run.note = value;
      run.refused = quantity == "refused";
    } else if (const auto number = to_number(value); number || value == no_number) {
      run.add(quantity, number.value_or(std::numeric_limits<double>::quiet_NaN()));
    } else {
      refuse(n, quantity + " of " + run_text(key) + " is no number");
    }
  }
  for (const auto& [key, each] : written)
    if (each.sum != hash(each.text)) refuse(each.line, run_text(key) + " is not as it was written");
}

void ResultFile::write() const {
  if (path_.empty()) return;
  AtomicFile file(path_);
  file.write("# Results of the study " + study_->name +
             ": mark, variant, method, grid, quantity, value; the value of a run is the sum of its "
             "lines.\n");
  for (const auto& [key, run] : runs_) {
    std::vector<std::string> lines;
    for (const auto& [name, value] : run.numbers) lines.push_back(line_of(name, number(value, 17)));
    if (!run.note.empty())
      lines.push_back(line_of(run.refused ? "refused" : "stopped", plain(run.note)));
    std::string all;
    for (const std::string& each : lines) all += each;
    const std::string start = mark(key.variant) + "\t" + key.variant + "\t" + key.method + "\t" +
                              std::to_string(key.grid) + "\t";
    file.write(start + line_of("run", hash(all)));
    for (const std::string& each : lines) file.write(start + each);
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
