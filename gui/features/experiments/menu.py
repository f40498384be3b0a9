"""The menu of the paper's experiments, and their window, created on first use."""

from __future__ import annotations

from collections.abc import Generator
from importlib import import_module
from typing import TYPE_CHECKING

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QMenu, QWidget

from ...work.jobs import Worker
from ..context import Context, Feature, PendingWork

if TYPE_CHECKING:
    from .window import ExperimentsWindow

_LOAD_AFTER_MS = 1500
"""Delay [ms], so that the first frame is shown before."""


class ExperimentsMenu(QMenu):
    """Menu with an entry per experiment and one for all. Opening it loads the experiments if needed.

    Signals
    -------
    message(str)
        Status of a run while its window is closed.
    """

    message = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("E&xperiments", parent)
        self.window_: ExperimentsWindow | None = None
        self.setToolTipsVisible(True)
        self._end = self.addSeparator()
        self._filled = False
        all_quick = self.addAction("Run all (&quick)")
        all_quick.setToolTip("Run every experiment with few points, and compare the results with the paper")
        all_quick.triggered.connect(lambda _=False: self._shown().run_all_quick())
        self.aboutToShow.connect(self.fill)
        self._loader = Worker(self)
        self._loading = QTimer(self, singleShot=True, interval=_LOAD_AFTER_MS)
        self._loading.timeout.connect(lambda: self._loader.start(_load))

    def load_soon(self) -> None:
        """Load the experiments after a delay, in a worker thread, so that the menu opens immediately."""
        self._loading.start()

    def fill(self) -> None:
        """Add the entries of the experiments, once."""
        if self._filled:
            return
        from ilf.lab.experiments.registry import EXPERIMENTS

        self._filled = True
        for name, experiment in EXPERIMENTS.items():
            action = self.addAction(f"{experiment.title} ({experiment.source})…")
            action.setObjectName(f"experiment_{name}")
            action.setToolTip(experiment.about)
            action.triggered.connect(lambda _=False, name=name: self._shown().choose(name))
            self.insertAction(self._end, action)

    @property
    def busy(self) -> bool:
        """Whether experiments are running."""
        return self.window_ is not None and self.window_.runner.busy

    def shutdown(self) -> bool:
        """Close the window and stop its run. True if it has ended."""
        self._loading.stop()
        self._loader.shutdown()
        if self.window_ is None:
            return True
        ended = self.window_.shutdown()
        self.window_.close()
        return ended

    def _shown(self) -> ExperimentsWindow:
        """Show the window in front and return it."""
        if self.window_ is None:
            from .window import ExperimentsWindow

            self.window_ = ExperimentsWindow()
            self.window_.message.connect(self.message)
        if not self.window_.isVisible():
            self.window_.refresh()
        self.window_.show()
        self.window_.raise_()
        self.window_.activateWindow()
        return self.window_


class ExperimentsFeature(Feature):
    """The experiments of the paper, in their menu and window."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.menu = ExperimentsMenu(context.window)
        self.menu.message.connect(context.notes.show_message)

    def pending_work(self) -> list[PendingWork]:
        """The experiments in progress, if any."""
        return [PendingWork("an experiment")] if self.menu.busy else []

    def shutdown(self) -> bool:
        """Close the window of the experiments and stop its run. True if it has ended."""
        return self.menu.shutdown()


def _load() -> Generator[None, None, None]:
    yield None
    import_module("ilf.lab.experiments")
