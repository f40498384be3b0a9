"""A frame's chapter of a report, and the index of several."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..camera import camera_text
from ..confidence import MEDIAN_NAME, RMS_NAME
from ..declarations import ParameterSet, Value
from ..filter.edge_aware.guiding import fit_guide
from ..frame import InputFile
from ..io.encodings import encoding_of_inputs
from ..number_words import grouped, millimetres
from ..parameters import BlockParameters, Parameters
from ..preset_words import likeness
from ..run import ExportOptions, RunRecord, make_record
from ..stopping import stoppable
from .again import again_text
from .content import Cell, Chapter, Column, Fact, Facts, Gallery, Image, Paragraph, Part, Section, Table
from .curves import MOST_CURVES, curve_blocks, curve_plots
from .figures import ErrorFigures, Figures
from .images import photo
from .pictures import frame_pictures, thumbnail
from .subject import Subject, Unreadable
from .tables import EXPECTED, block_remarks, block_table, error_table, own_table, runs_table

INDEX = "frames"
_THUMBNAIL, _THUMBNAIL_QUALITY = 240, 70


@dataclass(frozen=True, eq=False)
class Entry:
    """What the index says of a frame; `cells` are those after the picture and the name."""

    chapter: str
    name: str
    image: Image | None
    cells: tuple[Cell, ...] = ()
    note: str = ""


def frame_chapter(id: str, figures: Figures, most: int) -> Chapter:
    """All there is to say of a frame; pictures are `most` pixels wide or high at most."""
    subject = figures.subject
    return Chapter(id, subject.run.frame.name, subject.note, tuple(stoppable(_sections(figures, most))))


def _sections(figures: Figures, most: int) -> Iterator[Section]:
    subject = figures.subject
    record = make_record(subject.run, subject.completion, ExportOptions())
    yield Section("", (_head(figures), *(Paragraph(text, warns=True) for text in subject.problems)))
    yield Section("Pictures", (Gallery(frame_pictures(figures, most)),))
    yield Section("How far off", _accuracy(figures))
    yield Section("Blocks", _blocks(figures))
    yield Section("Parameters", _parameters(subject))
    yield Section("Convergence", _convergence(subject))
    if subject.kept:
        yield Section("Kept runs", (runs_table(subject),))
    yield Section("Files and versions", (_provenance(record),))
    if subject.completion.results:
        yield Section("How to have it again", _again(subject))


def unreadable_chapter(id: str, frame: Unreadable) -> Chapter:
    """What there is to say of a frame that cannot be read."""
    return Chapter(id, frame.name, "", (Section("", (Paragraph(frame.why, warns=True),)),))


def index_entry(id: str, figures: Figures) -> Entry:
    """A frame's row in the index."""
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
        _rmse(figures.against_truth),
        _rmse(figures.on_hidden_depth),
    )
    small = thumbnail(subject, _THUMBNAIL)
    return Entry(id, frame.name, photo(small, _THUMBNAIL_QUALITY), tuple(Cell(text) for text in cells), subject.note)


def index_chapter(title: str, entries: Sequence[Entry]) -> Chapter:
    """A row for each frame; what there is nothing to say of has no column."""
    columns = (
        Column("", number=False),
        Column("frame", number=False),
        Column("size [px]"),
        Column("missing in", "Share of the pixels without depth, in the depth camera's view"),
        Column("missing out", "The same after completion"),
        Column("blocks"),
        Column("with result", "Blocks that have been completed, or tried to"),
        EXPECTED,
        Column("truth [mm]", "Root mean square error of filled pixels against the truth"),
        Column("hidden [mm]", "Root mean square error on hidden depth"),
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
    count = f"{len(entries)} frame{'s' * (len(entries) != 1)}"
    return Chapter(INDEX, title, "", (Section("", (Paragraph(f"{count}."), table)),))


def _rmse(errors: ErrorFigures | None) -> str:
    return "" if errors is None else millimetres(errors.judgement.rmse)


def _head(figures: Figures) -> Facts:
    subject = figures.subject
    frame, completion = subject.run.frame, subject.completion
    height, width = frame.shape
    known = frame.depth[frame.known]
    missing, left = (
        int(np.count_nonzero(frame.missing & np.isnan(depth))) for depth in (frame.depth, completion.depth)
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
        more = f", of which {grouped(filled)} are filled all the same" if filled else ""
        share = f"{outside / frame.depth.size:.1%} ({grouped(outside)} pixels{more})"
        facts.append(Fact("Outside the depth camera's view", share))
    if frame.distrusted is not None:
        count = int(np.count_nonzero(frame.distrusted & np.isfinite(frame.measured)))
        facts.append(Fact("Distrusted", f"{grouped(count)} measured pixels, which count as missing"))
    guide = fit_guide(frame)
    if guide is not None:
        facts.append(Fact("Guide", guide.in_words()))
    if completion.results:
        facts.append(Fact("Missing after", f"{left / frame.depth.size:.1%} ({grouped(left)} pixels)"))
        if guessed := int(np.count_nonzero(completion.guessed)):
            facts.append(Fact("Guessed", f"{grouped(guessed)} pixels, which no block vouches for"))
        expected = figures.whole_expected
        if math.isfinite(expected.rms):
            facts.append(Fact(RMS_NAME, f"{millimetres(expected.rms)} mm"))
            facts.append(Fact(MEDIAN_NAME, f"{millimetres(expected.median)} mm"))
    blocks = int(np.count_nonzero(np.bincount(subject.run.blocks.ravel())[1:]))
    facts.append(Fact("Blocks", f"{blocks}, over {inside:.1%} of the frame" if blocks else "none"))
    return Facts(tuple(facts))


def _accuracy(figures: Figures) -> tuple[Part, ...]:
    if figures.errors:
        return (error_table(figures.errors),)
    if not figures.subject.completion.results:
        return (Paragraph("Nothing has been completed, so there is nothing to judge."),)
    return (Paragraph("The frame has no truth, and no depth was hidden to test it: its errors are not known."),)


def _blocks(figures: Figures) -> tuple[Part, ...]:
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


def _parameters(subject: Subject) -> tuple[Part, ...]:
    run = subject.run
    nearest = likeness(run.parameters)
    parts: list[Part] = []
    if nearest.differs:
        parts.append(Paragraph(f"Filter: the preset {nearest.preset}, but for these values."))
        parts.append(_differing(Parameters, nearest.differs))
    else:
        parts.append(Paragraph(f"Filter: the preset {nearest.preset}, as it is."))
    own = own_table(subject)
    if own is not None:
        parts.append(own)
    if run.extraction is None:
        parts.append(Paragraph("The blocks were given, not extracted."))
    else:
        differs = run.extraction.unlike(BlockParameters())
        differs = {name: differs[name] for name in filter(run.extraction.matters, differs)}
        edited = " The blocks were edited afterwards." if run.edited else ""
        if differs:
            parts.append(Paragraph(f"Extraction: the defaults, but for these values.{edited}"))
            parts.append(_differing(BlockParameters, differs))
        else:
            parts.append(Paragraph(f"Extraction: the defaults.{edited}"))
    if run.dense:
        parts.append(Paragraph("What no block could complete was to be guessed."))
    return tuple(parts)


def _differing(kind: type[ParameterSet], values: Mapping[str, Value]) -> Table:
    declared = kind.declarations()
    rows = tuple(
        (Cell(declared[name].label, about=declared[name].help), Cell(name), Cell(declared[name].in_words(value)))
        for name, value in values.items()
    )
    return Table((Column("parameter", number=False), Column("name", number=False), Column("value")), rows)


def _convergence(subject: Subject) -> tuple[Part, ...]:
    plots = curve_plots(subject)
    if not plots:
        return (Paragraph("No block was iterated."),)
    shown = len(curve_blocks(subject))
    iterated = sum(bool(len(result.history)) for result in subject.completion.results.values())
    text = f"Of {iterated} blocks that were iterated, the {shown} that have filled most pixels are shown."
    return (*((Paragraph(text),) if iterated > MOST_CURVES else ()), Gallery(plots))


def _provenance(record: RunRecord) -> Facts:
    facts: list[Fact] = []
    if record.inputs is None:
        facts.append(Fact("Files", "The frame was not read from files."))
    else:
        files: list[tuple[str, InputFile | None]] = [
            ("Colour", record.inputs.rgb),
            ("Depth", record.inputs.depth),
            ("Truth", record.inputs.truth),
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
    facts.append(Fact("Blocks, SHA-256", record.labels_sha256, is_hash=True))
    if record.outcomes and record.depth_sha256:
        facts.append(Fact("Depth out, SHA-256", record.depth_sha256, is_hash=True))
    for name, sha256 in (record.extraction_networks | record.networks).items():
        facts.append(Fact(f"Edge network {name}", sha256, is_hash=True))
    versions = ", ".join(f"{library} {version or 'not installed'}" for library, version in record.versions.items())
    facts += [Fact("Program", f"ILF Studio {record.version}"), Fact("Libraries", versions)]
    return Facts((*facts, Fact("Processor", record.processor)))


def _again(subject: Subject) -> tuple[Part, ...]:
    text, command = again_text(subject.run)
    if subject.again:
        text, command = "This command makes the runs again and says what differs.", subject.again
    return (Paragraph(text), *((Paragraph(command, code=True),) if command else ()))
