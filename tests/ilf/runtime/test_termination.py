"""Commands and their processes end when they are asked to, and whoever reads their output may leave before that."""

import os
import signal
import stat
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from ilf._runtime.children import run_in_processes
from ilf._runtime.termination import Interrupted, error_log_path, log_error, terminating_on_signal
from ilf.cli import info, main
from ilf.errors import IlfError
from ilf.evaluation.bench.runner import run_bench

from ..batch_frames import write_frames
from .crashing import only_once

posix = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


class _Ends(str):
    """The name of a method with which a process ends."""

    def __reduce__(self):
        return os._exit, (1,)


def test_a_process_that_ends_is_told_of():
    assert dict(run_in_processes(os._exit, [0, 1], jobs=2)) == {0: None, 1: None}
    with pytest.raises(IlfError, match="worker process ended"):
        run_bench([Path("a")], ["random"], [_Ends()], jobs=2)
    with pytest.raises(ZeroDivisionError):
        list(run_in_processes(partial(divmod, 1), [0], jobs=2))


def test_items_whose_process_crashes_are_tried_once_more_and_the_others_are_not_lost(tmp_path):
    (tmp_path / "good").touch()
    tidied = []
    items = ["good", "bad", "good", "unlucky"]
    found = list(run_in_processes(partial(only_once, tmp_path), items, jobs=2, tidy=tidied.append))
    assert sorted(found, key=str) == [("bad", None), ("good", "good"), ("good", "good"), ("unlucky", "unlucky")]
    assert sorted(tidied) == ["bad", "bad", "unlucky"]


_BUSY = """
import os, sys, threading, time
from pathlib import Path
from ilf._runtime.termination import terminating_on_signal
from ilf._runtime.writing import removed_on_exit
from ilf._runtime.children import Child

half = Path(sys.argv[1])
half.touch()
with terminating_on_signal(), removed_on_exit(half):
    child = Child()
    helper = child.call(os.getpid)
    threading.Thread(target=child.call, args=(time.sleep, 600), daemon=True).start()
    while True:
        try:
            print(helper, flush=True)
            threading.Event().wait()
        except KeyboardInterrupt:
            pass  # as if it did not hear
"""


@posix
def test_what_does_not_end_is_cut_short_and_leaves_neither_files_nor_processes(tmp_path):
    half = tmp_path / "half"
    with subprocess.Popen(
        [sys.executable, "-c", _BUSY, half], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as command:
        helper = int(command.stdout.readline())
        assert half.exists()
        command.send_signal(signal.SIGTERM)
        assert command.wait(60) == 128 + signal.SIGTERM
        assert not half.exists()
        while _runs(helper):
            time.sleep(0.01)
        assert command.stderr.read() == "ilf: error: ended by SIGTERM\n"


_STARTING = """
import os
from ilf._runtime.children import run_in_processes

for _, group in run_in_processes(os.getpgid, [0]):
    print(group != os.getpgid(0))
"""


@posix
def test_a_program_without_a_main_guard_has_children_that_leave_the_terminal_s_interrupt_to_it(tmp_path):
    (tmp_path / "program.py").write_text(_STARTING)
    ended = subprocess.run([sys.executable, tmp_path / "program.py"], capture_output=True, text=True)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "True\n", "")


_BATCH = """
import signal, sys, time
from ilf.batch.folder_sink import FolderSink
from ilf.cli import main

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell makes what it starts in the background ignore it
    close = FolderSink.close

    def slowly(sink):  # as over ten thousand frames, or on a disk far away
        print("ending", flush=True)
        time.sleep(0.3)
        close(sink)

    FolderSink.close = slowly
    sys.exit(main(["batch", *sys.argv[1:]]))
"""


@posix
def test_a_batch_that_is_asked_to_end_has_a_manifest_of_what_is_done(tmp_path):
    out = tmp_path / "out"
    words = [write_frames(tmp_path / "in", 40), "--out", out, "--no-cloud", "--jobs", "1", "--max-iterations", "2"]
    with subprocess.Popen(
        [sys.executable, "-c", _BATCH, *words, "--no-correction", "--no-expected-error", "--blocks-detector", "canny"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as command:
        while not list(out.glob("*/frame.json")):
            assert command.poll() is None
            time.sleep(0.05)
        command.send_signal(signal.SIGINT)
        told, wrong = command.communicate()
    assert (command.returncode, wrong) == (128 + signal.SIGINT, "ilf: error: interrupted\n")
    assert told.startswith("ending\n40 frames: ")
    rows = (out / "manifest.csv").read_text().splitlines()[1:]
    assert len(rows) == len(list(out.glob("*/frame.json"))) < 40


_TRYING = """
import sys
from ilf._runtime.children import run_in_child
reader = "import os, time; print(os.getpid(), file=open(%r, 'w'), flush=True); time.sleep(600)" % sys.argv[1]
run_in_child(exec, reader, file="a")
"""


@posix
def test_a_reader_that_is_tried_ends_with_who_tries_it(tmp_path):
    note = tmp_path / "process"
    with subprocess.Popen([sys.executable, "-c", _TRYING, note]) as trying:
        while not (note.exists() and note.read_text()):
            assert trying.poll() is None
            time.sleep(0.01)
        trying.kill()
    while _runs(int(note.read_text())):
        time.sleep(0.01)


def _runs(process):
    """Whether it does; what has ended and was not asked for its status does not."""
    state = subprocess.run(["ps", "-o", "stat=", "-p", str(process)], capture_output=True, text=True).stdout
    return bool(state.strip()) and not state.startswith("Z")


@posix
@pytest.mark.parametrize(("name", "status"), [("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)])
def test_a_command_that_is_asked_to_end_says_so(name, status, heard, capsys, monkeypatch):
    monkeypatch.setattr(info, "facts_of_frame", lambda *_: signal.raise_signal(signal.Signals[name]))
    assert main(["info", str(Path(__file__).parents[3] / "assets" / "samples" / "room")]) == status
    assert capsys.readouterr().err == f"ilf: error: {'interrupted' if status == 130 else f'ended by {name}'}\n"
    assert signal.getsignal(signal.Signals[name]) is heard


@posix
def test_what_was_told_to_survive_its_terminal_does(monkeypatch):
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with terminating_on_signal():
            signal.raise_signal(signal.SIGHUP)
            with pytest.raises(Interrupted, match="SIGTERM"):
                signal.raise_signal(signal.SIGTERM)
    finally:
        signal.signal(signal.SIGHUP, before)


_EARLY = """
import os, signal, sys

class AskedMeanwhile:
    def find_spec(self, name, *_):
        if name == "numpy":
            os.kill(os.getpid(), signal.{name})
            while True:
                pass

signal.signal(signal.{name}, signal.SIG_DFL)
sys.meta_path.insert(0, AskedMeanwhile())
from ilf.cli import main
main(["info", "absent"])
"""


@posix
@pytest.mark.parametrize(
    ("name", "line"), [("SIGINT", "ilf: error: interrupted\n"), ("SIGTERM", "ilf: error: ended by SIGTERM\n")]
)
def test_a_command_ends_quietly_while_it_is_still_importing(name, line):
    ended = subprocess.run([sys.executable, "-c", _EARLY.format(name=name)], capture_output=True, text=True)
    assert (ended.returncode, ended.stdout, ended.stderr) == (128 + signal.Signals[name], "", line)


@pytest.fixture
def unread():
    """A pipe that nobody reads."""
    reading, writing = os.pipe()
    os.close(reading)
    return writing


def test_errors_that_nobody_reads(unread, monkeypatch):
    with open(unread, "w") as stderr:
        monkeypatch.setattr(sys, "stderr", stderr)
        assert main(["info", "nothing"]) == 1
        assert main(["info", "--presets"]) == 0


def test_what_nobody_has_foreseen_is_one_line_and_the_way_to_the_log(monkeypatch, cli):
    def broken(*_):
        raise ZeroDivisionError("nothing\nto divide by")

    monkeypatch.setattr(info, "facts_of_frame", broken)
    (line,) = cli("info", Path(__file__).parents[3] / "assets" / "samples" / "room", status=1).err.splitlines()
    assert "ZeroDivisionError: nothing to divide by" in line
    assert line.endswith(str(error_log_path()))
    assert "in broken" in error_log_path().read_text()


@pytest.mark.skipif(os.name != "posix", reason="asks for permissions")
@pytest.mark.parametrize("is_there", [False, True])
def test_no_other_user_may_read_the_log(is_there):
    if is_there:
        error_log_path().touch(0o644)
    log_error(KeyError("new"))
    assert stat.S_IMODE(error_log_path().stat().st_mode) == 0o600
