/* Particles to a field with gradient and report, and a run of the material point method: the same in C++, C, Fortran
 * and Python, with the same output (field.output). The argument is a problem file. */
#include <math.h>
#include <recon/c/recon.h>
#include <stdio.h>
#include <stdlib.h>

static void must(recon_status status) {
  if (status == RECON_OK) return;
  fprintf(stderr, "%s\n", recon_message());
  exit(1);
}

int main(int count, char** arguments) {
  static double x[2000][2], u[2000], targets[9][2], value[9], gradient[9][2], degree[9];
  for (int i = 0; i < 2000; ++i) {
    x[i][0] = fmod((i + 1) * 0.7548776662466927, 1),
    x[i][1] = fmod((i + 1) * 0.5698402909980532, 1);
    u[i] = x[i][0] * (x[i][0] + x[i][1]);
  }
  for (int t = 0; t < 9; ++t)
    targets[t][0] = 0.25 * (1 + t % 3), targets[t][1] = 0.25 * (1 + t / 3);

  recon_options* options;
  recon_fit* fit;
  recon_operator* slopes;
  must(recon_options_new(&options));
  must(recon_options_number(options, "degree", 1));
  must(recon_options_number(options, "radius", 0.1));
  must(recon_reconstruct(recon_doubles(x[0], 2000, 2), recon_doubles(targets[0], 9, 2), options,
                         &fit));
  must(recon_fit_apply(fit, recon_doubles(u, 2000, 1), recon_doubles(value, 9, 1)));
  must(recon_fit_operator(fit, "gradient", &slopes));
  must(recon_operator_apply(slopes, recon_doubles(u, 2000, 1), recon_doubles(gradient[0], 9, 2)));
  must(recon_fit_report(fit, "degree", degree, 9));
  double error = 0;
  int full = 0;
  for (int t = 0; t < 9; ++t) {
    error = fmax(error, fabs(value[t] - targets[t][0] * (targets[t][0] + targets[t][1])));
    full += degree[t] == 1;
  }
  printf("%d of %zu targets with degree 1, largest error %.6f\n", full, recon_fit_targets(fit),
         error);
  printf("u(0.5, 0.5) = %.6f, gradient (%.6f, %.6f)\n", value[4], gradient[4][0], gradient[4][1]);
  recon_operator_free(slopes), recon_fit_free(fit), recon_options_free(options);

  recon_simulation* disks;
  recon_array v, mass;
  must(recon_simulation_new(count > 1 ? arguments[1] : "", NULL, 0, &disks));
  must(recon_simulation_run_until(disks, 0.5));
  must(recon_simulation_array(disks, "v", &v));
  must(recon_simulation_array(disks, "mass", &mass));
  const double *m = mass.data, *w = v.data;
  double energy = 0;
  for (size_t p = 0; p < mass.size; ++p)
    energy += 0.5 * m[p] * (w[2 * p] * w[2 * p] + w[2 * p + 1] * w[2 * p + 1]);
  printf("%zu particles at t = %.2f, kinetic energy %.6f\n", mass.size,
         recon_simulation_time(disks), energy);
  recon_simulation_free(disks);
  return 0;
}
