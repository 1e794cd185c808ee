"""The command `driveline`: tables, files, other speeds and limits, messages and exit codes."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner, Result

pytest.importorskip("matplotlib", reason="the command writes figures")
pytest.importorskip("meshcat", reason="the command writes scenes")

from testkit.line_data import FAN, random_line

from cardan_dyn.drive_lines import DriveLine
from cardan_dyn.practice.command_line import commands as cli
from cardan_dyn.practice.viewer.viewing import View


def run(*arguments: str) -> Result:
    return CliRunner().invoke(cli.main, ["driveline", *arguments], catch_exceptions=False)


@pytest.fixture
def wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")


@pytest.mark.slow
@pytest.mark.usefixtures("wide")
def test_prints_data_forks_and_verdict() -> None:
    result = run("truck")
    assert result.exit_code == 0
    for text in (
        "coupling_shaft",
        "3.640",
        "residual angle from 1.414° to 0.029°",
        "Fork couples",
    ):
        assert text in result.output
    assert "FAIL" not in result.output
    strict = run("truck", "--check", "--limit", "residual_angle=0.02rad")
    assert "FAIL axle: residual angle 1.414°" in strict.output
    assert strict.exit_code == 1
    loose = run("truck", "--check")
    assert loose.exit_code == 3
    assert "OPEN gearbox_rear, gearbox_front: force across the shaft: " in loose.output


@pytest.mark.usefixtures("wide")
@pytest.mark.parametrize(
    ("lost", "options", "code"),
    [("", (), 0), ("travel_mm", (), 3), ("", ("--limit", "torsional_distance=0.2"), 1)],
)
def test_a_check_has_three_outcomes(
    lost: str, options: tuple[str, ...], code: int, tmp_path: Path
) -> None:
    file = tmp_path / "fan.toml"
    file.write_text(FAN.replace(", travel_mm = 110", "") if lost else FAN, encoding="utf-8")
    assert run(str(file), "--check", *options).exit_code == code


def table_of(output: str) -> list[str]:
    """Lines of the verdict's table that are rows of a rule."""
    lines = output[output.index("quantity, where, at") : output.index("Verdict: ")].splitlines()
    return [line for line in lines if re.search(r" (pass|fail|open|stated)$", line)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "lost", ["", ", travel_mm = 110", "friction = 0.1, radius_mm = 25, ", "inertia_kgm2 = 25\n"]
)
def test_the_table_has_every_row_and_no_margin_of_open_ones(
    lost: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    file = tmp_path / "fan.toml"
    file.write_text(FAN.replace(lost, ""), encoding="utf-8")
    verdict = DriveLine.from_toml(file).verdict()
    output = run(str(file)).output
    rows = table_of(output)
    assert Counter(line.split()[-1] for line in rows) == Counter(row.status for row in verdict)
    assert len(verdict.open) == sum(row.endswith("open") for row in rows)
    # What is asked for in the same words stands once, with all places.
    opened = [line[5:].split(":")[0] for line in output.splitlines() if line.startswith("OPEN ")]
    assert Counter(", ".join(opened).split(", ") if opened else []) == Counter(
        row.where or "line" for row in verdict.open
    )
    for line, row in zip(rows, verdict, strict=True):
        assert line.startswith(row.quantity)
        assert row.texts()[6] == "" or (row.texts()[6] in line) == (row.status != "open")
    has_limit = [row for row in verdict.open if row.margin is not None]
    assert bool(has_limit) == ("friction" in lost)


def test_torsional_speeds_are_told_with_order_speed_and_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    file = tmp_path / "fan.toml"
    file.write_text(FAN, encoding="utf-8")
    # Two inertias and that of the tube in the middle: the lower root of three in a row.
    outer, inner = 0.045, 0.042
    stiff = 80.8e9 * np.pi / 2.0 * (outer**4 - inner**4) / 1.2
    half, middle = 2.0 * stiff, 7850.0 * np.pi / 2.0 * (outer**4 - inner**4) * 1.2
    mean = 0.5 * half * (1.0 / 0.5 + 2.0 / middle + 1.0 / 25.0)
    product = half**2 * (0.5 + middle + 25.0) / (0.5 * middle * 25.0)
    natural = 30.0 / np.pi * np.sqrt(product / (mean + np.sqrt(mean**2 - product)))
    told = f"(order 2 {natural / 2.0:.0f} 1/min; order 4 {natural / 4.0:.0f} 1/min; "
    output = run(str(file), "--limit", "torsional_distance=0.5").output
    joined = " ".join(output.split())
    rule = "distance from a torsional critical speed "
    assert f"FAIL line: {rule}{told}" in joined
    distance = 1.0 - 980.0 / (natural / 4.0)
    nearest = f"nearest: order 4 at {natural / 4.0:.0f} 1/min) {distance:.4g} at rated"
    assert f"{nearest}, limit ≥ 0.5" in joined
    (row,) = [line for line in table_of(output) if line.startswith(rule)]
    assert told in row and ", rated " in row


@pytest.mark.campaign
@pytest.mark.slow
def test_writes_page_figures_and_scene(tmp_path: Path) -> None:
    page, figures, scene = tmp_path / "b.html", tmp_path / "f", tmp_path / "s.html"
    result = run(
        "paper_machine",
        *("--page", str(page), "--no-scene", "--figures", str(figures), "--export", str(scene)),
    )
    assert result.exit_code == 0
    assert "Drive line paper_machine" in page.read_text("utf-8")
    assert len(list(figures.iterdir())) == 8  # Four figures, as SVG and PNG.
    assert "paper_machine" in scene.read_text("utf-8")


@pytest.mark.slow
def test_json_with_other_speed_limits_and_forks() -> None:
    options = ("--speed", "3000", "--torque", "50", "--limit", "residual_angle=1e-4 rad")
    plain = json.loads(run("truck", "--json", *options).output)
    best = json.loads(run("truck", "--json", *options, "--optimise-phases").output)
    teeth = json.loads(run("truck", "--json", *options, "--teeth", "4").output)

    def residual(found: dict) -> dict:
        return next(row for row in found["rows"] if row["where"] == "axle" and row["limit"])

    assert residual(plain)["limit"]["value"] == 1e-4
    assert residual(plain)["value"] == pytest.approx(plain["phasing"]["given_residual_angle"])
    assert residual(best)["value"] == pytest.approx(plain["phasing"]["residual_angle"], rel=1e-9)
    assert np.allclose(np.mod(teeth["phasing"]["fork_offsets"], np.pi / 2), 0.0)
    speeds = [row["value"] for row in plain["rows"] if row["quantity"] == "speed"]
    assert speeds == pytest.approx([100 * np.pi] * 3)


@pytest.mark.slow
def test_the_help_names_a_limit_that_there_is() -> None:
    (named,) = re.findall(
        r"as (\w+=\w+)", " ".join(run("--help").output.split("--limit")[1].split())
    )
    assert run("truck", "--limit", named).exit_code == 0


def test_schema_holds_what_is_written() -> None:
    schema = json.loads(run("--schema").output)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert "application" in json.dumps(schema)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("none.toml",), "none.toml cannot be read"),
        (("truk",), "did you mean 'truck'"),
        ((), "lines of the package: paper_machine"),
        (("truck", "--limit", "residual=1deg"), "no limit of the verdict"),
        (("truck", "--limit", "residual_angle"), "--limit 'residual_angle' is not NAME=VALUE"),
        (("truck", "--limit", "residual_angle=3"), "--limit residual_angle = '3' has no unit"),
        (("truck", "--limit", "residual_angle=3mm"), "has the unit 'mm', which is none of angle"),
        (("truck", "--limit", "non_uniformity=3deg"), "expected a finite number [1]"),
        (("truck", "--page", "/dev/null/x.html"), "cannot be written"),
        (("truck", "--teeth", "1"), "teeth"),
    ],
)
def test_messages(arguments: tuple[str, ...], message: str) -> None:
    result = run(*arguments)
    assert result.exit_code != 0
    assert message in " ".join(result.output.split())
    assert "Traceback" not in result.output


def test_a_line_without_speed_asks_for_it(tmp_path: Path) -> None:
    path = tmp_path / "line.toml"
    random_line(1, 1).to_toml(path)
    assert "give --speed" in run(str(path)).output
    result = run(str(path), "--speed", "100", "--torque", "5")
    assert result.exit_code == 0 and "one joint" in result.output
    assert DriveLine.from_toml(path).speed is None


@pytest.mark.slow
def test_view_serves_the_turning_line(monkeypatch: pytest.MonkeyPatch) -> None:
    served: list[View] = []
    monkeypatch.setattr(View, "serve", lambda self: served.append(self))
    result = run("rolling_mill", "--view", "--no-open")
    assert result.exit_code == 0 and "Scene: http" in result.output
    assert len(served) == 1
    served[0].close()


@pytest.mark.slow
def test_says_on_the_page_whose_it_is_in_other_words_and_units(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    result = run(
        *("pto", "--page", str(page), "--no-scene", "--language", "de", "--units", "imperial"),
        *("--project", "Mäher <7>", "--customer", "Hof Nord", "--author", "A. B."),
        *("--revision", "C", "--date", "2026-01-31"),
    )
    assert result.exit_code == 0
    text = page.read_text("utf-8")
    for told in ("Mäher &lt;7&gt;", "Hof Nord", "A. B.", "31.01.2026", "lbf·ft", "Beurteilung"):
        assert told in text
    wrong = CliRunner().invoke(cli.main, ["driveline", "pto", "--date", "31.1.2026"])
    assert wrong.exit_code and "such as 2026-01-31" in str(wrong.output) + str(wrong.exception)


def test_required_ratings_stand_there_before_any_is_given(tmp_path: Path) -> None:
    """As the inverse of a row that has a rating, whatever that is; without a life it is asked."""
    line = DriveLine.from_toml("truck")
    bare = [replace(joint, rated_torque=None, capacity=None) for joint in line.joints]
    for kind in ("rated_torque", "capacity"):
        rated = line.replace(joints=[replace(joint, **{kind: 1e3}) for joint in bare])
        given, wanted = (
            {
                (row.where, str(one))
                for row in item.verdict()
                if row.rule in ("joint_life", "duty_cycle") and row.status != "stated"
                for one in row.inverses
            }
            for item in (rated, line.replace(joints=bare))
        )
        assert given and given <= wanted
    file = tmp_path / "bare.toml"
    file.write_text(line.replace(joints=bare).to_toml(), encoding="utf-8")
    found = run(str(file))
    told = " ".join(found.output.split())
    for where, text in wanted:
        assert text in told.partition(f"OPEN {where}: B10 life: ")[2].partition("OPEN")[0]
    assert "give rated_torque or capacity of the joint" in told
    assert "PTO" not in told  # The file says that it is no agricultural line.
    file.write_text(line.replace(joints=bare, life=None).to_toml(), encoding="utf-8")
    assert "give life of the line" in " ".join(run(str(file)).output.split())


def test_a_page_is_in_the_units_of_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cardan_dyn.practice.report.page.image", lambda figure: "data:,")
    text = DriveLine.from_toml("pto").to_toml()
    # Other units stay as they are: most decide.
    inches = re.sub(
        r"_mm = (\S+)$",
        lambda found: f" = '{float(found[1]) / 25.4!r}\"'",
        text,
        flags=re.MULTILINE,
    )
    inches = re.sub(r"_nm = (\S+)$", r" = '\1 lbf·ft'", inches, flags=re.MULTILINE)
    assert inches.count("\"'") > 10 and "_kg = " in inches
    for content, unit, other in ((text, "[mm]", "[in]"), (inches, "[in]", "[mm]")):
        file, page = tmp_path / "line.toml", tmp_path / "page.html"
        file.write_text(content, encoding="utf-8")
        assert run(str(file), "--page", str(page), "--no-scene").exit_code == 0
        shown = page.read_text("utf-8")
        assert unit in shown and other not in shown
    assert run(str(file), "--page", str(page), "--no-scene", "--units", "si").exit_code == 0
    assert "[mm]" in page.read_text("utf-8")
