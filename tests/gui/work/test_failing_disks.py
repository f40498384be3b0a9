"""Full, read-only and removed drives, for the autosave and for the project file: nothing on them gets worse, it is
said, and it works again by itself."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from ilf.data.blocks import Blocks
from ilf.errors import ExportError
from ilf.project.file import open_project, save_project
from ilf.project.frame_state import FrameState
from ilf.project.project import Project, ProjectFrame
from ilf.project.state_codec import load_state

from ..recording import Recording, assert_holds


def _mount(*arguments: str):
    try:
        subprocess.run(["mount", *arguments], check=True, capture_output=True, text=True)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"mounting a small drive is not permitted here: {getattr(error, 'stderr', error)}")


class _Drive:
    """A drive of 2 MB."""

    def __init__(self, folder: Path):
        self.folder = folder
        folder.mkdir()
        self.plug_in()

    def plug_in(self):
        """Mount it, empty."""
        _mount("-t", "tmpfs", "-o", "size=2m", "tmpfs", str(self.folder))

    def pull_out(self):
        """Take it away, whoever uses it."""
        subprocess.run(["umount", "--lazy", str(self.folder)], check=True)

    def fill(self):
        """Use all of its space."""
        with open(self.folder / "ballast", "wb", buffering=0) as ballast:
            try:
                while True:
                    ballast.write(bytes(4096))
            except OSError:
                pass

    def empty(self):
        """Give the space back."""
        (self.folder / "ballast").unlink()

    def lock(self, on: bool):
        """Let it be read-only, or no longer."""
        _mount("-o", f"remount,{'ro' if on else 'rw'}", str(self.folder))


@pytest.fixture
def drive(tmp_path):
    drive = _Drive(tmp_path / "drive")
    yield drive
    while os.path.ismount(drive.folder):
        drive.pull_out()


@pytest.fixture
def record(qtbot, tmp_path, small_frame, small_labels, monkeypatch):
    """Records two frames in a folder, at once instead of after two seconds."""
    monkeypatch.setattr("gui.project.recorder.AFTER_MS", 50)
    monkeypatch.setattr("gui.project.recorder._RETRY_MS", 100)
    desks = []

    def begin(folder: Path) -> Recording:
        desks.append(Recording(folder, tmp_path / "aside", small_frame, small_labels))
        return desks[-1]

    yield begin
    for context in desks:
        context.end()


def test_a_full_drive_leaves_the_autosave_whole_and_all_is_kept_when_there_is_room_again(drive, record, qtbot):
    context = record(drive.folder / "autosave")
    one, two = context.documents
    ended: list[Exception | None] = []
    context.recorder.failed.connect(ended.append)
    context.recorder.kept.connect(lambda: ended.append(None))
    context.erase(two, 1)
    qtbot.waitUntil(lambda: ended == [None] and context.store.has(two.id))
    drive.fill()
    had = [one.labels.copy()]
    for row in range(40):  # the last block of a file may have room left
        ended.clear()
        context.erase(one, row)
        qtbot.waitUntil(lambda: bool(ended))
        if ended[0] is not None:
            break
        had.append(one.labels.copy())
    assert "the disk is full" in str(ended[0])
    written = context.written()
    assert_holds(written, two)
    if len(had) > 1:
        assert np.array_equal(load_state(one.id, written).state.blocks.labels, had[-1])
    written.discard()
    drive.empty()
    with qtbot.waitSignal(context.recorder.kept):
        context.erase(one, 45)
    context.assert_written(one, two)


def test_a_drive_that_is_read_only_or_taken_away_costs_nothing(drive, record, qtbot):
    drive.lock(True)
    context = record(drive.folder / "autosave")
    one, two = context.documents
    with qtbot.waitSignal(context.recorder.failed) as failed:
        context.erase(two, 1)
    assert str(drive.folder) in str(failed.args[0])
    drive.lock(False)
    with qtbot.waitSignal(context.recorder.kept):
        context.erase(one, 1)
    context.assert_written(two)
    drive.pull_out()
    with qtbot.waitSignal(context.recorder.kept):
        context.erase(one, 2)
    context.assert_written(one, two)


@pytest.mark.parametrize("full", [True, False])
def test_a_project_file_that_cannot_be_replaced_stays_as_it_was(drive, small_frame, small_labels, full):
    path, project = drive.folder / "house.ilf", Project((ProjectFrame("a1", "house", None, has_state=True),))
    save_project(path, project, [FrameState("a1", small_frame, Blocks(small_labels))])
    before = path.read_bytes()
    if full:
        drive.fill()
    else:
        drive.lock(True)
    files = sorted(drive.folder.iterdir())
    with pytest.raises(ExportError, match=r"disk is full|read-only|write-protected"):
        save_project(path, project, [FrameState("a1", small_frame, Blocks(small_labels % 2))])
    assert path.read_bytes() == before
    assert sorted(drive.folder.iterdir()) == files, "nothing is left lying about"
    with open_project(path) as opened:
        assert np.array_equal(opened.state("a1").state.blocks.labels, small_labels)
