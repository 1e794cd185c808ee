/* Steps of an explicit method: the twin of `Stepper._taken` of elements/stepping.py. */

#include "kernels.h"

/* Rows of a tableau behind the weights of rates in the rows of its stages: those in the row at the
   end, and in the errors of both orders; places of the stages, as fractions of the step. */
enum { LAST, ERRORS, PLACES = ERRORS + 2, MORE };

/* Write `begin + length * (weights of rates)`; rows of `weighed` are the begin and the rates. */
static void along(const double *weighed, Py_ssize_t size, const double *weights, Py_ssize_t known,
                  double length, double *row)
{
    for (Py_ssize_t i = 0; i < size; i++)
        row[i] = 0.0;
    for (Py_ssize_t k = 0; k < known; k++) {
        if (weights[k] == 0.0)
            continue;
        const double *rate = weighed + (1 + k) * size;
        for (Py_ssize_t i = 0; i < size; i++)
            row[i] += weights[k] * rate[i];
    }
    for (Py_ssize_t i = 0; i < size; i++)
        row[i] = weighed[i] + length * row[i];
}

/* Write the rate that a function returns; -1 with an error set. */
static int rate_of(PyObject *derivative, double time, PyObject *row, Py_ssize_t size, double *rate)
{
    PyObject *found = PyObject_CallFunction(derivative, "dO", time, row);
    if (!found)
        return -1;
    Taken *held = NULL;
    const Py_buffer *array = take(&held, found, 'd', PyBUF_STRIDES);
    const int fits = array && array->ndim == 1 && array->shape[0] == size;
    if (array && !fits)
        PyErr_Format(PyExc_ValueError, "a rate of a row has %zd numbers", size);
    for (Py_ssize_t i = 0; fits && i < size; i++)
        rate[i] = *(const double *)((const char *)array->buf + i * array->strides[0]);
    release(&held);
    Py_DECREF(found);
    return fits ? 0 : -1;
}

/* Write the rate of a row by a program: the first outputs, behind which is one that is at most 1
   where it suits. Returns whether it does; -1 with an error set. */
static int rate_by_program(PyObject *program, const Py_buffer *inputs, const Py_buffer *outputs,
                           const double *row, Py_ssize_t size, double *rate)
{
    const double *found = outputs->buf;
    memcpy(inputs->buf, row, sizeof(double) * size);
    if (run_lane(program, inputs, outputs))
        return -1;
    if (!(found[size] <= 1.0))
        return 0;
    memcpy(rate, found, sizeof(double) * size);
    return 1;
}

/* The greater size of two; one that is not a number shows. */
static double greater(double one, double two)
{
    one = fabs(one), two = fabs(two);
    return one > two || one != one ? one : two;
}

/* explicit_step(tableau (S + 4, S), derivative, time, length, weighed (1 + K, n), stages (S, n),
   rows, atol (n) or (1), rtol, last (n), traced): take a step from the first row of `weighed`, whose
   rate is the second.

   `rows` is a sequence of S views of the stages, which the derivative is asked at. `traced` is None
   or a program that gives rates without it where it suits, with arrays for its inputs, of which the
   first are a row, and for its outputs: the rate and two more. Arrays have no gaps. Returns the sums
   of squares of both errors, as fractions of what is allowed, and how many rates the program
   gave. */
PyObject *explicit_step(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 11)
    Taken *held = NULL;
    PyObject *answer = NULL;
    const double time = PyFloat_AsDouble(given[2]), length = PyFloat_AsDouble(given[3]);
    const double rtol = PyFloat_AsDouble(given[8]);
    if (PyErr_Occurred())
        return NULL;
    const int written = PyBUF_C_CONTIGUOUS | PyBUF_WRITABLE;
    const Py_buffer *tableau = take(&held, given[0], 'd', PyBUF_C_CONTIGUOUS);
    const Py_buffer *begin = tableau ? take(&held, given[4], 'd', written) : NULL;
    const Py_buffer *tolerances = begin ? take(&held, given[7], 'd', PyBUF_C_CONTIGUOUS) : NULL;
    if (!tolerances)
        goto done;
    const Py_ssize_t count = tableau->ndim == 2 ? tableau->shape[1] : -1;
    const Py_ssize_t size = begin->ndim == 2 ? begin->shape[1] : -1;
    const Py_ssize_t each = tolerances->len > 8;
    if (count < 0 || size < 0 || tableau->shape[0] != count + MORE ||
        begin->shape[0] < 1 + count || tolerances->len != (each ? 8 * size : 8)) {
        PyErr_SetString(PyExc_ValueError, "there is no room for the rates of all stages");
        goto done;
    }
    const double *table = tableau->buf, *more = table + count * count, *atol = tolerances->buf;
    double *weighed = begin->buf, *rates = weighed + size;
    double *stages = take_all(&held, given[5], 'd', PyBUF_WRITABLE, count * size);
    double *last = stages ? take_all(&held, given[9], 'd', PyBUF_WRITABLE, size) : NULL;
    if (!last)
        goto done;
    PyObject *program = NULL;
    const Py_buffer *inputs = NULL, *outputs = NULL;
    if (given[10] != Py_None) {
        PyObject *in, *out;
        if (!PyArg_ParseTuple(given[10], "OOO", &program, &in, &out) ||
            !(inputs = take(&held, in, 'd', written)) ||
            !(outputs = take(&held, out, 'd', written)))
            goto done;
        if (inputs->len < 8 * size || outputs->len != 8 * (size + 2)) {
            PyErr_SetString(PyExc_ValueError, "the program is not one of these rows");
            goto done;
        }
    }
    Py_ssize_t runs = 0;
    for (Py_ssize_t stage = 1; stage < count; stage++) {
        double *row = stages + stage * size, *rate = rates + stage * size;
        along(weighed, size, table + stage * count, stage, length, row);
        const int suits =
            program ? rate_by_program(program, inputs, outputs, row, size, rate) : 0;
        if (suits < 0)
            goto done;
        runs += suits;
        if (suits)
            continue;
        PyObject *view = PySequence_GetItem(given[6], stage);
        if (!view)
            goto done;
        const double at = time + more[PLACES * count + stage] * length;
        const int failed = rate_of(given[1], at, view, size, rate);
        Py_DECREF(view);
        if (failed)
            goto done;
    }
    along(weighed, size, more + LAST * count, count, length, last);
    double sums[2] = {0.0, 0.0};
    for (Py_ssize_t i = 0; i < size; i++) {
        const double allowed = atol[i * each] + rtol * greater(weighed[i], last[i]);
        for (int order = 0; order < 2; order++) {
            const double *weights = more + (ERRORS + order) * count;
            double error = 0.0;
            for (Py_ssize_t k = 0; k < count; k++)
                if (weights[k] != 0.0)
                    error += weights[k] * rates[k * size + i];
            error /= allowed;
            sums[order] += error * error;
        }
    }
    answer = Py_BuildValue("ddn", sums[0], sums[1], runs);
done:
    release(&held);
    return answer;
}
