"""Playing the frames of a sequence, and the view of flicker."""

import threading
import time
from contextlib import closing
from functools import partial

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog, QLineEdit, QToolButton

from gui.base.commands import why_not
from gui.features.frame_list.feature import FramesFeature
from gui.features.sequence.moment import Moment, written_depth
from gui.features.sequence.playing import Playback, PlayFeature, frames_from, play
from gui.features.status import StatusFeature
from ilf.data.presets import preset
from ilf.errors import InputError

from ..ilf.small_sequences import sequence, write_sequence
from .conftest import loaded
from .test_neighbours import open_sequence

COUNT = 4


@pytest.fixture
def listed(window, qtbot, tmp_path):
    """The window with a short sequence, and its first frame open."""
    window.recorder.start()
    open_sequence(window, qtbot, write_sequence(tmp_path / "in", COUNT), number=0)
    window.actions_["speed_fastest"].trigger()
    return window


def _play(window, qtbot):
    """Play to the end, and wait until the last frame is open; return the frames shown."""
    feature, shown = window.feature(PlayFeature), []
    feature.worker.progressed.connect(lambda items: shown.append(items[-1]))
    window.actions_["play_frames"].trigger()
    qtbot.waitUntil(lambda: not feature.playing)
    _settle(window, qtbot)
    feature.worker.progressed.disconnect()
    feature.worker.progressed.connect(feature._take)
    return shown


def _settle(window, qtbot):
    """Wait until the frame shown by playing is open."""
    workspace, worker = window.workspace, window.feature(PlayFeature).worker
    qtbot.waitUntil(lambda: workspace.shown is not None and not window.loader.busy and not worker.busy)
    window.refresh.now()


def test_all_frames_are_shown_in_order_with_stored_results_and_edits_stay(listed, qtbot, run_all, tmp_path):
    window, workspace, views = listed, listed.workspace, listed.views
    window.feature(FramesFeature).open_frames.max_open = 1
    first = workspace.current
    workspace.current.replace_blocks(np.ones(first.frame.shape, np.int32), "One block")
    run_all(window)
    completed = first.completion().depth.copy()
    views.sheet.set_layout("grid-flicker")
    views.set_content("flicker", "flicker-in")

    shown = _play(window, qtbot)
    entries = workspace.entries
    assert [played.row for played in shown] == [0, 1, 2, 3]
    assert np.array_equal(shown[0].moment.depth, completed, equal_nan=True)
    assert [played.moment.depth is None for played in shown] == [False, True, True, True]
    assert workspace.current.id == entries[COUNT - 1].id, "the last one is open"
    qtbot.waitUntil(lambda: entries[0].document is None)

    by_batch = np.full(first.frame.shape, 2.5, np.float32)
    np.save(tmp_path / "depth.npy", by_batch)
    for entry in list(entries)[:2]:
        window.feature(PlayFeature).written[entry.id] = partial(written_depth, tmp_path, 1000.0)
    shown = _play(window, qtbot)  # after the last frame from the first one, which is stored now
    assert [played.row for played in shown] == [0, 1, 2, 3]
    assert np.array_equal(shown[0].moment.depth, completed, equal_nan=True)
    assert np.array_equal(shown[1].moment.depth, by_batch), "a frame without a result of its own"
    assert [played.moment.text for played in shown] == ["", "by batch", "", ""]
    changes = [played.before for played in shown]
    assert changes[0].depth_in is None
    off = [
        float(np.nanmedian(np.abs(played.moment.frame.depth - change.depth_in)))
        for played, change in zip(shown[1:], changes[1:], strict=True)
    ]
    assert max(off) < 0.002, "the scene stands still, and depth is stored in millimetres"
    assert changes[1].depth_out is not None
    assert changes[2].depth_out is None
    assert changes[1].text == "1 frame before, by poses"

    loaded(window, qtbot, window.loader.open_entry, entries[0])
    assert np.array_equal(workspace.current.labels, np.ones(first.frame.shape)), "the edit was stored"
    assert np.array_equal(workspace.current.completion().depth, completed, equal_nan=True)


def test_a_speed_that_is_chosen_before_there_are_frames_to_play_is_shown(window):
    window.actions_["speed_double"].trigger()
    (button,) = (one for one in window.findChildren(QToolButton) if one.accessibleName() == "Speed of playing")
    assert button.text().startswith("2")


def test_nothing_can_be_edited_while_frames_play_and_a_press_opens_the_frame_shown(listed, qtbot):
    window, workspace, feature = listed, listed.workspace, listed.feature(PlayFeature)
    actions, status = window.actions_, window.feature(StatusFeature)
    window.views.set_content("expected-error", "flicker-in")
    actions["play_loop"].trigger()
    actions["play_frames"].trigger()
    qtbot.waitUntil(lambda: feature.shown is not None and feature.shown.row == 2)
    window.refresh.now()
    assert workspace.shown is None
    for name in ("undo", "extract", "run", "select_all"):
        assert not actions[name].isEnabled(), name
    assert why_not(actions["run"]) == "Pause playing first."
    marked = window.feature(FramesFeature).panel.model.present
    window.views.navigation.point_at((40, 5))
    shown = feature.shown
    assert marked is workspace.entries[shown.row]
    assert status.bar.hint.text().startswith(f"{marked.name} ({shown.row + 1} of {COUNT}): ")
    assert "frames a second" in status.bar.hint.text()
    assert "x 40, y 5  |  in " in status.bar.readout.text()
    window.views.transform.look_at(30.0, 20.0, 9.0)
    view = window.views.cells["depth-in"].view
    QTest.mouseClick(view.viewport(), Qt.MouseButton.LeftButton, pos=view.viewport().rect().center())
    assert not feature.playing
    row = feature.shown.row
    _settle(window, qtbot)
    assert workspace.current.id == workspace.entries[row].id
    assert workspace.current.undo_stack.count() == 0
    assert actions["run"].isEnabled()
    assert window.views.transform.place == pytest.approx((30.0, 20.0, 9.0))


def test_going_to_another_frame_ends_playing_and_what_cannot_be_read_is_left_out(listed, qtbot, tmp_path):
    window, workspace, feature = listed, listed.workspace, listed.feature(PlayFeature)
    (tmp_path / "in" / "frame-000001.depth.png").write_bytes(b"nothing")
    actions = window.actions_
    actions["play_loop"].trigger()
    actions["play_frames"].trigger()
    qtbot.waitUntil(lambda: feature.shown is not None and feature.shown.row == 2)
    assert feature.shown.unreadable >= 1  # once a loop
    window.loader.open_entry(workspace.entries[0])
    window.refresh.now()
    assert not feature.playing
    _settle(window, qtbot)
    assert workspace.current.id == workspace.entries[0].id


def test_playing_is_turned_off_and_on_while_a_frame_is_still_read(listed, qtbot, monkeypatch):
    window, feature, gate = listed, listed.feature(PlayFeature), threading.Event()
    play = window.actions_["play_frames"]

    def late(entry, *_):
        def read():
            gate.wait(5.0)
            return Moment(entry.name, None, entry.document.frame, None)

        return read

    monkeypatch.setattr("gui.features.sequence.playing.moment_reader", late)
    feature.worker._patience.setInterval(5000)
    play.trigger()
    for on in (False, True, False, True):
        qtbot.waitUntil(play.isEnabled)
        play.trigger()
        assert play.isChecked() is on
    gate.set()
    qtbot.waitUntil(lambda: not feature.playing)
    _settle(window, qtbot)


def test_a_file_for_recording_that_is_chosen_after_playing_has_ended_is_asked_for_once(
    listed, qtbot, monkeypatch, tmp_path
):
    feature, asked = listed.feature(PlayFeature), []

    def choose(*_):
        asked.append(1)
        qtbot.waitUntil(lambda: not feature.playing)
        return str(tmp_path / "out.mcap"), ""

    monkeypatch.setattr(QFileDialog, "getSaveFileName", choose)
    listed.actions_["play_frames"].trigger()
    listed.actions_["play_recorded"].trigger()
    assert asked == [1]
    assert listed.actions_["play_recorded"].isChecked(), "the next frames that are played are recorded"


def test_a_frame_that_is_gone_when_playing_ends_is_not_opened(listed, qtbot):
    window, workspace, feature = listed, listed.workspace, listed.feature(PlayFeature)
    first, actions = workspace.current, window.actions_
    actions["play_loop"].trigger()
    actions["play_frames"].trigger()
    qtbot.waitUntil(lambda: feature.shown is not None and feature.shown.row == 1)
    workspace.remove_entries([workspace.entries[feature.shown.row]])
    qtbot.waitUntil(lambda: workspace.shown is not None)
    assert not feature.playing
    _settle(window, qtbot)
    assert workspace.current in workspace.open

    qtbot.waitUntil(lambda: actions["play_frames"].isEnabled())
    actions["play_frames"].trigger()
    qtbot.waitUntil(lambda: feature.shown is not None)
    workspace.remove_entries(list(workspace.entries))
    qtbot.waitUntil(lambda: not feature.playing and feature.shown is None)
    assert workspace.shown is None
    assert first not in workspace.open
    assert window.views.data.frame is None, "the start page is shown"


def test_frames_without_a_result_are_completed_while_they_play(listed, qtbot):
    window = listed
    window.actions_["play_completed"].trigger()
    shown = _play(window, qtbot)
    for played in shown:
        assert np.isfinite(played.moment.depth).all()
        assert played.moment.text == "completed as it plays"
    assert window.workspace.current.completion() is None, "nothing is stored"


def test_flicker_of_the_current_frame_is_against_the_one_before_it(listed, qtbot, run_all):
    window, workspace, views = listed, listed.workspace, listed.views
    views.sheet.set_layout("grid-flicker")
    cell = views.cells["flicker"]
    for number in (0, 1):
        if number:
            loaded(window, qtbot, window.actions_["next_frame"].trigger)
        window.refresh.now()
        assert cell.view.value_at(40, 5) is None
        workspace.current.replace_blocks(np.ones(workspace.current.frame.shape, np.int32), "One block")
        run_all(window)
    qtbot.waitUntil(lambda: cell.view.value_at(40, 5) is not None)
    assert cell.strip.title == "Flicker of depth out"
    assert abs(cell.view.value_at(40, 5)) < 5
    low, high = cell.bar.levels
    assert -high == low
    assert high < 50
    views.navigation.point_at((40, 5))
    window.refresh.now()
    assert "flicker out" in window.feature(StatusFeature).bar.readout.text()
    assert cell.bar.value == cell.view.value_at(40, 5)
    window.actions_["previous_frame"].trigger()
    window.refresh.now()
    assert views.data.before.text == "The list has no frame before this one"


def _rows(playback, count=99, bad=(), cost=0.0, start=0.0):
    """Rows of the first frames that are shown of ten that take so long to be read, the first one longer by `start` [s],
    and how many were left out."""
    frame = sequence(1)[0]

    def read(row):
        time.sleep(cost + start * (row == 0))
        if row in bad:
            raise InputError("It cannot be read.")
        return Moment(f"frame {row}", "here", frame, None)

    frames = frames_from([partial(read, row) for row in range(10)], 0, playback)
    with closing(play(frames, playback, preset(), 10)) as frames:
        shown = [played for played, _ in zip(frames, range(count), strict=False)]
    return [played.row for played in shown], shown[-1].left_out


def test_as_fast_as_it_goes_every_frame_is_shown():
    assert _rows(Playback(speed=None), cost=0.01) == (list(range(10)), 0)
    assert _rows(Playback(speed=None, loop=True), 25)[0] == [row % 10 for row in range(25)]
    assert _rows(Playback(speed=None, loop=True), 9, bad=(1, 9))[0] == [0, 2, 3, 4, 5, 6, 7, 8, 0]


def test_at_a_rate_frames_that_are_late_are_left_out_but_never_the_last_one():
    rows, left_out = _rows(Playback(own_rate=200.0), cost=0.03)
    assert left_out == 10 - len(rows) > 0
    assert rows == sorted(set(rows))
    assert rows[-1] == 9


def test_time_counts_from_the_first_frame():
    assert _rows(Playback(own_rate=8.0), start=0.8) == (list(range(10)), 0)


def test_a_loop_over_frames_that_cannot_be_read_ends():
    def read():
        raise InputError("It cannot be read.")

    playback = Playback(loop=True)
    with pytest.raises(InputError, match="It cannot be read"):
        next(play(frames_from(2 * [read], 0, playback), playback, preset(), 2))


def test_the_list_takes_frames_out_and_notes_by_keys(listed, qtbot):
    window, frames = listed, listed.feature(FramesFeature)
    window.panels.enter("Frames")
    view = frames.panel.view
    view.setFocus()
    view.setCurrentIndex(frames.panel.model.index(1, 0))
    QTest.keyClick(view, Qt.Key.Key_F2)
    (line,) = view.findChildren(QLineEdit)
    QTest.keyClicks(line, "glass")
    QTest.keyClick(line, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: window.workspace.entries[1].note == "glass")
    row = view.visualRect(frames.panel.model.index(2, 0)).center()
    QTest.mouseClick(view.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ShiftModifier, row)
    assert not window.loader.busy, "several are selected, none is opened"
    QTest.keyClick(view, Qt.Key.Key_Delete)
    qtbot.waitUntil(lambda: len(window.workspace.entries) == COUNT - 2)
