/* The event-driven integrator: model-free. The generated part above it defines PS_NX, PS_NZ,
 * PS_NC, PS_NP, PS_NG, PS_NO, PS_NM, PS_NSTART, PS_WORK, the coefficient macros PS_ROW_*, PS_E5,
 * PS_E3, PS_D*, and the tables PS_MODES, PS_STARTS. A mode's functions are smooth; what switches
 * is here. Guards fire when they cross from + to -. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Reasons, in the order the Python side reads them. */
enum { PS_T_END, PS_UNTIL, PS_LEFT_DOMAIN, PS_STEP_LIMIT, PS_EVENT_LIMIT, PS_ACCUMULATION,
       PS_NON_FINITE, PS_STEP_UNDERFLOW, PS_NO_MODE, PS_NO_MEMORY, PS_RUNNING = -1 };

/* Zero of a guard: reached within this part of a step, far above the round-off of a located root. */
static const double PS_ZERO_TIME = 1e-10;
/* Part of a step that stands for no time at all. */
static const double PS_AT_ONCE = 1e-14;
/* Events at one instant before it is called an accumulation: far above any real chain. */
static const int PS_CHAIN = 64;
/* Answer of find_event; any number that is no guard and not -1. */
#define PS_RETAKE -2
/* Samples of the dense output in a step that may hold an event. */
#define PS_SAMPLES 8
/* Accumulation: so many intervals in a row shrink geometrically ... */
static const int PS_SHRINKING = 6;
/* ... and what is left until their limit is below this part of the time integrated so far. */
static const double PS_REMAINDER = 1e-11;

typedef struct {
  double *data;
  long used, room, width;
} ps_rows;

typedef struct {
  double rtol, h0, h_max, t_end;
  double atol[PS_NX];
  long max_steps, max_events;
  unsigned char until[PS_NKIND];
  int record; /* 0: end only, 1: events, 2: events and dense steps */
} ps_options;

typedef struct {
  long accepted, rejected, fields, guards, dense, events;
} ps_counters;

typedef struct {
  double last, interval;
  int shrinking;
} ps_history;

typedef struct {
  /* Results, read by the caller. */
  double t, x[PS_NX], z[PS_NZ + 1];
  long mode, reason, stop_transition;
  ps_counters count;
  ps_rows steps, events;
  /* Working state. */
  double t_start, t_event, h, h_ref, c[PS_NC], k[16][PS_NX];
  double g[PS_NG], dg[PS_NG];
  unsigned char armed[PS_NG];
  int hit, at_once;
  ps_history history[PS_NM][PS_NG];
  casadi_int iw[8];
  double w[PS_WORK + 1];
} ps_run;

static int rows_push(ps_rows *r, const double **parts, const int *sizes, int n) {
  if (r->used == r->room) {
    long room = r->room ? 2 * r->room : 64;
    double *data = (double *)realloc(r->data, (size_t)(room * r->width) * sizeof(double));
    if (!data) return 0;
    r->data = data;
    r->room = room;
  }
  double *row = r->data + r->used * r->width;
  for (int i = 0; i < n; i++) {
    memcpy(row, parts[i], (size_t)sizes[i] * sizeof(double));
    row += sizes[i];
  }
  r->used++;
  return 1;
}

static void call(ps_run *s, ps_function f, const double *x, double **res) {
  const double *arg[3] = {x, s->z, s->c};
  f(arg, res, s->iw, s->w, 0);
}

static void field(ps_run *s, const double *x, double *out) {
  double *res[1] = {out};
  call(s, PS_MODES[s->mode].field, x, res);
  s->count.fields++;
}

static void guards(ps_run *s, const double *x, double *g, double *dg) {
  double *res[2] = {g, dg};
  call(s, PS_MODES[s->mode].guards, x, res);
  s->count.guards++;
}

/* ---- One Runge-Kutta step, its error and its dense output ---- */

#define STAGE(row, n)                                            \
  for (int i = 0; i < PS_NX; i++) y[i] = x[i] + h * (row);       \
  field(s, y, k[n]);

/* From x with k[0] = f(x): the end state y after h, stages 1..11 in k. */
static void step(ps_run *s, const double *x, double h, double *y) {
  double(*k)[PS_NX] = s->k;
  STAGE(PS_ROW_1, 1)
  STAGE(PS_ROW_2, 2)
  STAGE(PS_ROW_3, 3)
  STAGE(PS_ROW_4, 4)
  STAGE(PS_ROW_5, 5)
  STAGE(PS_ROW_6, 6)
  STAGE(PS_ROW_7, 7)
  STAGE(PS_ROW_8, 8)
  STAGE(PS_ROW_9, 9)
  STAGE(PS_ROW_10, 10)
  STAGE(PS_ROW_11, 11)
  for (int i = 0; i < PS_NX; i++) y[i] = x[i] + h * (PS_ROW_12);
}

/* Weighted error norm of the last step; the step is good when it is below 1. */
static double error_norm(ps_run *s, const ps_options *o, const double *x, const double *y,
                         double h) {
  double(*k)[PS_NX] = s->k;
  double e5 = 0, e3 = 0;
  for (int i = 0; i < PS_NX; i++) {
    double scale = o->atol[i] + o->rtol * fmax(fabs(x[i]), fabs(y[i]));
    double a = (PS_E5) / scale, b = (PS_E3) / scale;
    e5 += a * a;
    e3 += b * b;
  }
  double sum = e5 + 0.01 * e3;
  if (!(sum > 0)) return sum == 0 ? 0 : NAN;
  return fabs(h) * e5 / sqrt(sum * PS_NX);
}

/* Rows of the dense polynomial of a step from x to y; k[12] holds f(y). */
static void dense_rows(ps_run *s, const double *x, const double *end, double h,
                       double row[8][PS_NX]) {
  double(*k)[PS_NX] = s->k;
  double y[PS_NX];
  STAGE(PS_ROW_13, 13)
  STAGE(PS_ROW_14, 14)
  STAGE(PS_ROW_15, 15)
  for (int i = 0; i < PS_NX; i++) {
    double d = end[i] - x[i];
    row[0][i] = x[i];
    row[1][i] = d;
    row[2][i] = h * k[0][i] - d;
    row[3][i] = 2 * d - h * (k[12][i] + k[0][i]);
    row[4][i] = h * (PS_D_0);
    row[5][i] = h * (PS_D_1);
    row[6][i] = h * (PS_D_2);
    row[7][i] = h * (PS_D_3);
  }
  s->count.dense++;
}

static void dense_eval(double row[8][PS_NX], double u, double *x) {
  double v = 1 - u;
  for (int i = 0; i < PS_NX; i++)
    x[i] = row[0][i]
           + u * (row[1][i]
                  + v * (row[2][i]
                         + u * (row[3][i]
                                + v * (row[4][i]
                                       + u * (row[5][i] + v * (row[6][i] + u * row[7][i]))))));
}

/* First step of a mode (Hairer, Norsett & Wanner, II.4); k[0] = f(x) is set here. */
static double first_step(ps_run *s, const ps_options *o) {
  double y[PS_NX], d0 = 0, d1 = 0, d2 = 0;
  field(s, s->x, s->k[0]);
  for (int i = 0; i < PS_NX; i++) {
    double scale = o->atol[i] + o->rtol * fabs(s->x[i]);
    double a = s->x[i] / scale, b = s->k[0][i] / scale;
    d0 += a * a;
    d1 += b * b;
  }
  double h = d0 > 1e-10 && d1 > 1e-10 ? 0.01 * sqrt(d0 / d1) : 1e-6;
  if (h > o->h_max) h = o->h_max;
  for (int i = 0; i < PS_NX; i++) y[i] = s->x[i] + h * s->k[0][i];
  field(s, y, s->k[1]);
  for (int i = 0; i < PS_NX; i++) {
    double scale = o->atol[i] + o->rtol * fabs(s->x[i]);
    double a = (s->k[1][i] - s->k[0][i]) / scale;
    d2 += a * a;
  }
  double slope = fmax(sqrt(d1), sqrt(d2) / h);
  double h1 = slope > 1e-15 ? pow(0.01 / slope, 0.125) : fmax(1e-6, h * 1e-3);
  h = fmin(100 * h, h1);
  return h > 0 && h < o->h_max ? h : o->h_max;
}

/* ---- Events ---- */

static int geometric_accumulation(ps_run *s, int mode, int j, double t) {
  ps_history *y = &s->history[mode][j];
  double interval = t - y->last, before = y->interval;
  y->last = t;
  y->interval = interval;
  if (!(before > 0) || !(interval < 0.9999 * before)) {
    y->shrinking = 0;
    return 0;
  }
  if (++y->shrinking < PS_SHRINKING) return 0;
  double ratio = interval / before;
  return interval * ratio / (1 - ratio) < PS_REMAINDER * (t - s->t_start);
}

/* Applies transition j of the current mode; `departs` returns the guards known to leave zero. */
static void apply(ps_run *s, const ps_options *o, int j, int visible, unsigned *departs) {
  const ps_transition *tr = &PS_MODES[s->mode].transitions[j];
  double xn[PS_NX], zn[PS_NZ + 1] = {0}, condition[PS_NCHOICE];
  double *res[3] = {xn, zn, condition};
  int choice = 0, from = (int)s->mode;
  call(s, tr->event, s->x, res);
  *departs = 0;
  if (tr->stop < 0) {
    while (choice < tr->n - 1 && !(condition[choice] > 0)) choice++;
    s->mode = tr->target[choice];
    *departs = tr->departs[choice];
  } else {
    s->reason = tr->stop;
    s->stop_transition = j;
  }
  if (visible) {
    s->count.events++;
    if (o->record) {
      double head[4] = {s->t, (double)from, (double)j, (double)s->mode};
      const double *parts[5] = {head, s->x, s->z, xn, zn};
      const int sizes[5] = {4, PS_NX, PS_NZ, PS_NX, PS_NZ};
      if (!rows_push(&s->events, parts, sizes, 5)) s->reason = PS_NO_MEMORY;
    }
    if (o->until[tr->kind]) s->hit = 1;
    s->at_once = s->t == s->t_event ? s->at_once + 1 : 0;
    s->t_event = s->t;
    if (s->reason == PS_RUNNING && s->at_once >= PS_CHAIN) s->reason = PS_ACCUMULATION;
    if (s->reason == PS_RUNNING && geometric_accumulation(s, from, j, s->t))
      s->reason = PS_ACCUMULATION;
    if (s->reason == PS_RUNNING && s->count.events >= o->max_events) s->reason = PS_EVENT_LIMIT;
  }
  memcpy(s->x, xn, sizeof xn);
  memcpy(s->z, zn, sizeof(double) * PS_NZ);
}

/* 1: on its positive side, armed; 0: at zero and leaving upwards; -1: fires now. At zero the sign
 * is that of the first derivative, or of the second where the first is zero beside it. */
static int guard_side(double g, double d, double d2, double zero, int departs) {
  if (!isfinite(d)) d = isinf(d) ? copysign(1e300, d) : 0;
  if (!isfinite(d2)) d2 = 0;
  double first = d * zero, second = 0.5 * d2 * zero * zero;
  double band = fabs(first) + fabs(second);
  if (g > band) return 1;
  if (g < -band) return -1;
  if (departs) return 0;
  return (fabs(first) > fabs(second) ? first : second) < 0 ? -1 : 0;
}

/* Enters the mode in s->mode: transitions that must happen at once do, then guards are armed. */
static void settle(ps_run *s, const ps_options *o, unsigned departs, int visible) {
  double d2[PS_NG];
  for (int chain = 0; s->reason == PS_RUNNING; chain++) {
    const ps_mode *m = &PS_MODES[s->mode];
    if (chain == PS_CHAIN) {
      s->reason = PS_ACCUMULATION;
      return;
    }
    s->h_ref = first_step(s, o);
    if (!isfinite(s->h_ref)) {
      s->reason = PS_NON_FINITE;
      return;
    }
    double *res[3] = {s->g, s->dg, d2};
    call(s, m->jets, s->x, res);
    int fire = -1;
    for (int j = 0; j < m->n && fire < 0; j++) {
      int side = guard_side(s->g[j], s->dg[j], d2[j], PS_ZERO_TIME * s->h_ref,
                            (departs >> j) & 1u);
      s->armed[j] = side > 0;
      if (side < 0) fire = j;
    }
    if (fire < 0) return;
    apply(s, o, fire, visible, &departs);
  }
}

typedef struct {
  double at, g, d;
} ps_point;

static ps_point guard_at(ps_run *s, double row[8][PS_NX], int j, double u) {
  double x[PS_NX], g[PS_NG], dg[PS_NG];
  dense_eval(row, u, x);
  guards(s, x, g, dg);
  ps_point p = {u, g[j], dg[j]};
  return p;
}

/* A point between a and b where guard j is not positive though it is at both ends; at < 0 if none. */
static ps_point dip(ps_run *s, double row[8][PS_NX], int j, double a, double b) {
  ps_point p = {-1, 0, 0};
  for (int it = 0; it < 60 && b - a > 1e-15; it++) {
    p = guard_at(s, row, j, 0.5 * (a + b));
    if (p.g <= 0) return p;
    if (p.d < 0) a = p.at; else b = p.at;
  }
  p.at = -1;
  return p;
}

/* Illinois iteration between a (positive) and b (not), with a bisection now and then. */
static double refine(ps_run *s, double row[8][PS_NX], int j, ps_point a, ps_point b) {
  int side = 0;
  for (int it = 0; it < 100 && b.at - a.at > 4e-16; it++) {
    double u = it % 8 == 7 ? 0.5 * (a.at + b.at) : (a.at * b.g - b.at * a.g) / (b.g - a.g);
    if (!(u > a.at && u < b.at)) u = 0.5 * (a.at + b.at);
    ps_point p = guard_at(s, row, j, u);
    if (p.g == 0) return u;
    if (p.g > 0) {
      a = p;
      if (side == 1) b.g *= 0.5;
      side = 1;
    } else {
      b = p;
      if (side == -1) a.g *= 0.5;
      side = -1;
    }
  }
  return b.at;
}

/* First point after `a` of the dense step where guard j has come down to zero, or -1. Two crossings
 * between samples are found through the minimum of the guard. */
static double first_zero(ps_run *s, double row[8][PS_NX], int j, ps_point a) {
  for (int i = 1; i <= PS_SAMPLES; i++) {
    double u = (double)i / PS_SAMPLES;
    if (u <= a.at) continue;
    ps_point b = guard_at(s, row, j, u);
    if (b.g > 0 && a.d < 0 && b.d > 0) {
      ps_point low = dip(s, row, j, a.at, b.at);
      if (low.at >= 0) b = low;
    }
    if (b.g <= 0) return refine(s, row, j, a, b);
    a = b;
  }
  return -1;
}

/* The same for a guard that starts at zero and leaves upwards: an ordinary guard from the first
 * point where it is positive, which may be long before the first sample, but not so early that the
 * round-off of its start decides. */
static double next_zero(ps_run *s, double row[8][PS_NX], int j, double h) {
  double least = PS_ZERO_TIME * s->h_ref / h;
  ps_point p = guard_at(s, row, j, 1.0 / PS_SAMPLES);
  while (!(p.g > 0) && 0.5 * p.at > least) p = guard_at(s, row, j, 0.5 * p.at);
  return p.g > 0 ? first_zero(s, row, j, p) : -1;
}

/* Whether the cubic through both ends of a step dips so low that the guard may touch zero. */
static int may_dip(double g0, double d0, double g1, double d1, double h) {
  if (!(d0 < 0 && d1 > 0)) return 0;
  double low = fmin(g0, g1), dip = low;
  for (int i = 1; i < 8; i++) {
    double u = i / 8.0, v = 1 - u;
    double value = v * v * (1 + 2 * u) * g0 + u * u * (3 - 2 * u) * g1
                   + h * u * v * (v * d0 - u * d1);
    dip = fmin(dip, value);
  }
  return dip < 0.5 * low;
}

/* Earliest event inside the step that was just accepted: its guard, its place in `where`; -1 where
 * there is none, PS_RETAKE where only a shorter step can tell. */
static int find_event(ps_run *s, const double *y, double h, const double *g1, const double *d1,
                      double row[8][PS_NX], int have_dense, double *where) {
  const ps_mode *m = &PS_MODES[s->mode];
  int first = -1;
  *where = 2;
  for (int j = 0; j < m->n; j++) {
    int crossed = g1[j] <= 0 && (s->armed[j] || g1[j] < 0 || d1[j] < 0);
    if (!crossed && !(s->armed[j] && may_dip(s->g[j], s->dg[j], g1[j], d1[j], h))) continue;
    if (!have_dense) {
      dense_rows(s, s->x, y, h, row);
      have_dense = 1;
    }
    ps_point start = {0, s->g[j], s->dg[j]};
    double u = s->armed[j] ? first_zero(s, row, j, start) : next_zero(s, row, j, h);
    if (u < 0 && crossed && s->armed[j]) u = 1;
    if (u < 0 && crossed) {
      /* A guard that left zero is back, and this step is too long to show where. A far shorter one
       * may; if none does, it fires just after the start, where the rates that turned it already
       * have their new sign. */
      if (h > 10 * PS_ZERO_TIME * s->h_ref) return PS_RETAKE;
      u = PS_AT_ONCE;
    }
    if (u >= 0 && u < *where) {
      *where = u;
      first = j;
    }
  }
  return first;
}

static int record_step(ps_run *s, const ps_options *o, double h, double row[8][PS_NX]) {
  if (o->record < 2) return 1;
  double head[3] = {s->t, h, (double)s->mode};
  const double *parts[3] = {head, s->z, &row[0][0]};
  const int sizes[3] = {3, PS_NZ, 8 * PS_NX};
  if (rows_push(&s->steps, parts, sizes, 3)) return 1;
  s->reason = PS_NO_MEMORY;
  return 0;
}

/* Repeats the step so that it ends where guard j is zero, to round-off; returns its length.
 * s->k is left as a whole step needs it (k[0] at the start, k[12] at the end in y). The dense
 * output has the error of the whole step: where the repeated, shorter step shows the guard positive
 * and not coming down, there is no zero and `found` is 0. */
static double step_to_zero(ps_run *s, int j, double h, double *y, int *found) {
  double g[PS_NG], dg[PS_NG];
  *found = 1;
  for (int it = 0; it < 60; it++) {
    step(s, s->x, h, y);
    field(s, y, s->k[12]);
    guards(s, y, g, dg);
    double dh = dg[j] < 0 ? -g[j] / dg[j] : 0;
    if (g[j] > 0 && (!(dg[j] < 0) || dh > 0.5 * h)) {
      *found = 0;
      return h;
    }
    if (!(dh > -0.5 * h)) dh = -0.5 * h;
    if (fabs(dh) <= 1e-7 * h) {
      /* So close that the rest is linear: its square is below round-off. */
      for (int i = 0; i < PS_NX; i++) y[i] += dh * s->k[12][i];
      return h + dh;
    }
    h += dh;
  }
  return h;
}

static void enter_end_of_step(ps_run *s, double h, const double *y, const double *g,
                              const double *dg) {
  s->t += h;
  memcpy(s->x, y, sizeof s->x);
  memcpy(s->k[0], s->k[12], sizeof s->k[0]);
  for (int j = 0; j < PS_MODES[s->mode].n; j++) s->armed[j] |= g[j] > 0;
  memcpy(s->g, g, sizeof s->g);
  memcpy(s->dg, dg, sizeof s->dg);
}

/* Ends the step just made at the event of guard j, near the part `where` of it, and takes it. */
static void take_event(ps_run *s, const ps_options *o, int j, double where, double h, double *y,
                       double row[8][PS_NX]) {
  int found = 1;
  unsigned departs;
  h *= where;
  if (where > PS_AT_ONCE) {
    h = step_to_zero(s, j, h, y, &found);
  } else {
    step(s, s->x, h, y);
    field(s, y, s->k[12]);
  }
  if (o->record == 2) dense_rows(s, s->x, y, h, row);
  if (!record_step(s, o, h, row)) return;
  if (!found) {
    double g[PS_NG], dg[PS_NG];
    guards(s, y, g, dg);
    enter_end_of_step(s, h, y, g, dg);
    s->h = 6 * h;
    return;
  }
  s->t += h;
  memcpy(s->x, y, sizeof s->x);
  apply(s, o, j, 1, &departs);
  settle(s, o, departs, 1);
  /* The old step size is kept where the new mode is as smooth, else the estimate is used. */
  s->h = fmin(s->h, 10 * s->h_ref);
  if (s->hit && s->reason == PS_RUNNING) s->reason = PS_UNTIL;
}

/* One accepted step, or the event it ran into. */
static void advance(ps_run *s, const ps_options *o) {
  double y[PS_NX], row[8][PS_NX], g1[PS_NG], d1[PS_NG], err;
  int rejected = 0;
  for (;;) {
    int last = 0;
    double h = fmin(s->h, o->h_max);
    if (s->t + h * 1.0000001 >= o->t_end) {
      h = o->t_end - s->t;
      last = 1;
    }
    if (!(h > 16e-16 * fabs(s->t)) || s->count.accepted + s->count.rejected >= o->max_steps) {
      s->reason = s->count.accepted + s->count.rejected >= o->max_steps ? PS_STEP_LIMIT
                                                                        : PS_STEP_UNDERFLOW;
      if (last && s->reason == PS_STEP_UNDERFLOW) s->reason = PS_T_END;
      return;
    }
    step(s, s->x, h, y);
    err = error_norm(s, o, s->x, y, h);
    if (!(err < 1)) {
      s->count.rejected++;
      if (!isfinite(err) && h < 1e-200) {
        s->reason = PS_NON_FINITE;
        return;
      }
      s->h = h * (isfinite(err) ? fmax(0.1, 0.9 * pow(err, -0.125)) : 0.1);
      rejected = 1;
      continue;
    }
    s->count.accepted++;
    field(s, y, s->k[12]);
    guards(s, y, g1, d1);
    if (o->record == 2) dense_rows(s, s->x, y, h, row);
    double where, grow = err > 0 ? fmin(6.0, 0.9 * pow(err, -0.125)) : 6.0;
    int event = find_event(s, y, h, g1, d1, row, o->record == 2, &where);
    if (event == PS_RETAKE) {
      s->count.accepted--;
      s->count.rejected++;
      s->h = 0.02 * h;
      continue;
    }
    s->h = h * (rejected ? fmin(grow, 1) : grow);
    if (event >= 0) {
      take_event(s, o, event, where, h, y, row);
      return;
    }
    if (!record_step(s, o, h, row)) return;
    enter_end_of_step(s, h, y, g1, d1);
    if (last) {
      s->t = o->t_end;
      s->reason = PS_T_END;
    }
    return;
  }
}

static void choose_start(ps_run *s) {
  double condition[PS_NSTART];
  double *res[1] = {condition};
  int i = 0;
  call(s, PS_START_CONDITIONS, s->x, res);
  while (i < PS_NSTART - 1 && !(condition[i] > 0)) i++;
  s->mode = PS_STARTS[i];
}

/* ---- What the caller sees ---- */

PS_EXPORT void ps_constants(const double *p, double *c) {
  const double *arg[1] = {p};
  double *res[1] = {c};
  casadi_int iw[8];
  double w[PS_WORK + 1];
  PS_CONSTANTS(arg, res, iw, w, 0);
}

/* mode < 0: chosen from the state. Returns a run to be read and freed, NULL without memory. */
PS_EXPORT ps_run *ps_integrate(const double *x, const double *z, const double *p, double t,
                               int mode, const ps_options *o) {
  ps_run *s = (ps_run *)calloc(1, sizeof(ps_run));
  if (!s) return NULL;
  memcpy(s->x, x, sizeof s->x);
  memcpy(s->z, z, sizeof(double) * PS_NZ);
  s->t = s->t_start = t;
  s->t_event = -HUGE_VAL;
  s->steps.width = 3 + PS_NZ + 8 * PS_NX;
  s->events.width = 4 + 2 * (PS_NX + PS_NZ);
  s->reason = PS_RUNNING;
  s->stop_transition = -1;
  for (int i = 0; i < PS_NM; i++)
    for (int j = 0; j < PS_NG; j++) s->history[i][j].last = t;
  ps_constants(p, s->c);
  s->mode = mode;
  if (mode < 0) choose_start(s);
  /* What the start state makes happen at once is its choice of mode, not an event of the run. */
  settle(s, o, 0, 0);
  s->h = o->h0 > 0 ? o->h0 : s->h_ref;
  while (s->reason == PS_RUNNING) advance(s, o);
  return s;
}

PS_EXPORT void ps_free(ps_run *s) {
  if (!s) return;
  free(s->steps.data);
  free(s->events.data);
  free(s);
}

/* Outputs at n points, each with its mode, state and memory; c are constants. */
PS_EXPORT void ps_outputs(long n, const long *mode, const double *x, const double *z,
                          const double *c, double *out) {
  casadi_int iw[8];
  double w[PS_WORK + 1];
  for (long i = 0; i < n; i++) {
    const double *arg[3] = {x + i * PS_NX, z + i * PS_NZ, c};
    double *res[1] = {out + i * PS_NO};
    PS_MODES[mode[i]].outputs(arg, res, iw, w, 0);
  }
}

/* Field and guards of one mode at one point, for checks. */
PS_EXPORT void ps_evaluate(int mode, const double *x, const double *z, const double *c,
                           double *rate, double *g, double *dg) {
  casadi_int iw[8];
  double w[PS_WORK + 1];
  const double *arg[3] = {x, z, c};
  double *res[2] = {rate, NULL};
  PS_MODES[mode].field(arg, res, iw, w, 0);
  res[0] = g;
  res[1] = dg;
  PS_MODES[mode].guards(arg, res, iw, w, 0);
}
