"""Every bench in its quick form, so that none rots: `python -m pytest tests/bench`. No figure is claimed from it."""

import json
import os
import random
import runpy
from unittest.mock import patch

import cv2
import numpy as np
import pytest

from ilf._runtime.installation import asset_path
from tests.ilf.small_sequences import write_sequence
from tests.ilf.two_cameras import write_pair

from .samples import scaled, write_sample

QUICK = (
    ("blocks", "FRAME --methods canny,felzenszwalb", "purity"),
    ("correction_effect", "FRAME --seeds 1 --network NETWORK", "geometric mean: RMSE"),
    ("denoising", "--scenes STRAIGHT --methods input,median", "cylinder, 6.5 mm: all (230,400 pixels)"),
    ("faults", "--only preset --every 5", "preset"),
    ("frame_split", "choosing FRAMES", "nyu_0433"),
    ("fuzz", "--sound", "autosave: 1 valid files are read"),
    ("fuzz", "--cases 10 --format pose", "| pose | 10 |"),
    ("fuzz", "--seed 1 --first 689 --cases 1 --format ros2-sqlite-sql", "| ros2-sqlite-sql | 1 |"),  # without columns
    ("kill", "--rounds 1 --seed RANDOM", "1 kills"),
    ("kill.writers", "--kills 4 --only preset blocks", "complete after kills"),
    ("monkey", "--steps 40 --seeds 1", "40 steps, 0 exceptions"),
    ("mutants", "--sample 1 --only ilf/data/camera.py --suites CAMERA_TESTS --jobs 1 --out OUT", "faults found"),
    ("pass_band", "--sizes 48x27 --precisions float32 --iterations 5 --rounds 1", "48x27   float32"),
    ("pipeline", "FRAME --sizes 160x120 --threads 1 --rounds 1", "all steps"),
    ("quality_checks", "WHOLE", "| all |"),
    ("selection", "FRAMES --outlines OUTLINES", "1 objects, after 1, 2, 3 clicks"),
    ("sequences", "SEQUENCE --length 2 --threads 1", "stream, rate"),
    ("soak", "stream --frames 100 --size 40x30 --limit 1000", "memory has grown"),
    ("soak", "window --frames 2 --limit 1000", "memory has grown"),
    ("two_orders", "PAIR:1 --rigs 1 --scenes 1 --scale 0.1", "fill, align, fill"),
)  # fmt: skip
"""Module, its arguments, in which words in capitals are made data, and what its table contains."""

EXTRAS = {"mutants": "coverage"}
"""Benches whose packages are in an extra of their own."""


@pytest.fixture
def data(tmp_path):
    """Small data of every kind."""
    whole = tmp_path / "whole"
    whole.mkdir()
    frame = scaled((320, 240))
    cv2.imwrite(str(whole / "rgb.png"), frame.rgb[..., ::-1])
    cv2.imwrite(str(whole / "gt.png"), (1000 * np.nan_to_num(frame.depth, nan=5.0)).astype(np.uint16))
    pair = tmp_path / "pair"
    write_pair(pair)
    outlines = tmp_path / "outlines.json"
    outlines.write_text(json.dumps({"frame": {"middle": [[60, 40], [100, 40], [100, 80], [60, 80]]}}))
    return {
        "OUTLINES": str(outlines),
        "FRAME": str(write_sample(tmp_path / "frame", (160, 120))),
        "FRAMES": str(tmp_path),
        "SEQUENCE": str(write_sequence(tmp_path / "sequence")),
        "WHOLE": str(whole),
        "NETWORK": str(asset_path("models/correction.onnx")),
        "PAIR:1": f"{pair}:1",
        "CAMERA_TESTS": "tests/ilf/data/test_camera.py",
        "STRAIGHT": "cylinder, 6.5 mm",
        "OUT": str(tmp_path / "out"),
        "RANDOM": str(random.randrange(10**6)),
    }


# benches import from each other, and warn of doubtful frames as any program does
@pytest.mark.filterwarnings(
    "ignore:.*found in sys.modules after import of package:RuntimeWarning", "ignore::ilf.errors.DepthWarning"
)
@pytest.mark.parametrize(("module", "arguments", "printed"), QUICK, ids=[module for module, *_ in QUICK])
def test_it_runs_and_prints_its_table(module, arguments, printed, data, capsys, qapp):
    if module in EXTRAS:
        pytest.importorskip(EXTRAS[module])
    status: object = 0
    with patch("sys.argv", [module, *(data.get(word, word) for word in arguments.split())]), patch.dict(os.environ):
        try:
            runpy.run_module(f"tests.bench.{module}", run_name="__main__", alter_sys=False)
        except SystemExit as ended:
            status = ended.code
    told = capsys.readouterr()
    assert not status, told.out + told.err
    assert printed in told.out
