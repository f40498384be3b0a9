"""Project files with anything wrong in them: read as far as they can be, with sentences, never with a traceback."""

import io
import json
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ilf.errors import IlfError
from ilf.project.file import open_project, save_project
from ilf.project.frame_state import FrameState
from ilf.project.project import Project, ProjectFrame

from ..project_states import made_frame, rich_state, small_frame

QUICKLY = settings(max_examples=15, deadline=None)


class Saved:
    """The bytes of a project file, and where others may be put."""

    def __init__(self, content, path):
        self.content, self.path = content, path

    def parts(self):
        with zipfile.ZipFile(io.BytesIO(self.content)) as archive:
            return {name: archive.read(name) for name in archive.namelist()}


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """A project with a frame from files and one that a program has made."""
    folder = tmp_path_factory.mktemp("fuzz")
    states = [rich_state(small_frame(folder), "a1"), rich_state(made_frame(), "b2")]
    frames = tuple(ProjectFrame(state.id, state.frame.name, None, has_state=True) for state in states)
    save_project(folder / "room.ilf", Project(frames), states)
    return Saved((folder / "room.ilf").read_bytes(), folder / "spoiled.ilf")


def read_all(content, path):
    """Open all frames of a project with this content; what could be read, and what was said."""
    path.write_bytes(content)
    states, said = [], []
    try:
        with open_project(path) as opened:
            said += opened.problems
            for frame in opened.project.frames:
                try:
                    found = opened.state(frame.id)
                except IlfError as error:
                    said.append(str(error))
                else:
                    states.append(found.state)
                    said += found.problems
            save_project(path.with_name("again.ilf"), opened.project, base=[opened.parts], places=opened.places)
    except IlfError as error:
        said.append(str(error))
    for state in states:
        assert isinstance(state, FrameState)
        assert state.blocks.labels.shape == state.frame.shape
        for result in state.results.values():
            assert result.depth.size == np.count_nonzero(result.block.mask)
            assert len(list(result.history)) == len(result.history)
    assert all(sentence and "Traceback" not in sentence for sentence in said)
    return states, said


@QUICKLY
@given(cut=st.integers(0, 120_000), kept=st.booleans())
def test_cut(saved, cut, kept):
    content = saved.content
    states, said = read_all(content[: len(content) - cut] if kept else content[cut:], saved.path)
    assert len(states) == 2 or said


@QUICKLY
@given(data=st.data())
def test_flipped(saved, data):
    content = saved.content
    spoiled = bytearray(content)
    for _ in range(data.draw(st.integers(1, 8))):
        place = data.draw(st.integers(0, len(spoiled) - 1))
        spoiled[place] ^= data.draw(st.integers(1, 255))
    read_all(bytes(spoiled), saved.path)


@QUICKLY
@given(data=st.data())
def test_parts_removed_or_swapped(saved, data):
    parts = saved.parts()
    names = sorted(parts)
    for name in data.draw(st.lists(st.sampled_from(names), max_size=4)):
        parts.pop(name, None)
    for name in data.draw(st.lists(st.sampled_from(names), max_size=3)):
        parts[name] = parts.get(data.draw(st.sampled_from(names)), b"")
    states, said = read_all(zipped(parts), saved.path)
    assert len(states) == 2 or said


VALUES = st.one_of(
    st.none(), st.booleans(), st.integers(-(2**70), 2**70), st.floats(), st.text(max_size=5), st.just([]), st.just({}),
    st.lists(st.integers(-2, 2), max_size=5), st.dictionaries(st.text(max_size=3), st.integers(), max_size=2),
)  # fmt: skip


@QUICKLY
@given(data=st.data())
def test_any_value_of_the_json_is_another(saved, data):
    """A project that somebody else has written: sums and names fit, values do not."""
    parts = saved.parts()
    name = data.draw(st.sampled_from([name for name in sorted(parts) if name.endswith(".json")]))
    value = json.loads(parts[name])
    for _ in range(data.draw(st.integers(1, 3))):
        replace_somewhere(value, data)
    parts[name] = json.dumps(value).encode()
    read_all(zipped(parts), saved.path)


def replace_somewhere(value, data):
    """Put another value into an object or a list, at any depth."""
    while True:
        keys = sorted(value) if isinstance(value, dict) else range(len(value))
        if not keys:
            return
        key = data.draw(st.sampled_from(list(keys)))
        inside = value[key]
        if not isinstance(inside, dict | list) or not inside or data.draw(st.integers(0, 3)) == 0:
            value[key] = data.draw(VALUES)
            return
        value = inside


def zipped(parts):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in parts.items():
            archive.writestr(name, content)
    return buffer.getvalue()
