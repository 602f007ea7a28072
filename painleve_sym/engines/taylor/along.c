/* Arithmetic along the series of a step: read twice, for one motion (PS_REAL is double) and for
 * lanes of motions (ps_lanes). The same operations in the same order, so that bits agree. */

/* State at u units. */
static void PS_OF(state_along)(const PS_REAL (*v)[PS_COLUMNS], int p, const PS_REAL *u,
                              PS_REAL *restrict y) {
  PS_REAL sum[PS_NX];
  const PS_REAL h = *u;
  for (int i = 0; i < PS_NX; i++) sum[i] = v[p][i];
  for (int k = p - 1; k >= 0; k--)
    for (int i = 0; i < PS_NX; i++) sum[i] = PS_REAL_FMA(sum[i], h, v[k][i]);
  memcpy(y, sum, sizeof sum);
}

/* A ramp's base and its first two derivatives, the second halved, at u units; order p is not known. */
static void PS_OF(ramp_along)(const PS_REAL (*v)[PS_COLUMNS], int column, int p, const PS_REAL *u,
                             PS_REAL *restrict jet) {
  PS_REAL a = PS_REAL_OF(0.0), b = PS_REAL_OF(0.0), d = PS_REAL_OF(0.0);
  const PS_REAL h = *u;
  for (int k = p - 1; k >= 0; k--) {
    d = PS_REAL_FMA(d, h, b);
    b = PS_REAL_FMA(b, h, a);
    a = PS_REAL_FMA(a, h, v[k][column]);
  }
  jet[0] = a;
  jet[1] = b;
  jet[2] = d;
}

/* x to the power e, to three digits, enough for a step size. x > 0 and normal. */
static PS_REAL PS_OF(rough_power)(PS_REAL x, PS_REAL e) {
  const double shift = 0x1p52, round = 0x1.8p52;
  const PS_BITS bits = PS_OF(bits_of)(x);
  const PS_REAL m = PS_OF(of_bits)((bits & 0xfffffffffffffULL) | 0x3ff0000000000000ULL) - 1.0;
  const PS_REAL whole = PS_OF(of_bits)((bits >> 52) | 0x4330000000000000ULL) - (shift + 1023);
  const PS_REAL log2 = whole + m * (1.4249 + m * (-0.5871 + m * 0.1622));
  PS_REAL y = e * log2;
  y = PS_CHOOSE(y < 1000, y, PS_REAL_OF(1000.0));
  y = PS_CHOOSE(y > -1000, y, PS_REAL_OF(-1000.0));
  PS_REAL n = (y + round) - round;
  n = PS_CHOOSE(n > y, n - 1.0, n);
  const PS_REAL f = y - n;
  const PS_BITS power = PS_OF(bits_of)(n + (shift + 1023)) << 52;
  return PS_OF(of_bits)(power) * (1 + f * (0.6957 + f * (0.2251 + f * 0.0792)));
}

/* Step, in units, from the largest last terms and the largest ones before, in parts of the tolerance;
 * `nothing` is 0, and nan where a term is not finite. */
static inline PS_REAL PS_OF(step_of)(PS_REAL most, PS_REAL before, PS_REAL nothing, int p) {
  const PS_REAL least = PS_REAL_OF(1e-100);
  before *= 1 / 7.389;
  most = PS_CHOOSE(most > least, most, least);
  before = PS_CHOOSE(before > least, before, least);
  const PS_REAL h = PS_OF(rough_power)(most, PS_REAL_OF(-PS_INVERSE[p]));
  const PS_REAL other = PS_OF(rough_power)(before, PS_REAL_OF(-PS_INVERSE[p - 1]));
  return PS_CHOOSE(h < other, h, other) + nothing;
}

/* Step, in units, for which the last two terms of each state are within its tolerance; nan where one
 * is not finite. The last but one may be e^2 times larger: that is what a step of 1/e^2 of the
 * radius makes of it. */
PS_FUNCTION void PS_OF(step_along)(const PS_REAL (*v)[PS_COLUMNS], int p, const PS_REAL *x,
                                   const PS_REAL *atol, double rtol, PS_REAL *restrict step) {
  PS_REAL a[PS_NX], b[PS_NX], most = PS_REAL_OF(0.0), before = PS_REAL_OF(0.0);
  PS_REAL nothing = PS_REAL_OF(0.0);
  for (int i = 0; i < PS_NX; i++) {
    const PS_REAL weight = 1.0 / (PS_SHARE * (atol[i] + rtol * PS_REAL_ABS(x[i])));
    a[i] = PS_REAL_ABS(v[p][i]) * weight;
    b[i] = PS_REAL_ABS(v[p - 1][i]) * weight;
  }
  for (int i = 0; i < PS_NX; i++) {
    most = PS_CHOOSE(a[i] <= most, most, a[i]);
    before = PS_CHOOSE(b[i] <= before, before, b[i]);
    nothing += 0.0 * a[i] + 0.0 * b[i];
  }
  *step = PS_OF(step_of)(most, before, nothing, p);
}

/* Series of n guards and ramps over a step of h units, and for each a bound from below. */
PS_FUNCTION void PS_OF(bounds)(PS_OF(ps_guards) guards, int n, const PS_REAL *w, int p,
                               const PS_REAL *h, const PS_REAL (*v)[PS_COLUMNS],
                               PS_REAL (*restrict g)[PS_WATCHED], PS_REAL *restrict least) {
  PS_REAL power[PS_LENGTH];
  power[0] = PS_REAL_OF(1.0);
  power[1] = *h;
  for (int k = 2; k <= p; k++) power[k] = power[k / 2] * power[k - k / 2];
  guards(w, p, power, v, g);
  for (int j = 0; j < n; j++) least[j] = g[0][j];
  for (int k = 1; k <= p; k++)
    for (int j = 0; j < n; j++)
      least[j] += PS_CHOOSE(g[k][j] < 0, g[k][j], PS_REAL_OF(0.0));
}
