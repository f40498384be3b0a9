"""The dialog that loads ground truth shows what a file is before it is loaded."""

import cv2
import numpy as np
import pytest

from gui.features.accuracy.ground_truth import GroundTruthDialog
from gui.work.jobs import stop_workers
from gui.work.latest_request import LatestRequest


@pytest.fixture
def dialog(small_frame, qtbot):
    questions = LatestRequest()
    dialog = GroundTruthDialog(small_frame, questions)
    qtbot.addWidget(dialog)
    yield dialog
    dialog.reject()
    assert stop_workers(questions)


def test_the_true_depth_is_seen_and_described_before_it_is_loaded(dialog, small_frame, qtbot, tmp_path):
    path = tmp_path / "true.png"
    truth = np.nan_to_num(small_frame.depth, nan=2.0) + 0.1
    cv2.imwrite(str(path), (1000 * truth).round().astype(np.uint16))
    assert dialog.depth_preview.picture.pixmap().isNull()
    dialog.choose(str(path))
    qtbot.waitUntil(dialog.accept_button.isEnabled)
    assert not dialog.depth_preview.picture.pixmap().isNull()
    described = "Known at 100% of the pixels without depth; median deviation from the known depth: 100.0 mm."
    assert dialog.message.text().startswith(described)
    assert dialog.seen.found.ground_truth == pytest.approx(truth, abs=0.001)
    dialog.path.clear()
    dialog.read()
    assert dialog.depth_preview.picture.pixmap().isNull()
    assert not dialog.accept_button.isEnabled()
