"""Writes the pages that come from data or docstrings: `practice`, `errata` and `interface`.

Run it after a change of the rules, limits or errata of `analytic`, or of a public name:
python docs/write_pages.py
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path

import cardan_dyn as cd
from cardan_dyn.analytic import errata, limits, rules

HERE = Path(__file__).parent


def practice() -> str:
    """Return the page of the rules and limits."""
    lines = [
        "# Rules of practice",
        "",
        "What makers and builders of drive lines compute, in `cd.analytic`: formula, source, what",
        "must hold for it, and a worked example or an independent derivation that a test holds it",
        "against. The same table is `cd.analytic.rules.RULES`; the figures at the end are",
        "`cd.analytic.limits`, and any of them can be replaced. Symbols in formulas are those of",
        "the sources; functions take SI units and radians.",
        "",
        "Three ratings of joints look alike and are not: the rated torque T_D of the life formula",
        "(5000 h at n beta = 300 degrees/min), the capacity factor L_C, and the torque of a",
        "maker's own table, such as Klein's T = C R or T_e = T K_1 K_2 K_3. For 1000 N m,",
        "1450/min, 7 degrees and 2000 h the first is 2185 N m, Klein's 1339 N m.",
    ]
    for rule in rules.RULES.values():
        lines += ["", f"## {rule.title} ({rule.key})", "", f"- Formula: {rule.formula}"]
        lines.append("- Functions: " + ", ".join(f"`{name}`" for name in rule.functions))
        if rule.limits:
            lines.append("- Limits: " + ", ".join(f"`{name}`" for name in rule.limits))
        lines += [f"- Source: {rule.source}", f"- Holds if: {' '.join(rule.assumptions)}"]
        lines.append(f"- Example: {rule.example}")
    lines += ["", "## Limits and constants", "", *_table(limits.LIMITS)]
    lines += [
        "",
        "Constants C of omega = C sqrt(D^2 + d^2) / L^2:",
        "",
        *_table(limits.CRITICAL_CONSTANTS),
    ]
    factors = {
        f"{load}, {end}": limit
        for load, pair in limits.SERVICE_FACTORS.items()
        for end, limit in zip(("least", "greatest"), pair, strict=True)
    }
    lines += ["", "Service factors K by load, and factors K_3 by prime mover:", ""]
    lines += _table({**factors, **limits.POWER_FACTORS})
    lines += [
        "",
        "Speeds and angles by size of joint are `analytic.limits.JOINT_SIZES`, factors of",
    ]
    lines += ["precision joints `analytic.limits.DIN_808_FACTORS`."]
    return "\n".join(lines) + "\n"


def _table(listed: Mapping[str, limits.Limit]) -> list[str]:
    rows = [
        f"| `{name}` | {limit.value:.6g} | {limit.unit} | {limit.bound} | {limit.source} |"
        for name, limit in listed.items()
    ]
    return ["| name | value | unit | bound | source |", "|---|---|---|---|---|", *rows]


def sources() -> str:
    """Return the page of the errors found in the sources."""
    lines = [
        "# Errata of the sources",
        "",
        "Errors found while the formulas were derived anew. The kinds: *wrong*, as printed it",
        "gives a wrong value; *scan*, introduced by the scanning of the copy in circulation, or",
        "not to be told from that; *scope*, right, but only under a condition that is not stated.",
        "The same table is `cd.analytic.errata.ERRATA`.",
    ]
    for source in dict.fromkeys(erratum.source for erratum in errata.ERRATA):
        lines += ["", f"## {source}"]
        for erratum in errata.errata(source):
            lines += [
                "",
                f"### {erratum.place} ({erratum.key})",
                "",
                f"- Kind: {erratum.kind}",
                f"- Printed: {erratum.printed}",
                f"- Right: {erratum.right}",
            ]
            if erratum.numbers:
                lines += ["", "| number | printed | right |", "|---|---|---|"]
            for number in erratum.numbers:
                printed = "none" if number.printed is None else f"{number.printed:g}"
                # A vertical bar within a cell would end this cell of the table.
                what = number.what.replace("|", "\\|")
                lines.append(f"| {what} | {printed} | {number.right:.6g} |")
    return "\n".join(lines) + "\n"


_MEMBERS = {
    "Mechanism": (
        ("Parts", ("joint_names", "link_names", "joint", "drivable", "adjustable")),
        ("Its description", ("joint_springs", "joint_dynamics", "warnings", "to_urdf")),
    ),
    "Scene": (
        ("Drive, free, hold", ("sweep", "assemble", "response", "responses", "simulate")),
        ("Equation of motion", ("jacobian", "mass_matrix", "bias", "regressor", "linear")),
        (
            "Rest and range",
            ("equilibrium", "motion_range", "reachable", "branches", "configuration"),
        ),
        ("Motors and joints", ("transmission",)),
        ("The scene itself", ("plan", "replace")),
    ),
    "Sweep": (
        ("Forces", ("wrench", "drive_effort", "holding_effort", "element_force", "rod_force")),
        ("Motion", ("motion", "position", "speed", "acceleration", "point", "origin")),
        ("Axes", ("rotation", "orientation")),
        ("What a change does", ("derivative", "gradient")),
        (
            "Errors",
            (
                *("condition", "left_open", "loop_residual", "rate_residual"),
                *("balance_residual", "power_residual"),
            ),
        ),
        ("Figures and files", ("plot", "save", "to_csv", "to_dataframe", "to_xarray")),
    ),
    "TaskSweep": (
        ("All of a sweep, and", ("actuated_effort", "task_position", "task_speed")),
        ("Errors", ("task_condition", "task_residual")),
    ),
    "Trajectory": (
        ("All of a sweep, its derivatives aside, and", ("at", "evenly", "sweep", "steps")),
        ("Energy", ("kinetic_energy", "potential_energy", "elastic_energy", "work")),
        ("Errors", ("energy_residual", "time_residual", "effort_residual", "singular", "notes")),
    ),
    "TaskTrajectory": (
        ("All of a trajectory, and", ("actuated_effort", "task_position", "task_speed")),
        ("Errors", ("task_residual",)),
    ),
    "Response": (
        ("Forces", ("sweep", "uniform", "turn")),
        ("The drive", ("inertia", "inertia_derivative", "ratio")),
        ("Errors and files", ("error", "interval", "plot", "save")),
    ),
    "Transmission": (
        ("Positions", ("joints_of", "actuated_of")),
        ("Rates", ("jacobian", "jacobian_rate", "singular_values", "borders", "workspace")),
        ("Efforts", ("reflected_inertia", "speed_limits", "effort_limits")),
        ("For controllers", ("fitted", "write_c", "reduced")),
    ),
    "Workspace": (("The whole", ("plot",)),),
}
"""What users ask of a class, by class and subject."""


def interface(linked: bool = False) -> str:
    """Return the page of all public names.

    Args:
        linked: each name leads to the page of the site that has its docstring.
    """
    lines = [
        "# Interface",
        "",
        "Every public name in one line. `import cardan_dyn as cd`; its sub-packages are imported",
        "when they are first used. Lengths are in metres, angles in radians, all else in SI; only",
        "the command line and files of drive lines say other units, with every value. Arguments of",
        "a sweep broadcast, and their common shape, `(1,)` at least, is that of its results.",
        "",
        "Every result (of sweeps, simulations, analyses, scans, vibration) has `to_xarray()`,",
        "`to_dataframe()`, `plot(…)` and `save(path)`.",
    ]
    titles = {
        "load and describe": (
            *("load", "close", "couple", "describe", "assemble", "write", "bundled_names"),
            *("from_pinocchio", "Mechanism"),
        ),
        "scenes": (
            *("Scene", "PointTask", "PoseTask", "AngleTask", "DirectionTask", "DistanceTask"),
            *("Wrench", "described_elements", "view", "study", "DesignVariables"),
        ),
        "results": (
            *("Sweep", "TaskSweep", "Trajectory", "TaskTrajectory", "Response", "Transmission"),
            *("Workspace", "Report"),
        ),
        "force elements": (
            *("JointSpring", "PointSpring", "Bushing", "JointFriction", "Actuator"),
            *("PointActuator", "PinContact"),
            *("LinearContact", "HuntCrossley", "LankaraniNikravesh", "ImpactFunction", "Event"),
        ),
    }
    named = {name for names in titles.values() for name in names}
    errors = [name for name in cd.__all__ if name.endswith("Error")]
    modules = ("clearance", "drive_lines", "figures", "studies", "vibration", "analytic")
    rest = {*cd.__all__} - named - {*errors, *modules, "__version__"}
    titles |= {"parts of results": tuple(sorted(rest)), "errors": tuple(errors)}
    for title, names in titles.items():
        lines += [
            "",
            f"## {title[0].upper()}{title[1:]}",
            "",
            *_listed("cardan_dyn", names, linked),
        ]
        for name in names:
            for what, members in _MEMBERS.get(name, ()):
                lines += ["", f"`{name}`, {what[0].lower()}{what[1:]}:", ""]
                lines += _members(name, members, linked)
    packages = {name: f"cardan_dyn.{name}" for name in modules}
    packages["clearance.drawing"] = "cardan_dyn.motion.clearance.drawing"
    for name, package in packages.items():
        public = import_module(package).__all__
        lines += ["", f"## `cd.{name}`", "", *_listed(package, public, linked)]
    return "\n".join(lines) + "\n"


def _listed(package: str, names: Sequence[str], linked: bool) -> Iterator[str]:
    """Yield a line for each name of a package."""
    for name in names:
        shown = f"[`{name}`]({package}.{name}.md)" if linked else f"`{name}`"
        yield f"- {shown}: {_summary(getattr(import_module(package), name))}"


def _members(name: str, members: Sequence[str], linked: bool) -> Iterator[str]:
    """Yield a line for each method or property of a class."""
    for member in members:
        shown = f"`{name}.{member}`"
        if linked:
            shown = f"{{py:obj}}`{name}.{member} <cardan_dyn.{name}.{member}>`"
        yield f"- {shown}: {_summary(getattr(getattr(cd, name), member))}"


def _summary(item: object) -> str:
    """Return the first paragraph of a docstring, in one line."""
    return (inspect.getdoc(item) or "").split("\n\n")[0].replace("\n", " ")


PAGES = {
    HERE / "practice.md": practice,
    HERE / "errata.md": sources,
    HERE / "interface.md": interface,
}

if __name__ == "__main__":
    for path, page in PAGES.items():
        path.write_text(page(), encoding="utf-8")
