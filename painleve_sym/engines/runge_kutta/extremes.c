/* Extremes and time integrals of outputs, on the dense output of each step. */

typedef struct {
  double t, pace; /* since the start of the step; how fast it runs in parts of the step */
} ps_moment;

/* State and time at the part u of a step of length h: the stepper's. `row` is its dense output where
 * the run does not hold it. */
static ps_moment inside(ps_run *s, double h, double row[][PS_NX], double u, double *x);

/* Nodes and weights of Gauss's rule of order 10 on [0, 1]: above the order of the Runge-Kutta dense
 * output. A Taylor step is a seventh of the radius of convergence: the error is 27^-10. */
static const double PS_GAUSS_U[5] = {0.046910077030668003601, 0.23076534494715845448, 0.5,
                                     0.76923465505284154552, 0.95308992296933199640};
static const double PS_GAUSS_W[5] = {0.11846344252809454376, 0.23931433524968323402,
                                     0.28444444444444444444, 0.23931433524968323402,
                                     0.11846344252809454376};

static ps_moment outputs_at(ps_run *s, double h, double row[][PS_NX], double u, double *out) {
  double x[PS_NX], *res[1] = {out};
  ps_moment now = inside(s, h, row, u, x);
  call(s, PS_MODES[s->mode].outputs, x, res);
  return now;
}

/* Golden-section search of the extreme of output j between a and b, parts of the step. */
static void watch_inside(ps_run *s, ps_extreme *e, double sign, int j, double h,
                         double row[][PS_NX], double a, double b) {
  const double part = 0.38196601125010515180;
  double out[PS_NO], c = a + part * (b - a), d = b - part * (b - a);
  outputs_at(s, h, row, c, out);
  double at_c = sign * out[j];
  outputs_at(s, h, row, d, out);
  double at_d = sign * out[j];
  /* Past 1e-8 of the step the value no longer changes. */
  while (b - a > 1e-8) {
    if (at_c > at_d) {
      b = d;
      d = c;
      at_d = at_c;
      c = a + part * (b - a);
      outputs_at(s, h, row, c, out);
      at_c = sign * out[j];
    } else {
      a = c;
      c = d;
      at_c = at_d;
      d = b - part * (b - a);
      outputs_at(s, h, row, d, out);
      at_d = sign * out[j];
    }
  }
  ps_moment top = outputs_at(s, h, row, at_c > at_d ? c : d, out);
  watch_value(e, sign, sign * fmax(at_c, at_d), s->t_base + (s->t + top.t));
}

/* Values at the start, at the Gauss nodes and at the end of a step: the largest of them, and where
 * the parabola through it and its neighbours has its top beyond them, the top of the output. */
static void watch_extreme(ps_run *s, ps_extreme *e, double sign, int j, double h,
                          double row[][PS_NX], const double *u, const ps_moment *at,
                          double out[7][PS_NO]) {
  int best = 0;
  for (int i = 0; i < 7; i++) {
    watch_value(e, sign, out[i][j], s->t_base + (s->t + at[i].t));
    if (sign * out[i][j] > sign * out[best][j]) best = i;
  }
  int i = best < 1 ? 1 : best > 5 ? 5 : best;
  double f0 = out[i - 1][j], f1 = out[i][j], f2 = out[i + 1][j];
  double d1 = (f1 - f0) / (u[i] - u[i - 1]), d2 = (f2 - f1) / (u[i + 1] - u[i]);
  double bend = (d2 - d1) / (u[i + 1] - u[i - 1]);
  if (!(sign * bend < 0)) return;
  double top = 0.5 * (u[i] + u[i - 1] - d1 / bend);
  if (top > u[i - 1] && top < u[i + 1])
    watch_inside(s, e, sign, j, h, row, u[i - 1], u[i + 1]);
}

/* A step of length h from s->t, before it is taken. */
static void watch_step(ps_run *s, double h, double row[][PS_NX]) {
  ps_watch *w = s->watch;
  watch_after(s);
  if (!w || !w->dense) return;
  double u[7] = {0}, out[7][PS_NO];
  ps_moment at[7];
  for (int i = 0; i < 5; i++) u[i + 1] = PS_GAUSS_U[i];
  u[6] = 1;
  for (int i = 0; i < 7; i++) at[i] = outputs_at(s, h, row, u[i], out[i]);
  const ps_kept *kept = w->kept;
  const int extremes = kept->maxima + kept->minima;
  for (int i = 0; i < extremes; i++) {
    const double sign = i < kept->maxima ? 1 : -1;
    watch_extreme(s, &w->extreme[i], sign, kept->of[i], h, row, u, at, out);
  }
  for (int i = 0; i < kept->integrals; i++) {
    int j = kept->of[extremes + i];
    double sum = 0;
    for (int k = 0; k < 5; k++) sum += PS_GAUSS_W[k] * at[k + 1].pace * out[k + 1][j];
    w->integral[i] += sum;
  }
}
