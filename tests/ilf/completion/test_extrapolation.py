"""The guess of what no block could complete: everywhere, marked, and nothing else touched."""

import numpy as np
import pytest

import ilf
from ilf.completion.extrapolation import extrapolation_steps


@pytest.fixture
def half_done(small_frame):
    """The left half completed, the right one in no block."""
    labels = np.zeros(small_frame.shape, np.int32)
    labels[:, :30] = 1
    return small_frame, ilf.complete(small_frame, labels)


def test_all_that_is_missing_is_filled_and_marked(half_done):
    frame, before = half_done
    missing = np.isnan(before.depth)
    assert missing.sum() == 10 * 16
    after = ilf.extrapolate(before)
    assert np.array_equal(after.extrapolated, missing)
    assert np.array_equal(after.filled, ~frame.known)
    assert np.array_equal(after.depth[~missing], before.depth[~missing])
    assert after.depth.dtype == np.float32
    assert after.results == before.results
    _, columns = np.mgrid[:48, :64]
    assert np.abs(after.depth - (2.4 + 0.005 * columns))[missing].max() < 0.02
    assert not before.extrapolated.any(), "what went in is as it was"


def test_a_guess_is_no_nearer_and_no_farther_than_what_is_there(half_done):
    frame, _ = half_done
    _, columns = np.mgrid[:48, :64]
    slope = np.where((columns > 20) & (columns < 44), 1.0 + 0.05 * columns, np.nan)
    steep = ilf.RGBDFrame(frame.rgb, slope)
    extrapolated = ilf.extrapolate(ilf.complete(steep, np.zeros(frame.shape, np.int32))).depth
    assert np.isfinite(extrapolated).all()
    assert extrapolated.min() >= np.nanmin(np.float32(slope))
    assert extrapolated.max() <= np.nanmax(np.float32(slope))


def test_where_nothing_is_missing_nothing_is_guessed(half_done):
    _, before = half_done
    done = ilf.extrapolate(before)
    assert np.array_equal(ilf.extrapolate(done).depth, done.depth)
    assert list(extrapolation_steps(done)) == []


def test_the_guess_sees_the_edges_of_the_extraction_and_says_what_there_is_to_know(half_done, monkeypatch, tmp_path):
    frame, _ = half_done
    depth = frame.depth.copy()
    depth[20:40, 22:44] = np.nan
    frame = ilf.RGBDFrame(np.full((48, 64, 3), 90, np.uint8), depth)

    def guess(extraction):
        run = ilf.Run(frame, ilf.Blocks(np.zeros(frame.shape, np.int32), extraction=extraction), extrapolate=True)
        return run.complete()

    usual = guess(None)
    assert np.array_equal(guess(ilf.BlockParameters()).depth, usual.depth)
    assert not np.array_equal(guess(ilf.BlockParameters(depth_jump=3.0)).depth, usual.depth)
    assert usual.notes == ()
    monkeypatch.setattr("ilf._runtime.networks.network.asset_path", lambda name: tmp_path / "none.onnx")
    (note,) = guess(None).notes
    assert note.startswith("Canny's edges replace those of the network: ")


def test_the_rest_is_the_same_as_that_of_a_dense_run_and_is_saved_as_such(half_done, tmp_path):
    frame, before = half_done
    extrapolate, rest = ilf.complete(frame, before.blocks, extrapolate=True), ilf.extrapolate(before)
    for completion, name in ((extrapolate, "extrapolate"), (rest, "rest"), (before, "before")):
        completion.save(tmp_path / name)
    names = sorted(path.name for path in (tmp_path / "extrapolate").iterdir())
    assert "extrapolated.png" in names
    assert not (tmp_path / "before" / "extrapolated.png").exists()
    for name in names:
        assert (tmp_path / "extrapolate" / name).read_bytes() == (tmp_path / "rest" / name).read_bytes(), name
