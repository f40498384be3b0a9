"""The bench: what is hidden, what the peers make of it, how it is scored, and the command."""

import csv
import itertools
import json
import shutil

import cv2
import numpy as np
import pytest

from ilf import RGBDFrame, preset
from ilf.cli import main
from ilf.completion.confidence.expected_error import depth_error
from ilf.data.parameters import PRESETS
from ilf.errors import FormatError, InputError, ParameterError
from ilf.lab.bench.frames import BenchFrame, find_frames, load_bench_frame
from ilf.lab.bench.methods import GROUPS, METHODS, Method, parse_methods
from ilf.lab.bench.patterns import make_task
from ilf.lab.bench.results import Plan, against_peers, bootstrap, summarise
from ilf.lab.bench.runner import read_earlier_result, run_bench, score
from ilf.run.run import complete
from tests.bench import frame_split

from ..small_frames import write_small_frame

ROWS, COLUMNS = np.mgrid[:40, :60].astype(np.float64)
PLANE = 1.5 + 0.004 * ROWS + 0.006 * COLUMNS
HOLES = ((ROWS - 15) ** 2 + (COLUMNS - 20) ** 2 < 81) | ((COLUMNS > 40) & (ROWS > 30))
COLOUR = np.stack([COLUMNS * 4, ROWS * 5, np.full(ROWS.shape, 90)], axis=-1).astype(np.uint8)
LABELS = np.where(COLUMNS < 30, 1, 2).astype(np.int32)


@pytest.fixture(autouse=True)
def quick_presets(monkeypatch):
    """Presets as they are, but of few iterations."""
    for name in PRESETS:
        quick = preset(name, max_iterations=30)
        run = lambda frame, labels, quick=quick: complete(frame, labels, quick).depth  # noqa: E731
        monkeypatch.setitem(METHODS, name, Method(name, run, True))


@pytest.fixture
def two_frames(tmp_path):
    """A folder of two frame folders, the second with a measured truth."""
    for name in ("first", "second"):
        folder = tmp_path / "frames" / name
        write_small_frame(folder)
        meta = {"name": name, "depth_units_per_m": 1000}
        if name == "second":
            ground_truth = cv2.imread(str(folder / "depth.png"), cv2.IMREAD_UNCHANGED)
            ground_truth[ground_truth == 0] = 2000
            ground_truth[:, 60:] = 0
            cv2.imwrite(str(folder / "gt.png"), ground_truth)
            meta |= {"gt": "measured: by hand", "gt_units_per_m": 1000}
        (folder / "meta.json").write_text(json.dumps(meta))
    return tmp_path / "frames"


def frame_of(depth, holes=HOLES, name="plane"):
    return RGBDFrame(COLOUR, np.where(holes, np.nan, depth), name=name)


# patterns


def test_patterns_hide_their_share_and_follow_from_name_and_seed():
    source = BenchFrame(frame_of(PLANE), None)
    known = source.frame.known
    for pattern, share in (("random", 1 - 0.4277), ("areas", 0.25)):
        task = make_task(source, pattern)
        assert task.scored.sum() == pytest.approx(share * known.sum(), abs=1)
        assert not (task.scored & ~known).any()
        np.testing.assert_array_equal(task.frame.known, known & ~task.scored)
        np.testing.assert_array_equal(make_task(source, pattern).scored, task.scored)
        assert (make_task(source, pattern, seed=1).scored != task.scored).any()
        renamed = BenchFrame(frame_of(PLANE, name="other"), None)
        assert (make_task(renamed, pattern).scored != task.scored).any()


def test_areas_are_ellipses_of_the_stated_size():
    width = 400
    depth = np.full((300, width), 2.0)
    frame = RGBDFrame(np.zeros((*depth.shape, 3), np.uint8), depth, name="wide")
    scored = make_task(BenchFrame(frame, None), "areas").scored
    reach = cv2.distanceTransform(np.pad(scored, 1).astype(np.uint8), cv2.DIST_L2, 5).max()
    assert 0.03 * width - 1 <= reach <= 2 * 0.12 * width
    count, _ = cv2.connectedComponents(scored.astype(np.uint8))
    assert count - 1 <= 0.25 * depth.size / (np.pi * (0.03 * width) ** 2) + 1


def test_truth_scores_the_frames_own_holes_where_truth_is_known(two_frames):
    source = load_bench_frame(two_frames / "second")
    task = make_task(source, "ground-truth")
    np.testing.assert_array_equal(task.scored, ~source.frame.known & np.isfinite(source.ground_truth))
    assert task.scored.any()
    assert not task.scored[:, 60:].any()
    with pytest.raises(InputError, match="no measured or exact ground truth"):
        make_task(load_bench_frame(two_frames / "first"), "ground-truth")


@pytest.mark.parametrize(
    "worth", ["filled, 8-bit steps of 39.2 mm (+-20 mm)", "exact filled", "own hole filling, NOT measured GT", ""]
)
def test_filled_depth_is_no_truth(two_frames, worth):
    meta = {"depth_units_per_m": 1000, "gt": worth, "gt_units_per_m": 1000}
    (two_frames / "second" / "meta.json").write_text(json.dumps(meta))
    assert load_bench_frame(two_frames / "second").ground_truth is None


def test_truth_with_a_mask_stands_in_for_depth(two_frames):
    folder = two_frames / "second"
    (folder / "depth.png").unlink()
    mask = np.zeros((60, 80), np.uint8)
    mask[5:20, 5:20] = 255
    cv2.imwrite(str(folder / "mask.png"), mask)
    source = load_bench_frame(folder)
    np.testing.assert_array_equal(source.frame.known, np.isfinite(source.ground_truth) & (mask == 0))
    np.testing.assert_array_equal(make_task(source, "ground-truth").scored, mask > 0)


def test_a_folder_of_filled_depth_only_is_no_frame(two_frames):
    folder = two_frames / "second"
    (folder / "depth.png").unlink()
    with pytest.raises(InputError, match="neither raw depth nor a measured or exact gt"):
        load_bench_frame(folder)


def test_frames_that_leave_nothing_to_score():
    one = np.zeros((40, 60))
    one[3, 4] = 2.0
    for pattern in ("areas", "random"):
        with pytest.raises(InputError, match=r"hidden|held-out"):
            make_task(BenchFrame(RGBDFrame(COLOUR, one), None), pattern)
    with pytest.raises(InputError, match="no pattern 'stripes'"):
        make_task(BenchFrame(frame_of(PLANE), None), "stripes")


# methods


@pytest.mark.parametrize(
    ("name", "tolerance"), [("linear", 1e-5), ("thin-plate", 1e-6), ("soft-thin-plate", 1e-6), ("polynomial", 1e-6)]
)
def test_a_plane_is_recovered(name, tolerance):
    inner = (ROWS > 5) & (ROWS < 30) & (COLUMNS > 5) & (COLUMNS < 50)
    filled = METHODS[name].run(frame_of(PLANE, inner & HOLES), LABELS)
    np.testing.assert_allclose(filled, PLANE, atol=tolerance)


def test_thin_plate_and_polynomial_carry_a_plane_on_beyond_the_known():
    for name in ("thin-plate", "soft-thin-plate", "polynomial"):
        np.testing.assert_allclose(METHODS[name].run(frame_of(PLANE, COLUMNS > 40), LABELS), PLANE, atol=1e-5)


def test_soft_thin_plate_is_tilted_less_by_noise():
    rough = PLANE + np.random.default_rng(0).normal(0, 0.02, PLANE.shape)
    frame = frame_of(rough, COLUMNS > 45)
    errors = {
        name: np.abs(METHODS[name].run(frame, LABELS) - PLANE)[:, 46:].max()
        for name in ("thin-plate", "soft-thin-plate")
    }
    assert errors["soft-thin-plate"] < 0.3 * errors["thin-plate"]


def test_colourisation_follows_colour_and_laplace_does_not():
    step = np.where(COLUMNS < 30, 1.0, 2.0)
    colour = np.where(COLUMNS[..., None] < 30, 40, 220).repeat(3, axis=2).astype(np.uint8)
    hole = (abs(COLUMNS - 29.5) < 12) & (abs(ROWS - 20) < 12)
    frame = RGBDFrame(colour, np.where(hole, np.nan, step))
    errors = {
        name: np.abs(METHODS[name].run(frame, LABELS) - step)[hole].mean() for name in ("colourisation", "laplace")
    }
    assert errors["colourisation"] < 0.05
    assert errors["laplace"] > 0.15


def test_morphology_fills_narrow_gaps_and_leaves_wide_holes():
    depth = np.full((120, 160), 3.0)
    depth[:, :40] = 1.0
    depth[:, 36:44] = np.nan
    depth[20:100, 70:150] = np.nan
    filled = METHODS["morphology"].run(RGBDFrame(np.zeros((120, 160, 3), np.uint8), depth), LABELS)
    assert (np.diff(filled[60, 34:46]) >= 0).all()
    assert (filled[60, 34], filled[60, 45]) == pytest.approx((1.0, 3.0))
    assert np.isnan(filled[60, 110])
    assert np.nanmax(filled) == pytest.approx(3.0)


# OpenCV's Telea strays by up to sqrt(2) units, here millimetres, from pixel to pixel, even where all depth is the same
CLOSE = {"telea": 0.02}


# not the presets, whose zero start takes more iterations to be forgotten
@pytest.mark.parametrize("name", GROUPS["peers"])
def test_peers_keep_constant_depth(name):
    filled = METHODS[name].run(frame_of(np.full(ROWS.shape, 2.0)), LABELS)
    assert np.isfinite(filled).all()
    np.testing.assert_allclose(filled, 2.0, atol=CLOSE.get(name, 1e-5))


@pytest.mark.parametrize("name", METHODS)
def test_every_method_takes_holes_and_a_single_known_pixel(name):
    one = np.full(ROWS.shape, np.nan)
    one[12, 40] = 2.0
    for depth in (np.where(HOLES, np.nan, PLANE), one):
        filled = METHODS[name].run(RGBDFrame(COLOUR, depth), LABELS)
        known, found = np.isfinite(depth), np.isfinite(filled)
        assert filled.shape == depth.shape
        assert found[known].all()
        assert (filled[found] > 0).all()
    if name not in PRESETS:
        np.testing.assert_allclose(filled[found], 2.0, atol=CLOSE.get(name, 1e-5))


def test_new_presets_are_methods_and_groups_are_taken_apart():
    assert set(PRESETS) <= set(METHODS)
    assert parse_methods("peers,linear") == list(GROUPS["peers"])
    assert parse_methods("all") == list(METHODS)
    for wrong in ("linear,cubic", " , "):
        with pytest.raises(ParameterError, match="Known: all, presets, peers"):
            parse_methods(wrong)


# scoring


def test_uncovered_pixels_count_with_the_nearest_known_depth():
    task = make_task(BenchFrame(frame_of(PLANE), None), "areas")
    left_open = score(task.frame.depth, task)
    assert (left_open.coverage, left_open.within) == (0.0, None)
    assert left_open.errors == score(METHODS["nearest"].run(task.frame, LABELS), task).errors
    assert left_open.errors.rmse > 0
    half = np.where(COLUMNS < 30, PLANE, 0.0)
    assert score(half, task).coverage == pytest.approx((task.scored & (COLUMNS < 30)).sum() / task.scored.sum())
    perfect = score(PLANE, task)
    assert (perfect.coverage, perfect.within) == (1.0, 1.0)
    off = np.where(COLUMNS < 30, PLANE + 0.01, np.nan)
    assert score(off, task).within == pytest.approx(
        np.mean(depth_error(task.frame, off)[task.scored & (COLUMNS < 30)] >= 0.01), abs=1e-6
    )
    assert 0 < score(off, task).within < 1
    assert perfect.errors.rmse == pytest.approx(0, abs=1e-6)


def test_a_method_that_fails_counts_as_nothing_filled(two_frames, monkeypatch):
    def too_large(frame, labels):
        raise InputError("too large")

    monkeypatch.setitem(METHODS, "linear", Method("linear", too_large, False))
    result = run_bench(Plan((two_frames / "first",), ("areas",), ("linear", "nearest")))
    failed, nearest = result.rows
    assert (failed.failure, failed.coverage) == ("too large", 0.0)
    assert failed.rmse == nearest.rmse
    assert {line.method: line.failures for line in summarise(result)} == {"linear": 1, "nearest": 0}


def test_summary_is_the_mean_over_frames(two_frames):
    result = run_bench(Plan(tuple(find_frames([two_frames])), ("random",), ("laplace", "polynomial")))
    lines = {line.method: line for line in summarise(result)}
    rows = [row for row in result.rows if row.method == "laplace"]
    assert [row.frame for row in rows] == ["first", "second"]
    assert lines["laplace"].rmse_mm == pytest.approx(1000 * (rows[0].rmse + rows[1].rmse) / 2)
    assert lines["laplace"].extraction_seconds is None
    assert lines["polynomial"].extraction_seconds > 0


def test_frames_are_compared_one_by_one_with_the_best_peer_of_each(two_frames):
    (two_frames / "first" / "meta.json").write_text('{"name": "first", "depth_units_per_m": 1000, "sensor": "one"}')
    result = run_bench(Plan(tuple(find_frames([two_frames])), ("areas",), ("best", "paper", "nearest", "laplace")))
    assert [task.sensor for task in result.tasks] == ["one", "second"]
    for measure in ("rmse", "mae"):
        errors = {line: [getattr(row, measure) for row in result.rows if row.method == line] for line in METHODS}
        best_peer = np.minimum(errors["nearest"], errors["laplace"])
        for line in map(vars, summarise(result)):
            own = np.array(errors[line["method"]])
            ratios = own / best_peer
            assert line[f"{measure}_geometric_mm"] == pytest.approx(1000 * np.sqrt(own.prod()))
            assert line[f"{measure}_ratio"] == pytest.approx(np.sqrt(ratios.prod()))
            assert line[f"{measure}_wins"] == (ratios <= 1).sum()
            # of two sensors, both are drawn half of the time, and either of them twice a quarter of it
            assert line[f"{measure}_low_95"] == pytest.approx(ratios.min())
            assert line[f"{measure}_high_68"] == pytest.approx(ratios.max())
        assert sum(line.rmse_wins for line in summarise(result) if line.method not in PRESETS) == 2
    shares = [row.within for row in result.rows if row.method == "best"]
    best = next(line for line in summarise(result) if line.method == "best")
    assert best.calibrated == np.mean([0.55 <= share <= 0.80 for share in shares])
    assert best.sparsification == np.mean([row.sparsification for row in result.rows if row.method == "best"])


def test_without_peers_nothing_is_compared_with_them(two_frames):
    (line,) = summarise(run_bench(Plan((two_frames / "first",), ("areas",), ("best",))))
    assert line.rmse_ratio is line.mae_wins is line.rmse_low_68 is None
    assert line.rmse_geometric_mm == pytest.approx(line.rmse_mm)


def test_the_bootstrap_draws_whole_sensors():
    sensors = ("a", "a", "a", "b", "c")
    found = against_peers([0.1, 0.2, 0.4, 1.0, 0.0], [0.1, 0.1, 0.1, 0.5, 1e-6], sensors)
    logarithms = np.log([1, 2, 4, 2, 1])
    assert found == against_peers([0.1, 0.2, 0.4, 1.0, 0.0], [0.1, 0.1, 0.1, 0.5, 1e-6], sensors)
    assert (found.ratio, found.wins) == (pytest.approx(16 ** (1 / 5)), 2)
    every = [
        np.exp(np.concatenate([logarithms[np.array(sensors) == name] for name in drawn]).mean())
        for drawn in itertools.product("abc", repeat=3)
    ]
    drawn = bootstrap(logarithms, sensors)
    assert np.isin(drawn.round(9), np.round(every, 9)).all()
    assert drawn.mean() == pytest.approx(np.mean(every), rel=0.01)
    assert (found.low_95, found.high_95) == (pytest.approx(min(every)), pytest.approx(max(every)))
    assert found.low_95 <= found.low_68 < found.ratio < found.high_68 <= found.high_95
    assert against_peers([0.1, 0.2], [0.1, 0.1], ("a", "a")).low_68 is None


def test_no_frame_both_chooses_and_judges(capsys):
    halves = []
    for half in ("choosing", "judging"):
        assert frame_split.main([half, "frames"]) == 0
        halves.append(capsys.readouterr().out.split())
    assert all(path.startswith("frames/") for path in halves[0])
    assert not set(halves[0]) & set(halves[1])


# rows of an earlier result


@pytest.fixture
def earlier(two_frames, tmp_path):
    """A result of both frames, seed 1."""
    arguments = ["--methods", "nearest,linear,polynomial", "--pattern", "areas", "--seed", "1"]
    assert main(["bench", str(two_frames), *arguments, "--json", str(tmp_path / "earlier.json")]) == 0
    return tmp_path / "earlier.json"


@pytest.mark.parametrize("value", [[], {}, None, 10**400, float("nan"), True])
def test_an_earlier_result_that_is_damaged(earlier, value):
    content = json.loads(earlier.read_text())
    content["rows"][0]["frame" if isinstance(value, list) else "rmse"] = value
    earlier.write_text(json.dumps(content))
    with pytest.raises(FormatError, match="is not a result of"):
        read_earlier_result(earlier, list(METHODS))


def test_peers_of_an_earlier_result_are_not_run_again(two_frames, earlier, monkeypatch):
    def run(frame, labels):
        pytest.fail("it was run again")

    for name in ("nearest", "linear"):
        monkeypatch.setitem(METHODS, name, Method(name, run, False))
    methods = ("best", "nearest", "linear", "polynomial", "telea")
    then = read_earlier_result(earlier, methods)
    # a polynomial is fitted to each block, and blocks may be others by now
    assert then.methods == ("nearest", "linear")
    result = run_bench(Plan(tuple(find_frames([two_frames])), ("areas",), methods, 1), earlier=then)
    assert [row.method for row in result.rows] == [*methods, *methods]
    rows = json.loads(earlier.read_text())["rows"]
    assert [vars(row) for row in result.rows if row.method in then.methods] == [
        row for row in rows if row["method"] in then.methods
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--seed", "2"], "earlier.json does not fit first, pattern areas: its methods had other colour or depth"),
        (["--seed", "1", "--pattern", "random"], "earlier.json has no rows of first, pattern random"),
        (["--seed", "1", "--methods", "telea,polynomial"], "earlier.json has no rows of the peers to compare"),
    ],
)
def test_an_earlier_result_that_does_not_fit_is_refused(two_frames, earlier, capsys, arguments, message):
    rest = ["--pattern", "areas", "--methods", "nearest", *arguments, "--peers-from", str(earlier)]
    assert main(["bench", str(two_frames), *rest]) == 1
    assert message in capsys.readouterr().err


def test_other_depth_and_other_files_are_refused(two_frames, earlier, tmp_path, capsys):
    arguments = ["--pattern", "areas", "--methods", "nearest", "--seed", "1", "--peers-from"]
    (tmp_path / "old.json").write_text('{"rows": [{"frame": "first"}]}')
    assert main(["bench", str(two_frames), *arguments, str(tmp_path / "old.json")]) == 1
    assert "old.json is not a result of `ilf bench --json` of this version" in capsys.readouterr().err
    depth = cv2.imread(str(two_frames / "second" / "depth.png"), cv2.IMREAD_UNCHANGED)
    depth[depth > 0] += 1
    cv2.imwrite(str(two_frames / "second" / "depth.png"), depth)
    assert main(["bench", str(two_frames), *arguments, str(earlier)]) == 1
    assert "does not fit second, pattern areas" in capsys.readouterr().err


# the command


def without_seconds(items):
    return [{key: value for key, value in item.items() if "seconds" not in key} for item in items]


def test_command_end_to_end(two_frames, tmp_path, capsys):
    shutil.copytree(two_frames / "first", two_frames / "broken")
    (two_frames / "broken" / "depth.png").write_bytes(b"no image")
    files = ["--csv", str(tmp_path / "a.csv"), "--json", str(tmp_path / "a.json")]
    arguments = ["bench", str(two_frames), "--pattern", "random,areas,ground-truth"]
    assert main([*arguments, *files]) == 0
    captured = capsys.readouterr()
    warnings = captured.err.splitlines()
    assert len(warnings) == 2
    assert warnings[0].startswith("ilf: warning: skipped: broken. ")
    assert (
        warnings[1]
        == "ilf: warning: skipped for pattern ground-truth: first. There is no measured or exact ground truth."
    )
    tables = [part.splitlines() for part in captured.out.split("\n\n")]
    whats = ("", ", frame by frame", ", expected error")
    assert [lines[0].split(":")[0] for lines in tables] == [
        pattern + what for pattern in ("random", "areas", "ground-truth") for what in whats
    ]
    for lines in tables[::3]:
        rmse = [float(line.split()[1].rstrip("*")) for line in lines[2:]]
        assert len(rmse) == len(METHODS)
        assert rmse == sorted(rmse)
        assert lines[2].split()[1].endswith("*")

    content = json.loads((tmp_path / "a.json").read_text())
    assert set(content["presets"]) == set(PRESETS)
    assert len(content["rows"]) == len(METHODS) * 5
    assert [item["frame"] for item in content["skipped"]] == ["broken", "first"]
    with open(tmp_path / "a.csv", newline="") as stream:
        lines = list(csv.DictReader(stream))
    assert [(line["pattern"], line["method"]) for line in lines] == [
        (line["pattern"], line["method"]) for line in content["table"]
    ]
    assert float(lines[0]["rmse_mm"]) == content["table"][0]["rmse_mm"]
    assert float(lines[0]["within"]) == content["table"][0]["within"]
    assert all("within" in tables[2][1] and row["within"] is not None for row in content["rows"])
    assert [(task["pattern"], task["frame"], task["sensor"]) for task in content["tasks"]] == [
        *((pattern, frame, frame) for pattern in ("random", "areas") for frame in ("first", "second")),
        ("ground-truth", "second", "second"),
    ]


def test_jobs_change_nothing_but_the_seconds(two_frames, tmp_path, capsys):
    contents = []
    for jobs in ("1", "2"):
        arguments = ["bench", str(two_frames), "--methods", "nearest,linear,polynomial", "--jobs", jobs]
        assert main([*arguments, "--json", str(tmp_path / f"{jobs}.json"), "--progress"]) == 0
        contents.append(json.loads((tmp_path / f"{jobs}.json").read_text()))
    assert "4/4" in capsys.readouterr().err
    assert without_seconds(contents[0]["rows"]) == without_seconds(contents[1]["rows"])


def test_limit_and_seed(two_frames, tmp_path, capsys):
    rows = []
    for seed in ("0", "1"):
        file = tmp_path / f"{seed}.json"
        arguments = ["--limit", "1", "--seed", seed, "--methods", "laplace", "--pattern", "areas", "--json", str(file)]
        assert main(["bench", str(two_frames), *arguments, "--progress"]) == 0
        assert "1/1 frames and patterns" in capsys.readouterr().err
        rows.append(json.loads(file.read_text())["rows"])
    assert [row["frame"] for row in rows[0]] == ["first"]
    assert rows[0][0]["rmse"] != rows[1][0]["rmse"]


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["missing"], 1, "missing is not a folder"),
        (["empty"], 1, "none of its folders has one"),
        (
            ["frames", "--pattern", "stripes"],
            1,
            "no pattern 'stripes'. Known: random, areas, ground-truth, points, lines.",
        ),
        (["frames", "--pattern", ","], 1, "The list has no pattern"),
        (["frames", "--methods", "cubic"], 1, "There is no method 'cubic'"),
        (["frames", "--limit", "0"], 2, "'0' is not an integer of at least 1"),
        (["frames", "--seed", "-1"], 2, "--seed"),
        (["frames/first", "--pattern", "ground-truth"], 1, "No frame could be scored"),
        (["frames", "--methods", "nearest", "--csv", "no/such.csv"], 1, "Could not write no/such.csv"),
    ],
)
def test_what_cannot_be_done_is_one_line(two_frames, tmp_path, monkeypatch, capsys, arguments, status, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    try:
        found = main(["bench", *arguments])
    except SystemExit as stopped:
        found = stopped.code
    assert found == status
    assert message in capsys.readouterr().err.splitlines()[-1]
