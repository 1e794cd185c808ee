"""The notebooks: stored without outputs, they tell and execute; proofs are in their own tests."""

from __future__ import annotations

import ast
import json
import re
import shutil
import warnings
from pathlib import Path
from typing import Any

import pytest

nbclient = pytest.importorskip("nbclient", reason="executing notebooks needs nbclient")
nbformat = pytest.importorskip("nbformat", reason="reading notebooks needs nbformat")
pytest.importorskip("ipykernel", reason="executing notebooks needs a kernel")
pytest.importorskip("matplotlib", reason="the notebooks draw figures")

DIRECTORY = Path(__file__).parents[2] / "notebooks"
NAMES = (
    "catalogue",
    "dresig_thuemmel",
    "drive_line_design",
    "first_steps",
    "free_motion",
    "grossmann",
    "run_time_against_error",
    "thoma",
    "thoma_critical_speeds",
    "weisbach",
)
TIMEOUT = 120
"""Seconds that one cell may take; all notebooks together need about a minute."""
SOURCES = {
    "catalogue": "chapter 6",
    "dresig_thuemmel": "Karl-Marx-Stadt",
    "grossmann": "Schweizerische Bauzeitung 113 (1939)",
    "thoma": "Schweizerische Bauzeitung 75 (1920), no. 17, p. 187",
    "thoma_critical_speeds": "Schweizerische Bauzeitung 75 (1920)",
    "weisbach": "§ 26",
}


def notebook(name: str) -> Any:
    return nbformat.read(DIRECTORY / f"{name}.ipynb", as_version=4)


def code(name: str) -> list[str]:
    return [cell.source for cell in notebook(name).cells if cell.cell_type == "code"]


def test_all_notebooks_are_tested() -> None:
    assert sorted(path.stem for path in DIRECTORY.glob("*.ipynb")) == sorted(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_stored_without_outputs(name: str) -> None:
    stored = notebook(name)
    nbformat.validate(stored)
    for cell in stored.cells:
        if cell.cell_type == "code":
            assert cell.outputs == []
            assert cell.execution_count is None
    # Nothing of the machine on which it was written.
    assert set(stored.metadata) <= {"kernelspec", "language_info"}
    assert stored.metadata.kernelspec.name == "python3"
    assert set(stored.metadata.language_info) == {"name"}


@pytest.mark.parametrize("name", NAMES)
def test_tells_and_leaves_proofs_to_tests(name: str) -> None:
    text = "\n".join(cell.source for cell in notebook(name).cells)
    assert SOURCES.get(name, "#") in text
    for cell in code(name):
        for node in ast.walk(ast.parse(cell.replace("%matplotlib inline", ""))):
            assert not isinstance(node, ast.Assert)
            assert not (isinstance(node, ast.Attribute) and node.attr.startswith("assert_"))
    if name in SOURCES:
        assert re.search(r"\*\*What (he|they|it) asked|\*\*What it asks", text)
        assert re.search(r"## What (he|they) got wrong|## What it gets wrong", text)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_executes(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    executed = run(name, DIRECTORY, monkeypatch)
    assert complaints(executed) == []
    assert pictures(executed) >= 1


@pytest.mark.slow
def test_reads_results_of_benchmarks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    records = [
        {
            "method": method,
            "task": "wrenches",
            "beta_deg": beta_deg,
            "error": 10.0**-steps,
            "microseconds": cost * steps,
        }
        for method, cost in (("one", 1.0), ("other", 3.0))
        for beta_deg in (8.5, 50.0)
        for steps in (2, 4, 6)
    ]
    folder = tmp_path / "benchmarks" / "results"
    folder.mkdir(parents=True)
    shutil.copy(DIRECTORY.parent / "benchmarks" / "work_precision.py", folder.parent)
    content = json.dumps({"machine": {}, "records": records})
    (folder / "precision.json").write_text(content, encoding="utf-8")
    executed = run("run_time_against_error", tmp_path, monkeypatch)
    assert complaints(executed) == []
    assert pictures(executed) == 2
    text = "".join(
        output.text
        for cell in executed.cells
        for output in cell.get("outputs", [])
        if output.output_type == "stream"
    )
    assert "12 records" in text
    assert "wrenches, β = 8.5°" in text and "wrenches, β = 50°" in text


def run(name: str, where: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Execute a notebook in a directory and return it with its outputs."""
    monkeypatch.delenv("MPLBACKEND", raising=False)  # the notebooks choose `inline` themselves
    for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        monkeypatch.setenv(threads, "1")
    client = nbclient.NotebookClient(
        notebook(name),
        timeout=TIMEOUT,
        kernel_name="python3",
        resources={"metadata": {"path": str(where)}},
    )
    with warnings.catch_warnings():
        # Those of the machinery that runs kernels; the notebook's own are its outputs.
        warnings.simplefilter("ignore")
        return client.execute()


def complaints(executed: Any) -> list[str]:
    return [
        output.text
        for cell in executed.cells
        for output in cell.get("outputs", [])
        if output.output_type == "stream"
        and output.name == "stderr"
        and "IPKernelApp" not in output.text
        and not output.text.startswith("\r")  # How far something is.
    ]


def pictures(executed: Any) -> int:
    outputs = [output for cell in executed.cells for output in cell.get("outputs", [])]
    return sum("image/png" in output.get("data", {}) for output in outputs)
