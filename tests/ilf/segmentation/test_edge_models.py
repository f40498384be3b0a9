"""A user's own edge networks: ONNX of other conventions, names, refusals."""

import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import helper, numpy_helper

from ilf._runtime.networks.models import (
    BUNDLED,
    CORRECTION,
    DEPTH_EDGES,
    SPARSE_CORRECTION,
    model_names,
    model_path,
    models_folder,
    name_from,
    new_model_path,
    remove_model,
)
from ilf._runtime.networks.network import Session
from ilf.cli import main
from ilf.errors import FormatError, InputError
from ilf.segmentation.edges.detectors import load_model
from ilf.segmentation.edges.importing import add_model

GAINS = np.array([0.5, -0.2, 0.3], np.float32)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Of the user's networks; not there yet."""
    path = tmp_path / "own" / "models"
    monkeypatch.setenv("ILF_MODELS", str(path))
    return path


@pytest.fixture(autouse=True)
def networks_are_tried_here(monkeypatch):
    """Without a process for each; test_trials.py has them."""

    def at_once(function: Callable[..., object], *arguments: object, **_: object) -> object:
        return function(*arguments)

    monkeypatch.setattr("ilf._runtime.children.run_in_child", at_once)


def picture(height: int, width: int) -> np.ndarray:
    """RGB in [0, 1], (3, H, W)."""
    return np.random.default_rng(height).random((3, height, width), np.float32)


def strength_by(path: Path, rgb: np.ndarray) -> np.ndarray:
    session = Session(np.fromfile(path, np.uint8))
    return session.run({session.first_input: rgb[None]})[-1][0, 0]


def write_weighted_sum(
    path: Path, *nodes: onnx.NodeProto, size: tuple[int | str, int | str] = ("h", "w"), gains: np.ndarray = GAINS
) -> Path:
    """A network whose "sum" is the channels' weighted sum; what `nodes` make of it, if any, comes out."""
    first = helper.make_node("Conv", ["x", "gains"], ["sum"])
    last = nodes[-1].output[0] if nodes else "sum"
    graph = helper.make_graph(
        [first, *nodes],
        "sum",
        [helper.make_tensor_value_info("x", 1, [1, 3, *size])],
        [helper.make_tensor_value_info(last, 1, [1, 1, *size])],
        [
            numpy_helper.from_array(gains[None, :, None, None], "gains"),
            numpy_helper.from_array(np.array([1, 1, 48, 48]), "baked"),
        ],
    )
    onnx.save(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8), path)
    return path


SIGMOID = helper.make_node("Sigmoid", ["sum"], ["strength"])


def test_an_imported_network_is_listed_and_found_by_name(tmp_path, folder):
    assert model_names() == (BUNDLED,)
    source = write_weighted_sum(tmp_path / "my net (2).onnx", SIGMOID)
    path = add_model(source)
    assert path == folder / "my-net-2.onnx"
    assert path.read_bytes() == source.read_bytes(), "what is right as it is stays as it is"
    add_model(source, "Another")
    assert model_names() == (BUNDLED, "Another", "my-net-2")
    assert load_model("my-net-2").path == path.resolve()
    assert load_model(BUNDLED).path == model_path(BUNDLED).resolve()
    remove_model("my-net-2")
    assert model_names() == (BUNDLED, "Another")
    with pytest.raises(InputError, match=r"no edge network 'my-net-2' .* only edges, Another"):
        load_model("my-net-2")


INPUT_VALUES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "rgb": lambda rgb: rgb,
    "imagenet": lambda rgb: (rgb - [0.485, 0.456, 0.406]) / [0.229, 0.224, 0.225],
    "caffe": lambda rgb: rgb[..., ::-1] * 255 - [104.00698793, 116.66876762, 122.67891434],
}


@pytest.mark.parametrize("inputs", INPUT_VALUES)
@pytest.mark.parametrize("logits", [True, False])
def test_other_conventions_are_adapted(tmp_path, inputs, logits):
    gains = GAINS / 60 if inputs == "caffe" else GAINS * 4
    source = write_weighted_sum(tmp_path / "net.onnx", *([] if logits else [SIGMOID]), gains=gains)
    path = add_model(source, inputs=inputs, logits=logits)
    rgb = picture(32, 48)
    total = INPUT_VALUES[inputs](rgb.transpose(1, 2, 0).astype(float)) @ gains
    np.testing.assert_allclose(strength_by(path, rgb), 1 / (1 + np.exp(-total)), atol=1e-5)


def test_a_size_that_is_fixed_in_name_only_does_not_matter(tmp_path):
    add_model(write_weighted_sum(tmp_path / "net.onnx", SIGMOID, size=(320, 480)))
    assert load_model("net").strength(np.zeros((50, 70, 3), np.uint8)).shape == (50, 70)


def half(path: Path) -> Path:
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    return path


def with_two_inputs(path: Path) -> Path:
    model = onnx.load(write_weighted_sum(path, helper.make_node("Add", ["sum", "y"], ["strength"])))
    model.graph.input.append(helper.make_tensor_value_info("y", 1, [1, 1, "h", "w"]))
    onnx.save(model, path)
    return path


def write_text(path: Path) -> Path:
    path.write_text("not a network")
    return path


REFUSED: dict[str, tuple[str, Callable[[Path], object], str]] = {
    "truncated ONNX": ("a.onnx", lambda p: half(write_weighted_sum(p, SIGMOID)), "a.onnx cannot be read as an ONNX"),
    "text as ONNX": ("a.onnx", write_text, "a.onnx cannot be read as an ONNX"),
    "weights of Caffe": ("a.caffemodel", write_text, "a.caffemodel is not an ONNX network"),
    "two inputs": ("a.onnx", with_two_inputs, "has 2 inputs, not one image"),
    "fixed size": (
        "a.onnx",
        lambda p: write_weighted_sum(p, helper.make_node("Reshape", ["sum", "baked"], ["strength"]), size=(48, 48)),
        "images of any size.* free height and width",
    ),
    "out of range": ("a.onnx", lambda p: write_weighted_sum(p, gains=GAINS * 9), "not within 0 to 1.* --logits"),
    "three channels": (
        "a.onnx",
        lambda p: write_weighted_sum(p, helper.make_node("Sigmoid", ["x"], ["strength"])),
        "is not an edge network",
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_what_is_no_edge_network_is_refused_and_leaves_nothing(tmp_path, folder, kind):
    name, write, message = REFUSED[kind]
    write(tmp_path / name)
    with pytest.raises(FormatError, match=message):
        add_model(tmp_path / name)
    assert not folder.exists()


def test_options_that_do_not_fit_the_file_are_refused(tmp_path):
    with pytest.raises(InputError, match="Add it without --logits"):
        add_model(write_weighted_sum(tmp_path / "net.onnx", SIGMOID), logits=True)
    with pytest.raises(InputError, match="one of rgb, imagenet, caffe, not 'bgr'"):
        add_model(tmp_path / "net.onnx", inputs="bgr")


def test_names_that_cannot_be_used_are_refused(tmp_path):
    source = write_weighted_sum(tmp_path / "net.onnx", SIGMOID)
    for name in ("", "../net", "a b", "x" * 101):
        with pytest.raises(InputError, match="cannot be the name"):
            add_model(source, name)
    for name in (BUNDLED, DEPTH_EDGES):
        for replace in (True, False):
            with pytest.raises(InputError, match="name of a bundled"):
                add_model(source, name, replace=replace)
        with pytest.raises(InputError, match="cannot be removed"):
            remove_model(name)
    first = add_model(source).read_bytes()
    write_weighted_sum(source, SIGMOID, gains=GAINS / 2)
    with pytest.raises(InputError, match="'net' already"):
        add_model(source)
    assert model_path("net").read_bytes() == first
    assert add_model(source, replace=True).read_bytes() == source.read_bytes() != first


def test_only_conversions_need_the_onnx_package(tmp_path, monkeypatch):
    ready = write_weighted_sum(tmp_path / "ready.onnx", SIGMOID)
    fixed = write_weighted_sum(tmp_path / "fixed.onnx", SIGMOID, size=(320, 480))
    monkeypatch.setitem(sys.modules, "onnx", None)
    add_model(ready)
    for refused in (
        lambda: add_model(ready, "other", inputs="caffe"),
        lambda: add_model(fixed),
    ):
        with pytest.raises(InputError, match='pip install "onnx"'):
            refused()


def test_the_command_adds_lists_and_removes(tmp_path, capsys, cli):
    source = write_weighted_sum(tmp_path / "net.onnx", gains=GAINS * 9)
    error = cli("models", "add", source, status=1).err
    assert error.startswith("ilf: error: net.onnx")
    assert "--logits" in error
    assert main(["models", "add", str(source), "--name", "mine", "--input", "imagenet", "--logits"]) == 0
    assert capsys.readouterr().out == f"Added mine: 0.0 MB, {models_folder() / 'mine.onnx'}\n"
    rows = [re.split(" {2,}", line) for line in cli("models", "list").out.splitlines()]
    assert [row[0] for row in rows[1:6]] == [BUNDLED, "mine", DEPTH_EDGES, CORRECTION, SPARSE_CORRECTION]
    assert rows[1][1:] == ["contours", "ILF Studio", "MIT", "4.2 MB", "bundled"]
    assert rows[2][1:3] == ["contours", "your own"]
    assert rows[3][3] == "MIT"
    assert main(["models", "remove", "mine"]) == 0
    assert "no edge network 'mine'" in cli("models", "remove", "mine", status=1).err


@pytest.mark.parametrize("file", ["net.onnx", "my net (2).v3.onnx", "n" * 150 + ".onnx"])
def test_a_file_gives_the_network_a_name_that_is_allowed(file):
    assert new_model_path(name_from(Path(file))).suffix == ".onnx"
