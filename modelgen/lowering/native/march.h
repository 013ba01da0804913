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
  k->job[lane] = -1, k->h[lane] = 0.0, k->limit[lane] = k->t[lane];
}

/* Sizes at most as large as wanted, and the times that they lead to: no sliver is left before a break or the end. */
static void clip(const Task *task, const Work *k, S wanted, double *h, double *t_new) {
  const S t = row(k->t), limit = row(k->limit), left = limit - t, most = S_(all)(task->largest_step);
  const S size = S_(select)(most < wanted, most, wanted), to = t + S_(select)(2.0 * size > left, 0.5 * left, size);
  const S_MASK last = size >= left;
  put_row(t_new, S_(select)(last, limit, to)), put_row(h, S_(select)(last, left, to - t));
}

/* The number of equal parts (rule FIXED). */
static double part_count(const Task *task, const Work *k, int lane) {
  return larger(1.0, ceil((k->end[lane] - task->begin) / task->fixed_step * (1 - 1e-12)));
}

/* The steps to try next. */
static void propose(const Task *task, Work *k) {
  if (task->rule != FIXED) {
    if (task->break_count) memcpy(k->asked, k->h, sizeof k->asked);
    clip(task, k, row(k->h), k->h, k->t_new);
    return;
  }
  for (int lane = 0; lane < LANES; ++lane) { /* to the next of the equal parts, from wherever an event has left off */
    if (k->job[lane] < 0) continue;
    double span = k->end[lane] - task->begin, count = part_count(task, k, lane), part = (double)(k->grid[lane] + 1);
    k->t_new[lane] = smaller(part < count ? task->begin + span * (part / count) : k->end[lane], k->stop[lane]);
    k->h[lane] = k->t_new[lane] - k->t[lane];
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

/* Decide on the step that a lane tried: 1 if it takes it over. save: the lane tries a longer one first; restore: which fails. */
static int judge(const Task *task, Work *k, int lane, double difference, double miss, double guard, double size, double *save, double *restore) {
  double error = difference / task->tolerance;
  ++k->tried[lane];
  if (!(guard <= task->bound * task->bound)) {
    if (!isfinite(guard)) {
      error = INFINITY;
    } else if ((error <= 1 || task->rule == FIXED) && size > task->bound) {
      finish(task, k, lane, DIVERGED);
      return 0;
    }
  }
  if (has_guards(task) && (error <= 1 || task->rule == FIXED)) k->evaluations[lane] += EXTRA; /* the guards ask for the middle */
  if (task->rule == FIXED) {
    if (error == INFINITY) finish(task, k, lane, DIVERGED);
    return k->job[lane] >= 0;
  }
  error = miss == miss ? larger(error, miss) : INFINITY;
  if (task->rule == PAPER) {
    if (k->doubling[lane] && !(error <= 1)) {
      ++k->rejected[lane], *restore = 1.0;
      k->h[lane] = k->kept_h[lane], k->t_new[lane] = k->kept_t_new[lane];
    } else if (!(error <= 1)) {
      k->halving[lane] = 1;
      return refuse(task, k, lane, 0.5);
    } else if (!k->halving[lane] && k->longer[lane] >= 1.5 * k->h[lane]) {
      *save = 1.0, k->doubling[lane] = 1;
      k->kept_h[lane] = k->h[lane], k->kept_t_new[lane] = k->t_new[lane], k->h[lane] = k->longer[lane];
      return 0;
    }
    k->doubling[lane] = k->halving[lane] = 0;
    return 1;
  }
  if (!(error <= 1)) return refuse(task, k, lane, error < INFINITY ? larger(SMALLEST_SHRINK, SAFETY * pow(error, -EXPONENT)) : SMALLEST_SHRINK);
  return 1;
}

/* The same for all lanes. Most steps pass by sizes alone, side by side. */
static void judge_all(const Task *task, Work *k, S error, S miss, S guard, S size, double *accepted, double *save, double *restore) {
  const S one = S_(all)(1.0);
  double t_longer[LANES];
  S_MASK good = S_(and)(working(k), guard <= S_(all)(task->bound * task->bound));
  good = S_(and)(good, S_(and)(error / S_(all)(task->tolerance) <= one, miss <= one));
  if (task->rule != SMOOTH) good = one != one;
  put_row(accepted, S_(number)(good)), put_row(save, S_(all)(0.0)), put_row(restore, S_(all)(0.0));
  for (int lane = 0; lane < LANES; ++lane) k->tried[lane] += accepted[lane] != 0;
  for (int lane = 0; lane < LANES && has_guards(task) && EXTRA; ++lane) k->evaluations[lane] += accepted[lane] != 0 ? EXTRA : 0;
  if (!ANY(S_(not)(good))) return;
  if (task->rule == PAPER) clip(task, k, 2.0 * row(k->h), k->longer, t_longer);
  for (int lane = 0; lane < LANES; ++lane)
    if (k->job[lane] >= 0 && accepted[lane] == 0)
      accepted[lane] = judge(task, k, lane, LANE(error, lane), LANE(miss, lane), LANE(guard, lane), LANE(size, lane), &save[lane], &restore[lane]);
}

/* The next break of a lane, behind the one that it has passed. */
static void next_stop(const Task *task, Work *k, int lane) {
  int64_t n = k->next_break[lane];
  const double *before = task->breaks + 2 * k->job[lane] * task->break_count;
  k->stop[lane] = n < task->break_count ? before[n] : INFINITY;
  k->limit[lane] = smaller(k->end[lane], k->stop[lane]);
  k->behind[lane] = n < task->break_count ? before[task->break_count + n] : INFINITY;
}

/* A lane goes on behind a break. */
static void pass_break(const Task *task, Work *k, int lane) {
  k->t[lane] = k->behind[lane];
  if (task->rule == SMOOTH) k->h[lane] = larger(k->h[lane], smaller(k->asked[lane], task->largest_step));
  ++k->next_break[lane], next_stop(task, k, lane);
}

/* The lanes that take their step stand at its end, where an event has cut it, or behind a break. */
static void advance(const Task *task, Work *k, const double *accepted) {
  const S zero = S_(all)(0.0), h = row(k->h), until = row(k->until), t_new = row(k->t_new), most = row(k->largest), least = row(k->smallest);
  const S_MASK took = is_set(accepted), whole = S_(and)(until == t_new, S_(not)(is_set(k->crossing_break)));
  const S_MASK counts = S_(and)(took, S_(and)(h < least, S_(or)(t_new < row(k->end), least == S_(all)(INFINITY))));
  for (int lane = 0; lane < LANES; ++lane) k->steps[lane] += accepted[lane] != 0;
  put_row(k->largest, S_(select)(S_(and)(took, h > most), h, most)), put_row(k->smallest, S_(select)(counts, h, least));
  put_row(k->t, S_(select)(took, until, row(k->t)));
  if (task->rule == SMOOTH) {
    const S growth = row(k->growth), wish = S_(larger)(k->factor, S_(all)(SMALLEST_SHRINK));
    const S wanted = S_(larger)(h * S_(select)(wish < growth, wish, growth), row(k->floor));
    put_row(k->h, S_(select)(S_(and)(took, whole), wanted, h)), put_row(k->growth, S_(select)(took, S_(all)(LARGEST_GROWTH), growth));
    put_row(k->log_before, S_(select)(took, S_(select)(whole, k->log_error, zero), row(k->log_before)));
  }
  for (int lane = 0; lane < LANES && task->rule == FIXED; ++lane) {
    double span = k->end[lane] - task->begin, count = part_count(task, k, lane), part = (double)(k->grid[lane] + 1);
    if (accepted[lane] == 0) continue;
    if (k->crossing_break[lane] == 0) k->grid[lane] += k->until[lane] == k->t_new[lane];
    else k->grid[lane] += part < count && k->behind[lane] >= task->begin + span * (part / count);
  }
  for (int lane = 0; lane < LANES && task->break_count; ++lane)
    if (k->crossing_break[lane] != 0) pass_break(task, k, lane);
}
