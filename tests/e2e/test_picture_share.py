"""The pictures have most of the window, and nothing that matters is cut."""

from __future__ import annotations

import pytest

from gui.app.main_window import MainWindow
from gui.features.blocks.feature import BlocksFeature
from tests.bench.picture_share import BARS, cut, made_frame, share, show_frame


@pytest.mark.parametrize(("layout", "size"), list(BARS))
def test_the_picture_is_the_work(window: MainWindow, layout: str, size: tuple[int, int]) -> None:
    show_frame(window, made_frame(), size, layout)
    assert share(window) >= BARS[layout, size]
    assert cut(window) == []
    window.actions_["toggle_panels"].trigger()
    if layout == "correct":
        assert window.panels.open
        assert window.feature(BlocksFeature).table.isVisible()
