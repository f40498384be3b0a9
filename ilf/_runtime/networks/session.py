"""Running an ONNX file by ONNX Runtime: same bits for any number of cores, cancellable, without messages of its own."""

from __future__ import annotations

from functools import cache
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from ...errors import Cancelled, InstallationError
from ..cancellation import run_stoppable
from ..silence import silenced

_THREADS = 4
"""Threads of every session, on any machine: results depend on this number in the last digit."""

_FATAL = 4
"""Severity of the messages that are printed: errors are raised."""


class Session:
    """An ONNX network in memory; may be used from any thread.

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
        options.graph_optimization_level = runtime.GraphOptimizationLevel.ORT_ENABLE_ALL
        # waiting threads sleep, and memory is freed after each run
        options.add_session_config_entry("session.intra_op.allow_spinning", "0")
        options.enable_cpu_mem_arena = options.enable_mem_pattern = False
        # no other format of ONNX Runtime, whose references to files are not checked
        options.add_session_config_entry("session.load_model_format", "ONNX")
        options.log_severity_level = _FATAL
        try:
            self._session = runtime.InferenceSession(
                content.tobytes(), options, providers=["CPUExecutionProvider"], enable_fallback=0
            )
        except MemoryError:
            raise
        except Exception as error:  # its exceptions have no other base
            raise ValueError(str(error)) from error
        self.first_input = next((str(one.name) for one in self._session.get_inputs()), "")
        """Name of the first input, "" if there is none."""

    def run(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        """Return all outputs for named inputs.

        Raises
        ------
        ValueError
            If the network does not accept the inputs, or cannot be run.
        Cancelled
            Between two operations of the network.
        """
        options = _runtime().RunOptions()
        options.log_severity_level = _FATAL

        def run() -> list[NDArray[np.float32]]:
            return [np.asarray(one, np.float32) for one in self._session.run(None, inputs, options)]

        def stop() -> None:
            options.terminate = True

        try:
            return run_stoppable(run, stop)
        except (MemoryError, Cancelled):
            raise
        except Exception as error:
            raise ValueError(str(error)) from error


def runtime_version() -> str:
    """Return the version of ONNX Runtime; raise InstallationError if it cannot be imported."""
    return str(_runtime().__version__)


@cache
def _runtime() -> ModuleType:
    """Import ONNX Runtime when a network is first needed."""
    try:
        with silenced():  # of graphics cards that it cannot identify
            import onnxruntime
    except ImportError as error:
        raise InstallationError(
            f"ONNX Runtime, which the networks for edges and correction need, cannot be imported ({error}). Restore: "
            "pip install --force-reinstall onnxruntime. Or run without networks: "
            "--blocks-detector canny --edges canny --no-correction."
        ) from error
    onnxruntime.set_default_logger_severity(_FATAL)
    onnxruntime.disable_telemetry_events()
    return onnxruntime
