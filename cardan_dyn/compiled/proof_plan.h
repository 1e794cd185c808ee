/* The plan of the proof: tables that proof/layout.py fills, one row per item. */

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
        n_prescribed, n_known, n_massive, n_slides;
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

/* Find the tables of a plan, in the order of proof/layout.py; -1 if it is another one. */
static int read_plan(const Plan *plan, Layout *layout)
{
    int64_t n_counts, n_sizes, n_around, n_factors, rows[7];
    if (plan->integer_arrays != 15 || plan->number_arrays != 9)
        return -1;
    const int64_t *counts = integers(plan, 0, 8, &n_counts);
    layout->motions = integers(plan, 1, sizeof(Motion), &layout->n_motions);
    layout->offsets = integers(plan, 2, 8, &layout->n_offsets);
    layout->joints = integers(plan, 3, sizeof(Joint), &layout->n_joints);
    layout->bodies = integers(plan, 4, sizeof(Body), &layout->n_bodies);
    layout->efforts = integers(plan, 5, sizeof(Effort), &layout->n_efforts);
    layout->loops = integers(plan, 6, sizeof(Loop), &layout->n_loops);
    layout->around = integers(plan, 7, sizeof(Around), &n_around);
    layout->coupled = integers(plan, 8, sizeof(Coupling), &layout->n_coupled);
    layout->coupled_at = integers(plan, 9, 8, &n_factors);
    layout->moments = integers(plan, 10, sizeof(Coupled), &layout->n_moments);
    layout->prescribed = integers(plan, 11, sizeof(Prescribed), &layout->n_prescribed);
    layout->known = integers(plan, 12, 8, &layout->n_known);
    layout->slides = integers(plan, 13, 8, &layout->n_slides);
    layout->massive = integers(plan, 14, sizeof(Massive), &layout->n_massive);
    const double *sizes = numbers(plan, 0, 8, &n_sizes);
    layout->rate_scale = numbers(plan, 1, 8, rows);
    layout->placements = numbers(plan, 2, 16 * 8, rows + 1);
    layout->coupled_by = numbers(plan, 3, 8, rows + 2);
    layout->moment_factors = numbers(plan, 4, 8, rows + 3);
    layout->motion_numbers = numbers(plan, 5, sizeof(MotionNumbers), rows + 4);
    layout->effort_numbers = numbers(plan, 6, sizeof(EffortNumbers), rows + 5);
    layout->coupling_numbers = numbers(plan, 7, sizeof(CouplingNumbers), rows + 6);
    layout->mass_numbers = numbers(plan, 8, sizeof(MassNumbers), &n_around);
    if (n_counts != 5 || n_sizes != 2 || n_around != layout->n_massive)
        return -1;
    layout->size = counts[0];
    layout->rates = counts[1];
    layout->unit_twists = counts[2];
    layout->couplings = counts[3];
    layout->drives = counts[4];
    layout->length = sizes[0];
    layout->greatest_mass = sizes[1];
    const int64_t expected[] = {layout->rates,     layout->n_offsets, n_factors,
                                layout->n_moments, layout->n_motions, layout->n_efforts,
                                layout->n_coupled};
    return memcmp(rows, expected, sizeof(expected)) ? -1 : 0;
}

#endif
