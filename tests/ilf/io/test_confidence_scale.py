"""Confidence maps beside two files, and maps that are not from 0 to 2."""

from pathlib import Path

import numpy as np
import pytest

import ilf
from tests.ilf.image_files import write_file, write_rgbd

LEVELS = np.repeat([0, 1, 2], 4)[None] + np.zeros((9, 1), int)


def save(folder: Path, depth: str, confidence: str, levels: np.ndarray) -> tuple[Path, Path]:
    write_file(folder / confidence, levels)
    return write_rgbd(folder, np.full(LEVELS.shape, 2000, np.uint16), depth)


@pytest.mark.parametrize(
    ("depth", "confidence"),
    [
        ("depth.png", "confidence.png"),
        ("depth_07.png", "confidence_07.npy"),
        ("0007-depth.png", "0007-confidence.png"),
        ("depth/07.png", "confidence/07.png"),
        ("depth/depth_07.png", "confidence/confidence_07.png"),
    ],
)
def test_a_confidence_map_beside_two_files_is_used(depth, confidence, tmp_path, cli):
    files = save(tmp_path, depth, confidence, LEVELS.astype(np.uint8))
    frame = ilf.load_frame(*files, min_confidence=2)
    assert np.array_equal(frame.known, LEVELS == 2)
    assert not frame.plausibility_warnings
    assert any("confidence map" in note for note in ilf.load_frame(*files).notes)
    assert ilf.load_frame(*files, min_confidence=2, beside=False).known.all()
    assert "72 pixels, 66.7% of the known pixels" in cli("info", *files, "--min-confidence", "2").out
    (tmp_path / confidence).unlink()
    assert "no confidence map" in cli("info", *files, "--min-confidence", "2").out


@pytest.mark.parametrize("levels", [LEVELS * 127.5, LEVELS * 50, LEVELS / 2, 100 - LEVELS * 25])
@pytest.mark.parametrize("least", [1, 2])
def test_a_map_of_another_scale_is_doubted(levels, least, tmp_path, cli):
    files = save(tmp_path, "depth.png", "confidence.npy", levels)
    if levels.max() == 1:
        if least == 2:
            with pytest.raises(ilf.IlfError, match="ranges from 0 to 1"):
                ilf.load_frame(*files, min_confidence=least)
        return
    with pytest.warns(ilf.DepthWarning, match=f"to {levels.max():g}, not from 0 to 2"):
        frame = ilf.load_frame(*files, min_confidence=least)
    assert frame.plausibility_warnings
    assert "warning:" in cli("info", *files, "--min-confidence", least).out
    assert not ilf.load_frame(*files, min_confidence=levels.max()).plausibility_warnings


@pytest.mark.parametrize("sure", [1, 90])
def test_a_map_whose_larger_values_are_less_sure_is_doubted(sure, tmp_path, cli):
    """ZED has 1 for sure depth and 100 for none."""
    depth = np.full((20, 30), 2000, np.uint16)
    depth[:, :8] = 0
    write_file(tmp_path / "confidence.png", np.where(depth > 0, sure, 100 - sure).astype(np.uint8))
    files = write_rgbd(tmp_path, depth)
    found = ilf.load_frame(*files, min_confidence=1, warn=False).plausibility_warnings
    assert any("less sure" in text for text in found) == (sure == 1)
    assert ("less sure" in cli("info", *files, "--min-confidence", 1).out) == (sure == 1)


def test_a_map_without_values_where_depth_is_missing_is_not_doubted(tmp_path):
    depth = np.full((20, 30), 2000, np.uint16)
    depth[:, :8] = 0
    write_file(tmp_path / "confidence.npy", np.where(depth > 0, 2, np.nan))
    files = write_rgbd(tmp_path, depth)
    assert not ilf.load_frame(*files, min_confidence=1).plausibility_warnings  # nor does numpy warn


@pytest.mark.parametrize("least", [1, 2])
def test_a_map_of_two_values_is_not_doubted(least, tmp_path):
    files = save(tmp_path, "depth.png", "confidence.png", (255 * (LEVELS > 1)).astype(np.uint8))
    frame = ilf.load_frame(*files, min_confidence=least)
    assert np.array_equal(frame.known, LEVELS == 2)
    assert not frame.plausibility_warnings
