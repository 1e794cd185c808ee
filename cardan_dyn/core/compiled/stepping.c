/* Steps of an explicit method: the twin of `Stepper._taken` of elements/stepping.py. */

#include "arrays.h"
#include "kernels.h"

/* The arrays of a plan. */
enum {
    PLACES, /* (S) Of the stages, as fractions of the step. */
    ROWS,   /* (S, S) Weights of rates in the row of each stage. */
    LAST,   /* (S) Weights in the row at the end. */
    ERRORS, /* (2, S) Weights in the errors of both orders. */
    NUMBER_ARRAYS
};

static int stepping_fits(const Plan *plan)
{
    const Py_ssize_t *sizes = plan->number_sizes;
    Py_ssize_t count = sizes[PLACES];
    return sizes[ROWS] == count * count && sizes[LAST] == count && sizes[ERRORS] == 2 * count;
}

const PlanKind stepping_plan = {"stepping", 0, NUMBER_ARRAYS, stepping_fits};

/* Write `begin + length * (weights of rates)`; rows of `weighed` are the begin and the rates. */
static void along(const Array *weighed, const double *weights, Py_ssize_t known, double length,
                  double *row)
{
    Py_ssize_t size = weighed->size[1], across = weighed->step[1];
    for (Py_ssize_t i = 0; i < size; i++)
        row[i] = 0.0;
    for (Py_ssize_t k = 0; k < known; k++) {
        if (weights[k] == 0.0)
            continue;
        const double *rate = weighed->at + (1 + k) * weighed->step[0];
        for (Py_ssize_t i = 0; i < size; i++)
            row[i] += weights[k] * rate[i * across];
    }
    for (Py_ssize_t i = 0; i < size; i++)
        row[i] = weighed->at[i * across] + length * row[i];
}

static int rate_of(PyObject *derivative, double time, PyObject *row, const Array *weighed,
                   Py_ssize_t stage)
{
    PyObject *at = PyFloat_FromDouble(time);
    if (!at)
        return -1;
    PyObject *found = PyObject_CallFunctionObjArgs(derivative, at, row, NULL);
    Py_DECREF(at);
    if (!found)
        return -1;
    Array array;
    Held held = {&array, 0, NULL};
    int failed = -1;
    if (take(&held, found, 1, 0) && !has_size(&array, 0, weighed->size[1], 0)) {
        double *rate = weighed->at + (1 + stage) * weighed->step[0];
        for (Py_ssize_t i = 0; i < array.size[0]; i++)
            rate[i * weighed->step[1]] = array.at[i * array.step[0]];
        failed = 0;
    }
    release(&held);
    Py_DECREF(found);
    return failed;
}

/* A program of rates, its inputs of which the first are a row, and its outputs: the rates, and two
   of which the first is at most 1 where it suits. */
typedef struct {
    PyObject *handle;
    Array *inputs, *outputs;
} Traced;

/* Write the rate of a row by a program. Returns whether it suits; -1 with an error set. */
static int rate_by_program(const Traced *traced, const double *row, const Array *weighed,
                           Py_ssize_t stage)
{
    const Array *inputs = traced->inputs, *outputs = traced->outputs;
    Py_ssize_t size = weighed->size[1];
    for (Py_ssize_t i = 0; i < size; i++)
        inputs->at[i * inputs->step[0]] = row[i];
    if (run_lane(traced->handle, inputs, outputs))
        return -1;
    if (!(outputs->at[size * outputs->step[0]] <= 1.0))
        return 0;
    double *rate = weighed->at + (1 + stage) * weighed->step[0];
    for (Py_ssize_t i = 0; i < size; i++)
        rate[i * weighed->step[1]] = outputs->at[i * outputs->step[0]];
    return 1;
}

/* The greater size of two; one that is not a number shows. */
static double greater(double one, double two)
{
    one = fabs(one), two = fabs(two);
    return one > two || one != one ? one : two;
}

/* explicit_step(plan, derivative, time, length, weighed (1 + K, n), stages (S, n), rows, atol (n),
   rtol, last (n), traced): take a step from the first row of `weighed`, whose rate is the second.

   `rows` is a sequence of S views of the stages, which the derivative is asked at. `traced` is None
   or a program that gives rates without it where it suits, with arrays for its inputs and outputs.
   Returns the sums of squares of both errors, as fractions of what is allowed, and how many rates
   the program gave. */
PyObject *explicit_step(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 11)
    Array arrays[6], *weighed = arrays, *stages = arrays + 1, *atol = arrays + 2, *last = arrays + 3;
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    const Plan *plan = plan_of(given[0], &stepping_plan);
    if (!plan)
        return NULL;
    double time = PyFloat_AsDouble(given[2]), length = PyFloat_AsDouble(given[3]);
    double rtol = PyFloat_AsDouble(given[8]);
    if (PyErr_Occurred())
        return NULL;
    PyObject *handed[] = {given[4], given[5], given[7], given[9]};
    if (take_each(&held, handed, "=2 =2 1 =1"))
        goto done;
    Py_ssize_t size = weighed->size[1], count = plan->number_sizes[PLACES];
    if (weighed->size[0] < 1 + count) {
        PyErr_SetString(PyExc_ValueError, "there is no room for the rates of all stages");
        goto done;
    }
    if (has_size(stages, 0, count, 0) || has_size(stages, 1, size, 0) ||
        has_size(atol, 0, size, 1) || has_size(last, 0, size, 0))
        goto done;
    if (size > 1 && (stages->step[1] != 1 || last->step[0] != 1)) {
        PyErr_SetString(PyExc_ValueError, "rows that are written may have no gaps");
        goto done;
    }
    Traced traced = {NULL, arrays + 4, arrays + 5};
    if (given[10] != Py_None) {
        PyObject *each[3];
        for (int k = 0; k < 3; k++)
            if (!(each[k] = PyTuple_GetItem(given[10], k)))
                goto done;
        traced.handle = each[0];
        if (take_each(&held, each + 1, "=1 =1"))
            goto done;
        if (traced.inputs->size[0] < size || traced.outputs->size[0] != size + 2) {
            PyErr_SetString(PyExc_ValueError, "the program is not one of these rows");
            goto done;
        }
    }
    Py_ssize_t runs = 0;
    double *const *numbers = plan->numbers;
    for (Py_ssize_t stage = 1; stage < count; stage++) {
        double *row = stages->at + stage * stages->step[0];
        along(weighed, numbers[ROWS] + stage * count, stage, length, row);
        int suits = traced.handle ? rate_by_program(&traced, row, weighed, stage) : 0;
        if (suits < 0)
            goto done;
        runs += suits;
        if (suits)
            continue;
        PyObject *view = PySequence_GetItem(given[6], stage);
        if (!view)
            goto done;
        int failed =
            rate_of(given[1], time + numbers[PLACES][stage] * length, view, weighed, stage);
        Py_DECREF(view);
        if (failed)
            goto done;
    }
    along(weighed, numbers[LAST], count, length, last->at);
    double sums[2] = {0.0, 0.0};
    for (Py_ssize_t i = 0; i < size; i++) {
        double begin = weighed->at[i * weighed->step[1]];
        double allowed = atol->at[i * atol->step[0]] + rtol * greater(begin, last->at[i]);
        for (int order = 0; order < 2; order++) {
            const double *weights = numbers[ERRORS] + order * count;
            double error = 0.0;
            for (Py_ssize_t k = 0; k < count; k++)
                if (weights[k] != 0.0)
                    error += weights[k] *
                             weighed->at[(1 + k) * weighed->step[0] + i * weighed->step[1]];
            error /= allowed;
            sums[order] += error * error;
        }
    }
    answer = Py_BuildValue("ddn", sums[0], sums[1], runs);
done:
    release(&held);
    return answer;
}
