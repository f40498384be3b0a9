"""The driver that corrects boundaries in the real window as a user does, on a small frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from ilf import RGBDFrame, Run
from tests.bench.corrections.driver import Count, Driver
from tests.bench.corrections.hand import Brush, Click, Command, Key, Use, stroke
from tests.bench.corrections.scenes import frames_folder, load_scene, their_network
from tests.bench.corrections.targets import Correction, read_corrections, target_map, wrong_pixels
from tests.bench.corrections.tools import ACTIONS


@pytest.fixture
def driver(qtbot: QtBot) -> Iterator[Driver]:
    """A window that nothing has been done in."""
    driver = Driver()
    yield driver
    driver.close()


def test_actions_are_done_and_counted(driver: Driver, small_frame: RGBDFrame, small_labels: np.ndarray) -> None:
    session = driver.open(Run(small_frame, small_labels), Correction("edge", "", "", (20, 4, 44, 44), ()))
    grow = [Use("select"), Click(50, 24), Use("paint"), Brush(5), stroke((28, 10), (28, 38)), Use("paint")]
    assert driver.do(grow, "grow") == Count(clicks=1, strokes=1, keys=2)
    assert session.selected == [2]
    assert (session.labels[12:36, 26:30] == 2).all()
    assert (session.labels[:, :21] == 1).all()
    undo = [Command("undo"), Use("select"), Click(10, 24, ctrl=True)]
    assert driver.do(undo, "undo") == Count(clicks=1, keys=2)
    assert np.array_equal(session.labels, small_labels)
    assert session.selected == [2, 1]
    assert driver.do([Key("Escape")], "choose none") == Count(keys=1)
    assert session.selected == []


def test_what_cannot_be_done_is_an_error(driver: Driver, small_frame: RGBDFrame, small_labels: np.ndarray) -> None:
    driver.open(Run(small_frame, small_labels), Correction("edge", "", "", (20, 4, 44, 44), ()))
    for brush in (Brush(4), Brush(1000)):
        with pytest.raises(ValueError, match="There is no brush"):
            driver.do([brush], "brush")
    with pytest.raises(ValueError, match="has no key"):
        driver.do([Command("extrapolate")], "extrapolate")


@pytest.mark.skipif(not frames_folder().is_dir(), reason="there are no frames")
def test_one_stroke_gives_the_side_of_an_oven_back(driver: Driver) -> None:
    scenes, corrections = read_corrections()
    correction = next(one for one in corrections if one.name == "side of the oven")
    with their_network():
        run = Run.of(load_scene(scenes[correction.frame], frames_folder()).frame)
    target = target_map(run.blocks, correction)
    assert wrong_pixels(run.blocks, target, correction).sum() > 600
    session = driver.open(run, correction)
    assert driver.do(ACTIONS[correction.name], "side") == Count(strokes=1, keys=1)
    assert wrong_pixels(session.labels, target, correction).sum() < 100
    assert session.undo_stack.count() == 1
