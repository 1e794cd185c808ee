"""Extension of the site: what the gallery shows, and the scene that stands on the first page.

A script's page shows what it calls `figure`. Its picture among the others is the mechanism, without
words, which would be too small there.
"""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

import cardan_dyn as cd
from cardan_dyn.practice.viewer.picture import picture
from cardan_dyn.practice.viewer.still import Still

LIVE = {"excavator": ("2_linkages/excavator_arm.py", "swing")}
"""Scenes of the site to the script that makes each, and what it calls the sweep."""


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figure as soon as a block has made one, and return what shows it."""
    named = block_vars["example_globals"]
    figure = named.get("figure")
    if not isinstance(figure, Figure) or block_vars.get("shown") is figure:
        return ""
    if "shown" not in block_vars and (drawn := mechanism(named)) is not None:
        drawing = picture(drawn)
        for axes in drawing.axes:
            for text in [*axes.texts]:
                text.remove()
        # The first image of a page is its picture in the gallery, whether the page shows it or not.
        drawing.savefig(Path(next(block_vars["image_path_iterator"])), dpi=120, bbox_inches="tight")
    block_vars["shown"] = figure
    path = Path(next(block_vars["image_path_iterator"]))
    figure.savefig(path, dpi=120, bbox_inches="tight", pad_inches=0.15)
    plt.close("all")
    return str(figure_rst([str(path)], gallery_conf["src_dir"]))


def mechanism(named: dict[str, Any]) -> cd.Sweep | Still | None:
    """Return what a script has computed of a mechanism, with its loads; or where it starts."""
    for item in named.values():
        if isinstance(item, (cd.Trajectory, cd.Equilibrium)):
            return item.sweep
        if isinstance(item, cd.Sweep) and len(item.shape) == 1:
            return item
    for item in named.values():
        scene = item.scene() if isinstance(item, cd.drive_lines.DriveLine) else item
        if isinstance(scene, cd.Scene):
            return Still(scene.configuration(), scene.elements)
        if isinstance(scene, cd.Mechanism):
            return Still(cd.assemble(scene))
    return None


def write_scenes(app: Any, exception: Exception | None) -> None:
    """Write scenes as pages of the site that move."""
    if exception is not None:
        return
    folder = Path(app.outdir) / "scenes"
    folder.mkdir(exist_ok=True)
    for name, (script, sweep) in LIVE.items():
        named = runpy.run_path(str(Path(app.srcdir) / "gallery" / script))
        plt.close("all")
        cd.view(named[sweep], title=name.capitalize()).export(folder / f"{name}.html")


def setup(app: Any) -> dict[str, bool]:
    """Join the build."""
    app.connect("build-finished", write_scenes)
    return {"parallel_read_safe": True}


def _get_sg_image_scraper() -> Any:
    return scrape
