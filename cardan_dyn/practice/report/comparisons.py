"""Comparisons: the bundled descriptions against the closed forms of Weisbach, Thoma, Grossmann.

No computation of the library depends on them; `cardan-dyn compare` shows them. The closed forms
come from `analytic`, which does not use Pinocchio.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cardan_dyn.analytic import grossmann, single_joint, thoma

from ...core.mechanics.exact import load
from ...core.mechanism.mechanism import Mechanism
from ...core.results.sweep import Sweep
from ...kit.arrays import Array
from ...scene.scene import Scene
from .verdicts import Comparison, Comparisons

BETAS_DEG = (1.0, 8.5, 30.0, 50.0, 80.0)
"""Joint angles of the report: 8.5° is Thoma's, 30° Weisbach's, 50° Grossmann's."""
POSITIONS = np.linspace(0.0, 2.0 * np.pi, 721)
"""Drive positions over one revolution, the main positions 0, 90, 180 and 270° among them."""
TORQUE = 100.0
"""Load on the output shaft [N·m]. The ratios do not depend on it."""
SPEED = 1000.0
"""Drive speed of the comparisons with inertia [rad/s]."""
CLOSED_FORM_TOLERANCE = 1e-13
"""Greatest error against a closed form that passes. Measured: at most 8.5e-15; a wrong formula is
off by far more."""
RESIDUAL_TOLERANCE = 1e-11
"""Greatest residual of balance and power that passes. Measured: at most 3.6e-12; more than against
closed forms, since large inertial terms cancel at `SPEED`."""


def turn_of(mechanism: Mechanism, beta: float, speed: float = 0.0) -> Sweep:
    """Turn a bundled universal joint or double shaft once under load.

    Args:
        mechanism: `universal_joint` or `double_shaft_z`.
        beta: at which all of its joint angles are held [rad].
        speed: of the drive [rad/s]; quasi-static if zero.
    """
    scene = Scene(
        mechanism,
        drive="bearing_in",
        held={name: beta for name in mechanism.joints if name.startswith("joint_angle")},
        loads={"bearing_out": -TORQUE},
    )
    return scene.sweep(POSITIONS, speed=speed)


class Pair(NamedTuple):
    """A quantity over a turn and its closed form, both `(N,)`, and where that is from."""

    source: str
    computed: Array
    closed: Array


def of_joint(turn: Sweep) -> dict[str, Pair]:
    """Return what is compared of a turn of the universal joint."""
    beta, motion = float(np.max(turn.held["joint_angle"])), turn.motion
    wrench_in, wrench_out = turn["bearing_in"], turn["bearing_out"]
    closed, torque = grossmann.moments(beta, POSITIONS), wrench_in.torsion
    # The bearing balances what the cross exerts: its torsion is -M_t, and its moments about the
    # fixed axes across shaft 2 (y in the plane of the shafts, z normal to it) are M_x and M_z of
    # Thoma (1920), for a torque M_t in the sense of rotation.
    _, x, z = turn.wrench("bearing_out", "parent").moment.T / TORQUE
    m_x, m_z = thoma.bending_moments(beta, POSITIONS)
    angle = single_joint.output_angle(beta, POSITIONS)
    ratio = single_joint.speed_ratio(beta, POSITIONS)
    return {
        "output angle φ₂": Pair("Thoma (4)", motion.position("bearing_out"), angle),
        "speed ratio dφ₂/dφ₁": Pair("Weisbach § 26", motion.ratio("bearing_out"), ratio),
        "bending, input shaft B₁/D₁": Pair(
            "Grossmann (6)", wrench_in.bending / torque, closed.bending_1
        ),
        "torque ratio D₂/D₁": Pair("Grossmann (7)", -wrench_out.torsion / torque, closed.torsion_2),
        "bending, output shaft B₂/D₁": Pair(
            "Grossmann (8) corr.", wrench_out.bending / torque, closed.bending_2
        ),
        "bending M_x/M_t": Pair("Thoma (6)", x, m_x),
        "bending M_z/M_t": Pair("Thoma (7)", z, m_z),
    }


def of_shaft(turn: Sweep) -> dict[str, Pair]:
    """Return what is compared of a turn of the double shaft."""
    # Joint 2 mirrors joint 1: seen from the output shaft, its fork has the position of the first.
    closed = grossmann.moments(float(np.max(turn.held["joint_angle_1"])), POSITIONS)
    torque, motion = turn["bearing_in"].torsion, turn.motion
    middle = turn["slip"].torsion / torque
    bent_in, bent_out = (turn[name].bending / torque for name in ("bearing_in", "bearing_out"))
    return {
        "output angle = input angle": Pair(
            "equal angles", motion.position("bearing_out"), POSITIONS
        ),
        "speed ratio = 1": Pair(
            "equal angles", motion.ratio("bearing_out"), np.ones_like(POSITIONS)
        ),
        "torque, intermediate shaft D₂/D₁": Pair("Grossmann (7)", middle, closed.torsion_2),
        "bending, input shaft B₁/D₁": Pair("Grossmann (6)", bent_in, closed.bending_1),
        "bending, output shaft B₁/D₁": Pair("Grossmann (6)", bent_out, closed.bending_1),
    }


def run() -> Comparisons:
    """Compare both bundled descriptions at all `BETAS_DEG`."""
    errors: dict[tuple[str, str, str, float], dict[float, float]] = {}
    for scene, name, pairs in (
        ("universal joint", "universal_joint", of_joint),
        ("double shaft", "double_shaft_z", of_shaft),
    ):
        mechanism = load(name)
        for beta_deg in BETAS_DEG:
            beta = float(np.deg2rad(beta_deg))
            turn, fast = turn_of(mechanism, beta), turn_of(mechanism, beta, SPEED)
            found = {
                (scene, quantity, pair.source, CLOSED_FORM_TOLERANCE): deviation(*pair[1:])
                for quantity, pair in pairs(turn).items()
            }
            for pin in ("pin_in", "pin_out") if pairs is of_joint else ():
                along = np.abs(turn[pin].torsion) / np.linalg.norm(turn[pin].moment, axis=1)
                about = scene, "cross moment along its pins", "none (Thoma)", CLOSED_FORM_TOLERANCE
                found[about] = max(found.get(about, 0.0), float(np.max(along)))
            for law, error in (
                ("Newton-Euler balance", fast.balance_residual),
                ("balance of power", fast.power_residual),
            ):
                quantity = f"{law}, {SPEED:g} rad/s"
                found[scene, quantity, "laws of motion", RESIDUAL_TOLERANCE] = error
            for key, error in found.items():
                errors.setdefault(key, {})[beta_deg] = error
    return Comparisons(Comparison(*key, of) for key, of in errors.items())


def deviation(computed: Array, reference: Array) -> float:
    """Return the greatest deviation of values from a reference, relative to its greatest value."""
    return float(np.max(np.abs(computed - reference)) / np.max(np.abs(reference)))
