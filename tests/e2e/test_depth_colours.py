"""The colours of depth: the choice is remembered, and the default is said once."""

from gui.app.main_window import MainWindow
from gui.views.colours import DEPTH_MAP


def _with_frame(qtbot, frame_folder):
    window = MainWindow()
    qtbot.addWidget(window)
    window.show()
    with qtbot.waitSignal(window.loader.idle):
        window.documents.open_paths([frame_folder])
    window.refresh.now()
    return window


def test_the_map_is_said_once_and_another_choice_comes_back(qtbot, frame_folder):
    first = _with_frame(qtbot, frame_folder)
    assert first.log.text.toPlainText().count(DEPTH_MAP) == 1
    assert first.views.ranges.depth_map == DEPTH_MAP
    first.views.ranges.set_depth_map("turbo")
    first.close()
    second = _with_frame(qtbot, frame_folder)
    assert DEPTH_MAP not in second.log.text.toPlainText()
    assert second.views.ranges.depth_map == "turbo"
    second.close()
