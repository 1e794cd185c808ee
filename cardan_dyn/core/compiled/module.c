/* The module: its functions, and how arrays come in. */

#include "kernels.h"

const Py_buffer *take(Taken **held, PyObject *object, char type, int flags)
{
    const Py_ssize_t size = type == 'd' ? 8 : 4;
    Taken *taken = malloc(sizeof(Taken));
    if (!taken) {
        PyErr_NoMemory();
        return NULL;
    }
    const Py_buffer *buffer = &taken->buffer;
    if (PyObject_GetBuffer(object, &taken->buffer, flags | PyBUF_FORMAT) < 0) {
        free(taken);
        return NULL;
    }
    taken->next = *held;
    *held = taken;
    /* Where a long has 32 bits, they are told by its letter. */
    const char *format = buffer->format;
    const int has_type = format[0] == type || (type == 'i' && format[0] == 'l');
    if (!has_type || format[1] || buffer->itemsize != size)
        PyErr_Format(PyExc_TypeError, "an array of %s is needed",
                     type == 'd' ? "numbers" : "32-bit integers");
    else if ((uintptr_t)buffer->buf % size)
        PyErr_SetString(PyExc_ValueError, "numbers of an array lie across their boundaries");
    else
        return buffer;
    return NULL;
}

void *take_all(Taken **held, PyObject *object, char type, int flags, Py_ssize_t count)
{
    const Py_buffer *buffer = take(held, object, type, PyBUF_C_CONTIGUOUS | flags);
    if (!buffer)
        return NULL;
    if (buffer->len / buffer->itemsize != count) {
        PyErr_Format(PyExc_ValueError, "%zd numbers are needed, not %zd", count,
                     buffer->len / buffer->itemsize);
        return NULL;
    }
    return buffer->buf;
}

void release(Taken **held)
{
    while (*held) {
        Taken *next = (*held)->next;
        PyBuffer_Release(&(*held)->buffer);
        free(*held);
        *held = next;
    }
}

#define FUNCTION(name) {#name, (PyCFunction)(void (*)(void))name, METH_FASTCALL, NULL},

static PyMethodDef functions[] = {
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
