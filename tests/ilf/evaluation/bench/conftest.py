"""Frame folders for the bench."""

import json

import cv2
import pytest

from ...small_frames import write_small_frame


@pytest.fixture
def two_frames(tmp_path):
    """A folder of two frame folders, the second with a measured ground truth."""
    for name in ("first", "second"):
        folder = tmp_path / "frames" / name
        write_small_frame(folder)
        meta = {"name": name, "depth_units_per_m": 1000}
        if name == "second":
            ground_truth = cv2.imread(str(folder / "depth.png"), cv2.IMREAD_UNCHANGED)
            ground_truth[ground_truth == 0] = 2000
            ground_truth[:, 60:] = 0
            cv2.imwrite(str(folder / "gt.png"), ground_truth)
            meta |= {"gt": "measured: by hand", "gt_units_per_m": 1000}
        (folder / "meta.json").write_text(json.dumps(meta))
    return tmp_path / "frames"
