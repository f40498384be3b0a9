"""What a window leaves behind at a sudden end is offered to the next one, and comes back as it was."""

import contextlib
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QMessageBox

import ilf
from gui.app.main_window import MainWindow
from gui.features.project.autosave import AutosaveFeature
from gui.project.recorder import Recorder
from gui.project.store import WorkStore
from gui.state.document import Document
from gui.state.workspace import Workspace
from ilf.errors import ExportError, InputError
from ilf.project.file import save_project
from ilf.project.project import Project
from ilf.project.store import FolderInUse, WorkFolder
from tests.gui.naming import unnamed

from .conftest import answer, asked, open_frame, write_frame


@pytest.fixture(autouse=True)
def prompt_autosave(monkeypatch):
    """Changes are stored at once instead of after two seconds."""
    monkeypatch.setattr("gui.project.recorder.AFTER_MS", 50)


@pytest.fixture
def left(qtbot, tmp_path, small_frame, small_labels):
    """Autosaves of two windows that were killed, one with two frames, and one that cannot be read."""
    folder = Path(os.environ["ILF_AUTOSAVE"])
    folder.mkdir()
    for names in (("hall", "stairs"), ("attic",)):
        work = tmp_path / names[0]
        _leave(qtbot, work, [write_frame(tmp_path / f"frame-{name}", small_frame) for name in names], small_labels)
        shutil.copytree(work, folder, dirs_exist_ok=True)  # as it is while it is in use
    (folder / "other.work").mkdir()
    (folder / "other.work" / "index.json").write_bytes(b"no index" * 300)
    return folder


def _leave(qtbot, folder: Path, frames: list[Path], labels: np.ndarray, project: Path | None = None):
    workspace, store = Workspace(), WorkStore(folder)
    recorder = Recorder(workspace, store)
    recorder.present.take(project)
    recorder.start()
    for number, path in enumerate(frames):
        workspace.open_document(Document.of(ilf.Run(ilf.load_frame(str(path)), labels), None, str(path)))
        workspace.current.edit_info(1, "Rename", name=f"wall {number}")
    with qtbot.waitSignal(recorder.kept):
        pass
    assert recorder.shutdown()
    recorder.present.release()


@pytest.fixture
def window(another, left):
    """A window that looks for what others have left."""
    return another(persistent=True)


def _part(window) -> AutosaveFeature:
    return window.feature(AutosaveFeature)


def _asked(window, qtbot, about: str = "") -> QMessageBox:
    """The question about unsaved work, of which frames by a part of their names are named."""
    box = asked(window, qtbot, about)
    assert box.windowTitle() == "Restore unsaved work"
    return box


def _restore(window, qtbot, about: str = "") -> None:
    box = _asked(window, qtbot, about)
    next(one for one in box.buttons() if one.text() == "&Restore").click()
    qtbot.waitUntil(lambda: window.workspace.shown is not None and not window.loader.busy)


def _names(window) -> list[str]:
    return [entry.name for entry in window.workspace.entries]


def test_left_work_is_restored_discarded_or_left(window, left, qtbot):
    box = _asked(window, qtbot, "frame-attic")
    assert unnamed(box) == []
    assert "1 frame" in box.informativeText()
    _restore(window, qtbot)
    assert _names(window) == ["frame-attic"]
    window.project.discard_silently = False
    assert "2 of 2 frames changed" in _asked(window, qtbot, "frame-hall").informativeText()
    answer(window, "&Restore")
    qtbot.waitUntil(lambda: window.project.question is not None)
    window.project.question.discard_button.click()
    qtbot.waitUntil(lambda: len(_names(window)) == 2 and not window.loader.busy)
    window.project.discard_silently = True
    assert _names(window) == ["frame-hall", "frame-stairs"], "in place of the other, about which was asked"
    assert window.workspace.current.info(1).name == "wall 1", "the one that was looked at"
    assert all(entry.unsaved for entry in window.workspace.entries)
    for button in ("Cancel", "&Discard"):
        box = _asked(window, qtbot, "other.work")
        assert "index.json" in box.informativeText()
        assert "&Restore" not in {one.text() for one in box.buttons()}, "it cannot be read"
        answer(window, "&Discard…")
        answer(window, button)
    qtbot.waitUntil(lambda: len(list(left.glob("*.work"))) == 1)
    (own,) = left.glob("*.work")
    assert f"-{os.getpid()}-" in own.name
    qtbot.waitUntil(lambda: window.recorder.store.is_written)
    window.close()
    assert list(left.iterdir()) == [], "a window that is closed leaves nothing"


def test_what_is_left_for_later_stays_and_is_nobody_elses_meanwhile(window, left, qtbot, monkeypatch):
    _asked(window, qtbot)
    works = set(left.glob("*.work"))
    with pytest.raises(FolderInUse):
        WorkFolder(next(path for path in works if path.name != "other.work"))
    for about in ("frame-attic", "frame-hall", "other.work"):
        _asked(window, qtbot, about)
        answer(window, "Decide &later")
    _say_that_it_fails(window, monkeypatch)
    window.close()
    assert set(left.glob("*.work")) == works
    for path in works:
        if path.name != "other.work":
            left_work = WorkFolder(path)
            assert left_work.header.unsaved
            left_work.close()


def _say_that_it_fails(window, monkeypatch):
    """A failing autosave is said once, and shown until it works again."""
    said: list[str] = []
    monkeypatch.setattr(QMessageBox, "open", lambda box: said.append(box.text()))
    label = _part(window).label
    assert not label.isVisible()
    for _ in range(2):
        window.recorder.failed.emit(ExportError("The disk is full."))
        assert label.isVisible()
    assert [text.split("\n")[0] for text in said] == ["The disk is full."]
    assert "The disk is full." in label.toolTip()
    window.recorder.kept.emit()
    assert not label.isVisible()


def test_what_cannot_be_restored_is_left_for_another_time(window, left, qtbot, monkeypatch):
    _asked(window, qtbot, "frame-attic")
    works = set(left.glob("*.work"))

    def fail(*_: object):
        raise OSError("the drive has been removed")

    with monkeypatch.context() as broken:
        broken.setattr("gui.features.project.recovery.copy_frames", fail)
        with qtbot.waitSignal(window.notes.reported):
            answer(window, "&Restore")
    assert works <= set(left.glob("*.work"))
    qtbot.wait(50)
    (report,) = (box for box in window.findChildren(QMessageBox) if box.isVisible())
    assert "the drive has been removed" in report.text(), "it is asked again only once this is closed"
    report.close()
    _restore(window, qtbot, "frame-attic")
    assert _names(window) == ["frame-attic"]


def test_a_frame_that_cannot_be_read_is_named_and_stays_in_its_folder(left, qtbot, monkeypatch, request):
    hall = next(path for path in left.glob("*.work") if len(_frame_parts(path)) == 2)
    damaged = _frame_parts(hall)[0]
    with contextlib.closing(WorkFolder(hall)) as work:
        work.commit({damaged: b"{"})
    window: MainWindow = request.getfixturevalue("window")
    told: list[str] = []
    monkeypatch.setattr(window.notes, "warn", lambda what, notes, details="": told.extend(notes))
    _restore(window, qtbot, "frame-hall")  # the last one that was written
    assert _names(window) == ["frame-hall", "frame-stairs"]
    assert [entry.unsaved for entry in window.workspace.entries].count(True) == 1
    assert len(told) == 1
    assert str(hall) in told[0]
    # once the window has stored what it could read, the folder is let go, and nothing of it is lost
    qtbot.waitUntil(lambda: damaged in _frame_parts(hall))


def test_nothing_is_called_restored_if_the_only_frame_cannot_be_read(left, qtbot, request):
    attic = next(path for path in left.glob("*.work") if len(_frame_parts(path)) == 1)
    damaged = _frame_parts(attic)
    with contextlib.closing(WorkFolder(attic)) as work:
        work.commit({damaged[0]: b"{"})
    window: MainWindow = request.getfixturevalue("window")
    told: list[str] = []
    window.notes.show_message = told.append
    _restore(window, qtbot, "frame-attic")
    assert not [text for text in told if "save it" in text]


def _frame_parts(path: Path) -> list[str]:
    """The names of the frames' parts of an autosave, or of none if it cannot be read."""
    with contextlib.suppress(InputError), contextlib.closing(WorkFolder(path)) as work:
        return sorted(name for name in work.names() if name.startswith("frames/"))
    return []


def test_a_project_that_was_saved_after_the_work_was_left_is_not_replaced_unasked(
    another, qtbot, tmp_path, small_frame, small_labels
):
    folder, path = Path(os.environ["ILF_AUTOSAVE"]), tmp_path / "room.ilf"
    save_project(path, Project())
    _leave(qtbot, tmp_path / "work", [write_frame(tmp_path / "hall", small_frame)], small_labels, path)
    shutil.copytree(tmp_path / "work", folder, dirs_exist_ok=True)
    save_project(path, Project())
    window = another(persistent=True)
    _restore(window, qtbot)
    assert window.project.present.path == path
    assert "has been saved after this work" in window.project.present.read_only


def test_a_folder_that_cannot_be_taken_away_does_not_keep_the_window_open(window, left, qtbot, monkeypatch):
    _restore(window, qtbot)

    def own() -> bool:
        return any(f"-{os.getpid()}-" in path.name for path in left.glob("*.work"))

    qtbot.waitUntil(own)  # what was restored is stored there before it is let go

    def fail(work: WorkFolder):
        work.close()
        raise OSError("the folder is read-only")

    with monkeypatch.context() as locked:
        locked.setattr(WorkFolder, "discard", fail)
        window.close()
    assert not window.isVisible()
    assert own()


@pytest.mark.parametrize(("file_is_there", "sets_more"), [(True, True), (False, False)])
def test_frames_that_were_saved_since_are_not_called_changed(
    another, qtbot, tmp_path, small_frame, monkeypatch, file_is_there, sets_more
):
    former, path, folder = another(persistent=True), tmp_path / "house.ilf", tmp_path / "left"
    for name in ("hall", "stairs", "attic"):
        open_frame(former, qtbot, write_frame(tmp_path / name, small_frame))
        former.workspace.current.edit_info(1, "Rename", name="wall")
    done: list[bool] = []
    former.project.saving.save(path, then=done.append)
    qtbot.waitUntil(lambda: bool(done))
    former.workspace.current.edit_info(1, "Rename", name="roof")
    if sets_more:
        former.workspace.parameters.set_keeps_handmade(not former.workspace.parameters.keeps_handmade)
    stored: list[object] = []
    former.recorder.flush(stored.append)
    qtbot.waitUntil(lambda: bool(stored) and former.recorder.store.is_written)
    shutil.copytree(os.environ["ILF_AUTOSAVE"], folder)  # as a sudden end leaves it
    former.close()
    if not file_is_there:
        path.unlink()

    monkeypatch.setenv("ILF_AUTOSAVE", str(folder))
    window = another(persistent=True)
    monkeypatch.setattr(window.notes, "warn", lambda *_: None)
    assert "1 of 3 frames changed" in _asked(window, qtbot).informativeText()
    _restore(window, qtbot)
    assert _names(window) == ["hall", "stairs", "attic"]
    assert window.workspace.current.info(1).name == "roof"
    unsaved = [entry.unsaved for entry in window.workspace.entries]
    assert unsaved == ([False, False, True] if file_is_there else [True, True, True])
    assert window.project.present.words() == ("extraction parameters" if sets_more else "")
