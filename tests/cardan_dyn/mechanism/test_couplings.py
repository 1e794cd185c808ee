"""Couplings: which coordinates they couple, and the zero that mimics ask for."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import coupling, gears

import cardan_dyn as cd
from cardan_dyn.core.mechanism.welds import shown


def mimicking(*mimics: str) -> cd.Mechanism:
    """Wheels a, b, c on a base; the last ones mimic others."""
    wheels = "".join(
        f'<link name="wheel_{name}"/><joint name="{name}" type="continuous"><parent link="base"/>'
        f'<child link="wheel_{name}"/><axis xyz="0 0 1"/>{mimic}</joint>'
        for name, mimic in zip("abc", ("", *mimics), strict=True)
    )
    return cd.load(f'<robot name="wheels"><link name="base"/>{wheels}</robot>')


def test_couplings_of_links_count_the_joints_between_them() -> None:
    mechanism = cd.load(gears(coupling("ab", "a", "b", 2.0)))
    (item,) = mechanism.couplings
    columns = mechanism.coordinates.velocity_columns
    assert item.predecessor_columns == (columns["a"].start,)
    assert item.successor_columns == (columns["b"].start,)
    assert (item.ratio, item.offset) == (2.0, 0.0)
    assert shown(item) == "ab: ratio 2"


def test_zero_is_where_mimics_are_satisfied() -> None:
    """Also where a joint mimics one that mimics another itself, further below in the file."""
    mechanism = mimicking(
        '<mimic joint="c" multiplier="3" offset="0.5"/>',
        '<mimic joint="a" multiplier="2" offset="-0.25"/>',
    )
    x = mechanism.zero
    a, b, c = (x[mechanism.coordinates.columns[name].start] for name in "abc")
    assert (a, b, c) == (0.0, 3.0 * -0.25 + 0.5, -0.25)
    np.testing.assert_array_equal(cd.load("four_bar").zero, np.zeros(4))
    with pytest.raises(ValueError, match="read-only"):
        x[0] = 1.0
