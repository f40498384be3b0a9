"""Start and end of the desktop program: arguments, display, theme. Imports Qt only after checking that it works."""

from __future__ import annotations

import argparse
import atexit
import os
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from ilf._runtime.installation import __version__, asset_path, check_opencv, optional, run_if_child
from ilf._runtime.termination import log_crashes, log_error, terminating_immediately
from ilf._runtime.writing import check_writable, private_file
from ilf.errors import IlfError, InputError

from ..base.display import display_problem, qt_problem

if TYPE_CHECKING:
    from PySide6.QtWidgets import QApplication

    from ilf.sources.frame_ref import FrameRef, ReadingOptions

    from .main_window import MainWindow


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of `ilf-gui`."""
    run_if_child()
    # slow imports come after this
    with terminating_immediately("ilf-gui"):
        try:
            return _main(arguments)
        except Exception as error:
            return _print_refusal(log_error(error))


def _main(arguments: Sequence[str] | None) -> int:
    from ilf.cli.usage import check_there
    from ilf.sources.frame_ref import OPTIONS, ReadingOptions

    parser = build_parser()
    options = parser.parse_args(arguments)
    reading = ReadingOptions.from_arguments(vars(options))
    if options.frame is not None and (len(options.frames) != 1 or options.sample):
        parser.error("--frame selects a frame of one folder, data set or recording: give only this one.")
    try:
        check_there([*options.frames, options.live])
        check_opencv()
        sources, others = _inputs(options, reading)
        if options.screenshot is not None:
            if os.path.isdir(options.screenshot):
                raise InputError(f"{options.screenshot} is a folder: give the name of a file in it for the screenshot.")
            check_writable(Path(options.screenshot).parent)
    except IlfError as error:
        return _print_refusal(str(error))
    for name in reading.given:
        if OPTIONS[name].one_frame and len(sources) != 1:
            parser.error(f"{OPTIONS[name].flag} is for one frame: give only this one.")
    offscreen = options.screenshot is not None and not os.environ.get("QT_QPA_PLATFORM")
    problem = display_problem()
    if problem and offscreen:
        problem = qt_problem()  # the offscreen platform needs no display
        os.environ["QT_QPA_PLATFORM"] = "offscreen"
        # the offscreen platform warns for every window that it cannot pass on size hints
        os.environ.setdefault("QT_LOGGING_RULES", "default.warning=false")
    try:
        if problem:
            raise InputError(problem)
        optional("PySide6.QtWidgets", "ilf-studio[app]", "The window")
        return _run(options, sources, others)
    except InputError as error:
        return _print_refusal(f"{error} Without a window: ilf complete --help.")


def _run(options: argparse.Namespace, sources: Sequence[FrameRef], others: list[Path]) -> int:
    """Show the window until it is closed; returns the exit status. Raises InputError if a package is missing."""
    from .error_reporter import ErrorReporter, exit_soon

    log_crashes()
    app, present = _application(options.theme)
    splash = None
    if options.screenshot is not None:
        ignore_settings()
    else:
        from .splash import show_splash

        splash = show_splash(app)
    for package in ("pyqtgraph", "qtawesome"):
        optional(package, "ilf-studio[app]", "The window")

    from .headless import HeadlessRun
    from .main_window import MainWindow

    window = MainWindow(persistent=options.screenshot is None)
    if options.size:
        window.resize(*options.size)
    picture = None if options.screenshot is None else Path(options.screenshot)
    unattended = HeadlessRun(window, options.run, picture) if options.run or picture is not None else None
    ErrorReporter(window.notes)
    if splash is not None:
        splash.close()
    window.show()
    _open(window, options, sources, others)
    status = app.exec()
    if unattended is not None:
        status = unattended.status or status
    return status if present else exit_soon(status)


def _application(theme_name: str | None) -> tuple[QApplication, bool]:
    """Return the application with its theme, and whether it was there before."""
    from PySide6.QtCore import QCoreApplication, QSettings
    from PySide6.QtGui import QIcon
    from PySide6.QtWidgets import QApplication

    from ..base import theme

    QCoreApplication.setOrganizationName("ILF Studio")
    QCoreApplication.setApplicationName("ilf-studio")
    if sys.platform.startswith("linux"):  # other systems store settings elsewhere
        with suppress(OSError):
            private_file(Path(QSettings().fileName()))
    present = QApplication.instance()
    app = present if isinstance(present, QApplication) else QApplication(sys.argv[:1])
    theme.apply_theme(app, theme_name or str(QSettings().value("theme", "system")))
    theme.follow_system(app)
    app.setDesktopFileName("ilf-studio")
    app.setWindowIcon(QIcon(str(asset_path("icons/ilf-studio.png"))))
    return app, app is present


def ignore_settings() -> None:
    """Neither read nor change the user's settings from now on: they are those of this process alone."""
    from PySide6.QtCore import QSettings

    folder = TemporaryDirectory(prefix="ilf-")
    atexit.register(folder.cleanup)
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, folder.name)


def build_parser() -> argparse.ArgumentParser:
    """Build the parser of `ilf-gui`."""
    from ilf.cli.parsing import add_options
    from ilf.cli.usage import Parser, declare
    from ilf.sources.frame_ref import OPTIONS

    parser = Parser(prog="ilf-gui", description="Complete the missing depth of RGB-D frames, and watch it converge.")
    parser.add_argument("--version", action="version", version=f"ilf-gui {__version__}")
    declared = """
        [FRAME ...]  a project (.ilf), frame folders (with meta.json), folders of frames, run.json files, or a colour
            file and its depth file
        --frame KEY  key of a frame in a folder of frames, a data set or a recording, as for `ilf complete`
        --sample     open the bundled sample room
    """
    declare(parser, declared)
    add_options(parser, {name: option for name, option in OPTIONS.items() if not option.of_source})
    declared = """
        --live SOURCE  play a recording or folder, completed as it plays
        --realsense    play the connected RealSense camera, as with --live
    """
    declare(parser.add_mutually_exclusive_group(), declared)
    declared = """
        --rate HZ                  frames a second of --live or --realsense
        --run                      complete the depth of the (last) frame on start
        --screenshot FILE.png      save a screenshot of the window when all work is done, and exit
        --show images|cloud        content of the central view
    """
    declare(parser, declared, show="images")
    parser.add_argument("--size", type=_size, metavar="WxH", help="size of the window")
    declare(parser, "--theme system|light|dark  colours of the window")
    return parser


def _size(text: str) -> tuple[int, int]:
    size = re.fullmatch(r"(\d{3,4})x(\d{3,4})", text.lower())
    if size is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not WIDTHxHEIGHT, as in 1440x900")
    return int(size[1]), int(size[2])


def _open(window: MainWindow, options: argparse.Namespace, sources: Sequence[FrameRef], others: list[Path]) -> None:
    """Open frames, projects and records; a single file opens the dialog."""
    if options.show == "cloud":
        window.centre.show_cloud()
    if options.sample:
        window.documents.open_sample()
    if options.live is not None or options.realsense:
        from ..features.sequence.playing import PlayFeature

        window.feature(PlayFeature).play_live(options.live, options.rate)
    for source in sources:
        window.documents.open_source(source)
    window.documents.open_paths(others)


def _inputs(options: argparse.Namespace, reading: ReadingOptions) -> tuple[list[FrameRef], list[Path]]:
    """Return the frames, and what is none: projects, run records, and last a file without its partner, which only a
    user can be asked for.

    Raises
    ------
    IlfError
        If there is no frame with the key of --frame, or no user who could be asked.
    """
    from ilf.sources.frame_ref import FrameRef
    from ilf.sources.source import Source

    from ..base.paths import sort_paths
    from ..features.documents.frame_files import pair_of

    if options.frame is not None:
        found = Source(options.frames[0], reading).ref(options.frame)
        return [replace(found, options=reading.or_else(found.options))], []
    projects, folders, records, files = sort_paths(map(Path, options.frames))
    sources = [FrameRef(str(path), options=reading) for path in folders]
    if len(files) % 2 and (pair := pair_of(files[-1])) is not None:
        files[-1:] = pair
    pairs = zip(files[::2], files[1::2], strict=False)
    sources += [FrameRef(str(rgb), str(depth), options=reading) for rgb, depth in pairs]
    single = files[len(files) // 2 * 2 :]
    if single and options.screenshot is not None:
        raise InputError(
            f"{single[0]}: a frame needs a colour and a depth file, or a folder. Give both files, or the folder."
        )
    return sources, [*projects, *records, *single]


def _print_refusal(reason: str) -> int:
    """Print in one line why there is no window; returns the exit status."""
    print(f"ilf-gui: error: {reason}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
