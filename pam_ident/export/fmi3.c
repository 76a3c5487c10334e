// FMI 3.0, model exchange and co-simulation. Types and names are those of the standard, https://fmi-standard.org.

#include <stdbool.h>

#include "fmi.h"

typedef const char *String;

API String fmi3GetVersion(void) { return "3.0"; }

API void *fmi3InstantiateModelExchange(String name, String token, String resources, bool visible, bool logging,
                                       void *environment, const void *log)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)environment, (void)log;
    return instantiated(token);
}

API void *fmi3InstantiateCoSimulation(String name, String token, String resources, bool visible, bool logging,
                                      bool events, bool early, const Reference needed[], size_t n, void *environment,
                                      const void *log, const void *update)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)needed, (void)n;
    (void)environment, (void)log, (void)update;
    return instantiated(token);
}

API void fmi3FreeInstance(void *c) { free(c); }
API Status fmi3SetDebugLogging(void *c, bool on, size_t n, const String categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return OK;
}

API Status fmi3EnterInitializationMode(void *c, bool tolerant, Real tolerance, Real start, bool ends, Real stop)
{
    (void)tolerant, (void)tolerance, (void)ends, (void)stop;
    ((Instance *)c)->time = start;
    return OK;
}

API Status fmi3ExitInitializationMode(void *c) { (void)c; return OK; }
API Status fmi3EnterEventMode(void *c) { (void)c; return OK; }
API Status fmi3EnterStepMode(void *c) { (void)c; return OK; }
API Status fmi3Terminate(void *c) { (void)c; return OK; }
API Status fmi3Reset(void *c) { *(Instance *)c = at_rest(); return OK; }

API Status fmi3GetFloat64(void *c, const Reference which[], size_t n, Real value[], size_t values)
{
    return values < n ? ERROR : get(c, which, n, value);
}

API Status fmi3SetFloat64(void *c, const Reference which[], size_t n, const Real value[], size_t values)
{
    return values < n ? ERROR : set(c, which, n, value);
}

API Status fmi3GetFMUState(void *c, void **state) { return copied(c, state); }
API Status fmi3SetFMUState(void *c, void *state) { memcpy(c, state, sizeof(Instance)); return OK; }
API Status fmi3FreeFMUState(void *c, void **state) { (void)c; free(*state); *state = NULL; return OK; }
API Status fmi3SerializedFMUStateSize(void *c, void *state, size_t *size)
{
    (void)c, (void)state;
    *size = sizeof(Instance);
    return OK;
}

API Status fmi3SerializeFMUState(void *c, void *state, unsigned char bytes[], size_t size)
{
    (void)c;
    if (size < sizeof(Instance)) return ERROR;
    memcpy(bytes, state, sizeof(Instance));
    return OK;
}

API Status fmi3DeserializeFMUState(void *c, const unsigned char bytes[], size_t size, void **state)
{
    (void)c;
    return size < sizeof(Instance) ? ERROR : copied(bytes, state);
}

// Model exchange

API Status fmi3UpdateDiscreteStates(void *c, bool *again, bool *terminate, bool *nominals, bool *values, bool *timed,
                                    Real *next)
{
    (void)c, (void)next;
    *again = *terminate = *nominals = *values = *timed = false;
    return OK;
}

API Status fmi3EnterContinuousTimeMode(void *c) { accept(c); return OK; }
API Status fmi3CompletedIntegratorStep(void *c, bool never_back, bool *event, bool *terminate)
{
    (void)never_back;
    accept(c);
    *event = *terminate = false;
    return OK;
}

API Status fmi3SetTime(void *c, Real time) { ((Instance *)c)->time = time; return OK; }
API Status fmi3GetNumberOfContinuousStates(void *c, size_t *n) { (void)c; *n = 0; return OK; }
API Status fmi3GetNumberOfEventIndicators(void *c, size_t *n) { (void)c; *n = 0; return OK; }
API Status fmi3SetContinuousStates(void *c, const Real x[], size_t n) { (void)c, (void)x; return n ? ERROR : OK; }
API Status fmi3GetContinuousStates(void *c, Real x[], size_t n) { (void)c, (void)x; return n ? ERROR : OK; }
API Status fmi3GetContinuousStateDerivatives(void *c, Real dx[], size_t n) { (void)c, (void)dx; return n ? ERROR : OK; }
API Status fmi3GetNominalsOfContinuousStates(void *c, Real x[], size_t n) { (void)c, (void)x; return n ? ERROR : OK; }
API Status fmi3GetEventIndicators(void *c, Real z[], size_t n) { (void)c, (void)z; return n ? ERROR : OK; }

// Co-simulation

API Status fmi3DoStep(void *c, Real time, Real step, bool never_back, bool *event, bool *terminate, bool *early,
                      Real *reached)
{
    (void)never_back;
    step_over(c, time, step);
    *event = *terminate = *early = false;
    *reached = time + step;
    return OK;
}

// What there is nothing for: variables of other types, clocks, derivatives. They fail whatever they are given.
#define NONE(NAME) API Status fmi3##NAME(void) { return ERROR; }
#define NO_VARIABLES(TYPE) NONE(Get##TYPE) NONE(Set##TYPE)
NO_VARIABLES(Float32) NO_VARIABLES(Int8) NO_VARIABLES(UInt8) NO_VARIABLES(Int16) NO_VARIABLES(UInt16)
NO_VARIABLES(Int32) NO_VARIABLES(UInt32) NO_VARIABLES(Int64) NO_VARIABLES(UInt64) NO_VARIABLES(Boolean)
NO_VARIABLES(String) NO_VARIABLES(Binary) NO_VARIABLES(Clock)
NO_VARIABLES(IntervalDecimal) NO_VARIABLES(IntervalFraction) NO_VARIABLES(ShiftDecimal) NO_VARIABLES(ShiftFraction)
NONE(GetNumberOfVariableDependencies) NONE(GetVariableDependencies) NONE(GetDirectionalDerivative)
NONE(GetAdjointDerivative) NONE(GetOutputDerivatives) NONE(EvaluateDiscreteStates) NONE(EnterConfigurationMode)
NONE(ExitConfigurationMode) NONE(ActivateModelPartition)
API void *fmi3InstantiateScheduledExecution(void) { return NULL; }
