"""Judge: what a case may end with, an error of the package or a result that is proven."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random

import arguments
import descriptions
import numpy as np
import pool
import weight

import cardan_dyn as cd

RESIDUAL = 1e-6
EPS = float(np.finfo(float).eps)
FALL = 9.81
UP = np.array([0.0, 0.0, FALL])
_ATTEMPTS = 5
_MOST_DRIVES = 6
_MOST_PLACED = 120
_MOST_POINTS = 20_000


@dataclass(frozen=True)
class Finding:
    """Something that must not happen.

    Attributes:
        kind: an exception's type, or in words what is wrong.
        place: innermost location in the package, then in what it called; or which check.
        message: details.
    """

    kind: str
    place: str
    message: str


@dataclass(frozen=True)
class Verdict:
    """What came of a case.

    Attributes:
        outcome: how it ended, for statistics.
        finding: what is wrong, if anything.
    """

    outcome: str
    finding: Finding | None = None


class Wrong(Exception):  # noqa: N818
    """A result that is not proven, or contradicts the text it came from."""

    def __init__(self, kind: str, place: str, message: str) -> None:
        super().__init__(message)
        self.finding = Finding(kind, place, message)


def judge(family: str, seed: int, directory: Path) -> Verdict:
    """Run the case of a seed.

    Args:
        family: `descriptions` or `arguments`.
        seed: the seed.
        directory: for files of the case.
    """
    if family == "descriptions":
        case = descriptions.case(seed)
        verdict = _judged(lambda: description(case, seed, directory))
    else:
        code = arguments.call(seed)
        verdict = _judged(lambda: call(code, directory))
        if verdict.finding is not None:
            pool.refresh()  # What went wrong must not spoil the next case.
    for path in directory.iterdir():
        path.unlink()
    return verdict


def _judged(made: Callable[[], str]) -> Verdict:
    try:
        return Verdict(made())
    except cd.CardanError as error:
        return Verdict(type(error).__name__, _unreadable(error) or _refuted(error))
    except Wrong as wrong:
        return Verdict(wrong.finding.kind, wrong.finding)
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:
        kind, place = type(error).__name__, location(error)
        if "/" in place and " > " not in place:
            # Nothing of the package took part: the case itself could not be written down.
            return Verdict("no case", None)
        return Verdict(kind, Finding(kind, place, _message(error)))


def _message(error: BaseException) -> str:
    try:
        return f"{error}"[:400]
    except Exception as other:
        return f"no message: {type(other).__name__}"


def _unreadable(error: cd.CardanError) -> Finding | None:
    """Return what is wrong with an error's message, which has to say something in time."""
    try:
        text = str(error)
    except Exception as other:
        return Finding("unreadable message", location(other), repr(other)[:400])
    if not text.strip():
        return Finding("empty message", location(error), "")
    return None


def _refuted(error: cd.CardanError) -> Finding | None:
    """Return the finding that an error is by which the package owns to be wrong itself."""
    text = str(error)
    if "please report" in text:
        return Finding("refuted by its own proof", location(error), text[:400])
    return None


def location(error: BaseException) -> str:
    """Return the innermost place in the package and the innermost place of all."""
    package = str(Path(cd.__file__).parent)
    frames = traceback.extract_tb(error.__traceback__)
    inside = [frame for frame in frames if frame.filename.startswith(package)]
    last = frames[-1] if frames else None
    parts = [f"{Path(inside[-1].filename).name}:{inside[-1].lineno}"] if inside else []
    if last is not None and (not inside or last is not inside[-1]):
        path = Path(last.filename)
        parts.append(f"{path.parent.name}/{path.name}:{last.lineno}")
    return " > ".join(parts)


def description(case: descriptions.Case, seed: int, directory: Path) -> str:
    """Load a description, move it and weigh it; return how it ended."""
    mechanism = cd.load(case.source(directory), strict=case.strict)
    repr(mechanism)
    _accepted_numbers(case, mechanism)
    if seed % 8 == 0 and len(mechanism.joints) < 30:
        str(cd.describe(mechanism))
    scene = _scene(mechanism, case)
    if scene is None:
        return "loaded, not movable"
    sweep = scene.sweep(np.linspace(0.0, 0.2, 5) if len(scene.drives) == 1 else _ways(scene))
    prove_sweep(sweep)
    _weigh(case, mechanism, sweep)
    return "proven"


def _ways(scene: cd.Scene) -> np.ndarray:
    return np.linspace(0.0, 0.05, 5)[:, None] * np.ones(len(scene.drives))


def _scene(mechanism: cd.Mechanism, case: descriptions.Case) -> cd.Scene | None:
    """Return a scene with drives that the mechanism accepts, None if none was found.

    Errors of the package are passed over here: whether some drive fits is not the question.
    """
    single = [joint.name for joint in mechanism.joints.values() if joint.nv == 1]
    held = {name: value for name, value in case.held.items() if name in single}
    hinted = tuple(name for name in case.drives if name in single)
    waiting: list[tuple[tuple[str, ...], dict[str, float]]] = []
    if hinted:
        waiting.append((hinted, held))
    if mechanism.independent_joints:
        waiting.append((tuple(mechanism.independent_joints), {}))
    waiting += [((name,), {}) for name in single if (name,) != hinted]
    rng = Random(len(mechanism.joints))
    for _ in range(_ATTEMPTS):
        if not waiting:
            return None
        drives, fixed = waiting.pop(0)
        try:
            return cd.Scene(mechanism, drive=list(drives), held=fixed, gravity=-UP)
        except cd.MobilityError as error:
            count = error.details.get("mobility")
            if isinstance(count, int) and 1 < count <= min(_MOST_DRIVES, len(single)):
                waiting.insert(0, (tuple(rng.sample(single, count)), {}))
        except cd.CardanError as error:
            if _refuted(error):
                raise
    return None


def prove_sweep(sweep: cd.Sweep) -> None:
    """Check that a sweep is proven: residuals, and numbers throughout.

    Raises:
        Wrong: it is not.
    """
    everything = set(sweep.outputs) == set(sweep.mechanism.joints)
    # Where nothing acts there is nothing to compare.
    idle = everything and not any(
        np.any(sweep[name].force) or np.any(sweep[name].moment) for name in sweep.outputs
    )
    # A sweep says itself by how much its rounding is magnified.
    allowed = max(RESIDUAL, 100.0 * EPS * float(np.max(sweep.condition, initial=0.0)))
    for name in ("loop_residual", "balance_residual", "power_residual"):
        value = getattr(sweep, name)
        # Only what was left out may lack a balance.
        if np.isnan(value) and (idle or not everything) and name != "loop_residual":
            continue
        if not value < allowed:
            raise Wrong("not proven", name, f"{name} is {value}")
    if np.prod(sweep.shape) > _MOST_POINTS:
        return
    for name in sweep.outputs:
        wrench = sweep[name]
        parts = (wrench.force, wrench.moment, wrench.torsion, wrench.bending, wrench.shear)
        if not all(np.all(np.isfinite(part)) for part in parts):
            raise Wrong("not finite", "wrench", name)
    if everything and not np.all(np.isfinite(sweep.drive_effort)):
        raise Wrong("not finite", "drive effort", str(sweep.drive_effort)[:200])


def _accepted_numbers(case: descriptions.Case, mechanism: cd.Mechanism) -> None:
    """Check that what was loaded could be read."""
    if case.encoding != "utf-8":
        return
    try:
        if mechanism.notation.startswith("MJCF"):
            said = weight.mjcf(case.text, case.beside)
            computed = len(mechanism.loops)
            if computed != said.closures:
                text = f"{said.closures} active equalities, {computed} loops"
                raise Wrong("equality lost or invented", "loops", text)
        else:
            weight.urdf(case.text, case.beside)
    except weight.Unclear:
        return
    except weight.Malformed as error:
        raise Wrong("accepted what is no number", str(error).split(" ", 1)[0], str(error)) from None


def _weigh(case: descriptions.Case, mechanism: cd.Mechanism, sweep: cd.Sweep) -> None:
    """Compare what the world carries with the weight in the text."""
    if case.encoding != "utf-8":
        return
    force, moment, scale = _carried(mechanism, sweep)
    try:
        if mechanism.notation.startswith("MJCF"):
            mass = weight.mjcf(case.text, case.beside).mass
            bodies: dict[str, weight.Body] = {}
        else:
            bodies = weight.moving(weight.urdf(case.text, case.beside))
            mass = sum(body.mass for body in bodies.values())
    except weight.Unclear:
        return
    if mass is None:
        return
    slack = RESIDUAL * (scale + mass * FALL) + 1e-12
    if not np.all(np.abs(force - mass * UP) <= slack):
        text = f"the world carries {force[0].tolist()} N, the bodies weigh {mass * FALL} N"
        raise Wrong("weight lost", "weight", text)
    if not bodies or len(bodies) > _MOST_PLACED:
        return
    _compare_moments(bodies, mechanism, strict=case.strict)
    placed = _placements(bodies, sweep)
    if mechanism.couplings or placed is None:
        return
    expected, reach = np.zeros_like(moment), 0.0
    for name, body in bodies.items():
        rotation, position = placed[name]
        centre = position + rotation @ body.centre
        arm = np.cross(centre, body.mass * UP)
        expected = expected + arm
        reach += float(np.max(np.abs(centre), initial=0.0)) * body.mass * FALL
    slack = (
        RESIDUAL * (float(np.max(np.abs(moment))) + reach + scale * mechanism.characteristic_length)
        + 1e-12
    )
    if not np.all(np.abs(moment - expected) <= slack):
        text = f"about the origin {moment[0].tolist()} N·m, expected {expected[0].tolist()}"
        raise Wrong("weight misplaced", "moment", text)


def _compare_moments(bodies: dict[str, weight.Body], mechanism: cd.Mechanism, strict: bool) -> None:
    """Compare the sum of all moments of inertia with the text; statics does not show them.

    The sum does not change where a loop splits a body; a fixed joint adds to it.
    """
    if not strict or any(body.kind == "fixed" for body in bodies.values()):
        return
    model, left_out = mechanism.model, {0, *mechanism.auxiliary_bodies}
    computed = sum(
        float(np.trace(inertia.inertia))
        for index, inertia in enumerate(model.inertias)
        if index not in left_out
    )
    expected = sum(body.moments for body in bodies.values())
    if not abs(computed - expected) <= RESIDUAL * abs(expected) + 1e-300:
        text = (
            f"principal moments of all bodies sum up to {computed}, in the text to {expected} kg·m²"
        )
        raise Wrong("inertia lost", "inertia", text)


def _carried(mechanism: cd.Mechanism, sweep: cd.Sweep) -> tuple[np.ndarray, np.ndarray, float]:
    """Return force and moment about the origin by the world on everything, and how large parts are.

    Returns:
        `(N, 3)`, `(N, 3)`, and the greatest force.
    """
    force, moment, scale = np.zeros((len(sweep), 3)), np.zeros((len(sweep), 3)), 0.0
    loops = {loop.joint: loop for loop in mechanism.loops}
    for name, joint in mechanism.joints.items():
        loop = loops.get(name)
        if joint.parts:
            from_world = mechanism.model.parents[joint.parts[0].id] == 0
        else:
            from_world = loop is not None and loop.predecessor == 0
        to_world = loop is not None and loop.successor == 0
        sign = float(from_world) - float(to_world)
        if sign:
            wrench = sweep.wrench(name, "world")
            arm = np.cross(sweep.origin(name), wrench.force)
            force = force + sign * wrench.force
            moment = moment + sign * (wrench.moment + arm)
            scale = max(scale, float(np.max(np.abs(wrench.force))))
    return force, moment, scale


def _placements(
    bodies: dict[str, weight.Body], sweep: cd.Sweep
) -> dict[str, tuple[np.ndarray, np.ndarray]] | None:
    """Return where links are, from their joints; check joint origins and axes on the way."""
    placed: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for name in bodies:
        path = [name]
        while path[-1] in bodies and bodies[path[-1]].kind == "fixed":
            path.append(bodies[path[-1]].parent)
        carrier = bodies.get(path[-1])
        if carrier is None:
            return None
        rotation, position = sweep.rotation(carrier.joint), sweep.origin(carrier.joint)
        for step in reversed(path[:-1]):
            position = position + rotation @ bodies[step].xyz
            rotation = rotation @ bodies[step].rotation
        placed[name] = rotation, position
    for body in bodies.values():
        if body.kind not in ("revolute", "continuous") or body.parent not in placed:
            continue
        rotation, position = placed[body.parent]
        expected = position + rotation @ body.xyz
        computed = sweep.origin(body.joint)
        reach = 1.0 + float(np.max(np.abs(expected)))
        if not np.all(np.abs(computed - expected) <= 1e-9 * reach):
            text = f"{body.joint} at {computed[0].tolist()}, expected {expected[0].tolist()}"
            raise Wrong("joint misplaced", "origin", text)
        axis = body.axis / np.linalg.norm(body.axis)
        expected = rotation @ (body.rotation @ axis)
        computed = sweep.rotation(body.joint) @ axis
        if not np.all(np.abs(computed - expected) <= 1e-9):
            text = f"{body.joint} about {computed[0].tolist()}, expected {expected[0].tolist()}"
            raise Wrong("joint misplaced", "axis", text)
    return placed


def call(code: str, directory: Path) -> str:
    """Evaluate a call and prove what it returns; return how it ended."""
    result = pool.evaluate(code, directory)
    try:
        prove(result)
    except cd.CardanError as error:
        if _refuted(error):
            raise
        return f"accepted, then {type(error).__name__}"
    return "proven"


def prove(result: object) -> None:
    """Check a result of any public callable.

    Raises:
        Wrong: it is not proven.
    """
    repr(result)
    if isinstance(result, cd.Scene):
        str(result.plan())
        count = len(result.drives)
        prove_sweep(result.sweep(np.linspace(0.0, 0.1, 3)[:, None] * np.ones(count)))
    elif isinstance(result, cd.Sweep):
        prove_sweep(result)
    elif isinstance(result, cd.Response):
        if not (np.isfinite(result.error) and result.error < RESIDUAL):
            raise Wrong("not proven", "response error", str(result.error))
        low, high = (float(np.clip(limit, -3.0, 3.0)) for limit in result.interval)
        if low <= high:
            prove_sweep(result.sweep(np.linspace(low, high, 5)))
    elif isinstance(result, cd.JointWrench):
        if not np.all(np.isfinite(result.force)) or not np.all(np.isfinite(result.bending)):
            raise Wrong("not finite", "wrench", repr(result)[:200])
    elif isinstance(result, (np.ndarray, float)):
        if np.any(np.isnan(result)):
            raise Wrong("not finite", "array", repr(result)[:200])
    elif isinstance(result, (tuple, dict)):
        for value in result.values() if isinstance(result, dict) else result:
            prove(value)
    else:
        str(result)
