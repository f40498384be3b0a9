"""The window's settings, read on opening: damaged settings must not prevent it from opening."""

import json
import os
from dataclasses import replace
from functools import cache
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PySide6.QtCore import QCoreApplication, QEvent, QSettings
from PySide6.QtWidgets import QApplication

from gui.app.main_window import MainWindow
from gui.features.documents.recent import RecentMenu
from gui.features.export.files import stored_options
from gui.features.layouts import Arrangement, LayoutStore
from gui.features.palette import CommandPalette
from gui.features.shortcuts import Keymap
from gui.widgets.file_choice import last_folder, save_folder
from ilf.sources.frame_ref import FrameRef, ReadingOptions

FILE = "ILF Studio/ilf-studio.ini"


def settings(folder: Path) -> list[bytes]:
    """Settings of a closed window, with all possible user settings."""
    window = _window(folder)
    kept = window.documents.recent
    options = ReadingOptions(depth_units=1000.0, intrinsics=(30.0, 30.0, 15.5, 11.5))
    kept.note(FrameRef("rgb.png", "depth.png", "0.1", options))
    kept.note(Path("run.json"))
    arrangement = Arrangement("grid", {"colour": "depth-in"}, ("Blocks", "Runs"), window.panels.places())
    layouts = LayoutStore()
    layouts.changed["standard"] = arrangement
    layouts.put("own_1", replace(arrangement, text="Mine"))
    chosen = QSettings()
    values: dict[str, object] = {
        "window/geometry": window.saveGeometry(),
        "export/files": json.dumps({"cloud": "ply"}),
        "export/folder": str(folder),
        "open/folder": str(folder),
        "shortcuts/Open": "Ctrl+K, Ctrl+O",
        "theme": "dark",
        "palette/recent": ["open", "undo"],
    }
    for key, value in values.items():
        chosen.setValue(key, value)
    chosen.sync()
    return [(folder / FILE).read_bytes()]


def read_settings(path: Path) -> None:
    """Read all settings."""
    window = _window(path.parent.parent)
    QSettings().sync()
    recent = RecentMenu(print, None)
    recent.aboutToShow.emit()
    layouts = LayoutStore()
    for name in (*layouts.changed, *layouts.own):
        left = layouts.left(name)
        window.panels.take(left.panels, left.places)
    window.panels.size_window()
    CommandPalette(window).deleteLater()
    Keymap(window).deleteLater()
    stored_options(1000.0)
    save_folder()
    last_folder("open/folder")
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)  # otherwise every case leaves a dialog


@cache
def _window(folder: Path) -> MainWindow:
    application = QApplication.instance() or QApplication([])
    application.setOrganizationName(Path(FILE).parent.name)
    application.setApplicationName(Path(FILE).stem)
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(folder))
    window = MainWindow(persistent=False)
    window.panels.arrange()
    return window
