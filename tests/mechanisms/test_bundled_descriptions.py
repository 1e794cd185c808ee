"""What holds for every bundled description: inertias from the visuals, closed at zero, loadable."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from testkit.urdf_reader import URDF, Body, Reader, text

import cardan_dyn as cd

NAMES = sorted(path.stem for path in Path(URDF).glob("*.urdf"))
NEW = {
    "double_shaft_spatial",
    "double_shaft_w",
    "drive_line",
    "elastic_double_shaft",
    "elastic_thoma_rig",
    "four_bar",
    "needle_drive",
    "ring_joint",
    "slider_crank",
    "stewart_platform",
    "thoma_rig",
    "torsional_line_behind",
    "torsional_line_both",
    "torsional_line_front",
}


def test_descriptions_are_there() -> None:
    assert set(NAMES) >= NEW | {"universal_joint", "double_shaft_z"}


@pytest.mark.parametrize("name", NAMES)
def test_inertias_follow_from_the_visuals(name: str) -> None:
    """Every link is the sum of its visual primitives in steel, to all digits in the file."""
    reader = Reader(text(name))
    joints = reader.robot.findall("joint")
    behind = {
        joint.find("child").get("link")  # type: ignore[union-attr]
        for joint in joints
        if joint.get("adjustable")
    }
    for link in reader.links():
        visuals, given = reader.primitives(link), reader.body(link)
        if link in behind and given is None:
            # Links behind adjustable joints are places, not parts.
            assert not visuals
            continue
        assert visuals, f"{link} shows nothing"
        if given is None:
            assert all(visual.startswith("massless_") for visual in visuals), link
            continue
        assert not any(visual.startswith("massless_") for visual in visuals), link
        total: Body | None = None
        for body in visuals.values():
            total = body if total is None else total + body
        assert total is not None
        # Some files state twelve decimals, so absolute errors of 5e-13 are none.
        scale = np.max(np.abs(total.inertia))
        assert given.mass == pytest.approx(total.mass, rel=1e-11, abs=1e-12), link
        np.testing.assert_allclose(given.centre, total.centre, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(
            given.inertia, total.inertia, rtol=0.0, atol=1e-11 * scale + 6e-13
        )
        assert given.mass > 0.0 and np.min(np.linalg.eigvalsh(given.inertia)) > 0.0


@pytest.mark.parametrize("name", NAMES)
def test_loops_are_closed_at_zero(name: str) -> None:
    """Both frames of each loop coincide with all tree coordinates at zero: its own is zero too."""
    reader = Reader(text(name))
    loops = [loop.get("name", "") for loop in reader.robot.findall("loop")]
    assert loops
    for loop in loops:
        (axes_1, origin_1), (axes_2, origin_2) = reader.loop_placements(loop)
        np.testing.assert_allclose(origin_1, origin_2, rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(axes_1, axes_2, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("name", NAMES)
def test_header_says_where_the_numbers_come_from(name: str) -> None:
    comment = text(name).split("-->")[0]
    assert max(map(len, comment.splitlines())) <= 100
    running = " ".join(comment.split())
    for words in ("World:", "Inertia:", "7850 kg/m³", "Representative dimensions"):
        assert words in running, words


@pytest.mark.parametrize("name", NAMES)
def test_library_reads_the_same_bodies(name: str) -> None:
    """Total mass of what moves, and every joint and loop by its name."""
    reader = Reader(text(name))
    mechanism = cd.load(name)
    joints = [
        joint.get("name") for joint in reader.robot.findall("joint") if joint.get("type") != "fixed"
    ]
    loops = [loop.get("name") for loop in reader.robot.findall("loop")]
    assert mechanism.joint_names[len(joints) :] == loops
    assert sorted(mechanism.joint_names[: len(joints)]) == sorted(joints)
    (root,) = (
        link
        for link in reader.links()
        if link not in {_child(j) for j in reader.robot.iter("joint")}
    )
    moving = sum(
        body.mass for link in reader.links() if link != root and (body := reader.body(link))
    )
    computed = sum(inertia.mass for inertia in list(mechanism.model.inertias)[1:])
    assert computed == pytest.approx(moving, rel=1e-12)


def _child(joint: object) -> str:
    return joint.find("child").get("link")  # type: ignore[attr-defined]
