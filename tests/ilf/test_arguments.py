"""Arguments of another kind are taken where their meaning is clear, and answered by one sentence otherwise."""

from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf.data.by_hand import DepthByHand

CAMERA = (60.0, 63.0, 30.5, 24.5)


@pytest.fixture
def completion(small_frame, small_labels):
    return ilf.complete(small_frame, small_labels, preset="paper", max_iterations=3)


def test_depth_and_colour_in_either_order_are_the_same_frame(small_frame):
    swapped = ilf.RGBDFrame(small_frame.depth, small_frame.rgb)
    np.testing.assert_array_equal(swapped.depth, small_frame.depth)
    np.testing.assert_array_equal(swapped.rgb, small_frame.rgb)


def test_completion_and_frame_in_either_order_are_evaluated_alike(completion, small_frame):
    truth = ilf.RGBDFrame(small_frame.rgb, small_frame.depth, ground_truth=np.nan_to_num(small_frame.depth, nan=2.0))
    assert ilf.evaluate_completion(completion, truth) == ilf.evaluate_completion(truth, completion)


def test_a_hold_out_takes_a_pattern_and_a_completion(completion):
    by_name, by_test = (ilf.evaluate_hold_out(completion, test) for test in ("areas", ilf.HoldOutTest("areas")))
    assert by_name.whole == by_test.whole == ilf.evaluate_hold_out(completion.run).whole


def test_one_neighbour_and_one_point_need_no_list(small_frame):
    several = ilf.with_neighbours(small_frame, [small_frame])
    np.testing.assert_array_equal(ilf.with_neighbours(small_frame, small_frame).depth, several.depth)
    mask = ilf.select_region(small_frame, [(40, 20)], [(5, 5)])
    np.testing.assert_array_equal(ilf.select_region(small_frame, (40, 20), (5, 5)), mask)


@pytest.mark.parametrize(
    "camera", [CAMERA, ",".join(map(str, CAMERA)), np.array([[60.0, 0, 30.5], [0, 63.0, 24.5], [0, 0, 1]])]
)
def test_points_normals_and_surfaces_take_intrinsics_as_numbers(camera, completion, small_frame):
    images, known = (completion.depth, small_frame.rgb), ilf.Camera(*CAMERA)
    for make in (ilf.point_cloud, ilf.surface_mesh):
        assert len(make(*images, camera)) == len(make(*images, known)) > 0
    np.testing.assert_array_equal(ilf.surface_normals(images[0], camera), ilf.surface_normals(images[0], known))


def test_depth_of_a_completion_is_written(completion, tmp_path):
    ilf.write_depth(tmp_path / "depth.npy", completion)
    np.testing.assert_array_equal(np.load(tmp_path / "depth.npy"), completion.depth)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda frame: ilf.expected_error(frame.depth), "completion, not ndarray"),
        (lambda frame: ilf.unsupported(frame), "completion, not RGBDFrame"),
        (lambda frame: ilf.extrapolate(frame), "completion, not RGBDFrame"),
        (lambda frame: ilf.evaluate_completion(frame, frame.depth), "completion, not ndarray"),
        (lambda frame: ilf.evaluate_hold_out(frame), "run, not RGBDFrame"),
        (lambda frame: ilf.evaluate_hold_out(ilf.Run(frame, np.ones(frame.shape, int)), 3), "test, not int"),
        (lambda frame: ilf.HoldOutTest("areas", 3), "integers, not int"),
        (lambda frame: ilf.select_region(frame, inside="here"), "not 'h'"),
        (lambda frame: ilf.select_region(frame, inside=[(1, 2, 3)]), "1, 2, 3"),
        (lambda frame: ilf.with_neighbours(frame.depth, frame), "RGBDFrame, not ndarray"),
        (lambda frame: ilf.write_cloud("a.ply", frame.depth), "points, not ndarray"),
        (lambda frame: ilf.write_mesh("a.ply", frame), "surface, not RGBDFrame"),
        (lambda frame: ilf.write_depth(frame.depth, frame.depth), "path, not ndarray"),
        (lambda frame: ilf.point_cloud(frame.depth, frame.rgb, "nowhere"), "no intrinsics preset 'nowhere'"),
        (lambda frame: ilf.complete(frame, np.ones(frame.shape, int), own={3: "paper"}), "no block 3. Blocks: 1."),
        (lambda frame: ilf.complete(frame, np.ones((*frame.shape, 3), int)), r"of shape \(\d+, \d+, 3\), but"),
        (lambda frame: ilf.iterate(frame, np.ones(frame.shape, int), "1"), "no block '1'"),
        (lambda frame: frame.changed(name=7), "must be text, not int"),
        (lambda frame: frame.changed(intrinsics="60,60"), "'60,60' is not fx,fy,cx,cy"),
        (lambda frame: ilf.load_frame(frame.rgb, frame.depth), "files, not ndarray"),
        (lambda frame: ilf.load_frame(None), "files, not NoneType"),
        (lambda frame: ilf.open_source(None), "path, not NoneType"),
        (lambda frame: ilf.preset(3), "or file, not 3"),
        (lambda frame: ilf.save_preset(ilf.preset(), "soft"), "parameters, not str"),
        (lambda frame: ilf.Camera(*CAMERA, model="omni"), "model must be pinhole or fisheye, not 'omni'"),
        (lambda frame: ilf.Camera(*CAMERA).shape, "not known. Give it as size"),
        (lambda frame: ilf.point_cloud(frame.depth, frame.rgb, {"fx": 60, "cx": 1}), "lack fy, cy. Give fx, fy"),
        (lambda frame: DepthByHand(frame.depth, weight=2), "weight of depth by hand must lie between 0 and 1, not 2"),
    ],
)
def test_what_cannot_be_meant_is_one_sentence(call, told, small_frame, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ilf.IlfError, match=told):
        call(small_frame)
    assert not list(Path().iterdir())
