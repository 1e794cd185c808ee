/* The module: its functions, and how arrays and plans come in. */

#include "arrays.h"
#include "kernels.h"

static const char PLAN[] = "cardan_dyn.plan";

Array *take(Held *held, PyObject *object, int axes, int writable)
{
    Array *array = &held->arrays[held->held];
    int flags = PyBUF_STRIDES | PyBUF_FORMAT | (writable ? PyBUF_WRITABLE : 0);
    if (PyObject_GetBuffer(object, &array->buffer, flags) < 0)
        return NULL;
    held->held++;
    Py_buffer *buffer = &array->buffer;
    if (buffer->ndim != axes || buffer->itemsize != 8 || strcmp(buffer->format, "d") != 0) {
        PyErr_Format(PyExc_TypeError, "argument %d has to be an array of numbers with %d axes",
                     held->held, axes);
        return NULL;
    }
    array->at = buffer->buf;
    for (int axis = 0; axis < axes; axis++) {
        array->size[axis] = buffer->shape[axis];
        array->step[axis] = buffer->shape[axis] == 1 ? 0 : buffer->strides[axis] / 8;
        if (array->step[axis] * 8 != buffer->strides[axis] && array->step[axis]) {
            PyErr_Format(PyExc_TypeError, "numbers of argument %d lie between others", held->held);
            return NULL;
        }
    }
    return array;
}

int take_each(Held *held, Arguments given, const char *axes)
{
    for (; *axes; given++) {
        int may_be_none = *axes == '?', is_result = axes[may_be_none] == '=';
        axes += may_be_none + is_result;
        if (may_be_none && *given == Py_None)
            memset(&held->arrays[held->held++], 0, sizeof(Array));
        else if (!take(held, *given, *axes - '0', is_result))
            return -1;
        axes += axes[1] ? 2 : 1;
    }
    return 0;
}

double *room_for(Held *held, Py_ssize_t numbers)
{
    held->room = malloc(sizeof(double) * (numbers + 1));
    if (!held->room)
        PyErr_NoMemory();
    return held->room;
}

int has_size(const Array *array, int axis, Py_ssize_t size, int may_be_one)
{
    Py_ssize_t found = array->size[axis];
    if (found == size || (may_be_one && found == 1))
        return 0;
    PyErr_Format(PyExc_ValueError, "axis %d has %zd numbers instead of %zd", axis, found, size);
    return -1;
}

void release(Held *held)
{
    while (held->held)
        PyBuffer_Release(&held->arrays[--held->held].buffer);
    free(held->room);
    held->room = NULL;
}

static void free_plan(Plan *plan)
{
    if (!plan)
        return;
    for (Py_ssize_t k = 0; k < plan->integer_arrays; k++)
        free(plan->integers[k]);
    for (Py_ssize_t k = 0; k < plan->number_arrays; k++)
        free(plan->numbers[k]);
    free(plan->integers);
    free(plan->numbers);
    free(plan->integer_sizes);
    free(plan->number_sizes);
    free(plan);
}

static void free_capsule(PyObject *capsule)
{
    free_plan(PyCapsule_GetPointer(capsule, PLAN));
}

const Plan *plan_of(PyObject *capsule, const PlanKind *kind)
{
    const Plan *plan = PyCapsule_GetPointer(capsule, PLAN);
    if (plan && plan->kind != kind) {
        PyErr_Format(PyExc_ValueError, "this is no plan of %s but of %s", kind->name,
                     plan->kind->name);
        return NULL;
    }
    return plan;
}

/* Copy a sequence of flat arrays whose items are 8 bytes of a format. */
static int copy(PyObject *sequence, const char *formats, void ***arrays, Py_ssize_t **sizes,
                Py_ssize_t *count)
{
    Py_ssize_t length = PySequence_Size(sequence);
    if (length < 0)
        return -1;
    *arrays = calloc(length + 1, sizeof(void *));
    *sizes = calloc(length + 1, sizeof(Py_ssize_t));
    if (!*arrays || !*sizes) {
        PyErr_NoMemory();
        return -1;
    }
    for (Py_ssize_t k = 0; k < length; k++) {
        Py_buffer buffer;
        PyObject *item = PySequence_GetItem(sequence, k);
        if (!item)
            return -1;
        int failed = PyObject_GetBuffer(item, &buffer, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT);
        Py_DECREF(item);
        if (failed < 0)
            return -1;
        if (buffer.itemsize != 8 || !strchr(formats, buffer.format[0]) || buffer.format[1]) {
            PyBuffer_Release(&buffer);
            PyErr_Format(PyExc_TypeError, "array %zd of a plan has another type", k);
            return -1;
        }
        (*arrays)[k] = malloc(buffer.len + 8);
        if (!(*arrays)[k]) {
            PyBuffer_Release(&buffer);
            PyErr_NoMemory();
            return -1;
        }
        memcpy((*arrays)[k], buffer.buf, buffer.len);
        (*sizes)[k] = buffer.len / 8;
        *count = k + 1;
        PyBuffer_Release(&buffer);
    }
    return 0;
}

static const PlanKind *kind_of(PyObject *name)
{
#define KIND(name) &name##_plan,
    static const PlanKind *const kinds[] = {EVERY_PLAN(KIND)};
#undef KIND
    for (size_t k = 0; k < sizeof(kinds) / sizeof(kinds[0]); k++)
        if (PyUnicode_Check(name) && PyUnicode_CompareWithASCIIString(name, kinds[k]->name) == 0)
            return kinds[k];
    PyErr_Format(PyExc_ValueError, "there are no plans of %R", name);
    return NULL;
}

/* plan(what it is of, arrays of integers, arrays of numbers) */
static PyObject *plan(PyObject *module, Arguments given, Py_ssize_t nargs)
{
    (void)module;
    EXACTLY(nargs, 3)
    const PlanKind *kind = kind_of(given[0]);
    if (!kind)
        return NULL;
    Plan *made = calloc(1, sizeof(Plan));
    if (!made)
        return PyErr_NoMemory();
    made->kind = kind;
    if (copy(given[1], "lq", (void ***)&made->integers, &made->integer_sizes,
             &made->integer_arrays) < 0 ||
        copy(given[2], "d", (void ***)&made->numbers, &made->number_sizes, &made->number_arrays) <
            0) {
        free_plan(made);
        return NULL;
    }
    if (made->integer_arrays != kind->integer_arrays ||
        made->number_arrays != kind->number_arrays || !kind->fits(made)) {
        PyErr_Format(PyExc_ValueError, "the arrays of a plan of %s do not fit", kind->name);
        free_plan(made);
        return NULL;
    }
    PyObject *capsule = PyCapsule_New(made, PLAN, free_capsule);
    if (!capsule)
        free_plan(made);
    return capsule;
}

#define FUNCTION(name) {#name, (PyCFunction)(void (*)(void))name, METH_FASTCALL, NULL},

static PyMethodDef functions[] = {
    FUNCTION(plan)
    EVERY_FUNCTION(FUNCTION)
    {NULL, NULL, 0, NULL},
};

/* Say of what sources the module was made. */
static int execute(PyObject *module)
{
    PyObject *sources = PyLong_FromLongLong(SOURCES);
    int failed = sources ? PyObject_SetAttrString(module, "sources", sources) : -1;
    Py_XDECREF(sources);
    return failed;
}

static PyModuleDef_Slot slots[] = {{Py_mod_exec, (void *)execute}, {0, NULL}};

static PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_kernel", NULL, 0, functions, slots, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__kernel(void)
{
    return PyModuleDef_Init(&definition);
}
