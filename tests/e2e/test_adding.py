"""What the architecture page says of adding something is true: a reader, a sink and an option, each in a few lines.

A layer, a panel and a command are tried in `test_contents.py`, `test_panels.py` and `test_commands.py`.
"""

import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import ilf
from gui.features.export.feature import ExportFeature
from ilf.cli import main
from ilf.data.camera import Cameras
from ilf.run.formats import BLOCKS, FORMATS, Format
from ilf.sources import opening
from ilf.sources.recording import RecordedFrame, Recording, sha256_of
from tests.ilf.small_frames import write_small_frame

from .conftest import open_frame

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "assets/docs/architecture.md").read_text(encoding="utf-8")


class Stack(Recording):
    """A file of `numpy.savez` with rgb (N, H, W, 3) and depth (N, H, W) in millimetres."""

    kind = "a stack of arrays"
    suffixes = (".stack",)

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        with np.load(path) as arrays:
            self._rgb, self._depth = arrays["rgb"], arrays["depth"]
        self.frames = {f"{number:04}": number for number in range(len(self._rgb))}

    def frame(self, key: str) -> RecordedFrame:
        rgb, depth = self._rgb[self.at(key)], self._depth[self.at(key)]
        return RecordedFrame(rgb, depth, sha256_of(rgb.tobytes()), sha256_of(depth.tobytes()), encoding="mm")

    def cameras(self, key: str) -> Cameras:
        return Cameras.registered(None)


def test_a_new_reader_is_one_class_and_one_line(tmp_path, monkeypatch, window, qtbot):
    frame = ilf.load_frame(*write_small_frame(tmp_path / "in"))
    depth = np.nan_to_num(1000 * frame.depth).round().astype(np.uint16)
    with open(tmp_path / "two.stack", "wb") as file:
        np.savez(file, rgb=np.stack([frame.rgb, frame.rgb]), depth=np.stack([depth, 2 * depth]))
    built_in = opening.built_in_kinds()
    monkeypatch.setattr(opening, "built_in_kinds", lambda: (*built_in, Stack))
    source = ilf.open_source(tmp_path / "two.stack")
    assert (source.keys, source.layout) == (("0000", "0001"), "a stack of arrays")
    np.testing.assert_array_equal(source[0].depth, frame.depth)
    np.testing.assert_allclose(source[1].depth, 2 * frame.depth, rtol=1e-6)
    assert main(["complete", f"{tmp_path}/two.stack", "--frame", "0001", "--out", f"{tmp_path}/out"]) == 0
    assert main(["complete", "--replay", f"{tmp_path}/out/run.json", "--out", f"{tmp_path}/again"]) == 0
    open_frame(window, qtbot, tmp_path / "two.stack", frame="0001")
    np.testing.assert_array_equal(window.workspace.current.frame.depth, source[1].depth)


def _summary(completion: ilf.Completion, image: str) -> tuple[bytes, Sequence[str]]:
    """A line for each block."""
    lines = (f"{label} {one.status.value}" for label, one in completion.outcomes.items())
    return "\n".join(lines).encode(), ()


def test_a_new_exporter_is_one_function_and_one_line(tmp_path, monkeypatch, window, qtbot):
    monkeypatch.setitem(FORMATS, "txt", Format(BLOCKS, "A line for each block", "blocks.txt", _summary))
    files = [*map(str, write_small_frame(tmp_path / "in"))]
    words = ["--max-iterations", "3", "--quiet", "--export", "txt", "--out"]
    assert main(["complete", *files, *words, f"{tmp_path}/out", "--export", f"{tmp_path}/new/room.txt"]) == 0
    frame = ilf.load_frame(*files)
    ilf.complete(frame, max_iterations=3).save(f"{tmp_path}/saved", exports=("txt",))
    text = (tmp_path / "new/room.txt").read_text()
    numbers = [line.split()[0] for line in text.splitlines()]
    assert numbers == [str(number) for number in range(1, len(numbers) + 1)]
    assert len(numbers) >= 2
    assert [path.read_text() for path in sorted(tmp_path.glob("*/blocks.txt"))] == [text, text]
    open_frame(window, qtbot, *files)
    exporting = window.feature(ExportFeature)
    exporting.ask()
    box = exporting.files.fields["exports"].boxes["txt"]
    assert (box.text(), box.isVisible(), box.isEnabled()) == ("blocks: A line for each block", True, True)
    box.click()
    assert "blocks.txt" in exporting.message.text()
    assert exporting.request().options.exports == ("txt",)


_PROGRAM = """
import contextlib, importlib.util, json, sys
from pathlib import Path
import ilf.data, ilf.run

def declare(package, name, kind, line):
    spec = importlib.util.find_spec(f"{package.__name__}.{name}")
    before, head, after = Path(spec.origin).read_text().partition(f"class {kind}(ParameterSet):")
    docstring, end, fields = after.partition('\"\"\"\\n\\n')
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    setattr(package, name, module)
    exec(before + head + docstring + end + f"    {line}\\n" + fields, vars(module))

sharpening = 'sharpening: float = declare(0.0, "Sharpening", "Sharpen.", "Data", unit="m", minimum=0, maximum=9)'
declare(ilf.data, "parameters", "Parameters", sharpening)
sheet = 'sheet: bool = declare(False, "Sheet", "A sheet.", "Blocks and run")'
digits = 'digits: int = declare(6, "Digits", "Of numbers.", "Blocks and run", unit="px", minimum=1, maximum=9, '
digits += 'special="all", when=("sheet", True))'
declare(ilf.run, "options", "ExportOptions", f"{sheet}\\n    {digits}")

import ilf
from ilf.cli import main
from ilf.data.parameters import Parameters
rgb, depth, out = sys.argv[1:]
assert main(["complete", rgb, depth, "--sharpening", "3", "--sheet", "--max-iterations", "3", "--out", out]) == 0
with contextlib.suppress(SystemExit):
    main(["complete", rgb, depth, "--sharpening", "10", "--out", out])
record = json.loads(Path(out, "run.json").read_text())
print(record["parameters"]["sharpening"], record["export"]["sheet"])
print(ilf.preset(sharpening=2).sharpening, "sharpening : float, 0 to 9 m" in Parameters.__doc__)

from PySide6.QtWidgets import QApplication, QDoubleSpinBox
from gui.widgets.parameter_form import ParameterForm
application = QApplication([])
form = ParameterForm(Parameters)
form.all_button.click()
editor = form.findChild(QDoubleSpinBox, "sharpening")
editor.setValue(4)
print(form.parameters().sharpening, editor.maximum(), editor.suffix())

from PySide6.QtWidgets import QCheckBox
from gui.features.export.files import FilesForm
files = FilesForm()
(box,) = [box for box in files.findChildren(QCheckBox) if box.text() == "Sheet"]
box.setChecked(True)
print(files.options().sheet, box.toolTip())
digits = files.fields["digits"].choice
print(digits.currentText(), type(files.options().digits).__name__, digits.isEnabled())
box.setChecked(False)
files.fields["digits"].show_value(1)
print(digits.currentText(), files.options().digits, digits.isEnabled())
digits.setEditText("12")
try:
    files.options()
except ValueError as error:
    print(error)
"""


def test_a_new_option_is_one_declaration(tmp_path):
    files = [*map(str, write_small_frame(tmp_path / "in")), str(tmp_path / "out")]
    environment = os.environ | {"QT_QPA_PLATFORM": "offscreen"}
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM, *files], cwd=ROOT, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-7:] == [
        *("3.0 True", "2.0 True", "4.0 9.0  m", "True A sheet.", "6 px int True", "all 1 False"),
        "Digits must lie between 1 and 9 px, not 12.",
    ]
    assert "sharpening must lie between 0 and 9 m, not 10" in done.stderr


def test_the_page_names_what_is_there_and_says_each_in_ten_lines():
    for name in re.findall(r"`((?:ilf|gui|tests|assets)/[\w/.]+)(?:`|::)", PAGE):
        assert (ROOT / name).exists(), name
    tests = re.findall(r"`(tests/[\w/.]+)::(\w+)`", PAGE)
    assert len(tests) == 7
    for file, test in tests:
        assert f"def {test}(" in (ROOT / file).read_text(encoding="utf-8"), test
    recipes = [part for part in PAGE.split("\n\n") if re.match(r"\*\*An? \w+\.\*\*", part)]
    assert [part.split("**")[1] for part in recipes] == [
        "A layer.",
        "A panel.",
        "A command.",
        "A reader.",
        "A sink.",
        "An option.",
    ]
    assert all(len(part.splitlines()) <= 10 for part in recipes)


def test_the_page_has_ten_types_where_it_says():
    rows = re.findall(r"^\| `(\w+)` \|.*\| `([\w/]+\.py)` \|$", PAGE, re.MULTILINE)
    assert len(rows) == 10
    for name, file in rows:
        assert f"class {name}" in (ROOT / file).read_text(encoding="utf-8"), name
