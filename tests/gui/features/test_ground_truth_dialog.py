"""The dialog that loads ground truth shows what a file is before it is loaded."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from gui.features.accuracy.ground_truth import GroundTruthDialog, frame_with
from gui.work.latest_request import LatestRequest
from ilf.data.frame import RGBDFrame


@pytest.fixture
def dialog(small_frame: RGBDFrame, qtbot: QtBot) -> Iterator[GroundTruthDialog]:
    questions = LatestRequest(frame_with)
    dialog = GroundTruthDialog(small_frame, questions)
    qtbot.addWidget(dialog)
    yield dialog
    dialog.reject()
    assert questions.shutdown()


def test_the_true_depth_is_seen_and_described_before_it_is_loaded(
    dialog: GroundTruthDialog, small_frame: RGBDFrame, qtbot: QtBot, tmp_path: Path
) -> None:
    path = tmp_path / "true.png"
    truth = np.nan_to_num(small_frame.depth, nan=2.0) + 0.1
    cv2.imwrite(str(path), (1000 * truth).round().astype(np.uint16))
    assert dialog.preview.picture.pixmap().isNull()
    dialog.choose(str(path))
    qtbot.waitUntil(dialog.load_button.isEnabled)
    assert not dialog.preview.picture.pixmap().isNull()
    described = "Known at 100% of the pixels without depth; median deviation from the known depth: 100.0 mm."
    assert dialog.message.text().startswith(described)
    assert dialog.found().ground_truth == pytest.approx(truth, abs=0.001)
    dialog.path.clear()
    dialog.read()
    assert dialog.preview.picture.pixmap().isNull()
    assert not dialog.load_button.isEnabled()
