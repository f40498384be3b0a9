"""Declarations, validation, presets."""

import pytest

import ilf
from ilf.errors import ParameterError

SETS = [ilf.Parameters, ilf.BlockParameters]


@pytest.mark.parametrize("set_class", SETS)
def test_every_parameter_is_declared_with_a_default_in_range(set_class):
    for name, declaration in set_class.declarations().items():
        assert declaration.name == name
        assert declaration.label
        assert declaration.help.endswith(".")
        assert declaration.checked(declaration.default) == declaration.default
        if declaration.kind in (int, float):
            assert declaration.minimum is not None
            assert declaration.maximum is not None


@pytest.mark.parametrize("set_class", SETS)
def test_round_trip_through_a_dictionary(set_class):
    values = set_class().to_dict()
    assert set_class.from_dict(values) == set_class()


def test_presets_are_the_papers_and_the_released_codes():
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
    assert ilf.preset() == ilf.Parameters() == ilf.PRESETS["best"]
    best = ilf.Parameters()
    assert (best.filter, best.centred, best.s_criteria) == ("edge-aware", True, 0.0005)
    assert {preset.filter for preset in (paper, released)} == {"ideal"}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rgb_iteration": 3}, "Did you mean rgb_iterations"),
        ({"colour": 3}, "no parameter 'colour'"),
        ({"mode": "magic"}, "one of fill, fill\\+denoise"),
        ({"mode": ["fill"]}, "one of fill, fill\\+denoise"),
        ({"max_iterations": 0}, "between 1 and"),
        ({"max_iterations": 2.5}, "an integer"),
        ({"s_criteria": float("nan")}, "finite"),
        ({"s_criteria": -1}, "between 0 and 1 m"),
        ({"s_criteria": "0.005"}, "must be a number"),
        ({"padding": None}, "must be a number"),
        ({"centred": 1}, "true or false"),
        ({"rgb_iterations": True}, "must be a number"),
    ],
)
def test_unknown_names_and_values_out_of_range_raise(changes, message):
    with pytest.raises(ParameterError, match=message):
        ilf.preset("paper", **changes)


@pytest.mark.parametrize(
    ("preset", "changes", "name", "present", "needed"),
    [
        ("best", {"padding": 3}, "padding", "filter edge-aware", "filter ideal"),
        ("best", {"centred": True, "mode": "fill"}, "centred", "filter edge-aware", "filter ideal"),
        ("best", {"linear_start": 1}, "linear_start", "filter edge-aware", "filter ideal"),
        ("paper", {"linear_start": 1}, "linear_start", "schedule staged", "schedule linear"),
        ("paper", {"model": "mine"}, "model", "filter ideal", "filter edge-aware"),
        ("best", {"model": "mine", "edges": "canny"}, "model", "edges canny", "edges combined"),
    ],
)
def test_a_parameter_that_has_no_effect_is_refused(preset, changes, name, present, needed):
    sentence = f"{name} has no effect with {present}; it belongs to {needed}."
    with pytest.raises(ParameterError) as refused:
        ilf.preset(preset, **changes)
    assert str(refused.value) == sentence
    assert ilf.PRESETS[preset].replace(**changes).without_effect(changes) == (sentence,)


def test_every_parameter_that_has_no_effect_is_named():
    with pytest.raises(ParameterError, match=r"^padding has .* ideal\. precision has .* ideal\.$"):
        ilf.preset("best", padding=3, trend=False, precision="float32")


def test_a_parameter_counts_with_those_that_are_changed_beside_it():
    assert ilf.preset("best", filter="ideal", padding=3).padding == 3
    assert ilf.preset("paper", schedule="linear", linear_start=1).linear_start == 1
    with pytest.raises(ParameterError, match="padding has no effect with filter edge-aware"):
        ilf.preset("paper", filter="edge-aware", padding=3)


def test_a_parameter_may_count_with_several_values_of_another():
    for detector in ("rgbd", "hed"):
        assert ilf.BlockParameters().changed(detector=detector, threshold=0.3).has_effect("threshold")
    with pytest.raises(ParameterError) as refused:
        ilf.BlockParameters().changed(detector="canny", threshold=0.3)
    assert str(refused.value) == "threshold has no effect with detector canny; it belongs to detector rgbd or hed."


def test_replace_and_records_take_values_without_effect():
    assert ilf.preset().replace(padding=3).padding == 3
    assert ilf.Parameters.from_dict(ilf.preset().to_dict() | {"padding": 3}).padding == 3


@pytest.mark.parametrize("set_class", SETS)
def test_what_is_made_of_stored_values_needs_all_of_them(set_class):
    values = set_class().to_dict()
    first, *others = values
    with pytest.raises(ParameterError, match=f"There is no value for {first}"):
        set_class.from_dict({name: values[name] for name in others})


def test_sets_have_the_same_effect_if_they_differ_in_nothing_that_counts():
    best, paper = ilf.PRESETS["best"], ilf.PRESETS["paper"]
    assert best.same_effect(best.replace(padding=3.0, linear_start=2.0, centred=False))
    assert not best.same_effect(best.replace(noise=0.1))
    assert not best.same_effect(best.replace(filter="ideal"))
    assert paper.same_effect(paper.replace(noise=0.1, linear_start=2.0))
    assert not paper.same_effect(paper.replace(padding=3.0))
    assert ilf.BlockParameters(use_depth=False).same_effect(ilf.BlockParameters(use_depth=False, depth_jump=1.0))


@pytest.mark.parametrize("kind", [ilf.Parameters, ilf.BlockParameters])
def test_the_docstring_lists_every_parameter_as_it_is_declared(kind):
    entries = {}
    for line in (kind.__doc__ or "").splitlines():
        name, found, facts = line.partition(" : ")
        if found and not line.startswith(" "):
            entries[name] = facts
    assert list(entries) == list(kind.declarations())
    assert entries["model"] == "str, default 'edges'"
    if kind is ilf.BlockParameters:
        assert entries["depth_jump"] == "float, 0.001 to 5 m, default 0.04 m"
        assert entries["threshold"] == "float, 0 to 1 (0: auto), default auto"
        assert entries["detector"] == "{'rgbd', 'hed', 'canny'}, default 'hed'"
        assert entries["dilation"] == "int, 0 to 50 px, default 2 px"
        assert entries["use_depth"] == "bool, default True"
