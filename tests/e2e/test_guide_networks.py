"""*Guide by network* in the window, against a server that stands in for a network's publisher."""

import pytest
from PySide6.QtWidgets import QWidget

from gui.features.additional_depth import GUIDE, AdditionalDepthPanel
from gui.features.guide_networks import GuideNetworksDialog
from ilf.io.guide_models import guide_file, guides_folder

from ..ilf.io.test_guide_models import NAME, publishing
from ..ilf.tiny_onnx import node, write_network
from .conftest import in_front, open_frame


@pytest.fixture
def hub(tmp_path, monkeypatch):
    """A publisher that sends half of its network until it may go on."""
    with publishing(tmp_path, monkeypatch) as made:
        monkeypatch.setattr("ilf.io.fetching._BLOCK", 16)
        yield made
        made.go_on.set()


def opened(window: QWidget) -> GuideNetworksDialog:
    window.actions_["guide_by_network"].trigger()
    return in_front(window, GuideNetworksDialog)


def state(dialog: GuideNetworksDialog) -> list[list[str]]:
    rows = (dialog.networks.topLevelItem(number) for number in range(dialog.networks.topLevelItemCount()))
    return [[row.text(column) for column in range(row.columnCount())] for row in rows]


def test_a_network_is_fetched_when_asked_cancelled_continued_and_used(window, qtbot, frame_folder, hub):
    open_frame(window, qtbot, frame_folder)
    panel = window.feature(AdditionalDepthPanel)
    dialog = opened(window)
    assert state(dialog) == [
        [NAME, "Somebody", "CC-BY-NC-4.0, not for commercial use", "0.0 MB", "affine-inverse", "not fetched"]
    ]
    assert "licence CC-BY-NC-4.0, not for commercial use. Fetch gets it from 127.0.0.1." in dialog.message.text()
    assert not dialog.use_button.isEnabled()
    assert hub.asked == [], "nothing is fetched unasked"

    dialog.fetch_button.click()
    qtbot.waitUntil(lambda: dialog.work.isVisible() and dialog.work.bar.value() > 400)
    assert not dialog.fetch_button.isEnabled()
    dialog.work.cancel_button.click()
    qtbot.waitUntil(lambda: not panel.busy)
    assert guide_file(NAME) is None
    assert not dialog.work.isVisible()
    assert dialog.fetch_button.isEnabled()

    hub.go_on.set()
    qtbot.wait(100)  # the server ends the first connection
    dialog.fetch_button.click()
    dialog.close()  # the work goes on
    qtbot.waitUntil(lambda: f"guide network {NAME} is ready" in window.notes.message)
    assert hub.asked[1][1] is not None, "continued"
    assert guide_file(NAME).read_bytes() == hub.content

    dialog = opened(window)
    assert state(dialog)[0][-1] == "ready"
    assert not dialog.fetch_button.isEnabled()
    dialog.use_button.click()
    document = window.workspace.current
    qtbot.waitUntil(lambda: document.frame.guide is not None)
    assert document.frame.guide.gives == "affine-inverse"
    assert document.frame.guide.network.name == NAME
    window.refresh.now()
    assert f"From {NAME}" in panel._sections[GUIDE].message.text()
    assert len(hub.asked) == 2


def test_a_wrong_file_is_one_sentence_and_a_file_can_be_added(window, qtbot, hub, tmp_path, monkeypatch):
    panel = window.feature(AdditionalDepthPanel)
    dialog = opened(window)
    hub.content = b"<html>" * 400
    hub.go_on.set()
    dialog.fetch_button.click()
    qtbot.waitUntil(lambda: dialog.message.tone() == "error")
    assert "Traceback" not in dialog.message.text()
    assert guide_file(NAME) is None
    assert dialog.fetch_button.isEnabled()

    own = write_network(tmp_path / "own.onnx", [node("ReduceMax", ["image"], "strength", axes=[1], keepdims=1)])
    for path, name, gives in ((own, "own", "metric"), (tmp_path / "source.onnx", NAME, "affine-inverse")):
        monkeypatch.setattr("gui.features.guide_networks.choose_file", lambda *_, path=path: str(path))
        dialog.gives.setCurrentIndex(dialog.gives.findData("metric"))
        dialog.add_button.click()
        qtbot.waitUntil(lambda: not panel.busy)
        assert dialog.chosen() == name
        assert [row[4:] for row in state(dialog) if row[0] == name] == [[gives, "ready"]]
    assert not dialog.use_button.isEnabled()
    assert "Open a frame to use it." in dialog.message.text()
    dialog.show_networks("own")
    assert dialog.message.text() == "own: a network of your own. Open a frame to use it."
    (guides_folder() / "broken.json").write_text("no card")
    dialog.show_networks()
    assert "broken.json" in dialog.message.text()
    (guides_folder() / "broken.json").unlink()
    (tmp_path / "text.onnx").write_text("no network")
    monkeypatch.setattr("gui.features.guide_networks.choose_file", lambda *_: str(tmp_path / "text.onnx"))
    dialog.add_button.click()
    qtbot.waitUntil(lambda: "cannot be read as an ONNX network" in dialog.message.text())
    dialog.close()
    assert [row[0] for row in state(opened(window))] == [NAME, "own"], "still there"
