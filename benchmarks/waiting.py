"""How long do people wait: for single calls, scattered samples, first calls, chains, summaries?

Processor time of one thread, least of some repeats; R is one `pin.rnea` call from Python on the
same model in the same run. "Wanted" is what users would not notice, or the best that others reach.
Ratios compare two figures of this run: import against Pinocchio's, scattered samples against
ordered ones, one output joint against all, first calls against later ones. Every row but those of
fresh processes checks what it times: the residuals of its results.
"""

from __future__ import annotations

import gc
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import cardan_dyn as cd

from .descriptions import design_line
from .records import Record, markdown, save
from .robots import delta, fingers
from .timing import least_seconds, rnea_seconds

NAME = "waiting"
_TURN = 2.0 * np.pi
_CLOSED = 1e-9
"""Greatest residual of results that are timed."""


class Row(NamedTuple):
    """One thing that people wait for.

    Attributes:
        name: what it is.
        unit: of `value` and `wanted`: R, s, ms or "times".
        wanted: figure that is aimed at.
        value: measures it; its argument is the number of repeats.
    """

    name: str
    unit: str
    wanted: float
    value: Callable[[int], float]


def _seconds(run: Callable[[], object], repeats: int, patience: float = 10.0) -> float:
    least = least_seconds({"run": run}, repeats, patience, clock=time.process_time)
    return least["run"]


def _once(run: Callable[[], object]) -> float:
    """Return the time of a first call [s]."""
    gc.collect()
    begin = time.process_time()
    run()
    return time.process_time() - begin


def _proven(sweep: Any) -> None:
    worst = max(float(np.max(sweep.balance_residual)), float(np.max(sweep.loop_residual)))
    assert worst < _CLOSED, worst


@cache
def _mechanism(name: str) -> cd.Mechanism:
    made = {"delta, balls": lambda: delta(True), "delta": lambda: delta(False)}
    return cd.load(made[name]() if name in made else name)


def _joint(**options: Any) -> cd.Scene:
    given = {"drive": "bearing_in", "held": {"joint_angle": np.deg2rad(50.0)}, **options}
    return cd.Scene(_mechanism("universal_joint"), loads={"bearing_out": -1.0}, **given)


def _platform() -> cd.Scene:
    legs = [f"leg_{index}" for index in range(1, 7)]
    return cd.Scene(_mechanism("stewart_platform"), drive=legs, gravity=(0.0, 0.0, -9.81))


def _in_r(name: str, seconds: float) -> float:
    return seconds / rnea_seconds(_mechanism(name))


def _one_position(repeats: int) -> float:
    scene = _joint()
    scene.sweep(np.linspace(0.0, _TURN, 2000))
    _proven(scene.sweep([0.3]))
    run = lambda: scene.sweep([0.3])["bearing_out"].bending  # noqa: E731
    return _in_r("universal_joint", _seconds(run, 3 * repeats))


def _platform_call(repeats: int) -> float:
    """Each call near the last one, as a controller asks."""
    scene, share = _platform(), np.linspace(0.0, _TURN, 200)[:, None]
    path = 0.1 * np.sin(share * np.arange(1, 7))
    scene.sweep(path[:1])

    def run() -> None:
        for position in path:
            sweep = scene.sweep(position[None])
        _proven(sweep)

    return _in_r("stewart_platform", _seconds(run, repeats) / len(path))


def _scattered(held: bool) -> Callable[[int], float]:
    def value(repeats: int) -> float:
        rng = np.random.default_rng(0)
        phi = rng.uniform(0.0, 2000.0 * np.pi, 10_000)
        beta = rng.uniform(0.0, np.deg2rad(85.0), 10_000)
        one, both = _joint(), _joint(drive=["bearing_in", "joint_angle"], held={})
        positions = np.stack([phi, beta], axis=1)
        candidates: dict[str, Callable[[], cd.Sweep]] = {
            "ordered": lambda: one.sweep(np.sort(phi)),
            "scattered": (lambda: one.sweep(phi, held={"joint_angle": beta}))
            if held
            else (lambda: both.sweep(positions)),
        }
        for candidate in candidates.values():
            _proven(candidate())
        least = least_seconds(candidates, repeats, 20.0, clock=time.process_time)
        return least["scattered"] / least["ordered"]

    return value


def _double_shaft(repeats: int) -> float:
    scene = cd.Scene(
        _mechanism("double_shaft_z"),
        drive="bearing_in",
        held={"joint_angle_1": 0.4, "joint_angle_2": 0.3},
        loads={"bearing_out": -1.0},
    )
    phi = np.linspace(0.0, _TURN, 10_000)

    def run() -> None:
        sweep = scene.sweep(phi, speed=30.0, acceleration=5.0)
        for name in scene.mechanism.joints:
            _ = sweep[name].moment
        _proven(sweep)

    return _in_r("double_shaft_z", _seconds(run, repeats) / len(phi))


def _output_share(repeats: int) -> float:
    """One output joint against all, a million positions."""
    phi = np.linspace(0.0, 1000.0, 1_000_000)
    held = {"joint_angle_1": 0.4, "joint_angle_2": 0.3}
    options: dict[str, Any] = {"drive": "bearing_in", "held": held, "loads": {"bearing_out": -1.0}}
    shaft = _mechanism("double_shaft_z")
    one, every = cd.Scene(shaft, outputs=["bearing_out"], **options), cd.Scene(shaft, **options)
    candidates: dict[str, Callable[[], object]] = {
        "one": lambda: one.sweep(phi)["bearing_out"].moment,
        "all": lambda: [(sweep := every.sweep(phi))] and [sweep[n].moment for n in shaft.joints],
    }
    least = least_seconds(candidates, min(repeats, 2), 60.0, clock=time.process_time)
    return least["one"] / least["all"]


def _first_samples(name: str, drives: list[str]) -> Callable[[int], float]:
    """The first sweep of 24 random samples against a later one."""

    def value(repeats: int) -> float:
        first, later = np.inf, np.inf
        for seed in range(repeats):
            positions = np.random.default_rng(seed).uniform(-0.1, 0.1, (48, len(drives)))
            scene = cd.Scene(_mechanism(name), drive=drives, gravity=(0.0, 0.0, -9.81))
            first = min(first, _once(lambda: _proven(scene.sweep(positions[:24]))))  # noqa: B023
            later = min(later, _once(lambda: _proven(scene.sweep(positions[24:]))))  # noqa: B023
        return first / later

    return value


def _idle_rods(repeats: int) -> float:
    """A delta robot whose rods may spin against one whose rods may not, 1000 random positions."""
    arms, positions = [f"arm_{k}" for k in range(1, 4)], np.random.default_rng(0)
    path = positions.uniform(-0.3, 0.3, (1000, 3))
    candidates: dict[str, Callable[[], object]] = {}
    for name in ("delta, balls", "delta"):
        scene = cd.Scene(_mechanism(name), drive=arms, gravity=(0.0, 0.0, -9.81))
        _proven(scene.sweep(path))
        candidates[name] = lambda scene=scene: scene.sweep(path)  # type: ignore[misc]
    least = least_seconds(candidates, repeats, 30.0, clock=time.process_time)
    return least["delta, balls"] / least["delta"]


def _scene_of(name: str, make: Callable[[], cd.Scene]) -> Callable[[int], float]:
    def value(repeats: int) -> float:
        make()
        return _in_r(name, _seconds(make, 3 * repeats))

    return value


def _designs_of_joint() -> Callable[[], cd.Scene]:
    """Return what makes scenes each of which holds the joint angle elsewhere."""
    angles = count(0.8, 1e-5)
    return lambda: _joint(held={"joint_angle": next(angles)})


def _load(repeats: int) -> float:
    return 1e3 * _seconds(lambda: cd.load("universal_joint"), 3 * repeats)


def _fresh(words: list[str], repeats: int, **environment: str) -> float:
    """Return the processor time of a fresh process [s]; it has written its bytecode before."""
    import os

    least = np.inf
    for _ in range(repeats + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [sys.executable, *words],
            cwd=Path(__file__).parents[1],
            env={**os.environ, "PYTHONDONTWRITEBYTECODE": "", **environment},
            capture_output=True,
            check=False,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        least = min(least, used)
    return float(least)


def _import(words: str) -> Callable[[int], float]:
    pinocchio = ["-c", "import pinocchio"]
    return lambda repeats: _fresh(["-c", words], 3 * repeats) / _fresh(pinocchio, 3 * repeats)


def _command(*words: str, **environment: str) -> Callable[[int], float]:
    main = "import sys; from cardan_dyn.practice.command_line import main; sys.exit(main())"
    return lambda repeats: _fresh(["-c", main, *words], repeats, **environment)


def _four_bars(count: int) -> Callable[[int], float]:
    """Seconds per simulated second of connected four-bars, DOP853 at 1e-6."""

    def value(repeats: int) -> float:
        from .four_bars import GRAVITY, START, description

        mechanism, gravity = cd.load(description(count)), (0.0, -GRAVITY, 0.0)

        def run() -> None:
            scene = cd.Scene(mechanism, free="pivot_0", gravity=gravity, outputs=[])
            found = scene.simulate(1.0, position=START, method="DOP853", rtol=1e-6)
            assert found.energy_residual < 1e-5

        return _seconds(run, min(repeats, 3), 30.0)

    return value


def _quadrature(beta_deg: float, known: bool) -> Callable[[int], float]:
    """The scene included, the mechanism's motion followed by an earlier scene or by this one."""

    def value(repeats: int) -> float:
        from .spin import SPEED, description, spin

        task = spin(float(np.deg2rad(beta_deg)))
        mechanism = cd.load(description(task.beta))

        def run() -> None:
            if not known:
                mechanism.kept.forget("branch", "energy functions")
            scene = cd.Scene(mechanism, free="bearing_in", outputs=[])
            found = scene.simulate(task.duration, speed=SPEED, method="quadrature")
            assert abs(found.at(task.duration).position[0] - task.end) < 1e-12

        return _seconds(run, repeats) / rnea_seconds(mechanism)

    return value


def _general_method(repeats: int) -> float:
    """DOP853 in all coordinates against the hand-written row, at equal error, 30°.

    Times over errors are interpolated between tolerances.
    """
    from .engines.spin_pinocchio import methods
    from .spin import SPEED, description, spin

    task = spin(float(np.deg2rad(30.0)))
    mechanism = cd.load(description(task.beta))

    def ours(tolerance: float) -> Callable[[], float]:
        def run() -> float:
            scene = cd.Scene(mechanism, free="bearing_in", outputs=[])
            found = scene.simulate(task.duration, speed=SPEED, method="DOP853", rtol=tolerance)
            return float(found.at(task.duration).position[0])

        return run

    (by_hand,) = methods()
    tolerances = (1e-6, 1e-8, 1e-10)
    curves = []
    for prepare in (ours, lambda level: by_hand.prepare(task, level)):
        runs = {level: prepare(level) for level in tolerances}
        errors = [max(abs(run() - task.end), 1e-14) for run in runs.values()]
        seconds = [_seconds(run, repeats) for run in runs.values()]
        curves.append((np.log(errors), np.log(seconds)))
    # The hand-written row's time at each error of ours.
    order = np.argsort(curves[1][0])
    theirs = np.interp(curves[0][0], curves[1][0][order], curves[1][1][order])
    return float(np.exp(np.max(curves[0][1] - theirs)))


def _designs(repeats: int) -> float:
    count = 2000
    rng = np.random.default_rng(0)
    values = {f"angle_{k}": rng.uniform(0.02, 0.5, (count, 1)) for k in (1, 2, 3)}
    values |= {f"phase_{k}": rng.uniform(0.0, np.pi, (count, 1)) for k in (1, 2)}
    values |= {f"length_{k}": rng.uniform(-0.05, 0.05, (count, 1)) for k in (1, 2)}
    scene = cd.Scene(
        cd.load(design_line(3)),
        drive="bearing_0",
        held={name: float(array[0, 0]) for name, array in values.items()},
        loads={"bearing_3": -100.0},
    )
    phi = np.linspace(0.0, _TURN, 72)
    return _seconds(lambda: _proven(scene.sweep(phi, held=values)), min(repeats, 2), 30.0)


def _line_designs(repeats: int) -> float:
    """The same by `DriveLine.variants`: residual angle and bearing forces."""
    import cardan_dyn.drive_lines as dl

    line = dl.DriveLine.from_toml("truck")
    offsets = np.random.default_rng(0).uniform(-0.3, 0.3, (2000, len(line.shafts) - 2))
    many = line.variants(fork_offsets=offsets)
    find = lambda: line.analyse(variants=many).total.bearing_radial  # noqa: E731
    return _seconds(find, min(repeats, 2), 30.0)


def _line(what: str) -> Callable[[int], float]:
    def value(repeats: int) -> float:
        import cardan_dyn.drive_lines as dl

        return _seconds(lambda: getattr(dl.DriveLine.from_toml("truck"), what)(), repeats)

    return value


_RIG = """<robot name="rig"><link name="base"/>
<link name="shaft_driven"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0"
 ixz="0" iyz="0"/></inertial></link>
<link name="shaft_in"><inertial><mass value="1"/><inertia ixx="0.5" iyy="0.5" izz="0.5" ixy="0"
 ixz="0" iyz="0"/></inertial></link>
<link name="cross"/><link name="frame"/><link name="tilted"/><link name="housing_out"/>
<link name="shaft_out"><inertial><mass value="1"/><inertia ixx="0.1" iyy="1" izz="1" ixy="0"
 ixz="0" iyz="0"/></inertial></link>
<link name="flywheel"><inertial><mass value="1"/><inertia ixx="0.5" iyy="0.5" izz="0.5" ixy="0"
 ixz="0" iyz="0"/></inertial></link>
<joint name="bearing_in" type="continuous"><parent link="base"/><child link="shaft_driven"/>
 <axis xyz="1 0 0"/></joint>
<joint name="twist_in" type="continuous"><parent link="shaft_driven"/><child link="shaft_in"/>
 <axis xyz="1 0 0"/><dynamics spring_stiffness="4" damping="0.04"/></joint>
<joint name="pin_in" type="continuous"><parent link="shaft_in"/><child link="cross"/>
 <axis xyz="0 1 0"/></joint>
<joint name="joint_angle" type="revolute"><parent link="base"/><child link="frame"/>
 <axis xyz="0 0 1"/><limit lower="-1.57" upper="1.57" effort="1" velocity="1"/></joint>
<joint name="tilt_z" type="continuous"><parent link="frame"/><child link="tilted"/>
 <axis xyz="0 0 1"/><dynamics spring_stiffness="1" damping="0.02"/></joint>
<joint name="tilt_y" type="continuous"><parent link="tilted"/><child link="housing_out"/>
 <axis xyz="0 1 0"/><dynamics spring_stiffness="1" damping="0.02"/></joint>
<joint name="bearing_out" type="continuous"><parent link="housing_out"/><child link="shaft_out"/>
 <axis xyz="1 0 0"/></joint>
<joint name="twist_out" type="continuous"><parent link="shaft_out"/><child link="flywheel"/>
 <axis xyz="1 0 0"/><dynamics spring_stiffness="2" damping="0.02"/></joint>
<loop name="pin_out" type="continuous"><predecessor link="cross"/><successor link="shaft_out"/>
 <axis xyz="0 0 1"/></loop></robot>"""
"""Shaft 2 tilts on springs, and both shafts twist."""


def _rig(*free: str) -> cd.Scene:
    rig = cd.load(_RIG)
    fixed = [name for name in rig.joint_springs if name not in free]
    elements = [element for element in cd.described_elements(rig) if element.joint not in fixed]
    held = {"joint_angle": np.deg2rad(8.5), **dict.fromkeys(fixed, 0.0)}
    return cd.Scene(rig, drive="bearing_in", free=list(free), held=held, elements=elements)


def _critical_speeds(repeats: int) -> float:
    """README's rig."""
    rig = cd.load("elastic_thoma_rig")
    scene = cd.Scene(
        rig,
        drive="bearing_in",
        free=list(rig.joint_springs),
        elements=cd.described_elements(rig),
        held={"joint_angle": np.deg2rad(8.5)},
    )
    find = lambda: cd.vibration.critical_speeds(scene, [60.0, 160.0], orders=(2, 4))  # noqa: E731
    return _seconds(find, min(repeats, 2), 20.0)


def _critical_of_four(repeats: int) -> float:
    scene = _rig("twist_in", "tilt_z", "tilt_y", "twist_out")
    find = lambda: cd.vibration.critical_speeds(scene, [0.3, 1.5], orders=(2,))  # noqa: E731
    return _seconds(find, 1)


def _motion_of_three(repeats: int) -> float:
    scene = _rig("tilt_z", "tilt_y", "twist_out")
    return _seconds(lambda: cd.vibration.periodic_motion(scene, 0.6), min(repeats, 2), 20.0)


def _contacts(repeats: int) -> float:
    """A turn with impacts in a pin of a four-bar."""
    from cardan_dyn import clearance

    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    given: dict[str, Any] = {"clearance": 2e-4, "stiffness": 1e8, "damping_ratio": 0.25}
    run = lambda: clearance.simulate(  # noqa: E731
        scene, 100.0, joints="crank_pin", turns=2.0, rtol=1e-6, **given
    )
    return _seconds(run, min(repeats, 2), 20.0) / 2.0


def _geared(repeats: int) -> float:
    """1000 samples of a robot of 97 joints, of which 45 mimic others."""
    text, drives = fingers()
    scene = cd.Scene(cd.load(text), drive=drives, gravity=(0.0, 0.0, -9.81))
    positions = np.random.default_rng(0).uniform(-0.3, 0.3, (1000, len(drives)))
    return _seconds(lambda: _proven(scene.sweep(positions)), min(repeats, 2), 20.0)


def _describe(repeats: int) -> float:
    text, _ = fingers()
    return _seconds(lambda: str(cd.describe(cd.load(text))), repeats)


LEGS = [f"leg_{index}" for index in range(1, 7)]
ARMS = [f"arm_{index}" for index in range(1, 4)]
ROWS = (
    Row("one position: universal joint", "R", 250.0, _one_position),
    Row("one position: Stewart platform, each call near the last", "R", 200.0, _platform_call),
    Row("10 000 random (φ, β), β held per sample, to ordered", "times", 2.5, _scattered(True)),
    Row("10 000 random (φ, β), two drives, to ordered", "times", 2.5, _scattered(False)),
    Row("double shaft, all wrenches, at speed, a position", "R", 5.5, _double_shaft),
    Row("1e6 positions, one output joint to all", "times", 0.3, _output_share),
    Row("Scene: universal joint", "R", 2500.0, _scene_of("universal_joint", _joint)),
    Row("Scene: universal joint, each at another angle", "R", 2500.0,
        _scene_of("universal_joint", _designs_of_joint())),
    Row("Scene: Stewart platform", "R", 4000.0, _scene_of("stewart_platform", _platform)),
    Row("load, warm", "ms", 2.0, _load),
    Row("import, to Pinocchio's", "times", 1.1, _import("import cardan_dyn")),
    Row("import of what makes a scene, to Pinocchio's", "times", 1.1,
        _import("from cardan_dyn import Scene, load")),
    Row("cardan-dyn --help", "s", 0.1, _command("--help")),
    Row("cardan-dyn --version", "s", 0.1, _command("--version")),
    Row("cardan-dyn, completion by TAB", "s", 0.1,
        _command(_CARDAN_DYN_COMPLETE="bash_complete", COMP_WORDS="cardan-dyn v", COMP_CWORD="1")),
    Row("first 24 samples to later ones: Stewart platform", "times", 3.0,
        _first_samples("stewart_platform", LEGS)),
    Row("first 24 samples to later ones: delta robot", "times", 3.0,
        _first_samples("delta, balls", ARMS)),
    Row("delta robot, rods that may spin to rods that may not", "times", 1.0, _idle_rods),
    Row("97 joints, 45 couplings: 1000 samples", "s", 3.0, _geared),
    Row("97 joints, 45 couplings: load and describe", "s", 0.5, _describe),
    Row("10 connected four-bars, a simulated second", "s", 0.25, _four_bars(10)),
    Row("20 connected four-bars, a simulated second", "s", 0.5, _four_bars(20)),
    Row("40 connected four-bars, a simulated second", "s", 1.0, _four_bars(40)),
    Row("free spin by quadrature, 30°, first scene", "R", 10_000.0, _quadrature(30.0, False)),
    Row("free spin by quadrature, 30°, later scene", "R", 10_000.0, _quadrature(30.0, True)),
    Row("free spin by quadrature, 80°, first scene", "R", 15_000.0, _quadrature(80.0, False)),
    Row("free spin by quadrature, 80°, later scene", "R", 15_000.0, _quadrature(80.0, True)),
    Row("free spin by DOP853, to the hand-written row", "times", 1.0, _general_method),
    Row("line of three joints, 2000 designs × 72 positions", "s", 5.0, _designs),
    Row("truck, 2000 variants × 72 positions", "s", 5.0, _line_designs),
    Row("truck: analyse", "s", 0.1, _line("analyse")),
    Row("truck: verdict", "s", 0.3, _line("verdict")),
    Row("cardan-dyn driveline truck", "s", 1.0, _command("driveline", "truck")),
    Row("critical_speeds, README's rig", "s", 1.0, _critical_speeds),
    Row("critical_speeds, four freedoms", "s", 4.0, _critical_of_four),
    Row("periodic_motion, three freedoms, a speed", "s", 3.0, _motion_of_three),
    Row("four-bar with impacts in a pin, a turn", "s", 1.0, _contacts),
)  # fmt: skip


def measure(fast: bool = False) -> list[Record]:
    """Return all records; `ratio` is what was measured over what is wanted.

    Args:
        fast: few repeats, and only rows in R.
    """
    records = []
    for row in ROWS:
        if fast and row.unit != "R":
            continue
        value = row.value(1 if fast else 5)
        parameters = {"unit": row.unit, "value": value, "wanted": row.wanted}
        records.append(
            Record(NAME, row.name, cd.__version__, parameters=parameters, ratio=value / row.wanted)
        )
        print(f"{row.name}: {value:.3g} {row.unit}, wanted {row.wanted:g}", flush=True)
    return records


def answer(records: list[Record]) -> str:
    """Return which rows are slower than wanted."""
    missed = [record for record in records if record.ratio > 1.0]
    lines = [f"{record.method}: {record.ratio:.2g} times what is wanted." for record in missed]
    return "\n".join(
        [f"{len(records) - len(missed)} of {len(records)} rows are as wanted.", *lines]
    )


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    head = ["", "unit", "measured", "wanted"]
    rows = [
        [r.method, p["unit"], f"{p['value']:.3g}", f"{p['wanted']:g}"]
        for r in records
        for p in [r.parameters]
    ]
    return f"{markdown(head, rows)}\n\n{text}"
