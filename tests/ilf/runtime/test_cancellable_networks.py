"""Networks ask between their convolutions whether the work goes on, and say the same as without."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from collections.abc import Callable

import cv2
import numpy as np
import pytest

from ilf._runtime.cancellation import cancelled_by, check_cancelled
from ilf._runtime.installation import asset_path
from ilf._runtime.networks import cancellable as questions
from ilf._runtime.networks.cancellable import CHECK_INPUT, first_input, with_cancellation_checks
from ilf.errors import Cancelled
from ilf.segmentation.edges.detectors import EdgeNetwork

_PEAKS = """
import resource, sys
import cv2, numpy as np
from ilf._runtime.networks.cancellable import CHECK_INPUT, with_cancellation_checks
cv2.setNumThreads(1)
content = np.fromfile(sys.argv[1], np.uint8)
for is_asking in (False, True):
    net = cv2.dnn.readNetFromONNX(with_cancellation_checks(content) if is_asking else content)
    net.setInput(np.zeros((1, 3, 480, 640), np.float32), "image")
    if is_asking:
        net.setInput(np.zeros(1, np.float32), CHECK_INPUT)
    net.forward()
    del net
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""
"""A process that looks at an image without and with questions, and says its peak of memory after each."""

IMAGE = np.random.default_rng(0).integers(0, 256, (64, 96, 3), np.uint8)


@pytest.fixture
def edges() -> EdgeNetwork:
    return EdgeNetwork.load(asset_path("models/edges.onnx"))


def _on_question(monkeypatch: pytest.MonkeyPatch, number: int, do: Callable[[], None]) -> list[int]:
    """Do something at a question, the first being 0; how many have been asked."""
    asked = [0]

    def ask() -> None:
        if asked[0] == number:
            do()
        asked[0] += 1
        check_cancelled()

    monkeypatch.setattr(questions, "check_cancelled", ask)
    return asked


@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("edges", {"image": 3}),
        ("depth-edges", {"image": 3, "depth": 2}),
        ("correction", {"image": 3, "features": 10}),
    ],
)
def test_questions_change_nothing(name: str, inputs: dict[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    content = np.fromfile(asset_path(f"models/{name}.onnx"), np.uint8)
    asked = _on_question(monkeypatch, -1, lambda: None)
    found = []
    for one in (content, with_cancellation_checks(content)):
        net = cv2.dnn.readNetFromONNX(one)
        rng = np.random.default_rng(0)
        for input_name, channels in inputs.items():
            net.setInput(rng.random((1, channels, 64, 96), np.float32), input_name)
        if one is not content:
            net.setInput(np.zeros(1, np.float32), CHECK_INPUT)
        found.append([np.array(output) for output in net.forward(net.getUnconnectedOutLayersNames())])
    for plain, asking in zip(*found, strict=True):
        np.testing.assert_array_equal(asking, plain)
    assert asked[0] > 20
    assert first_input(content) == first_input(with_cancellation_checks(content)) == "image"


@pytest.mark.skipif(sys.platform == "win32", reason="peaks of memory as POSIX tells them")
def test_questions_take_no_memory() -> None:
    """OpenCV's buffers are as many as without; those of a large image take 100 MB each."""
    child = [sys.executable, "-c", _PEAKS, str(asset_path("models/edges.onnx"))]
    plain, asking = map(int, subprocess.run(child, stdout=subprocess.PIPE, check=True).stdout.split())
    assert asking < 1.1 * plain


def test_a_look_stops_at_the_next_question(edges: EdgeNetwork, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = edges.strength(IMAGE)
    for _ in range(3):
        wish = threading.Event()
        asked = _on_question(monkeypatch, 5, wish.set)
        with cancelled_by(wish), pytest.raises(Cancelled):
            edges.strength(IMAGE)
        assert asked == [6], "and no other is asked"
        np.testing.assert_array_equal(edges.strength(IMAGE), whole)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.usefixtures("heard")
def test_a_signal_ends_a_look(edges: EdgeNetwork, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its handler raises in the main thread, and never inside OpenCV, which would never return."""
    whole = edges.strength(IMAGE)
    main_thread = threading.main_thread().ident
    assert main_thread is not None
    stopped = threading.Event()

    def interrupt() -> None:
        signal.pthread_kill(main_thread, signal.SIGINT)
        while not stopped.wait(0.001):
            try:
                check_cancelled()
            except Cancelled:
                stopped.set()

    _on_question(monkeypatch, 5, interrupt)
    with pytest.raises(KeyboardInterrupt):
        edges.strength(IMAGE)
    assert stopped.is_set()
    monkeypatch.undo()
    np.testing.assert_array_equal(edges.strength(IMAGE), whole)
