"""What does a sample cost where something else varies than the position of one drive?

Random rotations φ (over a thousand turns) and joint angles β (0 to 85°) of the universal joint,
both driven, or β held per sample, beside a sweep of one design and Pinocchio by hand; the error is
that of the moments and of the speed ratio against Grossmann's closed forms, with unit torque. A
Stewart platform over random poses beside a smooth path. A drive line of eight joints with random
angles, phases and lengths beside a sweep of one design over as many positions. Times per sample,
all wrenches; ratios to the reference named in each group.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import cardan_dyn as cd

from .descriptions import design_line, random_designs
from .engines import pinocchio_by_hand
from .records import Record, markdown, save
from .timing import least_seconds

NAME = "many_designs"
_LINE = 8
_POSITIONS = 72


def _error_of(turn: cd.Sweep, beta: np.ndarray, phi: np.ndarray) -> float:
    """Return the worst relative error of moments and speed ratio, unit torque at the output."""
    square = np.cos(beta) ** 2 + (np.sin(beta) * np.sin(phi)) ** 2
    torsion = np.cos(beta) / square
    exact = {
        "torsion": (turn["bearing_in"].torsion, torsion),
        "bending in": (turn["bearing_in"].bending, torsion * np.tan(beta) * np.abs(np.sin(phi))),
        "bending out": (
            turn["bearing_out"].bending,
            torsion * np.tan(beta) * np.abs(np.cos(phi)) * np.sqrt(square),
        ),
        "ratio": (turn.motion.ratio("bearing_out"), torsion),
    }
    return max(
        float(np.max(np.abs(np.abs(found) - value) / np.maximum(np.abs(value), 1.0)))
        for found, value in exact.values()
    )


def _group(
    task: str,
    candidates: dict[str, Callable[[], object]],
    count: int,
    errors: dict[str, float],
    repeats: int,
) -> list[Record]:
    """Return records of candidates; the first one is the reference."""
    for candidate in candidates.values():
        candidate()
    seconds = least_seconds(candidates, repeats, patience=20.0)
    reference = next(iter(seconds.values()))
    return [
        Record(
            task=NAME,
            method=name,
            version=cd.__version__,
            parameters={"group": task, "samples": count},
            error=errors.get(name),
            microseconds=least / count * 1e6,
            ratio=least / reference,
        )
        for name, least in seconds.items()
    ]


def universal_joint(fast: bool = False) -> list[Record]:
    """Measure the universal joint."""
    count = 1000 if fast else 10_000
    rng = np.random.default_rng(0)
    phi = rng.uniform(0.0, 2000.0 * np.pi, count)
    beta = rng.uniform(0.0, np.deg2rad(85.0), count)
    joint, loads = cd.load("universal_joint"), {"bearing_out": -1.0}
    held = {"joint_angle": np.deg2rad(50.0)}
    one = cd.Scene(joint, drive="bearing_in", held=held, loads=loads)
    both = cd.Scene(joint, drive=["bearing_in", "joint_angle"], loads=loads)
    positions = np.stack([phi, beta], axis=1)
    candidates: dict[str, Callable[[], object]] = {
        "one drive": lambda: one.sweep(phi),
        "two drives": lambda: both.sweep(positions),
        "held per sample": lambda: one.sweep(phi, held={"joint_angle": beta}),
        "Pinocchio by hand": pinocchio_by_hand.prepare(beta, phi),
    }
    errors = {
        "one drive": _error_of(one.sweep(phi), np.full(count, held["joint_angle"]), phi),
        "two drives": _error_of(both.sweep(positions), beta, phi),
        "held per sample": _error_of(one.sweep(phi, held={"joint_angle": beta}), beta, phi),
    }
    return _group("universal joint", candidates, count, errors, 2 if fast else 5)


def platform(fast: bool = False) -> list[Record]:
    """Measure the Stewart platform."""
    count = 300 if fast else 10_000
    legs = [f"leg_{index}" for index in range(1, 7)]
    scene = cd.Scene(cd.load("stewart_platform"), drive=legs, gravity=(0.0, 0.0, -9.81))
    share = np.linspace(0.0, 2.0 * np.pi, count)[:, None]
    path = 0.1 * np.sin(share * np.arange(1, 7))
    poses = np.random.default_rng(1).uniform(-0.1, 0.1, (count, 6))
    candidates: dict[str, Callable[[], object]] = {
        "smooth path": lambda: scene.sweep(path, along_path=True),
        "random poses": lambda: scene.sweep(poses),
    }
    return _group("Stewart platform", candidates, count, {}, 2 if fast else 3)


def line(fast: bool = False) -> list[Record]:
    """Measure the drive line."""
    designs = 30 if fast else 2000
    held, varied = random_designs(_LINE, 1), random_designs(_LINE, designs)
    nominal = {name: float(values[0, 0]) for name, values in held.items()}
    scene = cd.Scene(
        cd.load(design_line(_LINE)),
        drive="bearing_0",
        held=nominal,
        loads={f"bearing_{_LINE}": -1.0},
    )
    position = np.linspace(0.0, 2.0 * np.pi, _POSITIONS, endpoint=False)
    many = np.linspace(0.0, 2.0 * np.pi, designs * _POSITIONS, endpoint=False)
    candidates: dict[str, Callable[[], object]] = {
        "one design": lambda: scene.sweep(many),
        "designs x 72 positions": lambda: scene.sweep(position, held=varied),
    }
    count = designs * _POSITIONS
    return _group("drive line of 8 joints", candidates, count, {}, 2 if fast else 3)


def measure(fast: bool = False) -> list[Record]:
    """Return all records."""
    return [*universal_joint(fast), *platform(fast), *line(fast)]


def answer(records: list[Record]) -> str:
    """Return what varies at which cost."""
    return " ".join(
        f"{record.parameters['group']}, {record.method}: {record.ratio:.3g} times the reference."
        for record in records
        if record.ratio != 1.0
    )


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    rows = [
        [
            str(record.parameters["group"]),
            record.method,
            str(record.parameters["samples"]),
            f"{record.microseconds:.3g}",
            f"{record.ratio:.3g}",
            "" if record.error is None else f"{record.error:.1e}",
        ]
        for record in records
    ]
    head = ["mechanism", "what varies", "samples", "µs/sample", "ratio", "error"]
    return f"{markdown(head, rows)}\n\n{text}"
