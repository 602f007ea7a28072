/* Transitions, the arming of guards, the first step of a mode, and the limits of accumulations. */

/* What a stepper remembers, as at the start of a run. */
static void prepare(ps_run *s, const ps_options *o);

static int geometric_accumulation(ps_run *s, int mode, int j, double t) {
  ps_history *y = &s->history[mode][j];
  double interval = t - y->last, before = y->interval;
  y->last = t;
  y->interval = interval;
  if (!(before > 0) || !(interval < 0.9999 * before)) {
    y->shrinking = 0;
    return 0;
  }
  /* The slower of the last two ratios: one short interval alone is not an accumulation. */
  double now = interval / before, ratio = PS_MAX(now, y->ratio);
  y->ratio = now;
  if (++y->shrinking < PS_SHRINKING) return 0;
  return interval * ratio / (1 - ratio) < PS_REMAINDER * t;
}

/* Counts and records an event from the present state and mode `from` to xn, zn and the mode in s. */
static void note_event(ps_run *s, const ps_options *o, int from, int j, int kind, int contact,
                       const double *xn, const double *zn) {
  s->count.events++;
  s->last_kind = kind;
  s->last_contact = contact;
  watch_event(s, kind);
  if (o->until[kind] & PS_AFTER) s->hit = 1;
  if (!o->record) return;
  double head[PS_EVENT_HEAD] = {s->t_base + s->t, (double)from, (double)j,
                                (double)s->mode,  (double)kind, (double)contact};
  const double *parts[5] = {head, s->x, s->z, xn, zn};
  const int sizes[5] = {PS_EVENT_HEAD, PS_NX, PS_NZ, PS_NX, PS_NZ};
  if (!rows_push(&s->events, parts, sizes, 5)) s->reason = PS_NO_MEMORY;
}

/* Whether the run ends before an event of this kind. One that continues another run does not where it
 * begins: the event is what the other one ended before. */
static int ends_before(const ps_run *s, const ps_options *o, int kind) {
  return o->until[kind] & PS_BEFORE && (o->start_mode < 0 || s->t_base + s->t > 0);
}

/* Applies transition j of the current mode, whose guard crossed zero (`timed`) or fired at once;
 * `departs` returns the guards known to leave zero: in a mode whose local modes are data, also those
 * that were so before at this instant. */
static void apply(ps_run *s, const ps_options *o, int j, int visible, double timed,
                  ps_bits *departs) {
  const ps_transition *tr = &PS_MODES[s->mode].transitions[j];
  double xn[PS_NX], zn[PS_NZ + 1] = {0}, condition[PS_NCHOICE];
  double *res[3] = {xn, zn, condition};
  const double *arg[4] = {s->x, s->z, s->c, &timed};
  int choice = 0, from = (int)s->mode;
  if (tr->watching) visible = tr->watching == PS_SEEN && !s->starting;
  if (visible && tr->stop != PS_DECISION && ends_before(s, o, tr->kind)) {
    s->reason = PS_UNTIL;
    s->stop_transition = j;
    return;
  }
  watch_before(s);
  tr->event(arg, res, s->iw, s->w, 0);
  ps_bits kept = PS_NPART && !timed && tr->target[0] == from ? *departs & ~((ps_bits)1 << j) : 0;
  *departs = 0;
  if (tr->stop == PS_RUNNING) {
    while (choice < tr->n - 1 && condition[choice] == 0) choice++;
    s->mode = tr->target[choice];
    *departs = tr->departs[choice] | kept;
#if PS_NPART
    s->repeats = 0;
    if (tr->chooses && !choose(s, o, xn, zn)) s->reason = PS_DECISION;
#ifdef PS_IMPACTS
    if (s->reason == PS_DECISION && ends_before(s, o, PS_IMPACT_KIND)) {
      s->mode = from; /* it chooses again where the run is continued */
      s->reason = PS_UNTIL;
      s->stop_transition = j;
      return;
    }
#endif
    if (tr->chooses) *departs |= PS_LEAVING[s->mode];
#endif
  } else { /* also where the contacts strike: the loop continues from there */
    s->reason = tr->stop;
    s->stop_transition = j;
  }
  if (visible && tr->watching) {
    const int last_kind = s->last_kind, last_contact = s->last_contact;
    note_event(s, o, from, j, tr->kind, tr->contact, xn, zn);
    s->last_kind = last_kind;
    s->last_contact = last_contact;
    if (s->reason == PS_RUNNING && s->count.events >= o->max_events) s->reason = PS_EVENT_LIMIT;
  } else if (visible && tr->stop != PS_DECISION) {
    note_event(s, o, from, j, tr->kind, tr->contact, xn, zn);
    s->at_once = s->t == s->t_event ? s->at_once + 1 : 0;
    s->t_event = s->t;
    if (s->reason == PS_RUNNING && s->at_once >= PS_CHAIN) s->reason = PS_ACCUMULATION;
    if (s->reason == PS_RUNNING && geometric_accumulation(s, from, j, s->t))
      s->reason = PS_ACCUMULATION;
    if (s->reason == PS_RUNNING && s->count.events >= o->max_events) s->reason = PS_EVENT_LIMIT;
  }
  if (tr->limit) {
    s->limit = tr;
    s->t_limit = s->t;
  }
  memcpy(s->x, xn, sizeof xn);
  memcpy(s->z, zn, sizeof(double) * PS_NZ);
}

/* 1: on its positive side, armed; 0: at zero and leaving upwards; -1: fires now. At zero the sign
 * is that of the first derivative, or of the second where the first is zero beside it. A guard that
 * rises above zero within a `moment`, which the time does not resolve, is at zero. */
static int guard_side(double g, double d, double d2, double zero, double moment, int departs) {
  if (!isfinite(d)) d = isinf(d) ? copysign(1e300, d) : 0;
  if (!isfinite(d2)) d2 = 0;
  double first = d * zero, second = 0.5 * d2 * zero * zero;
  double band = fabs(first) + fabs(second);
  if (g > band) return 1;
  if (g < -PS_MAX(band, d * moment)) return -1;
  if (departs) return 0;
  return (fabs(first) > fabs(second) ? first : second) < 0 ? -1 : 0;
}

/* First step of a mode (Hairer, Norsett & Wanner 1993, II.4, with the time in parts of tau, the
 * state's own time |x|/|f|, so that it does not depend on the unit); k[0] is f(x). */
static double first_step(ps_run *s, const ps_options *o) {
  double y[PS_NX], weight[PS_NX], d0 = 0, d1 = 0, d2 = 0;
  for (int i = 0; i < PS_NX; i++) {
    if (!isfinite(s->k[0][i]) || !isfinite(s->x[i])) return NAN;
    weight[i] = 1 / (o->atol[i] + o->rtol * fabs(s->x[i]));
    double a = s->x[i] * weight[i], b = s->k[0][i] * weight[i];
    d0 += a * a;
    d1 += b * b;
  }
  double tau = PS_FROM_REST * s->t_end, h;
  if (d1 > 0) tau = d0 > 1e-10 ? sqrt(d0 / d1) : PS_FROM_REST / (o->rtol * sqrt(d1));
  /* Beyond the end of the run no time is distinguished from another. */
  tau = PS_MIN(tau, 100 * s->t_end);
  h = 0.01 * tau;
  if (h > o->h_max) h = o->h_max;
  for (int i = 0; i < PS_NX; i++) y[i] = s->x[i] + h * s->k[0][i];
  field(s, y, s->k[1]);
  for (int i = 0; i < PS_NX; i++) {
    double a = (s->k[1][i] - s->k[0][i]) * weight[i];
    d2 += a * a;
  }
  /* A nan of d2 says nothing. */
  double bent = sqrt(d2) / h, straight = sqrt(d1), slope = PS_MAX(bent, straight);
  double h1 = slope > 0 ? tau * sqrt(sqrt(sqrt(0.01 / (tau * slope)))) : h;
  h = PS_MIN(100 * h, h1);
  return h > 0 && h < o->h_max ? h : o->h_max;
}

/* Enters the mode in s->mode: transitions that must happen at once do, then guards are armed. */
static void settle(ps_run *s, const ps_options *o, ps_bits departs, int visible) {
  double ahead = 0; /* time by which a guard that fired at once was before its zero */
  for (int chain = 0; s->reason == PS_RUNNING; chain++) {
    specialise(s, o);
    if (s->reason != PS_RUNNING) return;
    const ps_variant *v = s->variant;
    if (chain == PS_CHAIN) {
      s->reason = PS_ACCUMULATION;
      return;
    }
    jets_of_mode(s);
    s->h_ref = first_step(s, o);
    if (!isfinite(s->h_ref)) {
      s->reason = PS_NON_FINITE;
      return;
    }
    /* What follows an event that was ahead of its zero is as near to zero, however short its steps. */
    const double zero = PS_ZERO_TIME * s->h_ref, moment = PS_MAX(PS_MOMENT * fabs(s->t), 2 * ahead);
    int fire = -1;
    for (int j = 0; j < v->n && fire < 0; j++) {
      const int left = (departs >> v->transition[j]) & 1;
      int side = guard_side(s->g[j], s->dg[j], s->d2[j], zero, moment, left);
#if PS_NPART
      /* What is chosen again and again follows a guard that rises too slowly for the choice to see. */
      if (side < 0 && s->repeats && s->dg[j] > 0) side = 0;
#endif
      s->armed[j] = side > 0;
      if (side < 0) fire = v->transition[j];
      if (side < 0 && s->g[j] > 0 && s->dg[j] < 0) ahead = PS_MAX(ahead, s->g[j] / -s->dg[j]);
    }
    if (fire < 0 && PS_MODES[s->mode].immediate) fire = PS_MODES[s->mode].n;
    if (fire < 0) return;
    apply(s, o, fire, visible, 0, &departs);
  }
}

/* Begins at t = 0 in the present state and mode; what must happen at once does. */
static void enter(ps_run *s, const ps_options *o, int visible) {
  s->t = 0;
  s->t_end = o->t_end - s->t_base;
  s->t_event = -HUGE_VAL;
  s->at_once = 0;
  s->limit = NULL;
  s->last_kind = -1;
#if PS_NPART
  s->t_entered = -HUGE_VAL;
  s->repeats = 0;
#endif
  s->reason = PS_RUNNING;
  s->stop_transition = -1;
  memset(s->history, 0, sizeof s->history);
  prepare(s, o);
  settle(s, o, 0, visible);
  if (s->hit && s->reason == PS_RUNNING) s->reason = PS_UNTIL;
  s->h = o->h0 > 0 ? o->h0 : PS_START * s->h_ref;
}

/* Continues from the present state and mode with a time of its own, which keeps events sharp. */
static void begin_again(ps_run *s, const ps_options *o) {
  s->t_base += s->t;
  s->t = 0;
  if (s->reason == PS_RUNNING && s->hit) s->reason = PS_UNTIL;
  if (s->reason == PS_RUNNING && !(o->t_end - s->t_base > 0)) s->reason = PS_T_END;
  if (s->reason == PS_RUNNING && s->count.events >= o->max_events) s->reason = PS_EVENT_LIMIT;
  if (s->reason == PS_RUNNING) enter(s, o, 1);
}

/* Continues from the limit of events that accumulate, where the last of them says how and has come
 * so close to it that its state is that of the limit; 0: the run ends here. */
static int pass_limit(ps_run *s, const ps_options *o) {
  const ps_transition *tr = s->limit;
  double xn[PS_NX], zn[PS_NZ + 1] = {0}, *res[2] = {xn, zn};
  /* A limit at the instant of the one before it would be passed again and again. */
  if (!tr || s->t_limit != s->t || (s->limits && s->t_base + s->t == s->t_base)) return 0;
  call(s, tr->limit, s->x, res);
  for (int i = 0; i < PS_NOWN; i++)
    if (xn[i] != s->x[i] && !(fabs(xn[i] - s->x[i]) < PS_CLOSED * (o->atol[i] / o->rtol))) return 0;
  watch_now(s);
  const int from = (int)s->mode;
  s->mode = tr->limit_target;
  s->reason = PS_RUNNING;
  note_event(s, o, from, -1, tr->limit_kind, tr->contact, xn, zn);
  memcpy(s->x, xn, sizeof xn);
  memcpy(s->z, zn, sizeof(double) * PS_NZ);
  s->limits++;
  begin_again(s, o);
  return 1;
}

#ifdef PS_IMPACTS
static int strike(ps_run *s, const ps_options *o);
#endif

/* Whether the run continues. */
static int running(ps_run *s, const ps_options *o) {
  for (;;) {
    if (s->reason == PS_ACCUMULATION && pass_limit(s, o)) continue;
#ifdef PS_IMPACTS
    if (s->reason == PS_DECISION && strike(s, o)) continue;
#endif
    return s->reason == PS_RUNNING;
  }
}
