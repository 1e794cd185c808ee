"""How a universal joint gives way, against its kinetic energy written by hand."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.pin_rigs import THETA, compound, rig, scene

import cardan_dyn as cd
from cardan_dyn import ModelError
from cardan_dyn.motion.clearance.arguments import opened_joints
from cardan_dyn.motion.clearance.opened_joint import Mobility

BETA, RADIUS = np.radians(20.0), 0.05
PHI = [0.3, 1.7, 4.0]
MASS, INERTIA = 0.5, (2e-4, 3e-4, 4e-4)
BOTH_1, BOTH_2 = ("pin_in+", "pin_in-"), ("pin_out+", "pin_out-")


def opened(turn: cd.Scene, name: str, open_: tuple[str, ...], phi: float) -> Mobility:
    joints, _ = opened_joints(turn.solver, None, name, open_, 1e-5, 1e8, RADIUS)
    return joints[name].mobility(turn.sweep([phi]).motion.rows[0])


def determined(found: Mobility, force: np.ndarray) -> np.ndarray:
    """The part of forces that motion decides."""
    return np.asarray(found.movable @ (found.movable.T @ force))


def matrix(found: Mobility) -> np.ndarray:
    """W in the space of all bearings' forces."""
    return np.asarray(found.axes.T @ found.matrix @ found.axes)


class ByHand:
    """The rig at a position, from directions of its pins and shafts."""

    def __init__(self, phi: float) -> None:
        phi_2 = np.arctan2(np.sin(phi), np.cos(BETA) * np.cos(phi))
        self.e_2 = np.array([np.cos(BETA), np.sin(BETA), 0.0])
        across = np.array([-np.sin(BETA), np.cos(BETA), 0.0])
        self.a_1 = np.array([0.0, np.cos(phi), np.sin(phi)])
        self.a_2 = np.cos(phi_2) * np.array([0.0, 0.0, 1.0]) - np.sin(phi_2) * across
        self.n = np.cross(self.a_1, self.a_2)
        frame = np.array([self.a_1, self.a_2, self.n])
        self.inertia = frame.T @ np.diag(INERTIA) @ frame

    def rows(self, pin: int, sign: float, turns: np.ndarray, shift: np.ndarray) -> np.ndarray:
        """Motion of the child's side at a bearing, along t and n: of turns and shifts `(f, 3)`."""
        axis = (self.a_1, self.a_2)[pin]
        moved = shift + np.cross(turns, sign * RADIUS * axis)
        return np.array([moved @ np.cross(self.n, axis), moved @ self.n])

    def one_pin(self, pin: int) -> np.ndarray:
        """W with both bearings of a pin open: shaft 2 turns, and the cross about the other pin."""
        no = np.zeros(3)
        if pin == 0:
            turns = np.array([self.e_2, self.a_2])
            mass = turns @ self.inertia @ turns.T + np.diag([THETA, 0.0])
        else:
            # The cross stays with fork 1; the child of pin 2 is shaft 2.
            turns = np.array([self.e_2, -self.a_1])
            mass = np.diag([THETA, self.a_1 @ self.inertia @ self.a_1])
        j = np.concatenate([self.rows(pin, sign, turns, no) for sign in (1.0, -1.0)])
        return np.asarray(j @ np.linalg.solve(mass, j.T))

    def all_four(self) -> np.ndarray:
        """W with all open: shaft 2 turns, the cross turns freely and shifts along the normal."""
        mass = np.zeros((5, 5))
        mass[0, 0], mass[1:4, 1:4], mass[4, 4] = THETA, self.inertia, MASS
        shift = np.zeros((5, 3))
        shift[4] = self.n
        turns = np.zeros((5, 3))
        turns[1:4] = np.eye(3)
        shaft = np.zeros((5, 3))
        shaft[0] = self.e_2
        j = [self.rows(0, sign, turns, shift) for sign in (1.0, -1.0)]
        j += [self.rows(1, sign, shaft - turns, -shift) for sign in (1.0, -1.0)]
        stacked = np.concatenate(j)
        return np.asarray(stacked @ np.linalg.solve(mass, stacked.T))


@pytest.mark.parametrize("phi", PHI)
def test_mobility_by_hand(phi: float) -> None:
    turn, hand = scene(rig(MASS, INERTIA), BETA), ByHand(phi)
    cases = [
        (BOTH_1, hand.one_pin(0)),
        (BOTH_2, hand.one_pin(1)),
        ((*BOTH_1, *BOTH_2), hand.all_four()),
    ]
    for open_, expected in cases:
        found = matrix(opened(turn, "cross", open_, phi))
        scale = np.max(np.abs(expected))
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10 * scale)


def test_the_end_near_the_mass_of_the_cross_is_the_heavy_one() -> None:
    """Pushed along the normal, a cross is a free body: 1/m + (r ∓ c)²/J about the other pin."""
    centre = 0.01
    mass = f'<mass value="{MASS!r}"'
    urdf = rig(MASS, INERTIA)
    assert mass in urdf
    moved = urdf.replace(mass, f'<origin xyz="0 {centre!r} 0"/>{mass}')
    found = np.diag(matrix(opened(scene(moved, BETA), "cross", (*BOTH_1, *BOTH_2), 0.7)))[1:4:2]
    levers = RADIUS - np.array([centre, -centre])
    np.testing.assert_allclose(found, 1.0 / MASS + levers**2 / INERTIA[1], rtol=1e-9)


@pytest.mark.parametrize("name", ["thoma_rig", "universal_joint"])
def test_freedoms_of_open_bearings(name: str) -> None:
    """One open bearing leaves none, both of a pin two, one on each pin one, all four five."""
    turn = scene(name if name == "universal_joint" else rig(MASS, INERTIA), BETA)
    for one in (*BOTH_1, *BOTH_2):
        with pytest.raises(ModelError, match="alone nothing can move"):
            opened(turn, "cross", (one,), 0.7)
    counts = {
        BOTH_1: 2,
        BOTH_2: 2,
        ("pin_in+", "pin_out-"): 1,
        (*BOTH_1, "pin_out-"): 3,
        (*BOTH_1, *BOTH_2): 5,
    }
    for open_, count in counts.items():
        assert opened(turn, "cross", open_, 0.7).movable.shape[1] == count


@pytest.mark.parametrize("phi", PHI)
def test_a_massless_cross_leaves_the_flywheel(phi: float) -> None:
    """J = Θ / (e₂ · n)², and m = J / (2 r²) of a bearing; the cross carries no tilting force."""
    hand = ByHand(phi)
    expected = THETA / (hand.e_2 @ hand.n) ** 2 / (2.0 * RADIUS**2)
    massless = scene("thoma_rig", BETA)
    for open_ in (BOTH_1, BOTH_2):
        found = opened(massless, "cross", open_, phi)
        assert found.movable.shape[1] == 2
        (along,) = found.axes
        np.testing.assert_allclose(np.abs(along), np.array([1, 0, 1, 0]) / np.sqrt(2), atol=1e-12)
        assert found.reduced_mass(along) == pytest.approx(expected, rel=1e-10)
    light = scene(rig(1e-9, (1e-13, 1e-13, 1e-13)), BETA)
    pair = np.array([1.0, 0.0, -1.0, 0.0]) / np.sqrt(2.0)
    found = opened(light, "cross", BOTH_1, phi)
    assert found.reduced_mass(pair) == pytest.approx(expected, rel=1e-10)


def test_a_joint_of_type_universal_is_a_massless_cross() -> None:
    turn, plain = scene(compound(), BETA), scene("thoma_rig", BETA)
    for ends in (("1+", "1-"), ("2+", "2-"), ("1+", "1-", "2+", "2-")):
        names = {"1": "pin_in", "2": "pin_out"}
        own = tuple(f"coupling.turn_{end}" for end in ends)
        same = tuple(f"{names[end[0]]}{end[1]}" for end in ends)
        found, expected = opened(turn, "coupling", own, 0.7), opened(plain, "cross", same, 0.7)
        np.testing.assert_allclose(matrix(found), matrix(expected), rtol=1e-10, atol=1e-9)


def test_only_what_moves_decides_forces() -> None:
    """A force through the centre of a joint between fixed bearings is left out."""
    found = opened(scene(rig(MASS, INERTIA), BETA), "cross", BOTH_1, 0.7)
    np.testing.assert_allclose(determined(found, np.array([1.0, 2.0, 1.0, 2.0])), 0.0, atol=1e-12)
    pair = np.array([1.0, 2.0, -1.0, -2.0])
    np.testing.assert_allclose(determined(found, pair), pair, atol=1e-12)


def test_what_has_no_mass_is_refused() -> None:
    """Of one bearing on each pin of a massless cross, the cross alone can move."""
    with pytest.raises(ModelError, match="what would move there has no mass"):
        opened(scene("thoma_rig", BETA), "cross", ("pin_in+", "pin_out+"), 0.7)
