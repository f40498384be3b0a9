"""Edges from colour and known depth: of the depth that a frame has, for blocks and filter alike; what stands in."""

import dataclasses
import hashlib

import numpy as np
import pytest

import ilf
from ilf._runtime import installation as assets
from ilf.completion.edge_aware.iteration import EdgeAwareIteration
from ilf.data.blocks import find_blocks
from ilf.errors import InputError
from ilf.evaluation.hold_out import frame_without
from ilf.run.record import make_record
from ilf.run.replaying import network_differences
from ilf.segmentation.edges.detectors import DepthEdgeNetwork
from ilf.segmentation.edges.frame_edges import find_edges, joined, relief_of

from ..small_frames import QUICK, without_edges
from ..small_runs import OPTIONS
from ..tiny_onnx import node, write_network

RGBD, HED, CANNY = (ilf.BlockParameters(detector=name) for name in ("rgbd", "hed", "canny"))

NODES = [
    node("ReduceMean", ["depth"], "mean", axes=[1], keepdims=1),
    node("Sigmoid", ["mean"], "jump"),
    node("ReduceMean", ["image"], "crease", axes=[1], keepdims=1),
]
"""A network that says of every pixel what its features and its colour are on the mean, so that all of it is known."""


def _frame(seed=0):
    rng = np.random.default_rng(seed)
    rgb = rng.integers(0, 256, (64, 96, 3), np.uint8)
    depth = np.where(np.arange(96) < 40, 1.5, 2.5) + rng.uniform(0, 0.02, (64, 96))
    depth[20:40, 30:60] = np.nan
    return ilf.RGBDFrame(rgb, depth)


@pytest.fixture
def network(tmp_path, monkeypatch):
    """The bundled network of depth edges is a tiny one, whose file may be changed."""
    path = _tiny(tmp_path)
    _bundle(monkeypatch, {"models/depth-edges.onnx": path})
    return path


def _tiny(folder):
    return write_network(folder / "own.onnx", NODES, {"image": 3, "depth": 6}, {"jump": 1, "crease": 1})


def _bundle(monkeypatch, files):
    found = assets.asset_path
    monkeypatch.setattr("ilf._runtime.networks.network.asset_path", lambda name: files.get(name) or found(name))


def test_jumps_and_creases_are_the_networks_and_known_jumps_stand_at_1(network):
    frame = _frame()
    found = find_edges(frame, RGBD)
    jump, crease = DepthEdgeNetwork.load(network).look(frame.rgb, frame.depth)
    np.testing.assert_array_equal(found.detected, jump)
    np.testing.assert_array_equal(found.crease, crease)
    contours = find_edges(frame, HED).probability
    np.testing.assert_array_equal(found.strength, np.where(relief_of(frame, RGBD).edges, 1, joined(jump, contours)))
    np.testing.assert_array_equal(ilf.edge_strength(frame, "rgbd"), found.strength)
    assert relief_of(frame, RGBD).edges.any()
    assert found.network == hashlib.sha256(network.read_bytes()).hexdigest()
    assert find_edges(frame, HED).crease is None


def test_contours_count_as_far_as_a_jump_is_possible_and_crests_of_jumps_by_themselves():
    jump = np.zeros((21, 41), np.float32)
    jump[:, 10] = 0.4
    jump[:, 9] = jump[:, 11] = 0.2
    jump[:, 30] = 0.9
    contours = np.zeros_like(jump)
    contours[:, 12] = contours[:, 20] = contours[:, 28] = 0.8
    row = joined(jump, contours)[10]
    np.testing.assert_allclose(row[[9, 10, 11]], [1.4 * 0.2 / 16, 1.4 * 0.4, 1.4 * 0.2 / 16], rtol=1e-5)
    np.testing.assert_allclose(row[[12, 20, 28, 30]], [0.8 * np.sqrt(0.8), 0, 0.8, 1], rtol=1e-5)
    np.testing.assert_allclose(joined(jump)[10, [10, 12, 20, 28, 30]], [0.56, 0, 0, 0, 1], rtol=1e-5)


@pytest.mark.parametrize("pattern", ["areas", "random"])
def test_hidden_depth_leaves_no_trace(network, pattern):
    """What was found with depth that is hidden later is not there any more: neither in memory nor anywhere else."""
    frame = _frame()
    with_all = find_edges(frame, RGBD)
    hidden = frame_without(frame, pattern, 1)
    never = ilf.RGBDFrame(frame.rgb.copy(), hidden.depth.copy())
    expected = find_edges(never, RGBD)
    with_invalid_mask = frame.with_invalid_mask(frame.known & ~hidden.known)
    for same in (hidden, with_invalid_mask):
        found = find_edges(same, RGBD)
        for name in ("detected", "strength", "crease"):
            np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
        assert not np.array_equal(found.detected, with_all.detected)
    labels = np.ones(frame.shape, np.int32)
    depths = [ilf.complete(one, labels, ilf.preset(edges="rgbd")).depth for one in (never, hidden, with_invalid_mask)]
    np.testing.assert_array_equal(depths[0], depths[1])
    np.testing.assert_array_equal(depths[0], depths[2])
    trusting = find_edges(with_invalid_mask.with_invalid_mask(None), RGBD)
    np.testing.assert_array_equal(trusting.strength, with_all.strength)


def test_contours_stand_in_where_the_network_is_missing_and_then_canny(tmp_path, monkeypatch):
    missing, foreign = tmp_path / "none.onnx", tmp_path / "foreign.onnx"
    foreign.write_bytes(b"no network")
    frame = _frame()
    for path in (missing, foreign):
        _bundle(monkeypatch, {"models/depth-edges.onnx": path})
        found = find_edges(frame, RGBD)
        (note,) = found.notes
        assert note.startswith("Contours of the colour image replace depth edges: ")
        assert path.name in note
        np.testing.assert_array_equal(found.strength, find_edges(frame, HED).strength)
        assert found.network == find_edges(frame, HED).network
        assert found.crease is None
        with pytest.raises(InputError, match=path.name):
            ilf.edge_strength(frame, "rgbd")
        with pytest.warns(RuntimeWarning, match="replace depth edges"):
            assert np.array_equal(ilf.extract_blocks(frame, RGBD), ilf.extract_blocks(frame, HED))
    _bundle(monkeypatch, {"models/depth-edges.onnx": _tiny(tmp_path), "models/edges.onnx": missing})
    alone = find_edges(frame, RGBD)
    (note,) = alone.notes
    assert note.startswith("Depth edges are not combined with contours of the colour image: ")
    np.testing.assert_array_equal(alone.strength, np.where(relief_of(frame, RGBD).edges, 1, joined(alone.detected)))
    _bundle(monkeypatch, {"models/depth-edges.onnx": missing, "models/edges.onnx": missing})
    found = find_edges(frame, RGBD)
    assert [note.split(":")[0] for note in found.notes] == [
        "Contours of the colour image replace depth edges",
        "Canny's edges replace those of the network",
    ]
    np.testing.assert_array_equal(found.strength, find_edges(frame, CANNY).strength)
    assert found.network is None


def test_at_a_crease_the_surface_bends_but_does_not_tear():
    """A roof whose ridge is missing is found again if it is known to have one there."""
    columns = np.broadcast_to(np.arange(120.0), (90, 120))
    roof = 2.0 + 0.01 * np.abs(columns - 60)
    hole = np.zeros(roof.shape, bool)
    hole[20:70, 40:80] = True
    frame = ilf.RGBDFrame(np.full((90, 120, 3), 90, np.uint8), np.where(hole, np.nan, roof))
    (block,) = find_blocks(np.ones(roof.shape, np.int32)).values()
    edges = without_edges(frame)
    ridge = np.where(np.abs(columns - 60) <= 1, 1, 0).astype(np.float32)
    stiff = ilf.preset(trend=False, slope_weight=1e-4, bending_weight=10)

    def error(**known):
        iteration = EdgeAwareIteration(frame, block, stiff, dataclasses.replace(edges, **known))
        list(iteration)
        return float(np.sqrt(np.mean((iteration.surface.reshape(roof.shape) - roof)[hole] ** 2)))

    assert error(crease=ridge) < 0.5 * error()
    assert error(crease=np.zeros_like(ridge)) == error()


def test_the_record_names_the_network_that_was_used(network, tmp_path, monkeypatch):
    run = ilf.Run.of(_frame(), preset=ilf.preset(edges="rgbd", correction=False, **QUICK), extraction=RGBD)
    record = make_record(run.complete(), OPTIONS)
    sha256 = hashlib.sha256(network.read_bytes()).hexdigest()
    assert record.networks.extraction == record.networks.filter == {"depth-edges": sha256}
    assert network_differences(record) == []

    network.unlink()
    for text in network_differences(record):
        assert text.startswith("The network 'depth-edges' used by ")
        assert text.endswith("Install the recorded one.")
        assert " is not available: " in text
    run = ilf.Run.of(_frame(), preset=ilf.preset(edges="rgbd", correction=False, **QUICK), extraction=RGBD)
    record = make_record(run.complete(), OPTIONS)
    assert record.networks.extraction == record.networks.filter == {"edges": find_edges(run.frame, HED).network}
    assert network_differences(record) == []
