"""Presets by name or file: the built-in ones, and the user's own in files and in the presets folder."""

from __future__ import annotations

import dataclasses
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec

from .._runtime.files import read_json
from .._runtime.installation import user_path
from .._runtime.schema import Section, check_schema
from .._runtime.writing import ensure_folder, write_bytes
from ..errors import (
    ExportError,
    FormatError,
    IlfError,
    InputError,
    ParameterError,
    PathKind,
    check_kind,
    told_as,
)
from .declarations import Value
from .parameters import (
    DEFAULT_PRESET,
    PAPER_BLOCKS,
    PRESETS,
    BlockParameters,
    Parameters,
    as_block_parameters,
    nearest_preset,
    split_parameters,
)

PRESET_SUFFIX = ".json"

SCHEMA = 1
"""Version of the format of preset files."""

_KIND = "ilf-studio preset"
_LONGEST_NAME = 60
_NAME = re.compile(r"\w[\w +,()%=.-]*")
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
"""Names that Windows reserves for devices."""


@dataclass(frozen=True)
class UserPreset:
    """Named parameters.

    Parameters
    ----------
    name : str
    parameters : Parameters
        Parameters of the filter.
    extraction : BlockParameters, optional
        Parameters of the extraction; None if the preset does not set them.

    Examples
    --------
    >>> from ilf import preset
    >>> UserPreset("soft", preset("best", smoothness=3)).changes
    {'smoothness': 3.0}
    """

    name: str
    parameters: Parameters
    extraction: BlockParameters | None = None

    @property
    def base(self) -> str:
        """The nearest built-in preset; its file contains the differences from it."""
        return nearest_preset(self.parameters).preset

    @property
    def changes(self) -> dict[str, Value]:
        """The parameters of the filter that differ from the base."""
        return self.parameters.differences_from(PRESETS[self.base])

    @property
    def extraction_changes(self) -> dict[str, Value]:
        """The parameters of the extraction that differ from the defaults."""
        return {} if self.extraction is None else self.extraction.differences_from(BlockParameters())


BUILT_IN: Mapping[str | os.PathLike[str], UserPreset] = {
    name: UserPreset(name, parameters, None if name == DEFAULT_PRESET else PAPER_BLOCKS)
    for name, parameters in PRESETS.items()
}
"""Name -> preset of everybody."""


def preset(name: Parameters | str | os.PathLike[str] | None = DEFAULT_PRESET, **changes: object) -> Parameters:
    """Return the parameters of the filter of a preset, or given ones, with any of them changed.

    Parameters
    ----------
    name : str, path-like, Parameters or None
        "best" (edge-aware filter), "paper" (staged schedule, stop when steady), "released-code" (linear schedule,
        always 1500 iterations), one of your own by name, or its file; None for the default.
    **changes
        Any parameter by name.

    Raises
    ------
    ParameterError
        For an unknown preset or parameter, a value out of range, a parameter that has no effect with the others, or an
        object of another type.
    FormatError
        If the preset's file is damaged, or no preset.

    Examples
    --------
    >>> preset() == Parameters()
    True
    >>> preset("released-code", rgb_iterations=0, mode="fill+denoise").rgb_iterations
    0
    >>> preset("best", padding=3)
    Traceback (most recent call last):
    ilf.errors.ParameterError: padding has no effect with filter edge-aware; it belongs to filter ideal.
    """
    if not isinstance(name, Parameters | str | os.PathLike | None):
        raise ParameterError(
            f"Parameters must be ilf.Parameters, or a preset by name ({', '.join(PRESETS)}, your own) or file, not "
            f"{name!r:.60}."
        )
    if isinstance(name, Parameters):
        return name.changed(**changes)
    return find_preset(DEFAULT_PRESET if name is None else name).parameters.changed(**changes)


def chosen_parameters(
    given: Parameters | str | os.PathLike[str] | None,
    extraction: BlockParameters | None,
    changes: Mapping[str, Value],
    *others: str,
) -> tuple[Parameters, BlockParameters, dict[str, Value]]:
    """Return the parameters of filter and extraction that a call asks for by preset, object and keywords.

    A preset by name or file also sets its parameters of the extraction, unless `extraction` is given.

    Parameters
    ----------
    given : Parameters, str, path-like or None
        As in `preset`.
    extraction : BlockParameters, optional
    changes : mapping
        Name -> value of any parameter of either.
    *others : str
        Further keywords of the call, suggested for misspelt names.

    Returns
    -------
    tuple
        Parameters of the filter, of the extraction, and those of `changes` that belong to the extraction.

    Raises
    ------
    ParameterError, FormatError
        As for `preset` and `as_block_parameters`.
    """
    of_filter, of_blocks = split_parameters(changes, *others)
    if extraction is None and isinstance(given, str | os.PathLike):
        extraction = find_preset(given).extraction
    return preset(given, **of_filter), as_block_parameters(extraction, **of_blocks), of_blocks


def read_preset(path: str | os.PathLike[str]) -> UserPreset:
    """Read a preset's file.

    Parameters
    ----------
    path : path-like
        JSON with `kind` "ilf-studio preset", `schema` 1, `name`, `base` (a built-in preset; "best" if left out),
        `parameters` (those that differ from it) and optionally `extraction` (those that differ from the defaults).

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is damaged, not a preset, of another schema, or has an unknown parameter or an invalid value.

    Examples
    --------
    >>> from ilf import preset
    >>> write_preset("soft.json", UserPreset("soft", preset("best", smoothness=3)))
    >>> read_preset("soft.json").parameters.smoothness
    3.0
    """
    data = read_json(path)
    if not isinstance(data, dict) or data.get("kind") != _KIND:
        raise FormatError(f"{Path(path).absolute()} is not a preset: give a file with an exported preset.")
    with told_as(FormatError, f"{Path(path).absolute()}: {{error}}", IlfError):
        check_schema(data, SCHEMA, "preset")
        stated = Section("preset", {"name": Path(path).stem, "base": DEFAULT_PRESET, "parameters": {}, **data})
        base = stated.get("base", str)
        if base not in PRESETS:
            raise FormatError(f"Its base preset {base!r:.40} does not exist. Known: {', '.join(PRESETS)}.")
        own = stated.get("extraction", dict[str, Any]) if "extraction" in data else None
        extraction = None if own is None else BlockParameters().replace(**own)
        parameters = PRESETS[base].replace(**stated.get("parameters", dict[str, Any]))
        name = stated.get("name", Annotated[str, msgspec.Meta(min_length=1)])
        return UserPreset(name, parameters, extraction)


def write_preset(path: str | os.PathLike[str], preset: UserPreset) -> None:
    """Write a preset's file, atomically.

    Parameters
    ----------
    path : path-like
        Usually with the suffix .json.
    preset : UserPreset

    Raises
    ------
    ExportError
        If it cannot be written.
    """
    data: dict[str, Any] = {
        "kind": _KIND,
        "schema": SCHEMA,
        "name": preset.name,
        "base": preset.base,
        "parameters": preset.changes,
    }
    if preset.extraction is not None:
        data["extraction"] = preset.extraction_changes
    write_bytes(path, f"{json.dumps(data, indent=2, ensure_ascii=False)}\n".encode())


def presets_folder() -> Path:
    """Folder of the user's presets, which may not exist; the environment variable ILF_PRESETS overrides it."""
    return user_path("config", "presets", "ILF_PRESETS")


def list_presets() -> tuple[dict[str, UserPreset], list[str]]:
    """List the user's presets by file name, in alphabetical order, and a sentence for each file that cannot be read."""
    presets, problems = {}, []
    for path in sorted(presets_folder().glob(f"*{PRESET_SUFFIX}"), key=lambda path: path.stem.casefold()):
        try:
            presets[path.stem] = dataclasses.replace(read_preset(path), name=path.stem)
        except IlfError as error:
            problems.append(str(error))
    return presets, problems


def find_preset(name: str | os.PathLike[str]) -> UserPreset:
    """Find a preset by name or file. Those of the paper include parameters of the extraction.

    Parameters
    ----------
    name : str or path-like
        Name of a built-in or user preset, or path of a file.

    Raises
    ------
    ParameterError
        If there is no preset of that name, and no such file.
    FormatError
        If the file cannot be read.

    Examples
    --------
    >>> find_preset("paper").parameters.filter
    'ideal'
    """
    check_kind(name, PathKind, "A preset is given by name or file", "`ilf info --presets` lists them.")
    if name in BUILT_IN:
        return BUILT_IN[name]
    own = _existing(name) if isinstance(name, str) else None
    if own is not None:
        return dataclasses.replace(read_preset(own), name=own.stem)
    if os.path.isfile(name):
        return read_preset(name)
    known = ", ".join([*PRESETS, *list_presets()[0]])
    raise ParameterError(f"There is no preset {os.fspath(name)!r:.80}, and no such file. Known: {known}.")


def save_preset(
    name: str | os.PathLike[str],
    parameters: Parameters,
    extraction: BlockParameters | None = None,
    *,
    replace: bool = False,
) -> Path:
    """Save parameters as a preset of one's own, for `preset`, the window, and `--preset` of the command line.

    Parameters
    ----------
    name : str or path-like
        Its name in the list of presets, which are in the user's folder; or the file to write: a path, or text that ends
        in .json.
    parameters : Parameters
        Parameters of the filter.
    extraction : BlockParameters, optional
        Parameters of the extraction; the preset does not set them if left out.
    replace : bool
        Whether it may replace a preset of the same name, or a file.

    Returns
    -------
    Path
        Its file.

    Raises
    ------
    InputError
        If the name is taken, or not a valid file name on all systems.
    ExportError
        If it cannot be written.

    Examples
    --------
    >>> import ilf
    >>> path = ilf.save_preset("gentle.json", ilf.preset("best", smoothness=3))
    >>> ilf.preset("gentle.json").smoothness
    3.0
    """
    check_kind(parameters, Parameters, "A preset is saved from parameters", 'give ilf.save_preset("soft", parameters).')
    if isinstance(name, os.PathLike) or name.endswith(PRESET_SUFFIX):
        path = Path(name)
        if path.exists() and not replace:
            raise InputError(f"{path} exists already. Choose another name, or replace it.")
        write_preset(path, UserPreset(path.stem, parameters, extraction))
        return path
    path = (_existing(name) if replace else None) or _free_path(name)
    ensure_folder(path.parent)
    write_preset(path, UserPreset(name, parameters, extraction))
    return path


def rename_preset(old: str, new: str) -> Path:
    """Rename one of the user's presets.

    Raises
    ------
    InputError
        If there is none of the old name, or the new one is taken or not a valid file name on all systems.
    ExportError
        If its file cannot be renamed.
    """
    source = _user_preset(old)
    target = _free_path(new, keeps=source)
    with told_as(ExportError, f"{source} cannot be renamed: {{error}}. Check the folder's permissions.", OSError):
        return source.rename(target)


def delete_preset(name: str) -> Path:
    """Delete one of the user's presets; returns its former path.

    Raises
    ------
    InputError
        If there is none of that name.
    ExportError
        If it cannot be deleted.
    """
    path = _user_preset(name)
    with told_as(ExportError, f"{path} cannot be deleted: {{error}}. Check the folder's permissions.", OSError):
        path.unlink()
    return path


def _user_preset(name: str) -> Path:
    path = _existing(name)
    if path is None:
        known = ", ".join(list_presets()[0]) or "none"
        raise InputError(f"There is no user preset {name!r}. Known: {known}.")
    return path


def _existing(name: str) -> Path | None:
    """The file of one of the user's presets; names are compared without case, as on some systems."""
    files = presets_folder().glob(f"*{PRESET_SUFFIX}")
    return next((path for path in files if path.stem.casefold() == name.casefold()), None)


def _free_path(name: str, keeps: Path | None = None) -> Path:
    """The path for a preset of this name, unless another one than `keeps` has it."""
    fits = _NAME.fullmatch(name) and len(name) <= _LONGEST_NAME and name[-1] not in ". "
    if not fits or _RESERVED.fullmatch(name):
        raise InputError(
            f"{name!r:.80} cannot be the name of a preset. Use up to {_LONGEST_NAME} letters, digits, spaces and "
            "+ , ( ) % = . - _, beginning with a letter or digit, and not ending with a dot."
        )
    if name.casefold() in {preset.casefold() for preset in PRESETS}:
        raise InputError(f"{name!r} is the name of a built-in preset. Choose another name.")
    taken = _existing(name)
    if taken is not None and taken != keeps:
        raise InputError(f"A preset {taken.stem!r} already exists. Choose another name, or replace it.")
    return presets_folder() / f"{name}{PRESET_SUFFIX}"
