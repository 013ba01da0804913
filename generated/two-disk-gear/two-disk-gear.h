/* two-disk-gear: equations of motion of a driveline in C, with their Runge-Kutta solver. Written by modelgen.
 *
 * C99 that is also C++. Nothing is global, nothing is allocated, nothing recurs: all memory is in the caller's structs, so any
 * number of runs may go on side by side. Units are SI. Build the program that prints the default case:
 *
 *     cc -std=c99 -O2 two-disk-gear.c two-disk-gear_solver.c -lm -o two-disk-gear
 *
 * Default case: from the static state under the mean torques at time 0, 201 outputs up to 0.02 s, tolerance 1e-11.
 *
 * In real time, with steps of constant size and cost:
 *
 *     two_disk_gear_run run;
 *     int status = two_disk_gear_init(&run, 0.0, 0, 0);
 *     for (long k = 1; status == two_disk_gear_OK; ++k) status = two_disk_gear_step(&run, 1e-5 * (double)k);
 *
 * With error control:
 *
 *     two_disk_gear_begin(&run, end, tolerance);
 *     while (status == two_disk_gear_OK && run.time < end) status = two_disk_gear_advance(&run);
 *
 * States x:
 *   x[0]  pinion.angle_deviation [rad]
 *   x[1]  mesh.approach [m]
 *   x[2]  pinion.angle_deviation_rate [rad/s]
 *   x[3]  mesh.approach_rate [m/s]
 */
#ifndef two_disk_gear_INCLUDED
#define two_disk_gear_INCLUDED
#ifdef __cplusplus
extern "C" {
#endif

enum {
  two_disk_gear_X = 4, /* states */
  two_disk_gear_P = 47, /* parameters */
  two_disk_gear_Y = 30, /* outputs */
  two_disk_gear_J = 6, /* entries of the Jacobian that are not always zero */
  two_disk_gear_C = 61, /* values prepared from the parameters */
  two_disk_gear_W = 14  /* values that depend on time only */
};

/* What a function returns: done; a rate or state is no finite number; the error control asks for steps below the smallest;
 * a state is further than 1e10 scales from its start. The run then stays at the last good time. */
enum { two_disk_gear_OK, two_disk_gear_NOT_FINITE, two_disk_gear_STEP_TOO_SMALL, two_disk_gear_DIVERGED };

/* The default case. */
#define two_disk_gear_END 0.02
#define two_disk_gear_SAMPLES 201
#define two_disk_gear_TOLERANCE 1e-11

/* Names and units; values of the parameters; a start and the scales that the tolerance refers to. */
extern const char *const two_disk_gear_state_names[two_disk_gear_X];
extern const char *const two_disk_gear_state_units[two_disk_gear_X];
extern const double two_disk_gear_start[two_disk_gear_X];
extern const double two_disk_gear_scale[two_disk_gear_X];
extern const char *const two_disk_gear_parameter_names[two_disk_gear_P];
extern const char *const two_disk_gear_parameter_units[two_disk_gear_P];
extern const double two_disk_gear_parameter_values[two_disk_gear_P];
/* 1: other entries were computed from this one, which C does not do anew. */
extern const unsigned char two_disk_gear_parameter_is_source[two_disk_gear_P];
extern const char *const two_disk_gear_output_names[two_disk_gear_Y];
extern const char *const two_disk_gear_output_units[two_disk_gear_Y];
/* Row and column of each entry of the Jacobian, column by column. */
extern const int two_disk_gear_jacobian_rows[two_disk_gear_J];
extern const int two_disk_gear_jacobian_columns[two_disk_gear_J];

/* The equations by themselves: once per set of parameters p[two_disk_gear_P] prepare c[two_disk_gear_C], then at any time [s] and state ask for
 * dx/dt, for the outputs, or for the entries of the derivative of dx/dt by x. */
void two_disk_gear_prepare(const double *p, double *c);
void two_disk_gear_rates(const double *c, double t, const double *x, double *rates);
void two_disk_gear_outputs(const double *c, double t, const double *x, double *outputs);
void two_disk_gear_jacobian(const double *c, double t, const double *x, double *jacobian);

/* One run. The first fields may be read; the rest is memory for the solver. */
typedef struct {
  double time;        /* [s] */
  double time_before; /* start of the last step [s] */
  double c[two_disk_gear_C];  /* the prepared parameters */
  long steps, rejected;

  double origin[two_disk_gear_X], inverse[two_disk_gear_X];   /* the start, and 1 / scale */
  double moved[two_disk_gear_X], slope[two_disk_gear_X];      /* state less origin, so that a large angle costs no digits; its rate */
  double moved_before[two_disk_gear_X], slope_before[two_disk_gear_X], moved_middle[two_disk_gear_X], slope_middle[two_disk_gear_X];
  double moved_end[two_disk_gear_X], slope_end[two_disk_gear_X], slope_half[two_disk_gear_X];
  double place[two_disk_gear_X], rate[two_disk_gear_X], whole[two_disk_gear_X], first[two_disk_gear_X], second[two_disk_gear_X];
  double w[4][two_disk_gear_W];                       /* at the quarters of a step */
  double end, tolerance, next, smallest, last_error;
} two_disk_gear_run;

/* Start a run: x[two_disk_gear_X] and p[two_disk_gear_P], or 0 for the default start and values. */
int two_disk_gear_init(two_disk_gear_run *run, double time, const double *x, const double *p);

/* One step to a later time, without error control: always 11 evaluations, whatever the state. */
int two_disk_gear_step(two_disk_gear_run *run, double until);

/* Error control: begin once, then take one step after the other until run->time is the end. The largest error of a step is
 * tolerance times the scale of each state. A step is tried a few times, at most some hundred; each costs 11 evaluations. */
void two_disk_gear_begin(two_disk_gear_run *run, double end, double tolerance);
int two_disk_gear_advance(two_disk_gear_run *run);

/* The state at a time within the last step (interpolated to fifth order), or at run->time. */
void two_disk_gear_state(const two_disk_gear_run *run, double time, double *x);

#ifdef __cplusplus
}
#endif
#endif
