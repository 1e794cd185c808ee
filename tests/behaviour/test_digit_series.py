"""Machines described with four to sixteen digits: they move as their exact numbers say."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from testkit.hinge_loops import Hinge, bennett, hinge, origin, planar, spherical

import cardan_dyn as cd

DIGITS = range(4, 17)
GRAVITY = (0.3, -0.2, -9.81)
MASS = (
    '<inertial><origin xyz="0.1 0.05 -0.02"/><mass value="1.3"/>'
    '<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial>'
)
TURN = Rotation.from_rotvec([0.31, -0.52, 0.43])
"""Machines stand askew, so that all of their numbers are rounded."""


class Joint(NamedTuple):
    """A joint in the world, of a type, between two links."""

    parent: str
    child: str
    at: Hinge
    kind: str = "continuous"


class Machine(NamedTuple):
    """A machine.

    Attributes:
        joints, loops: name to joint.
        drives: names of driven ones.
        massless: names of links.
    """

    joints: dict[str, Joint]
    loops: dict[str, Joint]
    drives: list[str]
    massless: tuple[str, ...] = ()

    def text(self) -> str:
        """Return a URDF+ with all digits, each link in the frame of the joint that carries it."""
        frames, parts = {"ground": np.eye(4)}, ['<link name="ground"/>']
        for name, item in self.joints.items():
            frames[item.child] = frame = item.at.frame
            placed = origin(np.linalg.solve(frames[item.parent], frame))
            mass = "" if item.child in self.massless else MASS
            parts.append(
                f'<link name="{item.child}">{mass}</link><joint name="{name}" type="{item.kind}">'
                f'<parent link="{item.parent}"/><child link="{item.child}"/>{placed}'
                '<axis xyz="0 0 1"/></joint>'
            )
        for name, item in self.loops.items():
            sides = "".join(
                f'<{side} link="{link}">{origin(np.linalg.solve(frames[link], item.at.frame))}'
                f"</{side}>"
                for side, link in (("predecessor", item.parent), ("successor", item.child))
            )
            parts.append(
                f'<loop name="{name}" type="{item.kind}">{sides}<axis xyz="0 0 1"/></loop>'
            )
        return f'<robot name="m">{"".join(parts)}</robot>'


def askew(point: object, direction: object = (0.0, 0.0, 1.0)) -> Hinge:
    return hinge(TURN.apply(point) + np.array([0.123, 0.0457, -0.211]), TURN.apply(direction))


def one_loop(hinges: list[Hinge]) -> Machine:
    links = ["ground", *(f"l{k}" for k in range(1, len(hinges))), "ground"]
    every = {f"h{k}": Joint(links[k], links[k + 1], item) for k, item in enumerate(hinges)}
    last = f"h{len(hinges) - 1}"
    return Machine(every, {last: every.pop(last)}, ["h0"])


def parallelogram() -> Machine:
    return Machine(
        {
            "A": Joint("ground", "a", askew((0, 0, 0))),
            "B": Joint("a", "bar", askew((0.05, 0.2, 0))),
            "D": Joint("ground", "d", askew((0.3, 0, 0))),
        },
        {"C": Joint("bar", "d", askew((0.35, 0.2, 0)))},
        ["A"],
    )


def palletiser() -> Machine:
    """A turntable, two driven hinges on one line, and a levelling parallelogram."""
    return Machine(
        {
            "T": Joint("ground", "table", askew((0, 0, 0), (0, 1, 0))),
            "A": Joint("table", "upper", askew((0.1, 0.3, 0))),
            "E": Joint("upper", "fore", askew((0.15, 0.8, 0))),
            "D": Joint("table", "crank", askew((0.1, 0.3, 0.05))),
            "B": Joint("crank", "rod", askew((-0.05, 0.35, 0))),
            "L": Joint("table", "level", askew((0.0, 0.25, 0))),
            "M": Joint("level", "plate", askew((0.05, 0.75, 0))),
        },
        {
            "C": Joint("rod", "fore", askew((0.0, 0.85, 0))),
            "N": Joint("plate", "upper", askew((0.15, 0.8, 0))),
        },
        ["T", "A", "D"],
    )


def wrist() -> Machine:
    """Five hinges that meet in a point."""
    axes = ((0, 0, 1), (0.7, 0.1, 0.6), (0.5, 0.8, 0.3), (-0.2, 0.7, 0.5), (0.1, -0.6, 0.7))
    at = [askew((0, 0, 0), axis) for axis in axes]
    return Machine(
        {
            "A": Joint("ground", "a", at[0]),
            "B": Joint("a", "b", at[1]),
            "C": Joint("b", "c", at[2]),
            "E": Joint("ground", "e", at[4]),
        },
        {"D": Joint("c", "e", at[3])},
        ["A", "E"],
    )


def legs() -> Machine:
    """Two planar five-bars in planes of their own, one after the other."""
    joints, loops = {}, {}
    for side, way, z in (("l", (0, 0, 1), 0.2), ("r", (0.3, 0, 1), -0.2)):
        x = np.cross((0, 1, 0), way) / np.linalg.norm(way)

        def at(a: float, b: float, x: np.ndarray = x, z: float = z, way: object = way) -> Hinge:
            return askew(a * x + [0.0, b, z], way)

        joints |= {
            f"{side}A": Joint("ground", f"{side}a", at(0.0, 0.0)),
            f"{side}B": Joint(f"{side}a", f"{side}b", at(-0.1, -0.2)),
            f"{side}D": Joint("ground", f"{side}d", at(0.1, 0.0)),
            f"{side}E": Joint(f"{side}d", f"{side}e", at(0.22, -0.21)),
        }
        loops[f"{side}C"] = Joint(f"{side}b", f"{side}e", at(0.06, -0.43))
    return Machine(joints, loops, ["lA", "lD", "rA", "rD"])


def three_rods(middle: float) -> Machine:
    """A plate on three parallel rods with their ends in line: two four-bars, as in a robot's neck.

    Whether each rod is as long as the others is of no first order to how it moves.
    """
    rod, row = np.array([0.018, 0.038, 0.0]), np.array([0.0072, 0.0019, 0.0])
    at = {"a": 0.0 * row, "b": row, "c": middle * row}
    joints = {name: Joint("ground", name, askew(place)) for name, place in at.items()}
    joints["plate"] = Joint("a", "plate", askew(rod))
    loops = {
        f"on_{name}": Joint("plate", name, askew(at[name] + rod + [0, 0, 0.01])) for name in "bc"
    }
    return Machine(joints, loops, ["a"])


def delta() -> Machine:
    """Three arms, each with two rods between balls, which may spin about their own lines."""
    joints, loops = {}, {}
    for k, angle in enumerate(2.0 * np.pi / 3.0 * np.arange(3)):
        out, side = (np.array([np.cos(a), np.sin(a), 0.0]) for a in (angle, angle + np.pi / 2.0))
        joints[f"A{k}"] = Joint("ground", f"a{k}", askew(0.2 * out, side))
        elbow, foot = 0.35 * out - [0, 0, 0.1], 0.05 * out - [0, 0, 0.5]
        if not k:
            joints["rod"] = Joint("a0", "r0_0", askew(elbow + 0.05 * side, side), "spherical")
            joints["P"] = Joint("r0_0", "plate", askew(foot + 0.05 * side, side), "spherical")
        for j, off in enumerate((0.05, -0.05)):
            if k or j:
                at = askew(elbow + off * side, side)
                joints[f"r{k}_{j}"] = Joint(f"a{k}", f"r{k}_{j}", at, "spherical")
                at = askew(foot + off * side, side)
                loops[f"f{k}_{j}"] = Joint(f"r{k}_{j}", "plate", at, "spherical")
    rods = tuple(item.child for item in joints.values() if item.child.startswith("r"))
    return Machine(joints, loops, ["A0", "A1", "A2"], rods)


MACHINES: dict[str, Callable[[], Machine]] = {
    "planar": lambda: one_loop([askew(item.point, item.direction) for item in planar()]),
    "spherical": lambda: one_loop([askew(item.point, item.direction) for item in spherical()]),
    "bennett": lambda: one_loop([askew(item.point, item.direction) for item in bennett()]),
    "parallelogram": parallelogram,
    "palletiser": palletiser,
    "wrist": wrist,
    "legs": legs,
    "three_rods": lambda: three_rods(-1.0),
    "rods_in_a_row": lambda: three_rods(2.0),
    "delta": delta,
}


def rounded(text: str, digits: int) -> str:
    """Return a text with places and angles of joints to some decimals."""

    def shorter(match: re.Match[str]) -> str:
        words = (f"{float(word):.{digits}f}" for word in match[2].split())
        return f'{match[1]}="{" ".join(words)}"'

    parts = re.split(r"(<inertial>.*?</inertial>)", text)
    parts[::2] = [re.sub(r'(xyz|rpy)="([^"]*)"', shorter, part) for part in parts[::2]]
    return "".join(parts)


def swept(mechanism: cd.Mechanism, machine: Machine) -> cd.Sweep:
    positions = np.array([[-0.02, 0.03, 0.01, 0.02], [0.04, -0.03, 0.02, -0.01]])
    scene = cd.Scene(mechanism, drive=machine.drives, gravity=GRAVITY)
    return scene.sweep(positions[:, : len(machine.drives)], speed=1.0)


@cache
def exact(name: str) -> tuple[Machine, int, cd.Sweep]:
    machine = MACHINES[name]()
    mechanism = cd.load(machine.text())
    return machine, cd.describe(mechanism).mobility, swept(mechanism, machine)


def compare(name: str, digits: int) -> None:
    """Hold mobility, efforts and unique wrenches against those of exact numbers."""
    machine, mobility, expected = exact(name)
    text = rounded(machine.text(), digits)
    mechanism = cd.load(text)
    assert cd.describe(mechanism).mobility == mobility
    found = swept(mechanism, machine)
    allowed = 100.0 * max(10.0**-digits, 1e-12)
    size = np.max(np.abs(expected.drive_effort))
    assert np.max(np.abs(found.drive_effort - expected.drive_effort)) < allowed * size
    assert not np.any(found.unique & ~expected.unique)
    pairs = [
        (found.wrench(item, "world"), expected.wrench(item, "world")) for item in expected.outputs
    ]
    for part, columns in (("force", slice(0, 3)), ("moment", slice(3, 6))):
        size = max(np.max(np.abs(getattr(item, part))) for _, item in pairs)
        for mine, right in pairs:
            kept = mine.unique[columns]
            off = np.abs(getattr(mine, part) - getattr(right, part))[:, kept]
            assert np.max(off, initial=0.0) < allowed * size


@pytest.mark.slow
@pytest.mark.parametrize("digits", [4, 11])
@pytest.mark.parametrize("name", MACHINES)
def test_machines_with_few_digits(name: str, digits: int) -> None:
    compare(name, digits)


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize("digits", sorted({*DIGITS} - {4, 11}))
@pytest.mark.parametrize("name", MACHINES)
def test_machines_with_any_digits(name: str, digits: int) -> None:
    compare(name, digits)


@pytest.mark.parametrize(
    ("name", "tilt"),
    [
        ("parallelogram", 1e-3),
        ("parallelogram", 1e-5),
        ("legs", 1e-3),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (("legs", 1e-5), ("palletiser", 1e-3), ("palletiser", 1e-5))
        ),
    ],
)
def test_a_hinge_that_is_askew_by_more_than_digits_say_is_told(name: str, tilt: float) -> None:
    """Whichever it is: mobility is as with exact numbers, or a warning tells what would make it."""
    machine, mobility, _ = exact(name)
    before, *axes = machine.text().split('<axis xyz="0 0 1"/>')
    for index in range(len(machine.joints)):
        stated = [
            (0.8 * tilt * (count == index), 0.6 * tilt * (count == index))
            for count in range(len(axes))
        ]
        text = before + "".join(
            f'<axis xyz="{x} {y} 1"/>{part}' for (x, y), part in zip(stated, axes, strict=True)
        )
        mechanism = cd.load(text)
        if cd.describe(mechanism).mobility == mobility:
            continue
        (warning,) = (item for item in mechanism.warnings if "loops would close" in item)
        (tolerance,) = re.findall(r"closure_tolerance=([0-9.e-]+)", warning)
        assert float(tolerance) < 2.0 * tilt
        accepted = cd.load(text, closure_tolerance=float(tolerance))
        assert cd.describe(accepted).mobility == mobility
