"""Scalars: functions of floats, NumPy arrays and traced variables alike, also of both at once.

Arrays are left to NumPy, whose warnings apply. A float gives a float, mostly without NumPy, which
takes ten times as long for one number.
"""

from __future__ import annotations

import math

import numpy as np

from .operations import ON_ARRAYS
from .trace import Scalar, Variable, trace_of


def sin(x: Scalar) -> Scalar:
    """Return the sine of an angle [rad]; NaN of infinite ones."""
    if type(x) is float:
        return math.sin(x) if x - x == 0.0 else math.nan
    return _function("sin", x)


def cos(x: Scalar) -> Scalar:
    """Return the cosine of an angle [rad]; NaN of infinite ones."""
    if type(x) is float:
        return math.cos(x) if x - x == 0.0 else math.nan
    return _function("cos", x)


def sqrt(x: Scalar) -> Scalar:
    """Return the square root; NaN of negative numbers, -0.0 of -0.0."""
    if type(x) is float:
        return math.sqrt(x) if x >= 0.0 else math.nan
    return _function("sqrt", x)


def absolute(x: Scalar) -> Scalar:
    """Return the absolute value."""
    return abs(x) if type(x) is float else _function("absolute", x)


def exp(x: Scalar) -> Scalar:
    """Return the exponential."""
    return _function("exp", x)


def log(x: Scalar) -> Scalar:
    """Return the natural logarithm; NaN of negative numbers."""
    return _function("log", x)


def tanh(x: Scalar) -> Scalar:
    """Return the hyperbolic tangent."""
    return _function("tanh", x)


def arctan2(y: Scalar, x: Scalar) -> Scalar:
    """Return the angle of the point (x, y) from the axis of x, in [-π, π] [rad]."""
    trace = trace_of(y, x)
    return _on_numbers("arctan2", y, x) if trace is None else trace.arctan2(y, x)


def greater(a: Scalar, b: Scalar) -> Scalar:
    """Return the greater of two; NaN if one is NaN. Of two zeros it may be either."""
    if type(a) is float and type(b) is float:
        return a if a > b or a != a else b
    if type(a) is Variable or type(b) is Variable:
        return (a if type(a) is Variable else b).trace.extreme("greater", a, b)
    return _on_numbers("greater", a, b)


def smaller(a: Scalar, b: Scalar) -> Scalar:
    """Return the smaller of two; NaN if one is NaN. Of two zeros it may be either."""
    if type(a) is float and type(b) is float:
        return a if a < b or a != a else b
    if type(a) is Variable or type(b) is Variable:
        return (a if type(a) is Variable else b).trace.extreme("smaller", a, b)
    return _on_numbers("smaller", a, b)


def select(condition: Scalar, a: Scalar, b: Scalar) -> Scalar:
    """Return a where the condition is above 0, else b: also where the condition is NaN.

    Both are computed; what is not chosen may be NaN.
    """
    if type(condition) is float and type(a) is float and type(b) is float:
        return a if condition > 0.0 else b
    trace = trace_of(condition, a, b)
    if trace is None:
        return _on_numbers("select", condition, a, b)
    return trace.select(condition, a, b)


def _function(operation: str, x: Scalar) -> Scalar:
    if type(x) is Variable:
        return x.trace.function(operation, x)
    return _on_numbers(operation, x)


def _on_numbers(operation: str, *numbers: Scalar) -> Scalar:
    values = ON_ARRAYS[operation](*numbers)
    return values if type(values) is np.ndarray and values.ndim else float(values)
