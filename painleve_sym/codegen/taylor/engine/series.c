/* Products of Taylor series, one order at a time. What needs only known orders is summed first:
 * the two terms with the newest coefficients, on which the next operation waits, come last. */

#if defined(__FMA__)
#define PS_FMA(a, b, c) __builtin_fma(a, b, c)
#else
#define PS_FMA(a, b, c) ((a) * (b) + (c))
#endif
#define PS_TERM(j) case (j) + 1: s[(j) & 1] = PS_FMA(a[j], b[k - (j)], s[(j) & 1]); /* fall through */

/* Sum over 0 < j < n + 1 of a[j] b[k - j]. */
static inline double ps_part(const double *a, const double *b, int k, int n) {
  double s[2] = {0, 0};
  switch (n + 1) {
    PS_TERM(19) PS_TERM(18) PS_TERM(17) PS_TERM(16) PS_TERM(15) PS_TERM(14) PS_TERM(13)
    PS_TERM(12) PS_TERM(11) PS_TERM(10) PS_TERM(9) PS_TERM(8) PS_TERM(7) PS_TERM(6) PS_TERM(5)
    PS_TERM(4) PS_TERM(3) PS_TERM(2) PS_TERM(1)
    default: return s[0] + s[1];
  }
}

/* Sum over 0 < j < k of a[j] b[k - j]. */
static inline double ps_inner(const double *a, const double *b, int k) {
  return ps_part(a, b, k, k - 1);
}

/* Sum over 0 < j <= k of a[j] b[k - j]. */
static inline double ps_rest(const double *a, const double *b, int k) {
  return PS_FMA(a[k], b[0], ps_inner(a, b, k));
}

static inline double ps_mul(const double *a, const double *b, int k) {
  return PS_FMA(a[0], b[k], ps_rest(a, b, k));
}

/* Sum over 0 < j < k of a[j] a[k - j]. */
static inline double ps_square_inner(const double *a, int k) {
  double s = 2 * ps_part(a, a, k, (k - 1) / 2);
  return k & 1 ? s : PS_FMA(a[k / 2], a[k / 2], s);
}

static inline double ps_square(const double *a, int k) {
  return PS_FMA(2 * a[0], a[k], ps_square_inner(a, k));
}
