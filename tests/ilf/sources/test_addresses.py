"""Sources at addresses: they are read as on a disk, and neither errors nor results contain credentials."""

import shutil
import sys
import tempfile
import threading
from pathlib import Path

import cv2
import h5py
import numpy as np
import pytest

import ilf
from ilf._runtime.addresses import RemoteFiles, without_credentials
from ilf._runtime.installation import asset_path
from ilf._runtime.long_work import cancelled_by
from ilf.cli import main
from ilf.errors import Cancelled, FormatError, InputError
from ilf.sources.opening import close_all
from ilf.sources.reading import read_frame

from ...web_server import serving_folder
from ..bags import write_aligned
from ..batch_frames import work_in_this_process, write_frames
from ..phone_files import write_stray
from ..small_sequences import write_sequence

fsspec = pytest.importorskip("fsspec")


@pytest.fixture(autouse=True)
def memory(tmp_path, monkeypatch):
    """An empty store; temporary folders are in the test's own folder and gone at the end."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    store = fsspec.filesystem("memory")
    store.store.clear()
    store.pseudo_dirs[:] = [""]
    yield store
    close_all()
    assert not list(tmp_path.glob("ilf-at-*"))


def upload(folder: Path, name: str) -> str:
    fsspec.filesystem("memory").put(str(folder), f"/data/{name}", recursive=True)
    return f"memory://data/{name}"


def write_tum(folder: Path) -> Path:
    write_frames(folder, 3)
    for kind in ("rgb", "depth"):
        lines = [f"{number}.00 {kind}/{number:04}.png" for number in range(3)]
        (folder / f"{kind}.txt").write_text("\n".join(lines))
    rows = [f"{number}.00 {number / 10} 0 0 0 0 0 1" for number in range(3)]
    (folder / "groundtruth.txt").write_text("\n".join(rows))
    return folder


def write_room(folder: Path) -> Path:
    return Path(shutil.copytree(asset_path("samples"), folder))


def write_bag(folder: Path, frames: int = 2) -> Path:
    folder.mkdir()
    return write_aligned(folder, "ros1", frames=frames)


@pytest.mark.parametrize(
    ("write", "name"),
    [
        (lambda folder: write_frames(folder, 3), "pairs"),
        (write_tum, "rgbd_dataset_freiburg1_desk"),
        (lambda folder: write_sequence(folder, 2), "seq-01"),
        (write_room, "samples"),
        (write_bag, "bags"),
        (lambda folder: write_stray(folder) or folder, "stray"),
    ],
    ids=["pairs", "lists by time", "layout with poses", "frame folders", "bag", "folder of a recording"],
)
def test_a_source_is_read_as_on_a_disk(tmp_path, write, name):
    path = write(tmp_path / name)
    address = upload(path, path.name)
    here, there = ilf.open_source(path), ilf.open_source(address)
    assert (there.keys, there.timestamps, there.layout) == (here.keys, here.timestamps, here.layout)
    assert [note.replace(address, str(path)) for note in there.notes] == list(here.notes)
    assert (there.path, there.path.name) == (address, path.name)
    for key in here.keys:
        one, other = (read_frame(source.ref(key)) for source in (here, there))
        assert [text.replace(str(path), address) for text in one.notes] == list(other.notes)
        assert one.name == other.name
        np.testing.assert_array_equal(one.rgb, other.rgb)
        np.testing.assert_array_equal(one.measured, other.measured)
        for pose in (other.pose, there.pose(key)):
            assert (pose is None) == (one.pose is None)
            assert pose is None or np.array_equal(pose, one.pose)
        assert one.inputs.rgb.path.replace(str(path), address) == other.inputs.rgb.path
        assert one.inputs.rgb.sha256 == other.inputs.rgb.sha256
        assert (one.inputs.ground_truth is None) == (other.inputs.ground_truth is None)
        assert one.intrinsics == other.intrinsics
        again = ilf.load_frame(**other.sources, warn=False)
        np.testing.assert_array_equal(one.measured, again.measured)
    assert there.calibration(there.keys[0]).colour == here.calibration(here.keys[0]).colour


def test_a_folder_on_the_web_is_read_by_its_pages_of_links(tmp_path, monkeypatch):
    pytest.importorskip("aiohttp", reason="aiohttp is not installed (extra dev)")
    pytest.importorskip("pyarrow")
    work_in_this_process(monkeypatch)
    path = write_frames(tmp_path / "web" / "in", 2)
    out = str(tmp_path / "web" / "shards")
    assert main(["batch", str(path), "--shards", out, "--max-iterations", "3", "--quiet", "--per-shard", "1"]) == 0
    with serving_folder(tmp_path / "web") as (address, _):
        for name in ("in", "shards"):  # this server sends whole files only, and states no sizes
            here, there = ilf.open_source(tmp_path / "web" / name), ilf.open_source(f"{address}/{name}")
            assert here.keys == there.keys
            for key in here.keys:
                np.testing.assert_array_equal(here[key].measured, there[key].measured)


def test_a_page_of_links_that_never_ends_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("ilf._runtime.web._MAX_PAGE_BYTES", 1000)
    (tmp_path / "index.html").write_text('<a href="rgb.png">rgb.png</a>' * 100)
    with serving_folder(tmp_path) as (address, _), pytest.raises(InputError, match="a page of more than"):
        RemoteFiles(address).find()


def test_files_at_the_root_of_a_server_are_read_from_nowhere_else(tmp_path, capsys):
    pytest.importorskip("aiohttp", reason="aiohttp is not installed (extra dev)")
    frames = write_frames(tmp_path / "in", 1)
    (web := tmp_path / "web").mkdir()
    shutil.copy(frames / "rgb/0000.png", web / "rgb.png")
    depth = cv2.imread(str(frames / "depth/0000.png"), cv2.IMREAD_UNCHANGED)
    with h5py.File(web / "take.h5", "w") as file:
        file["left/depth"], file["right/depth"] = depth + 1, depth
    with serving_folder(web) as (address, _):
        files = [f"{address}/{name}" for name in ("rgb.png", "take.h5:/right/depth")]
        frame = ilf.load_frame(*files)
        assert np.allclose(np.nan_to_num(frame.depth), depth / 1000)
        assert np.array_equal(ilf.load_frame(**frame.sources).depth, frame.depth, equal_nan=True)
        assert main(["complete", *files, "--out", str(tmp_path / "out"), "--quiet", "--max-iterations", "3"]) == 0
        assert main(["complete", "--replay", str(tmp_path / "out/run.json"), "--out", str(tmp_path / "again")]) == 0
        assert "identical to the recorded one" in capsys.readouterr().out


def test_a_run_of_a_remote_frame_is_replayed_and_its_folder_opened(tmp_path, capsys, cli):
    address = upload(write_frames(tmp_path / "in", 1), "in")
    files = [f"{address}/rgb/0000.png", f"{address}/depth/0000.png"]
    quick = ["--max-iterations", "3"]
    assert main(["complete", *files, "--out", str(tmp_path / "out"), "--quiet", *quick]) == 0
    assert ilf.open_source(tmp_path / "out").layout
    assert ilf.load_frame(tmp_path / "out").missing_share == 0
    capsys.readouterr()
    assert main(["complete", "--replay", str(tmp_path / "out/run.json"), "--out", str(tmp_path / "again")]) == 0
    assert "identical to the recorded one" in capsys.readouterr().out
    assert main(["info", *files]) == 0
    assert main(["info", address]) == 0
    shown = cli("info", address, "--frame", "0000").out
    assert shown.count(f"{files[0]}, 32 x 24") == 3
    assert str(tmp_path) not in shown


def test_a_recording_is_copied_once_and_again_when_it_changes(tmp_path, monkeypatch):
    copied: list[str] = []
    real = RemoteFiles.download
    monkeypatch.setattr(RemoteFiles, "download", lambda self, *how: copied.append(self.address) or real(self, *how))
    path = write_bag(tmp_path / "bags")
    address = upload(path, path.name)
    assert len(ilf.open_source(address)) == len(ilf.open_source(address)) == 2
    assert copied == [address]
    close_all()
    upload(write_bag(tmp_path / "others", 3), path.name)
    assert len(ilf.open_source(address)) == 3
    stop = threading.Event()
    stop.set()
    shutil.rmtree(tmp_path / "cache")
    close_all()
    with cancelled_by(stop), pytest.raises(Cancelled):
        ilf.open_source(address)
    assert not [path for path in (tmp_path / "cache").rglob("*") if path.is_file()]


def test_errors_name_the_address_and_the_cure(tmp_path, capsys):
    address = upload(write_frames(tmp_path / "in", 2), "in")
    fsspec.filesystem("memory").pipe("/data/in/depth/0001.png", b"\x89PNG\r\n\x1a\n damaged")
    source = ilf.open_source(address)
    with pytest.raises(FormatError, match=f"^{address}/depth/0001.png") as caught:
        source["0001"]
    assert str(tmp_path) not in str(caught.value)
    fsspec.filesystem("memory").rm("/data/in/depth/0001.png")
    with pytest.raises(InputError, match=f"^{address}/depth/0001.png: there is no such file"):
        source["0001"]
    with pytest.raises(InputError, match="memory://data/none: there is no such folder or file"):
        ilf.open_source("memory://data/none")
    with pytest.raises(InputError, match="contains no frames"):
        ilf.open_source(upload(write_frames(tmp_path / "one", 1) / "rgb", "one"))
    assert main(["complete", address, "--frame", "0000", "--out", "memory://data/out"]) == 2
    assert "only `ilf batch --shards` writes to addresses" in capsys.readouterr().err


def test_a_frame_that_cannot_be_read_is_a_row_of_the_batch(tmp_path, monkeypatch, cli):
    work_in_this_process(monkeypatch)
    address, out = upload(write_frames(tmp_path / "in", 3), "in"), tmp_path / "out"
    fsspec.filesystem("memory").pipe("/data/in/depth/0001.png", b"damaged")
    command = ["batch", address, "--out", str(out), "--max-iterations", "3", "--quiet"]
    assert f"{address}/depth/0001.png" in cli(*command, status=1).err
    assert (out / "manifest.csv").read_text().count("completed") == 2
    good = cv2.imencode(".png", np.full((24, 32), 2000, np.uint16))[1].tobytes()
    for number in (0, 1):
        fsspec.filesystem("memory").pipe(f"/data/in/depth/000{number}.png", good)
    before = (out / "rgb__0000/depth.png").read_bytes()
    assert main([*command, "--rerun-changed", "--retry-failed"]) == 0
    assert (out / "rgb__0000/depth.png").read_bytes() != before


SECRET = "wJalrXUtnFEMI/K7MDENG"


@pytest.mark.parametrize(
    "address",
    [f"https://me:{SECRET}@host/data", f"https://host/data?X-Amz-Signature={SECRET}", f"s3://me:{SECRET}@bucket/data"],
)
def test_credentials_in_an_address_are_refused_and_not_shown(tmp_path, cli, address):
    out = str(tmp_path / "out")
    for command in (
        ["info", address],
        ["complete", address, f"{address}/b", "--out", out],
        ["batch", address, "--out", out],
        ["batch", str(tmp_path), "--shards", address],
        ["batch", "--shards", address, "--verify"],
    ):
        shown = cli(*command, status=1)
        assert "credentials come from the driver's own settings" in shown.err
        assert SECRET not in shown.err + shown.out
    assert not (tmp_path / "out").exists()


def test_credentials_in_errors_of_drivers_are_not_shown(memory, monkeypatch, tmp_path):
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", SECRET)
    monkeypatch.setenv("ANOTHER_KEY", SECRET[:8])  # which is no reason to show the rest
    address = upload(write_frames(tmp_path / "in", 1), "in")
    source = ilf.open_source(address)

    def failing(*_: object, **__: object) -> bytes:
        raise OSError(f"403 for https://me:pw@host/a.png?X-Amz-Signature=abc with {SECRET}\nno")

    monkeypatch.setattr(type(memory), "cat_file", failing)
    with pytest.raises(InputError) as caught:
        source[0]
    assert "(403 for https://host/a.png with *** no). Check the address, the credentials" in str(caught.value)
    assert caught.value.__suppress_context__
    work_in_this_process(monkeypatch)
    assert main(["batch", address, "--out", str(tmp_path / "out"), "--quiet"]) == 1
    written = [path.read_text() for path in (tmp_path / "out").rglob("*") if path.is_file()]
    assert any("403 for https://host/a.png with ***" in text for text in written)
    assert not any(SECRET in text or "Signature" in text for text in written)
    assert without_credentials("hf://datasets/a/b@main: no") == "hf://datasets/a/b@main: no"


def test_a_missing_driver_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "gcsfs", None)
    with pytest.raises(InputError, match="gs:// needs gcsfs: run pip install gcsfs"):
        ilf.open_source("gs://bucket/data")
    with pytest.raises(InputError, match="what://bucket/data: this protocol is never opened"):
        ilf.open_source("what://bucket/data")
    monkeypatch.setitem(sys.modules, "fsspec.core", None)
    with pytest.raises(InputError, match=r"s3:// needs the package fsspec, .*ilf-studio\[cluster\]"):
        ilf.open_source("s3://bucket/data")


def test_names_that_could_leave_a_folder_are_left_out(memory, tmp_path):
    address = upload(write_frames(tmp_path / "in", 1), "in")
    for name in ("../../evil.png", "rgb/.hidden.png", "rgb//empty.png", "rgb\\back.png", "rgb/query.png?C=N"):
        memory.store[f"/data/in/{name}"] = memory.store["/data/in/rgb/0000.png"]
    assert sorted(RemoteFiles(address).find()) == ["depth/0000.png", "rgb/0000.png"]


def test_of_a_file_that_is_too_large_no_more_than_the_limit_is_taken(memory, monkeypatch):
    """Whatever is stored under a name that a stranger's frame has."""
    memory.pipe({"/data/large.png": bytes(10_000), "/data/empty.png": b""})
    monkeypatch.setattr("ilf._runtime.addresses.MAX_FILE_BYTES", 1000)
    taken, cat_file = [], type(memory).cat_file

    def noting(*given: object, **named: object) -> bytes:
        taken.append(content := cat_file(*given, **named))
        return content

    monkeypatch.setattr(type(memory), "cat_file", noting)
    files = RemoteFiles("memory://data")
    with pytest.raises(FormatError, match="more than 1 GiB"):
        files.read("large.png")
    assert files.read_all(["empty.png"], ["missing.png"]) == [b"", None]
    assert max(map(len, taken)) < 1100
