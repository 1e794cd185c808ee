"""Suitable: what rules methods of simulation out."""

from __future__ import annotations

import pytest

from cardan_dyn.simulation.suitable import Traits, in_words, reason_against

PLAIN = Traits(True, False, True, False)


@pytest.mark.parametrize(
    ("found", "out"),
    [
        (PLAIN, set()),
        (PLAIN._replace(is_one_coordinate=False), {"quadrature", "response"}),
        (PLAIN._replace(has_idle_rods=True), {"quadrature", "response"}),
        (PLAIN._replace(is_constant=False), {"quadrature"}),
        (PLAIN._replace(has_given_steps=True), {"quadrature", "Radau"}),
    ],
)
def test_methods_that_would_leave_something_out(found: Traits, out: set[str]) -> None:
    methods = "quadrature", "response", "DOP853", "Radau"
    assert {method for method in methods if reason_against(method, found)} == out


def test_words_name_the_methods_in_their_order() -> None:
    said = in_words(PLAIN, "crank")
    places = [said.index(word) for word in ("quadrature", "response", "crank", "DOP853", "Radau")]
    assert places == sorted(places)
    assert in_words(PLAIN._replace(is_constant=False), "crank").startswith("response (no quad")
    assert in_words(PLAIN._replace(has_idle_rods=True), "crank").startswith("DOP853")
