#include "programs/common/manual.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "programs/common/checks.hpp"
#include "programs/common/errors.hpp"

namespace recon::program {

namespace {

struct Choice {
  std::vector<std::string> names;  // with their dashes; none for a positional argument
  std::string value;               // what it takes: N, NAME, FILE, ...; empty for a flag
  std::vector<std::string> words;  // what it may be, where that is known
  std::string description, group, standard;

  std::string last_name() const { return names.empty() ? value : names.back(); }
};

std::vector<Choice> choices_of(CLI::App& app) {
  std::vector<Choice> choices;
  for (CLI::Option* option : app.get_options()) {
    Choice choice;
    for (const std::string& name : option->get_snames()) choice.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) choice.names.push_back("--" + name);
    if (choice.names.empty())
      choice.value = option->get_name(true) + (option->get_items_expected_max() > 1 ? "..." : "");
    else if (option->get_items_expected_max() > 0)
      choice.value = option->get_type_name();
    choice.words = words_of(*option);
    choice.description = option->get_description();
    choice.group = option->get_group();
    choice.standard = option->get_default_str();
    choices.push_back(std::move(choice));
  }
  return choices;
}

// Options with a name; the positional arguments have none.
std::vector<Choice> named_choices_of(CLI::App& app) {
  std::vector<Choice> choices = choices_of(app);
  std::erase_if(choices, [](const Choice& choice) { return choice.names.empty(); });
  return choices;
}

std::string command_names(CLI::App& app) {
  std::string names;
  for (CLI::App* command : app.get_subcommands({})) names += command->get_name() + " ";
  return names + "help";
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

// The first clause of a program's description, without its name: for the list that apropos searches.
std::string brief_of(const std::string& description, const std::string& program) {
  std::string text = description.substr(0, description.find("\n\n"));
  std::replace(text.begin(), text.end(), '\n', ' ');
  text.resize(std::min(text.find_first_of(":,."), text.size()));
  return text.starts_with(program + " ") ? text.substr(program.size() + 1) : text;
}

std::string joined(const std::vector<std::string>& words, const char* separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

// ---- Pages for man ---------------------------------------------------------------------------------

// Text as troff takes it: no signs of its own, and every line at the place where it is.
std::string troff(const std::string& text) {
  std::string out;
  bool begin = true;
  for (const char c : text) {
    if (begin && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
    begin = c == '\n';
  }
  return out;
}

std::string set_in(const std::string& text) {
  return ".nf\n" + troff(text) + "\n.fi\n";
}

std::string troff_of(const Choice& choice) {
  std::string names;
  for (const std::string& name : choice.names)
    names += (names.empty() ? "\\fB" : ", \\fB") + troff(name) + "\\fR";
  std::string text = ".TP\n" + names + (names.empty() || choice.value.empty() ? "" : " ") +
                     (choice.value.empty() ? "" : "\\fI" + troff(choice.value) + "\\fR") + "\n" +
                     set_in(choice.description);
  if (!choice.standard.empty()) text += ".br\nDefault: " + troff(choice.standard) + "\n";
  return text;
}

}  // namespace

std::string manual_page(CLI::App& app, std::string_view command, std::string_view exit_statuses) {
  CLI::App* page = &app;
  if (!command.empty()) {
    const std::vector<CLI::App*> commands = app.get_subcommands({});
    const auto found = std::find_if(commands.begin(), commands.end(),
                                    [&](CLI::App* each) { return each->get_name() == command; });
    if (found == commands.end())
      fail_usage("manual: there is no command '" + std::string(command) + "'");
    page = *found;
  }
  const std::string program = app.get_name();
  const std::string name = program + (page == &app ? "" : "-" + page->get_name());
  const std::string description = page->get_description();
  std::string upper = name;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));

  std::string text = ".TH \"" + upper + "\" 1 \"\" \"" + program + " " RECON_VERSION "\"\n" +
                     ".SH NAME\n" + troff(name) + " \\- " +
                     troff(page == &app ? brief_of(description, program) : description) + "\n" +
                     ".SH SYNOPSIS\n.B " + troff(program);
  if (page == &app) {
    text += "\n\\fICOMMAND\\fR [\\fIOPTIONS\\fR]\n.SH DESCRIPTION\n" + set_in(description);
    text += ".SH COMMANDS\n";
    for (CLI::App* each : app.get_subcommands({}))
      text += ".TP\n\\fB" + troff(each->get_name()) + "\\fR\n" + troff(each->get_description()) +
              ": see \\fB" + troff(program + "-" + each->get_name()) + "\\fR(1)\n";
  } else {
    text += " " + page->get_name() + "\n";
    for (const Choice& choice : choices_of(*page))
      if (choice.names.empty()) text += "\\fI" + troff(choice.value) + "\\fR ";
    text += "[\\fIOPTIONS\\fR]\n.SH DESCRIPTION\n" + troff(description) + ".\n";
    for (const Choice& choice : choices_of(*page))
      if (choice.names.empty()) text += troff_of(choice);
  }
  text += ".SH OPTIONS\n";
  for (const std::string& group : page->get_groups()) {
    std::string options;
    for (const Choice& choice : named_choices_of(*page))
      if (choice.group == group) options += troff_of(choice);
    if (!options.empty())
      text += (group == "Options" ? "" : ".SS " + troff(group) + "\n") + options;
  }
  std::string footer = page->get_footer();
  while (footer.starts_with('\n')) footer.erase(0, 1);
  if (page != &app && footer.starts_with("Example"))
    text += ".SH EXAMPLES\n" + set_in(footer.substr(footer.find('\n') + 1));
  text +=
      ".SH EXIT STATUS\n" + set_in(std::string(exit_statuses.substr(exit_statuses.find('\n') + 1)));
  text += ".SH SEE ALSO\n";
  if (page != &app) text += "\\fB" + troff(program) + "\\fR(1)\n";
  for (CLI::App* each : app.get_subcommands({}))
    if (each != page) text += "\\fB" + troff(program + "-" + each->get_name()) + "\\fR(1)\n";
  return text;
}

// ---- Completion ------------------------------------------------------------------------------------

namespace {

std::string option_names_of(CLI::App& app) {
  std::string text;
  for (const Choice& choice : named_choices_of(app))
    text += (text.empty() ? "" : " ") + joined(choice.names, " ");
  return text;
}

// The names of an option, as a pattern of a shell.
std::string pattern(CLI::App& command, const Choice& choice) {
  std::string text;
  for (const std::string& name : choice.names)
    text += (text.empty() ? "\"" : " | \"") + command.get_name() + " " + name + "\"";
  return text;
}

std::string bash_script(CLI::App& app) {
  const std::string program = app.get_name();
  std::string function = "_" + program;
  std::replace(function.begin(), function.end(), '-', '_');
  std::string values, options;
  for (CLI::App* command : app.get_subcommands({})) {
    for (const Choice& choice : named_choices_of(*command)) {
      if (choice.words.empty()) continue;
      values += "    " + pattern(*command, choice) + ")\n      COMPREPLY=($(compgen -W \"" +
                joined(choice.words, " ") + "\" -- \"$word\"))\n      return ;;\n";
    }
    options += "    " + command->get_name() + ") words=\"" + option_names_of(*command) + "\" ;;\n";
  }
  return "# Completion of " + program + " in bash; made by " + program + " completion bash.\n" +
         function +
         "() {\n"
         "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words=\n"
         "  COMPREPLY=()\n"
         "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
         "    COMPREPLY=($(compgen -W \"" +
         command_names(app) + " " + option_names_of(app) +
         "\" -- \"$word\"))\n"
         "    return\n"
         "  fi\n"
         "  if [ \"$word\" = = ]; then\n"  // --option=VALUE is three words
         "    word=\n"
         "  elif [ \"$before\" = = ]; then\n"
         "    before=${COMP_WORDS[COMP_CWORD - 2]}\n"
         "  fi\n"
         "  case \"${COMP_WORDS[1]} $before\" in\n"
         "    \"help help\")\n"
         "      COMPREPLY=($(compgen -W \"" +
         command_names(app) +
         "\" -- \"$word\"))\n"
         "      return ;;\n" +
         values +
         "  esac\n"
         "  case \"${COMP_WORDS[1]}\" in\n" +
         options +
         "  esac\n"
         "  case \"$word\" in\n"
         "    -*) COMPREPLY=($(compgen -W \"$words\" -- \"$word\")) ;;\n"
         "  esac\n"
         "}\n"
         "complete -o default -F " +
         function + " " + program + "\n";
}

// Without the signs that mean something between single quotes, in brackets, or to a colon.
std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text)
    if (c != '\'' && c != '[' && c != ']' && c != ':' && c != '\\' && c != '"' && c != '$' &&
        c != '`')
      out += c;
  return out;
}

std::string zsh_script(CLI::App& app) {
  const std::string program = app.get_name();
  std::string commands, cases;
  for (CLI::App* command : app.get_subcommands({})) {
    commands += "    '" + command->get_name() + ":" + plain(command->get_description()) + "'\n";
    cases += "    " + command->get_name() + ")\n      _arguments \\\n";
    for (const Choice& choice : named_choices_of(*command))
      for (const std::string& name : choice.names) {
        cases += "        '*" + name + "[" + plain(first_line(choice.description)) + "]";
        if (!choice.value.empty())
          cases += ":" + plain(choice.value) + ":" +
                   (choice.words.empty() ? "_files" : "(" + joined(choice.words, " ") + ")");
        cases += "' \\\n";
      }
    cases += "        '*:file:_files' ;;\n";
  }
  return "#compdef " + program + "\n# Completion of " + program + " in zsh; made by " + program +
         " completion zsh.\n"
         "local -a commands=(\n" +
         commands +
         "    'help:all about a command'\n"
         "    '--help:this help'\n"
         "    '--version:the version'\n"
         ")\n"
         "if (( CURRENT == 2 )) || [[ $words[2] == help ]]; then\n"
         "  _describe command commands\n"
         "else\n"
         "  local command=$words[2]\n"
         "  shift words\n"
         "  (( CURRENT-- ))\n"
         "  case $command in\n" +
         cases + "  esac\nfi\n";
}

std::string fish_script(CLI::App& app) {
  const std::string program = app.get_name();
  std::string text =
      "# Completion of " + program + " in fish; made by " + program + " completion fish.\n";
  const std::string at_first = "complete -c " + program + " -n __fish_use_subcommand ";
  for (CLI::App* command : app.get_subcommands({})) {
    text += at_first + "-f -a " + command->get_name() + " -d '" +
            plain(command->get_description()) + "'\n";
    for (const Choice& choice : named_choices_of(*command)) {
      text += "complete -c " + program + " -n '__fish_seen_subcommand_from " + command->get_name() +
              "'";
      for (const std::string& name : choice.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!choice.words.empty())
        text += " -x -a '" + joined(choice.words, " ") + "'";
      else if (!choice.value.empty())
        text += " -r";
      text += " -d '" + plain(first_line(choice.description)) + "'\n";
    }
  }
  text += at_first + "-f -a help -d 'all about a command'\n";
  text += at_first + "-l help -d 'this help'\n";
  return text + at_first + "-l version -d 'the version'\n";
}

}  // namespace

std::string completion_script(CLI::App& app, const std::string& shell) {
  if (const std::string wrong = one_of({"bash", "zsh", "fish"})(shell); !wrong.empty())
    fail_usage("completion: " + wrong);
  return shell == "bash" ? bash_script(app) : shell == "zsh" ? zsh_script(app) : fish_script(app);
}

}  // namespace recon::program
