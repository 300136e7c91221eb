// What the definitions of the options say besides --help: manual pages and completion in shells.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace CLI {
class App;
}

namespace recon::program {

// A page for man: of the program or, where it is named, of a command. Ends with wrong_usage for a
// command that there is not.
std::string manual_page(CLI::App& app, std::string_view command, std::string_view exit_statuses);

// A script that completes commands, options and the words that some options take, in bash, zsh or
// fish; elsewhere names of files. Ends with wrong_usage for another shell.
std::string completion_script(CLI::App& app, const std::string& shell);

}  // namespace recon::program
