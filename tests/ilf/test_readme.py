"""What README shows runs as it stands there: the command line's lines, the Python block, the calls in the text.

The sample that they write is thinned to every second pixel for what comes after, and the surface of a quick experiment
is small: how large frames are is not what README tells of.
Left out are the lines that set up an environment; `.ci/run` runs the one that runs the tests.
"""

import contextlib
import json
import re
import shlex
from pathlib import Path

import cv2
import numpy as np
import pytest

from ilf.cli import main
from ilf.data.parameters import PRESETS
from ilf.lab.experiments import cylinder

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
PREFIX = ".venv/bin/ilf "

RESULTS = {
    *("depth.png", "depth.npy", "expected_error.png", "expected_error.npy", "unvouched.png"),
    *("blocks.png", "curves.csv", "cloud.ply", "run.json"),
}
STAGES = {"1-strength.png", "2-edges.png", "3-dilated.png", "4-contracted.png", "5-blocks.png"}
WRITTEN = {
    "sample room": {"room": {"rgb.jpg", "depth.png", "gt.png", "meta.json"}},
    "info room": {},
    "info .": {},
    "complete . --frame": {"room-by-key": RESULTS},
    "batch . --frames": {"room-batch": {"manifest.csv"}, "room-batch/room": RESULTS | {"frame.json", "preview.png"}},
    "complete room --out room-done": {"room-done": RESULTS},
    "complete room --mesh": {"room-mesh": RESULTS | {"mesh.glb"}},
    "complete room/rgb.jpg room/depth.png": {"room-files": RESULTS},
    "complete room --guide": {"room-guided": RESULTS | {"guide_used.npy"}},
    "judge room --preset": {},
    "judge room --hidden": {".": {"room-sweep.csv"}},
    "complete --replay": {"room-again": RESULTS},
    "report room-done": {".": {"room-report.html"}},
    "bench room": {},
    "blocks room --out": {".": {"room-blocks.png"}, "room-stages": STAGES},
    "blocks room --from": {".": {"room-blocks.json"}},
    "complete room --blocks": {"room-given": RESULTS - {"cloud.ply"}},
    "project new": {".": {"room.ilf"}},
    "project info": {},
    "experiments run": {"experiments": {"convergence.json", "cylinder.json", "cylinder-curves.png"}},
    "experiments report": {"experiments": {"report.html"}},
    "models list": {},
}
"""What a command of README begins with -> the files that it writes, by folder."""

TOLD_OF_THE_SAMPLE = (
    "ilf: warning: Depth is missing where it rises to the sensor's reach",
    "ilf: warning: Nothing measured vouches for",
    "ilf: warning: Left out of cloud and mesh",
)
"""What there is to say of the bundled sample: its open door leads into the dark."""

NEEDS = {
    "info room": "sample room",
    "info .": "sample room",
    "complete . --frame": "sample room",
    "batch . --frames": "sample room",
    "complete room --out room-done": "sample room",
    "complete room --mesh": "sample room",
    "complete room/rgb.jpg room/depth.png": "sample room",
    "complete room --guide": "sample room",
    "judge room --preset": "sample room",
    "judge room --hidden": "sample room",
    "complete --replay": "complete room --out room-done",
    "report room-done": "complete room --out room-done",
    "bench room": "sample room",
    "blocks room --out": "sample room",
    "blocks room --from": "blocks room --out",
    "complete room --blocks": "blocks room --from",
    "project new": "sample room",
    "project info": "project new",
    "experiments report": "experiments run",
}
"""Which command must have been run before."""


def section(title: str) -> str:
    """A section of README, without its title."""
    return README.split(f"\n## {title}\n", 1)[1].split("\n## ", 1)[0]


def indented(text: str) -> list[str]:
    """The lines of all code blocks, without their indent."""
    return [line[4:] for line in text.splitlines() if line.startswith("    ")]


def commands() -> list[str]:
    """The `ilf` lines of README, as pasted, but for the environment that they are run from."""
    return [line.removeprefix(PREFIX).split("  #")[0].strip() for line in indented(README) if line.startswith(PREFIX)]


def thin(room: Path) -> None:
    """Keep every second row and column of a frame's files."""
    for name in ("rgb.jpg", "depth.png", "gt.png"):
        picture = cv2.imread(str(room / name), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(room / name), picture[::2, ::2])
    meta = json.loads((room / "meta.json").read_text(encoding="utf-8"))
    meta["size"] = [number // 2 for number in meta["size"]]
    meta["K"] = [number / 2 for number in meta["K"]]
    (room / "meta.json").write_text(json.dumps(meta), encoding="utf-8")


class Shell:
    """Runs commands of README in one folder, each after what it needs, and once."""

    def __init__(self, folder):
        self.folder = folder
        self._done = set()

    def run(self, beginning):
        if beginning in self._done:
            return
        if beginning in NEEDS:
            self.run(NEEDS[beginning])
        command = next(command for command in commands() if command.startswith(beginning))
        with contextlib.chdir(self.folder):
            assert main(shlex.split(command)) == 0
            if beginning == "sample room":
                thin(Path("room"))
        self._done.add(beginning)


@pytest.fixture(scope="module")
def shell(tmp_path_factory):
    return Shell(tmp_path_factory.mktemp("readme"))


@pytest.fixture
def sample_room(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["sample", "room"]) == 0
    thin(Path("room"))


def test_every_command_of_readme_is_known_here():
    assert len(commands()) == len(WRITTEN)
    for command, beginning in zip(commands(), WRITTEN, strict=True):
        assert command.startswith(beginning)
    loose = [line for line in indented(section("The command line")) if not line.startswith(PREFIX)]
    assert not loose, "only ilf's own commands stand there"


@pytest.mark.parametrize("beginning", WRITTEN)
@pytest.mark.timeout(300)
def test_the_command_runs_and_writes_its_files(beginning, shell, capsys, monkeypatch):
    monkeypatch.setattr(cylinder, "_QUICK_SHAPE", (24, 32))
    shell.run(beginning)
    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("ilf: ")]
    assert all(line.startswith(TOLD_OF_THE_SAMPLE) for line in told), "there is nothing else to warn of"
    for place, names in WRITTEN[beginning].items():
        for name in names:
            assert (shell.folder / place / name).stat().st_size, f"{place}/{name} is empty"


def test_the_replay_gives_the_same_depth_bit_for_bit(shell):
    shell.run("complete --replay")
    again, done = (shell.folder / name / "depth.npy" for name in ("room-again", "room-done"))
    assert again.read_bytes() == done.read_bytes()


@pytest.mark.usefixtures("sample_room")
def test_the_python_block_runs_as_it_stands_and_so_do_the_calls_in_the_text(capsys):
    names: dict[str, object] = {}
    exec(compile("\n".join(indented(section("The library"))), "README.md", "exec"), names)
    assert all(Path(name).is_file() for name in ("completed.png", "completed.ply", "completed.glb"))
    assert "pixels filled" in capsys.readouterr().out
    frame, result = names["frame"], names["result"]
    assert names["strength"].shape == names["blocks"].shape == names["error"].shape == frame.shape
    np.testing.assert_array_equal(result.filled, ~frame.known & np.isfinite(result.depth))

    names |= {"rgb_uint8": frame.rgb, "depth_m": frame.depth}
    calls = re.findall(r"`(ilf\.\w+\([^`]*\))`", re.sub(r"\s+", " ", section("The library")))
    assert len(calls) >= 3
    for call in calls:
        assert eval(call, names) is not None


def test_the_presets_of_the_table_are_those_there_are():
    listed = re.findall(r"^\| `([\w-]+)`", section("The library"), re.MULTILINE)
    assert listed == list(PRESETS)
