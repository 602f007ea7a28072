/* An impact with frozen coefficients, phase by phase, over arrays of cases.
 *
 * g'' = W_nn F_n + W_nt F_t + b_n, v_t' = W_nt F_n + W_tt F_t + b_t; the force is K delta^n, and
 * after the largest compression K ((delta - delta_p)/e^2)^n. One set of coefficients (W_nn, W_nt,
 * W_tt, b_n, b_t) holds until the slip stops, the other afterwards. */

enum { PS_SEPARATION, PS_STAYS, PS_NO_IMPACT, PS_NO_END, PS_FAILED };
/* A start with less than this part of the energy is almost at rest: the rest would be rounding. */
#define PS_SLOW 1e-4
/* Less than this part of the energy at the largest compression counts as none. */
#define PS_ROUNDING 1e-12
#define PS_PHASES 8
#define PS_PHASE_NUMBERS 9
#define PS_HEAD 9
#define PS_INPUTS 17

typedef struct {
  double set[2][5], mu, K, n, e, vt, x, u, gamma_time;
  double speed; /* |v_t| at the start */
  int stopped, mode, loading, used, count;
  double delta_p, kap, largest;
  double sum[3]; /* time, normal and tangential impulse */
} ps_impact;

typedef struct {
  double ratio, offset, c, d; /* F_t = ratio F + offset, v_t' = c F + d */
  ps_ray ray;
} ps_path;

/* Direction of slip that a contact at rest tangentially takes under the force F; 0: it sticks. */
static int ps_departure(const ps_impact *s, double F) {
  const double *w = s->set[s->stopped];
  /* Without a free acceleration all scales with the force, also when it is still zero. */
  if (F == 0 && w[4] == 0) F = 1;
  double pull = w[1] * F + w[4];
  if (fabs(pull) <= s->mu * w[2] * F) return 0;
  return (pull > 0) - (pull < 0);
}

static ps_path ps_start(const ps_impact *s) {
  const double *w = s->set[s->stopped];
  ps_path y;
  y.ratio = s->mode ? -s->mu * s->mode : -w[1] / w[2];
  y.offset = s->mode ? 0 : -w[4] / w[2];
  y.c = s->mode ? w[1] + y.ratio * w[2] : 0;
  y.d = s->mode ? w[4] : 0;
  y.ray.a = w[0] + y.ratio * w[1];
  y.ray.b = w[3] + y.offset * w[1];
  y.ray.kap = s->kap;
  y.ray.n = s->n;
  y.ray.p = s->n + 1;
  y.ray.gamma_time = s->gamma_time;
  y.ray.used = 0;
  y.ray.other = 0;
  for (int i = 0; i < 2; i++) y.ray.so_far[i] = s->sum[i];
  ps_anchor(&y.ray, s->x, 0.5 * s->u * s->u);
  return y;
}

/* Newton from the side of the root where G is negative and steep: monotone. */
static double ps_descend(const ps_ray *r, double x) {
  for (int i = 0; i < 200; i++) {
    double step = ps_energy(r, x) / (r->a * ps_force(r, x) + r->b);
    x += step;
    if (fabs(step) <= 2e-16 * fabs(x)) break;
  }
  return x;
}

/* Where a loading motion turns: G = 0 ahead; HUGE_VAL if nowhere. */
static double ps_turn(const ps_ray *r) {
  double a = r->a * r->kap, still;
  if (a > 0) {
    double x = pow(r->x0p + r->p * r->g0 / a, 1 / r->p);
    still = r->b < 0 ? pow(-r->b / a, 1 / r->n) : 0;
    return ps_descend(r, fmax(fmax(x, 1.5 * still), r->x0));
  }
  if (!(r->b > 0)) return HUGE_VAL;
  if (a == 0) return r->x0 + r->g0 / r->b;
  still = pow(r->b / -a, 1 / r->n);
  if (r->x0 >= still || ps_energy(r, still) >= 0) return HUGE_VAL;
  return ps_descend(r, r->x0);
}

/* Where an unloading motion turns before x = 0, or -1. On one elastic curve from rest the energy at
 * x = 0 is zero but for its rounding: it turns there. */
static double ps_turn_back(const ps_ray *r, double x_max) {
  double a = r->a * r->kap, rounding = PS_ROUNDING * fabs(a) / r->p * pow(x_max, r->p);
  if (a < 0) {
    double still = r->b > 0 ? pow(r->b / -a, 1 / r->n) : 0;
    if (r->x0 <= still || ps_energy(r, still) >= rounding) return -1;
    return fmax(0, ps_descend(r, r->x0));
  }
  return ps_energy(r, 0) < rounding ? fmax(0, ps_descend(r, 0)) : -1;
}

static void ps_choose_map(ps_ray *r, double u, double x_turn, double x_end, int loading) {
  r->map = PS_PLAIN;
  r->unit = isfinite(x_end) ? fmax(x_end, r->x0) : 1;
  if (r->x0 == 0 && u == 0 && r->a <= 0) {
    int odd = fabs(r->n - 1) < PS_NEAR_ONE && r->n != 1;
    r->map = odd || r->n < 0.4 ? PS_PLAIN : PS_REST;
  } else if (u == 0 && r->x0 > 0) {
    r->map = PS_TURNING;
    r->sign = loading ? 1 : -1;
  }
  if (!(x_turn > 0) || !isfinite(x_turn)) return;
  if (r->g0 < PS_SLOW * fabs(r->a) * r->kap / r->p * pow(x_turn, r->p)) {
    r->other = x_turn;
  } else {
    ps_anchor(r, x_turn, 0);
    r->map = PS_TURNING;
    r->sign = loading ? -1 : 1;
  }
}

/* Time and impulse from x1 (where they are in `sum`) to x2. */
static void ps_advance(ps_ray *r, double x1, double x2, double dir, double sum[2]) {
  if (r->map == PS_REST) {
    ps_from_rest(r, x2, &sum[0], &sum[1]);
    r->used |= r->n == 1 ? PS_ELEMENTARY : PS_HYPERGEOMETRIC;
  } else if (x1 != x2) {
    if (r->map == PS_PLAIN && r->unit == 1) r->unit = fmax(x1, x2);
    ps_add_halves(r, x1, x2, dir, sum);
  }
}

/* The compression at which s v_t = w comes down to 0 between x0 and x_end, or -1. `sum` returns
 * time and impulse there, or at x_end. w' is monotone: its only zero splits the path. */
static double ps_slip_stop(const ps_impact *s, ps_path *y, double x_end, double sum[2]) {
  double dir = s->loading ? 1 : -1, p2 = 0.5 * y->ray.p, start = s->x;
  double c = s->mode * y->c, d = s->mode * y->d, w0 = s->mode * s->vt;
  double still = c * d < 0 ? pow(-d / c / s->kap, 1 / s->n) : -1, far = x_end;
  int turns = still > 0 && dir * (still - start) > 0 && dir * (x_end - still) > 0;
  int concave = c * dir < 0;
  if (concave || (turns && c * ps_force(&y->ray, start) + d < 0)) {
    if (!concave) far = still;
  } else if (w0 == 0 || c * ps_force(&y->ray, start) + d >= 0) {
    far = -1; /* the slip grows all the way */
  }
  double x = far, at = start, low = start, high = far, w, sure = w0;
  sum[0] = sum[1] = 0;
  if (far < 0) {
    ps_advance(&y->ray, start, x_end, dir, sum);
    return -1;
  }
  if (isfinite(far)) {
    ps_advance(&y->ray, start, far, dir, sum);
    w = w0 + c * sum[1] + d * sum[0];
    if (!(w < 0)) {
      ps_advance(&y->ray, far, x_end, dir, sum);
      return -1;
    }
    sum[0] = sum[1] = 0;
  } else if (!(c < 0)) {
    return HUGE_VAL;
  }
  /* First guess: the classical impulse, and the speed it gives. */
  double impulse = -(w0 + (y->ray.map == PS_REST && s->n > 1
                           ? d * sqrt(2 / -y->ray.b) * s->gamma_time *
                             pow(-y->ray.a * s->kap / y->ray.p / -y->ray.b, -0.5 / s->n) : 0)) / c;
  double speed = s->u * dir - y->ray.a * impulse, a = y->ray.a * s->kap / y->ray.p;
  double power = pow(start, y->ray.p) + (0.5 * s->u * s->u - 0.5 * speed * speed) / a;
  x = impulse > 0 && power > 0 && isfinite(power) ? pow(power, 1 / y->ray.p) : 0;
  if (!(dir * (x - start) > 0 && dir * (far - x) > 0))
    x = isfinite(far) ? 0.5 * (start + far)
                      : fmax(2 * fmax(start, still), pow(w0 / -c / s->kap, 1 / s->n));
  if (!(x > 0) || !isfinite(x)) return HUGE_VAL;
  for (int i = 0; i < 100; i++) {
    ps_advance(&y->ray, at, x, dir, sum);
    at = x;
    w = w0 + c * sum[1] + d * sum[0];
    if (w >= 0) low = x;
    else high = x;
    double g = ps_energy(&y->ray, x), slope = (c * ps_force(&y->ray, x) + d) / sqrt(2 * fmax(g, 0));
    double grow = 1 - dir * w / slope * p2 / x, next = pow(fmax(grow, 0), 1 / p2) * x;
    if (fabs(w) <= 4e-16 * sure || fabs(next - x) <= 4e-16 * x) break;
    if (!(dir * (next - low) > 0 && (!isfinite(high) || dir * (high - next) > 0)))
      next = isfinite(high) ? 0.5 * (low + high) : 4 * x;
    if (next == x) break;
    x = next;
  }
  return x;
}

/* Compression at which sticking under the force of the path fails first, or -1. */
static double ps_stick_end(const ps_impact *s, double x_end) {
  const double *w = s->set[s->stopped];
  double found = -1, dir = s->loading ? 1 : -1;
  for (int side = -1; side < 2; side += 2) {
    double F = w[4] / (side * s->mu * w[2] - w[1]);
    double x = F > 0 ? pow(F / s->kap, 1 / s->n) : -1;
    /* The threshold where sticking began is not ahead. */
    if (x < 0 || dir * (x - s->x) <= 1e-13 * s->x || dir * (x_end - x) <= 0) continue;
    if (found < 0 || dir * (found - x) > 0) found = x;
  }
  return found;
}

static void ps_unload(ps_impact *s) {
  double delta = s->x + s->delta_p;
  s->largest = delta;
  s->loading = 0;
  s->x = s->e * s->e * delta;
  s->delta_p = delta - s->x;
  s->kap = s->K * pow(s->e, -2 * s->n);
}

/* One phase; returns an end, or -1 to go on. */
static int ps_phase(ps_impact *s, double *row) {
  ps_path y = ps_start(s);
  double dir = s->loading ? 1 : -1, sum[2] = {0, 0};
  double turn = s->loading ? ps_turn(&y.ray)
                           : ps_turn_back(&y.ray, s->e * s->e * s->largest);
  double x_end = fmax(turn, 0), x = -1;
  double before = s->x, u = s->u;
  int next = s->mode, end = -1, back = !s->loading && turn >= 0;
  if (s->mode == 0) {
    double fails = ps_stick_end(s, x_end);
    ps_choose_map(&y.ray, s->u, turn, fails > 0 ? fails : x_end, s->loading);
    x = fails;
    if (!isfinite(x_end) && x < 0) return PS_NO_END;
    ps_advance(&y.ray, s->x, x < 0 ? x_end : x, dir, sum);
    if (x > 0) {
      const double *w = s->set[s->stopped];
      double pull = w[1] * ps_force(&y.ray, x) + w[4];
      next = (pull > 0) - (pull < 0);
    }
  } else {
    ps_choose_map(&y.ray, s->u, turn, x_end, s->loading);
    x = ps_slip_stop(s, &y, x_end, sum);
    if (x == HUGE_VAL || (!isfinite(x_end) && x < 0)) return PS_NO_END;
  }
  int event = x > 0;
  double to = event ? x : x_end;
  if (fabs(to - before) <= 1e-15 * before && s->u != 0) {
    /* So close to the turning point that compressions do not tell: uniform deceleration. */
    double F = ps_force(&y.ray, to), push = fabs(y.ray.a * F + y.ray.b);
    sum[0] = push > 0 ? fabs(s->u) / push : 0;
    sum[1] = F * sum[0];
  }
  if (!event && (s->loading || back)) s->u = 0;
  else s->u = dir * sqrt(2 * fmax(0, ps_energy(&y.ray, to)));
  s->vt = s->mode == 0 || (event && s->mode) ? 0 : s->vt + y.c * sum[1] + y.d * sum[0];
  s->used |= y.ray.used;
  double tangential = y.ratio * sum[1] + y.offset * sum[0];
  double numbers[PS_PHASE_NUMBERS] = {s->mode, s->loading, sum[0], sum[1], tangential,
                                      to + s->delta_p, s->u, s->vt,
                                      /* int P dt, from the momentum balance */
                                      (u * sum[0] - 0.5 * y.ray.b * sum[0] * sum[0] -
                                       (to - before)) / y.ray.a};
  for (int i = 0; i < PS_PHASE_NUMBERS; i++) row[i] = numbers[i];
  for (int i = 0; i < 2; i++) s->sum[i] += sum[i];
  s->sum[2] += tangential;
  s->x = to;
  if (event) {
    if (s->mode) {
      s->stopped = 1;
      next = ps_departure(s, ps_force(&y.ray, to));
    }
    s->mode = next;
  } else if (s->loading && s->mode && s->mode * s->vt <= 1e-15 * s->speed) {
    /* The slip stops at the largest compression, to round-off. */
    s->stopped = 1;
    s->vt = 0;
    if (s->e > 0) ps_unload(s);
    else end = PS_SEPARATION;
    s->mode = ps_departure(s, s->kap * pow(s->x, s->n));
  } else if (back) {
    /* One elastic curve can be loaded again; a contact that A > 0 holds stays closed. */
    if (s->e == 1 && y.ray.a <= 0) s->loading = 1;
    else end = PS_STAYS;
  } else if (s->loading) {
    if (s->e == 0) {
      s->largest = to;
      end = PS_SEPARATION;
    } else {
      ps_unload(s);
      if (s->mode == 0) s->mode = ps_departure(s, s->kap * pow(s->x, s->n));
    }
  } else {
    end = PS_SEPARATION;
  }
  return end;
}

static int ps_begin(ps_impact *s) {
  double F = s->x > 0 ? s->K * pow(s->x, s->n) : 0, rate;
  s->kap = s->K;
  s->speed = fabs(s->vt);
  s->mode = s->vt ? (s->vt > 0) - (s->vt < 0) : ps_departure(s, F);
  if (!s->vt) s->stopped = 1;
  ps_path y = ps_start(s);
  rate = -(y.ray.a * F + y.ray.b);
  s->loading = 1;
  s->largest = s->x;
  if (s->x == 0 && (s->u < 0 || (s->u == 0 && rate <= 0))) return PS_NO_IMPACT;
  if (s->u == 0 && rate == 0) return PS_STAYS;
  if (s->u < 0 || (s->u == 0 && rate < 0)) {
    if (s->e == 0) return PS_SEPARATION;
    ps_unload(s);
  }
  return -1;
}

static void ps_solve(ps_impact *s, double *head, double *rows) {
  int end = ps_begin(s);
  s->count = 0;
  for (int i = 0; i < PS_PHASES * PS_PHASE_NUMBERS; i++) rows[i] = NAN;
  while (end < 0 && s->count < PS_PHASES) {
    end = ps_phase(s, rows + s->count * PS_PHASE_NUMBERS);
    if (end != PS_NO_END) s->count++;
    if (!isfinite(s->x + s->u + s->vt + s->sum[0])) end = PS_FAILED;
  }
  if (end < 0) end = PS_STAYS;
  double numbers[PS_HEAD] = {end, s->used, s->count, s->vt, 0.0 - s->u,
                             s->sum[1], s->sum[2], s->sum[0], s->largest};
  for (int i = 0; i < PS_HEAD; i++) head[i] = numbers[i];
}

/* in[j][k stride[j]]: both sets, mu, K, n, e, v_t, delta, delta'. Rows of `out` belong to a case. */
PS_EXPORT void ps_frozen_impacts(long count, const double *const *in, const long *stride,
                                 double *head, double *rows) {
  double n = -1, gamma_time = 0;
  for (long k = 0; k < count; k++) {
    double v[PS_INPUTS];
    ps_impact s = {0};
    for (int j = 0; j < PS_INPUTS; j++) v[j] = in[j][k * stride[j]];
    for (int j = 0; j < 10; j++) s.set[j / 5][j % 5] = v[j];
    s.mu = v[10]; s.K = v[11]; s.n = v[12]; s.e = v[13]; s.vt = v[14]; s.x = v[15]; s.u = v[16];
    if (s.n != n) {
      n = s.n;
      gamma_time = tgamma(1 + 0.5 / n) * tgamma(0.5 - 0.5 / n) / sqrt(acos(-1.0));
    }
    s.gamma_time = gamma_time;
    ps_solve(&s, head + k * PS_HEAD, rows + k * PS_PHASES * PS_PHASE_NUMBERS);
  }
}
