"""Finding the kind of recording at a path, and a cache of open recordings."""

from __future__ import annotations

import os
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import cache
from pathlib import Path

from .._runtime.addresses import Address
from .._runtime.files import is_address, open_file
from .._runtime.folders import folder_at
from .._runtime.plugins import named_in_errors
from ..errors import FormatError, InputError
from ..io.kinds import check_is_there
from .copies import forget_recording, has_copy, recording_copy, reported, spelled
from .frame_folder import is_frame_folder
from .frame_ref import is_shards
from .naming import CALIBRATION_NAME
from .plugins import source_plugins
from .recording import Recording

_MAX_OPEN = 2

_access = threading.RLock()
_open: OrderedDict[tuple[int, str, tuple[int, ...]], Recording] = OrderedDict()


@cache
def built_in_kinds() -> tuple[type[Recording], ...]:
    """The built-in kinds, in the order in which they are tried, before those of plugins. They are imported when they
    are asked for the first time: frames of image files need none of them."""
    from .arkit_scenes import ARKitScenes
    from .azure_kinect import AzureKinect
    from .nyu import NyuLabelled, NyuRawFolder
    from .raw_pairs import RawPairs
    from .record3d import Record3D
    from .ros import RosBag
    from .scannet import ScanNet
    from .shards import Shards
    from .stray_scanner import StrayScanner

    return (
        *(RosBag, AzureKinect, Record3D, ScanNet, NyuLabelled),
        *(StrayScanner, ARKitScenes, NyuRawFolder, RawPairs, Shards),
    )


def kind_of(path: Path) -> type[Recording] | None:
    """The kind of recording at a path, by file names alone; None if there is none."""
    try:
        built_in = next((kind for kind in built_in_kinds() if kind.fits(path)), None)
    except (OSError, ValueError, InputError):  # no file can have that name, or it cannot be looked at
        return None
    return built_in or source_plugins().kind_of(path)


def is_recording(path: str | os.PathLike[str]) -> bool:
    """Whether there is a recording at a path, or at an address that is a file or has shards, by file names alone."""
    if is_address(path):
        return _is_recording_file(Address(path)) or is_shards(path)
    if is_frame_folder(path) and not os.path.isfile(os.path.join(path, CALIBRATION_NAME)):
        return False
    return kind_of(Path(path)) is not None


def _is_recording_file(address: Address) -> bool:
    return address.suffix.lower() in recording_suffixes()


def recording_suffixes() -> tuple[str, ...]:
    """Extensions of recordings."""
    return tuple(suffix for kind in (*built_in_kinds(), *source_plugins().kinds) for suffix in kind.suffixes)


@contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[Recording]:
    """Open a recording for reading, one thread at a time; it stays open for later calls.

    Raises
    ------
    InputError
        If there is none, or it cannot be read.
    FormatError
        If it is damaged.
    """
    if is_address(path):
        with _opened_at(Address(path)) as recording:
            yield recording
        return
    found = Path(path).absolute()
    kind = kind_of(found)
    if kind is None:
        if not os.path.lexists(found):
            raise InputError(f"{found}: there is no such recording. Check the name.")
        told = f"{found} is not a recording: recordings end in {', '.join(recording_suffixes())}, or are folders of "
        told += "ROS 2, Stray Scanner, ARKitScenes, NYU's raw frames, raw pairs with a calibration.json, or shards."
        raise InputError(source_plugins().with_notes(told))
    with _access:
        if found.is_file():
            open_file(found).close()
            if found.stat().st_size == 0:
                raise FormatError(f"{found} is empty (0 bytes). Copy or export it again.")
        check_is_there(found)
        plugin = source_plugins().kinds.get(kind) if kind not in built_in_kinds() else None
        with named_in_errors(plugin) if plugin else nullcontext():
            yield _kept((os.getpid(), str(found), kind.state(found)), lambda: _open_kind(kind, found))


def _open_kind(kind: type[Recording], path: Path) -> Recording:
    if not kind.in_child:
        return kind(path)
    from .recording_in_child import RecordingInChild

    return RecordingInChild(kind, path)


def _kept(name: tuple[int, str, tuple[int, ...]], open_it: Callable[[], Recording]) -> Recording:
    """A recording that is open, or is opened and stays so."""
    recording = _open.pop(name, None) or open_it()
    _open[name] = recording
    while len(_open) > _MAX_OPEN:
        _open.popitem(last=False)[1].close()
    return recording


@contextmanager
def _opened_at(address: Address) -> Iterator[Recording]:
    """Open shards at an address, or the copy of a recording there; what is open counts as unchanged."""
    name = os.getpid(), str(address), ()
    with _access:
        is_file = _is_recording_file(address)
        if not is_file and not has_copy(address) and (name in _open or is_shards(address)):
            with reported():
                from .shards import Shards

                yield _kept(name, lambda: Shards(spelled(address), folder_at(address)))
            return
    with reported(), opened(recording_copy(address, is_file)) as recording:
        yield recording


def forget(address: Address) -> None:
    """Have shards or a recording at an address opened anew, since they may have changed."""
    with _access:
        if (recording := _open.pop((os.getpid(), str(address), ()), None)) is not None:
            recording.close()
        forget_recording(address)


def close_all() -> None:
    """Close all recordings, so that their files can be moved or deleted."""
    with _access:
        while _open:
            _open.popitem()[1].close()
