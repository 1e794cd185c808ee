"""Description: what a file says about a mechanism, checked, as plain data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio


@dataclass(frozen=True, eq=False)
class SourceText:
    """Where a description comes from, for what is read only when it is shown.

    Attributes:
        text: the whole text.
        path: the file, beside which meshes are found; None for text.
    """

    text: str
    path: Path | None


@dataclass(frozen=True, eq=False)
class LoopDescription:
    """A closure between two links, in URDF+ notation.

    Attributes:
        name: name of the joint that the loop is.
        type: one of `LOOP_TYPES`.
        predecessor, successor: names of the two links.
        predecessor_origin, successor_origin: `(4, 4)` placements of the joint frame in the links
            [m]. The coordinate is zero where both coincide.
        axis: `(3,)` unit vector in the joint frame.
        axis_2: `(3,)` second axis of a `universal` joint, normal to the first; else the first.
    """

    name: str
    type: str
    predecessor: str
    successor: str
    predecessor_origin: np.ndarray
    successor_origin: np.ndarray
    axis: np.ndarray
    axis_2: np.ndarray


@dataclass(frozen=True, eq=False)
class CouplingDescription:
    """A gear, in URDF+ notation.

    The rotation of the successor is `ratio` times that of the predecessor, both summed up over
    the joints from their nearest common ancestor.
    """

    name: str
    predecessor: str
    successor: str
    ratio: float


@dataclass(frozen=True, eq=False)
class Description:
    """A checked description.

    Attributes:
        name: name of the mechanism.
        tree: builds Pinocchio's model of the spanning tree.
        links: names of the links in file order.
        joints: names of the tree joints to their types.
        axes: `(3,)` unit axis of each tree joint in its joint frame.
        loops: the closures in file order.
        couplings: the gears in file order.
        independent: names of the joints that its author drives.
        notation: how the loops were written, and what else was found.
        remarks: what is wrong with it and was accepted.
        source: its text and file.
    """

    name: str
    tree: Callable[[], pinocchio.Model]
    links: tuple[str, ...]
    joints: dict[str, str]
    axes: dict[str, np.ndarray]
    loops: tuple[LoopDescription, ...]
    couplings: tuple[CouplingDescription, ...] = ()
    independent: tuple[str, ...] = ()
    notation: str = "URDF+"
    remarks: tuple[str, ...] = ()
    source: SourceText | None = None
