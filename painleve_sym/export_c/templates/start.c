/* $title
 *
 * From coordinates and velocities to a start state and its tolerances. Generated: the numbers of
 * the contact at a state. The rest is described in ${name}_model.h.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) painleve-sym developers: the event loop and the interface. */

#include "${name}_model.h"

#include <math.h>
#include <string.h>

#define CASADI_CODEGEN_PREFIX
#define CODEGEN_PREFIX ${name}_start_
#if defined(__GNUC__)
/* The generated functions all take the same arguments, and some do not need all of them. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

$functions

/* Coordinates and as many velocities; the mechanism's own parameters, which come first. */
enum { COORDINATES = $coordinates, OWN = $own_parameters };
/* Results of the generated function for each contact; mass_i is the diagonal of the mass matrix. */
enum { $number_names };
/* Contacts, and the states of each: gap, gap rate, slip velocity. */
enum { CONTACTS = $contact_count };
static const int PLACES[CONTACTS][3] = {$contact_states};

static void contact_numbers(const double *p, const double *x, double *numbers) {
  double v[$motion + OWN], w[$work];
  const double *arg[1] = {v};
  double *res[1] = {numbers};
  casadi_int iw[8];
  memcpy(v, x, $span * sizeof(double));
  memcpy(v + $motion, p, OWN * sizeof(double));
  quantities(arg, res, iw, w, 0);
}

/* The length by which coordinates and gap are measured. */
static double characteristic_length(const double *numbers) {
  double pull = fabs(numbers[NUMBER_b_n]);
  double height = 2 * numbers[NUMBER_kinetic_energy] * numbers[NUMBER_W_nn];
  if (numbers[NUMBER_length] > 0) return numbers[NUMBER_length];
  return pull > 0 && height > 0 ? height / pull : 1.0;
}

/* What the free contact forces would give to a motion over a length. */
static double gained_energy(const double *numbers, double length) {
  double normal = fabs(numbers[NUMBER_b_n]) / numbers[NUMBER_W_nn] * length;
  double tangential = 0.0;
  if (numbers[NUMBER_W_tt] > 0)
    tangential = fabs(numbers[NUMBER_b_t]) / numbers[NUMBER_W_tt] * length;
  if (!(normal > tangential)) normal = tangential;
  return normal > 0 ? normal : 1.0;
}

$complete

/* Stiffness and exponent of the loading curve of each contact, 0 where it is rigid. */
static void loading_curves(const double *p, double *curves) {
  double c[${NAME}_CONSTANTS], w[$work];
  const double *arg[1] = {c};
  double *res[1] = {curves};
  casadi_int iw[8];
  ${name}_constants(p, c);
  loading(arg, res, iw, w, 0);
}

/* Scales of gap and gap rate of one contact, and its energy: of a compliant one the compression
 * under the free normal force, that over the time of a contact, and the available energy. */
static void own_scales(const double *curve, const double *numbers, double x_gap, double *gap,
                       double *rate, double *energy) {
  const double k = curve[0], n = curve[1], kinetic = numbers[NUMBER_kinetic_energy];
  const double W_nn = numbers[NUMBER_W_nn], b_n = fabs(numbers[NUMBER_b_n]), force = b_n / W_nn;
  double depth = -x_gap > 0 ? -x_gap : 0.0, length = characteristic_length(numbers), delta, stored;
  double gained = gained_energy(numbers, length);
  if (n == 0) {
    *gap = length;
    *energy = kinetic > $at_rest * gained ? kinetic : gained; /* below: a motion from rest */
    *rate = sqrt(2 * *energy * W_nn);
    return;
  }
  stored = k * pow(depth, n + 1) / (n + 1);
  if (force > 0)
    delta = pow(force / k, 1 / n);
  else /* nothing presses: a hundredth of what the available energy can compress */
    delta = 0.01 * pow((n + 1) * (kinetic + stored) / k, 1 / (n + 1));
  *energy = kinetic + stored + force * delta;
  if (*energy == 0) { /* nothing moves and nothing pushes */
    delta = length;
    *energy = gained;
  }
  *rate = force > 0 ? sqrt(delta * b_n) : 0.01 * sqrt(2 * *energy * W_nn);
  *gap = delta;
}

/* Scales of gap and gap rate of each contact, of several all with the largest energy of any. Where
 * hardly anything presses one of them, it is hit yet by what presses the others: its free
 * acceleration counts as a hundredth of theirs at least. */
static void scales(const double *p, const double *x, const double *numbers, double *gap,
                   double *rate, double *energy) {
  double curves[2 * CONTACTS], pressed[CONTACTS * NUMBERS], least = 0, own, largest = 0;
  loading_curves(p, curves);
  if (CONTACTS == 1) {
    own_scales(curves, numbers, x[PLACES[0][0]], gap, rate, energy);
    return;
  }
  memcpy(pressed, numbers, sizeof pressed);
  for (int i = 0; i < CONTACTS; i++) least = fmax(least, fabs(numbers[i * NUMBERS + NUMBER_b_n]));
  least = 0.01 * least;
  for (int i = 0; i < CONTACTS; i++) {
    double *f = pressed + i * NUMBERS, x_gap = x[PLACES[i][0]];
    f[NUMBER_b_n] = fmax(fabs(f[NUMBER_b_n]), least);
    own_scales(curves + 2 * i, f, x_gap, &gap[i], &rate[i], &own);
    if (f[NUMBER_kinetic_energy] > 0 || f[NUMBER_b_n] != 0 || x_gap < 0)
      largest = fmax(largest, own);
  }
  *energy = largest > 0 ? largest : 1.0;
  for (int i = 0; i < CONTACTS; i++) {
    pressed[i * NUMBERS + NUMBER_kinetic_energy] = *energy;
    own_scales(curves + 2 * i, pressed + i * NUMBERS, x[PLACES[i][0]], &gap[i], &rate[i],
               &own);
  }
}
$press
void ${name}_tolerances(const double *p, const double *x, double rtol, double *atol) {
  static const unsigned char in_metres[COORDINATES] = {$in_metres};
  double numbers[CONTACTS * NUMBERS], gap[CONTACTS], rate[CONTACTS], energy, length;
  contact_numbers(p, x, numbers);
  scales(p, x, numbers, gap, rate, &energy);
  length = characteristic_length(numbers);
  for (int i = 0; i < ${NAME}_STATES; i++) atol[i] = HUGE_VAL;
  for (int i = 0; i < COORDINATES; i++) {
    atol[i] = in_metres[i] ? length : 1.0;
    atol[COORDINATES + i] = sqrt(2 * energy / numbers[NUMBER_mass_0 + i]);
  }
$clock  for (int i = 0; i < CONTACTS; i++) {
    const double *f = numbers + i * NUMBERS, slip = sqrt(2 * energy * f[NUMBER_W_tt]);
    atol[PLACES[i][2]] = slip != 0 ? slip : sqrt(2 * energy * f[NUMBER_W_nn]);
    atol[PLACES[i][0]] = gap[i];
    atol[PLACES[i][1]] = rate[i];
  }
  for (int i = 0; i < ${NAME}_STATES; i++) atol[i] *= rtol;
}

void ${name}_default_options(const double *p, const double *x, double t_end, double rtol,
                     ${name}_options *o) {
  memset(o, 0, sizeof *o);
  o->t_end = t_end;
  o->rtol = rtol;
  ${name}_tolerances(p, x, rtol, o->atol);
  o->max_steps = $max_steps;
  o->max_events = $max_events;
}
