"""The sweep's widgets: what they propose, what they mark, and what a click takes."""

import pytest
from PySide6.QtCore import QPoint, QPointF, QSize, Qt
from PySide6.QtGui import QColor, QIcon

import ilf
from gui.features.sweep.cells import PointCells, point_cell
from gui.features.sweep.curve import ErrorCurve
from gui.features.sweep.options import CriterionBox, RangeBox
from ilf.errors import ParameterError


def test_a_range_box_offers_what_matters_and_proposes_a_range_around_the_present_value(qtbot):
    box = RangeBox("Parameter")
    qtbot.addWidget(box)
    box.set_parameters(ilf.PRESETS["best"].replace(smoothness=2.0))
    names = [box.names.itemData(position) for position in range(box.names.count())]
    assert {"smoothness", "edge_scale"} <= set(names)
    assert not {"padding", "mode", "trend"} & set(names)  # of the other filter, or no number
    box.choose("smoothness")
    assert (box.low.value(), box.high.value(), box.logarithmic) == (0.25, 16.0, True)
    assert 2.0 in box.values()
    box.low.setValue(3.0)
    box.set_parameters(ilf.PRESETS["best"])  # another value of the same parameters: the range is the user's
    assert box.low.value() == 3.0
    box.low.setValue(20.0)
    with pytest.raises(ParameterError, match="must increase"):
        box.values()
    box.set_parameters(ilf.PRESETS["paper"])
    assert box.declaration.name != "smoothness"


def test_the_truth_is_the_criterion_where_there_is_one(qtbot):
    box = CriterionBox()
    qtbot.addWidget(box)
    assert box.test().pattern == "areas"
    box.set_frame(has_ground_truth=True, chosen="Wall")
    assert box.by_ground_truth
    assert box.test() is None
    with qtbot.waitSignal(box.changed):
        qtbot.keyClick(box.blocks, Qt.Key.Key_Down)
    assert box.for_selected
    box.kind.setCurrentIndex(1)
    box.kind.activated.emit(1)
    box.hold_out.pattern.setCurrentIndex(box.hold_out.pattern.findData("random"))
    box.hold_out.seeds.setValue(2)
    box.set_frame(has_ground_truth=True, chosen="")
    assert (box.test().pattern, box.test().seeds) == ("random", (0, 1))
    assert not box.for_selected


def test_a_click_on_the_curve_takes_the_nearest_value(qtbot, shown):
    curve = shown(ErrorCurve(), 500, 200)
    curve.set_scale("Smoothness", [0.1, 1.0, 10.0], logarithmic=True)
    curve.draw([0.01, 0.02, 0.03], best=[0], present=1.0)
    qtbot.wait(1)
    assert curve.curve.getData()[1].tolist() == [10.0, 20.0, 30.0]
    assert curve.present.isVisible()
    assert curve.present.value() == 0.0
    box = curve.getViewBox()
    first, middle, last = (box.mapViewToScene(QPointF(place, 0)).x() for place in (-1, 0, 1))
    assert middle - first == pytest.approx(last - middle, abs=1)
    with qtbot.waitSignal(curve.taken) as taken:
        qtbot.mouseClick(curve.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(round(last), 100))
    assert taken.args == [2]
    curve.draw([0.01], best=[0], present=99.0)
    assert not curve.present.isVisible()


def _cells(texts, best=(), present=None, **more):
    return [
        point_cell(text, text, number in best, number == present, QIcon(), **more) for number, text in enumerate(texts)
    ]


def _centre(cells, number):
    return cells.visualItemRect(cells.item(*cells.place(number))).center()


def test_a_click_on_the_grid_takes_the_pair_whose_second_value_rises_upwards(qtbot, shown):
    grid = PointCells("Errors")
    grid.arrange((["1", "2", "3"], ["10", "20"]), QSize(60, 20))
    grid.show_cells(_cells(["10", "", "", "", "", "20"], best=[0], present=5, colour=QColor("teal")))
    shown(grid, 400, 300)
    first, above, right = (_centre(grid, number) for number in (0, 1, 2))
    assert first.x() == above.x() < right.x()
    assert above.y() < first.y() == right.y()
    assert [grid.verticalHeaderItem(row).text() for row in range(2)] == ["20", "10"]
    with qtbot.waitSignal(grid.taken) as taken:
        qtbot.mouseClick(grid.viewport(), Qt.MouseButton.LeftButton, pos=_centre(grid, 3))
    assert taken.args == [3]
    with qtbot.waitSignal(grid.taken) as taken:
        qtbot.keyClick(grid, Qt.Key.Key_Left)
        qtbot.keyClick(grid, Qt.Key.Key_Return)
    assert taken.args == [1]
    corners = [_centre(grid, number) for number in range(6)]
    picture = grid.viewport().grab().toImage()
    rings = {picture.pixelColor(grid.visualRect(grid.indexAt(at)).topLeft() + QPoint(2, 20)).name() for at in corners}
    assert len(rings) > 1, "a ring around the best"


@pytest.mark.parametrize("ground", ["#000004", "#2a0a55", "#fcffa4"])
def test_the_best_is_seen_on_every_colour_of_an_error(shown, ground):
    grid = PointCells("Errors")
    grid.arrange((["1"], ["10"]), QSize(60, 20))
    grid.show_cells(_cells(["5"], best=[0], colour=QColor(ground)))
    shown(grid, 300, 200)
    corner = grid.visualRect(grid.indexAt(_centre(grid, 0))).topLeft()
    ring = grid.viewport().grab().toImage().pixelColor(corner + QPoint(2, 20))
    assert abs(ring.lightness() - QColor(ground).lightness()) > 120


def test_pictures_are_in_as_many_columns_as_fit(shown, qtbot):
    cells = PointCells("Pictures")
    cells.arrange(None, QSize(60, 20))
    shown(cells, 300, 200)
    cells.show_cells(_cells([str(number) for number in range(9)]))
    for width in (300, 120, 900):
        cells.resize(width, 200)
        qtbot.waitUntil(lambda width=width: cells.width() == width)
        assert [cells.item(*cells.place(number)).text() for number in range(9)] == [str(number) for number in range(9)]
        assert all(cells.visualItemRect(cells.item(0, column)).right() < width for column in range(cells.columnCount()))
