/* Guesses: the twins of what kinematics/following does where motions are known:
   `BranchTable.values` with what `DriveMotion.write` does around it, `Rows`, and the lattice. */

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

enum { DRIVES, KEYS, FACTORS, LATTICE_INTEGERS };
enum { POINTS, LOW, SPACING, ORIGIN, WEIGHTS, LATTICE_NUMBERS };
enum { MOST_AROUND = 3, MOST_JETS = 1 + MOST_AROUND * (MOST_AROUND + 3) / 2 };

static int lattice_fits(const Plan *plan)
{
    Py_ssize_t d = plan->integer_sizes[DRIVES], size = plan->number_sizes[WEIGHTS];
    return d >= 1 && plan->integer_sizes[FACTORS] == d &&
           plan->integer_sizes[KEYS] >= 1 &&
           plan->number_sizes[POINTS] == plan->integer_sizes[KEYS] * d &&
           plan->number_sizes[LOW] == d && plan->number_sizes[SPACING] == d &&
           plan->number_sizes[ORIGIN] == d && are_indices(plan->integers[DRIVES], d, 1, 0, size);
}

const PlanKind lattice_plan = {"lattice", LATTICE_INTEGERS, LATTICE_NUMBERS, lattice_fits};

/* Index of a lattice point, the nearest one behind where it is none of them; whether it is one. */
static Py_ssize_t index_of(const Plan *plan, const double *point, int *is_there)
{
    Py_ssize_t d = plan->integer_sizes[DRIVES], count = plan->integer_sizes[KEYS];
    const double *low = plan->numbers[LOW], *points = plan->numbers[POINTS];
    const int64_t *keys = plan->integers[KEYS], *factors = plan->integers[FACTORS];
    uint64_t sum = 0; /* Points outside the box may have any key. */
    for (Py_ssize_t k = 0; k < d; k++) {
        double ahead = point[k] - low[k];
        if (!(fabs(ahead) < 0x1p62)) {
            *is_there = 0;
            return 0;
        }
        sum += (uint64_t)(int64_t)ahead * (uint64_t)factors[k];
    }
    int64_t key = (int64_t)sum;
    Py_ssize_t first = 0, last = count;
    while (first < last) {
        Py_ssize_t middle = first + (last - first) / 2;
        if (keys[middle] < key)
            first = middle + 1;
        else
            last = middle;
    }
    if (first == count)
        first = count - 1;
    *is_there = 1;
    for (Py_ssize_t k = 0; k < d; k++)
        *is_there &= points[first * d + k] == point[k];
    return first;
}

/* Weights of what is known at one of two points, see `_hermite`. */
enum { VALUE, SLOPE, BEND, CUBIC_VALUE, CUBIC_SLOPE, LINEAR, KINDS };

static void hermite(double share, double way, double weights[KINDS])
{
    double rest = 1.0 - share, square = rest * rest, cube = rest * rest * rest;
    weights[VALUE] = cube * (1.0 + share * (3.0 + 6.0 * share));
    weights[SLOPE] = way * share * cube * (1.0 + 3.0 * share);
    weights[BEND] = 0.5 * share * share * cube;
    weights[CUBIC_VALUE] = square * (1.0 + 2.0 * share);
    weights[CUBIC_SLOPE] = way * share * square;
    weights[LINEAR] = rest;
}

/* Weights of a point's coordinates and derivatives along d drives, see `_weights`. */
static void weights_of(double along[][KINDS], int d, double *weights)
{
    double product = along[0][VALUE];
    for (int k = 1; k < d; k++)
        product *= along[k][VALUE];
    *weights++ = product;
    for (int i = 0; i < d; i++) {
        product = 1.0;
        for (int k = 0; k < d; k++)
            product *= along[k][k < i ? CUBIC_VALUE : k == i ? SLOPE : VALUE];
        *weights++ = product;
    }
    for (int i = 0; i < d; i++)
        for (int j = i; j < d; j++) {
            product = 1.0;
            for (int k = 0; k < d; k++) {
                int kind = VALUE;
                if (k < i)
                    kind = LINEAR;
                else if (i == j)
                    kind = k == i ? BEND : VALUE;
                else if (k <= j)
                    kind = k == i ? CUBIC_SLOPE : k < j ? CUBIC_VALUE : SLOPE;
                product *= along[k][kind];
            }
            *weights++ = product;
        }
}

/* Add a factor times numbers, which stand one behind the other where their step is 1. */
static void add(double *restrict sums, double factor, const double *restrict numbers,
                Py_ssize_t step, Py_ssize_t count)
{
    if (step == 1)
        for (Py_ssize_t k = 0; k < count; k++)
            sums[k] += factor * numbers[k];
    else
        for (Py_ssize_t k = 0; k < count; k++)
            sums[k] += factor * numbers[k * step];
}

/* What is interpolated between the points around a position, see `_Points._interpolated`.

   Returns whether all of these are known. */
static int interpolated(const Plan *plan, Py_ssize_t point, const double *position,
                        const Array *jets, const Array *known, double *result)
{
    int d = (int)plan->integer_sizes[DRIVES], are_known = 1;
    const double *nearest = plan->numbers[POINTS] + point * d;
    double side[MOST_AROUND], ends[2][MOST_AROUND][KINDS], along[MOST_AROUND][KINDS] = {{0.0}};
    for (int k = 0; k < d; k++) {
        double ahead = (position[k] - plan->numbers[ORIGIN][k]) / plan->numbers[SPACING][k];
        double share = fabs(ahead - nearest[k]);
        side[k] = ahead < nearest[k] ? -1.0 : 1.0;
        hermite(share, side[k], ends[0][k]);
        hermite(1.0 - share, -side[k], ends[1][k]);
    }
    Py_ssize_t size = jets->size[2];
    memset(result, 0, sizeof(double) * size);
    for (int corner = 0; corner < 1 << d; corner++) {
        Py_ssize_t at = point;
        double there[MOST_AROUND], weights[MOST_JETS];
        for (int k = 0; k < d; k++) {
            int is_other = corner >> (d - 1 - k) & 1; /* The last drive changes first. */
            there[k] = nearest[k] + side[k] * is_other;
            memcpy(along[k], ends[is_other][k], sizeof along[k]);
        }
        if (corner) {
            int is_there;
            at = index_of(plan, there, &is_there);
            are_known &= is_there && known->at[at * known->step[0]] != 0.0;
        }
        weights_of(along, d, weights);
        const double *jet = jets->at + at * jets->step[0];
        for (Py_ssize_t m = 0; m < jets->size[1]; m++)
            add(result, weights[m], jet + m * jets->step[1], jets->step[2], size);
    }
    return are_known;
}

/* lattice(plan, points (N,), positions (N, d), jets (M, J, size), way, guess (N, size),
           longest (N,), known (M,), between (N, size), are_known (N,)).

   The twins of `_Points._extrapolated` and `_Points._interpolated`: coordinates at positions of d
   drives near lattice points, from what is known there: coordinates, their first derivatives and
   their second ones. The last three are None where nothing is to be interpolated.

   Plan: columns of the drives; keys (M,) of the points, ascending; factors (d,) of a key. Points
   (M, d); least coordinates of a point; distance of points, position of the start (d,); weights
   (size,) of coordinates. */
PyObject *lattice(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 10)
    const Plan *plan = plan_of(given[0], &lattice_plan);
    double way = plan ? PyFloat_AsDouble(given[4]) : -1.0;
    if (!plan || (way == -1.0 && PyErr_Occurred()))
        return NULL;
    Array arrays[8];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    if (take_each(&held, given + 1, "1 2 3") || take_each(&held, given + 5, "=2 =1 ?1 ?=2 ?=1"))
        goto done;
    Array *points = arrays, *positions = arrays + 1, *jets = arrays + 2, *guess = arrays + 3;
    Array *longest_ways = arrays + 4, *known = arrays + 5, *between = arrays + 6;
    Array *are_known = arrays + 7;
    int is_between = between->at != NULL;
    Py_ssize_t samples = points->size[0], d = plan->integer_sizes[DRIVES];
    if (is_between && d > MOST_AROUND) {
        PyErr_SetString(PyExc_ValueError, "the plan has too many drives");
        goto done;
    }
    Py_ssize_t count = plan->integer_sizes[KEYS], size = plan->number_sizes[WEIGHTS];
    if (has_size(positions, 0, samples, 0) || has_size(positions, 1, d, 0) ||
        has_size(jets, 0, count, 0) || has_size(jets, 1, 1 + d * (d + 3) / 2, 0) ||
        has_size(jets, 2, size, 0) || has_size(guess, 0, samples, 0) ||
        has_size(guess, 1, size, 0) || has_size(longest_ways, 0, samples, 0))
        goto done;
    if (is_between && (has_size(known, 0, count, 0) || has_size(between, 0, samples, 0) ||
                       has_size(between, 1, size, 0) || has_size(are_known, 0, samples, 0)))
        goto done;
    double *work = room_for(&held, 2 * size + 2 * d);
    if (!work)
        goto done;
    double *first = work, *second = first + size, *position = second + size, *step = position + d;
    const int64_t *columns = plan->integers[DRIVES];
    for (Py_ssize_t sample = 0; sample < samples; sample++) {
        double index = points->at[sample * points->step[0]];
        if (!(index >= 0.0 && index < (double)count)) {
            PyErr_SetString(PyExc_ValueError, "there is no such lattice point");
            goto done;
        }
        Py_ssize_t point = (Py_ssize_t)index;
        const double *jet = jets->at + point * jets->step[0];
        double *row = guess->at + sample * guess->step[0];
        double fastest = 0.0, most_bent = 0.0;
        for (Py_ssize_t k = 0; k < d; k++) {
            position[k] = positions->at[sample * positions->step[0] + k * positions->step[1]];
            double begin = jet[columns[k] * jets->step[2]];
            step[k] = (position[k] - begin) / plan->numbers[SPACING][k];
        }
        memset(work, 0, sizeof(double) * 2 * size);
        const double *derivative = jet + jets->step[1];
        for (Py_ssize_t i = 0; i < d; i++, derivative += jets->step[1])
            add(first, step[i], derivative, jets->step[2], size);
        for (Py_ssize_t i = 0; i < d; i++)
            for (Py_ssize_t j = i; j < d; j++, derivative += jets->step[1])
                add(second, step[i] * step[j] * (i == j ? 0.5 : 1.0), derivative, jets->step[2],
                    size);
        for (Py_ssize_t k = 0; k < size; k++) {
            row[k * guess->step[1]] = jet[k * jets->step[2]] + (first[k] + second[k]);
            fastest = greater(fastest, fabs(first[k]) * plan->numbers[WEIGHTS][k]);
            most_bent = greater(most_bent, fabs(second[k]) * plan->numbers[WEIGHTS][k]);
        }
        for (Py_ssize_t k = 0; k < d; k++)
            row[columns[k] * guess->step[1]] = position[k];
        longest_ways->at[sample * longest_ways->step[0]] = longest_way(fastest, most_bent, way);
        if (!is_between)
            continue;
        are_known->at[sample * are_known->step[0]] =
            interpolated(plan, point, position, jets, known, work);
        for (Py_ssize_t k = 0; k < d; k++)
            work[columns[k]] = position[k];
        for (Py_ssize_t k = 0; k < size; k++)
            between->at[sample * between->step[0] + k * between->step[1]] = work[k];
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}
