"""Workspaces: borders against circles, straight lines and lengths by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from testkit import task_machines as machines
from testkit import transmissions

import cardan_dyn as cd
from cardan_dyn.kit.arrays import Array

pytestmark = pytest.mark.usefixtures("loaded_once")

ROWS = {"load.x": (-0.6, 0.6), "load.y": (-0.6, 0.6)}
BASES, PROXIMAL, DISTAL = np.array([[-0.1, 0.0], [0.1, 0.0]]), 0.2, 0.25


def task_scene(mechanism: cd.Mechanism, **arguments: Any) -> cd.TaskScene:
    scene = cd.Scene(mechanism, **arguments)
    assert isinstance(scene, cd.TaskScene)
    return scene


def five_bar_scene() -> cd.TaskScene:
    return task_scene(
        cd.load(machines.five_bar()),
        task=cd.PointTask("load", axes="xy"),
        actuated=["m1", "m2"],
        near=machines.five_bar_start(),
    )


@pytest.fixture(scope="module")
def five_bar() -> cd.Workspace:
    scene = five_bar_scene()
    return scene.workspace(ROWS, condition=20.0, every_mode=True, samples=33)


def elbows(points: Array, sides: tuple[float, float]) -> Array:
    """Where both elbows `(N, 2, 2)` are, to the left of the way from base to tip, or the right."""
    ways = points[:, None] - BASES
    length = np.linalg.norm(ways, axis=-1, keepdims=True)
    along = (length**2 + PROXIMAL**2 - DISTAL**2) / (2.0 * length)
    across = np.sqrt(np.maximum(PROXIMAL**2 - along**2, 0.0)) * np.reshape(sides, (2, 1))
    left = ways[..., ::-1] * [-1.0, 1.0]
    return np.asarray(BASES + (along * ways + across * left) / length)


def motors_by_tip(points: Array, sides: tuple[float, float]) -> tuple[Array, Array]:
    """Numerators `(N, 2, 2)` and denominators `(N, 2)` of ∂motors/∂tip: rods keep their lengths."""
    at = elbows(points, sides)
    rods, cranks = points[:, None] - at, at - BASES
    return rods, rods[..., 1] * cranks[..., 0] - rods[..., 0] * cranks[..., 1]


def condition(points: Array, sides: tuple[float, float]) -> Array:
    rods, across = motors_by_tip(points, sides)
    sizes = np.linalg.svd(rods / across[..., None], compute_uv=False)
    return np.asarray(sizes[:, 0] / sizes[:, 1])


def sides_of(points: Array) -> tuple[float, float]:
    """Which of the four modes a section is, told by where its curves of the second kind lie."""
    every = [(a, b) for a in (1.0, -1.0) for b in (1.0, -1.0)]
    off = [np.max(np.abs(np.linalg.det(motors_by_tip(points, sides)[0]))) for sides in every]
    return every[int(np.argmin(off))]


def test_places_near_the_end_of_reach_are_of_their_own_working_mode() -> None:
    """Of a grid this coarse, Newton's method leads some of its edges to the mode beside it."""
    coarse = five_bar_scene().workspace(ROWS, condition=20.0, every_mode=True, samples=21)
    for section in coarse.sections:
        sides = sides_of(section.border("hold"))
        found = condition(section.border("condition"), sides)
        assert len(found) > 10
        np.testing.assert_allclose(found, 20.0, rtol=1e-12)


def test_five_bar_reaches_between_circles(five_bar: cd.Workspace) -> None:
    nodes = np.stack(np.meshgrid(*five_bar.grid, indexing="ij"), axis=-1)
    away = np.linalg.norm(nodes[..., None, :] - BASES, axis=-1)
    inside = np.all((away > DISTAL - PROXIMAL) & (away < DISTAL + PROXIMAL), axis=-1)
    assert [section.mode for section in five_bar.sections] == ["A", "B", "C", "D"]
    for section in five_bar.sections:
        assert np.array_equal(section.reached, inside)
        reach = section.border("reach")
        away = np.linalg.norm(reach[:, None] - BASES, axis=-1)
        circles = np.stack([away - DISTAL - PROXIMAL, away - DISTAL + PROXIMAL])
        assert np.max(np.min(np.abs(circles), axis=(0, 2))) < 1e-13
        crossed = sum(np.sum(np.diff(inside.astype(int), axis=axis) != 0) for axis in (0, 1))
        closed = [item for item in section.borders if item.kind == "reach"]
        assert all(item.is_exact for item in closed)
        assert all(np.array_equal(item.position[0], item.position[-1]) for item in closed)
        assert len(reach) - len(closed) == crossed


def test_five_bar_loses_hold_where_rods_are_in_line(five_bar: cd.Workspace) -> None:
    nodes = np.stack(np.meshgrid(*five_bar.grid, indexing="ij"), axis=-1)
    found = set()
    for section in five_bar.sections:
        hold = section.border("hold")
        sides = sides_of(hold)
        found.add(sides)
        rods, _ = motors_by_tip(hold, sides)
        assert np.max(np.abs(np.linalg.det(rods))) < 1e-14
        # No edge of the grid that is crossed is left out.
        rods, _ = motors_by_tip(nodes.reshape(-1, 2), sides)
        sign = np.where(section.reached, np.sign(np.linalg.det(rods)).reshape(33, 33), np.nan)
        crossed = sum(np.sum(np.diff(sign, axis=axis) ** 2 == 4.0) for axis in (0, 1))
        points = np.unique(hold, axis=0)
        assert len(points) == crossed >= 10
        # What is usable lies on one side, and keeps the bound.
        assert len(np.unique(sign[section.usable])) == 1
        assert np.max(condition(nodes[section.usable], sides)) < 20.0
        assert condition(section.border("condition"), sides) == pytest.approx(20.0, rel=1e-10)
    assert len(found) == 4


def limited(text: str, limits: dict[str, tuple[float, float]]) -> cd.Mechanism:
    for name, (low, high) in limits.items():
        start = text.index("</joint>", text.index(f'<joint name="{name}"'))
        limit = f'<limit lower="{low}" upper="{high}" velocity="1" effort="1"/>'
        text = text[:start] + limit + text[start:]
    return cd.load(text)


def test_excavator_by_strokes_of_its_cylinders() -> None:
    """With a cylinder at its end, the stick's tip is on a circle by the law of cosines."""
    strokes = {"boom_cylinder": (-0.3, 0.4), "stick_cylinder": (-0.25, 0.35)}
    tip = machines.BUCKET_PIN - machines.STICK_PIN
    scene = task_scene(
        limited(machines.excavator(), strokes),
        task=[cd.PointTask("stick", tip, axes="xz"), "bucket_cylinder"],
        actuated=machines.CYLINDERS,
    )
    ranges = {"stick.x": (1.0, 8.0), "stick.z": (-4.0, 6.0)}
    workspace = scene.workspace(ranges, samples=25)
    (section,) = workspace.sections
    reached = section.border("limit", "boom_cylinder")[:, None] - [
        boom_pin(machines.LENGTHS[0] + stroke) for stroke in strokes["boom_cylinder"]
    ]
    off = np.abs(np.linalg.norm(reached, axis=-1) - np.linalg.norm(tip))
    assert len(off) > 20 and np.max(np.min(off, axis=1)) < 1e-12
    away = np.linalg.norm(section.border("limit", "stick_cylinder"), axis=-1)
    far = [stick_reach(machines.LENGTHS[1] + stroke) for stroke in strokes["stick_cylinder"]]
    off = np.abs(away[:, None] - far)
    assert len(off) > 20 and np.max(np.min(off, axis=1)) < 1e-12
    nodes = np.stack(np.meshgrid(*workspace.grid, indexing="ij"), axis=-1)
    away = np.linalg.norm(nodes[section.usable], axis=-1)
    assert min(far) < np.min(away) and np.max(away) < max(far)


def angle(a: Array, b: Array) -> float:
    """From a to b in the plane x z."""
    return float(np.arctan2(a[0] * b[2] - a[2] * b[0], a @ b))


def boom_pin(length: float) -> Array:
    """Where the stick's pin `(2,)` is while the boom's cylinder is so long."""
    base, head, pin = machines.BOOM_BASE, machines.BOOM_HEAD, machines.STICK_PIN
    a, b = np.linalg.norm(base), np.linalg.norm(head)
    turn = np.arccos((a**2 + b**2 - length**2) / (2 * a * b)) + angle(head, pin)
    start = np.arctan2(base[2], base[0])
    far = np.linalg.norm(pin)
    return np.asarray(far * np.array([np.cos(start + turn), np.sin(start + turn)]))


def stick_reach(length: float) -> float:
    """How far the bucket's pin is from the boom's foot while the stick's cylinder is so long."""
    pin = machines.STICK_PIN
    base, head = machines.STICK_BASE - pin, machines.STICK_HEAD - pin
    tip, foot = machines.BUCKET_PIN - pin, machines.FOOT - pin
    a, b = np.linalg.norm(base), np.linalg.norm(head)
    closed = np.arccos((a**2 + b**2 - length**2) / (2 * a * b)) * np.sign(angle(base, head))
    between = angle(foot, base) + closed + angle(head, tip)
    c, d = np.linalg.norm(foot), np.linalg.norm(tip)
    return float(np.sqrt(c**2 + d**2 - 2 * c * d * np.cos(between)))


def test_stewart_by_lengths_of_its_legs() -> None:
    """Sections with the platform turned about the vertical: legs come to their ends on spheres."""
    strokes = dict.fromkeys(machines.LEGS, (-0.1, 0.15))
    mechanism = limited(machines.stewart(), strokes)
    scene = task_scene(mechanism, task=cd.PoseTask("platform"), actuated=machines.LEGS)
    ranges = {"platform.x": (-0.5, 0.5), "platform.z": (0.3, 0.9)}
    at: dict[str, ArrayLike] = {"platform.y": 0.05, "platform.turn_z": [0.0, 0.3]}
    workspace = scene.workspace(ranges, at, samples=13)
    assert [section.at["platform.turn_z"] for section in workspace.sections] == [0.0, 0.3]
    for section in workspace.sections:
        turned = section.at["platform.turn_z"]
        turn = np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
        heads = np.column_stack([machines.HEADS[:, :2] @ turn.T, np.zeros(6)])
        assert {item.kind for item in section.borders} == {"limit"}
        assert np.any(section.usable) and not np.all(section.usable)
        for leg, name in enumerate(machines.LEGS):
            points = section.border("limit", name)
            assert len(points) > 4
            place = np.column_stack([points[:, 0], np.full(len(points), 0.05), points[:, 1]])
            length = np.linalg.norm(place + heads[leg] - machines.FEET[leg], axis=1)
            off = np.abs(length[:, None] - machines.LEG_LENGTHS[leg] - strokes[name])
            assert np.max(np.min(off, axis=1)) < 1e-13
    with pytest.raises(cd.ArgumentError, match=r"platform\.turn_x .*rotation vector"):
        scene.workspace({"platform.x": (0.0, 1.0), "platform.turn_x": (0.0, 1.0)})


def test_ankle_by_limits_of_its_motors() -> None:
    """A transmission: motors by the form by hand where they come to their limits."""
    motors = ["left_motor", "right_motor"]
    scene = cd.Scene(cd.load(transmissions.ankle()), drive=motors)
    maps = scene.transmission(motors, ["pitch", "roll"])
    workspace = maps.workspace({"pitch": (-0.6, 0.6), "roll": (-0.5, 0.5)}, samples=21)
    (section,) = workspace.sections
    for number, name in enumerate(motors):
        points = section.border("limit", name)
        found = transmissions.ankle_motors(*points.T)[number]
        assert len(points) > 10
        assert np.abs(found) == pytest.approx(0.4, abs=1e-12)
    nodes = np.stack(np.meshgrid(*workspace.grid, indexing="ij"), axis=-1)[section.usable]
    assert np.max(np.abs(transmissions.ankle_motors(*nodes.T))) < 0.4
    assert np.max(np.abs(nodes[:, 0])) < 0.3 and np.max(np.abs(nodes[:, 1])) < 0.2


def test_figure(five_bar: cd.Workspace) -> None:
    pytest.importorskip("matplotlib", reason="figures need matplotlib")
    from testkit.drawings import check_texts

    figure = five_bar.plot(title="A five-bar")
    check_texts(figure)
    assert [panel.get_title() for panel in figure.axes] == [f"mode {mode}" for mode in "ABCD"]
    told = {text.get_text() for text in figure.legends[0].get_texts()}
    assert told == {"end of reach", "motors lose hold", "condition bound"}
    alone = cd.Workspace(
        five_bar.names, five_bar.units, five_bar.grid, five_bar.sections[:1]
    ).plot()
    check_texts(alone)
    drawn = np.concatenate([line.get_xydata() for line in figure.axes[0].get_lines()])
    assert len(drawn) == sum(len(item.position) for item in five_bar.sections[0].borders)


def test_refusals() -> None:
    scene = five_bar_scene()
    for ranges, told in (
        ({"load.x": (0.0, 0.1)}, "names 1 coordinates"),
        ({"load.x": (0.0, 0.1), "m1": (0.0, 0.1)}, r"'m1' is none of"),
        ({"load.x": (0.1, 0.1), "load.y": (0.0, 0.1)}, "is no range"),
    ):
        with pytest.raises(cd.ArgumentError, match=told):
            scene.workspace(ranges)
    with pytest.raises(cd.ArgumentError, match="or is in both"):
        scene.workspace(ROWS, {"load.x": 0.1})
    with pytest.raises(cd.AssemblyError, match=r"nothing of load\.x 1 to 2"):
        scene.workspace({"load.x": (1.0, 2.0), "load.y": (1.0, 2.0)}, samples=3)
