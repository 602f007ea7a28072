/* What the generated series are made of. */

typedef double ps_vector __attribute__((vector_size(32)));

#if defined(__FMA__)
#define PS_FMA(a, b, c) __builtin_fma(a, b, c)
#else
#define PS_FMA(a, b, c) ((a) * (b) + (c))
#endif
#if defined(__FMA__) && defined(__AVX__) && !defined(__clang__)
#define PS_VECTOR_FMA(a, b, c) __builtin_ia32_vfmaddpd256(a, b, c)
#else
#define PS_VECTOR_FMA(a, b, c) ((a) * (b) + (c))
#endif
