"""Networks that predict guides: depth or inverse depth from colour, by a user's own ONNX file or by a name."""

from __future__ import annotations

import os
import shutil
import tomllib
from dataclasses import replace
from functools import cache
from importlib.resources import files
from pathlib import Path

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import existing_file, file_sha256, read_file, read_json
from .._runtime.networks.models import check_name, model_names, models_folder, name_from
from .._runtime.networks.network import OnnxNetwork, RefusedInputError, as_input
from .._runtime.schema import converted
from .._runtime.writing import atomic_path, ensure_folder, write_bytes
from ..data.guide import Gives, Guide, GuideCard
from ..errors import ExportError, FormatError, InputError, told_as
from .fetching import ROUNDED, Progress, fetch

_ANY = GuideCard("", "", "", "relative-inverse", 0)
"""The card of a network without one."""

_SIZES = ((518, 14), (384, 32))
"""Shorter side of the input [px] and the number that its sides are multiples of, where neither network nor card says:
those of vision transformers with patches of 14 px, then of networks that halve their input five times."""


class GuideNetwork(OnnxNetwork):
    """A network that predicts depth or inverse depth from colour, such as Depth Anything or MiDaS. `load` creates one.

    The file is an ONNX network with one input, RGB as float32 (1, 3, H, W), and an output that is any monotone function
    of depth, (1, H, W) or (1, 1, H, W), of any size. If the file fixes H and W, the image is resized to them. Its card
    states the rest; without one, the size is one of the usual, colour is normalised by the mean and the standard
    deviation of ImageNet's colours, and the output is the first.
    """

    KIND = "guide network"
    INSTEAD = ", or a file with the guide's values"

    def predict(self, rgb: NDArray[np.uint8], card: GuideCard = _ANY) -> NDArray[np.float32]:
        """Predict the values of a guide for an image.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (H, W, 3)
        card : GuideCard

        Returns
        -------
        ndarray of float32, shape (H, W)
            In any unit.

        Raises
        ------
        FormatError
            If the network does not accept an image, or its output is not one value per pixel.
        """
        height, width = rgb.shape[:2]
        refused: RefusedInputError | None = None
        for size in self._sizes(height, width, card):
            image = np.asarray(cv2.resize(rgb, size[::-1], interpolation=cv2.INTER_AREA), np.uint8)
            try:
                found = self._run(image, card)
            except RefusedInputError as error:
                refused = error
                continue
            return np.asarray(cv2.resize(found, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)
        raise self._takes_no_image() from refused

    def _sizes(self, height: int, width: int, card: GuideCard) -> list[tuple[int, int]]:
        """Heights and widths of the input to try for an image."""
        shape = self._session.first_shape
        if len(shape) == 4 and shape[2] and shape[3]:
            return [(shape[2], shape[3])]
        if card.size and not card.keep_aspect:
            return [(card.size, card.size)]
        return [
            (max(round(height * side / min(height, width) / step), 1) * step,
             max(round(width * side / min(height, width) / step), 1) * step)
            for side, step in ([(card.size, card.step)] if card.size else _SIZES)
        ]  # fmt: skip

    def _run(self, image: NDArray[np.uint8], card: GuideCard) -> NDArray[np.float32]:
        if card.output and card.output not in self._session.outputs:
            known = ", ".join(self._session.outputs)
            raise FormatError(f"{self.path.name} has no output {card.output}, only {known}. Correct its card.")
        mean, deviation = (np.array(of_rgb, np.float32).reshape(3, 1, 1) for of_rgb in (card.mean, card.deviation))
        outputs = self._forward({"": (as_input(image) - mean) / deviation})
        output = outputs[self._session.outputs.index(card.output) if card.output else 0]
        if output.ndim < 2 or output.size != output.shape[-2] * output.shape[-1] or min(output.shape[-2:]) < 2:
            raise FormatError(self._unlike(f"its output is {output.shape}, not one value per pixel."))
        if not np.isfinite(output).all():
            raise FormatError(f"{self.path.name} returns values that are not finite for this frame.")
        return output.reshape(output.shape[-2:])

    def _try(self) -> None:
        """The network may be large: only its input is looked at, and `predict` tells the rest."""
        shape = self._session.first_shape
        if len(shape) != 4 or shape[1] not in {3, None}:
            raise self._takes_no_image()

    def _takes_no_image(self) -> FormatError:
        return FormatError(self._unlike("it does not accept one RGB image of shape (1, 3, height, width)."))


def predict_guide(path: Path, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Predict the values of a guide, float32 (H, W), by the network in a file; the network is cached until the file
    changes.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is no such network.
    """
    return GuideNetwork.load(path).predict(rgb)


# Networks by name: their cards, and their files in the user's folder.


def guides_folder() -> Path:
    """The folder of the networks, each NAME.onnx with its card NAME.json, which may not exist yet."""
    return models_folder() / "guides"


@cache
def _known() -> dict[str, GuideCard]:
    table = tomllib.loads((files(__package__) / "guide_models.toml").read_text(encoding="utf-8"))
    return {name: msgspec.convert({"name": name, **facts}, GuideCard) for name, facts in table.items()}


def guide_cards() -> tuple[dict[str, GuideCard], dict[str, FormatError]]:
    """The cards of the networks that the program knows, then of the user's own, with the hashes that were pinned; and
    the errors of those in the user's folder that cannot be read, both by the names of the networks."""
    cards, damaged = dict(_known()), {}
    for path in sorted(guides_folder().glob("*.json")):
        try:
            own = replace(converted(read_json(path), GuideCard, f"card {path}"), name=path.stem)
        except FormatError as error:
            damaged[path.stem] = FormatError(f"{error} Delete this card, and add or fetch its network again.")
            cards.pop(path.stem, None)  # it is not used without the hash that was pinned
            continue
        known = cards.get(own.name, own)
        cards[own.name] = known if known.sha256 else replace(known, sha256=own.sha256, bytes=own.bytes)
    return cards, damaged


def guide_card(name: str) -> GuideCard:
    """The card of a network; raises InputError if there is none of this name, FormatError if it is damaged."""
    cards, damaged = guide_cards()
    if name in damaged:
        raise damaged[name]
    if name not in cards:
        known = f"There is no guide network {name!r}, only {', '.join(cards)}"
        raise InputError(f"{known}. Choose one of these, or add one: ilf models add FILE --gives affine-inverse.")
    return cards[name]


def is_guide_name(text: object) -> bool:
    """Whether a guide is given by the name of a network; a file of that name comes first."""
    return isinstance(text, str) and not os.path.exists(text) and any(text in cards for cards in guide_cards())


def guide_file(name: str) -> Path | None:
    """The file of a network; None if it was neither fetched nor added."""
    path = guides_folder() / f"{name}.onnx"
    return path if path.is_file() else None


def fetch_guide(name: str, progress: Progress | None = None) -> Path:
    """Fetch the file of a network from its address, unless it is there already. It is only done when it is called.

    Parameters
    ----------
    name : str
        One of `guide_cards`.
    progress : callable, optional
        Called with the number of bytes that are here, and of all.

    Raises
    ------
    InputError
        If there is no such network, it has no address, the server cannot be reached, or has another file.
    FormatError
        If the file is not such a network.
    ExportError
        If it cannot be written.
    Cancelled
        If the work of this thread is cancelled; the next call continues where it ended.
    """
    card = guide_card(name)
    if (there := guide_file(name)) is not None:
        return there
    if not card.address:
        raise InputError(f"The guide network {name} has no address. Add its file: ilf models add FILE --name {name}.")

    target = guides_folder() / f"{name}.onnx"

    def accept(file: Path, sha256: str) -> None:
        if card.sha256 is None:
            GuideNetwork.read(read_file(file).data, target)
        _pin(card, file, sha256)

    fetch(card.address, target, card.bytes, card.sha256, progress, accept)
    return target


def is_guide_file(file: str | os.PathLike[str], name: str | None = None) -> bool:
    """Whether a file is to be that of a known network, by its name or by its content; raises InputError if there is no
    such file."""
    sha256 = file_sha256(existing_file(file))
    return name in _known() or any(card.sha256 == sha256 for card in _known().values())


def add_guide(
    file: str | os.PathLike[str], name: str | None = None, gives: Gives = "relative-inverse", *, again: bool = False
) -> Path:
    """Add the file of a network that was copied to this computer: of a known one, or of one of the user's own.

    Parameters
    ----------
    file : path-like
        ONNX, see `GuideNetwork`.
    name : str, optional
        Its name; by default that of the known network with this file, otherwise made from the file's name.
    gives : str
        What a network that is not known predicts, see `Gives`.
    again : bool
        Whether it may replace a network of the same name.

    Raises
    ------
    InputError
        If there is no such file, the name cannot be used, or the known network of this name has another file.
    FormatError
        If the file is not a guide network.
    ExportError
        If it cannot be written.
    """
    source = existing_file(file)
    sha256 = file_sha256(source)
    name = name or next((card.name for card in _known().values() if card.sha256 == sha256), name_from(source))
    card = (_known()[name] if again else guide_card(name)) if name in _known() else None
    if card is None:
        check_name(name)
        card = GuideCard(name, "your own", "", gives, source.stat().st_size)
    elif card.sha256 not in {None, sha256} or abs(source.stat().st_size - card.bytes) > ROUNDED * card.bytes:
        told = f"{source} is not the file of the guide network {name}, by its size or its SHA-256"
        raise InputError(f"{told}. Copy that of {card.address}, or rename the file (command line: --name).")
    if name in model_names() or (guide_file(name) is not None and not again):
        other = "Rename the file (command line: --name, or --replace)."
        raise InputError(f"A network {name!r} already exists. {other}")
    GuideNetwork.read(read_file(source).data, source)
    target = ensure_folder(guides_folder()) / f"{name}.onnx"
    _pin(card, source, sha256)
    with atomic_path(target) as temporary:
        shutil.copyfile(source, temporary)
    return target


def remove_guide(name: str) -> Path:
    """Delete the file of a network; a known one keeps the hash that was pinned, so that no other file takes its place.

    Raises
    ------
    InputError
        If it is not on this computer.
    ExportError
        If it cannot be deleted.
    """
    path = guide_file(name)
    if path is None:
        raise InputError(f"The guide network {guide_card(name).name} is not on this computer.")
    with told_as(ExportError, f"{path} cannot be removed: {{error}}. Check the folder's permissions.", OSError):
        path.unlink()
        if name not in _known():
            path.with_suffix(".json").unlink(missing_ok=True)
    return path


def ready_guide(name: str, gives: Gives | None = None) -> tuple[GuideCard, Path]:
    """The card and the file of a network; raises InputError if there is none, it is not on this computer, or gives
    something else."""
    card, path = guide_card(name), guide_file(name)
    if gives not in {None, card.gives}:
        raise InputError(f"The guide network {name} gives {card.gives}, not {gives}. Leave --guide-gives out.")
    if path is None:
        fetch_it = f"Fetch its {card.bytes / 1e6:.0f} MB (licence {licence_text(card)}): ilf models fetch {name}."
        raise InputError(f"The guide network {name} is not on this computer. {fetch_it}")
    return card, path


def predict_by_name(name: str, rgb: NDArray[np.uint8]) -> Guide:
    """Predict a guide for an image by a network that is on this computer.

    Raises
    ------
    InputError
        If there is no such network, it has not been fetched, or its file is not the one that was.
    FormatError
        If it is no such network.
    """
    card, path = ready_guide(name)
    network = GuideNetwork.load(path)
    if network.sha256 != card.sha256:
        remedy = f"Remove it, and fetch it again: ilf models remove {name}."
        raise InputError(f"{path} is not the file that was fetched or added. {remedy}")
    return Guide(network.predict(rgb, card), path=str(path), network=card)


def state_of(card: GuideCard) -> str:
    """Whether the file of a network is on this computer, in a word or two."""
    if guide_file(card.name) is not None:
        return "ready"
    return "not fetched" if card.address else "file missing"


def licence_text(card: GuideCard) -> str:
    """The licence of a network, with what it does not permit."""
    return f"{card.licence}, {card.terms}" if card.terms else card.licence or "of your own"


def _pin(card: GuideCard, file: Path, sha256: str) -> None:
    """Write the card of a network beside its place in the user's folder, with the size and the hash of its file."""
    pinned = replace(card, sha256=sha256, bytes=file.stat().st_size)
    write_bytes(guides_folder() / f"{card.name}.json", msgspec.json.format(msgspec.json.encode(pinned)))
