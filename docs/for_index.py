"""Make README.md and pyproject.toml ready for the package index, where nothing lies beside them.

    python docs/for_index.py https://github.com/OWNER/NAME v0.1.0

writes links and pictures of the README as addresses within the repository at that tag, and the
addresses of the project. The workflow that publishes a release does so, and it alone: where the
repository lives is nowhere else in it.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!https?:|mailto:|#)([^)\s]+)\)")


def absolute(text: str, address: str, tag: str) -> str:
    """Return a text of Markdown whose relative links are addresses.

    Args:
        text: of a file at the top of the repository.
        address: of the repository.
        tag: name of the version that is linked.
    """

    def linked(found: re.Match[str]) -> str:
        picture, words, path = found.groups()
        kind = "raw" if picture else "blob"
        return f"{picture}[{words}]({address}/{kind}/{tag}/{path})"

    return LINK.sub(linked, text)


def site(address: str, tag: str) -> str:
    """Return where the documentation of a repository is: its site, or else its text."""
    host, owner, name = address.removeprefix("https://").rsplit("/", 2)
    if host == "github.com":
        return f"https://{owner}.github.io/{name}/"
    return f"{address}/blob/{tag}/docs/guide.md"


def with_urls(project: str, address: str, tag: str) -> str:
    """Return the text of `pyproject.toml` with the addresses of the project."""
    urls = {
        "Repository": address,
        "Issues": f"{address}/issues",
        "Changelog": f"{address}/blob/{tag}/CHANGELOG.md",
        "Documentation": site(address, tag),
    }
    lines = "".join(f'{name} = "{url}"\n' for name, url in urls.items())
    return project.replace(
        "[project.optional-dependencies]",
        f"[project.urls]\n{lines}\n[project.optional-dependencies]",
        1,
    )


def main() -> None:
    """Rewrite both files."""
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    address, tag = sys.argv[1].rstrip("/"), sys.argv[2]
    for name, change in (("README.md", absolute), ("pyproject.toml", with_urls)):
        path = ROOT / name
        path.write_text(change(path.read_text(encoding="utf-8"), address, tag), encoding="utf-8")


if __name__ == "__main__":
    main()
