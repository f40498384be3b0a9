"""Files of strangers: what they name is neither asked for on the network nor read elsewhere, unless it is allowed."""

import hashlib
import json
import os
import shutil
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.data.frame import InputFile
from ilf.errors import InputError, without_credentials
from ilf.io.frame_additions import with_ground_truth_file
from ilf.project.file import save_project
from ilf.project.frame_state import FrameState
from ilf.project.project import FrameSummary, Project, ProjectFrame, Stage
from ilf.project.project_json import encode_project
from ilf.project.recovery import find_recoverable_work
from ilf.project.store import WorkFolder
from ilf.sources.frame_ref import FrameRef, ReadingOptions
from ilf.sources.named_places import NotAllowed, named_in, note_opened
from ilf.sources.reading import read_frame

from ..web_server import serving_folder
from .batch_frames import work_in_this_process, write_frames

fsspec = pytest.importorskip("fsspec")
pytest.importorskip("aiohttp", reason="aiohttp is not installed (extra dev)")

QUICK = ["--quiet", "--max-iterations", "3", "--no-correction", "--blocks-detector", "canny"]


@pytest.fixture(autouse=True)
def nothing_opened_before(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """The address of a folder with a frame on a web server, and the paths that were asked for."""
    root = tmp_path_factory.mktemp("web")
    write_frames(root / "in", 1)
    with serving_folder(root) as (address, asked):
        yield f"{address}/in", asked


@pytest.fixture
def web(server):
    server[1].clear()
    return server


def edited(path, change):
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))


def project(folder, source):
    save_project(folder / "stranger.ilf", Project((ProjectFrame("a1", "desk", source),)))
    return folder / "stranger.ilf"


def project_with_work(folder, frame, place):
    """A project whose stored frame names a place."""
    assert frame.inputs is not None
    inputs = replace(frame.inputs, **{kind: InputFile(f"{place}/{kind}/0000.png", "0") for kind in ("rgb", "depth")})
    state = FrameState("a1", replace(frame, inputs=inputs), ilf.Blocks(np.ones(frame.shape, np.int32)))
    path, listed = folder / "stranger.ilf", ProjectFrame("a1", "desk", None, FrameSummary(Stage.RUN), True)
    save_project(path, Project((listed,)), [state])
    return path


def run_record(folder, frame):
    ilf.complete(frame, max_iterations=3, correction=False, detector="canny").save(folder / "run")
    return folder / "run" / "run.json"


# A door makes a file that names a place, opens it by the command line, and returns the exit status.


def export(path):
    return main(["project", "export", str(path), "--complete", "--out", str(path.parent / "out")])


def by_project(folder, frame, place):
    return export(project(folder, FrameRef(f"{place}/rgb/0000.png", f"{place}/depth/0000.png")))


def by_option(name, folder, frame, place):
    assert frame.inputs is not None
    options = ReadingOptions(**{name: f"{place}/{name}.npy"})
    source = FrameRef(frame.inputs.rgb.path, frame.inputs.depth.path, options=options)
    return export(project(folder, source))


def by_stored_frame(folder, frame, place):
    return main(["report", str(project_with_work(folder, frame, place)), "--out", str(folder / "out.html")])


def by_record(command, key, folder, frame, place):
    path = run_record(folder, frame)
    named = {"path": f"{place}/truth.npy", "sha256": "0", "units": 1.0}
    edited(path, lambda data: data["inputs"].update({key: named}))
    again = ["report", str(path), "--out", str(folder / "out.html")]
    return main(again if command == "report" else ["complete", "--replay", str(path), "--out", str(folder / "out")])


def by_neighbour(folder, frame, place):
    path = run_record(folder, frame)
    source = {"rgb": f"{place}/rgb/0000.png", "depth": f"{place}/depth/0000.png", "frame": None}
    neighbour = {"name": "next", "motion": np.eye(4).tolist(), "sha256": ["0", "0"], "source": source}
    edited(path, lambda data: data.update(neighbours=[neighbour]))
    return main(["complete", "--replay", str(path), "--out", str(folder / "out")])


def by_recording_of_a_result(folder, frame, place):
    path = run_record(folder, frame)
    edited(path, lambda data: data["inputs"].update(frame="1", rgb={"path": f"{place}/a.bag", "sha256": "0"}))
    return main(["stream", str(path.parent), "--results", "--out", str(folder / "out.mcap")])


def by_meta(key, folder, frame, place):
    assert frame.inputs is not None
    for name, file in (("rgb.png", frame.inputs.rgb), ("depth.png", frame.inputs.depth)):
        shutil.copy(file.path, folder / name)
    (folder / "meta.json").write_text(json.dumps({"depth_units_per_m": 1000, key: f"{place}/{key}.npy"}))
    return main(["complete", str(folder), "--out", str(folder / "out"), *QUICK])


def by_list(folder, frame, place):
    (folder / "associations.txt").write_text(f"0 {place}/rgb/0000.png 0 {place}/depth/0000.png")
    return main(["complete", str(folder), "--frame", "0000", "--out", str(folder / "out"), *QUICK])


def by_transforms(folder, frame, place):
    listed = {"file_path": f"{place}/rgb/0000.png", "depth_file_path": f"{place}/depth/0000.png"}
    data = {"frames": [{**listed, "transform_matrix": np.eye(4).tolist()}], "fl_x": 30.0, "w": 32, "h": 24}
    (folder / "transforms.json").write_text(json.dumps(data))
    return main(["complete", str(folder), "--frame", "0000", "--out", str(folder / "out"), *QUICK])


def by_layout(folder, frame, place):
    write_frames(folder, 1)
    (folder / "layout.toml").write_text(f'rgb = "rgb/*.png"\ndepth = "depth/*.png"\nK = "{place}/K.txt"\n')
    return main(["info", str(folder), "--layout", str(folder / "layout.toml")])


def by_shards(folder, frame, place):
    parquet = pytest.importorskip("pyarrow.parquet")
    pyarrow = pytest.importorskip("pyarrow")
    shards = folder / "shards"
    assert main(["batch", str(write_frames(folder / "in", 1)), "--shards", str(shards), *QUICK]) == 0
    (table,) = shards.glob("*.parquet")
    found = parquet.read_table(table)
    at = found.schema.get_field_index("rgb")
    named = pyarrow.array([f"{place}/rgb/0000.png"], found.schema.field("rgb").type)
    parquet.write_table(found.set_column(at, found.schema.field("rgb"), named), table)
    return main(["complete", str(shards), "--frame", "0000", "--out", str(folder / "out"), *QUICK])


def by_frozen_list(folder, frame, place):
    pytest.importorskip("pyarrow")
    shards = folder / "shards"
    command = ["batch", str(write_frames(folder / "in", 1)), "--shards", str(shards), *QUICK]
    assert main(command) == 0
    (table,) = shards.glob("*.parquet")
    table.unlink()
    lines = shards / "frames.jsonl"
    text = lines.read_text().replace(str(folder / "in"), place)
    edited(shards / "shards.json", lambda data: data.update(list_bytes=len(text.encode())))
    lines.write_text(text)
    return main(command)


DOORS = {
    "project": by_project,
    "project: guide": partial(by_option, "guide"),
    "project: ground truth": partial(by_option, "ground_truth"),
    "project: intrinsics": partial(by_option, "intrinsics"),
    "project: report": by_stored_frame,
    "record: replay": partial(by_record, "replay", "rgb"),
    "record: report": partial(by_record, "report", "depth"),
    "record: ground truth": partial(by_record, "replay", "ground_truth"),
    "record: neighbour": by_neighbour,
    "record: recording": by_recording_of_a_result,
    "meta.json: colour": partial(by_meta, "rgb"),
    "meta.json: ground truth": partial(by_meta, "gt"),
    "meta.json: guide": partial(by_meta, "guide"),
    "list of frames": by_list,
    "transforms.json": by_transforms,
    "shards": by_shards,
    "frozen list": by_frozen_list,
}


@pytest.fixture
def frame(tmp_path):
    """The frame in the stranger's folder."""
    root = write_frames(tmp_path / "stranger" / "own", 1)
    return ilf.load_frame(root / "rgb/0000.png", root / "depth/0000.png", intrinsics="30,30,16,12")


@pytest.fixture
def stranger(tmp_path, frame, monkeypatch):
    """The folder of a stranger's files, in which nothing was opened before."""
    work_in_this_process(monkeypatch)
    return tmp_path / "stranger"


LISTS = {"list of frames", "transforms.json"}
"""Their paths are below the folder of the list: what looks like an address is none."""


@pytest.mark.parametrize("door", DOORS)
def test_an_address_in_a_file_is_not_asked_for(door, stranger, frame, web, capsys):
    address, asked = web
    assert DOORS[door](stranger, frame, address) == 1
    shown = capsys.readouterr()
    shown = shown.err + shown.out
    assert not asked
    assert door in LISTS or (address in shown and "--allow-address http://127.0.0.1" in shown), shown


@pytest.mark.parametrize("door", [*DOORS, "layout"])
def test_a_path_that_leads_elsewhere_is_not_read(door, tmp_path, stranger, frame, capsys):
    elsewhere = write_frames(tmp_path / "elsewhere", 2)
    for kind in ("rgb", "depth"):  # other content than the files of the same names
        (elsewhere / kind / "0001.png").rename(elsewhere / kind / "0000.png")
    for name in ("guide.npy", "ground_truth.npy", "gt.npy", "truth.npy", "rgb.npy", "intrinsics.npy", "a.bag", "K.txt"):
        (elsewhere / name).write_bytes(b"0")
    assert {**DOORS, "layout": by_layout}[door](stranger, frame, str(elsewhere)) == 1
    shown = capsys.readouterr()
    shown = shown.err + shown.out
    assert str(elsewhere) in shown
    assert "--allow-address" in shown


def test_links_and_ways_up_lead_out_of_a_folder_and_plain_names_do_not(tmp_path, stranger):
    secret = tmp_path / "secret.npy"
    np.save(secret, np.ones((24, 32)))
    (stranger / "link.npy").symlink_to(secret)
    for name in ("link.npy", "../secret.npy", "own/../../secret.npy", str(secret)):
        with pytest.raises(NotAllowed, match=r"secret\.npy|link\.npy"):
            named_in(name, stranger)
    assert named_in("own/rgb/0000.png", stranger) == str(stranger / "own/rgb/0000.png")


FORMS = [
    *("http://{}", "HTTP://{}", "Http://me:pw@{}", " http://{}", "\thttp://{}", "http://{}/%2e%2e/x"),
    *("reference://x::http://{}", "zip::http://{}", "simplecache::http://{}", "zip://a.png::simplecache::http://{}"),
    *("ftp://{}", "ssh://{}", "sftp://{}", "github://a:b@{}", "file://{}/x", "file:///etc/passwd", "data://{}"),
    *("//{}/share/x.png", "\\\\{}\\share\\x.png", "//?/UNC/{}/share", "s3://{}", "http://[::1", "http://{}:no/x"),
]


@pytest.mark.parametrize("form", FORMS)
def test_no_form_of_an_address_passes(form, stranger, web, capsys):
    address, asked = web
    place = form.format(address.removeprefix("http://"))
    for base in (stranger, "", None, "https://elsewhere/in"):
        with pytest.raises(InputError):
            named_in(place, base)
    assert export(project(stranger, FrameRef(place, place))) == 1
    assert not asked
    assert "Traceback" not in capsys.readouterr().err


TYPED = [
    "reference://x::{}",
    "zip::{}",
    "simplecache::{}",
    "http://[::1",
    "ftp://{}",
    "what://x",
    " {}",
    "http://a:b/c",
]


@pytest.mark.parametrize("form", TYPED)
def test_typed_chains_other_protocols_and_malformed_addresses_are_one_sentence(form, tmp_path, web, cli):
    address = form.format(web[0])
    out = ["--out", str(tmp_path / "out")]
    for command in (["info", address], ["complete", address, address, *out], ["batch", address, *out]):
        shown = cli(*command, status=1).err
        assert shown.startswith("ilf: error: ")
        assert shown.count("\n") == 1
        assert address.strip() in shown
    assert not web[1]


def test_a_project_is_listed_without_asking_and_opened_when_it_is_allowed(stranger, web, cli):
    address, asked = web
    path = project(stranger, FrameRef(f"{address}/rgb/0000.png", f"{address}/depth/0000.png"))
    assert "--allow-address" in cli("project", "info", path).out
    opening = ["project", "export", str(path), "--complete", "--out", str(stranger / "out")]
    assert main(opening) == 1
    assert main([*opening, "--allow-address", "https://127.0.0.1", "--allow-address", f"{address[:-1]}"]) == 1
    assert not asked
    assert main([*opening, "--allow-address", address]) == 0
    assert asked
    allowed = ilf.sources.allow_address
    with allowed("https://one.example/in"), allowed("/elsewhere"):
        named_in("https://one.example/in/rgb.png", stranger)


def test_a_strangers_autosave_does_not_call_home_and_ones_own_opens(tmp_path, frame, web, monkeypatch):
    address, asked = web
    source = FrameRef(f"{address}/rgb/0000.png", f"{address}/depth/0000.png")
    work = WorkFolder(tmp_path / "autosave" / "left.work")
    work.commit({"project.json": encode_project(Project((ProjectFrame("a1", "desk", source),)))})
    work.close()
    (left,) = find_recoverable_work(tmp_path / "autosave")
    (found,) = left.frames or left.read.project.frames
    with pytest.raises(NotAllowed):
        read_frame(found.source)
    assert not asked
    read_frame(source)  # by the user
    assert read_frame(found.source).shape == (24, 32)
    left.release()


def test_what_the_user_has_opened_is_his_wherever_it_lies(tmp_path, monkeypatch, cli):
    frames, project_file = write_frames(tmp_path / "data" / "in", 2), tmp_path / "work" / "mine.ilf"
    project_file.parent.mkdir()
    assert main(["project", "new", str(project_file), str(frames)]) == 0
    again = ["project", "export", str(project_file), "--complete", "--out", str(tmp_path / "out")]
    assert main(again) == 0
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "elsewhere"))  # somebody else
    assert str(frames) in cli(*again, status=1).err
    shutil.move(project_file, frames.parent / "mine.ilf")
    assert export(frames.parent / "mine.ilf") == 0


def test_a_file_with_its_hash_is_read_and_no_other(tmp_path, frame, monkeypatch):
    truth = tmp_path / "elsewhere" / "truth.npy"
    truth.parent.mkdir()
    np.save(truth, frame.depth)
    path = run_record(tmp_path, with_ground_truth_file(frame, truth))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "another"))
    assert ilf.replay(path).run.frame.ground_truth is not None
    np.save(truth, frame.depth + 1)
    with pytest.raises(NotAllowed):
        ilf.replay(path)


def test_a_list_at_an_address_leads_to_no_other_store(tmp_path):
    store = fsspec.filesystem("memory")
    store.store.clear()
    for name in ("owned", "others"):
        store.put(str(write_frames(tmp_path / name, 1)), f"/{name}/in", recursive=True)
    up = "../../others/in"
    store.pipe("/owned/in/associations.txt", f"0 {up}/rgb/0000.png 0 {up}/depth/0000.png".encode())
    with pytest.raises(NotAllowed, match="memory://others"):
        ilf.open_source("memory://owned/in")[0]


def test_places_are_compared_by_their_parts():
    note_opened("https://host/data/in")
    note_opened("s3://bucket/a/rgb.png", beside=True)
    for place in ("https://host/data/in/rgb/0.png", "HTTPS://HOST/data/in", "s3://bucket/a/depth.png"):
        assert named_in(place, None).lower() == place.lower()
    for place in ("https://host.evil/data/in", "https://host/data/in2", "https://host/data/in/../x", "s3://bucket/b/c"):
        with pytest.raises(NotAllowed):
            named_in(place, None)
    assert named_in("hf://datasets/a/b/x", "hf://datasets/a/b@main/y".replace("@main", ""))
    with pytest.raises(NotAllowed):
        named_in("hf://datasets/a/other/x", "hf://datasets/a/b/y")
    with pytest.raises(NotAllowed):
        named_in("hf://datasets/a/b/../%2e%2e/me/private/x", "hf://datasets/a/b/y")
    assert os.environ.get("ILF_ALLOW_ADDRESS") is None


def by_hash(stranger, own):
    sha256 = hashlib.sha256((own / "rgb/0000.png").read_bytes()).hexdigest()
    (stranger / "run.json").write_text(json.dumps({"inputs": {"rgb": {"sha256": sha256}}}))
    meta = {"rgb": str(own / "rgb/0000.png"), "run": "run.json", "depth": "depth.png", "depth_units_per_m": 1000}
    (stranger / "meta.json").write_text(json.dumps(meta))
    shutil.copy(own / "depth/0000.png", stranger / "depth.png")


def by_links(stranger, own):
    for kind in ("rgb", "depth"):
        (stranger / f"{kind}.png").symlink_to(own / kind / "0000.png")


@pytest.mark.parametrize("made", [by_hash, by_links])
def test_what_a_stranger_knows_opens_no_other_file_beside_it(made, tmp_path):
    own, stranger = write_frames(tmp_path / "own", 1), tmp_path / "stranger"
    stranger.mkdir()
    made(stranger, own)
    ilf.load_frame(stranger)
    with pytest.raises(NotAllowed):
        named_in(str(own / "rgb/secret.png"), stranger)


def test_a_server_does_not_learn_whether_a_file_exists(tmp_path):
    path = tmp_path / "a.png"
    path.write_bytes(b"known")
    sha256 = hashlib.sha256(b"known").hexdigest()
    assert named_in(str(path), tmp_path / "other", sha256) == str(path)
    with pytest.raises(NotAllowed):
        named_in(str(path), "https://host/in", sha256)


@pytest.mark.skipif(os.name == "nt", reason="no such names there")
@pytest.mark.parametrize("end", ["\n", "\x0b", "\u2028"])
def test_the_name_of_a_folder_allows_nothing_else(end, tmp_path):
    folder = tmp_path / f"in{end}" / "etc"
    folder.mkdir(parents=True)
    note_opened(folder)
    with pytest.raises(NotAllowed):
        named_in("/etc/passwd", tmp_path)
    assert end == "\n" or named_in(str(folder), None)


def test_what_is_opened_holds_for_the_process_where_no_list_can_be_written(tmp_path):
    (tmp_path / "state").write_text("no folder")
    (tmp_path / "in").mkdir()
    with pytest.raises(NotAllowed):
        named_in(str(tmp_path / "in"), None)
    note_opened(tmp_path / "in")
    assert named_in(str(tmp_path / "in"), None)


SECRETS = [
    *("https://me:{}@host/a", "HTTPS://me:{}@host/a", "https:/me:{}@host/a", "/home/https:/me:{}@host/a.png"),
    *("https://{}:x@host/a", "https://me:x@{}@host/a", "zip://a::https://me:{}@host/a", "//me:{}@host/share"),
    *("https://host/a?token={}", "https://host/a#{}", "s3://bucket/a?X-Amz-Signature={}"),
    *("GET /a?X-Amz-Signature={}&b=1", "access_token={}", "https:/host/a?sig={}", "https%3A%2F%2Fme%3A{}%40host"),
]


@pytest.mark.parametrize("form", SECRETS)
def test_passwords_are_hidden_in_every_form(form, tmp_path, capsys):
    secret = "wJalr/UtnFEMI+K7"
    text = form.format(secret)
    assert secret not in without_credentials(f"403 for {text}, no")
    assert secret not in str(InputError(f"{text}: no"))
    for command in (["info", text], ["complete", "--replay", text], ["project", "info", text], ["report", text]):
        assert main(command) != 0
        shown = capsys.readouterr()
        assert secret not in shown.err + shown.out
