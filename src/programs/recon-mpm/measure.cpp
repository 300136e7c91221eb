#include "measure.hpp"

#include <algorithm>
#include <filesystem>

#include "example_problems.hpp"
#include "programs/common/text.hpp"
#include "recon/core/error.hpp"

namespace recon::program {
namespace {

constexpr const char* words[] = {"free", "raise"};

bool is_word(const std::string& setting) {
  const std::string key = setting.substr(0, setting.find('='));
  return std::find(std::begin(words), std::end(words), key) != std::end(words);
}

template <class Plot>
void draw_in(const Request& request, const Plot& plot, const std::string& title) {
  if (request.folder.empty()) return;
  const std::string name = request.name + (title.empty() ? "" : "_" + title) + ".png";
  try {
    recon::draw(std::filesystem::path(request.folder) / name, plot);
  } catch (const std::exception&) {  // no gnuplot: the numbers are what counts
  }
}

}  // namespace

std::vector<std::string> Request::settings() const {
  std::vector<std::string> all;
  for (const auto* list : {&study.settings, &variant.settings})
    for (const std::string& each : *list)
      if (!is_word(each)) all.push_back(each);
  all.push_back("method.name=" + method);
  all.push_back("grid.cells=" + std::to_string(grid));
  all.push_back("threads=" + std::to_string(threads));
  return all;
}

bool Request::has_word(const std::string& word) const {
  const auto& all = variant.settings;
  return std::find(all.begin(), all.end(), word) != all.end();
}

std::optional<double> Request::word_value(const std::string& word) const {
  for (const std::string& each : variant.settings)
    if (each.starts_with(word + "=")) return to_number(each.substr(word.size() + 1));
  return {};
}

mpm::AnyProblem Request::load(std::vector<std::string> more) const {
  std::vector<std::string> all = settings();
  all.insert(all.end(), more.begin(), more.end());
  return mpm::read_problem_text(example_problem(study.problem), study.problem + ".toml", all);
}

void Request::draw(const LinePlot& plot, const std::string& title) const {
  draw_in(*this, plot, title);
}
void Request::draw(const HeatMap& map, const std::string& title) const {
  draw_in(*this, map, title);
}

Measure measure_of(const std::string& kind) {
  for (const auto measures : {convergence_measures(), account_measures(), bending_measures(),
                              fit_measures(), stability_measures(), probe_measures()})
    for (const NamedMeasure& each : measures)
      if (kind == each.kind) return each.measure;
  recon::detail::throw_invalid("kind of a study", kind, "is unknown");
}

}  // namespace recon::program
