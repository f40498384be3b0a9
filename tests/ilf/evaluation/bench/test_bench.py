"""`ilf bench`: how completion is scored and summarised over frames."""

import csv
import io
import itertools
import json
import shutil
from contextlib import redirect_stdout

import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.completion.confidence.expected_error import depth_error
from ilf.errors import InputError
from ilf.evaluation.bench.frames import BenchFrame, find_frames, make_task
from ilf.evaluation.bench.methods import METHODS
from ilf.evaluation.bench.results import against_peers, summarise
from ilf.evaluation.bench.runner import run_bench, score


@pytest.fixture(autouse=True)
def quick_presets(monkeypatch):
    """Presets as they are, but of few iterations."""
    for name in ilf.PRESETS:
        quick = ilf.preset(name, max_iterations=30)
        run = lambda frame, labels, quick=quick: ilf.complete(frame, labels, quick).depth  # noqa: E731
        monkeypatch.setitem(METHODS, name, run)


def run_command(folder, *arguments, json_file):
    with redirect_stdout(io.StringIO()) as printed:
        assert main(["bench", str(folder), *arguments, "--json"]) == 0
    json_file.write_text(printed.getvalue())
    return json.loads(printed.getvalue())


def test_what_a_method_leaves_open_counts_with_the_nearest_known_depth():
    rows, columns = np.mgrid[:40, :60].astype(np.float64)
    plane = 1.5 + 0.004 * rows + 0.006 * columns
    frame = ilf.RGBDFrame(np.zeros((40, 60, 3), np.uint8), plane, name="plane")
    task = make_task(BenchFrame(frame, None), "areas")
    left_open, nearest = score(task.frame.depth, task), score(METHODS["nearest"](task.frame, None), task)
    assert (left_open.coverage, left_open.within) == (0.0, None)
    assert left_open.rmse == nearest.rmse > 0
    perfect = score(plane, task)
    assert (perfect.coverage, perfect.within, perfect.rmse) == (1.0, 1.0, pytest.approx(0, abs=1e-6))
    left = task.scored & (columns < 30)
    off = np.where(columns < 30, plane + 0.01, np.nan)
    found = score(off, task)
    assert found.coverage == pytest.approx(left.sum() / task.scored.sum())
    assert found.within == pytest.approx(np.mean(depth_error(task.frame, off)[left] >= 0.01), abs=1e-6)
    assert 0 < found.within < 1


def test_a_method_that_fails_counts_as_nothing_filled(two_frames, monkeypatch):
    def too_large(frame, labels):
        raise InputError("too large")

    monkeypatch.setitem(METHODS, "linear", too_large)
    result = run_bench([two_frames / "first"], ["areas"], ["linear", "nearest"])
    failed, nearest = result.rows
    assert (failed.failure, failed.coverage, failed.rmse) == ("too large", 0.0, nearest.rmse)
    assert {line["method"]: line["failures"] for line in summarise(result)} == {"linear": 1, "nearest": 0}


def test_frames_are_compared_one_by_one_with_the_best_peer_of_each(two_frames):
    (two_frames / "first" / "meta.json").write_text('{"name": "first", "depth_units_per_m": 1000, "sensor": "one"}')
    result = run_bench(find_frames([two_frames]), ["areas"], ["best", "paper", "nearest", "laplace", "polynomial"])
    assert [row.sensor for row in result.rows if row.method == "best"] == ["one", "second"]
    lines = {line["method"]: line for line in summarise(result)}
    for measure in ("rmse", "mae"):
        errors = {
            name: np.array([getattr(row, measure) for row in result.rows if row.method == name]) for name in lines
        }
        best_peer = np.min([errors[name] for name in lines if name not in ilf.PRESETS], axis=0)
        for name, line in lines.items():
            ratios = errors[name] / best_peer
            assert line[f"{measure}_mm"] == pytest.approx(1000 * errors[name].mean())
            assert line[f"{measure}_geometric_mm"] == pytest.approx(1000 * np.sqrt(errors[name].prod()))
            assert line[f"{measure}_ratio"] == pytest.approx(np.sqrt(ratios.prod()))
            assert line[f"{measure}_wins"] == (ratios <= 1).sum()
            # of two sensors, both are drawn half of the time, and either of them twice a quarter of it
            assert line[f"{measure}_low_95"] == pytest.approx(ratios.min())
            assert line[f"{measure}_high_68"] == pytest.approx(ratios.max())
    shares = [row.within for row in result.rows if row.method == "best"]
    assert lines["best"]["calibrated"] == np.mean([0.55 <= share <= 0.80 for share in shares])
    assert lines["laplace"]["extraction_seconds"] is None
    assert lines["polynomial"]["extraction_seconds"] > 0


def test_without_peers_nothing_is_compared_with_them(two_frames):
    (line,) = summarise(run_bench([two_frames / "first"], ["areas"], ["best"]))
    assert line["rmse_ratio"] is line["mae_wins"] is line["rmse_low_68"] is None
    assert line["rmse_geometric_mm"] == pytest.approx(line["rmse_mm"])


def test_intervals_are_of_whole_sensors():
    errors, best, sensors = [0.1, 0.2, 0.4, 1.0, 0.0], [0.1, 0.1, 0.1, 0.5, 1e-6], ("a", "a", "a", "b", "c")
    found = against_peers(errors, best, sensors)
    assert found == against_peers(errors, best, sensors)
    assert (found["ratio"], found["wins"]) == (pytest.approx(16 ** (1 / 5)), 2)
    logarithms = np.log([1, 2, 4, 2, 1])
    every = [
        np.exp(np.concatenate([logarithms[np.array(sensors) == name] for name in drawn]).mean())
        for drawn in itertools.product("abc", repeat=3)
    ]
    assert (found["low_95"], found["high_95"]) == (pytest.approx(min(every)), pytest.approx(max(every)))
    assert found["low_95"] <= found["low_68"] < found["ratio"] < found["high_68"] <= found["high_95"]
    assert against_peers([0.1, 0.2], [0.1, 0.1], ("a", "a"))["low_68"] is None


def test_the_command_prints_tables_and_writes_files(two_frames, tmp_path, capsys, cli):
    shutil.copytree(two_frames / "first", two_frames / "broken")
    (two_frames / "broken" / "depth.png").write_bytes(b"no image")
    arguments = ["--pattern", "random,ground-truth", "--csv", str(tmp_path / "a.csv")]
    content = run_command(two_frames, *arguments, json_file=tmp_path / "a.json")
    capsys.readouterr()
    captured = cli("bench", two_frames, *arguments)
    broken, without_truth = captured.err.splitlines()
    assert broken.startswith("ilf: warning: skipped: broken. ")
    assert without_truth.startswith("ilf: warning: skipped for pattern ground-truth: first. ")
    tables = [part.splitlines() for part in captured.out.split("\n\n")]
    assert [lines[0].split(":")[0] for lines in tables] == [
        pattern + what
        for pattern in ("random", "ground-truth")
        for what in ("", ", frame by frame", ", expected error")
    ]
    for lines in tables[::3]:
        errors = [float(line.split()[1].rstrip("*")) for line in lines[2:]]
        assert len(errors) == len(METHODS)
        assert errors == sorted(errors)
        assert lines[2].split()[1].endswith("*")
    assert set(content["presets"]) == set(ilf.PRESETS)
    assert len(content["rows"]) == len(METHODS) * 3
    assert [item["frame"] for item in content["skipped"]] == ["broken", "first"]
    assert [(row["pattern"], row["frame"], row["sensor"]) for row in content["rows"] if row["method"] == "best"] == [
        *(("random", frame, frame) for frame in ("first", "second")),
        ("ground-truth", "second", "second"),
    ]
    with open(tmp_path / "a.csv", newline="") as stream:
        lines = list(csv.DictReader(stream))
    assert [line["method"] for line in lines] == [line["method"] for line in content["table"]]
    assert float(lines[0]["rmse_mm"]) == pytest.approx(content["table"][0]["rmse_mm"], rel=1e-12)


def test_a_seed_hides_other_depth_and_the_same_each_time(two_frames, tmp_path):
    arguments = ["--pattern", "random", "--methods", "nearest", "--limit", "1"]
    found = [
        [
            {name: value for name, value in row.items() if "seconds" not in name}
            for row in run_command(two_frames, *arguments, "--seed", seed, json_file=tmp_path / "a.json")["rows"]
        ]
        for seed in ("1", "1", "2")
    ]
    assert found[0] == found[1] != found[2]


def test_the_first_frames_may_be_enough(two_frames, tmp_path, capsys):
    arguments = ["--methods", "nearest", "--limit", "1", "--progress"]
    rows = run_command(two_frames, *arguments, json_file=tmp_path / "a.json")["rows"]
    assert {row["frame"] for row in rows} == {"first"}
    assert "2/2 frames and patterns" in capsys.readouterr().err
