"""The command line where it evaluates: ground truth, `ilf evaluate`, presets from files."""

import csv
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf._runtime.installation import asset_path
from ilf._runtime.long_work import run_to_end
from ilf.cli import main
from ilf.cli.output import completion_record, completion_report, errors_of
from ilf.data.parameters import BlockParameters
from ilf.data.presets import UserPreset, write_preset
from ilf.evaluation.evaluation import evaluate_completion
from ilf.evaluation.hold_out import HoldOutTest, compared_steps, evaluate_hold_out, hold_out_steps
from ilf.evaluation.sweep import Sweep, run_sweep

from ..small_frames import write_small_frame
from .test_cli import QUICK, fails


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Colour and depth file, and the truth in 0.2 mm, relative to the working directory."""
    monkeypatch.chdir(tmp_path)
    write_small_frame(tmp_path / "in")
    rows, columns = np.mgrid[:60, :80]
    ground_truth = np.where(columns < 40, 1500 + 4 * rows, 2600 + 3 * columns) + 10
    cv2.imwrite("in/gt.png", (5 * ground_truth).astype(np.uint16))
    return ["in/rgb.png", "in/depth.png"]


GROUND_TRUTH = ["--ground-truth", "in/gt.png", "--ground-truth-units", "5000"]


def figures(text: str, name: str) -> list[str]:
    """The cells of a line of a table that begins so."""
    return next(line.split() for line in text.splitlines() if line.startswith(name))


def test_complete_tells_the_error_against_the_truth(files, cli):
    text = cli("complete", *files, *GROUND_TRUTH, "--no-cloud", "--out", "out", *QUICK).out
    frame = ilf.load_frame(*files, ground_truth="in/gt.png", ground_truth_units=5000)
    run = ilf.Run.of(frame, preset=ilf.preset(max_iterations=25))
    evaluation = evaluate_completion(frame, run.complete())
    assert f"over {evaluation.pixels} filled pixels: median error {1000 * evaluation.median:.2f} mm, MAE " in text
    assert f", RMSE {1000 * evaluation.rmse:.2f} mm" in text
    assert "sigma [mm]  RMSE [mm]" in text
    assert json.loads(Path("out/run.json").read_text())["inputs"]["ground_truth"]["units"] == 5000
    assert main(["complete", "--replay", "out/run.json", "--out", "again", "--quiet"]) == 0
    assert Path("again/curves.csv").read_bytes() == Path("out/curves.csv").read_bytes()
    assert "gt.png, 5000 units per metre" in cli("info", "out/run.json").out


@pytest.fixture(scope="module")
def room():
    """The bundled sample, its run and the completion."""
    run = ilf.Run.of(ilf.load_frame(asset_path("samples/room")))
    return run, run.complete()


def report_of(completion):
    """The text that `ilf complete` prints of a completion."""
    errors = errors_of(completion)
    record = completion_record(completion, errors, 1.0, folder="out", files=[], exports=[])
    return completion_report(completion, errors, record)


def test_the_first_report_of_the_sample_is_short_and_tells_what_was_not_scored(room):
    run, completion = room
    lines = report_of(completion).splitlines()
    limited = [label for label, outcome in completion.outcomes.items() if outcome.message]
    assert len(limited) > 5
    remark = "Stopped at the limit of steps before it was steady"
    (line,) = [line for line in lines if remark in line]
    assert line.startswith(f"{len(limited)} blocks ({', '.join(map(str, limited))}): {remark}")
    missing, unknown = run.frame.missing.sum(), (run.frame.missing & np.isnan(run.frame.ground_truth)).sum()
    assert any(f"{unknown:,} of {missing:,} missing pixels" in line for line in lines)


def test_evaluate_tells_which_missing_pixels_are_not_scored(files, cli):
    truth = cv2.imread("in/gt.png", cv2.IMREAD_UNCHANGED)
    missing = cv2.imread(files[1], cv2.IMREAD_UNCHANGED) == 0
    rows, columns = np.nonzero(missing)
    truth[rows[:100], columns[:100]] = 0
    cv2.imwrite("in/gt.png", truth)
    arguments = ["evaluate", *files, *GROUND_TRUTH, *QUICK]
    line = next(line for line in cli(*arguments).out.splitlines() if line.startswith("Not scored"))
    assert f"100 of {missing.sum():,} missing pixels" in line
    assert json.loads(cli(*arguments, "--json").out)["unscored"] == 100
    assert "Not scored" not in cli("evaluate", *files, "--hold-out", "areas", *QUICK).out


def test_info_tells_what_is_known_of_the_truth(files, cli):
    text = cli("info", *files, *GROUND_TRUTH).out
    assert "gt.png, 5000 units per metre, known at 100.0% of all pixels and 100.0% of the missing ones" in text
    Path("in/meta.json").write_text(json.dumps({"depth_units_per_m": 1000, "gt": "exact"}))
    assert "5.03 times the measured depth: give 5000" in cli("info", "in").out
    assert "give 5000 as its units" in fails(cli, "complete", "in", "--out", "out")
    Path("in/meta.json").write_text(json.dumps({"depth_units_per_m": 1000, "gt": "filled by hand"}))
    assert "none: according to meta.json, gt.png" in cli("info", "in").out


def test_evaluate_prints_one_json_document(files, capsys, cli):
    flags = [*GROUND_TRUTH, "--preset", "best", "--preset", "paper", "--preset", "best", *QUICK]
    found = json.loads(cli("evaluate", *files, *flags, "--json").out, parse_constant=pytest.fail)
    assert (found["against"], found["pattern"], found["seeds"]) == ("ground truth", None, [])
    frame = ilf.load_frame(*files, ground_truth="in/gt.png", ground_truth_units=5000)
    for result, name in zip(found["results"], ("best", "paper"), strict=True):
        evaluation = evaluate_completion(frame, ilf.Run.of(frame, preset=name, max_iterations=25).complete())
        assert (result["name"], result["errors"]["rmse_m"]) == (name, evaluation.rmse)
        assert [block["label"] for block in result["blocks"]] == [1, 2]
    assert main(["evaluate", *files, "--hold-out", "random", "--seeds", "2", *QUICK, "--json"]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert (found["against"], found["pattern"], found["seeds"]) == ("hold-out", "random", [0, 1])


def test_evaluate_on_hold_out_is_the_default_without_ground_truth(files, cli):
    captured = cli("evaluate", *files, "--seeds", "2", "--csv", "new/table.csv", "--progress", *QUICK)
    assert "2 hold-outs" in captured.out
    assert "0 % |" in captured.err
    run = ilf.Run.of(ilf.load_frame(*files), preset=ilf.preset(max_iterations=25))
    result = evaluate_hold_out(run, HoldOutTest("areas", (0, 1)))
    with open("new/table.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["block"] for row in rows] == ["", "1", "2"]
    assert float(rows[0]["rmse_m"]) == result.whole.rmse
    assert float(rows[2]["mae_m"]) == result.blocks[2].mae


def test_evaluate_takes_presets_from_files_each_with_its_extraction(files, cli):
    one_block = UserPreset("one block", ilf.preset("paper"), BlockParameters(granularity=0.0, use_depth=False))
    write_preset("file.json", one_block)
    hidden = ["--hold-out", "random", "--seeds", "1", "--by-block"]
    text = cli("evaluate", *files, "--preset", "best", "--preset", "file.json", *hidden, *QUICK).out
    assert text.count("block  pixels") == 2, "other blocks, another table"
    frame = ilf.load_frame(*files)
    runs = [
        ilf.Run.of(frame, preset=preset.replace(max_iterations=25), extraction=extraction)
        for extraction, preset in ((None, ilf.preset()), (one_block.extraction, one_block.parameters))
    ]
    steps = compared_steps([hold_out_steps(run, HoldOutTest("random", (0,))) for run in runs])
    expected = run_to_end(steps)[1].whole.rmse
    assert figures(text, "one block")[2].rstrip("*") == f"{1000 * expected:.2f}"


def test_evaluate_sweeps_one_parameter_or_two(files, cli):
    text = cli("evaluate", *files, *GROUND_TRUTH, "--sweep", "max-iterations=3,25").out
    run = ilf.Run.of(ilf.load_frame(*files, ground_truth="in/gt.png", ground_truth_units=5000))
    for point in run_sweep(Sweep(run, {"max_iterations": [3, 25]})).points:
        name = f"max_iterations {point.values['max_iterations']} "
        assert figures(text, name)[2].rstrip("*") == f"{1000 * point.whole.rmse:.2f}"
    grid = ["--sweep", "smoothness=1,3", "--sweep", "trend=on,off", "--hold-out", "random", "--seeds", "1"]
    lines = cli("evaluate", *files, *grid, *QUICK).out.splitlines()[2:6]
    points = [f"smoothness {value} x, trend {switch}" for value in (1, 3) for switch in ("on", "off")]
    assert [line.split("  ")[0] for line in lines] == points


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--sweep", "smoothnes=1"], "Did you mean smoothness"),
        (["--sweep", "smoothness"], "a parameter and its values, such as smoothness=0.3,1,3"),
        (["--sweep", "smoothness=much"], "'much' is not a number"),
        (["--sweep", "trend=maybe"], "trend must be on or off, not 'maybe'"),
        (["--sweep", "smoothness=1", "--preset", "best", "--preset", "paper"], "varies one --preset"),
        (["--hold-out", "areas", *GROUND_TRUTH], "exclude each other"),
        ([*GROUND_TRUTH, "--seeds", "2"], "add --hold-out"),
        (["--preset", "bset"], "no preset 'bset', and no such file. Known: best"),
        (["--padding", "2"], "padding has no effect"),
    ],
)
def test_what_does_not_go_together_is_said_before_anything_runs(flags, message, files, cli):
    assert message in fails(cli, "evaluate", *files, *flags, status=2)


def test_what_cannot_be_evaluated_is_refused(files, cli):
    assert "padding has no effect" in fails(cli, "evaluate", *files, "--sweep", "padding=2,3")
    ground_truth = np.where(cv2.imread("in/depth.png", cv2.IMREAD_UNCHANGED) == 0, 0, 2000).astype(np.uint16)
    cv2.imwrite("in/known.png", ground_truth)
    error = fails(cli, "evaluate", *files, "--ground-truth", "in/known.png")
    assert "no ground truth where depth is missing in the blocks" in error


def test_presets_lists_built_in_ones_and_ones_own(cli):
    ilf.save_preset("soft", ilf.preset("best", smoothness=3))
    path = ilf.save_preset("damaged", ilf.preset())
    path.write_text("{")
    captured = cli("info", "--presets")
    assert figures(captured.out, "paper")[1] == "built-in"
    assert captured.out.count("soft  ") == 1
    assert "your own, from best  smoothness 3.0" in captured.out
    assert "damaged.json is not valid JSON" in captured.err
