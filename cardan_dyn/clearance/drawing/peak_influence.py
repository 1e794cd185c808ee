"""Peak influence: the peak of impacts over each of its parameters, the others as they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...errors import ArgumentError
from ...figures.style import Figure, axes_grid, legend, line_style, names, point_style
from ..impact_model import ImpactModel
from ..influences import PARAMETERS, influence
from ..scan_results import ForceReversal

_AXES = {
    "speed": (1.0, "speed Ω / Ω₀ [–]"),
    "slope": (1e-3, "slope F₀/t₀ [N/ms]"),
    "clearance": (1e6, "clearance 2s [µm]"),
    "mass": (1.0, "reduced mass m [kg]"),
    "stiffness": (1e-6, "stiffness c [N/µm]"),
}
"""Of each parameter the factor to its unit on the axis, and the label there."""
_COLUMNS = 3


def peak_influence(
    of: ForceReversal | ImpactModel | Mapping[str, ForceReversal | ImpactModel],
    parameters: str | Sequence[str] = PARAMETERS,
    *,
    factors: ArrayLike | None = None,
    title: str = "",
) -> Figure:
    """Draw the peak of impacts over their parameters, one panel for each.

    Args:
        of: a reversal of a scan, a two-mass model, or several by label.
        parameters: of `speed`, `slope`, `clearance`, `mass` and `stiffness`. The speed is drawn as
            a factor on that of the scan.
        factors: `(N,)` on each parameter; from 0.2 to 5 if None.
        title: of the figure.

    Raises:
        ArgumentError: as `clearance.influence`, or there is nothing to be drawn.

    Source:
        Dresig and Thümmel, Bild 8.
    """
    shown = dict(of) if isinstance(of, Mapping) else {"": of}
    wanted = names(parameters)
    if not shown or not wanted:
        raise ArgumentError("there is no reversal or no parameter to be drawn")
    columns = min(len(wanted), _COLUMNS)
    rows = -(-len(wanted) // columns)
    figure, axes = axes_grid(rows, columns, size=(1.0 + 3.2 * columns, 0.9 + 3.0 * rows))
    panels = np.atleast_1d(axes)
    for panel, parameter in zip(panels, wanted, strict=False):
        for index, (label, item) in enumerate(shown.items()):
            found = influence(item, parameter, factors)
            unit, axis = _AXES[parameter]
            panel.plot(unit * found.value, found.peak, **line_style(index), label=label)
            model = found.model
            at = 1.0 if parameter == "speed" else float(getattr(model, parameter))
            panel.plot(unit * at, float(model.estimate.peak), **point_style(index))
        panel.set_xlabel(axis)
        panel.set_ylabel("peak [N]")
        panel.set_xlim(left=0.0)
        panel.set_ylim(bottom=0.0)
    for panel in panels[len(wanted) :]:
        panel.remove()
    figure.suptitle(title, fontsize=11)
    if len(shown) > 1:
        legend(figure, 3)
    return figure
