/* The functions of the module; each is described where it is written. */

#ifndef CARDAN_DYN_KERNELS_H
#define CARDAN_DYN_KERNELS_H

#include "arrays.h"

PyObject *branch(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *cancellation(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *closure(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *lattice(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *longest(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *moved(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *newton_step(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *passive_accelerations(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *passive_rates(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *proven(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *refined(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *rows(PyObject *module, Arguments given, Py_ssize_t nargs);
PyObject *within(PyObject *module, Arguments given, Py_ssize_t nargs);

#endif
