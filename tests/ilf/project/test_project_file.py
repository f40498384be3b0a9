"""Project files: saved, opened, moved, damaged."""

import gc
import json
import os
import shutil
import stat
import zipfile
from dataclasses import replace

import pytest

import ilf
from ilf.errors import Cancelled, ExportError, FormatError, InputError
from ilf.io.cameras import intrinsics_from
from ilf.project.archive import Archive
from ilf.project.file import open_project, save_project
from ilf.project.project import FrameSummary, Project, ProjectFrame, Stage
from ilf.project.sources import MissingSource, source_part
from ilf.project.state_codec import UnreadableFrame, frame_part
from ilf.sources.frame_ref import FrameRef, ReadingOptions

from ..project_states import assert_same, made_frame, rich_state, small_frame
from ..small_frames import write_small_frame


def listed(state, source=None):
    """The frame of a state as a project lists it."""
    return ProjectFrame(
        state.id, state.frame.name, source, FrameSummary(Stage.RUN, "hm", (60, 80), 0.25, 3, 2, 1), True
    )


def made_work(folder):
    """Write a project of three frames: one from files, one that a program made, one that is untouched."""
    filed = rich_state(small_frame(folder / "frames" / "one"), "a1")
    made = rich_state(made_frame(), "b2")
    rgb, depth = map(str, write_small_frame(folder / "frames" / "two"))
    options = ReadingOptions(depth_units=1000.0, intrinsics=intrinsics_from("80,80,39.5,29.5"))
    project = Project(
        (
            listed(filed, FrameRef(filed.frame.inputs.rgb.path, filed.frame.inputs.depth.path)),
            listed(made),
            ProjectFrame("c3", "two", FrameRef(rgb, depth, options=options)),
        ),
        "b2",
        ilf.preset("paper"),
        True,
        ilf.BlockParameters(granularity=0.3),
        False,
        {"panels": ["curves"], "zoom": 2.5},
    )
    notes = save_project(folder / "room.ilf", project, [filed, made])
    assert notes == ()
    return project, filed, made


@pytest.fixture(scope="module")
def kept_work(tmp_path_factory):
    """A folder with such a project, moved since, so that its copies find their own files only."""
    folder = tmp_path_factory.mktemp("project")
    made_work(folder / "made")
    return (folder / "made").rename(folder / "kept")


@pytest.fixture
def work(kept_work, tmp_path):
    """A copy of the folder, saved anew, which may be changed, and what is in it."""
    folder = tmp_path / "work"
    shutil.copytree(kept_work, folder)
    with open_project(folder / "room.ilf") as opened:
        project, filed, made = opened.project, opened.state("a1").state, opened.state("b2").state
    save_project(folder / "room.ilf", project, [filed, made])
    return folder, project, filed, made


def test_a_project_comes_back_as_it_was(tmp_path):
    project, filed, made = made_work(tmp_path)
    with open_project(tmp_path / "room.ilf") as opened:
        assert opened.problems == ()
        assert opened.project == project
        for wanted in (filed, made):
            found = opened.state(wanted.id)
            assert found.problems == ()
            assert_same(wanted, found.state)
        assert not opened.state("c3").state.blocks.labels.any()
        with pytest.raises(InputError, match="no frame"):
            opened.state("d4")


def test_saving_after_one_edit_takes_the_rest_as_it_is_and_leaves_out_what_nobody_needs(work):
    folder, project, filed, made = work
    path = folder / "room.ilf"
    changed = replace(made, results={}, runs=(), extrapolation=None, note="new")
    with open_project(path) as opened:
        before = {name: opened.parts.read(name) for name in opened.parts.names()}
        save_project(path, project, [changed], base=[opened.parts], places=opened.places)
        after = {name: opened.parts.read(name) for name in opened.parts.names()}
        assert_same(changed, opened.state("b2").state)
        assert_same(filed, opened.state("a1").state)
    assert all(before[name] == content for name, content in after.items() if name in before and "b2" not in name)
    assert {name for name in before if name not in after}, "results of the frame that has none any more"
    without = replace(project, frames=project.frames[1:])
    with open_project(path) as opened:
        save_project(folder / "less.ilf", without, base=[opened.parts], places=opened.places)
    with open_project(folder / "less.ilf") as less:
        assert frame_part("a1") not in less.parts.names()
        assert_same(changed, less.state("b2").state)


def test_it_moves_with_its_frames_and_can_be_saved_elsewhere(work, tmp_path):
    folder, _, filed, _ = work
    moved = tmp_path / "far" / "away"
    shutil.move(folder, moved)
    with open_project(moved / "room.ilf") as opened:
        assert opened.project.frames[2].source.rgb == str(moved / "frames" / "two" / "rgb.png")
        state = opened.state("a1").state
        assert state.frame.inputs.rgb.path == str(moved / "frames" / "one" / "rgb.png")
        assert_same(filed.blocks.labels, state.blocks.labels)
        assert state.runs[0].run.frame.ground_truth is not None
        (tmp_path / "copies").mkdir()
        save_project(tmp_path / "copies" / "room.ilf", opened.project, base=[opened.parts], places=opened.places)
    shutil.move(tmp_path / "far", tmp_path / "near")
    shutil.move(tmp_path / "copies", tmp_path / "near" / "copies")
    with open_project(tmp_path / "near" / "copies" / "room.ilf") as opened:
        with pytest.raises(MissingSource):
            opened.state("a1")
        places = replace(opened.places, folders=(tmp_path / "near" / "away" / "frames",))
        assert opened.state("a1", places).problems == ()


def test_missing_and_changed_files_are_told_apart_and_can_be_given(work, tmp_path):
    folder, project, filed, _ = work
    source, elsewhere = folder / "frames" / "one" / "depth.png", tmp_path / "elsewhere.png"
    shutil.copy(source, elsewhere)
    with open_project(folder / "room.ilf") as opened:
        source.write_bytes((folder / "frames" / "one" / "rgb.png").read_bytes())
        with pytest.raises(MissingSource) as changed:
            opened.state("a1")
        source.unlink()
        with pytest.raises(MissingSource) as missing:
            opened.state("a1")
        assert changed.value.wanted == missing.value.wanted == filed.frame.inputs.depth
        assert (changed.value.found, missing.value.found) == (source, None)
        places = replace(opened.places, given={missing.value.wanted.sha256: elsewhere})
        found = opened.state("a1", places)
        assert found.problems == ()
        assert found.state.frame.inputs.depth.path == str(elsewhere)
        ground_truth = folder / "frames" / "one" / "truth.npy"
        ground_truth.rename(tmp_path / "truth.npy")
        found = opened.state("a1", places)
        assert found.state.frame.ground_truth is None
        assert "ground truth is not available" in found.problems[0]
        save_project(folder / "room.ilf", project, [found.state], base=[opened.parts], places=places)
        (tmp_path / "truth.npy").rename(ground_truth)
        assert_same(filed.frame.ground_truth, opened.state("a1").state.frame.ground_truth)


def test_embedded_files_need_nothing_else(work, tmp_path):
    folder, project, filed, _ = work
    with open_project(folder / "room.ilf") as opened:
        save_project(tmp_path / "all.ilf", project, base=[opened.parts], places=opened.places, embed=True)
    shutil.rmtree(folder)
    with open_project(tmp_path / "all.ilf") as opened:
        assert opened.embedded
        assert_same(filed, opened.state("a1").state)
        assert opened.state("c3").state.frame.shape == (60, 80)
        save_project(tmp_path / "all.ilf", opened.project, base=[opened.parts], places=opened.places, embed=False)
        assert_same(filed, opened.state("a1").state)  # what is nowhere else stays in


def test_an_embedded_file_that_is_damaged_is_read_from_where_it_was(work):
    folder, project, filed, _ = work
    path = folder / "room.ilf"
    with open_project(path) as opened:
        save_project(path, project, base=[opened.parts], places=opened.places, embed=True)
    with Archive(path) as archive:
        place = path.read_bytes().index(archive.read(source_part(filed.frame.inputs.rgb.sha256, "rgb.png")))
    content = bytearray(path.read_bytes())
    content[place + 40] ^= 1
    path.write_bytes(content)
    with open_project(path) as opened:
        assert_same(filed, opened.state("a1").state)
        (folder / "frames" / "one" / "rgb.png").unlink()
        with pytest.raises(MissingSource, match=r"rgb\.png no longer exists"):
            opened.state("a1")


def test_what_is_on_disk_stays_whole_when_saving_fails(work, monkeypatch):
    folder, project, _, _ = work
    path = folder / "room.ilf"
    path.chmod(0o640)
    link = folder / "link.ilf"
    link.symlink_to("room.ilf")
    before = path.read_bytes()

    def stop(done, total):
        if done == total - 1:
            raise Cancelled("stopped")

    with open_project(path) as opened:
        with pytest.raises(Cancelled):
            save_project(path, project, base=[opened.parts], on_part=stop)
        with monkeypatch.context() as patched:
            patched.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space")))
            with pytest.raises(ExportError, match="disk is full"):
                save_project(path, project, base=[opened.parts])
        assert path.read_bytes() == before
        assert opened.state("b2").problems == ()
        save_project(link, replace(project, present="a1"), base=[opened.parts], places=opened.places)
        assert not opened.parts.replaced(), "it has been read anew"
    assert link.is_symlink()
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert sorted(item.name for item in folder.iterdir()) == ["frames", "link.ilf", "room.ilf"]
    with open_project(path) as opened:
        assert opened.project.present == "a1"


def rewritten(path, change):
    """Write a zip again with the parts that `change` makes of its parts."""
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in change(parts).items():
            archive.writestr(name, content)


def contents(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist() if name != "project.json"}


def changed_state(change):
    """A change of the JSON of the frame "a1", for `rewritten`."""

    def changed(parts):
        data = json.loads(parts[frame_part("a1")])
        change(data["state"])
        return parts | {frame_part("a1"): json.dumps(data).encode()}

    return changed


def damaged_array(what):
    """A change that damages an array of the frame "a1", for `rewritten`."""

    def changed(parts):
        data = json.loads(parts[frame_part("a1")])
        name = data["parts"][what(data["state"])]
        return parts | {name: parts[name][:-9] + b"123456789"}

    return changed


def label_map_of(parts):
    data = json.loads(parts[frame_part("a1")])
    return data["parts"][data["state"]["blocks"]["labels"]]


@pytest.mark.parametrize(
    "damage",
    [
        damaged_array(lambda state: state["blocks"]["labels"]),
        damaged_array(lambda state: state["results"]["1"][0]),
        damaged_array(lambda state: state["frame"]["invalid_mask"]),
        changed_state(lambda state: state.pop("looked")),
        changed_state(lambda state: state["blocks"].pop("reasons")),
        changed_state(lambda state: state["blocks"].update(extracted=state["frame"]["guide"]["values"])),
        changed_state(lambda state: state.update(done="yes")),
        changed_state(lambda state: state.update(unheard_of=1)),
        changed_state(lambda state: state["blocks"]["own"].update({"2": {"smoothness": -1}})),
        changed_state(lambda state: state["results"]["1"].__setitem__(1, 99)),
        changed_state(lambda state: state["results"].update({"2": state["results"]["1"]})),
        lambda parts: parts | {frame_part("a1"): parts[frame_part("a1")][:-9]},
        lambda parts: with_schema(frame_part("a1"), 1)(parts),
        lambda parts: {name: parts[name] for name in parts if name != label_map_of(parts)},
    ],
)
def test_a_frame_that_cannot_be_read_is_left_aside_and_saved_as_it_is(work, damage):
    folder, project, _, _ = work
    path, elsewhere = folder / "room.ilf", folder / "elsewhere.ilf"
    rewritten(path, damage)
    before = contents(path)
    with open_project(path) as opened:
        assert opened.problems == ()
        assert opened.project.frames == project.frames
        with pytest.raises(UnreadableFrame, match="cannot be read: "):
            opened.state("a1")
        assert opened.state("c3").state.frame.name == "two"
        save_project(elsewhere, opened.project, base=[opened.parts], places=opened.places)
    assert contents(elsewhere) == before


def test_a_damaged_list_is_made_of_the_frames_that_are_there(work):
    folder, _, filed, _ = work
    path = folder / "room.ilf"
    rewritten(path, lambda parts: parts | {"project.json": parts["project.json"][:200]})
    with open_project(path) as opened:
        assert "list of frames and the common settings are lost" in opened.problems[0]
        assert not opened.embedded, "a project embeds no files unless it is asked to"
        assert [frame.name for frame in opened.project.frames] == [filed.frame.name, "made"]
        assert_same(filed.blocks.labels, opened.state("a1").state.blocks.labels)


def test_a_frame_with_a_wrong_checksum_keeps_it(work):
    folder, project, _, _ = work
    path = folder / "room.ilf"
    with Archive(path) as archive:
        place = path.read_bytes().index(archive.read(frame_part("a1")))
    content = bytearray(path.read_bytes())
    content[place + 3] ^= 1
    path.write_bytes(content)
    with open_project(path) as opened:
        with pytest.raises(UnreadableFrame):
            opened.state("a1")
        save_project(path, project, base=[opened.parts], places=opened.places)
        assert opened.parts.read_raw(frame_part("a1")).checksum is not None, "it is not taken for a whole one"
        assert opened.state("b2").problems == ()


def test_a_save_from_a_closed_file_fails_and_changes_nothing(work):
    folder, project, _, _ = work
    path = folder / "room.ilf"
    before = path.read_bytes()
    with open_project(path) as opened:
        pass
    with pytest.raises(InputError, match="cannot be read"):
        save_project(path, project, base=[opened.parts], places=opened.places)
    assert path.read_bytes() == before


def test_a_part_with_a_damaged_name_in_its_header_is_read_and_saved(work):
    folder, project, filed, _ = work
    path = folder / "room.ilf"
    before = contents(path)
    content = bytearray(path.read_bytes())
    content[content.index(frame_part("a1").encode())] ^= 1
    path.write_bytes(content)
    with open_project(path) as opened:
        assert_same(filed, opened.state("a1").state)
        assert save_project(path, project, base=[opened.parts], places=opened.places) == ()
    assert contents(path) == before


def test_members_are_found_without_the_directory(work):
    folder, project, _, made = work
    path = folder / "room.ilf"
    path.write_bytes(path.read_bytes()[:-60])
    with open_project(path) as opened:
        assert "truncated" in opened.problems[0]
        assert opened.project == project
        assert_same(made, opened.state("b2").state)


def with_schema(part, schema):
    """A change of parts, for `rewritten`."""

    def change(parts):
        return parts | {part: json.dumps(json.loads(parts[part]) | {"schema": schema}).encode()}

    return change


@pytest.mark.parametrize("schema", [0, 1, None])
def test_another_schema_is_neither_opened_nor_replaced(work, schema):
    folder, project, _, _ = work
    path = folder / "room.ilf"
    rewritten(path, with_schema("project.json", schema))
    content = path.read_bytes()
    with pytest.raises(FormatError, match=r"room\.ilf has schema .* reads schema 2 only\. Open it with the version"):
        open_project(path)
    with pytest.raises(ExportError, match=r"is not replaced\. The project has schema"):
        save_project(path, project)
    assert path.read_bytes() == content


def test_what_is_no_project_is_refused(tmp_path):
    for content in (b"", b"PK\3\4", b"hello" * 100):
        (tmp_path / "no.ilf").write_bytes(content)
        with pytest.raises(FormatError):
            open_project(tmp_path / "no.ilf")
    with pytest.raises(InputError, match="no such file"):
        open_project(tmp_path / "none.ilf")
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as archive:
        archive.writestr("../../evil.txt", b"x")
    with pytest.raises(FormatError, match="not a project file"):
        open_project(tmp_path / "other.zip")


def test_what_claims_to_be_huge_is_not_unpacked(work, monkeypatch):
    """A member that says it has gigabytes."""
    folder, _, filed, _ = work
    path = folder / "room.ilf"
    rewritten(path, lambda parts: parts | {"arrays/bomb.zip": bytes(10**6)})
    monkeypatch.setattr("ilf.project.archive.MAX_INFLATED", 10**6 - 1)
    with open_project(path) as opened:
        with pytest.raises(FormatError, match="compression"):
            opened.parts.read("arrays/bomb.zip")
        assert_same(filed, opened.state("a1").state)


def test_a_project_that_nobody_takes_is_closed(tmp_path):
    save_project(tmp_path / "empty.ilf", Project(()), [])
    open_project(tmp_path / "empty.ilf")
    gc.collect()  # a file that was not closed would be told as a warning, which fails
