/* The module: its functions, and of what sources it was made. */

#include "kernels.h"

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
