"""The colours of depth: the choice is remembered, and the default is said once."""

from gui.views.colours import DEPTH_MAP

from .conftest import open_frame


def test_the_map_is_said_once_and_another_choice_comes_back(another, qtbot, frame_folder):
    for chosen, said in ((DEPTH_MAP, 1), ("turbo", 0)):
        window = another(persistent=True)
        open_frame(window, qtbot, frame_folder)
        assert window.log.text.toPlainText().count(DEPTH_MAP) == said
        assert window.views.data.depth_map == chosen
        entries = {entry.text(): entry for entry in window.actions_["depth_colours_menu"].menu().actions()}
        entries["Turbo"].trigger()
        window.close()
