"""ONNX Runtime: an ONNX file in memory, run with the same bits on any number of cores, cancellable, and silent."""

from __future__ import annotations

import contextlib
import io
import math
import os
import threading
from collections.abc import Iterator
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError, InputError, InstallationError, told_as
from ..cancellation import run_aside
from ..memory import MIN_PIXELS_TO_RELEASE

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


@contextlib.contextmanager
def _silenced() -> Iterator[None]:
    """Discard what is printed during the block, by Python to stdout and by native code to stderr."""
    with _silent, contextlib.redirect_stdout(io.StringIO()), contextlib.ExitStack() as after:
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
