/* The loop over steps and events, and the functions a caller sees. */

static void choose_start(ps_run *s) {
  double condition[PS_NSTART];
  double *res[1] = {condition};
  int i = 0;
  call(s, PS_START_CONDITIONS, s->x, res);
  while (i < PS_NSTART - 1 && condition[i] == 0) i++;
  s->mode = PS_STARTS[i];
}

/* ---- What the caller sees ---- */

/* Calls a function with work space of its own. */
static void evaluate(ps_function f, const double **arg, double **res) {
  casadi_int iw[8];
  double w[PS_WORK + 1];
  f(arg, res, iw, w, 0);
}

PS_EXPORT void ps_constants(const double *p, double *c) {
  double *res[1] = {c};
  evaluate(PS_CONSTANTS, &p, res);
}

#ifdef PS_PREPARED
/* A whole start state x from the given states and the initial force (negative: none); `admits` is 1
 * or 0 for contact laws, definitions and domain. */
PS_EXPORT void ps_start(const double *p, const double *given, const double *force, double *x,
                        double *admits) {
  double c[PS_NC], *res[2] = {x, admits};
  const double *arg[3] = {given, force, c};
  ps_constants(p, c);
  evaluate(PS_PREPARED, arg, res);
}

/* The scales of the states x, below which only absolute errors count. */
PS_EXPORT void ps_scales(const double *p, const double *x, double *scales) {
  double c[PS_NC], *res[1] = {scales};
  const double *arg[2] = {x, c};
  ps_constants(p, c);
  evaluate(PS_SCALES, arg, res);
}

/* Both for n rows; a row of `out` holds state, admits and scales in turn. */
PS_EXPORT void ps_prepare(long n, const double *p, const double *given, const double *force,
                          double *out) {
  for (long i = 0; i < n; i++, out += 2 * PS_NX + PS_ADMITS) {
    ps_start(p + i * PS_NP, given + i * PS_GIVEN, force + i, out, out + PS_NX);
    ps_scales(p + i * PS_NP, out, out + PS_NX + PS_ADMITS);
  }
}
#endif

/* Sets the absolute tolerances of a run. What stands for infinity is finite: a state left out must
 * not turn 0 * inf into nan in a norm, nor into a number too small to be normal, which processors are
 * slow with. */
static void set_tolerances(ps_options *o, const double *atol) {
  for (int i = 0; i < PS_NX; i++) o->atol[i] = atol[i] > 1e100 ? 1e100 : atol[i];
}

/* Begins at t = 0 a run of which all is zero but what watches it. */
static void begin(ps_run *s, const double *x, const double *z, const double *p,
                  const ps_options *o) {
  memcpy(s->x, x, sizeof s->x);
  memcpy(s->z, z, sizeof(double) * PS_NZ);
  s->events.width = PS_EVENT_HEAD + 2 * (PS_NX + PS_NZ);
  ps_constants(p, s->c);
  s->mode = o->start_mode;
  if (s->mode < 0) choose_start(s);
  /* What the start state makes happen at once is its choice of mode, or events where asked. */
  s->starting = o->start_mode < 0;
  enter(s, o, o->start_events);
  s->starting = 0;
}

/* A whole run from t = 0, to be read and freed, NULL without memory. */
PS_EXPORT ps_run *ps_integrate(const double *x, const double *z, const double *p,
                               const ps_options *o) {
  ps_run *s = (ps_run *)calloc(1, sizeof(ps_run));
  if (!s) return NULL;
  begin(s, x, z, p, o);
  while (running(s, o)) advance(s, o);
  return s;
}

PS_EXPORT void ps_free(ps_run *s) {
  if (!s) return;
  free(s->steps.data);
  free(s->events.data);
  free(s);
}

/* A whole run from t = 0 with the absolute tolerances `atol`, its end in `out`: time, mode, reason,
 * stop transition, the counters, steps and events kept, numbers of a step, state, memory. Returns the
 * run where it kept any, for ps_take. */
PS_EXPORT ps_run *ps_complete(const double *x, const double *z, const double *p,
                              const ps_options *shared, const double *atol, double *out) {
  ps_options o = *shared;
  set_tolerances(&o, atol);
  ps_run *s = ps_integrate(x, z, p, &o);
  out[2] = PS_NO_MEMORY;
  if (!s) return NULL;
  const double head[] = {s->t_base + s->t, (double)s->mode, (double)s->reason, (double)s->stop_transition,
                           (double)s->count.accepted, (double)s->count.rejected,
                           (double)s->count.fields, (double)s->count.guards,
                           (double)s->count.dense, (double)s->count.events,
                           (double)s->steps.used, (double)s->events.used,
                           (double)s->steps.width};
  memcpy(out, head, sizeof head);
  out += sizeof head / sizeof *head;
  memcpy(out, s->x, sizeof s->x);
  memcpy(out + PS_NX, s->z, sizeof(double) * PS_NZ);
  if (s->steps.used || s->events.used) return s;
  ps_free(s);
  return NULL;
}

/* Copies the steps and events that a run kept, and frees it. */
PS_EXPORT void ps_take(ps_run *s, double *steps, double *events) {
  const size_t numbers = (size_t)(s->steps.used * s->steps.width);
  if (numbers) memcpy(steps, s->steps.data, numbers * sizeof(double));
  const size_t of_events = (size_t)(s->events.used * s->events.width);
  if (of_events) memcpy(events, s->events.data, of_events * sizeof(double));
  ps_free(s);
}

/* Outputs at n points, each with its mode, state and memory; c are constants. */
PS_EXPORT void ps_outputs(long n, const long *mode, const double *x, const double *z,
                          const double *c, double *out) {
  for (long i = 0; i < n; i++) {
    const double *arg[3] = {x + i * PS_NX, z + i * PS_NZ, c};
    double *res[1] = {out + i * PS_NO};
    evaluate(PS_MODES[mode[i]].outputs, arg, res);
  }
}

/* Field of one mode as it is at one point, and guards where it has any, for checks. */
PS_EXPORT void ps_evaluate(int mode, const double *x, const double *z, const double *c,
                           double *rate, double *g, double *dg) {
  const double *arg[3] = {x, z, c};
  double *rates[1] = {rate}, *res[2] = {g, dg};
  evaluate(PS_VARIANTS[mode].field, arg, rates);
  if (PS_VARIANTS[mode].guards) evaluate(PS_VARIANTS[mode].guards, arg, res);
}
