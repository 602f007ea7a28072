/* Sine and cosine together: read twice, for one motion and for lanes of motions, like along.c. The C
 * library has them for one number at a time. Reduction and corrections as in fdlibm (Sun Microsystems,
 * e_rem_pio2.c, k_sin.c, k_cos.c), with Taylor's coefficients: within one unit in the last place. */

/* The sum of eight terms of a series in z: (-1)^k z^k / (2 k + first)!. */
__attribute__((unused)) static inline PS_REAL PS_OF(eight_terms)(PS_REAL z, int first) {
  const double *const c = PS_INVERSE_FACTORIAL + first;
  const PS_REAL z2 = z * z;
  const PS_REAL a = PS_REAL_FMA(z, PS_REAL_OF(-c[2]), PS_REAL_OF(c[0]));
  const PS_REAL b = PS_REAL_FMA(z, PS_REAL_OF(-c[6]), PS_REAL_OF(c[4]));
  const PS_REAL d = PS_REAL_FMA(z, PS_REAL_OF(-c[10]), PS_REAL_OF(c[8]));
  const PS_REAL e = PS_REAL_FMA(z, PS_REAL_OF(-c[14]), PS_REAL_OF(c[12]));
  return PS_REAL_FMA(z2 * z2, PS_REAL_FMA(z2, e, d), PS_REAL_FMA(z2, b, a));
}

__attribute__((unused)) static inline PS_OF(ps_pair) PS_OF(ps_sin_cos)(PS_REAL x) {
  /* The nearest whole number of right angles, also in the last bits of `shifted`. */
  const PS_REAL shifted = PS_REAL_FMA(x, PS_REAL_OF(0x1.45f306dc9c883p-1), PS_REAL_OF(0x1.8p52));
  const PS_REAL n = shifted - 0x1.8p52;
  /* The angle that is left, y + rest. Two of the parts of pi/2 have 33 bits: products are exact. */
  const PS_REAL a = PS_REAL_FMA(n, PS_REAL_OF(-0x1.921fb544p0), x), b = n * 0x1.0b4611a6p-34;
  const PS_REAL y = a - b, rest = ((a - y) - b) - n * 0x1.3198a2e037073p-69;
  const PS_REAL z = y * y, half = 0.5 * z, w = 1.0 - half;
  const PS_REAL odd = y - PS_REAL_FMA(z * y, PS_OF(eight_terms)(z, 3), -rest * w);
  const PS_REAL more = PS_REAL_FMA(z * z, PS_OF(eight_terms)(z, 4), -y * rest);
  const PS_REAL even = w + (((1.0 - w) - half) + more);
  const PS_BITS turns = PS_OF(bits_of)(shifted);
  PS_REAL sine = PS_CHOOSE((turns & 1) != 0, even, odd);
  PS_REAL cosine = PS_CHOOSE((turns & 1) != 0, odd, even);
  sine = PS_OF(of_bits)(PS_OF(bits_of)(sine) ^ (turns >> 1 << 63));
  cosine = PS_OF(of_bits)(PS_OF(bits_of)(cosine) ^ ((turns + 1) >> 1 << 63));
  PS_OF(ps_pair) both = {sine, cosine};
  for (unsigned l = 0; l < sizeof x / sizeof(double); l++) {
    const double angle = ((const double *)&x)[l];
    if (fabs(angle) <= PS_FARTHEST) continue;
    const ps_pair far = far_sin_cos(angle);
    ((double *)&both.sin)[l] = far.sin;
    ((double *)&both.cos)[l] = far.cos;
  }
  return both;
}
