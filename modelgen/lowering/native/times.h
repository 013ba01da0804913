/* The time stage at the times of a step. Values that are sums of waves are read off polynomials in time where that is cheaper.
 *
 * A group of waves with angular frequencies up to B is, over a window of time BANDWIDTH_TIME / B, a polynomial of degree 15 but for
 * rounding: the interpolation at Chebyshev's points of a wave that turns by z to either side errs by less than 4 J_16(z) of its amplitude
 * (Trefethen, Approximation Theory and Approximation Practice, chapter 8), 7e-16 for z = BANDWIDTH_TIME / 2. A lane opens a window
 * where its step does not lie in the one it has; where less than LEAST_STEPS steps would fit, it computes the waves as they are. */

#define BANDWIDTH_TIME 2.8
#define LEAST_STEPS 8

/* Values of the time stage for the n-th new time of a step; times that only the dense output needs begin at LATE. */
#define W_AT(k, n) ((const TIME_VALUE *)(k)->w + (n) / BUNDLE * BUNDLE * NW + (n) % BUNDLE)
enum { LATE = BUNDLES * BUNDLE };

#if GROUPS
/* The sum over j of weight[j] times row j of a table. */
INLINE void combine(const double (*table)[HALF_COUNT], const double *weight, V *out) {
  for (int part = 0; part < HALF_COUNT / WIDTH; ++part) {
    V total = v_all(0.0);
    for (int j = 0; j < HALF_COUNT; ++j) total = v_fma(v_all(weight[j]), ((const V *)table[j])[part], total);
    out[part] = total;
  }
}

/* The polynomials of one lane from time t on, of the group's results at Chebyshev's points: first in Chebyshev's polynomials, the even
 * ones and the odd ones apart, then in powers. */
static void open_window(Work *k, int group, int lane, double t, double width) {
  double center = t + 0.5 * width, half = 0.5 * width;
  V results[MOST_RESULTS], value[MOST_RESULTS][COEFFICIENTS / WIDTH];
  for (int part = 0; part < COEFFICIENTS / WIDTH; ++part) {
    V offset;
    for (int slot = 0; slot < WIDTH; ++slot) offset[slot] = half * POINTS[part * WIDTH + slot];
    V at = center + offset, rest = offset - (at - center); /* all digits of the time, since the center is not less than the offset */
    group_between(group, k->c, lane, at, rest, results);
    for (int n = 0; n < RESULTS[group + 1] - RESULTS[group]; ++n) value[n][part] = results[n];
  }
  for (int n = 0; n < RESULTS[group + 1] - RESULTS[group]; ++n) {
    const double *y = (const double *)value[n];
    double sum[HALF_COUNT], difference[HALF_COUNT];
    V even[HALF_COUNT / WIDTH], odd[HALF_COUNT / WIDTH], even_power[HALF_COUNT / WIDTH], odd_power[HALF_COUNT / WIDTH];
    for (int j = 0; j < HALF_COUNT; ++j) sum[j] = y[j] + y[COEFFICIENTS - 1 - j], difference[j] = y[j] - y[COEFFICIENTS - 1 - j];
    combine(EVEN_SHARE, sum, even), combine(ODD_SHARE, difference, odd);
    combine(EVEN_POWER, (const double *)even, even_power), combine(ODD_POWER, (const double *)odd, odd_power);
    for (int m = 0; m < HALF_COUNT; ++m) {
      S *a = k->window[RESULTS[group] + n] + 2 * m;
      put(a, lane, ((const double *)even_power)[m]), put(a + 1, lane, ((const double *)odd_power)[m]);
    }
  }
  put(&k->window_center[group], lane, center), put(&k->window_scale[group], lane, 1.0 / half);
  put(&k->window_begin[group], lane, t), put(&k->window_end[group], lane, t + width);
}

/* Windows around the steps that the lanes try. How many lanes have one (an idle one does); in[lane] is 1 or 0. */
static int open_windows(Work *k, int group, double *in) {
  int count = 0;
  V end = spread(&k->time, -1) + spread(&k->step, -1);
  if (!v_any((spread(&k->time, -1) < spread(&k->window_begin[group], -1)) | (end > spread(&k->window_end[group], -1)))) return LANES;
  for (int lane = 0; lane < LANES; ++lane) {
    double t = get(&k->time, lane), h = get(&k->step, lane);
    in[lane] = 1.0, ++count;
    if (k->job[lane] < 0 || (t >= get(&k->window_begin[group], lane) && t + h <= get(&k->window_end[group], lane))) continue;
    double width = BANDWIDTH_TIME / get(&k->c[BANDWIDTH[group]], lane);
    if (h * LEAST_STEPS <= width && width < INFINITY) open_window(k, group, lane, t, width);
    else in[lane] = 0.0, --count;
  }
  return count;
}

static void close_windows(Work *k, int lane) {
  for (int group = 0; group < GROUPS; ++group) put(&k->window_begin[group], lane, INFINITY);
}

/* Results of a group at times of a step, by its polynomials. */
static void read_window(const Work *k, int group, const V *t, V *b) {
  const V center = spread(&k->window_center[group], -1), scale = spread(&k->window_scale[group], -1);
  V s[SIDE_BY_SIDE], z[SIDE_BY_SIDE];
  for (int n = 0; n < SIDE_BY_SIDE; ++n) s[n] = (t[n] - center) * scale, z[n] = s[n] * s[n];
  for (int row = RESULTS[group]; row < RESULTS[group + 1]; ++row) {
    const S *a = k->window[row];
    V even[SIDE_BY_SIDE], odd[SIDE_BY_SIDE];
    for (int n = 0; n < SIDE_BY_SIDE; ++n) even[n] = spread(&a[COEFFICIENTS - 2], -1), odd[n] = spread(&a[COEFFICIENTS - 1], -1);
    for (int m = COEFFICIENTS - 4; m >= 0; m -= 2)
      for (int n = 0; n < SIDE_BY_SIDE; ++n) even[n] = v_fma(even[n], z[n], spread(&a[m], -1)), odd[n] = v_fma(odd[n], z[n], spread(&a[m + 1], -1));
    for (int n = 0; n < SIDE_BY_SIDE; ++n) b[row * SIDE_BY_SIDE + n] = v_fma(odd[n], s[n], even[n]);
  }
}
#else
static void close_windows(Work *k, int lane) { (void)k, (void)lane; }
#endif

/* The time stage at fractions of a step from t, put down from place on (a multiple of BUNDLE). within: they lie in the step that the
 * lanes try (k->time, k->step). */
static void stage_times(Work *k, S t, S h, const double *fraction, int times, int place, int within) {
#if NW
#if GROUPS
  double in[GROUPS][LANES];
  int count[GROUPS] = {0};
  for (int group = 0; group < GROUPS && within; ++group) count[group] = open_windows(k, group, in[group]);
#else
  (void)within;
#endif
  for (int first = 0; first < times; first += BUNDLE) {
    V at[SIDE_BY_SIDE], b[WAVES * SIDE_BY_SIDE + 1];
#ifdef SINGLE
    at[0] = v_all(t + h);
    for (int n = 0; n < BUNDLE && first + n < times; ++n) at[0][n] = t + fraction[first + n] * h;
#else
    for (int n = 0; n < BUNDLE; ++n) at[n] = first + n < times ? t + fraction[first + n] * h : t + h;
#endif
#if GROUPS
    for (int group = 0; group < GROUPS; ++group) {
      if (count[group] < LANES)
        for (int n = 0; n < SIDE_BY_SIDE; ++n) group_at(group, k->c, at[n], b + RESULTS[group] * SIDE_BY_SIDE + n);
      if (count[group] == LANES) {
        read_window(k, group, at, b);
      } else if (count[group] > 0) { /* some lanes read, the others compute */
        V other[WAVES * SIDE_BY_SIDE + 1];
        S chosen;
        memcpy(&chosen, in[group], sizeof chosen);
        read_window(k, group, at, other);
        for (int n = RESULTS[group] * SIDE_BY_SIDE; n < RESULTS[group + 1] * SIDE_BY_SIDE; ++n) b[n] = v_select(spread(&chosen, -1) != v_all(0.0), other[n], b[n]);
      }
    }
#endif
    time_stage(k->c, TIMES_OF(at), b, k->w + (place + first) / (BUNDLE / SIDE_BY_SIDE) * NW);
  }
#else
  (void)k, (void)t, (void)h, (void)fraction, (void)times, (void)place, (void)within;
#endif
}

/* At all times of a step, and at one time (then W_AT(k, 0) holds it). */
static void times_at(Work *k, S t, S h) { stage_times(k, t, h, FRACTIONS, TIMES, 0, 1); }
static void time_at(Work *k, S t) { stage_times(k, t, S_(all)(0.0), FRACTIONS, 1, 0, 0); }
