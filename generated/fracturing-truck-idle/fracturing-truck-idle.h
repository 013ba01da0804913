/* fracturing-truck-idle: equations of motion of a driveline in C, with their Runge-Kutta solver. Written by modelgen.
 *
 * C99 that is also C++. Nothing is global, nothing is allocated, nothing recurs: all memory is in the caller's structs, so any
 * number of runs may go on side by side. Units are SI. Build the program that prints the default case:
 *
 *     cc -std=c99 -O2 fracturing-truck-idle.c fracturing-truck-idle_solver.c -lm -o fracturing-truck-idle
 *
 * Default case: from the static state under the mean torques at time 0, 201 outputs up to 0.04 s, tolerance 1e-11.
 *
 * In real time, with steps of constant size and cost:
 *
 *     fracturing_truck_idle_run run;
 *     int status = fracturing_truck_idle_init(&run, 0.0, 0, 0);
 *     for (long k = 1; status == fracturing_truck_idle_OK; ++k) status = fracturing_truck_idle_step(&run, 1e-5 * (double)k);
 *
 * With error control:
 *
 *     fracturing_truck_idle_begin(&run, end, tolerance);
 *     while (status == fracturing_truck_idle_OK && run.time < end) status = fracturing_truck_idle_advance(&run);
 *
 * States x:
 *   x[0]  flywheel.angle_deviation [rad]
 *   x[1]  crank_end.twist [rad]
 *   x[2]  coupling.twist [rad]
 *   x[3]  crank_5.twist [rad]
 *   x[4]  transmission_mesh.approach [m]
 *   x[5]  crank_4.twist [rad]
 *   x[6]  propeller_shaft.twist [rad]
 *   x[7]  crank_3.twist [rad]
 *   x[8]  pump_mesh.approach [m]
 *   x[9]  crank_2.twist [rad]
 *   x[10]  pump_crank_end_1.twist [rad]
 *   x[11]  crank_1.twist [rad]
 *   x[12]  pump_crank_1.twist [rad]
 *   x[13]  damper_shaft.twist [rad]
 *   x[14]  pump_crank_2.twist [rad]
 *   x[15]  pump_crank_end_2.twist [rad]
 *   x[16]  flywheel.angle_deviation_rate [rad/s]
 *   x[17]  crank_end.twist_rate [rad/s]
 *   x[18]  coupling.twist_rate [rad/s]
 *   x[19]  crank_5.twist_rate [rad/s]
 *   x[20]  transmission_mesh.approach_rate [m/s]
 *   x[21]  crank_4.twist_rate [rad/s]
 *   x[22]  propeller_shaft.twist_rate [rad/s]
 *   x[23]  crank_3.twist_rate [rad/s]
 *   x[24]  pump_mesh.approach_rate [m/s]
 *   x[25]  crank_2.twist_rate [rad/s]
 *   x[26]  pump_crank_end_1.twist_rate [rad/s]
 *   x[27]  crank_1.twist_rate [rad/s]
 *   x[28]  pump_crank_1.twist_rate [rad/s]
 *   x[29]  damper_shaft.twist_rate [rad/s]
 *   x[30]  pump_crank_2.twist_rate [rad/s]
 *   x[31]  pump_crank_end_2.twist_rate [rad/s]
 */
#ifndef fracturing_truck_idle_INCLUDED
#define fracturing_truck_idle_INCLUDED
#ifdef __cplusplus
extern "C" {
#endif

enum {
  fracturing_truck_idle_X = 32, /* states */
  fracturing_truck_idle_P = 194, /* parameters */
  fracturing_truck_idle_Y = 199, /* outputs */
  fracturing_truck_idle_J = 106, /* entries of the Jacobian that are not always zero */
  fracturing_truck_idle_C = 623, /* values prepared from the parameters */
  fracturing_truck_idle_W = 38  /* values that depend on time only */
};

/* What a function returns: done; a rate or state is no finite number; the error control asks for steps below the smallest;
 * a state is further than 1e10 scales from its start. The run then stays at the last good time. */
enum { fracturing_truck_idle_OK, fracturing_truck_idle_NOT_FINITE, fracturing_truck_idle_STEP_TOO_SMALL, fracturing_truck_idle_DIVERGED };

/* The default case. */
#define fracturing_truck_idle_END 0.04
#define fracturing_truck_idle_SAMPLES 201
#define fracturing_truck_idle_TOLERANCE 1e-11

/* Names and units; values of the parameters; a start and the scales that the tolerance refers to. */
extern const char *const fracturing_truck_idle_state_names[fracturing_truck_idle_X];
extern const char *const fracturing_truck_idle_state_units[fracturing_truck_idle_X];
extern const double fracturing_truck_idle_start[fracturing_truck_idle_X];
extern const double fracturing_truck_idle_scale[fracturing_truck_idle_X];
extern const char *const fracturing_truck_idle_parameter_names[fracturing_truck_idle_P];
extern const char *const fracturing_truck_idle_parameter_units[fracturing_truck_idle_P];
extern const double fracturing_truck_idle_parameter_values[fracturing_truck_idle_P];
/* 1: other entries were computed from this one, which C does not do anew. */
extern const unsigned char fracturing_truck_idle_parameter_is_source[fracturing_truck_idle_P];
extern const char *const fracturing_truck_idle_output_names[fracturing_truck_idle_Y];
extern const char *const fracturing_truck_idle_output_units[fracturing_truck_idle_Y];
/* Row and column of each entry of the Jacobian, column by column. */
extern const int fracturing_truck_idle_jacobian_rows[fracturing_truck_idle_J];
extern const int fracturing_truck_idle_jacobian_columns[fracturing_truck_idle_J];

/* The equations by themselves: once per set of parameters p[fracturing_truck_idle_P] prepare c[fracturing_truck_idle_C], then at any time [s] and state ask for
 * dx/dt, for the outputs, or for the entries of the derivative of dx/dt by x. */
void fracturing_truck_idle_prepare(const double *p, double *c);
void fracturing_truck_idle_rates(const double *c, double t, const double *x, double *rates);
void fracturing_truck_idle_outputs(const double *c, double t, const double *x, double *outputs);
void fracturing_truck_idle_jacobian(const double *c, double t, const double *x, double *jacobian);

/* One run. The first fields may be read; the rest is memory for the solver. */
typedef struct {
  double time;        /* [s] */
  double time_before; /* start of the last step [s] */
  double c[fracturing_truck_idle_C];  /* the prepared parameters */
  long steps, rejected;

  double origin[fracturing_truck_idle_X], inverse[fracturing_truck_idle_X];   /* the start, and 1 / scale */
  double moved[fracturing_truck_idle_X], slope[fracturing_truck_idle_X];      /* state less origin, so that a large angle costs no digits; its rate */
  double moved_before[fracturing_truck_idle_X], slope_before[fracturing_truck_idle_X], moved_middle[fracturing_truck_idle_X], slope_middle[fracturing_truck_idle_X];
  double moved_end[fracturing_truck_idle_X], slope_end[fracturing_truck_idle_X], slope_half[fracturing_truck_idle_X];
  double place[fracturing_truck_idle_X], rate[fracturing_truck_idle_X], whole[fracturing_truck_idle_X], first[fracturing_truck_idle_X], second[fracturing_truck_idle_X];
  double w[4][fracturing_truck_idle_W];                       /* at the quarters of a step */
  double end, tolerance, next, smallest, last_error;
} fracturing_truck_idle_run;

/* Start a run: x[fracturing_truck_idle_X] and p[fracturing_truck_idle_P], or 0 for the default start and values. */
int fracturing_truck_idle_init(fracturing_truck_idle_run *run, double time, const double *x, const double *p);

/* One step to a later time, without error control: always 11 evaluations, whatever the state. */
int fracturing_truck_idle_step(fracturing_truck_idle_run *run, double until);

/* Error control: begin once, then take one step after the other until run->time is the end. The largest error of a step is
 * tolerance times the scale of each state. A step is tried a few times, at most some hundred; each costs 11 evaluations. */
void fracturing_truck_idle_begin(fracturing_truck_idle_run *run, double end, double tolerance);
int fracturing_truck_idle_advance(fracturing_truck_idle_run *run);

/* The state at a time within the last step (interpolated to fifth order), or at run->time. */
void fracturing_truck_idle_state(const fracturing_truck_idle_run *run, double time, double *x);

#ifdef __cplusplus
}
#endif
#endif
