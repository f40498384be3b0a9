"""Frames and results as a data set of PyTorch. It needs PyTorch: pip install "ilf-studio[torch]"."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ._runtime.installation import optional
from .run.frame_arrays import FrameArrays
from .sources.source import Source

torch = optional("torch", "ilf-studio[torch]", "ilf.torch")
if TYPE_CHECKING:
    from torch.utils.data import Dataset
else:
    Dataset = optional("torch.utils.data", "ilf-studio[torch]", "ilf.torch").Dataset


class FrameDataset(FrameArrays, Dataset[Any]):
    """Frames of a source, or results, as a map-style data set for `torch.utils.data.DataLoader`.

    An item is a dict of new, writable tensors. H and W are the size of its frame; NaN is missing depth.

    | field | tensor | frames | results |
    |---|---|---|---|
    | `rgb` | uint8 (3, H, W) | yes | yes |
    | `depth_in` | float32 (1, H, W) [m]: before completion | yes | with expected errors, in the mode "fill" |
    | `mask` | bool (1, H, W): whether depth was measured | yes | with expected errors |
    | `ground_truth` | float32 (1, H, W) [m] | if the frame has it | no |
    | `depth` | float32 (1, H, W) [m]: after completion | no | yes |
    | `expected_error` | float32 (1, H, W) [m], NaN where depth was not filled | no | if it was written |
    | `unsupported` | bool (1, H, W): the expected error is not reliable | no | if it was written |
    | `K` | float32 (3, 3) [px], all NaN if it is not known | yes | yes |
    | `pose` | float32 (4, 4), camera to world, all NaN if it is not known | yes | yes |
    | `key` | str, from `keys` | yes | yes |

    The first item is read at once, and the others when they are asked for. Data loaders may use workers, started by
    fork or spawn: no file stays open. Frames of different sizes need a `transform` or a `collate_fn` to be batched.

    Parameters
    ----------
    source : path-like or Source
        A folder with results (of `ilf complete`, `ilf batch --out` or `ilf batch --shards`), whose items are these
        results; else anything that `ilf.open_source` opens, or a Source, whose items are the measured frames.
    fields : sequence of str, optional
        Names of the fields to read; others cost no time. None reads all that the first item has.
    transform : callable, optional
        Function from an item to what the data set returns. For workers started by spawn it must be picklable.

    Attributes
    ----------
    keys : tuple of str
        One for each item: keys of the source or the shards, or names of the folders with results.
    fields : tuple of str
        What the items contain.

    Raises
    ------
    InputError
        If there are no frames, or the first one cannot be read or lacks one of the fields; from an item, if it cannot
        be read or lacks a field that the first one has.
    FormatError
        If a file is damaged.
    ParameterError
        If there is no such field.
    """

    def __init__(
        self,
        source: str | os.PathLike[str] | Source,
        fields: Sequence[str] | None = None,
        transform: Callable[[dict[str, Any]], Any] | None = None,
    ) -> None:
        super().__init__(source, fields)
        self.transform = transform

    def __getitem__(self, number: int) -> Any:
        arrays = super().__getitem__(number)
        item = {name: one if isinstance(one, str) else torch.from_numpy(one) for name, one in arrays.items()}
        return item if self.transform is None else self.transform(item)
