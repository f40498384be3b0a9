"""Optional packages: imported when they are needed; error messages say what to install."""

from __future__ import annotations

import ctypes
import os
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import ModuleType

from ..errors import InputError

_CHILD = "--ilf-child"
"""First argument of a frozen program that runs as a child."""

_OTHER_PACKAGES = {"libglib-2.0.so.0": "libglib2.0-0", "libgthread-2.0.so.0": "libglib2.0-0", "libz.so.1": "zlib1g"}
"""Shared library -> its package of Debian and Ubuntu, where that is not named by their rule."""

_LIBRARY = re.compile(r"\blib[\w.+-]+\.so\.\d+")


def optional(module: str, requirement: str, purpose: str) -> ModuleType:
    """Import a package that this one does not install by itself.

    Parameters
    ----------
    module : str
        Its name, such as "h5py".
    requirement : str
        What pip installs: an extra, such as "ilf-studio[sensors]", or a package that no extra has.
    purpose : str
        What needs it, as the subject of a sentence: "NYU Depth V2's labelled file".

    Raises
    ------
    InputError
        If it is not installed, or a system library that it needs is missing; the message states what to install.
    """
    try:
        return import_module(module)
    except (ImportError, OSError) as error:
        package = module.partition(".")[0]
        raise InputError(f"{purpose} needs the package {package}, {remedy(package, requirement, error)}") from error


def load_libusb() -> None:
    """Load a copy of libusb-1.0, which some packages are linked against and minimal systems lack. It must be loaded
    before them. If there is no copy, importing these packages raises an error that names the library."""
    with suppress(ImportError, OSError):
        library = import_module("libusb_package").get_library_path()
        if library is not None:
            ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)


def remedy(module: str, requirement: str, error: ImportError | OSError, libraries: Sequence[str] = ()) -> str:
    """Describe why a package cannot be imported, and what to install: the end of a sentence.

    Parameters
    ----------
    module, requirement : str
        As for `optional`.
    error : ImportError or OSError
        The error raised by the import.
    libraries : sequence of str
        System libraries that it is linked against, so that the message names all missing ones at once.
    """
    if isinstance(error, ModuleNotFoundError):
        if is_frozen():
            return f'which is not part of this app. Install ilf-studio for Python: pip install "{requirement}".'
        return f'which is not installed. Install it: pip install "{requirement}".'
    missing = _LIBRARY.findall(str(error))
    if missing and sys.platform.startswith("linux"):
        missing = list(dict.fromkeys([*missing, *missing_libraries(libraries)]))
        return f"which cannot be loaded because system libraries are missing: {how_to_install(missing)}."
    return f"which cannot be loaded ({error}). Install what this message names, or reinstall {module}."


def missing_libraries(libraries: Sequence[str]) -> list[str]:
    """Return those libraries that cannot be loaded here."""
    missing = []
    for library in libraries:
        try:
            ctypes.CDLL(library)
        except OSError:
            missing.append(library)
    return missing


def how_to_install(libraries: Sequence[str]) -> str:
    """Format a list of libraries with the command that installs their packages, for a message.

    Examples
    --------
    >>> how_to_install(["libX11.so.6", "libEGL.so.1"])
    'libX11.so.6, libEGL.so.1. On Debian or Ubuntu: sudo apt install libx11-6 libegl1'
    """
    packages = dict.fromkeys(map(system_package, libraries))
    return f"{', '.join(libraries)}. On Debian or Ubuntu: sudo apt install {' '.join(packages)}"


def system_package(library: str) -> str:
    """The package of Debian and Ubuntu with a shared library: name and version, with a hyphen between digits."""
    name, _, version = library.lower().partition(".so.")
    return _OTHER_PACKAGES.get(library) or f"{name}{'-' * name[-1].isdigit()}{version}"


def check_opencv() -> None:
    """Raise InputError if a package of OpenCV 4 has replaced the files of OpenCV 5, which both install into `cv2`."""
    loaded = str(import_module("cv2").__version__)
    if int(loaded.partition(".")[0]) < 5:
        raise InputError(
            f"OpenCV {loaded} has replaced OpenCV 5. Uninstall opencv-python and opencv-contrib-python, and then: "
            "pip install --force-reinstall --no-deps opencv-python-headless"
        )


# Bundled files.

_PACKAGE = Path(__file__).parents[1]

# an installed package contains its assets, a checkout has them beside the package
_ROOTS = (_PACKAGE / "assets", _PACKAGE.parent / "assets")


def asset_path(name: str) -> Path:
    """Return the path of a bundled file or folder.

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
    raise InputError(f"The bundled {name} is not part of this installation. Reinstall ilf-studio.")


def is_asset(path: str | os.PathLike[str]) -> bool:
    """Whether a path lies among the program's own assets."""
    return any(root in Path(path).parents for root in _ROOTS)


# Folders of the user.


def user_path(kind: str, name: str, variable: str = "") -> Path:
    """Return a path in a folder of the user, which may not exist yet.

    Parameters
    ----------
    kind : str
        Of what the folder is for: "cache", "config", "data", "log" or "state".
    name : str
        Name of the file or folder in it.
    variable : str
        Environment variable whose path takes precedence.
    """
    import platformdirs  # not before: children start without it

    folder = getattr(platformdirs, f"user_{kind}_path")("ilf-studio", appauthor=False)
    return Path(os.environ.get(variable) or folder / name)


# Starting this program from itself.


_CHILDREN = f"{__package__}.children"
"""The module with the `main` of a child."""


def child_command() -> list[str]:
    """Return the command that starts a child: by the Python interpreter, or by this program itself if it is frozen."""
    if is_frozen():
        return [sys.executable, _CHILD]
    # -P: do not import modules from the current folder
    return [sys.executable, "-P", "-c", f"from {_CHILDREN} import main; main()"]


def run_if_child() -> None:
    """Do the work of a child if this is a frozen program started as one, and do not return. Every entry point calls
    this first."""
    if is_frozen() and sys.argv[1:2] == [_CHILD]:
        import_module(_CHILDREN).main()


def is_frozen() -> bool:
    """Whether a packager, such as PyInstaller, has bundled this program with Python."""
    return bool(getattr(sys, "frozen", False))


# The version, defined only here.

__version__ = "0.3.0.dev0"
