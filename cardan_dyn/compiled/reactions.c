/* Reactions: the twins of what dynamics/reactions.py does once the wrenches of the open tree are
   known, `ReactionSolver._closed`, and of loads on links, `OpenTree._contributions`.

   Samples are worked on one after the other, all groups, load cases and self-stresses of one at
   once: what self-stresses add to wrenches is never kept for all samples. Matrices have the load
   cases, or the amounts of a self-stress, as columns. */

#include "kernels.h"
#include "reactions_plan.h"
#include "stacked.h"

/* A pivot of the normal equations up to this part of its diagonal entry is what rounding leaves of
   zero: another self-stress loads the joints alike, or none is loaded. */
#define SINGULAR 1e-15

/* Amounts of most self-stresses, those of plane and spherical loops: loops over a known number of
   them take half as long. */
#define USUAL 3

/* Some columns of row (n,) @ columns (n, k): so few that their sums stay in registers. */
INLINE void some_sums(const double *row, Py_ssize_t step, Py_ssize_t n,
                      const double *columns, Py_ssize_t k, int some, double *result)
{
    double sums[4] = {0.0, 0.0, 0.0, 0.0};
    for (Py_ssize_t i = 0; i < n; i++)
        for (int m = 0; m < some; m++)
            sums[m] += row[i * step] * columns[i * k + m];
    for (int m = 0; m < some; m++)
        result[m] = sums[m];
}

/* result (k,) = row (n,) @ columns (n, k). */
INLINE void row_times(const double *row, Py_ssize_t step, Py_ssize_t n,
                      const double *columns, Py_ssize_t k, double *result)
{
    if (k == 1) {
        /* Two sums at a time, since each addition waits for the one before it. */
        double even = 0.0, odd = 0.0;
        Py_ssize_t i = 0;
        for (; i + 1 < n; i += 2) {
            even += row[i * step] * columns[i];
            odd += row[(i + 1) * step] * columns[i + 1];
        }
        if (i < n)
            even += row[i * step] * columns[i];
        result[0] = even + odd;
        return;
    }
    Py_ssize_t m = 0;
    for (; m + 4 <= k; m += 4)
        some_sums(row, step, n, columns + m, k, 4, result + m);
    if (m + 2 <= k) {
        some_sums(row, step, n, columns + m, k, 2, result + m);
        m += 2;
    }
    if (m < k)
        some_sums(row, step, n, columns + m, k, 1, result + m);
}

/* result (6, k) = sign * matrix @ columns (6, k), of a matrix (6, 6) that takes wrenches from one
   frame to another: moments add nothing to forces. */
static void times_any(const double *matrix, Py_ssize_t row, Py_ssize_t column, double sign,
                      const double *columns, Py_ssize_t k, double *result)
{
    for (int i = 0; i < 6; i++) {
        row_times(matrix + i * row, column, i < 3 ? 3 : 6, columns, k, result + i * k);
        for (Py_ssize_t m = 0; m < k; m++)
            result[i * k + m] *= sign;
    }
}

/* The same without gaps. */
INLINE void times_columns(const double *matrix, double sign, const double *columns,
                          Py_ssize_t k, double *result)
{
    for (int i = 0; i < 6; i++)
        for (Py_ssize_t m = 0; m < k; m++) {
            double sum = 0.0;
            for (int j = 0; j < (i < 3 ? 3 : 6); j++)
                sum += matrix[6 * i + j] * columns[j * k + m];
            result[i * k + m] = sign * sum;
        }
}

/* The same; loops over few columns, whose number is known, take half as long. */
static void times(const double *matrix, Py_ssize_t row, Py_ssize_t column, double sign,
                  const double *columns, Py_ssize_t k, double *result)
{
    if (row != 6 || column != 1 || k > 4)
        times_any(matrix, row, column, sign, columns, k, result);
    else if (k == 1)
        times_columns(matrix, sign, columns, 1, result);
    else if (k == 2)
        times_columns(matrix, sign, columns, 2, result);
    else if (k == 3)
        times_columns(matrix, sign, columns, 3, result);
    else
        times_columns(matrix, sign, columns, 4, result);
}

static const int NEXT[3] = {1, 2, 0}, AFTER_NEXT[3] = {2, 0, 1};

/* Where a joint's frame is, from its action: a rotation, row by row, and a position. */
static void placement(const Array *actions, Py_ssize_t sample, int64_t body, double *rotation,
                      double *position)
{
    const double *action =
        actions->at + sample * actions->step[0] + 6 * body * actions->step[1];
    Py_ssize_t row = actions->step[1], column = actions->step[2];
    for (int a = 0; a < 3; a++)
        for (int c = 0; c < 3; c++)
            rotation[3 * a + c] = action[c * row + a * column];
    for (int a = 0; a < 3; a++) {
        double sum = 0.0;
        for (int c = 0; c < 3; c++)
            sum += action[(3 + c) * row + AFTER_NEXT[a] * column] * rotation[3 * NEXT[a] + c];
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

/* The matrix (6, 6) of wrenches that a rotation and a position transform, or its transpose. */
static void transform(const double *rotation, const double *position, int is_transposed,
                      double *matrix)
{
    const int row = is_transposed ? 1 : 6, column = is_transposed ? 6 : 1;
    memset(matrix, 0, 36 * sizeof(double));
    for (int a = 0; a < 3; a++)
        for (int c = 0; c < 3; c++) {
            double *to = matrix + row * a + column * c;
            to[0] = to[21] = rotation[3 * a + c];
            to[18] = position[NEXT[a]] * rotation[3 * AFTER_NEXT[a] + c] -
                     position[AFTER_NEXT[a]] * rotation[3 * NEXT[a] + c];
        }
}

/* The matrix (6, 6) that takes wrenches in the axes of a body to the base's, see `LoopAxes`. */
static void from_carrier(const Array *actions, Py_ssize_t sample, int64_t body, const double *point,
                         double *matrix)
{
    double rotation[9], position[3];
    placement(actions, sample, body, rotation, position);
    shift(rotation, point, position);
    transform(rotation, position, 0, matrix);
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
    transform(rotation, position, 1, matrix);
}

/* The wrench (6, k) of a loop in the base's axes, from combinations of its weighted rows. */
static void wrench(const Work *work, const double *carrier, const double *combinations, int64_t k,
                   double *result)
{
    double *weighted = carrier ? work->added : result;
    for (int i = 0; i < 6; i++)
        for (int64_t m = 0; m < k; m++)
            weighted[i * k + m] = combinations[i * k + m] * work->scales[i];
    if (carrier)
        times(carrier, 6, 1, 1.0, weighted, k, result);
}

/* Combinations (6, k) of a loop's rows, from their multipliers. */
INLINE void combine(const Matrices *matrices, int64_t rows, const double *multipliers,
                    Py_ssize_t row, Py_ssize_t column, Py_ssize_t k, double *result)
{
    for (int i = 0; i < 6; i++)
        for (Py_ssize_t m = 0; m < k; m++) {
            double sum = 0.0;
            if (rows == 6)
                sum = multipliers[i * row + m * column];
            else
                for (int64_t j = 0; j < rows; j++)
                    sum += matrices->rows[i * rows + j] * multipliers[j * row + m * column];
            result[i * k + m] = sum;
        }
}

/* Copy (6, k) into some of the columns (6, whole). */
INLINE void place(const double *from, Py_ssize_t k, Py_ssize_t whole, double *to)
{
    for (int i = 0; i < 6; i++)
        for (Py_ssize_t m = 0; m < k; m++)
            to[i * whole + m] = from[i * k + m];
}

/* Add some of the columns (6, whole) to (6, k). */
INLINE void add(const double *from, Py_ssize_t k, Py_ssize_t whole, double *to)
{
    for (int i = 0; i < 6; i++)
        for (Py_ssize_t m = 0; m < k; m++)
            to[i * k + m] += from[i * whole + m];
}

/* Solve for the multipliers of a group from explicit inverses, with one step of refinement. */
INLINE void multipliers_of(const Work *work, const Group *group, const Given *given,
                           Py_ssize_t sample, Py_ssize_t cases)
{
    const double *square = given->square->at + sample * given->square->step[0];
    const double *inverse = given->inverse->at + sample * given->inverse->step[0];
    Py_ssize_t row = given->square->step[1], column = given->square->step[2];
    Py_ssize_t inverse_row = given->inverse->step[1], inverse_column = given->inverse->step[2];
    Py_ssize_t passives = group->passives, columns = group->columns;
    for (int64_t j = 0; j < columns; j++)
        row_times(inverse + j * inverse_row, inverse_column, passives, work->missing, cases,
                  work->multipliers + j * cases);
    for (int64_t i = 0; i < passives; i++) {
        double *left = work->left + i * cases;
        row_times(square + i * row, column, columns, work->multipliers, cases, left);
        for (Py_ssize_t m = 0; m < cases; m++)
            left[m] = work->missing[i * cases + m] - left[m];
    }
    /* Those of idle rods, behind the others, are no closure forces. */
    for (int64_t j = 0; j < group->rows; j++) {
        row_times(inverse + j * inverse_row, inverse_column, passives, work->left, cases,
                  work->combined);
        for (Py_ssize_t m = 0; m < cases; m++)
            work->multipliers[j * cases + m] += work->combined[m];
    }
}

/* What is missing along the passives of a group: given efforts less those of the wrenches. */
INLINE void missing_along(const Work *work, const Group *group, Py_ssize_t cases)
{
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
            work->missing[i * cases + m] = work->efforts[rate * cases + m] - effort;
        }
    }
}

/* Closure forces of a loop and its self-stresses, and what they add to wrenches.

   Multipliers are those of its rows, `null` (rows, amounts) likewise; the latter's forces go to
   `units`. All of them go along the loop at once, as columns beside each other. */
INLINE void close_loop(const Work *work, const Given *given, Py_ssize_t sample,
                       const Loop *loop, const Matrices *matrices,
                       const double *multipliers, const Item *shared,
                       const double *null, double *units, Py_ssize_t cases)
{
    double carrier_matrix[36], end_matrix[36], *carrier = NULL;
    double *forces = work->forces + 6 * loop->loop * cases, *columns = forces;
    const Item *own = loop->item < 0 ? NULL : work->items + loop->item;
    Py_ssize_t of_shared = shared ? shared->amounts : 0, of_own = own ? own->amounts : 0;
    Py_ssize_t whole = cases + of_shared + of_own;
    if (loop->carrier >= 0)
        from_carrier(given->actions, sample, loop->carrier, matrices->point,
                     carrier = carrier_matrix);
    combine(matrices, loop->rows, multipliers, cases, 1, cases, work->combined);
    wrench(work, carrier, work->combined, cases, forces);
    if (whole > cases) {
        columns = work->columns;
        place(forces, cases, whole, columns);
    }
    if (shared) {
        combine(matrices, loop->rows, null, given->null->step[1], given->null->step[2], of_shared,
                work->combined);
        wrench(work, carrier, work->combined, of_shared, units);
        place(units, of_shared, whole, columns + cases);
    }
    if (own) {
        double *unit = work->unit_forces + own->units;
        wrench(work, carrier, matrices->null, of_own, unit);
        place(unit, of_own, whole, columns + cases + of_shared);
    }
    const double *actions = given->actions->at + sample * given->actions->step[0];
    Py_ssize_t row = given->actions->step[1], column = given->actions->step[2];
    const OnPath *path = work->paths + loop->first_on_path;
    const double *signs = work->signs + loop->first_on_path;
    double *added = work->added, *of_joint = own ? work->spread + own->spread : NULL;
    for (int64_t index = 0; index < loop->on_path + (loop->fixed >= 0); index++) {
        int64_t joint = loop->fixed, slot = loop->fixed_slot;
        if (index < loop->on_path) {
            joint = path[index].joint;
            slot = path[index].slot;
            times(actions + path[index].row * row, row, column, signs[index], columns, whole,
                  added);
        } else {
            to_end(given->actions, sample, loop, matrices, end_matrix);
            times(end_matrix, 6, 1, 1.0, columns, whole, added);
        }
        add(added, cases, whole, work->wrenches + joint * 6 * cases);
        if (shared)
            add(added + cases, of_shared, whole,
                work->spread + shared->spread + slot * 6 * of_shared);
        if (own)
            for (int i = 0; i < 6; i++)
                for (Py_ssize_t m = 0; m < of_own; m++)
                    *of_joint++ = added[i * whole + cases + of_shared + m];
    }
}

/* Closure forces of a group and its self-stresses; loops and couplings are those from there on. */
INLINE void close_group(Work *work, const Group *group, const Given *given,
                        Py_ssize_t sample, const Loop *loops,
                        const Matrices *matrices, const Coupling *couplings,
                        const double *ratios, Py_ssize_t cases)
{
    int64_t start = 0, unit_row = 0, amounts = group->amounts;
    const Item *shared = NULL;
    const double *null = NULL;
    Py_ssize_t null_row = 0, null_column = 0;
    double *units = NULL;
    if (group->item >= 0) {
        shared = work->items + group->item;
        null = given->null->at + sample * given->null->step[0];
        null_row = given->null->step[1];
        null_column = given->null->step[2];
        units = work->unit_forces + shared->units;
        memset(work->spread + shared->spread, 0, 6 * sizeof(double) * shared->joints * amounts);
    }
    missing_along(work, group, cases);
    multipliers_of(work, group, given, sample, cases);
    for (int64_t index = 0; index < group->loops; index++) {
        const Loop *loop = loops + index;
        close_loop(work, given, sample, loop, matrices + index, work->multipliers + start * cases,
                   shared, shared ? null + start * null_row : NULL,
                   shared ? units + unit_row * amounts : NULL, cases);
        start += loop->rows;
        unit_row += 6;
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
                work->efforts[successors[j] * cases + m] += moment[m];
            for (int64_t j = 0; j < coupling->predecessors; j++)
                work->efforts[predecessors[j] * cases + m] -= ratio * moment[m];
        }
        if (!shared)
            continue;
        double *greatest = work->greatest_moments + coupling->coupling;
        for (int64_t m = 0; m < amounts; m++) {
            double moment_of_unit = null[start * null_row + m * null_column] / unit;
            units[unit_row * amounts + m] = moment_of_unit;
            *greatest = greater(*greatest, fabs(moment_of_unit));
        }
    }
}

/* The product of six components with a column. */
INLINE double product(const double *components, const double *column, Py_ssize_t step)
{
    double sum = 0.0;
    for (int i = 0; i < 6; i++)
        sum += components[i] * column[i * step];
    return sum;
}

/* Add the products of two self-stresses to their normal equations. */
INLINE void add_products(Work *work, const Pair *pair, int64_t size_of_first,
                         int64_t size_of_second, Py_ssize_t cases)
{
    const double *squares = work->scales + 6;
    const Item *first = work->items + pair->first, *second = work->items + pair->second;
    int is_same = first == second;
    for (int64_t shared = 0; shared < pair->shared; shared++) {
        const int64_t *slots = work->shared + 2 * (pair->first_shared + shared);
        const double *a = work->spread + first->spread + slots[0] * 6 * size_of_first;
        const double *b = work->spread + second->spread + slots[1] * 6 * size_of_second;
        const double *loaded = work->wrenches +
                               work->joints[first->first_joint + slots[0]] * 6 * cases;
        for (int64_t k = 0; k < size_of_first; k++) {
            const Row *row = work->rows + first->first_amount + k;
            double *to = work->normal + (row->start + second->first_amount - row->first_column);
            double *right = work->amounts + (first->first_amount + k) * cases;
            double weighted[6];
            for (int i = 0; i < 6; i++)
                weighted[i] = a[i * size_of_first + k] * squares[i];
            for (int64_t l = 0; l < (is_same ? k + 1 : size_of_second); l++)
                to[l] += product(weighted, b + l, size_of_second);
            if (is_same)
                for (Py_ssize_t m = 0; m < cases; m++)
                    right[m] -= product(weighted, loaded + m, cases);
        }
    }
}

/* The normal equations of the least norm: lower triangle, row by row, each from where it is not
   zero for lack of joints that both self-stresses load; and their right-hand sides. */
INLINE void normal_equations(Work *work, Py_ssize_t cases)
{
    memset(work->normal, 0, sizeof(double) * work->sizes[NORMAL_SIZE]);
    memset(work->amounts, 0, sizeof(double) * work->amount_count * cases);
    for (Py_ssize_t index = 0; index < work->pair_count; index++) {
        const Pair *pair = work->pairs + index;
        int64_t first = work->items[pair->first].amounts;
        int64_t second = work->items[pair->second].amounts;
        if (first == USUAL && second == USUAL)
            add_products(work, pair, USUAL, USUAL, cases);
        else
            add_products(work, pair, first, second, cases);
    }
}

/* Solve the normal equations, L D L' x = r; what a zero pivot leaves open is chosen as zero. */
INLINE void solve_normal(Work *work, Py_ssize_t cases)
{
    double *amounts = work->amounts, *diagonal = work->diagonal;
    for (Py_ssize_t i = 0; i < work->amount_count; i++) {
        const Row *row = work->rows + i;
        /* Entry j of row i is at own[j]. */
        double *own = work->normal + (row->start - row->first_column);
        double whole = own[i], pivot = own[i];
        for (int64_t j = row->first_column; j < i; j++) {
            const Row *other = work->rows + j;
            const double *of_other = work->normal + (other->start - other->first_column);
            int64_t from = row->first_column > other->first_column ? row->first_column
                                                                   : other->first_column;
            double sum = own[j];
            for (int64_t m = from; m < j; m++)
                sum -= own[m] * of_other[m];
            own[j] = sum;
        }
        for (int64_t j = row->first_column; j < i; j++) {
            double scaled = own[j] * diagonal[j];
            pivot -= own[j] * scaled;
            own[j] = scaled;
            for (Py_ssize_t m = 0; m < cases; m++)
                amounts[i * cases + m] -= scaled * amounts[j * cases + m];
        }
        diagonal[i] = pivot <= SINGULAR * whole ? 0.0 : 1.0 / pivot;
    }
    for (Py_ssize_t i = 0; i < work->amount_count; i++)
        for (Py_ssize_t m = 0; m < cases; m++)
            amounts[i * cases + m] *= diagonal[i];
    for (Py_ssize_t i = work->amount_count - 1; i >= 0; i--) {
        const Row *row = work->rows + i;
        const double *own = work->normal + (row->start - row->first_column);
        for (int64_t j = row->first_column; j < i; j++)
            for (Py_ssize_t m = 0; m < cases; m++)
                amounts[j * cases + m] -= own[j] * amounts[i * cases + m];
    }
}

/* Add rows of a self-stress times its amounts to a row of all load cases. */
INLINE void add_row(const double *of_unit, const double *amounts, int64_t size,
                    Py_ssize_t cases, double *to)
{
    for (Py_ssize_t m = 0; m < cases; m++) {
        double sum = 0.0;
        for (int64_t k = 0; k < size; k++)
            sum += of_unit[k] * amounts[k * cases + m];
        to[m] += sum;
    }
}

/* Add the chosen amounts of a self-stress to wrenches and closure forces. */
INLINE void add_item(Work *work, const Item *item, int64_t size, Py_ssize_t cases)
{
    const double *amounts = work->amounts + item->first_amount * cases;
    const double *of_unit = work->spread + item->spread;
    for (int64_t slot = 0; slot < item->joints; slot++) {
        double *to = work->wrenches + work->joints[item->first_joint + slot] * 6 * cases;
        for (int i = 0; i < 6; i++, of_unit += size)
            add_row(of_unit, amounts, size, cases, to + i * cases);
    }
    of_unit = work->unit_forces + item->units;
    for (int64_t row = 0; row < item->unit_rows; row++, of_unit += size)
        add_row(of_unit, amounts, size, cases,
                work->forces + work->targets[item->first_target + row] * cases);
}

/* Keep how much self-stresses change each component of a wrench at most.

   Bits of numbers without a sign are in the order of these, behind which come those of what is not
   a number. */
INLINE void keep_greatest(const double *spread, int64_t rows, int64_t size,
                          uint64_t *greatest)
{
    for (int64_t row = 0; row < rows; row++) {
        uint64_t known = greatest[row];
        for (int64_t k = 0; k < size; k++) {
            double change = fabs(*spread++);
            uint64_t bits;
            memcpy(&bits, &change, sizeof(bits));
            known = bits > known ? bits : known;
        }
        greatest[row] = known;
    }
}

/* All of a sample, whose wrenches and efforts are there. */
INLINE void close_sample(Work *work, Py_ssize_t sample, Py_ssize_t cases)
{
    const Loop *loops = work->loops;
    const Matrices *matrices = work->matrices;
    const Coupling *couplings = work->couplings;
    const double *ratios = work->ratios;
    for (Py_ssize_t index = 0; index < work->group_count; index++) {
        const Group *group = work->groups + index;
        close_group(work, group, work->given + index, sample, loops, matrices, couplings, ratios,
                    cases);
        loops += group->loops;
        matrices += group->loops;
        couplings += group->couplings;
        ratios += 2 * group->couplings;
    }
    if (work->item_count) {
        normal_equations(work, cases);
        solve_normal(work, cases);
        for (Py_ssize_t index = 0; index < work->item_count; index++) {
            const Item *item = work->items + index;
            const double *spread = work->spread + item->spread;
            uint64_t *greatest = work->greatest + 6 * item->first_joint;
            if (item->amounts == USUAL) {
                keep_greatest(spread, 6 * item->joints, USUAL, greatest);
                add_item(work, item, USUAL, cases);
            } else {
                keep_greatest(spread, 6 * item->joints, item->amounts, greatest);
                add_item(work, item, item->amounts, cases);
            }
        }
    }
}

/* Of a single load case, as most often, loops over the cases vanish. */
static void close_one_case(Work *work, Py_ssize_t sample)
{
    close_sample(work, sample, 1);
}

static void close_cases(Work *work, Py_ssize_t sample)
{
    close_sample(work, sample, work->cases);
}

const PlanKind reactions_plan = {"reactions", INTEGER_ARRAYS, NUMBER_ARRAYS, reactions_fit};

/* Take the arrays of all groups, which have to be of so many samples; -1 with an error set. */
static int take_groups(Held *held, Arguments given, const Work *work, Py_ssize_t count,
                       Given *of_groups)
{
    for (Py_ssize_t index = 0; index < work->group_count; index++) {
        const Group *group = work->groups + index;
        const Array *own = held->arrays + held->held;
        int has_null = group->item >= 0;
        if (take_each(held, given, has_null ? "3 3 3 3" : "3 3 3"))
            return -1;
        given += has_null ? 4 : 3;
        if (has_size(own, 0, count, 0) || has_size(own, 1, group->action_rows, 0) ||
            has_size(own, 2, 6, 0) || has_size(own + 1, 0, count, 0) ||
            has_size(own + 1, 1, group->passives, 0) || has_size(own + 1, 2, group->columns, 0) ||
            has_size(own + 2, 0, count, 0) || has_size(own + 2, 1, group->columns, 0) ||
            has_size(own + 2, 2, group->passives, 0))
            return -1;
        if (has_null && (has_size(own + 3, 0, count, 0) || has_size(own + 3, 1, group->rows, 0) ||
                         has_size(own + 3, 2, group->amounts, 0)))
            return -1;
        of_groups[index] = (Given){own, own + 1, own + 2, has_null ? own + 3 : NULL};
    }
    return 0;
}

/* Lay out the work space of a call, all of it zero; -1 with an error set. */
static int make_room(Held *held, const Plan *plan, Work *work)
{
    const int64_t *sizes = work->sizes;
    /* A loop may have a self-stress of its own beside that of its group. */
    Py_ssize_t cases = work->cases, columns = cases + 2 * sizes[MOST_AMOUNTS];
    Py_ssize_t greatest = 6 * plan->integer_sizes[JOINTS];
    struct {
        double **at;
        Py_ssize_t size;
    } needed[] = {
        {&work->wrenches, 6 * sizes[BODIES] * cases},
        {&work->forces, work->force_rows * cases},
        {&work->efforts, sizes[RATES] * cases},
        {&work->missing, sizes[MOST_PASSIVES] * cases},
        {&work->left, sizes[MOST_PASSIVES] * cases},
        {&work->multipliers, sizes[MOST_MULTIPLIERS] * cases},
        {&work->combined, 6 * columns},
        {&work->columns, 6 * columns},
        {&work->added, 6 * columns},
        {&work->spread, sizes[SPREAD_SIZE]},
        {&work->unit_forces, sizes[UNIT_SIZE]},
        {&work->normal, sizes[NORMAL_SIZE]},
        {&work->diagonal, work->amount_count},
        {&work->amounts, work->amount_count * cases},
        {&work->greatest_moments, sizes[COUPLING_COUNT]},
    };
    Py_ssize_t total = greatest, kinds = sizeof(needed) / sizeof(needed[0]);
    for (Py_ssize_t k = 0; k < kinds; k++)
        total += needed[k].size;
    double *room = room_for(held, total);
    if (!room)
        return -1;
    memset(room, 0, sizeof(double) * total);
    for (Py_ssize_t k = 0; k < kinds; k++) {
        *needed[k].at = room;
        room += needed[k].size;
    }
    work->greatest = (uint64_t *)room;
    return 0;
}

/* Read the wrenches of a sample into the work space, or write them back. */
static void move_wrenches(const Work *work, const Array *wrenches, Py_ssize_t sample, int back)
{
    Py_ssize_t cases = work->cases, bodies = work->sizes[BODIES];
    double *at = wrenches->at + sample * wrenches->step[0], *own = work->wrenches;
    if ((cases == 1 || wrenches->step[3] == 1) && wrenches->step[2] == cases &&
        (bodies == 1 || wrenches->step[1] == 6 * cases)) {
        memcpy(back ? at : own, back ? own : at, sizeof(double) * 6 * bodies * cases);
        return;
    }
    for (Py_ssize_t body = 0; body < bodies; body++)
        for (int i = 0; i < 6; i++)
            for (Py_ssize_t m = 0; m < cases; m++, own++) {
                double *one = at + body * wrenches->step[1] + i * wrenches->step[2] +
                              m * wrenches->step[3];
                *(back ? one : own) = *(back ? own : one);
            }
}

/* Write what self-stresses change at most, of all samples. */
static void write_changes(const Plan *plan, const Work *work, const Array *changes,
                          const Array *moments)
{
    for (Py_ssize_t body = 0; body < work->sizes[BODIES]; body++)
        for (int i = 0; i < 6; i++)
            changes->at[body * changes->step[0] + i * changes->step[1]] = 0.0;
    for (Py_ssize_t row = 0; row < 6 * plan->integer_sizes[JOINTS]; row++) {
        double greatest, *to = changes->at + work->joints[row / 6] * changes->step[0] +
                               row % 6 * changes->step[1];
        memcpy(&greatest, work->greatest + row, sizeof(greatest));
        *to = greater(*to, row % 6 < 3 ? work->scales[12] * greatest : greatest);
    }
    for (Py_ssize_t k = 0; k < work->sizes[COUPLING_COUNT]; k++)
        moments->at[k * moments->step[0]] = work->greatest_moments[k];
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
    const Plan *plan = plan_of(given[0], &reactions_plan);
    if (!plan)
        return NULL;
    Work work = tables_of(plan);
    const int64_t *sizes = work.sizes;
    Py_ssize_t groups = work.group_count, force_rows = work.force_rows;
    PyObject *answer = NULL;
    Array *arrays = malloc(sizeof(Array) * nargs);
    Given *of_groups = malloc(sizeof(Given) * (groups + 1));
    Held held = {arrays, 0, NULL};
    if (!arrays || !of_groups) {
        PyErr_NoMemory();
        goto done;
    }
    if (take_each(&held, given + 1, "=4 =3 =2 =1"))
        goto done;
    Array *wrenches = arrays, *forces = arrays + 1, *changes = arrays + 2, *moments = arrays + 3;
    Py_ssize_t count = wrenches->size[0], cases = wrenches->size[3];
    if (has_size(wrenches, 1, sizes[BODIES], 0) || has_size(wrenches, 2, 6, 0) ||
        has_size(forces, 0, count, 0) || has_size(forces, 1, force_rows, 0) ||
        has_size(forces, 2, cases, 0) || has_size(changes, 0, sizes[BODIES], 0) ||
        has_size(changes, 1, 6, 0) || has_size(moments, 0, sizes[COUPLING_COUNT], 0))
        goto done;
    Py_ssize_t expected = 5 + cases;
    for (Py_ssize_t index = 0; index < groups; index++)
        expected += work.groups[index].item >= 0 ? 4 : 3;
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
    work.given = of_groups;
    work.cases = cases;
    if (take_groups(&held, given + 5 + cases, &work, count, of_groups) ||
        make_room(&held, plan, &work))
        goto done;
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        move_wrenches(&work, wrenches, sample, 0);
        for (Py_ssize_t m = 0; m < cases; m++) {
            const double *load = loads[m].at + sample * loads[m].step[0];
            for (Py_ssize_t rate = 0; rate < sizes[RATES]; rate++)
                work.efforts[rate * cases + m] = load[rate * loads[m].step[1]];
        }
        if (cases == 1)
            close_one_case(&work, sample);
        else
            close_cases(&work, sample);
        move_wrenches(&work, wrenches, sample, 1);
        double *at = forces->at + sample * forces->step[0];
        for (Py_ssize_t row = 0; row < force_rows; row++)
            for (Py_ssize_t m = 0; m < cases; m++)
                at[row * forces->step[1] + m * forces->step[2]] = work.forces[row * cases + m];
    }
    write_changes(plan, &work, changes, moments);
    answer = Py_NewRef(Py_None);
done:
    free(of_groups);
    release(&held);
    free(arrays);
    return answer;
}

/* What a plan for `against_load` holds, in the order of its arrays. */
enum { LOADED_SIZES, LOADED_PATH, LOADED_INTEGERS };
enum { LOADED_ROWS, LOADED_BODY, LOADED_WRENCHES, LOADED_SIZE_COUNT };

static int load_fits(const Plan *plan)
{
    const Py_ssize_t *counts = plan->integer_sizes;
    const int64_t *sizes = plan->integers[LOADED_SIZES], *path = plan->integers[LOADED_PATH];
    Py_ssize_t joints = counts[LOADED_PATH] / 2;
    return counts[LOADED_SIZES] == LOADED_SIZE_COUNT && counts[LOADED_PATH] % 2 == 0 &&
           are_indices(sizes, LOADED_SIZE_COUNT, 1, 0, INT32_MAX) &&
           is_part(6 * sizes[LOADED_BODY], 6, sizes[LOADED_ROWS]) &&
           are_indices(path, joints, 2, 0, sizes[LOADED_ROWS] - 5) &&
           are_indices(path + 1, joints, 2, 0, sizes[LOADED_WRENCHES]);
}

const PlanKind load_plan = {"load", LOADED_INTEGERS, 0, load_fits};

/* against_load(plan, actions (N, 6 n, 6), place (3,), rotation (3, 3), whether in world axes,
                force (N, 3) or (1, 3), moment likewise, wrenches (N, b, 6))

   Add what holds a body against a load to the wrenches of all joints from the base to it. The load
   acts at a place in the body, in axes that are rotated in it, unless they are the base's. */
PyObject *against_load(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 8)
    const Plan *plan = plan_of(given[0], &load_plan);
    if (!plan)
        return NULL;
    const int64_t *sizes = plan->integers[LOADED_SIZES], *path = plan->integers[LOADED_PATH];
    int in_world = PyObject_IsTrue(given[4]);
    if (in_world < 0)
        return NULL;
    Array arrays[6];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    if (take_each(&held, given + 1, "3 1 2") || take_each(&held, given + 5, "2 2 =3"))
        goto done;
    Array *actions = arrays, *place = arrays + 1, *rotation = arrays + 2, *force = arrays + 3;
    Array *moment = arrays + 4, *wrenches = arrays + 5;
    Py_ssize_t count = wrenches->size[0];
    if (has_size(actions, 0, count, 0) || has_size(actions, 1, sizes[LOADED_ROWS], 0) ||
        has_size(actions, 2, 6, 0) || has_size(place, 0, 3, 0) || has_size(rotation, 0, 3, 0) ||
        has_size(rotation, 1, 3, 0) || has_size(force, 0, count, 1) || has_size(force, 1, 3, 0) ||
        has_size(moment, 0, count, 1) || has_size(moment, 1, 3, 0) ||
        has_size(wrenches, 1, sizes[LOADED_WRENCHES], 0) || has_size(wrenches, 2, 6, 0))
        goto done;
    double own_place[3], own_rotation[9];
    for (int a = 0; a < 3; a++) {
        own_place[a] = place->at[a * place->step[0]];
        for (int c = 0; c < 3; c++)
            own_rotation[3 * a + c] = rotation->at[a * rotation->step[0] + c * rotation->step[1]];
    }
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        double axes[9], point[3], vectors[6], wrench[6], added[6];
        placement(actions, sample, sizes[LOADED_BODY], axes, point);
        shift(axes, own_place, point);
        for (int a = 0; a < 3; a++) {
            vectors[a] = force->at[sample * force->step[0] + a * force->step[1]];
            vectors[3 + a] = moment->at[sample * moment->step[0] + a * moment->step[1]];
        }
        if (!in_world)
            for (int part = 0; part < 6; part += 3) {
                double in_body[3], in_base[3];
                for (int a = 0; a < 3; a++)
                    row_times(own_rotation + 3 * a, 1, 3, vectors + part, 1, in_body + a);
                for (int a = 0; a < 3; a++)
                    row_times(axes + 3 * a, 1, 3, in_body, 1, in_base + a);
                memcpy(vectors + part, in_base, sizeof(in_base));
            }
        for (int a = 0; a < 3; a++) {
            wrench[a] = -vectors[a];
            wrench[3 + a] = -(vectors[3 + a] + (point[NEXT[a]] * vectors[AFTER_NEXT[a]] -
                                                point[AFTER_NEXT[a]] * vectors[NEXT[a]]));
        }
        const double *of_sample = actions->at + sample * actions->step[0];
        double *out = wrenches->at + sample * wrenches->step[0];
        for (Py_ssize_t index = 0; index < plan->integer_sizes[LOADED_PATH] / 2; index++) {
            times(of_sample + path[2 * index] * actions->step[1], actions->step[1],
                  actions->step[2], 1.0, wrench, 1, added);
            double *to = out + path[2 * index + 1] * wrenches->step[1];
            for (int i = 0; i < 6; i++)
                to[i * wrenches->step[2]] += added[i];
        }
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}
