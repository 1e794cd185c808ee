"""Markup: HTML whose texts come back as they were."""

from __future__ import annotations

from html.parser import HTMLParser

from cardan_dyn.kit.markup import element, listed, table

ODD = "<script>alert('x')</script> & \"quoted\" &amp;"


class Contents(HTMLParser):
    """Collects tags and texts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.texts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        self.tags.append(f"/{tag}")

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_texts_are_shown_as_they_are() -> None:
    contents = Contents(element("p", ODD))
    assert contents.texts == [ODD]
    assert contents.tags == ["p", "/p"]


def test_line_breaks_are_kept() -> None:
    contents = Contents(element("td", "one\ntwo"))
    assert contents.texts == ["one", "two"]
    assert contents.tags == ["td", "br", "/td"]


def test_tables_have_a_header_and_rows() -> None:
    contents = Contents(table(("a", ODD), [(1, 2.5), (ODD, "")], caption=ODD))
    assert contents.texts == [ODD, "a", ODD, "1", "2.5", ODD]
    cells = [*("td", "/td"), *("td", "/td")]
    assert contents.tags == [
        *("table", "caption", "/caption", "thead", "tr", "th", "/th", "th", "/th", "/tr", "/thead"),
        *("tbody", "tr", *cells, "/tr", "tr", *cells, "/tr", "/tbody", "/table"),
    ]
    assert "caption" not in Contents(table(("a",), [])).tags


def test_lists_have_items() -> None:
    contents = Contents(listed("ol", ["first", ODD]))
    assert contents.texts == ["first", ODD]
    assert contents.tags == ["ol", "li", "/li", "li", "/li", "/ol"]
