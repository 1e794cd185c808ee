"""The changes that docs/changing.md shows, made to a copy of the package: its checks pass then."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pages import blocks

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "changing.md"


def changed(folder: Path, diff: str) -> None:
    """Change the files of a folder; what a part of a diff begins with has to be there once."""
    for part in re.split(r"^(?=--- |\+\+\+ )", diff, flags=re.MULTILINE)[1:]:
        head, _, body = part.partition("\n")
        path = folder / head[4:]
        text = "" if head.startswith("+") else path.read_text(encoding="utf-8")
        for hunk in body.split("@@\n"):
            lines = hunk.splitlines(keepends=True)
            before, after = (
                "".join(line[1:] for line in lines if line[0] in signs) for signs in (" -", " +")
            )
            assert not text or text.count(before) == 1, before
            text = text.replace(before, after, 1)
        path.write_text(text, encoding="utf-8")


@pytest.mark.slow
def test_each_change_is_complete(tmp_path: Path) -> None:
    for name in ("cardan_dyn", "urdf"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    for diff in blocks(PAGE, "diff"):
        changed(tmp_path, diff)
    ran = subprocess.run(
        [sys.executable, "-c", "\n".join(blocks(PAGE, "py"))],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert ran.returncode == 0, ran.stderr
