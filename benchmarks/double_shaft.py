"""What do all joint wrenches of a double shaft at speed cost, and how exact are they?

Z arrangement at 0.4 and 0.3 rad with its masses, 30 rad/s and 5 rad/s², unit torque at the output;
all wrenches of all joints. Exact is the 50-digit evaluation at a few of the samples; errors are
relative to the greatest wrench of the sample. Pinocchio by hand is given the closed positions and
rates, which the sweep determines; "positions closed before" are those of `Scene.assemble`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pinocchio as pin

import cardan_dyn as cd

from .descriptions import mechanics
from .exact import Exact
from .methods import methods, prepared
from .records import Record, markdown, save
from .timing import least_seconds

NAME = "double_shaft"
HELD = {"joint_angle_1": 0.4, "joint_angle_2": 0.3}
SPEED, ACCELERATION = 30.0, 5.0
COUNTS = (721, 10_000)
REFERENCE = "cardan_dyn sweep, N = 721"
_SINGLE_CALL = "one pin.rnea call, N = 721"
_CHECKED = 7


def by_hand(mechanism: cd.Mechanism, sweep: cd.Sweep) -> Callable[[], np.ndarray]:
    """Return Pinocchio in one loop over samples: all wrenches `(N, joints, 6)`."""
    model = mechanism.model.copy()
    model.gravity.setZero()
    data = model.createData()
    (weld,) = mechanism.constraint_models
    first, second = weld.joint1_id, weld.joint2_id
    known = [model.idx_vs[model.getJointId(name)] for name in ("bearing_in", *HELD)]
    passive = [column for column in range(model.nv) if column not in known]
    load = np.zeros(model.nv)
    load[model.idx_vs[model.getJointId("bearing_out")]] = -1.0
    q, v, a_known = sweep.motion.q, sweep.motion.v, sweep.motion.a[:, known]
    rest = np.zeros(model.nv)
    forces = pin.StdVec_Force()
    for _ in range(model.njoints):
        forces.append(pin.Force.Zero())
    world = pin.ReferenceFrame.WORLD

    def run() -> np.ndarray:
        result = np.empty((len(q), model.njoints - 1, 6))
        a = np.zeros(model.nv)
        for sample in range(len(q)):
            pin.forwardKinematics(model, data, q[sample], v[sample], rest)
            pin.computeJointJacobians(model, data, q[sample])
            rows = pin.getJointJacobian(model, data, first, world) - pin.getJointJacobian(
                model, data, second, world
            )
            placements = data.oMi[first], data.oMi[second]
            drift = placements[0].act(data.a[first]) - placements[1].act(data.a[second])
            a[known] = a_known[sample]
            square = rows[:, passive]
            a[passive] = -np.linalg.solve(square, rows[:, known] @ a[known] + drift.vector)
            effort = pin.rnea(model, data, q[sample], v[sample], a)
            closure = pin.Force(np.linalg.solve(square.T, (effort - load)[passive]))
            forces[first] = placements[0].actInv(closure)
            forces[second] = -placements[1].actInv(closure)
            pin.rnea(model, data, q[sample], v[sample], a, forces)
            for joint in range(1, model.njoints):
                result[sample, joint - 1] = data.f[joint].vector
        return result

    return run


def _errors(positions: np.ndarray, sweep: cd.Sweep) -> Callable[[Callable], float]:
    """Return a function that takes wrenches by joint name and gives their greatest error."""
    exact = Exact(mechanics("double_shaft_z"))
    chosen = np.linspace(0, len(positions) - 1, _CHECKED).astype(int)
    states = {}
    for sample in chosen:
        guess = {
            joint.name: float(np.atleast_1d(sweep.motion.position(joint.name))[sample])
            for joint in exact.joints
        }
        states[int(sample)] = exact.at(
            guess,
            {"bearing_in": float(positions[sample]), **HELD},
            {"bearing_in": SPEED},
            {"bearing_in": ACCELERATION},
            {"bearing_out": -1.0},
        )
    scale = np.repeat([sweep.mechanism.characteristic_length, 1.0], 3)

    def error(wrench: Callable[[str, int], np.ndarray]) -> float:
        worst = 0.0
        for sample, state in states.items():
            difference = size = 0.0
            for name, values in state.wrenches.items():
                computed = wrench(name, sample)
                for value, component, factor in zip(values, computed, scale, strict=True):
                    if value is not None:
                        difference = max(difference, abs(float(value - component)) * factor)
                        size = max(size, abs(float(value)) * factor)
            worst = max(worst, difference / size)
        return worst

    return error


def measure(fast: bool = False) -> list[Record]:
    """Return all records."""
    mechanism = cd.load("double_shaft_z")
    scene = cd.Scene(mechanism, drive="bearing_in", held=HELD, loads={"bearing_out": -1.0})
    runs: dict[str, tuple[Callable, int]] = {}
    errors: dict[str, float] = {}
    failed: dict[str, str] = {}
    for count in COUNTS[:1] if fast else COUNTS:
        positions = 2.0 * np.pi * np.arange(count) / count
        closed = scene.sweep(positions, SPEED, ACCELERATION)
        error = _errors(positions, closed)
        for method in methods():
            name = f"cardan_dyn {method}, N = {count}"
            try:
                ready = prepared(scene, method)
            except cd.CardanError as problem:
                failed[name] = str(problem)
                continue
            errors[name] = error(_wrench_of(ready.sweep(positions, SPEED, ACCELERATION)))
            runs[name] = partial(_all_wrenches, ready, positions), count
        name = f"cardan_dyn sweep of positions closed before, N = {count}"
        before = scene.assemble(positions)
        errors[name] = error(_wrench_of(scene.sweep(before, SPEED, ACCELERATION)))
        runs[name] = partial(scene.sweep, before, SPEED, ACCELERATION), count
        if count == COUNTS[0]:
            name = f"Pinocchio by hand, N = {count}"
            hand = by_hand(mechanism, closed)
            wrenches = hand()
            errors[name] = error(lambda joint, k, w=wrenches: w[k, mechanism.joints[joint].id - 1])
            runs[name] = hand, count
    runs[_SINGLE_CALL] = partial(_rnea_calls, mechanism.model, closed.motion.q[0]), COUNTS[0]
    seconds = least_seconds({name: item[0] for name, item in runs.items()}, 2 if fast else 9)
    times = {name: seconds[name] / count * 1e6 for name, (_, count) in runs.items()}
    return _records(times, errors, failed)


def _wrench_of(turn: cd.Sweep) -> Callable[[str, int], np.ndarray]:
    """Return a function that gives the wrench `(6,)` of a joint at a sample."""
    return lambda joint, sample: np.r_[turn[joint].force[sample], turn[joint].moment[sample]]


def _all_wrenches(
    ready: cd.Scene | cd.Response, positions: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Sweep, and return force and moment of every joint."""
    turn = ready.sweep(positions, SPEED, ACCELERATION)
    return [(wrench.force, wrench.moment) for _, wrench in turn.items()]


def _rnea_calls(model: pin.Model, q: np.ndarray) -> None:
    """Call `pin.rnea` as often as the first sweep has samples."""
    data, zero = model.createData(), np.zeros(model.nv)
    for _ in range(COUNTS[0]):
        pin.rnea(model, data, q, zero, zero)


def _records(
    times: dict[str, float], errors: dict[str, float], failed: dict[str, str]
) -> list[Record]:
    """Return the records of times per sample [µs] and errors, and of methods that failed."""
    return [
        Record(
            task=NAME,
            method=name,
            version=cd.__version__ if name.startswith("cardan") else pin.__version__,
            parameters={"rnea_calls": time / times[_SINGLE_CALL]},
            error=errors.get(name),
            microseconds=time,
            ratio=time / times[REFERENCE],
        )
        for name, time in times.items()
    ] + [
        Record(task=NAME, method=name, parameters={"failed": reason})
        for name, reason in failed.items()
    ]


def answer(records: list[Record]) -> str:
    """Return what it costs."""
    parts = []
    for record in records:
        if record.microseconds is None:
            parts.append(f"{record.method}: refused ({record.parameters['failed']}).")
            continue
        text_ = f"{record.method}: {record.microseconds:.3g} µs per sample"
        text_ += f", {record.parameters['rnea_calls']:.3g} rnea calls"
        parts.append(text_ + (f", error {record.error:.1e}." if record.error else "."))
    return "\n".join(parts)


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text_ = answer(records)
    save(NAME, [record.flat() for record in records], text_)
    rows = [
        [
            record.method,
            "" if record.error is None else f"{record.error:.1e}",
            "refused" if record.microseconds is None else f"{record.microseconds:.3g}",
            "" if record.ratio is None else f"{record.ratio:.3g}",
            f"{record.parameters.get('rnea_calls', 0.0):.3g}",
        ]
        for record in records
    ]
    head = ["method", "error", "µs/sample", "ratio", "in rnea calls"]
    return f"{markdown(head, rows)}\n\n{text_}"
