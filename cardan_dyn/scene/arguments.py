"""Arguments of a scene: as they were checked, and with changes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..checks import mapping
from ..errors import choices
from ..forces.link_loads import Wrench
from ..frozen import frozen
from ..mechanism.mechanism import Mechanism
from ..problem.coordinate_names import check_single
from ..problem.problem import Problem
from ..results.prescribed import Prescribed

if TYPE_CHECKING:
    from ..elements.element import Element

_MERGED = ("held", "loads")
"""Arguments whose changes are merged with what the scene has, name by name."""


class SceneArguments(Prescribed):
    """The arguments of a scene as properties."""

    @property
    def loads(self) -> Mapping[str, Array | Wrench]:
        """Loaded joint to its effort, of any shape [N·m or N]; link to its `Wrench`."""
        links = {name: load.wrench for name, load in self._problem.link_loads.items()}
        return frozen({**self._problem.joint_loads, **links})

    @property
    def gravity(self) -> Array:
        """Acceleration of free fall `(3,)` in world axes [m/s²]."""
        return self._problem.gravity

    @property
    def compliance(self) -> Mapping[str, Array]:
        """Joint to its `(6, 6)` compliance, force first [m/N, rad/(N·m)]."""
        return self._problem.compliance

    @property
    def strict(self) -> bool:
        """Whether statically indeterminate components are refused."""
        return self._problem.strict

    @property
    def start(self) -> Mapping[str, float | Array]:
        """What is brought to a position before the drives take over [rad or m].

        Coordinates by name; joints with balls by all of theirs, with unit quaternions.
        """
        return started(self._problem)

    @property
    def branch(self) -> str:
        """Name of the assembly mode."""
        return self._problem.branch

    @property
    def elements(self) -> tuple[Element, ...]:
        """Springs, dampers, bushings, friction and actuators."""
        return self._problem.elements

    def __repr__(self) -> str:
        arguments = [f"drives {', '.join(self.drives)}"]
        if self.held:
            arguments.append(
                "held " + ", ".join(f"{name} {position:g}" for name, position in self.held.items())
            )
        if self.loads:
            arguments.append(f"loads on {', '.join(self.loads)}")
        if np.any(self.gravity):
            arguments.append(f"gravity {self.gravity.tolist()}")
        if self.elements:
            arguments.append(f"{len(self.elements)} element{'s' * (len(self.elements) > 1)}")
        return f"<Scene of {self.mechanism.name!r}: {'; '.join(arguments)}>"


def replaced(scene: SceneArguments, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of a scene with changes, see `Scene.replace`; they are not checked.

    Raises:
        TypeError: no such argument.
        ArgumentError: `held` or `loads` is no mapping of names.
    """
    problem = scene._problem
    arguments: dict[str, Any] = {
        "mechanism": problem.mechanism,
        "drive": problem.drives,
        "held": problem.held,
        "loads": scene.loads,
        "gravity": problem.gravity,
        # If all joints are outputs, so are all joints of another mechanism.
        "outputs": None if problem.all_outputs else problem.outputs,
        "compliance": problem.compliance,
        "strict": problem.strict,
        "start": started(problem),
        "branch": problem.branch,
        "elements": problem.elements,
    }
    unknown = set(changes) - set(arguments)
    if unknown:
        listed = choices(arguments, min(unknown))
        raise TypeError(f"Scene has no argument {choices(unknown)}; arguments: {listed}")
    for name, value in changes.items():
        if name in _MERGED:
            arguments[name] = _merged(problem.mechanism, name, arguments[name], value)
        else:
            arguments[name] = value
    return arguments


def started(problem: Problem) -> Mapping[str, float | Array]:
    """Return the start of a problem as `Scene` takes it."""
    result: dict[str, float | Array] = dict(problem.start)
    for joint, quaternion in problem.start_balls.items():
        scalars = [
            result.pop(name)
            for name in problem.mechanism.joints[joint].coordinates
            if name in result
        ]
        result[joint] = np.concatenate([np.array(scalars, dtype=float), quaternion])
    return frozen(result)


def _merged(
    mechanism: Mechanism, name: str, present: Mapping[str, Any], changes: object
) -> dict[str, Any]:
    """Return a mapping with changes; names whose new value is None are taken out.

    None instead of changes takes all names out: it means none, as it does for `Scene`.

    Raises:
        ModelError: a name to be taken out is that of no joint, coordinate or link.
    """
    if changes is None:
        return {}
    merged = {**present, **mapping(name, changes)}
    for key, value in merged.items():
        if value is None and not (isinstance(key, str) and key in mechanism.links):
            check_single(mechanism, key, f"a key of {name},")
    return {key: value for key, value in merged.items() if value is not None}
