"""Files that come with the program."""

from __future__ import annotations

from pathlib import Path

from .errors import InputError

_PACKAGE = Path(__file__).parent

# an installed package carries its assets inside, a checkout has them beside the package
_ROOTS = (_PACKAGE / "assets", _PACKAGE.parent / "assets")


def asset_path(name: str) -> Path:
    """Path of a bundled file or folder.

    Parameters
    ----------
    name : str
        Path below the assets, such as "samples/room".

    Raises
    ------
    InputError
        If this installation does not have it.

    Examples
    --------
    >>> sorted(path.name for path in asset_path("samples/room").iterdir())
    ['depth.png', 'gt.png', 'meta.json', 'rgb.jpg']
    """
    for root in _ROOTS:
        if (root / name).exists():
            return root / name
    raise InputError(f"The bundled {name} is not part of this installation. Install ilf-studio again.")
