/* Many runs: one after the other, or, where the stepper can take a step of several at once
 * (`advance_lanes`), those side by side that are in the same variant. A row never sees another. */

#ifndef PS_LANES
#define PS_LANES 1
#endif
/* Runs open at once: where they are in few variants, some variant has at least PS_LANES of them. */
#define PS_OPEN (16 * (PS_LANES - 1) + 1)

/* One row of each array per run; `times` (rows, kinds, events), `extremes` (rows, maxima + minima,
 * value and time), `integrals` (rows, integrals), `samples` (rows, samples, events). */
typedef struct {
  double *t, *x, *z;
  int *mode, *reason, *transition;
  long *counters, *counts;
  double *times, *extremes, *integrals, *energy_residual, *samples;
} ps_ends;

static void watch_start(ps_watch *w, const ps_kept *kept, const ps_ends *e, long i) {
  int extremes = kept->maxima + kept->minima;
  w->kept = kept;
  w->dense = extremes + kept->integrals > 0;
  w->count = e->counts + i * PS_NKIND;
  w->times = e->times + i * PS_NKIND * kept->events;
  w->extreme = (ps_extreme *)(e->extremes + i * 2 * extremes);
  w->integral = e->integrals + i * kept->integrals;
  w->samples = e->samples + i * kept->samples * kept->events;
  w->instant = -HUGE_VAL;
  w->open = 0;
  for (int k = 0; k < PS_NKIND; k++) w->sampled[k] = 0;
  for (int k = 0; k < kept->samples * kept->events; k++) w->samples[k] = NAN;
  for (int k = 0; k < PS_NKIND; k++) w->count[k] = 0;
  for (int k = 0; k < PS_NKIND * kept->events; k++) w->times[k] = NAN;
  for (int k = 0; k < extremes; k++) w->extreme[k].value = w->extreme[k].time = NAN;
  for (int k = 0; k < kept->integrals; k++) w->integral[k] = 0;
}

/* n rows: states x (n, nx), parameters p (n, np), end times (n), absolute tolerances (n, nx), and the
 * memory (nz) with which all of them begin. */
typedef struct {
  long n;
  const double *x, *p, *t_end, *atol, *z;
} ps_given;

/* The run of a row, and its energies and losses at the start. */
typedef struct {
  ps_run run;
  ps_options options;
  ps_watch watch;
  long row;
  double start[PS_TERMS];
} ps_open;

static void open_row(ps_open *a, long i, const ps_given *given, const ps_kept *kept,
                     const ps_ends *e) {
  memset(&a->run, 0, sizeof a->run);
  a->row = i;
  a->run.watch = &a->watch;
  watch_start(&a->watch, kept, e, i);
  a->options.t_end = given->t_end[i];
  set_tolerances(&a->options, given->atol + i * PS_NX);
  begin(&a->run, given->x + i * PS_NX, given->z, given->p + i * PS_NP, &a->options);
  balance_terms(&a->run, a->start);
}

static void close_row(ps_open *a, const ps_ends *e) {
  ps_run *s = &a->run;
  long i = a->row;
  watch_now(s);
  watch_after(s);
  e->t[i] = s->t_base + s->t;
  memcpy(e->x + i * PS_NX, s->x, sizeof s->x);
  memcpy(e->z + i * PS_NZ, s->z, sizeof(double) * PS_NZ);
  e->mode[i] = (int)s->mode;
  e->reason[i] = (int)s->reason;
  e->transition[i] = (int)s->stop_transition;
  memcpy(e->counters + i * PS_NCOUNT, &s->count, sizeof s->count);
  e->energy_residual[i] = balance_residual(s, &a->options, a->start);
}

/* One step of n runs in the same variant: in lanes where at least half of them are full. */
static void advance_open(ps_open **open, int n) {
#if PS_LANES > 1
  if (n > 1 && 2 * n >= PS_LANES) {
    ps_run *runs[PS_LANES];
    const ps_options *options[PS_LANES];
    for (int i = 0; i < n; i++) {
      runs[i] = &open[i]->run;
      options[i] = &open[i]->options;
    }
    advance_lanes(runs, options, n);
    return;
  }
#endif
  for (int i = 0; i < n; i++) advance(&open[i]->run, &open[i]->options);
}

/* Open runs that are in the same variant. */
typedef struct {
  const ps_variant *variant;
  int count;
  ps_open *run[PS_OPEN];
} ps_group_of;

/* The group of a variant among all of them, or an empty one that becomes its own. */
static ps_group_of *group_of(ps_group_of *groups, const ps_variant *variant) {
  ps_group_of *empty = NULL;
  for (int i = 0; i < PS_OPEN; i++) {
    if (groups[i].count && groups[i].variant == variant) return &groups[i];
    if (!groups[i].count && !empty) empty = &groups[i];
    if (!groups[i].variant) break;
  }
  empty->variant = variant;
  return empty;
}

/* Integrates the rows, at most `lanes` of them side by side. Returns the rows done, fewer than n
 * where there is no memory for the runs. */
PS_EXPORT long ps_batch(const ps_given *given, const ps_options *o, const ps_kept *kept, int lanes,
                        const ps_ends *e) {
  ps_open *all = (ps_open *)malloc(PS_OPEN * sizeof(ps_open));
  ps_open *idle[PS_OPEN];
  ps_group_of groups[PS_OPEN] = {{0}}, *group = groups;
  int free_count = PS_OPEN;
  long next = 0;
  if (!all) return 0;
  if (lanes > PS_LANES) lanes = PS_LANES;
  for (int i = 0; i < PS_OPEN; i++) {
    all[i].options = *o;
    idle[i] = &all[i];
  }
  for (;;) {
    /* The variant of the last step if it can fill the lanes, else the one that most runs are in. */
    for (int i = 0; i < PS_OPEN && groups[i].variant && group->count < lanes; i++)
      if (groups[i].count > group->count) group = &groups[i];
    ps_open *now[PS_LANES];
    int n = 0;
    if (group->count < lanes && next < given->n && free_count) {
      now[n++] = idle[--free_count];
      open_row(now[0], next++, given, kept, e);
    } else {
      if (group->count == 0) break;
      while (n < lanes && group->count > 0) now[n++] = group->run[--group->count];
      advance_open(now, n);
    }
    for (int i = n - 1; i >= 0; i--) {
      ps_run *s = &now[i]->run;
      if (running(s, &now[i]->options)) {
        ps_group_of *of = group_of(groups, s->variant);
        of->run[of->count++] = now[i];
      } else {
        close_row(now[i], e);
        idle[free_count++] = now[i];
      }
    }
  }
  free(all);
  return given->n;
}
