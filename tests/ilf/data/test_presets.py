"""Presets of one's own: in files and in their folder."""

import json
from pathlib import Path

import pytest

import ilf
from ilf.data.parameters import BlockParameters
from ilf.data.presets import (
    UserPreset,
    delete_preset,
    find_preset,
    list_presets,
    presets_folder,
    read_preset,
    rename_preset,
    save_preset,
    write_preset,
)
from ilf.errors import ExportError, FormatError, InputError, ParameterError

SOFT = UserPreset("weich, größer", ilf.preset("best", smoothness=3.5, noise=0.002))
PAPER = UserPreset("paper 300", ilf.preset("paper", max_iterations=300), BlockParameters(granularity=0.8))


def _saved(preset: UserPreset) -> Path:
    return save_preset(preset.name, preset.parameters, preset.extraction)


@pytest.mark.parametrize("preset", [SOFT, PAPER], ids=lambda preset: preset.name)
def test_a_preset_comes_back_from_its_file(preset, tmp_path):
    path = tmp_path / "mine.json"
    write_preset(path, preset)
    assert read_preset(path) == preset
    data = json.loads(path.read_text(encoding="utf-8"))
    assert data["parameters"] == preset.changes, "only what differs is in it"
    assert ("extraction" in data) == (preset.extraction is not None)


def test_what_a_file_leaves_out_is_as_in_its_base(tmp_path):
    path = tmp_path / "short.json"
    path.write_text('{"kind": "ilf-studio preset", "schema": 1}')
    assert read_preset(path) == UserPreset("short", ilf.preset())


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "empty"),
        ("{", "not valid JSON"),
        ("[1]", "is not a preset"),
        ('{"program": "ilf-studio"}', "is not a preset"),
        ({"schema": 2}, "preset has schema 2; ILF Studio .* reads schema 1 only"),
        ({"schema": 0}, "preset has schema 0; ILF Studio .* reads schema 1 only"),
        ({"schema": None}, "preset has schema null"),
        ({"base": "bestest"}, "base preset 'bestest' does not exist"),
        ({"base": ["best"]}, "'base' in the preset must be text, not a list"),
        ({"parameters": {"smoothnes": 1}}, "Did you mean smoothness"),
        ({"parameters": {"smoothness": "much"}}, "smoothness must be a number"),
        ({"parameters": [1]}, "'parameters' in the preset must be an object, not a list"),
        ({"extraction": None}, "'extraction' in the preset must be an object, not null"),
        ({"extraction": {"granularity": 7}}, "granularity must lie between 0 and 1"),
        ({"name": 7}, "'name' in the preset must be text, not an integer"),
        ({"name": ""}, "'name' in the preset must be text of length >= 1"),
    ],
    ids=lambda value: str(value)[:30],
)
def test_damaged_files_and_other_schemas_get_one_clear_sentence(content, message, tmp_path):
    path = tmp_path / "bad.json"
    whole = {"kind": "ilf-studio preset", "schema": 1}
    path.write_text(content if isinstance(content, str) else json.dumps(whole | content))
    with pytest.raises(FormatError, match=message) as caught:
        read_preset(path)
    assert str(path) in str(caught.value)


def test_ones_own_presets_are_kept_renamed_and_deleted(tmp_path):
    assert list_presets()[0] == {}
    path = _saved(SOFT)
    assert path.parent == presets_folder()
    _saved(PAPER)
    assert list(list_presets()[0]) == ["paper 300", "weich, größer"]
    with pytest.raises(InputError, match="A preset 'paper 300' already exists"):
        save_preset("Paper 300", SOFT.parameters)
    save_preset("paper 300", SOFT.parameters, replace=True)
    assert list_presets()[0]["paper 300"].parameters == SOFT.parameters
    rename_preset("paper 300", "Paper 300")
    rename_preset("Paper 300", "other")
    with pytest.raises(InputError, match="already"):
        rename_preset("other", SOFT.name)
    with pytest.raises(InputError, match=r"no user preset 'paper 300'\. Known: other, weich"):
        rename_preset("paper 300", "x")
    assert delete_preset("other").stem == "other"
    assert list(list_presets()[0]) == [SOFT.name]


@pytest.mark.parametrize(
    "name", ["", "a/b", "..", " a", "a ", "a.", "x" * 61, "con", "COM1.x", "a:b", "Best", "paper", "a\nb"]
)
def test_names_that_no_file_can_have_everywhere_are_refused(name):
    with pytest.raises(InputError, match=r"cannot be the name|built-in preset"):
        save_preset(name, SOFT.parameters)
    assert not presets_folder().exists()


def test_presets_are_found_by_name_and_by_file(tmp_path, monkeypatch):
    _saved(SOFT)
    write_preset(tmp_path / "file.json", PAPER)
    monkeypatch.chdir(tmp_path)
    assert find_preset("best").parameters == ilf.preset()
    assert find_preset(SOFT.name) == SOFT
    assert find_preset("file.json") == PAPER
    with pytest.raises(ParameterError, match=r"no preset 'file', and no such file\. Known: best, paper.*größer"):
        find_preset("file")


def test_the_library_takes_own_presets_by_name_and_file(small_frame, tmp_path):
    own = {"parameters": ilf.preset("best", smoothness=3), "extraction": BlockParameters(detector="canny")}
    ilf.save_preset("soft", **own)
    file = ilf.save_preset(tmp_path / "soft.json", **own)
    assert ilf.preset("soft", noise=0.01) == ilf.preset(str(file), noise=0.01) == own["parameters"].replace(noise=0.01)
    with pytest.raises(InputError, match="exists already"):
        ilf.save_preset(file, **own)
    for given in ("soft", file, str(file)):
        run = ilf.Run.of(small_frame, preset=given)
        assert (run.parameters, run.blocks.extraction) == tuple(own.values())
    blocks = ilf.extract_blocks(small_frame)
    assert ilf.complete(small_frame, blocks, preset="soft").run.parameters == own["parameters"]
    assert ilf.Run.of(small_frame, preset="soft", extraction=BlockParameters()).blocks.extraction == BlockParameters()
    with pytest.raises(ParameterError, match=r"no preset 'sof'.*soft"):
        ilf.complete(small_frame, preset="sof")


def test_a_preset_that_cannot_be_renamed_or_deleted_is_said(monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    path = _saved(SOFT)
    monkeypatch.setattr(Path, "unlink", refuse)
    monkeypatch.setattr(Path, "rename", refuse)
    with pytest.raises(ExportError, match=r"cannot be deleted: Permission denied.*permissions"):
        delete_preset(SOFT.name)
    with pytest.raises(ExportError, match=r"cannot be renamed: Permission denied.*permissions"):
        rename_preset(SOFT.name, "hart")
    assert path.is_file()
