"""Case: the sweep that a report tells of, where its user gives none."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.description.description import JointDescription, LinkDescription
from ...core.elements.described import described_elements
from ...core.mechanism.mechanism import Mechanism
from ...core.results.sweep import Sweep
from ...kit.arrays import Array
from ...kit.errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    CardanError,
    MobilityError,
    SingularConfigurationError,
)
from ...motion.simulation.trajectory import Trajectory
from ...scene.describe import describe
from ...scene.scene import Scene
from ...scene.usual_motion import driving, one_way, slides, usual_motion
from .grids import place

STANDING = "(stands)"
"""Name of the joint beside a mechanism that cannot move; nothing hangs on it."""


class Case(NamedTuple):
    """What is computed.

    Attributes:
        mechanism: as it was loaded.
        sweep: the sweep; None if the mechanism cannot be moved or held.
        said: how it is driven and why, and what was done otherwise than asked.
        box: `(d, 2)` ranges of several drives [rad or m] that are looked through besides.
        trajectory: that it is the sweep along.
        ways: loads that act while their joints move one way, see `one_way`.
    """

    mechanism: Mechanism
    sweep: Sweep | None
    said: tuple[str, ...] = ()
    box: Array | None = None
    trajectory: Trajectory | None = None
    ways: Mapping[str, tuple[float, int]] = {}


def case_of(
    mechanism: Mechanism,
    *,
    speed: float | None = None,
    interval: tuple[float, float] | None = None,
    elements: bool = False,
    samples: int = 721,
    ways: Mapping[str, tuple[float, int]] | None = None,
    **given: Any,
) -> Case:
    """Return the case of a mechanism: as given, or else as is usual, see `usual_motion`.

    Args:
        mechanism: from `load`.
        speed: of a single drive [rad/s or m/s].
        interval: between which positions of a single drive [rad or m]; it is shortened where the
            mechanism does not get there.
        elements: whether the springs, dampers and friction of the description act.
        samples: count of positions.
        ways: efforts on joints that act while these move one way, see `one_way`.
        given: what drives and acts, see `default_scene`.

    Raises:
        ArgumentError: an interval of several drives, or an empty one.
        CardanError: as `Scene` does, of what was given.
    """
    found = describe(mechanism)
    if found.mobility <= len(found.idle_rods):  # Rods that spin about their lines need no drive.
        if interval or given.get("drive") or given.get("held"):
            raise MobilityError(
                f"{mechanism.name} cannot move: there is nothing to be driven or held", mobility=0
            )
        return _standing(mechanism, given.get("loads"), given.get("gravity"))
    try:
        motion = usual_motion(mechanism, samples=samples, **given)
    except CardanError as error:
        if any(given.get(name) for name in ("drive", "near", "held", "loads")):
            raise
        return Case(mechanism, None, (f"Nothing was computed: {error}.",))
    scene, said = motion.scene, f"As is usual: {motion.said}."
    acting = described_elements(scene.mechanism) if elements else ()
    if acting:
        scene = scene.replace(elements=acting)
    positions, remarks = motion.positions, [said]
    rate = 0.0 if not motion.turns else motion.speed if speed is None else speed
    if interval is None and not motion.turns and len(scene.drives) == 1 and not ways:
        # What moves there and back is the same on both ways at rest.
        low, high = motion.box[0].tolist()
        positions = np.linspace(low, high, samples)
        rate = speed or 0.0
    single, *others = scene.drives
    if others and (interval is not None or speed is not None):
        raise ArgumentError(
            "a range and a speed are those of a single drive; hold all but one of them"
        )
    if interval is not None:
        low, high = interval
        where = slides(scene.mechanism, single)
        if not low < high:
            raise ArgumentError(
                f"the range from {place(low, where)} to {place(high, where)} is empty"
            )
        positions, rate = np.linspace(low, high, samples), motion.speed if speed is None else speed
        remarks = [f"As asked: {single} from {place(low, where)} to {place(high, where)}."]

    def solved(positions: Array) -> Sweep:
        loads = one_way(scene, positions, rate, ways or {})
        return scene.sweep(positions, speed=rate, loads=loads)

    if others:
        box = None if ways else motion.box
        return Case(mechanism, solved(positions), tuple(remarks), box, ways=ways or {})
    try:
        sweep = solved(positions)
    except (AssemblyError, SingularConfigurationError, AccuracyError) as error:
        part = _shortened(mechanism, scene, positions, solved, remarks, error)
        return part._replace(ways=ways or {})
    if motion.turns and interval is None and given.get("loads"):
        remarks += driving(sweep)
    return Case(mechanism, sweep, tuple(remarks), ways=ways or {})


def _shortened(
    mechanism: Mechanism,
    scene: Scene,
    positions: Array,
    solved: Callable[[Array], Sweep],
    remarks: list[str],
    error: CardanError,
) -> Case:
    """Return the case over that part of a range which the mechanism reaches from its start."""
    low, high = scene.motion_range()
    asked, where = (float(positions[0]), float(positions[-1])), scene.drives[0]
    bottom, top = max(asked[0], low), min(asked[1], high)
    if bottom >= top:
        raise error
    # Wrenches grow without limit towards a dead point: the first distance that suffices is kept.
    for clear in (1e-3, 1e-2, 0.05):
        first = bottom + clear * (top - bottom) * (bottom > asked[0])
        last = top - clear * (top - bottom) * (top < asked[1])
        try:
            sweep = solved(np.linspace(first, last, len(positions)))
        except (AssemblyError, SingularConfigurationError, AccuracyError):
            continue
        of_slide = slides(scene.mechanism, where)
        shown = f"from {place(first, of_slide)} to {place(last, of_slide)}"
        why = (
            f"the mechanism does not go beyond {place(bottom, of_slide)} and {place(top, of_slide)}"
        )
        text = (
            f"The range was shortened, {shown}: {why}, towards which wrenches grow without limit."
        )
        return Case(mechanism, sweep, (*remarks, text))
    raise error


def _standing(
    mechanism: Mechanism, loads: Mapping[str, float] | None, gravity: ArrayLike | str | None
) -> Case:
    """Return the case of a mechanism that cannot move: its wrenches at rest.

    A scene needs a drive: a joint stands beside the mechanism, on which a link without mass hangs.
    """
    # The numbers of the second reading: the text, which has no such joint, is not read again.
    description = mechanism.second_reading
    eye, axis = np.eye(4), np.array([0.0, 0.0, 1.0])
    joint = JointDescription(STANDING, "continuous", description.root, STANDING, eye, axis, axis)
    beside = replace(
        description,
        links=(*description.links, LinkDescription(STANDING)),
        joints=(*description.joints, joint),
        order=(*description.order, STANDING),
        source=None,
    )
    try:
        scene = Scene(
            Mechanism(beside),
            drive=STANDING,
            loads=loads,
            gravity=gravity,
            outputs=tuple(mechanism.joints),
        )
        sweep = scene.sweep(0.0)
    except CardanError as error:
        return Case(mechanism, None, (f"Nothing was computed: {error}.",))
    return Case(
        mechanism,
        sweep,
        ("The mechanism cannot move: its wrenches at rest are those of a structure.",),
    )
