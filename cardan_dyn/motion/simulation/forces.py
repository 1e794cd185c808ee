"""Forces: what acts on a mechanism while it is simulated, as efforts along all its coordinates."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import pinocchio

from ...core.elements.element import Element
from ...core.elements.element_efforts import ElementEfforts
from ...core.elements.element_forces import labels
from ...core.elements.link_loads import LinkLoad
from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import Array
from ...kit.checks import described
from ...kit.errors import ArgumentError
from .turning_model import turning_model


class Named(Mapping[str, float]):
    """Positions or speeds of turns and slides by name, of one state; functions get it."""

    def __init__(self, indices: Mapping[str, int], values: Array) -> None:
        self._indices, self._values = indices, values

    def __getitem__(self, name: str) -> float:
        return float(self._values[self._indices[name]])

    def __iter__(self) -> Iterator[str]:
        return iter(self._indices)

    def __len__(self) -> int:
        return len(self._indices)


State: TypeAlias = tuple[Named, Named]
"""Positions [rad or m] and speeds [rad/s or m/s] by name."""


class StateNames:
    """Reads states by the names of their coordinates."""

    def __init__(self, mechanism: Mechanism, known: Collection[str] | None = None) -> None:
        named = mechanism.coordinates.named
        chosen = [(name, named[name]) for name in named if known is None or name in known]
        self._columns = {name: item.column for name, item in chosen}
        self._rates = {name: item.rate for name, item in chosen}

    def of(self, x: Array, v: Array) -> State:
        """Return a state by name, of coordinates `x (size,)` and velocities `v (nv,)`."""
        return Named(self._columns, x), Named(self._rates, v)


StateFunction = Callable[[float, Named, Named], Any]
"""Of time [s], positions and speeds by name."""


def state_function(label: str, function: Callable[..., Any]) -> StateFunction:
    """Return a function of time, or of time, positions and speeds, as one of all three.

    Raises:
        ArgumentError: it takes another number of arguments; when it is called, it fails.
    """
    needed = needs(function)
    if needed not in (None, 0, 1, 3, math.inf):
        raise ArgumentError(
            f"{label}: a function of {needed} arguments, expected (time) or "
            "(time, position, speed), the latter two by joint names"
        )
    return _OfState(label, function, needed not in (3, math.inf))


@dataclass(frozen=True)
class _OfState:
    """A user's function as one of time, positions and speeds; see `state_function`."""

    label: str
    function: Callable[..., Any]
    takes_time_alone: bool

    def __call__(self, time: float, position: Named, speed: Named) -> Any:
        try:
            if self.takes_time_alone:
                return self.function(time)
            return self.function(time, position, speed)
        except Exception as error:
            raise ArgumentError(
                f"{self.label} failed at time {time:g} s: {type(error).__name__}: {error}"
            ) from error


def needs(function: Callable[..., Any]) -> float | None:
    """Return how many arguments a function needs, inf for any number, None if that is not known."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # Some functions of compiled modules have none.
        return None
    kinds = [item.kind for item in parameters if item.default is inspect.Parameter.empty]
    return math.inf if inspect.Parameter.VAR_POSITIONAL in kinds else len(kinds)


class Forces:
    """Loads on joints and links, constant or functions of time and state.

    Attributes:
        is_constant: whether nothing depends on time or speed.
        is_nothing: whether nothing acts at all.
        act_on_links: whether anything acts on links, not along coordinates.
        does_no_work: whether nothing acts but springs.
        has_functions: whether users' functions say what acts.
        names: reads states by name.
        joint_loads: coordinates to constant efforts.
        link_loads: links to constant wrenches.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        joint_loads: Mapping[str, Array],
        link_loads: Mapping[str, LinkLoad],
        functions: Mapping[str, StateFunction],
        elements: Sequence[Element] = (),
        known: Collection[str] | None = None,
    ) -> None:
        """Make the forces.

        Args:
            mechanism: the mechanism.
            joint_loads: coordinates to constant efforts.
            link_loads: links to constant wrenches, `(3,)` each.
            functions: joints or links to functions of what acts there; instead of the constant.
            elements: force elements of the scene.
            known: names by which functions may read states; all if None.
        """
        self._mechanism, self._known = mechanism, known
        coordinates = mechanism.coordinates
        self.names = StateNames(mechanism, known)
        self._constant = np.zeros(mechanism.model.nv)
        for name, effort in joint_loads.items():
            if name not in functions:
                self._constant[coordinates.named[name].rate] += float(effort)
        self._joint_functions = {
            name: function for name, function in functions.items() if name in coordinates.named
        }
        self._driven = coordinates.rates_of(self._joint_functions)
        self._link_functions = {
            name: function for name, function in functions.items() if name in mechanism.link_frames
        }
        self.link_loads = {name: load for name, load in link_loads.items() if name not in functions}
        self.joint_loads = joint_loads
        self._every_element = tuple(elements)
        self._elements = ElementEfforts(mechanism, elements)
        self.is_constant = not functions and self._elements.is_conservative
        self.has_functions = bool(functions) or self._elements.has_functions
        self.is_nothing = not (functions or joint_loads or link_loads or elements)
        self.act_on_links = bool(
            self.link_loads or self._link_functions or self._elements.act_on_links
        )
        self.does_no_work = not (functions or joint_loads or link_loads)
        self.does_no_work &= self._elements.is_conservative

    def efforts(self, model: Any, data: Any, time: float, x: Array, v: Array) -> Array:
        """Return the efforts `(nv,)` along all coordinates at a state.

        Args:
            model: Pinocchio's, whose configurations are rows `x`.
            data: of the model.
            time: [s].
            x: coordinates `(size,)`, all turns counted.
            v: velocities `(nv,)`.

        Raises:
            ArgumentError: a function returns no number, or a wrench of a wrong shape.
        """
        efforts = self.along_coordinates(time, x, v)
        if self.act_on_links:
            efforts += self.on_links(model, data, time, x, v, x, v)
        return efforts

    def along_coordinates(self, time: float, x: Array, v: Array) -> Array:
        """Return the efforts `(nv,)` of what acts along coordinates, see `efforts`."""
        efforts = self._constant.copy()
        if self._joint_functions:
            efforts[self._driven] += self._joint_values(time, x, v)
        self._elements.add_along_coordinates(efforts, time, x, v)
        return efforts

    def on_links(
        self, model: Any, data: Any, time: float, q: Array, rates: Array, x: Array, v: Array
    ) -> Array:
        """Return the efforts `(nv,)` of what acts on links, along the coordinates of a model.

        Args:
            model: Pinocchio's, whose bodies are those of the mechanism.
            data: of the model.
            time: [s].
            q: its configuration.
            rates: its velocities.
            x: coordinates `(size,)` of the mechanism, all turns counted.
            v: velocities `(nv,)` of the mechanism.

        Raises:
            ArgumentError: see `efforts`.
        """
        efforts = np.zeros(model.nv)
        loads = [*self.link_loads.values(), *self._links_of_functions(time, x, v)]
        if loads:
            pinocchio.computeJointJacobians(model, data, q)
            for load in loads:
                efforts += _along_coordinates(model, data, load)
        self._elements.add_on_links(efforts, model, data, time, (q, rates), x, v)
        return efforts

    @property
    def limits(self) -> str:
        """Where laws of elements end, to be added to why a simulation failed."""
        named = zip(labels(self._every_element), self._every_element, strict=True)
        return "".join(f"; {label}: {item.limits}" for label, item in named if item.limits)

    @property
    def bodies(self) -> set[int]:
        """Bodies of the mechanism's model on which loads or elements act."""
        links = self._mechanism.link_frames
        loaded = {load.body + 1 for load in self.link_loads.values()}
        loaded |= {int(links[name][0]) for name in self._link_functions}
        return loaded | self._elements.bodies

    def depend_on(self, rates: set[int]) -> bool:
        """Return whether what acts depends on some coordinates, or acts along them."""
        along = {*np.flatnonzero(self._constant).tolist(), *self._elements.rates}
        return self.has_functions or bool(rates & along)

    def _joint_values(self, time: float, x: Array, v: Array) -> list[float]:
        state = self.names.of(x, v)
        return [
            number_at(f"loads[{name!r}]", function(time, *state), time)
            for name, function in self._joint_functions.items()
        ]

    def _links_of_functions(self, time: float, x: Array, v: Array) -> list[LinkLoad]:
        """Return what functions say that acts on links at a state."""
        if not self._link_functions:
            return []
        from ...core.problem.arguments import split_loads  # Few simulations have such functions.

        state = self.names.of(x, v)
        given = {name: function(time, *state) for name, function in self._link_functions.items()}
        try:
            loads = split_loads(self._mechanism, given)[1]
        except ArgumentError as error:
            raise ArgumentError(f"at time {time:g} s: {error}") from error
        for name, load in loads.items():
            if load.force.shape != (3,) or load.moment.shape != (3,):
                raise ArgumentError(f"loads[{name!r}] returned several wrenches at {time:g} s")
        return [loads[name] for name in given]

    def with_elements(self, elements: Sequence[Element]) -> Forces:
        """Return the same loads with other elements."""
        functions = self._joint_functions | self._link_functions
        loads = self.joint_loads, self.link_loads, functions
        return Forces(self._mechanism, *loads, elements, self._known)

    def all_efforts(self, times: Array, x: Array, v: Array) -> Array:
        """Return the efforts `(N, nv)` at N states, see `sampled` for them."""
        if self.is_nothing:
            return np.zeros_like(v)
        model = turning_model(self._mechanism)
        data = model.createData()
        states = zip(times.tolist(), x, v, strict=True)
        return np.array([self.efforts(model, data, *state) for state in states])

    def sampled(
        self, times: Array, x: Array, v: Array
    ) -> tuple[dict[str, Array], dict[str, LinkLoad]]:
        """Return the loads at N states, for a sweep over them.

        Args:
            times: `(N,)`.
            x: coordinates `(N, size)`, all turns counted.
            v: velocities `(N, nv)`.

        Returns:
            Coordinates to efforts, `()` or `(N,)`; links to their loads, `(3,)` or `(N, 3)`.
        """
        states = list(zip(times.tolist(), x, v, strict=True))
        joints, links = dict(self.joint_loads), dict(self.link_loads)
        if self._joint_functions:
            values = np.array([self._joint_values(*state) for state in states])
            joints.update(zip(self._joint_functions, values.T, strict=True))
        if self._link_functions:
            rows = [self._links_of_functions(*state) for state in states]
            for index, name in enumerate(self._link_functions):
                column = [row[index] for row in rows]
                force, moment = (
                    np.array([getattr(load, part) for load in column])
                    for part in ("force", "moment")
                )
                if any(np.any(load.point != column[0].point) for load in column):
                    raise ArgumentError(
                        f"loads[{name!r}] returned wrenches at several points; a load acts at one "
                        "point of its link: add what its moment changes where the force moves"
                    )
                links[name] = replace(column[0], force=force, moment=moment)
        return joints, links


def number_at(label: str, value: object, time: float) -> float:
    """Return what a user's function returned at a time [s].

    Raises:
        ArgumentError: it is no finite number.
    """
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise ArgumentError(
            f"{label} returned {described(value)} at time {time:g} s, expected a number"
        )
    return number


def _along_coordinates(model: Any, data: Any, load: LinkLoad) -> Array:
    """Return the efforts `(nv,)` that do the work of a wrench on a link.

    Joint Jacobians have been computed.
    """
    joint = load.body + 1
    frame = data.oMi[joint]
    rotation = np.eye(3) if load.in_world else frame.rotation @ load.rotation
    force, moment = rotation @ load.force, rotation @ load.moment
    origin = frame.act(load.place)
    jacobian = pinocchio.getJointJacobian(model, data, joint, pinocchio.ReferenceFrame.WORLD)
    wrench = np.concatenate([force, moment + np.cross(origin, force)])
    return np.asarray(jacobian.T @ wrench)
