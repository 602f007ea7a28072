/* The event-driven integrator: model-free, in files read one after the other: state, watch, events,
 * those of a stepper (Runge-Kutta: step, extremes, search, advance; Taylor: series, angles twice, tangents,
 * roots, along twice, size, advance, lanes), loop, batch. Here, what it remembers. The generated part above it defines PS_NX, PS_NZ, PS_NC,
 * PS_NP, PS_NG, PS_NO, PS_NM, PS_NSTART, PS_WORK, the tables PS_MODES, PS_STARTS, and what the
 * stepper needs. A mode's functions are smooth; what switches is here. Guards fire when they cross
 * from + to -. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Reasons, in the order the Python side reads them. */
enum { PS_T_END, PS_UNTIL, PS_LEFT_DOMAIN, PS_STEP_LIMIT, PS_EVENT_LIMIT, PS_ACCUMULATION,
       PS_NON_FINITE, PS_STEP_UNDERFLOW, PS_NO_MODE, PS_SINGULAR, PS_JAM };

/* Not fmin and fmax, which are calls; b where a is nan. */
#define PS_MIN(a, b) ((a) < (b) ? (a) : (b))
#define PS_MAX(a, b) ((a) > (b) ? (a) : (b))

/* Zero of a guard: reached within this part of a step, far above the round-off of a located root. */
static const double PS_ZERO_TIME = 1e-10;
/* No step is shorter than this part of the time it begins at, and no event is nearer to its time. */
static const double PS_MOMENT = 16e-16;
/* Events closer than this part of a step are simultaneous: the first in the mode's list goes first. */
static const double PS_TIE = 1e-12;
/* tau of a state at the origin, in parts of the time in which it would come to its scale, or, where it
 * stands still, of the time left. */
static const double PS_FROM_REST = 1e-4;
/* Runge-Kutta starts with this multiple of the step by which guards are armed: the error decides. */
static const double PS_START = 40;
/* Part of a step that stands for no time at all. */
static const double PS_AT_ONCE = 1e-14;
/* Events at one instant before it is called an accumulation: far above any real chain. */
static const int PS_CHAIN = 64;
/* Choices of local modes at one instant that are known. */
enum { PS_ENTERED = 32 };
/* Places from which a guard that starts at zero is looked at, going back to the start. */
#define PS_SAMPLES 8
/* Accumulation: this number of intervals in a row shrink geometrically ... */
static const int PS_SHRINKING = 6;
/* ... and the time that remains until their limit is below this part of the time integrated so far. */
static const double PS_REMAINDER = 1e-11;
#ifdef PS_IMPACTS
/* Accumulations of several contacts: 6 windows in a row, of at most 8 touchdowns, shrink. */
#define PS_TOUCHDOWNS (8 * 6 + 1)
#endif
/* What happens at the limit of an accumulation changes states by less than this part of their scale. */
static const double PS_CLOSED = 1e-6;

typedef struct {
  double *data;
  long used, room, width;
} ps_rows;

/* Where an event ends a run: after all that happens at its instant, or before it happens. */
enum { PS_AFTER = 1, PS_BEFORE = 2 };
/* Of ps_transition.watching. */
enum { PS_SEEN = 1 };

typedef struct {
  double rtol, h0, h_max, t_end;
  double atol[PS_NX];
  long max_steps, max_events;
  unsigned char until[PS_NKIND]; /* of each kind: PS_AFTER and PS_BEFORE, or 0 */
  int record; /* 0: end only, 1: events, 2: events and dense steps */
  int start_events;
  int start_mode; /* -1: chosen from the state */
  /* Hears of impacts, see impulse.c and impact.c, and may add to the state after them; or NULL. */
  void (*listener)(int what, const double *numbers, double *x);
  /* Makes the variant of a mode for what is `known` of its memory, NULL where that fails; or NULL: modes run as they are. */
  const ps_variant *(*make)(int mode, const double *known);
} ps_options;

typedef struct {
  long accepted, rejected, fields, guards, dense, events;
} ps_counters;

typedef struct {
  double last, interval, ratio;
  int shrinking;
} ps_history;

#define PS_NCOUNT (sizeof(ps_counters) / sizeof(long))

typedef struct {
  double value, time;
} ps_extreme;

/* Which outputs are watched: indices of those with a maximum, a minimum, an integral, in turn. Samples
 * are values at events: of each the kind, 1 for after or 0 for before, and the index of an output or,
 * behind the outputs, of a state. */
typedef struct {
  int events, maxima, minima, integrals, samples;
  const int *of, (*sample)[3];
} ps_kept;

/* What a batch keeps of the row that runs; see watch.c. */
typedef struct {
  const ps_kept *kept;
  int dense;
  long *count;
  double *times, *integral, *samples;
  ps_extreme *extreme;
  /* Events whose values after them are known; the instant of the last ones, what was before it, and
   * whether it is not over yet. */
  long sampled[PS_NKIND];
  double instant, before[PS_NO + PS_NX];
  int open;
} ps_watch;

typedef struct {
  /* Results, read by the caller. The time since the start is t + t_base. */
  double t, x[PS_NX], z[PS_NZ + 1];
  long mode, reason, stop_transition;
  ps_counters count;
  ps_rows steps, events;
  /* Working state. What is smooth of the mode is that of its variant in the present memory. */
  const ps_variant *variant;
  double t_base, t_end, t_event, t_limit, h, h_ref, c[PS_NC], k[PS_STAGES][PS_NX];
  PS_STEPPER
  double g[PS_NG], dg[PS_NG], d2[PS_NG];
  unsigned char armed[PS_NG];
  int hit, at_once, limits;
  int starting; /* whether the mode of a start state is being chosen */
  const ps_transition *limit; /* the last one that says what follows where it accumulates, at t_limit */
  ps_watch *watch; /* NULL: nothing is watched */
  ps_history history[PS_NM][PS_NT];
  int last_kind; /* of the last event since the run began or continued from an impact, or -1 */
  int last_contact; /* of the last event, or -1 */
#if PS_NPART
  double entered[PS_ENTERED][PS_NZ], t_entered; /* memory chosen at one instant, and the instant */
  int choices, repeats; /* how many, and whether the last one was there before */
  int exists;           /* whether there is always one motion: all forces are given */
#endif
#ifdef PS_IMPACTS
  double touchdown[PS_TOUCHDOWNS]; /* the last times, the latest first */
  long touchdowns;
#endif
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

#ifdef PS_HAS_VARIANTS
/* A variant that was made while a process runs. */
typedef struct ps_made {
  const ps_variant *variant;
  const struct ps_made *next;
} ps_made;
static const ps_made *PS_MADE = NULL;

/* Adds a variant, which its caller keeps; 0 without memory. One call at a time, beside any runs. */
PS_EXPORT int ps_add_variant(const ps_variant *variant) {
  ps_made *added = (ps_made *)malloc(sizeof *added);
  if (!added) return 0;
  added->variant = variant;
  added->next = PS_MADE;
  __atomic_store_n(&PS_MADE, added, __ATOMIC_RELEASE);
  return 1;
}

/* What a variant may know of a memory, INFINITY for any value: of each part what the first of its values
 * that agree have in common, else all whole numbers. */
static void known_memory(const double *z, double *known) {
  const double *values = PS_KNOWN_MEMORY;
  for (int i = 0; i < PS_NZ; i++) known[i] = INFINITY;
  for (int p = 0; p < PS_NPART; p++) {
    const int first = PS_OWNED[p], size = PS_OWNED[p + 1] - first;
    const double *agrees = NULL;
    for (int k = 0; k < PS_KNOWN[p]; k++, values += size) {
      int i = 0;
      while (i < size && (values[i] == z[first + i] || isinf(values[i]))) i++;
      if (i == size && !agrees) agrees = values;
    }
    for (int i = 0; i < size; i++) {
      if (agrees) known[first + i] = agrees[i];
      else if (z[first + i] == floor(z[first + i])) known[first + i] = z[first + i];
    }
  }
}

static int is_known(const ps_variant *v, long mode, const double *known) {
  if (v->mode != mode) return 0;
  for (int i = 0; i < PS_NZ; i++)
    if (v->known[i] != known[i]) return 0;
  return 1;
}
#endif

/* Takes the variant of the mode for the present memory, or the mode as it is. */
static void specialise(ps_run *s, const ps_options *o) {
  s->variant = &PS_VARIANTS[s->mode];
#ifdef PS_HAS_VARIANTS
  double known[PS_NZ];
  if (!PS_HAS_VARIANTS(s->mode)) return;
  known_memory(s->z, known);
  for (int i = PS_NM; i < PS_NV; i++) {
    s->variant = &PS_VARIANTS[i];
    if (is_known(s->variant, s->mode, known)) return;
  }
  for (const ps_made *m = __atomic_load_n(&PS_MADE, __ATOMIC_ACQUIRE); m; m = m->next) {
    s->variant = m->variant;
    if (is_known(s->variant, s->mode, known)) return;
  }
  s->variant = o->make ? o->make((int)s->mode, known) : &PS_VARIANTS[s->mode];
  if (s->variant) return;
  s->variant = &PS_VARIANTS[s->mode];
  s->reason = PS_NO_VARIANT;
#else
  (void)o;
#endif
}

/* Guards with their first two derivatives along the motion, and the rates, at x. */
typedef struct {
  double *g, *dg, *d2, *rate;
} ps_jets;

#ifdef PS_ORDER
/* The series of the present variant at x: orders 0 to p, in seconds. A power whose base is not above its
 * floor is 0, and so are its derivatives. */
static void orders(ps_run *s, const double *x, int p, double (*v)[PS_COLUMNS]) {
  const ps_series *m = &s->variant->series;
  double live[PS_RAMPS];
  for (int r = 0; r < m->ramps; r++) live[r] = 1;
  if (p > 1 && m->ramps) {
    m->series(x, s->scalars, live, 1, 1, 0, v);
    for (int r = 0; r < m->ramps; r++) live[r] = v[0][m->ramp[r]] > m->floor[r];
  }
  m->series(x, s->scalars, live, p, 1, 0, v);
}

static void jets_by_series(ps_run *s, const double *x, int p, const ps_jets *jets) {
  const double one[4] = {1, 1, 1, 1};
  double v[4][PS_COLUMNS], g[4][PS_WATCHED];
  orders(s, x, p, v);
  if (jets->rate) memcpy(jets->rate, v[1], PS_NX * sizeof(double));
  if (p == 1) return;
  s->variant->series.guards(s->scalars, p, one, (const double(*)[PS_COLUMNS])v, g);
  for (int j = 0; j < s->variant->n; j++) {
    jets->g[j] = g[0][j];
    jets->dg[j] = g[1][j];
    if (p > 2) jets->d2[j] = 2 * g[2][j];
  }
}
#else
#define jets_by_series(s, x, p, jets) (void)0
#endif

static void field(ps_run *s, const double *x, double *out) {
  double *res[1] = {out};
  if (s->variant->field) call(s, s->variant->field, x, res);
  else jets_by_series(s, x, 1, (&(ps_jets){.rate = out}));
  s->count.fields++;
}

static void guards(ps_run *s, const double *x, double *g, double *dg) {
  double *res[2] = {g, dg};
  if (s->variant->guards) call(s, s->variant->guards, x, res);
  else jets_by_series(s, x, 2, (&(ps_jets){.g = g, .dg = dg}));
  s->count.guards++;
}

/* Guards, their derivatives and the rates of the mode just entered. */
static void jets_of_mode(ps_run *s) {
  double *res[4] = {s->g, s->dg, s->d2, s->k[0]};
  if (s->variant->jets) {
    call(s, s->variant->jets, s->x, res);
    return;
  }
#ifdef PS_ORDER
  double *scalars[1] = {s->scalars};
  call(s, s->variant->series.scalars, s->x, scalars);
#endif
  jets_by_series(s, s->x, 3, (&(ps_jets){s->g, s->dg, s->d2, s->k[0]}));
}

#ifdef PS_ENERGIES
/* The energies at x in the present mode. */
static void energies(ps_run *s, const double *x, double *energy) {
  double out[PS_NO], *res[1] = {out};
  call(s, PS_MODES[s->mode].outputs, x, res);
  for (int i = 0; i < PS_ENERGIES; i++) energy[i] = out[PS_ENERGY[i]];
}
#endif

/* Keeps a step with its dense output, rows of PS_NX numbers, and its bend (see Trajectory). */
static int record_step(ps_run *s, const ps_options *o, double h, const double *dense, int rows,
                       double bend) {
  if (o->record < 2) return 1;
  double head[PS_STEP_HEAD] = {s->t_base + s->t, h, (double)s->mode};
  const double *parts[4] = {head, s->z, dense, &bend};
  const int sizes[4] = {PS_STEP_HEAD, PS_NZ, rows * PS_NX, 1};
  if (rows_push(&s->steps, parts, sizes, 4)) return 1;
  s->reason = PS_NO_MEMORY;
  return 0;
}
