"""Base of all bundled and imported networks: ONNX files run by ONNX Runtime, from any thread."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, suppress
from functools import cache, partial
from pathlib import Path
from threading import Lock
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError, InputError, told_as
from ..files import read_file
from ..installation import asset_path
from ..memory import memory_limit
from .models import models_folder
from .session import RefusedInputError, Session, device, runtime_version

Shapes = dict[str, tuple[int, ...]]
"""Shapes of a network's inputs, by name."""

# Networks of users are tried in a child first, and with every size of images, since they can crash the program.

_TRIED = ".tried"
"""Folder beside the user's own networks, with an empty file for each trial that was passed."""

TRIAL_S, _LONGEST_TRIAL_S = 30.0, 3600.0
"""Time limits of a trial with small images and with others [s]."""

_READ_BYTES_PER_S = 4_000_000
"""Rate at which the slowest computers read a network for its trial."""

_tried: set[str] = set()


def is_bundled(sha256: str) -> bool:
    """Whether a network with this content is bundled."""
    return sha256 in _bundled()


def tried_once(trial: Callable[[], object], *what: str) -> None:
    """Call a function, unless it was called for the same before, with this version of ONNX Runtime on this device, by
    this process or an earlier one, and raised no exception."""
    name = "-".join((*what, runtime_version(), device()))
    mark = models_folder() / _TRIED / name
    if name in _tried or mark.exists():
        return
    trial()
    _tried.add(name)
    with suppress(OSError):  # then the next process tries it again
        mark.parent.mkdir(parents=True, exist_ok=True)
        mark.touch()


@cache
def _bundled() -> frozenset[str]:
    sums = asset_path("models/SHA256SUMS").read_text(encoding="ascii")
    return frozenset(line.split()[0] for line in sums.splitlines())


_networks: dict[tuple[type, Path, str], tuple[tuple[int, int], OnnxNetwork]] = {}
"""Kind, file and device -> version of the file, and the network."""

_networks_lock = Lock()


class OnnxNetwork:
    """A network, ready to run. Create one by `load`; it may be used from any thread."""

    KIND: ClassVar[str] = "edge network"
    """Name of this kind of network in messages."""

    INSTEAD: ClassVar[str] = ", or the Canny detector"
    """What can be chosen instead of a network of this kind, in messages."""

    def __init__(self, content: NDArray[np.uint8], path: Path) -> None:
        with self._intact(path):
            self._session = Session(content)
        self.path = path
        self.sha256 = hashlib.sha256(content.data).hexdigest()
        """Hash of the bytes that the network was read from, in hexadecimal digits."""
        self._untried: NDArray[np.uint8] | None = None
        """The content, if inputs of new sizes are tried in a child."""
        self._try()
        if not is_bundled(self.sha256):
            self._untried = content

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Load the network of a file, read once and cached until the file changes.

        Parameters
        ----------
        path : str or Path
            An ONNX file, as described by the class.

        Raises
        ------
        InputError
            If the file does not exist.
        FormatError
            If it is not an ONNX network, or not one of this kind.
        InstallationError
            As for `read`.
        """
        path = Path(path).resolve()
        if not os.path.isfile(path):
            raise InputError(f"There is no {cls.KIND} at {path}. Choose an ONNX file{cls.INSTEAD}.")
        status = path.stat()
        version = (status.st_mtime_ns, status.st_size)
        key = (cls, path, device())
        with _networks_lock:
            known = _networks.get(key)
            if known is None or known[0] != version:
                known = _networks[key] = (version, cls.read(read_file(path).data, path))
            assert isinstance(known[1], cls)
            return known[1]

    @classmethod
    def read(cls, content: NDArray[np.uint8], path: Path) -> Self:
        """Read the network in a file's content and test it with small images, without caching it.

        Networks not yet tried are first tried in a child, since they can crash the reader.

        Parameters
        ----------
        content : ndarray of uint8
        path : Path
            The file it comes from, for messages.

        Raises
        ------
        FormatError
            If it is not an ONNX network, not one of this kind, reads weights from other files, or crashes the reader.
        InstallationError
            If ONNX Runtime cannot be imported: then the file is not the cause, and no other detector is used instead.
        """
        sha256 = hashlib.sha256(content.data).hexdigest()
        if not is_bundled(sha256):
            cls._check_content(content, path)
            tried_once(partial(cls._try_in_child, content, path, {}), sha256, cls.__name__)
        return cls(content, path)

    @classmethod
    def _try_in_child(cls, content: NDArray[np.uint8], path: Path, shapes: Shapes) -> None:
        """Load a network in a child, which it may crash, and run it on empty images of these shapes."""
        from ..children import MEMORY, run_in_child  # not before: few networks are tried

        # a large one takes its time to reach the child, and is there several times while it is read
        seconds, memory = TRIAL_S + content.nbytes // _READ_BYTES_PER_S, MEMORY + 4 * content.nbytes
        doing = "running it"
        for *_, height, width in shapes.values():
            seconds, memory = _LONGEST_TRIAL_S, int(memory_limit())
            doing = f"running it on an image of about {width} x {height} pixels"
        run_in_child(cls._trial, content, path, shapes, file=path.name, seconds=seconds, memory=memory, doing=doing)

    @classmethod
    def _intact(cls, path: Path) -> AbstractContextManager[None]:
        """Within the block, a ValueError says that the file is no intact network."""
        remedy = f"Choose an intact ONNX file with its weights{cls.INSTEAD}."
        return told_as(FormatError, f"{path.name} cannot be read as an ONNX network. {remedy}", ValueError)

    @classmethod
    def _check_content(cls, content: NDArray[np.uint8], path: Path) -> None:
        """Raise FormatError for a network that makes the reader open other files."""
        from .protobuf import has_external_data

        with cls._intact(path):
            is_outside = has_external_data(content)
        if is_outside:
            raise FormatError(f"{path.name} reads weights from other files: not allowed. Export it as one file.")

    @classmethod
    def _trial(cls, content: NDArray[np.uint8], path: Path, shapes: Shapes) -> None:
        """Load the network, which runs it on small images, and run it on empty images of these shapes if there are
        any."""
        network = cls(content, path)
        with suppress(RefusedInputError):
            if shapes:
                network._results({name: np.zeros(shape, np.float32) for name, shape in shapes.items()})

    def _forward(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        """Return all outputs; raise RefusedInputError if the network does not accept these inputs, another FormatError
        if it crashes with inputs of their size. "" is the first input."""
        try:
            if self._untried is not None:
                shapes = {name: values.shape for name, values in inputs.items()}
                sizes = ("x".join(map(str, shape)) for shape in shapes.values())
                trial = partial(self._try_in_child, self._untried, self.path, shapes)
                tried_once(trial, self.sha256, type(self).__name__, *sizes)
            return self._results(inputs)
        except RefusedInputError as error:
            taken = " and ".join(str(values.shape) for values in inputs.values())
            raise RefusedInputError(self._unlike(f"it does not accept inputs of shape {taken}.")) from error

    def _results(self, inputs: dict[str, NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        named = {name or self._session.first_input: values for name, values in inputs.items()}
        return self._session.run(named, keep_memory=self._untried is None)  # those of users may need gigabytes

    def _unlike(self, why: str) -> str:
        """The message of an error: the network is not of this kind."""
        return f"{self.path.name} is not a{'n' * (self.KIND[0] in 'aeiou')} {self.KIND}: {why}"

    def _try(self) -> None:
        """Raise FormatError for a network that is not of this kind, before it is used."""
        raise NotImplementedError


def trial_images() -> Iterator[NDArray[np.uint8]]:
    """Yield the small images with which networks are tried."""
    for height, width in ((64, 64), (64, 96)):
        yield np.linspace(0, 255, height * width * 3).astype(np.uint8).reshape(height, width, 3)


def reflected(
    image: NDArray[np.generic], multiple: int, margin: int = 0, axis: int = 0
) -> tuple[NDArray, tuple[slice, slice]]:
    """Pad an image by reflection at its borders, to sides that are multiples of a number.

    Parameters
    ----------
    image : ndarray, shape (..., H, W, ...)
    multiple : int
    margin : int
        Minimum padding on every side [px].
    axis : int
        The axis of the rows; the next is that of the columns.

    Returns
    -------
    padded : ndarray
        The image itself if nothing is to be padded.
    window : (slice, slice)
        Rows and columns of the image within the padded one.
    """
    height, width = image.shape[axis : axis + 2]
    sides = (length + 2 * margin for length in (height, width))
    after = (side + -side % multiple - margin - length for side, length in zip(sides, (height, width), strict=True))
    added = np.zeros((image.ndim, 2), int)
    added[axis : axis + 2] = [(margin, size) for size in after]
    padded = np.pad(image, added, mode="reflect") if added.any() else image
    return padded, (slice(margin, margin + height), slice(margin, margin + width))


def as_input(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Convert an RGB image (H, W, 3) to the input of a network, in [0, 1], shape (1, 3, H, W)."""
    return np.moveaxis(image.astype(np.float32) * np.float32(1 / 255), 2, 0)[None]
