from __future__ import annotations

import pytest


@pytest.fixture
def without_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages whose figures are made, but not written: that takes longer than all the rest."""
    monkeypatch.setattr("cardan_dyn.practice.report.page.image", lambda figure: "data:,")
