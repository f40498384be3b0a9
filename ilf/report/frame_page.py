"""The part of a report on one frame, and its row in the index."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .._runtime.cancellation import cancellable_items
from .._runtime.formatting import grouped, millimetres
from ..completion.completion import guide_text
from ..completion.confidence.expected_error import MEDIAN_NAME, RMS_NAME, error_summary, expected_error, summarised
from ..data.blocks import own_values
from ..data.camera import camera_text
from ..data.parameters import BlockParameters, Parameters, nearest_preset
from ..data.results import BlockResult, Status, blocks_by_message
from ..evaluation.evaluation import Evaluated
from ..evaluation.hold_out import HoldOutResult, untrusted_note
from ..io.encodings import encoding_of_inputs
from ..run.options import ExportOptions
from ..run.record import make_record
from .curves import curve_lines, curve_plots
from .evaluations import against_ground_truth, on_hold_out, p95
from .pictures import frame_pictures, thumbnail
from .replay_command import replay_text
from .subject import Subject
from .templates import render

GROUND_TRUTH = "Against ground truth"
_THUMBNAIL = 240


class FramePage:
    """The figures of a frame, and the parts of a report that show them.

    Parameters
    ----------
    subject : Subject
    hidden : HoldOutResult, optional
        The evaluation on hold-out, if there is one.
    """

    def __init__(self, subject: Subject, hidden: HoldOutResult | None = None) -> None:
        self._subject, self._hidden = subject, hidden
        self._expected: NDArray[np.float32] = expected_error(subject.completion)
        self._evaluations = self._evaluate()
        pixels = np.bincount(subject.run.blocks.labels.ravel())
        known = np.bincount(subject.run.blocks.labels[~subject.run.frame.missing], minlength=pixels.size)
        self._blocks = {
            int(label): (int(pixels[label]), 1 - known[label] / pixels[label])
            for label in np.flatnonzero(pixels)
            if label
        }
        """Label -> number of pixels, and share of them without measured depth."""

    def html(self, id: str, most: int) -> str:
        """Return the frame's part of the page; its pictures have at most `most` pixels on the longer side."""
        subject, run, completion = self._subject, self._subject.run, self._subject.completion
        lines, record = curve_lines(subject), make_record(run, completion, ExportOptions())
        return render(
            "frame.html",
            id=id,
            subject=subject,
            run=run,
            frame=run.frame,
            completion=completion,
            summary=self._summary(),
            pictures=cancellable_items(frame_pictures(subject, self._expected, self._hidden, most)),
            evaluations=self._evaluations,
            p95=p95,
            untrusted=untrusted_note(run.frame) if self._hidden else "",
            blocks=self._blocks,
            expected_of=self._expected_of,
            faults=blocks_by_message(
                outcome
                for outcome in completion.outcomes.values()
                if outcome.status in (Status.NOT_RECOVERABLE, Status.ITERATION_LIMIT)
            ),
            notes=list(dict.fromkeys([*run.blocks.notes, *completion.notes])),
            nearest=nearest_preset(run.parameters),
            filter_declarations=Parameters.declarations(),
            own={label: own_values(run.parameters_of(label), run.parameters) for label in sorted(run.blocks.own)},
            extraction_declarations=BlockParameters.declarations(),
            extraction={} if run.blocks.extraction is None else _effective_changes(run.blocks.extraction),
            iterated=sum(bool(len(result.history)) for result in completion.results.values()),
            lines=lines,
            plots=curve_plots(subject, lines),
            preset_of=nearest_preset,
            record=record,
            networks=record.networks.extraction | record.networks.filter,
            encoding_of=encoding_of_inputs,
            replay=("This command replays the runs and reports differences.", subject.again)
            if subject.again
            else replay_text(run),
        )

    def index_row(self, id: str) -> dict[str, str]:
        """Return the frame's row in the index: id, name, picture, and text by the column's heading."""
        frame, completion = self._subject.run.frame, self._subject.completion
        against = self._evaluations.get(GROUND_TRUTH)
        return {
            "id": id,
            "name": frame.name,
            "image": thumbnail(self._subject, _THUMBNAIL),
            "size [px]": f"{frame.shape[1]} × {frame.shape[0]}",
            "missing in": f"{frame.missing_share:.1%}",
            "missing out": f"{float(np.mean(frame.missing & np.isnan(completion.depth))):.1%}",
            "blocks": str(len(self._blocks)),
            "with result": str(len(completion.results)),
            f"{RMS_NAME} [mm]": millimetres(error_summary(self._expected, completion).rms),
            "ground truth [mm]": "" if against is None else millimetres(against.whole.rmse),
            "hold-out [mm]": "" if self._hidden is None else millimetres(self._hidden.whole.rmse),
            "note": self._subject.note,
        }

    def _evaluate(self) -> dict[str, Evaluated]:
        """Return all evaluations of the frame by their names."""
        run, completion = self._subject.run, self._subject.completion
        by_blocks = against_ground_truth(run, completion, completion.filled_by_blocks, self._expected)
        found = {} if by_blocks is None else {GROUND_TRUTH: by_blocks}
        if completion.extrapolated.any():
            whole = against_ground_truth(run, completion, completion.filled, self._expected)
            found |= {} if whole is None else {f"{GROUND_TRUTH}, including extrapolated pixels": whole}
        return found if self._hidden is None else found | on_hold_out(self._hidden)

    def _expected_of(self, result: BlockResult) -> float:
        """Return the RMS of the expected error [m] over the pixels that a block has filled; NaN if there are none."""
        box = result.block.box
        return summarised(self._expected[box][result.block.mask & self._subject.completion.filled_by_blocks[box]]).rms

    def _summary(self) -> dict[str, str]:
        frame, completion = self._subject.run.frame, self._subject.completion
        known = frame.depth[frame.own]

        def pixels(mask: NDArray[np.bool_]) -> str:
            return f"{np.mean(mask):.1%} ({grouped(np.count_nonzero(mask))} pixels)"

        facts = {
            "Size": f"{frame.shape[1]} × {frame.shape[0]} px",
            "Camera": camera_text(frame.intrinsics),
            "Depth": f"{known.min():.2f} to {known.max():.2f} m, median {np.median(known):.2f} m",
            "Missing before": pixels(frame.missing & np.isnan(frame.own_depth)),
        }
        if frame.outside_view is not None:
            filled = np.count_nonzero(frame.outside_view & completion.filled)
            more = f", {grouped(filled)} of them filled" if filled else ""
            facts["Outside the depth camera's view"] = f"{pixels(frame.outside_view)}{more}"
        if frame.invalid_mask is not None:
            count = np.count_nonzero(frame.invalid_mask & np.isfinite(frame.measured))
            facts["Marked invalid"] = f"{grouped(count)} measured pixels, which count as missing"
        if frame.guide is not None:
            facts["Guide"] = guide_text(frame)
        if completion.results:
            facts["Missing after"] = pixels(frame.missing & np.isnan(completion.depth))
            if by_hand := np.count_nonzero(completion.by_hand):
                facts["Depth by hand"] = f"{grouped(by_hand)} of the filled pixels"
            if completion.suspect:
                facts["Suspect"] = f"{grouped(completion.suspect)} measured pixels, left out of the fill"
            if extrapolated := np.count_nonzero(completion.extrapolated):
                facts["Extrapolated"] = f"{grouped(extrapolated)} pixels that no block has filled"
            expected = error_summary(self._expected, completion)
            if math.isfinite(expected.rms):
                facts |= {
                    RMS_NAME: f"{millimetres(expected.rms)} mm",
                    MEDIAN_NAME: f"{millimetres(expected.median)} mm",
                }
        inside = np.mean(self._subject.run.blocks.labels > 0)
        facts["Blocks"] = f"{len(self._blocks)}, over {inside:.1%} of the frame" if self._blocks else "none"
        return facts


def _effective_changes(extraction: BlockParameters) -> dict[str, object]:
    differs = extraction.differences_from(BlockParameters())
    return {name: value for name, value in differs.items() if extraction.has_effect(name)}
