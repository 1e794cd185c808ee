/* Stacked matrices: the twins of functions of kinematics/closing/stacked.py. */

#include "kernels.h"
#include "stacked.h"

/* Vectors of four numbers where the processor has them. They are rounded as single numbers are. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define ON_WIDE_VECTORS __attribute__((target_clones("avx2", "default")))
#else
#define ON_WIDE_VECTORS
#endif

/* Subtract multiples of rows first to last - 1 of a matrix from a row (n), one after the other,
   several of them each time that it is read. Of a lower triangle, rows end with the diagonal. */
INLINE void subtract_rows(double *row, const double *factors, const double *matrix,
                                  Py_ssize_t step, Py_ssize_t first, Py_ssize_t last, Py_ssize_t n,
                                  int is_lower)
{
    Py_ssize_t k = first;
    while (k < last) {
        Py_ssize_t which[4], count = 0;
        for (; k < last && count < 4; k++)
            if (factors[k] != 0.0)
                which[count++] = k;
        if (!count)
            return;
        Py_ssize_t length = is_lower ? which[count - 1] + 1 : n;
        if (count == 4) {
            const double *a = matrix + which[0] * step, *b = matrix + which[1] * step;
            const double *c = matrix + which[2] * step, *d = matrix + which[3] * step;
            double fa = factors[which[0]], fb = factors[which[1]];
            double fc = factors[which[2]], fd = factors[which[3]];
            for (Py_ssize_t j = 0; j < length; j++)
                row[j] = row[j] - fa * a[j] - fb * b[j] - fc * c[j] - fd * d[j];
            continue;
        }
        for (Py_ssize_t m = 0; m < count; m++) {
            const double *a = matrix + which[m] * step;
            double fa = factors[which[m]];
            for (Py_ssize_t j = 0; j < length; j++)
                row[j] -= fa * a[j];
        }
    }
}

/* The row of the pivot of a column: that of its greatest entry from the diagonal on, as LAPACK has it.
   One that is not a number counts as that, so that it shows. */
INLINE Py_ssize_t pivot_of(const double *matrix, Py_ssize_t n, Py_ssize_t k)
{
    Py_ssize_t pivot = k;
    double greatest = fabs(matrix[k * n + k]);
    for (Py_ssize_t i = k + 1; i < n; i++) {
        double size = fabs(matrix[i * n + k]);
        if (size > greatest || size != size) {
            greatest = size;
            pivot = i;
        }
    }
    return pivot;
}

ON_WIDE_VECTORS
int invert(double *lower, double *result, Py_ssize_t n, Py_ssize_t *order)
{
    for (Py_ssize_t k = 0; k < n; k++)
        order[k] = k;
    for (Py_ssize_t k = 0; k < n; k++) {
        Py_ssize_t pivot = pivot_of(lower, n, k);
        if (lower[pivot * n + k] == 0.0)
            return 0;
        if (pivot != k) {
            for (Py_ssize_t j = 0; j < n; j++) {
                double other = lower[k * n + j];
                lower[k * n + j] = lower[pivot * n + j];
                lower[pivot * n + j] = other;
            }
            Py_ssize_t other = order[k];
            order[k] = order[pivot];
            order[pivot] = other;
        }
        const double *upper = lower + k * n;
        for (Py_ssize_t i = k + 1; i < n; i++) {
            double *row = lower + i * n;
            if (row[k] == 0.0)
                continue;
            /* Of rows that are alike nothing is left, which a reciprocal would not see. */
            double factor = row[k] = row[k] / upper[k];
            for (Py_ssize_t j = k + 1; j < n; j++)
                row[j] -= factor * upper[j];
        }
    }
    /* The inverse of the lower triangle, whose rows are as long as they are far down; the columns of
       it and of the result are in the order of the pivots until the end. */
    memset(result, 0, sizeof(double) * n * n);
    for (Py_ssize_t i = 0; i < n; i++) {
        subtract_rows(result + i * n, lower + i * n, result, n, 0, i, n, 1);
        result[i * n + i] = 1.0;
    }
    for (Py_ssize_t i = n - 1; i >= 0; i--) {
        double *row = result + i * n, diagonal = lower[i * n + i];
        subtract_rows(row, lower + i * n, result, n, i + 1, n, n, 0);
        for (Py_ssize_t j = 0; j < n; j++)
            row[j] /= diagonal;
    }
    for (Py_ssize_t i = 0; i < n; i++) {
        memcpy(lower, result + i * n, sizeof(double) * n);
        for (Py_ssize_t j = 0; j < n; j++)
            result[i * n + order[j]] = lower[j];
    }
    return 1;
}

/* refined(matrices (N, i, j), inverses (N, j, i), right (N, i, k), result (N, j, k)).

   Of the former three, each may be the same for all samples, with N = 1. */
PyObject *refined(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 4)
    Array arrays[4];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    if (take_each(&held, given, "3 3 3 =3"))
        goto done;
    Array *A = arrays, *B = arrays + 1, *right = arrays + 2, *result = arrays + 3;
    Py_ssize_t count = result->size[0], rows = A->size[1], columns = A->size[2];
    Py_ssize_t sides = right->size[2];
    if (has_size(A, 0, count, 1) || has_size(B, 0, count, 1) || has_size(right, 0, count, 1) ||
        has_size(B, 1, columns, 0) || has_size(B, 2, rows, 0) || has_size(right, 1, rows, 0) ||
        has_size(result, 1, columns, 0) || has_size(result, 2, sides, 0))
        goto done;
    double *left = room_for(&held, rows + columns);
    if (!left)
        goto done;
    double *solution = left + rows;
    Matrix matrix = {NULL, rows, columns, A->step[1], A->step[2]};
    Matrix inverse = {NULL, columns, rows, B->step[1], B->step[2]};
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        matrix.at = A->at + sample * A->step[0];
        inverse.at = B->at + sample * B->step[0];
        for (Py_ssize_t side = 0; side < sides; side++) {
            const double *r = right->at + sample * right->step[0] + side * right->step[2];
            double *out = result->at + sample * result->step[0] + side * result->step[2];
            for (Py_ssize_t i = 0; i < rows; i++)
                left[i] = r[i * right->step[1]];
            solve(&matrix, &inverse, left, solution);
            for (Py_ssize_t j = 0; j < columns; j++)
                out[j * result->step[1]] = solution[j];
        }
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}

/* The sign of the determinant of a matrix (n, n), which is overwritten; 0 if it is none. */
INLINE int sign_of(double *matrix, Py_ssize_t n)
{
    int sign = 1;
    for (Py_ssize_t k = 0; k < n; k++) {
        Py_ssize_t pivot = pivot_of(matrix, n, k);
        /* Written so that what is not a number has no sign. */
        if (!(fabs(matrix[pivot * n + k]) > 0.0))
            return 0;
        double *upper = matrix + k * n, *other = matrix + pivot * n;
        if (pivot != k) {
            for (Py_ssize_t j = k; j < n; j++) {
                double exchanged = upper[j];
                upper[j] = other[j];
                other[j] = exchanged;
            }
            sign = -sign;
        }
        if (upper[k] < 0.0)
            sign = -sign;
        for (Py_ssize_t i = k + 1; i < n; i++) {
            double *row = matrix + i * n, factor = row[k] / upper[k];
            if (factor != 0.0)
                for (Py_ssize_t j = k + 1; j < n; j++)
                    row[j] -= factor * upper[j];
        }
    }
    return sign;
}

/* Return whether the product of a matrix (p, columns) with another one, whose rows lie `step` apart,
   has a positive determinant. `work` is of p * p + columns. */
ON_WIDE_VECTORS
static int is_positive(const double *matrix, Py_ssize_t row_step, Py_ssize_t column_step,
                       const double *other, Py_ssize_t step, Py_ssize_t p, Py_ssize_t columns,
                       double *work)
{
    double *product = work, *factors = work + p * p;
    memset(product, 0, sizeof(double) * p * p);
    for (Py_ssize_t i = 0; i < p; i++) {
        for (Py_ssize_t k = 0; k < columns; k++)
            factors[k] = -matrix[i * row_step + k * column_step];
        subtract_rows(product + i * p, factors, other, step, 0, columns, p, 0);
    }
    return sign_of(product, p) > 0;
}

/* same_side(rows (N, p, R), inverses (N, R, p), result (N,)): 1 where their products have positive
   determinants, else 0. */
PyObject *same_side(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 3)
    Array arrays[3];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    if (take_each(&held, given, "3 3 =1"))
        goto done;
    Array *A = arrays, *B = arrays + 1, *result = arrays + 2;
    Py_ssize_t count = result->size[0], p = A->size[1], columns = A->size[2];
    if (has_size(A, 0, count, 1) || has_size(B, 0, count, 1) || has_size(B, 1, columns, 0) ||
        has_size(B, 2, p, 0))
        goto done;
    double *work = room_for(&held, p * p + columns + columns * p);
    if (!work)
        goto done;
    double *copied = work + p * p + columns;
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        const double *a = A->at + sample * A->step[0], *b = B->at + sample * B->step[0];
        Py_ssize_t step = B->step[1];
        if (B->step[2] != 1) {
            for (Py_ssize_t k = 0; k < columns; k++)
                for (Py_ssize_t j = 0; j < p; j++)
                    copied[k * p + j] = b[k * B->step[1] + j * B->step[2]];
            b = copied, step = p;
        }
        result->at[sample * result->step[0]] =
            is_positive(a, A->step[1], A->step[2], b, step, p, columns, work);
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}
