/* The library for C, from C99: every function, what it refuses, and what it says then. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "recon/c/recon.h"

static int failures = 0;

#define CHECK(condition)                                                            \
  do {                                                                              \
    if (!(condition)) {                                                             \
      fprintf(stderr, "%s:%d: %s\n  message: %s\n", __FILE__, __LINE__, #condition, \
              recon_message());                                                     \
      ++failures;                                                                   \
    }                                                                               \
  } while (0)
#define CHECK_MESSAGE(call, status, words)         \
  do {                                             \
    CHECK((call) == (status));                     \
    CHECK(strstr(recon_message(), words) != NULL); \
  } while (0)

enum { side = 12, n = side * side, m = 9 };
static double points[n][2], targets[m][2], u[n], values[m], slopes[m][2], forces[n];

static void make_points(void) {
  for (int p = 0; p < n; ++p) {
    points[p][0] = (p % side + 0.3 * sin(7.0 * p)) / side;
    points[p][1] = (p / side + 0.3 * cos(5.0 * p)) / side;
    u[p] = 1 + 2 * points[p][0] - 3 * points[p][1];
  }
  for (int t = 0; t < m; ++t) {
    targets[t][0] = 0.3 + 0.15 * (t % 3);
    targets[t][1] = 0.3 + 0.15 * (t / 3);
  }
}

static recon_array all_points(void) {
  return recon_doubles(&points[0][0], n, 2);
}
static recon_array all_targets(void) {
  return recon_doubles(&targets[0][0], m, 2);
}

static void linear_fields_are_reproduced(void) {
  recon_options* options = NULL;
  recon_fit* fit = NULL;
  recon_operator* gradient = NULL;
  double degree[m];
  CHECK(recon_options_new(&options) == RECON_OK);
  CHECK(recon_options_number(options, "degree", 1) == RECON_OK);
  CHECK(recon_options_number(options, "radius", 0.3) == RECON_OK);
  CHECK(recon_options_text(options, "method", "imls") == RECON_OK);
  CHECK(recon_reconstruct(all_points(), all_targets(), options, &fit) == RECON_OK);
  recon_options_free(options); /* the fit needs nothing of them */
  CHECK(recon_fit_targets(fit) == m && recon_fit_particles(fit) == n);
  CHECK(recon_fit_apply(fit, recon_doubles(u, n, 1), recon_doubles(values, m, 1)) == RECON_OK);
  CHECK(recon_fit_operator(fit, "gradient", &gradient) == RECON_OK);
  CHECK(recon_operator_components(gradient, 1) == 2 && recon_operator_components(gradient, 3) == 6);
  CHECK(recon_operator_apply(gradient, recon_doubles(u, n, 1),
                             recon_doubles(&slopes[0][0], m, 2)) == RECON_OK);
  CHECK(recon_fit_report(fit, "degree", degree, m) == RECON_OK);
  for (int t = 0; t < m; ++t) {
    CHECK(fabs(values[t] - (1 + 2 * targets[t][0] - 3 * targets[t][1])) < 1e-12);
    CHECK(fabs(slopes[t][0] - 2) < 1e-10 && fabs(slopes[t][1] + 3) < 1e-10);
    CHECK(degree[t] == 1);
  }

  /* <apply(u), f> = <u, apply_transpose(f)>, for both. */
  double left = 0, right = 0;
  CHECK(recon_fit_apply_transpose(fit, recon_doubles(values, m, 1), recon_doubles(forces, n, 1)) ==
        RECON_OK);
  for (int t = 0; t < m; ++t) left += values[t] * values[t];
  for (int p = 0; p < n; ++p) right += forces[p] * u[p];
  CHECK(fabs(left - right) < 1e-12 * fabs(left));
  CHECK(recon_operator_apply_transpose(gradient, recon_doubles(&slopes[0][0], m, 2),
                                       recon_doubles(forces, n, 1)) == RECON_OK);
  left = right = 0;
  for (int t = 0; t < m; ++t) left += slopes[t][0] * slopes[t][0] + slopes[t][1] * slopes[t][1];
  for (int p = 0; p < n; ++p) right += forces[p] * u[p];
  CHECK(fabs(left - right) < 1e-10 * fabs(left));
  recon_operator_free(gradient);
  recon_fit_free(fit);
}

static void arrays_are_read_where_they_lie(void) {
  struct grain {
    float mass;
    double x, velocity[2], y;
  } grains[n];
  double x[n], y[n], out[m][5];
  for (int p = 0; p < n; ++p) {
    grains[p].x = x[p] = points[p][0];
    grains[p].y = y[p] = points[p][1];
    grains[p].velocity[0] = 2 * y[p];
    grains[p].velocity[1] = u[p];
  }
  recon_array from = recon_doubles(&grains[0].x, n, 2),
              velocity = recon_doubles(grains[0].velocity, n, 2);
  from.stride = velocity.stride = (ptrdiff_t)sizeof(struct grain);
  from.component_stride = (char*)&grains[0].y - (char*)&grains[0].x;
  recon_array to = recon_doubles(&out[0][1], m, 2);
  to.stride = (ptrdiff_t)sizeof out[0];
  to.component_stride = 2 * (ptrdiff_t)sizeof(double);
  memset(out, 0, sizeof out);

  recon_fit *members = NULL, *axes = NULL;
  double again[m][2];
  CHECK(recon_reconstruct(from, all_targets(), NULL, &members) == RECON_OK);
  CHECK(recon_reconstruct(recon_double_arrays(x, y, NULL, n), all_targets(), NULL, &axes) ==
        RECON_OK);
  CHECK(recon_fit_apply(members, velocity, to) == RECON_OK);
  CHECK(recon_fit_apply(axes, velocity, recon_doubles(&again[0][0], m, 2)) == RECON_OK);
  for (int t = 0; t < m; ++t) {
    CHECK(out[t][1] == again[t][0] && out[t][3] == again[t][1]);
    CHECK(out[t][0] == 0 && out[t][2] == 0 && out[t][4] == 0);
    CHECK(fabs(out[t][1] - 2 * targets[t][1]) < 1e-12);
  }
  recon_fit_free(members);
  recon_fit_free(axes);

  float fx[n], fy[n], ft[2 * m], fu[n], fv[m];
  for (int p = 0; p < n; ++p) fx[p] = (float)x[p], fy[p] = (float)y[p], fu[p] = (float)u[p];
  for (int t = 0; t < m; ++t)
    ft[2 * t] = (float)targets[t][0], ft[2 * t + 1] = (float)targets[t][1];
  recon_fit* single = NULL;
  CHECK(recon_reconstruct(recon_float_arrays(fx, fy, NULL, n), recon_floats(ft, m, 2), NULL,
                          &single) == RECON_OK);
  CHECK(recon_fit_apply(single, recon_floats(fu, n, 1), recon_floats(fv, m, 1)) == RECON_OK);
  for (int t = 0; t < m; ++t)
    CHECK(fabs(fv[t] - (1 + 2 * targets[t][0] - 3 * targets[t][1])) < 1e-4);
  CHECK_MESSAGE(recon_fit_apply(single, recon_doubles(u, n, 1), recon_floats(fv, m, 1)),
                RECON_INVALID_ARGUMENT, "field.number = double: must be that of the object");
  recon_fit_free(single);
}

static void sources_follow_their_particles(void) {
  recon_options *options = NULL, *rule = NULL;
  recon_sources* sources = NULL;
  recon_fit* fit = NULL;
  const double weights[n] = {1}, stretch[2] = {1, 2};
  CHECK(recon_options_new(&options) == RECON_OK && recon_options_new(&rule) == RECON_OK);
  CHECK(recon_options_periodic(options, 0, -0.1, 1.1) == RECON_OK);
  CHECK(recon_options_numbers(options, "stretch", stretch, 2) == RECON_OK);
  CHECK(recon_options_number(rule, "nearest", 12) == RECON_OK);
  CHECK(recon_sources_new(all_points(), options, &sources) == RECON_OK);
  CHECK(recon_sources_size(sources) == n);
  CHECK(recon_reconstruct_from(sources, all_targets(), rule, &fit) == RECON_OK);
  CHECK_MESSAGE(recon_sources_update(sources, all_points(), weights), RECON_INVALID_ARGUMENT,
                "particle_weights");
  CHECK(recon_sources_update(sources, all_points(), NULL) == RECON_OK);
  CHECK_MESSAGE(recon_fit_apply(fit, recon_doubles(u, n, 1), recon_doubles(values, m, 1)),
                RECON_INVALID_ARGUMENT, "before an update of the Sources");
  CHECK(recon_fit_update(fit, all_targets()) == RECON_OK);
  CHECK(recon_fit_apply(fit, recon_doubles(u, n, 1), recon_doubles(values, m, 1)) == RECON_OK);

  double mass[n], density[m], support[m];
  for (int p = 0; p < n; ++p) mass[p] = 2.0 / n;
  recon_options_free(rule);
  CHECK(recon_options_new(&rule) == RECON_OK &&
        recon_options_number(rule, "radius", 0.3) == RECON_OK);
  CHECK(recon_options_text(rule, "weight", "wendland_c4") == RECON_OK);
  CHECK(recon_kernel_sum(sources, all_targets(), recon_doubles(mass, n, 1), rule,
                         recon_doubles(density, m, 1)) == RECON_OK);
  CHECK(density[4] > 1.5 && density[4] < 2.5);
  CHECK(recon_fit_report(fit, "support", support, m) == RECON_OK && support[0] > 0);
  recon_fit_free(fit);
  recon_sources_free(sources);
  recon_options_free(options);
  recon_options_free(rule);
}

static void operators_add_up(void) {
  recon_options* options = NULL;
  recon_fit* fit = NULL;
  recon_operator *sum = NULL, *laplacian = NULL, *divergence = NULL;
  double squares[n], plain[m], curved[m], both[m], vectors[n][2];
  CHECK(recon_options_new(&options) == RECON_OK &&
        recon_options_number(options, "degree", 2) == RECON_OK);
  CHECK(recon_reconstruct(all_points(), all_targets(), options, &fit) == RECON_OK);
  CHECK(recon_fit_operator(fit, "value", &sum) == RECON_OK);
  CHECK(recon_fit_operator(fit, "laplacian", &laplacian) == RECON_OK);
  CHECK(recon_fit_operator(fit, "divergence", &divergence) == RECON_OK);
  CHECK(recon_operator_components(divergence, 2) == 1 &&
        recon_operator_components(divergence, 1) == 0);
  for (int p = 0; p < n; ++p) {
    squares[p] = points[p][0] * points[p][0];
    vectors[p][0] = 3 * points[p][0], vectors[p][1] = points[p][1];
  }
  const recon_array field = recon_doubles(squares, n, 1);
  CHECK(recon_operator_apply(sum, field, recon_doubles(plain, m, 1)) == RECON_OK);
  CHECK(recon_operator_apply(laplacian, field, recon_doubles(curved, m, 1)) == RECON_OK);
  CHECK(recon_operator_add(sum, 0.5, laplacian) == RECON_OK);
  CHECK(recon_operator_apply(sum, field, recon_doubles(both, m, 1)) == RECON_OK);
  for (int t = 0; t < m; ++t) {
    CHECK(fabs(curved[t] - 2) < 1e-7);
    CHECK(fabs(both[t] - plain[t] - 0.5 * curved[t]) < 1e-10);
  }
  CHECK(recon_operator_apply(divergence, recon_doubles(&vectors[0][0], n, 2),
                             recon_doubles(plain, m, 1)) == RECON_OK);
  for (int t = 0; t < m; ++t) CHECK(fabs(plain[t] - 4) < 1e-8);
  CHECK_MESSAGE(recon_operator_apply(divergence, field, recon_doubles(plain, m, 1)),
                RECON_INVALID_ARGUMENT, "components");
  CHECK_MESSAGE(recon_operator_add(sum, 1, divergence), RECON_INVALID_ARGUMENT,
                "must be alike to be added");
  recon_operator_free(sum);
  recon_operator_free(laplacian);
  recon_operator_free(divergence);
  recon_fit_free(fit);
  recon_options_free(options);
}

static void grids_and_limits(void) {
  enum { nx = 4, ny = 3 };
  const recon_grid grid = {2, {0.3, 0.3, 0}, {0.1, 0.15, 0}, {nx, ny, 1}};
  recon_options* options = NULL;
  recon_fit* fit = NULL;
  double sums[nx * ny], fits[nx * ny], gradients[nx * ny][2], steps[n], held[m];
  CHECK(recon_options_new(&options) == RECON_OK &&
        recon_options_number(options, "radius", 0.3) == RECON_OK);
  CHECK(recon_on_grid(all_points(), recon_doubles(u, n, 1), grid, options,
                      recon_doubles(sums, nx * ny, 1), "diffuse",
                      recon_doubles(&gradients[0][0], nx * ny, 2)) == RECON_OK);
  CHECK(recon_reconstruct_at_nodes(all_points(), grid, options, &fit) == RECON_OK);
  CHECK(recon_fit_apply(fit, recon_doubles(u, n, 1), recon_doubles(fits, nx * ny, 1)) == RECON_OK);
  for (int i = 0; i < nx * ny; ++i) {
    const double exact = 1 + 2 * (0.3 + 0.1 * (i % nx)) - 3 * (0.3 + 0.15 * (i / nx));
    CHECK(fabs(sums[i] - exact) < 1e-11 && fabs(fits[i] - exact) < 1e-11);
    CHECK(fabs(gradients[i][0] - 2) < 1e-9 && fabs(gradients[i][1] + 3) < 1e-9);
  }
  recon_fit_free(fit);
  CHECK(recon_options_number(options, "degree", 2) == RECON_OK);
  CHECK(recon_reconstruct(all_points(), all_targets(), options, &fit) == RECON_OK);
  for (int p = 0; p < n; ++p) steps[p] = points[p][0] > 0.45;
  CHECK(recon_fit_apply_limited(fit, recon_doubles(steps, n, 1), "range",
                                recon_doubles(held, m, 1)) == RECON_OK);
  for (int t = 0; t < m; ++t) CHECK(held[t] >= 0 && held[t] <= 1);
  CHECK_MESSAGE(
      recon_fit_apply_limited(fit, recon_doubles(steps, n, 1), "rage", recon_doubles(held, m, 1)),
      RECON_INVALID_ARGUMENT, "limit = 'rage': is not known; did you mean 'range'?");
  recon_fit_free(fit);
  recon_options_free(options);
}

static void lists_of_ones_own(void) {
  const int64_t offsets[3] = {0, 4, 8};
  const uint32_t indices[8] = {0, 1, 12, 13, 40, 41, 52, 53}, beyond[8] = {0, 1, 2, n, 4, 5, 6, 7};
  const double support[2] = {1, 1};
  recon_options* options = NULL;
  recon_fit* fit = NULL;
  double at_two[2], neighbours[2];
  CHECK(recon_options_new(&options) == RECON_OK);
  CHECK(recon_options_neighbours(options, 2, offsets, indices, support) == RECON_OK);
  CHECK(recon_reconstruct(all_points(), recon_doubles(&points[0][0], 2, 2), options, &fit) ==
        RECON_OK);
  CHECK(recon_fit_apply(fit, recon_doubles(u, n, 1), recon_doubles(at_two, 2, 1)) == RECON_OK);
  CHECK(recon_fit_report(fit, "neighbours", neighbours, 2) == RECON_OK && neighbours[0] == 4);
  recon_fit_free(fit);
  CHECK(recon_options_neighbours(options, 2, offsets, beyond, support) == RECON_OK);
  CHECK_MESSAGE(recon_reconstruct(all_points(), recon_doubles(&points[0][0], 2, 2), options, &fit),
                RECON_INVALID_ARGUMENT, "144");
  CHECK(fit == NULL);
  recon_options_free(options);
}

static void supports_that_are_ellipsoids(void) {
  recon_options *options = NULL, *radius = NULL;
  recon_fit *fit = NULL, *ball = NULL;
  double tensors[m][3], one[m], other[m];
  for (int t = 0; t < m; ++t) tensors[t][0] = tensors[t][2] = 0.3, tensors[t][1] = 0;
  CHECK(recon_options_new(&options) == RECON_OK && recon_options_new(&radius) == RECON_OK);
  CHECK(recon_options_ellipsoids(options, recon_doubles(&tensors[0][0], m, 3)) == RECON_OK);
  CHECK(recon_options_number(radius, "radius", 0.3) == RECON_OK);
  CHECK(recon_reconstruct(all_points(), all_targets(), options, &fit) == RECON_OK);
  CHECK(recon_reconstruct(all_points(), all_targets(), radius, &ball) == RECON_OK);
  CHECK(recon_fit_apply(fit, recon_doubles(u, n, 1), recon_doubles(one, m, 1)) == RECON_OK);
  CHECK(recon_fit_apply(ball, recon_doubles(u, n, 1), recon_doubles(other, m, 1)) == RECON_OK);
  for (int t = 0; t < m; ++t) CHECK(fabs(one[t] - other[t]) < 1e-11);
  CHECK(recon_options_number(options, "radius", 0.3) == RECON_OK);
  recon_fit_free(fit);
  CHECK_MESSAGE(recon_reconstruct(all_points(), all_targets(), options, &fit),
                RECON_INVALID_ARGUMENT, "say one of them");
  recon_fit_free(ball);
  recon_options_free(options);
  recon_options_free(radius);
}

static int say_no(double fraction, void* calls) {
  *(int*)calls += fraction >= 0;
  return 0;
}

static void long_calls_can_be_cancelled(void) {
  enum { many = 200000 };
  double* x = malloc(sizeof(double) * many * 3);
  recon_options* options = NULL;
  recon_fit* fit = NULL;
  int calls = 0;
  if (!x) return;
  for (int i = 0; i < 3 * many; ++i)
    x[i] = fmod(i * 0.618033988749895 + i / 3 * 0.7548776662466927, 1);
  CHECK(recon_options_new(&options) == RECON_OK);
  CHECK(recon_options_number(options, "degree", 3) == RECON_OK);
  CHECK(recon_options_progress(options, say_no, &calls) == RECON_OK);
  CHECK_MESSAGE(
      recon_reconstruct(recon_doubles(x, many, 3), recon_doubles(x, many, 3), options, &fit),
      RECON_CANCELLED, "cancelled");
  CHECK(calls == 1 && fit == NULL);
  recon_options_free(options);
  free(x);
}

static void slips_are_named(void) {
  recon_options* options = NULL;
  recon_fit* fit = NULL;
  recon_operator* op = NULL;
  double out[m], bad[n][2];
  CHECK(recon_options_new(&options) == RECON_OK);
  CHECK_MESSAGE(recon_options_number(options, "raduis", 1), RECON_INVALID_ARGUMENT,
                "option = 'raduis': is not known; did you mean 'radius'?");
  CHECK_MESSAGE(recon_options_text(options, "weight", "cubik"), RECON_INVALID_ARGUMENT,
                "did you mean");
  CHECK_MESSAGE(recon_options_text(options, "degree", "one"), RECON_INVALID_ARGUMENT,
                "degree = 'one': must be a number");
  CHECK_MESSAGE(recon_options_number(options, "weight", 1), RECON_INVALID_ARGUMENT,
                "must be a text");
  CHECK_MESSAGE(recon_options_numbers(options, "weights", out, 1), RECON_INVALID_ARGUMENT,
                "option = 'weights'");
  CHECK_MESSAGE(recon_options_periodic(options, 3, 0, 1), RECON_INVALID_ARGUMENT, "axis = 3");
  CHECK_MESSAGE(recon_options_number(options, NULL, 1), RECON_INVALID_ARGUMENT,
                "name = NULL: must be given");
  CHECK_MESSAGE(recon_options_number(NULL, "degree", 1), RECON_INVALID_ARGUMENT,
                "options = NULL: must be given");
  CHECK(recon_options_number(options, "degree", 7) == RECON_OK); /* known when it is used */
  CHECK_MESSAGE(recon_reconstruct(all_points(), all_targets(), options, &fit),
                RECON_INVALID_ARGUMENT, "degree = 7: must be 0 to 4");
  CHECK(fit == NULL);
  CHECK_MESSAGE(recon_reconstruct(all_points(), all_targets(), NULL, NULL), RECON_INVALID_ARGUMENT,
                "must be an address");
  memcpy(bad, points, sizeof bad);
  bad[17][1] = NAN;
  CHECK_MESSAGE(recon_reconstruct(recon_doubles(&bad[0][0], n, 2), all_targets(), NULL, &fit),
                RECON_INVALID_ARGUMENT, "coordinate y of point 17");
  CHECK_MESSAGE(recon_reconstruct(recon_doubles(NULL, n, 2), all_targets(), NULL, &fit),
                RECON_INVALID_ARGUMENT, "points.arrays[0] = NULL");
  CHECK_MESSAGE(
      recon_reconstruct(recon_doubles(&points[0][0], n / 2, 4), all_targets(), NULL, &fit),
      RECON_INVALID_ARGUMENT, "points.components = 4: must be 1, 2 or 3");
  CHECK(recon_reconstruct(all_points(), all_targets(), NULL, &fit) == RECON_OK);
  CHECK_MESSAGE(recon_fit_apply(fit, recon_doubles(u, n, 1), recon_doubles(out, m - 1, 1)),
                RECON_INVALID_ARGUMENT, "out.size = 8: must be 9");
  CHECK_MESSAGE(recon_fit_apply(fit, recon_doubles(u, n / 2, 2), recon_doubles(out, m, 1)),
                RECON_INVALID_ARGUMENT, "out.components = 1: must be 2");
  CHECK_MESSAGE(recon_fit_apply(fit, recon_doubles(u, n - 1, 1), recon_doubles(out, m, 1)),
                RECON_INVALID_ARGUMENT, "143");
  CHECK_MESSAGE(recon_fit_operator(fit, "gradiant", &op), RECON_INVALID_ARGUMENT,
                "did you mean 'gradient'");
  CHECK_MESSAGE(recon_fit_report(fit, "degre", out, m), RECON_INVALID_ARGUMENT,
                "did you mean 'degree'");
  CHECK_MESSAGE(recon_fit_report(fit, "degree", out, m + 1), RECON_INVALID_ARGUMENT, "count = 10");
  recon_fit_free(fit);
  recon_options_free(options);
  recon_fit_free(NULL);
  recon_options_free(NULL);
  recon_operator_free(NULL);
  recon_sources_free(NULL);
  recon_table_free(NULL);
}

static void files_are_read(const char* dump) {
  recon_table* table = NULL;
  recon_array at;
  const double* vx = NULL;
  recon_fit* fit = NULL;
  double out;
  const double target[3] = {5, 5, 4};
  CHECK(recon_read(dump, -1, &table) == RECON_OK);
  CHECK(recon_table_size(table) == 3000);
  CHECK(recon_table_column(table, "vx", &vx) == RECON_OK && vx != NULL);
  CHECK(recon_table_positions(table, &at) == RECON_OK && at.components == 3);
  CHECK(recon_reconstruct(at, recon_doubles(target, 1, 3), NULL, &fit) == RECON_OK);
  CHECK(recon_fit_apply(fit, recon_doubles(vx, 3000, 1), recon_doubles(&out, 1, 1)) == RECON_OK &&
        out > 0);
  CHECK_MESSAGE(recon_table_column(table, "vxx", &vx), RECON_INVALID_ARGUMENT, "did you mean 'vx'");
  CHECK(vx == NULL);
  recon_fit_free(fit);
  recon_table_free(table);
  CHECK_MESSAGE(recon_read("nowhere.dump", -1, &table), RECON_FILE_ERROR,
                "nowhere.dump: no such file");
  CHECK(table == NULL);
}

int main(int count, char** arguments) {
  CHECK(recon_abi_version() == RECON_C_ABI && strchr(recon_version(), '.') != NULL);
  CHECK(strcmp(recon_message(), "") == 0);
  make_points();
  linear_fields_are_reproduced();
  arrays_are_read_where_they_lie();
  sources_follow_their_particles();
  operators_add_up();
  grids_and_limits();
  lists_of_ones_own();
  supports_that_are_ellipsoids();
  long_calls_can_be_cancelled();
  slips_are_named();
  if (count > 1) files_are_read(arguments[1]);
  if (failures > 0) fprintf(stderr, "%d checks failed\n", failures);
  return failures > 0;
}
