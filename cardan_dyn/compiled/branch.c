/* Guesses: the twins of `BranchTable.values` with what `DriveMotion.write` does around it. */

#include "arrays.h"
#include "kernels.h"

enum { COLUMNS, BALLS, DRIVE, BRANCH_INTEGERS };
enum { NODES, CURVES, WINDINGS, PERIOD, BRANCH_NUMBERS };
enum { FAR, LENGTH, TURNS, PARTS, PERIOD_NUMBERS = PARTS + 3 };

/* Scale a quaternion to unit length, as NumPy adds up few squares: one after the other. */
static void normalise(double *quaternion)
{
    double sum = 0.0;
    for (int i = 0; i < 4; i++)
        sum += quaternion[i] * quaternion[i];
    double length = sqrt(sum);
    for (int i = 0; i < 4; i++)
        quaternion[i] /= length;
}

/* The interval of a position among nodes: how many of those between the outer ones lie before it. */
static Py_ssize_t interval_of(const double *nodes, Py_ssize_t count, double position)
{
    Py_ssize_t low = 0, high = count - 2;
    while (low < high) {
        Py_ssize_t middle = low + (high - low) / 2;
        if (nodes[middle + 1] < position)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Whether indices lie between 0 and a limit, with so many more behind each. */
static int are_below(const int64_t *indices, Py_ssize_t count, Py_ssize_t more, Py_ssize_t limit)
{
    for (Py_ssize_t k = 0; k < count; k++)
        if (indices[k] < 0 || indices[k] > limit - 1 - more)
            return 0;
    return 1;
}

static int is_branch(const Plan *plan)
{
    if (plan->integer_arrays != BRANCH_INTEGERS || plan->number_arrays != BRANCH_NUMBERS)
        return 0;
    Py_ssize_t width = plan->integer_sizes[COLUMNS], count = plan->number_sizes[NODES];
    return count >= 2 && plan->number_sizes[CURVES] == 6 * (count - 1) * width &&
           plan->number_sizes[WINDINGS] == width && plan->integer_sizes[DRIVE] == 1 &&
           plan->number_sizes[PERIOD] == PERIOD_NUMBERS &&
           are_below(plan->integers[BALLS], plan->integer_sizes[BALLS], 3, width);
}

/* branch(plan, positions (N,), x (N, size), turns (N, size)): whether the branch is known there.

   Plan: columns (k,) that the drive moves; places among them at which quaternions begin; column of
   the drive. Nodes (K,); coefficients (K - 1, 6, k) of the polynomials between them, of ascending
   powers; whole turns (k,) in a period; from which distance on a period would be sought, its
   length (0 if there is none), in turns of the drive, and the parts of a turn. Where a position is
   not known, rows may be half written. `turns` are zeros before. */
PyObject *branch(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 4)
    const Plan *plan = plan_of(given[0]);
    if (!plan)
        return NULL;
    if (!is_branch(plan)) {
        PyErr_SetString(PyExc_ValueError, "no plan of a branch");
        return NULL;
    }
    Array arrays[3];
    Held held = {arrays, 0};
    PyObject *answer = NULL;
    double *values = NULL;
    if (!take(&held, given[1], 1, 0) || !take(&held, given[2], 2, 1) ||
        !take(&held, given[3], 2, 1))
        goto done;
    Array *positions = arrays, *x = arrays + 1, *turns = arrays + 2;
    Py_ssize_t samples = positions->size[0], size = x->size[1];
    if (has_size(x, 0, samples, 0) || has_size(turns, 0, samples, 0) || has_size(turns, 1, size, 0))
        goto done;
    const int64_t *columns = plan->integers[COLUMNS], *balls = plan->integers[BALLS];
    const int64_t drive = plan->integers[DRIVE][0];
    Py_ssize_t width = plan->integer_sizes[COLUMNS], ball_count = plan->integer_sizes[BALLS];
    if (!are_below(columns, width, 0, size) || !are_below(&drive, 1, 0, size)) {
        PyErr_SetString(PyExc_ValueError, "rows have too few coordinates");
        goto done;
    }
    values = malloc(sizeof(double) * (width + 1));
    if (!values) {
        PyErr_NoMemory();
        goto done;
    }
    Py_ssize_t count = plan->number_sizes[NODES];
    const double *nodes = plan->numbers[NODES], *windings = plan->numbers[WINDINGS];
    const double *of_period = plan->numbers[PERIOD];
    const double far = of_period[FAR], period = of_period[LENGTH];
    double lowest = INFINITY, highest = -INFINITY;
    int is_known = 1;
    for (Py_ssize_t sample = 0; sample < samples; sample++) {
        double position = positions->at[sample * positions->step[0]], where = position;
        double periods = 0.0;
        if (period > 0.0) {
            periods = floor((position - nodes[0]) / period);
            double whole = periods * of_period[TURNS];
            for (int part = 0; part < 3; part++)
                where -= whole * of_period[PARTS + part];
            is_known = isfinite(where);
        } else {
            lowest = position < lowest ? position : lowest;
            highest = position > highest ? position : highest;
            /* Written so that what is not a number is not known. */
            is_known = position >= nodes[0] && position <= nodes[count - 1] &&
                       highest - lowest < far && highest <= far && -lowest <= far;
        }
        if (!is_known)
            break;
        Py_ssize_t left = interval_of(nodes, count, where);
        double low = nodes[left], share = (where - low) / (nodes[left + 1] - low);
        const double *curve = plan->numbers[CURVES] + left * 6 * width;
        for (Py_ssize_t k = 0; k < width; k++) {
            double value = curve[5 * width + k];
            for (int power = 4; power >= 0; power--)
                value = value * share + curve[power * width + k];
            values[k] = value;
        }
        for (Py_ssize_t ball = 0; ball < ball_count; ball++)
            normalise(values + balls[ball]);
        double *row = x->at + sample * x->step[0];
        for (Py_ssize_t k = 0; k < width; k++)
            row[columns[k] * x->step[1]] = values[k];
        row[drive * x->step[1]] = position;
        if (periods != 0.0)
            for (Py_ssize_t k = 0; k < width; k++)
                turns->at[sample * turns->step[0] + columns[k] * turns->step[1]] =
                    periods * windings[k];
    }
    answer = PyBool_FromLong(is_known);
done:
    free(values);
    release(&held);
    return answer;
}
