"""Names and files of the available networks: the bundled ones and the user's own."""

from __future__ import annotations

import os
import re
from pathlib import Path

import platformdirs

from ...errors import ExportError, InputError, cause
from ..installation import asset_path

BUNDLED = "edges"
"""The bundled contour network."""

SURFACES = "surfaces"
"""The bundled network that looks at a frame, the only one of its kind."""

CORRECTION = "correction"
"""The bundled network that corrects completed depth, the only one of its kind."""

_OURS = (BUNDLED, SURFACES, CORRECTION)

_SUFFIX = ".onnx"
_NAME = re.compile(r"[A-Za-z0-9_-]{1,100}")


def models_folder() -> Path:
    """Return the folder of the user's networks, which may not exist yet; environment variable ILF_MODELS overrides
    it."""
    chosen = os.environ.get("ILF_MODELS")
    return Path(chosen) if chosen else platformdirs.user_data_path("ilf-studio", appauthor=False) / "models"


def model_names() -> tuple[str, ...]:
    """Return the names of all contour networks: the bundled one, then the user's in alphabetical order."""
    own = {path.stem for path in models_folder().glob(f"*{_SUFFIX}") if path.is_file() and _NAME.fullmatch(path.stem)}
    return (BUNDLED, *sorted(own - set(_OURS)))


def model_path(name: str) -> Path:
    """Return the path of a network's file.

    Parameters
    ----------
    name : str
        One of `model_names`, `SURFACES` or `CORRECTION`.

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
            "Choose one of these, or import it: ilf models import FILE --name NAME."
        )
    return _own_path(name)


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
    if not _NAME.fullmatch(name):
        raise InputError(
            f"{name!r} cannot be the name of an edge network. Use 1 to 100 letters, digits, - and _ (--name)."
        )
    if name in _OURS:
        raise InputError(f"{name!r} is the name of a bundled edge network. Choose another name (--name).")
    if not replace and name in model_names():
        raise InputError(f"An edge network {name!r} already exists. Choose another name (--name), or --replace it.")
    return _own_path(name)


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
    try:
        path.unlink()
    except OSError as error:
        raise ExportError(f"{path} cannot be removed: {cause(error)}. Check the folder's permissions.") from error
    return path


def _own_path(name: str) -> Path:
    return models_folder() / f"{name}{_SUFFIX}"
