/* The loop around a step for LANES trajectories side by side, each with its own time, step and error. A lane whose step fails keeps its
 * state; a lane that has finished takes the next job; what one lane does, no other one feels. */

/* Slopes and guards where lanes start or go on after an event (those with which[lane] != 0). */
static void set_out(const Task *task, Work *k, const double *which) {
  double accepted[LANES];
  memcpy(accepted, which, sizeof accepted);
  memcpy(&k->time, k->t, sizeof(S)), memcpy(&k->accepted, accepted, sizeof(S));
  S_MASK take = k->accepted != S_(all)(0.0);
  time_at(k, k->time);
  for (int i = 0; i < NX; ++i) k->x[i] = k->x0[i] + k->y[i];
  state_stage(k->c, W_AT(k, 0), k->x, k->base);
  for (int i = 0; i < NX; ++i) k->now.k[0][i] = S_(select)(take, k->base[i], k->now.k[0][i]);
  if (!has_guards(task)) return;
  look(task, k, HALF, W_AT(k, 0), k->y, k->now.k[0]);
  for (int64_t n = 0; n < 2 * RATES; ++n) k->guard[START][n] = S_(select)(take, k->guard[HALF][n], k->guard[START][n]);
}

/* Where lanes go on after events, signs of the guards that stand at START. */
static void set_out_with_signs(const Task *task, Work *k, const double *which) {
  set_out(task, k, which);
  for (int lane = 0; lane < LANES && has_guards(task); ++lane)
    if (which[lane] != 0) set_signs(task, k, lane);
}

/* The next job for an idle lane: its parameters, its start, the modes that hold there. The outcome if it ends at once. */
static int64_t begin(const Task *task, Work *k, int lane, int64_t job) {
  const double *times = task->times + job * task->times_stride;
  double start[NX], reach;
  int64_t outcome;
  memset(start, 0, sizeof start);
  memcpy(k->p[lane], task->p + job * NP, NP * sizeof(double));
  for (int i = 0; i < NX; ++i) {
    put(&k->x0[i], lane, task->x0[job * NX + i]), put(&k->inverse[i], lane, 1.0 / task->scale[job * NX + i]);
    put(&k->y[i], lane, 0.0), put(&k->now.y_end[i], lane, 0.0);
  }
  k->job[lane] = job, k->t[lane] = k->since[lane] = task->begin, k->end[lane] = times[task->samples - 1];
  reach = larger(fabs(k->t[lane]), fabs(k->end[lane]));
  k->floor[lane] = larger(task->smallest_step * (k->end[lane] - k->t[lane]), 4 * ulp(reach));
  k->steps[lane] = k->tried[lane] = k->rejected[lane] = k->grid[lane] = k->doubling[lane] = k->halving[lane] = 0;
  k->evaluations[lane] = 1;
  k->smallest[lane] = INFINITY, k->largest[lane] = 0.0, k->log_before[lane] = 0.0, k->growth[lane] = LARGEST_GROWTH, k->h[lane] = 0.0;
  k->reached[lane] = times[0] == task->begin, set_due(task, k, lane);
  k->events[lane] = k->quick[lane] = k->finds[lane] = 0, k->last_event[lane] = -1;
  k->next_break[lane] = k->crossing_break[lane] = k->returns[lane] = 0, next_stop(task, k, lane);
  if (k->stop[lane] <= k->t[lane]) k->t[lane] = k->behind[lane], k->next_break[lane] = 1, next_stop(task, k, lane); /* it starts on a break */
  set_parameters(task, k, lane);
  if (!has_guards(task)) return RUNNING;
  for (int64_t n = 0; n < task->crossings; ++n) {
    k->fired[lane * task->crossings + n] = 0;
    put(&k->guard_near[task->crossing[n * CROSSING + SURFACE]], lane, TOUCH * task->guard_zero[job * task->crossings + n]);
  }
  for (int64_t n = 0; n < task->surfaces; ++n) {
    put(&k->guard_floor[n], lane, task->guard_floor[job * task->surfaces + n]);
    put(&k->guard_sampled[n], lane, task->way[n] == SAMPLED);
  }
  read_modes(task, k, lane);
  k->event_time[lane] = -INFINITY, k->early[lane] = k->late[lane] = 0.0, k->leapt[lane] = 1;
  Before before = {0.0, 0};
  outcome = chain(task, k, 0, lane, 0, before, k->t[lane], start);
  for (int64_t n = 0; n < task->variables; ++n) task->first_modes[job * task->variables + n] = k->modes[lane * task->variables + n];
  for (int i = 0; i < NX; ++i) put(&k->y[i], lane, start[i]);
  return outcome;
}

/* Give idle lanes the next jobs, with slopes and first steps (Hairer's rule). Whether any lane is at work. */
static int take_jobs(const Task *task, Work *k) {
  while (ANY(S_(not)(working(k)))) {
    double unit[LANES], speed[LANES], taken[LANES];
    int64_t sample[WIDTH];
    int any = 0, busy = 0;
    for (int lane = 0; lane < LANES; ++lane) {
      taken[lane] = 0, unit[lane] = 0.0, speed[lane] = 0.0;
      if (k->job[lane] >= 0) {
        busy = 1;
        continue;
      }
      int64_t job = __atomic_load_n(task->next, __ATOMIC_RELAXED), outcome;
      if (job >= task->jobs || (job = __atomic_fetch_add(task->next, 1, __ATOMIC_RELAXED)) >= task->jobs) continue;
      any = 1;
      outcome = begin(task, k, lane, job);
      if (outcome == RUNNING) taken[lane] = 1;
      else finish(task, k, lane, outcome);
    }
    if (!any) return busy;
    set_out_with_signs(task, k, taken);
    any = 0;
    for (int slot = 0; slot < WIDTH; ++slot) {
      int lane = SLOT_LANE(slot), first = slot < LANES && taken[lane] != 0 && k->reached[lane];
      sample[slot] = first ? 0 : -1, any |= first;
    }
    if (any) {
      memset(k->at_y, 0, sizeof k->at_y);
      emit(task, k, k->at_y, spread(&k->time, -1), sample);
    }
    for (int lane = 0; lane < LANES; ++lane) {
      if (taken[lane] == 0) continue;
      int finite = 1;
      for (int i = 0; i < NX; ++i) {
        double slope = get(&k->now.k[0][i], lane);
        finite &= isfinite(slope) != 0;
        speed[lane] = larger(speed[lane], fabs(slope * get(&k->inverse[i], lane)));
      }
      double horizon = k->end[lane] - k->t[lane];
      unit[lane] = smaller(smaller(speed[lane] > 0 ? FIRST_MOVE / speed[lane] : FIRST_SHARE * horizon, horizon), task->largest_step);
      if (horizon > 0 && !finite) k->h[lane] = k->floor[lane], finish(task, k, lane, NON_FINITE_RATE), taken[lane] = 0;
      else if (!(horizon > 0)) finish(task, k, lane, SUCCESS), taken[lane] = 0;
    }
    memcpy(&k->step, unit, sizeof(S));
    time_at(k, k->time + k->step);
    for (int i = 0; i < NX; ++i) k->x[i] = k->x0[i] + (k->y[i] + k->step * k->now.k[0][i]);
    state_stage(k->c, W_AT(k, 0), k->x, k->base);
    for (int lane = 0; lane < LANES; ++lane) {
      if (taken[lane] == 0) continue;
      double bend = 0.0, h = task->first_step;
      if (!(h > 0)) {
        for (int i = 0; i < NX; ++i) {
          double turn = fabs((get(&k->base[i], lane) - get(&k->now.k[0][i], lane)) * get(&k->inverse[i], lane));
          bend = turn > bend || turn != turn ? turn : bend; /* NaN stays */
        }
        double size = larger(unit[lane] * speed[lane], unit[lane] * bend);
        if (task->rule != FIXED) ++k->evaluations[lane];
        h = unit[lane] * smaller(FIRST_GROWTH, size > 0 ? pow(FIRST_ERROR * task->tolerance / size, EXPONENT) : FIRST_GROWTH);
        if (!isfinite(unit[lane] * bend) || !isfinite(size)) h = k->floor[lane];
      }
      k->h[lane] = larger(h, k->floor[lane]);
    }
  }
  return 1;
}

/* The step of each lane and what goes with it, kept while longer ones are tried (rule PAPER). */
static void keep(Work *k, const double *save, const double *restore) {
  S saved, restored, *one = (S *)&k->now, *other = (S *)&k->kept;
  memcpy(&saved, save, sizeof(S)), memcpy(&restored, restore, sizeof(S));
  S_MASK saving = saved != S_(all)(0.0), restoring = restored != S_(all)(0.0);
  for (size_t i = 0; i < sizeof(Trial) / sizeof(S); ++i) {
    S trial = one[i];
    one[i] = S_(select)(restoring, other[i], trial);
    other[i] = S_(select)(saving, trial, other[i]);
  }
}

/* From the end of a step just before a break to its other side, with the slope of this side: y, and the outcome there. */
static int64_t go_behind(const Task *task, Work *k, Log *log, int lane, double *y) {
  double start[NX], gap = k->behind[lane] - k->stop[lane];
  for (int i = 0; i < NX; ++i) {
    start[i] = get(&k->now.y_end[i], lane);
    y[i] = start[i] + gap * get(&k->now.k[END][i], lane);
  }
  return has_guards(task) ? jump(task, k, log, lane, k->stop[lane], start, k->behind[lane], y) : RUNNING;
}

/* Slopes, guards and signs where lanes go on after events and breaks; a mode that is left at once is left here. */
static void set_out_again(const Task *task, Work *k, Log *log, const double *which) {
  double going[LANES];
  memcpy(going, which, sizeof going);
  for (int any = 1; any;) {
    any = 0;
    set_out(task, k, going);
    for (int lane = 0; lane < LANES; ++lane) {
      double y[NX];
      int64_t next = -1, outcome;
      int finite = 1;
      if (going[lane] == 0) continue;
      for (int i = 0; i < NX; ++i) y[i] = get(&k->y[i], lane), finite &= isfinite(get(&k->now.k[0][i], lane)) != 0;
      if (!finite) finish(task, k, lane, NON_FINITE_RATE);
      else if (has_guards(task)) next = returning(task, k, lane);
      if (next < 0) {
        going[lane] = 0.0;
        if (finite && has_guards(task)) set_signs(task, k, lane);
        continue;
      }
      outcome = go_back(task, k, log, lane, next, y);
      for (int i = 0; i < NX; ++i) put(&k->y[i], lane, y[i]);
      if (outcome == RUNNING) any = 1, ++k->evaluations[lane];
      else finish(task, k, lane, outcome), going[lane] = 0.0;
    }
  }
}

/* What happens to a lane in the step that it takes: events, a break. y: where it goes on if *whole becomes zero. The outcome there. */
static int64_t come_upon(const Task *task, Work *k, Log *log, int lane, double *whole, double *y) {
  int64_t outcome = RUNNING;
  if (k->finds[lane]) {
    outcome = happen(task, k, log, lane, y);
    if (k->jumped[lane]) *whole = k->crossing_break[lane] = 0.0;
  }
  if (has_guards(task) && *whole != 0 && LANE(k->suspects, lane)) keep_signs(task, k, lane);
  if (k->crossing_break[lane] != 0) {
    *whole = 0.0;
    outcome = go_behind(task, k, log, lane, y);
  }
  return outcome;
}

/* The state that each lane goes on from where its step is taken as a whole. */
static void go_on(const Task *task, Work *k, S_MASK whole) {
  if (!ANY(S_(not)(whole))) {
    S *start = k->guard[START];
    for (int i = 0; i < NX; ++i) k->y[i] = k->now.y_end[i], k->now.k[0][i] = k->now.k[END][i];
    if (has_guards(task)) k->guard[START] = k->guard[FULL], k->guard[FULL] = start;
    return;
  }
  for (int i = 0; i < NX; ++i) {
    k->y[i] = S_(select)(whole, k->now.y_end[i], k->y[i]);
    k->now.k[0][i] = S_(select)(whole, k->now.k[END][i], k->now.k[0][i]);
  }
  for (int64_t n = 0; n < 2 * RATES; ++n) k->guard[START][n] = S_(select)(whole, k->guard[FULL][n], k->guard[START][n]);
}

/* The steps that were accepted: events, outputs, and the state that each lane goes on from. */
static void take_steps(const Task *task, Work *k, Log *log, const double *accepted) {
  const S_MASK took = is_set(accepted), none = S_(all)(0.0) != S_(all)(0.0);
  S_MASK looked = has_guards(task) ? S_(and)(took, k->suspects) : none, behind = none;
  double whole[LANES], again[LANES], y[LANES][NX];
  int64_t outcome[LANES];
  int cuts = 0;
  memcpy(k->until, k->t_new, sizeof k->until), memcpy(whole, accepted, sizeof whole);
  put_row(again, S_(all)(0.0)), memset(outcome, 0, sizeof outcome), memset(k->finds, 0, sizeof k->finds);
  for (int lane = 0; lane < LANES; ++lane) k->dense_used[lane] = EXTRA && has_guards(task);
  if (ANY(looked)) dense_stages(k);
  for (int lane = 0; lane < LANES && ANY(looked); ++lane)
    if (LANE(looked, lane)) find(task, k, lane), cut(task, k, lane);
  memcpy(k->covers, k->until, sizeof k->covers);
  if (task->break_count) {
    behind = S_(and)(took, row(k->until) == row(k->stop));
    put_row(k->crossing_break, S_(number)(behind)), put_row(k->covers, S_(select)(behind, row(k->behind), row(k->until)));
  }
  write_outputs(task, k, accepted);
  for (int lane = 0; lane < LANES && ANY(S_(or)(looked, behind)); ++lane) {
    if (!LANE(S_(or)(looked, behind), lane)) continue;
    outcome[lane] = come_upon(task, k, log, lane, &whole[lane], y[lane]);
    if (whole[lane] == 0) again[lane] = 1.0, cuts = 1;
  }
  advance(task, k, accepted);
  go_on(task, k, is_set(whole));
  if (!cuts && !ANY(S_(and)(took, S_(not)(row(k->t) < row(k->end))))) return;
  for (int lane = 0; lane < LANES; ++lane) {
    if (again[lane] != 0) {
      for (int i = 0; i < NX; ++i) put(&k->y[i], lane, y[lane][i]);
      k->evaluations[lane] += outcome[lane] == RUNNING;
    }
    if (outcome[lane] != RUNNING) finish(task, k, lane, outcome[lane]), again[lane] = 0.0;
    else if (accepted[lane] != 0 && !(k->t[lane] < k->end[lane])) finish(task, k, lane, SUCCESS), again[lane] = 0.0;
  }
  if (cuts) set_out_again(task, k, log, again);
}

/* Go on for at most so many steps; whether anything is left to do. */
int64_t modelgen_run(const Task *task, Work *k, Log *log, int64_t steps) {
  int64_t most = LANES * (FINDS * task->crossings + (MANY + 1) * (MANY + 1) + task->crossings); /* events that one step can add to the log */
  for (int lane = 0; lane < LANES; ++lane)
    if (k->job[lane] >= 0 && task->counts[k->job[lane] * COUNTS + STOP]) finish(task, k, lane, RUNNING);
  while (take_jobs(task, k)) {
    double accepted[LANES], save[LANES], restore[LANES];
    if (steps-- <= 0 || (has_guards(task) && log->room - log->used < most)) {
      for (int lane = 0; lane < LANES; ++lane)
        if (k->job[lane] >= 0) report(task, k, lane, RUNNING);
      return 1;
    }
    propose(task, k);
    for (int lane = 0; lane < LANES; ++lane)
      if (k->tried[lane] >= task->max_steps && k->job[lane] >= 0) finish(task, k, lane, MAX_STEPS);
    memcpy(&k->time, k->t, sizeof(S)), memcpy(&k->step, k->h, sizeof(S));
    k->dense_ready = 0;
    S error, guard, size, miss = S_(all)(0.0);
    try_step(k, task->correction, &error, &guard, &size);
    if (has_guards(task)) miss = watch(task, k);
    if (task->rule == SMOOTH) weigh(task, k, error, miss);
    judge_all(task, k, error, miss, guard, size, accepted, save, restore);
    if (task->rule == PAPER && ANY(S_(or)(is_set(save), is_set(restore)))) keep(k, save, restore);
    if (task->rule == PAPER && ANY(is_set(restore))) {
      memcpy(&k->step, k->h, sizeof(S));
      k->dense_ready = 0;
      if (has_guards(task)) times_at(k, k->time, k->step), watch(task, k);
    }
    if (ANY(is_set(accepted))) take_steps(task, k, log, accepted);
  }
  return 0;
}

int64_t modelgen_sizes(int64_t which) {
  const int64_t sizes[] = {NX, NP, LANES, sizeof(Work), sizeof(Task), NC, NW};
  return which >= 0 && which < 7 ? sizes[which] : -1;
}

/* Bytes of a piece of work. */
int64_t modelgen_bytes(const Task *task) { return (int64_t)sizeof(Work) + 64 + lay_out(task, 0, 0); }

/* Before the first call on a piece of work (aligned to 64 bytes). */
void modelgen_start(const Task *task, Work *k) {
  memset(k, 0, (size_t)modelgen_bytes(task));
  for (int lane = 0; lane < LANES; ++lane) k->job[lane] = -1;
  lay_out(task, (char *)k + (sizeof(Work) + 63) / 64 * 64, k);
}

/* The job that a lane works on, or -1. */
int64_t modelgen_job(const Work *k, int64_t lane) { return lane >= 0 && lane < LANES ? k->job[lane] : -1; }

/* The rates at some times and one place, for checks; step > 0: as at the start of such steps. Every lane computes the same. */
void modelgen_rates(Work *k, int64_t count, double step, const double *t, const double *x, const double *p, double *rates) {
  parameter_stage(p, k->one_c);
  for (int i = 0; i < NC; ++i) k->c[i] = S_(all)(k->one_c[i]);
  for (int i = 0; i < NX; ++i) k->x[i] = S_(all)(x[i]);
  for (int lane = 0; lane < LANES; ++lane) close_windows(k, lane), k->job[lane] = 0;
  for (int64_t n = 0; n < count; ++n) {
    k->time = S_(all)(t[n]), k->step = S_(all)(step);
    stage_times(k, k->time, S_(all)(0.0), FRACTIONS, 1, 0, step > 0);
    state_stage(k->c, W_AT(k, 0), k->x, k->base);
    for (int i = 0; i < NX; ++i) rates[n * NX + i] = get(&k->base[i], 0);
  }
}
