"""Edge strength of a frame: found once, kept as long as the frame and no longer."""

import gc
import sys
import weakref

import numpy as np
import pytest

import ilf
from ilf._runtime.networks import network
from ilf.errors import InputError, InstallationError
from ilf.segmentation.edges.detectors import EdgeNetwork
from ilf.segmentation.edges.frame_edges import DETECTORS, canny_lines, edges_for, find_edges, relief_of
from ilf.segmentation.extraction import extract


def _frame():
    """A colour edge between columns 29 and 30, and a depth jump between rows 39 and 40."""
    rgb = np.full((60, 80, 3), 60, np.uint8)
    rgb[:, 30:] = (220, 90, 30)
    depth = np.full((60, 80), 1.5)
    depth[40:] = 2.5
    return ilf.RGBDFrame(rgb, depth)


CANNY, NETWORK = ilf.BlockParameters(detector="canny"), ilf.BlockParameters()


def test_strength_is_1_at_colour_edges_and_depth_jumps_and_0_far_from_them():
    strength = find_edges(_frame(), CANNY).strength
    assert strength.dtype == np.float32
    assert strength.shape == (60, 80)
    assert strength.min() >= 0
    assert strength.max() == 1
    assert (strength[5:35, 28:32].max(axis=1) == 1).all()
    assert (strength[38:42, 45:].max(axis=0) == 1).all()
    assert (strength[5:30, 50:] == 0).all()


def test_a_frame_has_one_strength_that_cannot_be_changed():
    frame, other = _frame(), _frame()
    found = find_edges(frame, CANNY)
    assert find_edges(frame, CANNY).strength is found.strength
    assert find_edges(other, CANNY).strength is not found.strength
    assert np.array_equal(find_edges(other, CANNY).strength, found.strength)
    relief = relief_of(frame, CANNY)
    assert relief_of(frame, CANNY) is relief
    for array in (found.strength, relief.bend, relief.jumps[0], canny_lines(frame, CANNY)):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1


def test_strength_goes_with_the_frame():
    frame = _frame()
    left = weakref.ref(frame), weakref.ref(find_edges(frame, CANNY).strength)
    gc.collect()
    assert left[1]() is not None, "kept while the frame is"
    del frame
    gc.collect()
    assert [kept() for kept in left] == [None, None]


def _holed():
    depth = np.full((64, 80), 2.0, np.float32)
    depth[20:30, 20:30] = np.nan
    return ilf.RGBDFrame(np.zeros((64, 80, 3), np.uint8), depth), np.ones((64, 80), np.int32)


@pytest.mark.parametrize("foreign", [False, True], ids=["missing", "foreign"])
def test_without_the_network_canny_is_taken_and_that_is_said(foreign, tmp_path, monkeypatch):
    path = tmp_path / "edges.onnx"
    if foreign:
        path.write_bytes(b"no network")
    monkeypatch.setattr(EdgeNetwork, "bundled", lambda: EdgeNetwork.load(path))
    frame, labels = _holed()
    result = ilf.complete(frame, labels, ilf.preset(correction=False))
    assert np.isfinite(result.depth).all()
    (note,) = result.notes
    assert note.startswith("Canny's edges replace those of the network: ")
    assert "edges.onnx" in note
    assert result.results[1].network is None
    assert result.results[1].notes == extract(frame).notes == ilf.iterate(frame, labels, 1).notes == (note,)
    canny = ilf.complete(frame, labels, ilf.preset(edges="canny", correction=False))
    assert np.array_equal(canny.depth, result.depth)
    assert canny.notes == ()
    assert canny.outcomes == result.outcomes


@pytest.fixture
def missing_runtime(monkeypatch):
    """As after pip uninstall onnxruntime."""
    monkeypatch.setattr(network, "_runtime", network._runtime.__wrapped__)
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    monkeypatch.setattr("ilf._runtime.networks.network._networks", {})


def test_nothing_stands_in_for_networks_that_cannot_be_run(missing_runtime):
    frame, labels = _holed()
    cure = 'pip install --force-reinstall "onnxruntime>=1.20,<2"'
    for parameters in (ilf.preset(), ilf.preset(correction=False), ilf.preset(edges="canny")):
        with pytest.raises(InstallationError, match=r"ONNX Runtime, which the networks .* cannot be loaded") as caught:
            ilf.complete(frame, labels, parameters)
        assert cure in str(caught.value)
    with pytest.raises(InstallationError):
        extract(frame)


def test_a_run_that_asks_for_no_network_needs_none(missing_runtime, tmp_path):
    frame, labels = _holed()
    found = extract(frame, CANNY)
    for parameters in (ilf.preset(edges="canny", correction=False), ilf.preset("paper")):
        run = ilf.Run(frame, labels, parameters)
        completion = run.complete()
        assert found.notes == completion.notes == ()
        written = completion.save(tmp_path / parameters.filter, cloud=None)
        note = written.notes[0]
        assert note.startswith("Canny's edges are used for the expected error: ONNX Runtime")


def test_the_filter_sees_the_edges_of_the_extraction():
    """Canny and jumps with its parameters; whether and which network is asked stays the filter's own choice."""
    frame = _frame()
    own = ilf.BlockParameters(canny_sigma=4.0, canny_high=0.3, canny_low_ratio=0.2, depth_jump=0.5, model="none")
    seen = edges_for(frame, ilf.preset(edges="canny"), own)
    assert np.array_equal(seen.detected, find_edges(frame, own.replace(detector="canny")).detected)
    assert not np.array_equal(seen.detected, edges_for(frame, ilf.preset(edges="canny")).detected)
    assert edges_for(frame, ilf.preset(), own).network == find_edges(frame, NETWORK).network
    flat = edges_for(frame, ilf.preset(), ilf.BlockParameters(depth_jump=2.0))
    assert np.array_equal(flat.strength, flat.probability), "no jump is that large"
    usual = edges_for(frame, ilf.preset())
    assert not np.array_equal(usual.strength, usual.probability)
    # where the extraction takes no notice of depth, its jumps are the usual ones for the filter
    flat = edges_for(frame, ilf.preset(), ilf.BlockParameters(use_depth=False, depth_jump=2.0))
    assert np.array_equal(flat.strength, usual.strength)
    assert edges_for(frame, ilf.preset("paper")) is None


@pytest.mark.parametrize("detector", [name for name in DETECTORS if name != "rgbd"])
def test_every_detector_gives_a_strength(detector):
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


def test_colour_alone_serves_the_network_and_canny():
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


@pytest.mark.parametrize("multiscale", [False, True])
def test_blocks_and_filter_see_as_many_scales_as_they_ask_for(multiscale):
    frame = _frame()
    expected = ilf.edge_strength(frame, "hed", multiscale=multiscale)
    assert np.array_equal(find_edges(frame, ilf.BlockParameters(multiscale=multiscale)).detected, expected)
    assert np.array_equal(edges_for(frame, ilf.preset(multiscale=multiscale)).detected, expected)
    combined = ilf.edge_strength(frame, "combined", multiscale=multiscale)
    likely = find_edges(frame, ilf.BlockParameters(multiscale=multiscale)).probability
    assert np.array_equal(combined, np.where(relief_of(frame, CANNY).edges, 1, likely))
