"""The run record: the same for the same run, checked when read, and enough to make the run again."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import ilf
from ilf.completion import CompletionRun, compose
from ilf.ebs import extract
from ilf.errors import FormatError, InputError
from ilf.run import replay as replay_module
from ilf.run.export import ExportOptions, export
from ilf.run.record import labels_sha256, make_run_record, read_run_record
from ilf.run.replay import replay

from .small_frames import CAMERA, QUICK, write_small_frame

OPTIONS = ExportOptions(cloud="xyz", axes="y-up", cloud_unit="mm")


class Run:
    """A run and its export, as the window makes them."""

    def __init__(self, folder, *, edit=None, parameters=None, only=None, options=OPTIONS):
        self.files = write_small_frame(folder / "in")
        self.frame = ilf.load_frame(*self.files, intrinsics=CAMERA)
        self.labels = ilf.extract_blocks(self.frame)
        if edit is not None:
            edit(self.labels)
        chosen = ilf.preset(**QUICK) if parameters is None else parameters
        run = CompletionRun(self.frame, self.labels, chosen, only)
        list(run)
        self.completion = compose(self.frame, run.results)
        self.record = make_run_record(
            self.frame, self.labels, ilf.BlockParameters(), edit is not None, self.completion, options
        )
        self.out = folder / "out"
        export(self.out, self.frame, self.labels, self.completion, options, run_record=self.record)
        self.path = self.out / "run.json"

    def changed(self, change):
        """Write the record again with something changed."""
        data = json.loads(self.path.read_text())
        change(data)
        self.path.write_text(json.dumps(data))
        return self.path


def replayed(path, out, *files):
    """Replay a record and export what comes out; returns the Replay."""
    again = replay(read_run_record(path), path.parent, *files)
    run = CompletionRun(again.frame, again.labels, again.parameters, set(again.parameters))
    list(run)
    completion = compose(again.frame, run.results)
    record = make_run_record(
        again.frame, again.labels, again.extraction, again.edited, completion, again.options, inputs=again.inputs
    )
    export(out, again.frame, again.labels, completion, again.options, run_record=record)
    return again


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def draw_a_block(labels):
    labels[5:30, 30:50] = 40_000


def test_same_run_gives_same_record_without_times(tmp_path):
    first, second = Run(tmp_path), Run(tmp_path)
    assert first.record == second.record
    assert first.path.read_bytes().endswith(b"}\n")
    text = first.path.read_text()
    assert "seconds" not in text
    assert str(first.out) not in text


def test_record_reads_back(tmp_path):
    special = ilf.preset(**QUICK, mode="fill+denoise")
    run = Run(tmp_path, parameters={1: ilf.preset(**QUICK), 2: special})
    data = json.loads(run.path.read_text())
    assert data["block_parameters"] == {"2": {"mode": "fill+denoise"}}
    record = read_run_record(run.path)
    assert record.parameters == {1: ilf.preset(**QUICK), 2: special}
    assert record.options == OPTIONS
    assert record.extraction == ilf.BlockParameters()
    assert record.inputs.depth_units == 1000
    assert record.shape == (60, 80)
    assert [outcome.label for outcome in record.outcomes] == [1, 2]
    assert list(record.outcomes) == list(run.completion.outcomes.values())


def test_what_is_not_a_number_becomes_null(tmp_path):
    run = Run(tmp_path, parameters=ilf.preset(min_known_pixels=5000))
    assert {outcome["status"] for outcome in run.record["blocks_outcome"]} == {"not recoverable"}
    assert {outcome["sigma_i"] for outcome in run.record["blocks_outcome"]} == {None}
    assert all(math.isnan(outcome.sigma_i) for outcome in read_run_record(run.path).outcomes)


def test_newer_records_are_read_but_not_with_unknown_parameters(tmp_path):
    run = Run(tmp_path)

    def add(data):
        data["mood"] = "good"
        data["blocks"]["outline"] = []
        data["export"]["colour"] = "red"
        data["blocks_outcome"][0]["seconds"] = 1

    read_run_record(run.changed(add))
    with pytest.raises(FormatError, match="another version"):
        read_run_record(run.changed(lambda data: data["parameters"].update(prior="plane")))


def set_at(*keys_and_value):
    *keys, last, value = keys_and_value

    def change(data):
        for key in keys:
            data = data[key]
        data[last] = value

    return change


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data.pop("inputs"),
        lambda data: data["blocks"].pop("sha256"),
        lambda data: data["blocks_outcome"][0].pop("label"),
        set_at("program", "other"),
        set_at("version", 3),
        set_at("versions", []),
        set_at("inputs", "depth_units", True),
        set_at("inputs", "depth_units", float("inf")),
        set_at("inputs", "intrinsics", [1, 2, 3]),
        set_at("inputs", "rgb", "rgb.png"),
        set_at("extraction", []),
        set_at("extraction", "dilation", 1.5),
        set_at("parameters", "mode", "magic"),
        set_at("block_parameters", {"1": 5}),
        set_at("blocks", "shape", [60]),
        set_at("blocks", "edited", 1),
        set_at("blocks", "file", "../in/depth.png"),
        set_at("export", "depth_formats", "png"),
        set_at("export", "depth_formats", [1]),
        set_at("export", "cloud", "obj"),
        set_at("export", "labels", None),
        set_at("blocks_outcome", {}),
        set_at("blocks_outcome", 0, "status", "splendid"),
        set_at("blocks_outcome", 0, "sigma_i", "0.1"),
    ],
)
def test_damaged_records_are_refused_by_name(tmp_path, damage):
    run = Run(tmp_path)
    with pytest.raises(FormatError, match=r"run\.json") as caught:
        read_run_record(run.changed(damage))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"3", b"\xff\xfe", b"[" * 100_000])
def test_files_that_are_no_record_are_refused(tmp_path, content):
    path = tmp_path / "run.json"
    path.write_bytes(content)
    with pytest.raises(FormatError):
        read_run_record(path)


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"edit": draw_a_block},
        {"only": {2}},
        {"parameters": {1: ilf.preset(**QUICK), 2: ilf.preset(**QUICK, mode="fill+denoise", trend=False)}},
        {"parameters": ilf.preset("released-code", **QUICK)},
    ],
    ids=["plain", "edited", "some blocks", "own parameters", "released code"],
)
def test_replay_gives_the_same_bytes(tmp_path, how):
    run = Run(tmp_path, **how)
    again = replayed(run.path, tmp_path / "again")
    assert again.warnings == ()
    assert contents(tmp_path / "again") == contents(run.out)


def test_replay_refuses_changed_inputs(tmp_path):
    run = Run(tmp_path)
    depth = run.files[1]
    depth.write_bytes(depth.read_bytes() + b"\0")
    with pytest.raises(InputError, match=r"depth\.png is not the depth file of the recorded run"):
        replayed(run.path, tmp_path / "again")
    assert not (tmp_path / "again").exists()


def test_replay_finds_moved_inputs_when_told_or_beside_the_record(tmp_path):
    run = Run(tmp_path)
    moved = [path.rename(tmp_path / path.name) for path in run.files]
    with pytest.raises(InputError, match=r"rgb\.png: there is no such file"):
        replayed(run.path, tmp_path / "again")
    replayed(run.path, tmp_path / "again", *moved)
    assert contents(tmp_path / "again") == contents(run.out)
    with pytest.raises(InputError, match="not the colour file"):
        replayed(run.path, tmp_path / "other", *moved[::-1])

    record = tmp_path / "run.json"
    record.write_bytes(run.path.read_bytes())
    replayed(record, tmp_path / "beside")
    assert contents(tmp_path / "beside") == contents(run.out)


def test_replay_of_edited_blocks_needs_their_label_map(tmp_path):
    run = Run(tmp_path, edit=draw_a_block)
    labels = run.out / "blocks.png"
    others = run.labels.copy()
    others[0, 0] = 9
    ilf.io.write_labels(labels, others)
    with pytest.raises(InputError, match="edited by hand"):
        replayed(run.path, tmp_path / "again")
    labels.unlink()
    with pytest.raises(InputError, match=r"blocks\.png"):
        replayed(run.path, tmp_path / "again")


def test_a_parameter_that_had_another_name_is_understood(tmp_path):
    run = Run(tmp_path, parameters={1: ilf.preset(), 2: ilf.preset(edges="canny")})
    for name in ("network", "hed"):
        run.changed(set_at("parameters", "edges", name))
        assert {label: own.edges for label, own in read_run_record(run.path).parameters.items()} == {
            1: "combined", 2: "canny",
        }  # fmt: skip


def test_a_record_from_before_there_was_a_choice_of_filters_is_of_the_papers(tmp_path):
    run = Run(tmp_path, parameters=ilf.preset("paper"))
    data = json.loads(run.path.read_text())
    for name in ("filter", "centred", "s_criteria", "smoothness", "edges", "model"):
        del data["parameters"][name]
    run.path.write_text(json.dumps(data))
    assert set(read_run_record(run.path).parameters.values()) == {ilf.preset("paper")}


def test_a_record_may_hold_values_without_effect(tmp_path):
    run = Run(tmp_path)
    run.changed(set_at("parameters", "padding", 3.0))
    assert {own.padding for own in read_run_record(run.path).parameters.values()} == {3.0}


def test_replay_where_the_extraction_has_changed(tmp_path, monkeypatch):
    """Another version of a library may find other blocks: the written ones are used, and the user is told."""
    run = Run(tmp_path)
    run.changed(set_at("versions", "scipy", "0.1"))

    def one_block(frame, parameters):
        return replace(extract(frame, parameters), blocks=np.ones(frame.shape, np.int32))

    monkeypatch.setattr(replay_module, "extract", one_block)
    again = replayed(run.path, tmp_path / "again")
    assert labels_sha256(again.labels) == labels_sha256(run.labels)
    (warning,) = again.warnings
    assert "scipy 0.1 (here" in warning
    (run.out / "blocks.png").unlink()
    with pytest.raises(InputError, match=r"scipy 0\.1"):
        replayed(run.path, tmp_path / "third")


def test_frames_that_came_from_no_file_have_a_record_but_no_replay(tmp_path):
    run = Run(tmp_path)
    frame = ilf.RGBDFrame(run.frame.rgb, run.frame.depth)
    options = replace(OPTIONS, cloud=None)
    record = make_run_record(frame, run.labels, None, True, run.completion, options)
    assert record["inputs"] is None
    export(tmp_path / "bare", frame, run.labels, run.completion, options, run_record=record)
    with pytest.raises(InputError, match="not read from files"):
        replayed(tmp_path / "bare" / "run.json", tmp_path / "again")
