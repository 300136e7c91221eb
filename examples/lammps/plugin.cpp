// fix recon/grid as a plugin, for a LAMMPS with the package PLUGIN: `plugin load recon_grid.so`.
// Built where the headers of such a LAMMPS are found (lammpsplugin.h); Debian's has neither.
#include <lammpsplugin.h>
#include <version.h>

#include "fix_recon_grid.hpp"

static LAMMPS_NS::Fix* make_fix(LAMMPS_NS::LAMMPS* lammps, int count, char** words) {
  return new LAMMPS_NS::FixReconGrid(lammps, count, words);
}

extern "C" void lammpsplugin_init(void* lammps, void* handle, void* function) {
  lammpsplugin_t plugin;
  plugin.version = LAMMPS_VERSION;
  plugin.style = "fix";
  plugin.name = "recon/grid";
  plugin.info = "fields on a grid, and forces from it";
  plugin.author = "the recon developers";
  plugin.creator.v2 = reinterpret_cast<lammpsplugin_factory2*>(&make_fix);
  plugin.handle = handle;
  reinterpret_cast<lammpsplugin_regfunc>(function)(&plugin, lammps);
}
