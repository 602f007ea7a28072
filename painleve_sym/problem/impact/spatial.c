/* Impacts of one contact in space: the path of the impulse in blown-up time, as derived in
 * problem/impact/spatial.py. */
#include <math.h>
#include <string.h>

#ifndef PS_EXPORT
#define PS_EXPORT __attribute__((visibility("default")))
#endif
/* Order of the power series, phases of an impact at most, numbers that are given and rows. */
enum { ORDER = 20, PHASES = 16, GIVEN = 12, HEAD = 2, ROW = 11 };
enum { VELOCITY, IMPULSE, WORK }; /* of which restitution returns a share */
enum { NO_IMPACT, ENDED, JAM, UNFINISHED };
enum { SLIP, STOPS, STICK, RESUMED };
enum { GOES_ON = -1 };

static const double ROUND_OFF = 8.881784197001252e-16, COINCIDENT = 1e-12;
/* Of a velocity: what W of rank two cannot change, below which it is 0. */
static const double TIED = 1e-9;
/* Of the first term of a series: the last one. Of v at the start of a slip: a v that has stopped. */
static const double LAST_TERM = 1e-17, STOPPED = 1e-30;
/* Of the terms of a rate: the least one for which series about an invariant direction are used; and how
 * much v grows at most along one of their pieces. */
static const double LEAST_RATE = 1e-3, GROWTH = 16;
/* Of v: events within a smaller change of it would lose digits along such a piece. */
static const double LEAST_CHANGE = 0.05;
static const int PIECES = 20000;

/* Direction e = (c, s), slip v, v_n; impulses and works since the beginning of the phase. */
typedef struct { double c, s, v, n, P, P1, P2, E, T; } state;

typedef struct {
  double Wnn, w1, w2, W11, W12, W22, mu, target, share;
  int measure, restitution, phases;
  double left; /* of P or of the work that restitution has to give */
  double size; /* of the terms of h and k */
  int singular; /* v_n and v_t are tied: v_n = offset + a1 v_1 + a2 v_2 all along */
  double a1, a2, offset;
  state at;
  double *rows;
} impact;

/* Where slip tends to along an invariant direction: series in y, y' = rate y, of unit first order. */
typedef struct {
  double c, s, k, rate, radius;
  double C[ORDER + 1], S[ORDER + 1], D[ORDER + 1], V[ORDER + 1];
} limit;

/* Series of a piece. By time: powers of x = tau. Else x = exp(k tau), from 1 to 0 for k < 0, and y = x^power. */
typedef struct {
  int by_time;
  double k, power, end, n_end, P_end, P1_end, P2_end, E_end, T_end;
  double c[ORDER + 1], s[ORDER + 1], v[ORDER + 1], n[ORDER + 1], P[ORDER + 1], P1[ORDER + 1];
  double P2[ORDER + 1], E[ORDER + 1], T[ORDER + 1];
  state from;
  const impact *of;
} piece;

static double added_three(double a, double b, double c) {
  double sum = a + b + c;
  return fabs(sum) > ROUND_OFF * (fabs(a) + fabs(b) + fabs(c)) ? sum : 0.0;
}
static double added(double a, double b) { return added_three(a, b, 0.0); }

/* ---- rates along a direction ---- */

static double A_of(const impact *p, double c, double s) {
  return added_three(p->Wnn, -p->mu * p->w1 * c, -p->mu * p->w2 * s);
}
static double w_along(const impact *p, double c, double s) { return p->w1 * c + p->w2 * s; }
static double w_across(const impact *p, double c, double s) { return added(p->w2 * c, -p->w1 * s); }
static double k_of(const impact *p, double c, double s) {
  double f1 = p->w1 - p->mu * (p->W11 * c + p->W12 * s);
  double f2 = p->w2 - p->mu * (p->W12 * c + p->W22 * s);
  double k = c * f1 + s * f2;
  return fabs(k) > ROUND_OFF * p->size ? k : 0.0; /* so that no slip stops by rounding alone */
}
static double h_of(const impact *p, double c, double s) {
  double f1 = p->w1 - p->mu * (p->W11 * c + p->W12 * s);
  double f2 = p->w2 - p->mu * (p->W12 * c + p->W22 * s);
  double h = c * f2 - s * f1;
  return fabs(h) > ROUND_OFF * p->size ? h : 0.0; /* below that by the rounding of c and s alone */
}
/* k where h = 0. Slip that turned there has left some rounding in it, by which alone a v_n that is tied
 * to the slip would end. */
static double steady_k(const impact *p, double c, double s) {
  double k = k_of(p, c, s);
  return p->singular && fabs(k) <= COINCIDENT * p->size ? 0.0 : k;
}
/* dh/dphi where h = 0. */
static double slope_of(const impact *p, double c, double s) {
  return -k_of(p, c, s) - p->mu * (p->W11 * s * s - 2 * p->W12 * s * c + p->W22 * c * c);
}

/* dv_n/dv along a direction of slip, where W is of rank two. */
static double tied_along(const impact *p, double c, double s) { return added(p->a1 * c, p->a2 * s); }
/* Whether v_n and the slip vanish together. */
static int tied(const impact *p) { return p->singular && p->offset == 0.0; }
/* A number with the sign of v_n, also at the end of a slip that stops together with v_n: it is 0 there
 * where v_n is the smaller one. */
static double sense(const impact *p, const state *a) {
  double along = tied_along(p, a->c, a->s);
  return !tied(p) ? a->n : fabs(along) > COINCIDENT * hypot(p->a1, p->a2) ? along : 0.0;
}

/* ---- invariant directions ---- */

/* The zero of w2 cos - w1 sin - D sin cos between two angles, from the sign at the first to the other. */
static double zero_between(double w1, double w2, double D, double from, double to, int sign) {
  double x = (from + to) / 2;
  for (int i = 0; i < 200; i++) {
    double c = cos(x), s = sin(x), h = w2 * c - w1 * s - D * s * c;
    if (h == 0.0) return x;
    if (h * sign > 0.0) from = x; else to = x;
    double next = x - h / (-w2 * s - w1 * c - D * (c * c - s * s));
    if (!(next > from && next < to)) next = (from + to) / 2;
    if (fabs(next - x) <= 1e-16 * fabs(x) || next == from || next == to) return next;
    x = next;
  }
  return x;
}

/* All zeros of h, the one with the largest k first, as angles; how many, 0 where h = 0 everywhere. */
static int invariant_directions(const impact *p, double *angle) {
  const double half = acos(-1.0) / 2, d = (p->W11 - p->W22) / 2, r = hypot(d, p->W12);
  double axis = r > 0.0 ? atan2(p->W12, d) / 2 + half : 0.0, D = 2 * p->mu * r;
  /* Components along the axis of the smaller and of the larger mobility, made positive. */
  double a = p->w1 * cos(axis) + p->w2 * sin(axis), b = p->w2 * cos(axis) - p->w1 * sin(axis);
  double w1 = fabs(a), w2 = fabs(b), one = a < 0.0 ? -1.0 : 1.0, two = b < 0.0 ? -1.0 : 1.0;
  double root1 = cbrt(w1), root2 = cbrt(w2), directions[4];
  int count = 2;
  if (w1 == 0.0 && w2 == 0.0 && D == 0.0) return 0;
  directions[0] = zero_between(w1, w2, D, 0.0, half, 1);
  directions[1] = zero_between(w1, w2, D, 2 * half, 3 * half, -1);
  if (pow(root1 * root1 + root2 * root2, 1.5) < D) { /* within the astroid */
    double top = 2 * half - atan2(root2, root1);
    directions[2] = zero_between(w1, w2, D, half, top, -1);
    directions[3] = zero_between(w1, w2, D, top, 2 * half, 1);
    count = 4;
  }
  for (int i = 0; i < count; i++)
    angle[i] = axis + atan2(two * sin(directions[i]), one * cos(directions[i]));
  return count;
}

/* ---- series ---- */

/* Term j of a product. */
static double term(const double *a, const double *b, int j) {
  double sum = 0.0;
  for (int i = 0; i <= j; i++) sum += a[i] * b[j - i];
  return sum;
}
static double value(const double *a, double x) {
  double sum = a[ORDER];
  for (int j = ORDER - 1; j >= 0; j--) sum = sum * x + a[j];
  return sum;
}
/* The size of x for which the last terms of a series are small parts of `first`. */
static double reach(const double *a, double first) {
  double x = INFINITY;
  for (int j = ORDER - 1; j <= ORDER; j++)
    if (a[j] != 0.0) x = fmin(x, pow(LAST_TERM * first / fabs(a[j]), 1.0 / j));
  return x;
}

static void by_time(const impact *p, piece *q) {
  double f1[ORDER], f2[ORDER], h[ORDER], k[ORDER];
  const state *at = &p->at;
  q->by_time = 1, q->from = *at, q->of = p;
  q->c[0] = at->c, q->s[0] = at->s, q->v[0] = at->v, q->n[0] = at->n;
  q->P[0] = at->P, q->P1[0] = at->P1, q->P2[0] = at->P2, q->E[0] = at->E, q->T[0] = at->T;
  for (int j = 0; j < ORDER; j++) {
    f1[j] = (j ? 0.0 : p->w1) - p->mu * (p->W11 * q->c[j] + p->W12 * q->s[j]);
    f2[j] = (j ? 0.0 : p->w2) - p->mu * (p->W12 * q->c[j] + p->W22 * q->s[j]);
    /* Several sums at a time: each waits for its last term. */
    double cf1 = 0.0, cf2 = 0.0, sf1 = 0.0, sf2 = 0.0, vc = 0.0, vs = 0.0, vn = 0.0, vv = 0.0;
    for (int i = 0; i <= j; i++) {
      double c = q->c[i], s = q->s[i], v = q->v[i];
      cf1 += c * f1[j - i], cf2 += c * f2[j - i], sf1 += s * f1[j - i], sf2 += s * f2[j - i];
      vc += v * q->c[j - i], vs += v * q->s[j - i], vn += v * q->n[j - i], vv += v * q->v[j - i];
    }
    h[j] = cf2 - sf1, k[j] = cf1 + sf2;
    double next = j + 1, sh = 0.0, ch = 0.0, vk = 0.0;
    for (int i = 0; i <= j; i++) sh += q->s[i] * h[j - i], ch += q->c[i] * h[j - i], vk += q->v[i] * k[j - i];
    q->c[j + 1] = -sh / next, q->s[j + 1] = ch / next, q->v[j + 1] = vk / next;
    q->n[j + 1] = (p->Wnn * q->v[j] - p->mu * (p->w1 * vc + p->w2 * vs)) / next;
    q->P[j + 1] = q->v[j] / next, q->P1[j + 1] = -p->mu * vc / next, q->P2[j + 1] = -p->mu * vs / next;
    q->E[j + 1] = vn / next, q->T[j + 1] = -p->mu * vv / next;
  }
  q->end = fmin(fmin(reach(q->c, 1.0), reach(q->s, 1.0)), reach(q->v, at->v));
}

/* The invariant direction towards which slip turns; 0 where it has no series. */
static int limit_ahead(const impact *p, double h, limit *l) {
  double angle[4], here = atan2(p->at.s, p->at.c), turn = 4 * acos(-1.0) / 2, nearest = INFINITY;
  int count = invariant_directions(p, angle);
  for (int i = 0; i < count; i++) {
    double ahead = fmod((angle[i] - here) * (h > 0.0 ? 1.0 : -1.0), turn);
    if (ahead < 0.0) ahead += turn;
    double c = cos(angle[i]), s = sin(angle[i]), rate = slope_of(p, c, s);
    if (rate < 0.0 && ahead < nearest)
      nearest = ahead, l->c = c, l->s = s, l->rate = rate, l->k = k_of(p, c, s);
  }
  if (nearest == INFINITY) return 0;
  double least = fmin(fabs(l->k), fmin(fabs(l->k + l->rate), fabs(2 * l->k + l->rate)));
  if (least < LEAST_RATE * p->size) return 0; /* quotients by smaller ones lose digits */
  double f1[ORDER + 1], f2[ORDER + 1], K[ORDER + 1], *C = l->C, *S = l->S, *D = l->D, *V = l->V;
  double turned[ORDER + 1]; /* j D_j */
  C[0] = l->c, S[0] = l->s, D[0] = turned[0] = 0.0, V[0] = 1.0;
  f1[0] = p->w1 - p->mu * (p->W11 * C[0] + p->W12 * S[0]);
  f2[0] = p->w2 - p->mu * (p->W12 * C[0] + p->W22 * S[0]);
  K[0] = 0.0;
  for (int j = 1; j <= ORDER; j++) {
    /* First without D_j, whose part in term j of h is rate D_j. */
    turned[j] = C[j] = S[j] = V[j] = 0.0;
    C[j] = -term(S, turned, j) / j, S[j] = term(C, turned, j) / j;
    f1[j] = -p->mu * (p->W11 * C[j] + p->W12 * S[j]);
    f2[j] = -p->mu * (p->W12 * C[j] + p->W22 * S[j]);
    D[j] = j == 1 ? 1.0 : (term(C, f2, j) - term(S, f1, j)) / ((j - 1) * l->rate);
    turned[j] = j * D[j];
    C[j] -= S[0] * D[j], S[j] += C[0] * D[j];
    f1[j] = -p->mu * (p->W11 * C[j] + p->W12 * S[j]);
    f2[j] = -p->mu * (p->W12 * C[j] + p->W22 * S[j]);
    K[j] = (term(C, f1, j) + term(S, f2, j)) / l->rate;
    V[j] = term(K, V, j) / j;
  }
  l->radius = fmin(fmin(reach(D, 1.0), reach(V, 1.0)), fmin(reach(C, 1.0), reach(S, 1.0)));
  return 1;
}

/* The piece along an invariant direction, to the stop of the slip where k < 0, where it is near enough. */
static int along_limit(const impact *p, const limit *l, piece *q) {
  const state *at = &p->at;
  double off = atan2(l->c * at->s - l->s * at->c, l->c * at->c + l->s * at->s), y = off, power = 1.0;
  if (fabs(off) > l->radius) return 0;
  for (int i = 0; i < 50; i++) {
    double slope = ORDER * l->D[ORDER];
    for (int j = ORDER - 1; j > 0; j--) slope = slope * y + j * l->D[j];
    double step = (value(l->D, y) - off) / slope;
    y -= step;
    if (fabs(step) <= 1e-17 + 1e-16 * fabs(y)) break;
  }
  if (!(fabs(y) <= l->radius)) return 0;
  double u1[ORDER + 1], u2[ORDER + 1], sum = value(l->V, y);
  q->by_time = 0, q->from = *at, q->of = p, q->end = l->k < 0.0 ? 0.0 : GROWTH, q->k = l->k, q->power = l->rate / l->k;
  for (int j = 0; j <= ORDER; j++, power *= y) {
    q->c[j] = l->C[j] * power, q->s[j] = l->S[j] * power;
    q->v[j] = l->V[j] * power * at->v / sum;
  }
  for (int j = 0; j <= ORDER; j++) {
    double one = l->k + j * l->rate, two = 2 * l->k + j * l->rate;
    u1[j] = term(q->v, q->c, j), u2[j] = term(q->v, q->s, j);
    q->n[j] = (p->Wnn * q->v[j] - p->mu * (p->w1 * u1[j] + p->w2 * u2[j])) / one;
    q->P[j] = q->v[j] / one;
    q->P1[j] = -p->mu * u1[j] / one, q->P2[j] = -p->mu * u2[j] / one;
    q->E[j] = term(q->v, q->n, j) / two;
    q->T[j] = -p->mu * term(q->v, q->v, j) / two;
  }
  q->n_end = at->n - value(q->n, 1.0), q->P_end = at->P - value(q->P, 1.0);
  q->P1_end = at->P1 - value(q->P1, 1.0), q->P2_end = at->P2 - value(q->P2, 1.0);
  q->T_end = at->T - value(q->T, 1.0);
  q->E_end = at->E - value(q->E, 1.0) - q->n_end * value(q->P, 1.0);
  return 1;
}

static state state_at(const piece *q, double x) {
  state a;
  if (x == (q->by_time ? 0.0 : 1.0)) return q->from;
  double y = q->by_time ? x : pow(x, q->power), m = q->by_time ? 1.0 : x, P = m * value(q->P, y);
  a.c = value(q->c, y), a.s = value(q->s, y), a.v = m * value(q->v, y);
  double unit = hypot(a.c, a.s);
  a.c /= unit, a.s /= unit;
  a.n = m * value(q->n, y), a.P = P, a.P1 = m * value(q->P1, y), a.P2 = m * value(q->P2, y);
  a.E = m * m * value(q->E, y), a.T = m * m * value(q->T, y);
  if (!q->by_time) {
    a.E += q->E_end + q->n_end * P, a.n += q->n_end, a.P += q->P_end;
    a.P1 += q->P1_end, a.P2 += q->P2_end, a.T += q->T_end;
  }
  if (q->of->singular) a.n = q->of->offset + a.v * tied_along(q->of, a.c, a.s);
  return a;
}

/* ---- events ---- */

enum { BORDER, LAW, RATE, TURN };

/* The function that vanishes at an event, and its derivative by tau. */
static double event_of(const impact *p, int event, const state *a, double *slope) {
  double A = A_of(p, a->c, a->s);
  switch (event) {
  case RATE:
    *slope = -p->mu * w_across(p, a->c, a->s) * h_of(p, a->c, a->s);
    return A;
  case TURN: {
    double across = w_across(p, a->c, a->s);
    *slope = -w_along(p, a->c, a->s) * h_of(p, a->c, a->s);
    return fabs(across) > 1e-14 * hypot(p->w1, p->w2) ? across : 0.0;
  }
  case LAW:
    if (p->measure == IMPULSE) {
      *slope = a->v;
      return a->P - p->left;
    }
    if (p->measure == WORK) {
      *slope = a->v * a->n;
      return a->E - p->left;
    } /* fall through */
  default:
    *slope = a->v * A;
    return event == LAW ? a->n - p->target : a->n;
  }
}

/* The event between two places of a piece, of which the function has this sign at the first. */
static double event_between(const impact *p, const piece *q, int event, double from, double to, int sign) {
  double x = (from + to) / 2, slope;
  for (int i = 0; i < 200; i++) {
    state a = state_at(q, x);
    double f = event_of(p, event, &a, &slope);
    if (f == 0.0) return x;
    if (f * sign > 0.0) from = x; else to = x;
    if (!q->by_time) slope /= q->k * x;
    double next = x - f / slope, low = fmin(from, to), high = fmax(from, to);
    if (!(next > low && next < high)) next = (from + to) / 2;
    if (fabs(next - x) <= 4e-16 * fabs(x) || next == from || next == to) return next;
    x = next;
  }
  return x;
}

/* Whether an event is too near to the beginning of a piece along an invariant direction. */
static int too_near(const piece *q, double x) { return !q->by_time && fabs(x - 1) < LEAST_CHANGE; }

/* ---- the path ---- */

static int sign_of(double x) { return (x > 0.0) - (x < 0.0); }

/* What the present phase has taken of the impulse or of the work. */
static double taken(const impact *p) { return p->measure == IMPULSE ? p->at.P : p->at.E; }

static void tell(impact *p, int ray, double c, double s) {
  const state *a = &p->at;
  double spent = taken(p);
  if (p->restitution) p->left -= spent;
  else if (p->measure != VELOCITY) p->left += p->share * (p->measure == IMPULSE ? spent : -spent);
  double numbers[ROW] = {2 * ray + p->restitution, a->P, a->P1, a->P2, a->n, a->v * a->c, a->v * a->s,
                          a->E, a->T, c, s};
  if (p->phases < PHASES) memcpy(p->rows + HEAD + ROW * p->phases, numbers, sizeof numbers);
  p->phases++;
  p->at.P = p->at.P1 = p->at.P2 = p->at.E = p->at.T = 0.0;
}

/* Whether restitution has nothing to give from here. */
static int nothing_due(const impact *p) {
  return p->measure == VELOCITY ? p->at.n >= p->target : p->left <= 0.0;
}

/* Whether restitution ends here but for rounding. */
static int nearly_done(const impact *p) {
  const state *a = &p->at;
  if (p->measure == VELOCITY) return p->target - a->n <= COINCIDENT * p->target;
  return p->left - taken(p) <= COINCIDENT * p->left;
}

/* The impulse along a ray to the end of the present part, INFINITY where it never is, and v_n there. */
static double impulse_to_end(const impact *p, double A, double *n) {
  double left = fmax(0.0, p->left - taken(p));
  *n = p->at.n;
  if (!p->restitution || p->measure == VELOCITY) {
    double due = p->restitution ? p->target : 0.0;
    if (A > 0.0) return *n = due, (due - p->at.n) / A;
    return p->phases && due <= p->at.n && (A == 0.0 || p->restitution) ? 0.0 : INFINITY;
  }
  if (p->measure == IMPULSE) return *n += A * left, left;
  if (left == 0.0) return 0.0;
  double squared = p->at.n * p->at.n + 2 * A * left;
  if (squared <= 0.0) return INFINITY;
  return *n = sqrt(squared), 2 * left / (p->at.n + *n);
}

/* Follows a straight ray to the end of the impact, or to where its slip stops (GOES_ON). The impulse is
 * dP_n (1, r1, r2), and v_n and v change at the rates A and k. */
static int ray(impact *p, int kind, double r1, double r2, double A, double k) {
  state *a = &p->at;
  if (p->singular && a->v > 0.0) A = k * (a->n - p->offset) / a->v;
  for (;;) {
    double n, end = impulse_to_end(p, A, &n), stop = k < 0.0 && a->v > 0.0 ? -a->v / k : INFINITY;
    /* In restitution v_n may fall to 0 before: the contact is compressed again. */
    double border = p->restitution && A < 0.0 ? -a->n / A : INFINITY;
    int falls = border < end;
    if (falls) end = border, n = 0.0;
    double sooner = end * (1 - COINCIDENT), c = kind == STICK ? 0.0 : a->c, s = kind == STICK ? 0.0 : a->s;
    int stops = stop < INFINITY && stop <= (p->restitution ? sooner : end * (1 + COINCIDENT));
    if (!stops && end == INFINITY) return JAM;
    double P = stops ? stop : end, reached = stops && stop < sooner ? a->n + A * stop : n;
    double v = stops || stop <= end * (1 + COINCIDENT) ? 0.0 : a->v + k * P;
    a->P += P, a->P1 += r1 * P, a->P2 += r2 * P;
    a->E += P * (a->n + reached) / 2;
    a->T += P * (r1 * a->c + r2 * a->s) * (a->v + v) / 2;
    a->n = stops && p->singular ? p->offset : reached, a->v = v;
    tell(p, stops ? STOPS : kind, c, s);
    if (stops) return GOES_ON;
    if (p->restitution && !falls) return ENDED;
    p->restitution = !falls;
  }
}

/* Whether v_n, which is tied to the slip of a driven surface, never gets beyond what ends the part: the
 * slip tends to where mu W11 cos = w1. */
static int never_ends(const impact *p) {
  const state *a = &p->at;
  if (!p->singular || p->W22 != 0.0 || fabs(p->w1) >= p->mu * p->W11) return 0;
  if (p->restitution && p->measure != VELOCITY) return 0;
  double cosine = p->w1 / (p->mu * p->W11);
  double turned = p->a1 * a->v * fabs(a->s) * cosine / sqrt(1 - cosine * cosine);
  double above = p->offset + turned - (p->restitution ? p->target : 0.0);
  return above <= TIED * (fabs(p->offset) + fabs(turned));
}

/* Follows slip that turns, to the end of the impact or to where it stops. */
static int curve(impact *p) {
  limit l;
  piece q;
  state *a = &p->at;
  const int both = p->mu * hypot(p->w1, p->w2) > p->Wnn * (1 - COINCIDENT);
  int known = 0, rate = 1, turn = 0, direct = 0;
  double start = a->v;
  for (int i = 0; i < PIECES; i++) {
    if (never_ends(p)) return JAM;
    double h = h_of(p, a->c, a->s);
    if (h == 0.0) return ray(p, SLIP, -p->mu * a->c, -p->mu * a->s, A_of(p, a->c, a->s), steady_k(p, a->c, a->s));
    if (!i) {
      known = limit_ahead(p, h, &l);
      rate = sign_of(A_of(p, a->c, a->s)), turn = sign_of(w_across(p, a->c, a->s));
      if (!rate) rate = sign_of(-turn * h);
      if (!rate) rate = 1;
      if (!turn) turn = sign_of(-w_along(p, a->c, a->s) * h);
    }
    if (direct || !(known && along_limit(p, &l, &q))) by_time(p, &q);
    direct = 0;
    double from = q.by_time ? 0.0 : 1.0, to = q.end, unused, x;
    state end = state_at(&q, to);
    int passes = 0, changes = 0;
    if (both) { /* v_n is monotonic between the zeros of A, of which one is on each side of w */
      passes = turn * event_of(p, TURN, &end, &unused) < 0.0;
      if (passes) to = event_between(p, &q, TURN, from, to, turn), end = state_at(&q, to);
      changes = rate * A_of(p, end.c, end.s) < 0.0;
      if (changes) passes = 0, to = event_between(p, &q, RATE, from, to, rate), end = state_at(&q, to);
    }
    int opens = tied(p) ? sense(p, &end) > 0.0 : end.n >= 0.0;
    if (!p->restitution && rate > 0 && opens && a->n < 0.0) {
      x = event_between(p, &q, BORDER, from, to, -1);
      if ((direct = too_near(&q, x))) continue;
      *a = state_at(&q, x), a->n = 0.0;
      tell(p, SLIP, a->c, a->s);
      p->restitution = 1;
      if (nothing_due(p)) return tell(p, SLIP, a->c, a->s), ENDED;
      continue;
    }
    if (p->restitution) {
      int falls = rate < 0 && sense(p, &end) < 0.0;
      if (falls) to = event_between(p, &q, BORDER, from, to, 1), end = state_at(&q, to), end.n = 0.0;
      if (event_of(p, LAW, &end, &unused) >= 0.0) {
        x = event_between(p, &q, LAW, from, to, -1);
        if ((direct = too_near(&q, x))) continue;
        *a = state_at(&q, x);
        if (p->measure == VELOCITY) a->n = p->target;
        if (a->v <= COINCIDENT * start) a->v = 0.0; /* it stops at the end */
        return tell(p, SLIP, a->c, a->s), ENDED;
      }
      if (falls) { /* compressed again */
        if ((direct = too_near(&q, to))) continue;
        *a = end;
        tell(p, SLIP, a->c, a->s);
        p->restitution = 0;
        continue;
      }
    }
    *a = end;
    rate = changes ? -rate : rate, turn = passes ? -turn : turn;
    if ((!q.by_time && to == 0.0) || a->v < STOPPED * start) {
      a->v = 0.0, a->n = p->singular ? p->offset : a->n;
      if (p->restitution && nearly_done(p)) return tell(p, SLIP, a->c, a->s), ENDED;
      return tell(p, STOPS, a->c, a->s), GOES_ON;
    }
  }
  return UNFINISHED;
}

/* Follows what a contact without slip does: it sticks, or slips in the one direction in which slip grows. */
static int at_rest(impact *p, int after_stop) {
  double r1 = -p->a1, r2 = -p->a2, k = 0.0, c = 0.0, s = 0.0, angle[4];
  if (hypot(r1, r2) > p->mu) {
    if (!invariant_directions(p, angle)) return UNFINISHED;
    c = cos(angle[0]), s = sin(angle[0]), k = k_of(p, c, s);
  }
  if (k <= 0.0) { /* also on the edge of the cone */
    double A = p->Wnn + p->w1 * r1 + p->w2 * r2;
    return ray(p, STICK, r1, r2, !p->singular && A > COINCIDENT * p->Wnn ? A : 0.0, 0.0);
  }
  p->at.c = c, p->at.s = s;
  return ray(p, after_stop ? RESUMED : SLIP, -p->mu * c, -p->mu * s, A_of(p, c, s), k);
}

/* Whether an impact begins: an approach, or at v_n = 0 a slip that does not open the contact. */
static int begins(const impact *p) {
  const state *a = &p->at;
  if (a->n < 0.0) return 1;
  if (a->v == 0.0 || p->Wnn == 0.0) return 0;
  double A = A_of(p, a->c, a->s), h = h_of(p, a->c, a->s), grows = -w_across(p, a->c, a->s) * h;
  if (A != 0.0) return A < 0.0;
  return grows < 0.0 || (grows == 0.0 && h == 0.0 && k_of(p, a->c, a->s) < 0.0);
}

static void follow(const double *g, double *rows) {
  impact p = {.Wnn = g[0], .w1 = g[1], .w2 = g[2], .W11 = g[3], .W12 = g[4], .W22 = g[5], .mu = g[6],
              .share = g[11], .measure = (int)g[10], .rows = rows};
  double v = hypot(g[8], g[9]);
  p.at.n = g[7], p.at.v = v, p.at.c = v > 0.0 ? g[8] / v : 0.0, p.at.s = v > 0.0 ? g[9] / v : 0.0;
  p.target = -p.share * p.at.n;
  p.size = hypot(p.w1, p.w2) + p.mu * (p.W11 + p.W22);
  double det = p.W11 * p.W22 - p.W12 * p.W12, size = p.W11 * p.W22;
  p.a1 = (p.W22 * p.w1 - p.W12 * p.w2) / det;
  p.a2 = (p.W11 * p.w2 - p.W12 * p.w1) / det;
  if (p.W22 == 0.0) p.a1 = p.w1 / p.W11, p.a2 = 0.0, det = size = p.W11; /* nothing moves along t2 */
  double least = p.Wnn - p.w1 * p.a1 - p.w2 * p.a2;
  p.singular = least * det <= COINCIDENT * p.Wnn * size;
  p.offset = p.at.n - p.a1 * g[8] - p.a2 * g[9];
  if (fabs(p.offset) <= TIED * (fabs(p.at.n) + fabs(p.a1 * g[8]) + fabs(p.a2 * g[9]))) p.offset = 0.0;
  rows[0] = NO_IMPACT, rows[1] = 0.0;
  if (!begins(&p)) return;
  int end = v > 0.0 ? curve(&p) : at_rest(&p, 0);
  if (end == GOES_ON) end = at_rest(&p, 1);
  rows[0] = p.phases > PHASES ? UNFINISHED : end, rows[1] = p.phases;
}

/* Impacts one after the other. Each is given W_nn, W_n1, W_n2, W_11, W_12, W_22, mu, v_n, v_1, v_2, measure, share,
 * and gets its end, how many phases it has, and of each: twice its ray and whether it is of restitution,
 * P_n, P_1, P_2, the velocity at its end, both works and the direction of slip at its end. */
PS_EXPORT void ps_impacts_in_space(int n, const double *given, double *rows) {
  for (int i = 0; i < n; i++) follow(given + GIVEN * i, rows + (HEAD + ROW * PHASES) * i);
}
