"""Frames of an SDF model: where each stands initially, and on which link."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from ....core.description.elements import check_unique, name_of, one_of
from ....kit.arrays import Array, inverse
from ....kit.errors import ModelError
from .elements import base_of, pose, text

MODEL = "__model__"
"""Name of the frame of the model itself."""
WORLD = "world"
"""Name of what stands still."""


class _Frame(NamedTuple):
    """A named frame.

    Attributes:
        base: name of the frame in which it is placed.
        placement: `(4, 4)` in that frame.
        carrier: name of the frame that it moves with; its own where it is a link.
    """

    base: str
    placement: Array
    carrier: str


class NamedFrames:
    """The frames of a model in `plain` words.

    Attributes:
        links: names of the links in file order, as keys.
        canonical: name of the link that carries the model's frame.
        further: names of the `<frame>`s in file order.
    """

    def __init__(self, model: Element, where: str, has_names: bool = True) -> None:
        """Read the frames.

        Args:
            model: the `<model>`.
            where: how messages name the source of the text.
            has_names: whether joints are frames, too; in versions before 1.7, links and joints may
                share names.

        Raises:
            ModelError: names are missing or repeated, or a pose is malformed.
        """
        self._where = where
        names = {
            tag: [name_of(item, where) for item in model.findall(tag)]
            for tag in ("link", "joint", "frame")
        }
        self._check_names(names, has_names)
        self.links = dict.fromkeys(names["link"])
        self.further = tuple(names["frame"])
        self.canonical = model.get("canonical_link") or names["link"][0]
        one_of(self.canonical, self.links, "canonical link", where)
        self._frames: dict[str, _Frame] = {}
        self._joints: dict[str, _Frame] = {}
        for tag in names:
            for item in model.findall(tag):
                self._add(item, f"{where}: {tag} {item.get('name')!r}")
        if has_names:
            self._frames |= self._joints
        self._placements = {WORLD: np.eye(4), MODEL: np.eye(4)}
        self._placements = {WORLD: np.eye(4), MODEL: self._model_placement(model)}

    def _check_names(self, names: dict[str, list[str]], has_names: bool) -> None:
        check_unique([*names["link"], *names["frame"]], "link or frame", self._where)
        check_unique(names["joint"], "joint", self._where)
        everything = [name for listed in names.values() for name in listed]
        if has_names:
            check_unique(everything, "link, joint or frame", self._where)
        for name in everything:
            if name == WORLD or (name.startswith("__") and name.endswith("__")):
                raise ModelError(f"{self._where}: the name {name!r} is reserved; choose another")
        if not names["link"]:
            raise ModelError(f"{self._where}: the model has no <link>")

    def _add(self, element: Element, at: str) -> None:
        name, carrier = element.get("name", ""), element.get("attached_to") or MODEL
        default = carrier
        if element.tag == "link":
            carrier = name
        elif element.tag == "joint":
            carrier = default = text(element, "child", "", at)
        among = self._joints if element.tag == "joint" else self._frames
        among[name] = _Frame(base_of(element) or default, pose(element, at), carrier)

    def _model_placement(self, model: Element) -> Array:
        """Return the `(4, 4)` placement of the model in the world."""
        at, base = f"{self._where}: model", base_of(model)
        if base not in ("", WORLD):
            raise ModelError(
                f"{at}: its pose is relative to {base!r}; only a pose in the world is read"
            )
        placement, placed = pose(model, at), model.get("placement_frame")
        if not placed:
            return placement
        at = f"{at}: placement_frame"
        # So far the frames are placed as if the model stood at the world's origin.
        in_model = self.placement(placed, at)
        if self._chain(placed, (MODEL, WORLD), at)[1] == WORLD:
            raise ModelError(f"{at}: {placed!r} does not move with the model")
        return np.asarray(placement @ inverse(in_model))

    def placement(self, name: str, at: str) -> Array:
        """Return the initial `(4, 4)` placement of a frame in the world.

        Raises:
            ModelError: there is no such frame, or its pose depends on itself.
        """
        chain, known = self._chain(name, self._placements, at)
        placement = self._placements[known]
        for link in reversed(chain):
            placement = placement @ self._frames[link].placement
            self._placements[link] = placement
        return placement

    def _chain(self, name: str, ends: Collection[str], at: str) -> tuple[list[str], str]:
        """Return the frames whose poses lead from one to one of `ends`, and that end."""
        chain: dict[str, None] = {}
        while name not in ends:
            if name in chain:
                raise ModelError(f"{at}: the pose of {name!r} is stated relative to itself")
            chain[name] = None
            name = self._known(name, at).base
        return list(chain), name

    def joint_placement(self, name: str, at: str) -> Array:
        """Return the initial `(4, 4)` placement of a joint's frame in the world."""
        frame = self._joints[name]
        return np.asarray(self.placement(frame.base, at) @ frame.placement)

    def link(self, name: str, at: str) -> str:
        """Return the link that a frame moves with; `WORLD` where it stands still.

        Raises:
            ModelError: there is no such frame, or it is attached to itself.
        """
        seen: set[str] = set()
        while name != WORLD and name not in self.links:
            if name == MODEL:
                return self.canonical
            if name in seen:
                raise ModelError(f"{at}: the frame {name!r} is attached to itself")
            seen.add(name)
            name = self._known(name, at).carrier
        return name

    def check(self) -> None:
        """Refuse names that lead nowhere, also those of frames that nothing refers to.

        Raises:
            ModelError: there is no such frame, or it is placed or attached in a ring.
        """
        for name in self._frames:
            at = f"{self._where}: {name!r}"
            self.placement(name, at)
            self.link(name, at)
        for name in self._joints:
            self.joint_placement(name, f"{self._where}: joint {name!r}")

    def _known(self, name: str, at: str) -> _Frame:
        if name not in self._frames:
            one_of(name, [*self._frames, MODEL, WORLD], "frame", at)
        return self._frames[name]
