"""Which borders of blocks were drawn by hand, and what an edit makes of that.

A *border link* joins two neighbours, along a row or a column, of different labels. A pixel of a block is drawn if one
of its border links was made by an edit; to the filter, all of its border links are then drawn.
"""

from __future__ import annotations

import numpy as np

from ..blocks import Box, within
from .edit.patches import LabelPatch, Labels, Mask, grown


def border_pixels(labels: Labels, box: Box | None = None) -> Mask:
    """Pixels of blocks that have a 4-neighbour of another label.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        0 = no block.
    box : tuple of slice, optional
        Rows and columns to look at; all if left out.

    Returns
    -------
    ndarray of bool
        In the shape of the box. Neighbours outside it count as well.

    Examples
    --------
    >>> border_pixels(np.array([[1, 1, 2, 0]])).tolist()
    [[False, True, True, False]]
    """
    if box is None:
        box = slice(0, labels.shape[0]), slice(0, labels.shape[1])
    around = grown(box, 1, labels.shape)
    seen = labels[around]
    return (_ends(*_border_links(seen)) & (seen > 0))[within(box, around)]


def redrawn(drawn: Mask | None, labels: Labels, patch: LabelPatch) -> tuple[Box, Mask]:
    """What an edit makes of the drawn pixels.

    A pixel is drawn afterwards if it belongs to a block and has a border link that was none before the edit, or if it
    was drawn and still has one.

    Parameters
    ----------
    drawn : ndarray of bool, shape (H, W), or None
        The drawn pixels before; None if there are none.
    labels : ndarray of int32, shape (H, W)
        The label map, before the patch is applied or after.
    patch : LabelPatch
        The edit.

    Returns
    -------
    tuple of slice
        Rows and columns in which pixels may have changed: those of the patch, and one more on every side.
    ndarray of bool
        The drawn pixels there. Put in the place of the old ones, which make it undone.

    Examples
    --------
    >>> labels = np.array([[1, 1, 1, 2]], np.int32)
    >>> patch = LabelPatch((slice(0, 1), slice(1, 3)), labels[:, 1:3].copy(), np.array([[1, 2]], np.int32))
    >>> box, now = redrawn(None, labels, patch)
    >>> now.tolist()
    [[False, True, True, False]]
    """
    box = grown(patch.box, 1, labels.shape)
    around = grown(box, 1, labels.shape)
    before = labels[around].copy()
    after = before.copy()
    inside = within(patch.box, around)
    before[inside], after[inside] = patch.before, patch.after
    was, now = _border_links(before), _border_links(after)
    marked = _ends(now[0] & ~was[0], now[1] & ~was[1])
    if drawn is not None:
        marked |= drawn[around] & _ends(*now)
    return box, (marked & (after > 0))[within(box, around)]


def _border_links(labels: Labels) -> tuple[Mask, Mask]:
    """Which neighbours along rows, and along columns, have different labels."""
    return labels[:, 1:] != labels[:, :-1], labels[1:] != labels[:-1]


def _ends(along_rows: Mask, along_columns: Mask) -> Mask:
    """The pixels that such links join."""
    found = np.zeros((along_rows.shape[0], along_columns.shape[1]), bool)
    found[:, 1:] |= along_rows
    found[:, :-1] |= along_rows
    found[1:] |= along_columns
    found[:-1] |= along_columns
    return found
