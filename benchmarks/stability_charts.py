"""How long does a stability chart of a shaft with a joint take, and how exact is it?

Multipliers at 200 speeds and 50 joint angles from 1 to 45°, two worker processes: a line with an
elastic shaft in front of its joint (one free coordinate, half its inertia in front, half behind,
damping ratio 0.02), the bundled line with elastic shafts on both sides and the bundled shaft that
tilts on springs (two each). Errors are those of the trace against the line's equation, which SciPy
integrates; wall-clock time, R is one `pin.rnea` call from Python on the model.
"""

from __future__ import annotations

import time

import numpy as np
from scipy.integrate import solve_ivp

import cardan_dyn as cd

from .records import Record, markdown, save
from .timing import rnea_seconds

NAME = "stability_charts"
SPEEDS, ANGLES = 200, 50
_RATIO = 0.02
_PLACES = ((20, 3), (35, 11), (60, 19), (90, 27), (130, 34), (170, 49))
"""Numbers of speeds and angles at which errors are measured."""
_LINE = """<robot name="line">
<link name="base"/><link name="cross"/><link name="housing"/>
<link name="driven"/>
<link name="fork"><inertial><mass value="1"/>
<inertia ixx="0.5" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="flywheel"><inertial><mass value="1"/>
<inertia ixx="0.5" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="bearing_in" type="continuous"><parent link="base"/><child link="driven"/>
<axis xyz="1 0 0"/></joint>
<joint name="twist" type="continuous"><parent link="driven"/><child link="fork"/>
<axis xyz="1 0 0"/></joint>
<joint name="pin_in" type="continuous"><parent link="fork"/><child link="cross"/>
<axis xyz="0 1 0"/></joint>
<joint name="joint_angle" type="revolute"><parent link="base"/><child link="housing"/>
<axis xyz="0 0 1"/><limit lower="-1.5" upper="1.5" effort="1" velocity="1"/></joint>
<joint name="bearing_out" type="continuous"><parent link="housing"/><child link="flywheel"/>
<axis xyz="1 0 0"/></joint>
<loop name="pin_out" type="continuous"><predecessor link="cross"/><successor link="flywheel"/>
<axis xyz="0 0 1"/></loop>
</robot>"""


def _scenes() -> dict[str, tuple[cd.Scene, tuple[float, float]]]:
    """Return scenes with the least and greatest speed of their charts [rad/s]."""
    scenes = {}
    line = cd.load(_LINE)
    spring = cd.JointSpring("twist", 1.0, 2.0 * _RATIO)
    given = {
        "drive": "bearing_in",
        "free": "twist",
        "elements": [spring],
        "held": {"joint_angle": 0.1},
    }
    scenes["one elastic shaft"] = cd.Scene(line, **given), (0.2, 3.0)
    for title, name, ends in (
        ("two elastic shafts", "torsional_line_both", (60.0, 600.0)),
        ("tilting shaft", "elastic_thoma_rig", (30.0, 400.0)),
    ):
        rig = cd.load(name)
        scene = cd.Scene(
            rig,
            drive="bearing_in",
            free=list(rig.joint_springs),
            elements=cd.described_elements(rig),
            held={"joint_angle": 0.1},
        )
        scenes[title] = scene, ends
    return scenes


def _trace(beta: float, speed: float, start: np.ndarray) -> float:
    """Return the trace over half a turn of the line's equation about its motion near a start.

    (J₁ + J₂ η²) q'' + J₂ η η' (1 + q')² + (k q + d q' Ω) / Ω² = 0 with J₁ = J₂ = 1/2, k = 1;
    η = cos β / (1 - sin² β cos² θ), θ = φ + q from the position with the pin in the plane.
    """

    def bend(phi: float, q: complex, rate: complex) -> complex:
        theta = phi + q
        below = 1.0 - (np.sin(beta) * np.sin(theta)) ** 2
        ratio = np.cos(beta) / below
        slope = ratio * np.sin(beta) ** 2 * np.sin(2.0 * theta) / below
        forces = 0.5 * ratio * slope * (1.0 + rate) ** 2
        forces += q / speed**2 + 2.0 * _RATIO * rate / speed
        return complex(-forces / (0.5 + 0.5 * ratio**2))

    def rates(phi: float, y: np.ndarray) -> list[float]:
        tiny = 1e-100j
        stiff = bend(phi, y[0] + tiny, y[1]).imag / 1e-100
        damp = bend(phi, y[0], y[1] + tiny).imag / 1e-100
        found = [y[1], bend(phi, y[0], y[1]).real]
        for column in (2, 4):
            found += [y[column + 1], stiff * y[column] + damp * y[column + 1]]
        return found

    for _ in range(8):
        begin = [*start, 1.0, 0.0, 0.0, 1.0]
        run = solve_ivp(rates, (0.0, np.pi), begin, "DOP853", rtol=3e-14, atol=1e-16)
        end = run.y[:, -1]
        matrix = end[2:].reshape(2, 2).T
        miss = end[:2] - start
        if np.max(np.abs(miss)) < 1e-13:
            break
        start = start - np.linalg.solve(matrix - np.eye(2), miss)
    return float(np.trace(matrix))


def _error(
    scene: cd.Scene, chart: cd.vibration.Floquet, places: tuple[tuple[int, int], ...]
) -> float:
    """Return the greatest error of the traces of a chart of the line at places."""
    worst = 0.0
    for speed, angle in places:
        beta, omega = float(chart.held["joint_angle"][angle]), float(chart.speed[speed])
        held = scene.replace(held={"joint_angle": beta})
        motion = cd.vibration.periodic_motion(held, omega).at(0.0)
        start = np.array([motion.position[0, 0, 0], motion.velocity[0, 0, 0] / omega])
        exact = _trace(beta, omega, start)
        worst = max(worst, abs(float(chart.trace[angle, speed]) - exact))
    return worst


def measure(fast: bool = False) -> list[Record]:
    """Return all records.

    Args:
        fast: few speeds and angles.
    """
    speeds, angles = (8, 4) if fast else (SPEEDS, ANGLES)
    held = {"joint_angle": np.radians(np.linspace(1.0, 45.0, angles))}
    records = []
    for title, (scene, ends) in _scenes().items():
        unit = rnea_seconds(scene.mechanism)
        begin = time.perf_counter()
        chart = cd.vibration.floquet(scene, np.linspace(*ends, speeds), held=held, workers=2)
        seconds = time.perf_counter() - begin
        error = None
        if title == "one elastic shaft":
            error = _error(scene, chart, ((1, 0), (6, 3)) if fast else _PLACES)
        values = {
            "speeds": speeds,
            "angles": angles,
            "seconds": seconds,
            "R": unit,
            "unstable": int(np.sum(~chart.is_stable & (chart.kind != "no motion"))),
            "without motion": int(np.sum(chart.kind == "no motion")),
        }
        records.append(Record(NAME, title, cd.__version__, "", values, error, None, seconds / unit))
    return records


def answer(records: list[Record]) -> str:
    """Return in words what was measured."""
    lines = []
    for r in records:
        p = r.parameters
        within = "" if r.error is None else f"; traces within {r.error:.1e}"
        lines.append(
            f"{r.method}: {p['speeds']} speeds at {p['angles']} angles in {p['seconds']:.3g} s, "
            f"{r.ratio:.3g} R{within}."
        )
    return "\n".join(lines)


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    save(NAME, [record.flat() for record in records], answer(records))
    head = ["", "s", "R in µs", "million R", "unstable", "no motion", "traces within"]
    rows = [
        [
            r.method,
            f"{r.parameters['seconds']:.3g}",
            f"{1e6 * r.parameters['R']:.2f}",
            f"{1e-6 * (r.ratio or 0.0):.3g}",
            str(r.parameters["unstable"]),
            str(r.parameters["without motion"]),
            "" if r.error is None else f"{r.error:.1e}",
        ]
        for r in records
    ]
    return markdown(head, rows)
