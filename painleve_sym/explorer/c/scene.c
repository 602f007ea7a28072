/* Places in the drawing of $mechanism, at the state and parameters of ${name}.c: the points of its
 * shapes, then place, normal and surface speed of its contacts; the functions of the surfaces that
 * are ground; and the margins of the domain.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) painleve-sym developers: the interface. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CASADI_CODEGEN_PREFIX
#define CODEGEN_PREFIX ${name}_scene_
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

$functions

#define CALLED(name) __attribute__((export_name(#name)))

enum { MOTION = $motion, OWN = $own, NUMBERS = $numbers, GROUNDS = $grounds, BOUNDS = $bounds };

double *${name}_parameters_at(void);
double *${name}_state_at(void);

static void call(int (*f)(const casadi_real **, casadi_real **, casadi_int *, casadi_real *, int),
                 const double *place, double *out) {
  double v[2 + MOTION + OWN], w[$work];
  const double *arg[1] = {v};
  double *res[1] = {out};
  casadi_int iw[8];
  memcpy(v, ${name}_state_at(), MOTION * sizeof(double));
  memcpy(v + MOTION, ${name}_parameters_at(), OWN * sizeof(double));
  memcpy(v + MOTION + OWN, place, 2 * sizeof(double));
  f(arg, res, iw, w, 0);
}

static const double nowhere[2] = {0, 0};

/* All places, in m, and speeds, in m/s. */
CALLED(scene) double *scene(void) {
  static double numbers[NUMBERS + 1];
  call(scene_places, nowhere, numbers);
  return numbers;
}

/* What is positive within the domain, bound by bound. */
CALLED(margins) double *margins(void) {
  static double numbers[BOUNDS + 1];
  call(scene_margins, nowhere, numbers);
  return numbers;
}

/* The functions of the grounds on a grid of n by n points, y fastest, all of them at each: zero on a
 * surface. NULL without memory. */
CALLED(surfaces)
double *surfaces(double left, double right, double low, double high, int n) {
  static double *grid;
  static int room;
  if (n * n * GROUNDS > room) {
    grid = (double *)realloc(grid, sizeof(double) * (size_t)(room = n * n * GROUNDS));
    if (!grid) return grid;
  }
  double *point = grid;
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++, point += GROUNDS) {
      const double place[2] = {left + (right - left) * i / (n - 1), low + (high - low) * j / (n - 1)};
      call(scene_surfaces, place, point);
    }
  }
  return grid;
}
