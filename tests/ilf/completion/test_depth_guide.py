"""Guides: what they are, how they are fitted and believed, and that a run with one is made again."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import ilf
from ilf._runtime.formatting import length_text
from ilf.completion.completion import guide_hold_out, guide_text
from ilf.completion.confidence.expected_error import depth_error
from ilf.completion.edge_aware.fitted_guide import fit_guide
from ilf.completion.edge_aware.guide_curve import fit_curve, sharpen
from ilf.completion.guide_hold_out import FollowedRanges, HeldOut, decided, held_out_frames
from ilf.data.guide import Guide, GuideCard
from ilf.errors import FormatError, InputError
from ilf.evaluation.hold_out import frame_without, hidden_pixels
from ilf.io.depth import encode_npy
from ilf.io.frame_additions import load_guide

SHAPE = (90, 120)


def ground_truth() -> np.ndarray:
    """A wall, and a box before it with a top that leans."""
    rows, columns = np.indices(SHAPE, np.float32)
    wall = 3 + columns / 120
    box = 1.2 + rows / 300
    return np.where((abs(rows - 45) < 25) & (abs(columns - 60) < 30), box, wall)


def frame_with_hole(**more: object) -> ilf.RGBDFrame:
    """Half of the box, and the wall beside it, are missing; colour says nothing."""
    depth = ground_truth()
    depth[30:60, 70:110] = np.nan
    return ilf.RGBDFrame(np.full((*SHAPE, 3), 90, np.uint8), depth, **more)


BLOCKS = np.ones(SHAPE, np.int32)


def error(completion: ilf.Completion) -> float:
    return float(np.abs(completion.depth - ground_truth())[30:60, 70:110].mean())


@pytest.fixture(scope="module")
def without():
    # what a guide is followed in is not corrected
    return ilf.complete(frame_with_hole(), BLOCKS, ilf.preset(correction=False))


@pytest.mark.parametrize("said", [lambda z: 1 / z, lambda z: 200 - 30 * z**2])
def test_guide_in_any_unit_brings_the_jump_back(said, without):
    guided = ilf.complete(frame_with_hole(), BLOCKS, guide=said(ground_truth()))
    assert error(guided) < 0.1 * error(without)
    known = frame_with_hole().known
    assert np.array_equal(guided.depth[known], without.depth[known])


def test_guide_that_known_depth_contradicts_changes_nothing(without):
    noise = np.random.default_rng(0).normal(size=SHAPE)
    guided = ilf.complete(frame_with_hole(), BLOCKS, ilf.preset(correction=False), guide=noise)
    assert np.array_equal(guided.depth, without.depth, equal_nan=True)
    assert "not used" in guided.notes[-1]


def guide_that_misses_the_rest_of_the_box() -> np.ndarray:
    """Right where depth is missing, and wrong where it would be missing if the gap were turned."""
    guide = ground_truth()
    guide[30:60, 10:50] = 3.5
    return guide


def test_guide_that_makes_hidden_depth_worse_is_not_followed(without):
    frame = frame_with_hole(guide=guide_that_misses_the_rest_of_the_box())
    fitted, test = fit_guide(frame), guide_hold_out(frame)
    assert fitted.belief > 0, "the quick test alone would follow it"
    assert not test.followed
    assert test.with_guide > test.without
    unguided, guided = ilf.complete(frame_with_hole(), BLOCKS), ilf.complete(frame, BLOCKS)
    assert np.array_equal(guided.depth, unguided.depth, equal_nan=True), "corrected, too, as without"
    said = f"The guide is not used: {guide_text(frame).partition(': ')[2]}."
    assert said in guided.notes
    assert length_text(test.with_guide) in said
    assert length_text(test.without) in said
    stepper = ilf.iterate(frame, BLOCKS, 1)
    assert np.array_equal(stepper.surface, ilf.iterate(frame_with_hole(), BLOCKS, 1).surface)
    assert without.notes == (), "only a frame with a guide has the note"


def test_expected_error_is_smaller_by_what_the_hold_out_says_of_a_followed_guide():
    completion = ilf.complete(frame_with_hole(guide=ground_truth()), BLOCKS)
    test = guide_hold_out(completion.frame)
    assert test.followed
    factor = (test.with_guide / test.without) ** 0.75
    expected = factor * depth_error(completion.frame, completion.depth)
    np.testing.assert_allclose(ilf.expected_error(completion), expected, rtol=1e-5)
    ignored = ilf.complete(frame_with_hole(guide=guide_that_misses_the_rest_of_the_box()), BLOCKS)
    np.testing.assert_array_equal(ilf.expected_error(ignored), depth_error(ignored.frame, ignored.depth))


def test_guide_is_tested_where_the_gaps_lie_when_turned_and_its_own_depth_is_hidden():
    frame = frame_with_hole(guide=ground_truth())
    turned, mirrored = held_out_frames(frame)
    gap = ~frame.known
    for held_out, expected in ((turned, gap[::-1, ::-1]), (mirrored, gap[:, ::-1])):
        np.testing.assert_array_equal(frame.known & ~held_out.known, expected & frame.known)
        assert held_out.guide is frame.guide
    whole = ilf.RGBDFrame(frame.rgb, ground_truth(), guide=ground_truth())
    assert list(held_out_frames(whole)) == [], "without gaps there is nothing to complete"
    assert guide_hold_out(whole).everywhere, "nothing speaks against it"


NEAR_TO_FAR = np.repeat(np.float32([1, 2, 3, 4]), 100)
"""Depth of the pixels of a hold-out: a hundred in each of four ranges."""


def held_out(*shares: float) -> HeldOut:
    """A hold-out with an error of 0.1 m without the guide, and this share of it with the guide in each range."""
    off = np.float32(0.1) * np.repeat(np.float32(shares), 100)
    without = NEAR_TO_FAR + np.float32(0.1)
    return HeldOut(NEAR_TO_FAR, NEAR_TO_FAR + off, without, (1.5, 2.5, 3.5), least=100)


@pytest.mark.parametrize(
    ("held", "followed", "with_guide"),
    [
        ([(0.5, 0.5, 0.5, 0.5)], (True, True, True, True), 0.05),
        ([(0.5, 0.5, 0.5, 0.5), (1, 1, 1, 1)], (False,) * 4, 0.075),
        ([(0.95, 0.95, 0.95, 0.95)], (False,) * 4, 0.095),
        ([(2.0, 0.5, 0.5, 0.5)], (False, True, True, True), 0.0625),
        ([(2.0, 0.5, 0.5, 0.5), (2.0, 0.5, 0.95, 0.5)], (False, True, False, True), 0.075),
        ([(2.0, 1.0, 1.0, 0.7)], (False,) * 4, 0.1175),  # too little in all
    ],
)
def test_guide_must_be_better_in_every_hold_out_and_may_be_followed_in_ranges_of_depth(held, followed, with_guide):
    found = decided([held_out(*shares) for shares in held], True)
    assert (found.ranges.followed, found.without) == (followed, pytest.approx(0.1, abs=1e-6))
    assert found.with_guide == pytest.approx(with_guide, abs=1e-6)
    assert (found.followed, found.everywhere) == (any(followed), all(followed))


def test_hold_out_needs_hidden_pixels_and_enough_of_them_in_a_range():
    assert [decided([], by_belief).followed for by_belief in (True, False)] == [True, False]
    found = decided([replace(held_out(2.0, 0.5, 0.5, 0.5), least=101)], True)
    assert not found.followed


@pytest.mark.parametrize(
    ("followed", "said"),
    [
        ((True, True, True, True), "followed: on a hold-out"),
        ((True, True, False, True), "followed in a part, at depth up to 2.5 m and from 3.5 m on: on a hold-out"),
        ((False, True, True, False), "followed in a part, at depth from 1.5 m to 3.5 m: on a hold-out"),
    ],
)
def test_followed_ranges_are_told_and_end_slowly(followed, said):
    shares = [0.5 if one else 2 for one in followed]
    found = decided([held_out(*shares)], True)
    assert found.to_text().startswith(said)
    ranges = FollowedRanges((1.5, 2.5, 3.5), followed)
    depth = np.linspace(1, 5, 2000, dtype=np.float32)
    share = ranges.share(depth)
    assert np.abs(np.diff(share)).max() < 0.02
    np.testing.assert_allclose(ranges.share(NEAR_TO_FAR)[::100], np.float32(followed), atol=1e-6)


@pytest.mark.parametrize("right_near", [True, False])
def test_guide_that_is_right_at_one_depth_and_wrong_at_another_does_no_harm(right_near):
    rows, columns = np.indices(SHAPE, np.float32)
    near = rows >= 45
    depth = np.where(near, 2 - rows / 90, 3 + columns / 120)
    # half of a turned gap, where only the guide knows it: the mean error of the hold-outs becomes much smaller
    depth[np.s_[58:77, 85:97] if right_near else np.s_[13:32, 85:97]] *= 0.7
    known = depth.copy()
    for rows_of_gap in (slice(10, 35), slice(55, 80)):
        known[rows_of_gap, 10:35] = np.nan
    frame = ilf.RGBDFrame(np.full((*SHAPE, 3), 90, np.uint8), known)
    waves = np.where(near == right_near, 1, 1 + 0.03 * np.sin(columns * np.pi / 6))
    test = guide_hold_out(frame.with_guide(1 / (waves * depth)))
    assert test.with_guide < 0.9 * test.without
    assert not test.everywhere
    guided, unguided = ilf.complete(frame, BLOCKS, guide=1 / (waves * depth)), ilf.complete(frame, BLOCKS)
    assert np.array_equal(guided.depth[near], unguided.depth[near])
    off, before = (np.abs(one.depth - depth)[~near & np.isnan(known)].mean() for one in (guided, unguided))
    if right_near:  # where it is right by much in a part of that range alone
        assert not test.followed
        assert off == before
    else:
        assert off < 0.8 * before
    assert any(("not used" if right_near else "followed in a part") in note for note in guided.notes)
    factor = (
        np.ones(SHAPE)
        if right_near
        else 1 - test.ranges.share(guided.depth) * (1 - (test.with_guide / test.without) ** 0.75)
    )
    expected = factor * depth_error(guided.frame, guided.depth)
    np.testing.assert_allclose(ilf.expected_error(guided), expected, rtol=1e-5)


def test_block_without_known_depth_is_completed_by_a_guide_alone():
    blocks = BLOCKS.copy()
    blocks[40:50, 75:85] = 2
    assert ilf.complete(frame_with_hole(), blocks).outcomes[2].status == "not recoverable"
    guided = ilf.complete(frame_with_hole(), blocks, guide=ground_truth())
    assert guided.outcomes[2].status == "completed"
    assert error(guided) < 0.025
    np.testing.assert_array_equal(ilf.unsupported(guided), blocks == 2)


def test_rest_is_guessed_by_the_guide_too():
    frame = frame_with_hole(guide=ground_truth())
    extrapolate = ilf.extrapolate(ilf.complete(frame, np.zeros(SHAPE, np.int32)))
    assert error(extrapolate) < 0.1


def test_stepper_starts_from_the_guide():
    stepper = ilf.iterate(frame_with_hole(), BLOCKS, 1, guide=1 / ground_truth())
    assert np.abs(stepper.surface.reshape(SHAPE) - ground_truth())[30:60, 70:110].mean() < 0.05


@pytest.mark.parametrize(
    ("gives", "said"),
    [
        ("affine-inverse", lambda z: 3 / z - 0.4),
        ("affine", lambda z: 40 * z + 30),
        ("metric", lambda z: z),
        ("metric", lambda z: 1000 * z),
    ],
)
def test_guide_that_gives_a_line_or_metres_is_fitted_beyond_what_is_known(gives, said):
    truth = ground_truth()
    near = truth < 2
    known = np.where(near, truth, np.nan)
    known[30:60, 70:110] = np.nan
    known[0, 0], known[60, 115] = truth[0, 0], truth[60, 115]
    frame = ilf.RGBDFrame(np.full((*SHAPE, 3), 90, np.uint8), known)
    errors = []
    for stated in (gives, None):
        found = fit_guide(frame.with_guide(Guide(said(truth), gives=stated)))
        errors.append(np.abs(found.depth / truth - 1)[~near].mean())
    assert errors[0] < 0.01
    assert errors[1] > 0.1, "otherwise nothing would have to be stated"


def test_guide_says_what_it_gives():
    values = ground_truth()
    values[:4] = -1
    assert np.isnan(Guide(values, gives="metric").values[:4]).all()
    assert np.isfinite(Guide(values, gives="affine").values).all()
    assert not Guide(values, gives="affine").is_same_as(Guide(values))
    assert Guide(values, gives="affine").resized_to((180, 240)).gives == "affine"
    card = GuideCard("small", "its maker", "MIT", "affine-inverse", 1)
    assert Guide(values, network=card).gives == "affine-inverse"
    with pytest.raises(InputError, match=r"cannot give 'depth'\. Known: 'relative-inverse', 'affine-inverse'"):
        Guide(values, gives="depth")  # type: ignore[arg-type]


def test_curve_is_monotone_and_goes_on_beyond_what_is_known():
    depth = np.linspace(1, 4, 4000)
    outliers = depth.copy()
    outliers[::10] = 2.0
    curve = fit_curve(1 / depth, np.log(outliers), np.ones(4000))
    asked = np.linspace(0.8, 5, 50)
    found = np.exp(curve(1 / asked))
    assert np.all(np.diff(found) >= 0)
    assert found == pytest.approx(asked, rel=0.03)
    for factor in (0.001, 1000.0):
        again = fit_curve(1 / depth, np.log(outliers), np.full(4000, factor))
        assert np.exp(again(1 / asked)) == pytest.approx(found, rel=1e-6), "weights count relative to each other"


def test_hidden_depth_has_no_part_in_the_fit():
    frame = frame_with_hole(guide=1 / ground_truth())
    hidden = frame_without(frame, "areas")
    assert hidden.guide is frame.guide
    # by the direct formula: without noise and bias, the guide is the depth itself
    fitted = fit_guide(hidden)
    assert fitted.belief > 0.9
    assert np.median(np.abs(fitted.depth / ground_truth() - 1)) < 0.01
    gone = hidden_pixels(frame, "areas")
    changed = ilf.RGBDFrame(frame.rgb, np.where(gone, 1.5 * frame.depth, frame.depth), guide=frame.guide)
    other = fit_guide(frame_without(changed, "areas"))
    np.testing.assert_array_equal(other.depth, fitted.depth)
    np.testing.assert_array_equal(other.test.change, fitted.test.change)


def test_values_that_stand_for_nothing_and_far_outliers_do_no_harm():
    odd = 1 / ground_truth()
    odd[:5], odd[5, :5] = -3.4e38, 1e29
    assert np.isnan(Guide(odd).values[:5]).all()
    found = fit_guide(frame_with_hole(guide=odd))
    assert found.belief > 0.9
    assert np.median(np.abs(found.depth[6:] / ground_truth()[6:] - 1)) < 0.01
    level = np.full((40, 50), 2, np.float32)
    level[0, 0], level[1, 1] = 9e29, -9e29
    assert np.isfinite(sharpen(level)).all()


def test_where_a_guide_has_no_value_its_confidence_does_not_count():
    holed = 1 / ground_truth()
    holed[40:50, 80:100] = np.nan
    plain, sure = (ilf.complete(frame_with_hole(guide=Guide(holed, one)), BLOCKS) for one in (None, np.ones(SHAPE)))
    assert np.array_equal(sure.depth, plain.depth, equal_nan=True)


def test_second_depth_is_no_confidence():
    with pytest.raises(InputError, match="not 0 to 1"):
        Guide(ground_truth(), ground_truth())


def test_guide_is_resized_only_to_its_own_aspect():
    small = cv2.resize(ground_truth(), (60, 45), interpolation=cv2.INTER_AREA)
    frame = frame_with_hole(guide=small)
    assert frame.guide.values.shape == SHAPE
    holed = small.copy()
    holed[:10] = 0
    assert np.isnan(Guide(holed).resized_to(SHAPE).values[:18]).all()
    with pytest.raises(InputError, match="90 x 90 but the frame is 120 x 90, which has another aspect"):
        frame_with_hole(guide=ground_truth()[:, :90])


def test_larger_guide_is_averaged_and_smaller_one_interpolated():
    values = np.arange(24.0).reshape(4, 6) + 1
    in_corners = np.kron(values, np.pad([[16.0]], (0, 3))).astype(np.float32)
    in_corners[in_corners == 0] = 1e-9  # zero stands for nothing
    np.testing.assert_allclose(Guide(in_corners).resized_to((4, 6)).values, values, rtol=1e-6)
    larger = Guide(values).resized_to((16, 24)).values
    np.testing.assert_allclose(np.diff(larger[:, 2:-2]), 0.25, rtol=1e-5)


@pytest.mark.parametrize("values", [np.zeros((4, 4)), np.full((4, 4), 3.0), np.full((4, 4), np.nan)])
def test_guide_that_says_nothing_is_refused(values):
    with pytest.raises(InputError, match="no usable values"):
        Guide(values)


def test_guides_are_read_from_files(tmp_path):
    grey = (40 * ground_truth()).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "grey.png"), grey)
    cv2.imwrite(str(tmp_path / "three.png"), np.dstack([grey] * 3))
    cv2.imwrite(str(tmp_path / "four.png"), np.dstack([*[grey] * 3, np.full_like(grey, 255)]))
    np.save(tmp_path / "one.npy", grey[None])
    np.savez(tmp_path / "named.npz", other=np.zeros(3), disparity=grey)
    for name in ("grey.png", "three.png", "four.png", "one.npy", "named.npz"):
        assert np.array_equal(load_guide(tmp_path / name, SHAPE).values, grey), name
    both = Guide(ground_truth(), ground_truth() / 5)
    (tmp_path / "both.npy").write_bytes(encode_npy(both.array))
    assert load_guide(tmp_path / "both.npy").is_same_as(both)
    assert not both.is_same_as(Guide(ground_truth()))

    cv2.imwrite(str(tmp_path / "coloured.png"), cv2.applyColorMap(grey, cv2.COLORMAP_JET))
    (tmp_path / "broken.npz").write_bytes(b"PK no zip")
    np.savez(tmp_path / "many.npz", a=grey, b=grey)
    for name, words in (
        ("coloured.png", "colour-mapped"),
        ("broken.npz", "cannot be read"),
        ("many.npz", "it has a, b"),
    ):
        with pytest.raises(FormatError, match=words):
            load_guide(tmp_path / name)


@pytest.fixture
def folder(tmp_path):
    """A frame folder with a guide in it."""
    frame = frame_with_hole()
    cv2.imwrite(str(tmp_path / "rgb.png"), frame.rgb)
    np.save(tmp_path / "depth.npy", frame.depth)
    np.save(tmp_path / "guide.npy", (1 / ground_truth()).astype(np.float32))
    (tmp_path / "meta.json").write_text('{"depth_units_per_m": 1}')
    return tmp_path


def test_run_with_a_guide_is_made_again_and_not_without_it(folder, cli):
    frame = ilf.load_frame(folder)
    run = ilf.Run(frame.with_guide(replace(frame.guide, gives="affine-inverse")), BLOCKS)
    run.complete().save(folder / "out", cloud=None)
    (folder / "guide.npy").unlink()
    again = ilf.replay(folder / "out" / "run.json")
    assert again.differences == ()
    assert again.verdict(again.run.complete()) == ()
    assert again.run.frame.guide.gives == "affine-inverse"
    assert "guide_used.npy" in cli("info", folder / "out" / "run.json").out

    used = folder / "out" / "guide_used.npy"
    used.write_bytes(encode_npy(Guide(ground_truth()).array))
    with pytest.raises(InputError, match="not the guide of the recorded run"):
        ilf.replay(folder / "out" / "run.json")
    used.unlink()
    with pytest.raises(InputError, match="is not beside the record"):
        ilf.replay(folder / "out" / "run.json")
