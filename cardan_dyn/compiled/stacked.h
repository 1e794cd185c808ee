/* Small matrices, one per sample: what the kernels share. */

#ifndef CARDAN_DYN_STACKED_H
#define CARDAN_DYN_STACKED_H

#include <stddef.h>

/* Factorise `lower` (n, n) with row exchanges and write its inverse; 0 if it is exactly singular.
   `order` is work space of n. */
int invert(double *lower, double *result, ptrdiff_t n, ptrdiff_t *order);

/* A matrix (i, j) with steps, such as a transpose. */
typedef struct {
    const double *at;
    ptrdiff_t rows, columns, row_step, column_step;
} Matrix;

/* Add a multiple of a product with a vector: result (i) += factor * matrix (i, j) vector (j). */
static inline void add_product(const Matrix *matrix, const double *vector, double factor,
                               double *result)
{
    ptrdiff_t rows = matrix->rows, columns = matrix->columns;
    if (matrix->row_step == 1 || columns == 1) {
        /* Column after column: there are no chains of sums to wait for. */
        for (ptrdiff_t j = 0; j < columns; j++) {
            const double *column = matrix->at + j * matrix->column_step;
            double scaled = factor * vector[j];
            if (matrix->row_step == 1)
                for (ptrdiff_t i = 0; i < rows; i++)
                    result[i] += scaled * column[i];
            else
                for (ptrdiff_t i = 0; i < rows; i++)
                    result[i] += scaled * column[i * matrix->row_step];
        }
        return;
    }
    for (ptrdiff_t i = 0; i < rows; i++) {
        const double *row = matrix->at + i * matrix->row_step;
        double sum = 0.0;
        for (ptrdiff_t j = 0; j < columns; j++)
            sum += row[j * matrix->column_step] * vector[j];
        result[i] += factor * sum;
    }
}

#endif
