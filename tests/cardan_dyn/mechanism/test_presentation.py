"""What a mechanism shows of itself, and the zero that it is written with."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from testkit.many_drives import COUPLER, linkage

import cardan_dyn as cd


def unclosed() -> cd.Mechanism:
    """A linkage whose coupler is 5 mm too long for its zero."""
    text = f'<robot name="linkage"><link name="base"/>{linkage(0, "base")}</robot>'
    end = '<origin xyz="{} 0 0"/>'
    return cd.load(text.replace(end.format(COUPLER), end.format(COUPLER + 0.005)))


def test_it_shows_itself() -> None:
    mechanism = cd.load("four_bar")
    assert repr(mechanism) == "<Mechanism 'four_bar': 4 joints, loops: rocker_pin>"
    html = mechanism._repr_html_()
    assert "crank_bearing: continuous" in html
    assert "0.4 m" in html


@pytest.mark.parametrize("suffix", [".urdf", ".xml"])
def test_an_open_zero_is_written_assembled(tmp_path: Path, suffix: str) -> None:
    mechanism = unclosed()
    assembled = cd.assemble(mechanism)
    again = cd.load(cd.write(mechanism, tmp_path / f"linkage{suffix}"), strict=False)
    zero = cd.assemble(again)
    assert zero.zero_residual < 1e-12 < assembled.zero_residual
    for joint in ("crank_0", "middle_0", "rocker_0"):
        np.testing.assert_allclose(zero.origin(joint), assembled.origin(joint), atol=1e-12)


def test_a_closed_zero_is_written_as_it_is(tmp_path: Path) -> None:
    mechanism = cd.load("four_bar")
    again = cd.load(cd.write(mechanism, tmp_path / "again.urdf"))
    assert again.description == cd.load(mechanism.to_urdf()).description


def test_what_cannot_be_assembled_is_refused(tmp_path: Path) -> None:
    mechanism = cd.load(unclosed().to_urdf().replace(repr(COUPLER + 0.005), "9.0"))
    with pytest.raises(cd.AssemblyError):
        cd.write(mechanism, tmp_path / "linkage.urdf")
