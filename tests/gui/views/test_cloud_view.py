"""The cloud widget: mouse, keys, colours, and what it leaves behind when it goes."""

import math

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QAction, QImage, QMouseEvent
from PySide6.QtWidgets import QApplication

from gui.base import theme
from gui.views.cloud import drawing
from gui.views.cloud.cloud_view import CloudView, DepthClip
from gui.views.cloud.scene import ColourBy, Scene, compose
from gui.views.colours import depth_table, error_table
from gui.views.layers import Layer
from gui.work.jobs import stop_workers
from ilf.data.camera import Camera
from ilf.drawing.colours import to_indices

RED = 200, 30, 30


@pytest.fixture
def scene():
    """A slanted wall of 50 x 60 pixels of a frame that is 64 pixels wide."""
    x, y = np.meshgrid(np.linspace(-1, 1, 60, dtype=np.float32), np.linspace(-1, 1, 50, dtype=np.float32))
    points = np.stack([x, y, 2 + 0.3 * x], axis=-1).reshape(-1, 3)
    pixels = (64 * np.arange(50)[:, None] + np.arange(60)).reshape(-1).astype(np.int32)
    found = {"points": points, "pixels": pixels, "colours": np.full(points.shape, RED, np.uint8)}
    rgb = np.zeros((50, 64, 3), np.uint8)
    layer = Layer((rgb,), picture=lambda: rgb)
    return Scene(depth=np.zeros((50, 64), np.float32), layer=layer, spacing=0.02, depths=(1.7, 2.3), **found)


@pytest.fixture
def view(shown, scene):
    widget = CloudView()
    widget.add_switches(*(QAction(name, checkable=True) for name in ("raw", "chosen", "beside")))
    shown(widget, 400, 320)
    widget.show_scene(scene)
    yield widget
    stop_workers(widget)


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


def test_texts_of_lines_leave_the_rest_of_the_view_as_it_is(qtbot, view):
    view.canvas.setFocus()
    qtbot.waitUntil(view.canvas.hasFocus)
    before = pixels(view.canvas)[5, 5]
    view.canvas.set_lines([[(10, 10), (40, 40)]], ["1.120 m"])
    assert (pixels(view.canvas)[5, 5] == before).all()


def test_left_drag_orbits_and_double_click_resets(qtbot, view):
    home = view.canvas.camera
    drag(qtbot, view.canvas, Qt.MouseButton.LeftButton, QPoint(40, 20))
    turned = view.canvas.camera
    assert turned.yaw > home.yaw
    assert turned.pitch > home.pitch
    assert (turned.distance, turned.target) == (home.distance, home.target)
    qtbot.mouseDClick(view.canvas, Qt.MouseButton.LeftButton, pos=QPoint(2, 2))
    assert view.canvas.camera == home, "beside the cloud"


@pytest.mark.parametrize(
    ("direction", "forward"), [("front", (0, 0, 1)), ("top", (0, 1, 0)), ("side", (-1, 0, 0))], ids=lambda of: str(of)
)
def test_front_top_and_side_look_along_an_axis_at_the_whole_cloud(view, scene, direction, forward):
    view.canvas.look(direction)
    camera = view.canvas.camera
    assert camera.rotation()[2] == pytest.approx(forward, abs=1e-9)
    eye = np.c_[scene.points, np.ones(len(scene.points))] @ camera.view_matrix().T
    assert (np.abs(eye[:, 1]) < eye[:, 2] * math.tan(camera.fov / 2)).all()


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


def test_a_double_click_turns_about_the_point_there(qtbot, view, scene):
    view.canvas.grab()
    middle, home = view.canvas.rect().center(), view.canvas.camera
    place = middle + QPoint(40, 30)
    qtbot.mouseDClick(view.canvas, Qt.MouseButton.LeftButton, pos=place)
    camera = view.canvas.camera
    assert (camera.yaw, camera.pitch, camera.distance) == (home.yaw, home.pitch, home.distance)
    x, y, _ = home.project(np.array([camera.target]), view.canvas.width(), view.canvas.height())[0]
    assert math.hypot(x - place.x(), y - place.y()) < 8
    view.canvas.grab()
    seen = scene.points[scene.index_of(view.canvas._pixel_at(QPointF(middle)))]
    assert np.linalg.norm(seen - camera.target) < 0.05


def test_points_and_pixels_find_each_other(qtbot, view, scene):
    canvas = view.canvas
    assert scene.pixel_of(61) == (1, 1)
    assert (scene.index_of((1, 1)), scene.index_of((0, 1))) == (61, 60)
    assert scene.index_of((62, 1)) is scene.index_of((64, 0)) is scene.index_of((0, 50)) is None
    hovered, picked = [], []
    canvas.hovered.connect(hovered.append)
    canvas.picked.connect(lambda *pixel: picked.append(pixel))
    canvas.grab()
    index = 25 * 60 + 12
    x, y, _ = canvas.camera.project(scene.points[index : index + 1], canvas.width(), canvas.height())[0]
    place = QPoint(round(x), round(y))
    qtbot.mouseMove(canvas, place)
    assert np.abs(np.subtract(hovered[-1], scene.pixel_of(index))).max() <= 1
    qtbot.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=place)
    assert picked == [(*hovered[-1], False)]
    qtbot.mouseMove(canvas, QPoint(2, 2))
    assert hovered[-1] is None
    drag(qtbot, canvas, Qt.MouseButton.LeftButton, QPoint(40, 20))
    qtbot.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=QPoint(2, 2))
    assert len(picked) == 1, "neither a drag nor a click beside the cloud picks"
    plain = pixels(canvas)
    canvas.mark(scene.pixel_of(index))
    rows, columns = np.nonzero((pixels(canvas) != plain).any(axis=2))
    x, y, _ = canvas.camera.project(scene.points[index : index + 1], canvas.width(), canvas.height())[0]
    assert math.hypot(columns.mean() - x, rows.mean() - y) < 2


def test_colours_mean_what_is_chosen(qapp):
    depth = np.array([[1, 2, 3], [4, np.nan, 5]], np.float32)
    mask = np.array([[False, True, False], [False, False, True]])
    rgb, shades = np.arange(18, dtype=np.uint8).reshape(2, 3, 3), theme.colours(QApplication.palette())
    pixels = np.array([0, 1, 2, 3, 5], np.int32)
    none, camera = shades.grid, Camera(2.0, 2.0, 1.0, 1.0)

    def shade(colour):
        return [colour.red(), colour.green(), colour.blue()]

    def scene_of(layer, unit="", lacking="", marks=()):
        return compose(Scene("", camera, depth, layer, unit, "", "", none, lacking, marks))

    image = Layer((rgb,), picture=lambda: rgb)
    plain = rgb.reshape(-1, 3)[pixels].tolist()
    assert scene_of(image).colours.tolist() == plain
    by_depth = scene_of(Layer((depth,), levels=(1.0, 5.0), table=depth_table("turbo")), "m")
    assert by_depth.colours.tolist() == depth_table("turbo")[to_indices(depth.reshape(-1)[pixels], 1, 5), :3].tolist()
    assert (by_depth.unit, by_depth.layer.levels, by_depth.legend) == ("m", (1.0, 5.0), ())
    error = Layer(
        (np.where(mask, np.float32(10), np.float32(np.nan)),),
        levels=(1.0, 100.0),
        logarithmic=True,
        table=error_table(),
    )
    doubtful = np.zeros((2, 3), bool)
    doubtful[0, 1] = True
    expected = scene_of(error, lacking="measured")
    assert expected.colours[[0, 1]].tolist() == [shade(none), error_table()[128, :3].tolist()], "10 of 1 to 100 mm"
    marked = scene_of(error, marks=((doubtful, shades.warning, "{} unsupported"),))
    assert marked.colours[1].tolist() == shade(shades.warning)
    np.testing.assert_array_equal(np.delete(marked.colours, 1, 0), np.delete(expected.colours, 1, 0))
    assert [expected.legend[-1][1], marked.legend[-1][1]] == ["measured", "1 unsupported"]
    filled = scene_of(image, marks=((mask, shades.accent, "{} filled"), (~mask & False, shades.warning, "{} no")))
    assert filled.colours[[0, 1, 4]].tolist() == [plain[0], *[shade(shades.accent)] * 2]
    assert [text for _, text in filled.legend] == ["2 filled"]


def test_the_menus_of_the_bar_choose_colours_size_and_shading(view):
    view._choices[ColourBy.DEPTH].trigger()
    assert view.colour_by is ColourBy.DEPTH
    assert view._colour_button.text().startswith(ColourBy.DEPTH.text)
    view._sizes[3].trigger()
    assert (view.canvas.point_size, view.canvas.shaded) == (3, True)
    view._shading.trigger()
    assert (view.canvas.point_size, view.canvas.shaded) == (3, False)
    view._sizes[None].trigger()
    assert view.canvas.point_size is None


def test_large_clouds_are_coarse_while_moving_and_whole_at_rest(qtbot, view, scene, monkeypatch):
    monkeypatch.setattr(drawing, "detail", lambda points, pixels: (2, 500))
    view.show_scene(scene)
    view.canvas.grab()
    assert not view.canvas.drawing.is_full
    qtbot.waitUntil(lambda: view.canvas.drawing.is_full)
    assert len(view.canvas.drawing._picture.scene) == len(scene)
    whole = pixels(view.canvas)
    qtbot.keyClick(view.canvas, Qt.Key.Key_Left)
    view.canvas.grab()
    assert len(view.canvas.drawing._picture.scene) == 500
    index = scene.index_of(view.canvas._pixel_at(QPointF(view.canvas.rect().center())))
    assert scene.points[index, :2] == pytest.approx((0, 0), abs=0.2), "some of the points know their pixels"
    qtbot.keyClick(view.canvas, Qt.Key.Key_Right)
    qtbot.waitUntil(lambda: view.canvas.drawing.is_full)
    assert (pixels(view.canvas) == whole).all()
    qtbot.keyClick(view.canvas, Qt.Key.Key_Right)
    view.canvas.grab()
    assert not view.canvas.drawing.is_full
    view.canvas.drawing.finish()
    assert view.canvas.drawing.is_full, "for a picture of the window"


def test_depths_are_clipped_in_metres(view):
    view._show_clip(True)
    everything = np.count_nonzero((pixels(view.canvas) == RED).all(axis=2))
    view.clip.near.setValue(500)
    low, high = view.canvas.depths
    assert low == pytest.approx(2.0, abs=0.01)
    assert high == math.inf
    half = np.count_nonzero((pixels(view.canvas) == RED).all(axis=2))
    assert half < 0.7 * everything
    view._show_clip(False)
    assert view.canvas.depths == (-math.inf, math.inf)
    view._show_clip(True)
    assert view.canvas.depths == (low, high), "what was cut off comes back"
    view.clip.near.setValue(0)
    assert np.count_nonzero((pixels(view.canvas) == RED).all(axis=2)) == everything


def test_clipped_depths_stay_in_metres_when_the_cloud_changes(qtbot):
    row = DepthClip()
    qtbot.addWidget(row)
    row.set_bounds(1.0, 3.0)
    row.near.setValue(500)
    row.set_bounds(0.0, 4.0)
    assert row.depths == (2.0, math.inf)
    assert [row.near.value(), row.far.value()] == [500, 1000]
    qtbot.keyClick(row.near, Qt.Key.Key_Left)
    assert row.depths == (pytest.approx(1.96), math.inf)
    row.far.setValue(400)
    assert row.depths == (pytest.approx(1.6), pytest.approx(1.6)), "one pushes the other"
    assert row.near.value() == 400
