#include "bindings/any_simulation.hpp"
#include "c/handles.hpp"

struct recon_simulation {
  recon::bindings::AnySimulation simulation;
};

using recon::c::guarded;
using recon::c::there;

recon_status recon_simulation_new(const char* path, const char* const* settings, size_t count,
                                  recon_simulation** simulation) {
  return recon::c::made_by(simulation, [&] {
    std::vector<std::string> texts;
    if (count > 0) there(settings, "settings");
    for (std::size_t i = 0; i < count; ++i) texts.emplace_back(&there(settings[i], "a setting"));
    return std::unique_ptr<recon_simulation>(new recon_simulation{{&there(path, "path"), texts}});
  });
}

void recon_simulation_free(recon_simulation* simulation) {
  delete simulation;
}

int recon_simulation_dimension(const recon_simulation* simulation) {
  return simulation ? simulation->simulation.dimension() : 0;
}
size_t recon_simulation_particles(const recon_simulation* simulation) {
  return simulation ? simulation->simulation.size() : 0;
}
double recon_simulation_time(const recon_simulation* simulation) {
  return simulation ? simulation->simulation.time() : 0;
}
double recon_simulation_end(const recon_simulation* simulation) {
  return simulation ? simulation->simulation.end() : 0;
}

recon_status recon_simulation_choose_step(const recon_simulation* simulation, double* dt) {
  return guarded(
      [&] { there(dt, "dt") = there(simulation, "simulation").simulation.choose_step(); });
}

recon_status recon_simulation_step(recon_simulation* simulation, double dt) {
  return guarded([&] { there(simulation, "simulation").simulation.step(dt); });
}

recon_status recon_simulation_run_until(recon_simulation* simulation, double time) {
  return guarded([&] { there(simulation, "simulation").simulation.run_until(time); });
}

recon_status recon_simulation_array(const recon_simulation* simulation, const char* name,
                                    recon_array* array) {
  return guarded([&] {
    const recon::bindings::ParticleArrayView view =
        there(simulation, "simulation").simulation.particles(&there(name, "name"));
    if (view.integers)
      recon::detail::throw_invalid("array of the particles", name, "must be one of double numbers");
    // The numbers of one particle lie side by side.
    int components = 1;
    for (std::size_t axis = 1; axis < view.shape.size(); ++axis)
      components *= static_cast<int>(view.shape[axis]);
    there(array, "array") =
        recon_doubles(static_cast<const double*>(view.data), view.shape[0], components);
  });
}
