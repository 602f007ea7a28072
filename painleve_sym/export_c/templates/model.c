/* $title
 *
 * Generated: the rates, guards, resets and outputs of every mode. Then the event loop, the same for
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

/* Whether what the start makes happen at once is an event; whether bounces die out in a contact;
 * the states gap and gap rate; the mode in which a closed contact finds its solution. */
enum { START_EVENTS = $start_events, BOUNCES = $bounces, GAP = $gap, GAP_RATE = $gap_rate, DECISION = $decision };
/* Gap and normal speed, in parts of the state's scale, at which bounces have died out. */
#define CLOSED $closed
/* Stand for infinity: a state left out must not turn 0 * inf into nan in a norm, nor into a number
 * too small to be normal, which processors are slow with. */
#define ENDLESS 1e300
#define LEFT_OUT 1e100

$names

void ${name}_constants(const double *p, double *c) { ps_constants(p, c); }

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

static void engine_options(const ${name}_options *o, ps_options *e) {
  memset(e, 0, sizeof *e);
  e->rtol = o->rtol;
  e->h0 = o->first_step;
  e->h_max = o->max_step > 0 ? fmin(o->max_step, ENDLESS) : ENDLESS;
  e->t_end = o->t_end;
  for (int i = 0; i < PS_NX; i++) e->atol[i] = fmin(o->atol[i], LEFT_OUT);
  e->max_steps = o->max_steps;
  e->max_events = o->max_events;
  memcpy(e->until, o->until, sizeof e->until);
  e->record = o->keep_steps ? 2 : 1;
  e->start_events = START_EVENTS;
  e->start_mode = -1;
}

/* Room for what a piece of the run adds, and for one more event. */
static int make_room(${name}_run *r, const ps_run *s) {
  size_t events = (size_t)(r->event_count + s->events.used + 1) * sizeof(${name}_event);
  size_t steps = (size_t)((r->step_count + s->steps.used) * s->steps.width) * sizeof(double);
  void *room = realloc(r->events, events);
  if (!room) return 0;
  r->events = (${name}_event *)room;
  if (!s->steps.used) return 1;
  room = realloc(r->steps, steps);
  if (!room) return 0;
  r->steps = (double *)room;
  r->step_width = s->steps.width;
  return 1;
}

static void add_event(${name}_run *r, const double *row, double start, const double *c) {
  ${name}_event *e = &r->events[r->event_count++];
  const double *x = row + 4, *z = x + PS_NX;
  long mode = (long)row[1];
  e->time = row[0] + start;
  e->mode_before = (int)row[1];
  e->kind = PS_MODES[mode].transitions[(int)row[2]].kind;
  e->mode_after = (int)row[3];
  memcpy(e->before, x, sizeof e->before);
  memcpy(e->after, z + PS_NZ, sizeof e->after);
  ps_outputs(1, &mode, x, z, c, e->outputs);
}

/* Adds a piece that began at `start`; 0 without memory. */
static int add_piece(${name}_run *r, const ps_run *s, double start, const double *c) {
  long mode = s->mode;
  if (s->reason >= PS_NO_MEMORY || !make_room(r, s)) return 0;
  for (long i = 0; i < s->events.used; i++)
    add_event(r, s->events.data + i * s->events.width, start, c);
  for (long i = 0; i < s->steps.used; i++, r->step_count++) {
    double *row = r->steps + r->step_count * s->steps.width;
    memcpy(row, s->steps.data + i * s->steps.width, (size_t)s->steps.width * sizeof(double));
    row[0] += start;
  }
  r->time = s->t + start;
  r->mode = (int)mode;
  r->stop = (int)s->reason;
  memcpy(r->state, s->x, sizeof r->state);
  memcpy(r->memory, s->z, sizeof(double) * PS_NZ);
  ps_outputs(1, &mode, r->state, r->memory, c, r->outputs);
  r->accepted_steps += s->count.accepted;
  r->rejected_steps += s->count.rejected;
  r->field_evaluations += s->count.fields;
  return 1;
}

/* Whether the bounces that accumulate have brought the contact to rest on the surface. */
static int bounced_out(const ${name}_run *r, const ${name}_options *o) {
  if (!BOUNCES || r->stop != ${name}_stop_accumulation) return 0;
  double gap = o->atol[GAP] / o->rtol, rate = o->atol[GAP_RATE] / o->rtol;
  return fabs(r->state[GAP]) < CLOSED * gap && fabs(r->state[GAP_RATE]) < 1e3 * CLOSED * rate;
}

/* Closes the contact where its bounces have died out: an event, and the state to go on from. */
static void settle_contact(${name}_run *r, double *x, const double *c) {
  const double none[PS_NZ + 1] = {0};
  const long mode = DECISION;
  ${name}_event *e = &r->events[r->event_count++];
  memcpy(e->before, r->state, sizeof e->before);
  memcpy(x, r->state, sizeof e->after);
  x[GAP] = x[GAP_RATE] = 0;
  memcpy(e->after, x, sizeof e->after);
  e->time = r->time;
  e->kind = $settle;
  e->mode_before = r->mode;
  e->mode_after = DECISION;
  ps_outputs(1, &mode, x, none, c, e->outputs);
}

${name}_run *${name}_simulate(const double *p, const double *x, const ${name}_options *o) {
  const double none[PS_NZ + 1] = {0};
  double from[PS_NX], c[PS_NC], start = 0;
  ps_options e;
  ${name}_run *r = (${name}_run *)calloc(1, sizeof *r);
  if (!r) return NULL;
  engine_options(o, &e);
  ps_constants(p, c);
  memcpy(from, x, sizeof from);
  for (int piece = 0;; piece++) {
    ps_run *s = ps_integrate(from, none, p, 0.0, &e);
    int added = s && add_piece(r, s, start, c);
    ps_free(s);
    if (!added) {
      ${name}_free(r);
      return NULL;
    }
    if (!bounced_out(r, o) || (piece && r->time == start)) return r;
    settle_contact(r, from, c);
    start = r->time;
    e.t_end = o->t_end - start;
    if (!(e.t_end > 0)) return r;
  }
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
  const double *step_row = r->steps + low * width, *rows = step_row + 3 + PS_NZ;
  /* The part of the step that has passed, and the variable u of its polynomial, in which time runs as
   * (1 - bend) u + bend u^2. */
  double part = fmax(0.0, fmin(1.0, (t - step_row[0]) / step_row[1])), bend = step_row[width - 1];
  double u = 2 * part / (1 - bend + sqrt((1 - bend) * (1 - bend) + 4 * bend * part));
  for (int i = 0; i < PS_NX; i++) {
    double value = 0;
    for (long k = (width - 4 - PS_NZ) / PS_NX - 1; k > 0; k--)
      value = (value + rows[k * PS_NX + i]) * (k % 2 ? u : 1 - u);
    x[i] = rows[i] + value;
  }
  return 1;
}
