/* The plan of the reactions, how it is read, and what is worked on along it. */

#ifndef CARDAN_DYN_REACTIONS_PLAN_H
#define CARDAN_DYN_REACTIONS_PLAN_H

#include "arrays.h"

/* What a plan holds, in the order of its arrays; dynamics/reaction_plan.py writes it. Of
   integers:

   SIZES: see below. GROUPS: in the order of solution. PASSIVES: of all groups, the velocity
   coordinate, and the component of all wrenches along it, or the first of its joint. LOOPS, PATHS,
   COUPLINGS: of all groups. COUPLED: coordinates of the couplings, first those of the successor.
   ITEMS: self-stresses. JOINTS: what these load. TARGETS: rows of all closure forces that they
   consist of. PAIRS: of self-stresses that load the same joints. SHARED: these joints, by their
   places in both. ROWS: of the normal equations.

   Of numbers: SCALES: of closure equations (6), of squares in the norm (6), of forces in the
   influence (1). UNITS: per passive the sign of its component, or its unit twist (6). MATRICES: of
   the loops. SIGNS: of the bodies on loops. RATIOS: per coupling the unit of its slip and the
   ratio. */
enum {
    SIZES, GROUPS, PASSIVES, LOOPS, PATHS, COUPLINGS, COUPLED, ITEMS, JOINTS, TARGETS, PAIRS,
    SHARED, ROWS, INTEGER_ARRAYS
};
enum { SCALES, UNITS, MATRICES, SIGNS, RATIOS, NUMBER_ARRAYS };
enum {
    RATES, BODIES, LOOP_COUNT, COUPLING_COUNT, ALONG_AXES, MOST_PASSIVES, MOST_MULTIPLIERS,
    MOST_AMOUNTS, SPREAD_SIZE, UNIT_SIZE, NORMAL_SIZE, SIZE_COUNT
};

/* Its closure equations have so many rows, followed by idle rods in `columns`. `amounts` are those
   of its redundant equations, whose self-stress is the `item`; -1 is none, here and below. */
typedef struct {
    int64_t passives, columns, rows, amounts, action_rows, first_passive, loops, couplings, item;
} Group;

/* Of a `fixed` loop, `fixed` is the index of its wrench, and `end` the body of its successor. The
   `item` is the self-stress of its own redundant rows; `fixed_slot` a place in its group's. */
typedef struct {
    int64_t loop, rows, carrier, first_on_path, on_path, fixed, end, item, fixed_slot;
} Loop;

/* A body on a loop: its first row of actions, its wrench, its place in the group's self-stress. */
typedef struct {
    int64_t row, joint, slot;
} OnPath;

typedef struct {
    int64_t coupling, first, successors, predecessors;
} Coupling;

/* A self-stress: the number of its parts, and where they are among those of all. */
typedef struct {
    int64_t amounts, first_amount, joints, first_joint, spread, unit_rows, first_target, units;
} Item;

typedef struct {
    int64_t first, second, first_shared, shared;
} Pair;

/* A row begins in a column, and is at a start among the numbers of all rows. */
typedef struct {
    int64_t first_column, start;
} Row;

/* Rows of a loop (6, rows) and those that it cannot reach (6, amounts), the point of its axes, and
   where a `fixed` loop ends in its successor. */
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
    const Given *given;
    Py_ssize_t group_count, item_count, pair_count, amount_count, force_rows, cases;
    /* Of the sample that is worked on. */
    double *wrenches, *forces, *efforts, *missing, *left, *multipliers, *combined, *columns;
    double *added, *spread, *unit_forces, *normal, *diagonal, *amounts;
    /* Of all samples; the first are bits, see `keep_greatest`. */
    uint64_t *greatest;
    double *greatest_moments;
} Work;

static Work tables_of(const Plan *plan)
{
    Work work = {
        .sizes = plan->integers[SIZES],
        .groups = (const Group *)plan->integers[GROUPS],
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
        .group_count = plan->integer_sizes[GROUPS] / FIELDS(Group),
        .item_count = plan->integer_sizes[ITEMS] / FIELDS(Item),
        .pair_count = plan->integer_sizes[PAIRS] / FIELDS(Pair),
        .amount_count = plan->integer_sizes[ROWS] / FIELDS(Row),
        .force_rows = 6 * plan->integers[SIZES][LOOP_COUNT] + plan->integers[SIZES][COUPLING_COUNT],
    };
    return work;
}

/* Whether all tables have the sizes that they need. */
static int are_whole(const Plan *plan)
{
    const Py_ssize_t *counts = plan->integer_sizes, *numbers = plan->number_sizes;
    if (counts[SIZES] != SIZE_COUNT ||
        !are_indices(plan->integers[SIZES], SIZE_COUNT, 1, 0, INT32_MAX))
        return 0;
    int per_passive = plan->integers[SIZES][ALONG_AXES] ? 1 : 6;
    return counts[GROUPS] % FIELDS(Group) == 0 && counts[PASSIVES] % 2 == 0 &&
           counts[LOOPS] % FIELDS(Loop) == 0 && counts[PATHS] % FIELDS(OnPath) == 0 &&
           counts[COUPLINGS] % FIELDS(Coupling) == 0 && counts[ITEMS] % FIELDS(Item) == 0 &&
           counts[PAIRS] % FIELDS(Pair) == 0 && counts[SHARED] % 2 == 0 &&
           counts[ROWS] % FIELDS(Row) == 0 && numbers[SCALES] == 13 &&
           numbers[UNITS] == counts[PASSIVES] / 2 * per_passive &&
           numbers[MATRICES] == counts[LOOPS] / FIELDS(Loop) * FIELDS(Matrices) &&
           numbers[SIGNS] == counts[PATHS] / FIELDS(OnPath) &&
           numbers[RATIOS] == counts[COUPLINGS] / FIELDS(Coupling) * 2;
}

/* Whether an index is one of so many, or -1 for none. */
static int is_or_none(int64_t index, int64_t count)
{
    return -1 <= index && index < count;
}

/* Whether a loop of a group, whose self-stress may be `shared`, stays within the tables. */
static int loop_fits(const Plan *plan, const Work *of, const Group *group, const Loop *loop,
                     const Item *shared)
{
    const int64_t bodies = of->sizes[BODIES], carriers = group->action_rows / 6;
    if (!is_part(loop->loop, 1, of->sizes[LOOP_COUNT]) || !is_part(0, loop->rows, 6) ||
        !is_or_none(loop->carrier, carriers) || !is_or_none(loop->end, carriers) ||
        !is_or_none(loop->fixed, bodies) || !is_or_none(loop->item, of->item_count) ||
        (shared && loop->fixed >= 0 && !is_part(loop->fixed_slot, 1, shared->joints)) ||
        !is_part(loop->first_on_path, loop->on_path, plan->integer_sizes[PATHS] / FIELDS(OnPath)))
        return 0;
    const Item *own = loop->item < 0 ? NULL : of->items + loop->item;
    if (own && (own->amounts > 6 || own->unit_rows != 6 ||
                own->joints != loop->on_path + (loop->fixed >= 0)))
        return 0;
    for (int64_t k = 0; k < loop->on_path; k++) {
        const OnPath *on_path = of->paths + loop->first_on_path + k;
        if (!is_part(on_path->row, 6, group->action_rows) || !is_part(on_path->joint, 1, bodies) ||
            (shared && !is_part(on_path->slot, 1, shared->joints)))
            return 0;
    }
    return 1;
}

/* Whether all groups stay within the tables. */
static int groups_fit(const Plan *plan, const Work *of)
{
    const Py_ssize_t *counts = plan->integer_sizes;
    int64_t loop = 0, coupling = 0, couplings = counts[COUPLINGS] / FIELDS(Coupling);
    for (Py_ssize_t index = 0; index < of->group_count; index++) {
        const Group *group = of->groups + index;
        if (!is_or_none(group->item, of->item_count))
            return 0;
        const Item *shared = group->item < 0 ? NULL : of->items + group->item;
        if (!is_part(0, group->passives, of->sizes[MOST_PASSIVES]) ||
            !is_part(0, group->columns, of->sizes[MOST_MULTIPLIERS]) ||
            !is_part(0, group->rows, group->columns) || group->action_rows < 0 ||
            !is_part(group->first_passive, group->passives, counts[PASSIVES] / 2) ||
            !is_part(loop, group->loops, counts[LOOPS] / FIELDS(Loop)) ||
            !is_part(coupling, group->couplings, couplings))
            return 0;
        if (group->amounts != (shared ? shared->amounts : 0) ||
            (shared && shared->unit_rows != 6 * group->loops + group->couplings))
            return 0;
        int64_t rows = group->couplings;
        for (int64_t k = 0; k < group->loops; k++) {
            if (!loop_fits(plan, of, group, of->loops + loop + k, shared))
                return 0;
            rows += of->loops[loop + k].rows;
        }
        if (rows != group->rows)
            return 0;
        loop += group->loops, coupling += group->couplings;
    }
    for (int64_t k = 0; k < couplings; k++) {
        const Coupling *own = of->couplings + k;
        if (!is_part(own->coupling, 1, of->sizes[COUPLING_COUNT]) ||
            !is_part(0, own->successors, counts[COUPLED]) || own->predecessors < 0 ||
            !is_part(own->first, own->successors + own->predecessors, counts[COUPLED]))
            return 0;
    }
    return loop == counts[LOOPS] / FIELDS(Loop) && coupling == couplings;
}

/* Whether all self-stresses and their normal equations stay within the tables. */
static int items_fit(const Plan *plan, const Work *of)
{
    const Py_ssize_t *counts = plan->integer_sizes;
    const int64_t *sizes = of->sizes;
    int64_t amounts = 0;
    for (Py_ssize_t index = 0; index < of->item_count; index++) {
        const Item *item = of->items + index;
        if (item->first_amount != amounts || !is_part(0, item->amounts, sizes[MOST_AMOUNTS]) ||
            !is_part(amounts, item->amounts, of->amount_count) ||
            !is_part(item->first_joint, item->joints, counts[JOINTS]) ||
            !is_part(item->first_target, item->unit_rows, counts[TARGETS]) ||
            !is_part(item->spread, 6 * item->joints * item->amounts, sizes[SPREAD_SIZE]) ||
            !is_part(item->units, item->unit_rows * item->amounts, sizes[UNIT_SIZE]))
            return 0;
        amounts += item->amounts;
    }
    for (int64_t index = 0; index < of->amount_count; index++) {
        const Row *row = of->rows + index;
        if (!is_part(row->first_column, 1, index + 1) ||
            !is_part(row->start, index + 1 - row->first_column, sizes[NORMAL_SIZE]))
            return 0;
    }
    for (Py_ssize_t index = 0; index < of->pair_count; index++) {
        const Pair *pair = of->pairs + index;
        if (!is_part(pair->first, 1, of->item_count) ||
            !is_part(pair->second, 1, pair->first + 1) ||
            !is_part(pair->first_shared, pair->shared, counts[SHARED] / 2))
            return 0;
        const Item *first = of->items + pair->first, *second = of->items + pair->second;
        const int64_t *slots = of->shared + 2 * pair->first_shared;
        if (!are_indices(slots, pair->shared, 2, 0, first->joints) ||
            !are_indices(slots + 1, pair->shared, 2, 0, second->joints))
            return 0;
        for (int64_t k = 0; k < first->amounts; k++)
            if (of->rows[first->first_amount + k].first_column > second->first_amount)
                return 0;
    }
    return amounts == of->amount_count;
}

static int reactions_fit(const Plan *plan)
{
    if (!are_whole(plan))
        return 0;
    const Work of = tables_of(plan);
    const int64_t *sizes = of.sizes;
    const Py_ssize_t *counts = plan->integer_sizes;
    const int64_t components = 6 * sizes[BODIES] - (sizes[ALONG_AXES] ? 0 : 5);
    return are_indices(of.passives, counts[PASSIVES] / 2, 2, 0, sizes[RATES]) &&
           are_indices(of.passives + 1, counts[PASSIVES] / 2, 2, 0, components) &&
           are_indices(of.coupled, counts[COUPLED], 1, 0, sizes[RATES]) &&
           are_indices(of.joints, counts[JOINTS], 1, 0, sizes[BODIES]) &&
           are_indices(of.targets, counts[TARGETS], 1, 0, of.force_rows) && items_fit(plan, &of) &&
           groups_fit(plan, &of);
}

#endif
