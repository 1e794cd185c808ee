"""Responding: a scene with one drive as functions of the drive's position."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING

from .inspection import SceneInspection

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..response.family import ResponseFamily
    from ..response.response import Response


class SceneResponses(SceneInspection):
    """Responses of a scene."""

    def response(
        self, tolerance: float = 1e-13, *, interval: tuple[float, float] | None = None
    ) -> Response:
        """Return wrenches and efforts as functions of the drive's position.

        `responses` builds those of many designs together.

        Built from a few hundred solved positions, they hold everywhere to rounding, at any speed,
        acceleration, load and gravity, for nanoseconds per value.

        Args:
            tolerance: error of the functions relative to the greatest wrench of their joint, or a
                tenth of the greatest of all joints; where rounding stops short of it, times the
                condition number. `Response.error` is what was reached.
            interval: positions between which it is to hold [rad or m]; without, the drive has to
                come back to where it was.

        Raises:
            ArgumentError: the interval is empty, or the scene has several drives, or elements.
            AccuracyError: the tolerance cannot be reached; the message says what can.
            IndeterminateError: a component of an output is not unique, in a strict scene.
            CardanError: the drive does not turn through and no interval was given.
        """
        from ..response.build import build
        from ..response.response import Response

        return Response(self._solver, build(self._solver, tolerance, interval))

    def responses(
        self,
        held: Mapping[str, ArrayLike],
        tolerance: float = 1e-13,
        *,
        interval: tuple[float, float] | None = None,
    ) -> ResponseFamily:
        """Return the responses of many designs, built together.

        Args:
            held: joints that the scene holds, to positions of any shape; they broadcast, and their
                common shape is that of the family.
            tolerance: see `response`; for every design.
            interval: see `response`; the same for every design.

        Raises:
            ArgumentError: shapes do not broadcast, or a joint is not held.
            ModelError: no such joint.
            CardanError: see `response`; the message names the design where it is that of one.
        """
        from ..response.family import family

        return family(self._solver, held, tolerance, interval)

    def load_response(self, path: str | os.PathLike[str]) -> Response:
        """Read the response of this scene, or of one like it, that `Response.save` wrote.

        Efforts at joints and the direction of gravity may have other values.

        Args:
            path: the file.

        Raises:
            ArgumentError: no path, or the scene has elements.
            CardanError: the file cannot be read, is damaged, or is the response of another scene.
        """
        from ..response.build import refuse_elements
        from ..response.file import read
        from ..response.response import Response

        refuse_elements(self._solver.problem)
        return Response(self._solver, read(path, self._solver))
