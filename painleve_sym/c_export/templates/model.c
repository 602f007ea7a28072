/* $title
 *
 * Generated: the rates, guards, resets and outputs of every mode, start states and scales. Then the event loop, the same for
 * every mechanism, and the functions that ${name}_model.h describes.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) painleve-sym developers: the event loop and the interface. */

#include "${name}_model.h"

#define CASADI_CODEGEN_PREFIX
#define CODEGEN_PREFIX ${name}_model_
#define PS_EXPORT static __attribute__((unused))
#if defined(__GNUC__)
/* The generated functions all take the same arguments, and some do not need all of them. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

$engine

/* ---- The interface ---- */

/* Whether what the start makes happen at once is an event. */
enum { AT_START = $start_events };
/* Stands for infinity. */
#define ENDLESS 1e300
/* Part of the scale of a contact below which other parameters change its state by rounding alone. */
#define CHANGE $change
/* Of each contact its gap, gap rate and slip among the states. */
static const int CHANGED_STATES[${NAME}_CONTACTS][3] = {$contact_states};
/* The parameters that are inputs, then -1. */
static const int INPUT_PARAMETER[${NAME}_INPUTS + 1] = {$input_parameters};

$names

$local_modes
void ${name}_constants(const double *p, double *c) { ps_constants(p, c); }

/* Completes a start state for an initial force, negative for none. */
static void complete(const double *p, double force, double *x) {
  double given[PS_GIVEN], admits[PS_ADMITS];
  memcpy(given, x, sizeof given);
  ps_start(p, given, &force, x, admits);
}

void ${name}_complete_state(const double *p, double *x) { complete(p, -1.0, x); }

${press}void ${name}_tolerances(const double *p, const double *x, double rtol, double *atol) {
  ps_scales(p, x, atol);
  for (int i = 0; i < PS_NX; i++) atol[i] *= rtol;
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

void ${name}_outputs(const double *p, int mode, const double *x, const double *z, double *out) {
  const long modes[1] = {mode};
  double c[PS_NC];
  ps_constants(p, c);
  ps_outputs(1, modes, x, z, c, out);
}

void ${name}_rates(const double *p, int mode, const double *x, const double *z, double *rates) {
  double c[PS_NC], g[PS_NG], dg[PS_NG];
  ps_constants(p, c);
  ps_evaluate(mode, x, z, c, rates, g, dg);
}

static void options_of_engine(const ${name}_options *o, ps_options *e) {
  memset(e, 0, sizeof *e);
  e->rtol = o->rtol;
  e->h0 = o->first_step;
  e->h_max = o->max_step > 0 ? fmin(o->max_step, ENDLESS) : ENDLESS;
  e->t_end = o->t_end - o->t_start;
  set_tolerances(e, o->atol);
  e->max_steps = o->max_steps;
  e->max_events = o->max_events;
  memcpy(e->until, o->until, sizeof e->until);
  e->record = o->keep_steps ? 2 : 1;
  e->start_events = AT_START;
  e->start_mode = -1;
}

/* What a run kept, with times from t_start on. */
static void copy_record(${name}_run *r, const ps_run *s, double t_start) {
  for (long i = 0; i < s->events.used; i++) {
    ${name}_event *e = &r->events[i];
    const double *row = s->events.data + i * s->events.width, *x = row + PS_EVENT_HEAD;
    const long mode = (long)row[1];
    e->time = t_start + row[0];
    e->mode_before = (int)mode;
    e->mode_after = (int)row[3];
    e->kind = (int)row[4];
    memcpy(e->before, x, sizeof e->before);
    memcpy(e->after, x + PS_NX + PS_NZ, sizeof e->after);
$copy_contact    ps_outputs(1, &mode, x, x + PS_NX, s->c, e->outputs);
  }
  r->event_count = s->events.used;
}

/* The end of a run that began at t_start, and what it kept; 0 without memory. */
static int copy_end(${name}_run *r, ps_run *s, double t_start) {
  if (s->reason == PS_NO_MEMORY) return 0;
  r->events = (${name}_event *)malloc((size_t)(s->events.used + 1) * sizeof(${name}_event));
  if (!r->events) return 0;
  copy_record(r, s, t_start);
  r->steps = s->steps.data;
  r->step_count = s->steps.used;
  r->step_width = s->steps.width;
  s->steps.data = NULL;
  for (long i = 0; i < r->step_count; i++) r->steps[i * r->step_width] += t_start;
  r->time = t_start + (s->t_base + s->t);
  r->mode = (int)s->mode;
  r->stop = (int)s->reason;
  memcpy(r->state, s->x, sizeof r->state);
  memcpy(r->memory, s->z, sizeof(double) * PS_NZ);
  ps_outputs(1, &s->mode, r->state, r->memory, s->c, r->outputs);
  r->accepted_steps = s->count.accepted;
  r->rejected_steps = s->count.rejected;
  r->field_evaluations = s->count.fields;
  return 1;
}

/* A run from the memory z in a mode, -1 where the state chooses it. */
static ${name}_run *follow(const double *p, const double *x, const double *z, int mode,
                     const ${name}_options *o) {
  ps_options e;
  options_of_engine(o, &e);
  e.start_mode = mode;
  /* Of a motion that continues, all that happens is an event. */
  if (mode >= 0) e.start_events = 1;
  ${name}_run *r = (${name}_run *)calloc(1, sizeof *r);
  ps_run *s = r ? ps_integrate(x, z, p, &e) : NULL;
  const int copied = s && copy_end(r, s, o->t_start);
  ps_free(s);
  if (copied) return r;
  ${name}_free(r);
  return NULL;
}

${name}_run *${name}_simulate(const double *p, const double *x, const ${name}_options *o) {
  const double none[PS_NZ + 1] = {0};
  return follow(p, x, none, -1, o);
}

${name}_run *${name}_simulate_from(const double *p, const double *x, const double *z, int mode,
                     const double *inputs, const ${name}_options *o) {
  double held[PS_NP + 1], own[PS_NZ + 1] = {0};
  memcpy(held, p, sizeof(double) * PS_NP);
  for (int i = 0; inputs && i < ${NAME}_INPUTS; i++) held[INPUT_PARAMETER[i]] = inputs[i];
  if (z) memcpy(own, z, sizeof(double) * PS_NZ);
  ${name}_run *r = follow(held, x, own, mode, o);
  /* Sums of times round. */
  if (r && r->stop == PS_T_END) r->time = o->t_end;
  return r;
}

int ${name}_change_parameters(const double *before, const double *p, double *x) {
  double old[PS_NX], own[PS_NX], scale[PS_NX], moved[PS_NX];
  memcpy(old, x, sizeof old);
  memcpy(own, x, sizeof own);
  memcpy(moved, x, sizeof moved);
  complete(before, -1.0, old);
  complete(p, -1.0, own);
  ps_scales(p, own, scale);
  for (int i = 0; i < ${NAME}_CONTACTS; i++) {
    const int *at = CHANGED_STATES[i];
    double change[3], least[3];
    for (int k = 0; k < 3; k++) {
      least[k] = CHANGE * scale[at[k]];
      change[k] = own[at[k]] - old[at[k]];
      if (!(fabs(change[k]) > least[k])) change[k] = 0;
      moved[at[k]] += change[k];
    }
    const int open = fmin(x[at[0]], moved[at[0]]) > least[0];
    const int slides = change[0] == 0 && change[1] == 0 && x[at[2]] * moved[at[2]] > 0;
    if ((change[0] != 0 || change[1] != 0 || change[2] != 0) && !open && !slides) return i;
  }
  memcpy(x, moved, sizeof moved);
  return -1;
}

void ${name}_free(${name}_run *r) {
  if (!r) return;
  free(r->events);
  free(r->steps);
  free(r);
}

int ${name}_at(const ${name}_run *r, double t, double *x) {
  const long width = r->step_width;
  long low = 0, high = r->step_count;
  if (!high || !(t >= r->steps[0]) || !(t <= r->time)) return 0;
  while (high - low > 1) {
    long middle = low + (high - low) / 2;
    if (r->steps[middle * width] <= t) low = middle;
    else high = middle;
  }
  const double *step_row = r->steps + low * width, *rows = step_row + PS_STEP_HEAD + PS_NZ;
  /* The part of the step that has passed, and the variable u of its polynomial, in which time runs as
   * (1 - bend) u + bend u^2. */
  double part = fmax(0.0, fmin(1.0, (t - step_row[0]) / step_row[1])), bend = step_row[width - 1];
  double u = 2 * part / (1 - bend + sqrt((1 - bend) * (1 - bend) + 4 * bend * part));
  for (int i = 0; i < PS_NX; i++) {
    double value = 0;
    for (long k = (width - PS_STEP_HEAD - 1 - PS_NZ) / PS_NX - 1; k > 0; k--)
      value = (value + rows[k * PS_NX + i]) * (k % 2 ? u : 1 - u);
    x[i] = rows[i] + value;
  }
  return 1;
}
