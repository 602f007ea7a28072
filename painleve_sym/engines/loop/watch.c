/* What a batch keeps of each row besides its end: first event times, extremes and time integrals of
 * outputs. Nothing here changes the run. */

static void watch_value(ps_extreme *e, double sign, double value, double t) {
  if (!(sign * value > sign * e->value) && !isnan(e->value)) return;
  e->value = value;
  e->time = t;
}

static void watch_event(ps_run *s, int kind) {
  ps_watch *w = s->watch;
  if (!w) return;
  if (w->count[kind] < w->events) w->times[kind * w->events + w->count[kind]] = s->t_base + s->t;
  w->count[kind]++;
}

/* The present state counts too: where no time passed it is the only one. */
static void watch_now(ps_run *s) {
  ps_watch *w = s->watch;
  double out[PS_NO], *res[1] = {out};
  if (!w || !w->dense) return;
  call(s, PS_MODES[s->mode].outputs, s->x, res);
  for (int i = 0; i < w->maxima + w->minima; i++)
    watch_value(&w->extreme[i], i < w->maxima ? 1 : -1, out[w->of[i]], s->t_base + s->t);
}
