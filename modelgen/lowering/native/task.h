/* What is computed together, and its memory: S is one double where one trajectory runs, else LANES of them side by side.
 *
 * All memory is the caller's; nothing is global, nothing is allocated. Task is shared by all threads of a run; each thread has a Work
 * of its own, followed by what the guards and channels of the model at hand need, and a Log. */
#ifdef SINGLE
#define LANES 1
typedef double S;
typedef s_mask S_MASK;
#define S_(name) s_##name
#define LANE(a, i) (a)
#define CHOOSE(m, a, b) ((m) ? (a) : (b))
INLINE double s_larger(double a, double b) { return a > b ? a : b; } /* b where one is NaN */
#define ANY(m) (m)
#define ONE_LANE(a, lane) (a) /* one lane's value in all slots */
#define TIME_VALUE double
#define TIME_STRIDE BUNDLE
#define TIME_PARAMETER(a) v_all(a)
#define SIDE_BY_SIDE 1 /* values of a time that are computed together, a V each */
#define TIMES_OF(at) (at)[0]
#else
#define LANES WIDTH
typedef V S;
typedef v_mask S_MASK;
#define S_(name) v_##name
#define LANE(a, i) (a)[i]
#define CHOOSE(m, a, b) (((m) & (a)) | (~(m) & (b)))
#define ANY(m) v_any(m)
#define ONE_LANE(a, lane) v_all((a)[lane])
#define TIME_VALUE V
#define TIME_STRIDE BUNDLE
#define TIME_PARAMETER(a) (a)
#define SIDE_BY_SIDE BUNDLE
#define TIMES_OF(at) (at)
#endif
#include "stages.h"

#define EXTRA_BUNDLES ((EXTRA + BUNDLE - 1) / BUNDLE) /* of times that only the dense output needs */
#include "records.h"

typedef struct {
  double time;
  int64_t crossing;
} Found;

enum { FINDS = 32 }; /* passings of each guard in one step that are kept */

enum { FIRST, WHOLE }; /* gains of a doubled step */
enum { FOURS = (NX + 3) / 4 * 4 };

typedef struct {
  S k[SLOTS][NX]; /* slopes: that at the start first; END: that at the end */
  S y_middle[NX], y_end[NX], middle_slope[NX];
#if HIGH
  S high[2][NX]; /* what the dense output has beyond a quintic */
#endif
} Trial;

typedef struct {
  S c[NC + 1], x0[NX], inverse[NX], y[NX]; /* what stays between steps */
  Trial now;                                                  /* the step that was tried last */
  S base[NX], x[NX], gain[GAINS + 1][NX];
#ifdef SINGLE
  S measure[MEASURES][FOURS]; /* zeros behind */
#endif
  V w[(BUNDLES + EXTRA_BUNDLES) * BUNDLE * NW + 1];
  S window[WAVES + 1][COEFFICIENTS], window_center[GROUPS + 1], window_scale[GROUPS + 1]; /* see times.h */
  S window_begin[GROUPS + 1], window_end[GROUPS + 1];
  S_MASK suspects;
  S fresh; /* not 0: the lane has just started, and its guards may have other signs than their values */
  S time, step, accepted; /* as lanes see them */
  S log_error, factor;               /* of the step that was tried last */
  double t[LANES], h[LANES], t_new[LANES], until[LANES], due[LANES], log_before[LANES], growth[LANES], end[LANES], floor[LANES];
  double smallest[LANES], largest[LANES], kept_h[LANES], kept_t_new[LANES], longer[LANES];
  int64_t job[LANES], steps[LANES], tried[LANES], rejected[LANES], evaluations[LANES], reached[LANES], grid[LANES], doubling[LANES], halving[LANES], jumped[LANES];
  double one_c[NC + 1], p[LANES][NP + 1];
  double since[LANES], event_time[LANES], early[LANES], late[LANES];
  double stop[LANES], behind[LANES], covers[LANES], asked[LANES], limit[LANES], crossing_break[LANES]; /* break that no step crosses, time behind it; see solver.h */
  int64_t next_break[LANES], returns[LANES];
  int64_t quick[LANES], events[LANES], last_event[LANES], finds[LANES], leapt[LANES];
  int dense_ready, dense_used[LANES];
  V at_x[NX], at_v[NX], at_y[NX]; /* arguments of an observer */
  Trial kept;                     /* the last step that passed, while a longer one is tried (rule PAPER) */
  /* what follows in memory, for the guards and channels at hand */
  V *guard_c, *lane_guard_c, *channel_c, *reset_c, *seen, *channel, *after, *bounds_c, *lane_bounds_c, *bounded;
  S *guard[3], *sign, *active, *watched, *guard_floor;                                       /* guards and rates at start, middle, end; sign at start */
  S *guard_near, *guard_rest, *guard_sampled, *beyond[2];
  double *observer_c, *four; /* four: guards and rates at four times */
  double *fired_at, *graze, *graze_after, *side, *p_before, *g_before; /* graze: when a guard came near zero, NAN or INFINITY (excused) */
  int64_t *modes, *fired, *entered;
  Found *found;
} Work;

INLINE void put(S *a, int lane, double value) { ((double *)a)[lane] = value; }
INLINE double get(const S *a, int lane) { return ((const double *)a)[lane]; }
INLINE S row(const double *a) { S all; memcpy(&all, a, sizeof all); return all; } /* of numbers, one of each lane */
INLINE void put_row(double *a, S all) { memcpy(a, &all, sizeof all); }
INLINE S_MASK is_set(const double *a) { return row(a) != S_(all)(0.0); }
INLINE int has_guards(const Task *task) { return SURFACES && task->crossings; } /* known to the compiler where there are none */

/* Which lanes have a job. */
INLINE S_MASK working(const Work *k) {
#ifdef SINGLE
  return k->job[0] >= 0;
#else
  v_mask job;
  memcpy(&job, k->job, sizeof job);
  return job >= 0;
#endif
}
static double smaller(double a, double b) { return b < a ? b : a; }
static double larger(double a, double b) { return b > a ? b : a; }
static double ulp(double a) { return nextafter(fabs(a), INFINITY) - fabs(a); }

/* The largest size, and the sum of squares, of a row in scales: place, movement, errors. A largest value hides NaN, a sum does not.
 * One trajectory fills a row first and takes four entries at a time, so that none waits for the other; lanes take each as it comes. */
#ifdef SINGLE
#define MEASURE_FROM_ZERO
#define MEASURE(k, n, i, value) (k)->measure[n][i] = (value)
#define LARGEST(k, n) largest((k)->measure[n])
#define SQUARES(k, n) squares((k)->measure[n])
static S largest(const S *a) {
  S most[4] = {S_(fabs)(a[0]), S_(fabs)(a[1]), S_(fabs)(a[2]), S_(fabs)(a[3])};
  for (int i = 4; i < FOURS; i += 4)
    for (int n = 0; n < 4; ++n) most[n] = S_(larger)(S_(fabs)(a[i + n]), most[n]);
  return S_(larger)(S_(larger)(most[0], most[1]), S_(larger)(most[2], most[3]));
}

static S squares(const S *a) {
  S sum[4] = {a[0] * a[0], a[1] * a[1], a[2] * a[2], a[3] * a[3]};
  for (int i = 4; i < FOURS; i += 4)
    for (int n = 0; n < 4; ++n) sum[n] = sum[n] + a[i + n] * a[i + n];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}
#else
typedef struct {
  S largest, squares;
} Measure;
#define MEASURE_FROM_ZERO Measure measure[MEASURES]; for (int n = 0; n < MEASURES; ++n) measure[n].largest = measure[n].squares = S_(all)(0.0);
#define MEASURE(k, n, i, value) take_in(&measure[n], value)
#define LARGEST(k, n) measure[n].largest
#define SQUARES(k, n) measure[n].squares
INLINE void take_in(Measure *m, S value) {
  m->largest = S_(larger)(S_(fabs)(value), m->largest), m->squares = m->squares + value * value;
}
#endif

/* Lay out what follows a Work; with NULL only count the bytes. */
static int64_t lay_out(const Task *task, char *memory, Work *k) {
  int64_t used = 0, g = task->crossings, padded = g + WIDTH, most = task->guards.values;
  if (task->channels.values > most) most = task->channels.values;
  if (task->resets.values > most) most = task->resets.values;
  if (task->bounds.values > most) most = task->bounds.values;
  if (task->rests.values > most) most = task->rests.values;
#define PLACE(name, kind, count) \
  { if (memory) k->name = (kind *)(memory + used); used += ((int64_t)sizeof(kind) * (count) + 63) / 64 * 64; }
  PLACE(guard_c, V, task->guards.values) PLACE(lane_guard_c, V, task->guards.values) PLACE(channel_c, V, task->channels.values)
  PLACE(reset_c, V, task->resets.values + task->rests.values) PLACE(seen, V, task->guards.outputs) PLACE(four, double, 4 * task->guards.outputs) PLACE(channel, V, task->channels.outputs)
  PLACE(after, V, task->resets.outputs) PLACE(sign, S, padded) PLACE(guard_floor, S, padded) PLACE(active, S, padded) PLACE(watched, S, padded)
  PLACE(guard[0], S, 2 * padded) PLACE(guard[1], S, 2 * padded) PLACE(guard[2], S, 2 * padded)
  PLACE(observer_c, double, most) PLACE(modes, int64_t, LANES * task->variables) PLACE(fired, int64_t, LANES * g) PLACE(found, Found, LANES * FINDS * g)
  PLACE(guard_near, S, padded) PLACE(guard_rest, S, padded) PLACE(guard_sampled, S, padded) PLACE(beyond[0], S, padded) PLACE(beyond[1], S, padded)
  PLACE(bounds_c, V, task->bounds.values) PLACE(lane_bounds_c, V, task->bounds.values) PLACE(bounded, V, task->bounds.outputs + task->rests.outputs)
  PLACE(fired_at, double, LANES * g) PLACE(graze, double, LANES * g) PLACE(graze_after, double, LANES * g) PLACE(side, double, LANES * g)
  PLACE(p_before, double, NP) PLACE(g_before, double, g) PLACE(entered, int64_t, LANES * task->variables)
#undef PLACE
  return used;
}

#ifdef SINGLE
#define SLOT_LANE(slot) 0
#else
#define SLOT_LANE(slot) (slot)
#endif

/* A value of one lane in all slots; lane < 0: each slot is a lane. One trajectory fills its slots with times instead. */
INLINE V spread(const S *a, int lane) {
#ifdef SINGLE
  (void)lane;
  return v_all(*a);
#else
  return lane < 0 ? *a : v_all(get(a, lane));
#endif
}
