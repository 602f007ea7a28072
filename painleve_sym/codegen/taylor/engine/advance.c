/* One Taylor step, or the event it runs into: the series is the dense output and holds the events. */

/* Part of the tolerance that the last term of a series may use: the terms left out add up to a few
 * times as much where a power ends, and so do the steps. */
static const double PS_SHARE = 0.05;

/* A series that starts at a vanishing base of a real power leaves the power out: what that does to
 * the rates at the end of the step decides how long it may be. */
static const double PS_SMALL_BASE = 1e-2;

/* The zero of a base is near when it is so many of the last steps away. */
static const double PS_NEAR = 2;
/* ... and taken to be a little farther: a series cannot go on beyond it. */
static const double PS_MARGIN = 1.02;
/* A step along the root of the time since a zero should be this part of that time; else the zero is
 * no longer what limits it. */
static const double PS_WORTH = 0.8;

#define PS_MIN(a, b) ((a) < (b) ? (a) : (b))
#define PS_MAX(a, b) ((a) > (b) ? (a) : (b))

static void prepare(ps_run *s, const ps_options *o) {
  /* Jorba & Zou, Experiment. Math. 14 (2005) 99-117: the order that is cheapest for a tolerance. */
  int order = (int)ceil(-0.5 * log(PS_SHARE * o->rtol)) + 1;
  s->order = order < 4 ? 4 : order > PS_ORDER ? PS_ORDER : order;
  inverse_binomials(s->order, s->binomial);
  s->steps.width = 3 + PS_NZ + (s->order + 1) * PS_NX + 1;
}

/* Time after u units, how fast it runs there, and the units that a time takes. */
static double time_at(const ps_run *s, double u) {
  return u * (s->unit + 0.5 * s->bend * u);
}

static double pace_at(const ps_run *s, double u) {
  return s->unit + s->bend * u;
}

static double units_of(const ps_run *s, double t) {
  double root = s->unit * s->unit + 2 * s->bend * t;
  return root > 0 ? 2 * t / (s->unit + sqrt(root)) : HUGE_VAL;
}

static void fill_series(ps_run *s) {
  PS_SERIES[s->mode].series(s->x, s->scalars, s->live, s->order, s->unit, s->bend,
                            s->v);
  s->count.dense++;
}

/* x to the power e, to three digits: a step size needs no more. */
static double rough_power(double x, double e) {
  union { double d; unsigned long long u; } bits = {x};
  double whole = (double)((long long)(bits.u >> 52) - 1023);
  bits.u = (bits.u & 0xfffffffffffffULL) | 0x3ff0000000000000ULL;
  double m = bits.d - 1, log2 = whole + m * (1.4249 + m * (-0.5871 + m * 0.1622));
  double y = PS_MAX(PS_MIN(e * log2, 1000), -1000), n = floor(y), f = y - n;
  bits.u = (unsigned long long)((long long)n + 1023) << 52;
  return bits.d * (1 + f * (0.6957 + f * (0.2251 + f * 0.0792)));
}

/* Step, in units, for which the last two terms of each state are within its tolerance. The last
 * but one may be e^2 times larger: that is what a step of 1/e^2 of the radius makes of it. */
static double step_by_terms(ps_run *s, const ps_options *o) {
  const int p = s->order;
  double last = 0, before = 0, a[PS_NX], b[PS_NX];
  for (int i = 0; i < PS_NX; i++) {
    double weight = 1 / (PS_SHARE * (o->atol[i] + o->rtol * fabs(s->x[i])));
    a[i] = fabs(s->v[p][i]) * weight;
    b[i] = fabs(s->v[p - 1][i]) * weight;
  }
  for (int i = 0; i < PS_NX; i++) {
    if (!(a[i] <= last)) last = a[i];
    if (!(b[i] <= before)) before = b[i];
  }
  if (!isfinite(last) || !isfinite(before)) return NAN;
  double h = rough_power(PS_MAX(last, 1e-100), -PS_INVERSE[p]);
  return fmin(h, rough_power(PS_MAX(before / 7.389, 1e-100), -PS_INVERSE[p - 1]));
}

/* State at u units, and its rate. */
static void state_at(ps_run *s, double u, double *restrict y) {
  double sum[PS_NX];
  for (int i = 0; i < PS_NX; i++) sum[i] = s->v[s->order][i];
  for (int k = s->order - 1; k >= 0; k--)
    for (int i = 0; i < PS_NX; i++) sum[i] = PS_FMA(sum[i], u, s->v[k][i]);
  memcpy(y, sum, sizeof sum);
}

static void rate_at(ps_run *s, double u, double *restrict rate) {
  for (int i = 0; i < PS_NX; i++) rate[i] = s->order * s->v[s->order][i];
  for (int k = s->order - 1; k > 0; k--)
    for (int i = 0; i < PS_NX; i++) rate[i] = PS_FMA(rate[i], u, k * s->v[k][i]);
  for (int i = 0; i < PS_NX; i++) rate[i] /= s->unit;
}

/* The part of h units at the end of which a vanished base is largest, the first time: it may rise
 * from zero and be back before h, and then the rates at h tell nothing of what was left out. */
static double until_return(const ps_run *s, double h) {
  const ps_series *m = &PS_SERIES[s->mode];
  double part = 1;
  for (int r = 0; r < m->ramps; r++) {
    double q[PS_LENGTH], fall[PS_LENGTH], own[PS_LENGTH], power = 1, from = 0;
    int lowest = 0, n;
    if (s->live[r] > 0) continue;
    for (int k = 0; k < s->order - 1; k++, power *= h)
      q[k] = (k + 1) * s->v[k + 1][m->ramp[r]] * power;
    while (lowest < s->order - 2 && q[lowest] == 0) lowest++;
    n = s->order - 2 - lowest;
    inverse_binomials(n, own);
    if (q[lowest] < 0) {
      for (int k = 0; k <= n; k++) fall[k] = -q[lowest + k];
      from = first_root(fall, n, 0, own);
      if (from < 0) continue;
      from = fmin(from * (1 + 1e-6), 1);
      if (!(horner(q + lowest, n, from) > 0)) continue;
    }
    double u = first_root(q + lowest, n, from, own);
    if (u > 0) part = fmin(part, u);
  }
  return part;
}

/* Step, in units and at most h, over which what a vanished power would have done is within the
 * tolerance; the power grows like t^(e - 1), and e is found on the way. */
static double step_by_defect(ps_run *s, const ps_options *o, double h) {
  double e = 4, last_h = 0, last = 0, least = 0, most = h *= until_return(s, h);
  for (int it = 0; it < 20; it++) {
    double y[PS_NX], rate[PS_NX], slope[PS_NX], error = 0;
    state_at(s, h, y);
    rate_at(s, h, slope);
    field(s, y, rate);
    for (int i = 0; i < PS_NX; i++) {
      double weight = 1 / (o->atol[i] + o->rtol * fabs(s->x[i]));
      double d = fabs(rate[i] - slope[i]) * h * s->unit * weight / e;
      if (!(d <= error)) error = d;
    }
    if (error <= 1 && (it == 0 || error > 0.1 || h <= least)) return h;
    if (!isfinite(error)) {
      h *= 0.1;
      continue;
    }
    if (last_h > 0 && last > 0 && last_h != h)
      e = fmin(fmax(log(error / last) / log(h / last_h), 1.5), 20);
    last_h = h;
    last = error;
    if (error <= 1) least = h;
    h = fmin(h * fmin(pow(0.5 / fmax(error, 1e-30), 1 / e), error > 1 ? 1 : 4), most);
  }
  return fmin(h, least > 0 ? least : h);
}

/* Time from the end of a step of h units to where the base of a live power comes to zero, if that is
 * near; 0 where it is not. */
static double zero_ahead(const ps_run *s, double h) {
  const ps_series *m = &PS_SERIES[s->mode];
  double nearest = 0;
  for (int r = 0; r < m->ramps; r++) {
    double a = 0, b = 0, d = 0, pace = pace_at(s, h);
    if (!(s->live[r] > 0)) continue;
    for (int k = s->order - 1; k >= 0; k--) {
      d = PS_FMA(d, h, b);
      b = PS_FMA(b, h, a);
      a = PS_FMA(a, h, s->v[k][m->ramp[r]]);
    }
    b /= pace;
    d = (d - 0.5 * b * s->bend) / (pace * pace);
    double root = b * b - 4 * a * d;
    if (!(a > m->floor[r]) || !(b < 0) || !(root > 0)) continue;
    double t = 2 * a / (-b + sqrt(root));
    if (t < PS_NEAR * time_at(s, h) && (nearest == 0 || t < nearest)) nearest = t;
  }
  return PS_MARGIN * nearest;
}

/* Coefficients of the series at the current state, and how far it is good, in units. */
static double open_step(ps_run *s, const ps_options *o) {
  const ps_series *m = &PS_SERIES[s->mode];
  int dead = 0, small = 0;
  if (!s->ready) {
    double *res[1] = {s->scalars};
    call(s, m->scalars, s->x, res);
  }
  for (int r = 0; r < m->ramps; r++) s->live[r] = 1;
  /* The variable of the series: time, or the root of the time from or to a zero of a base. A series
   * in time ends at that zero, in the root it does not. */
  s->bend = s->zero != 0 ? -0.5 * s->unit * s->unit / s->zero : 0;
  fill_series(s);
  for (int r = 0; r < m->ramps; r++) {
    const int c = m->ramp[r];
    double base = s->v[0][c], u = s->h_ref / s->unit;
    double scale = fabs(s->v[1][c]) * u + fabs(s->v[2][c]) * u * u;
    if (!(base > m->floor[r])) {
      s->live[r] = 0;
      dead = 1;
    } else if (!s->ready && s->v[1][c] > 0 && base < PS_SMALL_BASE * scale) {
      small = 1;
    }
  }
  s->ready = 1;
  double alive = NAN;
  if (small && !dead) {
    s->bend = 0;
    fill_series(s);
    /* Next to the branch point the series hardly reaches; leaving the power out may go further. */
    alive = step_by_terms(s, o);
    for (int r = 0; r < m->ramps; r++) s->live[r] = 0;
    dead = 1;
  }
  if (!dead) {
    double h = step_by_terms(s, o);
    /* Up to the zero of the base as it was estimated; beyond it time would run back. */
    return s->bend < 0 ? fmin(h, -0.999 * s->unit / s->bend) : h;
  }
  s->bend = 0;
  fill_series(s);
  double h = step_by_terms(s, o);
  if (isfinite(h)) h = step_by_defect(s, o, fmin(h, (o->t_end - s->t) / s->unit));
  if (alive > h) {
    for (int r = 0; r < m->ramps; r++) s->live[r] = 1;
    fill_series(s);
    return alive;
  }
  s->left_out = 1;
  return h;
}

/* Place of the first zero of a guard that starts at zero and leaves upwards; -1 where none. */
static double next_root(double *p, int n, double least, int crossed, const double *inverse) {
  p[0] = 0;
  int m = 1;
  while (m < n && fabs(p[m]) <= fabs(p[m + 1]) * least) m++;
  if (p[m] > 0) {
    /* What is left after division by the zero at the start. */
    double own[PS_LENGTH];
    inverse_binomials(n - m, own);
    return first_root(p + m, n - m, 0, own);
  }
  double u = 1.0 / PS_SAMPLES;
  while (!(horner(p, n, u) > 0) && 0.5 * u > least) u *= 0.5;
  if (horner(p, n, u) > 0) return first_root(p, n, u, inverse);
  /* A guard that left zero is back at once: where the rates that turned it have their new sign. */
  return crossed ? PS_AT_ONCE : -1;
}

/* Powers of the step, series of guards and ramps over it, and for each a bound from below. */
static void watch(ps_run *s, double h, double g[][PS_WATCHED], double *least) {
  s->power[0] = 1;
  s->power[1] = h;
  for (int k = 2; k <= s->order; k++) s->power[k] = s->power[k / 2] * s->power[k - k / 2];
  PS_SERIES[s->mode].guards(s->scalars, s->order, s->power, (const double(*)[PS_COLUMNS])s->v, g);
  for (int j = 0; j < PS_WATCHED; j++) least[j] = g[0][j];
  for (int k = 1; k <= s->order; k++)
    for (int j = 0; j < PS_WATCHED; j++) least[j] += g[k][j] < 0 ? g[k][j] : 0;
  s->count.guards++;
}

static void column(double g[][PS_WATCHED], int j, int order, double *p) {
  for (int k = 0; k <= order; k++) p[k] = g[k][j];
}

/* Earliest event inside a step: its guard and its place in [0, 1]; -1 for none, and then `rising`
 * has the guards that are positive at the end. */
static int find_event(ps_run *s, double g[][PS_WATCHED], const double *least, double at_once,
                      double *where, unsigned *rising) {
  int n = PS_MODES[s->mode].n, first = -1, order = s->order;
  *where = 2;
  *rising = 0;
  for (int j = 0; j < n; j++) {
    double p[PS_LENGTH], u;
    if (s->armed[j] && least[j] > 0) continue;
    column(g, j, order, p);
    double end = horner(p, order, 1);
    int crossed = end <= 0 && (s->armed[j] || end < 0 || horner_slope(p, order, 1) < 0);
    if (end > 0) *rising |= 1u << j;
    if (s->armed[j]) {
      u = p[0] > 0 ? first_root(p, order, 0, s->binomial) : PS_AT_ONCE;
      if (u < 0 && crossed) u = 1;
    } else {
      u = next_root(p, order, at_once, crossed, s->binomial);
    }
    /* Of guards that are zero together the first one fires: round-off does not decide. */
    if (u >= 0 && u < *where - PS_AT_ONCE) {
      *where = u;
      first = j;
    }
  }
  return first;
}

/* Place in [0, 1] just beyond which the base of a live power has gone to zero, else 1. */
static double until_kink(ps_run *s, double g[][PS_WATCHED], const double *least) {
  int n = PS_MODES[s->mode].n;
  double u = 1;
  for (int r = 0; r < PS_SERIES[s->mode].ramps; r++) {
    double p[PS_LENGTH];
    if (!(s->live[r] > 0) || least[n + r] > 0 || PS_SERIES[s->mode].guarded[r]) continue;
    column(g, n + r, s->order, p);
    double root = first_root(p, s->order, 0, s->binomial);
    if (root >= 0) u = fmin(u, fmax(root * (1 + 1e-9), 1e-9));
  }
  return u;
}

/* Rows of the dense output (see Trajectory) of the step of h units: the same polynomial. */
static void dense_rows(ps_run *s, double h, double *row) {
  const int p = s->order;
  for (int i = 0; i < PS_NX; i++) {
    double b[PS_LENGTH], power = 1;
    for (int k = 0; k <= p; k++, power *= h) b[k] = s->v[k][i] * power;
    /* Divided by u and by 1 - u in turn; what remains each time is a row. */
    int lowest = 0;
    for (int r = 0; r <= p; r++) {
      if (r % 2 == 0) {
        row[r * PS_NX + i] = b[lowest++];
      } else {
        double sum = 0;
        for (int k = p; k >= lowest; k--) {
          double next = sum + b[k];
          b[k] = -sum;
          sum = next;
        }
        row[r * PS_NX + i] = sum;
      }
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

/* Brings the end of the step, y after h units, to the zero of guard j itself; 0 where it has none. */
static int polish(ps_run *s, int j, double *h, double *y) {
  double g[PS_NG], dg[PS_NG];
  for (int it = 0; it < 4; it++) {
    state_at(s, *h, y);
    guards(s, y, g, dg);
    if (g[j] == 0) return 1;
    if (!(dg[j] < 0)) return g[j] < 0;
    double change = -g[j] / (dg[j] * pace_at(s, *h));
    if (!(fabs(change) < 0.01 * *h)) return g[j] <= 0;
    if (fabs(change) <= 1e-15 * *h) return 1;
    *h += change;
  }
  return 1;
}

/* Ends the step at the event of guard j, at the part `where` of h units, and takes it. */
static void take_event(ps_run *s, const ps_options *o, int j, double where, double h) {
  double y[PS_NX];
  unsigned departs;
  int found = 1;
  h *= where;
  if (where > PS_AT_ONCE) found = polish(s, j, &h, y);
  state_at(s, h, y);
  if (!keep_step(s, o, h)) return;
  s->t += time_at(s, h);
  memcpy(s->x, y, sizeof s->x);
  if (!found) return;
  apply(s, o, j, 1, 1, &departs);
  settle(s, o, departs, 1);
  s->ready = s->left_out = 0;
  s->zero = 0;
  s->unit = s->h_ref;
  if (s->hit && s->reason == PS_RUNNING) s->reason = PS_UNTIL;
}

/* One step, or the event it ran into. */
static void advance(ps_run *s, const ps_options *o) {
  int last = 0, event;
  unsigned rising;
  double y[PS_NX], g[PS_LENGTH][PS_WATCHED], least[PS_WATCHED], where;
  if (s->count.accepted + s->count.rejected >= o->max_steps) {
    s->reason = PS_STEP_LIMIT;
    return;
  }
  if (!(s->unit > 0)) s->unit = s->h_ref;
  double h = open_step(s, o), left = units_of(s, o->t_end - s->t);
  if (!isfinite(h)) {
    s->reason = PS_NON_FINITE;
    return;
  }
  h = fmin(h, units_of(s, o->h_max));
  if (s->count.accepted == 0 && o->h0 > 0) h = fmin(h, units_of(s, o->h0));
  if (h * 1.0000001 >= left) {
    h = left;
    last = 1;
  }
  if (!(time_at(s, h) > 16e-16 * fabs(s->t))) {
    s->reason = last ? PS_T_END : PS_STEP_UNDERFLOW;
    return;
  }
  watch(s, h, g, least);
  event = find_event(s, g, least, PS_ZERO_TIME * s->h_ref / time_at(s, h), &where, &rising);
  double kink = until_kink(s, g, least);
  s->count.accepted++;
  if (event >= 0 && where <= kink) {
    take_event(s, o, event, where, h);
    return;
  }
  if (kink < 1) {
    h *= kink;
    last = 0;
  } else {
    for (int j = 0; j < PS_MODES[s->mode].n; j++) s->armed[j] |= (rising >> j) & 1u;
  }
  state_at(s, h, y);
  if (!keep_step(s, o, h)) return;
  double took = time_at(s, h);
  s->t += took;
  memcpy(s->x, y, sizeof s->x);
  if (s->left_out) {
    s->zero = -took;
  } else if (s->zero < 0 && took > -PS_WORTH * s->zero && kink == 1) {
    s->zero -= took;
  } else {
    s->zero = zero_ahead(s, h);
  }
  s->left_out = 0;
  s->unit = took;
  if (last) {
    s->t = o->t_end;
    s->reason = PS_T_END;
  }
}
