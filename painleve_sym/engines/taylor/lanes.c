/* One step of several motions in the same variant at once. What their series take part in is done for all
 * of them together, a lane each; where a motion goes from there is its own. Every lane does what
 * `advance` does, operation by operation, so that results are bitwise independent of the other lanes. */

typedef struct {
  int n, last[PS_LANES];
  ps_run *run[PS_LANES];
  const ps_options *own[PS_LANES];
  ps_lanes x[PS_NX], atol[PS_NX], scalars[PS_SCALARS], live[PS_RAMPS], time[2], h;
  ps_lanes v[PS_LENGTH][PS_COLUMNS], g[PS_LENGTH][PS_WATCHED], least[PS_WATCHED];
  ps_lanes step, end[PS_NX], ramp[PS_RAMPS][3];
} ps_group;

/* One number of every motion; a lane without a motion repeats the first. */
#define PS_GATHER(to, value)         \
  do {                               \
    ps_lanes t_;                     \
    PS_EACH_LANE(t_[l] = (value))    \
    (to) = t_;                       \
  } while (0)

/* Series of all motions. Vectors stay in functions that are called, so that what is called from
 * them starts with clean registers. */
__attribute__((noinline)) static void fill_lanes(ps_group *b) {
  const ps_series *m = &b->run[0]->variant->series;
  const int p = b->run[0]->order;
  for (int i = 0; i < PS_NX; i++) {
    PS_GATHER(b->x[i], b->run[l]->x[i]);
    PS_GATHER(b->atol[i], b->own[l]->atol[i]);
  }
  for (int i = 0; i < m->scalar_count; i++) PS_GATHER(b->scalars[i], b->run[l]->scalars[i]);
  for (int r = 0; r < m->ramps; r++) PS_GATHER(b->live[r], b->run[l]->live[r]);
  PS_GATHER(b->time[0], b->run[l]->unit);
  PS_GATHER(b->time[1], b->run[l]->bend);
  m->series_lanes(b->x, b->scalars, b->live, p, b->time, b->v);
  step_along_lanes((const ps_lanes(*)[PS_COLUMNS])b->v, p, b->x, b->atol, b->own[0]->rtol, &b->step);
}

/* What the series of all motions say of their steps. */
__attribute__((noinline)) static void look_along(ps_group *b, const double *h) {
  const ps_series *m = &b->run[0]->variant->series;
  const int p = b->run[0]->order, watched = b->run[0]->variant->n + m->ramps;
  const ps_lanes(*v)[PS_COLUMNS] = (const ps_lanes(*)[PS_COLUMNS])b->v;
  PS_GATHER(b->h, h[l]);
  bounds_lanes(m->guards_lanes, watched, b->scalars, p, &b->h, v, b->g, b->least);
  state_along_lanes(v, p, &b->h, b->end);
  for (int r = 0; r < m->ramps; r++) ramp_along_lanes(v, m->ramp[r], p, &b->h, b->ramp[r]);
}

/* The step of lane l; 0 where its motion stops. */
static double measure_lane(ps_group *b, int l) {
  ps_run *s = b->run[l];
  const ps_series *m = &s->variant->series;
  for (int r = 0; r < m->ramps; r++)
    for (int k = 0; k < 3; k++) s->v[k][m->ramp[r]] = b->v[k][m->ramp[r]][l];
  for (int i = 0; i < m->arguments; i++)
    for (int k = 0; k < s->order; k++) s->v[k][m->argument[i]] = b->v[k][m->argument[i]][l];
  const long filled = ++s->count.dense;
  double h = measure_step(s, b->own[l], b->step[l], &b->last[l]);
  if (s->count.dense > filled)
    for (int k = 0; k <= s->order; k++)
      for (int c = 0; c < m->columns; c++) b->v[k][c][l] = s->v[k][c];
  return h;
}

static void take_lane(ps_group *b, int l, double h) {
  ps_run *s = b->run[l];
  ps_end end;
  for (int i = 0; i < PS_NX; i++) end.x[i] = b->end[i][l];
  for (int r = 0; r < s->variant->series.ramps; r++)
    for (int i = 0; i < 3; i++) end.ramp[r][i] = b->ramp[r][i][l];
  ps_look look = {(const double *)b->g + l, (const double *)b->least + l,
                  (const double *)b->v + l, PS_WATCHED * PS_LANES, PS_LANES};
  take_step(s, b->own[l], h, b->last[l], &look, &end);
}

static void advance_lanes(ps_run **runs, const ps_options *const *options, int n) {
  ps_group b;
  double h[PS_LANES];
  b.n = 0;
  for (int i = 0; i < n; i++) {
    if (!begin_step(runs[i], options[i])) continue;
    b.run[b.n] = runs[i];
    b.own[b.n++] = options[i];
  }
  if (b.n == 0) return;
  for (int l = b.n; l < PS_LANES; l++) {
    b.run[l] = b.run[0];
    b.own[l] = b.own[0];
  }
  fill_lanes(&b);
  for (int l = 0; l < PS_LANES; l++) h[l] = l < b.n ? measure_lane(&b, l) : h[0];
  look_along(&b, h);
  for (int l = 0; l < b.n; l++)
    if (h[l] != 0) take_lane(&b, l, h[l]);
}
