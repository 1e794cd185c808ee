"""Tables in HTML."""

from __future__ import annotations

from html.parser import HTMLParser

from cardan_dyn.mechanism.html_table import html_table


class Cells(HTMLParser):
    """Collects tags and texts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.texts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_texts_are_shown_as_they_are() -> None:
    rows = [("a < b", "<script>alert('x')</script>"), ("&amp;", "one\ntwo")]
    cells = Cells(html_table('<b>"title"</b>', rows))
    assert cells.texts == [
        '<b>"title"</b>',
        "a < b",
        "<script>alert('x')</script>",
        "&amp;",
        "one",
        "two",
    ]
    assert cells.tags == ["table", "caption", "tr", "th", "td", "tr", "th", "td", "br"]
