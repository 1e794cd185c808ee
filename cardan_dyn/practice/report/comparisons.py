"""Comparisons: the bundled descriptions against the closed forms of Weisbach, Thoma, Grossmann.

No computation of the library depends on them; `cardan-dyn compare` shows them. The closed forms
come from `analytic`, which does not use Pinocchio.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

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


def universal_joint_turn(mechanism: Mechanism, beta: float, speed: float = 0.0) -> Sweep:
    """Turn the universal joint once under load, its joint angle held at `beta` [rad].

    Args:
        mechanism: the bundled universal joint.
        beta: joint angle [rad].
        speed: of the drive [rad/s]; quasi-static if zero.
    """
    scene = Scene(
        mechanism,
        drive="bearing_in",
        held={"joint_angle": beta},
        loads={"bearing_out": -TORQUE},
    )
    return scene.sweep(POSITIONS, speed=speed)


def double_shaft_turn(mechanism: Mechanism, beta: float, speed: float = 0.0) -> Sweep:
    """Turn the double shaft once under load, both joint angles held at `beta` [rad].

    Args:
        mechanism: the bundled double shaft in Z arrangement.
        beta: both joint angles [rad].
        speed: of the drive [rad/s]; quasi-static if zero.
    """
    scene = Scene(
        mechanism,
        drive="bearing_in",
        held={"joint_angle_1": beta, "joint_angle_2": beta},
        loads={"bearing_out": -TORQUE},
    )
    return scene.sweep(POSITIONS, speed=speed)


def thoma_moments(turn: Sweep) -> tuple[Array, Array]:
    """Return Thoma's `(M_x, M_z)` `(N,)` [N·m] from the output bearing of the universal joint.

    The bearing balances what the cross exerts: its wrench has the torsion -M_t, and its moments
    about the fixed axes across shaft 2 (y in the plane of the shafts, z normal to it) are M_x and
    M_z of Thoma (1920), eqs 6 and 7, for a torque M_t in the sense of rotation.
    """
    moment = turn.wrench("bearing_out", "parent").moment
    return moment[:, 1], moment[:, 2]


def run() -> Comparisons:
    """Compare both bundled descriptions at all `BETAS_DEG`."""
    joint, shaft = load("universal_joint"), load("double_shaft_z")
    errors: dict[_Key, dict[float, float]] = {}
    for beta_deg in BETAS_DEG:
        beta = float(np.deg2rad(beta_deg))
        for key, error in (*_universal_joint(joint, beta), *_double_shaft(shaft, beta)):
            errors.setdefault(key, {})[beta_deg] = error
    return Comparisons(Comparison(*key, of) for key, of in errors.items())


def deviation(computed: Array, reference: Array) -> float:
    """Return the greatest deviation of values from a reference, relative to its greatest value."""
    return float(np.max(np.abs(computed - reference)) / np.max(np.abs(reference)))


_Key: TypeAlias = tuple[str, str, str, float]
"""What is compared: scene, quantity, source, tolerance."""


def _universal_joint(mechanism: Mechanism, beta: float) -> Iterator[tuple[_Key, float]]:
    turn = universal_joint_turn(mechanism, beta)
    wrench_in, wrench_out, motion = turn["bearing_in"], turn["bearing_out"], turn.motion
    closed, angle = grossmann.moments(beta, POSITIONS), motion.position("bearing_out")
    m_x, m_z = thoma.bending_moments(beta, POSITIONS)
    computed_x, computed_z = thoma_moments(turn)
    ratio, torque = motion.ratio("bearing_out"), wrench_in.torsion
    out = -wrench_out.torsion / torque
    bent_in, bent_out = wrench_in.bending / torque, wrench_out.bending / torque
    output, speed = (
        law(beta, POSITIONS) for law in (single_joint.output_angle, single_joint.speed_ratio)
    )
    scene = "universal joint"
    for quantity, source, computed, reference in (
        ("output angle φ₂", "Thoma (4)", angle, output),
        ("speed ratio dφ₂/dφ₁", "Weisbach § 26", ratio, speed),
        ("bending, input shaft B₁/D₁", "Grossmann (6)", bent_in, closed.bending_1),
        ("torque ratio D₂/D₁", "Grossmann (7)", out, closed.torsion_2),
        ("bending, output shaft B₂/D₁", "Grossmann (8) corr.", bent_out, closed.bending_2),
        ("bending M_x/M_t", "Thoma (6)", computed_x / TORQUE, m_x),
        ("bending M_z/M_t", "Thoma (7)", computed_z / TORQUE, m_z),
    ):
        yield (scene, quantity, source, CLOSED_FORM_TOLERANCE), deviation(computed, reference)
    along_pins = max(
        float(np.max(np.abs(turn[pin].torsion) / np.linalg.norm(turn[pin].moment, axis=1)))
        for pin in ("pin_in", "pin_out")
    )
    about = scene, "cross moment along its pins", "none (Thoma)", CLOSED_FORM_TOLERANCE
    yield about, along_pins
    yield from _residuals(scene, universal_joint_turn(mechanism, beta, SPEED))


def _double_shaft(mechanism: Mechanism, beta: float) -> Iterator[tuple[_Key, float]]:
    turn = double_shaft_turn(mechanism, beta)
    # Joint 2 mirrors joint 1: seen from the output shaft, its fork has the position of the first.
    closed, ones = grossmann.moments(beta, POSITIONS), np.ones_like(POSITIONS)
    torque, equal = turn["bearing_in"].torsion, "equal angles"
    angle, ratio = turn.motion.position("bearing_out"), turn.motion.ratio("bearing_out")
    middle = turn["slip"].torsion / torque
    bent_in, bent_out = (turn[name].bending / torque for name in ("bearing_in", "bearing_out"))
    scene = "double shaft"
    for quantity, source, computed, reference in (
        ("output angle = input angle", equal, angle, POSITIONS),
        ("speed ratio = 1", equal, ratio, ones),
        ("torque, intermediate shaft D₂/D₁", "Grossmann (7)", middle, closed.torsion_2),
        ("bending, input shaft B₁/D₁", "Grossmann (6)", bent_in, closed.bending_1),
        ("bending, output shaft B₁/D₁", "Grossmann (6)", bent_out, closed.bending_1),
    ):
        yield (scene, quantity, source, CLOSED_FORM_TOLERANCE), deviation(computed, reference)
    yield from _residuals(scene, double_shaft_turn(mechanism, beta, SPEED))


def _residuals(scene: str, turn: Sweep) -> Iterator[tuple[_Key, float]]:
    for quantity, error in (
        ("Newton-Euler balance", turn.balance_residual),
        ("balance of power", turn.power_residual),
    ):
        yield (scene, f"{quantity}, {SPEED:g} rad/s", "laws of motion", RESIDUAL_TOLERANCE), error
