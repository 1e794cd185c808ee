"""Solving: from a line, a speed and a torque to its motion and forces, through sweeps of a scene.

All forces follow linearly from what acts at a position, so three kinds of sweeps over the same
closed positions are enough: with a unit torque at the output at rest, whose results are multiplied
by the torque; at speed with weight and without torque; and with a unit force in a spline, which is
multiplied by its friction.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import AssemblyError
from ..frozen import FrozenDict, read_only
from ..mechanism.mechanism import Mechanism
from ..results.sweep import Sweep
from ..results.wrench import JointWrench
from ..scene.scene import Scene
from .analysis import Analysis
from .bearing_axes import bearing_axes
from .forces import LineForces
from .geometry import MEETING
from .line_data import LineData
from .line_motion import LineMotion, line_motion
from .supports import Supports, hangs_by_rear, spline_distance, supports
from .tasks import Task
from .zero import Zero, line_zero

_BLOCK, _BLOCK_OF_ONE = 10_000, 50_000
"""Samples times joints that are closed at a time: of designs, some 10 kilobytes for each; of one
line, some 5, where each block would follow the line's motion anew."""


class _Setup(NamedTuple):
    """A scene of a line, and where its results are found.

    Attributes:
        scene: with a unit torque at the output.
        zero: how the pins stand at zero.
        bearings: joints whose forces are those of the bearings.
        places: shaft of each bearing, and how far its place is turned about it in the data [rad].
        tilting: of end shafts that misaligned bearings tilt, the first bearing, which keeps the
            sleeve from turning, another one, and their distance along the flow [m].
        slips: joints of the splines.
        levers: distances from where each slip has its origin to its spline [m]; NaN where that is
            the spline, and the slip's child is the rear piece.
    """

    scene: Scene
    zero: Zero
    bearings: tuple[str, ...]
    places: tuple[tuple[int, float], ...]
    tilting: tuple[tuple[int, int, float], ...]
    slips: tuple[str, ...]
    levers: tuple[float, ...]


class _Part(NamedTuple):
    """Results of a block of samples."""

    motion: LineMotion
    static: LineForces
    inertial: LineForces | None
    residuals: tuple[float, ...]


def scene_of(line: LineData, mechanism: Mechanism, **options: object) -> Scene:
    """Return a scene of a line, driven at its input; see `DriveLine.scene`."""
    arguments: dict[str, object] = {"drive": "bearing_in"}
    if supports(line).indeterminate:
        # Where bearings decide the place of shafts twice, joints between them pass on no force,
        # as the closed forms have it: only what goes through joints counts in the least energy.
        soft = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
        names = [f"pin_{k}_out" for k in range(1, line.count + 1)]
        if max(len(shaft.bearings) for shaft in line.shafts) <= 2:
            arguments["compliance"] = dict.fromkeys(names, soft)
    return Scene(mechanism, **{**arguments, **options})  # type: ignore[arg-type]


def analysed(line: LineData, mechanism: Mechanism, task: Task) -> Analysis:
    """Return the analysis of a line."""
    setup = _setup(line, mechanism, task)
    arrays = _Arrays(task)
    residuals = []
    for chosen, block, held in _blocks(line, task):
        part = _solved(setup, line, block, held)
        arrays.put("motion", chosen, part.motion[:4])
        if task.variants is not None:
            arrays.put("mean", chosen, part.motion[4:])
        arrays.put("static", chosen, part.static)
        arrays.put("inertial", chosen, part.inertial or ())
        residuals.append(part.residuals)
    rotation, ratio, acceleration, slip = arrays.of["motion"]
    inertial = arrays.of["inertial"]
    mean_lead = arrays.of["mean"][0] if "mean" in arrays.of else read_only(part.motion.mean_lead)
    loop, balance, power = np.max(residuals, axis=0).tolist()
    return Analysis(
        name=line.name,
        shafts=line.shaft_names,
        joints=line.joint_names,
        bearings=tuple(name.removeprefix("support_") for name in setup.bearings),
        centrings=tuple(line.shaft_names[k] for k in line.centred),
        splines=tuple(line.shaft_names[int(name.removeprefix("slip_"))] for name in setup.slips),
        speed=task.speed,
        position=read_only(task.positions),
        designs=task.variants.held if task.variants else FrozenDict({}),
        rotation=rotation,
        ratio=ratio,
        acceleration=acceleration,
        static=LineForces(*arrays.of["static"]),
        inertial=LineForces(*inertial) if inertial else None,
        slip=slip,
        mean_lead=mean_lead,
        indeterminate=supports(line).indeterminate,
        loop_residual=loop,
        balance_residual=balance,
        power_residual=power,
    )


class _Arrays:
    """Arrays of all samples, which blocks are written to.

    Attributes:
        of: groups of arrays by name, which cannot be written to by others.
    """

    of: dict[str, list[Array]]

    def __init__(self, task: Task) -> None:
        self._count = len(task.positions) if task.variants is None else task.variants.designs
        self._whole: dict[str, list[Array]] = {}
        self.of = {}

    def put(self, name: str, chosen: slice, values: Sequence[Array]) -> None:
        """Write the values of some designs or positions."""
        if name not in self._whole:
            self._whole[name] = [np.empty((self._count, *value.shape[1:])) for value in values]
            self.of[name] = [read_only(whole.view()) for whole in self._whole[name]]
        for whole, value in zip(self._whole[name], values, strict=True):
            whole[chosen] = value


def _setup(line: LineData, mechanism: Mechanism, task: Task) -> _Setup:
    """Return the scene, with all joint angles held and what varies from design to design."""
    stand, held_by = line_zero(line), supports(line)
    listed = [(item.shaft, f"support_{item.name}") for item in held_by.bearings]
    ends = ((0, "bearing_in"), (line.count, "bearing_out"))
    listed += [end for end in ends if not line.shafts[end[0]].bearings]
    listed.sort(key=lambda item: item[0])
    # What turns on its place alone stands there as its pins do, and bearings straight.
    places = [
        (index, float(stand.rotations[index]) if name in ("bearing_in", "bearing_out") else 0.0)
        for index, name in listed
    ]
    names = [name for _, name in listed]
    varied = {} if task.variants is None else dict.fromkeys(task.variants.held, 0.0)
    is_misaligned = any(name.startswith("support_") for name in varied)
    tilting = _sleeves(held_by, names, (0, line.count)) if is_misaligned else ()
    with_spline = [k for k, shaft in enumerate(line.shafts) if shaft.spline]
    slips = tuple(f"slip_{k}" for k in with_spline)
    levers = tuple(
        spline_distance(line, k) if hangs_by_rear(held_by, k) else np.nan for k in with_spline
    )
    pins = [f"pin_{k}_{side}" for k in range(1, line.count + 1) for side in ("in", "out")]
    angles = {f"joint_angle_{k}": 0.0 for k in range(1, line.count + 1)}
    centrings = [f"centring_{k}" for k in line.centred]
    wanted = [*pins, *names, *slips, *centrings, *angles, "bearing_in", "bearing_out"]
    outputs = dict.fromkeys(wanted)
    scene = scene_of(
        line,
        mechanism,
        held={**angles, **varied},
        loads={"bearing_out": -1.0, **dict.fromkeys(slips, 0.0)},
        outputs=list(outputs),
    )
    return _Setup(scene, stand, tuple(names), tuple(places), tilting, slips, levers)


def _sleeves(
    held_by: Supports, names: Sequence[str], ends: tuple[int, int]
) -> tuple[tuple[int, int, float], ...]:
    """Return the first two bearings on the sleeves of end shafts; see `_Setup.tilting`."""
    found = []
    for shaft in ends:
        # In the order in which the closed chain takes them.
        on_shaft = [item for item in held_by.bearings if item.shaft == shaft]
        on_shaft.sort(key=lambda item: not item.locating)
        if len(on_shaft) > 1:
            first, second = (names.index(f"support_{item.name}") for item in on_shaft[:2])
            apart = on_shaft[1].distance - on_shaft[0].distance
            found.append((first, second, apart if shaft else -apart))
    return tuple(found)


def _blocks(line: LineData, task: Task) -> Iterator[tuple[slice, Task, Mapping[str, Array]]]:
    """Yield some positions or designs at a time, with the task and the adjustable joints `(d, 1)`.

    Of variants, the slice is one of designs, and the task has all positions.
    """
    size = _BLOCK_OF_ONE if task.variants is None else _BLOCK
    most = max(1, size // line.count)
    if task.variants is None:
        for start in range(0, len(task.positions), most):
            chosen = slice(start, start + most)
            torque = task.torque[chosen] if task.torque.ndim else task.torque
            yield chosen, task._replace(positions=task.positions[chosen], torque=torque), {}
        return
    size = max(1, most // len(task.positions))
    for start in range(0, task.variants.designs, size):
        chosen = slice(start, min(start + size, task.variants.designs))
        held = task.variants.held.items()
        yield chosen, task, {name: values[chosen, None] for name, values in held}


def _solved(setup: _Setup, line: LineData, task: Task, held: Mapping[str, Array]) -> _Part:
    """Return the results of a block of samples."""
    scene = setup.scene
    # Designs × positions, even where there is one design or nothing varies.
    count = max((len(values) for values in held.values()), default=1)
    is_grid = task.variants is not None
    positions = np.broadcast_to(task.positions, (count, len(task.positions)))
    closed = scene.assemble(positions if is_grid else task.positions, held=held)
    axes = bearing_axes(line.geometry, held, setup.places)
    turns = list(np.swapaxes(axes, 0, 1) if is_grid else axes[0])

    def sweep(loads: Mapping[str, float] | None = None, moving: bool = False) -> Sweep:
        return scene.sweep(
            closed,
            task.speed if moving else 0.0,
            task.acceleration if moving else 0.0,
            gravity=task.gravity if moving else None,
            loads=loads,
            workers=task.workers,
        )

    is_moving = task.speed != 0.0 or task.acceleration != 0.0
    is_heavy = _has_mass(scene.mechanism)
    # Without mass, forces in motion are those at rest.
    unit = sweep(moving=is_moving and not is_heavy)
    _check_place(setup, unit, held)
    sweeps = [unit]
    ratio = unit.motion.ratio("bearing_out")
    torque = np.broadcast_to(task.torque, ratio.shape)
    static = _of(setup, line, turns, unit).times(torque if task.at_output else torque / ratio)
    for index, name in enumerate(setup.slips if task.slipping else ()):
        spline = line.shafts[int(name.removeprefix("slip_"))].spline
        if spline is None or not spline.friction or spline.radius is None:
            continue
        friction = spline.friction / spline.radius * np.abs(static.spline_torque[..., index])
        pushed = sweep({name: 1.0, "bearing_out": 0.0})
        sweeps.append(pushed)
        static = static.plus(_of(setup, line, turns, pushed).times(-task.slipping * friction))
    moving, inertial = unit, None
    if is_heavy and (is_moving or task.gravity.any()):
        moving = sweep({"bearing_out": 0.0}, moving=True)
        inertial = _of(setup, line, turns, moving)
        sweeps.append(moving)
    even = [joint.kind == "constant_velocity" for joint in line.joints]
    motion = line_motion(moving, setup.zero, setup.slips, task.speed, task.acceleration, even)
    residuals = tuple(
        float(np.max([getattr(item, name) for item in sweeps]))
        for name in ("loop_residual", "balance_residual", "power_residual")
    )
    return _Part(motion, static, inertial, residuals)


def _check_place(setup: _Setup, sweep: Sweep, held: Mapping[str, Array]) -> None:
    """Refuse designs whose shafts are not where they are designed to be.

    Where bearings and splines nearly leave shafts free to tilt, loops can close in a second place,
    and the way from the data to a design can lead there. Misalignments have no place to compare.

    Raises:
        AssemblyError: a spline is drawn out by another length than that of the design.
    """
    none = np.zeros(1)
    tubes = {name: name.replace("tube", "shaft", 1) for name in held if name.startswith("tube_")}
    follow = all(np.array_equal(held[tube], held.get(shaft, none)) for tube, shaft in tubes.items())
    if not follow or any(name.startswith(("offset_", "support_")) for name in held):
        return
    for name in setup.slips:
        designed = held.get(f"shaft_length_{name.removeprefix('slip_')}", none)
        found = sweep.motion.position(name)
        if np.max(np.abs(found - designed)) > MEETING:
            worst = np.unravel_index(np.argmax(np.abs(found - designed)), found.shape)
            at = f" of design {worst[0]}" if found.ndim > 1 else ""
            planned = float(np.broadcast_to(designed, found.shape)[worst])
            raise AssemblyError(
                f"{name} is drawn out by {found[worst]:.6g} m{at} instead of {planned:.6g} m: the "
                "bearings leave the shafts a second place, into which they came on the way from "
                "the data; give this design as a line of its own, or support the line better"
            )


def _has_mass(mechanism: Mechanism) -> bool:
    return any(link.mass > 0.0 for link in mechanism.description.links)


def _of(setup: _Setup, line: LineData, turns: Sequence[Array], sweep: Sweep) -> LineForces:
    """Return the forces of a sweep; `turns` are the rotations to the axes of each bearing."""
    joints = range(1, line.count + 1)
    # The joint's axes at zero are turned about the driving pin against those of the shaft.
    moments_in = [
        sweep.wrench(f"pin_{k}_in", "parent").moment @ _about_y(turn).T
        for k, turn in zip(joints, setup.zero.driving, strict=True)
    ]
    moments_out = [sweep[f"pin_{k}_out"].moment for k in joints]
    forces = [sweep.wrench(name, "parent").force for name in setup.bearings]
    for first, second, distance in setup.tilting:
        pair = _pair_of_sleeve(sweep, setup.bearings[first], distance)
        forces[first], forces[second] = forces[first] + pair, forces[second] - pair
    forces = [force @ np.swapaxes(turn, -1, -2) for force, turn in zip(forces, turns, strict=True)]
    slips = [
        _in_spline(sweep[name], lever, sweep.motion.position(name))
        for name, lever in zip(setup.slips, setup.levers, strict=True)
    ]
    centrings = [sweep.wrench(f"centring_{k}", "parent").force for k in line.centred]
    empty = np.zeros((*sweep.shape, 0, 3))
    return LineForces(
        moment_in=np.stack(moments_in, axis=-2),
        moment_out=np.stack(moments_out, axis=-2),
        bearing_force=np.stack(forces, axis=-2),
        spline_force=np.stack([force for force, _ in slips], axis=-2) if slips else empty,
        spline_moment=np.stack([moment for _, moment in slips], axis=-2) if slips else empty,
        centring_force=np.stack(centrings, axis=-2) if centrings else empty,
        holding_moment=np.stack(
            [sweep.holding_effort[f"joint_angle_{k}"] for k in joints], axis=-1
        ),
        drive_torque=np.array(sweep.drive_effort),
        load_torque=np.broadcast_to(
            np.asarray(sweep.loads.get("bearing_out", 0.0)), sweep.shape
        ).astype(float),
    )


def _pair_of_sleeve(sweep: Sweep, first: str, distance: float) -> Array:
    """Return what the first bearing of a tilted end shaft lacks in force `(…, 3)`.

    Its sleeve hands the outer torque to a universal joint, which takes moments normal to its own
    axes alone. Across the tilted shaft these are a couple that no outer torque exerts.
    """
    turn_1, turn_2 = (sweep.motion.position(f"{first}.turn_{i}") for i in (1, 2))
    axis = np.stack(
        [
            np.cos(turn_1) * np.cos(turn_2),
            np.sin(turn_2),
            -np.sin(turn_1) * np.cos(turn_2),
        ],
        axis=-1,
    )
    pair = np.cross(axis, sweep.wrench(first, "parent").moment) / distance
    # A cage passes on no force along its housing; a pair along the shaft exerts no moment.
    return np.asarray(pair - (pair[..., :1] / axis[..., :1]) * axis)


def _in_spline(wrench: JointWrench, lever: float, drawn_out: Array) -> tuple[Array, Array]:
    """Return force and moment `(…, 3)` of the front on the rear piece at the spline."""
    sign, arm = 1.0, drawn_out
    if not np.isnan(lever):
        # The slip has the front piece as its child, and its origin at the joint before the spline.
        sign, arm = -1.0, np.broadcast_to(-lever, drawn_out.shape)
    moved = np.cross(arm[..., None] * [1.0, 0.0, 0.0], wrench.force)
    return sign * wrench.force, sign * (wrench.moment + moved)


def _about_y(angle: float) -> Array:
    """Return the rotation `(3, 3)` about y."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
