#include "programs/common/command_line.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <thread>

#include "programs/common/build_options.hpp"
#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"
#include "programs/common/launch.hpp"
#include "programs/common/manual.hpp"
#include "programs/common/started.hpp"
#include "programs/common/text.hpp"

namespace recon::program {

namespace {

constexpr const char* exit_codes =
    "Exit codes:\n"
    "  0  done\n"
    "  1  wrong usage: an unknown option or field, a bad value\n"
    "  2  the input: a file is missing, a line is broken, a number is not finite\n"
    "  3  an output could not be written; files are written whole or not at all\n"
    "  4  anything else\n"
    "Messages go to the standard error, summaries to the standard output.";

// Is the standard output a terminal whose user has nothing against colours (no-color.org)?
bool takes_colours() {
  const char* none = std::getenv("NO_COLOR");
  return isatty(STDOUT_FILENO) == 1 && (none == nullptr || *none == '\0');
}

// Usage lines that name the arguments, and one blank line between groups, whose names are bold on
// terminals.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() { column_width(30); }
  std::string make_usage(const CLI::App* app, std::string name) const override {
    if (!app->get_parent()) return "\nUsage: " + name + " COMMAND ...\n";
    for (const CLI::Option* each : app->get_options())
      if (each->get_positional())
        name += " " + each->get_name(true) + (each->get_items_expected_max() > 1 ? "..." : "");
    return "\nUsage: " + name + " [OPTIONS]\n";
  }
  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    if (colours_ && !is_positional) group = "\033[1m" + group + "\033[0m";
    std::string text = Formatter::make_group(group, is_positional, options);
    if (is_positional) text.erase(0, text.find('\n', 1) + 1).insert(0, "\n");
    return text;
  }
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    std::string text = Formatter::make_help(app, name, mode);
    for (std::size_t at; (at = text.find("\n\n\n")) != std::string::npos;) text.erase(at, 1);
    return text;
  }

 private:
  bool colours_ = takes_colours();
};

// `recon help map` means `recon map --help`.
std::vector<std::string> arguments(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  if (words.empty()) return {"--help"};
  if (words[0] == "help") {
    words.erase(words.begin());
    words.push_back("--help");
  }
  return words;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

// Is this word an option rather than a value such as -1 or "-x > 2"?
bool looks_like_option(const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  if (name.find_first_of(" <>*/^()") != std::string::npos) return false;
  return word.starts_with("--") ||
         (word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1])));
}

// Misspelt names are found here and not by the parser, which would complain about what it misses
// before what it does not know.
void check_names(const Front& front, const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* command = &app;
  std::size_t first = 0;
  if (!looks_like_option(words[0])) {
    std::vector<std::string> commands;
    for (const CLI::App* each : app.get_subcommands({})) {
      commands.push_back(each->get_name());
      if (each->get_name() == words[0]) command = each;
    }
    if (command == &app) {
      if (std::filesystem::exists(words[0]))
        fail_usage("'" + words[0] + "' is a file; what is to be done with it? For a start:\n  " +
                   front.name + " " + front.file_hint + " " + words[0]);
      fail_usage("unknown command '" + words[0] + "'; " + suggest(words[0], commands));
    }
    first = 1;
  }
  const std::vector<std::string> names = option_names(*command);
  for (std::size_t i = first; i < words.size(); ++i) {
    const std::string name = words[i].substr(0, words[i].find('='));
    if (!looks_like_option(words[i]) || contains(names, name)) continue;
    fail_usage("unknown option '" + name + "'; " + suggest(name, names) + "\nSee " + front.name +
               " " + (first == 1 ? words[0] + " " : "") + "--help.");
  }
}

void parse(const Front& front, CLI::App& app, std::vector<std::string> words) {
  check_names(front, app, words);
  std::reverse(words.begin(), words.end());  // as the parser wants them
  app.parse(std::move(words));
}

// What was printed must have arrived: on a full disk it has not.
void require_printed() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw ProgramError(no_output, "the standard output cannot be written: " +
                                      std::generic_category().message(errno));
}

// Two commands that --help does not show, as their results are installed: `completion SHELL` and
// `manual [COMMAND]`.
bool print_for_installation(CLI::App& app, const std::vector<std::string>& words) {
  if (words[0] == "completion" && words.size() == 2)
    std::fputs(completion_script(app, words[1]).c_str(), stdout);
  else if (words[0] == "manual" && words.size() <= 2)
    std::fputs(manual_page(app, words.size() == 2 ? words[1] : "", exit_codes).c_str(), stdout);
  else
    return false;
  require_printed();
  return true;
}

// The command that was asked for; --help and --version are done at once.
Command read_words(const Front& front, CLI::App& app, const std::vector<std::string>& words,
                   const std::map<std::string, Command>& commands) {
  try {
    parse(front, app, words);
  } catch (const CLI::Success& asked_for) {  // --help, --version
    app.exit(asked_for);
    return [] {};
  } catch (const CLI::ExtrasError&) {
    std::string extra;
    for (const CLI::App* sub : app.get_subcommands())
      for (const std::string& word : sub->remaining())
        extra += (extra.empty() ? "'" : " '") + word + "'";
    fail_usage("too many arguments: " + extra +
               " (lists are written with commas and without blanks, as in vx,vy,vz)");
  } catch (const CLI::ArgumentMismatch& error) {
    const std::string what = error.what();
    const bool missing = what.find("missing") != std::string::npos;
    fail_usage(what.substr(0, what.find(':')) +
               (missing ? " needs a value" : " can be given only once"));
  } catch (const CLI::ParseError& error) {
    fail_usage(error.what());
  }
  for (const auto& [name, command] : commands)
    if (app.got_subcommand(name)) return command;
  return [] {};
}

// Several copies are joined, but for commands of one process: those may have been started by a program
// that is a rank itself.
int run(const Front& front, const std::string& description, int argc, char** argv,
        const AddCommands& add) {
  CLI::App app{description, front.name};
  app.set_version_flag("--version", front.name + " " RECON_VERSION "\n" + build_options(),
                       "the version, and with what it was built");
  app.require_subcommand(1);
  app.footer(exit_codes);
  app.formatter(std::make_shared<HelpFormatter>());
  app.set_help_flag("-h,--help", "this help");
  Launch launch;
  const std::map<std::string, Command> commands = add(app, launch);
  const std::vector<std::string> words = arguments(argc, argv);
  const int copies = started().copies;
  if (copies == 1 && print_for_installation(app, words)) return success;
  const auto prepare = [&]() -> Command {
    return [command = read_words(front, app, words, commands)] {
      command();
      require_printed();
    };
  };
  if (copies == 1) {
    prepare()();
    return success;
  }
  if (commands.contains(words[0]) && !contains(front.on_ranks, words[0]))
    fail_usage(words[0] + " is for one process, and " + std::to_string(copies) +
               " were started; only " + front.name + " " + enumeration(front.on_ranks) +
               " is spread over the ranks of mpirun or srun");
  return launch.join(front.name, words, prepare);
}

}  // namespace

int run_program(const Front& front, const std::string& description, int argc, char** argv,
                const AddCommands& add) {
  const int rank = started().rank;
  // Of several processes the first one speaks.
  if (rank > 0 && std::freopen("/dev/null", "w", stdout) == nullptr) std::fclose(stdout);
  try {
    return run(front, description, argc, argv, add);
  } catch (const FailureOfAll& of_all) {
    if (rank == 0) say(front.name, of_all.what());
    return of_all.code();
  } catch (...) {
    const Failure own = failure();
    // Copies that were not joined: where the first one fails, too, it says so, and its end is that of
    // the others before they do.
    if (rank > 0) std::this_thread::sleep_for(std::chrono::seconds(3));
    say(front.name, rank > 0 ? "rank " + std::to_string(rank) + ": " + own.text : own.text);
    return own.code;
  }
}

}  // namespace recon::program
