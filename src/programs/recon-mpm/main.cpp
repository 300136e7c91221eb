// recon-mpm: problem files in, runs and studies of the material point method out.
#include <signal.h>

#include <string_view>

#include "commands.hpp"
#include "stop_signals.hpp"

int main(int argc, char** argv) {
  using namespace recon::program;
  signal(SIGXFSZ, SIG_IGN);  // a limit to the size of files is an error like a full disk
  StopSignals signals;
  if (argc > 1 && argv[1] == std::string_view("run")) signals.catch_them();
  return run_program(
      {.name = "recon-mpm", .file_hint = "run", .on_ranks = {"run"}},
      "recon-mpm runs the material point method in its variants, whose velocity and stress maps "
      "are\n"
      "reconstructions by weighted least squares.\n\n"
      "  recon-mpm methods                          the methods, and what they are made of\n"
      "  recon-mpm run PROBLEM.toml --method cpls   one run: frames for ParaView, a ledger;\n"
      "                                             on many processors by mpirun -n N\n"
      "  recon-mpm converge PROBLEM.toml            errors and orders against the exact solution\n"
      "  recon-mpm compare PROBLEM.toml             every method on one problem, side by side\n"
      "  recon-mpm verify                           the claims of the publications, measured\n"
      "  recon-mpm stability                        the largest stable step of each method\n"
      "  recon-mpm help run                         all about one of them",
      argc, argv, [](CLI::App& app, const Launch& launch) -> std::map<std::string, Command> {
        return {{"run", add_run(app, launch)},   {"methods", add_methods(app)},
                {"converge", add_converge(app)}, {"compare", add_compare(app)},
                {"verify", add_verify(app)},     {"stability", add_stability(app)}};
      });
}
