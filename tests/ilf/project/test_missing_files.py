"""Files of a project's frames that are gone are noticed, and found where they are now."""

import hashlib
import os
from collections.abc import Generator
from pathlib import Path
from typing import TypeVar

from ilf.data.frame import InputFile
from ilf.project.file import open_project, save_project
from ilf.project.missing_files import MissingFile, locate, missing_files, relocated
from ilf.project.project import Project, ProjectFrame
from ilf.project.sources import Places
from ilf.sources.frame_ref import FrameRef
from ilf.sources.reading_options import ReadingOptions

T = TypeVar("T")


def result(steps: Generator[object, None, T]) -> T:
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            return stop.value  # type: ignore[no-any-return]


def put(path: Path, content: bytes) -> InputFile:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return InputFile(str(path), hashlib.sha256(content).hexdigest())


def test_files_are_found_in_a_folder_by_name_and_taken_by_content(tmp_path):
    names = ("x/a.png", "x/b.png", "x/c.png")
    wanted = [InputFile(f"C:\\data\\{name}", hashlib.sha256(name.encode()).hexdigest()) for name in names]
    put(tmp_path / "x" / "a.png", b"x/a.png")
    put(tmp_path / "b.png", b"another picture of this name")
    put(tmp_path / "x" / "b.png", b"x/b.png")
    put(tmp_path / "x" / "renamed.png", b"x/c.png")
    folder, gone = InputFile("/gone/x", ""), InputFile("/gone/y", "")
    places = Places(folders=(tmp_path,))
    assert result(locate([*wanted, folder, gone], places)) == {
        wanted[0]: tmp_path / "x" / "a.png",
        wanted[1]: tmp_path / "x" / "b.png",
        folder: tmp_path / "x",
    }
    given = {wanted[2].path: tmp_path / "x" / "renamed.png", wanted[1].path: tmp_path / "b.png"}
    assert result(locate(wanted[1:], Places(given=given))) == {wanted[2]: given[wanted[2].path]}


def test_a_frame_without_work_misses_what_it_is_opened_from(tmp_path):
    put(tmp_path / "there.png", b"")
    source = FrameRef(str(tmp_path / "there.png"), str(tmp_path / "gone.png"))
    frames = ProjectFrame("a", "a", source), ProjectFrame("b", "b", FrameRef(str(tmp_path)))
    save_project(tmp_path / "p.ilf", Project(frames))
    with open_project(tmp_path / "p.ilf") as opened:
        lost = result(missing_files(opened))
    assert lost == [MissingFile("a", InputFile(str(tmp_path / "gone.png"), ""))]


def test_a_source_follows_its_files(tmp_path):
    found = {os.path.join("/old", "a", "sub", "rgb.png"): Path("/new/b/sub/rgb.png"), "/t.npy": Path("/u/t.npy")}
    source = FrameRef("/old/a", options=ReadingOptions(ground_truth="/t.npy", confidence="/old/a/sub/sure.png"))
    found["/old/a/sub/sure.png"] = Path("/new/b/sub/sure.png")
    options = ReadingOptions(ground_truth="/u/t.npy", confidence="/new/b/sub/sure.png")
    assert relocated(source, found) == FrameRef("/new/b", options=options)
    renamed = {"/old/a/rgb.png": Path("/new/colour.png")}
    assert relocated(FrameRef("/old/a"), renamed) == FrameRef("/old/a"), "no folder has it under its name"
    assert relocated(FrameRef("/old/a/rgb.png", "/old/a/d.png"), renamed).rgb == "/new/colour.png"
