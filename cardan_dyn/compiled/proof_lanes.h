/* Lanes: vectors, wrenches and frames of a few samples side by side, for the proof alone.

   They are rows of three components; of each component, the samples lie side by side, so that
   processors work on several at once. A wrench has two rows, a frame four: three axes and an
   origin. Functions are written for `lanes` samples, and compiled for one and for TOGETHER. */

#ifndef CARDAN_DYN_PROOF_LANES_H
#define CARDAN_DYN_PROOF_LANES_H

#include "arrays.h"

#define TOGETHER 4
#define EACH for (int l = 0; l < lanes; l++)
#define VECTOR (3 * lanes)
#define WRENCH (6 * lanes)
#define FRAME (12 * lanes)

#define LEAST_SCALE 1e-300

/* The greater number; what is not a number is kept, as by `np.maximum`. */
INLINE double greater(double a, double b)
{
    return ((a >= b) | (a != a)) ? a : b;
}

INLINE double ratio(double numerator, double denominator)
{
    return numerator == 0.0 ? 0.0 : numerator / (denominator + LEAST_SCALE);
}

/* out += factor (a x b); the factor is 1 or -1. */
INLINE void add_cross(double *restrict out, double factor, const double *a, const double *b,
                      int lanes)
{
    EACH {
        double x = a[l], y = a[lanes + l], z = a[2 * lanes + l];
        double u = b[l], v = b[lanes + l], w = b[2 * lanes + l];
        out[l] += factor * (y * w - z * v);
        out[lanes + l] += factor * (z * u - x * w);
        out[2 * lanes + l] += factor * (x * v - y * u);
    }
}

INLINE void add(double *restrict out, const double *restrict values, int count)
{
    for (int k = 0; k < count; k++)
        out[k] += values[k];
}

INLINE double dot(const double *a, const double *b, int l, int lanes)
{
    return a[l] * b[l] + a[lanes + l] * b[lanes + l] + a[2 * lanes + l] * b[2 * lanes + l];
}

/* out = the sum of the axes of a frame times components: those of a vector in the frame. */
INLINE void in_world(double *restrict out, const double *restrict frame,
                     const double *restrict components, int lanes)
{
    for (int i = 0; i < 3; i++)
        EACH out[i * lanes + l] = components[l] * frame[i * lanes + l] +
                                  components[lanes + l] * frame[VECTOR + i * lanes + l] +
                                  components[2 * lanes + l] * frame[2 * VECTOR + i * lanes + l];
}

/* The same for three constants. */
INLINE void along(double *restrict out, const double *restrict frame, const double *components,
                  int lanes)
{
    double x = components[0], y = components[1], z = components[2];
    for (int k = 0; k < VECTOR; k++)
        out[k] = x * frame[k] + y * frame[VECTOR + k] + z * frame[2 * VECTOR + k];
}

/* A constant placement, transposed, in a frame; in the world, of which there is no frame.

   Products with zeros are not left out, which keeps what is not a number. */
INLINE void place(double *restrict out, const double *restrict frame,
                  const double *restrict placement, int lanes)
{
    for (int row = 0; row < 4; row++) {
        double x = placement[4 * row], y = placement[4 * row + 1], z = placement[4 * row + 2];
        double *to = out + row * VECTOR;
        if (!frame) {
            EACH to[l] = x, to[lanes + l] = y, to[2 * lanes + l] = z;
            continue;
        }
        double w = placement[4 * row + 3];
        for (int k = 0; k < VECTOR; k++)
            to[k] = x * frame[k] + y * frame[VECTOR + k] + z * frame[2 * VECTOR + k] +
                    w * frame[3 * VECTOR + k];
    }
}

/* A frame after a turn about one of its axes, with a sign. */
INLINE void turn_along(double *restrict frame, const double *restrict start, int axis, double sign,
                       const double *angle, int lanes)
{
    double cosine[TOGETHER], sine[TOGETHER];
    EACH cosine[l] = cos(angle[l]), sine[l] = sin(angle[l]);
    EACH sine[l] *= sign;
    const int second = (axis + 1) % 3 * VECTOR, third = (axis + 2) % 3 * VECTOR;
    memcpy(frame + axis * VECTOR, start + axis * VECTOR, sizeof(double) * VECTOR);
    memcpy(frame + 3 * VECTOR, start + 3 * VECTOR, sizeof(double) * VECTOR);
    for (int i = 0; i < 3; i++)
        EACH {
            double y = start[second + i * lanes + l], z = start[third + i * lanes + l];
            frame[second + i * lanes + l] = y * cosine[l] + z * sine[l];
            frame[third + i * lanes + l] = z * cosine[l] - y * sine[l];
        }
}

/* A frame after a turn about any axis: R = 1 + sin K + (1 - cos) K K, after Rodrigues. */
INLINE void turn(double *restrict frame, const double *restrict start, const double *axis,
                 const double *angle, int lanes)
{
    double x = axis[0], y = axis[1], z = axis[2];
    double K[3][3] = {{0.0, z, -y}, {-z, 0.0, x}, {y, -x, 0.0}}, square[3][3];
    double sine[TOGETHER], versine[TOGETHER];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            square[i][j] = K[i][0] * K[0][j] + K[i][1] * K[1][j] + K[i][2] * K[2][j];
    EACH {
        double cosine = cos(angle[l]);
        sine[l] = sin(angle[l]);
        /* Without cancellation for small angles. */
        versine[l] = cosine > 0.0 ? sine[l] * sine[l] / (1.0 + cosine) : 1.0 - cosine;
    }
    memcpy(frame + 3 * VECTOR, start + 3 * VECTOR, sizeof(double) * VECTOR);
    for (int row = 0; row < 3; row++)
        for (int i = 0; i < 3; i++)
            EACH {
                double u = start[i * lanes + l], v = start[VECTOR + i * lanes + l],
                       w = start[2 * VECTOR + i * lanes + l];
                double linear = K[row][0] * u + K[row][1] * v + K[row][2] * w;
                double quadratic = square[row][0] * u + square[row][1] * v + square[row][2] * w;
                frame[row * VECTOR + i * lanes + l] = start[row * VECTOR + i * lanes + l] +
                                                      sine[l] * linear + versine[l] * quadratic;
            }
}

/* A frame after a rotation by unit quaternions (x, y, z, w). */
INLINE void rotate(double *restrict frame, const double *restrict start,
                   const double *quaternions, int lanes)
{
    memcpy(frame + 3 * VECTOR, start + 3 * VECTOR, sizeof(double) * VECTOR);
    EACH {
        double x = quaternions[l], y = quaternions[lanes + l], z = quaternions[2 * lanes + l],
               w = quaternions[3 * lanes + l];
        double R[3][3] = {
            {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)},
            {2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)},
            {2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)},
        };
        for (int row = 0; row < 3; row++)
            for (int i = 0; i < 3; i++)
                frame[row * VECTOR + i * lanes + l] =
                    R[0][row] * start[i * lanes + l] + R[1][row] * start[VECTOR + i * lanes + l] +
                    R[2][row] * start[2 * VECTOR + i * lanes + l];
    }
}

#endif
