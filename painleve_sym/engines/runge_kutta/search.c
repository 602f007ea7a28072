/* The search for the first event inside a Runge-Kutta step, on its dense output. */

/* Answer of find_event; any number that is neither that of a guard nor -1. */
#define PS_RETAKE -2

typedef struct {
  double at, g, d;
} ps_point;

static ps_point guard_at(ps_run *s, double row[8][PS_NX], int j, double u) {
  double x[PS_NX], g[PS_NG], dg[PS_NG];
  dense_eval(row, u, x);
  guards(s, x, g, dg);
  ps_point p = {u, g[j], dg[j]};
  return p;
}

/* A point between a and b where guard j is not positive though it is at both ends; at < 0 if none. */
static ps_point dip(ps_run *s, double row[8][PS_NX], int j, double a, double b) {
  ps_point p = {-1, 0, 0};
  for (int it = 0; it < 60 && b - a > 1e-15; it++) {
    p = guard_at(s, row, j, 0.5 * (a + b));
    if (p.g <= 0) return p;
    if (p.d < 0) a = p.at; else b = p.at;
  }
  p.at = -1;
  return p;
}

/* Illinois iteration between a (positive) and b (not), with a bisection where three of its steps did not
 * halve what they enclose: of a guard that begins far nearer to its zero than to b they hardly do. */
static double refine(ps_run *s, double row[8][PS_NX], int j, ps_point a, ps_point b) {
  int side = 0;
  double enclosed = HUGE_VAL;
  for (int it = 0; b.at - a.at > 4e-16; it++) {
    const double width = b.at - a.at;
    const int slow = it % 4 == 3 && width > 0.5 * enclosed;
    if (it % 4 == 0) enclosed = width;
    double u = slow ? 0.5 * (a.at + b.at) : (a.at * b.g - b.at * a.g) / (b.g - a.g);
    if (!(u > a.at && u < b.at)) u = 0.5 * (a.at + b.at);
    if (!(u > a.at && u < b.at)) break;
    ps_point p = guard_at(s, row, j, u);
    if (p.g == 0) return u;
    if (p.g > 0) {
      a = p;
      if (side == 1) b.g *= 0.5;
      side = 1;
    } else {
      b = p;
      if (side == -1) a.g *= 0.5;
      side = -1;
    }
  }
  return b.at;
}

/* First point after `a` of the dense step where guard j has reached zero, or -1. Two crossings
 * between samples are located through the minimum of the guard. */
static double first_zero(ps_run *s, double row[8][PS_NX], int j, ps_point a) {
  for (int i = 1; i <= PS_SAMPLES; i++) {
    double u = (double)i / PS_SAMPLES;
    if (u <= a.at) continue;
    ps_point b = guard_at(s, row, j, u);
    if (b.g > 0 && a.d < 0 && b.d > 0) {
      ps_point low = dip(s, row, j, a.at, b.at);
      if (low.at >= 0) b = low;
    }
    if (b.g <= 0) return refine(s, row, j, a, b);
    a = b;
  }
  return -1;
}

/* The same for a guard that starts at zero and leaves upwards: an ordinary guard from the first
 * point where it is positive, which may be long before the first sample, but not so early that the
 * round-off of its start decides. */
static double next_zero(ps_run *s, double row[8][PS_NX], int j, double h) {
  double least = PS_ZERO_TIME * s->h_ref / h;
  ps_point p = guard_at(s, row, j, 1.0 / PS_SAMPLES);
  while (!(p.g > 0) && 0.5 * p.at > least) p = guard_at(s, row, j, 0.5 * p.at);
  return p.g > 0 ? first_zero(s, row, j, p) : -1;
}

/* Whether a guard that is positive at both ends may touch zero between: where its tangents meet is
 * a bound from below for a guard that is convex there. */
static int may_dip(double g0, double d0, double g1, double d1, double h) {
  return d0 < 0 && d1 > 0 && g0 + d0 * (g0 - g1 + d1 * h) / (d1 - d0) <= 0;
}

/* Earliest event inside the step that was just accepted: its guard, its place in `where`; -1 where
 * there is none, PS_RETAKE where only a shorter step can tell. */
static int find_event(ps_run *s, const double *y, double h, const double *g1, const double *d1,
                      double row[8][PS_NX], int have_dense, double *where) {
  const ps_variant *m = s->variant;
  int first = -1;
  *where = 2;
  for (int j = 0; j < m->n; j++) {
    int crossed = g1[j] <= 0 && (s->armed[j] || g1[j] < 0 || d1[j] < 0);
    if (!crossed && !(s->armed[j] && may_dip(s->g[j], s->dg[j], g1[j], d1[j], h))) continue;
    if (!have_dense) {
      dense_rows(s, s->x, y, h, row);
      have_dense = 1;
    }
    ps_point start = {0, s->g[j], s->dg[j]};
    double u = s->armed[j] ? first_zero(s, row, j, start) : next_zero(s, row, j, h);
    if (u < 0 && crossed && s->armed[j]) u = 1;
    if (u < 0 && crossed) {
      /* A guard that left zero is back, and this step is too long to show where. A far shorter one
       * may; if none does, it fires just after the start, where the rates that turned it already
       * have their new sign. */
      const double least = PS_MAX(10 * PS_ZERO_TIME * s->h_ref, 100 * PS_MOMENT * fabs(s->t));
      if (h > least) return PS_RETAKE;
      u = PS_AT_ONCE;
    }
    if (u >= 0 && u < *where - PS_TIE) {
      *where = u;
      first = j;
    }
  }
  return first;
}
