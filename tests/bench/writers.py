"""All writers of files, each with two versions of a file set, for tests of disk failures and killed processes."""

import argparse
import io
import os
from collections.abc import Callable, Collection
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import numpy as np

import ilf
from ilf._runtime import writing as left_over
from ilf._runtime.installation import asset_path
from ilf._runtime.networks.models import new_model_path
from ilf._runtime.writing import restore_interrupted, write_bytes
from ilf.cli.sample import run as write_sample
from ilf.data.presets import UserPreset, write_preset
from ilf.io.block_files import write_blocks
from ilf.project.file import save_project
from ilf.project.frame_state import FrameState
from ilf.project.project import Project, ProjectFrame
from ilf.run.options import ExportOptions
from ilf.run.writing import write

Write = Callable[[Path, int], object]
"""Writes into a folder; the number selects one of two versions."""


@dataclass(frozen=True)
class Writer:
    """A writer of files.

    Attributes
    ----------
    name : str
    prepare : callable
        Takes a folder for inputs, and returns the write function.
    varying : collection of str
        Names of files that differ at each writing.
    """

    name: str
    prepare: Callable[[Path], Write]
    varying: Collection[str] = ()

    def steady(self, names: Collection[str]) -> list[str]:
        """Return the files that are the same at each writing."""
        return [name for name in names if name not in self.varying]


def contents(folder: Path) -> dict[str, bytes]:
    """Read every file below a folder, including hidden ones."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def contents_after_cleanup(folder: Path) -> dict[str, bytes]:
    """The same after the clean-up that the next writer does first, of remains of a killed process."""
    restore_interrupted(folder)
    left_over._cleared.discard(folder)  # as if this process had not used the folder yet
    write_bytes(folder / "next", b"")
    (folder / "next").unlink()
    return contents(folder)


def _frame(shift: float = 0.0) -> ilf.RGBDFrame:
    rows, columns = np.mgrid[:24, :32]
    depth = np.where(columns < 15, 1.5 + 0.004 * rows, 2.4 + 0.005 * columns) + shift
    depth[8:14, 4:10] = np.nan
    rgb = np.where((columns < 15)[..., None], [200, 90, 40], [40, 110, 180]).astype(np.uint8)
    return ilf.RGBDFrame(rgb, depth, ilf.Camera(30.0, 30.0, 15.5, 11.5), name="two-planes")


def _labels() -> np.ndarray:
    labels = np.ones((24, 32), np.int32)
    labels[:, 15:] = 2
    return labels


def _completions() -> list[ilf.Completion]:
    quick = ilf.preset(max_iterations=2, correction=False)
    return [ilf.Run(_frame(shift), _labels(), quick).complete() for shift in (0.0, 0.25)]


def _run(folder: Path) -> Write:
    versions = _completions()
    options = ExportOptions(depth_formats=("png", "tiff", "npy"), mesh="ply")
    return lambda target, version: write(target, versions[version], options)


def _export(folder: Path) -> Write:
    """Other formats, as offered in the window's dialog."""
    versions = _completions()
    options = ExportOptions(depth_formats=("tiff",), cloud="pcd", mesh="glb", curves=False, normals=True)
    return lambda target, version: write(target, versions[version], options)


def _cloud(folder: Path) -> Write:
    """Clouds and meshes only."""
    versions = [ilf.complete(_frame(shift), _labels() * 0) for shift in (0.0, 0.25)]
    options = ExportOptions(
        (), expected_error=False, labels=False, curves=False, cloud="ply", mesh="obj", run_record=False
    )
    return lambda target, version: write(target, versions[version], options)


def _project(folder: Path) -> Write:
    def write(target: Path, version: int) -> None:
        target.mkdir(exist_ok=True)
        frame = _frame(0.25 * version)
        state = FrameState("a" * 32, frame, ilf.Blocks(_labels()))
        save_project(
            target / "work.ilf", Project(frames=(ProjectFrame(state.id, "room", None, has_state=True),)), [state]
        )

    return write


def _blocks(folder: Path) -> Write:
    def write(target: Path, version: int) -> None:
        target.mkdir(exist_ok=True)
        write_blocks(target / "blocks.json", _labels() + version)

    return write


def _preset(folder: Path) -> Write:
    def write(target: Path, version: int) -> None:
        target.mkdir(exist_ok=True)
        write_preset(target / "own.json", UserPreset("own", ilf.preset(max_iterations=5 + version)))

    return write


def _model(folder: Path) -> Write:
    bundled = asset_path("models/edges.onnx").read_bytes()

    def write(target: Path, version: int) -> None:
        target.mkdir(exist_ok=True)
        with patch.dict(os.environ, ILF_MODELS=str(target)):
            # an additional field that readers skip, to distinguish the two
            path = new_model_path("own", replace=True)
            write_bytes(path, bundled if version else bundled + b"\x12\x01x")

    return write


def _sample(folder: Path) -> Write:
    older = folder / "older"
    older.mkdir()
    for path in asset_path("samples/room").iterdir():
        (older / path.name).write_bytes(b"older")

    def write(target: Path, version: int) -> None:
        source = asset_path("samples/room") if version else older
        with patch("ilf.cli.sample.asset_path", lambda _: source), redirect_stdout(io.StringIO()):
            write_sample(argparse.Namespace(dir=str(target), force=True))

    return write


WRITERS = {
    writer.name: writer
    for writer in (
        Writer("run", _run, ("run.json",)),
        Writer("export", _export, ("run.json",)),
        Writer("cloud", _cloud),
        Writer("project", _project, ("work.ilf",)),
        Writer("blocks", _blocks),
        Writer("preset", _preset),
        Writer("model", _model),
        Writer("sample", _sample),
    )
}
