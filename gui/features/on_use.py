"""Commands whose features are imported and made when they are first used: their dialogs are seldom needed."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

from ..base import theme
from ..base.commands import Command
from ..base.needs import Need
from .context import Context, Feature
from .filter import FilterPanel
from .menus import insert_menu

if TYPE_CHECKING:
    from .export.feature import ExportFeature
    from .live import LiveFeature
    from .palette.palette import PaletteFeature
    from .sweep.feature import SweepFeature


class OnUseFeature(Feature):
    """The commands of features that are made on use."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        installed = find_spec("pyrealsense2") is not None
        no_camera = "" if installed else 'Install pyrealsense2 first: pip install "ilf-studio[sensors]".'
        context.actions.add(
            (
                Command(
                    "sweep",
                    "S&weep a parameter…",
                    "Test many values of a parameter, or of two, and compare their errors against "
                    "ground truth or on hold-outs",
                    icon="ph.chart-bar",
                    handler=lambda: self._sweep().open(),
                    needs=Need.FRAME,
                ),
                Command(
                    "export",
                    "&Export…",
                    "Write completed depth, blocks, curves, point cloud and run.json",
                    icon="ph.export",
                    keys="Ctrl+E",
                    handler=lambda: self._export().ask(),
                    needs=Need.FRAME,
                ),
                Command(
                    "report",
                    "&Report…",
                    "Write a page on this frame or all frames, as HTML or PDF: "
                    "pictures, blocks, parameters, curves, errors",
                    icon="ph.file-text",
                    handler=lambda: self._export().ask(only_report=True),
                    needs=Need.FRAME,
                ),
                Command(
                    "batch",
                    "&Batch…",
                    "Complete many frames of the list from their files, in the background, each into its own folder",
                    icon="ph.film-strip",
                    handler=lambda: self._export().ask("all", from_files=True),
                    needs=Need.LISTED,
                ),
                Command(
                    "export_all",
                    "Export a&ll…",
                    "Write the results of all frames of the list, of those worked on, or of those marked as done",
                    icon="ph.export",
                    keys="Ctrl+Alt+E",
                    handler=lambda: self._export().ask("all"),
                    needs=Need.FRAME,
                ),
                Command(
                    "play_recording",
                    "&Recording…",
                    "Play a recording at its rate, and complete it as it plays",
                    handler=lambda: self._live().ask_recording(),
                ),
                Command(
                    "play_folder",
                    "&Folder…",
                    "Play the frames of a folder or data set, and complete them as they play",
                    handler=lambda: self._live().ask_folder(),
                ),
                Command(
                    "play_camera",
                    "RealSense &camera",
                    "Play the connected RealSense camera, and complete its frames as they come",
                    handler=lambda: self._live().play(),
                    why_off=lambda: no_camera,
                ),
                Command(
                    "palette",
                    "Command &palette…",
                    "Find a command by part of its name",
                    icon="ph.magnifying-glass",
                    keys="Ctrl+Shift+P",
                    handler=lambda: self._palette().toggle(),
                ),
            )
        )
        context.feature(FilterPanel).form.menu_requested.connect(
            lambda name, place: self._sweep().show_menu(name, place)
        )

    def begin(self) -> None:
        """Insert the menu *Play live*."""
        menu = self.context.actions.menu("Play &live", self.context.window, "play_recording play_folder play_camera")
        menu.setIcon(theme.icon("ph.play-circle", menu.palette()))
        insert_menu(self.context.window.menuBar(), menu, self.context.actions["open_sample"])

    def _sweep(self) -> SweepFeature:
        from .sweep.feature import SweepFeature

        return self.context.feature(SweepFeature)

    def _export(self) -> ExportFeature:
        from .export.feature import ExportFeature

        return self.context.feature(ExportFeature)

    def _live(self) -> LiveFeature:
        from .live import LiveFeature

        return self.context.feature(LiveFeature)

    def _palette(self) -> PaletteFeature:
        from .palette.palette import PaletteFeature

        return self.context.feature(PaletteFeature)
