/* Arrays that Python hands over, and plans: index arrays and constants that a scene keeps.

   Arrays are asked for with their strides, so that transposes and slices need no copies. Numbers
   are doubles, indices 64-bit integers. Sizes are checked here, once: kernels read and write without
   looking. */

#ifndef CARDAN_DYN_ARRAYS_H
#define CARDAN_DYN_ARRAYS_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_AXES 4

typedef struct {
    Py_buffer buffer;
    double *at;
    Py_ssize_t size[MOST_AXES];
    Py_ssize_t step[MOST_AXES]; /* In numbers, not bytes. An axis of length 1 has step 0. */
} Array;

/* Arrays that a call holds; they are released together. */
typedef struct {
    Array *arrays;
    int held;
} Held;

/* Take an array with so many axes; writable ones are results. Returns NULL with an error set. */
Array *take(Held *held, PyObject *object, int axes, int writable);

/* Return 0 if an axis has a size, or 1 if `may_be_one`; else -1 with an error set. */
int has_size(const Array *array, int axis, Py_ssize_t size, int may_be_one);

void release(Held *held);

/* A plan: arrays of integers and of numbers, in an order that each kernel defines. */
typedef struct {
    Py_ssize_t integer_arrays, number_arrays;
    Py_ssize_t *integer_sizes, *number_sizes;
    int64_t **integers;
    double **numbers;
} Plan;

Plan *plan_of(PyObject *capsule);

#define EXACTLY(nargs, count)                                                                     \
    if ((nargs) != (count)) {                                                                     \
        PyErr_Format(PyExc_TypeError, "%d arguments are needed, not %zd", (int)(count), (nargs)); \
        return NULL;                                                                              \
    }

typedef PyObject *const *Arguments;

#endif
