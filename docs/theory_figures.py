"""Draw the pictures of the page on theory: `python docs/theory_figures.py` writes them.

They are as wide as a telephone, so that their letters are read there, on white in light and dark.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Arc, Ellipse, FancyBboxPatch

from cardan_dyn.analytic import clearance, impact, single_joint

FOLDER = Path(__file__).parent / "images" / "theory"
WIDTH = 4.2
"""Of all pictures [in]."""
INPUT, OUTPUT, MOMENT, PIN, GREY = "#0b5fa5", "#b5480f", "#7a1f9c", "#8a6d00", "#666666"
STYLE = {"font.size": 10, "svg.hashsalt": "theory", "mathtext.fontset": "dejavusans"}


def arrow(ax: Any, start: Any, end: Any, color: str, label: str = "", at: Any = (0, 0)) -> None:
    """Draw a vector, and its letter beside its end."""
    ax.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.8})
    if label:
        ax.text(end[0] + at[0], end[1] + at[1], label, color=color, ha="center", va="center")


def bare(ax: Any, x: tuple[float, float], y: tuple[float, float]) -> None:
    """Show a plane without axes, to scale."""
    ax.set(xlim=x, ylim=y, aspect="equal")
    ax.axis("off")


def frames() -> plt.Figure:
    """Return shafts, directions and zero of rotation of the single joint."""
    beta = np.radians(35)
    figure, (plane, along) = plt.subplots(
        2, 1, figsize=(WIDTH, 4.9), gridspec_kw={"height_ratios": [1.15, 1]}
    )
    bare(plane, (-2.5, 2.5), (-1.15, 1.75))
    e_2 = np.array([np.cos(beta), np.sin(beta)])
    u_2 = np.array([-np.sin(beta), np.cos(beta)])
    plane.plot([-2.3, -0.25], [0, 0], color=INPUT, lw=7, solid_capstyle="butt")
    plane.plot(*np.transpose([0.25 * e_2, 2.3 * e_2]), color=OUTPUT, lw=7, solid_capstyle="butt")
    plane.plot([0, 2.2], [0, 0], color=GREY, lw=0.8, ls=(0, (6, 3)))
    plane.add_patch(Arc((0, 0), 3.6, 3.6, theta1=0, theta2=35, color=GREY))
    plane.text(1.98, 0.58, r"$\beta$", ha="center", va="center")
    plane.plot([0, 0], [-0.5, 0.5], color=PIN, lw=4)
    plane.text(0.42, -0.5, r"pin $a$ at $\varphi_1=0$", color=PIN, va="center")
    plane.add_patch(Ellipse((0, 0), 0.22, 0.22, facecolor="white", edgecolor=PIN, lw=2, zorder=5))
    plane.plot([0], [0], "o", color=PIN, ms=3, zorder=6)
    plane.text(-0.95, -0.88, r"pin $b$, towards you", color=PIN, ha="center", va="center")
    plane.plot([-0.55, -0.1], [-0.74, -0.12], color=PIN, lw=0.7)
    arrow(plane, (-1.75, 0.35), (-0.85, 0.35), INPUT, r"$e_1$", (0.2, 0.02))
    arrow(plane, 0.95 * e_2 + 0.3 * u_2, 1.8 * e_2 + 0.3 * u_2, OUTPUT, r"$e_2$", (0.17, 0.12))
    arrow(plane, (0, 0.1), (0, 1.05), INPUT, r"$u_1$", (0.22, 0.05))
    arrow(plane, 0.1 * u_2, 1.35 * u_2, OUTPUT, r"$u_2=-e_x$", (-0.5, 0.14))
    plane.text(-2.4, 1.55, r"in the plane of the shafts, $z$ towards you", va="center")

    bare(along, (-2.5, 2.5), (-1.35, 1.35))
    phi = np.radians(40)
    along.add_patch(Ellipse((0, 0), 2, 2, facecolor="none", edgecolor=INPUT, lw=2))
    along.plot([0, 0], [-1.2, 1.2], color=GREY, lw=0.8, ls=(0, (6, 3)))
    # Seen from behind, along e_1: u_1 points up, and a right-handed turn is clockwise.
    pin = np.array([np.sin(phi), np.cos(phi)])
    along.plot(*np.transpose([-pin, pin]), color=PIN, lw=4)
    along.text(*(1.2 * pin + (0.12, 0.05)), r"$a$", color=PIN, ha="center", va="center")
    along.add_patch(Arc((0, 0), 1.2, 1.2, theta1=50, theta2=90, color="black"))
    along.text(0.25, 0.78, r"$\varphi_1$", ha="center", va="center")
    arrow(along, (1.02, 0), (1.62, 0), INPUT, r"$z$", (0.16, 0))
    arrow(along, (0, 1.0), (0, 1.3), INPUT, r"$u_1$", (-0.25, -0.06))
    along.text(-2.4, 1.2, r"seen along $e_1$", va="center")
    along.text(-2.4, -0.95, "plane of\nthe shafts", color=GREY, va="center")
    along.plot([-1.45, -0.05], [-1.0, -1.12], color=GREY, lw=0.6)
    figure.subplots_adjust(0, 0, 1, 1, hspace=0.02)
    return figure


def wrench() -> plt.Figure:
    """Return the wrench of a joint on its child, with its parts along the axis and across it."""
    figure, sides = plt.subplots(1, 2, figsize=(WIDTH, 2.9))
    parts = (
        ("force", "$f$", OUTPUT, (0.75, 0.95), ("axial", "shear")),
        ("moment", "$m$", MOMENT, (0.95, 0.75), ("torsion", "bending")),
    )
    for ax, (title, letter, color, (across, along), (axial, shear)) in zip(
        sides, parts, strict=True
    ):
        bare(ax, (-1.25, 1.35), (-1.75, 1.75))
        ax.text(0.05, 1.62, title, color=color, ha="center", va="center")
        # A housing below, the parent; a shaft out of it, the child; the axis upward.
        ax.add_patch(plt.Rectangle((-0.8, -0.75), 1.6, 0.5, facecolor="#d9d9d9", edgecolor=GREY))
        ax.plot([0, 0], [-0.95, 1.25], color=INPUT, lw=9, alpha=0.35, solid_capstyle="butt")
        ax.plot([0, 0], [-1.3, 1.4], color=GREY, lw=0.8, ls=(0, (6, 3)))
        ax.text(-0.78, -1.0, "parent", color=GREY, ha="center", va="center")
        ax.text(-0.42, 1.15, "child", color=INPUT, ha="center", va="center")
        ax.text(0.36, -1.25, "axis", color=GREY, ha="center", va="center")
        arrow(ax, (0, 0), (across, along), color, letter, (0.14, 0.12))
        arrow(ax, (0, 0), (0, along), color, axial, (-0.52, -0.32))
        arrow(ax, (0, 0), (across, 0), color)
        ax.text(0.72, -0.13, shear, color=color, ha="center", va="center")
        ax.plot([0, across, across], [along, along, 0], color=color, lw=0.8, ls=(0, (2, 2)))
        ax.plot([0], [0], "o", color="black", ms=4, zorder=6)
        ax.text(-0.38, 0.0, "origin", ha="center", va="center", fontsize=9)
    figure.subplots_adjust(0, 0, 1, 1, wspace=0.02)
    return figure


def swing() -> plt.Figure:
    """Return the path of the moment's direction between both shafts."""
    figure, ax = plt.subplots(figsize=(WIDTH, 3.9))
    for beta, color in ((20, GREY), (50, MOMENT)):
        angle, phi = np.radians(beta), np.linspace(0, np.pi, 361)
        n = direction(angle, phi)
        ax.plot(np.degrees(n[1]), np.degrees(n[2]), color=color)
        if beta == 50:
            steps = direction(angle, np.radians(np.arange(0, 180, 15)))
            ax.plot(np.degrees(steps[1]), np.degrees(steps[2]), "o", color=color, ms=3.5)
            for step in (30, 60, 120, 150):
                _, x, y = np.degrees(direction(angle, np.radians(step)))
                ax.text(x * 1.2, y * 1.2, f"{step}°", ha="center", va="center", color=color)
        for end, name, shade in ((-0.5, "e_1", INPUT), (0.5, "e_2", OUTPUT)):
            ax.plot([end * beta], [0], "s", color=shade, ms=6, zorder=5)
            if beta == 50:
                ax.text(end * beta * 1.22, 0, f"${name}$", color=shade, ha="center", va="center")
    ax.text(0, 0, r"$\beta=20°$", color=GREY, ha="center", va="center")
    ax.text(0, -22, r"$\beta=50°$", color=MOMENT, ha="center", va="center")
    ax.set(xlim=(-35, 35), ylim=(-36, 36), aspect="equal")
    ax.set_xlabel("in the plane of the shafts [°]")
    ax.set_ylabel("normal to it [°]")
    ax.grid(alpha=0.3)
    figure.tight_layout(pad=0.4)
    return figure


def direction(beta: float, phi: Any) -> Any:
    """Return the moment's direction as angles about the middle between both shafts, and 1."""
    turned = single_joint.output_angle(beta, phi)
    e_1 = np.array([np.cos(beta / 2), -np.sin(beta / 2), 0.0])
    e_2 = e_1 * [1, -1, 1]
    z = np.array([0.0, 0.0, 1.0])
    a = np.multiply.outer(np.cross(z, e_1), np.cos(phi)) + np.multiply.outer(z, np.sin(phi))
    b = np.multiply.outer(z, np.cos(turned)) - np.multiply.outer(np.cross(z, e_2), np.sin(turned))
    n = np.cross(a, b, axis=0)
    return np.array([np.ones_like(n[0]), np.arctan2(n[1], n[0]), np.arcsin(n[2])])


def phasing() -> plt.Figure:
    """Return Z and W arrangements with the forks that make the output even, and the force P."""
    figure, axes = plt.subplots(2, 1, figsize=(WIDTH, 3.5))
    for ax, name, sign in zip(axes, "ZW", (1, -1), strict=True):
        bare(ax, (-2.55, 2.55), (-0.95, 1.25) if name == "Z" else (-1.1, 1.1))
        slope = np.radians(30)
        ends = [np.array([-1.1, 0.0]), np.array([1.1, 0.0])]
        far = [
            ends[0] - 1.3 * np.array([np.cos(slope), np.sin(slope)]),
            ends[1] + 1.3 * np.array([np.cos(slope), sign * np.sin(slope)]),
        ]
        ax.plot(*np.transpose(ends), color=GREY, lw=6, solid_capstyle="butt")
        ax.plot(*np.transpose([far[0], ends[0]]), color=INPUT, lw=6, solid_capstyle="butt")
        ax.plot(*np.transpose([ends[1], far[1]]), color=OUTPUT, lw=6, solid_capstyle="butt")
        for end, outer in zip(ends, far, strict=True):
            along = (outer - end) / np.linalg.norm(outer - end)
            across = 0.3 * np.array([-along[1], along[0]])
            ax.plot(*np.transpose([end - across, end + across]), color=PIN, lw=3.5, zorder=4)
            ax.plot(*end, "o", mfc="white", mec=PIN, mew=2, ms=8, zorder=5)
            ax.plot(*end, "o", color=PIN, ms=2.5, zorder=6)
        if name == "Z":
            ax.text(0, 0.3, r"$P=0$", color=MOMENT, ha="center", va="center")
        else:
            for (x, y), mark, label in zip(ends, ("x", "."), ("P", "-P"), strict=True):
                ax.plot(x, y + 0.55, "o", mfc="white", mec=MOMENT, mew=1.6, ms=11)
                ax.plot(x, y + 0.55, mark, color=MOMENT, mew=1.6, ms=7)
                ax.text(x, y + 0.88, f"${label}$", color=MOMENT, ha="center", va="center")
        ax.text(0, -0.3, "$e_2$, length $L$", color=GREY, ha="center", va="center")
        ax.text(*(far[0] + (0.2, 0.55)), "$e_1$", color=INPUT)
        ax.text(*(far[1] + (-0.35, 0.25 if sign > 0 else 0.45)), "$e_3$", color=OUTPUT)
        ax.text(-2.5, 0.75 if name == "Z" else 0.55, name, weight="bold", va="center", size=12)
    figure.subplots_adjust(0, 0, 1, 1, hspace=0.02)
    return figure


def weld() -> plt.Figure:
    """Return a loop as a joint of the tree and a weld."""
    figure, ax = plt.subplots(figsize=(WIDTH, 3.5))
    bare(ax, (-0.1, 6.1), (-0.15, 5.05))
    boxes = {
        "base": (3.0, 0.4, GREY),
        "shaft_in": (1.0, 1.7, INPUT),
        "housing_out": (5.0, 1.7, GREY),
        "cross": (1.0, 3.0, PIN),
        "shaft_out": (5.0, 3.0, OUTPUT),
        "pin_out's\nbody": (1.0, 4.35, MOMENT),
    }
    for name, (x, y, color) in boxes.items():
        style = "round,pad=0.02,rounding_size=0.12"
        height = 0.85 if "\n" in name else 0.6
        dashes = "--" if "\n" in name else "-"
        ax.add_patch(
            FancyBboxPatch(
                (x - 0.85, y - height / 2),
                1.7,
                height,
                boxstyle=style,
                facecolor="white",
                edgecolor=color,
                lw=1.8,
                ls=dashes,
                zorder=3,
            )
        )
        ax.text(x, y, name, ha="center", va="center", color=color, zorder=4, size=9)
    joints = (
        ((3.0, 0.7), (1.0, 1.4), "bearing_in", (-0.55, -0.2)),
        ((3.0, 0.7), (5.0, 1.4), "joint_angle", (0.55, -0.2)),
        ((1.0, 2.0), (1.0, 2.7), "pin_in", (0.55, 0)),
        ((5.0, 2.0), (5.0, 2.7), "bearing_out", (-0.85, 0)),
        ((1.0, 3.3), (1.0, 3.92), "pin_out", (0.6, 0)),
    )
    for start, end, name, shift in joints:
        arrow(ax, start, end, "black")
        middle = (np.add(start, end)) / 2 + shift
        ax.text(*middle, name, ha="center", va="center", size=9)
    ax.plot([1.9, 5.0, 5.0], [4.35, 4.35, 3.3], color=MOMENT, lw=3, ls=(0, (1.2, 0.8)))
    ax.text(3.6, 4.62, "weld: 6 equations", ha="center", color=MOMENT, size=9)
    figure.subplots_adjust(0, 0, 1, 1)
    return figure


def crossing() -> plt.Figure:
    """Return force, flight and impact of the worked example of Dresig and Thümmel."""
    mass, stiffness, half, ramp = 3.6, 1e7, 0.5e-4, 360e3
    found = impact.reversal(mass, stiffness, half, ramp)
    figure, ax = plt.subplots(figsize=(WIDTH, 3.0))
    time = np.linspace(0, 3.0e-3, 1000)  # From the impact.
    force = impact.contact_force(time, mass, stiffness, half, ramp)
    ax.plot(
        [-0.6, 4.8], [-0.6e-6 * ramp, 4.8e-6 * ramp], color=GREY, ls="--", label="without clearance"
    )
    before = np.linspace(-0.6e-3, 0, 2)
    ax.plot(before * 1e3, ramp * before / 1e3, color=MOMENT)
    before = np.linspace(-0.6e-3, 0, 2)
    course = np.concatenate([before, [0, found.t_1], found.t_1 + time])
    forces = np.concatenate([ramp * before, [0, 0], force])
    ax.plot(course * 1e3, forces / 1e3, color=MOMENT, label="with clearance")
    peak = float(found.t_1 + found.theta_m / clearance.natural_frequency(mass, stiffness))
    ax.plot([peak * 1e3], [float(found.peak) / 1e3], "o", color=MOMENT)
    text = rf"$F_{{12\,max}}={float(found.peak):.0f}$ N"
    ax.text(peak * 1e3, float(found.peak) / 1e3 + 0.2, text, color=MOMENT, ha="center", va="center")
    ax.axvspan(0, float(found.t_1) * 1e3, color="#eeeeee")
    ax.text(float(found.t_1) * 500, 0.95, "flight\nacross $2s$", ha="center", va="center")
    ax.text(float(found.t_1) * 1e3 + 0.18, -0.14, "$t_1$", ha="center", va="center")
    ax.set(xlabel="time from the reversal [ms]", ylabel="force [kN]", ylim=(-0.3, 2.7))
    ax.legend(loc="upper left", frameon=False, fontsize=9)
    figure.tight_layout(pad=0.4)
    return figure


PICTURES: dict[str, Callable[[], plt.Figure]] = {
    "wrench": wrench,
    "frames": frames,
    "swing": swing,
    "phasing": phasing,
    "weld": weld,
    "crossing": crossing,
}


def main(folder: Path = FOLDER) -> None:
    """Write all pictures into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    with plt.rc_context(STYLE):
        for name, draw in PICTURES.items():
            figure = draw()
            figure.savefig(folder / f"{name}.svg", metadata={"Date": None}, facecolor="white")
            plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
