/* Sizes of steps, as in solvers/march.py: by the error ("smooth"), by halving and doubling (the paper's), or given. */

/* What the caller may read: where a lane stands, at its end and whenever the caller gets control. */
static void report(const Task *task, const Work *k, int lane, int64_t outcome) {
  int64_t job = k->job[lane], *counts = task->counts + job * COUNTS;
  double *facts = task->facts + job * FACTS, *last = task->last + 2 * job * NX;
  counts[OUTCOME] = outcome, counts[STEPS] = k->steps[lane], counts[REJECTED] = k->rejected[lane];
  counts[EVALUATIONS] = k->evaluations[lane] + EVALUATED * k->tried[lane], counts[REACHED] = k->reached[lane];
  counts[EVENTS] = k->events[lane], counts[LAST_EVENT] = k->last_event[lane];
  facts[TIME] = k->t[lane], facts[SIZE] = k->h[lane], facts[SMALLEST] = k->smallest[lane], facts[LARGEST] = k->largest[lane];
  if (task->p_now) memcpy(task->p_now + job * NP, k->p[lane], NP * sizeof(double));
  for (int i = 0; i < NX; ++i) {
    last[i] = get(&k->y[i], lane), last[NX + i] = get(&k->now.y_end[i], lane);
  }
}

static void finish(const Task *task, Work *k, int lane, int64_t outcome) {
  hold(task, k, lane, k->t[lane]);
  report(task, k, lane, outcome);
  k->job[lane] = -1, k->h[lane] = 0.0;
}

/* A size at most as large as wanted, and the time that it leads to: no sliver is left before a break or the end. */
static void clip(const Task *task, const Work *k, int lane, double wanted, double *h, double *t_new) {
  double left = k->limit[lane] - k->t[lane];
  *h = smaller(wanted, task->largest_step);
  if (*h >= left) {
    *h = left, *t_new = k->limit[lane];
  } else {
    *t_new = k->t[lane] + (2 * *h > left ? left / 2 : *h);
    *h = *t_new - k->t[lane];
  }
}

/* The step to try next. */
static void propose(const Task *task, Work *k, int lane) {
  if (task->rule == FIXED) { /* to the next of the equal parts, from wherever an event has left off */
    double span = k->end[lane] - task->begin, count = larger(1.0, ceil(span / task->fixed_step * (1 - 1e-12)));
    double part = (double)(k->grid[lane] + 1);
    k->t_new[lane] = smaller(part < count ? task->begin + span * (part / count) : k->end[lane], k->stop[lane]);
    k->h[lane] = k->t_new[lane] - k->t[lane];
  } else {
    if (task->break_count) k->asked[lane] = smaller(k->h[lane], task->largest_step);
    clip(task, k, lane, k->h[lane], &k->h[lane], &k->t_new[lane]);
  }
}

/* Try again with less. */
static int refuse(const Task *task, Work *k, int lane, double factor) {
  ++k->rejected[lane];
  k->h[lane] *= factor, k->growth[lane] = 1.0; /* it grows not at once after a rejection */
  if (k->h[lane] < k->floor[lane]) k->h[lane] = k->floor[lane], finish(task, k, lane, STEP_TOO_SMALL);
  return 0;
}

/* How much longer the next step may be, by the errors of this one and the one before: error^(-PRESENT e) before^(PAST e), e = EXPONENT, by
 * one logarithm and one exponential. */
static void weigh(const Task *task, Work *k, S error, S miss) {
  S before;
  memcpy(&before, k->log_before, sizeof before);
  k->log_error = S_(log)(S_(larger)(S_(larger)(error / S_(all)(task->tolerance), miss), S_(all)(LEAST_ERROR)));
  k->factor = S_(all)(SAFETY) * S_(exp)(S_(all)(-PRESENT * EXPONENT) * k->log_error + S_(all)(PAST * EXPONENT) * before);
}

/* Decide on the step that was tried: 1 if the lane takes it over. save: the lane tries a longer one first; restore: which fails. */
static int judge(const Task *task, Work *k, int lane, double difference, double miss, double guard, double size, double *save, double *restore) {
  double h = k->h[lane], error = difference / task->tolerance;
  *save = *restore = 0.0;
  ++k->tried[lane];
  if (!(guard <= task->bound * task->bound)) {
    if (!isfinite(guard)) {
      error = INFINITY;
    } else if ((error <= 1 || task->rule == FIXED) && size > task->bound) {
      finish(task, k, lane, DIVERGED);
      return 0;
    }
  }
  if (task->crossings && (error <= 1 || task->rule == FIXED)) k->evaluations[lane] += EXTRA; /* the guards ask for the middle */
  if (task->rule == FIXED) {
    if (error == INFINITY) finish(task, k, lane, DIVERGED);
    return k->job[lane] >= 0;
  }
  error = miss == miss ? larger(error, miss) : INFINITY;
  if (task->rule == PAPER) {
    double longer, t_longer;
    if (k->doubling[lane] && !(error <= 1)) {
      ++k->rejected[lane], *restore = 1.0;
      k->h[lane] = k->kept_h[lane], k->t_new[lane] = k->kept_t_new[lane];
    } else if (!(error <= 1)) {
      k->halving[lane] = 1;
      return refuse(task, k, lane, 0.5);
    } else if (!k->halving[lane]) {
      clip(task, k, lane, 2 * h, &longer, &t_longer);
      if (longer >= 1.5 * h) {
        *save = 1.0, k->doubling[lane] = 1;
        k->kept_h[lane] = h, k->kept_t_new[lane] = k->t_new[lane], k->h[lane] = longer;
        return 0;
      }
    }
    k->doubling[lane] = k->halving[lane] = 0;
    k->wanted[lane] = k->h[lane];
    return 1;
  }
  if (!(error <= 1)) return refuse(task, k, lane, error < INFINITY ? larger(SMALLEST_SHRINK, SAFETY * pow(error, -EXPONENT)) : SMALLEST_SHRINK);
  k->wanted[lane] = larger(k->floor[lane], h * smaller(k->growth[lane], larger(SMALLEST_SHRINK, get(&k->factor, lane))));
  k->log_before[lane] = get(&k->log_error, lane), k->growth[lane] = LARGEST_GROWTH;
  return 1;
}

/* The next break of a lane, behind the one that it has passed. */
static void next_stop(const Task *task, Work *k, int lane) {
  int64_t n = k->next_break[lane];
  const double *before = task->breaks + 2 * k->job[lane] * task->break_count;
  k->stop[lane] = n < task->break_count ? before[n] : INFINITY;
  k->limit[lane] = smaller(k->end[lane], k->stop[lane]);
  k->behind[lane] = n < task->break_count ? before[task->break_count + n] : INFINITY;
}

/* The lane stands at the end of its step, where an event has cut it, or behind a break. */
static void advance(const Task *task, Work *k, int lane) {
  int whole = k->until[lane] == k->t_new[lane], at_break = task->break_count && k->crossing_break[lane];
  ++k->steps[lane];
  k->largest[lane] = larger(k->largest[lane], k->h[lane]);
  if (k->t_new[lane] < k->end[lane] || !(k->smallest[lane] < INFINITY)) k->smallest[lane] = smaller(k->smallest[lane], k->h[lane]);
  k->t[lane] = at_break ? k->behind[lane] : k->until[lane];
  if (task->rule == FIXED) {
    double span = k->end[lane] - task->begin, count = larger(1.0, ceil(span / task->fixed_step * (1 - 1e-12))), part = (double)(k->grid[lane] + 1);
    k->grid[lane] += at_break ? part < count && k->behind[lane] >= task->begin + span * (part / count) : whole;
  } else if (whole && !at_break) {
    k->h[lane] = k->wanted[lane];
  } else {
    k->log_before[lane] = 0.0;
    if (at_break && task->rule == SMOOTH) k->h[lane] = larger(k->h[lane], k->asked[lane]);
  }
  if (at_break) ++k->next_break[lane], next_stop(task, k, lane);
}
