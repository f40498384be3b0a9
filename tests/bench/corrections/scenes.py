"""The frames of the corrections, with holes in their depth."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from ilf._runtime.files import read_json
from ilf.evaluation.bench.frames import GROUND_TRUTH_FILE, BenchFrame, as_measured
from ilf.evaluation.bench.patterns import Task, make_task
from ilf.segmentation.edges.detectors import EdgeNetwork
from ilf.sources.frames import META_NAME, load_frame

from .targets import Scene

DEPTH_FILE = "depth.png"

NETWORK = Path(__file__).parents[3] / "assets" / "models" / "bsds500" / "ilf_bsds500" / "bsds500.onnx"
"""The contour network with whose blocks the corrections were chosen."""


@contextmanager
def their_network() -> Iterator[None]:
    """Find contours by `NETWORK` during the block, whatever network is asked for."""
    with patch("ilf.segmentation.edges.frame_edges.load_model", lambda name: EdgeNetwork.load(NETWORK)):
        yield


def frames_folder() -> Path:
    """Return the folder of frames: that of ILF_TEST_DATA, or ../shared/data beside the project."""
    return Path(os.environ.get("ILF_TEST_DATA", Path(__file__).parents[3] / "../shared/data")) / "rgbd"


def load_scene(scene: Scene, folder: Path) -> Task:
    """Return a frame with a quarter of its known depth hidden in ellipses, and the hidden depth.

    Frames without measured depth have their ground truth as depth.
    """
    root = folder / scene.name
    if (root / DEPTH_FILE).is_file():
        frame = load_frame(root)
    else:
        colour = next(root.glob("rgb.*"))
        units = read_json(root / META_NAME)["gt_units_per_m"]
        frame = load_frame(colour, root / GROUND_TRUTH_FILE, depth_units=units, name=scene.name)
    return make_task(BenchFrame(as_measured(frame), None), "areas", scene.seed)
