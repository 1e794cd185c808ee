"""Results: closed positions that a scene can use again, and what a user gets of a sweep."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .coordinates import Array
from .errors import IndeterminateError
from .kinematics import ClosedMechanism, Kinematics
from .motion import Motion
from .pipeline import Block
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

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        return f"<{len(self)} closed positions of {self.scene.mechanism.name!r}>"


def collected(scene: Scene, found: Block, turns: Array) -> Sweep:
    """Return what a user gets of what was solved.

    Raises:
        IndeterminateError: a wanted component is not unique, in a strict scene.
    """
    numbers = [scene.place(name) for name in scene.outputs]
    unique = (found.influence < UNIQUE_TOLERANCE)[numbers]
    if scene.strict and not (scene.elastic or np.all(unique)):
        _refuse(scene, unique)
    velocities, needed = scene.coordinates.velocities, scene.assembly.needed
    known = {
        name: found.efforts[:, velocities[name].start]
        for name in (*scene.drives, *scene.held)
        if needed.efforts_alone or scene.mechanism.joints[name].index - 1 in needed.complete
    }
    effort = None
    if all(name in known for name in scene.drives):
        effort = np.stack([known[name] for name in scene.drives], axis=1)
        effort = effort[:, 0] if len(scene.drives) == 1 else effort
    # What was not solved is not a number, rather than where it happened to be.
    skipped = set(scene.assembly.passives.tolist()) - set(scene.assembly.decided.tolist())
    for part in (found.v, found.a, found.transmission):
        part[:, list(skipped)] = np.nan
    for columns, span in zip(scene.coordinates.columns.values(), velocities.values(), strict=True):
        if set(range(span.start, span.stop)).intersection(skipped):
            found.x[:, columns] = np.nan
    motion = Motion(
        scene.mechanism,
        scene.coordinates,
        found.x,
        turns,
        found.v,
        found.a,
        found.transmission,
    )
    holding = {
        name: known[name] for name in scene.held if name in known and not needed.efforts_alone
    }
    couplings = scene.mechanism.couplings
    return Sweep(
        mechanism=scene.mechanism,
        solver=scene.reactions,
        outputs=scene.outputs,
        source=Solved(found.wrenches[:, numbers], effort, holding, motion),
        unique=unique,
        tooth_moment={item.name: found.tooth[:, k] for k, item in enumerate(couplings)},
        tooth_unique={
            item.name: number not in found.open_couplings for number, item in enumerate(couplings)
        },
        condition=found.condition,
        loop_residual=float(np.max(found.closure)),
        balance_residual=found.residuals.balance,
        power_residual=found.residuals.power,
    )


def _refuse(scene: Scene, unique: Array) -> None:
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
