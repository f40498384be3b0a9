"""Importing a user's own edge network: HED's weights, or any ONNX network from one image to its edges."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError, InputError
from ...extras import optional
from ...io.atomic import write_bytes
from ...io.files import read_file
from ...io.folders import made_folder
from ...models import name_from, new_model_path
from ..network import EdgeNetwork, OutOfRange
from .caffe import read_caffemodel
from .foreign import image_input, with_input, with_sigmoid
from .keras import read_keras_weights
from .layers import check_layers
from .normalisation import INPUTS

__all__ = ["INPUTS", "add_model"]

_ONNX, _CAFFE, _KERAS = _SUFFIXES = (".onnx", ".caffemodel", ".h5")
_AS_IT_IS = "rgb"


def add_model(
    file: str | os.PathLike[str],
    name: str | None = None,
    *,
    inputs: str = "rgb",
    logits: bool = False,
    replace: bool = False,
) -> Path:
    """Turn a file into an edge network as `EdgeNetwork` describes it, try it, and add it to the user's own.

    Parameters
    ----------
    file : str or path
        An ONNX network (.onnx), or the weights of HED of Caffe (.caffemodel) or Keras (.h5).
    name : str, optional
        By which it is chosen; made from the file's name if left out.
    inputs : str
        What an ONNX network takes: one of `INPUTS`.
    logits : bool
        Whether an ONNX network lacks the sigmoid at its end.
    replace : bool
        Whether it may take the place of one of the user's own of the same name.

    Returns
    -------
    Path
        The ONNX file. Nothing is written unless the network works.

    Raises
    ------
    InputError
        If there is no such file, the name cannot be used, or a package that the conversion needs is missing.
    FormatError
        If the file is no edge network.
    ExportError
        If it cannot be written.
    """
    source = Path(file)
    target = new_model_path(name_from(source) if name is None else name, replace)
    content = _converted(source, inputs, logits)
    made_folder(target.parent)
    write_bytes(target, content.tobytes())
    return target


def _converted(source: Path, inputs: str, logits: bool) -> NDArray[np.uint8]:
    """The content of a file of this library's convention, which has been tried."""
    suffix = source.suffix.lower()
    if suffix not in _SUFFIXES:
        raise FormatError(f"{source} is of no known format. Choose a file of {', '.join(_SUFFIXES)}.")
    if inputs not in INPUTS:
        raise InputError(f"The input of a network is one of {', '.join(INPUTS)}, not {inputs!r}.")
    content = read_file(source).data
    if suffix == _ONNX:
        return _from_onnx(content, source, inputs, logits)
    if inputs != _AS_IT_IS or logits:
        raise InputError(f"--input and --logits are for ONNX networks; {source.name} needs neither.")
    return _from_hed(content, source, caffe=suffix == _CAFFE)


def _from_hed(content: NDArray[np.uint8], source: Path, caffe: bool) -> NDArray[np.uint8]:
    layers = (read_caffemodel if caffe else read_keras_weights)(content, source.name)
    check_layers(layers, source.name)
    _need_onnx()
    from .hed import hed_network

    content = np.frombuffer(hed_network(layers, caffe), np.uint8)
    EdgeNetwork.read(content, source)
    return content


def _from_onnx(content: NDArray[np.uint8], source: Path, inputs: str, logits: bool) -> NDArray[np.uint8]:
    image = image_input(content, source.name)
    if inputs != _AS_IT_IS or logits:
        _need_onnx()
    if inputs != _AS_IT_IS:
        content = with_input(content, source.name, inputs)
    try:
        if logits:
            _refuse_range(content, source)
            content = with_sigmoid(content, source.name)
        EdgeNetwork.read(content, source)
    except OutOfRange:
        raise
    except FormatError as error:
        if image.fixed_size:
            raise FormatError(
                f"{source.name} takes images of {image.fixed_size} only, but edges are needed of images of any size. "
                "Export it with free height and width."
            ) from error
        raise
    return content


def _refuse_range(content: NDArray[np.uint8], source: Path) -> None:
    """Refuse a network that ends with a sigmoid where it is said that it does not."""
    try:
        EdgeNetwork.read(content, source)
    except OutOfRange:
        return
    raise InputError(f"The output of {source.name} is within 0 to 1 as it is. Import it without --logits.")


def _need_onnx() -> None:
    optional("onnx", "models", "Converting a network")
