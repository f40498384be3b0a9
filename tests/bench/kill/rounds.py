"""One kill, and the recovery after it."""

import json
import os
import random
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import ilf
from ilf._runtime.installation import asset_path
from ilf.errors import InputError
from ilf.project.archive import Parts
from ilf.project.file import OpenedProject
from ilf.project.project import ProjectFrame
from ilf.project.recovery import RecoverableWork, find_recoverable_work
from ilf.project.state_codec import frame_part, load_state
from tests.e2e.conftest import write_frame

from .digests import digest_of

LATEST_S = 3.0
MOMENTS = "any", "any", "commit", "commit", "replace", "replaced"
ENDS = "save", "export", "close"
_DELAYS_S = 0, 0.001, 0.003, 0.01, 0.03
"""Delay from the announcement of a write to the kill [s]."""
_LONGEST_END_S = 0.6
"""The same for what takes longer."""
_ROOT = Path(__file__).parents[3]


@dataclass
class Found:
    """Result of a round.

    Attributes
    ----------
    number : int
    moment : str
        Moment of the kill.
    states : int
        Number of states reported until then.
    age : float or None
        Time [s] between the replacement of the recovered state and the kill, 0 for the last state; None if nothing had
        been done yet.
    project_opened : bool
        Whether a project file existed, could be opened and contained a state of the child.
    problem : str
    """

    number: int
    moment: str
    states: int = 0
    age: float | None = None
    project_opened: bool = False
    problem: str = ""


@dataclass
class _Reports:
    """Reports of the child."""

    times: list[float] = field(default_factory=list)
    states: list[dict[str, str]] = field(default_factory=list)
    unsaved: list[bool] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)

    def take(self, line: str) -> dict[str, Any]:
        """Read a line."""
        try:
            said: dict[str, Any] = json.loads(line)
        except ValueError:
            return {}  # cut off
        if "state" in said:
            now = said["state"], said["unsaved"]
            if not self.states or now != (self.states[-1], self.unsaved[-1]):
                self.times.append(said["time"])
                self.states.append(said["state"])
                self.unsaved.append(said["unsaved"])
        self.errors += [str(said[key]) for key in ("error", "failed") if key in said]
        return said


def frames_in(folder: Path) -> list[Path]:
    """Write three frames to files."""
    room = ilf.load_frame(str(asset_path("samples/room")))
    frames = [room]
    for step, (top, left) in ((2, (0, 0)), (3, (1, 1))):
        frames.append(ilf.RGBDFrame(room.rgb[top::step, left::step], room.depth[top::step, left::step]))
    return [write_frame(folder / f"frame{number}", frame) for number, frame in enumerate(frames)]


def one_round(
    number: int, frames: Sequence[Path], folder: Path, longest: float = 6.0, moments: Sequence[str] = MOMENTS
) -> Found:
    """Let a child work for at most `seconds`, kill it, and check the recovery."""
    chance = random.Random(number)
    folder.mkdir()
    moment = chance.choice(moments)
    told, killed = _killed(number, moment, chance.uniform(0.3, longest), frames, folder)
    found = Found(number, moment, len(told.states))
    try:
        _look(found, told, killed, folder)
    except ilf.IlfError as error:
        found.problem = f"{type(error).__name__}: {error}"
    if told.errors:
        found.problem = found.problem or told.errors[0]
    if not found.problem:
        shutil.rmtree(folder)
    return found


def _killed(number: int, moment: str, wait: float, frames: Sequence[Path], folder: Path) -> tuple[_Reports, float]:
    with open(folder / "stderr", "w") as stderr:
        child = subprocess.Popen(
            [sys.executable, "-m", "tests.bench.kill.child", str(number), moment, folder, *frames],
            stdout=subprocess.PIPE,
            stderr=stderr,
            text=True,
            cwd=_ROOT,
            env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
        )
    assert child.stdout is not None
    told = _Reports()
    begun: float | None = None
    chance = random.Random(number)
    for line in child.stdout:
        said = told.take(line)
        if moment in ENDS:
            if said.get("at") == moment:
                time.sleep(chance.uniform(0, _LONGEST_END_S))
                break
            continue
        if begun is None and told.states:
            begun = time.monotonic()
        late = begun is not None and time.monotonic() - begun > wait
        if late and (moment == "any" or said.get("at") == moment or time.monotonic() - begun > wait + 15):
            if moment != "any":
                time.sleep(_DELAYS_S[number % len(_DELAYS_S)])
            break
    killed = time.monotonic()
    child.kill()
    for line in child.stdout:
        told.take(line)
    child.wait()
    child.stdout.close()
    return told, killed


def _look(found: Found, told: _Reports, killed: float, folder: Path) -> None:
    """Open the project file and the recovered work as the next window does."""
    path = folder / "work.ilf"
    with ilf.open_project(path) if path.exists() else nullcontext() as opened:
        _compare(found, told, killed, folder, opened)


def _compare(found: Found, told: _Reports, killed: float, folder: Path, opened: OpenedProject | None) -> None:
    state, base = _in_project(opened), None if opened is None else opened.parts
    if base is not None:
        if state not in told.states:
            found.problem = f"the project file contains no state of the child: {_nearest(state, told)}"
            return
        found.project_opened = True
    works = find_recoverable_work(folder / "autosave")
    if works:
        try:
            state = _in_work(works[0], base)
        finally:
            works[0].discard()
        fitting = [number for number, one in enumerate(told.states) if one == state]
    else:  # everything is saved, or only blocks have been extracted
        saved = [(number, one) for number, one in enumerate(told.states) if not told.unsaved[number]]
        fitting = [number for number, one in saved if state.items() <= one.items()]
    if told.states and not fitting:
        found.problem = f"the recovered work is no state of the child: {_nearest(state, told)}"
    elif told.states:
        overtaken = told.times[fitting[-1] + 1] if fitting[-1] + 1 < len(told.times) else killed
        found.age = max(killed - overtaken, 0.0)


def _in_project(opened: OpenedProject | None) -> dict[str, str]:
    """Return digests of all frames of the project file."""
    if opened is None:
        return {}
    if opened.problems:
        raise InputError(" ".join(opened.problems))
    return {frame.id: _digest(frame, opened.parts) for frame in opened.project.frames if frame.has_state}


def _in_work(left: RecoverableWork, base: Parts | None) -> dict[str, str]:
    """Return digests of all frames of the recovered work, combined with those of the project file."""
    if left.problem or left.read.problems:
        raise InputError(left.problem or " ".join(left.read.problems))
    digests = {}
    for frame in left.read.project.frames:
        parts = left.parts if frame.id in left.stored else base
        if parts is not None and frame_part(frame.id) in parts.names():
            digests[frame.id] = _digest(frame, parts)
    return digests


def _digest(frame: ProjectFrame, parts: Parts) -> str:
    decoded = load_state(frame.id, parts)
    if decoded.problems:
        raise InputError(f"{frame.name}: {decoded.problems}")
    return digest_of(decoded.state)


def _nearest(state: dict[str, str], told: _Reports) -> str:
    found = []
    for frame_id, one in state.items():
        when = [number for number, states in enumerate(told.states) if states.get(frame_id) == one]
        found.append(f"{frame_id[:6]}: states {when[:1]}-{when[-1:]} of {len(told.states)}")
    return ", ".join(found)
