"""Stages of the extraction: their pictures and their view."""

import numpy as np
import pytest
from PySide6.QtGui import QActionGroup
from PySide6.QtWidgets import QMenu

from gui.state.workspace import Workspace
from gui.views.cell import Cell
from gui.views.view_data import ShownStage, ViewData
from ilf.drawing.blocks import STAGES, stage_count, stage_legend, stage_picture
from ilf.segmentation.extraction import Extraction


def _extraction(height: int = 8, width: int = 12) -> Extraction:
    edges = np.zeros((height, width), bool)
    edges[:, 6] = True
    dilated = edges.copy()
    dilated[:, 5:8] = True
    labels = np.where(np.arange(width) < 6, 1, 2) * np.ones((height, 1), np.int32)
    strength = np.linspace(0, 1, width, dtype=np.float32) * np.ones((height, 1), np.float32)
    return Extraction(strength, edges, dilated, labels.astype(np.int32), labels.astype(np.int32), "")


def test_pictures_of_the_stages():
    extraction, rgb = _extraction(), np.full((8, 12, 3), 100, np.uint8)
    strength, binarised, dilated, contracted, blocks = (stage_picture(stage, rgb, extraction) for stage in STAGES)
    assert strength[0, [0, -1]].tolist() == [1, 255]
    dimmed, edge, around = binarised[0, 0], binarised[0, 6], dilated[0, 5]
    assert (dimmed < 100).all()
    assert (binarised[0, 5] == dimmed).all()
    assert (dilated[0, 6] == edge).all()
    assert len({tuple(colour) for colour in (dimmed, edge, around)}) == 3
    np.testing.assert_array_equal(contracted, blocks)
    assert (blocks[0, 0] != blocks[0, -1]).any()


def test_what_is_said_of_a_stage_belongs_to_its_picture():
    extraction, rgb = _extraction(), np.zeros((8, 12, 3), np.uint8)
    assert [stage_count(stage, extraction) for stage in STAGES] == ["", "", "", "2 regions", "2 blocks"]
    texts = {stage: [text for _, text in stage_legend(stage, extraction)] for stage in STAGES}
    assert texts["binarised"] == ["edges 8.3%"]
    assert texts["dilated"] == ["edges", "dilated 25.0%"]
    assert not any(texts[stage] for stage in ("strength", "contracted", "blocks"))
    picture = stage_picture("dilated", rgb, extraction)[0]
    (edge, _), (around, _) = stage_legend("dilated", extraction)
    for colour, shown in ((edge, picture[6]), (around, picture[5])):
        np.testing.assert_allclose(shown, 0.75 * np.array(colour), atol=1)


@pytest.fixture
def data(qapp):
    data, group = ViewData(Workspace()), QActionGroup(qapp)
    for text in STAGES.values():
        action = group.addAction(f"Show &{text}")
        action.setIconText(text)
        action.setCheckable(True)
    data.stage_actions = group.actions()
    return data


@pytest.fixture
def cell(shown, data):
    return shown(Cell("extraction", lambda view, event: False, data), 900, 300)


def test_stages_are_chosen_in_the_menu_of_the_view_whose_title_names_them(cell, data):
    cell.open_menu()
    (stages,) = (menu for menu in cell._menu.findChildren(QMenu) if menu.title().startswith("Stage"))
    cell._menu.close()
    assert [action.iconText() for action in stages.actions()] == list(STAGES.values())
    stages.actions()[1].trigger()
    assert data.stage_actions[1].isChecked()
    data.stage = ShownStage("binarised")
    cell.draw_again()
    assert cell.strip.title == "Extraction: binarised"
