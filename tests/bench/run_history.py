"""Memory of the run history: many runs of a frame, each with other values, stored as in the window.

    QT_QPA_PLATFORM=offscreen python -m tests.bench.run_history [FRAME] [--runs 50] [--preset best]

Every run has another value of the preset's main parameter, so that no two share a result: the worst case. Prints the
growth of the process's memory.
"""

from __future__ import annotations

import argparse
import gc

from PySide6.QtCore import QCoreApplication, QEventLoop

from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.work.run_recorder import RunRecorder
from gui.work.runs import RunController
from ilf._runtime.installation import asset_path
from ilf.data.parameters import PRESETS, Parameters
from ilf.run.run import Run
from ilf.sources.frames import load_frame

from .memory import resident

_MB = 1024**2
_VARIED = {"edge-aware": "smoothness", "ideal": "shortest_wavelength"}


def main() -> None:
    """Store runs, and print their memory."""
    options = _options()
    app = QCoreApplication([])
    frame = load_frame(options.frame)
    workspace = Workspace()
    runs = RunController(workspace)
    keeper = RunRecorder(workspace, runs)
    session = Session.of(Run.of(frame), options.frame, options.frame)
    workspace.add_session(session)
    preset = PRESETS[options.preset]
    _run(app, workspace, runs, preset)  # edges etc. are computed once
    workspace.runs.drop(session, session.run_history[0])
    gc.collect()
    before = resident()
    for number in range(options.runs):
        _run(app, workspace, runs, _varied(preset, number))
    gc.collect()
    kept = session.run_history
    print(f"{frame.name}, {frame.shape[1]} x {frame.shape[0]}, {len(session.counts())} blocks, preset {options.preset}")
    print(f"{len(kept)} stored runs, {sum(one.iterations for one in kept)} iterations")
    print(f"resident: {(resident() - before) / _MB:.0f} MB more, {resident() / _MB:.0f} MB in total")
    keeper.shutdown()
    runs.shutdown()


def _run(app: QCoreApplication, workspace: Workspace, runs: RunController, parameters: Parameters) -> None:
    workspace.parameters.set(parameters)
    count = len(workspace.session.run_history)
    runs.start()
    while len(workspace.session.run_history) == count:
        app.processEvents(QEventLoop.ProcessEventsFlag.WaitForMoreEvents)


def _varied(preset: Parameters, number: int) -> Parameters:
    name = _VARIED[preset.filter]
    return preset.replace(**{name: getattr(preset, name) * (1.02 + 0.02 * number)})


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frame", nargs="?", default=str(asset_path("samples/room")))
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--preset", choices=list(PRESETS), default="best")
    return parser.parse_args()


if __name__ == "__main__":
    main()
