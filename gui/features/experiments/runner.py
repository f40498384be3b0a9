"""Running experiments from the window, one after the other."""

from __future__ import annotations

import tempfile
import traceback
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from ilf._runtime.files import ensure_folder
from ilf._runtime.processes import ProcessContext, exit_with_parent
from ilf.errors import ExportError, IlfError, cause
from ilf.lab.experiments.experiment import Progress, Settings
from ilf.lab.experiments.files import write_result
from ilf.lab.experiments.registry import EXPERIMENTS, run_experiment
from ilf.lab.experiments.sources import find_sources

from ...work.jobs import Worker

# Experiments run in a separate process: the window stays responsive, and they can be stopped at any time.

_POLL_S = 0.1
"""Maximum delay of a cancellation [s]."""


@dataclass(frozen=True)
class Writing:
    """Message: an experiment has ended; its files are being written."""

    experiment: str


@dataclass(frozen=True)
class Written:
    """Message: all files of an experiment have been written."""

    experiment: str


Message = Progress | Writing | Written


def run_in_process(names: Sequence[str], settings: Settings, folder: Path) -> Generator[Message | None, None, None]:
    """Run experiments one after the other in another process, which writes their files into a folder.

    Closing the generator stops the process; files that are being written are finished first.

    Parameters
    ----------
    names : sequence of str
    settings : Settings
        `jobs` must be 1: a process that may be terminated must not have child processes.
    folder : Path
        Created if it does not exist.

    Yields
    ------
    Progress, Writing, Written or None
        None if there is no news within the polling interval.

    Raises
    ------
    IlfError, OSError
        The error that ended the run. A crashed process also raises IlfError.
    """
    context = ProcessContext()
    receiving, sending = context.Pipe(duplex=False)
    parent_watch, held = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(tuple(names), settings, folder, sending, parent_watch), daemon=True)
    process.start()
    sending.close()
    parent_watch.close()
    writing = False
    try:
        while True:
            if not receiving.poll(_POLL_S):
                yield None
                continue
            try:
                message = receiving.recv()
            except EOFError:
                break
            if isinstance(message, Exception):
                raise message
            writing = isinstance(message, Writing)
            yield message
        process.join()
        if process.exitcode:
            raise IlfError(
                f"The process of the experiments ended unexpectedly (exit code {process.exitcode}). Memory may have "
                "run out: close other programs, or select a quick run or fewer frames."
            )
    finally:
        receiving.close()  # so that a process that is writing files ends right after them
        if not writing:
            process.terminate()
        process.join()
        process.close()
        held.close()


def _work(
    names: tuple[str, ...], settings: Settings, folder: Path, connection: Connection, parent_watch: Connection
) -> None:
    exit_with_parent(parent_watch.recv_bytes)
    try:
        # report errors of data or folder before any run
        if any(EXPERIMENTS[name].needs_frames for name in names):
            find_sources(settings)
        _check_writable(ensure_folder(folder))
        for name in names:
            connection.send(Progress(name, 0, 0))
            result = run_experiment(name, settings, connection.send)
            connection.send(Writing(name))
            write_result(result, EXPERIMENTS[name], folder)
            connection.send(Written(name))
    except BrokenPipeError:
        return  # the receiver has closed
    except (IlfError, OSError) as error:
        connection.send(error)
    except Exception as error:
        traceback.print_exc()
        connection.send(IlfError(f"{type(error).__name__}: {error}"))


def _check_writable(folder: Path) -> None:
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise ExportError(f"Cannot write to {folder}: {cause(error)}. Choose another folder.") from error


class ExperimentRunner(QObject):
    """Starts and cancels experiments, and reports their progress.

    Signals
    -------
    changed()
        `present`, `waiting` or `progress` has changed.
    written(str)
        The files of an experiment have been written.
    ended(str)
        The run is over: "finished", "cancelled" or "failed".
    failed(str, object)
        The experiment that failed, or "", and the exception; emitted after `ended`.
    """

    changed = Signal()
    written = Signal(str)
    ended = Signal(str)
    failed = Signal(str, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._worker = Worker(self, must_finish=True)  # it ends with the process
        self._worker.progressed.connect(self._take)
        self._worker.finished.connect(lambda _: self._end("finished"))
        self._worker.cancelled.connect(lambda: self._end("cancelled"))
        self._worker.failed.connect(self._fail)
        self._forget()

    def _forget(self) -> None:
        self.names: tuple[str, ...] = ()
        """All experiments of the run."""
        self.present = ""
        """The running experiment."""
        self.progress: Progress | None = None
        self.writing = False
        self.cancelling = False
        self._done: set[str] = set()

    @property
    def busy(self) -> bool:
        """Whether a run is in progress."""
        return self._worker.busy

    @property
    def waiting(self) -> set[str]:
        """Experiments of the run that have not started."""
        return set(self.names) - self._done - {self.present}

    def start(self, names: Sequence[str], settings: Settings, folder: Path) -> None:
        """Run experiments; RuntimeError if a run is in progress."""
        self._worker.start(lambda: run_in_process(names, settings, folder))
        self._forget()
        self.names = tuple(names)
        self.changed.emit()

    def cancel(self) -> None:
        """Stop immediately; completed experiments keep their files."""
        if self.busy:
            self.cancelling = True
            self._worker.cancel()
            self.changed.emit()

    def shutdown(self) -> bool:
        """Cancel and wait for the process, without further signals. True if it has ended."""
        ended = self._worker.shutdown()
        self._forget()
        return ended

    def _take(self, batch: list[Message | None]) -> None:
        for message in batch:
            if message is None:
                continue
            self.present = message.experiment
            self.writing = isinstance(message, Writing)
            if isinstance(message, Progress):
                self.progress = message
            elif isinstance(message, Written):
                self._done.add(message.experiment)
                self.present = ""
                self.written.emit(message.experiment)
        if any(batch):
            self.changed.emit()

    def _end(self, how: str) -> None:
        self._forget()
        self.changed.emit()
        self.ended.emit(how)

    def _fail(self, error: Exception) -> None:
        broken = self.present
        self._end("failed")
        self.failed.emit(broken, error)
