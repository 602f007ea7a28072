/* Time and impulse along one ray of a frozen impact: x'' = -(a F + b) with F = kap x^n.
 *
 * Between two turning points the energy integral x'^2/2 = G(x), with
 * G(x) = g0 - a kap (x^p - x0^p)/p - b (x - x0) and p = n + 1, gives t = int dx/|x'| and
 * P = int F dt: from rest at x = 0 as Gauss hypergeometric functions, else by Gauss-Legendre
 * quadrature in a variable that removes the singularities at the ends. The part above this file
 * defines two rules by PS_ORDER, PS_NODES and PS_WEIGHTS, and PS_LAST, PS_BEFORE, which give the last
 * two Legendre coefficients. */

#include <math.h>

#define PS_EXPORT __attribute__((visibility("default")))

/* A panel is kept where its last Legendre coefficients, number N - 1 of N nodes, are below this
 * part of the whole. They fall like rho^-k and the error of the rule like rho^-2N: its square. */
#define PS_PANEL 3e-8
#define PS_PANELS 200
/* Next to n = 1 both terms of the connection formula grow like 1/(n - 1): quadrature there. */
#define PS_NEAR_ONE 0.05
#define PS_TERMS 400

enum { PS_REST, PS_TURNING, PS_PLAIN };
enum { PS_HYPERGEOMETRIC = 1, PS_ELEMENTARY = 2, PS_QUADRATURE = 4 };

typedef struct {
  double a, b, kap, n, p;
  double x0, g0, x0p; /* anchor, G and x^p there */
  int map;            /* PS_REST, PS_TURNING (at x0) or PS_PLAIN (unit: length) */
  double sign, unit, gamma_time;
  double other; /* the turning point ahead, where a motion started (almost) at rest; or 0 */
  double so_far[2]; /* of the impact: what the errors are compared with */
  int used;
} ps_ray;

static double ps_force(const ps_ray *r, double x) { return x > 0 ? r->kap * pow(x, r->n) : 0; }

/* x^p - x0^p and x - x0 keep their digits next to the anchor. */
static double ps_energy(const ps_ray *r, double x) {
  double dx = x - r->x0, power;
  if (r->x0 > 0)
    power = r->x0p * expm1(r->p * log1p(fmax(dx / r->x0, -1)));
  else
    power = pow(x, r->p);
  return r->g0 - r->a * r->kap / r->p * power - r->b * dx;
}

static void ps_anchor(ps_ray *r, double x0, double g0) {
  r->x0 = x0;
  r->g0 = g0;
  r->x0p = x0 > 0 ? pow(x0, r->p) : 0;
}

/* 2F1(1/2, 1; c; w) for 0 <= w <= 1/2. */
static double ps_series(double c, double w) {
  double term = 1, sum = 1;
  for (int k = 0; k < PS_TERMS; k++) {
    term *= (k + 0.5) / (k + c) * w;
    sum += term;
    if (term < 1e-17 * sum) break;
  }
  return sum;
}

/* From rest at x = 0 with a <= 0 and b < 0: the closed forms of derivations/corrected_jump.py. */
static void ps_from_rest(const ps_ray *r, double x, double *t, double *P) {
  double beta = -r->b, root = sqrt(2 * x / beta), f = ps_force(r, x);
  double z = -r->a * f / (r->p * beta), b0 = 0.5 / r->n, w = z / (1 + z), scale;
  if (z <= 1) {
    scale = 1 / sqrt(1 + z);
    *t = root * scale * ps_series(1 + b0, w);
    *P = f * root * scale * ps_series(2 + b0, w) / (2 * r->n + 1);
    return;
  }
  if (r->n == 1)
    *t = root / sqrt(z) * asinh(sqrt(z));
  else {
    double g = (r->n - 1) / (2 * r->n);
    double tail = root / sqrt(1 + z) / (r->n - 1) * ps_series(1 + g, 1 / (1 + z));
    *t = root * r->gamma_time * pow(z, -b0) - tail;
  }
  *P = (sqrt(2 * beta * x * (1 + z)) - beta * *t) / -r->a;
}

/* dx/|x'| and F dx/|x'| per d(variable). PS_TURNING: x = x0 (1 +- q^2)^4. PS_PLAIN: x = unit q^4. */
static void ps_integrand(const ps_ray *r, double q, double *dt, double *dP) {
  double x, dx, g, f;
  if (r->map == PS_TURNING) {
    double e = r->sign * q * q, square = (1 + e) * (1 + e);
    double power = expm1(4 * r->p * log1p(e));
    x = r->x0 * square * square;
    dx = 8 * r->x0 * q * (1 + e) * square;
    g = -r->a * r->kap / r->p * r->x0p * power - r->b * r->x0 * e * (4 + e * (6 + e * (4 + e)));
    f = x > 0 ? r->kap * r->x0p * (1 + power) / x : 0;
  } else {
    x = r->unit * q * q * q * q;
    dx = 4 * r->unit * q * q * q;
    g = ps_energy(r, x);
    f = ps_force(r, x);
  }
  *dt = g > 0 ? dx / sqrt(2 * g) : 0;
  *dP = f * *dt;
}

static double ps_variable(const ps_ray *r, double x) {
  if (r->map == PS_PLAIN) return sqrt(sqrt(x / r->unit));
  double near = fmax((x - r->x0) / r->x0, -1);
  return sqrt(fmax(0, r->sign * (near > -1 ? expm1(log1p(near) / 4) : -1)));
}

/* t and P over a panel by one rule; returns whether they are right to round-off of the whole: the
 * last two Legendre coefficients of the integrands tell how fast those fall. */
static int ps_rule(const ps_ray *r, double l, double h, int rule, double whole[2],
                   const double part[2], double value[2]) {
  double m = 0.5 * (l + h), half = 0.5 * (h - l), f[2], last[2] = {0, 0}, before[2] = {0, 0};
  int fine = 1;
  value[0] = value[1] = 0;
  for (int i = 0; i < PS_ORDER[rule]; i++) {
    ps_integrand(r, m + half * PS_NODES[rule][i], &f[0], &f[1]);
    for (int k = 0; k < 2; k++) {
      value[k] += half * PS_WEIGHTS[rule][i] * f[k];
      last[k] += half * PS_LAST[rule][i] * f[k];
      before[k] += half * PS_BEFORE[rule][i] * f[k];
    }
  }
  for (int k = 0; k < 2; k++) {
    whole[k] = fmax(whole[k], fabs(part[k] + value[k]));
    fine = fine && !(fabs(last[k]) + fabs(before[k]) > PS_PANEL * whole[k]);
  }
  return fine;
}

/* Adds time and impulse from x1 to x2 to `sum`; backwards in `dir` they count negative. */
static void ps_add(ps_ray *r, double x1, double x2, double dir, double sum[2]) {
  double way = r->map == PS_TURNING ? r->sign * dir : dir;
  double stack[PS_PANELS][2] = {{ps_variable(r, x1), ps_variable(r, x2)}};
  double value[2], part[2] = {0, 0}, whole[2] = {r->so_far[0], r->so_far[1]};
  int depth = 1, count = 0;
  r->used |= PS_QUADRATURE;
  while (depth) {
    double l = stack[--depth][0], h = stack[depth][1], middle = 0.5 * (l + h);
    int fine = (r->map == PS_PLAIN || fabs(h - l) < 0.5) &&
               ps_rule(r, l, h, 0, whole, part, value);
    fine = fine || ps_rule(r, l, h, 1, whole, part, value);
    if (fine || ++count > PS_PANELS || depth + 2 > PS_PANELS) {
      part[0] += value[0];
      part[1] += value[1];
      continue;
    }
    stack[depth][0] = middle;
    stack[depth++][1] = h;
    stack[depth][0] = l;
    stack[depth++][1] = middle;
  }
  sum[0] += way * part[0];
  sum[1] += way * part[1];
}

/* The same where the motion is (almost) at rest at both ends: each half is reckoned from its own. */
static void ps_add_halves(ps_ray *r, double x1, double x2, double dir, double sum[2]) {
  double middle = 0.5 * (r->x0 + r->other);
  if (!(r->other > 0)) {
    ps_add(r, x1, x2, dir, sum);
    return;
  }
  int first = dir * (x1 - middle) < 0, second = dir * (x2 - middle) < 0;
  if (first || second) ps_add(r, first ? x1 : middle, second ? x2 : middle, dir, sum);
  if (first && second) return;
  ps_ray half = *r;
  ps_anchor(&half, r->other, 0);
  half.map = PS_TURNING;
  half.sign = r->x0 < r->other ? -1 : 1;
  ps_add(&half, first ? middle : x1, second ? middle : x2, dir, sum);
}
