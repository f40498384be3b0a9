"""Commands whose features are imported and made when they are first used: their dialogs are seldom needed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QPoint

from ..base.commands import command
from ..base.needs import Need
from .context import Feature

if TYPE_CHECKING:
    from .export.feature import ExportFeature
    from .sweep.feature import SweepFeature


class OnUseFeature(Feature):
    """The commands of features that are made on use."""

    @command("sweep", "S&weep a parameter…", icon="ph.chart-bar", needs=Need.FRAME)
    def _open_sweep(self) -> None:
        """Test many values of a parameter, or of two, and compare their errors against ground truth or on hold-outs."""
        self._sweep().open()

    @command("export", "&Export…", icon="ph.export", keys="Ctrl+E", needs=Need.FRAME)
    def _ask_export(self) -> None:
        """Write completed depth, blocks, curves, point cloud and run.json."""
        self._export().ask()

    @command("report", "&Report…", icon="ph.file-text", needs=Need.FRAME)
    def _ask_report(self) -> None:
        """Write a page on this frame or all frames, as HTML or PDF: pictures, blocks, parameters, curves, errors."""
        self._export().ask(only_report=True)

    @command("batch", "&Batch…", icon="ph.film-strip", needs=Need.LISTED)
    def _ask_batch(self) -> None:
        """Complete many frames of the list from their files, in the background, each into its own folder."""
        self._export().ask(of_all=True, from_files=True)

    @command("export_all", "E&xport all…", icon="ph.export", keys="Ctrl+Alt+E", needs=Need.FRAME)
    def _ask_export_all(self) -> None:
        """Write the results of all frames of the list, or choose those worked on or marked as done."""
        self._export().ask(of_all=True)

    def show_menu(self, name: str, place: QPoint) -> None:
        """Show the menu of a parameter of the filter, which sweeps it."""
        self._sweep().show_menu(name, place)

    def _sweep(self) -> SweepFeature:
        from .sweep.feature import SweepFeature

        return self.context.feature(SweepFeature)

    def _export(self) -> ExportFeature:
        from .export.feature import ExportFeature

        return self.context.feature(ExportFeature)
