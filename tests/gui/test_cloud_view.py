"""The cloud widget: mouse, keys, colours, and what it leaves behind when it goes."""

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QImage, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QApplication

from gui import theme
from gui.cloud import canvas as cloud_canvas
from gui.cloud.cloud_view import CloudView, ColourBy


@pytest.fixture
def cloud():
    x, y = np.meshgrid(np.linspace(-1, 1, 60, dtype=np.float32), np.linspace(-1, 1, 50, dtype=np.float32))
    points = np.stack([x, y, 2 + 0.3 * x], axis=-1).reshape(-1, 3)
    return points, np.full(points.shape, (200, 30, 30), np.uint8)


@pytest.fixture
def view(qtbot, cloud):
    widget = CloudView()
    qtbot.addWidget(widget)
    widget.resize(400, 320)
    widget.show()
    widget.set_cloud(*cloud)
    return widget


def drag(qtbot, canvas, button, by, modifier=Qt.KeyboardModifier.NoModifier):
    start = QPoint(100, 100)
    qtbot.mousePress(canvas, button, modifier, start)
    # qtbot.mouseMove knows neither buttons nor modifiers
    place = QPointF(start + by)
    event = QMouseEvent(QEvent.Type.MouseMove, place, canvas.mapToGlobal(place), button, button, modifier)
    QApplication.sendEvent(canvas, event)
    qtbot.mouseRelease(canvas, button, modifier, start + by)


def pixels(widget):
    image = widget.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    raw = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
    return raw[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).copy()


def test_left_drag_orbits_and_double_click_resets(qtbot, view):
    home = view.canvas.camera
    drag(qtbot, view.canvas, Qt.MouseButton.LeftButton, QPoint(40, 20))
    turned = view.canvas.camera
    assert turned.yaw > home.yaw
    assert turned.pitch > home.pitch
    assert (turned.distance, turned.target) == (home.distance, home.target)
    qtbot.mouseDClick(view.canvas, Qt.MouseButton.LeftButton)
    assert view.canvas.camera == home


@pytest.mark.parametrize(
    ("button", "modifier"),
    [
        (Qt.MouseButton.RightButton, Qt.KeyboardModifier.NoModifier),
        (Qt.MouseButton.MiddleButton, Qt.KeyboardModifier.NoModifier),
        (Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ShiftModifier),
    ],
)
def test_pan_moves_the_cloud_with_the_cursor(qtbot, view, button, modifier):
    home = view.canvas.camera
    drag(qtbot, view.canvas, button, QPoint(30, -12), modifier)
    panned = view.canvas.camera
    assert (panned.yaw, panned.pitch) == (home.yaw, home.pitch)
    x, y, z, _ = panned.view_matrix() @ np.append(home.target, 1.0)
    focal = panned.focal(view.canvas.height())
    np.testing.assert_allclose((x / z * focal, y / z * focal), (30, -12), atol=1e-6)


def test_keys_orbit_zoom_and_reset(qtbot, view):
    canvas, home = view.canvas, view.canvas.camera
    qtbot.keyClick(canvas, Qt.Key.Key_Right)
    assert canvas.camera.yaw > home.yaw
    qtbot.keyClick(canvas, Qt.Key.Key_Plus)
    assert canvas.camera.distance < home.distance
    qtbot.keyClick(canvas, Qt.Key.Key_R)
    assert canvas.camera == home
    qtbot.keyClick(canvas, Qt.Key.Key_Minus)
    assert canvas.camera.distance > home.distance
    qtbot.keyClick(canvas, Qt.Key.Key_Home)
    assert canvas.camera == home


def test_wheel_forward_comes_nearer(view):
    before = view.canvas.camera.distance
    none = Qt.KeyboardModifier.NoModifier
    place = QPointF(50, 50)
    event = QWheelEvent(
        place, place, QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton, none, Qt.ScrollPhase.NoScrollPhase, False
    )
    QApplication.sendEvent(view.canvas, event)
    assert view.canvas.camera.distance < before


def test_a_cloud_of_the_same_frame_keeps_the_point_of_view(qtbot, view, cloud):
    qtbot.keyClick(view.canvas, Qt.Key.Key_Right)
    turned = view.canvas.camera
    view.set_cloud(cloud[0][::2], cloud[1][::2], reset=False)
    assert view.canvas.camera == turned
    view.set_cloud(*cloud)
    assert view.canvas.camera != turned


def test_colours_mean_what_is_chosen(view, cloud):
    accent = theme.colours(view.palette()).accent
    rgb = accent.red(), accent.green(), accent.blue()
    view.canvas.set_drawing(point_size=8, shaded=False)
    view.set_colour_by(ColourBy.FILLED)
    middle = view.canvas.rect().center()
    assert tuple(pixels(view.canvas)[middle.y(), middle.x()]) == (200, 30, 30)
    view.set_filled(np.ones(len(cloud[0]), bool))
    assert tuple(pixels(view.canvas)[middle.y(), middle.x()]) == rgb
    view.set_colour_by(ColourBy.DEPTH)
    assert tuple(pixels(view.canvas)[middle.y(), middle.x()]) not in (rgb, (200, 30, 30))
    view.set_colour_by(ColourBy.COLOUR)
    assert tuple(pixels(view.canvas)[middle.y(), middle.x()]) == (200, 30, 30)


def test_arrays_that_do_not_fit_are_refused_and_the_cloud_stays(view, cloud):
    with pytest.raises(ValueError, match="must both be"):
        view.set_cloud(cloud[0], cloud[1][:-1])
    with pytest.raises(ValueError, match="filled must be"):
        view.set_filled(np.ones(3, bool))
    assert len(view.canvas.points) == len(cloud[0])


def test_a_message_takes_the_place_of_the_cloud(view):
    before = pixels(view.canvas)
    view.set_message("This frame has no camera intrinsics.")
    assert len(view.canvas.points) == 0
    assert (pixels(view.canvas) != before).any()


def test_large_clouds_are_thin_while_moving_and_whole_at_rest(qtbot, view, cloud, monkeypatch):
    monkeypatch.setattr(cloud_canvas, "MOVING_POINTS", 500)
    drawn = []
    real = cloud_canvas.splat
    monkeypatch.setattr(
        cloud_canvas, "splat", lambda points, *rest, **named: drawn.append(len(points)) or real(points, *rest, **named)
    )
    view.set_cloud(*cloud)
    view.canvas.grab()
    qtbot.keyClick(view.canvas, Qt.Key.Key_Left)
    view.canvas.grab()
    assert view.canvas.rest_timer.isActive()
    qtbot.waitUntil(lambda: not view.canvas.rest_timer.isActive())
    view.canvas.grab()
    assert drawn[0] == drawn[-1] == len(cloud[0])
    assert 500 in drawn
    count = len(drawn)
    view.canvas.grab()
    assert len(drawn) == count  # nothing changed, nothing drawn anew


def test_closing_stops_the_timer(qtbot, view, cloud, monkeypatch):
    monkeypatch.setattr(cloud_canvas, "MOVING_POINTS", 500)
    view.set_cloud(*cloud)
    qtbot.keyClick(view.canvas, Qt.Key.Key_Left)
    assert view.canvas.rest_timer.isActive()
    view.close()
    assert not view.canvas.rest_timer.isActive()
