/* One accepted Runge-Kutta step, or the event it runs into. */

/* A step ends so far beyond the event it is likely to meet, in parts of the time until then: beyond
 * an event a mode may not be smooth. */
static const double PS_BEYOND = 1.1;

static void prepare(ps_run *s, const ps_options *o) {
  (void)o;
  s->steps.width = PS_STEP_HEAD + PS_NZ + 8 * PS_NX + 1;
  s->h_last = 0;
}

static ps_moment inside(ps_run *s, double h, double row[][PS_NX], double u, double *x) {
  ps_moment now = {h * u, h};
  (void)s;
  dense_eval(row, u, x);
  return now;
}

static int keep_step(ps_run *s, const ps_options *o, double h, double row[8][PS_NX]) {
  watch_step(s, h, row);
  return record_step(s, o, h, &row[0][0], 8, 0);
}

/* Repeats the step so that it ends where guard j is zero, to round-off; returns its length, which
 * belongs to y. The guard is known not to be positive after `until`, or nowhere (HUGE_VAL).
 * s->k is left as a whole step needs it (k[0] at the start, k[12] at the end in y). The dense
 * output has the error of the whole step: where the repeated, shorter step shows the guard positive
 * and not coming down, there is no zero and `is_zero` is 0. */
static double step_to_zero(ps_run *s, int j, double h, double until, double *y, int *is_zero) {
  double g[PS_NG], dg[PS_NG], from = 0;
  *is_zero = 1;
  for (int it = 0;; it++) {
    step(s, s->x, h, y);
    field(s, y, s->k[12]);
    guards(s, y, g, dg);
    double dh = dg[j] < 0 ? -g[j] / dg[j] : 0;
    if (g[j] > 0 && (!(dg[j] < 0) || dh > 0.5 * h)) {
      *is_zero = 0;
      return h;
    }
    if (!(dh > -0.5 * h)) dh = -0.5 * h;
    if (g[j] > 0) from = h; else until = h;
    if (fabs(dh) > 1e-7 * h && !(h + dh > from && h + dh < until)) {
      /* The round-off of a guard that hardly moves is larger than what its slope says: its signs
       * enclose the zero. */
      dh = until - from > 1e-7 * h ? 0.5 * (from + until) - h : until - h;
    }
    if (fabs(dh) <= 1e-7 * h) {
      /* So close that the rest is linear: its square is below round-off. */
      for (int i = 0; i < PS_NX; i++) y[i] += dh * s->k[12][i];
      return h + dh;
    }
    if (it == 60) return h;
    h += dh;
  }
}

/* Time until the first armed guard crosses zero, by its value, slope and bend. */
static double time_to_event(const ps_run *s) {
  double first = HUGE_VAL;
  for (int j = 0; j < s->variant->n; j++) {
    double root = s->dg[j] * s->dg[j] - 2 * s->g[j] * s->d2[j];
    if (!s->armed[j] || !(s->dg[j] < 0) || !(root >= 0)) continue;
    double t = 2 * s->g[j] / (sqrt(root) - s->dg[j]);
    first = PS_MIN(first, t);
  }
  return first;
}

/* Next step size after a good step of size h (Gustafsson 1994; for explicit methods
 * Gustafsson 1991): the error per size to the eighth continues to change as it did. */
static double next_size(ps_run *s, double h, double err) {
  double grow = err > 0 ? 0.9 * pow(err, -0.125) : 6;
  if (s->h_last > 0 && err > 0) {
    double trend = h / s->h_last * pow(s->err_last / err, 0.125);
    if (trend < 1) grow *= trend;
  }
  s->h_last = h;
  s->err_last = PS_MAX(err, 1e-2);
  grow = PS_MIN(grow, 6);
  return h * PS_MAX(grow, 0.2);
}

/* Step size after one of size h that failed. */
static double shorter_size(double h, double err) {
  double shrink = isfinite(err) ? 0.9 * pow(err, -0.125) : 0.1;
  return h * PS_MAX(shrink, 0.1);
}

static void enter_end_of_step(ps_run *s, double h, const double *y, const double *g,
                              const double *dg) {
  for (int j = 0; j < s->variant->n; j++) s->d2[j] = (dg[j] - s->dg[j]) / h;
  s->t += h;
  memcpy(s->x, y, sizeof s->x);
  memcpy(s->k[0], s->k[12], sizeof s->k[0]);
  for (int j = 0; j < s->variant->n; j++) s->armed[j] |= g[j] > 0;
  memcpy(s->g, g, sizeof s->g);
  memcpy(s->dg, dg, sizeof s->dg);
}

/* Ends the step just made at the event of guard j, near the part `where` of it, and takes it; `crossed`:
 * the guard is not positive at the end of the step. */
static void take_event(ps_run *s, const ps_options *o, int j, double where, int crossed, double h,
                       double *y, double row[8][PS_NX]) {
  int is_zero = 1;
  ps_bits departs = 0;
  const double until = crossed ? h : HUGE_VAL;
  h *= where;
  if (where > PS_AT_ONCE) {
    h = step_to_zero(s, j, h, until, y, &is_zero);
    /* Nearer than the time can tell, states do not change by more than their rounding. */
    is_zero |= crossed && !(h > PS_MOMENT * fabs(s->t));
    /* A step beyond the event can pass by chance, where its two error estimates cancel or where
     * it left the domain of the law: the part that is taken must pass as well. */
    double err = error_norm(s, o, s->x, y, h);
    if (!(err < 1)) {
      s->count.accepted--;
      s->count.rejected++;
      s->h = shorter_size(h, err);
      s->h_last = 0;
      return;
    }
  } else {
    step(s, s->x, h, y);
    field(s, y, s->k[12]);
  }
  if (wants_dense(s, o)) dense_rows(s, s->x, y, h, row);
  if (!keep_step(s, o, h, row)) return;
  if (!is_zero) {
    double g[PS_NG], dg[PS_NG];
    guards(s, y, g, dg);
    enter_end_of_step(s, h, y, g, dg);
    s->h = PS_MAX(6 * h, 4 * PS_MOMENT * fabs(s->t));
    return;
  }
  s->t += h;
  memcpy(s->x, y, sizeof s->x);
  apply(s, o, s->variant->transition[j], 1, 1, &departs);
  settle(s, o, departs, 1);
  s->h_last = 0;
  /* The old step size is kept where the new mode is as smooth, else the estimate is used. */
  s->h = PS_MIN(s->h, 10 * PS_START * s->h_ref);
  if (s->hit && s->reason == PS_RUNNING) s->reason = PS_UNTIL;
}

/* One accepted step, or the event it ran into. */
static void advance(ps_run *s, const ps_options *o) {
  double y[PS_NX], row[8][PS_NX], g1[PS_NG], d1[PS_NG], err;
  double ahead = PS_BEYOND * time_to_event(s), reach = PS_MAX(ahead, 1e-3 * s->h);
  /* An event nearer than the time can tell is met by a step that is long enough to be made. */
  const double moment = PS_MOMENT * fabs(s->t);
  reach = PS_MAX(reach, 4 * moment);
  int finite = 1;
  for (;;) {
    int last = 0;
    double h = PS_MIN(s->h, reach);
    h = PS_MIN(h, o->h_max);
    if (s->t + h * 1.0000001 >= s->t_end) {
      h = s->t_end - s->t;
      last = 1;
    }
    if (!(h > moment) || s->count.accepted + s->count.rejected >= o->max_steps) {
      s->reason = s->count.accepted + s->count.rejected >= o->max_steps ? PS_STEP_LIMIT
                  : finite                                              ? PS_STEP_UNDERFLOW
                                                                        : PS_NON_FINITE;
      if (last && s->reason == PS_STEP_UNDERFLOW) s->reason = PS_T_END;
      return;
    }
    step(s, s->x, h, y);
    err = error_norm(s, o, s->x, y, h);
    if (!(err < 1)) {
      s->count.rejected++;
      finite = isfinite(err);
      if (!finite && h < 1e-200) {
        s->reason = PS_NON_FINITE;
        return;
      }
      s->h = shorter_size(h, err);
      continue;
    }
    s->count.accepted++;
    field(s, y, s->k[12]);
    guards(s, y, g1, d1);
    if (wants_dense(s, o)) dense_rows(s, s->x, y, h, row);
    double where;
    int event = find_event(s, y, h, g1, d1, row, wants_dense(s, o), &where);
    if (event == PS_RETAKE) {
      s->count.accepted--;
      s->count.rejected++;
      s->h = 0.02 * h;
      continue;
    }
    /* A step that an event made short says little of the next one, which must be long enough to be made. */
    const double next = next_size(s, h, err);
    s->h = PS_MAX(next, 2 * moment);
    if (event >= 0) {
      take_event(s, o, event, where, g1[event] <= 0, h, y, row);
      return;
    }
    if (!keep_step(s, o, h, row)) return;
    enter_end_of_step(s, h, y, g1, d1);
    if (last) {
      s->t = s->t_end;
      s->reason = PS_T_END;
    }
    return;
  }
}
