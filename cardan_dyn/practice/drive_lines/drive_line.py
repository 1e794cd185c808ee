"""Drive line: a line as data, and all that is asked of it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.mechanics.exact import load
from ...core.mechanism.mechanism import Mechanism
from ...kit.checks import described, number, numbers, several, vector
from ...kit.errors import ArgumentError, ModelError, choices
from .design.layout import layout
from .design.phasing import phasing
from .line.closed_chain import urdf
from .line.data import LineData
from .line.files import read, schema, write
from .line.parts import ShaftJoint
from .line.supports import supports
from .verdict.analysis import Analysis
from .verdict.solving import LineSolver, Task, scene_of
from .verdict.variants import Variants, variants
from .verdict.verdict import Verdict, verdict

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike

    from cardan_dyn.analytic.limits import Limit

    from ...figures.style import Figure
    from ...scene.scene import Scene

_SLIPPING = {None: 0, "out": 1, "in": -1}


@dataclass(frozen=True, kw_only=True, repr=False)
class DriveLine(LineData):
    """A line of n universal joints between n + 1 shafts.

    It cannot be changed: `replace` makes another one. Lines are equal if their data are.

    Attributes:
        shafts: shafts along the power flow, n + 1 of them, the input shaft first.
        joints: n joints; plain ones unless given.
        name: name of the line.
        speed: speed of the input shaft [rad/s].
        torque: torque of the input shaft, positive if it drives the line in the sense of rotation
            [N·m].
        duty_cycle: shares of the time with their speeds and torques.
        application: `vehicle`, `agricultural` or `industrial`, whose limits the verdict goes by;
            limits that hold for one of them alone are not judged unless given.
        service_factor: K, shock torque over torque; 1 unless given.
        reversing: whether the torque changes its sense.
        acceleration: greatest angular acceleration of the input shaft, running up or braking, on
            top of the torque [rad/s²]; the verdict counts with none unless given.
        life: life asked of the joints' bearings [s].
        report: what reports on the line say at their head.

    Raises:
        ModelError: the field, its value and what is valid: see `Shaft` and the others; shafts that
            cannot be put together.
    """

    to_toml = write
    to_urdf = urdf
    variants = variants
    phasing = phasing
    layout = layout

    def plot(
        self, *, title: str = "", ax: Any = None, figsize: tuple[float, float] | None = None
    ) -> Figure:
        """Draw the line at rest, seen from its right side and from above; see `arrangement`.

        Args:
            title: of the figure; the name of the line unless given.
            ax: two axes to be drawn into instead of a new figure.
            figsize: width and height of a new figure [inch].

        Raises:
            MissingExtraError: matplotlib is not installed.
            ArgumentError: other than two axes.
        """
        from .drawing import arrangement  # Imported here: few scripts draw.

        return arrangement(self, title=title, ax=ax, figsize=figsize)

    @classmethod
    def from_toml(cls, source: str | PathLike[str]) -> DriveLine:
        """Read a line from a TOML file; `toml_schema` lists its fields.

        Args:
            source: path of the file, the text itself, or the name of one of `examples()`.

        Raises:
            ModelError: the file cannot be read, or which of its fields is wrong, its value and what
                is valid.
        """
        line: DriveLine = read(source, cls)
        return line

    @cached_property
    def mechanism(self) -> Mechanism:
        """The line as a mechanism.

        Raises:
            ModelError: what is missing for the line to be held by its bearings.
        """
        return load(self.to_urdf())

    @cached_property
    def _solver(self) -> LineSolver:
        """Solves the line, and keeps its scenes."""
        return LineSolver(self, self.mechanism)

    @property
    def indeterminate(self) -> tuple[str, ...]:
        """What statics leaves open, in words; empty if the bearings decide all forces.

        Raises:
            ModelError: what is missing for the line to be held by its bearings.
        """
        return supports(self).indeterminate

    def scene(self, **options: Any) -> Scene:
        """Return a scene of the line, driven at `bearing_in`.

        Where statics leaves forces open, joints pass on as little force as possible, as the closed
        forms have it; `compliance` decides otherwise.

        Args:
            options: arguments of `Scene`.

        Raises:
            CardanError: as `Scene` does, and as `mechanism` does.
        """
        return scene_of(self, self.mechanism, **options)

    def analyse(
        self,
        *,
        speed: float | None = None,
        torque: ArrayLike | None = None,
        positions: ArrayLike | None = None,
        acceleration: float = 0.0,
        torque_at: str = "input",
        gravity: ArrayLike | None = None,
        slipping: str | None = None,
        variants: Variants | None = None,
    ) -> Analysis:
        """Return the motion of all shafts and what acts in all joints, bearings and splines.

        Args:
            speed: of the input shaft [rad/s]; that of the line unless given.
            torque: [N·m], a number or a value per position; that of the line unless given.
            positions: `(P,)` of the input shaft [rad], 0 where its fork's pin is horizontal; a
                whole turn in 1° unless given, in 5° for variants.
            acceleration: of the input shaft [rad/s²].
            torque_at: `input` if the input shaft passes on this torque at every position, as
                catalogues have it, before inertia is added; `output` if the output shaft does.
            gravity: `(3,)` acceleration of free fall [m/s²]; none unless given.
            slipping: `out` if the splines are drawn out under torque, `in` if they are pushed in:
                their friction then acts against it. None without friction.
            variants: designs, from `variants`; results are then designs × positions.

        Raises:
            ArgumentError: a value is missing, not finite or out of its range.
            CardanError: as `Scene` and `Scene.sweep` do; a design cannot be put together.
        """
        if variants is not None and not isinstance(variants, Variants):
            raise ArgumentError(
                f"variants is {described(variants)}, expected what variants() returns"
            )
        if variants is not None and variants.shafts != self.shafts:
            raise ArgumentError("variants are those of another line; make them of this one")
        if not isinstance(torque_at, str) or torque_at not in ("input", "output"):
            raise ArgumentError(
                f"torque_at is {described(torque_at)}, expected 'input' or 'output'"
            )
        if slipping is not None and (not isinstance(slipping, str) or slipping not in _SLIPPING):
            raise ArgumentError(f"slipping is {described(slipping)}, expected 'in', 'out' or None")
        if positions is None:
            positions = np.radians(np.arange(0.0, 360.0, 1.0 if variants is None else 5.0))
        angles = several("positions", positions)
        torques = numbers("torque", _given("torque", torque, self.torque))
        if torques.shape not in ((), angles.shape):
            raise ArgumentError(
                f"torque has shape {torques.shape}, expected a number or a value per position "
                f"{angles.shape}"
            )
        task = Task(
            speed=number("speed", _given("speed", speed, self.speed)),
            acceleration=number("acceleration", acceleration),
            torque=torques,
            at_output=torque_at == "output",
            positions=angles,
            gravity=np.zeros(3) if gravity is None else vector("gravity", gravity, 3),
            slipping=_SLIPPING[slipping],
            variants=variants,
        )
        return self._solver.analysed(task)

    def verdict(
        self,
        limits: Mapping[str, Limit | float | str | None] | None = None,
        analysis: Analysis | None = None,
    ) -> Verdict:
        """Return what the rules of practice say of the line, a row per rule and place.

        Values are exact where closed forms or the analysis give them, with those of the rule
        beside them; rows say which data they lack, and which assumptions of the rule do not hold.
        The line is judged at its own speed and torque and at those of its duty cycle. Of forces the
        worst counts, joint by joint and bearing by bearing, in each direction: with the shock
        torque and without, at rest and at speed, with splines that slide in and out, run up and
        braked, under the weight of the line.

        Args:
            limits: names of `analytic.limits.LIMITS` to other values [SI units, radians] or
                `Limit`s with their source, or to None to take a limit out; besides,
                `torsional_distance` (least distance of speeds from torsional critical ones,
                relative to these) and `critical_constant` (of bending speeds [rad m/s], or a name
                of `analytic.limits.CRITICAL_CONSTANTS`).
            analysis: one of this line, whose speed and torque count instead of the line's own, and
                whose forces count besides the worst of these.

        Raises:
            ArgumentError: an unknown limit, or one that is no number; an analysis of another line.
        """
        return verdict(self, limits, analysis, lambda: self._solver)

    def replace(self, **changes: Any) -> DriveLine:
        """Return a line that differs in some fields.

        Raises:
            ModelError: no such field, or what is wrong with a line like that.
        """
        known = {item.name for item in dataclasses.fields(self)}
        for name in changes.keys() - known:
            raise ModelError(
                f"a DriveLine has no field {name!r}; fields: {choices(known, name)}", name=name
            )
        if "shafts" in changes and not any(joint != ShaftJoint() for joint in self.joints):
            changes = {"joints": (), **changes}  # As many plain ones as there will be joints.
        return dataclasses.replace(self, **changes)


def toml_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of files that `DriveLine.from_toml` reads.

    Editors complete and check such files by it, once they are told of it.
    """
    return schema(DriveLine)


def _given(name: str, value: ArrayLike | None, of_line: float | None) -> ArrayLike:
    if value is not None:
        return value
    if of_line is None:
        raise ArgumentError(f"{name} is given neither here nor by the line; give {name}=")
    return of_line
