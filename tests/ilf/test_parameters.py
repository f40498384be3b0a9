"""Declarations, validation, presets."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import ilf
from ilf.declarations import ParameterSet
from ilf.errors import ParameterError
from ilf.parameters import PRESETS, BlockParameters, Parameters

SETS = [Parameters, BlockParameters]


@pytest.mark.parametrize("set_class", SETS)
def test_every_parameter_is_declared_with_a_default_in_range(set_class: type[ParameterSet]) -> None:
    for name, declaration in set_class.declarations().items():
        assert declaration.name == name
        assert declaration.label
        assert declaration.help.endswith(".")
        assert declaration.checked(declaration.default) == declaration.default
        if declaration.kind in (int, float):
            assert declaration.minimum is not None
            assert declaration.maximum is not None


@pytest.mark.parametrize("set_class", SETS)
def test_round_trip_through_a_dictionary(set_class: type[ParameterSet]) -> None:
    values = set_class().to_dict()
    assert set_class.from_dict(values) == set_class()


def test_presets_are_the_papers_and_the_released_codes() -> None:
    paper, released = ilf.preset("paper"), ilf.preset("released-code")
    assert (paper.schedule, paper.s_criteria, paper.max_iterations, paper.rgb_iterations) == (
        "staged",
        0.005,
        1500,
        150,
    )
    assert (released.schedule, released.max_iterations, released.stop_when_steady) == ("linear", 1500, False)
    assert released.rgb_iterations == 99  # i < 100
    assert not paper.centred
    assert not released.centred
    assert ilf.preset() == PRESETS["best"]


def test_changes_by_name() -> None:
    changed = ilf.preset("released-code", rgb_iterations=0, mode="fill+denoise")
    assert (changed.rgb_iterations, changed.mode) == (0, "fill+denoise")
    assert changed.schedule == "linear"
    assert ilf.preset(s_criteria=np.float32(0.25)).s_criteria == 0.25


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rgb_iteration": 3}, "Did you mean rgb_iterations"),
        ({"colour": 3}, "no parameter 'colour'"),
        ({"mode": "magic"}, "one of fill, fill\\+denoise"),
        ({"max_iterations": 0}, "between 1 and"),
        ({"max_iterations": 2.5}, "whole number"),
        ({"s_criteria": float("nan")}, "finite"),
        ({"s_criteria": -1}, "between 0 and 1 m"),
        ({"s_criteria": "0.005"}, "must be a number"),
        ({"padding": None}, "must be a number"),
        ({"centred": 1}, "true or false"),
        ({"rgb_iterations": True}, "must be a number"),
    ],
)
def test_unknown_names_and_values_out_of_range_raise(changes: dict[str, object], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        ilf.preset("paper", **changes)


def test_unknown_preset() -> None:
    with pytest.raises(ParameterError, match="paper, released-code"):
        ilf.preset("fast")


def test_parameters_are_immutable() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        ilf.preset().mode = "fill"
