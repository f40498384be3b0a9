"""The column *Error* of the block table: against ground truth, of a hold-out test that is valid, or as expected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from weakref import WeakKeyDictionary, WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from ilf.data.results import BlockResult
from ilf.evaluation.evaluation import Evaluation, evaluate_blocks

from ...base.needs import Need
from ...state.blocks import GROUND_TRUTH, HOLD_OUT, BlockErrors
from ...state.document import Document
from ...state.parts import Part
from ..context import Context, Feature
from .hold_out import HoldOutOutcome


class BlockErrorsFeature(Feature):
    """Keeps the errors of the blocks up to date."""

    what = "evaluation against ground truth"
    awaits = Need.RESULTS

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.outcomes: WeakKeyDictionary[Document, HoldOutOutcome] = WeakKeyDictionary()
        """The last hold-out test of each frame."""
        self._found: tuple[Document | None, Mapping[int, Evaluation]] = None, {}
        """The errors against ground truth, and their frame."""
        self._of: NDArray[np.float32] | None = None
        self._expected = BlockErrors()
        """Expected errors of the blocks, from the expected error `_of`."""
        self._results: WeakValueDictionary[int, BlockResult] = WeakValueDictionary()
        """The results that `_expected` belongs to."""
        changed = Part.FRAME | Part.LABELS | Part.RESULTS | Part.GROUND_TRUTH
        context.refresh.add("errors against ground truth", self._ask, changed, Part.SOME_RESULTS)
        context.refresh.add(
            "block errors",
            self._show,
            changed | Part.INVALID_MASK | Part.GUIDE | Part.NEIGHBOURS | Part.PARAMETERS | Part.EXPECTED_ERROR,
        )

    def _ask(self) -> None:
        """Have the current results evaluated, if there is ground truth."""
        document = self.context.workspace.current if self.context.workspace.has_current else None
        completion = None if document is None or document.frame.ground_truth is None else document.completion()
        if document is None or completion is None:
            self.requests.forget()
            self._found = None, {}
        else:
            frame, labels = document.frame, document.labels.copy()
            self.requests.ask(lambda: evaluate_blocks(frame, completion, labels), partial(self._take, document))

    def _take(self, document: Document, found: Mapping[int, Evaluation]) -> None:
        self._found = document, found
        self.context.refresh.mark("block errors")

    def _show(self) -> None:
        """Give the errors to the table of blocks."""
        workspace = self.context.workspace
        if not workspace.has_current:
            return
        document = workspace.current
        outcome = self.outcomes.get(document)
        if document.frame.ground_truth is not None:
            of, found = self._found
            of_document = found if of is document else {}
            rmse = {label: evaluated.rmse for label, evaluated in of_document.items() if evaluated.pixels}
            errors = BlockErrors(GROUND_TRUTH, rmse)
        elif outcome is not None and (held_out := outcome.errors_of(document)):
            errors = BlockErrors(HOLD_OUT, held_out)
        else:
            errors = self._as_expected(document)
        document.set_block_errors(errors)

    def _as_expected(self, document: Document) -> BlockErrors:
        """Return the expected errors; until they are computed again, those of the blocks with unchanged results."""
        error, results = document.expected_error(), document.valid_results()
        if error is None:
            same = {label for label, result in results.items() if self._results.get(label) is result}
            kept = {label: rmse for label, rmse in self._expected.rmse.items() if label in same}
            return replace(self._expected, rmse=kept) if kept else BlockErrors()
        if error is not self._of:
            self._of, self._results = error, WeakValueDictionary(results)
            self._expected = BlockErrors.expected(error, document.labels)
        return self._expected
