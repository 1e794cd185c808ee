/* The plan of the proof: tables that proof/proof_plan.py fills, one row per item. */

#ifndef CARDAN_DYN_PROOF_PLAN_H
#define CARDAN_DYN_PROOF_PLAN_H

#include "arrays.h"

/* Kinds of motions: turns about an axis of the frame before them, any other turn, slide, ball. */
enum { ALONG_X, ALONG_Y, ALONG_Z, TURN, SLIDE, BALL };

/* Rows of tables of integers, then of numbers. */
typedef struct {
    int64_t kind, before, is_placed, column, rate, row, along;
} Motion;
typedef struct {
    int64_t column, frame, child, parent;
} Joint;
typedef struct {
    int64_t motion, is_covered;
} Body;
typedef struct {
    int64_t joint, is_last, is_moment, component, motion, row, rate;
} Effort;
typedef struct {
    int64_t start, end, last, from, to;
} Loop;
typedef struct {
    int64_t motion, sign;
} Around;
typedef struct {
    int64_t from_rate, to_rate, from_column, to_column;
} Coupling;
typedef struct {
    int64_t rate, coupling;
} Coupled;
typedef struct {
    int64_t rate, column;
} Prescribed;
typedef struct {
    int64_t body, motion;
} Massive;

typedef struct {
    double placement[16], axis[3];
} MotionNumbers;
typedef struct {
    double mass, centre[3], inertia[9];
} MassNumbers;
typedef struct {
    double axis[3], scale;
} EffortNumbers;
typedef struct {
    double offset, scale;
} CouplingNumbers;

typedef struct {
    int64_t size, rates, unit_twists, couplings, drives;
    int64_t n_motions, n_offsets, n_joints, n_bodies, n_efforts, n_loops, n_coupled, n_moments,
        n_prescribed, n_known, n_massive, n_slides, n_around, n_factors;
    const Motion *motions;
    const int64_t *offsets; /* Per placed frame, the motion before it; -1 for the world. */
    const Joint *joints;
    const Body *bodies;
    const Effort *efforts;
    const Loop *loops;
    const Around *around;
    const Coupling *coupled;
    const int64_t *coupled_at; /* Rates, or columns, of the factors of couplings. */
    const Coupled *moments;
    const Prescribed *prescribed; /* The drives, then the held joints. */
    const int64_t *known, *slides;
    const Massive *massive;
    double length, greatest_mass;
    const double *rate_scale, *placements, *coupled_by, *moment_factors;
    const MotionNumbers *motion_numbers;
    const EffortNumbers *effort_numbers;
    const CouplingNumbers *coupling_numbers;
    const MassNumbers *mass_numbers;
} Layout;

enum { INTEGER_TABLES = 15, NUMBER_TABLES = 9, COUNTS = 5, SIZES = 2 };

/* A table of integers of a plan whose rows are so many bytes, and their number. */
static const void *integers(const Plan *plan, int table, size_t row, int64_t *rows)
{
    *rows = plan->integer_sizes[table] * 8 / (int64_t)row;
    return plan->integers[table];
}

static const void *numbers(const Plan *plan, int table, size_t row, int64_t *rows)
{
    *rows = plan->number_sizes[table] * 8 / (int64_t)row;
    return plan->numbers[table];
}

/* Find the tables of a plan, in the order of proof/proof_plan.py. */
static Layout layout_of(const Plan *plan)
{
    Layout layout;
    int64_t rows; /* Of tables that have as many as others. */
    const int64_t *counts = integers(plan, 0, 8, &rows);
    layout.motions = integers(plan, 1, sizeof(Motion), &layout.n_motions);
    layout.offsets = integers(plan, 2, 8, &layout.n_offsets);
    layout.joints = integers(plan, 3, sizeof(Joint), &layout.n_joints);
    layout.bodies = integers(plan, 4, sizeof(Body), &layout.n_bodies);
    layout.efforts = integers(plan, 5, sizeof(Effort), &layout.n_efforts);
    layout.loops = integers(plan, 6, sizeof(Loop), &layout.n_loops);
    layout.around = integers(plan, 7, sizeof(Around), &layout.n_around);
    layout.coupled = integers(plan, 8, sizeof(Coupling), &layout.n_coupled);
    layout.coupled_at = integers(plan, 9, 8, &layout.n_factors);
    layout.moments = integers(plan, 10, sizeof(Coupled), &layout.n_moments);
    layout.prescribed = integers(plan, 11, sizeof(Prescribed), &layout.n_prescribed);
    layout.known = integers(plan, 12, 8, &layout.n_known);
    layout.slides = integers(plan, 13, 8, &layout.n_slides);
    layout.massive = integers(plan, 14, sizeof(Massive), &layout.n_massive);
    const double *sizes = numbers(plan, 0, 8, &rows);
    layout.rate_scale = numbers(plan, 1, 8, &rows);
    layout.placements = numbers(plan, 2, 16 * 8, &rows);
    layout.coupled_by = numbers(plan, 3, 8, &rows);
    layout.moment_factors = numbers(plan, 4, 8, &rows);
    layout.motion_numbers = numbers(plan, 5, sizeof(MotionNumbers), &rows);
    layout.effort_numbers = numbers(plan, 6, sizeof(EffortNumbers), &rows);
    layout.coupling_numbers = numbers(plan, 7, sizeof(CouplingNumbers), &rows);
    layout.mass_numbers = numbers(plan, 8, sizeof(MassNumbers), &rows);
    layout.size = counts[0];
    layout.rates = counts[1];
    layout.unit_twists = counts[2];
    layout.couplings = counts[3];
    layout.drives = counts[4];
    layout.length = sizes[0];
    layout.greatest_mass = sizes[1];
    return layout;
}

/* Whether all tables have the sizes that they need. */
static int are_whole(const Plan *plan)
{
    static const size_t rows[INTEGER_TABLES] = {
        COUNTS * 8, sizeof(Motion), 8, sizeof(Joint), sizeof(Body), sizeof(Effort), sizeof(Loop),
        sizeof(Around), sizeof(Coupling), 8, sizeof(Coupled), sizeof(Prescribed), 8, 8,
        sizeof(Massive),
    };
    for (int table = 0; table < INTEGER_TABLES; table++)
        if (plan->integer_sizes[table] * 8 % (Py_ssize_t)rows[table])
            return 0;
    if (plan->integer_sizes[0] != COUNTS || plan->number_sizes[0] != SIZES)
        return 0;
    const Layout of = layout_of(plan);
    const int64_t sizes[NUMBER_TABLES] = {
        SIZES, of.rates, 16 * of.n_offsets, of.n_factors, of.n_moments,
        of.n_motions * FIELDS(MotionNumbers),
        of.n_efforts * FIELDS(EffortNumbers),
        of.n_coupled * FIELDS(CouplingNumbers),
        of.n_massive * FIELDS(MassNumbers),
    };
    for (int table = 0; table < NUMBER_TABLES; table++)
        if (plan->number_sizes[table] != sizes[table])
            return 0;
    return 1;
}

/* Whether a field of all rows of a table is at least `least` and below `end`. */
#define WITHIN(table, field, least, end) \
    are_indices(&of.table->field, of.n_##table, sizeof(*of.table) / 8, least, end)

static int proof_fits(const Plan *plan)
{
    if (!are_whole(plan))
        return 0;
    const Layout of = layout_of(plan);
    const int64_t frames = of.n_motions + of.n_offsets;
    if (!are_indices(plan->integers[0], COUNTS, 1, 0, INT32_MAX) || of.drives > of.n_prescribed)
        return 0;
    for (int64_t m = 0; m < of.n_motions; m++) {
        const Motion *motion = of.motions + m;
        int is_ball = motion->kind == BALL, rates = is_ball ? 3 : 1, columns = is_ball ? 4 : 1;
        /* Frames are placed from the world outwards. */
        if (motion->before < -1 || motion->before >= m || motion->kind < ALONG_X ||
            motion->kind > BALL || !is_part(motion->column, columns, of.size) ||
            !is_part(motion->rate, rates, of.rates) ||
            !is_part(motion->row, rates, of.unit_twists) || motion->along < -1 ||
            motion->along > 2)
            return 0;
    }
    for (int64_t k = 0; k < of.n_loops; k++)
        if (!is_part(of.loops[k].from, of.loops[k].to - of.loops[k].from, of.n_around))
            return 0;
    for (int64_t k = 0; k < of.n_coupled; k++) {
        const Coupling *own = of.coupled + k;
        int64_t rates = own->to_rate - own->from_rate;
        int64_t columns = own->to_column - own->from_column;
        if (!is_part(own->from_rate, rates, of.n_factors) ||
            !is_part(own->from_column, columns, of.n_factors) ||
            !are_indices(of.coupled_at + own->from_rate, rates, 1, 0, of.rates) ||
            !are_indices(of.coupled_at + own->from_column, columns, 1, 0, of.size))
            return 0;
    }
    return are_indices(of.offsets, of.n_offsets, 1, -1, of.n_motions) &&
           WITHIN(joints, column, 0, of.n_joints) && WITHIN(joints, frame, 0, frames) &&
           WITHIN(joints, child, -1, of.n_bodies) && WITHIN(joints, parent, -1, of.n_bodies) &&
           WITHIN(bodies, motion, 0, of.n_motions) && WITHIN(efforts, joint, 0, of.n_joints) &&
           WITHIN(efforts, component, -1, 3) && WITHIN(efforts, motion, 0, of.n_motions) &&
           WITHIN(efforts, row, 0, of.unit_twists) && WITHIN(efforts, rate, 0, of.rates) &&
           WITHIN(loops, start, 0, frames) && WITHIN(loops, end, 0, frames) &&
           WITHIN(loops, last, -1, of.n_motions) && WITHIN(around, motion, 0, of.n_motions) &&
           WITHIN(moments, rate, 0, of.rates) && WITHIN(moments, coupling, 0, of.couplings) &&
           WITHIN(prescribed, rate, 0, of.rates) && WITHIN(prescribed, column, 0, of.size) &&
           are_indices(of.known, of.n_known, 1, 0, of.rates) &&
           are_indices(of.slides, of.n_slides, 1, 0, of.rates) &&
           WITHIN(massive, body, 0, of.n_bodies) && WITHIN(massive, motion, 0, of.n_motions);
}

#undef WITHIN

#endif
