/* Stacked matrices: the twins of functions of kinematics/closing/stacked.py. */

#include "arrays.h"
#include "kernels.h"

#define MOST_ROWS 64

/* Factorise `lower` (n, n) with row exchanges and write its inverse; 0 if it is exactly singular.

   As LAPACK does: the greatest entry of a column is its pivot. */
static int inverted(double *lower, double *result, int n)
{
    int order[MOST_ROWS];
    for (int k = 0; k < n; k++)
        order[k] = k;
    for (int k = 0; k < n; k++) {
        int pivot = k;
        double greatest = fabs(lower[k * n + k]);
        for (int i = k + 1; i < n; i++) {
            double size = fabs(lower[i * n + k]);
            if (size > greatest) {
                greatest = size;
                pivot = i;
            }
        }
        if (greatest == 0.0)
            return 0;
        if (pivot != k) {
            for (int j = 0; j < n; j++) {
                double other = lower[k * n + j];
                lower[k * n + j] = lower[pivot * n + j];
                lower[pivot * n + j] = other;
            }
            int other = order[k];
            order[k] = order[pivot];
            order[pivot] = other;
        }
        double reciprocal = 1.0 / lower[k * n + k];
        for (int i = k + 1; i < n; i++) {
            double factor = lower[i * n + k] *= reciprocal;
            if (factor != 0.0)
                for (int j = k + 1; j < n; j++)
                    lower[i * n + j] -= factor * lower[k * n + j];
        }
    }
    memset(result, 0, sizeof(double) * n * n);
    for (int k = 0; k < n; k++)
        result[k * n + order[k]] = 1.0;
    for (int i = 1; i < n; i++)
        for (int k = 0; k < i; k++) {
            double factor = lower[i * n + k];
            if (factor != 0.0)
                for (int j = 0; j < n; j++)
                    result[i * n + j] -= factor * result[k * n + j];
        }
    for (int i = n - 1; i >= 0; i--) {
        double *row = result + i * n;
        for (int k = i + 1; k < n; k++) {
            double factor = lower[i * n + k];
            if (factor != 0.0)
                for (int j = 0; j < n; j++)
                    row[j] -= factor * result[k * n + j];
        }
        double diagonal = lower[i * n + i];
        for (int j = 0; j < n; j++)
            row[j] /= diagonal;
    }
    return 1;
}

/* inverse(matrices (N, n, n), result (N, n, n)): whether none is exactly singular. */
PyObject *inverse(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 2)
    Array arrays[2];
    Held held = {arrays, 0};
    Array *from = take(&held, given[0], 3, 0), *to = from ? take(&held, given[1], 3, 1) : NULL;
    PyObject *answer = NULL;
    if (!to)
        goto done;
    Py_ssize_t count = from->size[0], n = from->size[1];
    if (has_size(from, 2, n, 0) || has_size(to, 0, count, 0) || has_size(to, 1, n, 0) ||
        has_size(to, 2, n, 0))
        goto done;
    if (n > MOST_ROWS || (n > 1 && (to->step[2] != 1 || to->step[1] != n))) {
        PyErr_SetString(PyExc_ValueError, "too many rows, or a result with gaps");
        goto done;
    }
    double lower[MOST_ROWS * MOST_ROWS];
    int regular = 1;
    for (Py_ssize_t sample = 0; sample < count && regular; sample++) {
        const double *matrix = from->at + sample * from->step[0];
        for (Py_ssize_t i = 0; i < n; i++)
            for (Py_ssize_t j = 0; j < n; j++)
                lower[i * n + j] = matrix[i * from->step[1] + j * from->step[2]];
        regular = inverted(lower, to->at + sample * to->step[0], (int)n);
    }
    answer = PyBool_FromLong(regular);
done:
    release(&held);
    return answer;
}

/* refined(matrices (N, i, j), inverses (N, j, i), right (N, i, k), result (N, j, k)). */
PyObject *refined(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 4)
    Array arrays[4];
    Held held = {arrays, 0};
    PyObject *answer = NULL;
    for (int k = 0; k < 4; k++)
        if (!take(&held, given[k], 3, k == 3))
            goto done;
    Array *A = arrays, *B = arrays + 1, *right = arrays + 2, *result = arrays + 3;
    Py_ssize_t count = A->size[0], rows = A->size[1], columns = A->size[2], sides = right->size[2];
    if (has_size(B, 0, count, 0) || has_size(B, 1, columns, 0) || has_size(B, 2, rows, 0) ||
        has_size(right, 0, count, 0) || has_size(right, 1, rows, 0) ||
        has_size(result, 0, count, 0) || has_size(result, 1, columns, 0) ||
        has_size(result, 2, sides, 0))
        goto done;
    double *left = malloc(sizeof(double) * (rows + columns + 1));
    if (!left) {
        PyErr_NoMemory();
        goto done;
    }
    double *solution = left + rows;
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        const double *a = A->at + sample * A->step[0], *b = B->at + sample * B->step[0];
        for (Py_ssize_t side = 0; side < sides; side++) {
            const double *r = right->at + sample * right->step[0] + side * right->step[2];
            double *out = result->at + sample * result->step[0] + side * result->step[2];
            for (Py_ssize_t j = 0; j < columns; j++) {
                double sum = 0.0;
                for (Py_ssize_t i = 0; i < rows; i++)
                    sum += b[j * B->step[1] + i * B->step[2]] * r[i * right->step[1]];
                solution[j] = sum;
            }
            for (Py_ssize_t i = 0; i < rows; i++) {
                double sum = 0.0;
                for (Py_ssize_t j = 0; j < columns; j++)
                    sum += a[i * A->step[1] + j * A->step[2]] * solution[j];
                left[i] = r[i * right->step[1]] - sum;
            }
            for (Py_ssize_t j = 0; j < columns; j++) {
                double sum = 0.0;
                for (Py_ssize_t i = 0; i < rows; i++)
                    sum += b[j * B->step[1] + i * B->step[2]] * left[i];
                out[j * result->step[1]] = solution[j] + sum;
            }
        }
    }
    free(left);
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}
