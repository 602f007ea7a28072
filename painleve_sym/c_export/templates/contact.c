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
enum { SLIP_VELOCITY, A_STICK, B_STICK, EACH };
/* The parameter that is the friction coefficient of a contact; how many signs its normal force may
 * have, 2 where it holds from both sides; the state that is its slip velocity. */
static const int FRICTION[${NAME}_CONTACTS] = {$friction};
static const int SIDES[${NAME}_CONTACTS] = {$sides};
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
  for (int i = 0; i < ${NAME}_CONTACTS; i++) mu[i] = p[FRICTION[i]];
}

/* a - b; 0 where that is within the rounding of a and b: its sign would be an accident. */
static double rounded_difference(double a, double b) {
  const double value = a - b;
  return fabs(value) <= $rounding * (fabs(a) + fabs(b)) ? 0.0 : value;
}

void ${name}_contact_coefficients(const double *p, const double *x, int contact,
                     ${name}_coefficients *c) {
  double all[FIRST + EACH * ${NAME}_CONTACTS];
  const int n = PS_N(contact), t = PS_T(contact, 0);
  const double *W = all, *b = all + ROWS * ROWS;
  const double *own = all + FIRST + EACH * contact;
  evaluate_contacts(p, x, all);
  c->mu = p[FRICTION[contact]];
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

/* Part of the terms below which a coefficient in sticking, or a difference of rates, is zero: W has
 * rank one then, but for rounding. */
#define ALMOST 1e-12

/* Solutions as they are added. */
typedef struct {
  ${name}_solutions *list;
  double a_t[6];  /* of each */
  double size[6]; /* of its terms */
  int moves;      /* whether motions form a continuum */
  int open;       /* whether one motion leaves its forces open */
} ps_forces;

static void add_force(ps_forces *f, const ${name}_coefficients *c, double F_n, double F_t, int slip,
                      int mode) {
  ${name}_solutions *list = f->list;
  const int k = list->count++;
  list->normal_force[k] = F_n;
  list->tangential_force[k] = F_t;
  list->slip[k] = slip;
  list->mode[k] = mode;
  f->a_t[k] = c->W_nt * F_n + c->W_tt * F_t + c->b_t;
  f->size[k] = fabs(c->W_nt * F_n) + fabs(c->W_tt * F_t) + fabs(c->b_t);
}

/* Adds F_n of the sign `side` with A F_n + B = 0, in slip along s; from rest only where a_t drives
 * the slip along s. */
static void add_slip(ps_forces *f, const ${name}_coefficients *c, int s, int side, int rests) {
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
    const double a_t = rounded_difference(c->W_nt * force + c->b_t, -c->W_tt * F_t);
    if (!rests || s * a_t > 0) add_force(f, c, force, F_t, s, ${name}_case_slip);
  }
}

/* Adds the shortest of the forces of the sign `side` in sticking where W has rank one, whose other
 * forces have the same motion. */
static void add_open_stick(ps_forces *f, const ${name}_coefficients *c, int side) {
  const double b = side * c->b_t, W_nt = c->W_nt, reach = c->mu * c->W_tt;
  double low = 0, high = INFINITY;
  if (c->W_tt <= 0) {
    if (c->b_t != 0 || c->W_nn <= 0 || -c->b_n * side / c->W_nn <= 0) return;
    add_force(f, c, -c->b_n / c->W_nn, 0.0, 0, ${name}_case_stick);
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
  if (F > 0) add_force(f, c, side * F, -(c->b_t + W_nt * side * F) / c->W_tt, 0, ${name}_case_stick);
  f->open |= high > low;
}

/* Adds F_n of the sign `side` in sticking. */
static void add_stick(ps_forces *f, const ${name}_coefficients *c, int side) {
  const double free = c->W_tt > 0 ? fabs(c->W_nt * c->b_t / c->W_tt) : 0.0;
  if (c->W_tt <= 0 || fabs(c->A_stick) <= ALMOST * c->W_nn) {
    if (c->W_tt <= 0 || fabs(c->B_stick) <= ALMOST * (fabs(c->b_n) + free)) add_open_stick(f, c, side);
    return;
  }
  const double force = -c->B_stick / c->A_stick;
  const double F_t = -(c->b_t + c->W_nt * force) / c->W_tt;
  if (c->A_stick > 0 && side * force > 0 && rounded_difference(fabs(F_t), c->mu * fabs(force)) <= 0)
    add_force(f, c, force, F_t, 0, ${name}_case_stick);
}

/* Writes the solutions in slip along `direction`, 0 at rest, and returns the case. */
static int solve(const ${name}_coefficients *c, int sides, int direction,
                 ${name}_solutions *solutions) {
  const int opens = sides == 1;
  ps_forces f = {solutions, {0}, {0}, 0, 0};
  memset(solutions, 0, sizeof *solutions);
  /* No force: the contact opens, or one that cannot moves on. */
  const int way = direction ? direction : (c->b_t > 0) - (c->b_t < 0);
  const int held = way ? ${name}_case_slip : ${name}_case_stick;
  if (c->B == 0 || (opens && c->B > 0))
    add_force(&f, c, 0.0, 0.0, opens ? direction : way, opens ? ${name}_case_liftoff : held);
  for (int side = 1; side > -sides; side -= 2) {
    for (int s = -1; s <= 1; s += 2)
      if (s * direction >= 0) add_slip(&f, c, s, side, !direction);
    if (!direction) add_stick(&f, c, side);
  }
  if (f.moves) return ${name}_case_indeterminate;
  if (solutions->count == 0) return ${name}_case_inconsistent;
  for (int k = 1; k < solutions->count; k++) {
    const int opened = k && solutions->mode[0] == ${name}_case_liftoff && c->B > 0;
    if (opened || fabs(f.a_t[k] - f.a_t[0]) > ALMOST * (f.size[k] + f.size[0]))
      return ${name}_case_indeterminate;
  }
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
