"""Colour tables that everybody can read: equal steps of depth look equal, with all kinds of colour vision."""

import numpy as np
import pytest
from PySide6.QtGui import QColor

from gui.base import theme
from gui.base.theme import blend
from gui.views.colours import DEPTH_MAP, DEPTH_MAPS, depth_table, difference_table, error_table, strength_table
from gui.views.drawings import missing_brush
from ilf.data.pictures import depth_colours

from ..base.test_theme import APART, SEEN_BY, lab

SEQUENTIAL = {name: depth_table(name) for name in DEPTH_MAPS if name != "turbo"} | {
    "error": error_table(),
    "strength": strength_table(),
}


def _seen(table: np.ndarray, eye: str, step: int = 16) -> np.ndarray:
    return np.array([lab(QColor(*map(int, entry[:3])), eye) for entry in table[1::step]])


@pytest.mark.parametrize("eye", SEEN_BY)
@pytest.mark.parametrize("name", SEQUENTIAL)
def test_what_is_farther_or_larger_is_brighter_for_everybody(name, eye):
    lightness = _seen(SEQUENTIAL[name], eye)[:, 0]
    assert (np.diff(lightness) > 0).all()
    assert lightness[-1] - lightness[0] > 50


def test_reports_draw_depth_as_the_window_does():
    assert np.abs(depth_table(DEPTH_MAP)[1:, :3].astype(int) - depth_colours()[1:]).max() <= 2


def test_the_default_has_equal_steps_and_turbo_stays_a_choice():
    steps = {
        name: np.linalg.norm(np.diff(_seen(depth_table(name), "everybody"), axis=0), axis=1)
        for name in (DEPTH_MAP, "turbo")
    }
    assert steps[DEPTH_MAP].max() < 2.5 * steps[DEPTH_MAP].min()
    assert steps["turbo"].max() > 2.5 * steps["turbo"].min()


@pytest.mark.parametrize("eye", SEEN_BY)
@pytest.mark.parametrize("dark", [False, True])
def test_both_signs_of_a_difference_are_told_apart(dark, eye):
    ends = _seen(difference_table(dark), eye, step=254)
    assert np.linalg.norm(ends[0] - ends[1]) > 2 * APART


@pytest.mark.parametrize("eye", SEEN_BY)
@pytest.mark.parametrize("name", ["light", "dark"])
def test_depth_in_only_one_of_two_is_told_apart(qapp, any_theme, name, eye):
    theme.apply_theme(qapp, name)
    colours = theme.colours(qapp.palette())
    first, second = (blend(colours.background, only, 0.55) for only in (colours.good, colours.warning))
    assert np.linalg.norm(lab(first, eye) - lab(second, eye)) >= APART / 2


def test_stripes_go_on_from_tile_to_tile(qapp):
    tile = missing_brush(theme.colours(qapp.palette())).texture().toImage()
    height, width = tile.height(), tile.width()
    grey = np.array([[tile.pixelColor(x, y).red() for x in range(width)] for y in range(height)])
    contrast = np.ptp(grey)
    assert contrast > 20
    assert np.abs(grey - np.roll(grey, (1, -1), (0, 1))).max() < 0.13 * contrast
