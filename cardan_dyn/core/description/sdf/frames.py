"""Frames of an SDF model: where each stands initially, and on which link."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from ....kit.arrays import Array, inverse
from ....kit.errors import ModelError, choices
from ..elements import check_unique, name_of, only
from .elements import pose, text

MODEL = "__model__"
"""Name of the frame of the model itself."""
WORLD = "world"
"""Name of what stands still."""
FIRST_WITH_FRAMES = (1, 7)
"""Version from which on `relative_to`, `attached_to` and `expressed_in` name frames."""


@dataclass(frozen=True, eq=False)
class _Frame:
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
    """The frames of a model.

    Attributes:
        links: names of the links in file order, as keys.
        canonical: name of the link that carries the model's frame.
        further: names of the `<frame>`s in file order.
    """

    def __init__(
        self,
        model: ElementTree.Element,
        version: tuple[int, int],
        where: str,
        standing: Mapping[str, Array] | None = None,
    ) -> None:
        """Read the frames.

        Args:
            model: the `<model>`.
            version: of the format.
            where: how messages name the source of the text.
            standing: `(4, 4)` placements in the world of links that do not state theirs.

        Raises:
            ModelError: names are missing or repeated, or a pose is malformed.
        """
        self._version, self._where = version, where
        names = {
            tag: [name_of(item, where) for item in model.findall(tag)]
            for tag in ("link", "joint", "frame")
        }
        self._check_names(names)
        self.links = dict.fromkeys(names["link"])
        self.further = tuple(names["frame"])
        self.canonical = self._canonical(model)
        self._frames: dict[str, _Frame] = {}
        self._joints: dict[str, _Frame] = {}
        for tag in names:
            for item in model.findall(tag):
                self._add(item, f"{where}: {tag} {item.get('name')!r}")
        self._placements = {WORLD: np.eye(4), MODEL: np.eye(4)}
        self._placements[MODEL] = self._model_placement(model)
        self._placements |= standing or {}

    def _check_names(self, names: dict[str, list[str]]) -> None:
        check_unique([*names["link"], *names["frame"]], "link or frame", self._where)
        check_unique(names["joint"], "joint", self._where)
        everything = [name for listed in names.values() for name in listed]
        if self.has_names:
            check_unique(everything, "link, joint or frame", self._where)
        for name in everything:
            if name == WORLD or (name.startswith("__") and name.endswith("__")):
                raise ModelError(f"{self._where}: the name {name!r} is reserved; choose another")
        if not names["link"]:
            raise ModelError(f"{self._where}: the model has no <link>")

    def _canonical(self, model: ElementTree.Element) -> str:
        name = model.get("canonical_link") or next(iter(self.links))
        if name not in self.links:
            raise ModelError(
                f"{self._where}: canonical_link {name!r} does not exist; links: "
                f"{choices(self.links, name)}"
            )
        return name

    def _add(self, element: ElementTree.Element, at: str) -> None:
        name, carrier = element.get("name", ""), element.get("attached_to") or MODEL
        default = carrier
        if element.tag == "link":
            carrier = name
        elif element.tag == "joint":
            carrier = default = text(element, "child", "", at)
        frame = _Frame(self._base(element, at) or default, pose(element, at), carrier)
        if element.tag == "joint":
            self._joints[name] = frame
        # Before attributes could name frames, links and joints could share a name.
        if element.tag != "joint" or self.has_names:
            self._frames[name] = frame

    @property
    def has_names(self) -> bool:
        """Whether the version of the format lets attributes name frames."""
        return self._version >= FIRST_WITH_FRAMES

    def _base(self, element: ElementTree.Element, at: str) -> str:
        """Return the frame that a `<pose>` names, empty where it names none."""
        stated = only(element, "pose", at)
        if stated is None:
            return ""
        word, other = ("relative_to", "frame") if self.has_names else ("frame", "relative_to")
        if stated.get(other):
            raise ModelError(f"{at}: pose: in this version of SDF the attribute is called {word!r}")
        return stated.get(word) or ""

    def _model_placement(self, model: ElementTree.Element) -> Array:
        """Return the `(4, 4)` placement of the model in the world."""
        at = f"{self._where}: model"
        base = self._base(model, at)
        if base not in ("", WORLD):
            raise ModelError(
                f"{at}: its pose is relative to {base!r}; only a pose in the world is read"
            )
        placement = pose(model, at)
        placed = model.get("placement_frame")
        if not placed:
            return placement
        at = f"{at}: placement_frame"
        # So far the frames are placed as if the model stood at the world's origin.
        in_model = self.placement(placed, at)
        if self._chain(placed, {MODEL, WORLD}, at)[1] == WORLD:
            raise ModelError(f"{at}: {placed!r} does not move with the model")
        self._placements = {WORLD: np.eye(4)}
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
            known = [*self._frames, MODEL, WORLD]
            raise ModelError(f"{at}: no frame {name!r}; frames: {choices(known, name)}")
        return self._frames[name]
