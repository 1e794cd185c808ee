"""What a misspelled word was meant to be."""

from __future__ import annotations

import pytest

import cardan_dyn as cd
from cardan_dyn.description.words import similar_word, unknown_keys

KNOWN = ("closed_loop", "type", "name_mot")


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("types", "type"),
        ("tpye", "type"),
        ("closed_lop", "closed_loop"),
        ("name_motor", "name_mot"),
        ("typists", None),
        ("foo", None),
    ],
)
def test_similar_words_are_found(word: str, meant: str | None) -> None:
    assert similar_word(word, KNOWN) == meant


def test_keys_that_are_misspelled_are_refused_and_others_named() -> None:
    assert unknown_keys(["foo", "type", 7, "foo"], KNOWN, "file", strict=True) == [
        "file: foo is unknown and was passed over",
        "file: 7 is unknown and was passed over",
    ]
    with pytest.raises(cd.ModelError, match=r"file: key 'types' .* did you mean 'type'"):
        unknown_keys(["types"], KNOWN, "file", strict=True)
    assert unknown_keys(["types"], KNOWN, "file", strict=False) == [
        "file: types is unknown and was passed over"
    ]
