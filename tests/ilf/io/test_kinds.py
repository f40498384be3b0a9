"""Files of kinds that are not read are named by their kind, with what is read instead."""

from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf.io.depth import read_depth_values
from ilf.io.images import read_colour
from tests.ilf.depth_files import pillow
from tests.ilf.image_files import write_rgbd

GREY = np.arange(96, dtype=np.uint16).reshape(8, 12) + 1000


def encoded(kind: str) -> bytes:
    return pillow(np.zeros((8, 12, 3), np.uint8), kind)


KINDS_OF_POINTERS = ("png", "npy", "exr", "h5", "npz", "pcd", "heic")
POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n"
FOREIGN = {
    **{f"pointer.{suffix}": (lambda: POINTER, "Git LFS") for suffix in KINDS_OF_POINTERS},
    "colour.webp": (lambda: encoded("WEBP"), "WebP"),
    "colour.gif": (lambda: encoded("GIF"), "GIF"),
    "colour.bmp": (lambda: encoded("BMP"), "BMP"),
    "colour.jp2": (lambda: encoded("JPEG2000"), "JPEG 2000"),
    "colour.avif": (lambda: b"\0\0\0\x1cftypavif\0\0\0\0", "AVIF"),
    "colour.jxl": (lambda: b"\0\0\0\x0cJXL \r\n\x87\n", "JPEG XL"),
    "bare.jxl": (lambda: b"\xff\x0a" + bytes(9), "JPEG XL"),
    "report.pdf": (lambda: encoded("PDF"), "PDF"),
    "page.png": (lambda: b"\n<!DOCTYPE html><title>404</title>", "HTML"),
    "photo.heic": (lambda: encoded("JPEG"), "JPEG"),
    "table2.csv": (lambda: b"x,y,depth\n1,2,3.4\n", "CSV"),
    "mcap.svo2": (lambda: b"\x89MCAP0\r\n" + bytes(60), "ZED"),
    "network.pt": (lambda: b"PK\x03\x04" + bytes(60), "array"),
    "comment.png": (lambda: b"<!-- page -->\n<html>not here</html>", "HTML"),
    "files.zip": (lambda: b"PK\x03\x04" + bytes(60), "zip"),
    "film.mp4": (lambda: b"\0\0\0\x20ftypisom\0\0\x02\0", "video"),
    "film.webm": (lambda: b"\x1aE\xdf\xa3" + bytes(30), "video"),
    "table.csv": (lambda: b"3.1,2.2,,nan,4\n1,2,3,4,5\n", "CSV"),
    "table.png": (lambda: b"3.1 2.2 1e-3 4\n1 2 3 4\n", "CSV"),
    "take.svo": (lambda: bytes(64), "ZED"),
    "frame.dpt": (lambda: b"PIEH" + bytes(60), "Sintel"),
    "data.json": (lambda: b'{"depth": [1, 2]}', "JSON"),
    "data.mat": (lambda: b"MATLAB 5.0 MAT-file, Platform: GLNXA64", "MATLAB"),
    "note.png": (lambda: b"hello, this is no image", "text"),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_a_file_of_another_kind_is_named(name, tmp_path, cli):
    make, kind = FOREIGN[name]
    (tmp_path / name).write_bytes(make())
    write_rgbd(tmp_path, GREY)
    for paths in ((name, "depth.png"), ("rgb.png", name)):
        with pytest.raises(ilf.IlfError, match=rf"{name} is .*{kind}.*, not (a|an) [A-Z]") as told:
            ilf.load_frame(*(tmp_path / path for path in paths))
        assert "despite" not in str(told.value)
    for command in (["info"], ["complete", "--out", str(tmp_path / "out")], ["batch", "--out", str(tmp_path / "b")]):
        said = cli(command[0], tmp_path / name, *command[1:], status=1).err
        assert kind in said or Path(name).suffix not in {".svo", ".svo2", ".csv", ".webp", ".mp4", ".zip"}


@pytest.mark.parametrize("kind", ["NPY", "HDF5"])
def test_a_format_under_another_suffix_is_not_said_to_be_none_that_is_read(kind, tmp_path):
    content = {"NPY": b"\x93NUMPY\x01\0", "HDF5": b"\x89HDF\r\n\x1a\n"}[kind] + bytes(90)
    (tmp_path / "depth.dat").write_bytes(content)
    write_rgbd(tmp_path, GREY)
    with pytest.raises(ilf.IlfError, match=f"{kind}.* Rename it") as told:
        read_depth_values(tmp_path / "depth.dat")
    assert "not a" not in str(told.value)
    with pytest.raises(ilf.IlfError, match=f"{kind}.*swapped"):
        ilf.load_frame(tmp_path / "depth.dat", tmp_path / "depth.png")


@pytest.mark.parametrize("name", ["take.bag", "take.mcap", "take.db3", "take.mkv", "take.r3d", "take.sens", "take.mat"])
def test_pointers_in_place_of_recordings_are_named(name, tmp_path):
    (tmp_path / name).write_bytes(POINTER)
    with pytest.raises(ilf.IlfError, match="Git LFS pointer"):
        ilf.open_source(tmp_path / name)


@pytest.mark.parametrize("largest", [1200, 65535])
def test_text_pgm_of_16_bits_is_read(largest, tmp_path):
    rows = "\n".join(" ".join(map(str, row)) for row in GREY)
    (tmp_path / "depth.pgm").write_text(f"P2\n# by hand\n12 8\n{largest}\n# rows\n{rows}\n")
    assert np.array_equal(read_depth_values(tmp_path / "depth.pgm"), GREY)
    for wrong in (f"{largest}\n{rows[:-9]}", f"1010\n{rows}", f"{largest}\n{rows.replace('9', 'x')}"):
        (tmp_path / "depth.pgm").write_text(f"P2 12 8 {wrong}")
        with pytest.raises(ilf.IlfError, match="damaged"):
            read_depth_values(tmp_path / "depth.pgm")


def test_text_ppm_is_colour_scaled_by_its_largest_value(tmp_path):
    (tmp_path / "rgb.ppm").write_text("P3 2 1 15\n15 0 3  0 15 0")
    assert read_colour(tmp_path / "rgb.ppm").tolist() == [[[255, 0, 51], [0, 255, 0]]]
