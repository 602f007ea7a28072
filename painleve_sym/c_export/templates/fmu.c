/* $title: a functional mock-up unit for co-simulation, FMI $fmi_version
 *
 * Generated: the tables of variables, ranges and start values. Then what both versions of FMI share: an
 * instance is a motion that each communication step continues, with its events inside the step.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) painleve-sym developers: the interface. */

#include "${name}_model.c"

#include <stdarg.h>
#include <stdio.h>

#ifdef _WIN32
#define FMU_EXPORT __declspec(dllexport)
#else
#define FMU_EXPORT __attribute__((visibility("default")))
#endif

/* ---- Tables ---- */

/* Of what a variable is an element. */
enum { FMU_TIME, FMU_PARAMETER, FMU_FORCE, FMU_STATE, FMU_OUTPUT, FMU_MEMORY, FMU_MODE, FMU_EVENTS };
enum { FMU_VARIABLES = $variables_count };
/* By value reference. */
static const struct { int kind, index; } FMU_VARIABLE[FMU_VARIABLES] = {$variables};
static const char *const FMU_NAME[FMU_VARIABLES] = {$variable_names};
/* Ranges of the parameters, in numbers and in words. */
static const struct { double lower, upper; int lower_closed, upper_closed; const char *is, *need; }
    FMU_RANGE[PS_NP + 1] = $ranges;
static const double FMU_PARAMETERS[PS_NP + 1] = $parameter_values;
static const double FMU_START[PS_GIVEN] = $start_values;
/* Normal force at the start, N; negative: none. */
static const double FMU_START_FORCE = $force;
/* The time among the states and, of inputs that vary within a step, the parameter that is the instant of
 * their value and rate: the beginning of the step. */
enum { FMU_INSTANTS = $instants_count, FMU_CLOCK = $clock };
static const int FMU_INSTANT[FMU_INSTANTS + 1] = $instants;
/* Why a run ended. */
static const char *const FMU_STOP[${NAME}_STOPS] = $stop_sentences;
static const char FMU_TOKEN[] = "$token";
static const double FMU_RTOL = $rtol, FMU_STOP_TIME = $t_end;

static void fmu_limits(${name}_options *options) {
  (void)options;
$options}

/* ---- An instance ---- */

enum { FMU_INSTANTIATED, FMU_INITIALIZATION, FMU_STEPPING, FMU_ENDED };

typedef struct {
  /* Given: parameters, coordinates and velocities at the start, normal force there. */
  double p[PS_NP + 1], start[PS_GIVEN], force, rtol;
  /* The place of the motion, and the parameters of the step that led there. Before the first step
   * `begun` is 0, and the place is what the start makes happen at once. */
  double time, x[PS_NX], z[PS_NZ + 1], out[PS_NO], held[PS_NP + 1];
  ${name}_options options;
  long events;
  int begun, mode, phase, stale;
} fmu_motion;

typedef struct fmu_instance {
  fmu_motion now;
  void (*log)(const struct fmu_instance *, const char *text);
  void *logger, *environment;
  char *name;
  int early; /* whether a step may end before its time */
} fmu_instance;

/* Writes a sentence to the log, and returns 0. */
static int fmu_say(const fmu_instance *i, const char *format, ...) {
  char text[1024];
  va_list values;
  va_start(values, format);
  vsnprintf(text, sizeof text, format, values);
  va_end(values);
  if (i->logger) i->log(i, text);
  return 0;
}

static void fmu_reset(fmu_instance *i) {
  fmu_motion *m = &i->now;
  memset(m, 0, sizeof *m);
  memcpy(m->p, FMU_PARAMETERS, sizeof m->p);
  memcpy(m->start, FMU_START, sizeof m->start);
  m->force = FMU_START_FORCE;
  m->rtol = FMU_RTOL;
  m->stale = 1;
}

static fmu_instance *fmu_new(const char *name, const char *token, void *logger, void *environment,
                             void (*log)(const fmu_instance *, const char *)) {
  fmu_instance *i = (fmu_instance *)calloc(1, sizeof *i);
  if (!i) return NULL;
  i->log = log;
  i->logger = logger;
  i->environment = environment;
  const size_t size = strlen(name ? name : "") + 1;
  i->name = (char *)calloc(size, 1);
  if (!i->name || !token || strcmp(token, FMU_TOKEN) != 0) {
    fmu_say(i, "the model description is of another FMU: got token %s, need %s.",
            token ? token : "none", FMU_TOKEN);
    free(i->name);
    free(i);
    return NULL;
  }
  memcpy(i->name, name ? name : "", size);
  fmu_reset(i);
  return i;
}

static void fmu_free(fmu_instance *i) {
  if (!i) return;
  free(i->name);
  free(i);
}

/* ---- The motion ---- */

/* Writes the start state of the motion and its options; 0 where it cannot start there. */
static int fmu_begin(fmu_instance *i) {
  fmu_motion *m = &i->now;
  double admits[PS_ADMITS];
  ps_start(m->p, m->start, &m->force, m->x, admits);
  memset(m->z, 0, sizeof m->z);
  if (!admits[1]) return fmu_say(i, "start: the parameters give a constant that is not finite.");
  if (!admits[2]) return fmu_say(i, "start: the state is outside the domain of the mechanism.");
  if (!admits[0])
    return fmu_say(i, "start: the contact law does not admit the state. Fix: a rigid contact starts with "
                      "gap >= 0, one that holds from both sides with gap 0.");
  ${name}_default_options(m->p, m->x, FMU_STOP_TIME, m->rtol, &m->options);
  fmu_limits(&m->options);
  memcpy(m->held, m->p, sizeof m->p);
  return 1;
}

/* Inputs have their values and rates at the present time. */
static void fmu_give_instants(fmu_motion *m) {
  const double now = m->begun ? m->x[FMU_CLOCK] : m->start[FMU_CLOCK];
  for (int k = 0; k < FMU_INSTANTS; k++) m->p[FMU_INSTANT[k]] = now;
}

static int fmu_keep(fmu_motion *m, const ${name}_run *run) {
  memcpy(m->x, run->state, sizeof m->x);
  memcpy(m->z, run->memory, sizeof(double) * PS_NZ);
  memcpy(m->out, run->outputs, sizeof m->out);
  m->mode = run->mode;
  m->stale = 0;
  return 1;
}

static ${name}_run *fmu_run(fmu_instance *i, const ${name}_options *options) {
  const fmu_motion *m = &i->now;
  ${name}_run *run =
      ${name}_simulate_from(m->p, m->x, m->z, m->begun ? m->mode : -1, NULL, options);
  if (!run) fmu_say(i, "no memory for the motion.");
  return run;
}

/* Computes the place of the motion and its outputs by the present parameters. */
static int fmu_refresh(fmu_instance *i) {
  fmu_motion *m = &i->now;
  if (!m->stale) return 1;
  fmu_give_instants(m);
  if (m->begun) {
    ${name}_outputs(m->p, m->mode, m->x, m->z, m->out);
    m->stale = 0;
    return 1;
  }
  if (!fmu_begin(i)) return 0;
  ${name}_options none = m->options;
  none.max_steps = 0;
  ${name}_run *run = fmu_run(i, &none);
  if (!run) return 0;
  const int ended = run->stop != ${name}_stop_step_limit && run->stop != ${name}_stop_until;
  if (ended) fmu_say(i, "start: %s.", FMU_STOP[run->stop]);
  else fmu_keep(m, run);
  ${name}_free(run);
  return !ended;
}

/* Enters the motion: its start has to be possible. */
static int fmu_initialized(fmu_instance *i) {
  if (!fmu_refresh(i)) return 0;
  i->now.phase = FMU_STEPPING;
  return 1;
}

static int fmu_setup(fmu_instance *i, int tolerance_defined, double tolerance, double time) {
  i->now.time = time;
  if (!tolerance_defined) return 1;
  if (!(tolerance >= 1e-15 && tolerance < 1))
    return fmu_say(i, "tolerance: got %g, need a number with 1e-15 <= tolerance < 1.", tolerance);
  i->now.rtol = tolerance;
  return 1;
}

enum { FMU_ERROR, FMU_OK, FMU_END };

/* Continues the motion from t by h; FMU_END where it ended before. */
static int fmu_step(fmu_instance *i, double t, double h) {
  fmu_motion *m = &i->now;
  if (m->phase != FMU_STEPPING)
    return fmu_say(i, "step: the motion %s.", m->phase == FMU_ENDED ? "has ended" : "is not initialized");
  if (!(fabs(t - m->time) <= 1e-6 * h + 1e-12 * fabs(t)))
    return fmu_say(i, "step: got the communication point %.17g s, but the motion is at %.17g s.", t,
                   m->time);
  const double end = t + h;
  if (!(end > m->time) || !isfinite(end))
    return fmu_say(i, "step: got the size %g s at %g s, need a time after that.", h, t);
  fmu_give_instants(m);
  if (!m->begun) {
    if (!fmu_begin(i)) return FMU_ERROR;
  } else {
    const int contact = ${name}_change_parameters(m->held, m->p, m->x);
    if (contact >= 0)
      return fmu_say(i, "step: what changes at %g s moves contact %s while it is closed. Fix: change what "
                        "leaves its surface in place.",
                     t, ${name}_contact_names[contact]);
  }
  m->options.t_start = m->time;
  m->options.t_end = end;
  ${name}_run *run = fmu_run(i, &m->options);
  if (!run) return FMU_ERROR;
  const int stop = run->stop;
  fmu_keep(m, run);
  memcpy(m->held, m->p, sizeof m->p);
  m->begun = 1;
  m->time = run->time;
  m->events += run->event_count;
  ${name}_free(run);
  if (stop == ${name}_stop_t_end) return FMU_OK;
  m->phase = FMU_ENDED;
  fmu_say(i, "the motion ended at t = %.17g s: %s.", m->time, FMU_STOP[stop]);
  return FMU_END;
}

/* ---- Variables ---- */

static int fmu_unknown(const fmu_instance *i, unsigned int reference, const char *type) {
  return fmu_say(i, "value reference %u: the unit has no such variable of type %s.", reference, type);
}

static int fmu_get_real(fmu_instance *i, unsigned int reference, double *value) {
  fmu_motion *m = &i->now;
  if (reference >= FMU_VARIABLES) return fmu_unknown(i, reference, "real");
  const int kind = FMU_VARIABLE[reference].kind, at = FMU_VARIABLE[reference].index;
  if (kind == FMU_MODE || kind == FMU_EVENTS) return fmu_unknown(i, reference, "real");
  if (kind == FMU_TIME) *value = m->time;
  else if (kind == FMU_PARAMETER) *value = m->p[at];
  else if (kind == FMU_FORCE) *value = m->force;
  else if (m->phase == FMU_INSTANTIATED) *value = kind == FMU_STATE && at < PS_GIVEN ? m->start[at] : 0;
  else if (!fmu_refresh(i)) return 0;
  else *value = kind == FMU_STATE ? m->x[at] : kind == FMU_OUTPUT ? m->out[at] : m->z[at];
  return 1;
}

static int fmu_get_integer(fmu_instance *i, unsigned int reference, long *value) {
  fmu_motion *m = &i->now;
  const int kind = reference < FMU_VARIABLES ? FMU_VARIABLE[reference].kind : -1;
  if (kind == FMU_EVENTS) *value = m->events;
  else if (kind != FMU_MODE) return fmu_unknown(i, reference, "integer");
  else if (m->phase == FMU_INSTANTIATED) *value = 1;
  else if (!fmu_refresh(i)) return 0;
  else *value = 1 + ($mode);
  return 1;
}

static int fmu_set_real(fmu_instance *i, unsigned int reference, double value) {
  fmu_motion *m = &i->now;
  if (reference >= FMU_VARIABLES) return fmu_unknown(i, reference, "real");
  const int kind = FMU_VARIABLE[reference].kind, at = FMU_VARIABLE[reference].index;
  const int before = m->phase < FMU_STEPPING;
  double *target = kind == FMU_PARAMETER                                  ? &m->p[at]
                   : before && kind == FMU_FORCE                          ? &m->force
                   : before && kind == FMU_STATE && at < PS_GIVEN ? &m->start[at]
                                                                          : NULL;
  if (!target || m->phase == FMU_ENDED)
    return fmu_say(i, "%s cannot be set %s.", FMU_NAME[reference], target ? "after the end" : "here");
  int fits = fabs(value) <= $largest;
  if (kind == FMU_PARAMETER) {
    const double lower = FMU_RANGE[at].lower, upper = FMU_RANGE[at].upper;
    fits = fits && (FMU_RANGE[at].lower_closed ? value >= lower : value > lower);
    fits = fits && (FMU_RANGE[at].upper_closed ? value <= upper : value < upper);
    fits = fits && !(lower == 0 && !FMU_RANGE[at].lower_closed && value < $smallest);
    if (!fits)
      return fmu_say(i, "%s: got %.17g, need %s.", FMU_RANGE[at].is, value, FMU_RANGE[at].need);
  }
  if (!fits) return fmu_say(i, "%s: got %.17g, need a finite number.", FMU_NAME[reference], value);
  *target = value;
  m->stale = 1;
  return 1;
}

/* ---- States of the FMU ---- */

enum { FMU_BYTES = sizeof FMU_TOKEN + sizeof(fmu_motion) };

static int fmu_save(const fmu_instance *i, void **state) {
  if (!*state) *state = malloc(sizeof(fmu_motion));
  if (!*state) return fmu_say(i, "no memory for the state of the FMU.");
  memcpy(*state, &i->now, sizeof(fmu_motion));
  return 1;
}

static int fmu_restore(fmu_instance *i, const void *state) {
  if (!state) return fmu_say(i, "state of the FMU: got none.");
  memcpy(&i->now, state, sizeof(fmu_motion));
  return 1;
}

static int fmu_write(const fmu_instance *i, const void *state, void *bytes, size_t size) {
  if (!state || size < FMU_BYTES) return fmu_say(i, "state of the FMU: need %d bytes.", (int)FMU_BYTES);
  memcpy(bytes, FMU_TOKEN, sizeof FMU_TOKEN);
  memcpy((char *)bytes + sizeof FMU_TOKEN, state, sizeof(fmu_motion));
  return 1;
}

static int fmu_read(const fmu_instance *i, const void *bytes, size_t size, void **state) {
  if (size != FMU_BYTES || memcmp(bytes, FMU_TOKEN, sizeof FMU_TOKEN) != 0)
    return fmu_say(i, "state of the FMU: the bytes are of another FMU.");
  if (!*state) *state = malloc(sizeof(fmu_motion));
  if (!*state) return fmu_say(i, "no memory for the state of the FMU.");
  memcpy(*state, (const char *)bytes + sizeof FMU_TOKEN, sizeof(fmu_motion));
  return 1;
}

