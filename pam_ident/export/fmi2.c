// FMI 2.0, model exchange and co-simulation. Types and names are those of the standard, https://fmi-standard.org.

#include "fmi.h"

typedef int Integer;
typedef int Boolean;
typedef const char *String;
typedef struct { Boolean new_states, terminate, nominals, values, time_defined; Real time; } EventInfo;

API String fmi2GetTypesPlatform(void) { return "default"; }
API String fmi2GetVersion(void) { return "2.0"; }

API void *fmi2Instantiate(String name, int kind, String guid, String resources, const void *callbacks, Boolean visible,
                          Boolean logging)
{
    (void)name, (void)kind, (void)resources, (void)callbacks, (void)visible, (void)logging;
    return instantiated(guid);
}

API void fmi2FreeInstance(void *c) { free(c); }
API Status fmi2SetDebugLogging(void *c, Boolean on, size_t n, const String categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return OK;
}

API Status fmi2SetupExperiment(void *c, Boolean tolerant, Real tolerance, Real start, Boolean ends, Real stop)
{
    (void)tolerant, (void)tolerance, (void)ends, (void)stop;
    ((Instance *)c)->time = start;
    return OK;
}

API Status fmi2EnterInitializationMode(void *c) { (void)c; return OK; }
API Status fmi2ExitInitializationMode(void *c) { (void)c; return OK; }
API Status fmi2Terminate(void *c) { (void)c; return OK; }
API Status fmi2Reset(void *c) { *(Instance *)c = at_rest(); return OK; }

API Status fmi2GetReal(void *c, const Reference which[], size_t n, Real value[])
{
    return get(c, which, n, value);
}

API Status fmi2SetReal(void *c, const Reference which[], size_t n, const Real value[])
{
    return set(c, which, n, value);
}

// There are no variables of other types.
#define NO_VARIABLES(TYPE, T) \
    API Status fmi2Get##TYPE(void *c, const Reference which[], size_t n, T value[]) \
    { (void)c, (void)which, (void)value; return n ? ERROR : OK; } \
    API Status fmi2Set##TYPE(void *c, const Reference which[], size_t n, const T value[]) \
    { (void)c, (void)which, (void)value; return n ? ERROR : OK; }
NO_VARIABLES(Integer, Integer)
NO_VARIABLES(Boolean, Boolean)
NO_VARIABLES(String, String)

API Status fmi2GetFMUstate(void *c, void **state) { return copied(c, state); }
API Status fmi2SetFMUstate(void *c, void *state) { memcpy(c, state, sizeof(Instance)); return OK; }
API Status fmi2FreeFMUstate(void *c, void **state) { (void)c; free(*state); *state = NULL; return OK; }
API Status fmi2SerializedFMUstateSize(void *c, void *state, size_t *size)
{
    (void)c, (void)state;
    *size = sizeof(Instance);
    return OK;
}

API Status fmi2SerializeFMUstate(void *c, void *state, char bytes[], size_t size)
{
    (void)c;
    if (size < sizeof(Instance)) return ERROR;
    memcpy(bytes, state, sizeof(Instance));
    return OK;
}

API Status fmi2DeSerializeFMUstate(void *c, const char bytes[], size_t size, void **state)
{
    (void)c;
    return size < sizeof(Instance) ? ERROR : copied(bytes, state);
}

API Status fmi2GetDirectionalDerivative(void *c, const Reference of[], size_t m, const Reference by[], size_t n,
                                        const Real seed[], Real value[])
{
    (void)c, (void)of, (void)m, (void)by, (void)n, (void)seed, (void)value;
    return ERROR;
}

// Model exchange

API Status fmi2EnterEventMode(void *c) { (void)c; return OK; }
API Status fmi2NewDiscreteStates(void *c, EventInfo *info)
{
    (void)c;
    memset(info, 0, sizeof *info);
    return OK;
}

API Status fmi2EnterContinuousTimeMode(void *c) { accept(c); return OK; }
API Status fmi2CompletedIntegratorStep(void *c, Boolean never_back, Boolean *event, Boolean *terminate)
{
    (void)never_back;
    accept(c);
    *event = *terminate = 0;
    return OK;
}

API Status fmi2SetTime(void *c, Real time) { ((Instance *)c)->time = time; return OK; }
API Status fmi2SetContinuousStates(void *c, const Real x[], size_t n) { (void)c, (void)x; return n ? ERROR : OK; }
API Status fmi2GetContinuousStates(void *c, Real x[], size_t n) { (void)c, (void)x; return n ? ERROR : OK; }
API Status fmi2GetDerivatives(void *c, Real dx[], size_t n) { (void)c, (void)dx; return n ? ERROR : OK; }
API Status fmi2GetNominalsOfContinuousStates(void *c, Real x[], size_t n) { (void)c, (void)x; return n ? ERROR : OK; }
API Status fmi2GetEventIndicators(void *c, Real z[], size_t n) { (void)c, (void)z; return n ? ERROR : OK; }

// Co-simulation: the inputs are those at the beginning of a step.

API Status fmi2DoStep(void *c, Real time, Real step, Boolean never_back)
{
    (void)never_back;
    step_over(c, time, step);
    return OK;
}

API Status fmi2CancelStep(void *c) { (void)c; return ERROR; }
API Status fmi2SetRealInputDerivatives(void *c, const Reference which[], size_t n, const Integer order[],
                                       const Real value[])
{
    (void)c, (void)which, (void)n, (void)order, (void)value;
    return ERROR;
}

API Status fmi2GetRealOutputDerivatives(void *c, const Reference which[], size_t n, const Integer order[], Real value[])
{
    (void)c, (void)which, (void)n, (void)order, (void)value;
    return ERROR;
}

#define NO_STATUS(TYPE, T) \
    API Status fmi2Get##TYPE##Status(void *c, int kind, T *value) { (void)c, (void)kind, (void)value; return DISCARD; }
API Status fmi2GetStatus(void *c, int kind, Status *value) { (void)c, (void)kind, (void)value; return DISCARD; }
NO_STATUS(Real, Real)
NO_STATUS(Integer, Integer)
NO_STATUS(Boolean, Boolean)
NO_STATUS(String, String)
