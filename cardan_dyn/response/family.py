"""Family: the responses of many designs of one scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array
from ..dynamics.problem_solver import ProblemSolver
from ..errors import ArgumentError
from ..frozen import Frozen, FrozenDict, frozen, read_only
from ..problem.samples import common_shape, drive_values, targets_of
from ..results.sweep import Sweep
from .build import checked_tolerance, domain_of, refuse_unsuitable
from .data import ResponseData
from .factors import checked_operation
from .family_build import built, refuse_what_does_not_come_back
from .family_points import FamilyPoints, sweep_of
from .response import Response
from .sampling import FunctionSampler

if TYPE_CHECKING:
    from .plot import FamilyPlot


def family(
    solver: ProblemSolver, held: object, tolerance: object, interval: object
) -> ResponseFamily:
    """Return the responses of many designs; see `Scene.responses`."""
    checked = checked_tolerance(tolerance)
    refuse_unsuitable(solver.problem)
    domain = domain_of(solver, interval)
    start = solver.problem.mechanism.coordinates.named[solver.problem.independent[0]].column
    at_start = float(solver.assembly.start[start])
    designs = targets_of(solver.problem, at_start, held)
    every = solver.of_varied(designs.varied)
    rows = designs.designs[designs.design_of]
    refuse_what_does_not_come_back(every, designs, domain)
    sampler = FunctionSampler(every)
    # Where all designs are that of the scene, they share one response.
    different = designs if designs.held else designs.of_samples(np.zeros(1, dtype=int))
    data = built(every, sampler, different, domain, checked)
    every_held: dict[str, float | Array] = {**solver.problem.held, **designs.held}
    return ResponseFamily(every, designs.shape, frozen(every_held), designs.varied, rows, data)


class ResponseFamily(Frozen):
    """The responses of one scene for many designs; `Scene.responses` makes it.

    `family[index]` is the `Response` of a design, with as many indices as the family has
    dimensions. Nothing in it can be changed.

    Attributes:
        shape: of the designs.
        held: held joints and their positions [rad or m]; arrays where designs differ.
    """

    def __init__(
        self,
        solver: ProblemSolver,
        shape: tuple[int, ...],
        held: FrozenDict[str, float | Array],
        varied: tuple[str, ...],
        rows: Array,
        data: list[ResponseData],
    ) -> None:
        """Make the family.

        Args:
            solver: of the scene, for positions of the varied joints.
            shape: see the attribute.
            held: see the attribute.
            varied: names of the joints whose positions are not those of the scene.
            rows: their positions `(D, h)`.
            data: the functions of each design; of the only one where none varies.
        """
        self._solver, self.shape, self.held = solver, shape, held
        self._varied, self._rows, self._data = varied, read_only(rows), tuple(data)
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        arguments = self._solver, self.shape, self.held, self._varied, np.array(self._rows)
        return ResponseFamily, (*arguments, list(self._data))

    def __len__(self) -> int:
        """Return the number of designs, along the first of several dimensions."""
        return self.shape[0]

    def __repr__(self) -> str:
        size = " × ".join(map(str, self.shape))
        return (
            f"<ResponseFamily of {self._solver.problem.mechanism.name!r}: {size} designs, "
            f"{int(np.sum(self.sample_count))} samples, error {np.max(self.error):.1e}>"
        )

    def __getitem__(self, index: int | tuple[int, ...]) -> Response:
        """Return the response of a design.

        Raises:
            ArgumentError: no whole numbers, or not one for every dimension.
            IndexError: there is no such design.
        """
        place = index if isinstance(index, tuple) else (index,)
        whole = (int, np.integer)
        if len(place) != len(self.shape) or not all(isinstance(item, whole) for item in place):
            raise ArgumentError(f"a design of shape {self.shape} has {len(self.shape)} indices")
        flat = np.arange(int(np.prod(self.shape))).reshape(self.shape)
        return self._responses[int(flat[place])]

    def __iter__(self) -> Iterator[Response]:
        """Iterate over the responses of all designs, in C order."""
        return iter(self._responses)

    @property
    def plot(self) -> FamilyPlot:
        """Figures: `family.plot("bearing_out.bending", speed=3.0)`, a line per design."""
        from .plot import FamilyPlot  # Imported here: few scripts draw.

        return FamilyPlot(self)

    @property
    def error(self) -> Array:
        """Measured error of every design, see `Proof`."""
        return self._of_all("error")

    @property
    def sample_count(self) -> Array:
        """Number of solved positions of every design."""
        return self._of_all("sample_count")

    def sweep(
        self,
        position: ArrayLike,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
        *,
        loads: Mapping[str, ArrayLike] | None = None,
        gravity: ArrayLike | None = None,
    ) -> Sweep:
        """Return wrenches at any operating points of all designs.

        All arguments broadcast with the shape of the designs; see `Response.sweep` for them and
        the errors.
        """
        problem = self._solver.problem
        operation = checked_operation(problem, speed, acceleration, loads, gravity)
        arrays = {
            "position": drive_values("position", position, problem)[..., 0],
            "speed": operation.speed,
            "acceleration": operation.acceleration,
            **{f"loads[{name!r}]": effort for name, effort in operation.joint_loads.items()},
        }
        shapes = {name: array.shape for name, array in arrays.items()}
        shapes |= {"gravity": operation.gravity.shape[:-1], "designs": self.shape}
        shape = common_shape(shapes)
        chosen = _choices(self.shape, shape)
        sweeps = []
        for response, where in zip(self._responses, chosen, strict=True):

            def part(values: Array, trailing: tuple[int, ...] = (), at: Any = where) -> Array:
                whole = np.broadcast_to(values, (*shape, *trailing))
                return np.atleast_1d(whole[at]) if not trailing else np.asarray(whole[at])

            efforts = {name: part(effort) for name, effort in operation.joint_loads.items()}
            sweeps.append(
                response.sweep(
                    part(arrays["position"]),
                    part(operation.speed),
                    part(operation.acceleration),
                    loads=efforts,
                    gravity=part(operation.gravity, (3,)),
                )
            )
        whole = {name: np.broadcast_to(array, shape) for name, array in arrays.items()}
        points = FamilyPoints(
            self._solver,
            tuple(sweeps),
            tuple(chosen),
            shape,
            whole["position"],
            whole["speed"],
            whole["acceleration"],
            self.held,
            frozen(dict(operation.joint_loads)),
            operation.gravity,
        )
        return sweep_of(points)

    @cached_property
    def _responses(self) -> list[Response]:
        solver, count = self._solver, int(np.prod(self.shape))
        if not self._varied:
            return [Response(solver, self._data[0])] * count
        return [
            Response(solver.at_design(dict(zip(self._varied, row.tolist(), strict=True))), data)
            for row, data in zip(self._rows, self._data, strict=True)
        ]

    def _of_all(self, name: str) -> Array:
        values = [getattr(response, name) for response in self._responses]
        return read_only(np.array(values).reshape(self.shape))


def _choices(designs: tuple[int, ...], shape: tuple[int, ...]) -> list[tuple[Any, ...]]:
    """Return what to index arrays of a shape with to have the part of each design, in C order."""
    padded = (1,) * (len(shape) - len(designs)) + designs
    return [
        tuple(place if size > 1 else slice(None) for place, size in zip(index, padded, strict=True))
        for index in np.ndindex(*padded)
    ]
