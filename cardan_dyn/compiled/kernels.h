/* The functions of the module; each is described where it is written. */

#ifndef CARDAN_DYN_KERNELS_H
#define CARDAN_DYN_KERNELS_H

#include "arrays.h"

PyObject *against_load(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *all_finite(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *exerted(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *inverse(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *magnified(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *reactions(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *refined(PyObject *module, Arguments given, Py_ssize_t nargs);

#endif
