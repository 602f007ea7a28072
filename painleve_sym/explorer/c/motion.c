/* $title
 *
 * What a page calls: buffers for parameters, state and numbers, and one run that is kept. Every
 * function writes its answer to the buffer of numbers. The motion itself is ${name}_model.c.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) painleve-sym developers. */

#include "${name}_model.c"

#define CALLED(name) __attribute__((export_name(#name)))

enum { MEMORY_ROOM = PS_NZ + 1, NUMBERS = 16 + 2 * PS_NX + 2 * MEMORY_ROOM + PS_NO };

static double parameters[PS_NP + 1], state[PS_NX], numbers[NUMBERS];
static ${name}_run *run;

CALLED(${name}_parameters_at) double *${name}_parameters_at(void) { return parameters; }
CALLED(${name}_state_at) double *${name}_state_at(void) { return state; }
CALLED(${name}_numbers_at) double *${name}_numbers_at(void) { return numbers; }

static double *put(double *to, const double *from, int count) {
  memcpy(to, from, sizeof(double) * (size_t)count);
  return to + count;
}

/* Completes the state from its coordinates and velocities, pressed with `force` (negative: not
 * pressed). Bits of what admits it: 1 the law, 2 finite numbers, 4 the domain. */
CALLED(${name}_complete) int ${name}_complete(double force) {
  double given[PS_GIVEN], admits[PS_ADMITS];
  memcpy(given, state, sizeof given);
  ps_start(parameters, given, &force, state, admits);
  int bits = 0;
  for (int i = 0; i < PS_ADMITS; i++) bits |= (admits[i] != 0) << i;
  return bits;
}

/* Follows the motion from the state. `until` has a bit for each kind of event that ends it. The
 * number of events, or -1 without memory; writes time, stop reason, mode, steps, state, memory and
 * outputs at the end. */
CALLED(${name}_follow)
int ${name}_follow(double t_end, double rtol, int max_steps, int max_events, int until, int keep) {
  ${name}_options options;
  ${name}_default_options(parameters, state, t_end, rtol, &options);
  options.max_steps = max_steps;
  options.max_events = max_events;
  options.keep_steps = keep;
  for (int i = 0; i < PS_NKIND; i++) options.until[i] = until >> i & 1;
  ${name}_free(run);
  run = ${name}_simulate(parameters, state, &options);
  if (!run) return -1;
  numbers[0] = run->time;
  numbers[1] = run->stop;
  numbers[2] = run->mode;
  numbers[3] = (double)run->step_count;
  double *rest = put(numbers + 4, run->state, PS_NX);
  rest = put(rest, run->memory, PS_NZ);
  put(rest, run->outputs, PS_NO);
  return (int)run->event_count;
}

/* Writes event i: time, kind, modes before and after, contact, states before and after, outputs
 * before, memory after. */
CALLED(${name}_event) void ${name}_read_event(int i) {
  const ${name}_event *e = run->events + i;
  numbers[0] = e->time;
  numbers[1] = e->kind;
  numbers[2] = e->mode_before;
  numbers[3] = e->mode_after;
  numbers[4] = $event_contact;
  double *rest = put(numbers + 5, e->before, PS_NX);
  rest = put(rest, e->after, PS_NX);
  rest = put(rest, e->outputs, PS_NO);
  $event_memory
}

static const double *step_at(double t) {
  long low = 0, high = run->step_count;
  while (high - low > 1) {
    const long middle = low + (high - low) / 2;
    if (run->steps[middle * run->step_width] <= t) low = middle;
    else high = middle;
  }
  return run->steps + low * run->step_width;
}

/* Writes time, mode, state, memory and outputs at a time; 0 outside the run. */
CALLED(${name}_at_time) int ${name}_at_time(double t) {
  double x[PS_NX];
  if (!run || !${name}_at(run, t, x)) return 0;
  const double *step = step_at(t);
  const int mode = (int)step[2];
  numbers[0] = t;
  numbers[1] = mode;
  double *rest = put(numbers + 2, x, PS_NX);
  rest = put(rest, step + PS_STEP_HEAD, PS_NZ);
  ${name}_outputs(parameters, mode, x, step + PS_STEP_HEAD, rest);
  return 1;
}

/* Writes the scales of the states at the start, below which only absolute errors count. */
CALLED(${name}_scales) void ${name}_write_scales(void) { ps_scales(parameters, state, numbers); }

/* The time at which step i begins. */
CALLED(${name}_step_time) double ${name}_step_time(int i) {
  return run->steps[i * run->step_width];
}

/* The largest change of the sum of all energies over the ends of the steps, in parts of the largest
 * term, the potential energy counted from the start; infinite where one is not finite. */
CALLED(${name}_energy_residual) double ${name}_energy_residual(void) {
  static const int of_output[] = {$energies}, of_state[] = {$dissipations};
  enum { ENERGIES = sizeof of_output / sizeof(int), TERMS = ENERGIES + sizeof of_state / sizeof(int) };
  double first[TERMS], size[TERMS] = {0}, whole[TERMS] = {0}, start = 0, change = 0, rounding = 0;
  for (long i = 0; i <= run->step_count; i++) {
    const double *row = run->steps + i * run->step_width;
    const int end = i == run->step_count;
    const double *z = end ? run->memory : row + PS_STEP_HEAD, *x = end ? run->state : z + PS_NZ;
    double outputs[PS_NO], total = 0;
    ${name}_outputs(parameters, end ? run->mode : (int)row[2], x, z, outputs);
    for (int k = 0; k < TERMS; k++) {
      const double term = k < ENERGIES ? outputs[of_output[k]] : x[of_state[k - ENERGIES]];
      if (!i) first[k] = k < ENERGIES && of_output[k] == $potential ? term : 0;
      whole[k] = fmax(whole[k], fabs(term));
      size[k] = fmax(size[k], fabs(term - first[k]));
      total += term;
    }
    if (!i) start = total;
    if (!isfinite(total)) return HUGE_VAL;
    change = fmax(change, fabs(total - start));
  }
  for (int k = 0; k < TERMS; k++) {
    rounding += $rounding * whole[k];
    size[0] = fmax(size[0], size[k]);
  }
  return size[0] > rounding ? change / size[0] : 0;
}

/* Sets quantity i: a coordinate, velocity or the clock, or after these a parameter. */
static void set_quantity(double *x, int i, double value) {
  if (i < PS_GIVEN) x[i] = value;
  else parameters[i - PS_GIVEN] = value;
}

/* Runs from `count` starts, quantity a from first to last, b held: how each ends. -1: not admitted;
 * kind: the first event of the kinds in `until`; 100 + mode: none until t_end; 200 + stop reason. */
CALLED(${name}_outcomes)
double *${name}_outcomes(int a, double first, double last, int count, int b, double held,
                         double force, double t_end, double rtol, int max_steps, int until) {
  static double *row;
  static int room;
  double kept[PS_NX], own[PS_NP + 1];
  if (count > room) {
    row = (double *)realloc(row, sizeof(double) * (size_t)(room = count));
    if (!row) return row;
  }
  ${name}_run *shown = run; /* the page still reads it */
  run = NULL;
  memcpy(kept, state, sizeof kept);
  memcpy(own, parameters, sizeof own);
  for (int i = 0; i < count; i++) {
    memcpy(state, kept, sizeof kept);
    set_quantity(state, b, held);
    set_quantity(state, a, first + (last - first) * i / (count > 1 ? count - 1 : 1));
    row[i] = -1;
    if (${name}_complete(force) != 7) continue;
    const int events = ${name}_follow(t_end, rtol, max_steps, max_steps, until, 0);
    if (events < 0) row[i] = 200 + ${name}_stop_no_mode;
    else if (run->stop == ${name}_stop_until) {
      /* Others may follow at the same time. */
      int last = events - 1;
      while (last > 0 && !(until >> run->events[last].kind & 1)) last--;
      row[i] = run->events[last].kind;
    }
    else if (run->stop == ${name}_stop_t_end) row[i] = 100 + run->mode;
    else row[i] = 200 + run->stop;
  }
  ${name}_free(run);
  run = shown;
  memcpy(state, kept, sizeof kept);
  memcpy(parameters, own, sizeof own);
  return row;
}
