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

/* The largest of the last and the last but one terms of the states, each over its tolerance; nan
 * where one is not finite. */
static void PS_OF(last_terms)(const PS_REAL (*v)[PS_COLUMNS], int p, const PS_REAL *x,
                              const PS_REAL *atol, double rtol, PS_REAL *restrict last) {
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
  last[0] = most + nothing;
  last[1] = before + nothing;
}

/* Series of n guards and ramps over a step of h units, and for each a bound from below. */
static void PS_OF(bounds)(PS_OF(ps_guards) guards, int n, const PS_REAL *w, int p, const PS_REAL *h,
                          const PS_REAL (*v)[PS_COLUMNS], PS_REAL (*restrict g)[PS_WATCHED],
                          PS_REAL *restrict least) {
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

#undef PS_REAL
#undef PS_OF
#undef PS_REAL_OF
#undef PS_REAL_FMA
#undef PS_REAL_ABS
#undef PS_CHOOSE
