"""Frames' states as parts and back, whatever fields they have."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from ilf.errors import FormatError
from ilf.project.codec import pack, unpack
from ilf.project.state_codec import Known, encode, frame_part, load_state

from ..project_states import assert_same, made_frame, rich_state, small_frame


class Held:
    """Parts in memory."""

    def __init__(self, parts=()):
        self.parts = dict(parts)

    def names(self):
        return self.parts.keys()

    def read(self, name):
        return self.parts[name]

    def take(self, encoded, frame_id):
        self.parts |= {frame_part(frame_id): encoded.content, **encoded.made}
        return self


@pytest.fixture(scope="module")
def state(tmp_path_factory):
    return rich_state(small_frame(tmp_path_factory.mktemp("frame")))


@pytest.mark.parametrize("origin", ["files", "program"])
def test_a_state_comes_back_as_it_was(origin, state):
    wanted = state if origin == "files" else rich_state(made_frame())
    encoded = encode(wanted)
    assert encoded.made.keys() == encoded.names
    found = load_state(wanted.id, Held().take(encoded, wanted.id))
    assert found.problems == ()
    assert_same(wanted, found.state)
    assert found.state.runs[1].run.frame is found.state.frame, "what runs share, they share again"
    assert found.state.runs[1].run.blocks.labels is found.state.blocks.labels
    assert found.state.runs[1].results[1] is found.state.results[1]


def test_only_what_is_another_object_is_written_again(state):
    held, known = Held().take(encode(state), state.id), Known()
    read = load_state(state.id, held, known=known)
    encode(read.state, known)
    assert not encode(read.state, known).made
    assert encode(read.state, known, is_there=lambda name: False).made, "it is stored no more"
    labels = read.state.blocks.labels.copy()
    labels[0, 0] += 1
    edited = replace(read.state, note="new", blocks=replace(read.state.blocks, labels=labels))
    changed = encode(edited, known)
    assert len(changed.made) == 1
    assert_same(edited, load_state(state.id, held.take(changed, state.id)).state)


@pytest.mark.parametrize(
    "array",
    [
        np.array([0.5, np.nan, -np.inf], np.float32),
        np.full((200, 3), np.nan, np.float32),
        np.full((2160, 1), 70_000, np.int32),
        np.arange(300, dtype=np.int64) - 5,
        np.zeros((0, 4), bool),
    ],
)
def test_an_array_comes_back_with_its_type_and_all_bits(array):
    kind = NDArray[array.dtype.type]
    assert_same(array, unpack(*pack(array), kind))


def test_a_part_that_unpacks_to_gigabytes_is_refused(monkeypatch):
    monkeypatch.setattr("ilf.project.codec.MAX_UNPACKED", 10**6)
    for arrays in ((np.zeros(10**6),), (np.zeros(10**5), np.arange(10**5, dtype=np.int32))):  # also of small files
        with pytest.raises(FormatError, match="too large"):
            unpack(*pack(arrays), tuple[*(NDArray[array.dtype.type] for array in arrays)])


def test_the_same_set_is_the_same_part_however_it_was_made():
    assert pack({8, 16}) == pack({16, 8})


def test_the_state_that_is_tried_has_something_in_every_place(state):
    """Who adds a field to what a project holds has to think of how it is kept."""
    kept = state.runs
    tried = [
        (state,),
        (state.blocks,),
        (state.looked,),
        tuple(state.blocks.infos.values()),
        kept,
        tuple(run.run for run in kept),
        tuple(state.results.values()),
    ]
    for things in tried:
        for one in dataclasses.fields(things[0]):
            default = one.default
            if one.default_factory is not dataclasses.MISSING:
                default = one.default_factory()
            if not one.metadata.get("stored", True) or one.name.startswith("_") or default is dataclasses.MISSING:
                continue
            values = [getattr(thing, one.name) for thing in things]
            assert any(value is not default and not np.array_equal(value, default) for value in values), one.name
