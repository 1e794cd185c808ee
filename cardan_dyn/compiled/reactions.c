/* Reactions: the twins of what dynamics/reactions.py does once the wrenches of the open tree are
   known, and of what dynamics/inverse_dynamics.py takes from its results.

   Samples are worked on one after the other, all groups, load cases and self-stresses of one at
   once, so that what a self-stress adds to wrenches is never kept for all samples. Matrices have the
   load cases, or the amounts of a self-stress, as columns. Products are written out in full: what
   is not a number spreads as it does in NumPy's. */

#include "arrays.h"
#include "kernels.h"

/* A pivot of the normal equations up to this part of its diagonal entry is what rounding leaves of
   zero: another self-stress loads the joints alike, or none is loaded. */
#define SINGULAR 1e-15

/* What a plan holds, in the order of its arrays; see dynamics/reaction_plan.py. */
enum {
    SIZES, GROUPS, PASSIVES, LOOPS, PATHS, COUPLINGS, COUPLED, ITEMS, JOINTS, TARGETS, PAIRS, SHARED,
    ROWS, INTEGER_ARRAYS
};
enum { SCALES, UNITS, MATRICES, SIGNS, RATIOS, NUMBER_ARRAYS };
enum {
    KIND, RATES, BODIES, LOOP_COUNT, COUPLING_COUNT, ALONG_AXES, MOST_PASSIVES, MOST_MULTIPLIERS,
    MOST_AMOUNTS, SPREAD_SIZE, UNIT_SIZE, NORMAL_SIZE, SIZE_COUNT
};
#define REACTIONS 1296390985 /* Tells plans of this kind from others. */

typedef struct {
    int64_t passives, columns, rows, amounts, action_rows, first_passive, loops, couplings, item;
} Group;

typedef struct {
    int64_t loop, rows, carrier, first_on_path, on_path, fixed, end, item, fixed_slot;
} Loop;

typedef struct {
    int64_t row, joint, slot;
} OnPath;

typedef struct {
    int64_t coupling, first, successors, predecessors;
} Coupling;

/* A self-stress, by its amounts. */
typedef struct {
    int64_t amounts, first_amount, joints, first_joint, spread, unit_rows, first_target, units;
} Item;

typedef struct {
    int64_t first, second, first_shared, shared;
} Pair;

typedef struct {
    int64_t first_column, start;
} Row;

typedef struct {
    double rows[36], null[36], point[3], rotation[9], translation[3];
} Matrices;

/* The arrays of a group at all samples. */
typedef struct {
    const Array *actions, *square, *inverse, *null;
} Given;

typedef struct {
    const int64_t *sizes;
    const Group *groups;
    const int64_t *passives;
    const Loop *loops;
    const OnPath *paths;
    const Coupling *couplings;
    const int64_t *coupled;
    const Item *items;
    const int64_t *joints, *targets;
    const Pair *pairs;
    const int64_t *shared;
    const Row *rows;
    const double *scales, *units;
    const Matrices *matrices;
    const double *signs, *ratios;
    Py_ssize_t group_count, item_count, pair_count, amount_count, force_rows, cases;
    /* Of the sample that is worked on. */
    double *wrenches, *forces, *given, *missing, *left, *multipliers, *combined, *force;
    double *spread, *unit_forces, *normal, *diagonal, *amounts;
    /* Of all samples. */
    double *greatest, *greatest_moments;
} Work;

/* The greater one; what is not a number stays. */
static inline double greater(double known, double found)
{
    return found > known || found != found ? found : known;
}

/* result (6, k) = sign * matrix (6, 6) @ columns (6, k). */
static inline void times(const double *matrix, Py_ssize_t row, Py_ssize_t column, double sign,
                         const double *columns, Py_ssize_t k, double *result)
{
    for (int i = 0; i < 6; i++)
        for (Py_ssize_t m = 0; m < k; m++) {
            double sum = 0.0;
            for (int j = 0; j < 6; j++)
                sum += matrix[i * row + j * column] * columns[j * k + m];
            result[i * k + m] = sign * sum;
        }
}

/* Where a joint's frame is, from its action: a rotation, row by row, and a position. */
static void placement(const Array *actions, Py_ssize_t sample, int64_t body, double *rotation,
                      double *position)
{
    const double *action =
        actions->at + sample * actions->step[0] + 6 * body * actions->step[1];
    Py_ssize_t row = actions->step[1], column = actions->step[2];
    static const int before[3] = {2, 0, 1}, after[3] = {1, 2, 0};
    for (int a = 0; a < 3; a++)
        for (int c = 0; c < 3; c++)
            rotation[3 * a + c] = action[c * row + a * column];
    for (int a = 0; a < 3; a++) {
        double sum = 0.0;
        for (int c = 0; c < 3; c++)
            sum += action[(3 + c) * row + before[a] * column] * rotation[3 * after[a] + c];
        position[a] = sum;
    }
}

/* position + rotation @ vector, in place. */
static void shift(const double *rotation, const double *vector, double *position)
{
    for (int a = 0; a < 3; a++)
        position[a] += rotation[3 * a] * vector[0] + rotation[3 * a + 1] * vector[1] +
                       rotation[3 * a + 2] * vector[2];
}

static const int NEXT[3] = {1, 2, 0}, AFTER_NEXT[3] = {2, 0, 1};

/* The matrix (6, 6) that takes wrenches in the axes of a body to the base's, see `LoopAxes`. */
static void from_carrier(const Array *actions, Py_ssize_t sample, int64_t body, const double *point,
                         double *matrix)
{
    double rotation[9], position[3];
    placement(actions, sample, body, rotation, position);
    shift(rotation, point, position);
    memset(matrix, 0, 36 * sizeof(double));
    for (int a = 0; a < 3; a++)
        for (int c = 0; c < 3; c++) {
            matrix[6 * a + c] = matrix[6 * (a + 3) + c + 3] = rotation[3 * a + c];
            matrix[6 * (a + 3) + c] = position[NEXT[a]] * rotation[3 * AFTER_NEXT[a] + c] -
                                      position[AFTER_NEXT[a]] * rotation[3 * NEXT[a] + c];
        }
}

/* The matrix (6, 6) that takes wrenches in the base's axes to the frame of a `fixed` loop. */
static void to_end(const Array *actions, Py_ssize_t sample, const Loop *loop,
                   const Matrices *matrices, double *matrix)
{
    double rotation[9], position[3];
    if (loop->end < 0) {
        memcpy(rotation, matrices->rotation, sizeof(rotation));
        memcpy(position, matrices->translation, sizeof(position));
    } else {
        double body[9];
        placement(actions, sample, loop->end, body, position);
        shift(body, matrices->translation, position);
        for (int a = 0; a < 3; a++)
            for (int c = 0; c < 3; c++)
                rotation[3 * a + c] = body[3 * a] * matrices->rotation[c] +
                                      body[3 * a + 1] * matrices->rotation[3 + c] +
                                      body[3 * a + 2] * matrices->rotation[6 + c];
    }
    memset(matrix, 0, 36 * sizeof(double));
    for (int c = 0; c < 3; c++)
        for (int a = 0; a < 3; a++) {
            matrix[6 * c + a] = matrix[6 * (c + 3) + a + 3] = rotation[3 * a + c];
            matrix[6 * (c + 3) + a] = position[NEXT[a]] * rotation[3 * AFTER_NEXT[a] + c] -
                                      position[AFTER_NEXT[a]] * rotation[3 * NEXT[a] + c];
        }
}

/* The wrench (6, k) of a loop in the base's axes, from combinations of its weighted rows. */
static void wrench(const Work *work, const double *carrier, const double *combinations, int64_t k,
                   double *scratch, double *result)
{
    double *weighted = carrier ? scratch : result;
    for (int i = 0; i < 6; i++)
        for (int64_t m = 0; m < k; m++)
            weighted[i * k + m] = combinations[i * k + m] * work->scales[i];
    if (carrier)
        times(carrier, 6, 1, 1.0, weighted, k, result);
}

/* Combinations (6, k) of a loop's rows, from their multipliers. */
static void combine(const Matrices *matrices, int64_t rows, const double *multipliers,
                    Py_ssize_t row, Py_ssize_t column, int64_t k, double *result)
{
    for (int i = 0; i < 6; i++)
        for (int64_t m = 0; m < k; m++) {
            double sum = 0.0;
            if (rows == 6)
                sum = multipliers[i * row + m * column];
            else
                for (int64_t j = 0; j < rows; j++)
                    sum += matrices->rows[i * rows + j] * multipliers[j * row + m * column];
            result[i * k + m] = sum;
        }
}

/* Add what forces (6, k) of a loop add to the wrenches of the joints on it.

   Where `by_slot`, into what a self-stress adds; `on_loop` alone has its joints in their order. */
static void along_path(const Work *work, const Given *given, Py_ssize_t sample, const Loop *loop,
                       const double *end, const double *forces, int64_t k, double *result,
                       int by_slot, int on_loop)
{
    const double *actions = given->actions->at + sample * given->actions->step[0];
    Py_ssize_t row = given->actions->step[1], column = given->actions->step[2];
    const OnPath *path = work->paths + loop->first_on_path;
    double *added = work->combined;
    for (int64_t index = 0; index <= loop->on_path; index++) {
        int64_t place;
        if (index < loop->on_path) {
            const OnPath *on = path + index;
            double sign = work->signs[loop->first_on_path + index];
            const double *action = actions + on->row * row;
            if (row == 6 && column == 1)
                times(action, 6, 1, sign, forces, k, added);
            else
                times(action, row, column, sign, forces, k, added);
            place = on_loop ? index : by_slot ? on->slot : on->joint;
        } else {
            if (loop->fixed < 0)
                break;
            times(end, 6, 1, 1.0, forces, k, added);
            place = on_loop ? index : by_slot ? loop->fixed_slot : loop->fixed;
        }
        double *to = result + place * 6 * k;
        for (int64_t m = 0; m < 6 * k; m++)
            to[m] += added[m];
    }
}

/* Solve for the multipliers of a group from explicit inverses, with one step of refinement. */
static void multipliers_of(const Work *work, const Group *group, const Given *given,
                           Py_ssize_t sample)
{
    const double *square = given->square->at + sample * given->square->step[0];
    const double *inverse = given->inverse->at + sample * given->inverse->step[0];
    Py_ssize_t row = given->square->step[1], column = given->square->step[2];
    Py_ssize_t inverse_row = given->inverse->step[1], inverse_column = given->inverse->step[2];
    Py_ssize_t cases = work->cases;
    for (int64_t j = 0; j < group->columns; j++)
        for (Py_ssize_t m = 0; m < cases; m++) {
            double sum = 0.0;
            for (int64_t i = 0; i < group->passives; i++)
                sum += inverse[j * inverse_row + i * inverse_column] * work->missing[i * cases + m];
            work->multipliers[j * cases + m] = sum;
        }
    for (int64_t i = 0; i < group->passives; i++)
        for (Py_ssize_t m = 0; m < cases; m++) {
            double sum = 0.0;
            for (int64_t j = 0; j < group->columns; j++)
                sum += square[i * row + j * column] * work->multipliers[j * cases + m];
            work->left[i * cases + m] = work->missing[i * cases + m] - sum;
        }
    /* Those of idle rods, behind the others, are no closure forces. */
    for (int64_t j = 0; j < group->rows; j++)
        for (Py_ssize_t m = 0; m < cases; m++) {
            double sum = 0.0;
            for (int64_t i = 0; i < group->passives; i++)
                sum += inverse[j * inverse_row + i * inverse_column] * work->left[i * cases + m];
            work->multipliers[j * cases + m] += sum;
        }
}

/* What is missing along the passives of a group: given efforts less those of the wrenches. */
static void missing_along(const Work *work, const Group *group)
{
    Py_ssize_t cases = work->cases;
    for (int64_t i = 0; i < group->passives; i++) {
        int64_t passive = group->first_passive + i;
        int64_t rate = work->passives[2 * passive], row = work->passives[2 * passive + 1];
        for (Py_ssize_t m = 0; m < cases; m++) {
            double effort = 0.0;
            if (work->sizes[ALONG_AXES])
                effort = work->wrenches[row * cases + m] * work->units[passive];
            else
                for (int j = 0; j < 6; j++)
                    effort += work->wrenches[(row + j) * cases + m] * work->units[6 * passive + j];
            work->missing[i * cases + m] = work->given[rate * cases + m] - effort;
        }
    }
}

/* Closure forces of a group and its self-stresses; loops and couplings are those from there on. */
static void close_group(Work *work, const Group *group, const Given *given, Py_ssize_t sample,
                        const Loop *loops, const Matrices *matrices, const Coupling *couplings,
                        const double *ratios)
{
    Py_ssize_t cases = work->cases;
    int64_t start = 0, unit_row = 0, amounts = group->amounts;
    const double *null = NULL;
    Py_ssize_t null_row = 0, null_column = 0;
    double *units = NULL, *spread = NULL;
    if (group->item >= 0) {
        null = given->null->at + sample * given->null->step[0];
        null_row = given->null->step[1];
        null_column = given->null->step[2];
        units = work->unit_forces + work->items[group->item].units;
        spread = work->spread + work->items[group->item].spread;
    }
    missing_along(work, group);
    multipliers_of(work, group, given, sample);
    for (int64_t index = 0; index < group->loops; index++) {
        const Loop *loop = loops + index;
        const Matrices *own = matrices + index;
        double carrier_matrix[36], end_matrix[36], *carrier = NULL, *end = NULL;
        if (loop->carrier >= 0)
            from_carrier(given->actions, sample, loop->carrier, own->point,
                         carrier = carrier_matrix);
        if (loop->fixed >= 0)
            to_end(given->actions, sample, loop, own, end = end_matrix);
        double *forces = work->forces + 6 * loop->loop * cases;
        combine(own, loop->rows, work->multipliers + start * cases, cases, 1, cases,
                work->combined);
        wrench(work, carrier, work->combined, cases, work->force, forces);
        along_path(work, given, sample, loop, end, forces, cases, work->wrenches, 0, 0);
        if (null) {
            combine(own, loop->rows, null + start * null_row, null_row, null_column, amounts,
                    work->combined);
            double *unit = units + unit_row * amounts;
            wrench(work, carrier, work->combined, amounts, work->force, unit);
            along_path(work, given, sample, loop, end, unit, amounts, spread, 1, 0);
            unit_row += 6;
        }
        if (loop->item >= 0) {
            const Item *item = work->items + loop->item;
            double *unit = work->unit_forces + item->units;
            wrench(work, carrier, own->null, item->amounts, work->force, unit);
            along_path(work, given, sample, loop, end, unit, item->amounts,
                       work->spread + item->spread, 1, 1);
        }
        start += loop->rows;
    }
    for (int64_t index = 0; index < group->couplings; index++, start++, unit_row++) {
        const Coupling *coupling = couplings + index;
        double unit = ratios[2 * index], ratio = ratios[2 * index + 1];
        double *moment = work->forces +
                         (6 * work->sizes[LOOP_COUNT] + coupling->coupling) * cases;
        const int64_t *successors = work->coupled + coupling->first;
        const int64_t *predecessors = successors + coupling->successors;
        for (Py_ssize_t m = 0; m < cases; m++) {
            moment[m] = work->multipliers[start * cases + m] / unit;
            for (int64_t j = 0; j < coupling->successors; j++)
                work->given[successors[j] * cases + m] += moment[m];
            for (int64_t j = 0; j < coupling->predecessors; j++)
                work->given[predecessors[j] * cases + m] -= ratio * moment[m];
        }
        if (!null)
            continue;
        double *greatest = work->greatest_moments + coupling->coupling;
        for (int64_t m = 0; m < amounts; m++) {
            double moment_of_unit = null[start * null_row + m * null_column] / unit;
            units[unit_row * amounts + m] = moment_of_unit;
            *greatest = greater(*greatest, fabs(moment_of_unit));
        }
    }
}

/* The normal equations of the least norm: lower triangle, row by row, each from where it is not
   zero for lack of joints that both self-stresses load; and their right-hand sides. */
static void normal_equations(Work *work)
{
    Py_ssize_t cases = work->cases;
    const double *squares = work->scales + 6;
    memset(work->normal, 0, sizeof(double) * work->sizes[NORMAL_SIZE]);
    memset(work->amounts, 0, sizeof(double) * work->amount_count * cases);
    for (Py_ssize_t index = 0; index < work->pair_count; index++) {
        const Pair *pair = work->pairs + index;
        const Item *first = work->items + pair->first, *second = work->items + pair->second;
        const double *of_first = work->spread + first->spread;
        const double *of_second = work->spread + second->spread;
        for (int64_t shared = 0; shared < pair->shared; shared++) {
            const int64_t *slots = work->shared + 2 * (pair->first_shared + shared);
            const double *a = of_first + slots[0] * 6 * first->amounts;
            const double *b = of_second + slots[1] * 6 * second->amounts;
            for (int64_t k = 0; k < first->amounts; k++) {
                const Row *row = work->rows + first->first_amount + k;
                double *to = work->normal + row->start + second->first_amount - row->first_column;
                int64_t last = first == second ? k + 1 : second->amounts;
                for (int64_t l = 0; l < last; l++) {
                    double sum = 0.0;
                    for (int i = 0; i < 6; i++)
                        sum += a[i * first->amounts + k] * squares[i] * b[i * second->amounts + l];
                    to[l] += sum;
                }
                if (first != second)
                    continue;
                const double *loaded = work->wrenches +
                                       work->joints[first->first_joint + slots[0]] * 6 * cases;
                double *right = work->amounts + (first->first_amount + k) * cases;
                for (Py_ssize_t m = 0; m < cases; m++)
                    for (int i = 0; i < 6; i++)
                        right[m] -= a[i * first->amounts + k] * squares[i] * loaded[i * cases + m];
            }
        }
    }
}

/* Solve the normal equations, L D L' x = r; what a zero pivot leaves open is chosen as zero. */
static void solve_normal(Work *work)
{
    Py_ssize_t cases = work->cases;
    for (Py_ssize_t i = 0; i < work->amount_count; i++) {
        const Row *row = work->rows + i;
        /* Entry j of row i is at own[j]. */
        double *own = work->normal + row->start - row->first_column;
        double whole = own[i], pivot = own[i];
        for (int64_t j = row->first_column; j < i; j++) {
            const Row *other = work->rows + j;
            const double *of_other = work->normal + other->start - other->first_column;
            int64_t from = row->first_column > other->first_column ? row->first_column
                                                                   : other->first_column;
            double sum = own[j];
            for (int64_t m = from; m < j; m++)
                sum -= own[m] * of_other[m];
            own[j] = sum;
        }
        for (int64_t j = row->first_column; j < i; j++) {
            double scaled = own[j] * work->diagonal[j];
            pivot -= own[j] * scaled;
            own[j] = scaled;
            for (Py_ssize_t m = 0; m < cases; m++)
                work->amounts[i * cases + m] -= scaled * work->amounts[j * cases + m];
        }
        work->diagonal[i] = pivot <= SINGULAR * whole ? 0.0 : 1.0 / pivot;
    }
    for (Py_ssize_t i = 0; i < work->amount_count; i++)
        for (Py_ssize_t m = 0; m < cases; m++)
            work->amounts[i * cases + m] *= work->diagonal[i];
    for (Py_ssize_t i = work->amount_count - 1; i >= 0; i--) {
        const Row *row = work->rows + i;
        const double *own = work->normal + row->start - row->first_column;
        for (int64_t j = row->first_column; j < i; j++)
            for (Py_ssize_t m = 0; m < cases; m++)
                work->amounts[j * cases + m] -= own[j] * work->amounts[i * cases + m];
    }
}

/* Add the chosen amounts of all self-stresses to wrenches and closure forces. */
static void add_amounts(Work *work)
{
    Py_ssize_t cases = work->cases;
    for (Py_ssize_t index = 0; index < work->item_count; index++) {
        const Item *item = work->items + index;
        const double *amounts = work->amounts + item->first_amount * cases;
        const double *spread = work->spread + item->spread;
        for (int64_t slot = 0; slot < item->joints; slot++) {
            double *to = work->wrenches + work->joints[item->first_joint + slot] * 6 * cases;
            for (int i = 0; i < 6; i++, spread += item->amounts)
                for (Py_ssize_t m = 0; m < cases; m++) {
                    double sum = 0.0;
                    for (int64_t k = 0; k < item->amounts; k++)
                        sum += spread[k] * amounts[k * cases + m];
                    to[i * cases + m] += sum;
                }
        }
        const double *unit = work->unit_forces + item->units;
        for (int64_t row = 0; row < item->unit_rows; row++, unit += item->amounts) {
            double *to = work->forces + work->targets[item->first_target + row] * cases;
            for (Py_ssize_t m = 0; m < cases; m++) {
                double sum = 0.0;
                for (int64_t k = 0; k < item->amounts; k++)
                    sum += unit[k] * amounts[k * cases + m];
                to[m] += sum;
            }
        }
    }
}

/* Keep how much self-stresses change each component of a wrench at most. */
static void keep_greatest(Work *work)
{
    double *greatest = work->greatest;
    for (Py_ssize_t index = 0; index < work->item_count; index++) {
        const Item *item = work->items + index;
        const double *spread = work->spread + item->spread;
        for (int64_t row = 0; row < 6 * item->joints; row++, greatest++)
            for (int64_t k = 0; k < item->amounts; k++)
                *greatest = greater(*greatest, fabs(*spread++));
    }
}

/* Whether the sizes of a plan's arrays are those of a plan for this function. */
static int is_plan(const Plan *plan)
{
    if (plan->integer_arrays != INTEGER_ARRAYS || plan->number_arrays != NUMBER_ARRAYS ||
        plan->integer_sizes[SIZES] != SIZE_COUNT || plan->integers[SIZES][KIND] != REACTIONS) {
        PyErr_SetString(PyExc_ValueError, "this is no plan of reactions");
        return 0;
    }
    return 1;
}

/* reactions(plan, wrenches (N, b, 6, c), forces (N, 6 L + G, c), changes (b, 6), moments (G,),
             c loads (N, nv) or (1, nv),
             of each group in turn: actions, square, inverse, and null if it has amounts)

   The wrenches of the open tree become those of the closed chain. Results are closure forces, the
   greatest changes of wrenches per unit of self-stress, and those of the couplings' moments. */
PyObject *reactions(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    if (nargs < 5) {
        PyErr_SetString(PyExc_TypeError, "at least 5 arguments are needed");
        return NULL;
    }
    Plan *plan = plan_of(given[0]);
    if (!plan || !is_plan(plan))
        return NULL;
    const int64_t *sizes = plan->integers[SIZES];
    Py_ssize_t groups = plan->integer_sizes[GROUPS] / (Py_ssize_t)(sizeof(Group) / 8);
    Py_ssize_t force_rows = 6 * sizes[LOOP_COUNT] + sizes[COUPLING_COUNT];
    PyObject *answer = NULL;
    Array *arrays = malloc(sizeof(Array) * nargs);
    Given *of_groups = malloc(sizeof(Given) * (groups + 1));
    double *memory = NULL;
    Held held = {arrays, 0};
    if (!arrays || !of_groups) {
        PyErr_NoMemory();
        goto done;
    }
    Array *wrenches = take(&held, given[1], 4, 1);
    Array *forces = wrenches ? take(&held, given[2], 3, 1) : NULL;
    Array *changes = forces ? take(&held, given[3], 2, 1) : NULL;
    Array *moments = changes ? take(&held, given[4], 1, 1) : NULL;
    if (!moments)
        goto done;
    Py_ssize_t count = wrenches->size[0], cases = wrenches->size[3];
    if (has_size(wrenches, 1, sizes[BODIES], 0) || has_size(wrenches, 2, 6, 0) ||
        has_size(forces, 0, count, 0) || has_size(forces, 1, force_rows, 0) ||
        has_size(forces, 2, cases, 0) || has_size(changes, 0, sizes[BODIES], 0) ||
        has_size(changes, 1, 6, 0) || has_size(moments, 0, sizes[COUPLING_COUNT], 0))
        goto done;
    const Group *described = (const Group *)plan->integers[GROUPS];
    Py_ssize_t expected = 5 + cases;
    for (Py_ssize_t index = 0; index < groups; index++)
        expected += described[index].item >= 0 ? 4 : 3;
    if (nargs != expected) {
        PyErr_Format(PyExc_TypeError, "%zd arguments are needed, not %zd", expected, nargs);
        goto done;
    }
    const Array *loads = arrays + 4;
    for (Py_ssize_t index = 0; index < cases; index++) {
        const Array *load = take(&held, given[5 + index], 2, 0);
        if (!load || has_size(load, 0, count, 1) || has_size(load, 1, sizes[RATES], 0))
            goto done;
    }
    PyObject *const *next = given + 5 + cases;
    for (Py_ssize_t index = 0; index < groups; index++) {
        const Group *group = described + index;
        Given *own = of_groups + index;
        if (!(own->actions = take(&held, *next++, 3, 0)) ||
            !(own->square = take(&held, *next++, 3, 0)) ||
            !(own->inverse = take(&held, *next++, 3, 0)))
            goto done;
        if (has_size(own->actions, 0, count, 0) ||
            has_size(own->actions, 1, group->action_rows, 0) || has_size(own->actions, 2, 6, 0) ||
            has_size(own->square, 0, count, 0) || has_size(own->square, 1, group->passives, 0) ||
            has_size(own->square, 2, group->columns, 0) || has_size(own->inverse, 0, count, 0) ||
            has_size(own->inverse, 1, group->columns, 0) ||
            has_size(own->inverse, 2, group->passives, 0))
            goto done;
        if (group->item >= 0 &&
            (!(own->null = take(&held, *next++, 3, 0)) || has_size(own->null, 0, count, 0) ||
             has_size(own->null, 1, group->rows, 0) || has_size(own->null, 2, group->amounts, 0)))
            goto done;
    }
    Work work = {
        .sizes = sizes,
        .groups = described,
        .passives = plan->integers[PASSIVES],
        .loops = (const Loop *)plan->integers[LOOPS],
        .paths = (const OnPath *)plan->integers[PATHS],
        .couplings = (const Coupling *)plan->integers[COUPLINGS],
        .coupled = plan->integers[COUPLED],
        .items = (const Item *)plan->integers[ITEMS],
        .joints = plan->integers[JOINTS],
        .targets = plan->integers[TARGETS],
        .pairs = (const Pair *)plan->integers[PAIRS],
        .shared = plan->integers[SHARED],
        .rows = (const Row *)plan->integers[ROWS],
        .scales = plan->numbers[SCALES],
        .units = plan->numbers[UNITS],
        .matrices = (const Matrices *)plan->numbers[MATRICES],
        .signs = plan->numbers[SIGNS],
        .ratios = plan->numbers[RATIOS],
        .group_count = groups,
        .item_count = plan->integer_sizes[ITEMS] / (Py_ssize_t)(sizeof(Item) / 8),
        .pair_count = plan->integer_sizes[PAIRS] / (Py_ssize_t)(sizeof(Pair) / 8),
        .amount_count = plan->integer_sizes[ROWS] / (Py_ssize_t)(sizeof(Row) / 8),
        .force_rows = force_rows,
        .cases = cases,
    };
    Py_ssize_t columns = cases > sizes[MOST_AMOUNTS] ? cases : sizes[MOST_AMOUNTS];
    Py_ssize_t joint_rows = 6 * plan->integer_sizes[JOINTS];
    Py_ssize_t wrench_size = 6 * sizes[BODIES] * cases;
    struct {
        double **at;
        Py_ssize_t size;
    } needed[] = {
        {&work.wrenches, wrench_size},
        {&work.forces, force_rows * cases},
        {&work.given, sizes[RATES] * cases},
        {&work.missing, sizes[MOST_PASSIVES] * cases},
        {&work.left, sizes[MOST_PASSIVES] * cases},
        {&work.multipliers, sizes[MOST_MULTIPLIERS] * cases},
        {&work.combined, 6 * columns},
        {&work.force, 6 * columns},
        {&work.spread, sizes[SPREAD_SIZE]},
        {&work.unit_forces, sizes[UNIT_SIZE]},
        {&work.normal, sizes[NORMAL_SIZE]},
        {&work.diagonal, work.amount_count},
        {&work.amounts, work.amount_count * cases},
        {&work.greatest, joint_rows},
        {&work.greatest_moments, sizes[COUPLING_COUNT]},
    };
    Py_ssize_t total = 1, kinds = sizeof(needed) / sizeof(needed[0]);
    for (Py_ssize_t k = 0; k < kinds; k++)
        total += needed[k].size;
    if (!(memory = calloc(total, sizeof(double)))) {
        PyErr_NoMemory();
        goto done;
    }
    double *free_memory = memory;
    for (Py_ssize_t k = 0; k < kinds; k++) {
        *needed[k].at = free_memory;
        free_memory += needed[k].size;
    }
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        double *at = wrenches->at + sample * wrenches->step[0], *to = work.wrenches;
        for (Py_ssize_t body = 0; body < sizes[BODIES]; body++)
            for (int i = 0; i < 6; i++)
                for (Py_ssize_t m = 0; m < cases; m++)
                    *to++ = at[body * wrenches->step[1] + i * wrenches->step[2] +
                               m * wrenches->step[3]];
        for (Py_ssize_t m = 0; m < cases; m++) {
            const double *load = loads[m].at + sample * loads[m].step[0];
            for (Py_ssize_t rate = 0; rate < sizes[RATES]; rate++)
                work.given[rate * cases + m] = load[rate * loads[m].step[1]];
        }
        memset(work.forces, 0, sizeof(double) * force_rows * cases);
        memset(work.spread, 0, sizeof(double) * sizes[SPREAD_SIZE]);
        const Loop *loops = work.loops;
        const Matrices *matrices = work.matrices;
        const Coupling *couplings = work.couplings;
        const double *ratios = work.ratios;
        for (Py_ssize_t index = 0; index < groups; index++) {
            const Group *group = described + index;
            close_group(&work, group, of_groups + index, sample, loops, matrices, couplings,
                        ratios);
            loops += group->loops;
            matrices += group->loops;
            couplings += group->couplings;
            ratios += 2 * group->couplings;
        }
        if (work.item_count) {
            keep_greatest(&work);
            normal_equations(&work);
            solve_normal(&work);
            add_amounts(&work);
        }
        const double *from = work.wrenches;
        for (Py_ssize_t body = 0; body < sizes[BODIES]; body++)
            for (int i = 0; i < 6; i++)
                for (Py_ssize_t m = 0; m < cases; m++)
                    at[body * wrenches->step[1] + i * wrenches->step[2] +
                       m * wrenches->step[3]] = *from++;
        from = work.forces;
        at = forces->at + sample * forces->step[0];
        for (Py_ssize_t row = 0; row < force_rows; row++)
            for (Py_ssize_t m = 0; m < cases; m++)
                at[row * forces->step[1] + m * forces->step[2]] = *from++;
    }
    for (Py_ssize_t body = 0; body < sizes[BODIES]; body++)
        for (int i = 0; i < 6; i++)
            changes->at[body * changes->step[0] + i * changes->step[1]] = 0.0;
    const double *greatest = work.greatest;
    for (Py_ssize_t index = 0; index < plan->integer_sizes[JOINTS]; index++)
        for (int i = 0; i < 6; i++) {
            double *to = changes->at + work.joints[index] * changes->step[0] +
                         i * changes->step[1];
            *to = greater(*to, i < 3 ? work.scales[12] * *greatest : *greatest);
            greatest++;
        }
    for (Py_ssize_t k = 0; k < sizes[COUPLING_COUNT]; k++)
        moments->at[k * moments->step[0]] = work.greatest_moments[k];
    answer = Py_NewRef(Py_None);
done:
    free(memory);
    free(of_groups);
    release(&held);
    free(arrays);
    return answer;
}
