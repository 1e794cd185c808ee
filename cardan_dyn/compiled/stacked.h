/* Small matrices and vectors, one per sample: what all files that solve share. */

#ifndef CARDAN_DYN_STACKED_H
#define CARDAN_DYN_STACKED_H

#include "arrays.h"

/* The greater number; what is not a number stays. */
static inline double greater(double known, double found)
{
    return found > known || found != found ? found : known;
}

static inline double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross(const double *a, const double *b, double *result)
{
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

/* The product of quaternions (x, y, z, w). */
static inline void turned(const double q[4], const double r[4], double result[4])
{
    result[0] = q[3] * r[0] - q[2] * r[1] + q[1] * r[2] + q[0] * r[3];
    result[1] = q[2] * r[0] + q[3] * r[1] - q[0] * r[2] + q[1] * r[3];
    result[2] = -q[1] * r[0] + q[0] * r[1] + q[3] * r[2] + q[2] * r[3];
    result[3] = -q[0] * r[0] - q[1] * r[1] - q[2] * r[2] + q[3] * r[3];
}

/* Factorise `lower` (n, n) with row exchanges and write its inverse; 0 if it is exactly singular.
   `order` is work space of n. */
int invert(double *lower, double *result, Py_ssize_t n, Py_ssize_t *order);

/* A matrix (i, j) with steps, such as a transpose. */
typedef struct {
    const double *at;
    Py_ssize_t rows, columns, row_step, column_step;
} Matrix;

/* Add a multiple of a product with a vector: result (i) += factor * matrix (i, j) vector (j). */
static inline void add_product(const Matrix *matrix, const double *vector, double factor,
                               double *result)
{
    Py_ssize_t rows = matrix->rows, columns = matrix->columns;
    if (matrix->row_step == 1 || columns == 1) {
        /* Column after column: there are no chains of sums to wait for. */
        for (Py_ssize_t j = 0; j < columns; j++) {
            const double *column = matrix->at + j * matrix->column_step;
            double scaled = factor * vector[j];
            if (matrix->row_step == 1)
                for (Py_ssize_t i = 0; i < rows; i++)
                    result[i] += scaled * column[i];
            else
                for (Py_ssize_t i = 0; i < rows; i++)
                    result[i] += scaled * column[i * matrix->row_step];
        }
        return;
    }
    for (Py_ssize_t i = 0; i < rows; i++) {
        const double *row = matrix->at + i * matrix->row_step;
        double sum = 0.0;
        for (Py_ssize_t j = 0; j < columns; j++)
            sum += row[j * matrix->column_step] * vector[j];
        result[i] += factor * sum;
    }
}

/* Solve a linear system by an explicit inverse, with one step of refinement, which makes it as
   stable as an elimination. The right-hand side is overwritten. */
static inline void solve(const Matrix *matrix, const Matrix *inverse, double *right,
                         double *solution)
{
    memset(solution, 0, sizeof(double) * matrix->columns);
    add_product(inverse, right, 1.0, solution);
    add_product(matrix, solution, -1.0, right);
    add_product(inverse, right, 1.0, solution);
}

#endif
