// A muscle's force behind FMI, whatever the standard's version. `model.h` gives INPUTS, START, TOKEN, Memory and
// force_at(). There are no continuous states: the memory moves on at each instant that is accepted, and the force at any
// other is a trial from there.

#include <stdlib.h>
#include <string.h>

#include "model.h"

#ifdef _WIN32
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif

typedef double Real;
typedef unsigned int Reference;
typedef enum { OK, WARNING, DISCARD, ERROR } Status;
typedef struct { Memory memory; Real time, input[INPUTS]; } Instance;

static Instance at_rest(void)
{
    Instance fresh;
    memset(&fresh, 0, sizeof fresh);
    memcpy(fresh.input, START, sizeof START);
    return fresh;
}

static void *instantiated(const char *token)
{
    Instance *muscle = strcmp(token, TOKEN) ? NULL : malloc(sizeof(Instance));
    if (muscle) *muscle = at_rest();
    return muscle;
}

static void accept(Instance *muscle)
{
    force_at(&muscle->memory, muscle->input, muscle->time);
}

// The inputs are those at the beginning of the step.
static void step_over(Instance *muscle, Real time, Real step)
{
    muscle->time = time;
    accept(muscle);
    muscle->time = time + step;
}

static Status get(const Instance *muscle, const Reference which[], size_t n, Real value[])
{
    for (size_t k = 0; k < n; ++k) {
        Memory trial = muscle->memory;
        if (which[k] > INPUTS + 1) return ERROR;
        if (which[k] < INPUTS) value[k] = muscle->input[which[k]];
        else value[k] = which[k] > INPUTS ? muscle->time : force_at(&trial, muscle->input, muscle->time);
    }
    return OK;
}

static Status set(Instance *muscle, const Reference which[], size_t n, const Real value[])
{
    for (size_t k = 0; k < n; ++k) {
        if (which[k] >= INPUTS) return ERROR;
        muscle->input[which[k]] = value[k];
    }
    return OK;
}

static Status copied(const void *from, void **state)
{
    if (!*state) *state = malloc(sizeof(Instance));
    if (!*state) return ERROR;
    memcpy(*state, from, sizeof(Instance));
    return OK;
}
