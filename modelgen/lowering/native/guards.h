/* Guards of a step: their values where a step is known, whether they are resolved, and which may pass zero.
 *
 * The rules are those of solvers/guards.py. A step must resolve its guards: at the middle, Hermite's cubic from the ends must meet value
 * and slope. A guard that is linear in the states keeps its side where the Bernstein coefficients of the quintic through its values and
 * rates do, with room for what the guard has beyond it; one that is only sampled, where neither its signs nor its tangents show a zero. */

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

#if HIGH
/* What guards have beyond the quintic through start, middle and end: its factors of (c0 + c1 theta) (theta (theta - 1/2) (theta - 1))^2. */
static void look_beyond(const Task *task, Work *k) {
  S moved[2 * SURFACES + 1], v[NX];
  high_powers(task, k);
  for (int each = 0; each < 2; ++each) {
    for (int64_t n = 0; n < task->reads; ++n) v[task->read[n]] = k->now.k[END][task->read[n]] + k->now.high[each][task->read[n]];
    guard_stage(k->c, W_AT(k, TIMES - 1), k->x, v, moved);
    for (int n = 0; n < SURFACES; ++n) k->beyond[each][n] = moved[SURFACES + n] - k->guard[FULL][RATES + n];
  }
}
#endif

/* Which guards that can only be sampled may pass zero. A dip whose tangents meet far from zero stays there. */
static v_mask sampled(V g0, V g1, V g2, V r0, V r1, V r2, V half, V size, V near) {
  const V zero = v_all(0.0);
  V far0 = DIP * size * v_fabs(r0 - r1), far1 = DIP * size * v_fabs(r1 - r2);
  V meet0 = v_fabs(g0) * v_fabs(r0 - r1) - r0 * (g1 - half * r1 - g0), meet1 = v_fabs(g1) * v_fabs(r1 - r2) - r1 * (g2 - half * r2 - g1);
  v_mask b0 = g0 < zero, b1 = g1 < zero, b2 = g2 < zero, rises0 = r0 > zero, rises1 = r1 > zero, rises2 = r2 > zero;
  v_mask found = (b0 ^ b1) | (b1 ^ b2) | (v_fabs(g0) <= near) | (v_fabs(g1) <= near) | (v_fabs(g2) <= near);
  found |= ~(b0 ^ rises0) & (rises0 ^ rises1) & (meet0 < far0); /* toward zero and away again */
  return found | (~(b1 ^ rises1) & (rises1 ^ rises2) & (meet1 < far1));
}

/* The worst error of the guards' interpolation, in units of what is allowed (below 1e-5: zero), NaN where a guard has no value; and
 * whether a guard may pass zero, as after each start it may. */
static S watch(const Task *task, Work *k) {
  const V zero = v_all(0.0), h = spread(&k->step, -1), half = 0.5 * h, h2 = h * h, h6 = h2 * h2 * h2;
  const v_mask minus = (v_mask)v_all(-0.0);
  V worst = zero;
  v_mask suspects = zero != zero;
  const int rows = ROWS;
  const V *start = (const V *)k->guard[START], *middle = (const V *)k->guard[HALF], *end = (const V *)k->guard[FULL];
  const V *active = (const V *)k->watched, *floor = (const V *)k->guard_floor, *near = (const V *)k->guard_near;
  const V *rest = (const V *)k->guard_rest, *samples = (const V *)k->guard_sampled;
  look_ahead(task, k);
#if HIGH
  const V *one = (const V *)k->beyond[0], *two = (const V *)k->beyond[1];
  look_beyond(task, k);
#endif
  for (int n = 0; n < rows; ++n) {
    V g0 = start[n], g1 = middle[n], g2 = end[n], r0 = start[rows + n], r1 = middle[rows + n], r2 = end[rows + n];
    V off = v_fabs(0.5 * (g0 + g2) + 0.125 * h * (r0 - r2) - g1);
    V off_rate = v_fabs(1.5 * (g2 - g0) - h * (0.25 * (r0 + r2) + r1));
    V size = v_larger(v_larger(v_larger(v_fabs(g0), v_fabs(g1)), v_fabs(g2)), floor[n]);
    size = v_larger(size, h * v_larger(v_larger(v_fabs(r0), v_fabs(r1)), v_fabs(r2)));
    v_mask on = active[n] != zero;
    V miss = v_larger(off, 0.125 * off_rate) + 0.0 * (off + off_rate), allowed = RESOLUTION * size; /* a maximum hides NaN */
    v_mask large = on & ~(miss <= 1e-5 * allowed);
    if (v_any(large)) {
      miss = v_where(large, miss / allowed);
      worst = v_select((miss > worst) | (miss != miss), miss, worst);
    }
    V first = g0 + 0.2 * (h * r0), last = g2 - 0.2 * (h * r2), margin = near[n] + rest[n] * h6;
    V total = 3.2 * g1 - 0.1 * (g0 + g2) - 0.5 * (first + last), step = 1.6 * (h * r1) + 0.5 * (g0 - g2) + 1.5 * (first - last);
    v_mask turned = ((v_mask)g0 & minus) ^ minus; /* so that every coefficient is negative where none has another sign than g0 */
    V most = v_larger(v_larger((V)((v_mask)g0 ^ turned), (V)((v_mask)g2 ^ turned)), v_larger((V)((v_mask)first ^ turned), (V)((v_mask)last ^ turned)));
    most = v_larger(most, v_larger((V)((v_mask)(0.5 * (total - step)) ^ turned), (V)((v_mask)(0.5 * (total + step)) ^ turned)));
#if HIGH
    margin = margin + (1.0 / 432) * v_larger(v_fabs(one[n]), v_fabs(one[n] + two[n]));
#endif
    v_mask found = ~(most < -margin);
    if (task->sampled_guards) {
      v_mask others = samples[n] != zero;
      found = (others & sampled(g0, g1, g2, r0, r1, r2, half, size, near[n])) | (~others & found);
    }
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
