"""Inference can be cancelled, gives the same bits on any number of cores, keeps no memory and prints nothing."""

import os
import signal
import subprocess
import sys
import threading

import cv2
import numpy as np
import onnxruntime
import pytest

from ilf._runtime.installation import asset_path
from ilf._runtime.long_work import cancelled_by
from ilf._runtime.networks.network import RefusedInputError, Session
from ilf.errors import Cancelled, InputError, InstallationError
from ilf.segmentation.edges.detectors import EdgeNetwork

from ..tiny_onnx import node, write_network

IMAGE = np.random.default_rng(0).integers(0, 256, (960, 1280, 3), np.uint8)
"""Large, so that inference takes many times as long as cancellation."""

SMALL = IMAGE[:64, :96]

BUNDLED = {"edges": {"image": 3}, "depth-edges": {"image": 3, "depth": 6}, "correction": {"image": 3, "features": 10}}
"""Inputs of the bundled networks, and their channels."""


class Watched:
    """An inference session that does something when it begins to run, and records whether it ran to its end."""

    def __init__(self, session, begin):
        self._session, self._begin = session, begin
        self.ended = []

    def run(self, *given):
        self.ended.append(False)
        self._begin()
        found = self._session.run(*given)
        self.ended[-1] = True
        return found


@pytest.fixture
def edges():
    return EdgeNetwork.load(asset_path("models/edges.onnx"))


def watched(edges, monkeypatch, begin):
    session = Watched(edges._session._session, begin)
    monkeypatch.setattr(edges._session, "_session", session)
    return session


def test_inference_that_is_cancelled_ends_at_once_and_the_next_is_as_ever(edges, monkeypatch):
    before = edges.strength(SMALL)
    wish = threading.Event()
    session = watched(edges, monkeypatch, wish.set)
    with cancelled_by(wish), pytest.raises(Cancelled):
        edges.strength(IMAGE)
    assert session.ended == [False]
    np.testing.assert_array_equal(edges.strength(SMALL), before)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.usefixtures("heard")
def test_a_signal_ends_inference(edges, monkeypatch):
    """Its handler raises in the main thread, which waits."""
    before = edges.strength(SMALL)
    main_thread = threading.main_thread().ident
    session = watched(edges, monkeypatch, lambda: signal.pthread_kill(main_thread, signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        edges.strength(IMAGE)
    for thread in threading.enumerate():  # it may have come while the thread was started
        if thread.name.startswith("ilf-aside"):
            thread.join()
    assert session.ended == [False]
    monkeypatch.undo()
    np.testing.assert_array_equal(edges.strength(SMALL), before)


def _inputs(name):
    rng = np.random.default_rng(0)
    return {key: rng.random((1, channels, 160, 224), np.float32) for key, channels in BUNDLED[name].items()}


@pytest.mark.parametrize("name", BUNDLED)
def test_a_network_gives_what_opencv_computes(name):
    path, inputs = asset_path(f"models/{name}.onnx"), _inputs(name)
    net = cv2.dnn.readNetFromONNX(str(path))
    for key, values in inputs.items():
        net.setInput(values, key)
    expected = net.forward(net.getUnconnectedOutLayersNames())
    found = Session(np.fromfile(path, np.uint8)).run(inputs)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-4, atol=1e-5)


_BITS = """
import os, sys
import numpy as np
if sys.argv[3] == "one core":
    os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])
import cv2
cv2.setNumThreads(1 if sys.argv[3] == "one core" else 8)
from ilf._runtime.networks.network import Session
content, inputs = np.fromfile(sys.argv[1], np.uint8), dict(np.load(sys.argv[2]))
for one in Session(content).run(inputs):
    sys.stdout.buffer.write(one.tobytes())
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="cores cannot be taken away")
def test_the_number_of_cores_changes_no_bit(tmp_path):
    """The correction network differs in the last digit between one and two threads of a session."""
    path, inputs = asset_path("models/correction.onnx"), _inputs("correction")
    np.savez(tmp_path / "inputs.npz", **inputs)
    here = b"".join(one.tobytes() for one in Session(np.fromfile(path, np.uint8)).run(inputs))
    for cores in ("one core", "all cores"):
        child = [sys.executable, "-c", _BITS, str(path), str(tmp_path / "inputs.npz"), cores]
        assert subprocess.run(child, stdout=subprocess.PIPE, check=True).stdout == here


def test_an_unknown_device_is_named(monkeypatch):
    monkeypatch.setenv("ILF_DEVICE", "tpu")
    with pytest.raises(InputError, match="ILF_DEVICE must be cpu, cuda, directml, not 'tpu'"):
        EdgeNetwork.load(asset_path("models/edges.onnx"))


@pytest.mark.parametrize("listed", [False, True], ids=("another distribution", "without its libraries"))
def test_a_device_that_cannot_be_used_is_named(listed, monkeypatch):
    monkeypatch.setenv("ILF_DEVICE", "cuda")
    if listed:  # then sessions use the processor instead
        start = onnxruntime.InferenceSession
        monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: ["CUDAExecutionProvider"])
        monkeypatch.setattr(onnxruntime, "InferenceSession", lambda content, options, **_: start(content, options))
    with pytest.raises(InstallationError, match="Install onnxruntime-gpu in its place"):
        EdgeNetwork.load(asset_path("models/edges.onnx"))


def test_a_network_that_does_not_accept_its_input_says_so(edges):
    with pytest.raises(RefusedInputError, match=r"does not accept inputs of shape \(1, 4, 64, 64\)"):
        edges._forward({"": np.zeros((1, 4, 64, 64), np.float32)})
    with pytest.raises(RefusedInputError):
        edges._forward({"another": np.zeros((1, 3, 64, 64), np.float32)})


def _twisted(content):
    return content.replace(b"Conv", b"Cons")


@pytest.mark.parametrize(
    "change",
    [_twisted, lambda content: content[:5000], lambda content: b"", lambda content: b"\xff" * 64],
    ids=["unknown operation", "truncated", "empty", "no network"],
)
def test_files_that_cannot_be_read_print_nothing(change, capfd):
    content = change(asset_path("models/edges.onnx").read_bytes())
    with pytest.raises(ValueError):
        Session(np.frombuffer(content, np.uint8))
    assert capfd.readouterr() == ("", "")


def test_files_of_another_format_are_refused(tmp_path):
    """ONNX Runtime's own format may refer to other files, too."""
    options = onnxruntime.SessionOptions()
    options.optimized_model_filepath = str(tmp_path / "own.ort")
    options.add_session_config_entry("session.save_model_format", "ORT")
    path = write_network(tmp_path / "own.onnx", [node("Sigmoid", ["image"], "strength")])
    onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    content = np.fromfile(tmp_path / "own.ort", np.uint8)
    assert onnxruntime.InferenceSession(content.tobytes(), providers=["CPUExecutionProvider"]).get_inputs()
    with pytest.raises(ValueError):
        Session(content)


_NOISY = """
import os
os.write(2, b"[W:onnxruntime:Default] GPU device discovery failed\\n")
raise ImportError("DLL load failed")
"""


def test_what_the_import_prints_is_not_shown(tmp_path):
    (tmp_path / "onnxruntime.py").write_text(_NOISY)
    code = "from ilf._runtime.networks.network import _runtime; _runtime()"
    paths = os.pathsep.join([str(tmp_path), *sys.path])
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | {"PYTHONPATH": paths}, capture_output=True, text=True
    )
    assert "InstallationError: ONNX Runtime, which the networks for edges and correction need" in done.stderr
    assert "DLL load failed" in done.stderr
    assert "GPU device" not in done.stderr
