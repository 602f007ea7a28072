/* Places in the drawing of $mechanism, at the state and parameters of ${name}.c: the points of its
 * shapes, then place and normal of its contacts; and the functions of the surfaces.
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

enum { MOTION = $motion, OWN = $own, NUMBERS = $numbers, CONTACTS = $contacts };

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

/* All places, in m. */
CALLED(scene) double *scene(void) {
  static double numbers[NUMBERS + 1];
  const double nowhere[2] = {0, 0};
  call(scene_places, nowhere, numbers);
  return numbers;
}

/* The surfaces' functions on a grid of n by n points, y fastest, all contacts at each: zero on a
 * surface. NULL without memory. */
CALLED(surfaces)
double *surfaces(double left, double right, double low, double high, int n) {
  static double *grid;
  static int room;
  if (n * n * CONTACTS > room) {
    grid = (double *)realloc(grid, sizeof(double) * (size_t)(room = n * n * CONTACTS));
    if (!grid) return grid;
  }
  double *point = grid;
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++, point += CONTACTS) {
      const double place[2] = {left + (right - left) * i / (n - 1), low + (high - low) * j / (n - 1)};
      call(scene_surfaces, place, point);
    }
  }
  return grid;
}
