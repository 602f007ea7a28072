/* Many runs after one another through one run object. A row never sees the row before it. */

/* One row of each array per run; `times` (rows, kinds, events), `extremes` (rows, maxima + minima,
 * value and time), `integrals` (rows, integrals). */
typedef struct {
  double *t, *x, *z;
  int *mode, *reason, *transition;
  long *counters, *counts;
  double *times, *extremes, *integrals;
} ps_ends;

/* Which outputs are watched: indices of those with a maximum, a minimum, an integral, in turn. */
typedef struct {
  int events, maxima, minima, integrals;
  const int *of;
} ps_wish;

static void watch_start(ps_watch *w, const ps_wish *wish, const ps_ends *e, long i) {
  int extremes = wish->maxima + wish->minima;
  w->events = wish->events;
  w->maxima = wish->maxima;
  w->minima = wish->minima;
  w->integrals = wish->integrals;
  w->of = wish->of;
  w->dense = extremes + wish->integrals > 0;
  w->count = e->counts + i * PS_NKIND;
  w->times = e->times + i * PS_NKIND * wish->events;
  w->extreme = (ps_extreme *)(e->extremes + i * 2 * extremes);
  w->integral = e->integrals + i * wish->integrals;
  for (int k = 0; k < PS_NKIND; k++) w->count[k] = 0;
  for (int k = 0; k < PS_NKIND * wish->events; k++) w->times[k] = NAN;
  for (int k = 0; k < extremes; k++) w->extreme[k].value = w->extreme[k].time = NAN;
  for (int k = 0; k < wish->integrals; k++) w->integral[k] = 0;
}

/* The state the run ended in counts too: where no time passed it is the only one. */
static void watch_end(ps_run *s) {
  ps_watch *w = s->watch;
  double out[PS_NO], *res[1] = {out};
  if (!w->dense) return;
  call(s, PS_MODES[s->mode].outputs, s->x, res);
  for (int i = 0; i < w->maxima + w->minima; i++)
    watch_value(&w->extreme[i], i < w->maxima ? 1 : -1, out[w->of[i]], s->t);
}

/* Integrates n rows: states x (n, nx), parameters p (n, np), end times (n), absolute tolerances
 * (n, nx). Returns the rows done, fewer than n where there is no memory for a run. */
PS_EXPORT long ps_batch(long n, const double *x, const double *p, const double *t_end,
                        const double *atol, const ps_options *given, const ps_wish *wish,
                        const ps_ends *e) {
  const double z[PS_NZ + 1] = {0};
  ps_run *s = (ps_run *)malloc(sizeof(ps_run));
  if (!s) return 0;
  ps_options o = *given;
  ps_watch watch;
  for (long i = 0; i < n; i++) {
    memset(s, 0, sizeof *s);
    s->watch = &watch;
    watch_start(&watch, wish, e, i);
    o.t_end = t_end[i];
    memcpy(o.atol, atol + i * PS_NX, sizeof o.atol);
    integrate(s, x + i * PS_NX, z, p + i * PS_NP, 0, &o);
    watch_end(s);
    e->t[i] = s->t;
    memcpy(e->x + i * PS_NX, s->x, sizeof s->x);
    memcpy(e->z + i * PS_NZ, s->z, sizeof(double) * PS_NZ);
    e->mode[i] = (int)s->mode;
    e->reason[i] = (int)s->reason;
    e->transition[i] = (int)s->stop_transition;
    memcpy(e->counters + i * PS_NCOUNT, &s->count, sizeof s->count);
  }
  free(s);
  return n;
}

/* Constants c (n, nc) of n rows of parameters (n, np). */
PS_EXPORT void ps_many_constants(long n, const double *p, double *c) {
  for (long i = 0; i < n; i++) ps_constants(p + i * PS_NP, c + i * PS_NC);
}
