"""Drive line: the public face of its data, its description, its scenes and its analysis."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..errors import ModelError, choices
from ..mechanism.mechanism import Mechanism, load
from .parts import Joint
from .phased_line import PhasedLine
from .supports import supports

if TYPE_CHECKING:
    from collections.abc import Mapping
    from os import PathLike

    from numpy.typing import ArrayLike

    from analytic.limits import Limit

    from ..scene.scene import Scene
    from .analysis import Analysis
    from .variants import Variants
    from .verdict import Verdict


@dataclass(frozen=True, kw_only=True, repr=False)
class DriveLine(PhasedLine):
    """A line of n universal joints between n + 1 shafts.

    It cannot be changed: `replace` makes another one. Lines are equal if their data are.

    Attributes:
        shafts: n + 1 shafts along the power flow, the input shaft first.
        joints: n joints; plain ones unless given.
        name: of the line.
        speed: of the input shaft [rad/s].
        torque: of the input shaft, positive if it drives the line in the sense of rotation [N·m].
        duty_cycle: shares of the time with their speeds and torques.
        application: `vehicle`, `agricultural` or `industrial`, whose limits the verdict goes by;
            limits that hold for one of them alone are not judged unless given.
        service_factor: K, shock torque over torque; 1 unless given.
        reversing: whether the torque changes its sense.
        acceleration: greatest angular acceleration of the input shaft, running up or braking, on
            top of the torque [rad/s²]; the verdict counts with none unless given.
        life: that is asked of the joints' bearings [s].

    Raises:
        ModelError: the field, its value and what is valid: see `Shaft` and the others; shafts that
            cannot be put together.
    """

    @classmethod
    def from_toml(cls, source: str | PathLike[str]) -> DriveLine:
        """Read a line from a TOML file; `toml_schema` lists its fields.

        Args:
            source: path of the file, the text itself, or the name of one of `examples()`.

        Raises:
            ModelError: the file cannot be read, or which of its fields is wrong, its value and what
                is valid.
        """
        from .toml_reader import read  # Imported here: lines made in Python need no reader.

        line: DriveLine = read(source, cls)
        return line

    def to_toml(self, path: str | PathLike[str] | None = None) -> str:
        """Return the line as TOML text, which `from_toml` reads as an equal line.

        Args:
            path: file to write it to; none unless given.
        """
        from .toml_writer import write  # Imported here: as above.

        return write(self, path)

    def to_urdf(self) -> str:
        """Return the line as a closed-chain URDF+ description, which `cardan_dyn.load` reads.

        `closed_chain` says what its links and joints are. All that is a matter of design is an
        adjustable joint.

        Raises:
            ModelError: what is missing for the line to be held by its bearings.
        """
        from .closed_chain import urdf  # Imported here: most lines are read before they are built.

        return urdf(self)

    @cached_property
    def mechanism(self) -> Mechanism:
        """The line as a mechanism.

        Raises:
            ModelError: what is missing for the line to be held by its bearings.
        """
        return load(self.to_urdf())

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
        from .solving import scene_of  # Imported here: as above.

        return scene_of(self, self.mechanism, **options)

    def variants(
        self,
        *,
        angles: ArrayLike | None = None,
        planes: ArrayLike | None = None,
        fork_offsets: ArrayLike | None = None,
        lengths: ArrayLike | None = None,
        misalignments: Mapping[str, ArrayLike] | None = None,
    ) -> Variants:
        """Return D designs of the line, for `analyse`; what is not given is as in the data.

        Args:
            angles: joint angles `(D, n)` [rad].
            planes: plane offsets `(D, n)` [rad]; see `Geometry`.
            fork_offsets: `(D, n - 1)` of the intermediate shafts [rad].
            lengths: `(D, n - 1)` of the intermediate shafts [m]. Bearings stay at their distances
                from the joints at the fronts of their shafts, those behind a spline from the
                joints at the rears. Splines are drawn out, tubes without one longer; masses stay.
            misalignments: names of adjustable joints, see `closed_chain`, to positions `(D,)` [rad
                or m]: `offset_y_k` and `offset_z_k` move what lies behind shaft k across it,
                `support_A_y` and `support_A_z` a bearing.

        Raises:
            ArgumentError: a value is not finite or out of its range, or shapes do not match.
            ModelError: unknown adjustable joint.
        """
        from .variants import variants  # Imported here: as above.

        return variants(
            self,
            angles=angles,
            planes=planes,
            fork_offsets=fork_offsets,
            lengths=lengths,
            misalignments=misalignments,
        )

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
        workers: int = 1,
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
            workers: see `Scene.sweep`.

        Raises:
            ArgumentError: a value is missing, not finite or out of its range.
            CardanError: as `Scene` and `Scene.sweep` do; a design cannot be put together.
        """
        from .solving import analysed  # Imported here: as above.
        from .tasks import task

        asked = task(
            self,
            speed=speed,
            torque=torque,
            positions=positions,
            acceleration=acceleration,
            torque_at=torque_at,
            gravity=gravity,
            slipping=slipping,
            variants=variants,
            workers=workers,
        )
        return analysed(self, self.mechanism, asked)

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
        from .verdict import verdict  # Imported here: as above.

        return verdict(self, limits, analysis, lambda line, **options: line.analyse(**options))

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
        if "shafts" in changes and not any(joint != Joint() for joint in self.joints):
            changes = {"joints": (), **changes}  # As many plain ones as there will be joints.
        return dataclasses.replace(self, **changes)
