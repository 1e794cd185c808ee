/* What follows of wrenches: the twins of `InverseDynamics._exerted` and `condition`, and of
   `Solution.overflown`, in dynamics/inverse_dynamics.py. */

#include "kernels.h"
#include "stacked.h"

/* What a plan for `exerted` holds, in the order of its arrays. */
enum { EXERTED_SIZES, EXERTED, EXERTED_MOMENTS, EXERTED_INTEGERS };
enum { EXERTED_UNITS, EXERTED_FACTORS, EXERTED_NUMBERS };
enum { EXERTED_RATES, EXERTED_BODIES, EXERTED_COUPLINGS, EXERTED_AXES, EXERTED_SIZE_COUNT };

/* Of a rate: where it is among the components of wrenches, and the couplings that load it. */
typedef struct {
    int64_t rate, body, component, from, to;
} Exerted;

static int exerted_fits(const Plan *plan)
{
    const Py_ssize_t *counts = plan->integer_sizes, *numbers = plan->number_sizes;
    const int64_t *sizes = plan->integers[EXERTED_SIZES];
    const Exerted *efforts = (const Exerted *)plan->integers[EXERTED];
    if (counts[EXERTED_SIZES] != EXERTED_SIZE_COUNT || counts[EXERTED] % FIELDS(Exerted) ||
        !are_indices(sizes, EXERTED_SIZE_COUNT, 1, 0, INT32_MAX))
        return 0;
    Py_ssize_t effort_count = counts[EXERTED] / FIELDS(Exerted);
    for (Py_ssize_t k = 0; k < effort_count; k++)
        if (!is_part(efforts[k].rate, 1, sizes[EXERTED_RATES]) ||
            !is_part(efforts[k].body, 1, sizes[EXERTED_BODIES]) ||
            !is_part(efforts[k].component, 1, 6) ||
            !is_part(efforts[k].from, efforts[k].to - efforts[k].from, counts[EXERTED_MOMENTS]))
            return 0;
    return numbers[EXERTED_FACTORS] == counts[EXERTED_MOMENTS] &&
           numbers[EXERTED_UNITS] == effort_count * (sizes[EXERTED_AXES] ? 1 : 6) &&
           are_indices(plan->integers[EXERTED_MOMENTS], counts[EXERTED_MOMENTS], 1, 0,
                       sizes[EXERTED_COUPLINGS]);
}

const PlanKind exerted_plan = {"exerted", EXERTED_INTEGERS, EXERTED_NUMBERS, exerted_fits};

/* exerted(plan, wrenches (N, b, 6), loads (N, nv) or (1, nv), result (N, nv), G moments (N, 1))

   What drives and held joints exert: components of wrenches less loads and moments of couplings. */
PyObject *exerted(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    const Plan *plan = nargs < 4 ? NULL : plan_of(given[0], &exerted_plan);
    if (nargs < 4)
        PyErr_SetString(PyExc_TypeError, "at least 4 arguments are needed");
    if (!plan)
        return NULL;
    const int64_t *sizes = plan->integers[EXERTED_SIZES];
    EXACTLY(nargs, 4 + sizes[EXERTED_COUPLINGS])
    Array *arrays = malloc(sizeof(Array) * nargs);
    if (!arrays)
        return PyErr_NoMemory();
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    if (take_each(&held, given + 1, "3 2 =2"))
        goto done;
    Array *wrenches = arrays, *loads = arrays + 1, *result = arrays + 2;
    Py_ssize_t count = wrenches->size[0];
    if (has_size(wrenches, 1, sizes[EXERTED_BODIES], 0) || has_size(wrenches, 2, 6, 0) ||
        has_size(loads, 0, count, 1) || has_size(loads, 1, sizes[EXERTED_RATES], 0) ||
        has_size(result, 0, count, 0) || has_size(result, 1, sizes[EXERTED_RATES], 0))
        goto done;
    const Array *moments = arrays + 3;
    for (Py_ssize_t index = 0; index < sizes[EXERTED_COUPLINGS]; index++) {
        const Array *moment = take(&held, given[4 + index], 2, 0);
        if (!moment || has_size(moment, 0, count, 0) || has_size(moment, 1, 1, 0))
            goto done;
    }
    const Exerted *efforts = (const Exerted *)plan->integers[EXERTED];
    Py_ssize_t effort_count = plan->integer_sizes[EXERTED] / FIELDS(Exerted);
    const double *factors = plan->numbers[EXERTED_FACTORS];
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        double *out = result->at + sample * result->step[0];
        for (Py_ssize_t rate = 0; rate < sizes[EXERTED_RATES]; rate++)
            out[rate * result->step[1]] = 0.0;
        for (Py_ssize_t index = 0; index < effort_count; index++) {
            const Exerted *effort = efforts + index;
            const double *wrench = wrenches->at + sample * wrenches->step[0] +
                                   effort->body * wrenches->step[1];
            const double *units = plan->numbers[EXERTED_UNITS] + index;
            double sum = 0.0;
            if (sizes[EXERTED_AXES])
                sum = wrench[effort->component * wrenches->step[2]] * *units;
            else
                for (int i = 0; i < 6; i++)
                    sum += wrench[i * wrenches->step[2]] * units[5 * index + i];
            for (int64_t k = effort->from; k < effort->to; k++) {
                const Array *moment = moments + plan->integers[EXERTED_MOMENTS][k];
                sum += factors[k] * moment->at[sample * moment->step[0]];
            }
            out[effort->rate * result->step[1]] =
                sum - loads->at[sample * loads->step[0] + effort->rate * loads->step[1]];
        }
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    free(arrays);
    return answer;
}

/* Add differences of numbers with themselves, which are not zero where they are not finite. */
static double differences(const double *at, Py_ssize_t count, Py_ssize_t step)
{
    double sums[4] = {0.0, 0.0, 0.0, 0.0};
    Py_ssize_t k = 0;
    if (step == 1)
        for (; k + 4 <= count; k += 4)
            for (int i = 0; i < 4; i++)
                sums[i] += at[k + i] - at[k + i];
    for (; k < count; k++)
        sums[0] += at[k * step] - at[k * step];
    return sums[0] + sums[1] + sums[2] + sums[3];
}

/* all_finite(arrays of at most four axes): whether all of their numbers are finite. */
PyObject *all_finite(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    double sum = 0.0;
    for (Py_ssize_t index = 0; index < nargs; index++) {
        Py_buffer buffer;
        if (PyObject_GetBuffer(given[index], &buffer, PyBUF_STRIDES | PyBUF_FORMAT) < 0)
            return NULL;
        if (buffer.ndim > MOST_AXES || buffer.itemsize != 8 || strcmp(buffer.format, "d") != 0) {
            PyBuffer_Release(&buffer);
            PyErr_Format(PyExc_TypeError, "argument %zd has to be an array of numbers", index + 1);
            return NULL;
        }
        if (PyBuffer_IsContiguous(&buffer, 'A'))
            sum += differences(buffer.buf, buffer.len / 8, 1);
        else {
            Py_ssize_t size[MOST_AXES] = {1, 1, 1, 1}, step[MOST_AXES] = {0, 0, 0, 0};
            for (int axis = 0; axis < buffer.ndim; axis++) {
                size[MOST_AXES - buffer.ndim + axis] = buffer.shape[axis];
                step[MOST_AXES - buffer.ndim + axis] = buffer.strides[axis] / 8;
            }
            const double *at = buffer.buf;
            for (Py_ssize_t i = 0; i < size[0]; i++)
                for (Py_ssize_t j = 0; j < size[1]; j++)
                    for (Py_ssize_t k = 0; k < size[2]; k++)
                        sum += differences(at + i * step[0] + j * step[1] + k * step[2], size[3],
                                           step[3]);
        }
        PyBuffer_Release(&buffer);
    }
    return PyBool_FromLong(sum == 0.0);
}

/* magnified(condition (N,), ratios (N, nv, d), scale (nv, d), result (N,)): conditions times the
   greatest ratio, which counts as one at least. */
PyObject *magnified(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 4)
    Array arrays[4];
    Held held = {arrays, 0, NULL};
    PyObject *answer = NULL;
    if (take_each(&held, given, "1 3 2 =1"))
        goto done;
    Array *condition = arrays, *ratios = arrays + 1, *scale = arrays + 2, *result = arrays + 3;
    Py_ssize_t count = ratios->size[0], rates = ratios->size[1], drives = ratios->size[2];
    if (has_size(condition, 0, count, 0) || has_size(scale, 0, rates, 0) ||
        has_size(scale, 1, drives, 0) || has_size(result, 0, count, 0))
        goto done;
    for (Py_ssize_t sample = 0; sample < count; sample++) {
        const double *at = ratios->at + sample * ratios->step[0];
        double greatest = 1.0;
        for (Py_ssize_t rate = 0; rate < rates; rate++)
            for (Py_ssize_t drive = 0; drive < drives; drive++) {
                double unit = scale->at[rate * scale->step[0] + drive * scale->step[1]];
                double ratio = at[rate * ratios->step[1] + drive * ratios->step[2]];
                greatest = greater(greatest, fabs(ratio) * unit);
            }
        result->at[sample * result->step[0]] =
            condition->at[sample * condition->step[0]] * greatest;
    }
    answer = Py_NewRef(Py_None);
done:
    release(&held);
    return answer;
}
