/* Arrays that Python hands over, and plans: index arrays and constants that a scene keeps.

   A function checks how many arguments it has, takes its plan and its arrays, compares their sizes,
   computes without looking at them again, and releases what it took at `done`. Arrays are asked for
   with their strides, so that transposes and slices need no copies. Numbers are doubles, indices
   64-bit integers. */

#ifndef CARDAN_DYN_ARRAYS_H
#define CARDAN_DYN_ARRAYS_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define INLINE static inline __attribute__((always_inline))

/* Numbers of a row of a table. */
#define FIELDS(Row) ((Py_ssize_t)(sizeof(Row) / 8))

typedef PyObject *const *Arguments;

#define MOST_AXES 4

typedef struct {
    Py_buffer buffer;
    double *at;
    Py_ssize_t size[MOST_AXES];
    Py_ssize_t step[MOST_AXES]; /* In numbers, not bytes. An axis of length 1 has step 0. */
} Array;

/* Arrays that a call holds, and its work space; they are released together. */
typedef struct {
    Array *arrays;
    int held;
    void *room;
} Held;

/* Take an array with so many axes; writable ones are results. Returns NULL with an error set. */
Array *take(Held *held, PyObject *object, int axes, int writable);

/* Take several, one for each word of `axes`: how many it has, after `=` if it is a result, and
   after `?` if it may be None, and is at NULL then. Returns -1 with an error set. */
int take_each(Held *held, Arguments given, const char *axes);

/* Return work space for so many numbers, once in a call; NULL with an error set. */
double *room_for(Held *held, Py_ssize_t numbers);

/* Return 0 if an axis has a size, or 1 if `may_be_one`; else -1 with an error set. */
int has_size(const Array *array, int axis, Py_ssize_t size, int may_be_one);

void release(Held *held);

/* A plan: arrays of integers and of numbers, in an order that its kind defines. */
typedef struct {
    const struct PlanKind *kind;
    Py_ssize_t integer_arrays, number_arrays;
    Py_ssize_t *integer_sizes, *number_sizes;
    int64_t **integers;
    double **numbers;
} Plan;

/* What a plan is of, and how many arrays it has. It is made only if its sizes and indices fit each
   other, so that functions need not look at them again. */
typedef struct PlanKind {
    const char *name;
    int integer_arrays, number_arrays;
    int (*fits)(const Plan *plan);
} PlanKind;

/* Return the plan in a capsule; NULL with an error set if it is of another kind. */
const Plan *plan_of(PyObject *capsule, const PlanKind *kind);

/* Whether indices, so many numbers apart, are at least `least` and below `end`. */
static inline int are_indices(const int64_t *indices, Py_ssize_t count, Py_ssize_t apart,
                              int64_t least, int64_t end)
{
    for (Py_ssize_t k = 0; k < count; k++)
        if (indices[k * apart] < least || indices[k * apart] >= end)
            return 0;
    return 1;
}

/* Whether a part of an array, from `first` on, lies within it. */
static inline int is_part(int64_t first, int64_t count, int64_t size)
{
    return 0 <= first && 0 <= count && count <= size && first <= size - count;
}

#define EXACTLY(nargs, count)                                                                     \
    if ((nargs) != (count)) {                                                                     \
        PyErr_Format(PyExc_TypeError, "%d arguments are needed, not %zd", (int)(count), (nargs)); \
        return NULL;                                                                              \
    }

#endif
