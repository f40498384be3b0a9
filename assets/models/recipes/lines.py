"""Measures of detected lines: average precision and best F over thresholds, with a tolerance in pixels."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

THRESHOLDS = np.linspace(0.02, 0.98, 33)


class LineScore:
    """Counts over pictures of correctly and wrongly detected line pixels.

    Parameters
    ----------
    tolerance : int
        Maximum offset [px] of a line, in rows and columns.
    """

    def __init__(self, tolerance: int = 1) -> None:
        self._square = np.ones((2 * tolerance + 1,) * 2, np.uint8)
        # rows: detected and right, detected, true and detected, true
        self._counts = np.zeros((4, THRESHOLDS.size), np.int64)

    def add(self, strength: NDArray[np.float32], ground_truth: NDArray[np.bool_], where: NDArray[np.bool_]) -> None:
        """Count the pixels of one picture inside `where`; they may be matched with neighbours outside."""
        ridge = _ridges(strength)
        near_ground_truth = cv2.dilate(ground_truth.view(np.uint8), self._square) > 0
        true = ground_truth & where
        for k, threshold in enumerate(THRESHOLDS):
            line = ridge & (strength >= threshold)
            near_line = cv2.dilate(line.view(np.uint8), self._square) > 0
            found = line & where
            self._counts[:, k] += [
                np.count_nonzero(one) for one in (found & near_ground_truth, found, true & near_line, true)
            ]

    @property
    def true(self) -> int:
        """Number of counted pixels of true lines."""
        return int(self._counts[3, 0])

    @property
    def precision_recall(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Both at each of `THRESHOLDS`; precision is 1 where nothing is detected."""
        right, found, seen, true = self._counts
        return np.where(found > 0, right / np.maximum(found, 1), 1.0), seen / np.maximum(true, 1)

    @property
    def average_precision(self) -> float:
        """Area under precision over recall; beyond the largest recall, precision counts as 0."""
        precision, recall = self.precision_recall
        order = np.argsort(recall, kind="stable")
        best = np.maximum.accumulate(precision[order][::-1])[::-1]
        return float(np.sum(np.diff(recall[order], prepend=0) * best))

    @property
    def best_f(self) -> float:
        """Largest harmonic mean of precision and recall."""
        precision, recall = self.precision_recall
        return float(np.max(2 * precision * recall / np.maximum(precision + recall, 1e-9)))


def _ridges(strength: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Pixels as strong as both neighbours along their row or their column."""
    padded = np.pad(strength, 1, constant_values=-1)
    centre = padded[1:-1, 1:-1]
    along_row = (centre >= padded[1:-1, :-2]) & (centre > padded[1:-1, 2:])
    along_column = (centre >= padded[:-2, 1:-1]) & (centre > padded[2:, 1:-1])
    return along_row | along_column
