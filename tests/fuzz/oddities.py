"""Oddities: code for values that hardly any argument may have."""

from __future__ import annotations

from random import Random

import numpy as np

ODD = (
    *("None", "True", "False", "''", "'x'", "'bearing_in'", "b'bytes'", "1j", "float('nan')"),
    *("float('inf')", "-float('inf')", "1e308", "-1e308"),
    *("1e-320", "10**400", "-10**400", "0", "-1"),
    *("2.5", "[]", "()", "{}", "set()", "{1, 2}", "{'a'}", "frozenset('ab')", "[None]", "['a']"),
    *("[[1.0]]", "[[1.0, 2.0], [3.0]]", "[1, [2, [3]]]", "[float('nan')]", "[1.0, 'x']", "[1j]"),
    *("{1: 2}", "{None: 1.0}", "{('a',): 1.0}", "{'x': 1.0}", "{b'a': 1.0}", "{1.5: [1.0]}"),
    *("np.array([])", "np.array('a')", "np.array(['a', 'b'])", "np.array([1, None], object)"),
    *("np.zeros((2, 3))", "np.zeros((3, 0))", "np.zeros((1, 1, 1, 1))", "np.array([1 + 1j])"),
    *("np.array([True, False])", "np.float32(0.5)", "np.float16(6e4)", "np.longdouble('1e4000')"),
    *("np.array([[1.0], [2.0]], object)", "np.datetime64('2001-01-01')", "np.timedelta64(3, 's')"),
    *("np.ma.masked_array([1.0, 2.0], [0, 1])", "np.rec.array([(1, 2)])"),
    *("np.array(0.3)", "np.uint8(255)", "np.arange(6.0)[::-2]", "np.int64(-2**63)", "np.str_('x')"),
    *("(value for value in [0.0, 0.1])", "iter(['a'])", "range(3)", "range(10**4)", "lambda: 0"),
    *("Path('/nowhere/x')", "Path('.')", "object()", "Ellipsis", "NotImplemented", "type", "cd"),
    *("slice(3)", "memoryview(b'ab')", "bytearray(b'a')", "decimal.Decimal('0.1')", "Exploding()"),
    *("fractions.Fraction(1, 3)", "datetime.date(2001, 1, 1)", "Number()", "Liar()", "Unequal()"),
    *("cd.Wrench()", "cd.Wrench('a', None, 3)", "cd.CardanError('x')", "scene", "mechanism('arm')"),
    *("np.broadcast_to(0.0, (10**4,))", "[[]]", "[[], []]"),
    *("np.nan", "'\\ud800'", "'\\x00'", "'a' * 9999"),
    *("dict.fromkeys('ab', 1.0)", "map(str, [1])"),
    *("np.full(3, 1e200)", "np.full(3, np.inf)", "[0.0] * 6"),
    *("[1e308] * 6", "np.eye(6)", "-np.eye(6)", "np.eye(6) * 1e200", "np.full((6, 6), np.nan)"),
)


class Exploding:
    """Raises whenever it is looked at."""

    def __getattr__(self, name: str) -> object:
        raise ValueError(name)

    def __iter__(self) -> object:
        raise ValueError("not to be iterated")

    def __array__(self, *arguments: object, **options: object) -> np.ndarray:
        raise ValueError("no array")


class Number:
    """Is a number in the way of Python's protocols alone."""

    def __float__(self) -> float:
        return 0.25

    def __index__(self) -> int:
        return 2


class Liar:
    """Promises a length that it does not have."""

    def __len__(self) -> int:
        return 3

    def __getitem__(self, index: object) -> float:
        raise IndexError(index)


class Unequal:
    """Can neither be compared nor hashed."""

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        raise ValueError("not to be compared")


CLASSES = (Exploding, Number, Liar, Unequal)
"""What the code refers to by name."""


def odd(rng: Random) -> str:
    """Return code for something that hardly any argument may be."""
    code = rng.choice(ODD)
    action = rng.random()
    if action < 0.06:
        return f"[{code}, {rng.choice(ODD)}]"
    if action < 0.09:
        return f"({code},)"
    if action < 0.11:
        return f"np.array([{rng.choice(['1.0', '2'])}, {code}], object)"
    return code
