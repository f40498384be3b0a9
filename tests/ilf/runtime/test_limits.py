"""What strangers send and write: no server and no file is waited for without end, or fills the memory."""

import gzip
import io
import json
import os
import socket
import struct
import tarfile
import threading
import zipfile
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf._runtime.addresses import RemoteFiles
from ilf._runtime.folders import folder_at
from ilf._runtime.long_work import cancelled_by
from ilf._runtime.networks import network
from ilf.cli import main
from ilf.errors import Cancelled, FormatError, InputError
from ilf.io.depth import read_depth_values
from ilf.segmentation.edges.detectors import EdgeNetwork
from ilf.sources.opening import close_all
from ilf.sources.shards import ShardTable, members_of

from ..batch_frames import work_in_this_process, write_frames
from ..tiny_onnx import message, node, number, write_network

# Servers.

LIMIT = 2**20


class Handler(BaseHTTPRequestHandler):
    """Answers as the first part of the path says: a status, or a way of not coming to an end."""

    protocol_version = "HTTP/1.1"

    def log_message(self, *_: object) -> None:
        pass

    def do_HEAD(self) -> None:
        self.do_GET()

    def do_GET(self) -> None:
        way = self.path.split("/")[1]
        self.close_connection = True
        try:
            if way.isdecimal():
                self.send_response(int(way))
                self.send_header("Content-Length", "0")
                self.end_headers()
            else:
                getattr(self, way)()
        except OSError:
            pass  # the other side has had enough

    def _begin(self, **headers: object) -> bool:
        self.send_response(200)
        for name, value in headers.items():
            self.send_header(name.replace("_", "-"), str(value))
        self.end_headers()
        return self.command == "GET"

    def silent(self) -> None:
        self.server.released.wait(20)

    def endless(self) -> None:
        if self._begin():
            while self.server.sent < 64 * LIMIT:
                self.server.sent += self.wfile.write(bytes(2**16))

    def bomb(self) -> None:
        content = gzip.compress(bytes(4 * LIMIT))
        if self._begin(Content_Encoding="gzip", Content_Length=len(content)):
            self.wfile.write(content)

    def private(self) -> None:
        if self.headers["Authorization"] != "me":
            self.send_error(401)
        elif self._begin(Content_Length=9):
            self.wfile.write(bytes(9))

    def short(self) -> None:
        if self._begin(Content_Length=1000):
            self.wfile.write(bytes(100))

    def longer(self) -> None:
        stated = 1000 if self.command == "HEAD" else 2000
        if self._begin(Content_Length=stated):
            self.wfile.write(bytes(stated))


@pytest.fixture
def server(monkeypatch):
    web = pytest.importorskip("ilf._runtime.web", reason="fsspec or aiohttp is not installed (extra dev)")
    monkeypatch.setattr(web, "SILENCE_S", 0.5)
    web.WebFiles.clear_instance_cache()  # a driver has the limits of the time when it was made
    for module in ("files", "addresses"):
        monkeypatch.setattr(f"ilf._runtime.{module}.MAX_FILE_BYTES", LIMIT)
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as found:
        found.daemon_threads, found.sent, found.released = True, 0, threading.Event()
        threading.Thread(target=found.serve_forever, daemon=True).start()
        yield found
        found.released.set()
        found.shutdown()
    web.WebFiles.clear_instance_cache()
    close_all()


@pytest.fixture
def address(server):
    return f"http://127.0.0.1:{server.server_port}"


def refusing() -> str:
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))
        return f"http://127.0.0.1:{held.getsockname()[1]}"


def read_stream(files: RemoteFiles, name: str) -> bytes:
    with files.open(name) as stream:
        return stream.read()


WAYS = {
    "read": lambda files, name: files.read(name),
    "wanted": lambda files, name: files.read_all([], [name]),
    "exists": lambda files, name: files.exists(name),
    "stream": read_stream,
    "range": lambda files, name: files.read_ranges([name], [3], [9]),
    "listing": lambda files, name: RemoteFiles(f"{files.address}/{name}").find(),
    "sizes": lambda files, name: RemoteFiles(f"{files.address}/{name}").sizes(),
}
"""All that is asked of a server."""


@pytest.mark.parametrize("way", WAYS)
def test_refused_denied_missing_and_silent_are_told_apart(address, way):
    ask = WAYS[way]
    for where, name, told in (
        (refusing(), "a", "refuses the connection"),
        (address, "401/a", "access is denied"),
        (address, "403/a", "access is denied"),
        (address, "500/a", "cannot be read"),
        (address, "silent/a", "does not answer, or too slowly"),
    ):
        with pytest.raises(InputError, match=told):
            ask(RemoteFiles(where), name)
    missing = {"wanted": [None], "exists": False, "sizes": {}}
    if way in missing:
        assert ask(RemoteFiles(address), "404/a") == missing[way]
    else:
        with pytest.raises(InputError, match="there is no such f"):
            ask(RemoteFiles(address), "404/a")


@pytest.mark.parametrize("way", ["read", "stream", "range"])
@pytest.mark.parametrize("kind", ["endless", "bomb", "short", "longer"])
def test_no_more_is_read_than_is_allowed(server, address, kind, way):
    if way == "range":
        assert WAYS[way](RemoteFiles(address), f"{kind}/a")[0] in {bytes(6), gzip.compress(bytes(9))[3:9]}
    elif (kind, way) != ("longer", "read"):
        with pytest.raises(InputError, match=r"more than 1 GiB|Not enough data|sends \d+ bytes instead of 1000"):
            WAYS[way](RemoteFiles(address), f"{kind}/a")
    assert server.sent < 32 * LIMIT


def test_files_read_at_the_same_time_share_the_limit(server, address):
    with pytest.raises(FormatError, match="more than 1 GiB"):
        RemoteFiles(address).read_all([f"endless/{number}" for number in range(8)])
    assert server.sent < 64 * LIMIT


@pytest.mark.parametrize("failure", ["401", "403", "500", "silent"])
def test_shards_that_cannot_be_seen_are_not_made_again(tmp_path, monkeypatch, address, failure, cli):
    pytest.importorskip("pyarrow")
    work_in_this_process(monkeypatch)
    frames = write_frames(tmp_path / "in", 1)
    monkeypatch.setattr(RemoteFiles, "upload", lambda *_: pytest.fail("nothing is written"))
    assert cli("batch", frames, "--shards", f"{address}/{failure}/out", "--quiet", status=1).err.count("\n") == 1


def test_a_folder_that_cannot_be_looked_at_is_not_an_empty_one(tmp_path, monkeypatch):
    folder = folder_at(tmp_path)
    assert not folder.exists("a")

    def failing(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    with monkeypatch.context() as broken:
        broken.setattr(os, "stat", failing)
        with pytest.raises(InputError, match="Permission denied"):
            folder.exists("a")


# Files.


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes of POSIX")
@pytest.mark.parametrize("kind", ["pipe", "device"])
@pytest.mark.parametrize(
    "words",
    [
        "complete RGB FILE --out OUT", "complete RGB DEPTH --out OUT --guide FILE",
        "complete RGB DEPTH --out OUT --invalid-mask FILE",
        "complete RGB DEPTH --out OUT --intrinsics FILE", "complete --replay FILE --out OUT", "project info FILE",
        "models add FILE", "batch --shards SHARDS --verify", "info SHARDS", "info bag",
    ],
)  # fmt: skip
def test_a_pipe_is_not_waited_for_and_a_device_not_read(tmp_path, monkeypatch, capsys, words, kind):
    monkeypatch.chdir(tmp_path)
    write_frames(tmp_path / "in", 1)
    for name in ("file.json", "shards/shards.json", "bag/metadata.yaml", "bag/a.mcap"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        os.mkfifo(path) if kind == "pipe" else path.symlink_to("/dev/zero")
    meant = {
        "FILE": "file.npy",
        "RGB": "in/rgb/0000.png",
        "DEPTH": "in/depth/0000.png",
        "OUT": "out",
        "SHARDS": "shards",
    }
    assert main([meant.get(word, word) for word in words.split()]) == 1
    assert capsys.readouterr().err.count("\n") == 1


def test_tables_and_tars_are_regular_files(tmp_path, monkeypatch, capsys):
    pytest.importorskip("pyarrow")
    work_in_this_process(monkeypatch)
    out = tmp_path / "out"
    assert main(["batch", str(write_frames(tmp_path / "in", 1)), "--shards", str(out), "--max-iterations", "3"]) == 0
    for path in out.glob("shard-*"):
        content = path.read_bytes()
        path.unlink()
        path.symlink_to("/dev/zero")
        close_all()
        with pytest.raises(InputError, match="device or a pipe"):
            ilf.open_source(out)[0]
        assert main(["batch", "--shards", str(out), "--verify"]) == 1
        path.unlink()
        path.write_bytes(content)
    with open(next(out.glob("*.tar")), "ab") as tar:  # of holes
        tar.truncate(2**40)
    close_all()
    capsys.readouterr()
    assert ilf.open_source(out)[0].missing_share == 0
    assert main(["batch", "--shards", str(out), "--verify"]) == 1


def table_of(columns: dict, **how: object) -> bytes:
    pyarrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    sink = pyarrow.BufferOutputStream()
    facts = {"ilf": json.dumps({"sha256": "", "tar_sha256": "", "failed": 0})}
    parquet.write_table(pyarrow.table(columns).replace_schema_metadata(facts), sink, **how)
    return sink.getvalue().to_pybytes()


def large_tables() -> Iterator[bytes]:
    pyarrow = pytest.importorskip("pyarrow")
    text = pyarrow.DictionaryArray.from_arrays(pyarrow.array(np.zeros(50_000, np.int32)), ["x" * 100_000])
    yield table_of({"key": text})
    yield table_of({"key": pyarrow.chunked_array([["x" * 100_000] * 500] * 25)})
    yield table_of({"key": [[["x"]] * 1000] * 1000})


def test_a_small_table_does_not_become_gigabytes(monkeypatch):
    pytest.importorskip("pyarrow")
    assert ShardTable(table_of({"key": ["a", None], "size": [1, 2]}), "a.parquet").read("key", "size").num_rows == 2
    monkeypatch.setattr("ilf.sources.shards.TABLE_MEMORY", 2**30)
    for content in large_tables():
        assert len(content) < 2**20
        with pytest.raises(FormatError, match=r"a\.parquet is damaged"):
            ShardTable(content, "a.parquet").read("key")


def test_files_of_holes_in_a_tar_are_refused():
    info = tarfile.TarInfo("a.depth.png")
    info.pax_headers = {"GNU.sparse.major": "0", "GNU.sparse.minor": "1", "GNU.sparse.map": f"{2**40},0"}
    info.pax_headers |= {"GNU.sparse.size": str(2**40), "GNU.sparse.realsize": str(2**40)}
    with pytest.raises(FormatError, match=r"a\.depth\.png is not a plain file"):
        members_of(info.tobuf(tarfile.PAX_FORMAT), "a.tar")
    link = tarfile.TarInfo("a.depth.png")
    link.type, link.linkname = tarfile.SYMTYPE, "b"
    with pytest.raises(FormatError, match="not a plain file"):
        members_of(link.tobuf(), "a.tar")


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA])
def test_no_more_of_a_zip_is_unpacked_than_its_entry_states(tmp_path, method):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", method) as archive:
        archive.writestr("depth.npy", bytes(2**23))
    content = packed.getvalue().replace(struct.pack("<L", 2**23), struct.pack("<L", 1000))
    (tmp_path / "a.npz").write_bytes(content)
    with pytest.raises(FormatError, match=r"a\.npz: this NPZ cannot be read"):
        read_depth_values(tmp_path / "a.npz")


# Networks.


def value(name: str, kind: int, dimensions: int) -> bytes:
    shape = b"".join(message(1, message(2, f"{name}{number}")) for number in range(dimensions))
    return message(1, name) + message(2, message(1, number(1, kind) + message(2, shape)))


def write_endless(path: Path) -> Path:
    """A network with a loop that never ends."""
    inside = (
        message(1, node("Identity", ["go"], "more")) + message(1, node("Identity", ["x"], "y")) + message(2, "inside")
    )
    for field, values in ((11, (("i", 7, 0), ("go", 9, 0), ("x", 1, 4))), (12, (("more", 9, 0), ("y", 1, 4)))):
        inside += b"".join(message(field, value(*one)) for one in values)
    loop = node("Loop", ["", "", "image"], "all")
    loop += message(5, message(1, "body") + message(6, inside) + number(20, 5))
    return write_network(path, [loop, node("Sigmoid", ["all"], "s"), node("ReduceMean", ["s"], "strength", axes=[1])])


@pytest.fixture
def endless(tmp_path, monkeypatch):
    monkeypatch.setattr(network, "_bundled", frozenset)
    monkeypatch.setattr(network, "TRIAL_S", 1.0)
    return write_endless(tmp_path / "endless.onnx")


def children() -> set[str]:
    return set(Path(f"/proc/self/task/{threading.main_thread().native_id}/children").read_text().split())


def test_a_trial_that_does_not_end_is_ended(endless):
    before = children() if os.path.exists("/proc/self/task") else set()
    with pytest.raises(FormatError, match=r"endless\.onnx is damaged: running it takes longer than 1 s"):
        EdgeNetwork.load(endless)
    assert not before or children() <= before


def test_a_run_that_does_not_end_is_cancellable(endless, monkeypatch):
    monkeypatch.setattr(network, "TRIAL_S", 60.0)
    stop = threading.Event()
    threading.Timer(1.0, stop.set).start()
    with cancelled_by(stop), pytest.raises(Cancelled):
        EdgeNetwork.load(endless)


def test_a_bundled_network_is_cancelled_within_its_run(endless):
    session = network.Session(np.fromfile(endless, np.uint8))
    stop = threading.Event()
    threading.Timer(1.0, stop.set).start()
    with cancelled_by(stop), pytest.raises(Cancelled):
        session.run({session.first_input: np.zeros((1, 3, 64, 64), np.float32)})
