// Runs the built program in an empty folder of the test's own, and looks at what it
// says and leaves.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "recon/io/read.hpp"

namespace recon::test {

struct Outcome {
  int code = -1;
  std::string out, err;
};

class ProgramTest : public testing::Test {
 protected:
  explicit ProgramTest(std::string name = "recon", std::string program = RECON_PROGRAM)
      : name_(std::move(name)), program_(std::move(program)) {
    std::string pattern = (std::filesystem::temp_directory_path() / "recon-test-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~ProgramTest() override { std::filesystem::remove_all(folder_); }

  // `arguments` as a shell reads them; $CHUTE is the example dump.
  Outcome run(const std::string& arguments) const {
    return shell("exec '" + program_ + "' " + arguments);
  }
  // The program's file, for commands of the shell.
  const std::string& program() const { return program_; }
  Outcome shell(const std::string& words) const {
    const std::string command = "cd '" + folder_.string() + "' || exit; CHUTE='" + chute() +
                                "'; exec > .stdout 2> .stderr; " + words;
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(".stdout"), read(".stderr")};
  }

  // Runs what must succeed, and say nothing on the standard error but how far it is, where it is slow.
  std::string succeed(const std::string& arguments) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 0) << name_ << " " << arguments << "\n" << outcome.err;
    static const std::regex progress("[a-z ]*: +[0-9]+ %, about [0-9]+ s left\n");
    EXPECT_EQ(std::regex_replace(outcome.err, progress, ""), "") << name_ << " " << arguments;
    return outcome.out;
  }

  // Runs what must fail with this code and message, and leave no file but the inputs.
  void expect_failure(const std::string& arguments, int code,
                      const testing::Matcher<const std::string&>& message) const {
    const std::vector<std::string> before = files();
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, code) << name_ << " " << arguments << "\n" << outcome.err;
    EXPECT_THAT(outcome.err, testing::StartsWith(name_ + ": ")) << name_ << " " << arguments;
    EXPECT_THAT(outcome.err, message) << name_ << " " << arguments;
    EXPECT_EQ(files(), before) << name_ << " " << arguments;
  }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  std::string read(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }
  std::string first_line(const std::string& name) const {
    return read(name).substr(0, read(name).find('\n'));
  }
  ParticleTable table(const std::string& name) const { return read_particles(folder_ / name); }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  // Names in the folder, but for the program's output.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      if (entry.path().filename().string()[0] != '.' || entry.path().extension() == ".tmp")
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  static std::string chute() {
    return std::string(RECON_SOURCE_DIR) + "/examples/data/chute.dump.gz";
  }
  static bool has_gnuplot() { return std::system("command -v gnuplot > /dev/null 2>&1") == 0; }

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::string name_, program_;
  std::filesystem::path folder_;
};

}  // namespace recon::test
