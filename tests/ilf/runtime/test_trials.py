"""Files that crash, exhaust or keep their reader: tried in a process of its own; the program says what is wrong."""

import hashlib
import os
import signal
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from ilf._runtime.children import run_in_child
from ilf._runtime.installation import asset_path
from ilf._runtime.networks.network import _outputs_in_child
from ilf.cli import main
from ilf.errors import FormatError, InputError
from ilf.segmentation.edges.detectors import EdgeNetwork

from ..small_frames import write_small_frame
from ..small_runs import contents
from ..tiny_onnx import message, node, number, write_network

HOSTILE = Path(os.environ.get("ILF_TEST_DATA", "../shared/data")) / "hostile"


def refuse() -> None:
    raise InputError("Not this one.")


def exhaust() -> int:
    return len(bytearray(2**32))


def spin() -> None:
    while True:
        pass


def crash() -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def test_a_child_gives_what_the_function_gives():
    assert run_in_child(divmod, 7, 2, file="seven") == (3, 1)
    assert run_in_child(time.sleep, 0.3, file="a.file", seconds=0.1) is None  # as while others have the processor
    for endless in (partial(time.sleep, 60), spin):
        with pytest.raises(FormatError, match=r"a\.file is damaged: reading it takes longer than 0\.1 s"):
            run_in_child(endless, file="a.file", seconds=0.1)


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_what_ends_a_child_is_told():
    with pytest.raises(FormatError, match=r"a\.file is damaged: reading it crashes .SIGSEGV"):
        run_in_child(crash, file="a.file")
    if os.path.exists("/proc/self/statm"):
        with pytest.raises(FormatError, match=r"a\.file is damaged: reading it needs more than 1 GiB"):
            run_in_child(exhaust, file="a.file", memory=2**30)


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_a_child_that_was_killed_while_it_waited_is_replaced():
    """As by a system without memory."""
    os.kill(run_in_child(os.getpid, file="a.file"), signal.SIGKILL)
    time.sleep(0.3)
    assert run_in_child(divmod, 7, 2, file="seven") == (3, 1)


def tensor(external: bytes) -> bytes:
    """One of two numbers."""
    return number(1, 2) + number(2, 1) + message(8, "w") + external


def kill_if_large(
    content: np.ndarray | None, sha256: str, unreadable: str, inputs: dict[str, np.ndarray]
) -> list[np.ndarray]:
    if max(one.size for one in inputs.values()) > 10**5:
        os.kill(os.getpid(), signal.SIGKILL)
    return _outputs_in_child(content, sha256, unreadable, inputs)


OWN = [node("Sigmoid", ["image"], "all"), node("ReduceMean", ["all"], "strength", axes=[1])]
NODE = node("Abs", ["image"], "strength")
KEY, VALUE = message(1, "location"), message(2, "../../../etc/passwd")
EXTERNAL = {
    "usual": KEY + VALUE,
    "value first": VALUE + KEY,
    "between others": message(9, "x") + KEY + message(9, "x") + VALUE,
    "long form of a number": KEY.replace(b"\x08", b"\x88\x80\x00") + VALUE,
}
"""How a file may write what a reader of protocol buffers takes for the same."""


@pytest.mark.parametrize("external", EXTERNAL.values(), ids=EXTERNAL)
@pytest.mark.parametrize("place", ["initialiser", "attribute", "subgraph", "sparse", "function"])
def test_weights_in_other_files_are_refused_wherever_they_are_named(external, place):
    weights = tensor(message(13, external))
    graph = {
        "initialiser": message(1, NODE) + message(5, weights),
        "attribute": message(1, NODE + message(5, message(1, "value") + message(5, weights))),
        "subgraph": message(1, NODE + message(5, message(6, message(5, weights)))),
        "sparse": message(15, message(2, weights)),
        "function": message(1, NODE),
    }[place]
    function = message(25, message(7, node("Constant", [], "c") + message(5, message(5, weights))))
    content = number(1, 8) + message(7, graph) + (function if place == "function" else b"")
    with pytest.raises(FormatError, match=r"w\.onnx reads weights from other files"):
        EdgeNetwork.read(np.frombuffer(content, np.uint8), Path("w.onnx"))


def test_the_bundled_networks_are_known_and_run_here_others_in_a_child(monkeypatch):
    for line in asset_path("models/SHA256SUMS").read_text().splitlines():
        sha256, name = line.split()
        assert hashlib.sha256(asset_path(f"models/{name}").read_bytes()).hexdigest() == sha256, f"SHA256SUMS: {name}"
    picture = np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)
    # other bytes, same network: a field that nobody knows at the end
    other = np.frombuffer(asset_path("models/edges.onnx").read_bytes() + number(2**20, 7), np.uint8)
    there = EdgeNetwork.read(other, Path("own.onnx")).strength(picture)
    monkeypatch.setattr("ilf._runtime.children.run_in_child", None)
    here = EdgeNetwork.load(asset_path("models/edges.onnx")).strength(picture)
    assert np.array_equal(here, there), "the same bits"


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_a_network_that_crashes_with_larger_images_is_refused(tmp_path, monkeypatch):
    path = write_network(tmp_path / "own.onnx", OWN)
    small, large = np.zeros((64, 64, 3), np.uint8), np.zeros((200, 300, 3), np.uint8)
    content = np.frombuffer(path.read_bytes() + number(2**20, 7), np.uint8)  # written by tests, that is a bundled one
    network = EdgeNetwork.read(content, path)
    assert network.strength(large).shape == (200, 300)
    monkeypatch.setattr("ilf._runtime.networks.network._outputs_in_child", kill_if_large)
    network.strength(small)
    for _ in range(2):
        with pytest.raises(FormatError, match=r"own\.onnx .* image of about 352 x 256 pixels crashes .SIGKILL"):
            network.strength(large)
    network.strength(small)


PLACES = [
    "info FILE", "complete FILE", "complete FILE FILE", "complete RGB FILE --out OUT", "complete --replay FILE",
    *(f"complete RGB DEPTH --out OUT {flag} FILE" for flag in (
        "--guide", "--blocks", "--drawn", "--invalid-mask", "--ground-truth", "--intrinsics", "--preset",
    )),
    "batch FILE --out OUT", "report FILE --out PAGE", "evaluate FILE", "blocks FILE --out OUT", "bench FILE",
    "project info FILE", "stream FILE --results --out OUT", "project export FILE --to nerfstudio --out OUT",
]  # fmt: skip
"""Commands that take a file, and their options that do."""


@pytest.mark.skipif(not HOSTILE.is_dir(), reason=f"no files that crashed readers in {HOSTILE}")
@pytest.mark.parametrize("words", PLACES)
def test_such_files_in_any_place_give_one_line(words, tmp_path, capsys):
    rgb, depth = write_small_frame(tmp_path)
    before = contents(tmp_path)
    for file in (next(HOSTILE.glob("*.onnx")), next(HOSTILE.glob("*.mat"))):
        meant = {"FILE": file, "RGB": rgb, "DEPTH": depth, "OUT": tmp_path / "out", "PAGE": tmp_path / "a.html"}
        assert main([str(meant.get(word, word)) for word in words.split()]) == 1
        assert capsys.readouterr().err.count("\n") == 1
        assert contents(tmp_path) == before
