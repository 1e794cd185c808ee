"""Claims of sweeps as the proof is handed them, and claims with a single false number."""

from __future__ import annotations

import numpy as np

import cardan_dyn as cd
from cardan_dyn.core.dynamics.problem_solver import ProblemSolver
from cardan_dyn.core.problem.samples import Acting, acting_on
from cardan_dyn.core.proof.free_bodies import FreeBodies
from cardan_dyn.core.proof.residuals import Claim, Residuals
from testkit.many_drives import cranks, on_arms

POSITIONS = np.linspace(0.2, 1.4, 30)


GRAVITY = (1.0, -2.0, -9.0)


RATES = {"speed": 3.0, "acceleration": 2.0}


def universal(**options: object) -> cd.Scene:
    loads = {"bearing_out": -5.0, "shaft_out": cd.Wrench([1.0, 2.0, 3.0], [0.5, 0.0, 1.0])}
    given = {"drive": "bearing_in", "held": {"joint_angle": 0.8}, "loads": loads}
    return cd.Scene(cd.load("universal_joint"), **{**given, "gravity": GRAVITY, **options})


def four_bar(**options: object) -> cd.Scene:
    given = {"drive": "crank_bearing", "gravity": GRAVITY, "loads": {"rocker_bearing": -5.0}}
    return cd.Scene(cd.load("four_bar"), **{**given, **options})


def spatial(**options: object) -> cd.Scene:
    angles = (("1_h", 0.4), ("1_v", 0.1), ("2_h", 0.3), ("2_v", -0.2))
    held = {f"joint_angle_{name}": angle for name, angle in angles}
    given = {"drive": "bearing_in", "held": held, "gravity": GRAVITY, "loads": {"bearing_out": -3}}
    return cd.Scene(cd.load("double_shaft_spatial"), **{**given, **options})


def coupled_wheels(**options: object) -> cd.Scene:
    """Two wheels on a swinging arm, one of which carries a mass that a fixed loop holds."""
    inertia = '<mass value="2"/><inertia ixx="1" iyy="1" izz="1"/>'
    mass = f'<inertial><origin xyz="0.2 0 0.1"/>{inertia}</inertial>'
    wheels = f"""<robot name="gears"><link name="base"/><link name="arm">{mass}</link>
      <link name="first">{mass}</link><link name="second">{mass}</link>
      <link name="bob">{mass}</link>
      <joint name="swing" type="continuous"><parent link="base"/><child link="arm"/>
        <axis xyz="0 1 0"/></joint>
      <joint name="in" type="continuous"><parent link="arm"/><child link="first"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="out" type="continuous"><parent link="arm"/><child link="second"/>
        <origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
      <joint name="hang" type="planar"><parent link="second"/><child link="bob"/>
        <axis xyz="0 0 1"/></joint>
      <loop name="bolt" type="fixed"><predecessor link="second"/><successor link="bob"/></loop>
      <coupling name="mesh"><predecessor link="first"/><successor link="second"/>
        <ratio value="-2"/></coupling></robot>"""
    given = {"drive": ["in", "swing"], "gravity": GRAVITY, "loads": {"out": -3.0}}
    return cd.Scene(cd.load(wheels), **{**given, **options})


def linkages_on_arms(**options: object) -> cd.Scene:
    """Two linkages, the second one on an arm on the rocker of the first."""
    mechanism = on_arms(2)
    given = {"drive": cranks(mechanism), "gravity": GRAVITY, "loads": {"rocker_1": -3.0}}
    return cd.Scene(mechanism, **{**given, **options})


SCENES = {
    "universal": universal,
    "four-bar": four_bar,
    "spatial": spatial,
    "gears": coupled_wheels,
    "arms": linkages_on_arms,
}


def positions(scene: cd.Scene) -> np.ndarray:
    """Return drive positions `(30, d)` of a scene."""
    return np.stack([(k + 1.0) * POSITIONS for k in range(len(scene.drives))], axis=1)


def acting(solver: ProblemSolver, speeds: np.ndarray, accelerations: np.ndarray) -> Acting:
    """Return rates `(N, d)` of the drives, with what acts in the scene, flat over the samples."""
    if speeds.shape[1] == 1:
        speeds, accelerations = speeds[:, 0], accelerations[:, 0]
    return acting_on(solver.problem, speeds, accelerations).flat((len(speeds),))


def claimed(
    scene: cd.Scene, where: np.ndarray | None = None, **rates: float
) -> tuple[FreeBodies, Claim, np.ndarray]:
    """Return the proof, the claim that a sweep hands to it, and the sweep's drive positions."""
    claims: list[Claim] = []
    bodies = scene.solver.inverse_dynamics.bodies
    check = bodies.check

    def watched(claim: Claim) -> Residuals:
        claims.append(claim)
        return check(claim)

    where = positions(scene) if where is None else where
    bodies.check = watched  # type: ignore[method-assign]
    try:
        scene.sweep(where, **rates)
    finally:
        del bodies.check
    return bodies, claims[0], where


def refused(bodies: FreeBodies, claim: Claim, where: np.ndarray) -> bool:
    """Return whether the proof refuses a claim for these drive positions."""
    try:
        bodies.check(claim).prove(where, np.ones(len(where)))
    except cd.AccuracyError:
        return True
    return False


def bent(array: np.ndarray, index: tuple[int, ...], by: float) -> np.ndarray:
    """Return an array with one number changed by a part of the greatest one."""
    result = np.array(array)
    size = np.max(np.abs(array)) or 1.0
    result[index] += by * size
    return result
