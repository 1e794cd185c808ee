"""Picture, table and verdict of a stress map."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .pictures import write
from .records import markdown
from .stress import BOUND, EPS, OPTIMISM, Point


def table(points: Sequence[Point]) -> str:
    """Return a map as a Markdown table."""
    head = (
        "case", "method", "parameter", "error", "stated κ", "error/(eps κ)",
        "balance: said", "true", "loops: said", "true",
    )  # fmt: skip
    rows = []
    for p in points:
        start = [p.case, p.method, f"{p.parameter:g}"]
        if p.refused:
            rows.append([*start, p.refused] + [""] * 6)
            continue
        numbers = (
            p.error, p.stated, p.over_stated, p.balance, p.balance_true, p.loop, p.loop_true,
        )  # fmt: skip
        rows.append([*start, *(f"{value:.1e}" for value in numbers)])
    return markdown(head, rows)


def verdict(points: Sequence[Point], where: str) -> str:
    """Return the answer of a map.

    Args:
        points: all points.
        where: a sentence on where digits are lost.
    """
    solved = [point for point in points if not point.refused]
    beyond = [point for point in solved if point.over_stated > BOUND]
    optimistic = [point for point in solved if point.optimism > OPTIMISM]
    lines = [
        f"{len(points)} points, {len(points) - len(solved)} refused. {where}",
        f"Greatest error: {max((p.error or 0.0 for p in solved), default=0.0):.1e}; over eps times "
        f"the stated condition number: {max((p.over_stated for p in solved), default=0.0):.2g}.",
        f"Beyond {BOUND:g} eps times the stated condition number: {len(beyond)} points"
        + (f" ({_places(beyond)})." if beyond else "."),
        f"Reported residuals too small by more than {OPTIMISM:g} times: {len(optimistic)} points"
        + (
            f", at worst {max(p.optimism for p in optimistic):.1e} times ({_places(optimistic)})."
            if optimistic
            else "."
        ),
    ]
    return "\n".join(lines)


def _places(points: Sequence[Point]) -> str:
    cases: dict[str, list[float]] = {}
    for point in points:
        cases.setdefault(point.case, []).append(point.parameter)
    return "; ".join(
        f"{case}: {min(at):g}" + (f" … {max(at):g}" if len(at) > 1 else "")
        for case, at in cases.items()
    )


def picture(points: Sequence[Point], path: Path, label: str) -> None:
    """Draw a map: one panel per case and method, readable without colours."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    keys = list(dict.fromkeys((point.case, point.method) for point in points))
    columns = min(len(keys), 3 if len(keys) > 8 else 2)
    lines = -(-len(keys) // columns)
    with mpl.rc_context({"font.size": 8}):
        figure = Figure(figsize=(8.8, 2.5 * lines + 0.6), layout="constrained")
        axes = figure.subplots(lines, columns, squeeze=False, sharex=True, sharey=True)
        for index, (case, method) in enumerate(keys):
            axis = axes[index // columns][index % columns]
            solved = [p for p in points if (p.case, p.method) == (case, method) and not p.refused]
            refused = [p for p in points if (p.case, p.method) == (case, method) and p.refused]
            at = [p.parameter for p in solved]
            axis.loglog(at, [p.error or EPS for p in solved], "k-o", ms=3.5, label="error")
            axis.loglog(
                at, [EPS * (p.stated or 1) for p in solved], color="0.35", ls="--",
                label="eps × stated condition",
            )  # fmt: skip
            axis.loglog(
                at, [max(p.balance or 0, EPS / 10) for p in solved], color="0.6", ls="-",
                marker="v", ms=3.5, mfc="white", label="balance residual as reported",
            )  # fmt: skip
            axis.loglog(
                at, [max(p.balance_true or 0, EPS / 10) for p in solved], color="0.6", ls="-.",
                marker="x", ms=4.5, label="balance residual, true",
            )  # fmt: skip
            if refused:
                axis.loglog(
                    [p.parameter for p in refused], [1.0] * len(refused), "kx", ms=5,
                    label="refused with a CardanError",
                )  # fmt: skip
            axis.set_title(case if method == "sweep" else f"{case}, {method}", fontsize=8.5)
            axis.grid(color="0.9", lw=0.5)
        for axis in axes.flat[len(keys) :]:
            axis.set_visible(False)
        for axis in axes[-1]:
            axis.set_xlabel(label)
        for line in axes:
            line[0].set_ylabel("relative to greatest wrench")
        handles = {}
        for axis in axes.flat:
            for handle, name in zip(*axis.get_legend_handles_labels(), strict=True):
                handles.setdefault(name, handle)
        figure.legend(
            handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=7.5
        )
        write(figure, path)
