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

from ...arrays import Array
from ...errors import AssemblyError
from ...frozen import FrozenDict
from ...mechanism.mechanism import Mechanism
from ...results.sweep import Sweep
from ...results.wrench import JointWrench
from ...scene.scene import Scene
from ..line.data import LineData
from ..line.geometry import MEETING, Geometry, leftwards
from ..line.supports import Supports, hangs_by_rear, spline_distance, supports
from .analysis import Analysis, LineForces
from .line_motion import LineMotion, line_motion
from .variants import Adjustable, Variants

_Moved = Mapping[Adjustable, Array]
"""Adjustable joints to their positions `(d, 1)` in some designs, which count from the data."""
_BLOCK, _BLOCK_OF_ONE = 10_000, 50_000
"""Samples times joints that are closed at a time: of designs, some 10 kilobytes for each; of one
line, some 5, where each block would follow the line's motion anew."""


class Task(NamedTuple):
    """What is asked for.

    Attributes:
        speed: of the input shaft [rad/s].
        acceleration: of the input shaft [rad/s²].
        torque: `()` or `(P,)` [N·m].
        at_output: whether the torque is that of the output shaft, not of the input shaft.
        positions: `(P,)` of the input shaft [rad].
        gravity: `(3,)` [m/s²].
        slipping: 1 if splines are drawn out, -1 if they are pushed in, 0 without friction.
        variants: designs; None for the line as it is.
        workers: see `Scene.sweep`.
    """

    speed: float
    acceleration: float
    torque: Array
    at_output: bool
    positions: Array
    gravity: Array
    slipping: int
    variants: Variants | None
    workers: int


class _Seat(NamedTuple):
    """Where the force of a bearing is read.

    Attributes:
        joint: of the description, whose force is that of the bearing.
        name: of the bearing, as results tell it.
        shaft: index of its shaft.
        turned: how far its place is turned about the shaft in the data [rad].
    """

    joint: str
    name: str
    shaft: int
    turned: float = 0.0


class _Slip(NamedTuple):
    """Where what acts in a spline is read.

    Attributes:
        joint: of the description.
        shaft: index of its shaft.
        lever: distance from where the joint has its origin to the spline [m]; NaN where that is the
            spline, and the joint's child is the rear piece.
    """

    joint: str
    shaft: int
    lever: float


class _Setup(NamedTuple):
    """A scene of a line, and where its results are found.

    Attributes:
        scene: with a unit torque at the output.
        seats: of all bearings.
        tilting: of end shafts that misaligned bearings tilt, the first bearing, which keeps the
            sleeve from turning, another one, and their distance along the flow [m].
        slips: of all splines.
    """

    scene: Scene
    seats: tuple[_Seat, ...]
    tilting: tuple[tuple[int, int, float], ...]
    slips: tuple[_Slip, ...]


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
    blocks: list[tuple[Array, ...]] = []
    means, residuals = [], []
    for block, moved in _blocks(line, task):
        motion, static, inertial, residual = _solved(setup, line, block, moved)
        blocks.append((*motion[:4], *static, *(inertial or ())))
        means.append(motion.mean_lead)
        residuals.append(residual)
    # Array by array, so that no more than one is there twice.
    columns = [list(column) for column in zip(*blocks, strict=True)]
    del blocks
    arrays = [np.concatenate(columns.pop(0)) for _ in range(len(columns))]
    rotation, ratio, acceleration, slip = arrays[:4]
    size = len(LineForces._fields)
    forces = [LineForces(*arrays[i : i + size]) for i in range(4, len(arrays), size)]
    loop, balance, power = np.max(residuals, axis=0).tolist()
    return Analysis(
        name=line.name,
        shafts=line.shaft_names,
        joints=line.joint_names,
        bearings=tuple(seat.name for seat in setup.seats),
        centrings=tuple(line.shaft_names[k] for k in line.centred),
        splines=tuple(line.shaft_names[slip.shaft] for slip in setup.slips),
        speed=task.speed,
        position=task.positions,
        moved=task.variants.moved if task.variants else FrozenDict({}),
        rotation=rotation,
        ratio=ratio,
        acceleration=acceleration,
        static=forces[0],
        inertial=forces[1] if len(forces) > 1 else None,
        slip=slip,
        mean_lead=means[-1] if task.variants is None else np.concatenate(means),
        indeterminate=supports(line).indeterminate,
        loop_residual=loop,
        balance_residual=balance,
        power_residual=power,
    )


def _setup(line: LineData, mechanism: Mechanism, task: Task) -> _Setup:
    """Return the scene, with all joint angles held and what varies from design to design."""
    held_by = supports(line)
    seats = [_Seat(item.joint, item.name, item.shaft) for item in held_by.bearings]
    # What turns on its place alone stands there as its pins do, and bearings straight.
    seats += [
        _Seat(name, name, shaft, float(line.zero.rotations[shaft]))
        for shaft, name in ((0, "bearing_in"), (line.count, "bearing_out"))
        if not line.shafts[shaft].bearings
    ]
    seats.sort(key=lambda seat: seat.shaft)
    moved = [] if task.variants is None else list(task.variants.moved)
    is_tilted = any(joint.kind in ("support_y", "support_z") for joint in moved)
    tilting = _sleeves(held_by, seats, (0, line.count)) if is_tilted else ()
    slips = [
        _Slip(f"slip_{k}", k, spline_distance(line, k) if hangs_by_rear(held_by, k) else np.nan)
        for k, shaft in enumerate(line.shafts)
        if shaft.spline
    ]
    pins = [f"pin_{k}_{side}" for k in range(1, line.count + 1) for side in ("in", "out")]
    held = {f"joint_angle_{k}": 0.0 for k in range(1, line.count + 1)}
    sliding = [slip.joint for slip in slips]
    wanted = [*pins, *(seat.joint for seat in seats), *sliding]
    wanted += [*(f"centring_{k}" for k in line.centred), *held, "bearing_in", "bearing_out"]
    scene = scene_of(
        line,
        mechanism,
        held=held | {joint.name: 0.0 for joint in moved},
        loads={"bearing_out": -1.0, **dict.fromkeys(sliding, 0.0)},
        outputs=list(dict.fromkeys(wanted)),
    )
    return _Setup(scene, tuple(seats), tilting, tuple(slips))


def _sleeves(
    held_by: Supports, seats: Sequence[_Seat], ends: tuple[int, int]
) -> tuple[tuple[int, int, float], ...]:
    """Return the first two bearings on the sleeves of end shafts; see `_Setup.tilting`."""
    found, names = [], [seat.name for seat in seats]
    for shaft in ends:
        # In the order in which the closed chain takes them.
        on_shaft = [item for item in held_by.bearings if item.shaft == shaft]
        on_shaft.sort(key=lambda item: not item.locating)
        if len(on_shaft) > 1:
            first, second = (names.index(item.name) for item in on_shaft[:2])
            apart = on_shaft[1].distance - on_shaft[0].distance
            found.append((first, second, apart if shaft else -apart))
    return tuple(found)


def _blocks(line: LineData, task: Task) -> Iterator[tuple[Task, _Moved]]:
    """Yield the task for some positions at a time, or for all of them and some designs."""
    size = _BLOCK_OF_ONE if task.variants is None else _BLOCK
    most = max(1, size // line.count)
    if task.variants is None:
        for start in range(0, len(task.positions), most):
            chosen = slice(start, start + most)
            torque = task.torque[chosen] if task.torque.ndim else task.torque
            yield task._replace(positions=task.positions[chosen], torque=torque), {}
        return
    size = max(1, most // len(task.positions))
    for start in range(0, task.variants.designs, size):
        chosen = slice(start, min(start + size, task.variants.designs))
        moved = task.variants.moved.items()
        yield task, {joint: values[chosen, None] for joint, values in moved}


def _solved(
    setup: _Setup, line: LineData, task: Task, moved: _Moved
) -> tuple[LineMotion, LineForces, LineForces | None, tuple[float, ...]]:
    """Return motion, static and inertial forces, and residuals of a block of samples."""
    scene = setup.scene
    # Designs × positions, even where there is one design or nothing varies.
    count = max((len(values) for values in moved.values()), default=1)
    is_grid = task.variants is not None
    positions = np.broadcast_to(task.positions, (count, len(task.positions)))
    held = {joint.name: values for joint, values in moved.items()}
    closed = scene.assemble(positions if is_grid else task.positions, held=held)
    axes = _bearing_axes(line.geometry, moved, setup.seats)
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
    is_heavy = any(link.mass > 0.0 for link in scene.mechanism.description.links)
    # Without mass, forces in motion are those at rest.
    unit = sweep(moving=is_moving and not is_heavy)
    _check_place(setup, unit, moved)
    sweeps = [unit]
    ratio = unit.motion.ratio("bearing_out")
    torque = np.broadcast_to(task.torque, ratio.shape)
    static = _of(setup, line, turns, unit).times(torque if task.at_output else torque / ratio)
    for index, slip in enumerate(setup.slips if task.slipping else ()):
        spline = line.shafts[slip.shaft].spline
        if spline is None or not spline.friction or spline.radius is None:
            continue
        friction = spline.friction / spline.radius * np.abs(static.spline_torque[..., index])
        pushed = sweep({slip.joint: 1.0, "bearing_out": 0.0})
        sweeps.append(pushed)
        static = static.plus(_of(setup, line, turns, pushed).times(-task.slipping * friction))
    moving, inertial = unit, None
    if is_heavy and (is_moving or task.gravity.any()):
        moving = sweep({"bearing_out": 0.0}, moving=True)
        inertial = _of(setup, line, turns, moving)
        sweeps.append(moving)
    slips = [slip.joint for slip in setup.slips]
    motion = line_motion(moving, line, slips, task.speed, task.acceleration)
    residuals = tuple(
        float(np.max([getattr(item, name) for item in sweeps]))
        for name in ("loop_residual", "balance_residual", "power_residual")
    )
    return motion, static, inertial, residuals


def _check_place(setup: _Setup, sweep: Sweep, moved: _Moved) -> None:
    """Refuse designs whose shafts are not where they are designed to be.

    Where bearings and splines nearly leave shafts free to tilt, loops can close in a second place,
    and the way from the data to a design can lead there. Misalignments have no place to compare.
    """
    lengths = {joint.of: item for joint, item in moved.items() if joint.kind == "shaft_length"}
    tubes = {joint.of: item for joint, item in moved.items() if joint.kind == "tube_length"}
    none = np.zeros(1)
    follow = all(np.array_equal(item, lengths.get(k, none)) for k, item in tubes.items())
    if not follow or any(joint.misaligns for joint in moved):
        return
    for slip in setup.slips:
        designed = lengths.get(slip.shaft, none)
        found = sweep.motion.position(slip.joint)
        if np.max(np.abs(found - designed)) > MEETING:
            worst = np.unravel_index(np.argmax(np.abs(found - designed)), found.shape)
            at = f" of design {worst[0]}" if found.ndim > 1 else ""
            planned = float(np.broadcast_to(designed, found.shape)[worst])
            raise AssemblyError(
                f"{slip.joint} is drawn out by {found[worst]:.6g} m{at} instead of {planned:.6g} "
                "m: the bearings leave the shafts a second place, into which they came on the way "
                "from the data; give this design as a line of its own, or support the line better"
            )


def _of(setup: _Setup, line: LineData, turns: Sequence[Array], sweep: Sweep) -> LineForces:
    """Return the forces of a sweep; `turns` are the rotations to the axes of each bearing."""
    joints = range(1, line.count + 1)
    # The joint's axes at zero are turned about the driving pin against those of the shaft.
    moments_in = [
        sweep.wrench(f"pin_{k}_in", "parent").moment @ _about_y(turn).T
        for k, turn in zip(joints, line.zero.driving, strict=True)
    ]
    moments_out = [sweep[f"pin_{k}_out"].moment for k in joints]
    forces = [sweep.wrench(seat.joint, "parent").force for seat in setup.seats]
    for first, second, distance in setup.tilting:
        pair = _pair_of_sleeve(sweep, setup.seats[first].joint, distance)
        forces[first], forces[second] = forces[first] + pair, forces[second] - pair
    forces = [force @ np.swapaxes(turn, -1, -2) for force, turn in zip(forces, turns, strict=True)]
    slips = [
        _in_spline(sweep[slip.joint], slip.lever, sweep.motion.position(slip.joint))
        for slip in setup.slips
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
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])


def _bearing_axes(found: Geometry, moved: _Moved, seats: Sequence[_Seat]) -> Array:
    """Return rotations from the axes of each bearing's place to along, left and up.

    Joint angles and planes turn the places of all shafts behind them. Misalignments do not: a
    bearing's axes are those of its housing.

    Returns:
        `(D, m, 3, 3)`, or `(1, m, 3, 3)` if no design turns them.
    """
    frames = found.frames[:, None]
    if any(joint.kind in ("joint_angle", "joint_plane") for joint in moved):
        frames = _frames(found, moved)
    axes = []
    for seat in seats:
        frame = frames[seat.shaft]
        along, left = frame[:, :, 0], np.array([leftwards(axis) for axis in frame[:, :, 0]])
        housing = np.stack([along, left, np.cross(along, left)], axis=1)
        axes.append(housing @ frame @ _about(0, np.array([seat.turned])))
    return np.stack(axes, axis=1)


def _frames(found: Geometry, moved: _Moved) -> Array:
    """Return the frames of all shafts in each design `(n + 1, D, 3, 3)`; see `Geometry`."""
    count = max(len(values) for values in moved.values())
    none = np.zeros((count, 1))
    frames = [np.broadcast_to(found.frames[0], (count, 3, 3))]
    nominal = zip(found.plane_offsets, found.joint_angles, strict=True)
    for k, (plane, angle) in enumerate(nominal, 1):
        planes = plane + moved.get(Adjustable("joint_plane", k), none)[:, 0]
        angles = angle + moved.get(Adjustable("joint_angle", k), none)[:, 0]
        frames.append(frames[-1] @ _about(0, planes) @ _about(2, angles))
    return np.stack(frames)


def _about(axis: int, angles: Array) -> Array:
    """Return rotations `(D, 3, 3)` about x (0) or z (2)."""
    result = np.zeros((len(angles), 3, 3))
    one, two = (axis + 1) % 3, (axis + 2) % 3
    result[:, axis, axis] = 1.0
    result[:, one, one] = result[:, two, two] = np.cos(angles)
    result[:, two, one], result[:, one, two] = np.sin(angles), -np.sin(angles)
    return result
