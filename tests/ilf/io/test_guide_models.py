"""Guide networks by name: fetched from a server that fails in every way, added from files, used, recorded."""

import errno
import hashlib
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import numpy as np
import pytest

import ilf
from ilf._runtime.long_work import cancelled_by
from ilf._runtime.networks.network import Session
from ilf.cli import main
from ilf.data.guide import GuideCard
from ilf.errors import Cancelled, ExportError, FormatError, InputError
from ilf.io import guide_models
from ilf.io.guide_models import fetch_guide, guide_cards, guide_file, guides_folder
from ilf.sources.frame_ref import ReadingOptions

from ...web_server import serving
from ..batch_frames import work_in_this_process
from ..tiny_onnx import node, write_network
from .test_guide_network import brightness, scene, write_scene

NAME = "small-depth"


@dataclass
class Hub:
    """A server of one file, and how it fails."""

    content: bytes
    cuts: list[int] = field(default_factory=list)
    """Bytes after which the next connections are cut."""
    status: int = 200
    ranges: bool = True
    states_length: bool = True
    go_on: threading.Event = field(default_factory=threading.Event)
    """Set when the second half may be sent."""
    path: str = "/net.onnx"
    asked: list[tuple[str, str | None]] = field(default_factory=list)
    address: str = ""


def _handler(hub: Hub) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def log_message(self, *_: Any) -> None:
            pass

        def do_GET(self) -> None:
            wanted = self.headers.get("Range")
            hub.asked.append((self.path, wanted))
            if hub.status in {301, 302, 307} and self.path == hub.path:
                self.send_response(hub.status)
                self.send_header("Location", "/elsewhere")
                self.end_headers()
                return
            if hub.status >= 400:
                self.send_error(hub.status)
                return
            start = 0
            if wanted and int(wanted.removeprefix("bytes=").rstrip("-")) >= len(hub.content):
                self.send_response(416)
                self.send_header("Content-Range", f"bytes */{len(hub.content)}")
                self.end_headers()
                return
            if wanted and hub.ranges:
                start = int(wanted.removeprefix("bytes=").rstrip("-"))
                self.send_response(206)
                self.send_header("Content-Range", f"bytes {start}-{len(hub.content) - 1}/{len(hub.content)}")
            else:
                self.send_response(200)
            if hub.states_length:
                self.send_header("Content-Length", str(len(hub.content) - start))
            self.end_headers()
            end = start + hub.cuts.pop(0) if hub.cuts else None
            halfway = end if hub.go_on.is_set() else max(len(hub.content) // 2, start)
            self.wfile.write(hub.content[start:halfway])
            if halfway != end and hub.go_on.wait(60):
                with suppress(OSError):  # the fetch was cancelled
                    self.wfile.write(hub.content[halfway:end])

    return Handler


@contextmanager
def publishing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Hub]:
    """A server with a network that predicts the mean of its channels, and a known card of it."""
    monkeypatch.setattr("ilf._runtime.networks.network._networks", {})
    monkeypatch.setenv("ILF_MODELS", str(tmp_path / "models"))
    monkeypatch.setattr("ilf.io.fetching._BLOCK", 64)
    made = Hub(brightness(tmp_path / "source.onnx").read_bytes())
    with serving(_handler(made)) as address:
        made.address = address + made.path
        know(monkeypatch, made)
        yield made


@pytest.fixture
def hub(tmp_path, monkeypatch):
    with publishing(tmp_path, monkeypatch) as made:
        made.go_on.set()
        yield made


def know(monkeypatch: pytest.MonkeyPatch, hub: Hub, **facts: Any) -> GuideCard:
    """Make the card of the server's network known."""
    card = GuideCard(NAME, "Somebody", "CC-BY-NC-4.0", "affine-inverse", len(hub.content), address=hub.address)
    usual = {"sha256": hashlib.sha256(hub.content).hexdigest(), "terms": "not for commercial use", "size": 64}
    card = replace(card, **{**usual, **facts})
    monkeypatch.setattr(guide_models, "_known", lambda: {NAME: card})
    return card


def pinned() -> str:
    return str(json.loads((guides_folder() / f"{NAME}.json").read_text())["sha256"])


def left() -> list[str]:
    """The names of what a fetch left behind."""
    return sorted(path.name for path in guides_folder().iterdir() if path.suffix != ".lock")


def test_it_is_fetched_once_with_progress_and_its_hash_is_pinned(hub):
    steps: list[tuple[int, int]] = []
    path = fetch_guide(NAME, lambda done, whole: steps.append((done, whole)))
    assert path == guide_file(NAME)
    assert path.read_bytes() == hub.content
    assert steps[-1] == (len(hub.content), len(hub.content))
    assert [done for done, _ in steps] == sorted(done for done, _ in steps)
    assert pinned() == hashlib.sha256(hub.content).hexdigest()
    assert left() == [f"{NAME}.json", f"{NAME}.onnx"]
    fetch_guide(NAME)
    assert len(hub.asked) == 1


@pytest.mark.parametrize("status", [301, 302, 307])
def test_redirects_are_followed(hub, status):
    hub.status = status
    assert fetch_guide(NAME).read_bytes() == hub.content
    assert [path for path, _ in hub.asked] == [hub.path, "/elsewhere"]


def test_a_cut_connection_is_one_sentence_and_the_next_command_continues(hub, capsys, cli):
    hub.cuts = [40]
    captured = cli("models", "fetch", NAME, status=1)
    assert "cut after 40 of" in captured.err
    assert captured.err.count("\n") == 1
    assert guide_file(NAME) is None
    assert main(["models", "fetch", NAME]) == 0
    assert hub.asked[-1] == (hub.path, "bytes=40-")
    out = capsys.readouterr().out
    assert "licence CC-BY-NC-4.0, not for commercial use" in out
    assert pinned() in out


@pytest.mark.parametrize("change", [{"ranges": False}, {"sha256": None}], ids=["no ranges", "no hash"])
def test_what_cannot_be_continued_comes_from_the_start(hub, monkeypatch, change):
    if "ranges" in change:
        hub.ranges = False
    else:
        know(monkeypatch, hub, **change)
    hub.cuts = [100]
    with pytest.raises(InputError, match="cut after 100 of"):
        fetch_guide(NAME)
    assert fetch_guide(NAME).read_bytes() == hub.content


def test_a_part_that_is_whole_is_not_fetched_again(hub):
    guides_folder().mkdir(parents=True)
    (guides_folder() / f".{NAME}.onnx.part").write_bytes(hub.content)
    assert fetch_guide(NAME).read_bytes() == hub.content
    assert left() == [f"{NAME}.json", f"{NAME}.onnx"]


def test_without_a_stated_length_the_size_of_the_card_counts(hub):
    hub.states_length = False
    assert fetch_guide(NAME).read_bytes() == hub.content
    guide_models.remove_guide(NAME)
    hub.cuts = [100]
    with pytest.raises(InputError, match="cut after 100 of"):
        fetch_guide(NAME)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        pytest.param({"content": b"x" * 50}, "has 50 bytes instead of", id="wrong size"),
        pytest.param({"status": 404}, "status 404, Not Found", id="404"),
        pytest.param({"status": 401}, "status 401", id="401"),
        pytest.param({"status": 503}, "status 503", id="503"),
        pytest.param({"status": 418}, "status 418", id="418"),
    ],
)
def test_what_is_not_the_file_is_refused_and_leaves_nothing(hub, change, reason):
    for name, value in change.items():
        setattr(hub, name, value)
    with pytest.raises(InputError, match=f"{hub.address}: .*{reason}"):
        fetch_guide(NAME)
    assert left() == []


def test_a_wrong_hash_is_refused_and_the_right_file_still_comes(hub):
    right = hub.content
    hub.content = right.replace(b"make strength", b"made strength")
    with pytest.raises(InputError, match=r"SHA-256 is [0-9a-f]{64} instead of [0-9a-f]{64}"):
        fetch_guide(NAME)
    assert left() == []
    hub.content = right
    assert fetch_guide(NAME).read_bytes() == right


def test_more_than_was_stated_is_refused(hub):
    hub.states_length = False
    hub.content += bytes(1000)
    with pytest.raises(InputError, match="sends more than"):
        fetch_guide(NAME)


def test_a_server_that_is_not_there_is_one_sentence(hub, monkeypatch):
    know(monkeypatch, replace(hub, address="http://127.0.0.1:1/net.onnx"))
    with pytest.raises(InputError, match=r"cannot be reached \(.*refused.*\). Check the connection"):
        fetch_guide(NAME)
    know(monkeypatch, replace(hub, address="file:///etc/hostname"))
    with pytest.raises(InputError, match="not an address of a web server"):
        fetch_guide(NAME)


def test_a_way_that_leaves_encryption_is_refused(hub, monkeypatch):
    monkeypatch.setattr("ilf.io.fetching.urlopen", lambda request, timeout: urlopen(hub.address))
    know(monkeypatch, replace(hub, address="https://hub.test/net.onnx"))
    with pytest.raises(InputError, match="without encryption"):
        fetch_guide(NAME)
    assert left() == []


def test_the_first_file_of_a_network_without_hash_is_pinned_and_no_other_is_taken_later(hub, monkeypatch, tmp_path):
    know(monkeypatch, hub, sha256=None, bytes=len(hub.content) + 1)
    first, hub.content = hub.content, b"n" * len(hub.content)
    with pytest.raises(FormatError, match="cannot be read as an ONNX network"):
        fetch_guide(NAME)
    assert left() == []
    hub.content = first
    fetch_guide(NAME)
    assert guide_cards()[0][NAME].sha256 == pinned() == hashlib.sha256(first).hexdigest()
    guide_models.remove_guide(NAME)
    hub.content = first.replace(b"make strength", b"made strength")
    with pytest.raises(InputError, match="SHA-256 is"):
        fetch_guide(NAME)


def test_cancelled_or_on_a_full_disk_it_does_not_appear_and_continues_later(hub, monkeypatch):
    stop = threading.Event()
    with cancelled_by(stop), pytest.raises(Cancelled):
        fetch_guide(NAME, lambda *_: stop.set())
    assert guide_file(NAME) is None

    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(ExportError, match=r"Could not write .*disk is full"):
        fetch_guide(NAME, full)
    assert fetch_guide(NAME).read_bytes() == hub.content
    assert hub.asked[-1][1] == "bytes=128-"


def test_two_processes_do_not_fetch_the_same_file(hub):
    def again(*_: Any) -> None:
        with pytest.raises(ExportError, match="Another process is fetching"):
            fetch_guide(NAME)

    assert fetch_guide(NAME, again).read_bytes() == hub.content


def test_nothing_is_fetched_unasked(hub):
    rgb, _ = scene()
    with pytest.raises(InputError, match=rf"Fetch its 0 MB \(licence CC-BY-NC-4.0, not.*\): ilf models fetch {NAME}"):
        ilf.load_guide(NAME, rgb=rgb)
    assert hub.asked == []


def test_a_network_is_used_by_its_name_and_recorded(hub, tmp_path, capsys, cli, monkeypatch):
    work_in_this_process(monkeypatch)
    fetch_guide(NAME)
    folder = write_scene(tmp_path / "frames" / "box")
    frame = ilf.load_frame(folder, guide=NAME)
    assert frame.guide is not None
    assert frame.guide.network == guide_cards()[0][NAME]
    out = tmp_path / "out"
    assert "on a hold-out of known depth" in cli("complete", folder, "--guide", NAME, "--out", out, "--no-cloud").out
    recorded = json.loads((out / "run.json").read_text())["guide"]["network"]
    assert (recorded["name"], recorded["sha256"], recorded["gives"]) == (NAME, pinned(), "affine-inverse")
    assert recorded["licence"] == "CC-BY-NC-4.0"
    assert f"predicted by {NAME}" in cli("info", out / "run.json").out
    assert main(["batch", str(folder.parent), "--guide", NAME, "--out", str(tmp_path / "set")]) == 0
    np.testing.assert_array_equal(np.load(tmp_path / "set" / "box" / "guide_used.npy"), frame.guide.values)
    guide_models.remove_guide(NAME)
    assert main(["batch", str(folder.parent), "--guide", NAME, "--out", str(tmp_path / "none")]) == 1
    assert f"ilf: error: The guide network {NAME} is not on this computer" in capsys.readouterr().err
    assert main(["complete", "--replay", str(out / "run.json"), "--out", str(tmp_path / "again")]) == 0
    again = json.loads((tmp_path / "again" / "run.json").read_text())
    assert again["guide"]["network"] == recorded


def test_an_existing_file_wins_over_a_name(hub, tmp_path, monkeypatch):
    fetch_guide(NAME)
    monkeypatch.chdir(tmp_path)
    assert guide_models.is_guide_name(NAME)
    assert ReadingOptions(guide=NAME).paths == {}
    (tmp_path / NAME).mkdir()
    assert not guide_models.is_guide_name(NAME)
    assert ReadingOptions(guide=NAME).paths == {"guide": NAME}


def test_a_damaged_card_says_what_to_do_and_none_is_written_with_another_kind(hub, tmp_path, cli):
    with pytest.raises(InputError, match="cannot give 'depth'"):
        guide_models.add_guide(tmp_path / "source.onnx", "mine", gives="depth")
    assert "mine" not in guide_cards()[0]
    guides_folder().mkdir(parents=True, exist_ok=True)
    (guides_folder() / "mine.json").write_text('{"name": "mine"}')
    with pytest.raises(FormatError, match=r"mine\.json.* Delete this card, and add or fetch its network again\."):
        ilf.load_guide("mine", rgb=scene()[0])
    (guides_folder() / f"{NAME}.json").write_text("no JSON")  # the pinned hash of a known network
    listed = cli("models", "list")
    assert "correction" in listed.out
    for name in "mine", NAME:
        assert f"The guide network {name} is left out: " in listed.err
        assert f"{name} " not in listed.out
        assert f"{name}.json" in cli("models", "fetch", name, status=1).err
    assert guide_file(NAME) is None


def test_a_file_that_was_changed_is_refused(hub):
    path = fetch_guide(NAME)
    write_network(path, [node("ReduceMax", ["image"], "strength", axes=[1], keepdims=1)])
    with pytest.raises(InputError, match=f"not the file that was fetched or added.*ilf models remove {NAME}"):
        ilf.load_guide(NAME, rgb=scene()[0])


def test_size_aspect_normalisation_and_output_are_those_of_the_card(hub, tmp_path, monkeypatch):
    both = write_network(
        tmp_path / "two.onnx",
        [node("Relu", ["image"], "other"), node("ReduceMean", ["image"], "depth", axes=[1], keepdims=1)],
        outputs={"other": 3, "depth": 1},
    )
    hub.content = both.read_bytes()
    know(monkeypatch, hub, output="depth", mean=(0.0, 0.0, 0.0), deviation=(1 / 255,) * 3, step=32, keep_aspect=False)
    fetch_guide(NAME)
    shapes: list[tuple[int, ...]] = []
    run = Session.run

    def noted(session: Session, inputs: dict[str, np.ndarray], **how: bool) -> list[np.ndarray]:
        shapes.extend(values.shape for values in inputs.values())
        return run(session, inputs, **how)

    monkeypatch.setattr(Session, "run", noted)
    rgb, _ = scene()
    guide = ilf.load_guide(NAME, rgb=rgb)
    np.testing.assert_allclose(guide.values[30:60, 40:80], rgb.mean(axis=2)[30:60, 40:80], atol=8)
    know(monkeypatch, hub, output="depth", step=32)
    ilf.load_guide(NAME, rgb=rgb)
    assert shapes == [(1, 3, 64, 64), (1, 3, 64, 96)]
    know(monkeypatch, hub, output="none")
    with pytest.raises(FormatError, match=r"no output none, only other, depth. Correct its card"):
        ilf.load_guide(NAME, rgb=rgb)


def test_files_are_added_where_there_is_no_network(hub, tmp_path, capsys, cli, monkeypatch):
    copied = tmp_path / "source.onnx"
    assert main(["models", "add", str(copied)]) == 0
    assert guide_file(NAME) is not None  # recognised by its content
    mine = write_network(tmp_path / "mine.onnx", [node("ReduceMax", ["image"], "strength", axes=[1], keepdims=1)])
    assert main(["models", "add", str(mine), "--gives", "metric"]) == 0
    card = guide_cards()[0]["mine"]
    assert (card.gives, card.bytes, card.address) == ("metric", mine.stat().st_size, "")
    assert ilf.load_guide("mine", rgb=scene()[0]).network == card
    capsys.readouterr()
    listed = cli("models", "list").out
    assert [line for line in listed.splitlines() if line.startswith("mine ") and "guide, metric" in line]
    assert "CC-BY-NC-4.0, not for commercial use" in listed
    assert "none was tried" in " ".join(listed.split())
    for command, reason in {
        f"add {mine} --gives metric": "already exists",
        f"add {mine} --name {NAME}": f"is not the file of the guide network {NAME}",
        f"add {mine} --name a/b --gives metric": "cannot be the name",
        f"add {mine} --name edges --gives metric": "already exists",
        "fetch mine": "has no address",
        "fetch nothing": "There is no guide network 'nothing'",
    }.items():
        if "fetch mine" in command:
            (guides_folder() / "mine.onnx").unlink()
        assert main(["models", *command.split()]) == 1, command
        assert reason in capsys.readouterr().err, command
    assert main(["models", "add", str(mine), "--gives", "metric"]) == 0
    assert main(["models", "add", str(mine), "--gives", "affine", "--replace"]) == 0
    assert guide_cards()[0]["mine"].gives == "affine"
    assert main(["models", "remove", "mine"]) == 0
    assert "mine" not in guide_cards()[0]
    assert main(["models", "add", str(mine), "--gives", "metric", "--logits"]) == 2


def test_a_file_added_as_an_edge_network_says_what_is_assumed(tmp_path, cli, monkeypatch):
    monkeypatch.setenv("ILF_MODELS", str(tmp_path / "models"))
    mine = write_network(tmp_path / "mine.onnx", [node("ReduceMax", ["image"], "strength", axes=[1], keepdims=1)])
    told = cli("models", "add", mine).out
    assert "taken as a network for edges whose input is RGB in 0 to 1" in told
    assert "ilf models remove mine" in told
    assert "--gives relative-inverse|" in told
    assert "taken as" not in cli("models", "add", mine, "--input", "rgb", "--replace").out


def test_the_known_cards_are_complete():
    for card in guide_models._known().values():
        assert card.address.startswith("https://")
        assert card.maker
        assert card.licence
        assert card.bytes > 1e6
        assert card.size is not None
        assert card.size % card.step == 0
    assert "not for commercial use" in guide_models.licence_text(guide_cards()[0]["depth-anything-v2-base"])
