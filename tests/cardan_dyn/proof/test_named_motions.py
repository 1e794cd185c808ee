"""Names of motions, and claims about driven and held coordinates with a single false number."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.claims import claimed
from testkit.compound_joints import X, Y, Z, body, crank_and_slider, joint, plate_on_table, robot
from testkit.kinematics import frames_of

import cardan_dyn as cd
from cardan_dyn.core.proof.named_motions import named_motions

FLOATING = robot(
    body("a", 1.0),
    joint("base", "floating", "ground a"),
    body("b", 1.0),
    joint("ball", "spherical", "a b", 'xyz="0.1 0.2 0.3"'),
)


def described(mechanism: cd.Mechanism) -> dict[str, tuple[str, list[float]]]:
    found = named_motions(frames_of(mechanism))
    return {name: (motion.kind, motion.axis.tolist()) for name, motion in found.items()}


def test_coordinates_are_named_by_what_they_are() -> None:
    x, y, z = np.eye(3).tolist()
    plain, cardan = cd.load(FLOATING), cd.load(FLOATING).variant(["ball", "base"])
    slides = {"base.x": ("slide", x), "base.y": ("slide", y), "base.z": ("slide", z)}
    assert described(plain) == slides
    turns = {"base.turn_x": x, "base.turn_y": y, "base.turn_z": z}
    turns |= {"ball.x": x, "ball.y": y, "ball.z": z}
    assert described(cardan) == slides | {name: ("turn", axis) for name, axis in turns.items()}
    assert described(cd.load(plate_on_table())) == {
        "c.slide": ("slide", [0.0, 0.6, 0.8]),
        "c.turn": ("turn", [0.0, 0.6, 0.8]),
        "u.turn_1": ("turn", x),
        "u.turn_2": ("turn", z),
        "t.slide_1": ("slide", y),
        "t.slide_2": ("slide", [-1.0, 0.0, 0.0]),
        "t.turn": ("turn", z),
    }


def test_the_exact_name_of_a_joint_comes_first() -> None:
    text = robot(
        body("a", 1.0),
        joint("u.turn_1", "prismatic", "ground a", "", (X,)),
        body("b", 1.0),
        joint("u", "universal", "a b", "", (Y, Z)),
    )
    found = described(cd.load(text))
    assert found == {"u.turn_1": ("slide", [1.0, 0.0, 0.0]), "u.turn_2": ("turn", [0.0, 0.0, 1.0])}


@pytest.mark.parametrize("text", [FLOATING, crank_and_slider(), plate_on_table()])
def test_the_solution_means_the_same_coordinates(text: str) -> None:
    """Both sides read names by code of their own."""
    mechanism = cd.load(text)
    for variant in (mechanism, mechanism.variant(list(mechanism))):
        found = named_motions(frames_of(variant))
        assert set(found) == set(variant.coordinates.named)
        for name, scalar in variant.coordinates.named.items():
            motion = found[name]
            assert (motion.column, motion.rate) == (scalar.column, scalar.rate)
            assert (motion.kind == "slide") == scalar.slides == variant.drivable[name].slides


def scene() -> cd.Scene:
    """Seven coordinates are prescribed: of a ball, of a universal joint and of a base."""
    text = FLOATING.replace(
        "</robot>", body("c", 1.0) + joint("u", "universal", "b c", "", (Y, Z)) + "</robot>"
    )
    drives = ["ball.y", "u.turn_2", "base.turn_x", "base.z"]
    held = dict.fromkeys(("ball.x", "ball.z", "u.turn_1", "base.x", "base.y"), 0.1)
    held |= {"base.turn_y": 0.2, "base.turn_z": -0.3}
    return cd.Scene(cd.load(text), drive=drives, held=held, gravity=(1.0, 2.0, -9.0))


def test_false_numbers_of_coordinates_are_found() -> None:
    posed = scene()
    bodies, claim, where = claimed(posed, speed=2.0, acceleration=3.0)
    bodies.check(claim).prove(where, np.ones(len(where)))
    named = posed.mechanism.coordinates.named
    for name in (*posed.drives, *posed.held):
        x, v, a = claim.x.copy(), claim.v.copy(), claim.a.copy()
        x[4, named[name].column] += 1e-6
        v[5, named[name].rate] += 1e-6
        a[6, named[name].rate] += 1e-5
        exerted = claim.exerted.copy()
        exerted[7, named[name].rate] += 1e-5
        for false in (
            claim._replace(x=x),
            claim._replace(v=v),
            claim._replace(a=a),
            claim._replace(exerted=exerted),
        ):
            with pytest.raises(cd.AccuracyError):
                bodies.check(false).prove(where, np.ones(len(where)))


@pytest.mark.parametrize("drive", ["u.turn_1", "s.y", "s.z"])
def test_false_efforts_at_coordinates_of_loops_are_found(drive: str) -> None:
    posed = cd.Scene(cd.load(crank_and_slider()), drive=drive, gravity=(1.0, 2.0, -9.0))
    where = np.linspace(-0.05, 0.02, 5)[:, None]
    bodies, claim, _ = claimed(posed, where, speed=2.0)
    column = posed.mechanism.coordinates.named[drive].rate
    exerted = claim.exerted.copy()
    exerted[2, column] *= 1.0 + 1e-6
    others = [rate for rate in range(exerted.shape[1]) if rate != column]
    assert not np.any(exerted[:, others])
    bodies.check(claim).prove(where, np.ones(len(where)))
    with pytest.raises(cd.AccuracyError):
        bodies.check(claim._replace(exerted=exerted)).prove(where, np.ones(len(where)))
