/* recon for C99, and for every language that can call C.
 *
 *   recon_options *options = NULL;
 *   recon_fit *fit = NULL;
 *   if (recon_options_new(&options) || recon_options_number(options, "radius", 0.3) ||
 *       recon_reconstruct(recon_doubles(x, n, 2), recon_doubles(t, m, 2), options, &fit) ||
 *       recon_fit_apply(fit, recon_doubles(u, n, 1), recon_doubles(v, m, 1)))
 *     fprintf(stderr, "%s\n", recon_message());
 *   recon_fit_free(fit);
 *   recon_options_free(options);
 *
 * Errors. A function that can fail returns RECON_OK (0) or what kind of trouble there is;
 * recon_message() says it in words, as the exceptions of the C++ library do: "<argument> = <value>:
 * <rule>". No exception passes this border. What a function that fails would have made is NULL, and
 * what it would have written is of no use. Numerical outcomes are no errors: they stand in the
 * report of a fit.
 *
 * Objects are handles, made by *_new and the like, and freed by *_free, which takes NULL. They own
 * what they need: arrays may go once a call has returned. Functions that take a handle as const may
 * be called from several threads at once, also for one object.
 *
 * The functions keep their meaning while RECON_C_ABI stays; new ones are added at the end of a
 * group. Lengths and data are in any consistent units.
 */
#ifndef RECON_C_RECON_H
#define RECON_C_RECON_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define RECON_C_ABI 1
/* RECON_C_ABI of the library that is linked. */
int recon_abi_version(void);
/* The version of recon, "1.2.3". */
const char* recon_version(void);

typedef enum recon_status {
  RECON_OK = 0,
  RECON_INVALID_ARGUMENT = 1, /* wrong input */
  RECON_FILE_ERROR = 2,       /* trouble with a file */
  RECON_CANCELLED = 3,        /* the progress function has said no */
  RECON_FAILURE = 4,          /* a simulation that cannot go on */
  RECON_NO_MEMORY = 5,
  RECON_UNEXPECTED = 6
} recon_status;

/* What the last call that failed in this thread had to say; valid until the next one fails. ""
 * before. */
const char* recon_message(void);

/* ---- arrays
 * ----------------------------------------------------------------------------------- */

typedef enum recon_number { RECON_DOUBLE = 0, RECON_FLOAT = 1 } recon_number;

/* `size` values of `components` numbers: coordinates of points, or a field. Component c of value
 * i lies at data + i * stride + c * component_stride bytes or, where `data` is NULL, at
 * arrays[c] + i * stride, for at most 9 components. Arguments that are called `out` are written,
 * all others only read. */
typedef struct recon_array {
  size_t size;
  int components;
  recon_number number;
  void* data;
  ptrdiff_t stride, component_stride;
  void* arrays[9];
} recon_array;

/* Numbers without gaps, value after value: x0 y0 z0 x1 y1 z1 ... */
recon_array recon_doubles(const double* data, size_t size, int components);
recon_array recon_floats(const float* data, size_t size, int components);
/* An array for each of up to three components; those that are not there are NULL. */
recon_array recon_double_arrays(const double* x, const double* y, const double* z, size_t size);
recon_array recon_float_arrays(const float* x, const float* y, const float* z, size_t size);

/* Node (i, j, k) lies at origin + (i, j, k) * spacing; the first axis runs fastest. */
typedef struct recon_grid {
  int dimension;
  double origin[3], spacing[3];
  size_t counts[3];
} recon_grid;

/* ---- options
 * ---------------------------------------------------------------------------------- */

typedef struct recon_options recon_options;

recon_status recon_options_new(recon_options** options);
void recon_options_free(recon_options* options);

/* By name; docs/c.md has the list. Numbers: degree, radius, nearest, threads, max_distance,
 * fill_value, grow.steps, grow.factor, tolerances.rank, ... Texts: method ("imls", "mls",
 * "shepard"), weight, form, solver, search, unsupported, instruction_set. A name that is none
 * gets a suggestion. */
recon_status recon_options_number(recon_options* options, const char* name, double value);
recon_status recon_options_text(recon_options* options, const char* name, const char* value);
/* particle_weights (one per particle), stretch (one per axis), radii (one per target). They are
 * copied. */
recon_status recon_options_numbers(recon_options* options, const char* name, const double* values,
                                   size_t count);
/* The domain is periodic along this axis (0, 1, 2). */
recon_status recon_options_periodic(recon_options* options, int axis, double lower, double upper);
/* A list of neighbours of one's own: those of target t are indices[offsets[t]] to
 * indices[offsets[t + 1] - 1], counted from 0, and support[t] is its support radius. Copied. */
recon_status recon_options_neighbours(recon_options* options, size_t targets,
                                      const int64_t* offsets, const uint32_t* indices,
                                      const double* support);
/* Supports that are ellipsoids: a support tensor of each target, packed (xx, xy, xz, yy, yz, zz as
 * far as the dimension has them) or full, doubles; recon/neighbourhood/support_tensor.hpp. Copied. */
recon_status recon_options_ellipsoids(recon_options* options, recon_array tensors);
/* Called with the fraction of the work that is done; 0 cancels the call. NULL: nobody is told. */
recon_status recon_options_progress(recon_options* options,
                                    int (*progress)(double fraction, void* context), void* context);

/* ---- particles that are kept
 * -------------------------------------------------------------------- */

typedef struct recon_sources recon_sources;

/* Of the options domain, stretch and particle_weights are used; they may be NULL. */
recon_status recon_sources_new(recon_array points, const recon_options* options,
                               recon_sources** sources);
/* particle_weights: one per particle, or NULL: as they are. Nobody may read meanwhile. */
recon_status recon_sources_update(recon_sources* sources, recon_array points,
                                  const double* particle_weights);
size_t recon_sources_size(const recon_sources* sources);
void recon_sources_free(recon_sources* sources);

/* Sums over kernels with unit integral, sum_p a_p W(x - x_p): a row per target. The support is
 * that of the options (radius, nearest, radii), their weight and form are used. */
recon_status recon_kernel_sum(const recon_sources* sources, recon_array targets,
                              recon_array amounts, const recon_options* options, recon_array out);

/* ---- reconstructions
 * ------------------------------------------------------------------------------ */

typedef struct recon_fit recon_fit;

/* Points and targets are both double or both float, and so are all fields of the fit. The
 * options may be NULL. */
recon_status recon_reconstruct(recon_array points, recon_array targets,
                               const recon_options* options, recon_fit** fit);
recon_status recon_reconstruct_at_nodes(recon_array points, recon_grid grid,
                                        const recon_options* options, recon_fit** fit);
/* From sources, which are not freed before. domain, stretch and particle_weights are theirs. */
recon_status recon_reconstruct_from(const recon_sources* sources, recon_array targets,
                                    const recon_options* options, recon_fit** fit);
/* For other targets, and for the present positions of the sources. */
recon_status recon_fit_update(recon_fit* fit, recon_array targets);
void recon_fit_free(recon_fit* fit);

size_t recon_fit_targets(const recon_fit* fit);
size_t recon_fit_particles(const recon_fit* fit);

/* out has a value per target: sum_p phi_p(x_t) u_p. `limit`: NULL, "none", "range" or "relaxed". */
recon_status recon_fit_apply(const recon_fit* fit, recon_array field, recon_array out);
recon_status recon_fit_apply_limited(const recon_fit* fit, recon_array field, const char* limit,
                                     recon_array out);
/* out has a value per particle: sum_t phi_p(x_t) f_t. */
recon_status recon_fit_apply_transpose(const recon_fit* fit, recon_array field, recon_array out);

/* What became of each target, `count` numbers: neighbours, rank, degree, status (0 full, 1
 * reduced, 2 nearest, 3 no support, 4 too far), solver, gradient_rank, hessian_rank,
 * smallest_pivot, amplification, gradient_amplification; and support, the support radius, a
 * length. */
recon_status recon_fit_report(const recon_fit* fit, const char* name, double* out, size_t count);

/* Operators: value, gradient, diffuse_gradient, hessian, laplacian, divergence, curl,
 * strain_rate. */
typedef struct recon_operator recon_operator;

recon_status recon_fit_operator(const recon_fit* fit, const char* name, recon_operator** op);
void recon_operator_free(recon_operator* op);
/* The components of `out` for a field of so many components: for each of these the numbers of
 * the operator, du/dx, du/dy, du/dz for a gradient; for divergence, curl and strain_rate, which
 * take a vector field, their own. 0 where such a field is not taken. */
int recon_operator_components(const recon_operator* op, int of_field);
recon_status recon_operator_apply(const recon_operator* op, recon_array field, recon_array out);
recon_status recon_operator_apply_transpose(const recon_operator* op, recon_array field,
                                            recon_array out);
/* op += factor * other, for operators of one fit. */
recon_status recon_operator_add(recon_operator* op, double factor, const recon_operator* other);

/* Fields at the nodes of a grid, mostly without lists of neighbours: a value per node.
 * `gradients` is NULL, or "diffuse" or "exact"; its `gradients_out` has component c * dimension
 * + d for d u_c / d x_d, and is not looked at without it. */
recon_status recon_on_grid(recon_array points, recon_array field, recon_grid grid,
                           const recon_options* options, recon_array out, const char* gradients,
                           recon_array gradients_out);

/* ---- files (where recon is built with recon::io)
 * ------------------------------------------------------ */

typedef struct recon_table recon_table;

/* One frame of a file, counted from 0, or from the end (-1 is the last). */
recon_status recon_read(const char* path, int frame, recon_table** table);
void recon_table_free(recon_table* table);
size_t recon_table_size(const recon_table* table);
/* A column, which lives as long as the table. */
recon_status recon_table_column(const recon_table* table, const char* name, const double** column);
/* The positions, which live as long as the table. */
recon_status recon_table_positions(const recon_table* table, recon_array* positions);

/* ---- the material point method (where recon is built with recon::mpm)
 * ---------------------------------- */

typedef struct recon_simulation recon_simulation;

/* A problem file, and settings "key=value" that replace values of it. */
recon_status recon_simulation_new(const char* path, const char* const* settings, size_t count,
                                  recon_simulation** simulation);
void recon_simulation_free(recon_simulation* simulation);
int recon_simulation_dimension(const recon_simulation* simulation);
size_t recon_simulation_particles(const recon_simulation* simulation);
double recon_simulation_time(const recon_simulation* simulation);
/* The end of the problem, infinity where it has none. */
double recon_simulation_end(const recon_simulation* simulation);
/* The step that the rule of the problem gives. */
recon_status recon_simulation_choose_step(const recon_simulation* simulation, double* dt);
recon_status recon_simulation_step(recon_simulation* simulation, double dt);
/* Steps of the problem's rule until this time, to rounding. */
recon_status recon_simulation_run_until(recon_simulation* simulation, double time);
/* What particles carry, as it is now: x, X, v (length `dimension` each), F, L, stress,
 * half_edges (row after row), mass, volume0, energy. Valid until the next step. */
recon_status recon_simulation_array(const recon_simulation* simulation, const char* name,
                                    recon_array* array);

#ifdef __cplusplus
}
#endif
#endif
