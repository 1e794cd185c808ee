/* The proof: the twin of `FreeBodies._residuals` of proof/free_bodies.py, and of all that it calls.

   It shares nothing with the functions that solve: frames, twists and wrenches are computed here
   once more, from the second reading of the description. What they mean is said in proof/.

   Vectors, wrenches and frames are in world axes about the corner. */

#include "arrays.h"
#include "kernels.h"
#include "proof_lanes.h"
#include "proof_plan.h"

#define TAU 6.283185307179586
#define LEAST_SQUARE 1e-200
#define GREATEST_SQUARE 1e200

/* Arrays of a claim, in the order in which they are handed over. */
enum {
    RESULT, X, TURNS, V, A, POSITIONS, SPEEDS, ACCELERATIONS, HELD, RATIOS, WRENCHES, EXERTED,
    COUPLINGS, LOADS, GRAVITY, LINK_LOADS, LINK_PLACES, ARRAYS,
};

/* Of a load on a link: its body, whether it is in world axes, the link's axes, its place. */
enum { LOAD_BODY, LOAD_IN_WORLD, LOAD_AXES, LOAD_PLACE = 11, LOAD_NUMBERS = 14 };

/* The results, in the order of the fields of `Residuals`. */
enum {
    IMBALANCE, POWER_IMBALANCE, LOOP_ERROR, RATE_ERROR, GREATEST_WRENCH, APPLIED, INERTIA,
    POWER_SCALE, SPEED_SCALE, RESULTS,
};

typedef struct {
    const Array *arrays;
    int has_rates, is_moving_at_rest, has_weight;
} Claim;

/* Numbers of a few samples. */
typedef struct {
    Py_ssize_t samples[TOGETHER];
    double *frames, *units, *relative, *velocities, *changes, *absolute;
    double *v, *a, *unit, *ratios, *given, *wrenches, *in_world, *net;
} Work;

INLINE void load(double *out, const Array *array, int64_t column, const Work *work, int lanes)
{
    const double *at = array->at + column * array->step[1];
    EACH out[l] = at[work->samples[l] * array->step[0]];
}

INLINE void load_all(double *out, const Array *array, const Work *work, int lanes)
{
    for (Py_ssize_t k = 0; k < array->size[1]; k++)
        load(out + k * lanes, array, k, work, lanes);
}

/* Frames of all motions, then those with an offset from one of them, or in the world. */
INLINE void place_all(const Layout *layout, const Array *x, Work *work, int lanes)
{
    double placed[12 * TOGETHER], moved[4 * TOGETHER], direction[3 * TOGETHER];
    for (int64_t m = 0; m < layout->n_motions; m++) {
        const Motion *motion = layout->motions + m;
        const MotionNumbers *numbers = layout->motion_numbers + m;
        double *frame = work->frames + m * FRAME;
        const double *before = motion->before < 0 ? NULL : work->frames + motion->before * FRAME;
        const double *start = before;
        if (motion->is_placed || !before) {
            place(placed, before, numbers->placement, lanes);
            start = placed;
        }
        load(moved, x, motion->column, work, lanes);
        switch (motion->kind) {
        case ALONG_X:
        case ALONG_Y:
        case ALONG_Z:
            turn_along(frame, start, (int)motion->kind, numbers->axis[motion->kind], moved, lanes);
            break;
        case TURN:
            turn(frame, start, numbers->axis, moved, lanes);
            break;
        case BALL:
            for (int k = 1; k < 4; k++)
                load(moved + k * lanes, x, motion->column + k, work, lanes);
            rotate(frame, start, moved, lanes);
            break;
        default:
            memcpy(frame, start, sizeof(double) * FRAME);
            along(direction, start, numbers->axis, lanes);
            for (int i = 0; i < 3; i++)
                EACH frame[3 * VECTOR + i * lanes + l] += direction[i * lanes + l] * moved[l];
        }
    }
    for (int64_t k = 0; k < layout->n_offsets; k++) {
        const double *before = NULL;
        if (layout->offsets[k] >= 0)
            before = work->frames + layout->offsets[k] * FRAME;
        place(work->frames + (layout->n_motions + k) * FRAME, before, layout->placements + 16 * k,
              lanes);
    }
}

/* The twist of a motion per unit of one of its rates. */
INLINE void unit_twists(const Layout *layout, Work *work, int lanes)
{
    for (int64_t m = 0; m < layout->n_motions; m++) {
        const Motion *motion = layout->motions + m;
        const double *frame = work->frames + m * FRAME, *axis = layout->motion_numbers[m].axis;
        double *twist = work->units + motion->row * WRENCH;
        int rates = motion->kind == BALL ? 3 : 1;
        for (int k = 0; k < rates; k++, twist += WRENCH) {
            double *direction = motion->kind == SLIDE ? twist : twist + VECTOR;
            if (motion->kind == BALL)
                memcpy(direction, frame + k * VECTOR, sizeof(double) * VECTOR);
            else if (motion->along < 0)
                along(direction, frame, axis, lanes);
            else
                for (int i = 0; i < VECTOR; i++)
                    direction[i] = frame[motion->along * VECTOR + i] * axis[motion->along];
            memset(motion->kind == SLIDE ? twist + VECTOR : twist, 0, sizeof(double) * VECTOR);
            if (motion->kind != SLIDE)
                add_cross(twist, 1.0, frame + 3 * VECTOR, direction, lanes);
        }
    }
}

/* Twists of all motions' frames relative to those before them. */
INLINE void relative_twists(const Layout *layout, const Work *work, const double *rates,
                            double *restrict out, int lanes)
{
    for (int64_t m = 0; m < layout->n_motions; m++, out += WRENCH) {
        const Motion *motion = layout->motions + m;
        const double *twist = work->units + motion->row * WRENCH;
        const double *rate = rates + motion->rate * lanes;
        for (int i = 0; i < 6; i++)
            EACH out[i * lanes + l] = twist[i * lanes + l] * rate[l];
        if (motion->kind == BALL)
            for (int k = 1; k < 3; k++)
                for (int i = 0; i < 6; i++)
                    EACH out[i * lanes + l] +=
                        twist[k * WRENCH + i * lanes + l] * rate[k * lanes + l];
    }
}

/* Sums from the world outwards. */
INLINE void add_up(const Layout *layout, const double *relative, double *out, int lanes)
{
    for (int64_t m = 0; m < layout->n_motions; m++) {
        int64_t before = layout->motions[m].before;
        const double *own = relative + m * WRENCH;
        double *sum = out + m * WRENCH;
        if (sum != own)
            memcpy(sum, own, sizeof(double) * WRENCH);
        if (before >= 0)
            add(sum, out + before * WRENCH, WRENCH);
    }
}

/* What an axis adds to relative accelerations because the frame before it moves. */
INLINE void add_transport(const Layout *layout, Work *work, int lanes)
{
    double before[6 * TOGETHER];
    for (int64_t m = 0; m < layout->n_motions; m++) {
        const double *relative = work->relative + m * WRENCH;
        const double *velocity = work->velocities + m * WRENCH;
        double *change = work->changes + m * WRENCH;
        for (int k = 0; k < WRENCH; k++)
            before[k] = velocity[k] - relative[k];
        add_cross(change, 1.0, before + VECTOR, relative, lanes);
        add_cross(change + VECTOR, 1.0, before + VECTOR, relative + VECTOR, lanes);
        add_cross(change, 1.0, before, relative + VECTOR, lanes);
    }
}

/* worst = how fast couplings slip and held joints move. */
INLINE void slip(const Layout *layout, const double *rates, double *restrict worst, int lanes)
{
    EACH worst[l] = 0.0;
    for (int64_t k = layout->drives; k < layout->n_prescribed; k++) {
        int64_t rate = layout->prescribed[k].rate;
        double scale = layout->rate_scale[rate];
        EACH worst[l] = greater(worst[l], fabs(rates[rate * lanes + l]) / scale);
    }
    for (int64_t k = 0; k < layout->n_coupled; k++) {
        double sum[TOGETHER] = {0}, scale = layout->coupling_numbers[k].scale;
        for (int64_t i = layout->coupled[k].from_rate; i < layout->coupled[k].to_rate; i++)
            EACH sum[l] +=
                layout->coupled_by[i] * rates[layout->coupled_at[i] * lanes + l];
        EACH worst[l] = greater(worst[l], fabs(sum[l]) / scale);
    }
}

/* worst is raised to how fast the ends of a loop move apart. */
INLINE void opening(const Layout *layout, const Work *work, const double *relative,
                    const int *moved, double *restrict worst, int lanes)
{
    for (int64_t k = 0; k < layout->n_loops; k++) {
        const Loop *loop = layout->loops + k;
        double apart[6 * TOGETHER] = {0};
        int moves = !moved;
        for (int64_t i = loop->from; i < loop->to; i++) {
            const Around *around = layout->around + i;
            const double *part = relative + around->motion * WRENCH;
            if (moved && !moved[around->motion])
                continue;
            moves = 1;
            if (around->sign > 0)
                add(apart, part, WRENCH);
            else
                for (int j = 0; j < WRENCH; j++)
                    apart[j] -= part[j];
        }
        if (!moves)
            continue;
        /* The gap opens at the loop's joint, not at the corner. */
        if (loop->last >= 0)
            add_cross(apart, 1.0, apart + VECTOR, work->frames + loop->last * FRAME + 3 * VECTOR,
                      lanes);
        for (int i = 0; i < 3; i++)
            EACH {
                worst[l] = greater(worst[l], fabs(apart[i * lanes + l]) / layout->length);
                worst[l] = greater(worst[l], fabs(apart[VECTOR + i * lanes + l]));
            }
    }
}

INLINE void greatest_rate(const Layout *layout, const double *rates, double *restrict greatest,
                          int lanes)
{
    EACH greatest[l] = 0.0;
    for (int64_t k = 0; k < layout->n_known; k++) {
        int64_t rate = layout->known[k];
        double scale = layout->rate_scale[rate];
        EACH greatest[l] = greater(greatest[l], fabs(rates[rate * lanes + l]) / scale);
    }
}

/* The greatest size of so many wrenches: of moments, and of forces times the length. */
INLINE void greatest_size(const double *wrenches, int64_t count, double length,
                          double *restrict greatest, int lanes)
{
    double square = length * length;
    EACH greatest[l] = 0.0;
    for (int64_t k = 0; k < count; k++) {
        const double *force = wrenches + k * WRENCH, *moment = force + VECTOR;
        EACH {
            greatest[l] = greater(greatest[l], dot(force, force, l, lanes) * square);
            greatest[l] = greater(greatest[l], dot(moment, moment, l, lanes));
        }
    }
    EACH {
        if (LEAST_SQUARE < greatest[l] && greatest[l] < GREATEST_SQUARE) {
            greatest[l] = sqrt(greatest[l]);
            continue;
        }
        /* Squares overflow, or vanish, long before the wrenches do. */
        double scale = 0.0, worst = 0.0;
        for (int64_t k = 0; k < 6 * count; k++)
            scale = greater(scale, fabs(wrenches[k * lanes + l]));
        greatest[l] = scale;
        if (!(0.0 < scale && scale < INFINITY))
            continue;
        for (int64_t k = 0; k < 2 * count; k++) {
            double sum = 0.0;
            for (int i = 0; i < 3; i++) {
                double part = wrenches[(3 * k + i) * lanes + l] / scale;
                sum += part * part;
            }
            worst = greater(worst, k % 2 ? sum : sum * square);
        }
        greatest[l] = scale * sqrt(worst);
    }
}

/* worst = how far rates of the drives are from the prescribed ones, relative. */
INLINE void drive_rate_error(const Layout *layout, const Claim *claim, const Work *work,
                             double *restrict worst, int lanes)
{
    const Array *ratios = claim->arrays + RATIOS;
    int64_t drives = layout->drives;
    EACH worst[l] = 0.0;
    for (int64_t i = 0; i < drives; i++)
        for (int64_t j = 0; j < drives; j++) {
            const double *at = ratios->at + layout->prescribed[i].rate * ratios->step[1] +
                               j * ratios->step[2];
            EACH worst[l] =
                greater(worst[l], fabs(at[work->samples[l] * ratios->step[0]] - (i == j)));
        }
    if (!claim->has_rates) {
        if (claim->is_moving_at_rest)
            EACH worst[l] = INFINITY;
        return;
    }
    for (int k = 0; k < 2; k++) {
        const double *rates = k ? work->a : work->v;
        double error[TOGETHER] = {0}, size[TOGETHER] = {0}, prescribed[TOGETHER];
        for (int64_t i = 0; i < drives; i++) {
            load(prescribed, claim->arrays + (k ? ACCELERATIONS : SPEEDS), i, work, lanes);
            const double *rate = rates + layout->prescribed[i].rate * lanes;
            EACH {
                error[l] = greater(error[l], fabs(rate[l] - prescribed[l]));
                size[l] = greater(size[l], fabs(prescribed[l]));
            }
        }
        EACH worst[l] = greater(worst[l], ratio(error[l], size[l]));
    }
}

/* error = the greatest violation of loops, couplings, drives and held joints by rates.

   `fastest` is the greatest joint speed at unit drive speeds. Also writes the absolute twists at
   unit drive speeds, the velocities, and the accelerations in place of `changes`. */
INLINE void check_rates(const Layout *layout, const Claim *claim, Work *work, int *moved,
                        double *restrict error, double *restrict fastest, int lanes)
{
    const Array *ratios = claim->arrays + RATIOS;
    const int64_t rates = layout->rates, drives = layout->drives;
    double violation[TOGETHER], scale[TOGETHER], size[TOGETHER];
    drive_rate_error(layout, claim, work, error, lanes);
    for (int64_t k = 0; k < rates * lanes; k++)
        work->unit[k] = 0.0;
    for (int64_t drive = 0; drive < drives; drive++) {
        for (int64_t k = 0; k < rates; k++) {
            const double *at = ratios->at + k * ratios->step[1] + drive * ratios->step[2];
            double *own = work->ratios + k * lanes;
            EACH own[l] = at[work->samples[l] * ratios->step[0]];
        }
        add(work->unit, work->ratios, (int)(rates * lanes));
        slip(layout, work->ratios, violation, lanes);
        relative_twists(layout, work, work->ratios, work->relative, lanes);
        /* One of many drives moves few loops. */
        if (drives > 1)
            for (int64_t m = 0; m < layout->n_motions; m++) {
                int any = 0;
                for (int k = 0; k < WRENCH; k++)
                    any |= work->relative[m * WRENCH + k] != 0.0;
                moved[m] = any;
            }
        opening(layout, work, work->relative, drives > 1 ? moved : NULL, violation, lanes);
        greatest_rate(layout, work->ratios, scale, lanes);
        EACH error[l] = greater(error[l], ratio(violation[l], scale[l]));
    }
    greatest_rate(layout, work->unit, fastest, lanes);
    if (drives != 1)
        relative_twists(layout, work, work->unit, work->relative, lanes);
    add_up(layout, work->relative, work->absolute, lanes);
    if (!claim->has_rates)
        return;
    relative_twists(layout, work, work->v, work->relative, lanes);
    add_up(layout, work->relative, work->velocities, lanes);
    relative_twists(layout, work, work->a, work->changes, lanes);
    add_transport(layout, work, lanes);
    greatest_rate(layout, work->v, scale, lanes);
    greatest_rate(layout, work->a, size, lanes);
    /* Accelerations contain centripetal terms, which grow with the square of the speed. */
    EACH size[l] += scale[l] * scale[l];
    slip(layout, work->v, violation, lanes);
    opening(layout, work, work->relative, NULL, violation, lanes);
    EACH error[l] = greater(error[l], ratio(violation[l], scale[l]));
    slip(layout, work->a, violation, lanes);
    opening(layout, work, work->changes, NULL, violation, lanes);
    EACH error[l] = greater(error[l], ratio(violation[l], size[l]));
    add_up(layout, work->changes, work->changes, lanes);
}

/* worst = the greatest violation of loops, couplings, drives and held joints by positions. */
INLINE void position_error(const Layout *layout, const Claim *claim, const Work *work,
                           double *restrict worst, int lanes)
{
    double square = 1.0 / (layout->length * layout->length);
    EACH worst[l] = 0.0;
    for (int64_t k = 0; k < layout->n_loops; k++) {
        const double *start = work->frames + layout->loops[k].start * FRAME;
        const double *end = work->frames + layout->loops[k].end * FRAME;
        double turned[TOGETHER] = {0}, gap[TOGETHER] = {0};
        /* Between frames that are turned by an angle, the squared differences of the three axes
           add up to twice its square, for small angles. */
        for (int i = 0; i < 9; i++)
            EACH {
                double part = start[i * lanes + l] - end[i * lanes + l];
                turned[l] += 0.5 * (part * part);
            }
        for (int i = 9; i < 12; i++)
            EACH {
                double part = start[i * lanes + l] - end[i * lanes + l];
                gap[l] += square * (part * part);
            }
        EACH worst[l] = greater(greater(worst[l], turned[l]), gap[l]);
    }
    EACH worst[l] = sqrt(worst[l]);
    for (int64_t k = 0; k < layout->n_coupled; k++) {
        const CouplingNumbers *numbers = layout->coupling_numbers + k;
        double sum[TOGETHER] = {0}, x[TOGETHER], turns[TOGETHER];
        for (int64_t i = layout->coupled[k].from_column; i < layout->coupled[k].to_column; i++) {
            load(x, claim->arrays + X, layout->coupled_at[i], work, lanes);
            load(turns, claim->arrays + TURNS, layout->coupled_at[i], work, lanes);
            EACH sum[l] += layout->coupled_by[i] * (x[l] + TAU * turns[l]);
        }
        EACH worst[l] = greater(worst[l], fabs(sum[l] - numbers->offset) / numbers->scale);
    }
    for (int64_t k = 0; k < layout->n_prescribed; k++) {
        const Prescribed *own = layout->prescribed + k;
        double x[TOGETHER], prescribed[TOGETHER], scale = layout->rate_scale[own->rate];
        int64_t is_held = k >= layout->drives;
        load(x, claim->arrays + X, own->column, work, lanes);
        load(prescribed, claim->arrays + (is_held ? HELD : POSITIONS),
             is_held ? k - layout->drives : k, work, lanes);
        /* A position of many turns is known only up to the rounding of its great number. */
        EACH worst[l] = greater(
            worst[l], fabs(x[l] - prescribed[l]) / greater(scale, fabs(prescribed[l])));
    }
}

/* The claimed wrenches in their joints' axes and in the world, and their sum on each body. */
INLINE void cut_free(const Layout *layout, const Claim *claim, Work *work, int lanes)
{
    const Array *given = claim->arrays + WRENCHES;
    for (int64_t k = 0; k < layout->n_bodies * WRENCH; k++)
        work->net[k] = 0.0;
    for (int64_t j = 0; j < layout->n_joints; j++) {
        const Joint *joint = layout->joints + j;
        const double *frame = work->frames + joint->frame * FRAME;
        double *wrench = work->wrenches + j * WRENCH, *world = work->in_world + j * WRENCH;
        for (int i = 0; i < 6; i++) {
            const double *at = given->at + joint->column * given->step[1] + i * given->step[2];
            EACH wrench[i * lanes + l] = at[work->samples[l] * given->step[0]];
        }
        in_world(world, frame, wrench, lanes);
        in_world(world + VECTOR, frame, wrench + VECTOR, lanes);
        add_cross(world + VECTOR, 1.0, frame + 3 * VECTOR, world, lanes);
        if (joint->child >= 0)
            add(work->net + joint->child * WRENCH, world, WRENCH);
    }
    for (int64_t j = 0; j < layout->n_joints; j++)
        if (layout->joints[j].parent >= 0) {
            double *net = work->net + layout->joints[j].parent * WRENCH;
            const double *world = work->in_world + j * WRENCH;
            for (int k = 0; k < WRENCH; k++)
                net[k] -= world[k];
        }
}

/* power += that of a wrench at unit drive speeds. */
INLINE void add_power(double *restrict power, const double *wrench, const double *twist, int lanes)
{
    for (int i = 0; i < 6; i++)
        EACH power[l] += wrench[i * lanes + l] * twist[i * lanes + l];
}

/* Loads on links act on the bodies. */
INLINE void add_link_loads(const Layout *layout, const Claim *claim, Work *work,
                           double (*restrict out)[TOGETHER], int lanes)
{
    const Array *loads = claim->arrays + LINK_LOADS, *places = claim->arrays + LINK_PLACES;
    for (Py_ssize_t k = 0; k < loads->size[0]; k++) {
        double numbers[LOAD_NUMBERS], given[6 * TOGETHER], wrench[6 * TOGETHER],
            point[3 * TOGETHER], power[TOGETHER] = {0}, size[TOGETHER];
        for (int i = 0; i < LOAD_NUMBERS; i++)
            numbers[i] = places->at[k * places->step[0] + i * places->step[1]];
        int64_t body = (int64_t)numbers[LOAD_BODY], motion = layout->bodies[body].motion;
        const double *frame = work->frames + motion * FRAME, *origin = frame + 3 * VECTOR;
        for (int i = 0; i < 6; i++) {
            const double *at = loads->at + k * loads->step[0] + i * loads->step[1];
            EACH given[i * lanes + l] = at[work->samples[l] * loads->step[2]];
        }
        along(point, frame, numbers + LOAD_PLACE, lanes);
        add(point, origin, VECTOR);
        if (numbers[LOAD_IN_WORLD] != 0.0)
            memcpy(wrench, given, sizeof(double) * WRENCH);
        else {
            double axes[9 * TOGETHER];
            for (int j = 0; j < 3; j++) {
                const double *of = numbers + LOAD_AXES + j;
                double axis[3] = {of[0], of[3], of[6]};
                along(axes + j * VECTOR, frame, axis, lanes);
            }
            in_world(wrench, axes, given, lanes);
            in_world(wrench + VECTOR, axes, given + VECTOR, lanes);
        }
        add_cross(wrench + VECTOR, 1.0, point, wrench, lanes);
        add_power(power, wrench, work->absolute + motion * WRENCH, lanes);
        add(work->net + body * WRENCH, wrench, WRENCH);
        add_cross(wrench + VECTOR, -1.0, origin, wrench, lanes);
        greatest_size(wrench, 1, layout->length, size, lanes);
        EACH {
            out[POWER_IMBALANCE][l] += power[l];
            out[POWER_SCALE][l] += fabs(power[l]);
            out[APPLIED][l] = greater(out[APPLIED][l], size[l]);
        }
    }
}

/* The components of a vector along the axes of a frame. */
INLINE void in_frame(double *restrict out, const double *restrict frame,
                     const double *restrict vector, int lanes)
{
    for (int i = 0; i < 3; i++)
        EACH out[i * lanes + l] = dot(frame + i * VECTOR, vector, l, lanes);
}

/* wrench = the weight of a body less its momentum rates, about the corner.

   By Euler's equations in the axes of the body, in which its inertia is constant. */
INLINE void inertial_wrench(const double *frame, const double *velocity,
                            const double *acceleration, const double *centre,
                            const MassNumbers *numbers, const double *gravity,
                            double *restrict wrench, int lanes)
{
    const double *spin = velocity + VECTOR, *spin_rate = acceleration + VECTOR;
    double speed[3 * TOGETHER], own[3 * TOGETHER], own_rate[3 * TOGETHER],
        momentum[3 * TOGETHER], rate[3 * TOGETHER], turned[3 * TOGETHER];
    memcpy(speed, velocity, sizeof(double) * VECTOR);
    add_cross(speed, 1.0, spin, centre, lanes);
    memcpy(wrench, acceleration, sizeof(double) * VECTOR);
    add_cross(wrench, 1.0, spin, speed, lanes);
    add_cross(wrench, 1.0, spin_rate, centre, lanes);
    for (int k = 0; k < VECTOR; k++)
        wrench[k] = (wrench[k] - gravity[k]) * -numbers->mass;
    in_frame(own, frame, spin, lanes);
    in_frame(own_rate, frame, spin_rate, lanes);
    for (int i = 0; i < 3; i++) {
        const double *row = numbers->inertia + 3 * i;
        EACH {
            momentum[i * lanes + l] =
                row[0] * own[l] + row[1] * own[lanes + l] + row[2] * own[2 * lanes + l];
            rate[i * lanes + l] = row[0] * own_rate[l] + row[1] * own_rate[lanes + l] +
                                  row[2] * own_rate[2 * lanes + l];
        }
    }
    add_cross(rate, 1.0, own, momentum, lanes);
    in_world(turned, frame, rate, lanes);
    for (int k = 0; k < VECTOR; k++)
        wrench[VECTOR + k] = -turned[k];
    add_cross(wrench + VECTOR, 1.0, centre, wrench, lanes);
}

/* Weights less momentum rates act on the bodies that have mass. */
INLINE void add_inertia(const Layout *layout, const Claim *claim, Work *work,
                        double (*restrict out)[TOGETHER], int lanes)
{
    double gravity[3 * TOGETHER], power[TOGETHER] = {0}, turning[TOGETHER] = {0};
    const double length = layout->length;
    load_all(gravity, claim->arrays + GRAVITY, work, lanes);
    for (int64_t k = 0; k < layout->n_massive; k++) {
        const Massive *massive = layout->massive + k;
        const MassNumbers *numbers = layout->mass_numbers + k;
        const double *frame = work->frames + massive->motion * FRAME;
        double centre[3 * TOGETHER], wrench[6 * TOGETHER];
        along(centre, frame, numbers->centre, lanes);
        add(centre, frame + 3 * VECTOR, VECTOR);
        if (claim->has_rates) {
            const double *velocity = work->velocities + massive->motion * WRENCH;
            const double *acceleration = work->changes + massive->motion * WRENCH;
            const double *spin = velocity + VECTOR, *spin_rate = acceleration + VECTOR;
            inertial_wrench(frame, velocity, acceleration, centre, numbers, gravity, wrench,
                            lanes);
            double scale = numbers->mass * (length * length);
            EACH turning[l] =
                greater(turning[l], (sqrt(dot(spin_rate, spin_rate, l, lanes)) +
                                     dot(spin, spin, l, lanes)) *
                                        scale);
        } else {
            for (int i = 0; i < VECTOR; i++)
                wrench[i] = numbers->mass * gravity[i], wrench[VECTOR + i] = 0.0;
            add_cross(wrench + VECTOR, 1.0, centre, wrench, lanes);
        }
        add_power(power, wrench, work->absolute + massive->motion * WRENCH, lanes);
        add(work->net + massive->body * WRENCH, wrench, WRENCH);
    }
    /* Slides whose motions cancel leave a body where it is, but their rounding does not cancel. */
    double fastest[TOGETHER] = {0}, greatest[TOGETHER] = {0};
    if (claim->has_rates)
        for (int64_t k = 0; k < layout->n_slides; k++)
            EACH {
                int64_t at = layout->slides[k] * lanes + l;
                fastest[l] = greater(fastest[l], fabs(work->v[at]));
                greatest[l] = greater(greatest[l], fabs(work->a[at]));
            }
    EACH {
        double mass = layout->greatest_mass;
        double weight = length * sqrt(dot(gravity, gravity, l, lanes));
        out[POWER_IMBALANCE][l] += power[l];
        out[POWER_SCALE][l] += fabs(power[l]);
        out[APPLIED][l] = greater(out[APPLIED][l], weight * mass);
        out[INERTIA][l] = turning[l];
        if (claim->has_rates)
            out[INERTIA][l] += mass * (length * greatest[l] + fastest[l] * fastest[l]);
    }
}

/* worst = the greatest difference between a wrench along a rate and what is given there. */
INLINE void effort_imbalance(const Layout *layout, const Work *work, double *restrict worst,
                             int lanes)
{
    EACH worst[l] = 0.0;
    for (int64_t k = 0; k < layout->n_efforts; k++) {
        const Effort *effort = layout->efforts + k;
        const EffortNumbers *numbers = layout->effort_numbers + k;
        const double *wrench = work->wrenches + effort->joint * WRENCH, *axis = numbers->axis;
        const double *given = work->given + effort->rate * lanes;
        double along_it[TOGETHER];
        if (!effort->is_last) {
            const double *world = work->in_world + effort->joint * WRENCH;
            const double *origin = work->frames + effort->motion * FRAME + 3 * VECTOR;
            const double *direction = work->units + effort->row * WRENCH;
            double moment[3 * TOGETHER];
            const double *vector = world;
            if (layout->motions[effort->motion].kind != SLIDE) {
                memcpy(moment, world + VECTOR, sizeof(double) * VECTOR);
                add_cross(moment, -1.0, origin, world, lanes);
                vector = moment;
                direction += VECTOR;
            }
            EACH along_it[l] = dot(vector, direction, l, lanes);
        } else {
            const double *vector = wrench + (effort->is_moment ? VECTOR : 0);
            int64_t component = effort->component;
            if (component >= 0)
                EACH along_it[l] = vector[component * lanes + l] * axis[component];
            else
                EACH along_it[l] = vector[l] * axis[0] + vector[lanes + l] * axis[1] +
                                   vector[2 * lanes + l] * axis[2];
        }
        EACH worst[l] =
            greater(worst[l], fabs((along_it[l] - given[l]) * numbers->scale));
    }
}

/* All residuals of a few samples. */
INLINE void check(const Layout *layout, const Claim *claim, Work *work, int *moved,
                  double (*restrict out)[TOGETHER], int lanes)
{
    const Array *arrays = claim->arrays;
    double exerted[TOGETHER], size[TOGETHER];
    place_all(layout, arrays + X, work, lanes);
    unit_twists(layout, work, lanes);
    if (claim->has_rates) {
        load_all(work->v, arrays + V, work, lanes);
        load_all(work->a, arrays + A, work, lanes);
    }
    check_rates(layout, claim, work, moved, out[RATE_ERROR], out[SPEED_SCALE], lanes);
    position_error(layout, claim, work, out[LOOP_ERROR], lanes);
    cut_free(layout, claim, work, lanes);

    double power[TOGETHER] = {0}, of_drives[TOGETHER] = {0};
    EACH out[APPLIED][l] = out[INERTIA][l] = 0.0;
    load_all(work->given, arrays + LOADS, work, lanes);
    for (int64_t k = 0; k < layout->rates; k++) {
        double *given = work->given + k * lanes, *unit = work->unit + k * lanes;
        load(exerted, arrays + EXERTED, k, work, lanes);
        EACH {
            power[l] += given[l] * unit[l];
            of_drives[l] += exerted[l] * unit[l];
            out[APPLIED][l] = greater(out[APPLIED][l], fabs(given[l]) * layout->rate_scale[k]);
            given[l] += exerted[l];
        }
    }
    EACH {
        out[POWER_IMBALANCE][l] = power[l] + of_drives[l];
        out[POWER_SCALE][l] = fabs(power[l]) + fabs(of_drives[l]);
    }
    for (int64_t k = 0; k < layout->n_moments; k++) {
        double *given = work->given + layout->moments[k].rate * lanes;
        load(exerted, arrays + COUPLINGS, layout->moments[k].coupling, work, lanes);
        EACH given[l] += layout->moment_factors[k] * exerted[l];
    }

    add_link_loads(layout, claim, work, out, lanes);
    if (layout->n_massive && (claim->has_rates || claim->has_weight))
        add_inertia(layout, claim, work, out, lanes);
    for (int64_t k = 0; k < layout->n_bodies; k++) {
        double *net = work->net + k * WRENCH;
        const double *frame = work->frames + layout->bodies[k].motion * FRAME;
        if (!layout->bodies[k].is_covered)
            memset(net, 0, sizeof(double) * WRENCH);
        add_cross(net + VECTOR, -1.0, frame + 3 * VECTOR, net, lanes);
    }
    greatest_size(work->net, layout->n_bodies, layout->length, out[IMBALANCE], lanes);
    greatest_size(work->wrenches, layout->n_joints, layout->length, out[GREATEST_WRENCH], lanes);
    effort_imbalance(layout, work, size, lanes);
    EACH {
        out[IMBALANCE][l] = greater(out[IMBALANCE][l], size[l]);
        out[POWER_IMBALANCE][l] = fabs(out[POWER_IMBALANCE][l]);
    }
}

/* Write the residuals of all samples, so many at a time. Returns -1 without memory. */
INLINE int check_all(const Layout *layout, const Claim *claim, int lanes)
{
    const int64_t motions = layout->n_motions;
    double out[RESULTS][TOGETHER];
    Work work;
    struct {
        double **at;
        int64_t numbers;
    } parts[] = {
        {&work.frames, 12 * (motions + layout->n_offsets)},
        {&work.units, 6 * layout->unit_twists},
        {&work.relative, 6 * motions},
        {&work.velocities, 6 * motions},
        {&work.changes, 6 * motions},
        {&work.absolute, 6 * motions},
        {&work.v, layout->rates},
        {&work.a, layout->rates},
        {&work.unit, layout->rates},
        {&work.ratios, layout->rates},
        {&work.given, layout->rates},
        {&work.wrenches, 6 * layout->n_joints},
        {&work.in_world, 6 * layout->n_joints},
        {&work.net, 6 * layout->n_bodies},
    };
    const size_t count = sizeof(parts) / sizeof(parts[0]);
    int64_t numbers = 0;
    for (size_t k = 0; k < count; k++)
        numbers += parts[k].numbers * lanes;
    double *room = malloc(sizeof(double) * numbers + sizeof(int) * (motions + 1));
    if (!room)
        return -1;
    int *moved = (int *)(room + numbers);
    double *next = room;
    for (size_t k = 0; k < count; k++) {
        *parts[k].at = next;
        next += parts[k].numbers * lanes;
    }
    const Array *result = claim->arrays + RESULT;
    Py_ssize_t samples = claim->arrays[X].size[0];
    for (Py_ssize_t first = 0; first < samples; first += lanes) {
        /* Where samples run out, the last one stands for those that are missing. */
        EACH work.samples[l] = first + l < samples ? first + l : samples - 1;
        check(layout, claim, &work, moved, out, lanes);
        for (int k = 0; k < RESULTS; k++)
            EACH result->at[k * result->step[0] + work.samples[l] * result->step[1]] = out[k][l];
    }
    free(room);
    return 0;
}

static int check_each(const Layout *layout, const Claim *claim)
{
    return check_all(layout, claim, 1);
}

static int check_together(const Layout *layout, const Claim *claim)
{
    return check_all(layout, claim, TOGETHER);
}

/* Whether a number of an array (rows, columns) differs from zero. */
static int any_nonzero(const Array *array)
{
    int any = 0;
    for (Py_ssize_t i = 0; i < array->size[0]; i++)
        for (Py_ssize_t j = 0; j < array->size[1]; j++)
            any |= array->at[i * array->step[0] + j * array->step[1]] != 0.0;
    return any;
}

/* Whether all arrays of a claim have the sizes of a layout; else 0 with an error set. */
static int fits(const Layout *layout, const Array *arrays)
{
    const Py_ssize_t samples = arrays[X].size[0], drives = layout->drives;
    const Py_ssize_t columns[] = {
        samples, layout->size, layout->size, layout->rates, layout->rates, drives, drives, drives,
        layout->n_prescribed - drives, layout->rates, layout->n_joints, layout->rates,
        layout->couplings, layout->rates, 3, 6, LOAD_NUMBERS,
    };
    for (int k = 0; k < ARRAYS; k++)
        if (has_size(arrays + k, 1, columns[k], 0))
            return 0;
    for (int k = X; k <= GRAVITY; k++)
        if (has_size(arrays + k, 0, samples, 1))
            return 0;
    const Array *places = arrays + LINK_PLACES;
    if (has_size(arrays + RESULT, 0, RESULTS, 0) || has_size(arrays + RATIOS, 2, drives, 0) ||
        has_size(arrays + WRENCHES, 2, 6, 0) || has_size(arrays + LINK_LOADS, 2, samples, 1) ||
        has_size(places, 0, arrays[LINK_LOADS].size[0], 0))
        return 0;
    for (Py_ssize_t k = 0; k < places->size[0]; k++) {
        double body = places->at[k * places->step[0]];
        if (!(0.0 <= body && body < (double)layout->n_bodies)) {
            PyErr_Format(PyExc_ValueError, "load %zd acts on no body", k);
            return 0;
        }
    }
    return 1;
}

const PlanKind proof_plan = {"proof", INTEGER_TABLES, NUMBER_TABLES, proof_fits};

/* proven(plan, residuals (9, N), fields of a claim in the order of the enumeration above,
   loads on links (L, 6, N or 1) and what they act on (L, 14), whether there are rates).

   All but `x` may have a single sample that holds for all. */
PyObject *proven(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, ARRAYS + 2)
    Array arrays[ARRAYS];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    Claim claim = {arrays, 0, 0, 0};
    const Plan *plan = plan_of(given[0], &proof_plan);
    if (!plan)
        return NULL;
    const Layout layout = layout_of(plan);
    if (take_each(&held, given + 1, "=2 2 2 2 2 2 2 2 2 3 3 2 2 2 2 3 2"))
        goto done;
    claim.has_rates = PyObject_IsTrue(given[1 + ARRAYS]);
    if (claim.has_rates < 0 || !fits(&layout, arrays))
        goto done;
    claim.has_weight = any_nonzero(arrays + GRAVITY);
    if (!claim.has_rates)
        claim.is_moving_at_rest = any_nonzero(arrays + V) || any_nonzero(arrays + A);
    int failed = arrays[X].size[0] == 1 ? check_each(&layout, &claim)
                                        : check_together(&layout, &claim);
    if (failed)
        PyErr_NoMemory();
    else
        answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}

/* cancellation(inertia, wrench, applied, result (N,)): the twin of `Residuals.cancellation`. */
PyObject *cancellation(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 4)
    Array arrays[4];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    for (int k = 0; k < 4; k++)
        if (!take(&held, given[k], 1, k == 3) || has_size(arrays + k, 0, arrays[0].size[0], 0))
            goto done;
    for (Py_ssize_t sample = 0; sample < arrays[0].size[0]; sample++) {
        double at[3];
        for (int k = 0; k < 3; k++)
            at[k] = arrays[k].at[sample * arrays[k].step[0]];
        double left = greater(at[1], at[2]);
        left = left > 0.0 ? left : at[0];
        arrays[3].at[sample * arrays[3].step[0]] = 1.0 + ratio(at[0], left);
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}

/* within(tolerance, fields of `Residuals` but `elastic`): whether all samples are, see `is_proven`.

   Comparisons with what is not a number are false, so that it is no proof. */
PyObject *within(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, RESULTS + 3)
    Array arrays[RESULTS];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    const double tolerance = PyFloat_AsDouble(given[0]);
    const int bodies = PyObject_IsTrue(given[1 + RESULTS]);
    const int power = PyObject_IsTrue(given[2 + RESULTS]);
    if (PyErr_Occurred())
        return NULL;
    for (int k = 0; k < RESULTS; k++)
        if (!take(&held, given[1 + k], 1, 0) || has_size(arrays + k, 0, arrays[0].size[0], 0))
            goto done;
    int is_within = 1;
    for (Py_ssize_t sample = 0; sample < arrays[0].size[0]; sample++) {
        double at[RESULTS];
        for (int k = 0; k < RESULTS; k++)
            at[k] = arrays[k].at[sample * arrays[k].step[0]];
        double size = at[GREATEST_WRENCH] + at[APPLIED] + at[INERTIA];
        double flow = at[POWER_SCALE] + size * at[SPEED_SCALE];
        is_within &= greater(at[LOOP_ERROR], at[RATE_ERROR]) <= tolerance;
        if (bodies)
            is_within &= at[IMBALANCE] <= tolerance * size && size < INFINITY;
        if (power)
            is_within &= at[POWER_IMBALANCE] <= tolerance * flow && flow < INFINITY;
    }
    answer = PyBool_FromLong(is_within);
done:
    release(&held);
    return answer;
}
