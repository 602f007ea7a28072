/* The first zero of a polynomial of degree n on [0, 1], by Descartes' rule on Bernstein
 * coefficients: no sign change, no zero; one, exactly one; more, the interval is halved. */

#define PS_DEPTH 52

/* Bernstein coefficients of the polynomial with coefficients p: b_i is the sum over k of
 * p_k C(i, k)/C(n, k), row by row of Pascal's triangle. */
static void bernstein(const double *p, int n, double *b) {
  double before[PS_LENGTH];
  for (int i = 0; i <= n; i++) {
    double now = p[i] * PS_INVERSE_BINOMIAL[n][i];
    for (int j = 0; j < i; j++) {
      double next = now + before[j];
      before[j] = now;
      now = next;
    }
    before[i] = b[i] = now;
  }
}

/* Splits at u: b keeps the part before u, c gets the part after it. */
static void subdivide(double *b, double *c, int n, double u) {
  for (int j = 0; j <= n; j++) {
    c[n - j] = b[n];
    for (int i = n; i > j; i--) b[i] = PS_FMA(u, b[i] - b[i - 1], b[i - 1]);
  }
}

/* Sign changes, at most 2; a zero counts as negative. */
static int variations(const double *b, int n) {
  int count = 0;
  for (int i = 1; i <= n && count < 2; i++) count += (b[i] > 0) != (b[i - 1] > 0);
  return count;
}

static double horner(const double *p, int n, double u) {
  double value = p[n];
  for (int k = n - 1; k >= 0; k--) value = PS_FMA(value, u, p[k]);
  return value;
}

static double horner_slope(const double *p, int n, double u) {
  double value = n * p[n];
  for (int k = n - 1; k > 0; k--) value = PS_FMA(value, u, k * p[k]);
  return value;
}

/* The zero between a, where p is positive, and b, where it is not: Halley, else bisection. `at_a` and
 * `at_b` are what p is there. */
static double refine(const double *p, int n, double a, double b, double at_a, double at_b) {
  double u = a + (b - a) * at_a / (at_a - at_b), before = 0;
  if (!(u > a && u < b)) u = b;
  for (int it = 0; it < 100 && b - a > 4e-16; it++) {
    double value = p[n], slope = 0, bend = 0;
    for (int k = n - 1; k >= 0; k--) {
      bend = PS_FMA(bend, u, slope);
      slope = PS_FMA(slope, u, value);
      value = PS_FMA(value, u, p[k]);
    }
    if (value == 0) return u;
    if (value > 0) a = u; else b = u;
    const double next = u - value * slope / (slope * slope - value * bend), change = fabs(next - u);
    const int inside = next > a && next < b;
    /* As near as numbers get: the side on which the polynomial is not positive. */
    if (change <= 2e-16 * u) return value > 0 ? PS_MIN(next + 2e-16 * u, b) : u;
    /* Changes shrink with their cubes: the next one would be as small. */
    const double shrinks = change / before;
    if (inside && shrinks * shrinks * shrinks * change <= 1e-17 * u) return PS_MIN(next + 2e-16 * u, b);
    before = inside ? change : 0;
    u = inside ? next : 0.5 * (a + b);
  }
  return b;
}

/* What the coefficients p, each `row` numbers after the one before, say of a polynomial on [0, 1]: its
 * end, the sum of their sizes, what it never falls below, and what its slope never exceeds. */
typedef struct {
  double end, size, least, steepest;
} ps_outline;

static ps_outline outline(const double *p, int row, int n) {
  ps_outline o = {p[0] + p[row], fabs(p[0]) + fabs(p[row]), p[0] + PS_MIN(p[row], 0), p[row]};
  for (int k = 2; k <= n; k++) {
    const double c = p[k * row];
    o.end += c;
    o.size += fabs(c);
    o.least += PS_MIN(c, 0);
    o.steepest += PS_MAX(k * c, 0);
  }
  return o;
}

/* Smallest zero of p in (from, 1] where p comes down from positive values; p(from) > 0. -1: none. */
static double first_root(const double *p, int n, double from) {
  double b[PS_DEPTH + 2][PS_LENGTH], lo[PS_DEPTH + 2], hi[PS_DEPTH + 2];
  int depth[PS_DEPTH + 2], top = 0;
  const ps_outline o = outline(p, 1, n);
  if (o.least > 0) return -1;
  /* Falling all the way: no zero or one. */
  if (o.steepest < 0)
    return o.end > 0 ? -1 : refine(p, n, from, 1, from > 0 ? horner(p, n, from) : p[0], o.end);
  bernstein(p, n, b[0]);
  if (from > 0) {
    subdivide(b[0], b[1], n, from);
    memcpy(b[0], b[1], sizeof b[0]);
  }
  lo[0] = from;
  hi[0] = 1;
  depth[0] = 0;
  while (top >= 0) {
    int count = variations(b[top], n);
    if (count == 0) {
      top--;
    } else if (count == 1) {
      return refine(p, n, lo[top], hi[top], b[top][0], b[top][n]);
    } else if (depth[top] == PS_DEPTH) {
      /* Two zeros that no arithmetic tells apart: a touch, not a crossing. */
      top--;
    } else {
      double middle = 0.5 * (lo[top] + hi[top]);
      subdivide(b[top], b[top + 1], n, 0.5);
      /* The part before the middle is on top of the stack: it is examined first. */
      double swap[PS_LENGTH];
      memcpy(swap, b[top], sizeof swap);
      memcpy(b[top], b[top + 1], sizeof swap);
      memcpy(b[top + 1], swap, sizeof swap);
      lo[top + 1] = lo[top];
      hi[top + 1] = lo[top] = middle;
      depth[top + 1] = ++depth[top];
      top++;
    }
  }
  return -1;
}
