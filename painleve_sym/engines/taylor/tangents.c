/* Directions side by side, in which states are differentiated: as many as a vector register holds. */
typedef double ps_wide __attribute__((vector_size(8 * PS_WIDTH)));
typedef long long ps_wide_bits __attribute__((vector_size(8 * PS_WIDTH)));

#define PS_WIDE_OF(a) ((a) - (ps_wide){0})
#if !defined(__FMA__) || PS_WIDTH == 4 || PS_BUILTIN(__builtin_elementwise_fma)
#define PS_WIDE_FMA(a, b, c) PS_VECTOR_FMA(a, b, c)
#elif PS_WIDTH == 8 && PS_BUILTIN(__builtin_ia32_vfmaddpd512_mask)
#define PS_WIDE_FMA(a, b, c) __builtin_ia32_vfmaddpd512_mask(a, b, c, -1, 4)
#else
#define PS_WIDE_FMA(a, b, c) PS_FMA_OF(ps_wide, PS_WIDTH, a, b, c)
#endif

/* Left alone, gcc 12 loads a vector again for every product that it is a factor of. */
#if defined(__x86_64__)
#define PS_IN_REGISTER(a) __asm__("" : "+v"(a))
#else
#define PS_IN_REGISTER(a)
#endif

#define PS_GROUPS ((PS_DIRECTIONS + PS_WIDTH - 1) / PS_WIDTH)

/* Number of directions in group g: a constant where all groups are full. */
static inline int ps_grouped(int g) {
  const int rest = PS_DIRECTIONS % PS_WIDTH;
  return rest && g == PS_GROUPS - 1 ? rest : PS_WIDTH;
}

/* The part of group g of a row of derivatives, followed by zeros. */
__attribute__((unused)) static inline ps_wide ps_wide_at(const double *row, int g) {
  ps_wide a = {0};
  const int n = ps_grouped(g);
  row += g * PS_WIDTH;
  if (n == PS_WIDTH)
    __builtin_memcpy(&a, row, sizeof a);
  else
    for (int i = 0; i < n; i++) a[i] = row[i];
  return a;
}

__attribute__((unused)) static inline void ps_wide_to(double *row, ps_wide a, int g) {
  const int n = ps_grouped(g);
  row += g * PS_WIDTH;
  if (n == PS_WIDTH)
    __builtin_memcpy(row, &a, sizeof a);
  else
    for (int i = 0; i < n; i++) row[i] = a[i];
}
