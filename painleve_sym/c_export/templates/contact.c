/* $title
 *
 * The rigid contact problem at a state: mobility, free accelerations, A and B, and the case of one
 * contact. Generated: the numbers. The rest is described in ${name}_model.h.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) painleve-sym developers: the interface. */

#include "${name}_model.h"

#include <math.h>
#include <string.h>

#define CASADI_CODEGEN_PREFIX
#define CODEGEN_PREFIX ${name}_contact_
#if defined(__GNUC__)
/* The generated functions all take the same arguments, and some do not need all of them. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

$rows
$functions

/* Coordinates, velocities and a clock; the mechanism's own parameters, which come first. */
enum { MOTION = $motion, OWN = $own };
/* What is generated: W, row by row, b, then these for each contact. */
enum { ROWS = PS_SIZE(${NAME}_CONTACTS), FIRST = ROWS * ROWS + ROWS };
enum { SLIP_VELOCITY, A_STICK, B_STICK, ${own_friction}EACH };
/* ${of_friction}how many signs its normal force may
 * have, 2 where it holds from both sides; the state that is its slip velocity. */
${friction}static const int SIDES[${NAME}_CONTACTS] = {$sides};
static const int SLIP_STATE[${NAME}_CONTACTS] = {$slip_states};

static void evaluate_contacts(const double *p, const double *x, double *out) {
  double v[MOTION + OWN], w[$work];
  const double *arg[1] = {v};
  double *res[1] = {out};
  casadi_int iw[8];
  memcpy(v, x, MOTION * sizeof(double));
  memcpy(v + MOTION, p, OWN * sizeof(double));
  contact_formulas(arg, res, iw, w, 0);
}

void ${name}_contact_problem(const double *p, const double *x, double *W, double *b, double *mu) {
  double all[FIRST + EACH * ${NAME}_CONTACTS];
  evaluate_contacts(p, x, all);
  memcpy(W, all, ROWS * ROWS * sizeof(double));
  memcpy(b, all + ROWS * ROWS, ROWS * sizeof(double));
  for (int i = 0; i < ${NAME}_CONTACTS; i++) mu[i] = $each_friction;
}

/* As in problem/law.py. Of the terms of a rate: what rounding leaves of a zero. Of its scale: what counts
 * as zero, and what may be missing to its right sign. Of two rates or forces: nearer ones are one. Of
 * the larger of terms and b, in the scale. Rounding of forces that could be all of b. */
static const double ROUNDING = $rounding, ZERO = $zero, SIGN = $sign, EQUAL = $equal,
                    LEAST_OF_LARGER = $least_of_larger, INFINITE = $infinite, EPSILON = $epsilon;
/* Of W_nn: less is left of it in sticking where W has rank one. Of b: what may be missing to its range. */
static const double RANK_ONE = $rank_one, RANGE = $range;

/* a - b; 0 where that is within the rounding of a and b: its sign would be an accident. */
static double rounded_difference(double a, double b) {
  const double value = a - b;
  return fabs(value) <= ROUNDING * (fabs(a) + fabs(b)) ? 0.0 : value;
}

void ${name}_contact_coefficients(const double *p, const double *x, int contact,
                     ${name}_coefficients *c) {
  double all[FIRST + EACH * ${NAME}_CONTACTS];
  const int n = PS_N(contact), t = PS_T(contact, 0);
  const double *W = all, *b = all + ROWS * ROWS;
  const double *own = all + FIRST + EACH * contact;
  evaluate_contacts(p, x, all);
  c->mu = $contact_friction;
  c->W_nn = W[n * ROWS + n];
  c->W_nt = W[n * ROWS + t];
  c->W_tt = W[t * ROWS + t];
  c->b_n = b[n];
  c->b_t = b[t];
  for (int i = 0; i < 2; i++) c->A[i] = rounded_difference(c->W_nn, (i ? 1 : -1) * c->mu * c->W_nt);
  c->B = c->b_n;
  c->A_stick = own[A_STICK];
  c->B_stick = own[B_STICK];
}

/* Solutions as they are added, with their rates along n and t, and the terms of these. */
typedef struct {
  const ${name}_coefficients *c;
  ${name}_solutions *list;
  double rate[6][2], terms[6][2];
  double b[2], beta[2]; /* of each row, and the largest that W couples with it */
  int moves;            /* whether motions form a continuum */
  int open;             /* whether one motion leaves its forces open */
} ps_forces;

static void begin(ps_forces *f, const ${name}_coefficients *c, ${name}_solutions *list) {
  const double unit = c->W_nn > 0 && c->W_tt > 0 ? sqrt(c->W_tt / c->W_nn) : 1.0;
  memset(f, 0, sizeof *f);
  memset(list, 0, sizeof *list);
  f->c = c;
  f->list = list;
  f->b[0] = f->beta[0] = fabs(c->b_n);
  f->b[1] = f->beta[1] = fabs(c->b_t);
  if (c->W_nt == 0) return;
  f->beta[0] = fmax(f->b[0], f->b[1] / unit);
  f->beta[1] = fmax(f->b[1], f->b[0] * unit);
}

/* What a rate is compared with. */
static double scale_of(const ps_forces *f, int row, double terms) {
  const double beta = f->beta[row];
  return beta > 0 ? fmin(terms, beta) + LEAST_OF_LARGER * fmax(terms, beta) : terms;
}

/* Whether a rate has no wrong sign. */
static int is_not_negative(const ps_forces *f, int row, double rate, double terms) {
  return -rate <= SIGN * scale_of(f, row, terms) + 4 * EPSILON * terms;
}

static void measure(const ps_forces *f, double F_n, double F_t, double *rate, double *terms) {
  const ${name}_coefficients *c = f->c;
  rate[0] = c->W_nn * F_n + c->W_nt * F_t + c->b_n;
  rate[1] = c->W_nt * F_n + c->W_tt * F_t + c->b_t;
  terms[0] = fabs(c->W_nn * F_n) + fabs(c->W_nt * F_t) + f->b[0];
  terms[1] = fabs(c->W_nt * F_n) + fabs(c->W_tt * F_t) + f->b[1];
}

/* Whether the first rates, which have to vanish, do, by forces that are not the rounding of infinite ones. */
static int vanish(const ps_forces *f, int rows, const double *rate, const double *terms) {
  double moved[2] = {0}, largest[2] = {0};
  for (int i = 0; i < rows; i++) {
    const int group = f->c->W_nt == 0 ? i : 0;
    if (fabs(rate[i]) > ZERO * scale_of(f, i, terms[i])) return 0;
    moved[group] = fmax(moved[group], terms[i] - f->b[i]);
    largest[group] = fmax(largest[group], f->b[i]);
  }
  for (int i = 0; i < 2; i++)
    if (largest[i] > 0 && INFINITE * moved[i] > largest[i]) return 0;
  return 1;
}

/* Whether solutions k and j have one motion. */
static int same_motion(const ps_forces *f, int k, int j) {
  for (int i = 0; i < 2; i++) {
    const double a = f->rate[k][i], other = f->rate[j][i], terms = fmax(f->terms[k][i], f->terms[j][i]);
    double rounding = 10 * ROUNDING * terms;
    if (f->beta[i] > 0) rounding = fmin(rounding, ZERO * f->beta[i] + ROUNDING * terms);
    if (fabs(a - other) >
        EQUAL * fmax(fmax(fabs(a), fabs(other)), f->b[i]) + rounding + 2 * EPSILON * f->beta[i])
      return 0;
  }
  return 1;
}

/* Whether forces that differ by these are one, by the terms of the rates. */
static int same_force(const ps_forces *f, double n, double t, const double *terms) {
  const ${name}_coefficients *c = f->c;
  return fabs(c->W_nn * n) + fabs(c->W_nt * t) <= EQUAL * scale_of(f, 0, terms[0]) &&
         fabs(c->W_nt * n) + fabs(c->W_tt * t) <= EQUAL * scale_of(f, 1, terms[1]) &&
         (n == 0 || c->W_nn > 0) && (t == 0 || c->W_tt > 0);
}

/* Adds forces of which `rows` rates vanish; of those that are there already none. */
static void add_force(ps_forces *f, double F_n, double F_t, int slip, int mode, int rows) {
  ${name}_solutions *list = f->list;
  const int k = list->count;
  measure(f, F_n, F_t, f->rate[k], f->terms[k]);
  if (!vanish(f, rows, f->rate[k], f->terms[k])) return;
  for (int j = 0; j < k; j++)
    if (same_force(f, F_n - list->normal_force[j], F_t - list->tangential_force[j], f->terms[k])) return;
  list->count++;
  list->normal_force[k] = F_n;
  list->tangential_force[k] = F_t;
  list->slip[k] = slip;
  list->mode[k] = mode;
}

/* Adds F_n of the sign `side` with A F_n + B = 0, in slip along s; from rest only where a_t drives
 * the slip along s. A rate of 0 is sticking; without friction its sign alone is the direction. */
static void add_slip(ps_forces *f, int s, int side, int rests) {
  const ${name}_coefficients *c = f->c;
  const double A = c->A[s * side > 0], force = -c->B / A;
  if (A == 0) {
    if (c->B != 0) return;
    /* Any force: another motion each, but where none moves the tangent. */
    const double rate = rounded_difference(c->W_nt, s * side * c->mu * c->W_tt);
    if (!rests)
      *(rate != 0 ? &f->moves : &f->open) = 1;
    else if (rate != 0 ? s * c->b_t > 0 : s * c->b_t >= 0)
      *(rate != 0 ? &f->moves : &f->open) = 1;
  } else if (force * side > 0) {
    const double F_t = -s * c->mu * fabs(force);
    double rate[2], terms[2];
    measure(f, force, F_t, rate, terms);
    const int sign = (rate[1] > 0) - (rate[1] < 0);
    const int way = !rests ? s : fabs(rate[1]) <= ROUNDING * terms[1] ? 0 : c->mu > 0 ? s : sign;
    if (rests && c->mu > 0 && !is_not_negative(f, 1, s * rate[1], terms[1])) return;
    add_force(f, force, F_t, way, way ? ${name}_case_slip : ${name}_case_stick, 1);
  }
}

/* Adds the shortest of the forces of the sign `side` in sticking where W has rank one, whose other
 * forces have the same motion. */
static void add_open_stick(ps_forces *f, int side) {
  const ${name}_coefficients *c = f->c;
  const double b = side * c->b_t, W_nt = c->W_nt, reach = c->mu * c->W_tt;
  double low = 0, high = INFINITY;
  if (c->W_tt <= 0) {
    if (c->b_t != 0 || c->W_nn <= 0 || -c->b_n * side / c->W_nn <= 0) return;
    add_force(f, -c->b_n / c->W_nn, 0.0, 0, ${name}_case_stick, 2);
    f->open |= c->mu > 0;
    return;
  }
  /* |b + W_nt F| <= mu W_tt F for F = |F_n|, and F_t = -(b_t + W_nt F_n)/W_tt. */
  const double slopes[2] = {reach + W_nt, reach - W_nt}, levels[2] = {b, -b};
  for (int k = 0; k < 2; k++) {
    const double slope = rounded_difference(k ? reach : W_nt, k ? W_nt : -reach);
    const double end = -levels[k] / slopes[k];
    if (slope > 0) low = fmax(low, end);
    if (slope < 0) high = fmin(high, end);
    if (slope == 0 && levels[k] < 0) return;
  }
  if (low > high || high <= 0) return;
  const double least = W_nt != 0 ? -b / (2 * W_nt) : 0.0, F = fmin(fmax(least, low), high);
  if (F > 0)
    add_force(f, side * F, -(c->b_t + W_nt * side * F) / c->W_tt, 0, ${name}_case_stick, 2);
  f->open |= high > low;
}

/* Adds F_n of the sign `side` in sticking. */
static void add_stick(ps_forces *f, int side) {
  const ${name}_coefficients *c = f->c;
  const double free = c->W_tt > 0 ? fabs(c->W_nt * c->b_t / c->W_tt) : 0.0;
  if (c->W_tt <= 0 || fabs(c->A_stick) <= RANK_ONE * c->W_nn) {
    if (c->W_tt <= 0 || fabs(c->B_stick) <= RANGE * (fabs(c->b_n) + free)) add_open_stick(f, side);
    return;
  }
  const double force = -c->B_stick / c->A_stick, limit = c->mu * fabs(force);
  const double F_t = -(c->b_t + c->W_nt * force) / c->W_tt;
  /* Beyond the cone it sticks only where that makes no rate. */
  if (c->A_stick > 0 && side * force > 0)
    add_force(f, force, fmin(fmax(F_t, -limit), limit), 0, ${name}_case_stick, 2);
}

/* Adds no force: the contact opens, or one that cannot moves on. */
static void add_none(ps_forces *f, int opens, int direction) {
  const ${name}_coefficients *c = f->c;
  const int way = direction ? direction : (c->b_t > 0) - (c->b_t < 0);
  const int held = way ? ${name}_case_slip : ${name}_case_stick;
  if (!opens) add_force(f, 0.0, 0.0, way, held, 1);
  else if (is_not_negative(f, 0, c->b_n, f->b[0]))
    add_force(f, 0.0, 0.0, direction, ${name}_case_liftoff, 0);
}

/* Writes the solutions in slip along `direction`, 0 at rest, and returns the case. */
static int solve(const ${name}_coefficients *c, int sides, int direction,
                 ${name}_solutions *solutions) {
  ps_forces f;
  begin(&f, c, solutions);
  add_none(&f, sides == 1, direction);
  for (int side = 1; side > -sides; side -= 2) {
    for (int s = -1; s <= 1; s += 2)
      if (s * direction >= 0) add_slip(&f, s, side, !direction);
    if (!direction && c->mu > 0) add_stick(&f, side);
  }
  if (f.moves) return ${name}_case_indeterminate;
  if (solutions->count == 0) return ${name}_case_inconsistent;
  for (int k = 1; k < solutions->count; k++)
    if (!same_motion(&f, k, 0)) return ${name}_case_indeterminate;
  return f.open || solutions->count > 1 ? ${name}_case_hyperstatic : solutions->mode[0];
}

int ${name}_solve(const double *p, const double *x, int contact, ${name}_solutions *solutions) {
  const double v_t = x[SLIP_STATE[contact]];
  ${name}_coefficients c;
  ${name}_contact_coefficients(p, x, contact, &c);
  return solve(&c, SIDES[contact], (v_t > 0) - (v_t < 0), solutions);
}

int ${name}_case_in_slip(const ${name}_coefficients *coefficients, int contact, int s) {
  ${name}_solutions solutions;
  return solve(coefficients, SIDES[contact], s, &solutions);
}

int ${name}_classify(const double *p, const double *x, int contact) {
  ${name}_solutions solutions;
  return ${name}_solve(p, x, contact, &solutions);
}
