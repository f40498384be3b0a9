"""The menu of the paper's experiments, and their window once it is needed."""

from __future__ import annotations

from collections.abc import Generator
from importlib import import_module
from typing import TYPE_CHECKING

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QMenu, QWidget

from ...work.jobs import Worker

if TYPE_CHECKING:
    from .window import ExperimentsWindow

_LOAD_AFTER_MS = 1500
"""The first frame comes first."""


class ExperimentsMenu(QMenu):
    """An entry per experiment, and one for all. What runs them is loaded when the menu is opened, if not before.

    Signals
    -------
    message(str)
        What is to be said of a run while its window is closed.
    """

    message = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("E&xperiments", parent)
        self.window_: ExperimentsWindow | None = None
        self.setToolTipsVisible(True)
        self._end = self.addSeparator()
        self._filled = False
        all_quick = self.addAction("Run all (&quick)")
        all_quick.setToolTip("Run every experiment with few points, and show how they stand beside the paper")
        all_quick.triggered.connect(lambda _=False: self._shown().run_all_quick())
        self.aboutToShow.connect(self.fill)
        self._loader = Worker(self)
        self._loading = QTimer(self, singleShot=True, interval=_LOAD_AFTER_MS)
        self._loading.timeout.connect(lambda: self._loader.start(_load))

    def load_soon(self) -> None:
        """Load what the entries need after a while, off the GUI's thread, so that the menu opens at once."""
        self._loading.start()

    def fill(self) -> None:
        """Add the experiments' entries, if they are not there yet."""
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
        """Close the window and stop what it runs. True if that has ended."""
        self._loading.stop()
        self._loader.shutdown()
        if self.window_ is None:
            return True
        ended = self.window_.shutdown()
        self.window_.close()
        return ended

    def _shown(self) -> ExperimentsWindow:
        """The window, in front."""
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


def _load() -> Generator[None, None, None]:
    yield None
    import_module("ilf.experiments")
