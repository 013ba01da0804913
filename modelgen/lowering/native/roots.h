/* How often a guard passes zero within a step of one lane, and where: the rules of solvers/root_counting.py and solvers/location.py.
 *
 * A step is taken apart into places between which a guard goes one way or has no zero: by the Bernstein coefficients of a polynomial,
 * by enclosures of a guard and its rate over parts of the step, or, where neither exists, by samples. */

enum { POLYNOMIAL, ENCLOSED, SAMPLED }; /* ways of counting */

typedef struct {
  double time, value, rounding, heading; /* heading: the sign of the rate with which a guard comes to a turning point, else 0 */
} Place;

/* One guard of one lane over its step. */
typedef struct {
  const Task *task;
  Work *k;
  int lane, places, undecided;
  int64_t surface;
  double zero, near;
  Place place[MOST_PLACES + DEEPEST + 4];
} Counting;

/* Bounds of a guard over a part of a step, and of its rate; turns: sign changes of the rate, -1 where they are not known. */
typedef struct {
  double low, high, rate_low, rate_high;
  int turns;
} Bounds;

static double guard_at(Counting *c, double time) {
  double at[4] = {time, time, time, time};
  see(c->task, c->k, c->lane, at);
  return c->k->four[4 * c->surface];
}

static void add_place(Counting *c, double time, double value, double rounding, double heading) {
  Place each = {time, value, rounding, heading};
  c->place[c->places++] = each;
}

/* The place where a guard turns, if its rates at both ends say that it does. */
static void turn(Counting *c, double a, double b) {
  const double ends[4] = {a, b, b, b}, *rate = c->k->four + 4 * (c->task->surfaces + c->surface);
  see(c->task, c->k, c->lane, ends);
  const double at_a = rate[0], at_b = rate[1];
  if (!(at_a * at_b < 0)) return;
  double place = locate(c->task, c->k, c->lane, c->task->surfaces + c->surface, at_a < 0, a, b, at_a, at_b);
  add_place(c, place, guard_at(c, place), 0.0, at_a < 0 ? -1.0 : 1.0);
}

/* Whether a part needs no halving: there is no zero, the guard goes one way, or it turns once. */
static int is_done(Counting *c, const Bounds *found, double a, double b, int depth) {
  if (found->low > c->near || found->high < -c->near || found->rate_low >= 0 || found->rate_high <= 0) return 1;
  int narrow = -c->near <= found->low && found->high <= c->near, last = depth >= DEEPEST || c->places >= MOST_PLACES;
  if (!(found->turns == 1 || narrow || last)) return 0;
  c->undecided |= !(found->turns == 1 || narrow);
  turn(c, a, b);
  return 1;
}

static void look_at(Counting *c, double time) { add_place(c, time, guard_at(c, time), c->zero, 0.0); }

/* Places of a polynomial by its eight Bernstein coefficients over a part of the step; de Casteljau's scheme halves. */
static void by_polynomial(Counting *c, const double *b, double from, double to, int depth) {
  Bounds found = {b[0], b[0], INFINITY, -INFINITY, 0};
  double before = 0.0, row[8], left[8], right[8], middle = from + 0.5 * (to - from);
  for (int i = 1; i < 8; ++i) {
    double step = b[i] - b[i - 1];
    found.low = smaller(found.low, b[i]), found.high = larger(found.high, b[i]);
    found.rate_low = smaller(found.rate_low, step), found.rate_high = larger(found.rate_high, step);
    if (step != 0) found.turns += before * step < 0, before = step < 0 ? -1.0 : 1.0;
  }
  if (is_done(c, &found, from, to, depth)) return;
  memcpy(row, b, sizeof row);
  for (int i = 0; i < 8; ++i) {
    left[i] = row[0], right[7 - i] = row[7 - i];
    for (int j = 0; j < 7 - i; ++j) row[j] = 0.5 * row[j] + 0.5 * row[j + 1];
  }
  by_polynomial(c, left, from, middle, depth + 1);
  look_at(c, middle);
  by_polynomial(c, right, middle, to, depth + 1);
}

/* The Bernstein coefficients of a polynomial over the part of the step from a to b, in place of those over all of it. */
static void part_of(double *row, double a, double b) {
  double share = (b - a) / (1 - a);
  for (int i = 0; i < DEGREE && a > 0; ++i)
    for (int j = 0; j < DEGREE - i; ++j) row[j] = (1 - a) * row[j] + a * row[j + 1];
  for (int i = 0; i < DEGREE && b < 1; ++i)
    for (int j = DEGREE; j > i; --j) row[j] = (1 - share) * row[j - 1] + share * row[j];
}

/* Ranges of the states and of their rates between two times of a lane's step: lows, then highs, in one slot. */
static void span(const Task *task, const Work *k, int lane, int slot, double from, double to, V *x, V *v) {
  const double h = k->h[lane], t = k->t[lane], a = (from - t) / h, b = to < k->t_new[lane] ? (to - t) / h : 1.0;
  for (int64_t n = 0; n < task->reads; ++n) {
    const int64_t i = task->read[n];
    double row[DEGREE + 1], start = get(&k->y[i], lane), low, high, slowest, fastest, per = DEGREE / ((b - a) * h);
    for (int j = 0; j <= DEGREE; ++j) {
      row[j] = start;
      for (int m = 0; m < TERMS; ++m) row[j] += BERNSTEIN[m][j] * (h * get(&k->now.k[TERM[m]][i], lane));
#if NODES
      row[j] += BERNSTEIN[TERMS][j] * (get(&k->now.y_middle[i], lane) - start) + BERNSTEIN[TERMS + 1][j] * (get(&k->now.y_end[i], lane) - start);
#endif
    }
    part_of(row, a, b);
    low = high = row[0], slowest = fastest = per * (row[1] - row[0]);
    for (int j = 1; j <= DEGREE; ++j) {
      double speed = per * (row[j] - row[j - 1]);
      low = smaller(low, row[j]), high = larger(high, row[j]), slowest = smaller(slowest, speed), fastest = larger(fastest, speed);
    }
    x[i][slot] = get(&k->x0[i], lane) + low, x[NX + i][slot] = get(&k->x0[i], lane) + high;
    v[i][slot] = slowest, v[NX + i][slot] = fastest;
  }
  v[2 * NX][slot] = from, v[2 * NX + 1][slot] = to;
}

/* Bounds of a guard over parts of the step that follow each other, between so many times, side by side. */
static void enclose(Counting *c, int parts, const double *ends, Bounds *found) {
  const int64_t g = c->task->surfaces, m = c->surface;
  const V none = v_all(c->k->t[c->lane]), *each = c->k->bounded;
  V x[2 * NX], v[2 * NX + 2];
  for (int i = 0; i < 2 * NX; ++i) x[i] = v[i] = v_all(0.0);
  v[2 * NX] = v[2 * NX + 1] = none;
  for (int n = 0; n < parts; ++n) span(c->task, c->k, c->lane, n, ends[n], ends[n + 1], x, v);
  c->task->bounds.at(c->k->lane_bounds_c, &none, x, v, c->k->bounded);
  for (int n = 0; n < parts; ++n) {
    Bounds one = {each[m][n], each[2 * g + m][n], each[g + m][n], each[3 * g + m][n], -1};
    found[n] = one;
  }
}

static void by_enclosures(Counting *c, const Bounds *found, double from, double to, int depth) {
  const double middle = from + 0.5 * (to - from), ends[] = {from, middle, to};
  Bounds half[2];
  if (is_done(c, found, from, to, depth)) return;
  enclose(c, 2, ends, half);
  by_enclosures(c, half, from, middle, depth + 1);
  look_at(c, middle);
  by_enclosures(c, half + 1, middle, to, depth + 1);
}

/* Whether the quintic through a guard's values and rates, given by its Bernstein coefficients, shows that the guard stays on its side of
 * zero or goes one way, with room for what it has beyond the quintic (infinite where that has no bound) and for the rate of that. */
static int is_plain(const Counting *c, const double *b) {
  const Work *k = c->k;
  double h = k->h[c->lane], rest = get(&k->guard_rest[c->surface], c->lane) * h * h * h * h * h * h, beyond = 0.0, bend = 0.0;
  double low = b[0], high = b[0], slowest = INFINITY, fastest = -INFINITY;
#if HIGH
  double one = get(&k->beyond[0][c->surface], c->lane), two = get(&k->beyond[1][c->surface], c->lane), most = larger(fabs(one), fabs(one + two));
  beyond = most / 432, bend = 0.05 * most + fabs(two) / 432;
#endif
  for (int i = 1; i < 6; ++i) {
    double step = 5 * (b[i] - b[i - 1]);
    low = smaller(low, b[i]), high = larger(high, b[i]), slowest = smaller(slowest, step), fastest = larger(fastest, step);
  }
  beyond += c->near + rest, bend += 130 * rest; /* 130: of the remainders of the rate and of the value, 432 720 0.0482 / 120 */
  return low > beyond || high < -beyond || slowest > bend || fastest < -bend;
}

/* All places of a guard, from the start of the step to its end. */
static void find_places(Counting *c) {
  const Task *task = c->task;
  Work *k = c->k;
  const int lane = c->lane;
  const int64_t m = c->surface, way = task->way[m];
  double g[3], r[3], h = k->h[lane], from = k->t[lane], to = k->t_new[lane], middle = from + 0.5 * h;
  for (int n = 0; n < 3; ++n) g[n] = get(&k->guard[n][m], lane), r[n] = h * get(&k->guard[n][RATES + m], lane);
  c->places = c->undecided = 0;
  add_place(c, from, g[0], c->zero, 0.0);
  double first = g[0] + 0.2 * r[0], last = g[2] - 0.2 * r[2];
  double total = 3.2 * g[1] - 0.1 * (g[0] + g[2]) - 0.5 * (first + last), step = 1.6 * r[1] + 0.5 * (g[0] - g[2]) + 1.5 * (first - last);
  double b[8] = {g[0], first, 0.5 * (total - step), 0.5 * (total + step), last, g[2]};
  if (way != SAMPLED && is_plain(c, b)) {
    add_place(c, to, g[2], c->zero, 0.0);
    return;
  }
  if (way == POLYNOMIAL) {
    static const double SQUARE[8] = SQUARE_COEFFICIENTS, CUBE[8] = CUBE_COEFFICIENTS;
    for (int degree = 5; degree < 7; ++degree) {
      b[degree + 1] = b[degree];
      for (int i = degree; i > 0; --i) b[i] = (1 - i / (degree + 1.0)) * b[i] + i / (degree + 1.0) * b[i - 1];
    }
#if HIGH
    for (int i = 0; i < 8; ++i) b[i] += SQUARE[i] * get(&k->beyond[0][m], lane) + CUBE[i] * get(&k->beyond[1][m], lane);
#else
    (void)SQUARE, (void)CUBE;
#endif
    by_polynomial(c, b, from, to, 0);
  } else if (way == ENCLOSED) {
    const double ends[] = {from, to};
    Bounds whole;
    for (int64_t n = 0; n < task->bounds.values; ++n) k->lane_bounds_c[n] = ONE_LANE(k->bounds_c[n], lane);
    enclose(c, 1, ends, &whole), by_enclosures(c, &whole, from, to, 0);
  } else {
    turn(c, from, middle), add_place(c, middle, g[1], c->zero, 0.0), turn(c, middle, to);
  }
  add_place(c, to, g[2], c->zero, 0.0);
}

/* Note what a lane comes upon in its step, in order of time: a crossing by its number, a touch behind all of them. */
static void note(const Task *task, Work *k, int lane, int64_t n, double time) {
  Found *found = k->found + lane * FINDS * task->crossings;
  int64_t at = k->finds[lane];
  if (at >= FINDS * task->crossings) return;
  ++k->finds[lane];
  for (; at > 0 && (found[at - 1].time > time || (found[at - 1].time == time && found[at - 1].crossing > n)); --at) found[at] = found[at - 1];
  found[at].time = time, found[at].crossing = n;
}

/* The walk of one guard over its places: passings of zero, and touches. */
static void walk(Counting *c, int64_t n, int64_t direction, double *side, double *graze) {
  double closest = INFINITY;
  for (int each = 1; each < c->places; ++each) {
    Place *before = c->place + each - 1, *place = c->place + each;
    int clear = fabs(place->value) > c->near;
    double side_there = fabs(place->value) > place->rounding ? (place->value < 0 ? -1.0 : 1.0) : 0.0;
    double heading = place->heading != 0 ? place->heading : place->value - before->value;
    /* Right after its event a guard stands a little beyond zero: its way back is none, its return from there is. */
    if (*side * side_there < 0 && heading * side_there > 0) {
      if (direction == 0 || (direction > 0) == (side_there > 0))
        note(c->task, c->k, c->lane, n, locate(c->task, c->k, c->lane, c->surface, *side < 0, before->time, place->time, before->value, place->value));
      *side = side_there, *graze = INFINITY; /* excused until it is clear of zero */
    } else if (*side == 0) {
      *side = side_there;
    }
    if (clear) {
      if (*graze < INFINITY && *side * side_there > 0) note(c->task, c->k, c->lane, c->task->crossings + n, *graze);
      *graze = NAN, closest = INFINITY;
    } else if (!(*graze == INFINITY) && fabs(place->value) < closest) {
      *graze = place->time, closest = fabs(place->value);
    }
  }
}

/* All zeros of the guards of one lane in its step, and all touches, in order of time. */
static void find(const Task *task, Work *k, int lane) {
  Counting c;
  c.task = task, c.k = k, c.lane = lane, c.places = c.undecided = 0, c.surface = -1;
  k->finds[lane] = 0;
  for (int64_t n = 0; n < task->guards.values; ++n) k->lane_guard_c[n] = ONE_LANE(k->guard_c[n], lane);
  for (int64_t n = 0; n < task->crossings; ++n) {
    const int64_t *crossing = task->crossing + n * CROSSING, at = lane * task->crossings + n, m = crossing[SURFACE];
    c.zero = task->guard_zero[k->job[lane] * task->crossings + n], c.near = TOUCH * c.zero;
    k->side[at] = get(&k->sign[n], lane), k->graze_after[at] = k->graze[at];
    if (get(&k->active[n], lane) == 0) {
      double end = get(&k->guard[FULL][m], lane);
      if (fabs(end) > c.zero) k->side[at] = end;
      continue;
    }
    if (c.surface != m) c.surface = m, find_places(&c);
    if (c.undecided) task->undecided[k->job[lane] * task->crossings + n] = 1;
    walk(&c, n, crossing[DIRECTION], k->side + at, k->graze_after + at);
  }
}

/* Signs of one lane's guards at the end of a step that was taken as a whole, and whether one of them must be looked at in the next. */
static void keep_signs(const Task *task, Work *k, int lane) {
  double unsettled = 0.0;
  for (int64_t n = 0; n < task->crossings; ++n) {
    const int64_t at = lane * task->crossings + n, m = task->crossing[n * CROSSING + SURFACE];
    double end = get(&k->guard[FULL][m], lane);
    put(&k->sign[n], lane, k->side[at]), k->graze[at] = k->graze_after[at];
    if (!(k->side[at] * end > 0) || k->graze[at] < INFINITY) unsettled = 1.0;
  }
  put(&k->fresh, lane, unsettled);
}
