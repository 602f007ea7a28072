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
  if (w->count[kind] < w->events) w->times[kind * w->events + w->count[kind]] = s->t;
  w->count[kind]++;
}
