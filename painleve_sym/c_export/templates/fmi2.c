/* ---- FMI 2.0 ---- */

/* The declarations of the standard (fmi-standard.org); a tool may have read its own before. */
#ifndef fmi2Functions_h
typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef char fmi2Byte;
typedef const char *fmi2String;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum {
  fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated
} fmi2StatusKind;
typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String,
                                   fmi2String, ...);
typedef struct {
  fmi2CallbackLogger logger;
  void *(*allocateMemory)(size_t, size_t);
  void (*freeMemory)(void *);
  void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
  fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;
#endif

#define FMU_OF(c) ((fmu_instance *)(c))

static void fmu_log(const fmu_instance *i, const char *text) {
  const fmi2CallbackFunctions *functions = (const fmi2CallbackFunctions *)i->logger;
  if (functions->logger)
    functions->logger(functions->componentEnvironment, i->name ? i->name : "", fmi2Error,
                      "logStatusError", "%s", text);
}

static fmi2Status fmu_status(int good) { return good ? fmi2OK : fmi2Error; }

/* What this FMU has not, which its model description says. */
static fmi2Status fmu_missing(fmi2Component c, size_t n) {
  if (n) fmu_say(FMU_OF(c), "this FMU has no such variable or function.");
  return n ? fmi2Error : fmi2OK;
}

FMU_EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
FMU_EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

FMU_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n,
                                          const fmi2String categories[]) {
  (void)c, (void)on, (void)n, (void)categories;
  return fmi2OK;
}

FMU_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                         fmi2String resources, const fmi2CallbackFunctions *functions,
                                         fmi2Boolean visible, fmi2Boolean logging) {
  (void)resources, (void)visible, (void)logging;
  if (type != fmi2CoSimulation) return NULL;
  return fmu_new(name, guid, (void *)functions, NULL, fmu_log);
}

FMU_EXPORT void fmi2FreeInstance(fmi2Component c) { fmu_free(FMU_OF(c)); }

FMU_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined,
                                          fmi2Real tolerance, fmi2Real start,
                                          fmi2Boolean stop_defined, fmi2Real stop) {
  (void)stop_defined, (void)stop;
  return fmu_status(fmu_setup(FMU_OF(c), tolerance_defined, tolerance, start));
}

FMU_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  FMU_OF(c)->now.phase = FMU_INITIALIZATION;
  return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return fmu_status(fmu_initialized(FMU_OF(c)));
}

FMU_EXPORT fmi2Status fmi2Terminate(fmi2Component c) {
  FMU_OF(c)->now.phase = FMU_ENDED;
  return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2Reset(fmi2Component c) {
  fmu_reset(FMU_OF(c));
  return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                  fmi2Real value[]) {
  int good = 1;
  for (size_t k = 0; k < n && good; k++) good = fmu_get_real(FMU_OF(c), r[k], &value[k]);
  return fmu_status(good);
}

FMU_EXPORT fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                     fmi2Integer value[]) {
  int good = 1;
  for (size_t k = 0; k < n && good; k++) {
    long own = 0;
    good = fmu_get_integer(FMU_OF(c), r[k], &own);
    value[k] = (fmi2Integer)own;
  }
  return fmu_status(good);
}

FMU_EXPORT fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                     fmi2Boolean value[]) {
  (void)r, (void)value;
  return fmu_missing(c, n);
}

FMU_EXPORT fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                    fmi2String value[]) {
  (void)r, (void)value;
  return fmu_missing(c, n);
}

FMU_EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                  const fmi2Real value[]) {
  int good = 1;
  for (size_t k = 0; k < n && good; k++) good = fmu_set_real(FMU_OF(c), r[k], value[k]);
  return fmu_status(good);
}

FMU_EXPORT fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                     const fmi2Integer value[]) {
  (void)r, (void)value;
  return fmu_missing(c, n);
}

FMU_EXPORT fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                     const fmi2Boolean value[]) {
  (void)r, (void)value;
  return fmu_missing(c, n);
}

FMU_EXPORT fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                    const fmi2String value[]) {
  (void)r, (void)value;
  return fmu_missing(c, n);
}

FMU_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
  return fmu_status(fmu_save(FMU_OF(c), state));
}

FMU_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  return fmu_status(fmu_restore(FMU_OF(c), state));
}

FMU_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
  (void)c;
  if (state) free(*state);
  if (state) *state = NULL;
  return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
  (void)c, (void)state;
  *size = FMU_BYTES;
  return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                            size_t size) {
  return fmu_status(fmu_write(FMU_OF(c), state, bytes, size));
}

FMU_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                              fmi2FMUstate *state) {
  return fmu_status(fmu_read(FMU_OF(c), bytes, size, state));
}

FMU_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                                   size_t n, const fmi2ValueReference known[],
                                                   size_t of_known, const fmi2Real seed[],
                                                   fmi2Real value[]) {
  (void)unknown, (void)known, (void)of_known, (void)seed, (void)value;
  return fmu_missing(c, n + 1);
}

FMU_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[],
                                                  size_t n, const fmi2Integer order[],
                                                  const fmi2Real value[]) {
  (void)r, (void)order, (void)value;
  return fmu_missing(c, n);
}

FMU_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[],
                                                   size_t n, const fmi2Integer order[],
                                                   fmi2Real value[]) {
  (void)r, (void)order, (void)value;
  return fmu_missing(c, n);
}

FMU_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_return) {
  (void)no_return;
  const int done = fmu_step(FMU_OF(c), t, h);
  return done == FMU_OK ? fmi2OK : done == FMU_END ? fmi2Discard : fmi2Error;
}

FMU_EXPORT fmi2Status fmi2CancelStep(fmi2Component c) { return fmu_missing(c, 1); }

FMU_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
  (void)c, (void)kind;
  *value = fmi2OK;
  return fmi2OK;
}

FMU_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
  *value = FMU_OF(c)->now.time;
  return kind == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard;
}

FMU_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind,
                                           fmi2Integer *value) {
  (void)c, (void)kind, (void)value;
  return fmi2Discard;
}

FMU_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind,
                                           fmi2Boolean *value) {
  *value = FMU_OF(c)->now.phase == FMU_ENDED;
  return kind == fmi2Terminated ? fmi2OK : fmi2Discard;
}

FMU_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind,
                                          fmi2String *value) {
  (void)c, (void)kind;
  *value = "";
  return fmi2Discard;
}
