"""Peak influence: the peak of impacts over each of its parameters, the others as they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ....figures.style import Figure, Into, Size, in_look, line_style, point_style, sheet
from ....kit.checks import names
from ....kit.errors import ArgumentError
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


@in_look
def peak_influence(
    of: ForceReversal | ImpactModel | Mapping[str, ForceReversal | ImpactModel],
    parameters: str | Sequence[str] = PARAMETERS,
    *,
    factors: ArrayLike | None = None,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw the peak of impacts over their parameters, one panel for each.

    Where the estimate does not hold, a curve is a hairline, see `Influence.holds`; it ends where
    there is no peak.

    Args:
        of: a reversal of a scan, a two-mass model, or several by label.
        parameters: of `speed`, `slope`, `clearance`, `mass` and `stiffness`. The speed is drawn as
            a factor on that of the scan.
        factors: `(N,)` on each parameter; from 0.2 to 5 if None.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure, one for each parameter.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: as `clearance.influence`, or there is nothing to be drawn.

    Source:
        Dresig and Thümmel, Bild 8.
    """
    shown = dict(of) if isinstance(of, Mapping) else {"": of}
    wanted = names("parameters", parameters)
    if not shown or not wanted:
        raise ArgumentError("there is no reversal or no parameter to be drawn")
    columns = min(len(wanted), 3)
    rows = -(-len(wanted) // columns)
    drawn = sheet(
        rows,
        columns,
        count=len(wanted),
        size=(1.0 + 3.2 * columns, 0.9 + 3.0 * rows),
        ax=ax,
        figsize=figsize,
    )
    for panel, parameter in zip(drawn.panels, wanted, strict=True):
        for index, (label, item) in enumerate(shown.items()):
            found = influence(item, parameter, factors)
            unit, axis = _AXES[parameter]
            value, color = unit * found.value, line_style(index)["color"]
            beyond = "beyond where the estimate holds" if not np.all(found.holds) else None
            panel.plot(value, found.peak, color=color, linewidth=0.6, label=beyond)
            model = found.model
            at = 1.0 if parameter == "speed" else float(getattr(model, parameter))
            panel.plot(unit * at, float(model.estimate.peak), **point_style(index))
            held = np.where(found.holds, found.peak, np.nan)
            panel.plot(value, held, **line_style(index), label=label or "peak")
        panel.set_xlabel(axis)
        panel.set_ylabel("two-mass peak [N]")
        panel.set_xlim(left=0.0)
        panel.set_ylim(bottom=0.0)
    return drawn.finish(title, 3)
