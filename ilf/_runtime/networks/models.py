"""Names and files of the available networks: the bundled ones, the user's own, and those of installed packages."""

from __future__ import annotations

import re
from functools import cache
from importlib.resources import files
from pathlib import Path

from ...errors import ExportError, InputError, told_as
from ..installation import asset_path, user_path
from ..plugins import call, entry_points

BUNDLED = "edges"
"""The bundled contour network."""

DEPTH_EDGES = "depth-edges"
"""The bundled depth-edge network, the only one of its kind."""

CORRECTION = "correction"
"""The bundled network that corrects completed depth, the only one of its kind."""

SPARSE_CORRECTION = "sparse-correction"
"""The bundled network that corrects sparse depth further, the only one of its kind."""

_OURS = (BUNDLED, DEPTH_EDGES, CORRECTION, SPARSE_CORRECTION)

_PACKAGES = "ilf.networks"
"""Group of entry points: the name of a network, and the package that contains `<name>.onnx`."""

_SUFFIX = ".onnx"
_NAME = re.compile(r"[A-Za-z0-9_-]{1,100}")


def models_folder() -> Path:
    """Return the folder of the user's networks, which may not exist yet; environment variable ILF_MODELS overrides
    it."""
    return user_path("data", "models", "ILF_MODELS")


def model_names() -> tuple[str, ...]:
    """Return the names of all contour networks: the bundled one, then the user's and installed ones in alphabetical
    order."""
    own = {path.stem for path in models_folder().glob(f"*{_SUFFIX}") if path.is_file() and _NAME.fullmatch(path.stem)}
    return (BUNDLED, *sorted((own | installed_models().keys()) - set(_OURS)))


@cache
def installed_models() -> dict[str, str]:
    """Return the networks of installed packages: name -> package."""
    return {one.name: one.value for one in entry_points(_PACKAGES) if _NAME.fullmatch(one.name)}


def model_path(name: str) -> Path:
    """Return the path of a network's file.

    Parameters
    ----------
    name : str
        One of `model_names`, `DEPTH_EDGES`, `CORRECTION` or `SPARSE_CORRECTION`.

    Raises
    ------
    InputError
        If no network has that name.
    """
    if name in _OURS:
        return asset_path(f"models/{name}{_SUFFIX}")
    names = model_names()
    if name not in names:
        raise InputError(
            f"There is no edge network {name!r} on this computer, only {', '.join(names)}. "
            "Choose one of these, or add it: ilf models add FILE --name NAME."
        )
    own = _own_path(name)
    if own.is_file() or name not in installed_models():
        return own
    entry = next(one for one in entry_points(_PACKAGES) if one.name == name)
    return Path(str(call(entry, files, entry.value).joinpath(f"{name}{_SUFFIX}")))


def new_model_path(name: str, replace: bool = False) -> Path:
    """Return the path for a network that is to be added.

    Parameters
    ----------
    name : str
        Letters, digits, - and _ only, at most 100 characters.
    replace : bool
        Whether one of the user's own networks may already have that name.

    Raises
    ------
    InputError
        If the name has other characters, is that of a bundled network or is taken.
    """
    check_name(name)
    if name in _OURS:
        raise InputError(f"{name!r} is the name of a bundled edge network. Choose another name (--name).")
    if not replace and name in model_names():
        raise InputError(f"An edge network {name!r} already exists. Choose another name (--name), or --replace it.")
    return _own_path(name)


def check_name(name: str) -> None:
    """Raise InputError unless a network can have this name: 1 to 100 letters, digits, - and _."""
    if not _NAME.fullmatch(name):
        raise InputError(f"{name!r} cannot be the name of a network. Use 1 to 100 letters, digits, - and _ (--name).")


def name_from(file: Path) -> str:
    """Derive a network's name from its file name, with - for characters that are not allowed."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem).strip("-")[:100]


def remove_model(name: str) -> Path:
    """Delete one of the user's networks.

    Returns
    -------
    Path
        Path of the deleted file.

    Raises
    ------
    InputError
        If no network has that name, or it is a bundled one.
    ExportError
        If it cannot be deleted.
    """
    if name in _OURS:
        raise InputError(f"{name!r} is a bundled edge network, which cannot be removed.")
    path = model_path(name)
    if path != _own_path(name):
        package = installed_models()[name]
        raise InputError(f"{name!r} belongs to the package {package}. Uninstall that package to remove it.")
    with told_as(ExportError, f"{path} cannot be removed: {{error}}. Check the folder's permissions.", OSError):
        path.unlink()
    return path


def _own_path(name: str) -> Path:
    return models_folder() / f"{name}{_SUFFIX}"
