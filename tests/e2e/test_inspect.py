"""Looking closely, in the window: profile, statistics, measurements."""

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDockWidget, QFileDialog

from gui.features.inspect.marks import Marks
from gui.features.inspect.panel import STATISTICS, InspectPanel
from gui.features.inspect.statistics import statistics_of
from gui.state.parts import Part
from ilf.evaluation.measuring import measure
from ilf.evaluation.statistics import surface_statistics

from .conftest import open_frame, save, settle, write_frame
from .hand import click, drag, hover, key


def marks(window) -> Marks:
    """What is drawn over a view."""
    window.refresh.now()
    return part_of(window)._marks[0]


def part_of(window) -> InspectPanel:
    part = window.feature(InspectPanel)
    assert part.widget is not None, "made, though it may be closed"
    return part


def numbers(window, qtbot) -> str:
    """The statistics, as soon as they are there."""
    settle(window, qtbot)
    return part_of(window).statistics.text()


def test_a_profile_from_drawing_to_file(opened, qtbot, run_all, tmp_path, small_frame, monkeypatch):
    window, part = opened, part_of(opened)
    assert "Inspect" not in window.panels.open
    window.actions_["tool_profile"].trigger()
    assert "Inspect" in window.panels.open
    qtbot.waitUntil(lambda: part.profile.isVisible())
    assert part.profile.axis.isVisible()
    drag(window, [(5.5, 16.5), (30, 16.5), (50.5, 16.5)], release=False)
    window.refresh.now()
    data = part.profile.data
    assert data.curves == ()
    assert len(data.profile) == 46
    drag(window, [(50.5, 16.5), (58.5, 16.5)])
    run_all(window)

    # the result, and its expected error though no view shows it
    window.views.sheet.set_layout("colour")
    data = part.profile.data
    assert [curve.name for curve in data.curves] == ["result"]
    assert np.isfinite(data.curves[0].depth).all()
    qtbot.waitUntil(lambda: part.profile.data.error is not None)

    # the mouse on the line marks the place in the plot, the mouse in the plot marks it in the views
    hover(window, (20.5, 16.5))
    window.refresh.now()
    sample = 20 - int(data.profile.columns[0])
    assert part.profile.sample == sample
    hover(window, (20.5, 40.5))
    window.refresh.now()
    assert part.profile.sample is None
    part.profile.plot.hovered.emit(10.0)
    window.refresh.now()
    assert marks(window).profile.preview.corners[2:] == ((data.profile.columns[10] + 0.5, 16.5),)

    path = tmp_path / "profile"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(path), "Table (*.csv)"))
    window.actions_["save_profile"].trigger()
    assert len(path.with_suffix(".csv").read_text().splitlines()) == len(data.profile) + 1
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(path), "SVG picture (*.svg)"))
    window.actions_["save_profile_picture"].trigger()
    assert path.with_suffix(".svg").read_bytes().startswith(b"<?xml")

    # it stays with its frame, and goes by Escape
    line = window.workspace.current.state.looked.line
    folder = write_frame(tmp_path / "another", small_frame)
    open_frame(window, qtbot, folder)
    assert part.profile.data is None
    window.workspace.show(window.workspace.open[0])
    window.refresh.now()
    assert marks(window).profile.preview.corners == line
    key(window, Qt.Key.Key_Escape)
    window.refresh.now()
    assert marks(window).profile.preview is None
    assert part.profile.data is None


def test_without_a_camera_it_is_said_why_there_is_no_angle():
    left = np.indices((20, 30))[1] < 15
    _, notes = statistics_of(np.full(left.shape, 2.0, np.float32), None, None, left, ~left)
    assert "intrinsics" in notes[-1]


def test_statistics_of_block_and_rectangle_beside_each_other(opened, qtbot, run_all):
    window, part, document = opened, part_of(opened), opened.workspace.current
    run_all(window)
    part.reveal_page(STATISTICS)
    qtbot.waitUntil(lambda: part.statistics.isVisible())
    window.workspace.select([1])
    depth = document.current_depth()
    camera = document.frame.intrinsics
    raw, result = (surface_statistics(values, document.labels == 1, camera) for values in (document.frame.depth, depth))
    text = numbers(window, qtbot)
    assert f"Missing\t{100 * raw.missing_share:.1f} %\t{100 * result.missing_share:.1f} %" in text
    assert f"Tilt\t{raw.plane.tilt:.1f}°\t{result.plane.tilt:.1f}°" in text

    window.workspace.select([1, 2])
    numbers(window, qtbot)
    assert "Angle between the planes" in part.statistics_note.text()

    window.actions_["tool_rectangle"].trigger()
    drag(window, [(35.5, 5.5), (40, 10), (50.5, 20.5)])
    assert "Pixels\t256\t256" in numbers(window, qtbot)
    assert part.subject_name.text().endswith("x 35, y 5")
    QTest.keyClick(part.subject, Qt.Key.Key_Up)
    assert f"Pixels\t{raw.pixels:,}" in numbers(window, qtbot)
    QTest.keyClick(part.subject, Qt.Key.Key_Down)
    key(window, Qt.Key.Key_Escape)
    assert document.state.looked.region is None
    assert f"Pixels\t{raw.pixels:,}" in numbers(window, qtbot)


def test_a_rectangle_that_was_saved_is_seen_at_once(opened, another, qtbot, tmp_path):
    opened.workspace.current.look(Part.REGION, region=np.s_[5:21, 35:51])
    save(opened, qtbot, tmp_path / "work.ilf")
    window = another()
    window.documents.open_paths([tmp_path / "work.ilf"])
    qtbot.waitUntil(lambda: window.workspace.shown is not None)
    window.refresh.now()
    assert window.context.made(InspectPanel) is not None
    assert marks(window).region.preview is not None


def test_measurements_are_listed_copied_deleted_and_taken_back(opened, qtbot, run_all):
    window, part = opened, part_of(opened)
    window.actions_["tool_measure"].trigger()
    qtbot.waitUntil(lambda: part.measurements.isVisible())
    click(window, (12.5, 15.5))
    assert "no depth" in window.notes.message
    assert window.workspace.current.state.looked.measurements == ()
    run_all(window)
    for point in ((5.5, 5.5), (12.5, 15.5), (40.5, 5.5), (60.5, 5.5)):
        click(window, point)
    window.refresh.now()
    rows = part.measurements.numbers
    assert [(row.name, "filled depth" in row.hint) for row in rows] == [("1", True), ("2", False)]
    document, depth = window.workspace.current, window.workspace.current.current_depth()
    wanted = measure(depth, window.workspace.current.state.looked.measurements[1], document.frame.intrinsics)
    assert rows[1].cells == (f"{wanted.distance:.3f} m", f"{wanted.height:+.3f} m")
    assert len(marks(window).names.texts) == 2

    window.actions_["copy_measurements"].trigger()
    lines = QApplication.clipboard().text().splitlines()
    assert len(lines) == 3
    assert lines[1].split("\t")[:3] == ["1", "5", "5"]

    part.measurements.setFocus()
    part.measurements.selectRow(0)
    QTest.keyClick(part.measurements, Qt.Key.Key_Delete)
    assert len(window.workspace.current.state.looked.measurements) == 1
    for delete in (False, True):  # the one, and all as none is selected
        if delete:
            part.measurements.clearSelection()
            window.actions_["delete_measurements"].trigger()
            assert not window.workspace.current.state.looked.measurements
        window.actions_["restore_measurements"].trigger()
        assert len(window.workspace.current.state.looked.measurements) == 2

    # with the panel closed, they follow the depth as long as their tool is selected
    window.actions_["tool_measure"].trigger()
    window.findChild(QDockWidget, "Inspect").close()
    window.refresh.now()
    assert len(marks(window).names.texts) == 2
    window.actions_["clear_results"].trigger()
    qtbot.waitUntil(lambda: marks(window).names.texts[0] == "1: no depth")
    window.actions_["tool_select"].trigger()
    window.refresh.now()
    assert marks(window).names.texts == []
