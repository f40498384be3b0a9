"""The experiments: what they measure, that they can be repeated, what is written, and what is said about it."""

import csv
import json
import math
import re
import shutil
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ilf import CameraIntrinsics, RGBDFrame
from ilf.cli import main
from ilf.data.results import IterationRecord
from ilf.errors import Cancelled, FormatError, InputError, ParameterError
from ilf.evaluation.hold_out import RANDOM_KEPT
from ilf.lab.experiments import convergence, cylinder, limits, registry, sphere, table
from ilf.lab.experiments.experiment import Settings
from ilf.lab.experiments.files import read_result, rendered, write_result
from ilf.lab.experiments.plots import compared_with_paper, spans, won_rates
from ilf.lab.experiments.real import cloud_picture
from ilf.lab.experiments.registry import EXPERIMENTS, run_experiment, selected_experiments
from ilf.lab.experiments.report import write_report
from ilf.lab.experiments.spots import find_spot, with_spot
from ilf.lab.experiments.surfaces import (
    POLYNOMIALS,
    Case,
    Surface,
    continuous_defect,
    inlier_polynomial,
    run_case,
    sensed,
)

from ..small_frames import write_small_frame

SPHERE = Surface("sphere", (30, 60), (1.2, 2.6), 2.0, 2.0)
NAMES = ["convergence", "cylinder", "sphere", "cylinder-noise", "unknowns", "real", "table", "limits"]


@pytest.fixture(scope="module")
def tiny():
    """Quick runs on grids of a few pixels."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        for module in (cylinder, sphere, limits):
            monkeypatch.setattr(module, "_QUICK_SHAPE", (24, 32))
        monkeypatch.setattr(cylinder, "_QUICK_RATES", (0.0, 0.4))
        monkeypatch.setattr(sphere, "_QUICK_RATES", (0.0, 0.4))
        monkeypatch.setattr(limits, "_QUICK_RATES", (0.2, 0.6))
        yield


@pytest.fixture(scope="module")
def results(tiny):
    """The quick runs of seed 0 by name; each is run once."""
    return cache(lambda name: run_experiment(name, Settings(quick=True)))


@pytest.fixture
def already_run(results, monkeypatch):
    """Makes the command take the results that there are."""

    def take(name):
        result = results(name)
        known = replace(EXPERIMENTS[name], run=lambda settings, on_progress: result)
        monkeypatch.setitem(registry.EXPERIMENTS, name, known)

    return take


@pytest.fixture(scope="module")
def sphere_result(results):
    return results("sphere")


@pytest.fixture(scope="module")
def sphere_files(sphere_result, tmp_path_factory):
    """A folder with the stored result; to be copied."""
    folder = tmp_path_factory.mktemp("sphere")
    files = write_result(sphere_result, EXPERIMENTS["sphere"], folder)
    assert sorted(files) == sorted(folder.iterdir())
    return folder


@pytest.fixture
def two_frames(tmp_path):
    for name in ("first", "second"):
        folder = tmp_path / "frames" / name
        write_small_frame(folder)
        (folder / "meta.json").write_text(json.dumps({"name": name, "depth_units_per_m": 1000, "sensor": name}))
    return tmp_path / "frames"


def timeless(rows):
    return [{name: value for name, value in row.items() if name != "seconds"} for row in rows]


# surfaces and the peer


def test_surfaces_are_where_they_should_be():
    depth = SPHERE.depth
    # every point is one radius away from the middle of the sphere
    y, x = np.meshgrid(np.linspace(-0.6, 0.6, 30), np.linspace(-1.3, 1.3, 60), indexing="ij")
    assert np.hypot(np.hypot(x, y), depth - 4.0) == pytest.approx(2.0)
    assert depth.min() == pytest.approx(2.0, abs=0.001)
    upright = replace(SPHERE, kind="upright cylinder").depth
    assert np.ptp(upright, axis=0).max() == 0 < np.ptp(upright, axis=1).min()
    assert np.ptp(replace(SPHERE, kind="plane").depth) == 0


@pytest.mark.parametrize(("along", "axis"), [("x", 1), ("y", 0)])
def test_a_continuous_defect_is_one_gap_of_its_rate(along, axis):
    for rate in (0.0, 0.2, 0.5, 1.0):
        defect = continuous_defect((30, 60), rate, along)
        inside = defect.all(axis=1 - axis)
        assert np.array_equal(inside, defect.any(axis=1 - axis))
        assert np.count_nonzero(np.diff(inside.astype(int))) == (2 if rate else 0)
        assert defect.mean() == pytest.approx(min(rate, 1 - 2 / defect.shape[axis]))


def test_noise_follows_from_the_seed_and_not_from_the_defect():
    none, some = continuous_defect(SPHERE.shape, 0, "x"), continuous_defect(SPHERE.shape, 0.4, "x")
    first, second = sensed(SPHERE, 0.065, none, 1), sensed(SPHERE, 0.065, some, 1)
    assert np.array_equal(first.depth[~some], second.depth[~some])
    assert np.std(first.depth - SPHERE.depth) == pytest.approx(0.065, rel=0.1)
    assert not np.array_equal(first.depth, sensed(SPHERE, 0.065, none, 2).depth)


def test_the_peer_finds_a_polynomial_under_outliers():
    rows, columns = np.mgrid[:40, :50] / 50
    ground_truth = 2 + rows - 0.5 * columns + 0.8 * rows * columns - 0.3 * columns**2
    depth = ground_truth.copy()
    rng = np.random.default_rng(0)
    depth[rng.random(depth.shape) < 0.2] += 0.5
    depth[:, 15:35] = np.nan
    block = np.ones(depth.shape, bool)
    block[:, :3] = False
    depth[:, :3] = 9
    found, rounds = inlier_polynomial(depth, block, 2)
    assert np.abs(found - ground_truth).max() < 1e-9
    assert rounds > 1
    assert np.abs(inlier_polynomial(depth, block, 1)[0] - ground_truth).max() > 0.02
    plain, rounds = inlier_polynomial(depth, block, 2, math.inf)
    assert rounds == 1
    assert np.abs(plain - ground_truth).max() > 0.02, "every point counts"
    depth[:] = np.nan
    depth[0, 10:40] = 2.0
    assert np.isnan(inlier_polynomial(depth, block, 2)[0]).all(), "one row does not determine it"


def test_errors_are_those_of_the_block_and_of_its_defective_area():
    case = Case(SPHERE, 0.0, 0.4, "x", "fill", 0)
    (row,) = run_case(case, ["nearest"])
    ground_truth, defect = SPHERE.depth, continuous_defect(SPHERE.shape, 0.4, "x")
    left = np.flatnonzero(defect[0])[0]
    columns = np.arange(60)
    middle = columns[defect[0]].mean()
    near = np.where(columns < middle, left - 1, 59 - left + 1)
    error = 1000 * np.where(defect, ground_truth[:, near] - ground_truth, 0)
    assert row["defect_rate"] == 0.4
    assert row["acc_mm"] == pytest.approx(error.mean(), abs=1e-3)
    assert row["prs_mm"] == pytest.approx(error.std(), abs=1e-3)
    assert row["hole_acc_mm"] == pytest.approx(error[defect].mean(), abs=1e-3)
    assert row["hole_rmse_mm"] == pytest.approx(math.hypot(row["hole_acc_mm"], row["hole_prs_mm"]))
    (whole,) = run_case(replace(case, rate=0.0), ["best"])
    assert whole["hole_prs_mm"] is None
    assert whole["prs_mm"] < 0.01


# single experiments


def test_glitches_are_rises_of_l1_where_the_band_grows():
    l1 = [10.0, 12.0, 13.0, 16.0, 15.0, 15.5, 15.2, 15.1]
    stages = [1, 1, 1, 2, 2, 3, 3, 4]
    sigma = [9.0, 5.0, 4.0, 7.0, 3.0, 2.0, 1.0, 0.5]
    records = [
        IterationRecord(i + 1, stage, s, value, 0.0, math.nan, 0.0)
        for i, (stage, s, value) in enumerate(zip(stages, sigma, l1, strict=True))
    ]
    enlarged, glitches, sigma_jumps = convergence._events(records)
    assert enlarged == [3, 5, 7]
    assert glitches == {3, 5}
    assert sigma_jumps == [3]
    assert convergence._count_recovered(records, enlarged, glitches) == 2
    assert convergence._count_recovered(records[:4], [3], {3}) == 0


def test_the_selective_mean_takes_won_blocks_only():
    def block(method, number, pixels, rmse):
        values = {"rmse_mm": rmse, "mae_mm": rmse / 2, "rel": rmse / 1000}
        return {"method": method, "block": number, "pixels": pixels, **values}

    mine = [block("paper", 1, 100, 10.0), block("paper", 2, 300, 50.0)]
    theirs = [block("nearest", 1, 100, 40.0), block("nearest", 2, 300, 20.0)]
    part = table._Part((*mine, *theirs), (("paper", 1.0), ("nearest", 2.0)), 1.0)
    fair, peer, chosen = table._summaries("random", [part], ["paper", "nearest"])
    assert fair["rmse_mm"] == pytest.approx(math.sqrt((100 * 10**2 + 300 * 50**2) / 400))
    assert peer["mae_mm"] == pytest.approx(12.5)
    assert fair["rel"] == pytest.approx(0.04)
    assert fair["rel_unweighted"] == pytest.approx(0.03)
    assert chosen["scope"] == table.SELECTIVE
    assert (chosen["blocks"], chosen["share_won"]) == (1, 0.5)
    assert (chosen["rmse_mm"], chosen["peer_rmse_mm"]) == (10.0, 40.0)


def test_the_table_counts_the_hidden_pixels_of_all_blocks(two_frames):
    result = run_experiment("table", Settings(data=two_frames, quick=True))
    fair = [row for row in result.rows if row["scope"] == table.ALL_BLOCKS]
    assert {row["pattern"] for row in fair} == {"random", "areas"}, "none has a measured truth"
    assert {row["frames"] for row in fair} == {2}
    blocks = [row for row in result.tables["blocks"] if row["pattern"] == "random" and row["method"] == "best"]
    (best,) = (row for row in fair if row["pattern"] == "random" and row["method"] == "best")
    assert best["blocks"] == len(blocks)
    assert best["pixels"] == sum(row["pixels"] for row in blocks)
    assert best["rmse_mm"] ** 2 == pytest.approx(
        sum(row["pixels"] * row["rmse_mm"] ** 2 for row in blocks) / best["pixels"]
    )
    known = 2 * np.isfinite(load_depth(two_frames / "first")[::2, ::2]).sum()
    assert best["pixels"] / best["share_of_hidden"] == pytest.approx((1 - RANDOM_KEPT) * known, abs=3)


def load_depth(folder):
    from ilf import load_frame

    return load_frame(folder).depth


def test_the_spot_is_15_cm_at_its_depth():
    rows, columns = np.mgrid[:120, :160]
    depth = np.where(columns < 80, 1.0 + 0.001 * rows, 2.0 + 0.2 * np.sin(rows / 2) * np.sin(columns / 2))
    depth[:, 78:82] = np.nan
    frame = RGBDFrame(np.full((120, 160, 3), 90, np.uint8), depth, CameraIntrinsics(200, 200, 79.5, 59.5))
    spot = find_spot(frame)
    assert spot.column < 78, "it is smooth there only"
    assert 2 * spot.radius / spot.focal * spot.depth == pytest.approx(0.15)
    gapped = with_spot(frame, spot, glare=True)
    hole = frame.known & ~gapped.known
    assert np.count_nonzero(hole) == pytest.approx(math.pi * spot.radius**2, rel=0.05)
    assert gapped.rgb[spot.row, spot.column].min() == 255
    assert np.array_equal(with_spot(frame, spot, glare=False).rgb, frame.rgb)
    with pytest.raises(InputError, match="No place of 15 cm"):
        find_spot(RGBDFrame(frame.rgb, np.where((rows + columns) % 5 == 0, 1.0, np.nan)))


def test_real_frames_are_one_of_every_sensor(two_frames):
    result = run_experiment("real", Settings(data=two_frames, quick=True))
    assert {row["sensor"] for row in result.rows} == {"first", "second"}
    completed = [row for row in result.rows if row["part"] == "completed"]
    assert all(row["recovered"] == 1 for row in completed if row["method"] == "best")
    assert any("nominal focal length" in note for note in result.notes)
    assert result.pictures["first/depth/best"].dtype == np.uint8


def test_without_data_the_sample_is_taken_and_named_as_such():
    from ilf.lab.experiments.sources import find_sources

    sources = find_sources(Settings())
    assert [source.name for source in sources.frames] == ["room"]
    assert "Only the bundled sample" in sources.notes[0]


# running, writing, reporting


def test_the_same_seed_gives_the_same_numbers_and_progress_counts_to_the_end(results):
    for name in ("cylinder", "limits"):
        seen = []
        again = run_experiment(name, Settings(quick=True), seen.append)
        assert timeless(results(name).rows) == timeless(again.rows)
        assert [progress.done for progress in seen] == list(range(seen[0].total + 1))


def test_another_seed_gives_other_numbers(results, monkeypatch):
    monkeypatch.setattr(cylinder, "_QUICK_RATES", (0.4,))
    monkeypatch.setattr(limits, "_QUICK_RATES", (0.2,))
    for name in ("cylinder", "limits"):
        other = run_experiment(name, Settings(quick=True, seed=4))
        rows, own = (result.tables.get("steps", result.rows) for result in (other, results(name)))
        assert not {row["rmse_mm"] for row in rows} <= {row["rmse_mm"] for row in own}


def test_progress_can_stop_the_run(tiny):
    def stop(progress):
        if progress.done == 1:
            raise Cancelled("stopped")

    with pytest.raises(Cancelled):
        run_experiment("cylinder", Settings(quick=True), stop)


def test_results_are_written_and_read_again(sphere_result, sphere_files, tmp_path):
    result = sphere_result
    shutil.copytree(sphere_files, tmp_path, dirs_exist_ok=True)
    content = json.loads((tmp_path / "sphere.json").read_text())
    assert {"experiment", "parameters", "seed", "seconds", "rows", "version"} <= set(content)
    for row in content["rows"]:
        assert {"method", "defect_rate", "acc_mm", "prs_mm", "rmse_mm"} <= set(row)
    with open(tmp_path / "sphere.csv", newline="") as file:
        lines = list(csv.DictReader(file))
    assert [float(line["rmse_mm"]) for line in lines] == [row["rmse_mm"] for row in result.rows]
    stored = read_result(tmp_path / "sphere.json")
    assert stored.rows == content["rows"]
    assert [(tmp_path / f"{figure.stem}.png").is_file() for figure in stored.figures] == [True, True]
    curves, _ = EXPERIMENTS["sphere"].draw(result)
    for form in ("png", "svg"):
        assert rendered(curves, form) == (tmp_path / f"sphere-curves.{form}").read_bytes()
    (tmp_path / "sphere.json").write_text('{"experiment": "sphere"}')
    with pytest.raises(FormatError, match="Run the experiment again"):
        read_result(tmp_path / "sphere.json")


def test_the_report_stands_alone(results, tmp_path):
    for name in ("cylinder", "limits"):
        write_result(results(name), EXPERIMENTS[name], tmp_path)
    (tmp_path / "docs").mkdir()
    page, text = write_report(tmp_path, markdown_file=tmp_path / "docs" / "experiments.md")
    html = page.read_text()
    assert html.count("data:image/png;base64,") == 2
    assert not re.search(r"(src|href)=\"(?!data:|#)", html)
    assert "numbers are not reliable" in html
    assert "10.28 mm" in html
    markdown = text.read_text()
    assert "Not run: convergence, sphere, cylinder-noise, unknowns, real, table." in markdown
    for image in re.findall(r"\]\((.*?\.png)\)", markdown):
        assert (text.parent / image).is_file()


def test_what_is_said_follows_from_the_numbers():
    assert compared_with_paper(5.0, 10.0) == "lower than in the paper, by a factor of 2.0"
    assert compared_with_paper(12.0, 10.0) == "higher than in the paper, by 20 %"
    assert compared_with_paper(10.2, 10.0) == "about as in the paper"
    rates = (0.0, 0.2, 0.4, 0.6)
    assert spans([0.0, 0.2, 0.6], rates) == "0-20 %, 60 %"
    assert spans([], rates) == "none"

    def rows(mine, theirs):
        values = dict.fromkeys(("paper", "best"), mine) | dict.fromkeys(("released-code", *POLYNOMIALS), theirs)
        return [
            {"method": method, "defect_rate": rate, "rmse_mm": value, "hole_rmse_mm": value if rate else None}
            for method in values
            for rate, value in zip(rates, values[method], strict=True)
        ]

    ahead, behind = rows([1, 1, 1, 1], [2, 2, 2, 2]), rows([2, 1, 2, 2], [1, 2, 1, 1])
    assert won_rates(ahead, "paper", ["polynomial-1"]) == list(rates)
    assert "the claim holds:" in cylinder.compare_wins(ahead, "here", 0.4)[0].text
    part = cylinder.compare_wins(behind, "here", 0.4)[0]
    assert "holds in part only" in part.text
    assert "In the defective area alone it is the lowest at 1 of 2." in part.text
    assert part.ours == "20 %"


def test_all_experiments_are_there_by_name():
    assert list(EXPERIMENTS) == NAMES
    assert selected_experiments("all") == NAMES
    assert selected_experiments("table, real") == ["table", "real"]
    with pytest.raises(ParameterError, match="no experiment 'cube'"):
        selected_experiments("cube")
    with pytest.raises(ParameterError, match="no experiment 'all'"):
        run_experiment("all")


# the command


def test_the_command_runs_lists_and_reports(tiny, already_run, tmp_path, capsys):
    already_run("cylinder-noise")
    assert main(["experiments", "list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == NAMES
    out = str(tmp_path / "out")
    assert main(["experiments", "run", "cylinder,cylinder-noise", "--quick", "--out", out]) == 0
    assert "cylinder.json" in capsys.readouterr().out
    assert main(["experiments", "report", "--out", out]) == 0
    assert (tmp_path / "out" / "report.html").is_file()


def test_interrupting_leaves_what_is_finished(already_run, tmp_path, capsys, monkeypatch):
    already_run("cylinder")

    def interrupted(settings, on_progress):
        raise KeyboardInterrupt

    monkeypatch.setitem(registry.EXPERIMENTS, "limits", replace(EXPERIMENTS["limits"], run=interrupted))
    assert main(["experiments", "run", "cylinder,limits", "--quick", "--out", str(tmp_path)]) == 130
    assert read_result(tmp_path / "cylinder.json").rows
    assert not list(tmp_path.glob("limits*"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "cube"], "There is no experiment 'cube'"),
        (["run", "table", "--data", "nowhere"], "is not a folder"),
        (["run", "table", "--split", "splits.mat"], "Give that file as the data"),
        (["report", "--out", "."], "has no results of experiments"),
    ],
)
def test_mistakes_are_told_in_one_line(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["experiments", *arguments]) == 1
    error = capsys.readouterr().err
    assert message in error
    assert len(error.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_clouds_are_pictured_from_above():
    """A floor 1 m below the camera: from above its far end lies higher in the picture than its near end."""
    rows = np.mgrid[:60, :80][0]
    depth = np.where(rows >= 35, 60.0 / np.maximum(rows - 29.5, 1), np.nan).astype(np.float32)
    far = depth > 4
    rgb = np.where(far[..., None], [200, 0, 0], [0, 0, 200]).astype(np.uint8)
    picture = cloud_picture(RGBDFrame(rgb, depth), depth, 60.0, 160)
    assert picture.shape == (120, 160, 3)
    np.testing.assert_array_equal(picture[0, 0], [250, 250, 250])
    red = np.nonzero((picture[..., 0] > 60) & (picture[..., 2] == 0))[0]
    blue = np.nonzero((picture[..., 2] > 60) & (picture[..., 0] == 0))[0]
    assert red.size > 50 < blue.size
    assert np.median(red) < np.median(blue) - 10


def stored_with(folder, **changes):
    """A stored result of which some things are not as they were written."""
    path = folder / "sphere.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def test_a_result_of_someone_else_reaches_nothing_beside_it(sphere_files, tmp_path):
    inside, docs = shutil.copytree(sphere_files, tmp_path / "results"), tmp_path / "docs" / "experiments.md"
    docs.parent.mkdir()
    (tmp_path / "secret.png").write_bytes((inside / "sphere-curves.png").read_bytes())
    before = (inside / "sphere.json").read_text()
    for stem in ("../secret", "/etc/x", "a/../../secret", "..", "x" * 5000, 7):
        stored_with(inside, figures=[{"stem": stem, "caption": "c", "shows_data": False}])
        with pytest.raises(FormatError, match="is not the result of an experiment"):
            write_report(inside, markdown_file=docs)
    (inside / "sphere.json").write_text(before)
    for changes in ({"experiment": "cylinder"}, {"notes": "text"}, {"title": 7}, {"rows": [{"method": "best"}]}):
        (inside / "sphere.json").write_text(before)
        stored_with(inside, **changes)
        with pytest.raises(FormatError):
            write_report(inside, markdown_file=docs)
    assert not docs.exists()
    assert not (inside / "report.html").exists()


def test_a_result_is_shown_as_text(sphere_files, tmp_path):
    shutil.copytree(sphere_files, tmp_path, dirs_exist_ok=True)
    evil = "<img src=x onerror=alert(1)> [a](http://b) | `code`\n# c"
    stored_with(tmp_path, title=evil, about=evil, notes=[evil], source=evil)
    page, text = (path.read_text() for path in write_report(tmp_path, markdown_file=tmp_path / "a.md"))
    assert "<img src=x" not in page
    assert "[a](" not in text
    assert "<img" not in text.replace(r"\<img", "")
    assert "\n# c" not in text
    assert "`code`" in text
