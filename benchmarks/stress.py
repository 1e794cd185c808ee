"""How far are a result and its proofs from the exact ones? What all stress maps measure.

At every point of a map: the error of all unique wrench components against 50 digits, relative to
the greatest wrench of the sample (forces times the characteristic length); the stated condition
number `Sweep.condition`; and the reported residuals beside the same residuals evaluated with 50
digits from the returned doubles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace

import numpy as np

import cardan_dyn as cd

from .exact import Exact, State
from .methods import prepared

EPS = float(np.finfo(float).eps)
BOUND = 100.0
"""Greatest error that counts as stated, in units of eps times the condition number."""
OPTIMISM = 10.0
"""How far a true residual may exceed the reported one (or eps, if that is more)."""


@dataclass(frozen=True)
class Point:
    """One point of a map; numbers are None where the library refused.

    Attributes:
        map: name of the map.
        case: which mechanism and which quantities act.
        parameter: where on the map.
        error: greatest error, see the module.
        stated: condition number that the sweep states there.
        over_stated: greatest error of all samples in units of eps times that number.
        loop, loop_true: reported and true closure error.
        balance, balance_true: reported and true imbalance of the bodies; a response reports its
            measured error as well, and the greater of both counts.
        method: `sweep` or `response`.
        refused, message: the `CardanError`, empty if there was none.
    """

    map: str
    case: str
    parameter: float
    error: float | None = None
    stated: float | None = None
    loop: float | None = None
    loop_true: float | None = None
    balance: float | None = None
    balance_true: float | None = None
    over_stated: float = 0.0
    method: str = "sweep"
    refused: str = ""
    message: str = ""

    @property
    def optimism(self) -> float:
        """True residual over the reported one, the worse of loops and balance."""
        if self.error is None:
            return 0.0
        pairs = ((self.loop_true, self.loop), (self.balance_true, self.balance))
        return max((true or 0.0) / max(said or 0.0, EPS) for true, said in pairs)

    def record(self) -> dict[str, object]:
        """Return it as a JSON record."""
        return {"task": f"stress {self.map}", **asdict(self)}


@dataclass(frozen=True)
class Case:
    """What is swept at one point of a map.

    Attributes:
        urdf: description.
        drive: driven joint.
        held: held joints.
        loads: efforts at joints.
        positions: of the drive; the worst one is the point's.
        speed, acceleration: of the drive.
        gravity: acceleration of free fall.
        method: `sweep` or, where the library has it, `response`.
        span: range of a response that is not periodic.
    """

    urdf: str
    drive: str
    positions: tuple[float, ...]
    held: Mapping[str, float]
    loads: Mapping[str, float]
    speed: float = 0.0
    acceleration: float = 0.0
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    method: str = "sweep"
    span: tuple[float, float] | None = None


def condition(sweep: cd.Sweep, sample: int) -> float:
    """Return the condition number that a result states."""
    # A response states the greatest of all positions that it was built from.
    return float(sweep.condition[min(sample, len(sweep.condition) - 1)])


def measure(name: str, label: str, parameter: float, case: Case) -> Point:
    """Sweep a case and return its worst sample as a point of a map."""
    exact = Exact(case.urdf)
    try:
        ready = prepared(_scene(case), case.method, case.span)
        sweep = ready.sweep(np.array(case.positions), case.speed, case.acceleration)
    except cd.CardanError as error:
        return Point(
            name,
            label,
            parameter,
            method=case.method,
            refused=type(error).__name__,
            message=str(error)[:240],
        )
    points, imbalances, wrenches = [], [], []
    for sample, position in enumerate(case.positions):
        guess = _coordinates(exact, sweep, sample)
        state = exact.at(
            guess,
            {case.drive: float(position), **case.held},
            {case.drive: case.speed},
            {case.drive: case.acceleration},
            case.loads,
            case.gravity,
        )
        error = _compared(sweep, sample, state)
        stated = condition(sweep, sample)
        left, wrench = _imbalance(exact, sweep, sample, case)
        imbalances.append(left)
        wrenches.append(wrench)
        points.append(
            Point(
                name,
                label,
                parameter,
                error=error,
                stated=stated,
                loop=float(sweep.loop_residual),
                loop_true=_loop_error(exact, guess, sweep.mechanism.characteristic_length),
                balance=max(float(sweep.balance_residual), getattr(ready, "error", 0.0)),
                over_stated=error / (EPS * stated),
                method=case.method,
            )
        )
    # Reported residuals are those of all samples, so the true ones are as well.
    whole = ("loop_true", "over_stated")
    worst = max(points, key=lambda point: point.error or 0.0)
    return replace(
        worst,
        balance_true=max(imbalances) / max(wrenches),
        **{key: max(getattr(point, key) for point in points) for key in whole},
    )


def _scene(case: Case) -> cd.Scene:
    return cd.Scene(
        cd.load(case.urdf),
        drive=case.drive,
        held=case.held,
        loads=case.loads,
        gravity=case.gravity if any(case.gravity) else None,
    )


def _coordinates(exact: Exact, sweep: cd.Sweep, sample: int) -> dict[str, float]:
    """Return joint coordinates without their whole turns, which a double cannot hold as well."""
    motion = sweep.motion
    columns = sweep.mechanism.coordinates.columns
    return {
        joint.name: float(motion.x[sample, columns[joint.name]][0])
        for joint in exact.joints
        if joint.kind != "fixed"
    }


def _compared(sweep: cd.Sweep, sample: int, state: State) -> float:
    """Return the greatest error of all unique components, see the module."""
    length = sweep.mechanism.characteristic_length
    scale = np.repeat([length, 1.0], 3)
    error = greatest = 0.0
    for name, exact in state.wrenches.items():
        wrench = sweep[name]
        computed = [*wrench.force[sample], *wrench.moment[sample]]
        for component, exact_component, factor in zip(computed, exact, scale, strict=True):
            if exact_component is not None:
                error = max(error, abs(float(exact_component - component)) * factor)
                greatest = max(greatest, abs(float(exact_component)) * factor)
    return float(error / greatest)


def _loop_error(exact: Exact, coordinates: Mapping[str, float], length: float) -> float:
    """Return the closure error of the returned coordinates, with 50 digits."""
    from mpmath import mpf

    worst = 0.0
    for error in exact.errors({name: mpf(value) for name, value in coordinates.items()}):
        values = [float(value) for value in error]
        gap, tilt = np.linalg.norm(values[:3]) / length, np.linalg.norm(values[3:])
        worst = max(worst, float(gap), float(tilt))
    return worst


def _imbalance(exact: Exact, sweep: cd.Sweep, sample: int, case: Case) -> tuple[float, float]:
    """Return the imbalance of the returned doubles and their greatest wrench, with 50 digits."""
    from mpmath import mpf

    from .exact import STEP
    from .vectors import add, cross, turn

    motion, length = sweep.motion, sweep.mechanism.characteristic_length
    joints = [joint for joint in exact.joints if joint.kind != "fixed"]
    moving = bool(case.speed or case.acceleration)
    coordinates = _coordinates(exact, sweep, sample)
    step = mpf(STEP)
    states = [
        {
            joint.name: mpf(coordinates[joint.name])
            + sign * step * mpf(float(motion.velocity(joint.name)[sample]))
            + (sign * step) ** 2 * mpf(float(motion.acceleration(joint.name)[sample])) / 2
            for joint in joints
        }
        for sign in ((0, -1, 1) if moving else (0,))
    ]
    poses = [exact.poses(state) for state in states]
    gravity = [mpf(value) for value in case.gravity]
    left = {}
    for name in exact.bodies:
        if name != exact.root:
            force, moment, centre = exact.inertia_wrench(name, poses, step, gravity)
            origin = poses[0][name][1]
            arm = [a - b for a, b in zip(centre, origin, strict=True)]
            left[name] = ([-x for x in force], [-x for x in add(moment, cross(arm, force))])
    greatest = 0.0
    for joint in exact.joints + exact.loops:
        wrench = sweep[joint.name]
        if joint.loop:
            rotation, origin = exact.ends(joint, poses[0])[1]
        else:
            rotation, origin = poses[0][joint.child]
        force = turn(rotation, [mpf(float(x)) for x in wrench.force[sample]])
        moment = turn(rotation, [mpf(float(x)) for x in wrench.moment[sample]])
        greatest = max(greatest, _size(force, moment, length))
        for link, sign in ((joint.child, 1), (joint.parent, -1)):
            if link in left:
                arm = [a - b for a, b in zip(origin, poses[0][link][1], strict=True)]
                turned = add(moment, cross(arm, force))
                left[link] = (
                    add(left[link][0], [sign * x for x in force]),
                    add(left[link][1], [sign * x for x in turned]),
                )
    return max(_size(*parts, length) for parts in left.values()), greatest


def _size(force: list, moment: list, length: float) -> float:
    forces = float(np.linalg.norm([float(x) for x in force]))
    return max(length * forces, float(np.linalg.norm([float(x) for x in moment])))
