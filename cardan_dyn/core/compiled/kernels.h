/* The functions of the module; each is described where it is written. */

#ifndef CARDAN_DYN_KERNELS_H
#define CARDAN_DYN_KERNELS_H

#include "arrays.h"
#include "machine.h"

#ifdef HAS_MACHINE
#define EVERY_MACHINE(WITH) \
    WITH(instructions) \
    WITH(program) \
    WITH(run_one) \
    WITH(run_program) \
    WITH(run_stages)
#else
#define EVERY_MACHINE(WITH)
#endif

#define EVERY_FUNCTION(WITH) \
    EVERY_MACHINE(WITH) \
    WITH(explicit_step)

#define DECLARED(name) PyObject *name(PyObject *module, Arguments given, Py_ssize_t nargs);
EVERY_FUNCTION(DECLARED)
#undef DECLARED

#endif
