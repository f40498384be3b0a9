"""The plot along a line: what is drawn, what the legend reads, what is written."""

import math
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtGui import QImage
from PySide6.QtSvg import QSvgRenderer

import ilf
from gui.features.inspect.profile import ProfilePage, profile_data
from gui.state.document import Document
from gui.state.results import ErrorEstimate, ViewedIteration
from ilf.project.run_history import StoredRun

LINE = ((4.5, 16.5), (60.5, 16.5))
"""Through the left hole and over the border of the blocks."""


@pytest.fixture
def data(workspace, results):
    """With all that there can be."""
    document: Document = workspace.current
    workspace.current.set_ground_truth(np.where(document.frame.known, document.frame.depth, np.float32(1.7)))
    document.store_results(results)
    completion = document.completion()
    error = ilf.expected_error(completion)
    document.store_error_estimate(completion, ErrorEstimate(error, np.zeros(error.shape, bool)))
    kept = StoredRun(1, "first try", document.run(document.state.common), {1: results[0]}, 1.0, (200, 60, 160))
    document.keep_run(kept)
    workspace.current.compare_runs([kept])
    return profile_data(document, LINE)


@pytest.fixture
def panel(shown):
    return shown(ProfilePage([]), 700, 200)


def legend(panel: ProfilePage) -> str:
    return panel.legend.text().replace("&nbsp;", " ")


def test_all_maps_are_read_at_the_same_pixels(data, workspace):
    document = workspace.current
    row, columns = 16, slice(4, 61)
    depth, error = document.current_depth(), document.expected_error()
    np.testing.assert_array_equal(data.raw, document.frame.depth[row, columns])
    result, run, truth = data.curves
    np.testing.assert_array_equal(result.depth, depth[row, columns])
    np.testing.assert_array_equal(data.error, error[row, columns])
    np.testing.assert_array_equal(truth.depth, document.frame.ground_truth[row, columns])
    assert (run.name, run.colour) == ("first try", (200, 60, 160))
    np.testing.assert_array_equal(run.depth, document.compared[0].completion.depth[row, columns])
    assert data.borders.tolist() == [26]
    header = data.profile.to_csv().splitlines()[0]
    assert header == "x,y,distance_px,surface_m,depth_m,raw_m,expected_error_m,truth_m,first try"


def test_depth_of_the_past_stands_for_the_result_and_has_no_expected_error(document):
    data = profile_data(document, LINE, ViewedIteration(document.frame.depth + 1, 7))
    (result,) = data.curves
    assert (result.name, data.error) == ("result as of iteration 7", None)
    np.testing.assert_array_equal(result.depth, data.raw + 1)


def test_the_legend_reads_what_the_mouse_is_at(panel, data):
    pointed: list[int | None] = []
    panel.pointed.connect(pointed.append)
    assert panel.data is None
    panel.show_data(replace(data, names={1: "wall <left>", 2: "floor"}))
    for name in ("raw", "result", "first try", "ground truth"):
        assert name in legend(panel)
    assert " m<" not in legend(panel)
    panel.plot.hovered.emit(7.6)  # in the hole, at column 12
    assert pointed == [8]
    text = legend(panel)
    assert "x 12, y 16" in text
    assert "wall &lt;left&gt;" in text
    assert "raw missing" in text
    assert f"result {data.curves[0].depth[8]:.3f} m ± {1000 * data.error[8]:.0f} mm" in text
    assert "truth 1.700 m" in text
    panel.plot.hovered.emit(math.nan)
    assert pointed == [8, None]
    assert "truth 1.700 m" not in legend(panel)


def test_the_axis_is_in_pixels_or_metres_along_the_surface(panel, data, small_frame, small_labels):
    panel.show_data(data)
    assert panel.plot._curves[0].getData()[0][-1] == 56
    panel.axis.setCurrentIndex(1)
    assert panel.plot._curves[0].getData()[0][-1] == data.profile.metres[-1]
    blind = Document.of(ilf.Run(ilf.RGBDFrame(small_frame.rgb, small_frame.depth), small_labels), "blind", "blind")
    panel.show_data(profile_data(blind, LINE))
    assert not panel.axis.isEnabled()
    assert panel.plot._raw.getData()[0][-1] == 56


def test_the_plot_is_written_as_picture(panel, data):
    panel.show_data(data)
    svg = panel.plot.picture(as_svg=True)
    assert QSvgRenderer(svg).isValid()
    for name in (b"raw", b"result", b"first try", b"ground truth"):
        assert name in svg
    assert b"<image" not in svg, "the points are drawn as such"
    picture = QImage.fromData(panel.plot.picture(as_svg=False))
    assert picture.width() == 2 * panel.plot.width()
    panel.show_data(replace(data, curves=()))
    assert picture != QImage.fromData(panel.plot.picture(as_svg=False))
