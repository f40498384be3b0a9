"""Ranges that are proposed make sense for every parameter, and are spread as they are asked to be."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ilf.data.parameters import PRESETS, BlockParameters, Parameters
from ilf.errors import ParameterError
from ilf.evaluation.sweep import can_be_swept, spread, suggested_range

NUMBERS = [
    one
    for declared in (Parameters.declarations(), BlockParameters.declarations())
    for one in declared.values()
    if can_be_swept(one)
]
SMOOTHNESS = Parameters.declarations()["smoothness"]
ITERATIONS = Parameters.declarations()["max_iterations"]


@pytest.mark.parametrize("declaration", NUMBERS, ids=lambda one: one.name)
def test_every_parameter_has_a_range_with_several_values_of_which_the_present_one_is_one(declaration):
    presets = [*(vars(values) for values in PRESETS.values()), vars(BlockParameters())]
    for present in {values.get(declaration.name, declaration.default) for values in presets}:
        low, high = suggested_range(declaration, present)
        values = spread(declaration, low, high, 7, declaration.scale == "log" and low > 0, present)
        assert len(values) >= 3
        assert values == tuple(declaration.checked(value) for value in values)  # none is out of bounds
        assert present in values or (declaration.scale == "log" and present <= 0)


@given(low=st.floats(0.001, 1e3), factor=st.floats(1.01, 1e3), steps=st.integers(2, 50), logarithmic=st.booleans())
def test_values_rise_from_one_end_to_the_other(low, factor, steps, logarithmic):
    high = low * factor
    values = np.array(spread(SMOOTHNESS, low, high, steps, logarithmic))
    assert (values[0], values[-1]) == (low, high)
    assert (np.diff(values) > 0).all()
    assert len(values) <= steps


def test_ratios_are_equal_on_a_logarithmic_range_and_differences_on_a_linear_one():
    assert spread(SMOOTHNESS, 1, 1000, 4, logarithmic=True) == (1.0, 10.0, 100.0, 1000.0)
    assert spread(SMOOTHNESS, 1, 2, 5, logarithmic=False) == (1.0, 1.25, 1.5, 1.75, 2.0)
    assert spread(ITERATIONS, 1, 3, 7, logarithmic=False) == (1, 2, 3)


@pytest.mark.parametrize(
    ("low", "high", "steps", "logarithmic", "said"),
    [
        (2.0, 1.0, 5, False, "must increase"),
        (0.0, 1.0, 5, True, "Start above 0"),
        (1.0, 2.0, 1, False, "2 to 50 values"),
        (1.0, 2e6, 3, False, "between 0.001 and 1e\\+06"),
    ],
)
def test_a_range_that_makes_no_sense_is_refused_in_a_sentence(low, high, steps, logarithmic, said):
    with pytest.raises(ParameterError, match=said):
        spread(SMOOTHNESS, low, high, steps, logarithmic)
