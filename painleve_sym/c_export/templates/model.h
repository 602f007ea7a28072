/* $title
 *
$about
 *
 * Units are SI and radians. The numbers equal those of painleve-sym to the last bit where this code is
 * compiled as the package compiles it:
 *   $compiler
 *   $flags
 *
 * Arrays: p holds parameters (enum ${name}_parameter), x a state (enum ${name}_state), z the memory
 * (enum ${name}_memory), each in the order of its enum; the caller keeps them, and they are only
 * read unless a function says that it writes them. Nothing is checked that C cannot check: sizes,
 * indices, and that parameters are finite and in their range are the caller's business.
 *
 * Threads: there is no state besides the arguments; all functions may be called from any number of
 * threads at once, on different or the same constant data.
 *
 * Slip direction s = sign of the slip velocity, F_t = -mu s F_n on the mechanism, F_n >= 0. The gap
 * is positive where the contact is open; compression is -gap. */

#ifndef ${NAME}_MODEL_H
#define ${NAME}_MODEL_H

#ifdef __cplusplus
extern "C" {
#endif

#define ${NAME}_STATES $states_count
#define ${NAME}_PARAMETERS $parameters_count
#define ${NAME}_INPUTS $inputs_count
#define ${NAME}_CONSTANTS $constants_count
#define ${NAME}_MEMORY $memory_count
#define ${NAME}_MODES $modes_count
#define ${NAME}_OUTPUTS $outputs_count
#define ${NAME}_EVENTS $events_count
#define ${NAME}_STOPS $stops_count
#define ${NAME}_CONTACTS $contacts_count
#define ${NAME}_CASES $cases_count

$enums

/* Names as the package shows them, in the order of the enums. */
extern const char *const ${name}_state_names[${NAME}_STATES];
extern const char *const ${name}_parameter_names[${NAME}_PARAMETERS];
extern const char *const ${name}_mode_names[${NAME}_MODES];
extern const char *const ${name}_output_names[${NAME}_OUTPUTS];
extern const char *const ${name}_event_names[${NAME}_EVENTS];
extern const char *const ${name}_stop_names[${NAME}_STOPS];
extern const char *const ${name}_contact_names[${NAME}_CONTACTS];
extern const char *const ${name}_case_names[${NAME}_CASES];
/* Values that a parameter has where none is given. */
extern const double ${name}_default_parameters[${NAME}_PARAMETERS];

$contacts/* How to integrate; start from ${name}_default_options. */
typedef struct {
  double t_start; /* when the run begins; s; 0 by default */
  double t_end;   /* when it ends, > t_start; s */
  double rtol;  /* relative tolerance, 1e-15 <= rtol < 1 */
  /* Absolute tolerances, each in the unit of its state; HUGE_VAL: not part of the step control. */
  double atol[${NAME}_STATES];
  double first_step; /* s; 0: chosen */
  double max_step;   /* s; 0: no bound */
  long max_steps;    /* >= 0; 0: what happens at the start alone */
  long max_events;   /* >= 1 */
  /* The run ends 1: after the first event of that kind and all else at its instant; 2: before it. */
  unsigned char until[${NAME}_EVENTS];
  int keep_steps; /* 1: keep what ${name}_at needs */
} ${name}_options;

/* One contact at a state, as if it were closed and the others open. A[0] is A of the normal
 * acceleration a_n = A F_n + B in slip to the left, A[1] in slip to the right, for F_n > 0; for
 * F_n < 0 of a contact that holds from both sides they change places. A and A_stick are in 1/kg, B
 * and B_stick in m/s^2: a_n = A_stick F_n + B_stick in sticking. W_nn, W_nt, W_tt (1/kg), b_n, b_t
 * (m/s^2): a_n = W_nn F_n + W_nt F_t + b_n, a_t = W_nt F_n + W_tt F_t + b_t. */
typedef struct {
  double A[2], B, A_stick, B_stick, mu, W_nn, W_nt, W_tt, b_n, b_t;
} ${name}_coefficients;

/* The forces that are possible at one rigid contact: `count` of them. */
typedef struct {
  int count;
  double normal_force[6], tangential_force[6]; /* N */
  int slip[6]; /* sign of the slip velocity; 0 in sticking */
  int mode[6]; /* enum ${name}_case: slip, stick, or liftoff: it opens */
} ${name}_solutions;

typedef struct {
  double time;                 /* s */
  int kind;                    /* enum ${name}_event_kind */
  int mode_before, mode_after; /* enum ${name}_mode */
  /* States just before and just after; outputs (enum ${name}_output) just before. */
  double before[${NAME}_STATES], after[${NAME}_STATES], outputs[${NAME}_OUTPUTS];
$event_contact} ${name}_event;

/* A run. It owns what it points to; only read it, and give it to ${name}_free when done. */
typedef struct {
  double time; /* where it ended; s */
  int mode;    /* enum ${name}_mode, at the end */
  int stop;    /* enum ${name}_stop */
  /* At the end. */
  double state[${NAME}_STATES], memory[$memory_room], outputs[${NAME}_OUTPUTS];
  long accepted_steps, rejected_steps, field_evaluations;
  long event_count;
  ${name}_event *events; /* in the order in which they happened */
  long step_count;       /* 0 unless options.keep_steps */
  double *steps;         /* for ${name}_at, */
  long step_width;       /* numbers of each step */
} ${name}_run;

/* Completes a state: coordinates and velocities (the first $motion_count entries of x) are read, every
 * other state is written: $completed. */
void ${name}_complete_state(const double *p, double *x);

$press/* Writes the absolute tolerances that the package uses for a run from the state x: scaled to the
 * contact and to the available energy. */
void ${name}_tolerances(const double *p, const double *x, double rtol, double *atol);

/* Writes the options that the package uses for a run from the state x: those tolerances, at most
 * $max_steps steps and $max_events events, until no event. The package's rtol is $rtol. */
void ${name}_default_options(const double *p, const double *x, double t_end, double rtol,
                     ${name}_options *options);

/* Follows the motion from the state x at options->t_start. Returns a run for the caller to free, also where it
 * stopped early (see run->stop); NULL without memory. */
${name}_run *${name}_simulate(const double *p, const double *x, const ${name}_options *options);

/* Continues a motion: from state, memory and mode of the end of a run, or of an event after it, at
 * options->t_start. Cut anywhere and continued it is the motion that was not cut, but for rounding.
 * The inputs (enum ${name}_input) are held until the end of the run, in place of those in p; NULL:
 * those in p. mode is -1 where the state chooses it, as for ${name}_simulate; z may be NULL then. */
${name}_run *${name}_simulate_from(const double *p, const double *x, const double *z, int mode,
                     const double *inputs, const ${name}_options *options);

/* Writes to x how gaps and slip velocities, which are states of their own, follow where parameters or
 * inputs change from `before` to p at the same coordinates and velocities; other states stay. Loads
 * change none. Returns -1, or the index of a closed contact that would be moved from its place;
 * then x stays as it is. */
int ${name}_change_parameters(const double *before, const double *p, double *x);

/* Frees a run; NULL is allowed. */
void ${name}_free(${name}_run *run);

/* Writes the state of a run at time t to x and returns 1; returns 0 where t lies outside the run or
 * its steps were not kept. At an event this is the state after it. */
int ${name}_at(const ${name}_run *run, double t, double *x);

/* Writes the rates of all states in a mode, in their units per s. z may be NULL without memory. */
void ${name}_rates(const double *p, int mode, const double *x, const double *z, double *rates);

/* Writes forces, gap and energies in a mode: ${NAME}_OUTPUTS numbers. */
void ${name}_outputs(const double *p, int mode, const double *x, const double *z, double *outputs);

/* Writes the parameters, then what is computed from them once: ${NAME}_CONSTANTS numbers
 * ($constants). */
void ${name}_constants(const double *p, double *c);

/* Writes the rigid contact problem at the state x, all contacts taken as closed: the accelerations
 * a = W F + b in the rows n1, t1, n2, t2, ... W holds 2 ${NAME}_CONTACTS rows one after the other, in 1/kg;
 * b as many numbers, in m/s^2; mu the friction coefficient of each contact. */
void ${name}_contact_problem(const double *p, const double *x, double *W, double *b, double *mu);

/* Writes the numbers of one contact (its index in ${name}_contact_names). */
void ${name}_contact_coefficients(const double *p, const double *x, int contact,
                     ${name}_coefficients *coefficients);

/* Returns the case (enum ${name}_case) of one rigid contact at the state x: which forces are
 * possible, as if it were closed and the others open. The slip velocity is that of x, and sticking
 * is considered where it is exactly 0. */
int ${name}_classify(const double *p, const double *x, int contact);

/* Writes the forces that ${name}_classify counts, and returns the case. Where A = B = 0 a ray of
 * forces is possible besides those that are written; where the case is hyperstatic, other forces
 * have the same motion. */
int ${name}_solve(const double *p, const double *x, int contact, ${name}_solutions *solutions);

/* Returns the case of one contact with these coefficients in slip along s, -1 or 1, whatever slip
 * velocity the state has. */
int ${name}_case_in_slip(const ${name}_coefficients *coefficients, int contact, int s);

#ifdef __cplusplus
}
#endif

#endif
