/* One Taylor step, or the event it runs into: the series is the dense output and holds the events.
 * A step is begun, its series are made, it is measured, and taken: for one motion here, for lanes of
 * motions in lanes.c, which does for all of them at once what one motion does with its series. */

/* Series of guards and ramps over a step: order k of number j is at[k * row + j * next]. The series
 * of the motion itself, as long as they lie elsewhere than in the run, are as far apart in `series`. */
typedef struct {
  const double *at, *least, *series;
  int row, next;
} ps_look;

static void own_series(ps_run *s, ps_look *g) {
  if (!g->series) return;
  for (int k = 0; k <= s->order; k++)
    for (int c = 0; c < s->variant->series.columns; c++)
      s->v[k][c] = g->series[(k * PS_COLUMNS + c) * g->next];
  g->series = NULL;
}

static void column(const ps_look *g, int j, int order, double *p) {
  int k = 0;
  do p[k] = g->at[k * g->row + j * g->next];
  while (++k <= PS_MAX(order, 1));
}

/* Part of the series of a guard, by size, above which its last two terms make it doubtful. */
static const double PS_TAIL = 1e-4;

/* Whether guard j is a sum of states, whose series is as exact as theirs. */
static int of_states(const ps_run *s, int j) {
  return (s->variant->series.of_states >> j) & 1;
}

static int may_vanish(const ps_look *g, int j) {
  return !(g->least[j * g->next] > 0);
}

static double guard_along(ps_run *s, int j, double h, double u) {
  double y[PS_NX], g[PS_NG], dg[PS_NG];
  state_at(s, u * h, y);
  guards(s, y, g, dg);
  return g[j];
}

/* Place of the first zero of guard j itself, where its series says it is at u. While a force is tiny
 * the series without it, or beyond the reach of its own, are good for the states of the step, not for
 * what a guard makes of the force: the friction that a contact can bear, just after it has closed. */
static double zero_of_guard(ps_run *s, int j, double h, double u) {
  double a = 0, b = u;
  int above = s->armed[j];
  if (!above || guard_along(s, j, h, u) > 0) {
    for (int i = 1; i <= PS_SAMPLES; i++) {
      b = (double)i / PS_SAMPLES;
      int positive = guard_along(s, j, h, b) > 0;
      if (above && !positive) break;
      above |= positive;
      if (positive) a = b;
    }
  }
  if (a == 1) return -1;
  if (!above) return u;
  for (int it = 0; it < 60 && b - a > 4e-16 * b; it++) {
    double middle = 0.5 * (a + b);
    if (guard_along(s, j, h, middle) > 0) a = middle; else b = middle;
  }
  return b;
}

/* Whether the series of guard j, of that outline, does not reach the end of the step. A guard made of a
 * low power of a base that has just been zero may change much while the power does nothing to the
 * states yet. */
static int diverges(const ps_look *g, int j, int order, const ps_outline *o) {
  const double *last = g->at + order * g->row + j * g->next;
  return fabs(last[0]) + fabs(last[-g->row]) > PS_TAIL * o->size;
}

/* Earliest event inside a step of h units: its guard and its place in [0, 1]; -1 for none, and then
 * `rising` has the guards that are positive at the end. */
static int find_event(ps_run *s, ps_look *g, double h, double at_once, double *where,
                      ps_bits *rising) {
  int n = s->variant->n, first = -1, order = s->order, known = 0;
  double y[PS_NX], after[PS_NG], slope[PS_NG];
  *where = 2;
  *rising = 0;
  for (int j = 0; j < n; j++) {
    double p[PS_LENGTH], u;
    const int exact = of_states(s, j);
    int own = s->left_out && !exact;
    if (s->armed[j] && !may_vanish(g, j) && !own) continue;
    const ps_outline o = outline(g->at + j * g->next, g->row, order);
    double end = o.end;
    const int crosses = end <= 0, doubtful = diverges(g, j, order, &o);
    /* A state that left zero within its tolerance: its series does not tell when it is back. */
    if (exact && doubtful && !s->armed[j]) continue;
    /* Of a slip that has just begun the series without the force says nothing but rounding. */
    const int begins = s->left_out && exact && !s->armed[j] && crosses;
    if (own || begins || (!exact && doubtful)) {
      if (!known) {
        own_series(s, g);
        state_at(s, h, y);
        guards(s, y, after, slope);
      }
      known = 1;
      if (begins && slope[j] > 0) continue;
      /* Where both cross zero, the series says where: the event is placed on the guard itself. Where
       * only the series does, away from a zero of a base, its place shortens the step. */
      own |= !exact && (crosses ? s->zero != 0 && after[j] > 0 : after[j] <= 0);
      if (own) end = after[j];
    }
    if (end > 0) *rising |= (ps_bits)1 << j;
    /* Positive where it is least. */
    if (s->armed[j] && o.steepest < 0 && o.end > 0 && end > 0) continue;
    column(g, j, order, p);
    int crossed = end <= 0 && (s->armed[j] || end < 0 || horner_slope(p, order, 1) < 0);
    if (s->armed[j]) {
      u = p[0] > 0 ? first_root(p, order, 0) : PS_AT_ONCE;
      if (u < 0 && crossed) u = 1;
    } else {
      u = next_root(p, order, at_once, crossed);
    }
    if (u >= 0 && own) u = zero_of_guard(s, j, h, u);
    if (u >= 0 && u < *where - PS_TIE) {
      *where = u;
      first = j;
    }
  }
  return first;
}

/* Place in [0, 1] just beyond which the base of a live power has gone to zero, else 1. */
static double until_kink(ps_run *s, const ps_look *g) {
  int n = s->variant->n;
  double u = 1;
  for (int r = 0; r < s->variant->series.ramps; r++) {
    double p[PS_LENGTH];
    if (!(s->live[r] > 0) || !may_vanish(g, n + r) || s->variant->series.guarded[r]) continue;
    column(g, n + r, s->order, p);
    double root = first_root(p, s->order, 0);
    if (root < 0) continue;
    root = PS_MAX(root * (1 + 1e-9), 1e-9);
    u = PS_MIN(u, root);
  }
  return u;
}

/* States that a register holds in the change of basis below, at most half of what is changed at once. */
#if PS_WIDTH >= 4 && PS_NX >= 4
#define PS_SIDE 4
#elif PS_NX >= 2
#define PS_SIDE 2
#else
#define PS_SIDE 1
#endif
typedef double ps_side __attribute__((vector_size(8 * PS_SIDE)));

/* Rows of the dense output (see Trajectory) of the step of h units: the same polynomial. Its terms are
 * divided by u and by 1 - u in turn; what remains each time is a row. Two registers of states take
 * turns, since each sum waits for the one before. The last ones may be the same states again. */
static void dense_rows(const ps_run *s, double h, double *row) {
  const int p = s->order;
  double power[PS_LENGTH];
  power[0] = 1;
  for (int k = 1; k <= p; k++) power[k] = power[k - 1] * h;
  for (int c = 0; c < PS_NX; c += 2 * PS_SIDE) {
    const int one = PS_MIN(c, PS_NX - PS_SIDE), other = PS_MIN(c + PS_SIDE, PS_NX - PS_SIDE);
    int lowest = 0, highest = p;
    ps_side a[PS_LENGTH], b[PS_LENGTH];
    for (int k = 0; k <= p; k++) {
      memcpy(a + k, s->v[k] + one, sizeof *a);
      memcpy(b + k, s->v[k] + other, sizeof *b);
      a[k] *= power[k];
      b[k] *= power[k];
    }
    for (int r = 0; r <= p; r++) {
      ps_side x = {0}, y = {0};
      if (r % 2 == 0) {
        x = a[lowest];
        y = b[lowest++];
      } else {
        for (int k = highest; k >= lowest; k--) {
          const ps_side next = x + a[k], after = y + b[k];
          a[k] = -x;
          b[k] = -y;
          x = next;
          y = after;
        }
        highest--;
      }
      memcpy(row + r * PS_NX + one, &x, sizeof x);
      memcpy(row + r * PS_NX + other, &y, sizeof y);
    }
  }
}

static ps_moment inside(ps_run *s, double h, double row[][PS_NX], double u, double *x) {
  ps_moment now = {time_at(s, u * h), h * pace_at(s, u * h)};
  (void)row;
  state_at(s, u * h, x);
  return now;
}

static int keep_step(ps_run *s, const ps_options *o, double h) {
  watch_step(s, h, NULL);
  if (o->record < 2) return 1;
  double row[PS_LENGTH * PS_NX];
  dense_rows(s, h, row);
  double t = time_at(s, h);
  return record_step(s, o, t, row, s->order + 1, 0.5 * s->bend * h * h / t);
}

/* So often in a row a guard may have no zero where its series has one; then its round-off is larger
 * than what a step makes of it, and the zero is where the series says. */
static const int PS_MISSES = 8;

/* Brings the end of the step, h of `whole` units, to the zero of guard j itself; 0, and h as it was,
 * where that has none: near a zero of a force its series is not as exact as the states. y is the state
 * at h. */
static int polish(ps_run *s, int j, double whole, double *h, double *y) {
  double g[PS_NG], dg[PS_NG], before = HUGE_VAL;
  const double start = *h;
  int beyond = 0, reaches = 0;
  for (int it = 0; it < 6 && !reaches; it++) {
    state_at(s, *h, y);
    guards(s, y, g, dg);
    if (g[j] == 0 || (beyond && g[j] < 0)) return 1;
    double change = -g[j] / (dg[j] * pace_at(s, *h));
    const double shrinks = change / before;
    if (!(dg[j] < 0) || !(fabs(change) < 0.01 * whole)) break;
    /* As near as h, or the time, can tell. */
    if (fabs(change) <= 1e-15 * whole) return 1;
    if (fabs(g[j]) <= -dg[j] * PS_MOMENT * fabs(s->t)) return 1;
    /* Changes shrink with their squares: the next one would be nothing. */
    reaches = it > 0 && shrinks * shrinks * fabs(change) <= 1e-17 * whole;
    if (fabs(change) > 0.5 * before) {
      /* Round-off of a guard that hardly moves: beyond its zero, so that it is not met again. */
      if (g[j] < 0) return 1;
      beyond = 1;
      change *= 2;
    }
    *h = PS_MAX(*h + change, 0);
    before = fabs(change);
  }
  if (!reaches && !(g[j] < 0)) *h = start;
  state_at(s, *h, y);
  return reaches || g[j] < 0;
}

/* Ends the step at the event of guard j, at the part `where` of h units, and takes it. */
static void take_event(ps_run *s, const ps_options *o, int j, double where, double h) {
  double y[PS_NX];
  ps_bits departs = 0;
  int fires = 1;
  const double whole = h;
  h *= where;
  if (where > PS_AT_ONCE)
    fires = polish(s, j, whole, &h, y) || s->missed == PS_MISSES;
  else
    state_at(s, h, y);
  if (fires) s->missed = 0;
  /* A guard that rises all the way there has no zero, however often its series has one. */
  else if (!(guard_along(s, j, h, 1) > guard_along(s, j, h, 0))) s->missed++;
  if (!keep_step(s, o, h)) return;
  s->t += time_at(s, h);
  memcpy(s->x, y, sizeof s->x);
  if (!fires) return;
  apply(s, o, s->variant->transition[j], 1, 1, &departs);
  settle(s, o, departs, 1);
  s->ready = s->left_out = 0;
  s->zero = 0;
  s->unit = s->h_ref;
  if (s->hit && s->reason == PS_RUNNING) s->reason = PS_UNTIL;
}

/* Takes a step of h units up to its end, or to what it runs into; `end` as far as it is known. */
static void take_step(ps_run *s, const ps_options *o, double h, int last, ps_look *g, ps_end *end) {
  ps_end own;
  ps_bits rising;
  double where;
  s->count.guards++;
  if (s->left_out) own_series(s, g);
  int event = find_event(s, g, h, PS_ZERO_TIME * s->h_ref / time_at(s, h), &where, &rising);
  if (event >= 0 && s->left_out == PS_BY_CHOICE) {
    /* A guard may be made of the very force that is left out: again, with it. */
    s->left_out = PS_KEPT;
    s->count.rejected++;
    return;
  }
  double kink = until_kink(s, g);
  s->count.accepted++;
  if (event >= 0 || kink < 1 || wants_dense(s, o)) own_series(s, g);
  if (event >= 0 && where <= kink) {
    take_event(s, o, event, where, h);
    return;
  }
  if (kink < 1) {
    h *= kink;
    last = 0;
    end = NULL;
  } else {
    for (int j = 0; j < s->variant->n; j++) s->armed[j] |= (rising >> j) & 1;
  }
  if (!end) {
    end_at(s, h, &own);
    end = &own;
  }
  if (!keep_step(s, o, h)) return;
  double took = time_at(s, h);
  s->t += took;
  memcpy(s->x, end->x, sizeof s->x);
  if (s->left_out && s->left_out != PS_KEPT) {
    s->zero = -took;
  } else if (s->zero < 0 && took > -PS_WORTH * s->zero && kink == 1) {
    s->zero -= took;
  } else {
    s->zero = zero_ahead(s, h, end);
  }
  s->left_out = s->missed = 0;
  s->unit = took;
  if (last) {
    s->t = s->t_end;
    s->reason = PS_T_END;
  }
}

/* One step, or the event it ran into. */
static void advance(ps_run *s, const ps_options *o) {
  double g[PS_LENGTH][PS_WATCHED], least[PS_WATCHED];
  int last;
  if (!begin_step(s, o)) return;
  fill_series(s);
  double h = measure_step(s, o, step_by_terms(s, o), &last);
  if (h == 0) return;
  const int watched = s->variant->n + s->variant->series.ramps;
  bounds(s->variant->series.guards, watched, s->scalars, s->order, &h, series_of(s), g, least);
  ps_look look = {g[0], least, NULL, PS_WATCHED, 1};
  take_step(s, o, h, last, &look, NULL);
}
