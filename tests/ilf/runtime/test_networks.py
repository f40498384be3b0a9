"""Inference can be cancelled, says the same with any number of threads, and keeps no memory."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest

from ilf._runtime.cancellation import cancelled_by
from ilf._runtime.installation import asset_path
from ilf._runtime.networks import network as networks
from ilf.errors import Cancelled
from ilf.segmentation.edges.detectors import EdgeNetwork

IMAGE = np.random.default_rng(0).integers(0, 256, (960, 1280, 3), np.uint8)
"""Large, so that inference takes many times as long as cancellation."""

SMALL = IMAGE[:64, :96]


class Watched:
    """An inference session that does something when it begins to run, and records whether it ran to its end."""

    def __init__(self, session: Any, begin: Callable[[], None]) -> None:
        self._session, self._begin = session, begin
        self.ended: list[bool] = []

    def run(self, *given: Any) -> Any:
        self.ended.append(False)
        self._begin()
        found = self._session.run(*given)
        self.ended[-1] = True
        return found


@pytest.fixture
def edges() -> EdgeNetwork:
    return EdgeNetwork.load(asset_path("models/edges.onnx"))


def watched(edges: EdgeNetwork, monkeypatch: pytest.MonkeyPatch, begin: Callable[[], None]) -> Watched:
    session = Watched(edges._session, begin)
    monkeypatch.setattr(edges, "_session", session)
    return session


def test_inference_that_is_cancelled_ends_at_once_and_the_next_is_as_ever(
    edges: EdgeNetwork, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = edges.strength(SMALL)
    wish = threading.Event()
    session = watched(edges, monkeypatch, wish.set)
    with cancelled_by(wish), pytest.raises(Cancelled):
        edges.strength(IMAGE)
    assert session.ended == [False]
    np.testing.assert_array_equal(edges.strength(SMALL), before)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.usefixtures("heard")
def test_a_signal_ends_inference(edges: EdgeNetwork, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its handler raises in the main thread, which waits."""
    before = edges.strength(SMALL)
    main_thread = threading.main_thread().ident
    assert main_thread is not None
    session = watched(edges, monkeypatch, lambda: signal.pthread_kill(main_thread, signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        edges.strength(IMAGE)
    assert session.ended == [False]
    monkeypatch.undo()
    np.testing.assert_array_equal(edges.strength(SMALL), before)


def test_the_number_of_threads_changes_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(networks, "_networks", {})
    threads = cv2.getNumThreads()
    found = []
    try:
        for count in (1, 2, 3):
            cv2.setNumThreads(count)
            network = EdgeNetwork.load(asset_path("models/edges.onnx"))
            assert network._session.get_session_options().intra_op_num_threads == count
            found.append(network.strength(IMAGE[:256, :320]))
    finally:
        cv2.setNumThreads(threads)
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])


def test_a_network_that_does_not_accept_its_input_says_so(edges: EdgeNetwork) -> None:
    with pytest.raises(networks.RefusedInputError, match="image"):
        edges._forward({"": np.zeros((1, 4, 64, 64), np.float32)})
    with pytest.raises(networks.RefusedInputError):
        edges._forward({"another": np.zeros((1, 3, 64, 64), np.float32)})
