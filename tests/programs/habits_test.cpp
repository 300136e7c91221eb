// What scripts and shells ask of the programs: summaries as JSON, completion, manual pages, colours.
#include "programs/run_program.hpp"

namespace recon::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class HabitsTest : public ProgramTest {
 protected:
  explicit HabitsTest(std::string name = "recon", std::string program = RECON_PROGRAM)
      : ProgramTest(std::move(name), std::move(program)) {}

  static bool has(const std::string& command) {
    return std::system(("command -v " + command + " > /dev/null 2>&1").c_str()) == 0;
  }

  // What a Python expression makes of the JSON object `it` that the program prints, as Python
  // prints it. Neither infinity nor NaN is JSON.
  std::string python(const std::string& arguments, const std::string& expression) const {
    write("look.py",
          "import json, sys\n"
          "def refuse(number): raise ValueError(number)\n"
          "text = open('summary.json').read()\n"
          "it = json.loads(text, parse_constant=refuse)\n"
          "assert text.count('\\n') == 1 and text.endswith('}\\n'), text\n"
          "print(" +
              expression + ")\n");
    write("summary.json", succeed(arguments));
    const Outcome outcome = shell("python3 look.py");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.out;
  }

  // Names of the commands, and of the options of one of them, as --help has them.
  std::vector<std::string> commands() const {
    const std::string help = succeed("--help");
    return found("\n  ([a-z]+)  +", help.substr(help.find("Subcommands:")));
  }
  std::vector<std::string> options(const std::string& command) const {
    return found("\n  (?:-[a-z],)?(--[a-z-]+)", succeed("help " + command));
  }

  // Each option that --help names is in the page and in what the shells are told, and the shells
  // take that for a program.
  void expect_all_options_everywhere() const {
    ASSERT_GE(commands().size(), 3u);
    for (const std::string shell_name : {"bash", "zsh", "fish"}) {
      write(shell_name + ".script", succeed("completion " + shell_name));
      if (!has(shell_name)) continue;
      const Outcome outcome = shell(shell_name + " -n " + shell_name + ".script");
      EXPECT_EQ(outcome.code, 0) << shell_name << outcome.err;
    }
    for (const std::string& command : commands()) {
      const std::string page = succeed("manual " + command);
      for (const std::string& option : options(command)) {
        const std::string name = option.substr(2);
        EXPECT_THAT(page,
                    HasSubstr("\\fB\\-\\-" + std::regex_replace(name, std::regex("-"), "\\-")));
        EXPECT_THAT(read("bash.script"), HasSubstr(" " + option));
        EXPECT_THAT(read("zsh.script"), HasSubstr("'*" + option + "["));
        EXPECT_THAT(read("fish.script"), HasSubstr("from " + command + "'"));
        EXPECT_THAT(read("fish.script"), HasSubstr(" -l " + name));
      }
      EXPECT_THAT(succeed("manual"), HasSubstr("\\-" + command + "\\fR(1)"));
    }
  }

  // The words that bash offers behind these, of which the last is the one to complete.
  std::vector<std::string> completed(const std::string& words) const {
    write("complete.bash", succeed("completion bash") + "COMP_WORDS=(" + words +
                               ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_" +
                               (words.starts_with("recon-mpm") ? "recon_mpm" : "recon") +
                               "\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n");
    std::istringstream lines(shell("bash complete.bash").out);
    std::vector<std::string> offered;
    for (std::string line; std::getline(lines, line);)
      if (!line.empty()) offered.push_back(line);
    return offered;
  }

 private:
  static std::vector<std::string> found(const std::string& pattern, const std::string& text) {
    const std::regex regex(pattern);
    std::vector<std::string> names;
    for (std::sregex_iterator at(text.begin(), text.end(), regex), end; at != end; ++at)
      names.push_back((*at)[1]);
    return names;
  }
};

TEST_F(HabitsTest, SummariesAsJson) {
  if (!has("python3")) GTEST_SKIP() << "python3 is not installed";
  EXPECT_EQ(python("info \"$CHUTE\" --json",
                   "it['particles'], len(it['frames']), it['coordinates'][2]['period'], "
                   "it['fields'][3]['name'], it['suggested']['nodes']"),
            "3000 6 None vx 3600\n");
  EXPECT_EQ(python("map \"$CHUTE\" --fields vx,solid_fraction --spacing 1 --radius 2 --out a.csv "
                   "--json",
                   "it['fit']['full'] + it['fit']['reduced'] + it['fit']['no_support'], "
                   "it['targets']['counts'], it['method']['degree'], "
                   "[f['name'] for f in it['fields']], it['fields'][0]['missing'], "
                   "0.99 < it['sums'][0]['over_grid'] / it['sums'][0]['of_particles'] < 1, "
                   "it['written'][0]['file']"),
            "3600 [20, 20, 9] 1 ['vx', 'solid_fraction'] 4 True a.csv\n");
  EXPECT_EQ(python("profile \"$CHUTE\" --fields vx --axis z --spacing 2 --radius 2 --range 0,8 "
                   "--methods shepard,mls --out p.csv --json",
                   "it['levels'], [m['method']['name'] for m in it['methods']], "
                   "round(it['means']['vx_shepard'][0], 3)"),
            "[0, 2, 4, 6, 8] ['shepard', 'mls'] 2.89\n");
}

TEST_F(HabitsTest, SummariesOfSeriesAsJson) {
  if (!has("python3")) GTEST_SKIP() << "python3 is not installed";
  const std::string map = "map \"$CHUTE\" --fields vx --spacing 4 --radius 2 --json --frame ";
  EXPECT_EQ(python(map + "0:2 --out a.vti",
                   "[f['step'] for f in it['frames']], "
                   "[w['file'] for w in it['written']]"),
            "[25000, 30000, 35000] ['a.pvd']\n");
  EXPECT_EQ(
      python(map + "all --average --out a.vti", "it['frames'], [f['name'] for f in it['fields']]"),
      "6 ['vx_mean', 'vx_std', 'frames', 'frames_full']\n");
}

// Nothing is a number there, and names and paths have signs of JSON.
TEST_F(HabitsTest, WhatIsNoNumberIsNull) {
  if (!has("python3")) GTEST_SKIP() << "python3 is not installed";
  write("a \"b\\.csv", "x,y,\"q\"\"\\\"\n0,0,nan\n1,0,inf\n0,1,\n");
  EXPECT_EQ(python("info 'a \"b\\.csv' --json", "it['source'], it['fields']"),
            "a \"b\\.csv [{'name': 'q\"\\\\', 'least': None, 'greatest': None, 'mean': None, "
            "'not_finite': 3}]\n");
}

TEST_F(HabitsTest, ManualAndCompletionHaveEveryOption) {
  expect_all_options_everywhere();
}

TEST_F(HabitsTest, ManualPagesHaveAName) {
  EXPECT_THAT(succeed("manual"),
              HasSubstr(".SH NAME\nrecon \\- turns scattered particle data into fields\n"));
  EXPECT_THAT(succeed("manual map"),
              HasSubstr(".SH NAME\nrecon\\-map \\- Particle data to fields"));
  if (!has("man")) GTEST_SKIP() << "man is not installed";
  const Outcome outcome = shell("'" + program() + "' manual map > map.1; man --warnings -l map.1");
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("--max-distance"), HasSubstr("EXIT STATUS")));
}

TEST_F(HabitsTest, CompletionInBash) {
  if (!has("bash")) GTEST_SKIP() << "bash is not installed";
  EXPECT_THAT(completed("recon m"), ElementsAre("map"));
  EXPECT_THAT(completed("recon help p"), ElementsAre("profile"));
  EXPECT_THAT(completed("recon map a.csv --wei"), ElementsAre("--weight", "--weight-by"));
  EXPECT_THAT(completed("recon map a.csv --form ''"), ElementsAre("radial", "tensor"));
  EXPECT_THAT(completed("recon map a.csv --form = t"), ElementsAre("tensor"));
  EXPECT_THAT(completed("recon map a"), ElementsAre());  // bash goes on with names of files
}

TEST_F(HabitsTest, UnknownShellsAndCommandsAreNamed) {
  expect_failure("completion tcsh", 1, AllOf(HasSubstr("'tcsh'"), HasSubstr("bash")));
  expect_failure("manual mop", 1, HasSubstr("'mop'"));
}

TEST_F(HabitsTest, TheVersionSaysWithWhatItWasBuilt) {
  EXPECT_THAT(succeed("--version"), AllOf(testing::StartsWith("recon 0."), HasSubstr("\ncompiler "),
                                          HasSubstr("\ninstruction sets  generic"),
                                          HasSubstr("\nOpenMP "), HasSubstr("Boost")));
}

TEST_F(HabitsTest, ColoursAreForTerminals) {
  const std::string escape = "\033[";
  EXPECT_THAT(succeed("help map"), Not(HasSubstr(escape)));
  if (!has("script")) GTEST_SKIP() << "script is not installed";
  const std::string on_a_terminal = "script -qec \"'" + program() + "' help map\" /dev/null";
  EXPECT_THAT(shell("unset NO_COLOR; " + on_a_terminal).out, HasSubstr("\033[1mParticles\033[0m"));
  EXPECT_THAT(shell("NO_COLOR=1 " + on_a_terminal).out, Not(HasSubstr(escape)));
}

#ifdef RECON_MPM_PROGRAM
class MpmHabitsTest : public HabitsTest {
 protected:
  MpmHabitsTest() : HabitsTest("recon-mpm", RECON_MPM_PROGRAM) {}
};

TEST_F(MpmHabitsTest, SummariesAsJson) {
  if (!has("python3")) GTEST_SKIP() << "python3 is not installed";
  const std::string ring = std::string(RECON_SOURCE_DIR) + "/examples/mpm/ring.toml";
  EXPECT_EQ(python("run '" + ring +
                       "' --cells 10 --set end=0.002 --set frames=1 --quiet --out o "
                       "--json",
                   "it['method'], it['dimension'], it['time'], it['stopped'], "
                   "it['first']['mass'] == it['last']['mass'], len(it['last']['momentum'])"),
            "cpls 2 0.002 False True 2\n");
}

TEST_F(MpmHabitsTest, ManualAndCompletionHaveEveryOption) {
  expect_all_options_everywhere();
}

TEST_F(MpmHabitsTest, CompletionKnowsTheMethods) {
  if (!has("bash")) GTEST_SKIP() << "bash is not installed";
  EXPECT_THAT(completed("recon-mpm run a.toml --method cpd"), ElementsAre("cpdi1", "cpdi2"));
}
#endif

}  // namespace
}  // namespace recon::test
