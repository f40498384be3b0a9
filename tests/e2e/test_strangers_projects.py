"""A stranger's project in the real window: what it names elsewhere is opened only after a question that shows it."""

import json

import pytest
from PySide6.QtWidgets import QMessageBox

from gui.features.documents.open_dialog import OpenDialog
from ilf.project.file import save_project
from ilf.project.project import Project, ProjectFrame
from ilf.sources.frame_ref import FrameRef

from ..ilf.batch_frames import write_frames
from ..web_server import serving_folder
from .conftest import answer, asked

pytest.importorskip("fsspec")
pytest.importorskip("aiohttp", reason="aiohttp is not installed (extra dev)")


@pytest.fixture
def web(tmp_path):
    """The address of a folder with a frame on a web server, and the paths that were asked for."""
    with serving_folder(write_frames(tmp_path / "web", 1)) as served:
        yield served


def test_an_address_in_a_project_is_opened_after_a_question_that_shows_it(window, qtbot, tmp_path, web):
    address, wanted = web
    source = FrameRef(f"{address}/rgb/0000.png", f"{address}/depth/0000.png")
    (tmp_path / "mail").mkdir()
    path = tmp_path / "mail" / "stranger.ilf"
    save_project(path, Project((ProjectFrame("a1", "desk", source),), "a1"))
    with qtbot.waitSignal(window.project.opening.opened):
        window.documents.open_paths([path])
    box = asked(window, qtbot)
    assert f"{address}/rgb/0000.png" in box.text()
    assert box.defaultButton() is box.button(QMessageBox.StandardButton.Cancel)
    box.defaultButton().click()
    qtbot.waitUntil(lambda: not window.loader.busy)
    assert not wanted
    assert window.workspace.shown is None
    window.loader.open_entry(window.workspace.entries[0])
    asked(window, qtbot)
    assert f"{address}/depth/0000.png" in answer(window, "&Open")
    qtbot.waitUntil(lambda: window.workspace.shown is not None)
    assert wanted


def test_the_open_dialog_leads_to_the_question(window, qtbot, tmp_path):
    desk = write_frames(tmp_path / "elsewhere", 1)
    folder = tmp_path / "stranger"
    folder.mkdir()
    (desk / "depth/0000.png").rename(folder / "depth.png")
    meta = {"rgb": str(desk / "rgb/0000.png"), "depth": "depth.png", "depth_units_per_m": 1000}
    (folder / "meta.json").write_text(json.dumps(meta))
    window.actions_["open"].trigger()
    dialog = window.findChild(OpenDialog)
    dialog.path.setText(str(folder))
    dialog.read()
    assert "elsewhere" in dialog.message.text()
    assert "--" not in dialog.message.text(), "that is for the command line"
    dialog.accept_button.click()
    asked(window, qtbot)
    answer(window, "&Open")
    qtbot.waitUntil(lambda: window.workspace.shown is not None)
