"""ONNX Runtime: an ONNX file in memory, run with the same bits on any number of cores, cancellable, and silent."""

from __future__ import annotations

from functools import cache
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from ...errors import InstallationError
from ..cancellation import run_aside
from ..silence import silenced

_THREADS = 4
"""Threads of every session, whatever the machine and the program's other threads: operations are divided among them,
and how they are divided decides the last digits of results."""

_FATAL = 4
"""Minimum severity of the messages that are printed; errors are raised."""


class RefusedInputError(Exception):
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
    InstallationError
        If ONNX Runtime cannot be imported.
    """

    def __init__(self, content: NDArray[np.uint8]) -> None:
        runtime = _runtime()
        options = runtime.SessionOptions()
        options.intra_op_num_threads = _THREADS
        options.inter_op_num_threads = 1
        options.add_session_config_entry("session.intra_op.allow_spinning", "0")
        # otherwise the memory of the largest run so far would be kept
        options.enable_cpu_mem_arena = options.enable_mem_pattern = False
        # its own format may refer to other files, too
        options.add_session_config_entry("session.load_model_format", "ONNX")
        options.log_severity_level = _FATAL
        try:
            self._session = runtime.InferenceSession(
                content.tobytes(), options, providers=["CPUExecutionProvider"], enable_fallback=0
            )
        except Exception as error:  # of many types without a common base
            raise ValueError(str(error)) from error
        shapes = {str(one.name): one.shape for one in self._session.get_inputs()}
        self.first_input, shape = next(iter(shapes.items()), ("", ()))
        """Name of the first input, "" if there is none."""
        self.first_shape = tuple(side if isinstance(side, int) else None for side in shape)
        """Its shape; None where the size is free."""
        self.outputs = tuple(str(one.name) for one in self._session.get_outputs())
        """Names of the outputs."""

    def run(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        """Return all outputs for named inputs.

        Raises
        ------
        RefusedInputError
            If the network does not accept the inputs.
        Cancelled
            At the end of the operation that runs when the work is cancelled.
        """
        options = _runtime().RunOptions()
        options.log_severity_level = _FATAL

        def run() -> list[NDArray[np.float32]]:
            try:
                return [np.asarray(one, np.float32) for one in self._session.run(None, inputs, options)]
            except Exception as error:  # of many types without a common base
                raise RefusedInputError(str(error)) from error

        def stop() -> None:
            options.terminate = True

        return run_aside(run, stop)


def runtime_version() -> str:
    """Return the version of ONNX Runtime; raise InstallationError if it cannot be imported."""
    return str(_runtime().__version__)


def _runtime() -> ModuleType:
    """Import ONNX Runtime; raise InstallationError if it cannot be imported."""
    try:
        return _imported()
    except (ImportError, OSError) as error:
        raise InstallationError(
            f"ONNX Runtime, which the networks for edges and correction need, cannot be loaded ({error}). Restore: "
            'pip install --force-reinstall "onnxruntime>=1.20,<2". Or run without networks: '
            "--blocks-detector canny --edges canny --no-correction."
        ) from error


@cache
def _imported() -> ModuleType:
    with silenced():  # it warns of graphics cards that it cannot identify
        import onnxruntime
    onnxruntime.set_default_logger_severity(_FATAL)
    onnxruntime.disable_telemetry_events()
    return onnxruntime
