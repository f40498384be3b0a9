"""The cloud in the window: what it shows of the frame, how it is linked with the images, where it stands."""

import numpy as np
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDockWidget

from gui.features.cloud import CloudPanel
from gui.features.status import StatusFeature
from gui.views.cloud.scene import ColourBy
from ilf.evaluation.measuring import measure
from ilf.project.run_history import StoredRun

from .conftest import settle


def shown(window, qtbot):
    """The cloud, when all that is to come has come."""
    settle(window, qtbot)
    canvas = window.feature(CloudPanel).view.canvas
    qtbot.waitUntil(lambda: canvas.drawing.is_full or not len(canvas.scene))
    return canvas.scene


def pixels(widget):
    """What a widget looks like now, uint8 (H, 4 W)."""
    image = widget.grab().toImage().convertToFormat(QImage.Format.Format_RGBA8888)
    return np.array(image.constBits()).reshape(image.height(), -1)


def place_of(window, pixel):
    """Where the point of a pixel is on the canvas."""
    canvas = window.feature(CloudPanel).view.canvas
    index = canvas.scene.index_of(pixel)
    x, y, _ = canvas.camera.project(canvas.scene.points[index : index + 1], canvas.width(), canvas.height())[0]
    return QPoint(round(x), round(y))


def test_the_cloud_follows_what_is_known_of_the_frame(opened, qtbot, run_all):
    document, actions = opened.workspace.current, opened.actions_
    assert opened.context.made(CloudPanel) is None, "not made before it is looked at"
    opened.centre.show_cloud()
    cloud = opened.feature(CloudPanel).view
    assert len(shown(opened, qtbot)) == document.frame.known.sum()
    assert not actions["cloud_raw"].isEnabled()
    why = {by: action.toolTip() for by, action in cloud._choices.items() if not action.isEnabled()}
    assert set(why) == {ColourBy.EXPECTED, ColourBy.ERROR, ColourBy.DIFFERENCE, ColourBy.FILLED}
    assert "ground truth" in why[ColourBy.ERROR]

    run_all(opened)
    completion = document.completion()
    assert len(shown(opened, qtbot)) == np.isfinite(completion.depth).sum()
    cloud.canvas.setFocus()
    QTest.keyPress(cloud.canvas, Qt.Key.Key_X)
    assert len(shown(opened, qtbot)) == document.frame.known.sum()
    QTest.keyRelease(cloud.canvas, Qt.Key.Key_X)
    assert len(shown(opened, qtbot)) == np.isfinite(completion.depth).sum()

    cloud.set_colour_by(ColourBy.EXPECTED)
    scene = shown(opened, qtbot)
    assert scene.layer.has_values, "worked out for who looks at it here"
    assert (scene.unit, scene.layer.logarithmic) == ("mm", True)
    opened.workspace.current.set_ground_truth(completion.depth - np.float32(0.02))
    cloud.set_colour_by(ColourBy.ERROR)
    colours = shown(opened, qtbot).colours
    assert (colours == colours[0]).all(), "20 mm everywhere"
    assert colours[0, 0] > colours[0, 2], "too far is red"
    opened.workspace.current.set_ground_truth(None)
    assert not shown(opened, qtbot).layer.has_values

    other = StoredRun(1, "Run 1", document.run(document.state.common), dict(document.valid_results()), 1.0, (1, 2, 3))
    document.keep_run(other)
    opened.workspace.current.compare_runs([other])
    cloud.set_colour_by(ColourBy.DIFFERENCE)
    scene = shown(opened, qtbot)
    assert scene.unit == "mm"

    opened.workspace.select([1])
    actions["cloud_selected_only"].setChecked(True)
    scene = shown(opened, qtbot)
    assert (document.labels.reshape(-1)[scene.pixels] == 1).all()
    assert 0 < len(scene) < np.isfinite(completion.depth).sum()
    QTest.keyClick(cloud.canvas, Qt.Key.Key_Left)
    camera = cloud.canvas.camera
    opened.workspace.select([])
    assert len(shown(opened, qtbot)) == 0
    assert "No block is selected" in cloud.canvas.message
    actions["cloud_selected_only"].setChecked(False)
    assert len(shown(opened, qtbot)) == np.isfinite(completion.depth).sum()
    assert cloud.canvas.camera == camera, "seen from where it was"


def test_points_and_pixels_are_linked(opened, qtbot):
    document, canvas = opened.workspace.current, opened.feature(CloudPanel).view.canvas
    opened.actions_["cloud_beside"].setChecked(True)
    assert opened.views.isVisible()
    assert opened.feature(CloudPanel).view.isVisible()
    shown(opened, qtbot)
    opened.views.navigation.point_at((10, 40))
    assert canvas._marked == (10, 40)
    wanted = (50, 20)
    QTest.mouseMove(canvas, place_of(opened, wanted))
    QTest.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=place_of(opened, wanted))
    assert document.selected == [document.labels[20, 50]]
    x, y = canvas._marked or (0, 0)
    assert np.abs(np.subtract((x, y), wanted)).max() <= 1
    assert opened.feature(StatusFeature).bar.readout.text().startswith(f"x {x}, y {y}")


def test_the_command_turns_between_images_and_cloud_also_if_they_are_side_by_side(opened):
    seen, turn = [], opened.actions_["turn_cloud"].trigger
    for beside in (False, True):
        opened.actions_["cloud_beside"].setChecked(beside)
        for _ in range(2):
            turn()
            seen.append((opened.views.isVisible(), opened.feature(CloudPanel).view.isVisible()))
    assert seen == [(False, True), (True, False)] * 2
    assert not opened.actions_["cloud_beside"].isChecked()


def test_neither_a_picture_nor_a_measurement_makes_the_cloud_which_has_its_lines_once_it_is_shown(opened, tmp_path):
    opened.actions_["tool_measure"].trigger()
    line = (50.5, 5.5), (10.5, 44.5)
    opened.workspace.current.set_measurements([line])
    opened.refresh.now()
    assert opened.documents.save_picture(str(tmp_path / "views.png"))
    assert opened.context.made(CloudPanel) is None
    opened.centre.show_cloud()
    opened.refresh.now()
    assert list(opened.feature(CloudPanel).view.canvas._lines) == [line]


def test_distances_are_measured_between_points_of_the_cloud(opened, qtbot):
    canvas = opened.feature(CloudPanel).view.canvas
    opened.centre.show_cloud()
    shown(opened, qtbot)
    opened.actions_["tool_measure"].trigger()
    assert opened.feature(CloudPanel).view.isVisible()
    chosen = opened.workspace.current.selected
    ends = (50, 5), (10, 44)
    for pixel in ends:
        QTest.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=place_of(opened, pixel))
    (line,) = opened.workspace.current.state.looked.measurements
    assert np.abs(np.subtract(np.floor(line), ends)).max() <= 1
    assert opened.workspace.current.selected == chosen
    opened.refresh.now()
    assert list(canvas._lines) == [line]
    length = measure(opened.workspace.current.frame.depth, line, opened.workspace.current.frame.intrinsics).distance
    assert canvas._texts == [f"{length:.3f} m"]
    with_text = pixels(canvas)
    canvas.set_lines([line], [])
    assert (pixels(canvas) != with_text).any(), "the length stands at its line"
    opened.actions_["tool_select"].trigger()
    opened.refresh.now()
    assert list(canvas._lines) == [line], "as over the images, for as long as the panel is open"
    opened.findChild(QDockWidget, "Inspect").close()
    opened.refresh.now()
    assert not canvas._lines
