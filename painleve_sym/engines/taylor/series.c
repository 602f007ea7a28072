/* What the generated series are made of. */

typedef double ps_vector __attribute__((vector_size(32)));

/* Numbers that a vector register holds, and motions side by side. */
#if defined(__AVX512F__)
#define PS_WIDTH 8
#elif defined(__AVX__)
#define PS_WIDTH 4
#else
#define PS_WIDTH 2
#endif
#ifndef PS_LANES
#define PS_LANES PS_WIDTH
#endif
typedef double ps_lanes __attribute__((vector_size(8 * PS_LANES)));
typedef long long ps_mask __attribute__((vector_size(8 * PS_LANES)));
typedef unsigned long long ps_lane_bits __attribute__((vector_size(8 * PS_LANES)));

#define PS_EACH_LANE(statement) for (int l = 0; l < PS_LANES; l++) statement;
#define PS_SPREAD(a) ((a) - (ps_lanes){0})
#define PS_LANES_ABS(a) ((ps_lanes)((ps_mask)(a) & 0x7fffffffffffffffLL))
#define PS_LANES_CHOOSE(test, a, b) \
  ((ps_lanes)(((ps_mask)(a) & (test)) | ((ps_mask)(b) & ~(test))))

/* Part of the tolerance that the last term of a series may use: the terms left out add up to a few
 * times as much where a power ends, and so do the steps. */
static const double PS_SHARE = 0.05;

#ifdef __has_builtin
#define PS_BUILTIN(name) __has_builtin(name)
#else
#define PS_BUILTIN(name) 0
#endif

/* Fused where the processor fuses, in one instruction for all numbers of a vector. */
#if defined(__FMA__)
#define PS_FMA(a, b, c) __builtin_fma(a, b, c)
#else
#define PS_FMA(a, b, c) ((a) * (b) + (c))
#endif
#if !defined(__FMA__)
#define PS_VECTOR_FMA(a, b, c) ((a) * (b) + (c))
#elif PS_BUILTIN(__builtin_elementwise_fma)
#define PS_VECTOR_FMA(a, b, c) __builtin_elementwise_fma(a, b, c)
#elif PS_BUILTIN(__builtin_ia32_vfmaddpd256)
#define PS_VECTOR_FMA(a, b, c) __builtin_ia32_vfmaddpd256(a, b, c)
#else
#define PS_VECTOR_FMA(a, b, c) PS_FMA_OF(ps_vector, 4, a, b, c)
#endif
#if !defined(__FMA__) || PS_LANES == 4 || PS_BUILTIN(__builtin_elementwise_fma)
#define PS_LANES_FMA(a, b, c) PS_VECTOR_FMA(a, b, c)
#elif PS_LANES == 8 && PS_BUILTIN(__builtin_ia32_vfmaddpd512_mask)
/* All lanes (-1), rounded as everything else is (4). */
#define PS_LANES_FMA(a, b, c) __builtin_ia32_vfmaddpd512_mask(a, b, c, -1, 4)
#else
#define PS_LANES_FMA(a, b, c) PS_FMA_OF(ps_lanes, PS_LANES, a, b, c)
#endif
#define PS_FMA_OF(type, n, a, b, c)                                          \
  __extension__({                                                            \
    const type a_ = (a), b_ = (b);                                           \
    type c_ = (c);                                                           \
    for (int l_ = 0; l_ < n; l_++) c_[l_] = __builtin_fma(a_[l_], b_[l_], c_[l_]); \
    c_;                                                                      \
  })

typedef union {
  double number;
  unsigned long long bits;
} ps_word;

static inline unsigned long long bits_of(double number) {
  return ((ps_word){.number = number}).bits;
}

static inline double of_bits(unsigned long long bits) {
  return ((ps_word){.bits = bits}).number;
}

#define bits_of_lanes(a) ((ps_lane_bits)(a))
#define of_bits_lanes(bits) ((ps_lanes)(bits))

typedef struct {
  double sin, cos;
} ps_pair;
typedef struct {
  ps_lanes sin, cos;
} ps_pair_lanes;

/* Angles, in rad, whose reduction to a right angle is exact in angles.c. */
static const double PS_FARTHEST = 1e5;

/* Compiled once: a compiler may compute both together, with other last bits than one by one. */
__attribute__((noinline, unused)) static ps_pair far_sin_cos(double x) {
  ps_pair both = {sin(x), cos(x)};
  return both;
}

/* The base of a real power, or its floor where the power is left out. */
__attribute__((unused)) static inline double ps_ramp(double live, double x, double floor) {
  return live > 0 && x > floor ? x : floor;
}

/* 1/cosh^2, also where cosh has no digits left. */
__attribute__((unused)) static inline double ps_sech2(double x) {
  const double c = cosh(x);
  return 1 / (c * c);
}
