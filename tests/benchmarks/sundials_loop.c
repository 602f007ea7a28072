/* An event loop around SUNDIALS: one phase after the other, each up to the zero of its guard.
 *
 * CasADi generates the rates, guards and transitions of all phases in front of this text, and
 * PHASES, STATES, WORK, LONGEST_STEP and the tables RATES, GUARDS, JUMPS. Each takes the state and a memory of one
 * number; a transition returns both. Nothing here knows a mechanism. */

#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdlib.h>
#include <string.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

enum { ADAMS, BDF, ERK };

typedef struct {
  int method, phase;
  double tolerance, memory;
  SUNContext context;
  N_Vector state;
  SUNMatrix matrix;
  SUNLinearSolver linear;
  SUNNonlinearSolver nonlinear;
  void *integrator;
  casadi_int iw[8];
  double w[WORK + 1];
  long evaluations;
} loop;

static int rates(double t, N_Vector y, N_Vector dy, void *data) {
  loop *l = data;
  const double *arg[2] = {N_VGetArrayPointer(y), &l->memory};
  double *res[1] = {N_VGetArrayPointer(dy)};
  (void)t;
  l->evaluations++;
  return RATES[l->phase](arg, res, l->iw, l->w, 0);
}

static int guard(double t, N_Vector y, double *value, void *data) {
  loop *l = data;
  const double *arg[2] = {N_VGetArrayPointer(y), &l->memory};
  double *res[1] = {value};
  (void)t;
  return GUARDS[l->phase](arg, res, l->iw, l->w, 0);
}

/* Creates the integrator of the present phase; what SUNDIALS prints on errors is left out. */
static int create(loop *l) {
  if (l->method == ERK) {
    void *m = l->integrator = ERKStepCreate(rates, 0, l->state, l->context);
    if (!m || ERKStepSetTableNum(m, ARKODE_FEHLBERG_13_7_8) || ERKStepSetErrFile(m, NULL) ||
        ERKStepSStolerances(m, l->tolerance, l->tolerance) || ERKStepSetUserData(m, l) ||
        ERKStepSetMaxNumSteps(m, 1000000) || ERKStepSetMaxStep(m, LONGEST_STEP) ||
        ERKStepRootInit(m, 1, guard) ||
        ERKStepSetNoInactiveRootWarn(m))
      return 0;
    return 1;
  }
  int direction = -1;
  void *m = l->integrator = CVodeCreate(l->method == ADAMS ? CV_ADAMS : CV_BDF, l->context);
  if (!m || CVodeInit(m, rates, 0, l->state) || CVodeSetErrFile(m, NULL) ||
      CVodeSStolerances(m, l->tolerance, l->tolerance) || CVodeSetUserData(m, l) ||
      CVodeSetMaxNumSteps(m, 1000000) || CVodeRootInit(m, 1, guard) ||
      CVodeSetRootDirection(m, &direction) || CVodeSetNoInactiveRootWarn(m))
    return 0;
  if (l->method == ADAMS) {
    l->nonlinear = SUNNonlinSol_FixedPoint(l->state, 0, l->context);
    return !CVodeSetNonlinearSolver(m, l->nonlinear);
  }
  l->matrix = SUNDenseMatrix(STATES, STATES, l->context);
  l->linear = SUNLinSol_Dense(l->state, l->matrix, l->context);
  return !CVodeSetLinearSolver(m, l->linear, l->matrix);
}

void loop_close(loop *l) {
  if (l->integrator && l->method == ERK) ERKStepFree(&l->integrator);
  if (l->integrator && l->method != ERK) CVodeFree(&l->integrator);
  if (l->nonlinear) SUNNonlinSolFree(l->nonlinear);
  if (l->linear) SUNLinSolFree(l->linear);
  if (l->matrix) SUNMatDestroy(l->matrix);
  if (l->state) N_VDestroy(l->state);
  if (l->context) SUNContext_Free(&l->context);
  free(l);
}

/* Makes all that does not depend on the start; NULL where SUNDIALS reports an error. */
loop *loop_open(int method, double tolerance) {
  loop *l = calloc(1, sizeof *l);
  if (!l) return NULL;
  l->method = method;
  l->tolerance = tolerance;
  if (!SUNContext_Create(NULL, &l->context)) {
    l->state = N_VNew_Serial(STATES, l->context);
    if (l->state && create(l)) return l;
  }
  loop_close(l);
  return NULL;
}

/* Integrates with Runge-Kutta steps up to the zero of the guard; 0 where it is not reached.
 *
 * ARKODE finds roots on an interpolant of degree 5 at most, whose error no tolerance bounds. So the
 * step in which it finds one is repeated to end at the root, which Newton's method then improves. */
static int runge_kutta_to_root(loop *l, double from, double horizon, double *root) {
  void *m = l->integrator;
  double *x = N_VGetArrayPointer(l->state), before = from, t = from, last[STATES], beyond[STATES];
  double rate[STATES], value, ahead, move;
  int flag;
  if (ERKStepReInit(m, rates, from, l->state) || ERKStepRootInit(m, 1, guard)) return 0;
  int direction = -1;
  if (ERKStepSetRootDirection(m, &direction) || ERKStepSetInitStep(m, 0)) return 0;
  do {
    before = t;
    memcpy(last, x, sizeof last);
    flag = ERKStepEvolve(m, horizon, l->state, &t, ARK_ONE_STEP);
  } while (flag == ARK_SUCCESS && t < horizon);
  if (flag != ARK_ROOT_RETURN) return 0;
  for (int i = 0; i < 8; i++) {
    memcpy(x, last, sizeof last);
    if (ERKStepReInit(m, rates, before, l->state) || ERKStepRootInit(m, 0, NULL) ||
        ERKStepSetInitStep(m, t - before) || ERKStepSetStopTime(m, t) ||
        ERKStepEvolve(m, t, l->state, root, ARK_NORMAL) < 0)
      return 0;
    const double *here[2] = {x, &l->memory}, *there[2] = {beyond, &l->memory};
    double *slope[1] = {rate}, *g[1] = {&value}, *g_ahead[1] = {&ahead};
    RATES[l->phase](here, slope, l->iw, l->w, 0);
    move = 1e-5 * (t - before);
    for (int j = 0; j < STATES; j++) beyond[j] = x[j] + move * rate[j];
    GUARDS[l->phase](here, g, l->iw, l->w, 0);
    GUARDS[l->phase](there, g_ahead, l->iw, l->w, 0);
    const double change = value * move / (value - ahead);
    if (!(fabs(change) > 4e-16 * t) || !(t + change > before)) break;
    t += change;
  }
  *root = t;
  return 1;
}

/* Integrates from `start` at t = 0 through all phases; writes the state at the end to `end` and the
 * time at which each phase ended to `times`. Returns 0, or 1 + the phase in which it failed. */
int loop_run(loop *l, const double *start, double horizon, double *end, double *times) {
  double *x = N_VGetArrayPointer(l->state), t = 0, next[STATES];
  memcpy(x, start, sizeof next);
  l->memory = 1;
  l->evaluations = 0;
  for (l->phase = 0; l->phase < PHASES; l->phase++) {
    double reached = t;
    if (l->method == ERK) {
      if (!runge_kutta_to_root(l, t, horizon, &reached)) return 1 + l->phase;
    } else {
      if (CVodeReInit(l->integrator, t, l->state)) return 1 + l->phase;
      const int flag = CVode(l->integrator, horizon, l->state, &reached, CV_NORMAL);
      if (flag != CV_ROOT_RETURN) return 1 + l->phase;
    }
    times[l->phase] = t = reached;
    const double *arg[2] = {x, &l->memory};
    double memory, *res[2] = {next, &memory};
    JUMPS[l->phase](arg, res, l->iw, l->w, 0);
    memcpy(x, next, sizeof next);
    l->memory = memory;
  }
  memcpy(end, x, sizeof next);
  return 0;
}

long loop_evaluations(const loop *l) { return l->evaluations; }
