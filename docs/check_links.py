"""Check that every link within a built site leads somewhere: python docs/check_links.py site.

The general checkers of links read each page once for every link to it: minutes, where this takes
seconds.
"""

from __future__ import annotations

import sys
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """What a page links to, and the places in it that can be linked to."""

    def __init__(self) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.anchors: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note links and anchors of an element."""
        for name, value in attrs:
            if value is None:
                continue
            if name in {"href", "src"} and tag != "base":
                self.links.add(value)
            elif name in {"id", "name"}:
                self.anchors.add(value)


@cache
def page(path: Path) -> Page:
    """Return what a file of HTML holds."""
    read = Page()
    read.feed(path.read_text(encoding="utf-8"))
    return read


def broken(site: Path) -> list[str]:
    """Return a line for each link of a site to a file or a place in a page that does not exist.

    Args:
        site: the folder in which it was built.
    """
    lines = []
    for path in sorted(site.rglob("*.html")):
        if path.is_relative_to(site / "_static"):
            continue  # Templates of the theme.
        for link in sorted(page(path).links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target /= "index.html"
            anchor = unquote(parts.fragment)
            is_page = target.suffix == ".html"
            if not target.is_file():
                lines.append(f"{path.relative_to(site)}: {link} does not exist")
            elif is_page and anchor and anchor not in page(target).anchors:
                lines.append(f"{path.relative_to(site)}: {link}: no such place in that page")
    return lines


def main() -> None:
    """Check the site that is named on the command line."""
    site = Path(sys.argv[1]).resolve()
    if not (site / "index.html").is_file():
        sys.exit(f"{site} has no index.html: build the site first")
    if found := broken(site):
        sys.exit("\n".join(found))


if __name__ == "__main__":
    main()
