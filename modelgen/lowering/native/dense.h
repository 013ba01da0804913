/* The state within a step, and where outputs and channels are taken from it. Output times never limit a step. */

/* State (from x0) and, with v, rate at fractions theta of the step that was tried last, of one lane or of all. */
static void dense(Work *k, int lane, V theta, V *y, V *v) {
  V value[TERMS + 2], rate[TERMS + 2];
  dense_weights(theta, spread(&k->step, lane), value, rate);
  for (int i = 0; i < NX; ++i) {
    V start = spread(&k->y[i], lane), gain = v_all(0.0), slope = v_all(0.0);
    for (int n = 0; n < TERMS; ++n) {
      V each = spread(&k->now.k[TERM[n]][i], lane);
      gain = gain + value[n] * each;
      if (v) slope = slope + rate[n] * each;
    }
#if NODES
    V middle = spread(&k->now.y_middle[i], lane) - start, end = spread(&k->now.y_end[i], lane) - start;
    gain = gain + (value[TERMS] * middle + value[TERMS + 1] * end);
    if (v) slope = slope + (rate[TERMS] * middle + rate[TERMS + 1] * end);
#endif
    y[i] = start + gain;
    if (v) v[i] = slope;
  }
}

/* Hand on the states y (from x0) of all slots at their times: sample[slot] of the slot's job, or -1 for nothing. */
static void emit(const Task *task, Work *k, const V *y, V time, const int64_t *sample) {
  if (task->states)
    for (int slot = 0; slot < WIDTH; ++slot)
      if (sample[slot] >= 0) {
        double *out = task->states + (k->job[SLOT_LANE(slot)] * task->samples + sample[slot]) * NX;
        for (int i = 0; i < NX; ++i) out[i] = y[i][slot];
      }
  int64_t outputs = task->channels.outputs;
  if (!outputs) return;
  for (int i = 0; i < NX; ++i) k->at_x[i] = spread(&k->x0[i], -1) + y[i];
  task->channels.at(k->channel_c, &time, k->at_x, k->at_x, k->channel);
  for (int slot = 0; slot < WIDTH; ++slot) {
    if (sample[slot] < 0) continue;
    int64_t job = k->job[SLOT_LANE(slot)];
    double *reduced = task->reduced + job * REDUCTIONS * outputs;
    double *kept = task->kept ? task->kept + (job * task->samples + sample[slot]) * outputs : 0;
    for (int64_t n = 0; n < outputs; ++n) {
      double value = k->channel[n][slot];
      reduced[LOWEST * outputs + n] = smaller(reduced[LOWEST * outputs + n], value);
      reduced[HIGHEST * outputs + n] = larger(reduced[HIGHEST * outputs + n], value);
      reduced[SUM * outputs + n] += value, reduced[SQUARES * outputs + n] += value * value;
      if (kept) kept[n] = value;
    }
  }
}

/* When the next output of a lane is due; there is none behind the last. */
static void set_due(const Task *task, Work *k, int lane) {
  int64_t n = k->reached[lane];
  k->due[lane] = n < task->samples ? task->times[k->job[lane] * task->times_stride + n] : INFINITY;
}

/* Outputs from t to where the steps that are taken end, or behind the break there. */
static void write_outputs(const Task *task, Work *k, const double *accepted) {
  V y[NX];
  if (!ANY(S_(and)(is_set(accepted), row(k->due) <= row(k->covers)))) return;
  for (;;) {
    V theta = v_all(0.0), time = v_all(0.0);
    int64_t sample[WIDTH];
    int any = 0;
    for (int slot = 0; slot < WIDTH; ++slot) {
      int lane = SLOT_LANE(slot);
      sample[slot] = -1, time[slot] = k->t[lane];
      if (accepted[lane] == 0 || !(k->due[lane] <= k->covers[lane])) continue;
      if (!k->dense_used[lane]) k->dense_used[lane] = 1, k->evaluations[lane] += EXTRA;
      sample[slot] = k->reached[lane]++, time[slot] = k->due[lane], theta[slot] = (k->due[lane] - k->t[lane]) / k->h[lane];
      set_due(task, k, lane), any = 1;
    }
    if (!any) return;
    if (task->states || task->channels.outputs) {
      dense_stages(k);
      dense(k, -1, theta, y, 0);
      emit(task, k, y, time, sample);
    }
  }
}
