#include "verification.hpp"

#include <cctype>

#include "example_problems.hpp"

namespace recon::program {
namespace {

std::string file_name(std::string figure) {
  for (char& c : figure)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return figure;
}

template <class Plot>
std::string drawn(const VerifyOptions& options, const std::string& figure, const Plot& plot) {
  if (options.out.empty()) return "";
  const std::string name = file_name(figure) + ".png";
  try {
    draw(std::filesystem::path(options.out) / picture_folder / name, plot);
  } catch (const FileError& error) {
    return std::string("(no picture: ") + error.what() + ")\n\n";
  }
  return "![" + figure + "](" + picture_folder + "/" + name + ")\n\n";
}

}  // namespace

std::string verdict_of(int kept, int all) {
  return kept == all ? "holds" : kept > 0 ? "holds partly" : "does not reproduce";
}

mpm::AnyProblem load(const std::string& name, std::vector<std::string> settings,
                     std::span<const std::string> more) {
  settings.insert(settings.end(), more.begin(), more.end());
  return mpm::read_problem_text(example_problem(name), name + ".toml", settings);
}

std::string picture(const VerifyOptions& options, const std::string& figure, const LinePlot& plot) {
  return drawn(options, figure, plot);
}
std::string picture(const VerifyOptions& options, const std::string& figure, const HeatMap& map) {
  return drawn(options, figure, map);
}

}  // namespace recon::program
