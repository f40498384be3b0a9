"""Files of a project's frames that are gone are found where they are now."""

import hashlib
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf.data.frame import InputFile
from ilf.project.sources import MissingSource, Places, load_inputs, located, moved
from ilf.sources.frame_ref import FrameRef, ReadingOptions


def put(path: Path, content: bytes = b"") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return path


def test_files_are_found_in_a_folder_by_name_and_taken_by_content(tmp_path):
    names = ("x/a.png", "x/b.png", "x/c.png")
    a, b, c = (InputFile(f"C:\\data\\{name}", hashlib.sha256(name.encode()).hexdigest()) for name in names)
    put(tmp_path / "x" / "a.png", b"x/a.png")
    other = put(tmp_path / "b.png", b"another picture of this name")
    put(tmp_path / "x" / "b.png", b"x/b.png")
    renamed = put(tmp_path / "x" / "renamed.png", b"x/c.png")
    places = Places(folders=(tmp_path,))
    assert located(a, places) == (tmp_path / "x" / "a.png", None)
    assert located(b, places) == (tmp_path / "x" / "b.png", None)
    assert located(c, places) == located(InputFile("/gone/y", ""), places) == (None, None)
    assert located(InputFile("/gone/x", ""), places) == (tmp_path / "x", None)
    given = Places(given={c.path: renamed, b.path: other})
    assert (located(c, given), located(b, given)) == ((renamed, None), (None, other))


def test_a_source_follows_its_files(tmp_path):
    there, guide, truth = put(tmp_path / "rgb.png"), put(tmp_path / "new" / "g" / "guide.npy"), put(tmp_path / "u.npy")
    old = str(tmp_path / "old" / "g")
    options = ReadingOptions(ground_truth="/t.npy", guide=f"{old}/guide.npy")
    places = Places(given={"/t.npy": truth}, folders=(tmp_path / "new",))
    now = ReadingOptions(ground_truth=str(truth), guide=str(guide))
    assert moved(FrameRef(str(there), old, options=options), places) == FrameRef(
        str(there), str(tmp_path / "new" / "g"), options=now
    )
    with pytest.raises(MissingSource, match=r"t\.npy no longer exists") as missing:
        moved(FrameRef(str(there), options=options), Places(folders=places.folders))
    assert missing.value.wanted == InputFile("/t.npy", "")


@pytest.mark.filterwarnings("ignore::ilf.DepthWarning")
def test_a_marker_of_missing_depth_is_known_again(tmp_path):
    depth = np.linspace(1000, 2000, 64 * 64).astype(np.uint16).reshape(64, 64)
    depth[:8] = 65535
    paths = tmp_path / "rgb.png", tmp_path / "depth.png"
    for path, image in zip(paths, (np.zeros((64, 64, 3), np.uint8), depth), strict=True):
        cv2.imwrite(str(path), image)
    frame = ilf.load_frame(*paths)
    assert frame.invalid_marker is not None
    assert load_inputs(frame.inputs, frame.name, None).invalid_marker == frame.invalid_marker
