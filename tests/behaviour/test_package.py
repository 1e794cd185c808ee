"""The package as it is installed: what importing costs, and what a wheel carries."""

from __future__ import annotations

import json
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from pages import followed

import cardan_dyn as cd
from cardan_dyn.core import compiled
from cardan_dyn.practice.command_line import main

ROOT = Path(__file__).parents[2]

needs_kernel = pytest.mark.skipif(compiled.kernel is None, reason="nothing is compiled here")

SCRIPT = """
import sys
from pathlib import Path
import numpy as np, cardan_dyn as cd
from cardan_dyn import analytic
root = Path(sys.argv[1])
assert Path(cd.__file__).is_relative_to(root), cd.__file__
assert Path(analytic.__file__).is_relative_to(root), analytic.__file__
assert {"double_shaft_z", "universal_joint"} <= set(cd.bundled_names())
scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.5},
                 loads={"bearing_out": -1.0})
assert scene.sweep([0.0]).loop_residual < 1e-14
from cardan_dyn.practice.command_line import commands as cli
cli.main(["compare", "--out", sys.argv[2]], standalone_mode=False)
"""


def python(
    *arguments: str, cwd: Path, path: Path | None = None, **more: str
) -> subprocess.CompletedProcess:
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | more
    if path is not None:
        environment["PYTHONPATH"] = str(path)
    return subprocess.run(
        [sys.executable, *arguments], cwd=cwd, env=environment, capture_output=True, text=True
    )


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Return a folder from which a copy of the package is imported."""
    ignored = shutil.ignore_patterns("__pycache__")
    # A folder with a space in its name, as users have.
    folder = tmp_path / "a copy"
    shutil.copytree(ROOT / "cardan_dyn", folder / "cardan_dyn", ignore=ignored)
    shutil.copytree(ROOT / "urdf", folder / "urdf", ignore=ignored)
    return folder


def said_by(package: Path) -> str:
    """Return what the command says of its version, and warnings behind it."""
    code = "from cardan_dyn.practice.command_line import main; main(['--version'])"
    ran = python("-c", code, cwd=package, path=package)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout + ran.stderr


@pytest.mark.slow
def test_an_installed_wheel_finds_its_descriptions(tmp_path: Path) -> None:
    pytest.importorskip("build", reason="the extra `test` brings the build front end")
    # As a release is built: the wheel from the source distribution, in which there are no links.
    # Compiling takes longer than all the rest, and is done whenever the package is installed.
    built = python(
        *("-m", "build", "--no-isolation", "--outdir", str(tmp_path), str(ROOT)),
        cwd=tmp_path,
        CC="false",
    )
    assert built.returncode == 0, built.stdout + built.stderr
    (archived,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archived) as archive:
        within = {name.partition("/")[2] for name in archive.getnames()}
    compiled_of = {path.relative_to(ROOT).as_posix() for path in ROOT.glob("cardan_dyn/**/*.[ch]")}
    assert compiled_of and compiled_of | {"hatch_build.py"} <= within
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        archive.extractall(tmp_path / "site")
    assert "cardan_dyn/urdf/universal_joint.urdf" in names
    assert "cardan_dyn/practice/report/templates/report.html" in names
    assert "cardan_dyn/core/description/words.json" in names
    assert "cardan_dyn/AGENTS.md" in names
    assert "cardan_dyn/analytic/grossmann.py" in names
    assert not [name for name in names if name.startswith(("tests/", "urdf/", "analytic/"))]
    # Without a compiler it serves every machine.
    assert wheel.name.endswith("-py3-none-any.whl")
    assert not [name for name in names if name.endswith((".so", ".c", ".h"))]
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    site = tmp_path / "site"
    ran = python("-c", SCRIPT, str(site), str(elsewhere / "out"), cwd=elsewhere, path=site)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert (elsewhere / "out" / "index.html").exists()


@needs_kernel
def test_the_version_says_whether_compiled_functions_are_used(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert said_by(package).splitlines() == [
        f"cardan-dyn, version {cd.__version__}",
        "compiled functions: yes",
    ]
    monkeypatch.setenv("CARDAN_DYN_COMPILED", "0")
    assert "compiled functions: no, switched off by CARDAN_DYN_COMPILED=0" in said_by(package)
    monkeypatch.delenv("CARDAN_DYN_COMPILED")
    for built in package.glob("cardan_dyn/core/compiled/*.so"):
        built.unlink()
    assert "compiled functions: no, this installation has none" in said_by(package)


@needs_kernel
@pytest.mark.parametrize("source", ["closure.c", "kernels.h", "new.c"])
def test_functions_compiled_of_other_sources_are_not_used(package: Path, source: str) -> None:
    with (package / "cardan_dyn/core/compiled" / source).open("a", encoding="utf-8") as file:
        file.write("/* changed */\n")
    why = "they were made of other sources; compile them again: python hatch_build.py"
    said = said_by(package)
    assert f"RuntimeWarning: without compiled functions, {why}" in said
    assert f"compiled functions: no, {why}" in said


@pytest.mark.slow
@needs_kernel
@pytest.mark.parametrize("content", [b"", b"of another machine"])
def test_without_functions_that_cannot_be_loaded_numpy_does_it_all(
    package: Path, content: bytes
) -> None:
    (built,) = package.glob("cardan_dyn/core/compiled/*.so")
    built.write_bytes(content)
    said = said_by(package)
    assert "RuntimeWarning: without compiled functions, they cannot be loaded: " in said
    assert built.name in said
    assert "install the package again" in said
    code = "import cardan_dyn as cd; print(cd.Scene(cd.load('universal_joint'), drive='bearing_in',"
    code += " held={'joint_angle': 0.5}).sweep([0.0]).loop_residual < 1e-14)"
    ran = python("-c", code, cwd=package, path=package)
    assert ran.stdout == "True\n", ran.stderr


def files_of(folder: Path) -> list[Path]:
    """Return all files but bytecode, which Python leaves where it may."""
    return sorted(path for path in folder.rglob("*") if "__pycache__" not in path.parts)


@pytest.mark.slow
def test_a_wheel_leaves_the_sources_as_they_are(package: Path) -> None:
    pytest.importorskip("build", reason="the extra `test` brings the build front end")
    shutil.copytree(ROOT / "analytic", package / "analytic")
    for name in ("pyproject.toml", "hatch_build.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, package / name)
    for built in package.glob("cardan_dyn/core/compiled/*.so"):
        built.unlink()
    # Where what is compiled goes does not depend on what it is, which would take a minute.
    for source in package.glob("cardan_dyn/core/compiled/*.c"):
        source.write_text("", encoding="utf-8")
    before = files_of(package)
    to = package.parent / "wheels"
    ran = python(
        *("-m", "build", "--wheel", "--no-isolation", "--outdir", str(to), str(package)),
        cwd=package.parent,
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert files_of(package) == before
    (wheel,) = to.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        built = [
            name for name in archive.namelist() if name.startswith("cardan_dyn/core/compiled/")
        ]
    assert sorted(built) == ["cardan_dyn/core/compiled/__init__.py"] + (
        ["cardan_dyn/core/compiled/_kernel.abi3.so"] if "-abi3-" in wheel.name else []
    )


def test_importing_loads_nothing_until_a_name_is_asked_for(tmp_path: Path) -> None:
    code = (
        "import sys, cardan_dyn as cd; cd.__version__; "
        "print(*sorted({name.split('.')[0] for name in sys.modules} & {'numpy', 'pinocchio', "
        "'matplotlib', 'meshcat', 'trimesh', 'scipy', 'click', 'rich', 'jinja2'}))"
    )
    ran = python("-c", code, cwd=tmp_path, path=ROOT)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.split() == []


@pytest.mark.slow
def test_a_sweep_imports_what_it_needs_and_no_more(tmp_path: Path) -> None:
    """NumPy's random numbers alone would take longer to import than a scene takes to make."""
    code = (
        "import sys, pinocchio; before = set(sys.modules); import cardan_dyn as cd; "
        "scene = cd.Scene(cd.load('universal_joint'), drive='bearing_in', "
        "held={'joint_angle': 0.8}, loads={'bearing_out': -1.0}); "
        "scene.sweep([0.1, 0.2], speed=3.0)['bearing_out'].bending; "
        "print(len(set(sys.modules) - before)); "
        "print(*sorted({'numpy.random', 'numpy.ma', 'numpy.typing', 'scipy', 'tempfile', "
        "'difflib', 'cardan_dyn.core.response.response', 'cardan_dyn.core.kinematics.diagnosis', "
        "'cardan_dyn.practice.formats.mjcf.reader'} & set(sys.modules)))"
    )
    ran = python("-c", code, cwd=tmp_path, path=ROOT)
    assert ran.returncode == 0, ran.stderr
    imported, unwanted = ran.stdout.splitlines()
    # What is imported beyond Pinocchio: zlib, and what a sweep runs through, with its tape.
    assert int(imported) <= 144
    assert unwanted == ""


def test_what_makes_a_scene_imports_no_more(tmp_path: Path) -> None:
    """What sweeps, follows and proves is imported when it is first asked for."""
    code = (
        "import sys, pinocchio; before = set(sys.modules); from cardan_dyn import Scene, load; "
        "scene = Scene(load('universal_joint'), drive='bearing_in', held={'joint_angle': 0.0}); "
        "print(len(set(sys.modules) - before)); "
        "print(*sorted({'cardan_dyn.core.' + room for room in ('results.sweep', "
        "'dynamics.inverse_dynamics', 'proof.residuals', 'kinematics.following.lines')} "
        "& set(sys.modules)))"
    )
    ran = python("-c", code, cwd=tmp_path, path=ROOT)
    assert ran.returncode == 0, ran.stderr
    imported, unwanted = ran.stdout.splitlines()
    assert int(imported) <= 107  # Two of them are storeys.
    assert unwanted == ""


PAGES = [
    page
    for page in [
        ROOT / "README.md",
        ROOT / "cardan_dyn" / "AGENTS.md",
        *sorted((ROOT / "docs").glob("*.md")),
    ]
    if "```python" in page.read_text(encoding="utf-8") and page.stem != "studies"  # It has its own.
]


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_what_pages_show_runs_and_prints_what_they_say(page: Path, tmp_path: Path) -> None:
    assert followed(page, tmp_path) == []


@pytest.mark.slow
def test_the_first_command_of_the_readme_shows_what_its_picture_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib", reason="the gallery draws figures")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(tmp_path)
    shown = runpy.run_path(str(ROOT / "docs" / "gallery" / "2_linkages" / "excavator_arm.py"))
    cd.write(shown["arm"], "excavator.urdf")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^cardan-dyn (view .+)$", readme, flags=re.MULTILINE)
    ran = CliRunner().invoke(main, [*shlex.split(command), "--export", "scene.html"])
    assert ran.exit_code == 0, ran.output
    assert Path("scene.html").stat().st_size > 1e5
    # The pin and the stroke of the picture, with the bucket as it is held there.
    scene = shown["scene"].replace(held={"crowd": 0.35, "bucket_pin": np.radians(-35)})
    assert scene.sweep([0.444])["boom_pin"].shear[0] == pytest.approx(242.8e3, rel=5e-4)


def test_every_word_of_urdf_is_described() -> None:
    path = ROOT / "cardan_dyn" / "core" / "description" / "words.json"
    words = json.loads(path.read_text("utf-8"))
    page = (ROOT / "docs" / "describe.md").read_text(encoding="utf-8")
    table = page.split("## Every element and attribute")[1].split("## Other notations")[0]
    told = set(re.findall(r"`(\w+)(?:=[^`]*)?`", table))
    for elements, allowed in words["urdf"].items():
        known = {*elements.split(), *" ".join(allowed.values()).split()}
        assert known <= told | {"type", "xyz", "rpy"}, known - told


def test_coding_agents_are_told_errors_and_attributes_that_exist() -> None:
    text = (ROOT / "cardan_dyn" / "AGENTS.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 80
    assert text in included(ROOT / "docs" / "coding_agents.md")
    named = set(re.findall(r"^\| `(\w+Error)`", text, flags=re.MULTILINE))
    assert named >= {"ModelError", "MobilityError", "AssemblyError", "SingularConfigurationError"}
    bar, joint = cd.load("four_bar"), cd.load("universal_joint")
    rocker = cd.Scene(bar, drive="rocker_bearing")
    crank = cd.Scene(bar, drive="crank_bearing", strict=True)
    raised = {}
    for mistake in (
        lambda: cd.Scene(bar, drive="no_joint"),
        lambda: cd.Scene(joint, drive="bearing_in"),
        lambda: rocker.sweep([3.0]),
        lambda: cd.Scene(cd.load("slider_crank"), drive="piston_guide"),  # At its dead centre.
        lambda: crank.sweep([0.0]),
        lambda: crank.sweep([np.nan]),
    ):
        with pytest.raises(cd.CardanError) as caught:
            mistake()
        raised[type(caught.value).__name__] = caught.value
    assert set(raised) == named
    assert raised["MobilityError"].advised == ["joint_angle"]
    assert raised["AssemblyError"].reach == pytest.approx(rocker.motion_range())


def included(page: Path) -> str:
    """Return the text of the files that a page includes."""
    found = re.findall(r"^```\{include\} (\S+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return "\n".join((page.parent / name).read_text(encoding="utf-8") for name in found)


@pytest.mark.slow
def test_pictures_of_the_theory_are_drawn_by_its_script(tmp_path: Path) -> None:
    ran = python(str(ROOT / "docs" / "theory_figures.py"), str(tmp_path), cwd=tmp_path, path=ROOT)
    assert ran.returncode == 0, ran.stderr
    page = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"images/theory/(\w+\.svg)", page))
    assert {path.name for path in tmp_path.iterdir()} == shown
    assert {path.name for path in (ROOT / "docs" / "images" / "theory").iterdir()} == shown


def test_messages_that_the_questions_quote_are_the_package_s() -> None:
    page = (ROOT / "docs" / "questions.md").read_text(encoding="utf-8")
    quoted = re.findall(r'^## .*"(.+)"', page, flags=re.MULTILINE)
    assert len(quoted) >= 4
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "cardan_dyn").rglob("*.py")]
    # A message may go on in the next line of its source.
    source = re.sub(r'"\s*\n\s*f?"', "", "\n".join(texts))
    assert [part for part in quoted if part not in source] == []


def test_analytic_knows_nothing_of_the_solver() -> None:
    code = (
        "import sys, analytic; from analytic import thoma; import analytic.impact; "
        "print(*[m for m in sys.modules if m.startswith(('cardan', 'pin'))])"
    )
    ran = python("-c", code, cwd=ROOT)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.split() == []


def test_closed_forms_load_no_solver() -> None:
    code = (
        "import sys, cardan_dyn.analytic, cardan_dyn as cd; cd.analytic.thoma; "
        "print(*sorted({m.split('.')[0] for m in sys.modules} & {'pinocchio', 'scipy', 'click'}))"
    )
    ran = python("-c", code, cwd=ROOT)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.split() == []
