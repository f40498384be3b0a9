"""The frames of the corrections, with holes in their depth."""

from __future__ import annotations

import os
from pathlib import Path

from ilf._runtime.files import read_json
from ilf.lab.bench.frames import GROUND_TRUTH_FILE, BenchFrame
from ilf.lab.bench.patterns import Task, make_task
from ilf.sources.frames import META_NAME, load_frame

from .targets import Scene

DEPTH_FILE = "depth.png"


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
    return make_task(BenchFrame(frame, None), "areas", scene.seed)
