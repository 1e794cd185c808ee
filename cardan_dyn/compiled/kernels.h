/* The functions of the module; each is described where it is written. */

#ifndef CARDAN_DYN_KERNELS_H
#define CARDAN_DYN_KERNELS_H

#include "arrays.h"
#include "machine.h"

#ifdef HAS_MACHINE
#define EVERY_MACHINE(WITH) \
    WITH(program) \
    WITH(run_program) \
    WITH(run_stages)
#else
#define EVERY_MACHINE(WITH)
#endif

#define EVERY_FUNCTION(WITH) \
    EVERY_MACHINE(WITH) \
    WITH(against_load) \
    WITH(all_finite) \
    WITH(branch) \
    WITH(closure) \
    WITH(exerted) \
    WITH(explicit_step) \
    WITH(lattice) \
    WITH(longest) \
    WITH(magnified) \
    WITH(moved) \
    WITH(newton_step) \
    WITH(passive_accelerations) \
    WITH(passive_rates) \
    WITH(reactions) \
    WITH(refined) \
    WITH(rows) \
    WITH(same_side)

/* What plans are of. */
#define EVERY_PLAN(WITH) \
    WITH(branch) \
    WITH(closure) \
    WITH(exerted) \
    WITH(lattice) \
    WITH(load) \
    WITH(moves) \
    WITH(reactions) \
    WITH(rows) \
    WITH(stepping)

#define DECLARED(name) PyObject *name(PyObject *module, Arguments given, Py_ssize_t nargs);
EVERY_FUNCTION(DECLARED)
#undef DECLARED

#define DECLARED(name) extern const PlanKind name##_plan;
EVERY_PLAN(DECLARED)
#undef DECLARED

#endif
