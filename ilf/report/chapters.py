"""The chapters of a report: one per frame, and the index of several."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .._runtime.cancellation import cancellable_items
from .._runtime.formatting import UNKNOWN, counted, grouped, millimetres
from ..completion.completion import guide_text
from ..completion.confidence.expected_error import MEDIAN_NAME, RMS_MEANING, RMS_NAME
from ..data.camera import camera_text
from ..data.declarations import ParameterSet, Value
from ..data.frame import InputFile
from ..data.parameters import BlockParameters, Parameters, nearest_preset, to_text
from ..data.results import Status, blocks_by_message
from ..evaluation.evaluation import Evaluation
from ..evaluation.hold_out import untrusted_note
from ..io.encodings import encoding_of_inputs
from ..project.frame_state import own_values
from ..run.options import ExportOptions
from ..run.record import RunRecord, make_record
from ..run.run import Run
from .content import (
    Cell,
    Chapter,
    Column,
    Element,
    Fact,
    Facts,
    Gallery,
    Image,
    Paragraph,
    Section,
    Subject,
    Table,
    Unreadable,
)
from .curves import MAX_CURVES, curve_blocks, curve_plots
from .frame_statistics import ErrorStatistics, FrameStatistics
from .pictures import frame_pictures, jpeg_image, thumbnail

# The tables of a frame: blocks, errors, run history, own parameters of blocks.

_WORDS = False
RMSE = Column("RMSE [mm]", "Root mean square error; dominated by large errors")
EXPECTED = Column(f"{RMS_NAME} [mm]", RMS_MEANING)

NOT_RUN, OUTDATED = "not run", "values changed"


def block_table(figures: FrameStatistics) -> Table:
    """Make the table of blocks."""
    subject, completion = figures.subject, figures.subject.completion
    evaluated = figures.evaluated_by
    columns = [
        Column("no."),
        Column("block", number=_WORDS),
        Column("pixels"),
        Column("missing", "Share of its pixels without measured depth"),
        Column("filled", "Number of missing pixels that were filled"),
        Column("status", number=_WORDS),
        Column("iterations"),
        Column("sigma [mm]", "sigma_i of the last iteration: its remaining change of the surface"),
        EXPECTED,
    ]
    if evaluated:
        columns.append(
            Column(f"RMSE, {evaluated} [mm]", f"Root mean square error of the filled depth against {evaluated}")
        )
    rows = []
    frame, blocks = subject.run.frame, subject.run.blocks
    pixels = np.bincount(blocks.ravel())
    known = np.bincount(blocks[~frame.missing], minlength=pixels.size)
    for label in (np.flatnonzero(pixels[1:]) + 1).tolist():
        result = completion.results.get(label)
        cells = [
            Cell(str(label)),
            Cell(subject.name_of(label), subject.colour_of(label)),
            Cell(grouped(int(pixels[label]))),
            Cell(f"{1 - known[label] / pixels[label]:.1%}"),
        ]
        if result is None:
            cells += [Cell(UNKNOWN), Cell(NOT_RUN), Cell(UNKNOWN), Cell(UNKNOWN), Cell(UNKNOWN)]
        else:
            outcome = result.outcome
            outdated = not result.parameters.same_effect(subject.run.parameters_of(label))
            cells += [
                Cell(grouped(outcome.recovered)),
                Cell(OUTDATED if outdated else str(outcome.status), about=outcome.message),
                Cell(grouped(outcome.iterations)),
                Cell(millimetres(outcome.sigma_i)),
                Cell(millimetres(figures.expected_of(result))),
            ]
        if evaluated:
            cells.append(Cell(millimetres(figures.by_block.get(label, Evaluation()).rmse)))
        rows.append(tuple(cells))
    return Table(tuple(columns), tuple(rows))


def block_remarks(subject: Subject) -> list[str]:
    """Return remarks on blocks that were not completed, and on the terms in the table."""
    wrong = [
        outcome
        for outcome in subject.completion.outcomes.values()
        if outcome.status in (Status.NOT_RECOVERABLE, Status.ITERATION_LIMIT)
    ]
    remarks = [f"No. {', '.join(map(str, labels))}: {message}" for message, labels in blocks_by_message(wrong).items()]
    run = subject.run
    if any(
        not result.parameters.same_effect(run.parameters_of(label))
        for label, result in subject.completion.results.items()
    ):
        remarks.append(f"“{OUTDATED}”: the parameters have been changed since the result was computed.")
    return remarks


def error_table(errors: tuple[ErrorStatistics, ...]) -> Table:
    """Make the table of errors, with a row per evaluation."""
    columns = (
        Column("evaluation", number=_WORDS),
        Column("pixels", "Number of compared pixels"),
        RMSE,
        Column("MAE [mm]", "Mean absolute error"),
        Column("median [mm]", "Median absolute error"),
        Column("95 % [mm]", "95th percentile of the absolute error"),
        Column("bias [mm]", "Mean error; positive if the depth is too large"),
        Column("within", "Share of pixels whose error is within the expected error; about 68 % if well calibrated"),
        Column("filled", "Filled share of the pixels to fill"),
    )
    rows = tuple(
        (
            Cell(one.name),
            Cell(grouped(one.evaluation.pixels)),
            Cell(millimetres(one.evaluation.rmse)),
            Cell(millimetres(one.evaluation.mae)),
            Cell(millimetres(one.evaluation.median)),
            Cell(millimetres(one.p95)),
            Cell(millimetres(one.evaluation.bias)),
            Cell(share(one.evaluation.within)),
            Cell(share(one.coverage)),
        )
        for one in errors
    )
    return Table(columns, rows)


def own_parameters_table(subject: Subject) -> Table | None:
    """Make the table of blocks with own parameters; None if there are none."""
    run = subject.run
    own = {label: own_values(parameters, run.parameters) for label, parameters in sorted(run.own.items())}
    rows = tuple(
        (Cell(str(label)), Cell(subject.name_of(label), subject.colour_of(label)), Cell("; ".join(to_text(values))))
        for label, values in own.items()
        if values
    )
    columns = Column("no."), Column("block", number=_WORDS), Column("own parameters", number=_WORDS)
    return Table(columns, rows) if rows else None


def runs_table(subject: Subject) -> Table:
    """Make the table of the run history."""
    columns = (
        Column("no."),
        Column("run", number=_WORDS),
        Column("date", number=_WORDS),
        Column("parameters", number=_WORDS),
        Column("blocks", "Number of blocks that were run"),
        Column("iterations"),
        Column("time [s]"),
        Column("filled", "Number of pixels filled by blocks"),
        EXPECTED,
        Column("ground truth [mm]", "Root mean square error against ground truth"),
        Column("hold-out [mm]", "Root mean square error on hold-out"),
        Column("note", number=_WORDS),
    )
    rows = tuple(
        (
            Cell(str(kept.number)),
            Cell(kept.name if kept.how == "finished" else f"{kept.name} ({kept.how})", kept.colour),
            Cell(f"{kept.when:%Y-%m-%d %H:%M}"),
            Cell(nearest_preset(kept.run.parameters).text()),
            Cell(str(len(kept.done))),
            Cell(grouped(kept.iterations)),
            Cell(f"{kept.seconds:.1f}"),
            Cell(grouped(kept.recovered)),
            Cell(_or_unknown(kept.expected_error)),
            Cell(_or_unknown(kept.ground_truth_error)),
            Cell(_or_unknown(kept.hold_out_error)),
            Cell(kept.note),
        )
        for kept in subject.kept
    )
    return Table(columns, rows)


def share(value: float | None) -> str:
    """Format a share in percent; a dash for none."""
    return UNKNOWN if value is None or not math.isfinite(value) else f"{value:.1%}"


def _or_unknown(metres: float | None) -> str:
    return UNKNOWN if metres is None else millimetres(metres)


# The command that reproduces a run, if there is one.


def replay_text(run: Run) -> tuple[str, str]:
    """Return a sentence and the command that reproduces the run; the command is empty if there is none.

    Parameters
    ----------
    run : Run
    """
    inputs, frame = run.frame.inputs, run.frame
    if inputs is None:
        return "The frame was not read from files, so no command reproduces the run.", ""
    by_hand = run.edited or run.own or any(one is not None for one in (frame.invalid_mask, run.drawn, run.by_hand))
    if by_hand or run.extraction is None or (frame.guide is not None and frame.guide.path is None):
        return (
            "Blocks, parameters or depth were edited by hand. Export the frame and replay its run.json.",
            "ilf complete --replay run.json",
        )
    nearest = nearest_preset(run.parameters)
    encoding = f"{inputs.depth_units:.9g}" if inputs.encoding is None else inputs.encoding
    files = [inputs.rgb.path, inputs.depth.path] if inputs.frame is None else [inputs.rgb.path, "--frame", inputs.frame]
    words = ["ilf", "complete", *files, "--depth-encoding", encoding]
    if inputs.invalid is not None:
        words += ["--invalid", f"{inputs.invalid:.9g}"]
    if inputs.intrinsics is not None:
        words += ["--intrinsics", ",".join(f"{number:.9g}" for number in inputs.intrinsics)]
    if frame.guide is not None and frame.guide.path is not None:
        words += ["--guide", frame.guide.path]
    words += ["--preset", nearest.preset, *_flags(run.parameters, nearest.differs)]
    words += _flags(run.extraction, run.extraction.differences_from(BlockParameters()), "blocks-")
    words += ["--extrapolate"] * run.extrapolate
    return "This command reproduces the run; its run.json contains all hashes.", shlex.join(words)


def _flags(values: ParameterSet, differing: Mapping[str, Value], prefix: str = "") -> list[str]:
    flags = []
    for name in filter(values.has_effect, differing):
        flag, value = f"{prefix}{name.replace('_', '-')}", differing[name]
        if isinstance(value, bool):
            flags.append(f"--{flag}" if value else f"--no-{flag}")
        else:
            flags += [f"--{flag}", str(value)]
    return flags


INDEX = "frames"
_THUMBNAIL, _THUMBNAIL_QUALITY = 240, 70


@dataclass(frozen=True, eq=False)
class Entry:
    """A frame's entry in the index; `cells` follow the picture and the name."""

    chapter: str
    name: str
    image: Image | None
    cells: tuple[Cell, ...] = ()
    note: str = ""


def frame_chapter(id: str, figures: FrameStatistics, most: int) -> Chapter:
    """Make the chapter of a frame; its pictures have at most `most` pixels on the longer side."""
    subject = figures.subject
    return Chapter(id, subject.run.frame.name, subject.note, tuple(cancellable_items(_sections(figures, most))))


def _sections(figures: FrameStatistics, most: int) -> Iterator[Section]:
    subject = figures.subject
    record = make_record(subject.run, subject.completion, ExportOptions())
    yield Section("", (_summary(figures), *(Paragraph(text, warns=True) for text in subject.problems)))
    yield Section("Pictures", (Gallery(frame_pictures(figures, most)),))
    yield Section("Accuracy", _accuracy(figures))
    yield Section("Blocks", _blocks(figures))
    yield Section("Parameters", _parameters(subject))
    yield Section("Convergence", _convergence(subject))
    if subject.kept:
        yield Section("Run history", (runs_table(subject),))
    yield Section("Files and versions", (_provenance(record),))
    if subject.completion.results:
        yield Section("Reproduce this run", _reproduction(subject))


def unreadable_chapter(id: str, frame: Unreadable) -> Chapter:
    """Make the chapter of a frame that cannot be read."""
    return Chapter(id, frame.name, "", (Section("", (Paragraph(frame.why, warns=True),)),))


def index_entry(id: str, figures: FrameStatistics) -> Entry:
    """Make a frame's entry in the index."""
    subject = figures.subject
    frame, completion = subject.run.frame, subject.completion
    blocks = int(np.count_nonzero(np.bincount(subject.run.blocks.ravel())[1:]))
    cells = (
        f"{frame.shape[1]} × {frame.shape[0]}",
        f"{frame.missing_share:.1%}",
        f"{float(np.mean(frame.missing & np.isnan(completion.depth))):.1%}",
        str(blocks),
        str(len(completion.results)),
        millimetres(figures.whole_expected.rms),
        _rmse(figures.against_ground_truth),
        _rmse(figures.on_hold_out),
    )
    small = thumbnail(subject, _THUMBNAIL)
    return Entry(
        id, frame.name, jpeg_image(small, _THUMBNAIL_QUALITY), tuple(Cell(text) for text in cells), subject.note
    )


def index_chapter(title: str, entries: Sequence[Entry]) -> Chapter:
    """Make the index with a row per frame; empty columns are left out."""
    columns = (
        Column("", number=False),
        Column("frame", number=False),
        Column("size [px]"),
        Column("missing in", "Share of the pixels without depth, in the depth camera's view"),
        Column("missing out", "The same after completion"),
        Column("blocks"),
        Column("with result", "Number of blocks that were run"),
        EXPECTED,
        Column("ground truth [mm]", "Root mean square error of filled pixels against ground truth"),
        Column("hold-out [mm]", "Root mean square error on hold-out"),
        Column("note", number=False),
    )
    empty = tuple(Cell("") for _ in range(len(columns) - 3))
    rows = tuple(
        (
            Cell("", image=entry.image),
            Cell(entry.name, target=entry.chapter),
            *(entry.cells or empty),
            Cell(entry.note),
        )
        for entry in entries
    )
    told = [number for number in range(len(columns)) if any(row[number].text or row[number].image for row in rows)]
    table = Table(tuple(columns[n] for n in told), tuple(tuple(row[n] for n in told) for row in rows))
    return Chapter(INDEX, title, "", (Section("", (Paragraph(f"{counted(len(entries), 'frame')}."), table)),))


def _rmse(errors: ErrorStatistics | None) -> str:
    return "" if errors is None else millimetres(errors.evaluation.rmse)


def _summary(figures: FrameStatistics) -> Facts:
    subject = figures.subject
    frame, completion = subject.run.frame, subject.completion
    height, width = frame.shape
    known = frame.depth[frame.own]
    missing, left = (
        int(np.count_nonzero(frame.missing & np.isnan(depth))) for depth in (frame.own_depth, completion.depth)
    )
    inside = np.count_nonzero(subject.run.blocks) / subject.run.blocks.size
    facts = [
        Fact("Size", f"{width} × {height} px"),
        Fact("Camera", camera_text(frame.intrinsics)),
        Fact("Depth", f"{known.min():.2f} to {known.max():.2f} m, median {np.median(known):.2f} m"),
        Fact("Missing before", f"{missing / frame.depth.size:.1%} ({grouped(missing)} pixels)"),
    ]
    if frame.outside_view is not None:
        outside = int(np.count_nonzero(frame.outside_view))
        filled = int(np.count_nonzero(frame.outside_view & completion.filled))
        more = f", {grouped(filled)} of them filled" if filled else ""
        share = f"{outside / frame.depth.size:.1%} ({grouped(outside)} pixels{more})"
        facts.append(Fact("Outside the depth camera's view", share))
    if frame.invalid_mask is not None:
        count = int(np.count_nonzero(frame.invalid_mask & np.isfinite(frame.measured)))
        facts.append(Fact("Marked invalid", f"{grouped(count)} measured pixels, which count as missing"))
    if frame.guide is not None:
        facts.append(Fact("Guide", guide_text(frame)))
    if completion.results:
        facts.append(Fact("Missing after", f"{left / frame.depth.size:.1%} ({grouped(left)} pixels)"))
        if by_hand := int(np.count_nonzero(completion.by_hand)):
            facts.append(Fact("Depth by hand", f"{grouped(by_hand)} of the filled pixels"))
        if completion.suspect:
            facts.append(Fact("Suspect", f"{grouped(completion.suspect)} measured pixels, left out of the fill"))
        if extrapolated := int(np.count_nonzero(completion.extrapolated)):
            facts.append(Fact("Extrapolated", f"{grouped(extrapolated)} pixels that no block has filled"))
        expected = figures.whole_expected
        if math.isfinite(expected.rms):
            facts.append(Fact(RMS_NAME, f"{millimetres(expected.rms)} mm"))
            facts.append(Fact(MEDIAN_NAME, f"{millimetres(expected.median)} mm"))
    blocks = int(np.count_nonzero(np.bincount(subject.run.blocks.ravel())[1:]))
    facts.append(Fact("Blocks", f"{blocks}, over {inside:.1%} of the frame" if blocks else "none"))
    return Facts(tuple(facts))


def _accuracy(figures: FrameStatistics) -> tuple[Element, ...]:
    if figures.errors:
        left_out = "" if figures.hidden is None else untrusted_note(figures.subject.run.frame)
        return error_table(figures.errors), *([Paragraph(left_out)] if left_out else [])
    if not figures.subject.completion.results:
        return (Paragraph("Nothing has been completed, so there is nothing to evaluate."),)
    return (Paragraph("The frame has no ground truth and was not evaluated on hold-out: its errors are unknown."),)


def _blocks(figures: FrameStatistics) -> tuple[Element, ...]:
    subject = figures.subject
    if not subject.run.blocks.any():
        return (Paragraph("The frame has no blocks."),)
    notes = list(dict.fromkeys([*subject.run.notes, *subject.completion.notes]))
    if not subject.completion.results:
        notes.insert(0, "No block has been run.")
    return (
        block_table(figures),
        *(Paragraph(text) for text in block_remarks(subject)),
        *(Paragraph(text, warns=True) for text in notes),
    )


def _parameters(subject: Subject) -> tuple[Element, ...]:
    run = subject.run
    nearest = nearest_preset(run.parameters)
    parts: list[Element] = []
    if nearest.differs:
        parts.append(Paragraph(f"Filter: preset {nearest.preset} with these changes."))
        parts.append(_differing(Parameters, nearest.differs))
    else:
        parts.append(Paragraph(f"Filter: preset {nearest.preset}."))
    own = own_parameters_table(subject)
    if own is not None:
        parts.append(own)
    if run.extraction is None:
        parts.append(Paragraph("The blocks were given, not extracted."))
    else:
        differs = run.extraction.differences_from(BlockParameters())
        differs = {name: differs[name] for name in filter(run.extraction.has_effect, differs)}
        edited = " The blocks were edited afterwards." if run.edited else ""
        if differs:
            parts.append(Paragraph(f"Extraction: defaults with these changes.{edited}"))
            parts.append(_differing(BlockParameters, differs))
        else:
            parts.append(Paragraph(f"Extraction: defaults.{edited}"))
    if run.extrapolate:
        parts.append(Paragraph("Depth still missing after the blocks is extrapolated."))
    return tuple(parts)


def _differing(kind: type[ParameterSet], values: Mapping[str, Value]) -> Table:
    declared = kind.declarations()
    rows = tuple(
        (Cell(declared[name].label, about=declared[name].help), Cell(name), Cell(declared[name].to_text(value)))
        for name, value in values.items()
    )
    return Table((Column("parameter", number=False), Column("name", number=False), Column("value")), rows)


def _convergence(subject: Subject) -> tuple[Element, ...]:
    plots = curve_plots(subject)
    if not plots:
        return (Paragraph("No block was iterated."),)
    shown = len(curve_blocks(subject))
    iterated = sum(bool(len(result.history)) for result in subject.completion.results.values())
    text = f"The {shown} of {iterated} iterated blocks that have filled most pixels are shown."
    return (*((Paragraph(text),) if iterated > MAX_CURVES else ()), Gallery(plots))


def _provenance(record: RunRecord) -> Facts:
    facts: list[Fact] = []
    if record.inputs is None:
        facts.append(Fact("Files", "The frame was not read from files."))
    else:
        files: list[tuple[str, InputFile | None]] = [
            ("Colour", record.inputs.rgb),
            ("Depth", record.inputs.depth),
            ("Ground truth", record.inputs.ground_truth),
        ]
        for name, file in files:
            if file is not None:
                facts += [Fact(name, file.path), Fact("SHA-256", file.sha256, is_hash=True)]
        if record.inputs.frame is not None:
            facts.append(Fact("Frame of the recording", record.inputs.frame))
        facts.append(Fact("Depth encoding", encoding_of_inputs(record.inputs).text))
    if record.guide is not None:
        given = [Fact("Guide", record.guide.path)] if record.guide.path is not None else []
        facts += [*given, Fact("Guide, SHA-256 of its values", record.guide.sha256, is_hash=True)]
    facts.append(Fact("Blocks, SHA-256", record.blocks.sha256, is_hash=True))
    if record.blocks_outcome and record.depth_sha256:
        facts.append(Fact("Depth out, SHA-256", record.depth_sha256, is_hash=True))
    for name, sha256 in (record.networks.extraction | record.networks.filter).items():
        facts.append(Fact(f"Edge network {name}", sha256, is_hash=True))
    versions = ", ".join(f"{library} {version or 'not installed'}" for library, version in record.versions.items())
    facts += [Fact("Program", f"ILF Studio {record.version}"), Fact("Libraries", versions)]
    return Facts((*facts, Fact("Processor", record.processor)))


def _reproduction(subject: Subject) -> tuple[Element, ...]:
    text, command = replay_text(subject.run)
    if subject.again:
        text, command = "This command replays the runs and reports differences.", subject.again
    return (Paragraph(text), *((Paragraph(command, code=True),) if command else ()))
