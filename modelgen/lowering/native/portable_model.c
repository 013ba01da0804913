/* $name: the equations as C functions, their tables of names, and a Runge-Kutta solver; see $name.h. Written by modelgen.
 *
 * A right-hand side falls into what depends on parameters only (MODEL_prepare), on time only (..._at) and on the state (..._of).
 * x, p and the outputs are numbered as in the tables at the end of the equations. */
#include "$name.h"

$stages
/* Tables. */

$tables

/* The solver: the classical Runge-Kutta method of order 4 by one step and two of half the size, whose difference measures the
 * error; a fifteenth of it is added to the result (Richardson). */

static double smaller(double a, double b) { return b < a ? b : a; }
static double larger(double a, double b) { return b > a ? b : a; }

/* What the state gains over a step h from base with the slope given there; w1, w2: time values in its middle and at its end. */
static void increment(MODEL_run *run, const double *w1, const double *w2, double h, const double *base, const double *slope,
                      double *gain) {
  double *place = run->place, *rate = run->rate;
  int i;
  for (i = 0; i < MODEL_X; ++i) place[i] = base[i] + h / 2 * slope[i];
  rates_of(run->c, w1, place, rate);
  for (i = 0; i < MODEL_X; ++i) gain[i] = slope[i] + 2 * rate[i], place[i] = base[i] + h / 2 * rate[i];
  rates_of(run->c, w1, place, rate);
  for (i = 0; i < MODEL_X; ++i) gain[i] += 2 * rate[i], place[i] = base[i] + h * rate[i];
  rates_of(run->c, w2, place, rate);
  for (i = 0; i < MODEL_X; ++i) gain[i] = h / 6 * (gain[i] + rate[i]);
}

/* Try a step from run->time to a later time: its error, the largest in scales. */
static int try_step(MODEL_run *run, double until, double *error) {
  double h = until - run->time, worst = 0, far = 0, sum = 0, base[MODEL_X];
  int i;
  for (i = 0; i < 4; ++i) rates_at(run->c, i < 3 ? run->time + 0.25 * (i + 1) * h : until, run->w[i]);
  for (i = 0; i < MODEL_X; ++i) base[i] = run->origin[i] + run->moved[i];
  increment(run, run->w[1], run->w[3], h, base, run->slope, run->whole);
  increment(run, run->w[0], run->w[1], h / 2, base, run->slope, run->first);
  for (i = 0; i < MODEL_X; ++i) base[i] += run->first[i];
  rates_of(run->c, run->w[1], base, run->slope_half);
  increment(run, run->w[2], run->w[3], h / 2, base, run->slope_half, run->second);
  for (i = 0; i < MODEL_X; ++i) {
    double both = run->first[i] + run->second[i], difference = both - run->whole[i], correction = difference / 15;
    run->moved_middle[i] = run->moved[i] + (run->first[i] + correction / 2);
    run->moved_end[i] = run->moved[i] + (both + correction);
    base[i] = run->origin[i] + run->moved_end[i];
    difference *= run->inverse[i];
    worst = larger(worst, fabs(difference));
    far = larger(far, fabs(run->moved_end[i] * run->inverse[i]));
    sum += difference * difference; /* finite only if everything is */
    sum += run->moved_end[i] * run->inverse[i] * run->moved_end[i] * run->inverse[i];
  }
  rates_of(run->c, run->w[3], base, run->slope_end);
  for (i = 0; i < MODEL_X; ++i) {
    double move = h * run->slope_end[i] * run->inverse[i];
    sum += move * move;
  }
  *error = worst;
  return !isfinite(sum) ? MODEL_NOT_FINITE : far > $BOUND ? MODEL_DIVERGED : MODEL_OK;
}

/* Take over the step that was tried. */
static void accept(MODEL_run *run, double until) {
  int i;
  for (i = 0; i < MODEL_X; ++i) {
    run->moved_before[i] = run->moved[i], run->slope_before[i] = run->slope[i];
    run->moved[i] = run->moved_end[i], run->slope[i] = run->slope_end[i];
    run->slope_middle[i] = run->slope_half[i];
  }
  run->time_before = run->time, run->time = until;
  ++run->steps;
}

int MODEL_init(MODEL_run *run, double time, const double *x, const double *p) {
  double sum = 0;
  int i;
  MODEL_prepare(p ? p : MODEL_parameter_values, run->c);
  for (i = 0; i < MODEL_X; ++i) {
    run->origin[i] = x ? x[i] : MODEL_start[i], run->inverse[i] = 1 / MODEL_scale[i];
    run->moved[i] = run->moved_before[i] = run->moved_middle[i] = 0;
  }
  MODEL_rates(run->c, time, run->origin, run->slope);
  for (i = 0; i < MODEL_X; ++i) {
    run->slope_before[i] = run->slope_middle[i] = run->slope[i];
    sum += 0 * run->slope[i] + 0 * run->origin[i];
  }
  run->time = run->time_before = run->end = time;
  run->steps = run->rejected = 0;
  run->tolerance = MODEL_TOLERANCE, run->next = run->smallest = 0, run->last_error = 1;
  return isfinite(sum) ? MODEL_OK : MODEL_NOT_FINITE;
}

int MODEL_step(MODEL_run *run, double until) {
  double error;
  int status = until > run->time ? try_step(run, until, &error) : MODEL_STEP_TOO_SMALL;
  if (status == MODEL_OK) accept(run, until);
  return status;
}

void MODEL_begin(MODEL_run *run, double end, double tolerance) {
  /* Hairer's starting rule, with time measured in units in which a state moves by a hundredth of its scale. */
  double horizon = end - run->time, reach = larger(fabs(run->time), fabs(end)), speed = 0, bend = 0, sum = 0, unit, size;
  int i;
  run->end = end, run->tolerance = tolerance, run->last_error = 1;
  run->smallest = larger($SMALLEST_STEP * horizon, 4 * (nextafter(reach, INFINITY) - reach));
  run->next = run->smallest;
  if (!(horizon > 0)) return;
  for (i = 0; i < MODEL_X; ++i) speed = larger(speed, fabs(run->slope[i] * run->inverse[i]));
  unit = smaller(speed > 0 ? $FIRST_MOVE / speed : $FIRST_SHARE * horizon, horizon);
  for (i = 0; i < MODEL_X; ++i) run->place[i] = run->origin[i] + (run->moved[i] + unit * run->slope[i]);
  MODEL_rates(run->c, run->time + unit, run->place, run->rate);
  for (i = 0; i < MODEL_X; ++i) {
    double turn = (run->rate[i] - run->slope[i]) * run->inverse[i];
    bend = larger(bend, fabs(turn)), sum += turn;
  }
  size = larger(unit * speed, unit * bend);
  if (isfinite(sum) && isfinite(size))
    run->next = larger(run->smallest, unit * smaller($FIRST_GROWTH, size > 0 ? pow($FIRST_ERROR * tolerance / size, $EXPONENT) : $FIRST_GROWTH));
}

int MODEL_advance(MODEL_run *run) {
  double h = run->next, growth = $LARGEST_GROWTH, error = 0, factor, until;
  for (;;) {
    double left = run->end - run->time;
    int status;
    if (!(left > 0)) return MODEL_OK;
    /* No sliver is left before the end; h is exactly the distance of two times. */
    until = h >= left ? run->end : run->time + (2 * h > left ? left / 2 : h);
    h = until - run->time;
    status = try_step(run, until, &error);
    error = status == MODEL_NOT_FINITE ? INFINITY : error / run->tolerance;
    if (error <= 1 && status == MODEL_DIVERGED) return status;
    if (error <= 1) break;
    ++run->rejected;
    h *= larger($SMALLEST_SHRINK, isfinite(error) ? $SAFETY * pow(error, -$EXPONENT) : 0);
    growth = 1; /* it grows not at once after a rejection */
    if (!(h >= run->smallest)) return status == MODEL_NOT_FINITE ? status : MODEL_STEP_TOO_SMALL;
  }
  accept(run, until);
  error = larger(error, $LEAST_ERROR);
  factor = $SAFETY * pow(error, -$PRESENT_EXPONENT) * pow(run->last_error, $PAST_EXPONENT);
  run->next = larger(run->smallest, h * smaller(growth, larger($SMALLEST_SHRINK, factor)));
  run->last_error = error;
  return MODEL_OK;
}

void MODEL_state(const MODEL_run *run, double time, double *x) {
  double width = run->time - run->time_before, theta = width > 0 ? (time - run->time_before) / width : 1;
  /* Weights of values (a, b, e) and slopes at start, middle and end: Hermite's quintic. The values' weights add up to one. */
  double a = 2 * (theta - 0.5) * (theta - 1), b = -4 * theta * (theta - 1), e = 2 * theta * (theta - 0.5);
  int i;
  a *= a, b *= b, e *= e;
  for (i = 0; i < MODEL_X; ++i) {
    double y = run->moved_before[i];
    x[i] = run->origin[i] +
           (y + theta * a * width * run->slope_before[i] + b * (run->moved_middle[i] - y) +
            (theta - 0.5) * b * width * run->slope_middle[i] + (7 - 6 * theta) * e * (run->moved[i] - y) +
            (theta - 1) * e * width * run->slope[i]);
  }
}
