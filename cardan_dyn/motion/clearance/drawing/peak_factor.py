"""Peak factor: f(τ), by which the peak of an impact exceeds stiffness times half the clearance."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cardan_dyn.analytic.damped_impact import damped_peak
from cardan_dyn.analytic.peak_factor import peak_factor as factor_of
from cardan_dyn.analytic.peak_factor import peak_factor_limits

from ....figures.style import Figure, Into, Size, in_look, line_style, point_style, sheet
from ..impact_model import ImpactModel
from ..scan_results import ForceReversal, Scan


@in_look
def peak_factor(
    of: Scan | Mapping[str, ForceReversal | ImpactModel] | None = None,
    *,
    title: str = "",
    ax: Into = None,
    figsize: Size | None = None,
) -> Figure:
    """Draw f(τ) = peak / (c s) with its limits, and where two-mass peaks are on it.

    Lines from rest, as in the paper, and from release, as a spring lets go, undamped; and one for
    each damping ratio of the impacts.

    Args:
        of: a scan, of which the worst reversal of each joint is shown, or labels to reversals or
            two-mass models; none if None.
        title: of the figure.
        ax: axes to be drawn into instead of a new figure.
        figsize: width and height of a new figure [inch].

    Raises:
        ArgumentError: a peak is beyond what the geometry of a pin has a stiffness for.

    Source:
        Dresig and Thümmel (36), Bild 5.
    """
    every = of.worst if isinstance(of, Scan) else of or {}
    models = {name: m.model if isinstance(m, ForceReversal) else m for name, m in every.items()}
    taus = [float(model.estimate.tau) for model in models.values()]
    tau = np.geomspace(min([0.5, *taus]), max([20.0, *taus]), 400)
    drawn = sheet(size=(7.2, 5.4), ax=ax, figsize=figsize)
    (axes,) = drawn.panels
    below, above = peak_factor_limits(tau)
    lines = {
        "from rest": factor_of(tau),
        "from release": factor_of(tau, start="release"),
        "24π/τ³: ramp without clearance": below,
        "6/τ: impact alone": above,
    }
    # A joint has one damper, which is another fraction of critical at each of its reversals.
    kinds = {(round(m.damping_ratio, 2), m.start) for m in models.values()}
    for ratio, start in sorted(kind for kind in kinds if kind[0]):
        # Mass, stiffness and ramp of 1: half the clearance is τ³/12.
        half = tau**3 / 12.0
        damped = damped_peak(1.0, 1.0, half, 1.0, ratio, start=start) / half
        lines[f"from {start}, damping ratio {ratio:g}"] = damped
    for index, (label, values) in enumerate(lines.items()):
        axes.loglog(tau, values, **line_style(index), label=label)
    for index, (label, model) in enumerate(models.items()):
        found = model.estimate
        value = float(found.peak) / (float(found.stiffness) * 0.5 * model.clearance)
        axes.plot(float(found.tau), value, **point_style(index), label=label)
    axes.set_xlabel("characteristic number τ [–]")
    axes.set_ylabel("f(τ) = peak / (c s) [–]")
    return drawn.finish(title or "Peak of the force after an impact (Bild 5)", 3)
