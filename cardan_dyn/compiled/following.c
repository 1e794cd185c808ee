/* Guesses: the twins of what kinematics/following does where motions are known:
   `BranchTable.values` with what `DriveMotion.write` does around it, and `Rows`. */

#include "kernels.h"
#include "stacked.h"

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

/* The interval of a position: how many nodes between the outer ones lie before it. */
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

static int branch_fits(const Plan *plan)
{
    Py_ssize_t width = plan->integer_sizes[COLUMNS], count = plan->number_sizes[NODES];
    return count >= 2 && plan->number_sizes[CURVES] == 6 * (count - 1) * width &&
           plan->number_sizes[WINDINGS] == width && plan->integer_sizes[DRIVE] == 1 &&
           plan->number_sizes[PERIOD] == PERIOD_NUMBERS &&
           are_indices(plan->integers[BALLS], plan->integer_sizes[BALLS], 1, 0, width - 3);
}

const PlanKind branch_plan = {"branch", BRANCH_INTEGERS, BRANCH_NUMBERS, branch_fits};

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
    const Plan *plan = plan_of(given[0], &branch_plan);
    if (!plan)
        return NULL;
    Array arrays[3];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    if (take_each(&held, given + 1, "1 =2 =2"))
        goto done;
    Array *positions = arrays, *x = arrays + 1, *turns = arrays + 2;
    Py_ssize_t samples = positions->size[0], size = x->size[1];
    if (has_size(x, 0, samples, 0) || has_size(turns, 0, samples, 0) || has_size(turns, 1, size, 0))
        goto done;
    const int64_t *columns = plan->integers[COLUMNS], *balls = plan->integers[BALLS];
    const int64_t drive = plan->integers[DRIVE][0];
    Py_ssize_t width = plan->integer_sizes[COLUMNS], ball_count = plan->integer_sizes[BALLS];
    if (!are_indices(columns, width, 1, 0, size) || !are_indices(&drive, 1, 1, 0, size)) {
        PyErr_SetString(PyExc_ValueError, "rows have too few coordinates");
        goto done;
    }
    double *values = room_for(&held, width);
    if (!values)
        goto done;
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
    release(&held);
    return answer;
}

enum { SCALAR_COLUMNS, SCALAR_VELOCITIES, BALL_COLUMNS, BALL_VELOCITIES, ROWS_INTEGERS };
enum { SCALE, ROWS_NUMBERS };

static int rows_fit(const Plan *plan)
{
    const Py_ssize_t *sizes = plan->integer_sizes, size = plan->number_sizes[SCALE];
    return sizes[SCALAR_COLUMNS] == sizes[SCALAR_VELOCITIES] &&
           sizes[BALL_COLUMNS] == sizes[BALL_VELOCITIES] &&
           are_indices(plan->integers[SCALAR_COLUMNS], sizes[SCALAR_COLUMNS], 1, 0, size) &&
           are_indices(plan->integers[BALL_COLUMNS], sizes[BALL_COLUMNS], 1, 0, size - 3);
}

const PlanKind rows_plan = {"rows", ROWS_INTEGERS, ROWS_NUMBERS, rows_fit};

/* The rate of a quaternion whose ball turns at a velocity: half their product. */
static void rate_of(const double q[4], const double velocity[3], double rate[4])
{
    double b[4] = {0.5 * velocity[0], 0.5 * velocity[1], 0.5 * velocity[2], 0.0};
    turned(q, b, rate);
}

/* rows(plan, x (N, size), v (N, nv), a (N, nv), first (N, size), second (N, size)).

   The twin of `Rows.of_rates`: first derivatives of rows, and half of the second ones. x may be one
   row for all. Plan: columns and velocity coordinates of turns and slides, first ones of balls;
   weights of coordinates. */
PyObject *rows(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 6)
    const Plan *plan = plan_of(given[0], &rows_plan);
    if (!plan)
        return NULL;
    Array arrays[5];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    if (take_each(&held, given + 1, "2 2 2 =2 =2"))
        goto done;
    Array *x = arrays, *v = arrays + 1, *a = arrays + 2, *first = arrays + 3, *second = arrays + 4;
    Py_ssize_t samples = v->size[0], rates = v->size[1], size = plan->number_sizes[SCALE];
    if (has_size(x, 0, samples, 1) || has_size(x, 1, size, 0) || has_size(a, 0, samples, 0) ||
        has_size(a, 1, rates, 0) || has_size(first, 0, samples, 0) || has_size(first, 1, size, 0) ||
        has_size(second, 0, samples, 0) || has_size(second, 1, size, 0))
        goto done;
    Py_ssize_t scalar_count = plan->integer_sizes[SCALAR_COLUMNS];
    Py_ssize_t ball_count = plan->integer_sizes[BALL_COLUMNS];
    const int64_t *columns = plan->integers[SCALAR_COLUMNS];
    const int64_t *velocities = plan->integers[SCALAR_VELOCITIES];
    const int64_t *balls = plan->integers[BALL_COLUMNS], *spins = plan->integers[BALL_VELOCITIES];
    if (!are_indices(velocities, scalar_count, 1, 0, rates) ||
        !are_indices(spins, ball_count, 1, 0, rates - 2)) {
        PyErr_SetString(PyExc_ValueError, "velocities have too few coordinates");
        goto done;
    }
    for (Py_ssize_t sample = 0; sample < samples; sample++) {
        const double *row = x->at + sample * x->step[0], *speed = v->at + sample * v->step[0];
        const double *bend = a->at + sample * a->step[0];
        double *slope = first->at + sample * first->step[0];
        double *half = second->at + sample * second->step[0];
        for (Py_ssize_t k = 0; k < scalar_count; k++) {
            slope[columns[k] * first->step[1]] = speed[velocities[k] * v->step[1]];
            half[columns[k] * second->step[1]] = 0.5 * bend[velocities[k] * a->step[1]];
        }
        for (Py_ssize_t ball = 0; ball < ball_count; ball++) {
            double q[4], turn[3], growth[3], rate[4], change[4], squared = 0.0;
            for (int i = 0; i < 4; i++)
                q[i] = row[(balls[ball] + i) * x->step[1]];
            for (int i = 0; i < 3; i++) {
                turn[i] = speed[(spins[ball] + i) * v->step[1]];
                growth[i] = bend[(spins[ball] + i) * a->step[1]];
                squared += turn[i] * turn[i];
            }
            rate_of(q, turn, rate);
            rate_of(q, growth, change);
            for (int i = 0; i < 4; i++) {
                slope[(balls[ball] + i) * first->step[1]] = rate[i];
                half[(balls[ball] + i) * second->step[1]] =
                    0.5 * (change[i] - 0.25 * squared * q[i]);
            }
        }
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}

/* How far rows may be extrapolated whose greatest derivatives are these, see `Rows.longest`. */
static double longest_way(double fastest, double most_bent, double longest)
{
    double by_slope = longest / fastest, by_bend = sqrt(longest / most_bent);
    return by_slope < by_bend || by_slope != by_slope ? by_slope : by_bend;
}

/* longest(plan, first (N, size), second (N, size), way, result (N,)): the twin of `Rows.longest`.

   Plan: as of `rows`. The way is the greatest displacement of a coordinate. */
PyObject *longest(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 5)
    const Plan *plan = plan_of(given[0], &rows_plan);
    double way = plan ? PyFloat_AsDouble(given[3]) : -1.0;
    if (!plan || (way == -1.0 && PyErr_Occurred()))
        return NULL;
    Array arrays[3];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    if (take_each(&held, given + 1, "2 2") || take_each(&held, given + 4, "=1"))
        goto done;
    Array *first = arrays, *second = arrays + 1, *result = arrays + 2;
    Py_ssize_t samples = first->size[0], size = plan->number_sizes[SCALE];
    if (has_size(first, 1, size, 0) || has_size(second, 0, samples, 0) ||
        has_size(second, 1, size, 0) || has_size(result, 0, samples, 0))
        goto done;
    const double *scale = plan->numbers[SCALE];
    for (Py_ssize_t sample = 0; sample < samples; sample++) {
        const double *slope = first->at + sample * first->step[0];
        const double *half = second->at + sample * second->step[0];
        double fastest = 0.0, most_bent = 0.0;
        for (Py_ssize_t k = 0; k < size; k++) {
            fastest = greater(fastest, fabs(slope[k * first->step[1]]) * scale[k]);
            most_bent = greater(most_bent, fabs(half[k * second->step[1]]) * scale[k]);
        }
        result->at[sample * result->step[0]] = longest_way(fastest, most_bent, way);
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}
