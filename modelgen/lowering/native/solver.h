/* Adaptive Runge-Kutta 4 by step doubling around the three stages: the loop of solvers/march.py (rule "smooth") and the outputs of
 * solvers/dense_output.py, for LANES trajectories side by side, each with its own time, step and error.
 *
 * All memory is the caller's; nothing is global, nothing is allocated. A lane whose step fails keeps its state; a lane that has
 * finished takes the next job. Slopes are asked for at four new times per step (the quarters), so the time stage runs for four times at once. */
#ifdef SINGLE
#define LANES 1
typedef double S;
typedef s_mask S_MASK;
#define S_(name) s_##name
#define LANE(a, i) (a)
#define ANY(m) (m)
#define TIME_VALUE double
#define TIME_STRIDE WIDTH
#define TIME_PARAMETER(a) v_all(a)
#else
#define LANES WIDTH
typedef V S;
typedef v_mask S_MASK;
#define S_(name) v_##name
#define LANE(a, i) (a)[i]
#define ANY(m) v_any(m)
#define TIME_VALUE V
#define TIME_STRIDE 4
#define TIME_PARAMETER(a) (a)
#endif
#include "stages.h"

enum { RUNNING, SUCCESS, MAX_STEPS, STEP_TOO_SMALL, NON_FINITE_RATE, DIVERGED };
enum { OUTCOME, STEPS, REJECTED, EVALUATIONS, REACHED, STOP, COUNTS };
enum { TIME, SIZE, SMALLEST, LARGEST, FACTS };

typedef struct {
  int64_t jobs, samples, times_stride; /* stride 0: all jobs share their output times */
  int64_t *next;                       /* job to take next, shared by all threads */
  const double *p, *x0, *scale, *times; /* [jobs][NP], [jobs][NX], [jobs][NX], [jobs or 1][samples] */
  double *states;                      /* [jobs][samples][NX], counted from x0 */
  double *last;                        /* [jobs][2][NX]: where the run stands, and where a diverged step led to, from x0 */
  double *extrema;                     /* [jobs][2][NX]: lowest and highest state from the first output time on, from x0, or NULL */
  int64_t *counts;                     /* [jobs][COUNTS]; the caller may set STOP */
  double *facts;                       /* [jobs][FACTS] */
  double begin, tolerance, first_step, largest_step, smallest_step, bound, correction; /* first_step 0: estimated */
  int64_t max_steps;
} Task;

typedef struct {
  S c[NC + 1], x0[NX], inverse[NX], y[NX], slope[NX], low[NX], high[NX]; /* what stays between steps */
  S base[NX], x[NX], k[NX], whole[NX], first[NX], second[NX], middle_slope[NX], y_middle[NX], y_end[NX], end_slope[NX];
  V w[4 * NW + 1];
  S time, step, until, accepted, recording; /* as lanes see them */
  double t[LANES], h[LANES], t_new[LANES], log_before[LANES], growth[LANES], end[LANES], floor[LANES], smallest[LANES], largest[LANES];
  int64_t job[LANES], steps[LANES], tried[LANES], rejected[LANES], evaluations[LANES], reached[LANES];
  double one_c[NC + 1];
} Work;

INLINE void put(S *a, int lane, double value) { ((double *)a)[lane] = value; }
INLINE double get(const S *a, int lane) { return ((const double *)a)[lane]; }

#ifdef SINGLE
static void times_at(Work *k, double t, double h) {
#if NW
  V quarters = {0.25, 0.5, 0.75, 1.0};
  time_stage(k->c, t + quarters * h, k->w);
#else
  (void)k, (void)t, (void)h;
#endif
}
#define W_AT(k, quarter) ((const double *)(k)->w + (quarter) - 1)
#else
static void times_at(Work *k, V t, V h) {
#if NW
  V quarters[4] = {t + 0.25 * h, t + 0.5 * h, t + 0.75 * h, t + h};
  time_stage(k->c, quarters, k->w);
#else
  (void)k, (void)t, (void)h;
#endif
}
#define W_AT(k, quarter) ((k)->w + (quarter) - 1)
#endif

/* What the state gains over a step h from base with the slope given there. */
static void increment(Work *k, const TIME_VALUE *middle, const TIME_VALUE *end, S h, const S *base, const S *slope, S *gain) {
  S half = h / 2, sixth = h / 6;
  S *x = k->x, *r = k->k;
  for (int i = 0; i < NX; ++i) x[i] = base[i] + half * slope[i];
  state_stage(k->c, middle, x, r);
  for (int i = 0; i < NX; ++i) gain[i] = slope[i] + 2.0 * r[i], x[i] = base[i] + half * r[i];
  state_stage(k->c, middle, x, r);
  for (int i = 0; i < NX; ++i) gain[i] = gain[i] + 2.0 * r[i], x[i] = base[i] + h * r[i];
  state_stage(k->c, end, x, r);
  for (int i = 0; i < NX; ++i) gain[i] = sixth * (gain[i] + r[i]);
}

/* One step and two of half the size; error: largest difference in scales; guard: finite only if everything is. */
static void try_step(Work *k, double correction, S *error, S *guard, S *size) {
  S h = k->step, worst = S_(all)(0.0), sum = S_(all)(0.0), far = S_(all)(0.0);
  times_at(k, k->time, h);
  for (int i = 0; i < NX; ++i) k->base[i] = k->x0[i] + k->y[i];
  increment(k, W_AT(k, 2), W_AT(k, 4), h, k->base, k->slope, k->whole);
  increment(k, W_AT(k, 1), W_AT(k, 2), h / 2, k->base, k->slope, k->first);
  for (int i = 0; i < NX; ++i) k->base[i] = k->base[i] + k->first[i];
  state_stage(k->c, W_AT(k, 2), k->base, k->middle_slope);
  increment(k, W_AT(k, 3), W_AT(k, 4), h / 2, k->base, k->middle_slope, k->second);
  for (int i = 0; i < NX; ++i) {
    S both = k->first[i] + k->second[i], difference = both - k->whole[i], corrected = correction * difference;
    k->y_middle[i] = k->y[i] + (k->first[i] + corrected / 2);
    k->y_end[i] = k->y[i] + (both + corrected);
    k->x[i] = k->x0[i] + k->y_end[i];
    S relative = difference * k->inverse[i], place = k->y_end[i] * k->inverse[i];
    worst = S_(fmax)(worst, S_(fabs)(relative));
    far = S_(fmax)(far, S_(fabs)(place));
    sum = sum + place * place + relative * relative;
  }
  state_stage(k->c, W_AT(k, 4), k->x, k->end_slope);
  for (int i = 0; i < NX; ++i) {
    S move = h * k->end_slope[i] * k->inverse[i];
    sum = sum + move * move;
  }
  *error = worst, *guard = sum, *size = far;
}

/* Report where a lane stands: at its end, and whenever the caller gets control. */
static void report(const Task *task, const Work *k, int lane, int64_t outcome) {
  int64_t job = k->job[lane], *counts = task->counts + job * COUNTS;
  double *facts = task->facts + job * FACTS, *last = task->last + 2 * job * NX;
  counts[OUTCOME] = outcome, counts[STEPS] = k->steps[lane], counts[REJECTED] = k->rejected[lane];
  counts[EVALUATIONS] = k->evaluations[lane] + 11 * k->tried[lane], counts[REACHED] = k->reached[lane];
  facts[TIME] = k->t[lane], facts[SIZE] = k->h[lane], facts[SMALLEST] = k->smallest[lane], facts[LARGEST] = k->largest[lane];
  for (int i = 0; i < NX; ++i) last[i] = get(&k->y[i], lane), last[NX + i] = get(&k->y_end[i], lane);
  if (task->extrema)
    for (int i = 0; i < NX; ++i) {
      task->extrema[2 * job * NX + i] = get(&k->low[i], lane);
      task->extrema[(2 * job + 1) * NX + i] = get(&k->high[i], lane);
    }
}

static void finish(const Task *task, Work *k, int lane, int64_t outcome) {
  report(task, k, lane, outcome);
  k->job[lane] = -1, k->h[lane] = 0.0;
}

/* Outputs between t and t_new: the quintic through start, middle and end of the step. */
static void write_outputs(const Task *task, Work *k, int lane) {
  int64_t job = k->job[lane];
  const double *times = task->times + job * task->times_stride;
  double start = k->t[lane], width = k->t_new[lane] - start;
  for (int64_t n = k->reached[lane]; n < task->samples && times[n] <= k->t_new[lane]; k->reached[lane] = ++n) {
    double *out = task->states + (job * task->samples + n) * NX;
    double theta = (times[n] - start) / width;
    double a = 2 * (theta - 0.5) * (theta - 1), b = -4 * theta * (theta - 1), c = 2 * theta * (theta - 0.5);
    a *= a, b *= b, c *= c;
    double slope_a = theta * a * width, slope_b = (theta - 0.5) * b * width, value_c = (7 - 6 * theta) * c, slope_c = (theta - 1) * c * width;
    for (int i = 0; i < NX; ++i) {
      double y = get(&k->y[i], lane);
      out[i] = y + slope_a * get(&k->slope[i], lane) + b * (get(&k->y_middle[i], lane) - y) + slope_b * get(&k->middle_slope[i], lane) +
               value_c * (get(&k->y_end[i], lane) - y) + slope_c * get(&k->end_slope[i], lane);
    }
  }
}

static double smaller(double a, double b) { return b < a ? b : a; }
static double larger(double a, double b) { return b > a ? b : a; }

/* A size at most as large as wanted, and the time that it leads to: no sliver is left before the end. */
static void clip(const Task *task, Work *k, int lane) {
  double h = smaller(k->h[lane], task->largest_step), left = k->end[lane] - k->t[lane];
  if (h >= left) {
    k->h[lane] = left, k->t_new[lane] = k->end[lane];
  } else {
    k->t_new[lane] = k->t[lane] + (2 * h > left ? left / 2 : h);
    k->h[lane] = k->t_new[lane] - k->t[lane];
  }
}

/* Give idle lanes the next jobs: parameters, start, slope there, first step (Hairer's rule). Whether any lane is at work. */
static int take_jobs(const Task *task, Work *k) {
  for (;;) {
    double unit[LANES], speed[LANES];
    int taken[LANES], any = 0, busy = 0;
    for (int lane = 0; lane < LANES; ++lane) {
      taken[lane] = 0, unit[lane] = 0.0;
      if (k->job[lane] >= 0) {
        busy = 1;
        continue;
      }
      int64_t job = __atomic_load_n(task->next, __ATOMIC_RELAXED);
      if (job >= task->jobs || (job = __atomic_fetch_add(task->next, 1, __ATOMIC_RELAXED)) >= task->jobs) continue;
      any = taken[lane] = 1;
      const double *times = task->times + job * task->times_stride;
      parameter_stage(task->p + job * NP, k->one_c);
      for (int i = 0; i < NC; ++i) put(&k->c[i], lane, k->one_c[i]);
      for (int i = 0; i < NX; ++i) {
        put(&k->x0[i], lane, task->x0[job * NX + i]), put(&k->inverse[i], lane, 1.0 / task->scale[job * NX + i]);
        put(&k->y[i], lane, 0.0), put(&k->y_end[i], lane, 0.0);
        put(&k->low[i], lane, times[0] == task->begin ? 0.0 : INFINITY), put(&k->high[i], lane, times[0] == task->begin ? 0.0 : -INFINITY);
      }
      k->job[lane] = job, k->t[lane] = task->begin, k->end[lane] = times[task->samples - 1];
      double reach = larger(fabs(k->t[lane]), fabs(k->end[lane]));
      k->floor[lane] = larger(task->smallest_step * (k->end[lane] - k->t[lane]), 4 * (nextafter(reach, INFINITY) - reach));
      k->steps[lane] = k->tried[lane] = k->rejected[lane] = 0, k->evaluations[lane] = 1;
      k->smallest[lane] = INFINITY, k->largest[lane] = 0.0, k->log_before[lane] = 0.0, k->growth[lane] = 5.0, k->h[lane] = 0.0;
      k->reached[lane] = times[0] == task->begin;
      if (k->reached[lane]) memset(task->states + job * task->samples * NX, 0, NX * sizeof(double));
    }
    if (!any) return busy;
    memcpy(&k->time, k->t, sizeof(S));
    k->step = S_(all)(0.0);
    times_at(k, k->time, k->step);
    for (int i = 0; i < NX; ++i) k->x[i] = k->x0[i] + k->y[i];
    state_stage(k->c, W_AT(k, 4), k->x, k->k);
    for (int lane = 0; lane < LANES; ++lane) {
      if (!taken[lane]) continue;
      int finite = 1;
      speed[lane] = 0.0;
      for (int i = 0; i < NX; ++i) {
        double slope = get(&k->k[i], lane);
        put(&k->slope[i], lane, slope);
        finite &= isfinite(slope) != 0;
        speed[lane] = larger(speed[lane], fabs(slope * get(&k->inverse[i], lane)));
      }
      double horizon = k->end[lane] - k->t[lane];
      unit[lane] = smaller(smaller(speed[lane] > 0 ? 0.01 / speed[lane] : 1e-6 * horizon, horizon), task->largest_step);
      if (horizon > 0 && !finite) k->h[lane] = k->floor[lane], finish(task, k, lane, NON_FINITE_RATE), taken[lane] = 0;
      if (!(horizon > 0)) finish(task, k, lane, SUCCESS), taken[lane] = 0;
    }
    memcpy(&k->step, unit, sizeof(S));
    times_at(k, k->time, k->step);
    for (int i = 0; i < NX; ++i) k->x[i] = k->x0[i] + (k->y[i] + k->step * k->slope[i]);
    state_stage(k->c, W_AT(k, 4), k->x, k->k);
    for (int lane = 0; lane < LANES; ++lane) {
      if (!taken[lane]) continue;
      double bend = 0.0, h = task->first_step;
      if (!(h > 0)) {
        for (int i = 0; i < NX; ++i) {
          double turn = fabs((get(&k->k[i], lane) - get(&k->slope[i], lane)) * get(&k->inverse[i], lane));
          bend = turn > bend || turn != turn ? turn : bend; /* NaN stays */
        }
        double size = larger(unit[lane] * speed[lane], unit[lane] * bend);
        ++k->evaluations[lane];
        h = unit[lane] * smaller(100.0, size > 0 ? pow(0.01 * task->tolerance / size, 0.2) : 100.0);
        if (!isfinite(unit[lane] * bend) || !isfinite(size)) h = k->floor[lane];
      }
      k->h[lane] = larger(h, k->floor[lane]);
    }
  }
}

/* Decide on the step that was tried: 1 if the lane takes it over. */
static int judge(const Task *task, Work *k, int lane, double difference, double guard, double size) {
  double h = k->h[lane], error = difference / task->tolerance;
  ++k->tried[lane];
  if (!(guard <= task->bound * task->bound)) {
    if (!isfinite(guard)) {
      error = INFINITY;
    } else if (error <= 1 && size > task->bound) {
      finish(task, k, lane, DIVERGED);
      return 0;
    }
  }
  if (error > 1) {
    double factor = error < INFINITY ? 0.9 * pow(error, -0.2) : 0.0;
    ++k->rejected[lane];
    k->h[lane] = h * larger(0.2, factor), k->growth[lane] = 1.0; /* it grows not at once after a rejection */
    if (k->h[lane] < k->floor[lane]) k->h[lane] = k->floor[lane], finish(task, k, lane, STEP_TOO_SMALL);
    return 0;
  }
  write_outputs(task, k, lane);
  ++k->steps[lane];
  k->largest[lane] = larger(k->largest[lane], h);
  if (k->t_new[lane] < k->end[lane] || !(k->smallest[lane] < INFINITY)) k->smallest[lane] = smaller(k->smallest[lane], h);
  double log_error = log(larger(error, 1e-10)); /* error^(-0.85/5) before^(0.2/5) by one logarithm and one exponential */
  double factor = 0.9 * exp(-0.85 * 0.2 * log_error + 0.2 * 0.2 * k->log_before[lane]);
  k->h[lane] = larger(k->floor[lane], h * smaller(k->growth[lane], larger(0.2, factor)));
  k->log_before[lane] = log_error, k->growth[lane] = 5.0, k->t[lane] = k->t_new[lane];
  return 1;
}

int64_t modelgen_sizes(int64_t which) {
  const int64_t sizes[] = {NX, NP, LANES, sizeof(Work), sizeof(Task), NC, NW};
  return which >= 0 && which < 7 ? sizes[which] : -1;
}

/* The rates at one place, for checks: every lane computes the same; lane 0 is given back. */
void modelgen_rates(Work *k, double t, const double *x, const double *p, double *rates) {
  parameter_stage(p, k->one_c);
  for (int i = 0; i < NC; ++i) k->c[i] = S_(all)(k->one_c[i]);
  for (int i = 0; i < NX; ++i) k->x[i] = S_(all)(x[i]);
  times_at(k, S_(all)(t), S_(all)(0.0));
  state_stage(k->c, W_AT(k, 4), k->x, k->k);
  for (int i = 0; i < NX; ++i) rates[i] = get(&k->k[i], 0);
}

/* Before the first call on a piece of work. */
void modelgen_start(Work *k) {
  memset(k, 0, sizeof(Work));
  for (int lane = 0; lane < LANES; ++lane) k->job[lane] = -1;
}

/* The job that a lane works on, or -1. */
int64_t modelgen_job(const Work *k, int64_t lane) { return lane >= 0 && lane < LANES ? k->job[lane] : -1; }

/* At most so many more steps; whether anything is left to do. */
int64_t modelgen_run(const Task *task, Work *k, int64_t steps) {
  for (int lane = 0; lane < LANES; ++lane)
    if (k->job[lane] >= 0 && task->counts[k->job[lane] * COUNTS + STOP]) finish(task, k, lane, RUNNING);
  while (take_jobs(task, k)) {
    double accepted[LANES], recording[LANES];
    int any = 0;
    if (steps-- <= 0) {
      for (int lane = 0; lane < LANES; ++lane)
        if (k->job[lane] >= 0) report(task, k, lane, RUNNING);
      return 1;
    }
    for (int lane = 0; lane < LANES; ++lane) {
      if (k->job[lane] < 0) continue;
      clip(task, k, lane);
      if (k->tried[lane] >= task->max_steps) finish(task, k, lane, MAX_STEPS);
    }
    memcpy(&k->time, k->t, sizeof(S)), memcpy(&k->step, k->h, sizeof(S));
    S error, guard, size;
    try_step(k, task->correction, &error, &guard, &size);
    for (int lane = 0; lane < LANES; ++lane) {
      double first = k->job[lane] < 0 ? 0.0 : task->times[k->job[lane] * task->times_stride];
      accepted[lane] = k->job[lane] >= 0 && judge(task, k, lane, LANE(error, lane), LANE(guard, lane), LANE(size, lane));
      recording[lane] = accepted[lane] != 0 && get(&k->time, lane) >= first;
      any |= recording[lane] != 0;
    }
    memcpy(&k->accepted, accepted, sizeof(S)), memcpy(&k->recording, recording, sizeof(S));
    S_MASK take = k->accepted != S_(all)(0.0), record = k->recording != S_(all)(0.0);
    for (int i = 0; i < NX; ++i) {
      k->y[i] = S_(select)(take, k->y_end[i], k->y[i]);
      k->slope[i] = S_(select)(take, k->end_slope[i], k->slope[i]);
    }
    if (any && task->extrema)
      for (int i = 0; i < NX; ++i) {
        S below = S_(fmin)(k->y_middle[i], k->y_end[i]), above = S_(fmax)(k->y_middle[i], k->y_end[i]);
        k->low[i] = S_(select)(record, S_(fmin)(k->low[i], below), k->low[i]);
        k->high[i] = S_(select)(record, S_(fmax)(k->high[i], above), k->high[i]);
      }
    for (int lane = 0; lane < LANES; ++lane)
      if (k->job[lane] >= 0 && accepted[lane] != 0 && !(k->t[lane] < k->end[lane])) finish(task, k, lane, SUCCESS);
  }
  return 0;
}
