"""Pages as their readers follow them: `python pages.py PAGE` does it in the folder one stands in.

It needs nothing but the package, so that the page is followed where nothing else is installed.
"""

from __future__ import annotations

import math
import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path


def blocks(page: Path, language: str) -> list[str]:
    """Return the blocks of a page in a language."""
    text = page.read_text(encoding="utf-8")
    return [part.split("```")[0] for part in text.split(f"```{language}\n")[1:]]


def followed(page: Path, folder: Path) -> list[str]:
    """Return what is wrong where somebody runs the Python of a page in an empty folder.

    Args:
        page: with Python in blocks, and what it prints in blocks of text.
        folder: in which it is run, by the Python that runs this, with the package that this finds:
            where there are several checkouts, an installed one may be another.
    """
    package = find_spec("cardan_dyn")
    assert package is not None and package.origin is not None, "cardan_dyn is not installed"
    environment = {**os.environ, "PYTHONPATH": str(Path(package.origin).parents[1])}
    code = "\n".join(blocks(page, "python"))
    ran = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, env=environment, capture_output=True, text=True
    )
    if ran.returncode:
        return [ran.stderr]
    printed = ran.stdout.split()
    expected = [word for part in blocks(page, "text") for word in part.split()]
    wrong = [
        f"{word} is printed as {found}"
        for found, word in zip(printed, expected, strict=False)
        if not _alike(found, word)
    ]
    if len(printed) != len(expected):
        wrong.append(f"{len(expected)} words are said to be printed, and {len(printed)} are")
    for name in re.findall(r'"(\w+\.(?:png|csv|html|nc|toml))"', code):
        if not (folder / name).is_file() or not (folder / name).stat().st_size:
            wrong += [f"{name} is not written"]
    return wrong


def _alike(found: str, word: str) -> bool:
    """Return whether words are the same but for rounding, whose digits depend on the processor."""
    if found == word:
        return True
    first, second = _number(found), _number(word)
    return math.isclose(first, second, rel_tol=1e-13) or (
        abs(first) < 1e-12 and abs(second) < 1e-12
    )


def _number(word: str) -> float:
    """Return a number without the punctuation about it; what is not alike to any if it is none."""
    try:
        return float(word.strip("[](),;:"))
    except ValueError:
        return math.nan


def main() -> None:
    """Follow a page, its commands of the shell after its Python, and say what is wrong."""
    page, folder = Path(sys.argv[1]).resolve(), Path.cwd()
    if found := followed(page, folder):
        sys.exit("\n".join(found))
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    for command in blocks(page, "sh"):
        subprocess.run(command, shell=True, check=True, env={**os.environ, "PATH": path})


if __name__ == "__main__":
    main()
