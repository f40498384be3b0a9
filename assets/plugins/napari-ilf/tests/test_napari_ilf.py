"""The reader, the sample and the widget, in napari."""

import cv2
import numpy as np
import pytest
from napari_ilf.completing import CompletionWidget

import ilf
from ilf.project.file import save_project
from ilf.project.frame_state import FrameState
from ilf.project.project import Project, ProjectFrame

CAMERA = ilf.Camera(80, 80, 39.5, 29.5)


@pytest.fixture
def frame():
    """Two walls in different colours at different depths, each with a hole."""
    rows, columns = np.mgrid[:60, :80]
    left = columns < 40
    rgb = np.where(left[..., None], (40, 90, 200), (220, 200, 60)).astype(np.uint8)
    depth = np.where(left, 1.5 + 0.004 * rows, 2.6 + 0.003 * columns)
    depth[20:34, 10:25] = np.nan
    depth[15:40, 55:66] = np.nan
    return ilf.RGBDFrame(rgb, depth, intrinsics=CAMERA, name="walls")


@pytest.fixture
def viewer(make_napari_viewer):
    return make_napari_viewer()


def names(viewer):
    return [layer.name for layer in viewer.layers]


def test_a_project(viewer, tmp_path, frame):
    completion = ilf.complete(frame)
    state = FrameState("ab", frame, completion.run.blocks, common=completion.run.parameters, results=completion.results)
    frames = ProjectFrame("ab", "walls", None, has_state=True), ProjectFrame("cd", "bare", None, has_state=True)
    bare = FrameState("cd", frame, ilf.Blocks(np.zeros(frame.shape, np.int32)))
    save_project(tmp_path / "two.ilf", Project(frames, present="ab"), [state, bare])
    viewer.open(tmp_path / "two.ilf", plugin="napari-ilf")
    kinds = "colour", "depth", "completed", "expected error", "blocks"
    assert names(viewer)[:5] == [f"walls {kind}" for kind in kinds]
    assert len(viewer.layers) == 7
    np.testing.assert_array_equal(viewer.layers["walls completed"].data, completion.depth)
    np.testing.assert_array_equal(viewer.layers["walls expected error"].data, ilf.expected_error(completion))
    np.testing.assert_array_equal(viewer.layers["walls blocks"].data, completion.blocks)
    assert viewer.layers[0].rgb
    assert [layer.visible for layer in viewer.layers] == [True, True, True, False, True, False, False]


@pytest.mark.parametrize("depth_format", ["npy", "png"])
def test_a_run_and_its_folder(viewer, tmp_path, frame, depth_format):
    cv2.imwrite(str(tmp_path / "rgb.png"), frame.rgb[..., ::-1])
    np.save(tmp_path / "depth.npy", frame.depth)
    read = ilf.load_frame(tmp_path / "rgb.png", tmp_path / "depth.npy", intrinsics=CAMERA)
    completion = ilf.complete(read)
    completion.save(tmp_path / "out", depth_formats=(depth_format,))
    viewer.open(tmp_path / "out" / "run.json", plugin="napari-ilf")
    viewer.open(tmp_path / "out", plugin="napari-ilf")
    assert len(viewer.layers) == 10
    tolerance = 0 if depth_format == "npy" else 0.0006
    for kind, expected in (("completed", completion.depth), ("expected error", ilf.expected_error(completion))):
        found = next(layer.data for layer in viewer.layers if layer.name.endswith(kind))
        both = np.isfinite(expected) & np.isfinite(found)
        assert both.sum() > 400
        np.testing.assert_allclose(found[both], expected[both], atol=tolerance, rtol=0)


def test_the_sample_is_completed_by_the_widget(viewer, qtbot):
    viewer.open_sample("napari-ilf", "room")
    assert names(viewer) == ["room colour", "room depth"]
    viewer.layers["room depth"].scale = (2, 2)
    for layer in viewer.layers:  # thinned, to be quick
        layer.data = layer.data[::4, ::4]
    viewer.layers["room depth"].metadata.clear()
    _, widget = viewer.window.add_plugin_dock_widget("napari-ilf", "Complete depth")
    assert isinstance(widget, CompletionWidget)
    widget.image.value, widget.depth.value = viewer.layers
    complete(widget, qtbot)
    assert "pixels filled" in widget.message.value, widget.message.value
    frame = ilf.RGBDFrame(viewer.layers[0].data, viewer.layers[1].data)
    expected = ilf.complete(frame)
    np.testing.assert_array_equal(viewer.layers["room depth completed"].data, expected.depth)
    np.testing.assert_array_equal(viewer.layers["room depth blocks"].data, expected.blocks)
    assert list(viewer.layers["room depth completed"].scale) == [2, 2]

    # once more, of integers, with one block only: the results replace the former ones
    millimetres = np.nan_to_num(viewer.layers[1].data * 1000).astype(np.uint16)
    viewer.layers[1].data = millimetres
    widget.depth.changed.emit(viewer.layers[1])
    assert widget.units.value == 1000
    before = names(viewer)
    widget.blocks.value = viewer.layers["room depth blocks"]
    complete(widget, qtbot)
    assert names(viewer) == before
    known = np.isfinite(expected.depth)
    assert np.nanmedian(abs(viewer.layers["room depth completed"].data - expected.depth)[known]) < 0.001


def complete(widget, qtbot):
    widget.button.changed.emit(True)
    assert widget.button.text == "Cancel", widget.message.value
    qtbot.waitUntil(lambda: widget.button.text == "Complete", timeout=60_000)


def test_cancelling_and_wrong_layers(viewer, qtbot, frame):
    viewer.add_image(frame.rgb, name="colour")
    _, widget = viewer.window.add_plugin_dock_widget("napari-ilf", "Complete depth")
    widget.button.changed.emit(True)
    assert widget.message.value.startswith("Select an image layer")
    viewer.add_image(frame.depth[:30], name="half")
    widget.image.value, widget.depth.value = viewer.layers
    widget.button.changed.emit(True)
    assert "30" in widget.message.value
    assert widget.button.text == "Complete"
    viewer.add_image(frame.depth, name="depth")
    widget.depth.value = viewer.layers["depth"]
    widget.button.changed.emit(True)
    widget.button.changed.emit(True)
    assert not widget.button.enabled
    qtbot.waitUntil(lambda: widget.button.text == "Complete", timeout=60_000)
    assert widget.message.value == "Cancelled."
    assert names(viewer) == ["colour", "half", "depth"]
