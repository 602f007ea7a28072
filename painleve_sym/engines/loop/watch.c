/* What a batch keeps of each row besides its end: first event times, extremes and time integrals of
 * outputs. Nothing here changes the run. */

static void watch_value(ps_extreme *e, double sign, double value, double t) {
  if (!(sign * value > sign * e->value) && !isnan(e->value)) return;
  e->value = value;
  e->time = t;
}

/* Outputs and states at the present state. */
static void sample_now(ps_run *s, double *values) {
  double *res[1] = {values};
  call(s, PS_MODES[s->mode].outputs, s->x, res);
  memcpy(values + PS_NO, s->x, sizeof s->x);
}

/* Puts the values of one side of events of a kind into the samples, from one occurrence up to another. */
static void keep_samples(ps_watch *w, int kind, int after, const double *values, long from, long to) {
  const ps_kept *k = w->kept;
  for (int i = 0; i < k->samples; i++) {
    if (k->sample[i][0] != kind || k->sample[i][1] != after) continue;
    for (long n = from; n < to && n < k->events; n++)
      w->samples[i * k->events + n] = values[k->sample[i][2]];
  }
}

/* Before the first event of an instant: what it changes is looked at. */
static void watch_before(ps_run *s) {
  ps_watch *w = s->watch;
  if (!w || !w->kept->samples || w->instant == s->t_base + s->t) return;
  w->instant = s->t_base + s->t;
  sample_now(s, w->before);
}

/* After the last event of an instant. */
static void watch_after(ps_run *s) {
  ps_watch *w = s->watch;
  double values[PS_NO + PS_NX];
  if (!w || !w->open) return;
  w->open = 0;
  sample_now(s, values);
  for (int k = 0; k < PS_NKIND; k++) {
    keep_samples(w, k, 1, values, w->sampled[k], w->count[k]);
    w->sampled[k] = w->count[k];
  }
}

static void watch_event(ps_run *s, int kind) {
  ps_watch *w = s->watch;
  if (!w) return;
  const int events = w->kept->events;
  if (w->count[kind] < events) w->times[kind * events + w->count[kind]] = s->t_base + s->t;
  if (w->kept->samples) {
    keep_samples(w, kind, 0, w->before, w->count[kind], w->count[kind] + 1);
    w->open = 1;
  }
  w->count[kind]++;
}

/* Whether the dense output of each step is asked for. */
static int wants_dense(const ps_run *s, const ps_options *o) {
  return o->record == 2 || (s->watch && s->watch->dense);
}

/* The present state counts too: where no time passed it is the only one. */
static void watch_now(ps_run *s) {
  ps_watch *w = s->watch;
  double out[PS_NO], *res[1] = {out};
  if (!w || !w->dense) return;
  call(s, PS_MODES[s->mode].outputs, s->x, res);
  const ps_kept *k = w->kept;
  for (int i = 0; i < k->maxima + k->minima; i++)
    watch_value(&w->extreme[i], i < k->maxima ? 1 : -1, out[k->of[i]], s->t_base + s->t);
}

/* Energies and losses at the present state; where an automaton has none, nothing is known. */
#ifdef PS_ENERGIES
#define PS_TERMS (PS_ENERGIES + PS_LOSSES)
enum { PS_POTENTIAL = 1 };
/* Of the energies: what coordinates of a body at rest carry along from many operations. */
static const double PS_TERM_ROUNDING = 2.2e-14;

static void balance_terms(ps_run *s, double *term) {
  energies(s, s->x, term);
  for (int i = 0; i < PS_LOSSES; i++) term[PS_ENERGIES + i] = s->x[PS_LOSS[i]];
}

/* See BatchRows. */
static double balance_residual(ps_run *s, const ps_options *o, const double *start) {
  double now[PS_TERMS], change = 0, size = o->atol[PS_LOSS[0]] / o->rtol, terms = 0;
  if (s->count.accepted == 0) return NAN;
  balance_terms(s, now);
  for (int i = 0; i < PS_TERMS; i++) {
    const double from = i == PS_POTENTIAL ? start[i] : 0;
    const double before = fabs(start[i] - from), after = fabs(now[i] - from);
    change += now[i] - start[i];
    size = PS_MAX(size, PS_MAX(before, after));
    terms += PS_MAX(fabs(start[i]), fabs(now[i]));
  }
  if (!isfinite(change)) return HUGE_VAL;
  return size > PS_TERM_ROUNDING * terms ? fabs(change) / size : 0;
}
#else
#define PS_TERMS 1

static void balance_terms(ps_run *s, double *term) {
  (void)s;
  term[0] = NAN;
}

static double balance_residual(ps_run *s, const ps_options *o, const double *start) {
  (void)s;
  (void)o;
  return start[0];
}
#endif
