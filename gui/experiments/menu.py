"""The menu of the paper's experiments, and their window once it is needed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QMenu, QWidget

if TYPE_CHECKING:
    from gui.experiments.window import ExperimentsWindow


class ExperimentsMenu(QMenu):
    """An entry per experiment, and one for all. What runs them is loaded when the menu is opened, not before."""

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

    def fill(self) -> None:
        """Add the experiments' entries, if they are not there yet."""
        if self._filled:
            return
        from ilf.experiments import EXPERIMENTS

        self._filled = True
        for name, experiment in EXPERIMENTS.items():
            action = self.addAction(f"{experiment.title} ({experiment.source})…")
            action.setObjectName(f"experiment_{name}")
            action.setToolTip(experiment.about)
            action.triggered.connect(lambda _=False, name=name: self._shown().choose(name))
            self.insertAction(self._end, action)

    def shutdown(self) -> bool:
        """Close the window and stop what it runs. True if that has ended."""
        if self.window_ is None:
            return True
        ended = self.window_.shutdown()
        self.window_.close()
        return ended

    def _shown(self) -> ExperimentsWindow:
        """The window, in front."""
        if self.window_ is None:
            from gui.experiments.window import ExperimentsWindow

            self.window_ = ExperimentsWindow()
        if not self.window_.isVisible():
            self.window_.refresh()
        self.window_.show()
        self.window_.raise_()
        self.window_.activateWindow()
        return self.window_
