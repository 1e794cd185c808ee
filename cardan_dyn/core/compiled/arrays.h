/* Arrays that Python hands over.

   A function checks how many arguments it has, takes its arrays, compares their sizes, computes
   without looking at them again, and releases what it took. */

#ifndef CARDAN_DYN_ARRAYS_H
#define CARDAN_DYN_ARRAYS_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef PyObject *const *Arguments;

/* An array that a call holds; they are a list. */
typedef struct Taken {
    Py_buffer buffer;
    struct Taken *next;
} Taken;

/* Take an array of doubles, "d", or of 32-bit integers, "i", with flags of `PyObject_GetBuffer`.
   Returns NULL with an error set. */
const Py_buffer *take(Taken **held, PyObject *object, char type, int flags);

/* Take so many numbers without gaps, in any shape. Returns NULL with an error set. */
void *take_all(Taken **held, PyObject *object, char type, int flags, Py_ssize_t count);

void release(Taken **held);

#define EXACTLY(nargs, count)                                                                     \
    if ((nargs) != (count)) {                                                                     \
        PyErr_Format(PyExc_TypeError, "%d arguments are needed, not %zd", (int)(count), (nargs)); \
        return NULL;                                                                              \
    }

#endif
