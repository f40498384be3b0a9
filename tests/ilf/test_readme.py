"""What README, commands.md and library.md show runs as it stands there; links between documents lead somewhere.

The sample that they write is thinned to every fourth pixel for what comes after: how large frames are is
not what the documents are about.
Left out are the window's lines and those that set up an environment, of which `.ci/run` runs that of the tests.
"""

import contextlib
import json
import re
import shlex
from dataclasses import fields
from pathlib import Path

import cv2
import numpy as np
import pytest

from ilf.batch.frame_record import FrameOutcome
from ilf.cli import main
from ilf.data.parameters import PRESETS
from ilf.evaluation.bench.methods import METHODS
from ilf.run.curves import CURVE_COLUMNS
from ilf.sources.frame_folder import Meta

from .batch_frames import work_in_this_process

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "assets" / "docs"
README = (ROOT / "README.md").read_text(encoding="utf-8")
COMMANDS = (DOCS / "commands.md").read_text(encoding="utf-8")
LIBRARY = (DOCS / "library.md").read_text(encoding="utf-8")
BENCHMARKS = (DOCS / "benchmarks.md").read_text(encoding="utf-8")
PREFIX = ".venv/bin/ilf "

RESULTS = {
    *("depth.png", "depth.npy", "expected_error.png", "expected_error.npy", "unsupported.png"),
    *("blocks.png", "curves.csv", "cloud.ply", "run.json"),
}
STAGES = {"1-strength.png", "2-edges.png", "3-dilated.png", "4-contracted.png", "5-blocks.png"}
WRITTEN = {
    "sample room": {"room": {"rgb.jpg", "depth.png", "gt.png", "meta.json"}},
    "info room": {},
    "complete room --out room-done": {"room-done": RESULTS},
    "complete --replay": {"room-again": RESULTS},
    "complete room/rgb.jpg room/depth.png": {"room-files": RESULTS},
    "complete room --guide": {"room-guided": RESULTS | {"guide_used.npy"}},
    "complete room --mesh": {"room-mesh": RESULTS | {"mesh.glb"}},
    "report room-done": {".": {"room-report.html"}},
    "info .": {},
    "complete . --frame": {"room-by-key": RESULTS},
    "batch . --frames": {"room-batch": {"manifest.csv"}, "room-batch/room": RESULTS | {"frame.json", "preview.png"}},
    "evaluate room --preset": {},
    "evaluate room --hold-out": {".": {"room-sweep.csv"}},
    "bench room": {},
    "blocks room --out": {".": {"room-blocks.png"}, "room-stages": STAGES},
    "blocks room --from": {".": {"room-blocks.json"}},
    "complete room --blocks": {"room-given": RESULTS - {"cloud.ply"}},
    "project new": {".": {"room.ilf"}},
    "project info": {},
    "info --presets": {},
    "models list": {},
}
"""What a command of commands.md begins with -> the files that it writes, by folder."""

TOLD_OF_THE_SAMPLE = (
    "ilf: warning: Depth is missing beyond the sensor range",
    "ilf: warning: Unsupported by measurements",
    "ilf: warning: Left out of cloud and mesh",
    "ilf: warning: The guide is not used: on a hold-out of known depth",
    *(f"ilf: warning: {number} folders left out: the depth was completed by ILF Studio" for number in range(2, 9)),
)
"""What there is to say of the bundled sample: its open door leads into the dark; thinned, it has no gap so wide that a
guide helps."""

NEEDS = {
    "info room": "sample room",
    "info .": "sample room",
    "complete . --frame": "sample room",
    "batch . --frames": "sample room",
    "complete room --out room-done": "sample room",
    "complete room --mesh": "sample room",
    "complete room/rgb.jpg room/depth.png": "sample room",
    "complete room --guide": "sample room",
    "evaluate room --preset": "sample room",
    "evaluate room --hold-out": "sample room",
    "complete --replay": "complete room --out room-done",
    "report room-done": "complete room --out room-done",
    "bench room": "sample room",
    "blocks room --out": "sample room",
    "blocks room --from": "blocks room --out",
    "complete room --blocks": "blocks room --from",
    "project new": "sample room",
    "project info": "project new",
}
"""Which command must have been run before."""


def indented(text: str) -> list[str]:
    """The lines of all code blocks, without their indent."""
    return [line[4:] for line in text.splitlines() if line.startswith("    ")]


def commands(text: str = COMMANDS) -> list[str]:
    """The `ilf` lines of a document, as pasted, but for the environment that they are run from."""
    return [line.removeprefix(PREFIX).split("  #")[0].strip() for line in indented(text) if line.startswith(PREFIX)]


def python(text: str) -> str:
    """The lines of Python of a document."""
    return "\n".join(line for line in indented(text) if not line.startswith((".venv", "python3", "py ")))


def thin(room: Path) -> None:
    """Keep every fourth row and column of a frame's files."""
    for name in ("rgb.jpg", "depth.png", "gt.png"):
        picture = cv2.imread(str(room / name), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(room / name), picture[::4, ::4])
    meta = json.loads((room / "meta.json").read_text(encoding="utf-8"))
    meta["size"] = [number // 4 for number in meta["size"]]
    meta["K"] = [number / 4 for number in meta["K"]]
    (room / "meta.json").write_text(json.dumps(meta), encoding="utf-8")


def with_thin_camera(text: str) -> str:
    """A text with the intrinsics of the thinned sample in place of the sample's, with and without blanks."""
    return re.sub(r"525,( ?)525, ?319.5, ?239.5", r"131.25,\g<1>131.25,\g<1>79.875,\g<1>59.875", text)


class Shell:
    """Runs the documented commands in one folder, each after what it needs, and once."""

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
            assert main(shlex.split(with_thin_camera(command))) == 0
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


def test_every_command_of_the_documents_is_known_here():
    assert len(commands()) == len(WRITTEN)
    for command, beginning in zip(commands(), WRITTEN, strict=True):
        assert command.startswith(beginning)
    loose = [line for line in indented(COMMANDS) if not line.startswith(PREFIX)]
    assert not loose, "only ilf's own commands stand there"
    assert set(commands(README)) <= set(commands()), "what README shows is explained in commands.md"


def test_all_that_files_of_a_frame_and_tables_state_is_explained():
    stated = {*Meta.__struct_fields__, *CURVE_COLUMNS, *(column.name for column in fields(FrameOutcome))}
    told = {word for text in re.findall(r"`([^`\n]+)`", COMMANDS) for word in re.findall(r"\w+", text)}
    assert stated - told == {"truth_mae_m", "truth_rmse_m"}, "`truth_...` stands for these"


def test_readme_sets_up_and_tests_a_clone_by_one_line_each():
    lines = [line for line in indented(README) if line.startswith("python3 -m venv ")]
    assert ["pytest" in line for line in lines] == [False, True]
    assert all(" -e '.[" in line for line in lines)


@pytest.mark.parametrize("text", [README, COMMANDS], ids=["README", "commands"])
def test_lines_to_paste_have_no_placeholders(text):
    lines = [line.split("  #")[0] for line in indented(text) if line.startswith((".venv", "python3"))]
    assert [line for line in lines if re.search(r"\b[A-Z]{2,}\b", line)] == []


def rows(text: str, heading: str, start: str = "| ") -> dict[str, list[str]]:
    """The rows of the first table below a heading: first cell -> the others."""
    below = text.partition(f"## {heading}")[2].partition("\n## ")[0]
    lines = [line.removeprefix(start) for line in below.splitlines() if line.startswith(start)]
    cells = [re.split(r" *\| *|  +", line.strip().rstrip("|").strip()) for line in lines]
    return {re.sub(r"[`*]|\s*\(.*\)", "", first).strip(): others for first, *others in cells}


def test_the_figures_of_readme_are_those_of_the_benchmarks():
    random, areas = (rows(BENCHMARKS, heading, "    ") for heading in ("Random", "Areas"))
    named = {"OpenCV inpainting": "navier-stokes"}
    shown = rows(README, "Accuracy")
    for method in ("best", "thin plate", "DCT smoothing", "colourisation", "OpenCV inpainting", "paper"):
        name = named.get(method, method.lower().replace(" ", "-"))
        one, other = ([float(cell.strip("*%-") or 0) for cell in table[name]] for table in (random, areas))
        measured = [*one[:2], *other[:2], one[7] + one[8], other[7] + other[8]]
        figures = re.findall(r"[\d.]+", " ".join(shown[method]))
        assert figures == [
            f"{value:.{len(figure.partition('.')[2])}f}" for figure, value in zip(figures, measured, strict=True)
        ], method
    judged = rows(BENCHMARKS, "Frame by frame, on the frames for evaluation")
    for what, row in {"random gaps": "random", "large areas": "areas", "500 known points": "500 points"}.items():
        assert shown[what] == [cell.split()[0] for cell in judged[row][:2]], what
    sample = rows(BENCHMARKS, "The bundled sample", "    ")
    errors = {name: [float(cell.rstrip("*")) for cell in sample[name][:2]] for name in sample if name in METHODS}
    peers = [error for name, error in errors.items() if name not in PRESETS]
    assert shown["holes of the sample"] == [
        f"{own / min(others):.2f}" for own, others in zip(errors["best"], zip(*peers, strict=True), strict=True)
    ]


@pytest.mark.parametrize("beginning", WRITTEN)
@pytest.mark.timeout(300)
def test_the_command_runs_and_writes_its_files(beginning, shell, capsys, monkeypatch):
    work_in_this_process(monkeypatch)
    shell.run(beginning)
    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("ilf: ")]
    assert [line for line in told if not line.startswith(TOLD_OF_THE_SAMPLE)] == []
    for place, names in WRITTEN[beginning].items():
        for name in names:
            assert (shell.folder / place / name).stat().st_size, f"{place}/{name} is empty"


def test_the_replay_gives_the_same_depth_bit_for_bit(shell):
    shell.run("complete --replay")
    again, done = (shell.folder / name / "depth.npy" for name in ("room-again", "room-done"))
    assert again.read_bytes() == done.read_bytes()


@pytest.mark.usefixtures("sample_room")
def test_the_lines_of_python_in_readme_run(capsys):
    names: dict[str, object] = {}
    exec(compile(python(README), "README.md", "exec"), names)
    assert "pixels filled" in capsys.readouterr().out
    assert names["error"].shape == names["frame"].shape


@pytest.mark.usefixtures("sample_room")
def test_the_examples_of_the_library_run_and_so_do_the_calls_in_the_text(capsys):
    names: dict[str, object] = {}
    exec(compile(with_thin_camera(python(LIBRARY)), "library.md", "exec"), names)
    assert all(Path(name).is_file() for name in ("completed.png", "completed.ply", "completed.glb"))
    assert "pixels filled" in capsys.readouterr().out
    frame, result = names["frame"], names["result"]
    assert names["strength"].shape == names["blocks"].shape == names["error"].shape == frame.shape
    np.testing.assert_array_equal(result.filled, ~frame.known & np.isfinite(result.depth))

    names |= {"rgb_uint8": frame.rgb, "depth_m": frame.depth}
    calls = re.findall(r"`(ilf\.\w+\([^`]*\))`", re.sub(r"\s+", " ", LIBRARY))
    assert len(calls) >= 3
    for call in calls:
        assert eval(call, names) is not None


def test_the_presets_of_the_table_are_those_there_are():
    listed = re.findall(r"^\| `([\w-]+)`", LIBRARY, re.MULTILINE)
    assert listed == list(PRESETS)


DOCUMENTS = [
    *(ROOT / "README.md", ROOT / ".github" / "CONTRIBUTING.md", ROOT / "assets" / "models" / "README.md"),
    *sorted(DOCS.rglob("*.md")),
]


def anchors(document: Path) -> set[str]:
    """What `#...` may name in a document: its headings, as they are written in addresses."""
    titles = re.findall(r"^#+ (.+)$", document.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_relative_links_lead_to_files_and_headings(document):
    broken = []
    for link in re.findall(r"\]\(([^)\s]+)\)", document.read_text(encoding="utf-8")):
        name, _, anchor = link.partition("#")
        target = (document.parent / name) if name else document
        if name.startswith(("https:", "http:", "mailto:")):
            continue
        if not target.exists() or (anchor and anchor not in anchors(target)):
            broken.append(link)
    assert broken == []


@pytest.mark.parametrize("document", sorted((DOCS / "decisions").glob("*.md")), ids=lambda path: path.stem)
def test_a_decision_is_read_in_one_sitting(document):
    assert len(document.read_text(encoding="utf-8").splitlines()) <= 40


def test_files_that_documents_name_are_there():
    lost = {
        (document.name, path)
        for document in DOCUMENTS
        if document.name != "changelog.md"
        for path in re.findall(r"`((?:ilf|gui|tests|assets)/[\w./-]+)`", document.read_text(encoding="utf-8"))
        if not (ROOT / path).exists()
    }
    assert lost == set()
