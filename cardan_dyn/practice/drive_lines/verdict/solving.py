"""Solving: from a line, a speed and a torque to its motion and forces, through sweeps of a scene.

All forces follow linearly from what acts at a position, so that one sweep over a few causes is
enough: a unit torque at the output at rest, whose results are multiplied by the torque; motion with
weight and without torque; and a unit force in each spline, which is multiplied by its friction
under the whole torque in it, that of inertia included. Friction does no work on the turning line,
so that it leaves the torque in splines as it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ....core.dynamics.problem_solver import AssembledPositions
from ....core.mechanism.mechanism import Mechanism
from ....core.problem.samples import targets_of
from ....core.results.sweep import Sweep
from ....core.results.wrench import JointWrench
from ....kit.arrays import Array
from ....kit.frozen import FrozenDict
from ....kit.periodic import highest
from ....scene.scene import Scene
from ..line.data import LineData
from ..line.files import units_of
from ..line.geometry import Geometry, levelled
from ..line.supports import (
    Supports,
    hangs_by_rear,
    in_order,
    spline_distance,
    supports,
)
from .analysis import Analysis, LineForces
from .coordinates import coordinates
from .half_turn import HalfTurn
from .line_motion import LineMotion, line_motion
from .variants import Adjustable, Variants

_Moved = Mapping[Adjustable, Array]
"""Adjustable joints to their positions `(d, 1)` in some designs, which count from the data."""
_BLOCK, _BLOCK_OF_ONE = 10_000, 50_000
"""Samples times joints that are closed at a time: of designs, some 10 kilobytes for each; of one
line, some 5, where each block would follow the line's motion anew."""
_FEWEST, _MOST = 96, 6144
"""Positions of a turn that forces are known at: the fewest determine those of joints at 30°."""
_SMOOTH = 2e-10
"""Highest harmonics that are nothing, relative to the greatest force: positions are enough."""
_NOTHING = 2e-13
"""Rounding of inertial forces, relative to those of all masses at the greatest distance."""


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
    """

    speed: float
    acceleration: float
    torque: Array
    at_output: bool
    positions: Array
    gravity: Array
    slipping: int
    variants: Variants | None


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
        is_heavy: whether any part has mass.
    """

    scene: Scene
    seats: tuple[_Seat, ...]
    tilting: tuple[tuple[int, int, float], ...]
    slips: tuple[_Slip, ...]
    is_heavy: bool


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


class Causes(NamedTuple):
    """What the forces of a turn are made of, at equal steps that determine them all over it.

    Attributes:
        bearings: names, see `Analysis`.
        splines: likewise.
        indeterminate: likewise.
        parts: per torque of the input shaft [1/(N·m)]; of lines with mass besides per square of the
            speed, per angular acceleration of the input shaft, and those of the weight.
        slides: for each spline with friction its name, and what its friction adds to each of the
            parts where it acts with the torque in the spline. Its size is that of all parts
            together: where that torque is negative, friction as smooth a function acts against it.
        is_open: names of `extremes.COMPONENTS` to `(k,)` which of its places statics leaves open.
    """

    bearings: tuple[str, ...]
    splines: tuple[str, ...]
    indeterminate: tuple[str, ...]
    parts: tuple[LineForces, ...]
    slides: tuple[tuple[str, tuple[LineForces, ...]], ...]
    is_open: Mapping[str, Array]

    @property
    def is_heavy(self) -> bool:
        """Whether any part has mass."""
        return len(self.parts) > 1


class LineSolver:
    """Solves a line; its scenes are made once, whatever is asked for how often.

    Attributes:
        line: the line.
        mechanism: the line as a mechanism.
    """

    def __init__(self, line: LineData, mechanism: Mechanism) -> None:
        self.line, self.mechanism = line, mechanism
        # By the names of the joints that designs move. Two threads may both make one: either's is
        # as good.
        self._setups: dict[tuple[str, ...], _Setup] = {}

    def analysed(self, task: Task) -> Analysis:
        """Return the analysis of the line."""
        line, setup = self.line, self._setup(() if task.variants is None else task.variants.moved)
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
            units=units_of(line),
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

    def causes(self, gravity: Array) -> Causes:
        """Return what the forces of a turn are made of.

        Args:
            gravity: `(3,)` in which the weight is that of the line [m/s²].
        """
        count, setup = _FEWEST, self._setup(())
        while True:
            found = _causes(setup, self.line, count, gravity)
            if count >= _MOST or self._is_smooth(found, float(np.linalg.norm(gravity))):
                return found
            count *= 2

    def _is_smooth(self, causes: Causes, gravity: float) -> bool:
        """Return whether the positions determine the forces between them.

        That is, whether the highest harmonics that they can have are nothing.
        """
        length = self.mechanism.characteristic_length
        mass = sum(link.mass for link in self.mechanism.description.links)
        scales = (0.0, mass * length**2, mass * length**2, mass * gravity * length)
        for parts in (causes.parts, *(parts for _, parts in causes.slides)):
            for part, scale in zip(parts, scales, strict=False):
                # Forces are compared with moments by the length of the line.
                every = [
                    length * values if name.endswith("_force") else values
                    for name, values in part._asdict().items()
                ]
                most = max(float(np.abs(values).max(initial=0.0)) for values in every)
                nothing = max(_SMOOTH * most, _NOTHING * scale)
                if any(highest(values).max(initial=0.0) > nothing for values in every):
                    return False
        return True

    def _setup(self, moved: Iterable[Adjustable]) -> _Setup:
        """Return the scene for designs that move some joints."""
        moved = tuple(moved)
        names = tuple(joint.name for joint in moved)
        if names not in self._setups:
            self._setups[names] = _setup(self.line, self.mechanism, moved)
        return self._setups[names]


def _setup(line: LineData, mechanism: Mechanism, moved: Sequence[Adjustable]) -> _Setup:
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
    is_heavy = any(link.mass > 0.0 for link in mechanism.description.links)
    return _Setup(scene, tuple(seats), tilting, tuple(slips), is_heavy)


def _sleeves(
    held_by: Supports, seats: Sequence[_Seat], ends: tuple[int, int]
) -> tuple[tuple[int, int, float], ...]:
    """Return the first two bearings on the sleeves of end shafts; see `_Setup.tilting`."""
    found, names = [], [seat.name for seat in seats]
    for shaft in ends:
        on_shaft = in_order(held_by, shaft)
        if len(on_shaft) > 1:
            first, second = (names.index(item.name) for item in on_shaft[:2])
            found.append((first, second, on_shaft[1].along - on_shaft[0].along))
    return tuple(found)


def _blocks(line: LineData, task: Task) -> Iterator[tuple[Task, _Moved]]:
    """Yield the task for some positions at a time, or for all of them and some designs."""
    size = _BLOCK_OF_ONE if task.variants is None else _BLOCK
    causes = 2 + sum(shaft.spline is not None for shaft in line.shafts)
    most = max(1, size // (line.count * causes))
    if task.variants is None:
        for start in range(0, len(task.positions), most):
            chosen = slice(start, start + most)
            torque = task.torque[chosen] if task.torque.ndim else task.torque
            yield task._replace(positions=task.positions[chosen], torque=torque), {}
        return
    size = max(1, most // len(HalfTurn.of(task.positions).positions))
    for start in range(0, task.variants.designs, size):
        chosen = slice(start, min(start + size, task.variants.designs))
        moved = task.variants.moved.items()
        yield task, {joint: values[chosen, None] for joint, values in moved}


class _Cause(NamedTuple):
    """What acts while the line turns.

    Attributes:
        torque: that the output shaft passes on [N·m].
        speed: of the input shaft [rad/s].
        acceleration: likewise [rad/s²].
        gravity: `(3,)` [m/s²].
        pushed: joint of the spline in which a unit force acts.
    """

    torque: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    gravity: Array = np.zeros(3)
    pushed: str = ""


class _Effects(NamedTuple):
    """What some causes do, each by itself.

    Attributes:
        half_turn: how all positions follow from those of the sweep.
        sweep: causes × samples.
        forces: of each cause.
        ratio: speed of the output shaft over that of the input shaft.
    """

    half_turn: HalfTurn
    sweep: Sweep
    forces: list[LineForces]
    ratio: Array


def _effects(
    setup: _Setup,
    line: LineData,
    positions: Array,
    causes: Sequence[_Cause],
    moved: _Moved | None = None,
) -> _Effects:
    """Return what causes do at positions `(P,)`, or at designs × positions where any are moved."""
    scene, half_turn = setup.scene, HalfTurn.of(positions)
    shape: tuple[int, ...] = half_turn.positions.shape
    if moved is not None:
        shape = max((len(values) for values in moved.values()), default=1), *shape
    every = np.broadcast_to(half_turn.positions, (len(causes), *shape))
    moved = moved or {}
    held = {joint.name: values for joint, values in moved.items()}
    known = coordinates(line, every[0], moved)
    at = every if known is None else closed_near(scene, every, held, known)

    def of_each(values: Sequence[float]) -> Array:
        return np.reshape(values, (-1, *(1 for _ in shape)))

    loads = {"bearing_out": of_each([-cause.torque for cause in causes])}
    loads |= {
        name: of_each([float(cause.pushed == name) for cause in causes])
        for name in {cause.pushed for cause in causes if cause.pushed}
    }
    sweep = scene.sweep(
        at,
        of_each([cause.speed for cause in causes]),
        of_each([cause.acceleration for cause in causes]),
        held=held if known is None else None,
        loads=loads,
        gravity=np.reshape([cause.gravity for cause in causes], (-1, *(1 for _ in shape), 3)),
    )
    axes = _bearing_axes(line.geometry, moved, setup.seats)
    turns = list(np.swapaxes(axes, 0, 1) if len(shape) > 1 else axes[0])
    found = _of(setup, line, turns, sweep)
    forces = [
        half_turn.forces(LineForces(*(values[index] for values in found)))
        for index in range(len(causes))
    ]
    ratio = half_turn.same(sweep.motion.ratio("bearing_out")[0], 0)
    return _Effects(half_turn, sweep, forces, ratio)


def closed_near(
    scene: Scene, positions: Array, held: Mapping[str, Array], known: Mapping[str, Array]
) -> AssembledPositions:
    """Return positions for a sweep, closed from where a closed form says that joints stand.

    Args:
        scene: of a line.
        positions: of the drive.
        held: held joints to their positions.
        known: see `coordinates`.
    """
    targets = targets_of(scene.solver.problem, positions, held)
    # As scenes do: what overflows is refused where it is used.
    with np.errstate(over="ignore", invalid="ignore"):
        return scene.solver.of_varied(targets.varied).assembled_at(targets, known)


def _solved(
    setup: _Setup, line: LineData, task: Task, moved: _Moved
) -> tuple[LineMotion, LineForces, LineForces | None, tuple[float, ...]]:
    """Return motion, static and inertial forces, and residuals of a block of samples."""
    moving = _Cause(speed=task.speed, acceleration=task.acceleration, gravity=task.gravity)
    is_moving = task.speed != 0.0 or task.acceleration != 0.0
    has_inertial = setup.is_heavy and (is_moving or bool(task.gravity.any()))
    # Without mass, forces in motion are those at rest.
    causes = [_Cause(1.0), moving] if has_inertial else [moving._replace(torque=1.0)]
    frictions = _frictions(setup, line) if task.slipping else {}
    causes += [_Cause(pushed=setup.slips[index].joint) for index in frictions]
    found = _effects(setup, line, task.positions, causes, moved if task.variants else None)
    forces = iter(found.forces)
    torque = np.broadcast_to(task.torque, found.ratio.shape)
    static = next(forces).times(torque if task.at_output else torque / found.ratio)
    inertial = next(forces) if has_inertial else None
    for (index, per_torque), pushed in zip(frictions.items(), forces, strict=True):
        drawn = pushed.times(np.asarray(-task.slipping * per_torque))
        alone = np.abs(static.spline_torque[..., index])
        if inertial is not None:
            both = np.abs(static.spline_torque + inertial.spline_torque)[..., index]
            inertial = inertial.plus(drawn.times(both - alone))
        static = static.plus(drawn.times(alone))
    slips = [slip.joint for slip in setup.slips]
    rates = task.speed, task.acceleration
    motion = line_motion(found.sweep, int(has_inertial), line, slips, *rates)
    residuals = tuple(
        float(np.max(getattr(found.sweep, name)))
        for name in ("loop_residual", "balance_residual", "power_residual")
    )
    return found.half_turn.motion(motion), static, inertial, residuals


def _frictions(setup: _Setup, line: LineData) -> dict[int, float]:
    """Return splines with friction, and its force per torque [1/m]."""
    splines = [line.shafts[slip.shaft].spline for slip in setup.slips]
    return {
        index: spline.friction / spline.radius
        for index, spline in enumerate(splines)
        if spline is not None and spline.friction and spline.radius is not None
    }


def _causes(setup: _Setup, line: LineData, count: int, gravity: Array) -> Causes:
    """Return what forces are made of at equal steps of a turn; see `LineSolver.causes`."""
    causes = [_Cause(1.0)]
    if setup.is_heavy:
        causes += [_Cause(speed=1.0), _Cause(acceleration=1.0), _Cause(gravity=gravity)]
    parts_of, frictions = len(causes), _frictions(setup, line)
    causes += [_Cause(pushed=setup.slips[index].joint) for index in frictions]
    found = _effects(setup, line, np.linspace(0.0, 2.0 * np.pi, count, endpoint=False), causes)
    parts = [found.forces[0].times(1.0 / found.ratio), *found.forces[1:parts_of]]
    names = tuple(line.shaft_names[slip.shaft] for slip in setup.slips)
    slides = []
    for (index, per_torque), pushed in zip(frictions.items(), found.forces[parts_of:], strict=True):
        drawn = pushed.times(np.asarray(-per_torque))
        added = tuple(drawn.times(part.spline_torque[..., index]) for part in parts)
        slides.append((names[index], added))
    return Causes(
        bearings=tuple(seat.name for seat in setup.seats),
        splines=names,
        indeterminate=supports(line).indeterminate,
        parts=tuple(parts),
        slides=tuple(slides),
        is_open=_open_places(setup, line, found.sweep),
    )


def _open_places(setup: _Setup, line: LineData, sweep: Sweep) -> dict[str, Array]:
    """Return which forces of a sweep statics leaves open; see `Causes`."""
    # In the axes of its place the first component of a bearing's force is the one along its shaft.
    unique = [sweep.wrench(seat.joint, "parent").unique[:3] for seat in setup.seats]
    within = [sweep.wrench(f"centring_{k}", "parent").unique[:3] for k in line.centred]
    return {
        "bearing_axial": np.array([not flags[0] for flags in unique]),
        "bearing_radial": np.array([not flags[1:].all() for flags in unique]),
        "centring": np.array([not flags.all() for flags in within], dtype=bool),
    }


def _of(setup: _Setup, line: LineData, turns: Sequence[Array], sweep: Sweep) -> LineForces:
    """Return the forces of a sweep; `turns` are the rotations to the axes of each bearing."""
    joints = range(1, line.count + 1)
    # The joint's axes at zero are turned about the driving pin against those of the shaft.
    moments_in = [
        sweep.wrench(f"pin_{k}_in", "parent").moment @ turn.T
        for k, turn in zip(joints, _about(1, line.zero.driving), strict=True)
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

    def side_by_side(vectors: Sequence[Array]) -> Array:
        return np.stack(vectors, axis=-2) if vectors else np.zeros((*sweep.shape, 0, 3))

    return LineForces(
        moment_in=side_by_side(moments_in),
        moment_out=side_by_side(moments_out),
        bearing_force=side_by_side(forces),
        spline_force=side_by_side([force for force, _ in slips]),
        spline_moment=side_by_side([moment for _, moment in slips]),
        centring_force=side_by_side(centrings),
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
        level = np.array([levelled(axis) for axis in frame[:, :, 0]])
        axes.append(np.swapaxes(level, 1, 2) @ frame @ _about(0, np.array([seat.turned])))
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
    """Return rotations `(D, 3, 3)` about x (0), y (1) or z (2)."""
    result = np.zeros((len(angles), 3, 3))
    one, two = (axis + 1) % 3, (axis + 2) % 3
    result[:, axis, axis] = 1.0
    result[:, one, one] = result[:, two, two] = np.cos(angles)
    result[:, two, one], result[:, one, two] = np.sin(angles), -np.sin(angles)
    return result
