// What the sections of a problem file share: the file, the problem that is being read, the
// constants, and values that are numbers or formulas.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "recon/runs/read_problem.hpp"
#include "runs/expression.hpp"
#include "runs/toml_reader.hpp"

namespace recon::mpm {

// Runs `work`; what it finds wrong is the fault of the key that it names, or else of this one.
template <class Work>
void checked(const TomlTable& table, std::string_view key, Work&& work) {
  try {
    work();
  } catch (const InvalidArgument& error) {
    table.fail(table.raw().contains(error.argument()) ? error.argument() : key, error.what());
  } catch (const std::invalid_argument& error) {
    table.fail(key, error.what());
  }
}

template <int D>
class ProblemReader {
 public:
  ProblemReader(const std::filesystem::path& path, const toml::table& root)
      : path_(path), file_(path, "", root) {}

  const std::filesystem::path& path() const { return path_; }
  const TomlTable& file() const { return file_; }
  ProblemFile<D>& out() { return out_; }
  Problem<D>& problem() { return out_.problem; }

  // The section [constants]: numbers, and formulas of other constants, in any order.
  void read_constants();

  // ProblemFile::formulas gets the text of this key.
  void note(const TomlTable& table, std::string_view key);

  Vector<D> vector(const TomlTable& table, std::string_view key) const {
    const std::vector<double> values = table.numbers(key, D);
    return Eigen::Map<const Vector<D>>(values.data());
  }
  // needed: what is said beside an error of the formula.
  Expression expression(const TomlTable& table, std::string_view key, const toml::node& node,
                        const std::string& needed = {}) const;
  // One for each axis, noted.
  std::array<Expression, D> expressions(const TomlTable& table, std::string_view key);

 private:
  std::filesystem::path path_;
  TomlTable file_;
  std::map<std::string, double> constants_;
  ProblemFile<D> out_;
};

// What an expression may depend on: reference and present position, and time.
template <int D>
Expression::Variables variables(const Vector<D>& X, const Vector<D>& x, double t) {
  Expression::Variables at{};
  for (int d = 0; d < D; ++d) {
    at[d] = X[d];
    at[3 + d] = x[d];
  }
  at[6] = t;
  return at;
}

// The sections [material] and [[body]].
template <int D>
void read_bodies(ProblemReader<D>& reader);
// The sections [[boundary]], [loads], [[point_load]] and [[pressure]], of bodies that are there.
template <int D>
void read_boundaries(ProblemReader<D>& reader);
template <int D>
void read_loads(ProblemReader<D>& reader);
// The keys of the lists of loads, by their path.
std::vector<std::string> load_keys();
// The list [[probe]], of bodies and boundaries that are there, and its keys.
template <int D>
void read_probes(ProblemReader<D>& reader);
std::vector<std::string> probe_keys();

}  // namespace recon::mpm
