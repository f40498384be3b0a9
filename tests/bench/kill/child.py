"""Child process that is killed: the real window with random actions, all reported to the parent.

    python -m tests.bench.kill.child SEED MOMENT FOLDER FRAME [FRAME ...]

Every line is a JSON object with the time, `time.monotonic()`, and either the digests of all frames ("state") or the
moment that comes next ("at"): a write, or "save", "export" or "close", with which this user ends its work, the last
after saving.
"""

import json
import os
import random
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from gui.app.main_window import MainWindow
from gui.features.export.feature import ExportFeature
from gui.features.export.jobs import Export, Scope
from gui.project.current_project import has_content
from gui.project.recorder import Recorder
from ilf.project.store import WorkFolder
from ilf.run.options import ExportOptions
from ilf.segmentation.editing.cutting import split
from ilf.segmentation.editing.painting import brush_stroke, paint
from ilf.sources.frame_ref import FrameRef

from .digests import digest_of

_LOCK = threading.Lock()


def report_action(**what: object) -> None:
    """Report to the parent."""
    with _LOCK:
        sys.stdout.write(json.dumps({"time": time.monotonic(), **what}) + "\n")
        sys.stdout.flush()


class RandomUser:
    """Performs random actions in the window."""

    def __init__(self, window: MainWindow, folder: Path, frames: list[str], chance: random.Random, moment: str) -> None:
        self.window, self.workspace = window, window.workspace
        self.end, self.left = self._ends().get(moment), chance.randint(10, 40)
        self.folder = folder
        self.project = folder / "work.ilf"
        self.unopened = list(frames)
        self.chance = chance
        self.strokes_left = 0
        self.timer = QTimer(window)
        self.timer.timeout.connect(self.act)

    def report(self) -> None:
        """Report the state of all frames; not during a stroke."""
        if not self.workspace.stroke_in_progress:
            begun = filter(has_content, self.workspace.open)
            states = {document.id: digest_of(document.snapshot()) for document in begun}
            report_action(state=states, unsaved=self.window.project.present.unsaved)

    def act(self) -> None:
        """Perform a random action."""
        if self.strokes_left:
            self._go_on_with_stroke()
        elif self.unopened and (not self.workspace.open or self.chance.random() < 0.05):
            self.window.loader.open(FrameRef(self.unopened.pop()))
        elif self.workspace.shown is None or not self.workspace.current.counts():
            return
        elif self.end is not None and not self.left:
            self.report()
            self.timer.stop()
            self.end()
            return
        else:
            self.left -= 1
            self.chance.choice(self._choices())()
        self.report()
        self.timer.setInterval(self.chance.choice([0, 5, 20, 60, 150]))

    def _ends(self) -> dict[str, Callable[[], None]]:
        return {"save": self._end_by_saving, "export": self._end_by_exporting, "close": self._end_by_closing}

    def _end_by_saving(self) -> None:
        report_action(at="save")
        self._save()

    def _end_by_exporting(self) -> None:
        report_action(at="export")
        self.window.feature(ExportFeature).start(Export(self.folder / "out", ExportOptions(cloud=None), Scope.ALL))

    def _end_by_closing(self) -> None:
        def close(_: bool) -> None:
            self.report()
            report_action(at="close")
            self.window.close()

        self.window.project.saving.save(self.project, then=close)

    def _choices(self) -> list[Callable[[], object]]:
        brush = [self._go_on_with_stroke] * 8
        values = [self._split, self._rename, self._lock, self._hide, self._own, self._common, self._note, self._turn]
        others = [self._undo, self._undo, self._redo, self._run, self._run, self._save, self._mark_invalid]
        return [*brush, *values, *values, *others]

    def _block(self) -> int:
        return self.chance.choice(list(self.workspace.current.counts()))

    def _point(self) -> np.ndarray:
        height, width = self.workspace.current.frame.shape
        return np.array([self.chance.uniform(0, width), self.chance.uniform(0, height)])

    def _go_on_with_stroke(self) -> None:
        document = self.workspace.current
        if not self.strokes_left:
            self.strokes_left, self.label, self.at = self.chance.randint(2, 6), self._block(), self._point()
        after = self.at + np.array([self.chance.uniform(-9, 9), self.chance.uniform(-9, 9)])
        stroke = brush_stroke(document.frame.shape, np.array([self.at, after]), 4.0)
        if stroke is not None:
            self.workspace.current.stroke(paint(document.labels, stroke, self.label, document.locked))
        self.at = after
        self.strokes_left -= 1
        if not self.strokes_left:
            document.edit(document.drop_stroke(), "Paint")

    def _split(self) -> None:
        document, block = self.workspace.current, self._block()
        points = np.array([self._point(), self._point()])
        self.workspace.current.edit(split(document.labels, block, points, document.locked), "Split")

    def _rename(self) -> None:
        self.workspace.current.edit_info(self._block(), "Rename", name=f"wall {self.chance.random():.6f}")

    def _lock(self) -> None:
        block = self._block()
        self.workspace.current.edit_info(block, "Lock", locked=not self.workspace.current.info(block).locked)

    def _hide(self) -> None:
        block = self._block()
        self.workspace.current.set_visible(block, not self.workspace.current.info(block).visible)

    def _own(self) -> None:
        self.workspace.parameters.set_own({"max_iterations": self.chance.randint(3, 12)}, [self._block()])

    def _common(self) -> None:
        common = self.workspace.parameters.current
        self.workspace.parameters.set(common.replace(max_iterations=self.chance.randint(3, 12)))

    def _note(self) -> None:
        entry = self.workspace.entries.of(self.workspace.current.id)
        if entry is not None:
            self.workspace.set_note(entry, f"look {self.chance.random():.6f}")

    def _turn(self) -> None:
        self.workspace.show(self.chance.choice(self.workspace.open))

    def _undo(self) -> None:
        self.workspace.current.undo_stack.undo()

    def _redo(self) -> None:
        self.workspace.current.undo_stack.redo()

    def _run(self) -> None:
        if self.window.runs.state.free:
            self.window.runs.current.start()

    def _mark_invalid(self) -> None:
        document = self.workspace.current
        mask = np.zeros(document.frame.shape, bool)
        row = self.chance.randrange(mask.shape[0] - 4)
        mask[row : row + 4, ::3] = np.isfinite(document.frame.measured[row : row + 4, ::3])
        self.workspace.current.set_invalid_mask(mask if mask.any() else None, "MarkInvalid")

    def _save(self) -> None:
        if not self.window.project.saving.busy:
            self.window.project.saving.save(self.project)


def main() -> None:
    """Work until killed."""
    seed, moment, folder, *frames = sys.argv[1:]
    os.environ["ILF_AUTOSAVE"] = str(Path(folder, "autosave"))
    hands: list[RandomUser] = []
    _announce(hands)
    app = QApplication(sys.argv[:1])
    window = MainWindow(persistent=True)
    window.resize(900, 600)
    window.show()
    hand = RandomUser(window, Path(folder), frames, random.Random(seed), moment)
    hands.append(hand)
    window.recorder.failed.connect(lambda error: report_action(failed=repr(error)))
    window.notes.reported.connect(
        lambda text: report_action(failed=text) if text.startswith("The project is not saved") else None
    )
    window.project.saving.saved.connect(lambda path, problems: report_action(saved=str(path), problems=problems))
    hand.timer.start(5)
    sys.excepthook = lambda kind, error, trace: (
        report_action(error=repr(error)),
        sys.__excepthook__(kind, error, trace),
    )
    sys.exit(app.exec())


def _announce(hands: list[RandomUser]) -> None:
    """Report every write before it starts."""
    commit, replace, take = WorkFolder.commit, os.replace, Recorder._take

    def reported_take(self: Recorder) -> None:
        for hand in hands:
            hand.report()
        take(self)

    Recorder._take = reported_take  # type: ignore[method-assign]

    def announced_commit(self: WorkFolder, *arguments: object, **more: object) -> None:
        report_action(at="commit")
        commit(self, *arguments, **more)  # type: ignore[arg-type]
        report_action(at="committed")

    WorkFolder.commit = announced_commit  # type: ignore[method-assign,assignment]

    def announced_replace(source: str, target: str) -> None:
        report_action(at="replace")
        replace(source, target)
        report_action(at="replaced")

    os.replace = announced_replace  # type: ignore[assignment]


if __name__ == "__main__":
    main()
