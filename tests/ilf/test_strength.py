"""Edge strength of a frame: found once, kept as long as the frame and no longer."""

from __future__ import annotations

import gc
import weakref
from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf.assets import asset_path
from ilf.edges.network import EdgeNetwork, load_model
from ilf.edges.strength import DETECTORS, canny_strength, combined_strength
from ilf.errors import InputError
from ilf.frame import RGBDFrame


def _frame() -> RGBDFrame:
    """A colour edge between columns 29 and 30, and a depth jump between rows 39 and 40."""
    rgb = np.full((60, 80, 3), 60, np.uint8)
    rgb[:, 30:] = (220, 90, 30)
    depth = np.full((60, 80), 1.5)
    depth[40:] = 2.5
    return RGBDFrame(rgb, depth)


def test_strength_is_1_at_colour_edges_and_depth_jumps_and_0_far_from_them() -> None:
    strength = canny_strength(_frame())
    assert strength.dtype == np.float32
    assert strength.shape == (60, 80)
    assert strength.min() >= 0
    assert strength.max() == 1
    assert (strength[5:35, 28:32].max(axis=1) == 1).all()
    assert (strength[38:42, 45:].max(axis=0) == 1).all()
    assert (strength[5:30, 50:] == 0).all()


def test_noise_has_strengths_in_between() -> None:
    rgb = np.random.default_rng(0).integers(0, 255, (40, 50, 3), dtype=np.uint8)
    strength = canny_strength(RGBDFrame(rgb, np.full((40, 50), 2.0)))
    assert 0 <= strength.min() < strength.max() <= 1
    assert ((strength > 0) & (strength < 1)).any()


def test_a_frame_has_one_strength_that_cannot_be_changed() -> None:
    frame, other = _frame(), _frame()
    strength = canny_strength(frame)
    assert canny_strength(frame) is strength
    assert canny_strength(other) is not strength
    assert np.array_equal(canny_strength(other), strength)
    with pytest.raises(ValueError, match="read-only"):
        strength[0, 0] = 1


def test_strength_goes_with_the_frame() -> None:
    frame = _frame()
    left = weakref.ref(frame), weakref.ref(canny_strength(frame))
    gc.collect()
    assert left[1]() is not None, "kept while the frame is"
    del frame
    gc.collect()
    assert [kept() for kept in left] == [None, None]


def test_network_and_depth_jumps_make_the_filters_edges() -> None:
    depth = np.full((64, 80), 2.0, np.float32)
    depth[:, 40:] = 3.0
    rgb = np.zeros((64, 80, 3), np.uint8)
    rgb[:32] = (200, 40, 40)
    strength = combined_strength(RGBDFrame(rgb, depth), load_model("edges"), False)
    assert strength.shape == (64, 80)
    assert strength.dtype == np.float32
    assert (strength[:, 39] == 1).all()
    assert strength[29:35, 10:30].max(axis=0).mean() > 0.4
    assert strength[5:20, 5:30].max() < 0.1


@pytest.mark.parametrize("foreign", [False, True], ids=["missing", "foreign"])
def test_without_the_network_canny_is_taken_and_that_is_said(
    foreign: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "edges.onnx"
    if foreign:
        path.write_bytes(b"no network")
    monkeypatch.setattr("ilf.models.asset_path", lambda name: path)
    depth = np.full((64, 80), 2.0, np.float32)
    depth[20:30, 20:30] = np.nan
    frame, labels = RGBDFrame(np.zeros((64, 80, 3), np.uint8), depth), np.ones((64, 80), np.int32)
    result = ilf.complete(frame, labels)
    assert np.isfinite(result.depth).all()
    assert result.outcomes[1].message.startswith("Edges come from Canny: ")
    assert "edges.onnx" in result.outcomes[1].message
    canny = ilf.complete(frame, labels, ilf.preset(edges="canny"))
    assert np.array_equal(canny.depth, result.depth)
    assert canny.outcomes[1].message == ""
    with pytest.warns(RuntimeWarning, match="Edges come from Canny"):
        ilf.iterate(frame, labels, 1)


def test_huge_images_are_looked_at_scaled_down(monkeypatch: pytest.MonkeyPatch) -> None:
    rgb = np.zeros((300, 480, 3), np.uint8)
    rgb[:, 240:] = 220
    network = EdgeNetwork.load(asset_path("models/edges.onnx"))
    monkeypatch.setattr("ilf.edges.network.LONGEST_SIDE", 160)
    sizes = []
    monkeypatch.setattr(network, "_run", lambda padded: sizes.append(padded.shape) or padded[..., 0] / np.float32(255))
    strength = network.strength(rgb)
    assert strength.shape == (300, 480)
    assert max(sizes[0]) <= 160 + 2 * 32


@pytest.mark.parametrize("detector", DETECTORS)
def test_every_detector_gives_a_strength(detector: str) -> None:
    frame = _frame()
    strength = ilf.edge_strength(frame, detector)
    assert strength.dtype == np.float32
    assert strength.shape == frame.shape
    assert strength.min() >= 0
    assert strength.max() <= 1
    strength[:] = 0  # the caller's own
    again = ilf.edge_strength(frame, detector)
    colour, depth = again[5:35, 28:32].max() > 0.5, again[38:42, 50:].max() == 1
    assert (colour, depth) == (detector != "depth", detector in ("depth", "combined"))


def test_colour_alone_serves_the_network_and_canny() -> None:
    frame = _frame()
    for detector in ("hed", "canny"):
        assert np.array_equal(ilf.edge_strength(frame.rgb, detector), ilf.edge_strength(frame, detector))
    for detector in ("depth", "combined"):
        with pytest.raises(InputError, match="needs a frame with depth"):
            ilf.edge_strength(frame.rgb, detector)
    with pytest.raises(InputError, match="8-bit RGB"):
        ilf.edge_strength(frame.rgb[..., 0], "canny")
    with pytest.raises(InputError, match="no detector 'sobel'"):
        ilf.edge_strength(frame, "sobel")
    with pytest.raises(InputError, match="no edge network 'mine'"):
        ilf.edge_strength(frame, "hed", model="mine")


def test_three_scales_differ_from_one() -> None:
    frame = _frame()
    assert not np.array_equal(ilf.edge_strength(frame, "hed", multiscale=True), ilf.edge_strength(frame, "hed"))
