"""Running experiments from the window: some at a time, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from gui.experiments.process import Message, Writing, Written, run_apart
from gui.work.worker import Worker
from ilf.experiments import Progress, Settings


class ExperimentRunner(QObject):
    """Starts and cancels; says how far it is.

    Signals
    -------
    changed()
        `present`, `waiting` or `progress` has changed.
    written(str)
        The files of an experiment are there.
    ended(str)
        The run is over: "finished", "cancelled" or "failed".
    failed(str, object)
        The experiment that broke, or "", and the exception; `ended` has come before.
    """

    changed = Signal()
    written = Signal(str)
    ended = Signal(str)
    failed = Signal(str, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._worker = Worker(self, finishes=True)  # its end is that of the process
        self._worker.progressed.connect(self._take)
        self._worker.finished.connect(lambda _: self._end("finished"))
        self._worker.cancelled.connect(lambda: self._end("cancelled"))
        self._worker.failed.connect(self._fail)
        self._forget()

    def _forget(self) -> None:
        self.names: tuple[str, ...] = ()
        """All experiments of the run."""
        self.present = ""
        """The one that is being run."""
        self.progress: Progress | None = None
        self.writing = False
        self.stopping = False
        self._done: set[str] = set()

    @property
    def busy(self) -> bool:
        """Whether a run is under way."""
        return self._worker.busy

    @property
    def waiting(self) -> set[str]:
        """Experiments of the run that have not begun."""
        return set(self.names) - self._done - {self.present}

    def start(self, names: Sequence[str], settings: Settings, folder: Path) -> None:
        """Run experiments; RuntimeError if a run is under way."""
        self._worker.start(lambda: run_apart(names, settings, folder))
        self._forget()
        self.names = tuple(names)
        self.changed.emit()

    def cancel(self) -> None:
        """Stop at once; experiments that are done keep their files."""
        if self.busy:
            self.stopping = True
            self._worker.cancel()
            self.changed.emit()

    def shutdown(self) -> bool:
        """Cancel and wait for the process. True if it has ended; no signal follows."""
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
