/* Guards of a step: their values where a step is known, whether they are resolved, and where they pass zero.
 *
 * The rules are those of solvers/events.py: a guard has the sign of its value; where that is zero, the sign it had before. A step must
 * resolve its guards: at the middle, Hermite's cubic from the ends must meet value and slope. Then on each half a guard has at most one
 * zero, or two where its slopes at the ends lead toward zero and away again. */

enum { START, HALF, FULL }; /* nodes of a step */

/* Crossings that differ only in direction and mode share a surface. Surfaces stand in rows of V: one surface of all lanes, or, where
 * one trajectory runs, WIDTH surfaces side by side. */
#ifdef SINGLE
enum { ROWS = (SURFACES + WIDTH - 1) / WIDTH };
#else
enum { ROWS = SURFACES };
#endif
enum { RATES = ROWS * (WIDTH / LANES) }; /* where the rates begin behind the guards, counted in S */

/* Guards and rates at a node: values of the time stage there, state from x0, slope. */
static void look(const Task *task, Work *k, int node, const TIME_VALUE *w, const S *y, const S *slope) {
  S out[2 * SURFACES + 1];
  for (int64_t n = 0; n < task->reads; ++n) k->x[task->read[n]] = k->x0[task->read[n]] + y[task->read[n]];
  guard_stage(k->c, w, k->x, slope, out);
  for (int n = 0; n < SURFACES; ++n) k->guard[node][n] = out[n], k->guard[node][RATES + n] = out[SURFACES + n];
}

/* Guards at the middle and end of the step that was tried. */
static void look_ahead(const Task *task, Work *k) {
#if NODES
  look(task, k, HALF, W_AT(k, MIDDLE_TIME), k->now.y_middle, k->now.k[MIDDLE]);
#else
  middle_node(task, k);
  look(task, k, HALF, W_AT(k, MIDDLE_TIME), k->now.y_middle, k->now.middle_slope);
#endif
  look(task, k, FULL, W_AT(k, TIMES - 1), k->now.y_end, k->now.k[END]);
}

/* The worst error of the guards' interpolation, in units of what is allowed (below 1e-5: zero), NaN where a guard has no value; and
 * whether a guard may pass zero, as after each start it may. A dip whose tangents meet far from zero stays there. */
static S watch(const Task *task, Work *k) {
  const V zero = v_all(0.0), h = spread(&k->step, -1), half = 0.5 * h;
  V worst = zero;
  v_mask suspects = zero != zero;
  const int rows = ROWS;
  const V *start = (const V *)k->guard[START], *middle = (const V *)k->guard[HALF], *end = (const V *)k->guard[FULL];
  const V *active = (const V *)k->watched, *floor = (const V *)k->guard_floor;
  look_ahead(task, k);
  for (int n = 0; n < rows; ++n) {
    V g0 = start[n], g1 = middle[n], g2 = end[n], r0 = start[rows + n], r1 = middle[rows + n], r2 = end[rows + n];
    V off = v_fabs(0.5 * (g0 + g2) + 0.125 * h * (r0 - r2) - g1);
    V off_rate = v_fabs(1.5 * (g2 - g0) - h * (0.25 * (r0 + r2) + r1));
    V size = v_larger(v_larger(v_larger(v_fabs(g0), v_fabs(g1)), v_fabs(g2)), floor[n]);
    size = v_larger(size, h * v_larger(v_larger(v_fabs(r0), v_fabs(r1)), v_fabs(r2)));
    v_mask on = active[n] != zero;
    V miss = v_larger(off, 0.125 * off_rate) + 0.0 * (off + off_rate), allowed = 0.02 * size; /* a maximum hides NaN */
    v_mask large = on & ~(miss <= 1e-5 * allowed);
    if (v_any(large)) {
      miss = v_where(large, miss / allowed);
      worst = v_select((miss > worst) | (miss != miss), miss, worst);
    }
    V far0 = 0.1 * size * v_fabs(r0 - r1), far1 = 0.1 * size * v_fabs(r1 - r2);
    V meet0 = v_fabs(g0) * v_fabs(r0 - r1) - r0 * (g1 - half * r1 - g0), meet1 = v_fabs(g1) * v_fabs(r1 - r2) - r1 * (g2 - half * r2 - g1);
    v_mask b0 = g0 < zero, b1 = g1 < zero, b2 = g2 < zero, rises0 = r0 > zero, rises1 = r1 > zero, rises2 = r2 > zero;
    v_mask found = (b0 ^ b1) | (b1 ^ b2) | (g0 == zero) | (g1 == zero) | (g2 == zero);
    found |= ~(b0 ^ rises0) & (rises0 ^ rises1) & (meet0 < far0); /* toward zero and away again */
    found |= ~(b1 ^ rises1) & (rises1 ^ rises2) & (meet1 < far1);
    suspects |= on & found;
  }
#ifdef SINGLE
  double total = 0.0;
  for (int i = 0; i < WIDTH; ++i) total = worst[i] > total || worst[i] != worst[i] ? worst[i] : total;
  k->suspects = v_any(suspects) | (k->fresh != 0);
  return total;
#else
  k->suspects = suspects | (k->fresh != zero);
  return worst;
#endif
}

/* Guards and rates of one lane at four times of its step: k->four[4 n ...] holds them. */
static void see(const Task *task, Work *k, int lane, const double *at) {
  V y[NX], v[NX];
  for (int first = 0; first < 4; first += WIDTH) {
    V time = v_all(at[3]), theta;
    for (int slot = 0; slot < WIDTH && first + slot < 4; ++slot) time[slot] = at[first + slot];
    theta = (time - k->t[lane]) / k->h[lane];
    dense(k, lane, theta, y, v);
    for (int i = 0; i < NX; ++i) y[i] = spread(&k->x0[i], lane) + y[i];
    task->guards.at(k->lane_guard_c, &time, y, v, k->seen);
    for (int64_t n = 0; n < task->guards.outputs; ++n)
      for (int slot = 0; slot < WIDTH && first + slot < 4; ++slot) k->four[4 * n + first + slot] = k->seen[n][slot];
  }
}

/* The first time with the new sign of entry n (a surface, or from task->surfaces on its rate) in (a, b], where a has the old one: four
 * places at once, two of them close around the secant's. The value there is left in *value (not touched where it is at b). */
static double locate(const Task *task, Work *k, int lane, int64_t n, int below, double a, double b, double value_a, double value_b) {
  double closeness = 0.01, resolution = 2 * ulp(larger(fabs(a), fabs(b)));
  for (int round = 0; round < 200 && b - a > resolution; ++round) {
    double share = value_a / (value_a - value_b), width = b - a, at[4];
    double secant = share > 0 && share < 1 ? a + share * width : a + 0.5 * width, near = larger(closeness * width, resolution / 2);
    at[1] = larger(secant - near, a + 0.125 * smaller(near, secant - a)), at[2] = smaller(secant + near, b - 0.125 * smaller(near, b - secant));
    at[0] = a + 0.5 * (at[1] - a), at[3] = b - 0.5 * (b - at[2]);
    see(task, k, lane, at);
    int first = 0;
    for (; first < 4; ++first) {
      double value = k->four[4 * n + first];
      if (value == 0 && at[first] > a) return at[first];
      if (value != 0 && (value < 0) != below) break;
    }
    if (first < 4 && at[first] < b) b = at[first], value_b = k->four[4 * n + first];
    if (first > 0 && at[first - 1] > a && at[first - 1] < b) a = at[first - 1], value_a = k->four[4 * n + first - 1];
    closeness = first == 2 ? larger(closeness * closeness, 1e-15) : smaller(0.25, 4 * closeness);
    if (!(b - a < width)) break;
  }
  return b;
}

static void note(const Task *task, Work *k, int lane, int64_t n, double time) {
  Found *found = k->found + lane * 4 * task->crossings;
  int64_t at = k->finds[lane]++;
  for (; at > 0 && (found[at - 1].time > time || (found[at - 1].time == time && found[at - 1].crossing > n)); --at) found[at] = found[at - 1];
  found[at].time = time, found[at].crossing = n;
}

/* All zeros of the guards of one lane in its step, in order of time. */
static void find(const Task *task, Work *k, int lane) {
  int64_t g = task->surfaces;
  k->finds[lane] = 0;
  for (int64_t n = 0; n < task->guards.values; ++n) k->lane_guard_c[n] = ONE_LANE(k->guard_c[n], lane);
  for (int64_t n = 0; n < task->crossings; ++n) {
    if (get(&k->active[n], lane) == 0) continue;
    int64_t direction = task->crossing[n * CROSSING + DIRECTION], m = task->crossing[n * CROSSING + SURFACE];
    double side = get(&k->sign[n], lane), zero = task->guard_zero[k->job[lane] * task->crossings + n];
    for (int node = START; node < FULL; ++node) {
      double one = get(&k->guard[node][m], lane), two = get(&k->guard[node + 1][m], lane);
      double rate = get(&k->guard[node][RATES + m], lane), end_rate = get(&k->guard[node + 1][RATES + m], lane);
      double a = k->t[lane] + (node == START ? 0.0 : 0.5 * k->h[lane]), b = node == START ? k->t[lane] + 0.5 * k->h[lane] : k->t_new[lane];
      double next = fabs(two) <= zero ? side : two; /* rounding has no sign */
      int below = side < 0;
      if (side * next < 0) {
        if (side * one <= 0 && side * rate > 0 && side * end_rate < 0) { /* a little beyond zero after its event: not its way back */
          a = locate(task, k, lane, g + m, rate < 0, a, b, rate, end_rate);
          double at[4] = {a, a, a, a};
          see(task, k, lane, at);
          one = k->four[4 * m];
        }
        if (direction == 0 || (direction > 0) == below) note(task, k, lane, n, locate(task, k, lane, m, below, a, b, one, two));
      } else if (below ? rate > 0 && end_rate < 0 : side > 0 && rate < 0 && end_rate > 0) {
        double turn = locate(task, k, lane, g + m, rate < 0, a, b, rate, end_rate), at[4] = {turn, turn, turn, turn};
        see(task, k, lane, at);
        double value = k->four[4 * m];
        if (value != 0 && (value < 0) != below) { /* there and back */
          if (direction == 0 || (direction > 0) == below) note(task, k, lane, n, locate(task, k, lane, m, below, a, turn, one, value));
          if (direction == 0 || (direction < 0) == below) note(task, k, lane, n, locate(task, k, lane, m, !below, turn, b, value, two));
        }
      }
      side = next;
    }
  }
}

/* Signs of one lane's guards at the end of a step that was taken as a whole. */
static void keep_signs(const Task *task, Work *k, int lane) {
  for (int64_t n = 0; n < task->crossings; ++n) {
    int64_t m = task->crossing[n * CROSSING + SURFACE];
    double half = get(&k->guard[HALF][m], lane), end = get(&k->guard[FULL][m], lane);
    double zero = task->guard_zero[k->job[lane] * task->crossings + n], sign = fabs(end) > zero ? end : fabs(half) > zero ? half : 0.0;
    if (sign != 0) put(&k->sign[n], lane, sign);
  }
  put(&k->fresh, lane, 0.0);
}
