"""Mechanism report: what `cd.describe` found, as text and as HTML."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar

from ..core.mechanism.configuration import Configuration
from ..core.mechanism.mechanism import Mechanism
from ..core.mechanism.undescribed import REMEDY
from ..kit.errors import ArgumentError, choices
from .drives import Drives, drives_of

_Said = TypeVar("_Said", bound=Hashable)


@dataclass(frozen=True)
class LoopReport:
    """One loop.

    Attributes:
        name: of its joint.
        type: of its joint.
        rank: how many of its six closure equations are independent, those of other loops aside.
        indeterminate: joint to the components (`x y z` of force, then of moment, in its frame)
            that are statically indeterminate because of it; None if the component is too large for
            that to be measured.
    """

    name: str
    type: str
    rank: int
    indeterminate: dict[str, str] | None

    @property
    def redundant(self) -> int:
        """Number of rows that are redundant whatever other loops are."""
        return 6 - self.rank

    @property
    def leaves_open(self) -> str:
        """What the redundant rows leave open, in one line."""
        if self.indeterminate is None:
            return "not examined"
        return "; ".join(f"{joint}: {what}" for joint, what in self.indeterminate.items())


@dataclass(frozen=True)
class ComponentReport:
    """Loops and couplings that have no joint in common with any others.

    Attributes:
        loops: their names.
        couplings: their names.
        coordinates: number of joint coordinates on them.
        rank: number of independent closure equations in generic closed configurations.
        rank_at_zero: their number at the zero of the description, or where the loops are assembled
            near it, or in the configuration that was described; less than `rank` where that is a
            singular configuration.
        is_counted: whether the ranks were counted from the structure alone, which misses
            mechanisms that move only because of special dimensions.
    """

    loops: tuple[str, ...]
    couplings: tuple[str, ...]
    coordinates: int
    rank: int
    rank_at_zero: int
    is_counted: bool

    @property
    def mobility(self) -> int:
        """Number of coordinates that remain free."""
        return self.coordinates - self.rank

    @property
    def is_singular_at_zero(self) -> bool:
        """Whether the description's zero, or what was described, is a singular configuration."""
        return self.rank_at_zero < self.rank

    @property
    def self_stresses(self) -> int:
        """Number of independent closure forces that load nothing but the mechanism itself."""
        return 6 * len(self.loops) + len(self.couplings) - self.rank

    @property
    def names(self) -> str:
        """Names of the loops and couplings as a text."""
        return ", ".join((*self.loops, *self.couplings))

    def __str__(self) -> str:
        counted = " (counted)" if self.is_counted else ""
        return (
            f"{self.names}: mobility {self.mobility}{counted} of {self.coordinates} coordinates, "
            f"{self.rank} independent equations, {self.self_stresses} self-stresses"
        )


@dataclass(frozen=True)
class MechanismReport:
    """What `cd.describe` returns; `print` shows it.

    Attributes:
        name: of the mechanism.
        notation: in which the loops are written.
        coordinates: number of joint coordinates.
        rank: number of independent closure equations.
        mobility: number of coordinates that remain free after the loops.
        length: characteristic length that weighs forces against moments [m].
        components: sets of loops and couplings that have no joint in common.
        loops: the loops.
        idle_rods: joints at the ends of every rod that may spin about its line, while the joints
            move that the description's author drives, if there are any. These freedoms are part of
            the mobility, and need no drive.
        drivable: names of the coordinates that a scene can drive or hold, see `Mechanism.drivable`:
            motors, then what has limits, slides, hinges, and turns of balls.
        warnings: what is wrong with the description and was accepted.
        silent: in a sentence each, which couplings do not say how they press on their joints.
        place: what the ranks are those of the surroundings of.
        described: what was described.
    """

    name: str
    notation: str
    coordinates: int
    rank: int
    mobility: int
    length: float
    components: list[ComponentReport]
    loops: list[LoopReport]
    idle_rods: list[tuple[str, ...]]
    drivable: tuple[str, ...]
    warnings: tuple[str, ...]
    silent: tuple[str, ...] = ()
    place: str = "the description's zero"
    described: Mechanism | Configuration | None = field(default=None, repr=False, compare=False)

    @cached_property
    def drives(self) -> Drives:
        """How it can be driven: each coordinate with its range, and which ones to drive first.

        Ranges are those from where the mechanism starts, and are followed when this is first read.

        Raises:
            ArgumentError: the report does not say what it describes.
        """
        if isinstance(self.described, Configuration):
            return drives_of(self.described.mechanism, self.described)
        if self.described is None:
            raise ArgumentError("drives are known of reports that describe() returns")
        return drives_of(self.described)

    def __str__(self) -> str:
        lines = [
            f"{self.name}: mobility {self._mobility}",
            f"  {self.coordinates} joint coordinates, {self.rank} independent closure equations",
            f"  loops: {self.notation}; characteristic length {self.length:.4g} m",
        ]
        shared = {name for component in self._sharing for name in component.loops}
        alike = grouped(
            (
                loop.name,
                f"({loop.type}): rank {loop.rank} of 6, {loop.redundant} redundant"
                f"{' by itself' * (loop.name in shared)}",
            )
            for loop in self.loops
        )
        lines += [
            f"  {_told('loop', names)} {text}{' each' * (len(names) > 1)}"
            for text, names in alike.items()
        ]
        lines += [f"  leaves open at {choices(at)}: {what}" for what, at in self.left_open.items()]
        couplings = [name for component in self.components for name in component.couplings]
        if couplings:
            lines.append(f"  couplings: {', '.join(couplings)}")
        lines += [f"  {remark}" for remark in self._remarks()]
        return "\n".join(lines)

    @property
    def left_open(self) -> dict[str, list[str]]:
        """Components of wrenches that statics leaves open, and the joints of which."""
        found: dict[str, str] = {}
        for loop in self.loops:
            found |= loop.indeterminate or {}
        return grouped(found.items())

    def _repr_html_(self) -> str:
        from ..kit.markup import element, listed, table  # Imported here: only notebooks show it.

        title = element("p", f"{self.name}: mobility {self._mobility}")
        facts = listed(
            "ul",
            (
                f"{self.coordinates} joint coordinates",
                f"{self.rank} independent closure equations",
                f"loops: {self.notation}",
                f"characteristic length {self.length:.4g} m",
            ),
        )
        header = ("loop", "type", "rank of 6", "redundant", "leaves open")
        rows = [
            (loop.name, loop.type, loop.rank, loop.redundant, loop.leaves_open)
            for loop in self.loops
        ]
        loops = table(header, rows) if rows else ""
        remarks = self._remarks()
        return f"<div>{title}{facts}{loops}{listed('ul', remarks) if remarks else ''}</div>"

    @property
    def is_counted(self) -> bool:
        """Whether ranks of any component were counted from the structure alone."""
        return any(component.is_counted for component in self.components)

    @property
    def _sharing(self) -> list[ComponentReport]:
        """Components that have more self-stresses than their loops have each by itself."""
        redundant = {loop.name: loop.redundant for loop in self.loops}
        return [
            component
            for component in self.components
            if component.self_stresses > sum(redundant[name] for name in component.loops)
        ]

    @property
    def mobility_remarks(self) -> list[str]:
        """What is to be said about the mobility: idle rods, and singular configurations."""
        remarks = []
        if self.idle_rods:
            rods = _told("idle rod", [" – ".join(rod) for rod in self.idle_rods], "at ")
            it = "it" if len(self.idle_rods) == 1 else "each"
            remarks.append(f"{rods}: {it} may spin about its line and needs no drive")
        return remarks + [
            f"{self.place} is a singular configuration of {component.names}: only "
            f"{component.rank_at_zero} of {component.rank} equations are independent there"
            for component in self.components
            if component.is_singular_at_zero
        ]

    def _remarks(self) -> list[str]:
        """Return what else there is to say: of drives, components, singular zeros, warnings."""
        several = len(self.components) > 1
        drives = choices(self.drivable, ranked=True)
        remarks = [f"can be driven or held: {drives}"] if self.mobility else []
        alike = grouped(
            (component.names, str(component).removeprefix(component.names))
            for component in self.components
            if several or component in self._sharing
        )
        remarks += [
            f"{_told('component', names)}{text}{' each' * (len(names) > 1)}"
            for text, names in alike.items()
        ]
        remarks += self.mobility_remarks
        remarks += [f"leaves open: {told}; {REMEDY}" for told in self.silent]
        return remarks + [f"warning: {warning}" for warning in self.warnings]

    @property
    def _mobility(self) -> str:
        """Return the mobility as text, and what is left of it for drives beside idle rods."""
        text = f"{self.mobility} (counted)" if self.is_counted else str(self.mobility)
        idle = len(self.idle_rods)
        return f"{text}, {self.mobility - idle} without idle rods" if idle else text


def grouped(pairs: Iterable[tuple[str, _Said]]) -> dict[_Said, list[str]]:
    """Return what is said of names to all the names of which it is said."""
    found: dict[_Said, list[str]] = {}
    for name, text in pairs:
        found.setdefault(text, []).append(name)
    return found


def _told(word: str, names: Sequence[str], lead: str = "") -> str:
    """Return one name or several behind a word."""
    if len(names) == 1:
        return f"{word} {lead}{names[0]}"
    return f"{len(names)} {word}s {lead}{choices(names, most=4)}"
