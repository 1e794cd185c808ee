"""Results: closed positions that a scene can use again, and what a user gets of a sweep."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .coordinates import Array
from .errors import IndeterminateError
from .frozen import frozen, read_only
from .kinematics import ClosedMechanism, Kinematics
from .motion import Motion
from .pipeline import Block
from .plan import solved_couplings
from .reactions import UNIQUE_TOLERANCE
from .sweep import Solved, Sweep

if TYPE_CHECKING:
    from .scene import Scene

COMPONENTS = ("force x", "force y", "force z", "moment x", "moment y", "moment z")


@dataclass(frozen=True, eq=False)
class ClosedPositions:
    """Drive positions with their loops closed; `Scene.close` makes them for `Scene.sweep`.

    Attributes:
        scene: whose they are.
        positions: of the drives `(N, d)`.
        turns: whole turns `(N, size)` that angles lack.
        spans: samples of each block.
        blocks: what is closed, block by block.
        kinematics: what closes them.
    """

    scene: Scene
    positions: Array
    turns: Array
    spans: list[slice]
    blocks: Iterable[ClosedMechanism]
    kinematics: Kinematics

    def __post_init__(self) -> None:
        read_only(self.positions)
        read_only(self.turns)

    def __len__(self) -> int:
        return len(self.positions)

    def __reduce__(self) -> tuple[object, ...]:
        # Closing them again takes less than carrying along all that was found.
        return self.scene.close, (self.positions,)

    def __repr__(self) -> str:
        return f"<{len(self)} closed positions of {self.scene.mechanism.name!r}>"


def collected(scene: Scene, found: Block, turns: Array) -> Sweep:
    """Return what a user gets of what was solved.

    Raises:
        IndeterminateError: a wanted component is not unique, in a strict scene.
    """
    numbers = [scene.place(name) for name in scene.outputs]
    unique = read_only((found.influence < UNIQUE_TOLERANCE)[numbers])
    refuse_open(scene, unique)
    velocities, needed = scene.coordinates.velocities, scene.assembly.needed
    known = {
        name: found.efforts[:, velocities[name].start]
        for name in (*scene.drives, *scene.held)
        if needed.efforts_alone or scene.mechanism.joints[name].index - 1 in needed.complete
    }
    effort = None
    if all(name in known for name in scene.drives):
        effort = np.stack([known[name] for name in scene.drives], axis=1)
        effort = read_only(effort[:, 0] if len(scene.drives) == 1 else effort)
    motion = motion_of(scene, turns, found.x, found.v, found.a, found.transmission)
    holding = {
        name: known[name] for name in scene.held if name in known and not needed.efforts_alone
    }
    couplings = {
        number: scene.mechanism.couplings[number].name
        for number in solved_couplings(scene.assembly.groups, needed)
    }
    return Sweep(
        mechanism=scene.mechanism,
        outputs=scene.outputs,
        source=Solved(read_only(found.wrenches[:, numbers]), effort, frozen(holding), motion),
        unique=unique,
        tooth_moment=frozen({name: found.tooth[:, k] for k, name in couplings.items()}),
        tooth_unique=frozen({name: k not in found.open_couplings for k, name in couplings.items()}),
        condition=read_only(found.condition),
        loop_residual=float(np.max(found.closure)),
        balance_residual=found.residuals.balance,
        power_residual=found.residuals.power,
        rate_residual=found.residuals.rate,
        unproven=scene.pipeline.bodies.unproven,
    )


def motion_of(
    scene: Scene, turns: Array, x: Array, v: Array, a: Array, transmission: Array
) -> Motion:
    """Return a motion, given by arrays that are nobody else's.

    What was not solved is not a number in it, rather than where it happened to be.
    """
    coordinates = scene.coordinates
    skipped = set(scene.assembly.passives.tolist()) - set(scene.assembly.decided.tolist())
    for part in (v, a, transmission):
        part[:, list(skipped)] = np.nan
    for name, span in coordinates.velocities.items():
        if skipped.intersection(range(span.start, span.stop)):
            x[:, coordinates.columns[name]] = np.nan
    return Motion(scene.mechanism, coordinates, x, turns, v, a, transmission, scene.drives)


def refuse_open(scene: Scene, unique: Array) -> None:
    """Refuse what the laws of motion leave open where a scene is strict and has no compliances.

    Args:
        scene: the scene.
        unique: `(k, 6)` which components of its outputs are unique.

    Raises:
        IndeterminateError: the scene is strict and wants a component that is not unique.
    """
    if not scene.strict or scene.elastic or np.all(unique):
        return
    open_components = {
        name: [label for label, sure in zip(COMPONENTS, row, strict=True) if not sure]
        for name, row in zip(scene.outputs, unique, strict=True)
        if not np.all(row)
    }
    listed = "; ".join(f"{name}: {', '.join(labels)}" for name, labels in open_components.items())
    raise IndeterminateError(
        f"{scene.mechanism.name}: the laws of motion leave open: {listed}. Give compliances, "
        "change the mechanism (a slide, a ball) or leave strict out to have the least norm",
        components=open_components,
    )
