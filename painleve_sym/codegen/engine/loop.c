/* The loop over steps and events, and the functions a caller sees. */

static int wants_dense(const ps_run *s, const ps_options *o) {
  return o->record == 2 || (s->watch && s->watch->dense);
}

static int record_step(ps_run *s, const ps_options *o, double h, double row[8][PS_NX]) {
  watch_step(s, h, row);
  if (o->record < 2) return 1;
  double head[3] = {s->t, h, (double)s->mode};
  const double *parts[3] = {head, s->z, &row[0][0]};
  const int sizes[3] = {3, PS_NZ, 8 * PS_NX};
  if (rows_push(&s->steps, parts, sizes, 3)) return 1;
  s->reason = PS_NO_MEMORY;
  return 0;
}

/* Repeats the step so that it ends where guard j is zero, to round-off; returns its length.
 * s->k is left as a whole step needs it (k[0] at the start, k[12] at the end in y). The dense
 * output has the error of the whole step: where the repeated, shorter step shows the guard positive
 * and not coming down, there is no zero and `found` is 0. */
static double step_to_zero(ps_run *s, int j, double h, double *y, int *found) {
  double g[PS_NG], dg[PS_NG];
  *found = 1;
  for (int it = 0; it < 60; it++) {
    step(s, s->x, h, y);
    field(s, y, s->k[12]);
    guards(s, y, g, dg);
    double dh = dg[j] < 0 ? -g[j] / dg[j] : 0;
    if (g[j] > 0 && (!(dg[j] < 0) || dh > 0.5 * h)) {
      *found = 0;
      return h;
    }
    if (!(dh > -0.5 * h)) dh = -0.5 * h;
    if (fabs(dh) <= 1e-7 * h) {
      /* So close that the rest is linear: its square is below round-off. */
      for (int i = 0; i < PS_NX; i++) y[i] += dh * s->k[12][i];
      return h + dh;
    }
    h += dh;
  }
  return h;
}

static void enter_end_of_step(ps_run *s, double h, const double *y, const double *g,
                              const double *dg) {
  s->t += h;
  memcpy(s->x, y, sizeof s->x);
  memcpy(s->k[0], s->k[12], sizeof s->k[0]);
  for (int j = 0; j < PS_MODES[s->mode].n; j++) s->armed[j] |= g[j] > 0;
  memcpy(s->g, g, sizeof s->g);
  memcpy(s->dg, dg, sizeof s->dg);
}

/* Ends the step just made at the event of guard j, near the part `where` of it, and takes it. */
static void take_event(ps_run *s, const ps_options *o, int j, double where, double h, double *y,
                       double row[8][PS_NX]) {
  int found = 1;
  unsigned departs;
  h *= where;
  if (where > PS_AT_ONCE) {
    h = step_to_zero(s, j, h, y, &found);
    /* A step beyond the event can pass by chance, where its two error estimates cancel or where
     * it left the domain of the law: the part that is taken must pass as well. */
    double err = error_norm(s, o, s->x, y, h);
    if (!(err < 1)) {
      s->count.accepted--;
      s->count.rejected++;
      s->h = h * (isfinite(err) ? fmax(0.1, 0.9 * pow(err, -0.125)) : 0.1);
      return;
    }
  } else {
    step(s, s->x, h, y);
    field(s, y, s->k[12]);
  }
  if (wants_dense(s, o)) dense_rows(s, s->x, y, h, row);
  if (!record_step(s, o, h, row)) return;
  if (!found) {
    double g[PS_NG], dg[PS_NG];
    guards(s, y, g, dg);
    enter_end_of_step(s, h, y, g, dg);
    s->h = 6 * h;
    return;
  }
  s->t += h;
  memcpy(s->x, y, sizeof s->x);
  apply(s, o, j, 1, &departs);
  settle(s, o, departs, 1);
  /* The old step size is kept where the new mode is as smooth, else the estimate is used. */
  s->h = fmin(s->h, 10 * s->h_ref);
  if (s->hit && s->reason == PS_RUNNING) s->reason = PS_UNTIL;
}

/* One accepted step, or the event it ran into. */
static void advance(ps_run *s, const ps_options *o) {
  double y[PS_NX], row[8][PS_NX], g1[PS_NG], d1[PS_NG], err;
  int rejected = 0, finite = 1;
  for (;;) {
    int last = 0;
    double h = fmin(s->h, o->h_max);
    if (s->t + h * 1.0000001 >= o->t_end) {
      h = o->t_end - s->t;
      last = 1;
    }
    if (!(h > 16e-16 * fabs(s->t)) || s->count.accepted + s->count.rejected >= o->max_steps) {
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
      s->h = h * (isfinite(err) ? fmax(0.1, 0.9 * pow(err, -0.125)) : 0.1);
      rejected = 1;
      continue;
    }
    s->count.accepted++;
    field(s, y, s->k[12]);
    guards(s, y, g1, d1);
    if (wants_dense(s, o)) dense_rows(s, s->x, y, h, row);
    double where, grow = err > 0 ? fmin(6.0, 0.9 * pow(err, -0.125)) : 6.0;
    int event = find_event(s, y, h, g1, d1, row, wants_dense(s, o), &where);
    if (event == PS_RETAKE) {
      s->count.accepted--;
      s->count.rejected++;
      s->h = 0.02 * h;
      continue;
    }
    s->h = h * (rejected ? fmin(grow, 1) : grow);
    if (event >= 0) {
      take_event(s, o, event, where, h, y, row);
      return;
    }
    if (!record_step(s, o, h, row)) return;
    enter_end_of_step(s, h, y, g1, d1);
    if (last) {
      s->t = o->t_end;
      s->reason = PS_T_END;
    }
    return;
  }
}

static void choose_start(ps_run *s) {
  double condition[PS_NSTART];
  double *res[1] = {condition};
  int i = 0;
  call(s, PS_START_CONDITIONS, s->x, res);
  while (i < PS_NSTART - 1 && !(condition[i] > 0)) i++;
  s->mode = PS_STARTS[i];
}

/* ---- What the caller sees ---- */

PS_EXPORT void ps_constants(const double *p, double *c) {
  const double *arg[1] = {p};
  double *res[1] = {c};
  casadi_int iw[8];
  double w[PS_WORK + 1];
  PS_CONSTANTS(arg, res, iw, w, 0);
}

/* Integrates from t in a run of which all is zero but what watches it. */
static void integrate(ps_run *s, const double *x, const double *z, const double *p, double t,
                      const ps_options *o) {
  memcpy(s->x, x, sizeof s->x);
  memcpy(s->z, z, sizeof(double) * PS_NZ);
  s->t = s->t_start = t;
  s->t_event = -HUGE_VAL;
  s->steps.width = 3 + PS_NZ + 8 * PS_NX;
  s->events.width = 4 + 2 * (PS_NX + PS_NZ);
  s->reason = PS_RUNNING;
  s->stop_transition = -1;
  for (int i = 0; i < PS_NM; i++)
    for (int j = 0; j < PS_NG; j++) s->history[i][j].last = t;
  ps_constants(p, s->c);
  s->mode = o->start_mode;
  if (s->mode < 0) choose_start(s);
  /* What the start state makes happen at once is its choice of mode, or events where asked. */
  settle(s, o, o->start_departs, o->start_events);
  if (s->hit && s->reason == PS_RUNNING) s->reason = PS_UNTIL;
  s->h = o->h0 > 0 ? o->h0 : s->h_ref;
  while (s->reason == PS_RUNNING) advance(s, o);
}

/* Returns a run to be read and freed, NULL without memory. */
PS_EXPORT ps_run *ps_integrate(const double *x, const double *z, const double *p, double t,
                               const ps_options *o) {
  ps_run *s = (ps_run *)calloc(1, sizeof(ps_run));
  if (s) integrate(s, x, z, p, t, o);
  return s;
}

PS_EXPORT void ps_free(ps_run *s) {
  if (!s) return;
  free(s->steps.data);
  free(s->events.data);
  free(s);
}

/* Outputs at n points, each with its mode, state and memory; c are constants. */
PS_EXPORT void ps_outputs(long n, const long *mode, const double *x, const double *z,
                          const double *c, double *out) {
  casadi_int iw[8];
  double w[PS_WORK + 1];
  for (long i = 0; i < n; i++) {
    const double *arg[3] = {x + i * PS_NX, z + i * PS_NZ, c};
    double *res[1] = {out + i * PS_NO};
    PS_MODES[mode[i]].outputs(arg, res, iw, w, 0);
  }
}

/* Field and guards of one mode at one point, for checks. */
PS_EXPORT void ps_evaluate(int mode, const double *x, const double *z, const double *c,
                           double *rate, double *g, double *dg) {
  casadi_int iw[8];
  double w[PS_WORK + 1];
  const double *arg[3] = {x, z, c};
  double *res[2] = {rate, NULL};
  PS_MODES[mode].field(arg, res, iw, w, 0);
  res[0] = g;
  res[1] = dg;
  PS_MODES[mode].guards(arg, res, iw, w, 0);
}
