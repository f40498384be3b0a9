"""Work is saved, opened again, left unsaved, and recovered after the program was killed."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

from ..frames import room, walk
from ..hand import Hand

_ROOT = Path(__file__).parents[4]


def _work(user: Hand) -> None:
    """A frame with a stroke and a run."""
    user.open(room(user.folder))
    user.set_filter("paper", 20)
    user.select((40, 30))
    user.tool("paint")
    user.drag([(60, 40), (80, 60)])
    user.do("run_all")


def save_close_and_reopen(user: Hand) -> None:
    """Saved, a new project begun, the file opened, worked on and saved again."""
    _work(user)
    path = user.save()
    user.do("new_project")
    user.keep("new", user.title())
    user.drop(path)
    user.keep_undo("reopened")
    user.do("one_to_one")
    user.tool("erase")
    user.drag([(60, 40), (70, 50)])
    user.do("save_project")
    user.keep("saved", user.title())
    user.restart()
    user.open(path)


def project_with_its_files(user: Hand) -> None:
    """The frame's files go into the project; without those on disk it opens as before."""
    _work(user)
    path = user.save(embed=True)
    user.do("new_project")
    shutil.rmtree(user.folder / "room")
    user.open(path)


def locate_missing_files(user: Hand) -> None:
    """The frame has been moved: the folder where it is now is shown by the user."""
    _work(user)
    path = user.save()
    user.do("new_project")
    (user.folder / "elsewhere").mkdir()
    shutil.move(user.folder / "room", user.folder / "elsewhere" / "kitchen")
    user.drop(path)
    dialog = user.dialog("Missing files of")
    with user.answering(user.folder / "elsewhere" / "kitchen"):
        user.press("Locate folder", dialog)
    user.settle()


def leave_work_unsaved(user: Hand) -> None:
    """A frame is closed: kept by Cancel, then saved; its next change is discarded."""
    _work(user)
    user.save()
    user.tool("paint")
    user.drag([(90, 40), (110, 60)])
    user.press("Cancel", user.dialog("Save the work?", "close_frame"))
    user.keep("cancelled", user.title())
    user.press("Save", user.dialog("Save the work?", "close_frame"))
    user.keep("saved", user.title())
    frames = user.panel("Frames")
    user.click_row("Frames", 0, within=frames, twice=True)
    user.do("one_to_one")
    user.tool("paint")
    user.drag([(20, 90), (40, 100)])
    user.press("Discard", user.dialog("Save the work?", "close_frame"))
    user.click_row("Frames", 0, within=frames, twice=True)


def killed_after_edits(user: Hand) -> None:
    """The program is killed once its edits are autosaved; they are discarded, and another time restored."""
    user.keep("killed", _killed(user.folder, "edits"))
    left = shutil.copytree(user.folder / "autosave", user.folder / "left")
    user.restart(autosaves=True)
    user.press("Discard", user.dialog("Restore unsaved work"))
    user.press("Discard", user.dialog("Discard"))
    user.keep("discarded", [path.name for path in left.iterdir() if (user.folder / "autosave" / path.name).exists()])
    user.restart()
    shutil.copytree(left, user.folder / "autosave", dirs_exist_ok=True)
    user.restart(autosaves=True)
    user.press("Restore", user.dialog("Restore unsaved work"))


def killed_after_a_run_of_a_project(user: Hand) -> None:
    """Killed after a run beyond the saved project; decided later, then the results are restored with it."""
    user.keep("killed", _killed(user.folder, "run"))
    user.restart(autosaves=True)
    user.press("Decide later", user.dialog("Restore unsaved work"))
    user.keep("later", user.title())
    user.restart(autosaves=True)
    user.press("Restore", user.dialog("Restore unsaved work"))


def open_with_options(user: Hand) -> None:
    """By the dialog: depth in other units, an invalid value, a camera in numbers."""
    frame = room(user.folder)
    files = {"Path": frame / "rgb.png", "Raw depth: 16-bit or float, one channel": frame / "depth.png"}
    user.use_dialog("Open", "open", files | {"Zero only; 65535 in 7-Scenes": 20_000}, "Open")


def sample_and_recent_frames(user: Hand) -> None:
    """The bundled sample, a frame of one's own, and one again from the list of recent ones."""
    user.open(walk(user.folder))
    user.do("open_sample")
    user.keep("sample", user.title())
    user.do("close_frame")
    user.choose("File", "Open recent", "2  walk")
    user.keep("recent", user.title())
    user.choose("File", "Open recent", "Clear this list")


def quit(user: Hand) -> None:
    """With nothing to save, it is over at once."""
    user.open(room(user.folder))
    user.start("quit")
    user.wait(lambda: not user.window.isVisible())
    user.keep("window is there", user.window.isVisible())


def something_that_cannot_be_opened(user: Hand) -> None:
    """A problem is told, and the work goes on."""
    _work(user)
    bad = user.folder / "record.json"
    bad.write_text(json.dumps({"program": "other"}))
    user.drop(bad)
    user.press("OK", user.dialog("Open"))


def _killed(folder: Path, what: str) -> int:
    """Work in a process of its own until the work is autosaved, and kill it."""
    command = [sys.executable, "-m", "tests.pins.window.child", str(folder), what]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=_ROOT, env=os.environ)
    assert child.stdout is not None
    assert "autosaved\n" in iter(child.stdout.readline, ""), f"the process that was to be killed ended: {what}"
    child.send_signal(signal.SIGKILL)
    child.stdout.close()
    return child.wait()
