"""Draw the main figure of each notebook into docs/images: python tests/notebooks/pictures.py."""

from __future__ import annotations

import tempfile
from pathlib import Path

import nbclient
import nbformat

ROOT = Path(__file__).parents[2]
LIMIT = 150_000  # bytes


def draw(path: Path, target: Path) -> None:
    """Execute a notebook and write the figure that its cell tagged `main-figure` calls `main`."""
    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as directory:
        there = Path(directory) / path.stem
        notebook.cells.append(
            nbformat.v4.new_code_cell(
                "from cardan_dyn import figures\n"
                f"if 'main' in globals():\n    figures.save(main, {str(there)!r}, dpi=110)"
            )
        )
        resources = {"metadata": {"path": str(path.parent)}}
        nbclient.NotebookClient(notebook, timeout=120, resources=resources).execute()
        picture = there.with_suffix(".png")
        if not picture.exists():
            print(f"{path.stem}: no main figure")  # run_time_against_error without results
            return
        content = picture.read_bytes()
        if len(content) > LIMIT:
            raise ValueError(f"{path.stem}: {len(content)} bytes are more than {LIMIT}")
        target.write_bytes(content)
        print(f"{target.name}: {len(content)} bytes")


if __name__ == "__main__":
    for notebook_path in sorted((ROOT / "notebooks").glob("*.ipynb")):
        draw(notebook_path, ROOT / "docs" / "images" / f"{notebook_path.stem}.png")
