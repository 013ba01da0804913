/* What happens where a guard passes zero: a log, a reset, another mode, and what follows from that at the same time.
 *
 * The mode of a lane is a set of flags at the end of its own copy of the parameters. */

static const double FAR = 5e299; /* beyond it an enclosure has no end */

/* The parameter stages of one lane anew, after its flags or its job changed. */
static void set_parameters(const Task *task, Work *k, int lane) {
  parameter_stage(k->p[lane], k->one_c);
  for (int i = 0; i < NC; ++i) put(&k->c[i], lane, k->one_c[i]);
  close_windows(k, lane);
  const Observer *observers[] = {&task->guards, &task->channels, &task->bounds};
  V *columns[] = {k->guard_c, k->channel_c, k->bounds_c};
  for (int each = 0; each < 3; ++each) {
    if (!observers[each]->values) continue;
    observers[each]->parameters(k->p[lane], k->observer_c);
    for (int64_t n = 0; n < observers[each]->values; ++n)
#ifdef SINGLE
      columns[each][n] = v_all(k->observer_c[n]);
#else
      columns[each][n][lane] = k->observer_c[n];
#endif
  }
}

/* How far guards that are linear in the states may be from the quintic over a step, per sixth power of the step. */
static void set_rests(const Task *task, Work *k, int lane) {
  const double most = 1.0 / (432.0 * 720.0);
  V x[2 * NX], v[2 * NX + 2], none = v_all(0.0);
  if (!task->rests.outputs) return;
  for (int i = 0; i < 2 * NX; ++i) x[i] = v[i] = none;
  v[2 * NX] = v_all(smaller(k->t[lane], k->end[lane])), v[2 * NX + 1] = v_all(k->end[lane]);
  task->rests.parameters(k->p[lane], k->observer_c);
  for (int64_t n = 0; n < task->rests.values; ++n) k->reset_c[n] = v_all(k->observer_c[n]);
  task->rests.at(k->reset_c, &none, x, v, k->bounded);
  for (int64_t n = 0; n < task->surfaces; ++n) {
    double low = fabs(k->bounded[n][0]), high = fabs(k->bounded[task->surfaces + n][0]);
    put(&k->guard_rest[n], lane, low < FAR && high < FAR ? most * larger(low, high) : INFINITY);
  }
}

static void set_active(const Task *task, Work *k, int lane) {
  for (int64_t n = 0; n < task->surfaces; ++n) put(&k->watched[n], lane, 0.0);
  for (int64_t n = 0; n < task->crossings; ++n) {
    const int64_t *crossing = task->crossing + n * CROSSING;
    int on = crossing[VARIABLE] < 0 || k->modes[lane * task->variables + crossing[VARIABLE]] == crossing[LEAVE];
    put(&k->active[n], lane, on);
    if (on) put(&k->watched[crossing[SURFACE]], lane, 1.0);
  }
}

/* Modes from the flags of a job. */
static void read_modes(const Task *task, Work *k, int lane) {
  for (int64_t n = 0; n < task->variables; ++n) {
    const int64_t *mode = task->mode + n * MODE;
    const double *flags = k->p[lane] + mode[FIRST_FLAG];
    int64_t best = 0;
    for (int64_t value = 1; value < mode[VALUES]; ++value)
      if (flags[value] > flags[best]) best = value;
    k->modes[lane * task->variables + n] = best;
  }
  set_active(task, k, lane);
}

/* The time since the last change belongs to the present modes. */
static void hold(const Task *task, Work *k, int lane, double time) {
  double *held = task->held + k->job[lane] * task->all_values, from = larger(k->since[lane], task->times[k->job[lane] * task->times_stride]);
  for (int64_t n = 0; n < task->variables && time > from; ++n)
    held[task->mode[n * MODE + FIRST_VALUE] + k->modes[lane * task->variables + n]] += time - from;
  k->since[lane] = time;
}

/* Guards of one lane at a time and a state from x0, in the present modes or with given parameters: first slots of k->seen. */
static void guards_at(const Task *task, Work *k, int lane, const double *p, double time, const double *y) {
  V at = v_all(time);
  if (p) task->guards.parameters(p, k->observer_c);
  for (int64_t n = 0; n < task->guards.values; ++n) k->lane_guard_c[n] = p ? v_all(k->observer_c[n]) : ONE_LANE(k->guard_c[n], lane);
  for (int i = 0; i < NX; ++i) k->at_x[i] = v_all(get(&k->x0[i], lane) + y[i]), k->at_v[i] = v_all(0.0);
  task->guards.at(k->lane_guard_c, &at, k->at_x, k->at_v, k->seen);
}

static void log_event(const Task *task, Work *k, Log *log, int lane, int64_t n, double time, const double *y) {
  int64_t job = k->job[lane];
  ++task->happened[job * task->crossings + n], k->last_event[lane] = n;
  k->fired[lane * task->crossings + n] = 1;
  if (k->events[lane]++ >= task->log_limit || log->used >= log->room) return;
  log->job[log->used] = job, log->which[log->used] = n, log->time[log->used] = time;
  for (int i = 0; i < NX; ++i) log->state[log->used * NX + i] = get(&k->x0[i], lane) + y[i];
  ++log->used;
}

static void log_touch(const Task *task, Work *k, Log *log, int lane, Found found) {
  if (log->used >= log->room || k->events[lane] >= task->log_limit) return;
  log->job[log->used] = k->job[lane], log->which[log->used] = found.crossing, log->time[log->used] = found.time;
  ++log->used;
}

/* Put the mode to which a crossing leads into parameters. */
static void enter(const Task *task, double *p, int64_t n) {
  const int64_t *crossing = task->crossing + n * CROSSING, *mode = task->mode + crossing[VARIABLE] * MODE;
  for (int64_t value = 0; crossing[VARIABLE] >= 0 && value < mode[VALUES]; ++value) p[mode[FIRST_FLAG] + value] = value == crossing[ENTER];
}

/* The jump and the change of mode that belong to a crossing. */
static void take_effect(const Task *task, Work *k, int lane, int64_t n, double time, double *y) {
  const int64_t *crossing = task->crossing + n * CROSSING;
  guards_at(task, k, lane, 0, time, y);
  k->fired_at[lane * task->crossings + n] = k->seen[crossing[SURFACE]][0];
  if (crossing[RESET] >= 0) {
    V at = v_all(time);
    if (task->resets.values) task->resets.parameters(k->p[lane], k->observer_c);
    for (int64_t i = 0; i < task->resets.values; ++i) k->reset_c[i] = v_all(k->observer_c[i]);
    for (int i = 0; i < NX; ++i) k->at_x[i] = v_all(get(&k->x0[i], lane) + y[i]);
    k->leapt[lane] = 1;
    task->resets.at(k->reset_c, &at, k->at_x, k->at_x, k->after);
    for (int i = 0; i < NX; ++i) {
      double now = k->after[crossing[RESET] * NX + i][0];
      if (now != k->at_x[i][0]) y[i] = now - get(&k->x0[i], lane); /* what does not jump keeps its digits */
    }
  }
  if (crossing[VARIABLE] >= 0 && crossing[LEAVE] != crossing[ENTER]) {
    hold(task, k, lane, time);
    enter(task, k->p[lane], n);
    k->entered[lane * task->variables + crossing[VARIABLE]] = 1;
    k->modes[lane * task->variables + crossing[VARIABLE]] = crossing[ENTER];
    set_parameters(task, k, lane), set_active(task, k, lane);
  }
}

/* One event: log, jump, change of mode; y is the state there. The outcome if the run ends with it. */
static int64_t fire(const Task *task, Work *k, Log *log, int lane, int64_t n, double time, double *y) {
  k->last_event[lane] = n;
  if (log) {
    if (k->events[lane] >= task->max_events) return MAX_EVENTS;
    log_event(task, k, log, lane, n, time, y);
  }
  take_effect(task, k, lane, n, time, y);
  return task->crossing[n * CROSSING + STOPS] ? EVENT : RUNNING;
}

/* Where a lane stood before a jump: time, state from x0 (NULL: there was none); its parameters stand in k->p_before. */
typedef struct {
  double time;
  const double *y;
} Before;

static int is_mode_change(const Task *task, const Work *k, int lane, int64_t n) {
  const int64_t *crossing = task->crossing + n * CROSSING;
  return crossing[VARIABLE] >= 0 && crossing[LEAVE] != crossing[ENTER] && get(&k->active[n], lane) != 0;
}

static double beyond_zero(const Task *task, const Work *k, int64_t n) {
  const int64_t *crossing = task->crossing + n * CROSSING;
  return (double)crossing[DIRECTION] * k->seen[crossing[SURFACE]][0];
}

/* The guard beyond zero that fires next, or -1: of several the one that a steep ramp from before the jump would meet first. */
static int64_t next_beyond(const Task *task, Work *k, int lane, Before before, double time, const double *y) {
  int64_t first = -1, count = 0;
  double least = INFINITY;
  guards_at(task, k, lane, 0, time, y);
  for (int64_t n = 0; n < task->crossings; ++n) {
    k->g_before[n] = 0.0;
    if (!is_mode_change(task, k, lane, n)) continue;
    double now = beyond_zero(task, k, n);
    if (!(now > task->guard_zero[k->job[lane] * task->crossings + n])) continue;
    if (!count++) first = n;
    k->g_before[n] = now;
  }
  if (count < 2 || !before.y) return first;
  guards_at(task, k, lane, k->p_before, before.time, before.y);
  for (int64_t n = 0; n < task->crossings; ++n) {
    if (!(k->g_before[n] > 0)) continue;
    double start = smaller(beyond_zero(task, k, n), 0.0), share = -start / (k->g_before[n] - start);
    if (!(share == share)) share = 0.0;
    if (share < least) least = share, first = n;
  }
  return first;
}

/* Guards of the present modes that are beyond zero already fire at once, until none is. */
static int64_t chain(const Task *task, Work *k, Log *log, int lane, int length, Before before, double time, double *y) {
  for (;;) {
    int64_t outcome, next = next_beyond(task, k, lane, before, time, y);
    if (next < 0) return RUNNING;
    if (++length > MANY) {
      k->last_event[lane] = next;
      return EVENT_CHATTER;
    }
    outcome = fire(task, k, log, lane, next, time, y);
    if (before.y) enter(task, k->p_before, next);
    if (outcome != RUNNING) return outcome;
  }
}

static int has_effect(const int64_t *crossing) { return crossing[VARIABLE] >= 0 || crossing[RESET] >= 0 || crossing[STOPS]; }

/* Where a lane's step is cut: at the first crossing found that has an effect, or that is one too many. */
static void cut(const Task *task, Work *k, int lane) {
  for (int64_t each = 0; each < k->finds[lane]; ++each) {
    Found found = k->found[lane * FINDS * task->crossings + each];
    if (found.crossing >= task->crossings) continue; /* a touch */
    if (has_effect(task->crossing + found.crossing * CROSSING) || k->events[lane] + each >= task->max_events) {
      k->until[lane] = found.time;
      return;
    }
  }
}

/* Whether events follow each other without time to speak of, or motion: ever faster, or not. */
static int64_t crowded(Work *k, int lane, double time, double horizon, double rate, double zero) {
  double gap = time - k->event_time[lane];
  k->event_time[lane] = time;
  if (!(gap < larger(MOMENT * horizon, ROUNDINGS * ulp(time))) && !(rate * gap <= zero)) {
    k->quick[lane] = 0, k->early[lane] = k->late[lane] = 0.0;
    return RUNNING;
  }
  *(k->quick[lane] < MANY / 2 ? &k->early[lane] : &k->late[lane]) += gap;
  if (++k->quick[lane] < MANY) return RUNNING;
  /* Gaps of a few last digits of the time are rounding: nothing shrinks there. */
  return k->late[lane] < SHRINKING * k->early[lane] && k->early[lane] > ROUNDINGS * MANY / 2 * ulp(time) ? ZENO : EVENT_CHATTER;
}

/* Everything found in a lane's step up to where it is cut; y: the state (from x0) where it goes on. The outcome where the run ends
 * there, or RUNNING. */
static int64_t happen(const Task *task, Work *k, Log *log, int lane, double *y) {
  int64_t outcome = RUNNING, g = task->crossings;
  int effects = 0;
  double time = k->until[lane], start[NX];
  Before before = {time, start};
  V place[NX];
  k->jumped[lane] = 0;
  for (int64_t each = 0; each < k->finds[lane]; ++each) {
    Found found = k->found[lane * FINDS * g + each];
    if (found.time > time) break;
    if (found.crossing >= g) {
      log_touch(task, k, log, lane, found);
      continue;
    }
    const int64_t *crossing = task->crossing + found.crossing * CROSSING;
    if (get(&k->active[found.crossing], lane) == 0) continue; /* an event at the same time left its mode */
    if (!effects) {
      dense(k, lane, v_all((found.time - k->t[lane]) / k->h[lane]), place, 0);
      for (int i = 0; i < NX; ++i) y[i] = place[i][0];
    }
    if (!has_effect(crossing)) {
      outcome = fire(task, k, log, lane, found.crossing, found.time, y);
      put(&k->sign[found.crossing], lane, -get(&k->sign[found.crossing], lane));
    } else {
      if (!effects++) {
        memcpy(start, y, sizeof start), memcpy(k->p_before, k->p[lane], NP * sizeof(double));
        double at[4] = {time, time, time, time};
        see(task, k, lane, at);
        double rate = fabs(k->four[4 * (task->surfaces + crossing[SURFACE])]), zero = task->guard_zero[k->job[lane] * g + found.crossing];
        k->last_event[lane] = found.crossing;
        outcome = crowded(k, lane, time, k->end[lane] - task->begin, rate, zero);
      }
      k->jumped[lane] = 1;
      if (outcome == RUNNING) outcome = fire(task, k, log, lane, found.crossing, time, y);
    }
    if (outcome != RUNNING) {
      k->jumped[lane] = 1; /* the run ends at y */
      return outcome;
    }
  }
  if (!effects) return RUNNING;
  for (int64_t n = 0; n < task->variables; ++n) k->entered[lane * task->variables + n] = 0; /* what the event itself entered */
  return chain(task, k, log, lane, effects, before, time, y);
}

/* A lane goes on behind a break, from y_before to y: what jumps over zero there fires, and the modes follow. */
static int64_t jump(const Task *task, Work *k, Log *log, int lane, double time_before, const double *y_before, double time, double *y) {
  int64_t outcome = RUNNING;
  int effects = 0;
  Before before = {time_before, y_before};
  k->jumped[lane] = 1;
  memcpy(k->p_before, k->p[lane], NP * sizeof(double));
  guards_at(task, k, lane, 0, time, y);
  for (int64_t n = 0; n < task->crossings; ++n) {
    const int64_t *crossing = task->crossing + n * CROSSING;
    double value = k->seen[crossing[SURFACE]][0], side = get(&k->sign[n], lane);
    k->g_before[n] = 0.0;
    if (!(fabs(value) > task->guard_zero[k->job[lane] * task->crossings + n])) continue;
    put(&k->sign[n], lane, value);
    int way = crossing[DIRECTION] == 0 || (crossing[DIRECTION] > 0) == (value > 0);
    if (!(side * value < 0) || !way || (crossing[DIRECTION] && crossing[VARIABLE] >= 0 && crossing[LEAVE] != crossing[ENTER])) continue;
    k->g_before[n] = 1.0;
  }
  for (int64_t n = 0; n < task->crossings && outcome == RUNNING; ++n) {
    if (k->g_before[n] == 0 || get(&k->active[n], lane) == 0) continue;
    effects += has_effect(task->crossing + n * CROSSING);
    outcome = fire(task, k, log, lane, n, time, y);
  }
  return outcome == RUNNING ? chain(task, k, log, lane, effects, before, time, y) : outcome;
}

/* A mode that was entered by a jump and is left again without time passing: the crossing that leaves it, or -1. Guards and rates stand at
 * START. */
static int64_t returning(const Task *task, const Work *k, int lane) {
  double moment = MOMENT * (k->end[lane] - task->begin);
  for (int64_t n = 0; n < task->crossings; ++n) {
    const int64_t *crossing = task->crossing + n * CROSSING, m = crossing[SURFACE];
    if (!is_mode_change(task, k, lane, n) || !k->entered[lane * task->variables + crossing[VARIABLE]]) continue;
    double value = (double)crossing[DIRECTION] * get(&k->guard[START][m], lane), rate = (double)crossing[DIRECTION] * get(&k->guard[START][RATES + m], lane);
    if (rate > 0 && -value <= rate * moment) return n;
  }
  return -1;
}

/* On from a crossing that leaves a mode at once. */
static int64_t go_back(const Task *task, Work *k, Log *log, int lane, int64_t n, double *y) {
  double start[NX], time = k->t[lane];
  Before before = {time, start};
  int64_t outcome;
  k->last_event[lane] = n;
  if (++k->returns[lane] > MANY) return EVENT_CHATTER;
  memcpy(start, y, sizeof start), memcpy(k->p_before, k->p[lane], NP * sizeof(double));
  outcome = fire(task, k, log, lane, n, time, y);
  return outcome == RUNNING ? chain(task, k, log, lane, 1, before, time, y) : outcome;
}

/* Signs of the guards where a lane starts or goes on after an event; guards and rates stand at START. One that is zero and may fire
 * starts on the side from which it fires; one that just fired, and was not taken away, on the side to which the motion goes. */
static void set_signs(const Task *task, Work *k, int lane) {
  int64_t g = task->crossings;
  for (int64_t n = 0; n < g; ++n) {
    const int64_t *crossing = task->crossing + n * CROSSING;
    int64_t m = crossing[SURFACE];
    double value = get(&k->guard[START][m], lane), rate = get(&k->guard[START][RATES + m], lane), sign = value;
    double zero = task->guard_zero[k->job[lane] * g + n];
    int near = fabs(value) <= zero, fired = k->fired[lane * g + n] && fabs(value - k->fired_at[lane * g + n]) <= zero;
    int effect = crossing[VARIABLE] >= 0 || crossing[RESET] >= 0; /* a run may start where another one was stopped */
    k->fired[lane * g + n] = 0;
    k->graze[lane * g + n] = fabs(value) <= TOUCH * zero ? INFINITY : NAN;
    if (near && !effect && !k->leapt[lane]) continue; /* a section keeps the side that it had */
    int rest = crossing[VARIABLE] < 0 && near && crossing[DIRECTION] && fabs(rate) * k->h[lane] <= zero;
    if (effect && fired && !rest) sign = rate != 0 ? rate : value; /* what was brought to rest on its surface may fire again */
    else if (near) sign = effect && crossing[DIRECTION] ? (double)-crossing[DIRECTION] : rate;
    put(&k->sign[n], lane, sign);
  }
  for (int64_t n = 0; n < task->variables; ++n) k->entered[lane * task->variables + n] = 0;
  k->leapt[lane] = k->returns[lane] = 0;
  set_rests(task, k, lane);
  put(&k->fresh, lane, 1.0);
}
