/* What a page calls of the rigid contact problem of $mechanism, at the state of ${name}_motion.c.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) painleve-sym developers. */

#include "${name}_model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CALLED(name) __attribute__((export_name(#name)))

enum { GIVEN = $motion, EACH = 4 };

double *${name}_parameters_at(void);
double *${name}_state_at(void);
int ${name}_complete(double force);

static double numbers[64];

CALLED(contact_numbers_at) double *contact_numbers_at(void) { return numbers; }

/* Writes A[0], A[1], B, A_stick, B_stick, mu of a contact, the case, the number of solutions, and of
 * each: normal force, tangential force, slip direction, case. */
CALLED(contact_problem) void contact_problem(int contact) {
  const double *p = ${name}_parameters_at(), *x = ${name}_state_at();
  ${name}_coefficients c;
  ${name}_solutions s;
  ${name}_contact_coefficients(p, x, contact, &c);
  const int given = ${name}_solve(p, x, contact, &s);
  const double own[] = {c.A[0], c.A[1], c.B, c.A_stick, c.B_stick, c.mu, given, s.count};
  memcpy(numbers, own, sizeof own);
  double *rest = numbers + sizeof own / sizeof *own;
  for (int i = 0; i < s.count; i++) {
    *rest++ = s.normal_force[i];
    *rest++ = s.tangential_force[i];
    *rest++ = s.slip[i];
    *rest++ = s.mode[i];
  }
}

static void set_quantity(int i, double value) {
  if (i < GIVEN) ${name}_state_at()[i] = value;
  else ${name}_parameters_at()[i - GIVEN] = value;
}

/* Writes the map of one contact over quantities a and b, for slips along s: of each point the case,
 * A in push, B and A in pull, four numbers, nan outside of the domain; the case also where A + B is
 * not finite. b runs fastest. NULL without memory. */
CALLED(contact_map)
double *contact_map(int a, double a_0, double a_1, int n_a, int b, double b_0, double b_1, int n_b,
                    int contact, int s) {
  static double *grid;
  static int room;
  double state[${NAME}_STATES], parameters[${NAME}_PARAMETERS];
  double *x = ${name}_state_at(), *p = ${name}_parameters_at();
  memcpy(state, x, sizeof state);
  memcpy(parameters, p, sizeof parameters);
  if (EACH * n_a * n_b > room) {
    grid = (double *)realloc(grid, sizeof(double) * (size_t)(room = EACH * n_a * n_b));
    if (!grid) return grid;
  }
  double *point = grid;
  for (int i = 0; i < n_a; i++) {
    for (int j = 0; j < n_b; j++, point += EACH) {
      ${name}_coefficients c;
      memcpy(x, state, sizeof state);
      set_quantity(a, a_0 + (a_1 - a_0) * i / (n_a - 1));
      set_quantity(b, b_0 + (b_1 - b_0) * j / (n_b - 1));
      for (int k = 0; k < EACH; k++) point[k] = NAN;
      if ((${name}_complete(-1.0) & 4) == 0) continue;
      ${name}_contact_coefficients(p, x, contact, &c);
      point[1] = c.A[s > 0];
      point[2] = c.B;
      point[3] = c.A[s < 0];
      if (isfinite(point[1] + c.B)) point[0] = ${name}_case_in_slip(&c, contact, s);
    }
  }
  memcpy(x, state, sizeof state);
  memcpy(p, parameters, sizeof parameters);
  return grid;
}
