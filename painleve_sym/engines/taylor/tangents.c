/* Directions side by side, in which states are differentiated: as many as a vector register holds. */
typedef double ps_wide __attribute__((vector_size(8 * PS_WIDTH)));

#define PS_WIDE_OF(a) ((a) - (ps_wide){0})
#if !defined(__FMA__) || PS_WIDTH == 4 || PS_BUILTIN(__builtin_elementwise_fma)
#define PS_WIDE_FMA(a, b, c) PS_VECTOR_FMA(a, b, c)
#elif PS_WIDTH == 8 && PS_BUILTIN(__builtin_ia32_vfmaddpd512_mask)
#define PS_WIDE_FMA(a, b, c) __builtin_ia32_vfmaddpd512_mask(a, b, c, -1, 4)
#else
#define PS_WIDE_FMA(a, b, c) PS_FMA_OF(ps_wide, PS_WIDTH, a, b, c)
#endif

/* Directions of the vector whose first one is given: a constant where all vectors are full. */
#define PS_DIRECTIONS_FROM(first) \
  (PS_DIRECTIONS % PS_WIDTH == 0 ? PS_WIDTH : PS_MIN(PS_DIRECTIONS - (first), PS_WIDTH))

/* The n numbers at `at`, and zeros. */
__attribute__((unused)) static inline ps_wide ps_wide_at(const double *at, int n) {
  ps_wide a = {0};
  if (n == PS_WIDTH)
    memcpy(&a, at, sizeof a);
  else
    for (int i = 0; i < n; i++) a[i] = at[i];
  return a;
}

__attribute__((unused)) static inline void ps_wide_to(double *at, ps_wide a, int n) {
  if (n == PS_WIDTH)
    memcpy(at, &a, sizeof a);
  else
    for (int i = 0; i < n; i++) at[i] = a[i];
}
