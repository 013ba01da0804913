/* $name: equations of motion of a driveline in C, with their Runge-Kutta solver. Written by modelgen.
 *
 * C99 that is also C++. Nothing is global, nothing is allocated, nothing recurs: all memory is in the caller's structs, so any
 * number of runs may go on side by side. Units are SI. Build the program that prints the default case:
 *
 *     cc -std=c99 -O2 $name.c ${name}_solver.c -lm -o $name
 *
 * Default case: from the static state under the mean torques at time 0, $samples outputs up to $end s, tolerance $tolerance.
 *
 * In real time, with steps of constant size and cost:
 *
 *     MODEL_run run;
 *     int status = MODEL_init(&run, 0.0, 0, 0);
 *     for (long k = 1; status == MODEL_OK; ++k) status = MODEL_step(&run, 1e-5 * (double)k);
 *
 * With error control:
 *
 *     MODEL_begin(&run, end, tolerance);
 *     while (status == MODEL_OK && run.time < end) status = MODEL_advance(&run);
 *
 * States x:
$states
 */
#ifndef MODEL_INCLUDED
#define MODEL_INCLUDED
#ifdef __cplusplus
extern "C" {
#endif

enum {
  MODEL_X = $X, /* states */
  MODEL_P = $P, /* parameters */
  MODEL_Y = $Y, /* outputs */
  MODEL_J = $J, /* entries of the Jacobian that are not always zero */
  MODEL_C = $C, /* values prepared from the parameters */
  MODEL_W = $W  /* values that depend on time only */
};

/* What a function returns: done; a rate or state is no finite number; the error control asks for steps below the smallest;
 * a state is further than 1e10 scales from its start. The run then stays at the last good time. */
enum { MODEL_OK, MODEL_NOT_FINITE, MODEL_STEP_TOO_SMALL, MODEL_DIVERGED };

/* The default case. */
#define MODEL_END $end
#define MODEL_SAMPLES $samples
#define MODEL_TOLERANCE $tolerance

/* Names and units; values of the parameters; a start and the scales that the tolerance refers to. */
extern const char *const MODEL_state_names[MODEL_X];
extern const char *const MODEL_state_units[MODEL_X];
extern const double MODEL_start[MODEL_X];
extern const double MODEL_scale[MODEL_X];
extern const char *const MODEL_parameter_names[MODEL_P];
extern const char *const MODEL_parameter_units[MODEL_P];
extern const double MODEL_parameter_values[MODEL_P];
/* 1: other entries were computed from this one, which C does not do anew. */
extern const unsigned char MODEL_parameter_is_source[MODEL_P];
extern const char *const MODEL_output_names[MODEL_Y];
extern const char *const MODEL_output_units[MODEL_Y];
/* Row and column of each entry of the Jacobian, column by column. */
extern const int MODEL_jacobian_rows[MODEL_J];
extern const int MODEL_jacobian_columns[MODEL_J];

/* The equations by themselves: once per set of parameters p[MODEL_P] prepare c[MODEL_C], then at any time [s] and state ask for
 * dx/dt, for the outputs, or for the entries of the derivative of dx/dt by x. */
void MODEL_prepare(const double *p, double *c);
void MODEL_rates(const double *c, double t, const double *x, double *rates);
void MODEL_outputs(const double *c, double t, const double *x, double *outputs);
void MODEL_jacobian(const double *c, double t, const double *x, double *jacobian);

/* One run. The first fields may be read; the rest is memory for the solver. */
typedef struct {
  double time;        /* [s] */
  double time_before; /* start of the last step [s] */
  double c[MODEL_C];  /* the prepared parameters */
  long steps, rejected;

  double origin[MODEL_X], inverse[MODEL_X];   /* the start, and 1 / scale */
  double moved[MODEL_X], slope[MODEL_X];      /* state less origin, so that a large angle costs no digits; its rate */
  double moved_before[MODEL_X], slope_before[MODEL_X], moved_middle[MODEL_X], slope_middle[MODEL_X];
  double moved_end[MODEL_X], slope_end[MODEL_X], slope_half[MODEL_X];
  double place[MODEL_X], rate[MODEL_X], whole[MODEL_X], first[MODEL_X], second[MODEL_X];
  double w[4][MODEL_W];                       /* at the quarters of a step */
  double end, tolerance, next, smallest, last_error;
} MODEL_run;

/* Start a run: x[MODEL_X] and p[MODEL_P], or 0 for the default start and values. */
int MODEL_init(MODEL_run *run, double time, const double *x, const double *p);

/* One step to a later time, without error control: always 11 evaluations, whatever the state. */
int MODEL_step(MODEL_run *run, double until);

/* Error control: begin once, then take one step after the other until run->time is the end. The largest error of a step is
 * tolerance times the scale of each state. A step is tried a few times, at most some hundred; each costs 11 evaluations. */
void MODEL_begin(MODEL_run *run, double end, double tolerance);
int MODEL_advance(MODEL_run *run);

/* The state at a time within the last step (interpolated to fifth order), or at run->time. */
void MODEL_state(const MODEL_run *run, double time, double *x);

#ifdef __cplusplus
}
#endif
#endif
