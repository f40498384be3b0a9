"""The command line: what it writes, that replays are exact, and that errors are one line."""

import argparse
import errno
import io
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf._runtime.installation import asset_path
from ilf.cli import main, output, parsing
from ilf.cli.commands import COMMANDS, build_parser
from ilf.errors import InputError
from ilf.io.block_files import read_blocks, write_blocks
from ilf.io.images import encode_mask, read_labels
from ilf.run.record import read_record

from ..small_frames import CAMERA, write_small_frame

ROOT = Path(__file__).parents[3]
QUICK = ["--max-iterations", "25"]
ERRORS = {"expected_error.png", "expected_error.npy", "unsupported.png"}
RESULTS = {"depth.png", "depth.npy", "blocks.png", "curves.csv", "cloud.ply", "meta.json", "run.json"} | ERRORS


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Colour and depth file, relative to the working directory."""
    monkeypatch.chdir(tmp_path)
    write_small_frame(tmp_path / "in")
    return ["in/rgb.png", "in/depth.png"]


def contents(folder):
    return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def replays(folder):
    """Replay a run; its files must be the same again."""
    assert main(["complete", "--replay", f"{folder}/run.json", "--out", "again", "--quiet"]) == 0
    assert contents("again") == contents(folder)


def fails(cli, *arguments, status=1):
    """Run a command that must fail; returns its one line on stderr."""
    told = cli(*arguments, status=status).err
    assert told.startswith("ilf: error: ")
    assert told.count("\n") == 1
    return told


def test_complete_writes_everything_and_says_what(files, capsys):
    assert main(["complete", *files, "--intrinsics", CAMERA, "--out", "out", *QUICK, "--depth-units", "1000"]) == 0
    assert set(contents("out")) == RESULTS
    captured = capsys.readouterr()
    assert captured.err == ""
    lines = captured.out.splitlines()
    assert "2 blocks cover 100.0% of the frame" in lines[0]
    assert "485 of 485 missing pixels recovered (100.0%)" in lines[1]
    assert lines[2] == (
        "Written to out: depth.png, depth.npy, expected_error.png, expected_error.npy, unsupported.png, blocks.png, "
        "curves.csv, cloud.ply, meta.json, run.json"
    )
    assert lines[3] == "", "the table of blocks may be long"
    assert lines[4].split()[:5] == ["block", "pixels", "missing", "recovered", "status"]
    assert [line.split()[0] for line in lines[5:7]] == ["1", "2"]


@pytest.mark.parametrize("loaded", ["4.10.0", "5.0.0"])
def test_opencv_4_in_the_place_of_opencv_5_is_named(loaded, files, monkeypatch, cli):
    monkeypatch.setattr(cv2, "__version__", loaded)
    if loaded.startswith("5"):
        assert main(["info", *files]) == 0
    else:
        assert "OpenCV 4.10.0 has replaced OpenCV 5" in fails(cli, "info", *files)


@pytest.mark.parametrize(
    "extra",
    [
        ["--preset", "released-code", "--no-cloud"],
        ["--blocks-dilation", "2", "--no-blocks-use-depth", "--cloud", "xyzrgb", "--depth-formats", "tiff"],
        ["--blocks", "drawn.png", "--png-units", "5000", "--mesh", "obj", "--normals", "--drop-flying"],
    ],
)
def test_replay_writes_the_same_bytes(files, tmp_path, extra):
    drawn = np.zeros((60, 80), np.uint8)
    drawn[10:50, 5:70] = 7
    cv2.imwrite("drawn.png", drawn)
    assert main(["complete", *files, "--intrinsics", CAMERA, "--out", "out", "--quiet", *QUICK, *extra]) == 0
    (tmp_path / "elsewhere").mkdir()
    os.chdir("elsewhere")
    replays("../out")
    Path("../in").rename("../moved")
    moved = ["../moved/rgb.png", "../moved/depth.png"]
    assert main(["complete", "--replay", "../out/run.json", *moved, "--out", "third", "--quiet"]) == 0
    assert contents("third") == contents("../out")


def test_a_folder_is_a_frame_and_names_the_output(files):
    Path("in/meta.json").write_text(
        json.dumps({"name": "../two walls", "depth_units_per_m": 1000, "K": [80, 80, 40, 30]})
    )
    assert main(["complete", "in", *QUICK]) == 0
    assert set(contents(".._two_walls-ilf")) == RESULTS


def test_without_intrinsics_there_is_no_cloud_and_that_is_said(files, capsys, cli):
    assert main(["complete", *files, "--out", "out", "--quiet", *QUICK]) == 0
    assert set(contents("out")) == RESULTS - {"cloud.ply"}
    assert "ilf: warning: No point cloud" in capsys.readouterr().err
    assert read_record("out/run.json").export.cloud is None
    assert "A point cloud needs" in fails(cli, "complete", *files, "--out", "new", "--cloud", "ply")
    assert "A mesh needs" in fails(cli, "complete", *files, "--out", "new", "--no-cloud", "--mesh", "glb")
    assert not Path("new").exists()


def test_a_missing_edge_network_is_said_by_every_command(files, capsys, cli):
    model = ["--blocks-model", "mine"]
    commands = (
        ["complete", *files, "--no-cloud", "--out", "out", "--quiet", *QUICK, *model],
        ["complete", "--replay", "out/run.json", "--out", "again", "--quiet"],
        ["blocks", *files, "--out", "blocks.png", "--quiet", *model],
        ["batch", ".", "--out", "batch", "--quiet", *QUICK, *model],
    )
    for command in commands:
        warnings = [line for line in cli(*command).err.splitlines() if "There is no edge network 'mine'" in line]
        assert len(warnings) == 1
        assert warnings[0].startswith("ilf: warning: Canny's edges replace those of the network: ")
    filters = ["complete", *files, "--no-cloud", "--out", "own", "--quiet", "--preset", "best", "--model", "mine"]
    evaluation = ["evaluate", *files, "--hold-out", "random", "--seeds", "1", "--model", "mine"]
    for command in (filters, ["complete", "--replay", "own/run.json", "--out", "own-again", "--quiet"], evaluation):
        assert main(command) == 0
        note = "Canny's edges replace those of the network: There is no edge network 'mine'"
        assert capsys.readouterr().err.count(note) == 1


def test_a_replay_says_how_it_came_out(files, cli):
    main(["complete", *files, "--no-cloud", "--out", "out", "--quiet", *QUICK])
    captured = cli("complete", "--replay", "out/run.json", "--out", "again")
    assert captured.err == ""
    assert captured.out.endswith("The result is identical to the recorded one.\n")
    Path("out/curves.csv").unlink()
    record = json.loads(Path("out/run.json").read_text())
    record["depth_sha256"] = "0"
    Path("out/run.json").write_text(json.dumps(record))
    captured = cli("complete", "--replay", "out/run.json", "--out", "again")
    assert "ilf: warning: The set of files is incomplete: missing curves.csv." in captured.err
    assert "ilf: warning: The depth differs from the recorded one by up to 0.0e+00 m, at 0 pixels" in captured.err
    assert "identical to the recorded one" not in captured.out


def test_a_replay_can_leave_out_the_cloud_that_cannot_be_written_here(files):
    main(["complete", *files, "--intrinsics", CAMERA, "--out", "out", "--quiet", *QUICK])
    assert main(["complete", "--replay", "out/run.json", "--no-cloud", "--out", "again", "--quiet"]) == 0
    there, here = contents("out"), contents("again")
    assert set(there) - set(here) == {"cloud.ply"}
    assert all(here[name] == there[name] for name in here if name != "run.json")


def test_distrusted_depth_is_completed_anew_and_replayed(files, cli):
    mask = np.zeros((60, 80), np.uint8)
    mask[40:52, 4:20] = 255
    cv2.imwrite("mask.png", mask)
    with_invalid_mask = ["complete", *files, "--no-cloud", "--quiet", *QUICK, "--invalid-mask", "mask.png"]
    assert main([*with_invalid_mask, "--out", "out"]) == 0
    frame = ilf.load_frame(*files).with_invalid_mask(mask > 0)
    depth = np.load("out/depth.npy")
    assert np.all(np.isfinite(depth[mask > 0]))
    assert np.any(depth[mask > 0] != frame.measured[mask > 0])
    assert np.all(np.isfinite(np.load("out/expected_error.npy")[mask > 0]))
    replays("out")
    cv2.imwrite("small.png", mask[:9])
    assert "the mask is 80 x 9" in fails(cli, *with_invalid_mask[:-1], "small.png")
    assert main(["blocks", *files, "--invalid-mask", "mask.png", "--out", "b.png", "--quiet"]) == 0
    np.testing.assert_array_equal(read_labels("b.png"), ilf.extract_blocks(frame))


def test_blocks_go_to_other_programs_and_come_back(files, cli):
    drawn = np.zeros((60, 80), np.int32)
    drawn[10:30, 30:50] = 7
    write_blocks("drawn.json", drawn, format="labelme", names={7: "chair"})
    shown = cli("blocks", *files, "--from", "drawn.json", "--out", "b.json", "--format", "coco-rle").out
    assert re.search(r"^ *7 +400 .* chair$", shown, re.MULTILINE)
    assert "1 block covers 8.3%" in shown
    found = read_blocks("b.json", (60, 80))
    np.testing.assert_array_equal(found.labels, drawn)
    assert found.names == {7: "chair"}
    written = json.loads(Path("b.json").read_text())
    assert written["images"][0]["file_name"] == Path(files[0]).name

    several = written["images"] + [written["images"][0] | {"id": 99, "file_name": "elsewhere.png"}]
    Path("b.json").write_text(json.dumps(written | {"images": several}))
    given = ["complete", *files, "--no-cloud", "--quiet", *QUICK, "--blocks", "b.json"]
    assert main([*given, "--out", "given"]) == 0
    np.testing.assert_array_equal(read_labels("given/blocks.png"), drawn)
    assert main([*given, "--fill-gaps", "--blocks-granularity", "0.4", "--out", "filled"]) == 0
    filled = read_labels("filled/blocks.png")
    assert np.all(filled > 0)
    np.testing.assert_array_equal(filled == 7, drawn == 7)
    replays("filled")

    write_blocks("none.json", drawn * 0)
    assert "contains none" in fails(cli, *given[:-1], "none.json")


def test_drawn_borders_are_taken_told_and_replayed(files, cli):
    frame = ilf.load_frame(*files)
    labels = np.where(np.arange(80) < 40, 1, 2) * np.ones((60, 1), np.int32)
    drawn = np.zeros((60, 80), bool)
    drawn[:, 39:41] = True
    write_blocks("labels.png", labels)
    Path("mask.png").write_bytes(encode_mask(drawn))
    flags = ["complete", *files, "--no-cloud", "--quiet", "--blocks", "labels.png", "--drawn", "mask.png"]
    assert main([*flags, "--out", "out"]) == 0
    depth = np.load("out/depth.npy")
    assert np.array_equal(depth, ilf.complete(frame, labels, drawn=drawn).depth, equal_nan=True)
    assert re.search(r"^borders: +drawn.png$", cli("info", "out/run.json").out, re.MULTILINE)
    replays("out")
    cv2.imwrite("small.png", np.zeros((9, 80), np.uint8))
    assert "the mask is 80 x 9" in fails(cli, *flags[:-1], "small.png")


def test_blocks_are_extracted_around_those_that_stay(files, capsys, cli):
    drawn = np.zeros((60, 80), np.uint8)
    drawn[10:30, 30:50] = 7
    drawn[40:50, 30:50] = 9
    cv2.imwrite("drawn.png", drawn)
    again = ["blocks", *files, "--out", "b.png", "--from", "drawn.png", "--fill-gaps"]
    assert main(again) == 0
    labels = read_labels("b.png")
    assert np.all(labels[drawn > 0] == drawn[drawn > 0])
    assert np.all(labels > 0)
    assert "4 blocks cover 100.0%" in capsys.readouterr().out
    assert main([*again, "--keep", "9", "--quiet"]) == 0
    labels = read_labels("b.png")
    assert np.all((labels == 9) == (drawn == 9))
    assert 7 not in labels
    assert main(["blocks", *files, "--out", "b.png", "--from", "drawn.png", "--keep", "7", "--quiet"]) == 0
    np.testing.assert_array_equal(read_labels("b.png"), np.where(drawn == 7, 7, 0))
    assert "no block 3. Blocks: " in fails(cli, *again, "--keep", "9,3")


@pytest.mark.parametrize(("kind", "prefix"), [(ilf.Parameters, "--"), (ilf.BlockParameters, "--blocks-")])
def test_every_declared_parameter_has_a_flag(kind, prefix):
    for name, declaration in kind.declarations().items():
        if declaration.kind is bool:
            value = not declaration.default
            flag = f"{prefix}{name.replace('_', '-')}"
            words = [flag if value else flag.replace("--", "--no-", 1)]
        else:
            value = declaration.maximum if declaration.kind is not str else "mine"
            value = [*declaration.choices][-1] if declaration.choices else declaration.kind(value)
            words = [f"{prefix}{name.replace('_', '-')}", str(value)]
        arguments = build_parser().parse_args(["complete", "a", "b", *words])
        assert parsing.given_parameters(arguments, kind) == {name: value}
    arguments = build_parser().parse_args(["complete", "a", "b", "--blocks-margin", "auto"])
    assert parsing.given_parameters(arguments, ilf.BlockParameters) == {"margin": -1}


def test_the_filter_follows_the_flags_of_the_extraction(files):
    """The same blocks, other edges: what the library gives with that extraction."""
    labels, mask = np.ones((60, 80), np.int32), np.zeros((60, 80), np.uint8)
    mask[20:40, 30:50] = 255  # across the jump
    cv2.imwrite("mask.png", mask)
    frame = ilf.load_frame(*files).with_invalid_mask(mask > 0)
    own = ilf.BlockParameters(granularity=0.0, min_size=50.0, depth_jump=3.0)
    flags = ["--blocks-granularity", "0", "--blocks-min-size", "50", "--blocks-depth-jump", "3"]
    flags += ["--invalid-mask", "mask.png"]
    assert main(["complete", *files, "--no-cloud", "--quiet", "--out", "out", *flags]) == 0
    assert np.array_equal(read_labels("out/blocks.png"), labels)
    expected = ilf.complete(frame, labels, extraction=own).depth
    assert np.array_equal(np.load("out/depth.npy"), expected, equal_nan=True)
    assert not np.array_equal(ilf.complete(frame, labels).depth, expected, equal_nan=True)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_a_help_and_those_that_extract_list_all_parameters(command, cli):
    text = cli(command, "--help").out
    flags = [f"--blocks-{name.replace('_', '-')}" for name in ilf.BlockParameters.declarations()]
    extracts = command in {"complete", "batch", "evaluate", "report", "blocks"}
    assert [flag in text for flag in flags] == [extracts] * len(flags)


def test_a_default_that_the_help_states_is_the_one_that_holds():
    def of(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
        for action in parser._actions:
            yield action
            if isinstance(action, argparse._SubParsersAction):
                yield from chain.from_iterable(map(of, action.choices.values()))

    stated = [
        (action.dest, float(match[1]), {action.default, action.const})
        for action in of(build_parser())
        if (match := re.search(r"\(default: (\d[\d.]*)\b", action.help or ""))
    ]
    assert len(stated) > 10
    assert [one for one in stated if one[1] not in one[2] and one[2] != {None}] == [], "None: worked out later"


def test_the_help_has_what_can_be_given_and_what_is_used_otherwise(cli):
    text = " ".join(cli("complete", "--help").out.split())
    for part in ("[any of png,tiff,npy; default png,npy]", "--no-cloud Write no cloud.", "y up. [default none]"):
        assert part in text


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["complete", "in/rgb.png"], "depth image"),
        (["complete", "in/none.png", "in/depth.png"], "no such file"),
        (["complete", "in/depth.png", "in/rgb.png"], "depth"),
        (["complete", "in/rgb.png", "in/depth.png", "--depth-units", "1"], "units"),
        (["complete", "in/rgb.png", "in/depth.png", "--intrinsics", "kinekt"], "preset"),
        (["complete", "in/rgb.png", "in/depth.png", "--out", "in"], "own file"),
        (["complete", "in/rgb.png", "in/depth.png", "--blocks", "in/rgb.png"], "label map"),
        (["complete", "in/rgb.png", "in/depth.png", "--blocks-margin", "40"], "no blocks"),
        (["complete", "--replay", "in/rgb.png"], "JSON"),
        (["complete", "--replay", "none.json"], "no such file"),
        (["blocks", "in/rgb.png", "in/depth.png", "--out", "missing/b.png"], "folder"),
        (["blocks", "in/rgb.png", "in/depth.png", "--out", "in/depth.png"], "own file"),
        (["blocks", "in/rgb.png", "in/depth.png", "--out", "b.jpg"], ".png"),
        (["blocks", "in/rgb.png", "in/depth.png", "--out", "b.png", "--stages", "in/rgb.png"], "folder"),
        (["complete", "."], "meta.json"),
        (["sample", "in/rgb.png"], "folder"),
    ],
)
def test_errors_are_one_line(files, arguments, word, cli):
    assert word in fails(cli, *arguments)


def test_interrupt_leaves_nothing_behind(files, monkeypatch, cli):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(output.Bar, "update", interrupted)
    assert "interrupted" in fails(cli, "complete", *files, "--out", "out", status=130)
    assert not Path("out").exists()


def test_progress_goes_to_stderr(files, cli):
    captured = cli("complete", *files, "--no-cloud", "--out", "out", "--progress", *QUICK)
    assert "0/2 blocks" in captured.err
    assert "/2 blocks" not in captured.out


def test_blocks_writes_the_label_map_and_its_stages(files, capsys):
    assert main(["blocks", *files, "--out", "b.png", "--stages", "stages/of"]) == 0
    labels = ilf.extract_blocks(ilf.load_frame(*files))
    np.testing.assert_array_equal(read_labels("b.png"), labels)
    names = ["1-strength", "2-edges", "3-dilated", "4-contracted", "5-blocks"]
    assert sorted(contents("stages/of")) == [f"{name}.png" for name in names]
    strength, edges, dilated = (cv2.imread(f"stages/of/{name}.png", cv2.IMREAD_UNCHANGED) for name in names[:3])
    assert np.ptp(strength) > 200
    assert np.count_nonzero(dilated) > np.count_nonzero(edges) > 0
    assert np.all(dilated[edges > 0])
    overlay = cv2.imread("stages/of/5-blocks.png")
    assert np.all(overlay[:, 39] == 255)
    assert len(np.unique(overlay[:, [10, 70]].reshape(-1, 3), axis=0)) == 2
    assert "2 blocks cover 100.0%" in capsys.readouterr().out
    assert main(["complete", *files, "--blocks", "b.png", "--no-cloud", "--out", "out", "--quiet", *QUICK]) == 0
    assert read_record("out/run.json").blocks.edited


def test_info_shows_frames_and_records(files, cli):
    text = cli("info", *files).out
    assert "80 x 60, uint16" in text
    assert "1000 units per metre (assumed" in text
    assert "10.1%" in text
    assert "1.500 to 2.837 m" in text
    assert "intrinsics:   unknown" in text
    text = cli("info", *files, "--depth-units", "1", "--intrinsics", "1,2,3,4").out
    assert "fx 1, fy 2, cx 3, cy 4" in text
    assert re.search(r"problem: +\S+depth.png: The median depth would be", text)
    assert cli("info", files[0]).out == "colour:       in/rgb.png, 80 x 60\n"
    main(["complete", *files, "--no-cloud", "--out", "out", "--quiet", *QUICK, "--preset", "released-code"])
    text = cli("info", "out/run.json").out
    assert "preset released-code with max_iterations 25" in text
    assert "block  pixels" in text


def document(cli, *words):
    """The one JSON document that a command prints."""
    return json.loads(cli(*words, "--json").out, parse_constant=pytest.fail)


def test_complete_prints_one_json_document(files, cli):
    how = ["complete", *files, "--no-cloud", "--out", "out", *QUICK, "--blocks-existence-rate", "0.95"]
    found = document(cli, *how)
    run = ilf.Run.of(ilf.load_frame(*files), existence_rate=0.95, max_iterations=25)
    completion = run.complete()
    assert (found["frame"], found["width"], found["height"]) == (run.frame.name, 80, 60)
    assert found["recovered"] == np.count_nonzero(completion.filled & run.frame.missing)
    assert found["missing_before"] == found["missing_after"] + found["recovered"]
    assert found["errors"] is None
    assert found["parameters"] == run.parameters.to_dict()
    assert set(found["files"]) == set(contents("out"))
    outcomes = list(completion.outcomes.values())
    assert [block["status"] for block in found["blocks"]] == [outcome.status for outcome in outcomes]
    for block, outcome in zip(found["blocks"], outcomes, strict=True):
        assert block["sigma_i_m"] == (None if np.isnan(outcome.sigma_i) else outcome.sigma_i)
    of_complete, of_blocks = (
        set(re.findall(r"`(\w+)`", line.partition(" | ")[2]))
        for line in (ROOT / "assets" / "docs" / "commands.md").read_text(encoding="utf-8").splitlines()
        if line.startswith(("| `ilf complete` |", "| its `blocks` |"))
    )
    assert set(found) == of_complete
    assert set(found["blocks"][0]) == of_blocks


def test_info_prints_one_json_document(files, capsys, cli):
    frame = ilf.load_frame(*files)
    found = document(cli, "info", *files, "--intrinsics", "80,81,38,29")["frame"]
    assert (found["width"], found["height"], found["depth_type"]) == (80, 60, "uint16")
    assert found["missing_share"] == pytest.approx(frame.missing_share)
    assert found["max_m"] == pytest.approx(np.nanmax(frame.depth))
    assert found["intrinsics"] == {"fx": 80.0, "fy": 81.0, "cx": 38.0, "cy": 29.0, "name": ""}
    assert (found["plausibility_warnings"], found["problems"]) == ([], [])
    main(["complete", *files, "--no-cloud", "--out", "out", "--quiet", *QUICK])
    capsys.readouterr()
    found = document(cli, "info", "out")
    assert list(found) == ["frame", "run"]
    assert [block["label"] for block in found["run"]["blocks"]] == [1, 2]
    assert found["run"]["preset"] == "best"
    Path("out/depth.npy").unlink()
    found = document(cli, "info", "out/run.json")
    assert found["run"]["problems"][0].startswith("The set of files is incomplete: missing depth.npy")
    write_small_frame(Path("more/a"))
    write_small_frame(Path("more/b"))
    for folder in ("a", "b"):
        Path(f"more/{folder}/meta.json").write_text(json.dumps({"depth_units_per_m": 1000}))
    found = document(cli, "info", "more")
    assert (found["source"]["frames"], found["source"]["keys"]) == (2, ["a", "b"])


def test_info_tells_how_much_of_the_missing_depth_a_guide_knows(files, capsys):
    np.save("guide.npy", np.where(np.arange(80) < 40, np.nan, np.linspace(1, 3, 60)[:, None]))
    assert main(["info", *files, "--guide", "guide.npy"]) == 0
    assert "known at 50.0% of all pixels and 56.7% of the missing ones" in capsys.readouterr().out


def test_info_shows_what_is_wrong_with_a_set(files, cli):
    main(["complete", *files, "--no-cloud", "--extrapolate", "--out", "out", "--quiet", *QUICK])
    text = cli("info", "out").out
    assert cli("info", Path("out").rename("out.ilf")).out == text.replace("out/", "out.ilf/")
    Path("out.ilf").rename("out")
    assert "name:         in-completed" in text
    assert "extrapolated: depth that was still missing after the run" in text
    assert re.search(r"network:      edges \([0-9a-f]{12}\) for blocks and the filter\n", text)
    assert "problem" not in text
    Path("out/depth.npy").unlink()
    assert "problem:      The set of files is incomplete: missing depth.npy." in cli("info", "out/run.json").out
    Path("out/run.json").unlink()
    assert "an interrupted export" in fails(cli, "info", "out")


def test_sample_is_copied_and_nothing_else_overwritten(tmp_path, capsys, cli):
    folder = tmp_path / "here" / "room"
    for _ in range(2):
        assert main(["sample", str(folder)]) == 0
    source = asset_path("samples/room")
    assert contents(folder) == {path.name: path.read_bytes() for path in source.iterdir()}
    assert ilf.load_frame(folder).intrinsics is not None
    (folder / "meta.json").write_text("mine")
    capsys.readouterr()
    assert "meta.json" in fails(cli, "sample", folder)
    assert (folder / "meta.json").read_text() == "mine"
    assert main(["sample", str(folder), "--force"]) == 0
    assert contents(folder) == {path.name: path.read_bytes() for path in source.iterdir()}


def test_missing_assets_are_said():
    with pytest.raises(InputError, match="samples/none"):
        asset_path("samples/none")


def test_version(cli):
    assert cli("--version").out == f"ilf {ilf.__version__}\n"


@pytest.mark.parametrize("words", [["--version"], ["--help"]])
def test_version_and_help_import_neither_commands_nor_numpy(words):
    program = (
        "import sys\nfrom ilf.cli import main\ntry:\n    main(sys.argv[1:])\nexcept SystemExit:\n    pass\n"
        "print('modules:', *sys.modules)"
    )
    ended = _child("-c", program, *words)
    assert ended.returncode == 0, ended.stderr
    modules = ended.stdout.decode().rpartition("modules:")[2].split()
    assert "numpy" not in modules
    ours = {name.removeprefix("ilf.") for name in modules if name.startswith("ilf.")}
    quick = {"cli", "cli.commands", "cli.usage", "errors", "sources", "sources.named_places"}
    assert {name for name in ours if not name.startswith("_runtime")} == quick


_NO_EFFECT = "has no effect with {0} {1}; it belongs to {0} {2}."


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("", "COMMAND"),
        ("complet", "There is no command 'complet'. Did you mean complete? See ilf --help."),
        ("live a.bag", "There is no command 'live'. `ilf-gui --live SOURCE` plays in the window, `ilf capture DIR`"),
        ("fly", "There is no command 'fly'. Choose from complete, batch, "),
        ("version", "There is no command 'version'. Did you mean --version?"),
        ("presets", "`ilf info --presets` lists the presets."),
        ("export out", "`ilf project export` writes results for other programs."),
        ("--verson", "There is no option --verson. Did you mean --version? See ilf --help."),
        ("complete --mask a.png", "There is no option --mask. Did you mean --invalid-mask? See ilf complete --help."),
        ("--completion", "--completion: expected one argument"),
        ("project nwe", "There is no action 'nwe'. Did you mean new? See ilf project --help."),
        ("project new x.ilf in --emb", "There is no option --emb. Did you mean --embed?"),
        ("project export a b --out c", "Give one project, or the format of a data set by --to."),
        ("project export a.ilf --to 3dgs --out b", "--to takes results, not a project"),
        ("project export a --to 3dgs --out b --mesh ply", "leave out --mesh."),
        ("complete", "not 0 paths"),
        ("batch in --shards a --merge", "--merge needs no SOURCE: give only --shards."),
        ("complete a b --s-criteria 7", "--s-criteria"),
        ("complete a b --max-iterations many", "'many' is not a number"),
        ("complete a b --mode magic", "'magic' is not a choice. Choose from fill, fill+denoise."),
        ("complete a b --png-units 0", "must lie between"),
        ("complete a b --depth-formats png,jpg", "any of png, tiff, npy, not ['png', 'jpg']."),
        ("complete a b --mesh plyy", "argument --mesh: 'plyy' is not a choice. Did you mean ply?"),
        ("complete a b --no-cloud --axes camera", "--no-cloud contradicts --axes: leave it out, or add --mesh."),
        ("complete a b --no-cloud --cloud ply", "--cloud: not allowed with argument --no-cloud"),
        ("complete a b --blocks c.png --blocks-dilation 2", "With --blocks nothing is extracted"),
        ("complete a b --fill-gaps", "--fill-gaps has no effect alone: add --blocks."),
        ("complete a b --by-hand-weight 1", "add --by-hand."),
        ("complete a b --neighbours 1", "--neighbours applies to frames of a folder or a recording"),
        ("complete a --neighbour-step 2", "add --neighbours."),
        ("batch in --out out --static-camera --neighbours 1", "leave out --neighbours."),
        ("complete a b --layout tum", "select one with --frame"),
        ("complete --replay run.json --normals", "leave out --normals."),
        ("complete --replay run.json --mode fill --png-units 5", "leave out --mode, --png-units."),
        ("complete --replay run.json --drawn mask.png --strict", "leave out --drawn, --strict."),
        ("complete --replay run.json a b c", "not 3 paths"),
        ("complete a b --padding 3", f"padding {_NO_EFFECT.format('filter', 'edge-aware', 'ideal')}"),
        (
            "blocks a b --out b.png --blocks-detector canny --blocks-threshold 0.5",
            f"threshold {_NO_EFFECT.format('detector', 'canny', 'rgbd or hed')}",
        ),
        ("complete in --depth_factor=5000", "no option --depth_factor. Did you mean --depth-units?"),
        ("complete in -j 4", "no option -j. Blocks run on all cores; ilf batch"),
        ("complete in --max-depth 4", "no option --max-depth. Mark depth to leave out by --invalid-mask."),
        ("batch in -j4", "no option -j4. Did you mean --jobs?"),
        ("blocks a b", "--out"),
        ("blocks a b --out b.png --keep 9", "add --from."),
        ("blocks a b --from b.json --out c.png --stages stages", "leave out --stages, or add --fill-gaps."),
        ("info", "Give a colour and a depth file, one folder, or a run.json."),
        ("info room.ilf", "room.ilf is a project: use `ilf project info`."),
        ("info in -K K.txt", "no option -K. Did you mean --intrinsics?"),
        ("bench", "FOLDER"),
        ("complete EMPTY", "INPUT: '' is not a name"),
        ("batch in --out EMPTY", "--out: '' is not a name"),
    ],
)
def test_wrong_usage_is_one_line_that_says_what_is_meant(words, sentence, files, cli):
    before = sorted(Path().iterdir())
    assert sentence in fails(cli, *(word.replace("EMPTY", "") for word in words.split()), status=2)
    assert sorted(Path().iterdir()) == before


@pytest.mark.parametrize(
    ("shell", "of_files"), [("bash", "=_shtab_compgen_files"), ("zsh", ":_files"), ("fish", "__fish_complete_path")]
)
def test_completion_scripts_have_commands_options_choices_and_files(shell, of_files, cli):
    text = cli("--completion", shell).out
    words = [*COMMANDS, "blocks-granularity", "fill+denoise"]
    assert not [word for word in words if word not in text]
    assert text.count(of_files) > len(COMMANDS)
    if found := shutil.which(shell):
        subprocess.run([found, "-n"], input=text, text=True, check=True)


def test_reader_that_goes_away_is_no_error_message(files):
    read_end, write_end = os.pipe()
    os.close(read_end)
    try:
        ended = subprocess.run(
            [sys.executable, "-c", "import sys, ilf.cli; sys.exit(ilf.cli.main())", "info", *files],
            stdout=write_end,
            stderr=subprocess.PIPE,
            check=False,
        )
    finally:
        os.close(write_end)
    assert ended.returncode == 1
    assert ended.stderr == b""


def _child(*arguments, **environment):
    return subprocess.run(
        [sys.executable, *arguments],
        capture_output=True, check=False, env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
    )  # fmt: skip


def test_system_errors_are_told_in_words(files, cli, monkeypatch):
    def too_large(arguments):
        raise OSError(errno.EFBIG, os.strerror(errno.EFBIG), "big.png")

    monkeypatch.setattr("ilf.cli.info.run", too_large)
    said = cli("info", *files, status=1).err
    assert said == "ilf: error: big.png: the file would be larger than its drive or a limit (ulimit -f) allows\n"


def test_python_runs_the_package_as_the_command():
    ended = _child("-m", "ilf", "info", "absent")
    assert ended.returncode == 1
    assert ended.stderr.startswith(b"ilf: error:")


def test_a_terminal_that_cannot_show_a_name_is_no_error(files, tmp_path, monkeypatch):
    folder, shown = tmp_path / "größe 深度", io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(shown, "ascii", write_through=True))
    assert main(["complete", *files, "--out", str(folder), "--max-iterations", "2"]) == 0
    assert rb"gr\xf6\xdfe \u6df1\u5ea6: depth.png" in shown.getvalue()
    assert (folder / "depth.npy").is_file()


def test_a_bare_installation_does_without_qt_and_extras_and_names_what_lacks(files, tmp_path):
    """Nor are they imported before they are needed, nor what runs networks."""
    program = """
import sys
import ilf.cli.commands, ilf.run.writing
lacks = ("PySide6", "pyqtgraph", "qtpy", "qtawesome", "gui", "ilf_studio", "open3d", "libusb_package", "matplotlib",
         "h5py", "onnx", "torch")
assert not {"onnxruntime", *lacks} & {name.partition(".")[0] for name in sys.modules}
sys.modules |= dict.fromkeys(lacks)  # as where they are not installed
from ilf.cli import main
rgb, depth, out, labelled = sys.argv[1:]
how = ["--cloud", "pcd", "--mesh", "glb", "--normals", "--max-iterations", "2"]
assert main(["complete", rgb, depth, "--intrinsics", "80,80,40,30", "--out", out, *how]) == 0
assert main(["complete", "--replay", f"{out}/run.json", "--out", "again"]) == 0
assert main(["blocks", rgb, depth, "--out", "b.png", "--stages", "stages"]) == 0
assert main(["info", rgb, depth]) == 0
sys.exit(main(["info", labelled]))
"""
    labelled = tmp_path / "nyu_depth_v2_labeled.mat"
    labelled.write_bytes(b"\x89HDF\r\n\x1a\n")
    lacking = tmp_path / "lacking"  # also for the process that reads the file
    lacking.mkdir()
    (lacking / "h5py.py").write_text("raise ModuleNotFoundError(name='h5py')")
    path = os.pathsep.join((str(lacking), str(ROOT)))
    ended = _child("-c", program, *files, "out", str(labelled), PYTHONPATH=path)
    assert ended.returncode == 1
    assert {"depth.npy", "cloud.pcd", "mesh.glb", "run.json"} <= set(contents("out"))
    assert b"h5py" in ended.stderr
    assert b'pip install "ilf-studio[sensors]"' in ended.stderr
    assert ended.stderr.count(b"\n") == 1
