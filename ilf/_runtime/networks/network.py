"""ONNX networks, bundled and imported, run by ONNX Runtime: with the same bits on any number of cores, from any thread,
cancellable, and silent."""

from __future__ import annotations

import hashlib
import io
import math
import os
import re
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stdout, suppress
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError, IlfError, InputError, InstallationError, told_as
from ..files import read_file
from ..installation import asset_path
from ..long_work import run_aside
from ..memory import MIN_PIXELS_TO_RELEASE, memory_limit

Answer = TypeVar("Answer")

# A file in memory, ready to run.

_THREADS = 4
"""Threads of every session, whatever the machine and the program's other threads: operations are divided among them,
and how they are divided decides the last digits of results."""

DEVICES: dict[str, tuple[str, str, dict[str, Any]]] = {
    "cpu": ("onnxruntime", "CPUExecutionProvider", {}),
    # not in the format TF32, whose rounding is coarser than float32's
    "cuda": ("onnxruntime-gpu", "CUDAExecutionProvider", {"use_tf32": 0}),
    "directml": ("onnxruntime-directml", "DmlExecutionProvider", {}),
}
"""Device that can run networks -> the distribution of ONNX Runtime for it, and its provider there, with options."""

DEVICE_VARIABLE = "ILF_DEVICE"
"""Environment variable with the device, so that worker processes inherit it."""

_FATAL = 4
"""Minimum severity of the messages that are printed; errors are raised."""


class RefusedInputError(FormatError):
    """Error: a network does not accept its inputs."""


class Session:
    """An ONNX network, ready to run from any thread.

    Parameters
    ----------
    content : ndarray of uint8
        Content of its file.

    Raises
    ------
    ValueError
        If it cannot be read.
    InputError
        If the chosen device is unknown.
    InstallationError
        If ONNX Runtime cannot be imported, or cannot use the chosen device.
    """

    def __init__(self, content: NDArray[np.uint8]) -> None:
        runtime = _runtime()
        _, *provider = DEVICES[device()]
        if provider[0] not in runtime.get_available_providers():
            raise _unusable(device())
        options = runtime.SessionOptions()
        options.intra_op_num_threads = _THREADS
        options.inter_op_num_threads = 1
        options.add_session_config_entry("session.intra_op.allow_spinning", "0")
        options.enable_mem_pattern = False  # it would make room for the largest run so far
        # its own format may refer to other files, too
        options.add_session_config_entry("session.load_model_format", "ONNX")
        options.log_severity_level = _FATAL
        try:
            self._session = runtime.InferenceSession(
                content.tobytes(), options, providers=[tuple(provider)], enable_fallback=0
            )
        except Exception as error:  # of many types without a common base
            raise ValueError(str(error)) from error
        if provider[0] not in self._session.get_providers():  # its libraries or the card are missing
            raise _unusable(device())
        shapes = {str(one.name): one.shape for one in self._session.get_inputs()}
        self.first_input, shape = next(iter(shapes.items()), ("", ()))
        """Name of the first input, "" if there is none."""
        self.first_shape = tuple(side if isinstance(side, int) else None for side in shape)
        """Its shape; None where the size is free."""
        self.outputs = tuple(str(one.name) for one in self._session.get_outputs())
        """Names of the outputs."""

    def run(self, inputs: dict[str, NDArray[np.float32]], keep_memory: bool = False) -> list[NDArray[np.float32]]:
        """Return all outputs for named inputs.

        Parameters
        ----------
        inputs : dict of str to ndarray of float32, shape (..., H, W)
        keep_memory : bool
            Whether the memory that operations take over from each other is kept for the next run if the inputs are
            small; else it is given back at the end.

        Raises
        ------
        RefusedInputError
            If the network does not accept the inputs.
        Cancelled
            At the end of the operation that runs when the work is cancelled.
        """
        options = _runtime().RunOptions()
        options.log_severity_level = _FATAL
        pixels = max(math.prod(one.shape[-2:]) for one in inputs.values())
        if not keep_memory or pixels >= MIN_PIXELS_TO_RELEASE:
            options.add_run_config_entry("memory.enable_memory_arena_shrinkage", "cpu:0")

        def run() -> list[NDArray[np.float32]]:
            try:
                return [np.asarray(one, np.float32) for one in self._session.run(None, inputs, options)]
            except Exception as error:  # of many types without a common base
                raise RefusedInputError(str(error)) from error

        def stop() -> None:
            options.terminate = True

        return run_aside(run, stop)


def device() -> str:
    """Return the device that runs networks, from the environment variable ILF_DEVICE; the default is "cpu".

    Raises
    ------
    InputError
        If there is no such device.
    """
    chosen = os.environ.get(DEVICE_VARIABLE) or "cpu"
    if chosen not in DEVICES:
        raise InputError(f"{DEVICE_VARIABLE} must be {', '.join(DEVICES)}, not {chosen!r:.40}: correct the variable.")
    return chosen


def _unusable(name: str) -> InstallationError:
    return InstallationError(
        f"ONNX Runtime cannot run networks on the device {name!r}. Install {DEVICES[name][0]} in its place, with "
        "the drivers that its page names, or choose the device 'cpu'."
    )


@cache
def _runtime() -> ModuleType:
    """Import ONNX Runtime; raise InstallationError if it cannot be imported."""
    with (
        told_as(
            InstallationError,
            "ONNX Runtime, which the networks for edges and correction need, cannot be loaded ({error}). Restore: "
            'pip install --force-reinstall "onnxruntime>=1.20,<2". Or run without networks: '
            "--blocks-detector canny --edges canny --no-correction.",
            (ImportError, OSError),
        ),
        _silenced(),
    ):  # it warns of graphics cards that it cannot identify
        import onnxruntime
    onnxruntime.set_default_logger_severity(_FATAL)
    onnxruntime.disable_telemetry_events()
    return onnxruntime


# stdout and stderr are global to the process
_silent = threading.Lock()


@contextmanager
def _silenced() -> Iterator[None]:
    """Discard what is printed during the block, by Python to stdout and by native code to stderr."""
    with _silent, redirect_stdout(io.StringIO()), ExitStack() as after:
        try:
            kept = os.dup(2)
        except OSError:  # a program without a terminal may have no stderr
            yield
            return
        after.callback(os.close, kept)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        after.callback(os.close, nowhere)
        os.dup2(nowhere, 2)
        after.callback(os.dup2, kept, 2)
        yield


# Kinds of networks, read from files and tried; those of users run in a child.

_IN_OTHER_FILE = re.compile(rb"location(?<=[\x08\0]location)")
"""How weights in another file are named, wherever it stands: the word and its length, which may be written longer."""

TRIAL_S, _LONGEST_S = 30.0, 3600.0
"""Limits of the processor time of a network of the user for small images, as it is tried with, and for others [s]."""

_SMALL = 200 * 200
"""Number of pixels up to which an image is small."""

_READ_BYTES_PER_S = 4_000_000
"""Rate at which the slowest computers read a network."""


@cache
def _bundled() -> frozenset[str]:
    """The hashes of the bundled networks."""
    sums = asset_path("models/SHA256SUMS").read_text(encoding="ascii")
    return frozenset(line.split()[0] for line in sums.splitlines())


_networks: dict[tuple[type, Path, str], tuple[tuple[int, int], OnnxNetwork]] = {}
"""Kind, file and device -> version of the file, and the network."""

_networks_lock = threading.Lock()


class OnnxNetwork:
    """A network, ready to run. Create one by `load`; it may be used from any thread."""

    KIND: ClassVar[str] = "edge network"
    """Name of this kind of network in messages."""

    NAME: ClassVar[str]
    """Name of the network of this kind that comes with the program."""

    INSTEAD: ClassVar[str] = ", or the Canny detector"
    """What can be chosen instead of a network of this kind, in messages."""

    def __init__(self, session: Session | SessionInChild, path: Path, sha256: str) -> None:
        self._session = session
        self.path = path
        self.sha256 = sha256
        """Hash of the bytes that the network was read from, in hexadecimal digits."""
        self._try()

    @classmethod
    def bundled(cls) -> Self:
        """Load the network that comes with the program; raises errors as `load`."""
        return cls.load(asset_path(f"models/{cls.NAME}.onnx"))

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Load the network of a file, read once and cached until the file changes.

        Parameters
        ----------
        path : str or Path
            An ONNX file, as described by the class.

        Raises
        ------
        InputError
            If the file does not exist.
        FormatError
            If it is not an ONNX network, or not one of this kind.
        InstallationError
            As for `read`.
        """
        path = Path(path).resolve()
        if not os.path.isfile(path):
            raise InputError(f"There is no {cls.KIND} at {path}. Choose an ONNX file{cls.INSTEAD}.")
        status = path.stat()
        version = (status.st_mtime_ns, status.st_size)
        key = (cls, path, device())
        with _networks_lock:
            known = _networks.get(key)
            if known is None or known[0] != version:
                known = _networks[key] = (version, cls.read(read_file(path).data, path))
            assert isinstance(known[1], cls)
            return known[1]

    @classmethod
    def read(cls, content: NDArray[np.uint8], path: Path) -> Self:
        """Read the network in a file's content and test it with small images, without caching it.

        All but the bundled ones run in a child, since they can crash the program.

        Parameters
        ----------
        content : ndarray of uint8
        path : Path
            The file it comes from, for messages.

        Raises
        ------
        FormatError
            If it is not an ONNX network, not one of this kind, reads weights from other files, or crashes the reader.
        InstallationError
            If ONNX Runtime cannot be imported: then the file is not the cause, and no other detector is used instead.
        """
        sha256 = hashlib.sha256(content.data).hexdigest()
        remedy = f"Choose an intact ONNX file with its weights{cls.INSTEAD}."
        unreadable = f"{path.name} cannot be read as an ONNX network. {remedy}"
        if sha256 in _bundled():
            return cls(Session(content), path, sha256)
        if _IN_OTHER_FILE.search(content.data):
            problem = "reads weights from other files, or names something 'location' as such weights are named"
            raise FormatError(f"{path.name} {problem}: not allowed. Export it as one file, without that name.")
        return cls(SessionInChild(content, path.name, sha256, unreadable), path, sha256)

    def _forward(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        """Return all outputs; raise RefusedInputError if the network does not accept these inputs, another FormatError
        if it crashes with them. "" is the first input."""
        named = {name or self._session.first_input: values for name, values in inputs.items()}
        try:
            return self._session.run(named, keep_memory=True)
        except RefusedInputError as error:
            taken = " and ".join(str(values.shape) for values in inputs.values())
            raise RefusedInputError(self._unlike(f"it does not accept inputs of shape {taken}.")) from error

    def _unlike(self, why: str) -> str:
        """The message of an error: the network is not of this kind."""
        return f"{self.path.name} is not a{'n' * (self.KIND[0] in 'aeiou')} {self.KIND}: {why}"

    def _try(self) -> None:
        """Raise FormatError for a network that is not of this kind, before it is used."""
        raise NotImplementedError


class SessionInChild:
    """A network of the user, which runs in a child that it may crash, exhaust or block; otherwise as `Session`.

    Parameters
    ----------
    content : ndarray of uint8
    file : str
        Its name, for messages.
    sha256 : str
    unreadable : str
        Message of the FormatError if it cannot be read.
    """

    def __init__(self, content: NDArray[np.uint8], file: str, sha256: str, unreadable: str) -> None:
        self._content, self._file = content, file
        self._network = sha256, unreadable
        self.first_input, self.first_shape, self.outputs = self._ask(_facts_in_child, 0, "running it")

    def run(self, inputs: dict[str, NDArray[np.float32]], keep_memory: bool = False) -> list[NDArray[np.float32]]:
        """As `Session.run`; those of users may need gigabytes, which are never kept."""
        height, width = max((one.shape[-2:] for one in inputs.values()), key=math.prod)
        size = f" on an image of about {width} x {height} pixels" if height * width > _SMALL else ""
        return self._ask(_outputs_in_child, height * width, f"running it{size}", inputs)

    def _ask(self, function: Callable[..., Answer], pixels: int, doing: str, *arguments: object) -> Answer:
        from ..children import MEMORY, run_in_child  # not before: few networks are not bundled

        # a large one takes its time to reach the child, and is there several times while it is read
        size = self._content.nbytes
        seconds, memory = TRIAL_S + size // _READ_BYTES_PER_S, MEMORY + 4 * size
        if pixels > _SMALL:
            seconds, memory = _LONGEST_S, int(memory_limit())
        limits: dict[str, Any] = {"seconds": seconds, "memory": memory, "doing": doing}
        with suppress(_NotOpenError):
            return run_in_child(function, None, *self._network, *arguments, file=self._file, **limits)
        return run_in_child(function, self._content, *self._network, *arguments, file=self._file, **limits)


# The child's side.

_sessions: dict[tuple[str, str], Session] = {}
"""Hash and device -> network."""


class _NotOpenError(IlfError):
    """The child needs the content of the network."""


def _session_in_child(content: NDArray[np.uint8] | None, sha256: str, unreadable: str) -> Session:
    key = sha256, device()
    if key not in _sessions:
        if content is None:
            raise _NotOpenError(unreadable)
        with told_as(FormatError, unreadable, ValueError):
            _sessions[key] = Session(content)
    return _sessions[key]


def _facts_in_child(*network: Any) -> tuple[str, tuple[int | None, ...], tuple[str, ...]]:
    session = _session_in_child(*network)
    return session.first_input, session.first_shape, session.outputs


def _outputs_in_child(
    content: NDArray[np.uint8] | None, sha256: str, unreadable: str, inputs: dict[str, NDArray[np.float32]]
) -> list[NDArray[np.float32]]:
    return _session_in_child(content, sha256, unreadable).run(inputs)


def trial_images() -> Iterator[NDArray[np.uint8]]:
    """Yield the small images with which networks are tried."""
    for height, width in ((64, 64), (64, 96)):
        yield np.linspace(0, 255, height * width * 3).astype(np.uint8).reshape(height, width, 3)


def reflected(
    image: NDArray[np.generic], multiple: int, margin: int = 0, axis: int = 0
) -> tuple[NDArray, tuple[slice, slice]]:
    """Pad an image by reflection at its borders, to sides that are multiples of a number.

    Parameters
    ----------
    image : ndarray, shape (..., H, W, ...)
    multiple : int
    margin : int
        Minimum padding on every side [px].
    axis : int
        The axis of the rows; the next is that of the columns.

    Returns
    -------
    padded : ndarray
        The image itself if nothing is to be padded.
    window : (slice, slice)
        Rows and columns of the image within the padded one.
    """
    height, width = image.shape[axis : axis + 2]
    sides = (length + 2 * margin for length in (height, width))
    after = (side + -side % multiple - margin - length for side, length in zip(sides, (height, width), strict=True))
    added = np.zeros((image.ndim, 2), int)
    added[axis : axis + 2] = [(margin, size) for size in after]
    padded = np.pad(image, added, mode="reflect") if added.any() else image
    return padded, (slice(margin, margin + height), slice(margin, margin + width))


def as_input(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Convert an RGB image (H, W, 3) to the input of a network, in [0, 1], shape (1, 3, H, W)."""
    return np.moveaxis(image.astype(np.float32) * np.float32(1 / 255), 2, 0)[None]
