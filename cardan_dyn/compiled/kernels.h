/* The functions of the module; each is described where it is written. */

#ifndef CARDAN_DYN_KERNELS_H
#define CARDAN_DYN_KERNELS_H

#include "machine.h"

#ifdef HAS_MACHINE
#define EVERY_FUNCTION(WITH) \
    WITH(instructions) \
    WITH(program) \
    WITH(run_program) \
    WITH(run_stages)
#else
#define EVERY_FUNCTION(WITH)
#endif

#define DECLARED(name) PyObject *name(PyObject *module, Arguments given, Py_ssize_t nargs);
EVERY_FUNCTION(DECLARED)
#undef DECLARED

#endif
