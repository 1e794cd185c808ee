"""Lets the gallery show what its scripts call `figure`, however it was made."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figure as soon as a block has made one, and return what shows it."""
    figure = block_vars["example_globals"].get("figure")
    if not isinstance(figure, Figure) or block_vars.get("shown") is figure:
        return ""
    block_vars["shown"] = figure
    path = Path(next(block_vars["image_path_iterator"]))
    figure.savefig(path, dpi=120, bbox_inches="tight", pad_inches=0.15)
    plt.close("all")
    return str(figure_rst([str(path)], gallery_conf["src_dir"]))


def _get_sg_image_scraper() -> Any:
    return scrape
