"""The pictures have most of the window, and nothing that matters is cut."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from PySide6.QtWidgets import QApplication

from gui.app.main_window import MainWindow
from gui.base import theme
from gui.features.blocks.feature import BlocksFeature
from gui.features.frame_list.feature import FramesFeature
from gui.features.layouts.layout import CORRECT
from tests.bench.picture_share import BARS, cut, made_frame, share, show_frames, show_layout


@pytest.fixture
def themed(qapp: QApplication) -> Iterator[None]:
    """The style of the program, which determines the sizes of its parts."""
    palette, sheet = qapp.palette(), qapp.styleSheet()
    theme.apply_theme(qapp, "light")
    yield
    qapp.setStyleSheet(sheet)
    qapp.setPalette(palette)


@pytest.mark.parametrize("size", sorted({size for _, size in BARS}))
@pytest.mark.usefixtures("themed")
def test_the_picture_is_the_work(window: MainWindow, size: tuple[int, int]) -> None:
    show_frames(window, [made_frame(number) for number in range(2)], size)
    assert window.feature(FramesFeature).panel.view.isVisible()
    for layout, of_size in BARS:
        if of_size == size:
            show_layout(window, layout)
            assert share(window) >= BARS[layout, size], layout
            assert cut(window) == []
    show_layout(window, CORRECT)
    window.actions_["toggle_panels"].trigger()
    assert window.feature(BlocksFeature).table.isVisible()
