"""Frames' states as parts and back."""

import dataclasses
import json

import numpy as np
import pytest

from ilf.project.decoding import load_state
from ilf.project.encoding import Encoder, frame_part
from ilf.project.project import Project
from ilf.project.project_json import decode_project, encode_project
from ilf.project.sources import Places

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
        self.parts |= {frame_part(frame_id): encoded.frame, **encoded.arrays}
        return self


@pytest.fixture(scope="module")
def state(tmp_path_factory):
    return rich_state(small_frame(tmp_path_factory.mktemp("frame")))


@pytest.mark.parametrize("origin", ["files", "program"])
def test_a_state_comes_back_as_it_was(origin, state):
    wanted = state if origin == "files" else rich_state(made_frame())
    parts = Held().take(Encoder().encode(wanted), wanted.id)
    found = load_state(wanted.id, parts)
    assert found.problems == ()
    assert_same(wanted, found.state)
    assert found.names == parts.parts.keys() - {frame_part(wanted.id)}
    assert found.state.runs[1].run.frame is found.state.frame, "what runs share, they share again"
    assert found.state.runs[1].run.blocks is found.state.blocks.labels
    assert found.state.runs[1].results[1] is found.state.results[1]


def test_what_has_been_given_out_is_not_given_again(state):
    encoder = Encoder()
    first, second = encoder.encode(state), encoder.encode(state)
    assert first.arrays.keys() == first.names == second.names
    assert not second.arrays
    encoder.forget(first.names)
    assert encoder.encode(state).arrays == first.arrays
    parts = Held().take(first, state.id)
    other, found = Encoder(), load_state(state.id, parts)
    other.learn(found.origins, found.names)
    again = other.encode(found.state)
    assert not again.arrays
    assert again.frame == first.frame


def test_results_on_another_depth_are_left_out_and_blocks_stay(state):
    parts = Held().take(Encoder().encode(state), state.id)
    name = frame_part(state.id)
    parts.parts[name] = json.dumps(json.loads(parts.parts[name]) | {"frame": other_depth(parts, name)}).encode()
    found = load_state(state.id, parts)
    assert_same(found.state.blocks.labels, state.blocks.labels)
    assert (found.state.results, found.state.runs) == ({}, ())
    assert len(found.problems) == 1


def other_depth(parts, name):
    """The frame of a state, as one whose depth was another."""
    return json.loads(parts.parts[name])["frame"] | {"measured": "0" * 64}


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
        for field in dataclasses.fields(things[0]):
            if field.name == "explained":  # told of the run alone, and not kept
                continue
            default = field.default
            if field.default_factory is not dataclasses.MISSING:
                default = field.default_factory()
            if field.name in {"_composed", "_held"} or default is dataclasses.MISSING:
                continue
            values = [getattr(thing, field.name) for thing in things]
            assert any(value is not default and not np.array_equal(value, default) for value in values), field.name


def test_where_the_user_says_that_files_are_is_told_with_the_list(tmp_path):
    given = {"/gone/rgb.png": tmp_path / "rgb.png", "ab12": tmp_path / "depth.png"}
    held = Held({"project.json": encode_project(Project(), Places(given=given))})
    assert decode_project(held).places.given == given
