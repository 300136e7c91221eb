// recon: files with particles in, files with fields out. The command line, and the exit codes.
#include "commands.hpp"

int main(int argc, char** argv) {
  using namespace recon::program;
  return run_program(
      {.name = "recon", .file_hint = "info", .on_ranks = {"map"}},
      "recon turns scattered particle data into fields: values and gradients on grids, by "
      "weighted\n"
      "least squares (Shepard, MLS, IMLS) with a report for every node.\n\n"
      "  recon info FILE                            what is in a file\n"
      "  recon convert FILE --out particles.xyz     to another format\n"
      "  recon map FILE --fields vx --out v.vti     fields on a grid\n"
      "  recon profile FILE --fields vx --out v.csv fields along an axis\n"
      "  recon help map                             all about one of them",
      argc, argv, [](CLI::App& app, const Launch& launch) -> std::map<std::string, Command> {
        return {{"convert", add_convert(app)},
                {"info", add_info(app)},
                {"map", add_map(app, launch)},
                {"profile", add_profile(app)}};
      });
}
