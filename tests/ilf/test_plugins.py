"""Plugins: the examples of `assets/plugins`, installed; others that fail; none is looked up unless it is needed."""

import importlib
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf._runtime import plugins
from ilf.cli import main
from ilf.errors import ExportError, InputError
from ilf.io.frame_additions import guide_suffixes
from ilf.sources.opening import close_all, recording_suffixes
from ilf.sources.plugins import source_plugins

from .small_frames import CAMERA, QUICK, write_small_frame

EXAMPLES = Path(__file__).parents[2] / "assets" / "plugins"


@pytest.fixture
def site(tmp_path, monkeypatch):
    """An empty folder of installed packages."""
    folder = tmp_path / "site-packages"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)
    modules = set(sys.modules)
    yield folder
    close_all()
    for name in set(sys.modules) - modules:
        if name.startswith(("ilf_example", "broken")):
            del sys.modules[name]
    forget()


def forget() -> None:
    importlib.invalidate_caches()
    plugins.entry_points.cache_clear()
    source_plugins.cache_clear()


def install(site: Path, name: str, entries: dict[str, dict[str, str]], source: str) -> None:
    """Install a module as pip does: the module, and a folder that has its name, version and entry points."""
    module = name.replace("-", "_")
    (site / f"{module}.py").write_text(source)
    info = site / f"{module}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    lines = [line for group, named in entries.items() for line in (f"[{group}]", *map(" = ".join, named.items()))]
    (info / "entry_points.txt").write_text("\n".join(lines))
    forget()


def install_example(site: Path, kind: str) -> None:
    folder = EXAMPLES / f"example-{kind}"
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    source = (folder / f"ilf_example_{kind}.py").read_text()
    install(site, project["name"], project["entry-points"], source)


@pytest.fixture
def frame(tmp_path):
    return ilf.load_frame(*write_small_frame(tmp_path / "in"), intrinsics=CAMERA)


def test_a_kind_of_recording(site, tmp_path, frame, capsys):
    install_example(site, "source")
    depth = np.stack([np.nan_to_num(frame.depth * 1000), np.full(frame.shape, 2500)]).astype(np.uint16)
    K = np.array([[80, 0, 39.5], [0, 80, 29.5], [0, 0, 1]])
    with open(tmp_path / "two.rgbd", "wb") as file:
        np.savez(file, rgb=np.stack([frame.rgb, frame.rgb]), depth=depth, K=K)
    source = ilf.open_source(tmp_path / "two.rgbd")
    assert (source.keys, source.layout) == (("0000", "0001"), "an archive of NumPy arrays")
    np.testing.assert_array_equal(source[0].depth, frame.depth)
    np.testing.assert_array_equal(source[0].rgb, frame.rgb)
    assert (source[1].depth == 2.5).all()
    assert source[1].intrinsics.fx == 80
    assert ".rgbd" in recording_suffixes()
    arguments = ["complete", str(tmp_path / "two.rgbd"), "--frame", "0000", "--out", str(tmp_path / "out")]
    assert main([*arguments, "--max-iterations", "5", "--no-cloud"]) == 0
    assert main(["complete", "--replay", str(tmp_path / "out/run.json"), "--out", str(tmp_path / "again")]) == 0
    assert "identical to the recorded one" in capsys.readouterr().out
    (tmp_path / "bad.rgbd").write_bytes(b"not an archive")
    with pytest.raises(InputError, match=r"bad\.rgbd has no rgb"):
        ilf.open_source(tmp_path / "bad.rgbd")


def test_a_layout(site, tmp_path):
    rgb, depth = write_small_frame(tmp_path / "written")
    for file, folder in ((rgb, "left"), (depth, "range")):
        (tmp_path / "rig" / folder).mkdir(parents=True)
        file.rename(tmp_path / "rig" / folder / "7.png")
    with pytest.raises(InputError, match="contains no frames"):
        ilf.open_source(tmp_path / "rig")
    install_example(site, "source")
    source = ilf.open_source(tmp_path / "rig")
    assert source.layout == "stereo-rig (a stereo rig)"
    assert np.nanmin(source[0].depth) == np.float32(0.75)
    assert ilf.open_source(tmp_path / "rig", layout="stereo-rig").keys == source.keys


def test_an_export_format(site, tmp_path, cli):
    install_example(site, "exporter")
    rgb, depth = write_small_frame(tmp_path / "in")
    table = tmp_path / "new" / "room.BLOCKS.csv"
    arguments = ["complete", str(rgb), str(depth), "--max-iterations", "5", "--out", str(tmp_path / "out")]
    assert f"Exported to {table}" in cli(*arguments, "--export", table).out
    head, *rows = table.read_text().splitlines()
    assert head.startswith("block,status")
    assert [row.split(",")[0] for row in rows] == [str(label) for label in range(1, len(rows) + 1)]
    assert len(rows) >= 2
    before = table.read_bytes()
    told = cli(*arguments, "--export", tmp_path / "room.csv", status=1).err
    assert "no export with this extension. Known: .exr, " in told
    assert told.endswith(".rrd, .blocks.csv.\n")
    assert table.read_bytes() == before


def test_the_library_exports_but_not_over_an_input(site, tmp_path, frame):
    install_example(site, "exporter")
    completion = ilf.complete(frame, **QUICK)
    completion.export(tmp_path / "a.blocks.csv")
    assert (tmp_path / "a.blocks.csv").read_text().count("\n") == 1 + len(completion.outcomes)
    install(site, "broken-package", {"ilf.exporters": {"png": "ilf_example_exporter:BlockTable"}}, "")
    before = (tmp_path / "in/depth.png").read_bytes()
    with pytest.raises(ExportError, match="is the frame's own file"):
        completion.export(tmp_path / "in/depth.png")
    assert (tmp_path / "in/depth.png").read_bytes() == before


def test_a_network_of_a_guide(site, tmp_path, frame, capsys):
    install_example(site, "guide")
    network = tmp_path / "depth.linear.json"
    network.write_text('{"weights": [0, 0, 1, 2, 3]}')
    found = ilf.load_guide(network, rgb=frame.rgb)
    assert found.values[30, 40] == pytest.approx(frame.rgb[30, 40, 2] / 255 + 2 * 0.5 + 3 * 0.5)
    assert found.path == str(network)
    assert ".linear.json" in guide_suffixes()
    files = [str(tmp_path / "in" / name) for name in ("rgb.png", "depth.png")]
    out = tmp_path / "out"
    assert main(["complete", *files, "--guide", str(network), "--max-iterations", "5", "--out", str(out)]) == 0
    np.testing.assert_array_equal(np.load(out / "guide_used.npy"), found.values)
    with pytest.raises(InputError, match="predicts a guide from the frame's colour"):
        ilf.load_guide(network)
    with pytest.raises(InputError, match="there is no such file"):
        ilf.load_guide(tmp_path / "other.linear.json", rgb=frame.rgb)
    network.write_text('{"weights": [1]}')
    with pytest.raises(InputError, match="has 1 weights, not 5"):
        ilf.load_guide(network, rgb=frame.rgb)


BROKEN = {
    "ilf.sources": {"odd": "broken_package:missing"},
    "ilf.exporters": {"odd": "broken_package:missing"},
    "ilf.guides": {"odd": "broken_package:missing"},
}


def test_a_plugin_that_cannot_be_loaded_is_named_and_stops_nothing_else(site, tmp_path, frame, capsys):
    install(site, "broken-package", BROKEN, "import no_such_module")
    install_example(site, "source")
    failed = "of the package broken-package failed: ModuleNotFoundError: No module named 'no_such_module'."
    source = ilf.open_source(tmp_path / "in")  # the folder of colour and depth
    assert len(source) == 1
    assert [note for note in source.notes if failed in note] == [source.notes[-1]]
    assert ".rgbd" in recording_suffixes()
    (tmp_path / "x.odd").write_text("x")
    with pytest.raises(InputError, match=failed):
        ilf.open_source(tmp_path / "x.odd")
    with pytest.raises(InputError, match=failed):
        ilf.load_guide(tmp_path / "x.odd", rgb=frame.rgb)
    files = [str(tmp_path / "in" / name) for name in ("rgb.png", "depth.png")]
    capsys.readouterr()
    assert main(["complete", *files, "--export", str(tmp_path / "y.odd"), "--out", str(tmp_path / "out")]) == 1
    assert failed in (told := capsys.readouterr().err)
    assert told.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_plugins_that_fail_when_they_are_used(site, tmp_path, frame):
    entries = {
        "ilf.sources": {"odd": "broken_package:Odd", "number": "broken_package:NUMBER"},
        "ilf.exporters": {"odd": "broken_package:Writer"},
        "ilf.guides": {"odd": "broken_package:predict"},
    }
    source = """
from ilf.sources.recording import Recording
NUMBER = 7
class Odd(Recording):
    index = frame = cameras = None
    @classmethod
    def fits(cls, path):
        raise RuntimeError("no idea")
class Writer:
    def write(self, path, completion):
        path.write_text("half")
        raise RuntimeError("no ink")
def predict(path, rgb):
    raise RuntimeError("no memory")
"""
    install(site, "broken-package", entries, source)
    notes = ilf.open_source(tmp_path).notes
    assert [text for note in notes for text in ("no idea", "neither a subclass of Recording") if text in note] == [
        "neither a subclass of Recording",
        "no idea",
    ]
    (tmp_path / "x.odd").write_text("before")
    with pytest.raises(InputError, match="broken-package failed: RuntimeError: no memory"):
        ilf.load_guide(tmp_path / "x.odd", rgb=frame.rgb)
    with pytest.raises(InputError, match="broken-package failed: RuntimeError: no ink"):
        ilf.complete(frame, **QUICK).export(tmp_path / "x.odd")
    assert (tmp_path / "x.odd").read_text() == "before"


def test_a_plugin_that_ends_the_program_or_lacks_a_method_is_named(site, tmp_path, frame, cli):
    install_example(site, "source")
    entries = {
        "ilf.sources": {"a": "broken_package:Abstract", "e": "broken_package:Ending"},
        "ilf.exporters": {"odd": "broken_package:Ending", "none": "broken_package:Silent"},
    }
    source = """
import sys
from ilf.sources.recording import Recording
class Abstract(Recording):
    suffixes = (".odd",)
class Silent:
    def write(self, path, completion): pass
class Ending(Abstract):
    index = frame = cameras = write = lambda *_: sys.exit(7)
    def __init__(self, path=None): sys.exit(7)
"""
    install(site, "broken-package", entries, source)
    (tmp_path / "x.odd").write_text("x")
    assert "broken-package failed: SystemExit: 7" in (told := cli("info", tmp_path / "x.odd", status=1).err)
    assert told.count("\n") == 1
    source = ilf.open_source(tmp_path / "in")
    assert any("Abstract is abstract: it has no cameras, frame" in note for note in source.notes)
    assert ".rgbd" in recording_suffixes()
    completion = ilf.complete(frame, **QUICK)
    with pytest.raises(InputError, match="broken-package failed: SystemExit: 7"):
        completion.export(tmp_path / "y.odd")
    with pytest.raises(ExportError, match="broken-package has written nothing"):
        completion.export(tmp_path / "y.none")
    assert not list(tmp_path.glob("y.*"))


@pytest.mark.parametrize("content", [b"[ilf.sources]\nno equals sign\n", b"[ilf.sources]\na = \xff\n"])
def test_a_damaged_list_of_one_package_leaves_the_others(site, content):
    install_example(site, "source")
    install(site, "broken-package", {}, "")
    (site / "broken_package-1.0.dist-info" / "entry_points.txt").write_bytes(content)
    forget()
    assert ".rgbd" in recording_suffixes()


def test_two_packages_with_the_same_format_are_both_named(site, tmp_path, frame):
    for name in ("broken-one", "broken-two"):
        install(site, name, {"ilf.guides": {"odd": f"{name.replace('-', '_')}:predict"}}, "")
    with pytest.raises(InputError, match=r"broken-one and broken-two both read or write \.odd"):
        ilf.load_guide(tmp_path / "x.odd", rgb=frame.rgb)


def test_plugins_are_not_looked_up_by_the_import_the_version_or_built_in_files(tmp_path):
    program = """
import sys
import ilf
from ilf.cli import main
assert main(["--version"]) == 0
assert "ilf._runtime.plugins" not in sys.modules
from ilf._runtime import plugins
plugins.entry_points = None
ilf.load_frame(*sys.argv[1:])
"""
    files = map(str, write_small_frame(tmp_path / "in"))
    subprocess.run([sys.executable, "-c", program, *files], check=True, stdout=subprocess.DEVNULL)


def test_rerun_is_missed_before_the_run(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "rerun", None)
    files = map(str, write_small_frame(tmp_path / "in"))
    assert main(["complete", *files, "--export", str(tmp_path / "x.rrd"), "--out", str(tmp_path / "out")]) == 1
    assert 'pip install "rerun-sdk"' in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
