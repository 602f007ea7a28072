/* How a Taylor step is begun, and how long it may be. */

/* A series that starts at a vanishing base of a real power leaves the power out: what that does to
 * the rates at the end of the step decides how long it may be. */
static const double PS_SMALL_BASE = 1e-2;

/* The zero of a base is near when it is at most this multiple of the last step away. Derivatives, of
 * lower powers of the base, make steps shorter next to it. */
#ifdef PS_DIRECTIONS
static const double PS_NEAR = 4;
#else
static const double PS_NEAR = 2;
#endif
/* ... and taken to be a little farther: a series cannot continue beyond it. */
static const double PS_MARGIN = 1.02;
/* A step along the root of the time since a zero should be this part of that time; else the zero is
 * no longer what limits it. */
static const double PS_WORTH = 0.8;

/* Why a step leaves a power out: its series does not exist, or reaches less far; or that it is kept
 * though its base is small. */
enum { PS_BY_NEED = 1, PS_BY_CHOICE, PS_KEPT };

static void prepare(ps_run *s, const ps_options *o) {
  /* Jorba & Zou (2005): the order that is cheapest for a tolerance. Their step size differs. */
  int order = (int)ceil(-0.5 * log(PS_SHARE * o->rtol)) + 1;
  s->order = order < 4 ? 4 : order > PS_ORDER ? PS_ORDER : order;
  s->steps.width = PS_STEP_HEAD + PS_NZ + (s->order + 1) * PS_NX + 1;
  s->ready = s->left_out = s->missed = 0;
  s->unit = s->zero = 0;
}

/* Time after u units, how fast it runs there, and the units that a time takes. */
static double time_at(const ps_run *s, double u) {
  return u * (s->unit + 0.5 * s->bend * u);
}

static double pace_at(const ps_run *s, double u) {
  return s->unit + s->bend * u;
}

static double units_of(const ps_run *s, double t) {
  if (s->bend == 0) return t / s->unit;
  double root = s->unit * s->unit + 2 * s->bend * t;
  return root > 0 ? 2 * t / (s->unit + sqrt(root)) : HUGE_VAL;
}

static const double (*series_of(const ps_run *s))[PS_COLUMNS] {
  return (const double(*)[PS_COLUMNS])s->v;
}

static void fill_series(ps_run *s) {
  s->variant->series.series(s->x, s->scalars, s->live, s->order, s->unit, s->bend,
                            s->v);
#ifdef PS_DIRECTIONS
  for (int g = 0; g < PS_GROUPS; g++)
    s->variant->series.tangents(s->x, s->scalars, s->live, s->order, s->unit, s->bend, g, s->v);
#endif
  s->count.dense++;
}

#ifdef PS_DIRECTIONS
/* A register of the states that have their places from c on. */
static inline ps_wide states_from(const double *row, int c) {
  ps_wide a;
  __builtin_memcpy(&a, row + c, sizeof a);
  return a;
}

static inline ps_wide wide_size(ps_wide a) {
  return (ps_wide)((ps_wide_bits)a & 0x7fffffffffffffffLL);
}

/* The larger of each two, b where that is not a number. */
static inline ps_wide wide_most(ps_wide a, ps_wide b) {
  const ps_wide_bits kept = b <= a;
  return (ps_wide)((kept & (ps_wide_bits)a) | (~kept & (ps_wide_bits)b));
}
#endif

static double step_by_terms(const ps_run *s, const ps_options *o) {
  double h;
#ifdef PS_DIRECTIONS
  /* As in step_along, of many states register by register. */
  const int p = s->order;
  ps_wide most = {0}, before = {0}, nothing = {0};
  int c = 0;
  for (; c + PS_WIDTH <= PS_NX; c += PS_WIDTH) {
    const ps_wide size = states_from(o->atol, c) + o->rtol * wide_size(states_from(s->x, c));
    const ps_wide weight = 1.0 / (PS_SHARE * size);
    const ps_wide a = wide_size(states_from(s->v[p], c)) * weight;
    const ps_wide b = wide_size(states_from(s->v[p - 1], c)) * weight;
    most = wide_most(most, a);
    before = wide_most(before, b);
    nothing += 0.0 * a + 0.0 * b;
  }
  double largest[2] = {0, 0}, none = 0;
  for (int i = 0; i < PS_WIDTH; i++) {
    largest[0] = most[i] <= largest[0] ? largest[0] : most[i];
    largest[1] = before[i] <= largest[1] ? largest[1] : before[i];
    none += nothing[i];
  }
  for (; c < PS_NX; c++) {
    const double weight = 1.0 / (PS_SHARE * (o->atol[c] + o->rtol * fabs(s->x[c])));
    const double a = fabs(s->v[p][c]) * weight, b = fabs(s->v[p - 1][c]) * weight;
    largest[0] = a <= largest[0] ? largest[0] : a;
    largest[1] = b <= largest[1] ? largest[1] : b;
    none += 0.0 * a + 0.0 * b;
  }
  h = step_of(largest[0], largest[1], none, p);
#else
  step_along(series_of(s), s->order, s->x, o->atol, o->rtol, &h);
#endif
  return h;
}

/* State at u units, and its rate. */
static void state_at(const ps_run *s, double u, double *restrict y) {
#ifdef PS_DIRECTIONS
  /* As in state_along, of many states register by register. */
  const ps_wide h = PS_WIDE_OF(u);
  const int p = s->order;
  int c = 0;
  for (; c + PS_WIDTH <= PS_NX; c += PS_WIDTH) {
    ps_wide sum = states_from(s->v[p], c);
    for (int k = p - 1; k >= 0; k--) sum = PS_WIDE_FMA(sum, h, states_from(s->v[k], c));
    __builtin_memcpy(y + c, &sum, sizeof sum);
  }
  for (; c < PS_NX; c++) {
    double sum = s->v[p][c];
    for (int k = p - 1; k >= 0; k--) sum = PS_FMA(sum, u, s->v[k][c]);
    y[c] = sum;
  }
#else
  state_along(series_of(s), s->order, &u, y);
#endif
}

static void rate_at(ps_run *s, double u, double *restrict rate) {
  for (int i = 0; i < PS_NX; i++) rate[i] = s->order * s->v[s->order][i];
  for (int k = s->order - 1; k > 0; k--)
    for (int i = 0; i < PS_NX; i++) rate[i] = PS_FMA(rate[i], u, k * s->v[k][i]);
  const double inverse = 1 / s->unit;
  for (int i = 0; i < PS_NX; i++) rate[i] *= inverse;
}

/* The part of h units at the end of which a vanished base is largest, the first time: it may rise
 * from zero and be back before h, and then the rates at h carry no information about the omitted part. */
static double until_return(const ps_run *s, double h) {
  const ps_series *m = &s->variant->series;
  double part = 1;
  for (int r = 0; r < m->ramps; r++) {
    double q[PS_LENGTH] = {0}, fall[PS_LENGTH], power = 1, from = 0;
    int lowest = 0, n;
    if (s->live[r] > 0) continue;
    for (int k = 0; k < s->order - 1; k++, power *= h)
      q[k] = (k + 1) * s->v[k + 1][m->ramp[r]] * power;
    while (lowest < s->order - 2 && q[lowest] == 0) lowest++;
    n = s->order - 2 - lowest;
    if (q[lowest] < 0) {
      for (int k = 0; k <= n; k++) fall[k] = -q[lowest + k];
      from = first_root(fall, n, 0);
      if (from < 0) continue;
      from = PS_MIN(from * (1 + 1e-6), 1);
      if (!(horner(q + lowest, n, from) > 0)) continue;
    }
    double u = first_root(q + lowest, n, from);
    if (u > 0) part = PS_MIN(part, u);
  }
  return part;
}

/* Step, in units and at most h, over which what a vanished power would have done is within the
 * tolerance; the power grows like t^(e - 1), and e is determined on the way. `first` is tried first. */
static double step_by_defect(ps_run *s, const ps_options *o, double h, double first) {
  double e = 4, last_h = 0, last = 0, least = 0, most = h * until_return(s, h);
  h = PS_MIN(most, first);
  for (int it = 0; it < 20; it++) {
    double y[PS_NX], rate[PS_NX], slope[PS_NX], error = 0;
    state_at(s, h, y);
    rate_at(s, h, slope);
    field(s, y, rate);
    for (int i = 0; i < PS_NX; i++) {
      double d = fabs(rate[i] - slope[i]) / (o->atol[i] + o->rtol * fabs(s->x[i]));
      if (!(d <= error)) error = d;
    }
    error *= h * s->unit / e;
    if (error <= 1 && (h == most || error > 0.1 || h <= least)) return h;
    if (!isfinite(error)) {
      h *= 0.1;
      continue;
    }
    if (last_h > 0 && last > 0 && last_h != h) {
      e = log(error / last) / log(h / last_h);
      e = PS_MAX(PS_MIN(e, 20), 1.5);
    }
    last_h = h;
    last = error;
    if (error <= 1) least = h;
    double factor = rough_power(0.5 / PS_MAX(error, 1e-30), 1 / e), top = error > 1 ? 1 : 4;
    h *= PS_MIN(factor, top);
    h = PS_MIN(h, most);
  }
  return least > 0 ? PS_MIN(h, least) : h;
}

/* What the series say of the end of the step: the state, and the ramps as in `ramp_along`. */
typedef struct {
  double x[PS_NX], ramp[PS_RAMPS][3];
} ps_end;

static void end_at(const ps_run *s, double h, ps_end *end) {
  const ps_series *m = &s->variant->series;
  state_at(s, h, end->x);
  for (int r = 0; r < m->ramps; r++)
    ramp_along(series_of(s), m->ramp[r], s->order, &h, end->ramp[r]);
}

/* Time from the end of a step of h units to where the base of a live power comes to zero, if that is
 * near; 0 where it is not. */
static double zero_ahead(const ps_run *s, double h, const ps_end *end) {
  const ps_series *m = &s->variant->series;
  double nearest = 0;
  for (int r = 0; r < m->ramps; r++) {
    double pace = pace_at(s, h), a = end->ramp[r][0];
    if (!(s->live[r] > 0) || !(a > m->floor[r]) || !(end->ramp[r][1] < 0)) continue;
    double b = end->ramp[r][1] / pace;
    double d = (end->ramp[r][2] - 0.5 * b * s->bend) / (pace * pace);
    double root = b * b - 4 * a * d;
    if (!(root > 0)) continue;
    double t = 2 * a / (-b + sqrt(root));
    if (t < PS_NEAR * time_at(s, h) && (nearest == 0 || t < nearest)) nearest = t;
  }
  return PS_MARGIN * nearest;
}

/* What the series of a step are made with; 0 where the run stops. */
static int begin_step(ps_run *s, const ps_options *o) {
  const ps_series *m = &s->variant->series;
  if (s->count.accepted + s->count.rejected >= o->max_steps) {
    s->reason = PS_STEP_LIMIT;
    return 0;
  }
  if (!(s->unit > 0)) s->unit = s->h_ref;
  if (!s->ready) {
    double *res[1] = {s->scalars};
    call(s, m->scalars, s->x, res);
  }
  for (int r = 0; r < m->ramps; r++) s->live[r] = 1;
  /* The variable of the series: time, or the root of the time from or to a zero of a base. A series
   * in time ends at that zero, in the root it does not. */
  s->bend = s->zero != 0 ? -0.5 * s->unit * s->unit / s->zero : 0;
  return 1;
}

/* How far series without the powers whose bases are not alive are good, in units. */
static double good_without(ps_run *s, const ps_options *o, int fresh) {
  s->bend = 0;
  fill_series(s);
  const double h = step_by_terms(s, o), left = (s->t_end - s->t) / s->unit;
  /* Of a contact that has just closed, the step of its mode tells how fast the power grows. */
  const double first = fresh ? 4 * s->h_ref / s->unit : HUGE_VAL;
  return isfinite(h) ? step_by_defect(s, o, PS_MIN(h, left), first) : h;
}

/* How far the series are good, in units; `h` is what their last terms say. Where a base vanishes
 * they are made again. */
static double good_for(ps_run *s, const ps_options *o, double h) {
  const ps_series *m = &s->variant->series;
  const double moment = PS_MOMENT * fabs(s->t) / s->unit;
  const int fresh = !s->ready;
  int dead = 0, small = 0, smalls[PS_RAMPS] = {0};
  for (int r = 0; r < m->ramps; r++) {
    const int c = m->ramp[r];
    double base = s->v[0][c], u = s->h_ref / s->unit;
    double scale = fabs(s->v[1][c]) * u + fabs(s->v[2][c]) * u * u;
    /* A base that vanishes before the time can tell has vanished. */
    if (!(base > m->floor[r] - PS_MIN(s->v[1][c], 0) * moment)) {
      s->live[r] = 0;
      /* A base that stays zero, of a contact that is open, leaves nothing out. */
      dead |= base != 0 || scale != 0;
    } else if (s->v[1][c] > 0 && base < PS_SMALL_BASE * scale) {
      small = smalls[r] = 1;
    }
  }
  s->ready = 1;
  /* Up to the zero of the base as it was estimated; beyond it time would run back. */
  if (!dead && !(small && (fresh || h <= 2 * moment))) {
    double most = -0.999 * s->unit / s->bend;
    return s->bend < 0 && most < h ? most : h;
  }
  /* Next to its branch point the series hardly reaches; leaving a small power out may go further: of
   * two feet that land together one has vanished, and the other is small. */
  double alive = NAN;
  if (small && dead) {
    alive = good_without(s, o, fresh);
  } else if (small) {
    s->bend = 0;
    fill_series(s);
    alive = step_by_terms(s, o);
  }
  for (int r = 0; r < m->ramps; r++)
    if (smalls[r]) s->live[r] = 0;
  h = good_without(s, o, fresh);
  if (alive > h) {
    for (int r = 0; r < m->ramps; r++)
      if (smalls[r]) s->live[r] = 1;
    fill_series(s);
    s->left_out = dead ? PS_BY_NEED : PS_KEPT;
    return alive;
  }
  s->left_out = fresh && !dead && isfinite(alive) ? PS_BY_CHOICE : PS_BY_NEED;
  return h;
}

/* Argument of exp, or half of that of its like, below which it is 0 to every tolerance. */
static const double PS_FLAT = -150;
/* Last known term of the series of an argument, in parts of the change that all terms make. */
static const double PS_SETTLED_TERM = 1e-3;

/* The part of h units over which the terms of exp(a) say what it does. They are those of
 * exp(a0) D^k/k! with the change D of its argument: where exp(a0) is below round-off, all of them may
 * be, though it rises within the step. So D is at most half the order, and a flat exp is followed to
 * where it is flat no longer. `p` has the n terms of a, in steps of h. */
static double part_of_flat(const double *p, int n, double most) {
  double part = 1, rises[PS_LENGTH];
  int reaches = 0;
  while (!reaches && part > 1e-12) {
    double change = 0, power = part, term = 0, before = 0;
    for (int k = 1; k < n; k++, power *= part) {
      before = term;
      term = fabs(p[k]) * power;
      change += term;
    }
    reaches = PS_MAX(term, before) <= PS_SETTLED_TERM * change && (p[0] < PS_FLAT || change <= most);
    if (!reaches) part *= 0.8;
  }
  if (p[0] >= PS_FLAT) return part;
  rises[0] = PS_FLAT + 1 - p[0];
  double power = part;
  for (int k = 1; k < n; k++, power *= part) rises[k] = -p[k] * power;
  const double u = first_root(rises, n - 1, 0);
  return u > 0 ? u * part : part;
}

/* At most h units, over which no function that may be flat comes and goes unnoticed. */
static double before_bump(const ps_run *s, double h) {
  const ps_series *m = &s->variant->series;
  for (int i = 0; i < m->arguments; i++) {
    double p[PS_LENGTH], power = 1;
    const double start = s->v[0][m->argument[i]], other = start > 0 ? -2 : 2;
    const double factor = m->sides[i] == 2 ? other : 1;
    for (int k = 0; k < s->order; k++, power *= h) p[k] = factor * s->v[k][m->argument[i]] * power;
    h *= part_of_flat(p, s->order, 0.5 * s->order);
  }
  return h;
}

/* The step, in units, that is tried; 0 where the run stops. `last`: it would end at the end time. */
static double measure_step(ps_run *s, const ps_options *o, double h, int *last) {
  h = good_for(s, o, h);
  double left = units_of(s, s->t_end - s->t);
  if (s->variant->series.arguments && isfinite(h)) h = before_bump(s, PS_MIN(h, left));
  *last = 0;
  if (!isfinite(h)) {
    s->reason = PS_NON_FINITE;
    return 0;
  }
  double most = units_of(s, o->h_max);
  if (s->count.accepted == 0 && o->h0 > 0) most = units_of(s, PS_MIN(o->h0, o->h_max));
  h = PS_MIN(h, most);
  if (h * 1.0000001 >= left) {
    h = left;
    *last = 1;
  }
  if (time_at(s, h) > PS_MOMENT * fabs(s->t)) return h;
  s->reason = *last ? PS_T_END : PS_STEP_UNDERFLOW;
  return 0;
}

/* First term of a guard, in parts of the sum of all, below which it may be round-off. */
static const double PS_FALL = 1e-6;

/* Place of the first zero of a guard that starts at zero and leaves upwards; -1 where none. */
static double next_root(double *p, int n, double least, int crossed) {
  p[0] = 0;
  int m = 1;
  while (m < n && fabs(p[m]) <= fabs(p[m + 1]) * least) m++;
  /* The quotient after division by the zero at the start. */
  if (p[m] > 0) return first_root(p + m, n - m, 0);
  /* Neither where it is zero all along: the slip of a contact that sticks. */
  if (p[m] < 0) {
    double u = 1.0 / PS_SAMPLES, size = 0;
    for (int k = m; k <= n; k++) size += fabs(p[k]);
    while (!(horner(p, n, u) > 0) && 0.5 * u > least) u *= 0.5;
    /* A guard that left zero is back at once, also where it rises again before the step ends: where the
     * rates that turned it have their new sign. Only a fall within round-off is none. */
    const int falls = -p[m] > PS_FALL * size;
    return !falls && horner(p, n, u) > 0 ? first_root(p, n, u) : PS_AT_ONCE;
  }
  return crossed ? PS_AT_ONCE : -1;
}

