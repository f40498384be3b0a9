"""A frame that is open, opened again with other reading options."""

import numpy as np
import pytest

from ilf.sources.frame_ref import FrameRef, ReadingOptions

from .conftest import loaded, open_frame, write_frame


@pytest.fixture
def images(tmp_path, small_frame):
    """Colour and depth files that state no camera."""
    folder = write_frame(tmp_path / "desk", small_frame)
    (folder / "meta.json").unlink()
    return str(folder / "rgb.png"), str(folder / "depth.png")


def test_with_a_camera_it_keeps_the_work_on_it(window, qtbot, images, run_all):
    open_frame(window, qtbot, *images)
    present = window.workspace.current
    present.edit_infos({1: {"name": "floor"}}, "Rename")
    run_all(window)
    completed = present.completion().depth
    assert present.frame.intrinsics is None
    with_camera = ReadingOptions(intrinsics=(500, 500, 31.5, 23.5))
    loaded(window, qtbot, window.documents.open_source, FrameRef(*images, options=with_camera))
    assert window.workspace.current is present
    assert len(window.workspace.entries) == 1
    assert present.frame.intrinsics.fx == present.completion().run.frame.intrinsics.fx == 500
    np.testing.assert_array_equal(present.completion().depth, completed)
    assert present.info(1).name == "floor"
    present.undo_stack.undo()
    assert present.info(1).name == "Block 1"


def test_with_other_units_it_is_replaced_after_asking(window, qtbot, images):
    open_frame(window, qtbot, *images)
    present = window.workspace.current
    asked: list[str] = []
    window.project.ask_remove = lambda entries, then: (asked.extend(entry.name for entry in entries), then())
    loaded(window, qtbot, window.documents.open_source, FrameRef(*images, options=ReadingOptions(depth_units=2000)))
    assert asked == [present.name]
    assert window.workspace.current is not present
    assert np.nanmedian(window.workspace.current.frame.depth) == pytest.approx(np.nanmedian(present.frame.depth) / 2)
