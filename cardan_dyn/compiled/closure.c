/* Closure equations: the twins of kinematics/closing/equations.py and group_solver.py.

   The words are explained there. All of it happens sample after sample, so that what is known of a
   sample is read again while it is near. */

#include "kernels.h"
#include "stacked.h"

#define HALF_TURN 1e-12
#define STRAIGHT 3e-10
#define CURVATURE 100.0
#define BENT 0.1
#define MOST_BENT 0.25
#define TAU 6.283185307179586

/* The arrays of a plan, see kinematics/closing/closure_plan.py. */
enum {
    SIZES,         /* Bodies, movable and known coordinates, loops, couplings, rods, row length. */
    MOVABLE,       /* (m) Velocity coordinates that may move: known ones, then passives. */
    MOVED,         /* (m) The body that each of them moves. */
    ALONG,         /* (m) Component of its body's actions that it is, -1 for a sum of several. */
    ENDS,          /* (L, 2) Bodies of the loops' ends, -1 for the base. */
    CARRIERS,      /* (L) Bodies that carry the loops' axes, -1 for the base. */
    ROW_COUNTS,    /* (L) Reduced rows. */
    SINGLE,        /* (sum of these) Component that a row is, -1 for a combination. */
    PATH_COUNTS,   /* (L + k) Movable coordinates on a loop, or that move an idle rod. */
    PATH_COLUMNS,  /* (sum of these) Which, outwards, the predecessors' side first. */
    COUPLED,       /* (c) Columns of coordinate rows that couplings count. */
    ROD_BODIES,    /* (k) */
    INTEGER_ARRAYS
};
enum {
    LENGTH,        /* (1) Characteristic length. */
    UNITS,         /* (m, 6) Unit twists in the frames of their joints. */
    PLACES,        /* (L, 2, 12) Of the ends in their bodies: rotations, row by row, positions. */
    POINTS,        /* (L, 3) About which twists are taken in the loops' axes. */
    ROWS,          /* (sum of ROW_COUNTS, 6) Reduced rows. */
    SIGNS,         /* (sum of PATH_COUNTS) 1 on the predecessor's side, else -1. */
    RATIOS,        /* (c, G) Coefficients of the couplings' slips. */
    OFFSETS,       /* (G) */
    SLIP_UNITS,    /* (G) */
    COUPLING_ROWS, /* (m, G) */
    STEP_SCALE,    /* (p) What Newton steps are counted in. */
    ROW_SCALE,     /* (p) What rows are counted in. */
    LINES,         /* (k, 3) Of the rods, in their frames. */
    NUMBER_ARRAYS
};

typedef struct {
    Py_ssize_t bodies, movable, known, passive, loops, couplings, rods, row_length;
    Py_ssize_t loop_rows, rows, whole, coupled; /* `rows` with couplings, `whole` with rods. */
    int64_t **integers;
    double **numbers;
    double length;
} Closure;

/* Whether counts, none of them below zero, have a sum. */
static int add_up(const int64_t *counts, Py_ssize_t count, int64_t sum)
{
    for (Py_ssize_t k = 0; k < count; k++) {
        if (!is_part(0, counts[k], sum))
            return 0;
        sum -= counts[k];
    }
    return sum == 0;
}

static void measure(const Plan *plan, Closure *of)
{
    const int64_t *sizes = plan->integers[SIZES];
    of->bodies = sizes[0], of->movable = sizes[1], of->known = sizes[2], of->loops = sizes[3];
    of->couplings = sizes[4], of->rods = sizes[5], of->row_length = sizes[6];
    of->passive = of->movable - of->known;
    of->coupled = plan->integer_sizes[COUPLED];
    of->loop_rows = plan->integer_sizes[SINGLE];
    of->rows = of->loop_rows + of->couplings;
    of->whole = of->rows + of->rods;
    of->integers = plan->integers, of->numbers = plan->numbers;
    of->length = plan->numbers[LENGTH][0];
}

static int closure_fits(const Plan *plan)
{
    int64_t *const *integers = plan->integers;
    const Py_ssize_t *counts = plan->integer_sizes, *numbers = plan->number_sizes;
    if (counts[SIZES] != 7 || !are_indices(integers[SIZES], 7, 1, 0, INT32_MAX) ||
        numbers[LENGTH] != 1)
        return 0;
    Closure closure, *of = &closure;
    measure(plan, of);
    Py_ssize_t paths = of->loops + of->rods, on_paths = counts[PATH_COLUMNS];
    return of->passive >= 0 && counts[MOVABLE] == of->movable && counts[MOVED] == of->movable &&
           counts[ALONG] == of->movable && counts[ENDS] == 2 * of->loops &&
           counts[CARRIERS] == of->loops && counts[ROW_COUNTS] == of->loops &&
           counts[PATH_COUNTS] == paths && counts[ROD_BODIES] == of->rods &&
           numbers[UNITS] == 6 * of->movable && numbers[PLACES] == 24 * of->loops &&
           numbers[POINTS] == 3 * of->loops && numbers[ROWS] == 6 * of->loop_rows &&
           numbers[SIGNS] == on_paths && numbers[RATIOS] == of->coupled * of->couplings &&
           numbers[OFFSETS] == of->couplings && numbers[SLIP_UNITS] == of->couplings &&
           numbers[COUPLING_ROWS] == of->movable * of->couplings &&
           numbers[STEP_SCALE] == of->passive && numbers[ROW_SCALE] == of->passive &&
           numbers[LINES] == 3 * of->rods &&
           add_up(integers[ROW_COUNTS], of->loops, of->loop_rows) &&
           add_up(integers[PATH_COUNTS], paths, on_paths) &&
           are_indices(integers[MOVABLE], of->movable, 1, 0, INT32_MAX) &&
           are_indices(integers[MOVED], of->movable, 1, 0, of->bodies) &&
           are_indices(integers[ALONG], of->movable, 1, -1, 6) &&
           are_indices(integers[ENDS], 2 * of->loops, 1, -1, of->bodies) &&
           are_indices(integers[CARRIERS], of->loops, 1, -1, of->bodies) &&
           are_indices(integers[SINGLE], of->loop_rows, 1, -1, 6) &&
           are_indices(integers[PATH_COLUMNS], on_paths, 1, 0, of->movable) &&
           are_indices(integers[COUPLED], of->coupled, 1, 0, of->row_length) &&
           are_indices(integers[ROD_BODIES], of->rods, 1, 0, of->bodies);
}

const PlanKind closure_plan = {"closure", INTEGER_ARRAYS, NUMBER_ARRAYS, closure_fits};

static int closure_of(PyObject *capsule, Closure *of)
{
    const Plan *plan = plan_of(capsule, &closure_plan);
    if (!plan)
        return -1;
    measure(plan, of);
    return 0;
}

/* Return 0 if an array `(count, rows, columns)` has no gaps within samples; else -1 with an error
   set. There may be one sample for all. */
static int is_whole(const Array *array, Py_ssize_t count, int may_be_one, Py_ssize_t rows,
                    Py_ssize_t columns)
{
    if (has_size(array, 0, count, may_be_one) || has_size(array, 1, rows, 0) ||
        has_size(array, 2, columns, 0))
        return -1;
    if (!count || !rows || !columns)
        return 0;
    if ((columns > 1 && array->step[2] != 1) || (rows > 1 && array->step[1] != columns)) {
        PyErr_SetString(PyExc_ValueError, "an array has gaps");
        return -1;
    }
    return 0;
}

/* Write the six unit twists of a placed joint, see `actions_of`. */
static void act(const double *placed, double *actions)
{
    for (int axis = 0; axis < 3; axis++) {
        const double *direction = placed + 3 * axis;
        double *along = actions + 6 * axis, *about = along + 18;
        for (int i = 0; i < 3; i++) {
            along[i] = about[3 + i] = direction[i];
            along[3 + i] = 0.0;
        }
        cross(placed + 9, direction, about);
    }
}

static void unit_twists(const Closure *of, const double *actions, double *twists)
{
    const int64_t *moved = of->integers[MOVED], *along = of->integers[ALONG];
    for (Py_ssize_t k = 0; k < of->movable; k++) {
        const double *action = actions + 36 * moved[k], *unit = of->numbers[UNITS] + 6 * k;
        double *twist = twists + 6 * k;
        if (along[k] >= 0) {
            for (int i = 0; i < 6; i++)
                twist[i] = action[6 * along[k] + i] * unit[along[k]];
            continue;
        }
        for (int i = 0; i < 6; i++) {
            double sum = 0.0;
            for (int j = 0; j < 6; j++)
                sum += unit[j] * action[6 * j + i];
            twist[i] = sum;
        }
    }
}

/* Place the end of a loop: rotation row by row, and position from the batch model's origin. */
static void place_end(const double *places, int64_t body, const double *end, double *placed)
{
    if (body < 0) {
        memcpy(placed, end, 12 * sizeof(double));
        return;
    }
    const double *place = places + 12 * body; /* Its rotation is written column by column. */
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            placed[3 * i + j] =
                place[i] * end[j] + place[3 + i] * end[3 + j] + place[6 + i] * end[6 + j];
        placed[9 + i] =
            place[9 + i] + (place[i] * end[9] + place[3 + i] * end[10] + place[6 + i] * end[11]);
    }
}

/* Write twice the sine of half the angle along the axis, see `rotations_between`. */
static void rotation_between(const double *first, const double *second, double *turn)
{
    double relative[9];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            relative[3 * i + j] = dot(first + 3 * i, second + 3 * j);
    double square = relative[0] + relative[4] + relative[8] + 1.0;
    if (square > HALF_TURN) {
        double root = sqrt(square);
        turn[0] = (relative[7] - relative[5]) / root;
        turn[1] = (relative[2] - relative[6]) / root;
        turn[2] = (relative[3] - relative[1]) / root;
        return;
    }
    /* R + 1 = 2 n nᵀ for a half turn about n; its longest column gives n most accurately. */
    double longest = -1.0;
    for (int j = 0; j < 3; j++) {
        double column[3] = {relative[j], relative[3 + j], relative[6 + j]};
        column[j] += 1.0;
        double length = sqrt(dot(column, column));
        if (length > longest || length != length) {
            longest = length;
            for (int i = 0; i < 3; i++)
                turn[i] = column[i];
        }
    }
    for (int i = 0; i < 3; i++)
        turn[i] = 2.0 * turn[i] / longest;
}

/* Write the twist that would take a successor to its predecessor; return the squared error. */
static double error_of(const Closure *of, Py_ssize_t loop, const double *places, double *twist)
{
    const int64_t *bodies = of->integers[ENDS] + 2 * loop;
    const double *ends = of->numbers[PLACES] + 24 * loop;
    double first[12], second[12], gap[3], middle[3], shift[3], *turn = twist + 3;
    place_end(places, bodies[0], ends, first);
    place_end(places, bodies[1], ends + 12, second);
    rotation_between(first, second, turn);
    for (int i = 0; i < 3; i++) {
        gap[i] = first[9 + i] - second[9 + i];
        middle[i] = 0.5 * (first[9 + i] + second[9 + i]);
    }
    cross(turn, middle, shift);
    for (int i = 0; i < 3; i++) {
        twist[i] = gap[i] - shift[i];
        gap[i] /= of->length;
    }
    return greater(dot(gap, gap), dot(turn, turn));
}

/* Write the components of a twist along the reduced rows of a loop, the first of which is given. */
static void along_rows(const Closure *of, Py_ssize_t loop, Py_ssize_t first, const double *twist,
                       const double *actions, double sign, double *result)
{
    double seen[6];
    int64_t carrier = of->integers[CARRIERS][loop];
    if (carrier < 0) {
        for (int i = 0; i < 6; i++)
            seen[i] = sign * twist[i];
    } else {
        /* The unit twists of the carrier hold its axes and their moments. */
        const double *action = actions + 36 * carrier;
        double shift[3];
        for (int i = 0; i < 3; i++) {
            const double *about = action + 18 + 6 * i;
            seen[i] = dot(about + 3, twist) + dot(about, twist + 3);
            seen[3 + i] = dot(about + 3, twist + 3);
        }
        cross(seen + 3, of->numbers[POINTS] + 3 * loop, shift);
        for (int i = 0; i < 3; i++) {
            seen[i] = sign * (seen[i] + shift[i]);
            seen[3 + i] *= sign;
        }
    }
    double weight = 1.0 / of->length;
    for (int i = 0; i < 3; i++)
        seen[i] *= weight;
    const int64_t *single = of->integers[SINGLE] + first;
    const double *rows = of->numbers[ROWS] + 6 * first;
    for (Py_ssize_t row = 0; row < of->integers[ROW_COUNTS][loop]; row++)
        result[row] = single[row] >= 0 ? seen[single[row]]
                                       : dot(rows + 6 * row, seen) +
                                             dot(rows + 6 * row + 3, seen + 3);
}

/* Write the direction of an idle rod's line. */
static void line_of(const Closure *of, Py_ssize_t rod, const double *actions, double *line)
{
    const double *action = actions + 36 * of->integers[ROD_BODIES][rod];
    const double *own = of->numbers[LINES] + 3 * rod;
    for (int i = 0; i < 3; i++)
        line[i] = own[0] * action[i] + own[1] * action[6 + i] + own[2] * action[12 + i];
}

/* Write the rows (m, whole) of all movable coordinates. */
static void rows_of(const Closure *of, const double *twists, const double *actions, double *rows)
{
    memset(rows, 0, sizeof(double) * of->movable * of->whole);
    const int64_t *columns = of->integers[PATH_COLUMNS];
    const double *signs = of->numbers[SIGNS];
    Py_ssize_t first = 0;
    for (Py_ssize_t loop = 0; loop < of->loops; loop++) {
        Py_ssize_t count = of->integers[PATH_COUNTS][loop];
        for (Py_ssize_t k = 0; k < count; k++)
            along_rows(of, loop, first, twists + 6 * columns[k], actions, signs[k],
                       rows + of->whole * columns[k] + first);
        columns += count, signs += count;
        first += of->integers[ROW_COUNTS][loop];
    }
    if (of->couplings)
        for (Py_ssize_t k = 0; k < of->movable; k++)
            memcpy(rows + of->whole * k + first,
                   of->numbers[COUPLING_ROWS] + of->couplings * k,
                   sizeof(double) * of->couplings);
    for (Py_ssize_t rod = 0; rod < of->rods; rod++) {
        Py_ssize_t count = of->integers[PATH_COUNTS][of->loops + rod];
        double line[3];
        line_of(of, rod, actions, line);
        for (Py_ssize_t k = 0; k < count; k++)
            rows[of->whole * columns[k] + of->rows + rod] =
                signs[k] * dot(twists + 6 * columns[k] + 3, line);
        columns += count, signs += count;
    }
}

/* closure(plan, placed (N, n, 12), x (N, size), turns (N, size) or None,
           actions (N, 6 n, 6), twists (N, m, 6), rows (N, m, R + k), error (N, R),
           samples (4, N), inverse (N, R + k, p) or None): whether no matrix is exactly singular.

   `samples` are residuals; condition numbers, if inverses are asked for; and what is known of
   guesses from which no step was taken: zero correction, and infinity for what a step leaves. */
PyObject *closure(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 10)
    Array arrays[9];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    Closure closure, *of = &closure;
    if (closure_of(given[0], of) < 0)
        return NULL;
    if (take_each(&held, given + 1, "3 2 ?2 =3 =3 =3 =2 =2 ?=3"))
        goto done;
    Array *placed = arrays, *x = arrays + 1, *turns = arrays + 2, *actions = arrays + 3;
    Array *twists = arrays + 4, *rows = arrays + 5, *error = arrays + 6, *samples = arrays + 7;
    Array *inverse = arrays + 8;
    turns = turns->at ? turns : NULL;
    inverse = inverse->at ? inverse : NULL;
    Py_ssize_t count = placed->size[0], p = of->passive;
    if (has_size(placed, 1, of->bodies, 0) || has_size(placed, 2, 12, 0) ||
        has_size(x, 0, count, 0) || has_size(x, 1, of->row_length, 0) ||
        (turns && (has_size(turns, 0, count, 0) || has_size(turns, 1, of->row_length, 0))) ||
        is_whole(actions, count, 0, 6 * of->bodies, 6) ||
        is_whole(twists, count, 0, of->movable, 6) ||
        is_whole(rows, count, 0, of->movable, of->whole) || has_size(error, 0, count, 0) ||
        has_size(error, 1, of->rows, 0) || has_size(samples, 0, 4, 0) ||
        has_size(samples, 1, count, 0) ||
        (inverse && (has_size(rows, 2, p, 0) || is_whole(inverse, count, 0, of->whole, p))))
        goto done;
    double *work = room_for(&held, 12 * of->bodies + of->rows + p * p + p);
    if (!work)
        goto done;
    double *places = work, *left = places + 12 * of->bodies, *lower = left + of->rows;
    Py_ssize_t *order = (Py_ssize_t *)(lower + p * p);
    int regular = 1;
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        double *action = actions->at + sample * actions->step[0];
        double *twist = twists->at + sample * twists->step[0];
        double *row = rows->at + sample * rows->step[0];
        for (Py_ssize_t body = 0; body < of->bodies; body++) {
            const double *from =
                placed->at + sample * placed->step[0] + body * placed->step[1];
            for (int i = 0; i < 12; i++)
                places[12 * body + i] = from[i * placed->step[2]];
            act(places + 12 * body, action + 36 * body);
        }
        unit_twists(of, action, twist);
        rows_of(of, twist, action, row);
        double worst = 0.0;
        Py_ssize_t first = 0;
        for (Py_ssize_t loop = 0; loop < of->loops; loop++) {
            double off[6];
            worst = greater(worst, error_of(of, loop, places, off));
            along_rows(of, loop, first, off, action, 1.0, left + first);
            first += of->integers[ROW_COUNTS][loop];
        }
        double residual = sqrt(worst);
        for (Py_ssize_t k = 0; k < of->couplings; k++) {
            double slip = 0.0;
            for (Py_ssize_t c = 0; c < of->coupled; c++) {
                Py_ssize_t column = of->integers[COUPLED][c];
                double angle = x->at[sample * x->step[0] + column * x->step[1]];
                if (turns)
                    angle += TAU *
                             turns->at[sample * turns->step[0] + column * turns->step[1]];
                slip += angle * of->numbers[RATIOS][c * of->couplings + k];
            }
            slip += of->numbers[OFFSETS][k];
            left[of->loop_rows + k] = slip / of->numbers[SLIP_UNITS][k];
            residual = greater(residual, fabs(slip) / of->numbers[SLIP_UNITS][k]);
        }
        for (Py_ssize_t k = 0; k < of->rows; k++)
            error->at[sample * error->step[0] + k * error->step[1]] = left[k];
        double *of_sample = samples->at + sample * samples->step[1];
        of_sample[0] = residual;
        of_sample[2 * samples->step[0]] = 0.0;
        of_sample[3 * samples->step[0]] = INFINITY;
        if (!inverse || !regular)
            continue;
        const double *passive = row + of->known * of->whole, *scale = of->numbers[ROW_SCALE];
        double *result = inverse->at + sample * inverse->step[0];
        memcpy(lower, passive, sizeof(double) * p * p);
        regular = invert(lower, result, p, order);
        double of_rows = 0.0, of_inverse = 0.0;
        for (Py_ssize_t i = 0; i < p; i++) {
            double of_row = 0.0, of_column = 0.0;
            for (Py_ssize_t j = 0; j < p; j++) {
                of_row += passive[i * p + j] * passive[i * p + j];
                of_column += result[j * p + i] * result[j * p + i];
            }
            of_rows += of_row * scale[i] * scale[i];
            of_inverse += of_column / (scale[i] * scale[i]);
        }
        of_sample[samples->step[0]] = sqrt(of_rows * of_inverse);
    }
    answer = PyBool_FromLong(regular);
done:
    release(&held);
    return answer;
}

/* Add the acceleration of what moves with one twist and has another: both times a factor. */
static void add_product_of_twists(const double *carrier, const double *joint, double factor,
                                  double *result)
{
    double linear[3], other[3], angular[3];
    cross(carrier + 3, joint, linear);
    cross(carrier, joint + 3, other);
    cross(carrier + 3, joint + 3, angular);
    for (int i = 0; i < 3; i++) {
        result[i] += factor * (linear[i] + other[i]);
        result[3 + i] += factor * angular[i];
    }
}

/* Write the acceleration that rates (m) alone cause along a path, see `LoopPaths.drift`. */
static void drift_of(const Closure *of, const int64_t *columns, const double *signs,
                     Py_ssize_t count, const double *twists, const double *rates, int closes,
                     double *result)
{
    const int64_t *moved = of->integers[MOVED];
    double carrier[6] = {0.0}, sum[6] = {0.0}, end[6] = {0.0};
    int64_t body = -1; /* The base carries the first body of a side, and does not move. */
    int is_carried = 0;
    memset(result, 0, 6 * sizeof(double));
    for (Py_ssize_t k = 0; k < count; k++) {
        if (k && signs[k] != signs[k - 1]) {
            memcpy(end, sum, sizeof sum);
            memset(sum, 0, sizeof sum);
            body = -1;
        }
        int64_t own = moved[columns[k]];
        if (own != body) {
            memcpy(carrier, sum, sizeof sum);
            is_carried = body >= 0;
            body = own;
        }
        const double *twist = twists + 6 * columns[k];
        double joint[6], rate = rates[columns[k]];
        for (int i = 0; i < 6; i++) {
            joint[i] = twist[i] * rate;
            sum[i] += joint[i];
        }
        if (is_carried)
            add_product_of_twists(carrier, joint, signs[k], result);
    }
    /* On one side only, nothing is at the other end. */
    if (closes && count && signs[0] != signs[count - 1])
        add_product_of_twists(end, sum, 1.0, result);
}

/* Write the drift of all loops along their reduced rows, and zero for couplings. */
static void drift_along_rows(const Closure *of, const double *twists, const double *actions,
                             const double *rates, int closes, double *result)
{
    const int64_t *columns = of->integers[PATH_COLUMNS];
    const double *signs = of->numbers[SIGNS];
    double drift[6];
    Py_ssize_t first = 0;
    for (Py_ssize_t loop = 0; loop < of->loops; loop++) {
        Py_ssize_t count = of->integers[PATH_COUNTS][loop];
        drift_of(of, columns, signs, count, twists, rates, closes, drift);
        along_rows(of, loop, first, drift, actions, 1.0, result + first);
        columns += count, signs += count;
        first += of->integers[ROW_COUNTS][loop];
    }
    for (Py_ssize_t k = 0; k < of->couplings; k++)
        result[first + k] = 0.0;
    if (closes)
        return;
    for (Py_ssize_t rod = 0; rod < of->rods; rod++) {
        Py_ssize_t count = of->integers[PATH_COUNTS][of->loops + rod];
        double line[3];
        /* A line is fixed in its rod, so its own motion adds nothing along it. */
        drift_of(of, columns, signs, count, twists, rates, 0, drift);
        line_of(of, rod, actions, line);
        result[of->rows + rod] = dot(drift + 3, line);
        columns += count, signs += count;
    }
}

/* Return the greatest component of a step (p), each in its unit. */
static double size_of(const Closure *of, const double *step)
{
    double size = 0.0;
    for (Py_ssize_t k = 0; k < of->passive; k++)
        size = greater(size, fabs(step[k] * of->numbers[STEP_SCALE][k]));
    return size;
}

/* newton_step(plan, inverse (N, R + k, p), error (N, R), twists (N, m, 6), actions (N, 6 n, 6),
               longest, step (N, p), samples (2, N)).

   The step is shortened to the longest, then bent. `samples` are its sizes, before that, and what
   it leaves. */
PyObject *newton_step(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 8)
    Array arrays[6];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    Closure closure, *of = &closure;
    if (closure_of(given[0], of) < 0)
        return NULL;
    double longest = PyFloat_AsDouble(given[5]);
    if (longest == -1.0 && PyErr_Occurred())
        return NULL;
    if (take_each(&held, given + 1, "3 2 3 3") || take_each(&held, given + 6, "=2 =2"))
        goto done;
    Array *inverse = arrays, *error = arrays + 1, *twists = arrays + 2, *actions = arrays + 3;
    Array *step = arrays + 4, *samples = arrays + 5;
    Py_ssize_t count = error->size[0], p = of->passive;
    if (has_size(error, 1, of->rows, 0) || has_size(inverse, 0, count, 0) ||
        has_size(inverse, 1, of->whole, 0) || has_size(inverse, 2, p, 0) ||
        is_whole(twists, count, 0, of->movable, 6) ||
        is_whole(actions, count, 0, 6 * of->bodies, 6) ||
        has_size(step, 0, count, 0) || has_size(step, 1, p, 0) || has_size(samples, 0, 2, 0) ||
        has_size(samples, 1, count, 0))
        goto done;
    double *work = room_for(&held, 2 * of->whole + of->movable + p);
    if (!work)
        goto done;
    double *off = work, *drift = off + of->whole, *rates = drift + of->whole;
    double *bend = rates + of->movable, *own = rates + of->known;
    memset(rates, 0, sizeof(double) * of->known);
    Matrix transposed = {NULL, p, of->rows, inverse->step[2], inverse->step[1]};
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        transposed.at = inverse->at + sample * inverse->step[0];
        for (Py_ssize_t k = 0; k < of->rows; k++)
            off[k] = error->at[sample * error->step[0] + k * error->step[1]];
        memset(own, 0, sizeof(double) * p);
        add_product(&transposed, off, -1.0, own);
        double size = size_of(of, own);
        double left = CURVATURE * (size * size);
        if (isfinite(longest) && !(size <= longest))
            for (Py_ssize_t k = 0; k < p; k++)
                own[k] *= longest / size;
        if (size > STRAIGHT && size <= BENT) {
            drift_along_rows(of, twists->at + sample * twists->step[0],
                             actions->at + sample * actions->step[0], rates, 1, drift);
            memset(bend, 0, sizeof(double) * p);
            add_product(&transposed, drift, -0.5, bend);
            double bends = size_of(of, bend);
            if (bends <= MOST_BENT * size) {
                for (Py_ssize_t k = 0; k < p; k++)
                    own[k] += bend[k];
                left = bends / size * bends + size * size * size;
            }
        }
        for (Py_ssize_t k = 0; k < p; k++)
            step->at[sample * step->step[0] + k * step->step[1]] = own[k];
        double *of_sample = samples->at + sample * samples->step[1];
        of_sample[0] = size;
        of_sample[samples->step[0]] = left;
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}

/* Solve the closure equations of a sample for passive rates (p), from `right` (R + k). */
static void solve_passive(const Closure *of, const Matrix *inverse, const double *rows,
                          double *right, double *solution)
{
    Matrix closing = {rows + of->known * of->whole, of->whole, of->passive, 1, of->whole};
    solve(&closing, inverse, right, solution);
}

/* What both of the following have: arrays of a state, of one or of `count` samples. */
static int has_state(const Closure *of, const Array *rows, const Array *inverse, Py_ssize_t count)
{
    return is_whole(rows, count, 1, of->movable, of->whole) || has_size(inverse, 0, count, 1) ||
           has_size(inverse, 1, of->whole, 0) || has_size(inverse, 2, of->passive, 0);
}

static int has_rates(const Closure *of, const Array *array)
{
    if (are_indices(of->integers[MOVABLE], of->movable, 1, 0, array->size[1]))
        return 0;
    PyErr_SetString(PyExc_ValueError, "too few joint rates");
    return -1;
}

/* passive_rates(plan, rows (N, m, R + k), inverse (N, R + k, p), v (M, nv, c)).

   Those of the passives are written into `v`; N is M or 1. */
PyObject *passive_rates(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 4)
    Array arrays[3];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    Closure closure, *of = &closure;
    if (closure_of(given[0], of) < 0)
        return NULL;
    if (take_each(&held, given + 1, "3 3 =3"))
        goto done;
    Array *rows = arrays, *inverse = arrays + 1, *v = arrays + 2;
    Py_ssize_t count = v->size[0], sides = v->size[2];
    if (has_state(of, rows, inverse, count) || has_rates(of, v))
        goto done;
    double *work = room_for(&held, of->whole + of->passive);
    if (!work)
        goto done;
    double *right = work, *solution = right + of->whole;
    const int64_t *movable = of->integers[MOVABLE];
    Matrix transposed = {NULL, of->passive, of->whole, inverse->step[2], inverse->step[1]};
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        const double *row = rows->at + sample * rows->step[0];
        transposed.at = inverse->at + sample * inverse->step[0];
        for (Py_ssize_t side = 0; side < sides; side++) {
            double *rates = v->at + sample * v->step[0] + side * v->step[2];
            memset(right, 0, sizeof(double) * of->whole);
            for (Py_ssize_t k = 0; k < of->known; k++) {
                double rate = rates[movable[k] * v->step[1]];
                for (Py_ssize_t i = 0; i < of->whole; i++)
                    right[i] += row[k * of->whole + i] * rate;
            }
            solve_passive(of, &transposed, row, right, solution);
            for (Py_ssize_t k = 0; k < of->passive; k++)
                rates[movable[of->known + k] * v->step[1]] = -solution[k];
        }
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}

/* passive_accelerations(plan, rows (N, m, R + k), inverse (N, R + k, p), twists (N, m, 6),
                         actions (N, 6 n, 6), v (M, nv), a (M, nv)).

   Those of the passives are written into `a`; N is M or 1. */
PyObject *passive_accelerations(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 7)
    Array arrays[6];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    Closure closure, *of = &closure;
    if (closure_of(given[0], of) < 0)
        return NULL;
    if (take_each(&held, given + 1, "3 3 3 3 2 =2"))
        goto done;
    Array *rows = arrays, *inverse = arrays + 1, *twists = arrays + 2, *actions = arrays + 3;
    Array *v = arrays + 4, *a = arrays + 5;
    Py_ssize_t count = a->size[0];
    if (has_state(of, rows, inverse, count) || is_whole(twists, count, 1, of->movable, 6) ||
        is_whole(actions, count, 1, 6 * of->bodies, 6) || has_size(v, 0, count, 0) ||
        has_size(v, 1, a->size[1], 0) || has_rates(of, a))
        goto done;
    double *work = room_for(&held, of->whole + of->passive + of->movable);
    if (!work)
        goto done;
    double *right = work, *solution = right + of->whole, *rates = solution + of->passive;
    const int64_t *movable = of->integers[MOVABLE];
    Matrix transposed = {NULL, of->passive, of->whole, inverse->step[2], inverse->step[1]};
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        const double *row = rows->at + sample * rows->step[0];
        double *result = a->at + sample * a->step[0];
        transposed.at = inverse->at + sample * inverse->step[0];
        for (Py_ssize_t k = 0; k < of->movable; k++)
            rates[k] = v->at[sample * v->step[0] + movable[k] * v->step[1]];
        drift_along_rows(of, twists->at + sample * twists->step[0],
                         actions->at + sample * actions->step[0], rates, 0, right);
        for (Py_ssize_t k = 0; k < of->known; k++) {
            double known = result[movable[k] * a->step[1]];
            for (Py_ssize_t i = 0; i < of->whole; i++)
                right[i] += row[k * of->whole + i] * known;
        }
        solve_passive(of, &transposed, row, right, solution);
        for (Py_ssize_t k = 0; k < of->passive; k++)
            result[movable[of->known + k] * a->step[1]] = -solution[k];
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}

/* What a plan of moves holds: columns, and where they are in a step; then the first ones of
   quaternions, and of what these turn by. */
enum { MOVED_COLUMNS, OF_STEP, QUATERNIONS, ROTATIONS, MOVES_INTEGERS };

static int moves_fit(const Plan *plan)
{
    const Py_ssize_t *sizes = plan->integer_sizes;
    return sizes[MOVED_COLUMNS] == sizes[OF_STEP] && sizes[QUATERNIONS] == sizes[ROTATIONS];
}

const PlanKind moves_plan = {"moves", MOVES_INTEGERS, 0, moves_fit};

/* moved(plan, x (N, size), step (N, k)): move rows in place, the twin of `Moves.apply`. */
PyObject *moved(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 3)
    Array arrays[2];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    const Plan *plan = plan_of(given[0], &moves_plan);
    if (!plan)
        return NULL;
    Array *x = arrays, *steps = arrays + 1;
    if (take_each(&held, given + 1, "=2 2") || has_size(steps, 0, x->size[0], 0))
        goto done;
    const Py_ssize_t *sizes = plan->integer_sizes;
    const int64_t *columns = plan->integers[MOVED_COLUMNS], *of_step = plan->integers[OF_STEP];
    const int64_t *balls = plan->integers[QUATERNIONS], *spins = plan->integers[ROTATIONS];
    if (!are_indices(columns, sizes[MOVED_COLUMNS], 1, 0, x->size[1]) ||
        !are_indices(of_step, sizes[OF_STEP], 1, 0, steps->size[1]) ||
        !are_indices(balls, sizes[QUATERNIONS], 1, 0, x->size[1] - 3) ||
        !are_indices(spins, sizes[ROTATIONS], 1, 0, steps->size[1] - 2)) {
        PyErr_SetString(PyExc_ValueError, "rows or steps have too few coordinates");
        goto done;
    }
    for (Py_ssize_t sample = 0; sample < x->size[0]; sample++) {
        double *row = x->at + sample * x->step[0];
        const double *step = steps->at + sample * steps->step[0];
        for (Py_ssize_t k = 0; k < sizes[MOVED_COLUMNS]; k++)
            row[columns[k] * x->step[1]] += step[of_step[k] * steps->step[1]];
        for (Py_ssize_t k = 0; k < sizes[QUATERNIONS]; k++) {
            double q[4], r[4], result[4];
            for (int i = 0; i < 4; i++)
                q[i] = row[(balls[k] + i) * x->step[1]];
            for (int i = 0; i < 3; i++)
                r[i] = 0.5 * step[(spins[k] + i) * steps->step[1]];
            double half = sqrt(dot(r, r)), ratio = half == 0.0 ? 1.0 : sin(half) / half;
            for (int i = 0; i < 3; i++)
                r[i] *= ratio;
            r[3] = cos(half);
            turned(q, r, result);
            for (int i = 0; i < 4; i++)
                row[(balls[k] + i) * x->step[1]] = result[i];
        }
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}
