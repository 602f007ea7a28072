/* ---- FMI 3.0 ---- */

#include <stdbool.h>
#include <stdint.h>

/* The declarations of the standard (fmi-standard.org); a tool may have read its own before. */
#ifndef fmi3Functions_h
typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8, fmi3Byte;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean, fmi3Clock;
typedef const char *fmi3String;
typedef const fmi3Byte *fmi3Binary;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum {
  fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent
} fmi3DependencyKind;
typedef enum {
  fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged
} fmi3IntervalQualifier;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean,
                                               fmi3Boolean, fmi3Boolean, fmi3Boolean, fmi3Boolean *,
                                               fmi3Float64 *);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);
#endif

#define FMU_OF(c) ((fmu_instance *)(c))
#define FMU_3 FMU_EXPORT fmi3Status
#define FMU_REFERENCES fmi3Instance c, const fmi3ValueReference r[], size_t n

static void fmu_log(const fmu_instance *i, const char *text) {
  ((fmi3LogMessageCallback)(uintptr_t)i->logger)(i->environment, fmi3Error, "logStatusError", text);
}

static fmi3Status fmu_status(int good) { return good ? fmi3OK : fmi3Error; }

/* What this FMU has not, which its model description says. */
static fmi3Status fmu_missing(fmi3Instance c, size_t n) {
  if (n) fmu_say(FMU_OF(c), "this FMU has no such variable or function.");
  return n ? fmi3Error : fmi3OK;
}

FMU_EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

FMU_3 fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) {
  (void)c, (void)on, (void)n, (void)categories;
  return fmi3OK;
}

FMU_EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token,
                                                     fmi3String resources, fmi3Boolean visible,
                                                     fmi3Boolean logging,
                                                     fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback log) {
  (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log;
  return NULL;
}

FMU_EXPORT fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference intermediate[], size_t n,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update) {
  (void)resources, (void)visible, (void)logging, (void)event_mode;
  (void)intermediate, (void)n, (void)update;
  fmu_instance *c = fmu_new(name, token, (void *)(uintptr_t)log, environment, fmu_log);
  if (c) c->early = early_return;
  return c;
}

FMU_EXPORT fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
    fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
  (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log;
  (void)update, (void)lock, (void)unlock;
  return NULL;
}

FMU_EXPORT void fmi3FreeInstance(fmi3Instance c) { fmu_free(FMU_OF(c)); }

FMU_3 fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                  fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop) {
  (void)stop_defined, (void)stop;
  FMU_OF(c)->now.phase = FMU_INITIALIZATION;
  return fmu_status(fmu_setup(FMU_OF(c), tolerance_defined, tolerance, start));
}

FMU_3 fmi3ExitInitializationMode(fmi3Instance c) { return fmu_status(fmu_initialized(FMU_OF(c))); }

FMU_3 fmi3Terminate(fmi3Instance c) {
  FMU_OF(c)->now.phase = FMU_ENDED;
  return fmi3OK;
}

FMU_3 fmi3Reset(fmi3Instance c) {
  fmu_reset(FMU_OF(c));
  return fmi3OK;
}

/* ---- Variables ---- */

FMU_3 fmi3GetFloat64(FMU_REFERENCES, fmi3Float64 value[], size_t values) {
  int good = n == values;
  for (size_t k = 0; k < n && good; k++) good = fmu_get_real(FMU_OF(c), r[k], &value[k]);
  return fmu_status(good);
}

FMU_3 fmi3SetFloat64(FMU_REFERENCES, const fmi3Float64 value[], size_t values) {
  int good = n == values;
  for (size_t k = 0; k < n && good; k++) good = fmu_set_real(FMU_OF(c), r[k], value[k]);
  return fmu_status(good);
}

FMU_3 fmi3GetInt64(FMU_REFERENCES, fmi3Int64 value[], size_t values) {
  int good = n == values;
  for (size_t k = 0; k < n && good; k++) {
    long own = 0;
    good = fmu_get_integer(FMU_OF(c), r[k], &own);
    value[k] = own;
  }
  return fmu_status(good);
}

FMU_3 fmi3SetInt64(FMU_REFERENCES, const fmi3Int64 value[], size_t values) {
  (void)r, (void)value, (void)values;
  return fmu_missing(c, n);
}

/* Types that no variable has. */
#define FMU_NONE(type)                                                            \
  FMU_3 fmi3Get##type(FMU_REFERENCES, fmi3##type value[], size_t values) {       \
    (void)r, (void)value, (void)values;                                           \
    return fmu_missing(c, n);                                                     \
  }                                                                               \
  FMU_3 fmi3Set##type(FMU_REFERENCES, const fmi3##type value[], size_t values) { \
    (void)r, (void)value, (void)values;                                           \
    return fmu_missing(c, n);                                                     \
  }
FMU_NONE(Float32)
FMU_NONE(Int8)
FMU_NONE(UInt8)
FMU_NONE(Int16)
FMU_NONE(UInt16)
FMU_NONE(Int32)
FMU_NONE(UInt32)
FMU_NONE(UInt64)
FMU_NONE(Boolean)
FMU_NONE(String)

FMU_3 fmi3GetBinary(FMU_REFERENCES, size_t sizes[], fmi3Binary value[], size_t values) {
  (void)r, (void)sizes, (void)value, (void)values;
  return fmu_missing(c, n);
}

FMU_3 fmi3SetBinary(FMU_REFERENCES, const size_t sizes[], const fmi3Binary value[], size_t values) {
  (void)r, (void)sizes, (void)value, (void)values;
  return fmu_missing(c, n);
}

FMU_3 fmi3GetClock(FMU_REFERENCES, fmi3Clock value[]) {
  (void)r, (void)value;
  return fmu_missing(c, n);
}

FMU_3 fmi3SetClock(FMU_REFERENCES, const fmi3Clock value[]) {
  (void)r, (void)value;
  return fmu_missing(c, n);
}

FMU_3 fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference r, size_t *n) {
  (void)r, (void)n;
  return fmu_missing(c, 1);
}

FMU_3 fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent, size_t elements[],
                                  fmi3ValueReference independents[], size_t of_independents[],
                                  fmi3DependencyKind kinds[], size_t n) {
  (void)dependent, (void)elements, (void)independents, (void)of_independents, (void)kinds, (void)n;
  return fmu_missing(c, 1);
}

/* ---- States of the FMU ---- */

FMU_3 fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
  return fmu_status(fmu_save(FMU_OF(c), state));
}

FMU_3 fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
  return fmu_status(fmu_restore(FMU_OF(c), state));
}

FMU_3 fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
  (void)c;
  if (state) free(*state);
  if (state) *state = NULL;
  return fmi3OK;
}

FMU_3 fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
  (void)c, (void)state;
  *size = FMU_BYTES;
  return fmi3OK;
}

FMU_3 fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
  return fmu_status(fmu_write(FMU_OF(c), state, bytes, size));
}

FMU_3 fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size,
                              fmi3FMUState *state) {
  return fmu_status(fmu_read(FMU_OF(c), bytes, size, state));
}

/* ---- What this FMU has not ---- */

FMU_3 fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknown[], size_t n,
                                   const fmi3ValueReference known[], size_t of_known,
                                   const fmi3Float64 seed[], size_t seeds, fmi3Float64 value[],
                                   size_t values) {
  (void)unknown, (void)n, (void)known, (void)of_known, (void)seed, (void)seeds, (void)value, (void)values;
  return fmu_missing(c, 1);
}

FMU_3 fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknown[], size_t n,
                               const fmi3ValueReference known[], size_t of_known,
                               const fmi3Float64 seed[], size_t seeds, fmi3Float64 value[],
                               size_t values) {
  (void)unknown, (void)n, (void)known, (void)of_known, (void)seed, (void)seeds, (void)value, (void)values;
  return fmu_missing(c, 1);
}

#define FMU_NO_CALL(name) \
  FMU_3 fmi3##name(fmi3Instance c) { return fmu_missing(c, 1); }
FMU_NO_CALL(EnterConfigurationMode)
FMU_NO_CALL(ExitConfigurationMode)
FMU_NO_CALL(EnterEventMode)
FMU_NO_CALL(EvaluateDiscreteStates)
FMU_NO_CALL(EnterContinuousTimeMode)
FMU_NO_CALL(EnterStepMode)

FMU_3 fmi3GetIntervalDecimal(FMU_REFERENCES, fmi3Float64 interval[], fmi3IntervalQualifier kind[]) {
  (void)r, (void)interval, (void)kind;
  return fmu_missing(c, n);
}

FMU_3 fmi3GetIntervalFraction(FMU_REFERENCES, fmi3UInt64 counter[], fmi3UInt64 resolution[],
                              fmi3IntervalQualifier kind[]) {
  (void)r, (void)counter, (void)resolution, (void)kind;
  return fmu_missing(c, n);
}

FMU_3 fmi3GetShiftDecimal(FMU_REFERENCES, fmi3Float64 shift[]) {
  (void)r, (void)shift;
  return fmu_missing(c, n);
}

FMU_3 fmi3GetShiftFraction(FMU_REFERENCES, fmi3UInt64 counter[], fmi3UInt64 resolution[]) {
  (void)r, (void)counter, (void)resolution;
  return fmu_missing(c, n);
}

FMU_3 fmi3SetIntervalDecimal(FMU_REFERENCES, const fmi3Float64 interval[]) {
  (void)r, (void)interval;
  return fmu_missing(c, n);
}

FMU_3 fmi3SetIntervalFraction(FMU_REFERENCES, const fmi3UInt64 counter[],
                              const fmi3UInt64 resolution[]) {
  (void)r, (void)counter, (void)resolution;
  return fmu_missing(c, n);
}

FMU_3 fmi3SetShiftDecimal(FMU_REFERENCES, const fmi3Float64 shift[]) {
  (void)r, (void)shift;
  return fmu_missing(c, n);
}

FMU_3 fmi3SetShiftFraction(FMU_REFERENCES, const fmi3UInt64 counter[], const fmi3UInt64 resolution[]) {
  (void)r, (void)counter, (void)resolution;
  return fmu_missing(c, n);
}

FMU_3 fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *end,
                               fmi3Boolean *nominals, fmi3Boolean *states, fmi3Boolean *event,
                               fmi3Float64 *time) {
  (void)again, (void)end, (void)nominals, (void)states, (void)event, (void)time;
  return fmu_missing(c, 1);
}

FMU_3 fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_return, fmi3Boolean *event,
                                  fmi3Boolean *end) {
  (void)no_return, (void)event, (void)end;
  return fmu_missing(c, 1);
}

FMU_3 fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
  (void)time;
  return fmu_missing(c, 1);
}

FMU_3 fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) {
  (void)x;
  return fmu_missing(c, n + 1);
}

#define FMU_NO_VECTOR(name)                                       \
  FMU_3 fmi3Get##name(fmi3Instance c, fmi3Float64 x[], size_t n) { \
    (void)x;                                                       \
    return fmu_missing(c, n + 1);                                  \
  }
FMU_NO_VECTOR(ContinuousStateDerivatives)
FMU_NO_VECTOR(EventIndicators)
FMU_NO_VECTOR(ContinuousStates)
FMU_NO_VECTOR(NominalsOfContinuousStates)

FMU_3 fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) {
  (void)n;
  return fmu_missing(c, 1);
}

FMU_3 fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) {
  (void)n;
  return fmu_missing(c, 1);
}

FMU_3 fmi3GetOutputDerivatives(FMU_REFERENCES, const fmi3Int32 order[], fmi3Float64 value[],
                               size_t values) {
  (void)r, (void)order, (void)value, (void)values;
  return fmu_missing(c, n);
}

FMU_3 fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time) {
  (void)clock, (void)time;
  return fmu_missing(c, 1);
}

/* ---- Steps ---- */

FMU_3 fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_return,
                 fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last) {
  (void)no_return;
  const int done = fmu_step(FMU_OF(c), t, h);
  *event = false;
  *end = done == FMU_END;
  *early = *end && FMU_OF(c)->early;
  *last = FMU_OF(c)->now.time;
  return fmu_status(done != FMU_ERROR);
}
