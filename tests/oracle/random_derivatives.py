"""Derivatives of random chains by numbers of every kind, beside differences in fifty digits.

A number that opens a loop has to be left out, and no other; derivatives are unique where wrenches
are and self-stress does not turn into them; forwards and backwards have to agree, and the proof
with both.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from compare import Difference, over, position_of, scene_of
from digits import AtJoint, Found, Sample, Spring, numbers_of
from free_bodies import OPEN, Oracle
from scenes import CERTAIN, ZERO, Case, draw

import cardan_dyn as cd

Array = np.ndarray
_KINDS = "force", "moment"

TOLERANCE = 1e-11
"""Relative error that is allowed at conditions up to 1e3, proportionally more beyond."""
NOTHING = 1e-9
"""Rates, wrenches and their changes count beside it, since steps may leave a square of theirs."""
KINDS = {
    "position": 1,
    "speed": 1,
    "acceleration": 1,
    "load": 2,
    "gravity": 1,
    "mass": 1,
    "centre": 1,
    "inertia": 1,
    "length": 4,
    "angle": 3,
    "element": 3,
}
"""Kinds of numbers, and by how many of them derivatives are asked for."""


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return what is wrong with derivatives of a seed's chain, and what was counted."""
    rng = np.random.default_rng([seed, 7])
    case = draw(seed, turns=bool(rng.random() < 0.3))
    oracle, given = Oracle(case.chain), {}
    elements = _elements(case, oracle, rng, given) if rng.random() < 0.5 else []
    scene = scene_of(case).replace(elements=[_element(item, given) for item in elements])
    sweep = scene.sweep(case.positions, speed=case.speeds, acceleration=case.accelerations)
    numbers = [numbers_of(case, oracle, k) | given for k in range(len(sweep))]
    samples = [
        Sample(case, oracle, own, position_of(sweep, oracle, k), elements)
        for k, own in enumerate(numbers)
    ]
    counted = [*sorted(case.features), *(["elements"] if elements else [])]
    changes, opening = {}, set()
    for name in _asked(numbers[0], rng):
        unit = _unit(case, oracle, name)
        found = [sample.change(name, unit) for sample in samples]
        farthest = max(np.abs(of.positions / samples[0].units).max() * unit for of in found)
        gap = max(np.abs(of.gaps).max(initial=0.0) * unit for of in found) / max(1.0, farthest)
        if ZERO < gap < CERTAIN:
            counted.append("unclear whether it opens")
            continue
        counted.append(f"by {_kind(name)}" + ", which opens" * bool(gap > ZERO))
        changes[name] = found
        if gap > ZERO:
            opening.add(name)
    # Patterns leave out what opens.
    told = sweep.derivative(*(name if name[-2] == "_" else f"{name}*" for name in changes))
    wrong = [f"{name} opens a loop" for name in sorted(told.keys() & opening)]
    wrong += [f"{name} left out" for name in sorted(changes.keys() - told.keys() - opening)]
    told = {name: by for name, by in told.items() if name in changes}
    allowed = TOLERANCE * max(1.0, float(np.max(sweep.condition)) / 1e3)
    for name in told.keys() - opening:
        unit = _unit(case, oracle, name)
        off = _off(case, oracle, samples, told[name], changes[name], unit, allowed)
        wrong += [f"{_kind(name)} {name}: {item}" for item in off]
    wrong += _backwards(case, sweep, told, changes, rng, allowed)
    for name in sorted(opening)[:1]:
        try:
            sweep.derivative(name)
        except cd.ModelError as error:
            wrong += [] if "opens a loop" in str(error) else [f"{name}: {error}"]
        else:
            wrong.append(f"{name} is not refused")
    return wrong, counted


def _elements(
    case: Case, oracle: Oracle, rng: np.random.Generator, numbers: dict[str, float]
) -> list[Spring | AtJoint]:
    """Return springs and friction, and write their numbers."""
    size, found = case.chain.size, []
    first, second = (str(name) for name in rng.choice(list(case.chain.links), 2, replace=False))
    if oracle.body_of[first] != oracle.body_of[second]:
        points = tuple(rng.uniform(-1.0, 1.0, (2, 3)) * size)
        found.append(Spring("strut", (first, second), points, 0.3 * size * rng.integers(2)))
        numbers["stiffness:strut"], numbers["damping:strut"] = rng.uniform(1.0, 9.0, 2) / size
    for name, transition in ("spring", 0.0), ("rubbing", 0.7):
        joint = str(rng.choice(oracle.single()))
        unit = size if oracle.slides[oracle.rate_columns([joint])[0]] else 1.0
        found.append(AtJoint(name, joint, 0.0 if transition else 0.4 * unit, transition * unit))
        kinds = ("friction",) if transition else ("stiffness", "damping")
        for kind in kinds:
            numbers[f"{kind}:{name}"] = rng.uniform(1.0, 9.0) * size / unit ** len(kinds)
    return found


def _element(item: Spring | AtJoint, numbers: dict[str, float]) -> object:
    """Return that of the package."""
    if isinstance(item, AtJoint) and item.transition:
        friction = numbers[f"friction:{item.name}"]
        return cd.JointFriction(item.joint, friction, item.transition, name=item.name)
    stiffness, damping = (numbers[f"{kind}:{item.name}"] for kind in ("stiffness", "damping"))
    if isinstance(item, AtJoint):
        return cd.JointSpring(item.joint, stiffness, damping, item.rest, name=item.name)
    ends = [part for end in zip(item.links, item.points, strict=True) for part in end]
    return cd.PointSpring(*ends, stiffness, damping, item.length, name=item.name)


def _kind(name: str) -> str:
    """Return the one of `KINDS` of a number."""
    kind, colon, rest = name.partition(":")
    if not colon:
        return "gravity" if kind.startswith("gravity.") else "position"
    if kind == "origin":
        return "length" if rest[-2] == "." else "angle"
    return "element" if kind in ("stiffness", "damping", "friction") else kind


def _asked(numbers: dict[str, float], rng: np.random.Generator) -> list[str]:
    """Return names of some numbers of every kind."""
    every: dict[str, list[str]] = {kind: [] for kind in KINDS}
    for name in numbers:
        every[_kind(name)].append(name)
    return [
        str(name)
        for kind, names in every.items()
        for name in rng.choice(names, min(len(names), KINDS[kind]), replace=False)
    ]


def _unit(case: Case, oracle: Oracle, name: str) -> float:
    """Return by how much a number changes to change things about as much as there is."""
    size, kind = case.chain.size, _kind(name)
    mass = sum(link.mass for link in case.chain.links.values()) or 1.0
    if kind in ("position", "speed", "acceleration"):
        (column,) = oracle.rate_columns([name.rpartition(":")[2]])
        return size if oracle.slides[column] else 1.0
    return {"mass": mass, "centre": size, "inertia": mass * size**2, "length": size}.get(kind, 1.0)


def _off(
    case: Case,
    oracle: Oracle,
    samples: Sequence[Sample],
    by: cd.Derivative,
    changes: Sequence[Found],
    unit: float,
    allowed: float,
) -> list[Difference]:
    """Return in what a derivative differs; `unit` as of `_unit`."""
    found = [sample.found for sample in samples]

    def rows(field: str, units: Array) -> tuple[Array, float]:
        """Return how a field changes with the unit, and how great that and the field are."""
        change = np.array([getattr(of, field) for of in changes]) * units * unit
        there = np.array([getattr(of, field).astype(float) for of in found]) * units
        sizes = (np.abs(part).max(initial=0.0) for part in (change, there))
        return change, float(sum(sizes)) + NOTHING

    errors, differing = {}, []
    for field, read in (
        ("positions", by.motion.position),
        ("velocities", by.motion.velocity),
        ("accelerations", by.motion.acceleration),
    ):
        change, scale = rows(field, 1.0 / samples[0].units)
        for name, span in oracle.columns.items():
            if span.stop == span.start:
                continue
            own = np.reshape(read(name), (len(samples), -1))
            # Quaternions are as long as no rotation.
            if own.shape[1] == span.stop - span.start:
                error = own / samples[0].units[span] * unit - change[:, span]
                errors[f"{field} of {name}"] = np.abs(error).max() / scale
    units = np.repeat([case.chain.size, 1.0], 3)
    change, scale = rows("wrenches", units)
    is_open = np.max([sample.influence for sample in samples], axis=0) > OPEN
    turned = np.zeros(is_open.shape)
    if is_open.any() and _kind(by.parameter) in ("position", "length", "angle"):
        # Where it is unique here, and no longer where the number is another.
        stressed = [
            sample.change(by.parameter, unit, scale / case.chain.size) for sample in samples
        ]
        other = np.array([of.wrenches for of in stressed]) * units * unit
        turned = np.abs(other - change).max(axis=0) / scale
    unclear = ~is_open & (turned > ZERO) & (turned < CERTAIN)
    is_open = is_open | (turned >= CERTAIN)
    for k, joint in enumerate(oracle.wrenched):
        wrench = by[joint.name]
        own = np.hstack([wrench.force, wrench.moment]) * units * unit
        wrong = np.any(np.isnan(own) == wrench.unique, axis=0) | (wrench.unique == is_open[k])
        if np.any(wrong & ~unclear[k]):
            differing.append(Difference(f"flags of {joint.name}"))
            continue
        error = np.abs(own - change[:, k])[:, wrench.unique & ~unclear[k]].max(initial=0.0)
        errors[f"wrench of {joint.name}"] = error / scale
    lengths = samples[0].units[oracle.rate_columns(case.prescribed)]
    change, more = rows("efforts", lengths)
    drives = np.reshape(by.drive_effort, (len(samples), -1)).T
    efforts = dict(zip(case.drives, drives, strict=True)) | by.holding_effort
    for k, name in enumerate(case.prescribed):
        # What others hold as well is chosen.
        if max(sample.hang[k] for sample in samples) < OPEN:
            error = np.abs(efforts[name] * lengths[k] * unit - change[:, k]).max()
            errors[f"effort of {name}"] = error / (scale + more)
    return differing + over(errors, allowed)


def _backwards(
    case: Case,
    sweep: cd.Sweep,
    told: dict[str, cd.Derivative],
    changes: dict[str, Sequence[Found]],
    rng: np.random.Generator,
    allowed: float,
) -> list[str]:
    """Return in what gradients differ, and what the proof says of derivatives."""
    oracle, wrong = Oracle(case.chain), []
    factors = rng.normal(size=(len(sweep.outputs), *sweep.shape, 6))

    def weights(of: cd.Sweep | cd.Derivative) -> dict[str, Array]:
        """Return weights of all components that are unique."""
        found = {}
        for joint, every in zip(sweep.outputs, factors, strict=True):
            parts = np.split(every * of[joint].unique, 2, axis=-1)
            found |= {f"{joint}.{kind}": part for kind, part in zip(_KINDS, parts, strict=True)}
        return found

    def terms(of: cd.Sweep | cd.Derivative, weights: dict[str, Array]) -> list[Array]:
        names = (name.rpartition(".") for name in weights)
        read = [np.nan_to_num(getattr(of[joint], kind)) for joint, _, kind in names]
        return [part * weight for part, weight in zip(read, weights.values(), strict=True)]

    greatest = max(
        np.abs(part).max()
        for name in sweep.outputs
        for part in (sweep[name].force, sweep[name].moment)
    )
    own = {name: weights(by) for name, by in told.items()}
    every = weights(sweep)
    turned = [name for name, of in own.items() if any(np.any(of[k] != every[k]) for k in every)]
    slopes = dict(sweep.gradient(every, *[name for name in told if name not in turned]))
    for name in turned:
        slopes |= sweep.gradient(own[name], name)
        try:
            sweep.gradient(every, name)
        except cd.ModelError as error:
            wrong += [] if "laws of motion alone" in str(error) else [f"{name}: {error}"]
        else:
            wrong.append(f"{_kind(name)} {name}: backwards self-stress is not refused")
    wrong += _motion_backwards(case, sweep, told, rng, allowed)
    for name, slope in slopes.items():
        by, unit = told[name], _unit(case, oracle, name)
        parts = terms(by, own[name])
        there = sum(np.abs(part).sum() for part in terms(sweep, own[name]))
        # What is unique may be zero, which is what cancels of all that is there.
        rounded = max(np.abs(of.wrenches).max() for of in changes[name])
        size = sum(np.abs(part).sum() for part in parts) + rounded + (there + greatest) / unit
        error = abs(slope - sum(part.sum() for part in parts))
        # Nothing but rounding is between both ways: they agree better than each with differences.
        if not error <= 0.1 * allowed * size:
            wrong.append(f"{_kind(name)} {name}: backwards {error / size:.1e}")
        if not by.loop_residual * unit <= 10.0 * allowed:
            wrong.append(f"{_kind(name)} {name}: loops open by {by.loop_residual:.1e}")
        # Where nothing changes, there is no size of anything to be in balance.
        if by.balance_residual > allowed:
            wrong.append(f"{_kind(name)} {name}: balance is off by {by.balance_residual:.1e}")
    return wrong


def _motion_backwards(
    case: Case,
    sweep: cd.Sweep,
    told: dict[str, cd.Derivative],
    rng: np.random.Generator,
    allowed: float,
) -> list[str]:
    """Return in what gradients of a weighted sum of the motion differ.

    Each coordinate, rate and acceleration counts by itself: what pins bear would hide it, and there
    may be no other results that change.
    """
    oracle, wrong = Oracle(case.chain), []
    if not told:
        return wrong
    for kind in "position", "velocity", "acceleration":
        own = [getattr(sweep.motion, kind)(name) for name in oracle.single()]
        factors = rng.normal(size=np.shape(own))
        every = {f"{name}.{kind}": row for name, row in zip(oracle.single(), factors, strict=True)}
        for name, slope in sweep.gradient(every, *told).items():
            changes = [getattr(told[name].motion, kind)(joint) for joint in oracle.single()]
            terms = factors * changes
            error, size = abs(slope - terms.sum()), np.abs(terms).sum()
            there = np.abs(factors * own).sum() / _unit(case, oracle, name)
            if not error <= 0.1 * allowed * (size + there):
                wrong.append(f"{_kind(name)} {name}: backwards {kind} {error / size:.1e}")
    return wrong
