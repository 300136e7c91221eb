// Programs as mpirun starts them.
#pragma once

#include "programs/run_program.hpp"

namespace recon::test {

class OnRanksTest : public ProgramTest {
 protected:
  using ProgramTest::ProgramTest;

  // What starts so many ranks of the words behind it.
  static std::string mpirun(int ranks) {
    return std::string("exec env " RECON_MPIRUN " ") + std::to_string(ranks) + " ";
  }
  Outcome on(int ranks, const std::string& arguments) const {
    return shell(mpirun(ranks) + "'" + program() + "' " + arguments);
  }
  // Two ranks, each with words of its own for the shell.
  Outcome each(const std::string& first, const std::string& second) const {
    return shell(mpirun(1) + first + " : -n 1 " + second);
  }
  // Two ranks of the program, in the folders 0 and 1, which this makes.
  Outcome each_in_its_folder(const std::string& arguments) const {
    for (const char* own : {"0", "1"}) std::filesystem::create_directory(folder() / own);
    const auto in = [&](const std::string& own) {
      return "sh -c 'cd " + own + " && exec \"" + program() + "\" " + arguments + "'";
    };
    return each(in("0"), in("1"));
  }
};

}  // namespace recon::test
