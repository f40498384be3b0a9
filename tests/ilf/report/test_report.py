"""Reports: one whole page whose numbers are those of the judgements, and which needs nothing else."""

import base64
import io
import re
import shlex
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import ilf
from ilf._runtime.formatting import millimetres
from ilf._runtime.long_work import run_to_end
from ilf.cli import main
from ilf.completion.confidence.expected_error import error_summary
from ilf.data.blocks import BlockInfo, Blocks
from ilf.errors import InputError
from ilf.evaluation.evaluation import evaluate_blocks, evaluate_completion
from ilf.evaluation.hold_out import HoldOutTest, evaluate_hold_out
from ilf.project.file import save_project
from ilf.project.frame_state import FrameState
from ilf.project.project import FrameSummary, Project, ProjectFrame, Stage
from ilf.project.run_history import StoredRun
from ilf.report.report import report_steps, write_report
from ilf.report.subject import Subject, Unreadable
from ilf.run.run import Run
from ilf.sources.frame_ref import FrameRef, ReadingOptions

from ..small_frames import write_small_frame
from ..small_runs import small_run

NASTY = "<script>alert(\"1\")</script> & 'Möbel' {{ 7*7 }} {% if %} 深度"
VOID = {"meta", "img", "br"}


def report(subjects, **how):
    return run_to_end(report_steps(subjects, len(subjects), **how)).html()


class Page(HTMLParser):
    """What stands in a page; whatever is wrong with its tags fails."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open = []
        self.tags = set()
        self.values = {"id": [], "href": [], "src": []}
        self.tables = []
        self.words = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        assert len(values) == len(attrs), f"an attribute twice in <{tag}>"
        self.tags.add(tag)
        if tag not in VOID:
            self.open.append(tag)
        for name in self.values.keys() & values.keys():
            self.values[name].append(values[name] or "")
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("td", "th"):
            self.tables[-1][-1].append("")

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        text = " ".join(data.split())
        if text and self.open and self.open[-1] != "style":
            self.words.append(text)
            if {"td", "th"} & set(self.open):
                cell = self.tables[-1][-1]
                cell[-1] = f"{cell[-1]} {text}".strip()

    @property
    def text(self):
        return " ".join(self.words)

    def table(self, *heading):
        """The rows below these headings."""
        found = [table for table in self.tables if table[0][: len(heading)] == list(heading)]
        assert len(found) == 1
        return found[0][1:]


def alone(page):
    """The page refers to nothing outside itself, and all within it is there and can be read."""
    assert len(set(page.values["id"])) == len(page.values["id"])
    assert set(page.values["href"]) <= {f"#{name}" for name in page.values["id"]}
    assert page.tags.isdisjoint({"script", "link", "iframe", "object", "form"})
    for source in page.values["src"]:
        kind, data = re.fullmatch(r"data:image/(png|jpeg|svg\+xml);base64,(.*)", source).groups()
        content = base64.b64decode(data, validate=True)
        if kind == "svg+xml":
            drawn = ElementTree.fromstring(content)
            height = float(drawn.get("viewBox").split()[3])
            heights = [float(line.get(name)) for line in drawn.iter() for name in ("y1", "y2") if line.get(name)]
            assert all(0 <= y <= height for y in heights), "a line outside the picture"
            continue
        with Image.open(io.BytesIO(content)) as image:
            image.load()
            assert image.format.lower() == kind


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A quick run of a frame with a truth, one of whose blocks has a value of its own."""
    made = small_run(tmp_path_factory.mktemp("frame"))
    ground_truth = np.where(np.isfinite(made.frame.depth), made.frame.depth, np.float32(2.0)) + np.float32(0.01)
    frame = replace(made.frame.with_ground_truth(ground_truth), name=NASTY)
    made = made.with_parameters(made.parameters, {1: made.parameters.replace(smoothness=3)})
    infos = {1: BlockInfo(NASTY, (250, 240, 10))}
    return replace(made, frame=frame, blocks=replace(made.blocks, infos=infos))


@pytest.fixture(scope="module")
def subject(run):
    """The run with all that can be told of it."""
    completion = run.complete()
    kept = StoredRun(
        3, NASTY, run, completion.results, 1.25, (200, 0, 0), NASTY, done=frozenset({1}), ground_truth_error=0.0123
    )
    return Subject(completion, NASTY, (kept,))


def test_the_page_of_a_frame_is_whole_and_its_numbers_are_those_of_the_judgements(run, subject):
    test = HoldOutTest("areas", (3, 5))
    text = report([subject], hidden=test)
    page = Page(text)
    alone(page)
    assert "<script" not in text
    assert "49" not in Page(text).table("no.", "block", "pixels")[0][1]
    assert page.text.count(NASTY) >= 5  # title, heading, note, block, kept run
    # errors
    expected = ilf.expected_error(subject.completion)
    ground_truth = evaluate_completion(run.frame, subject.completion, expected=expected)
    hidden = evaluate_hold_out(run, test)
    errors = page.table("evaluation", "pixels", "RMSE [mm]")
    evaluations = [ground_truth, hidden.whole]
    assert [row[2:5] for row in errors] == [[millimetres(e) for e in (j.rmse, j.mae, j.median)] for j in evaluations]
    assert [row[7] for row in errors] == [f"{evaluation.within:.1%}" for evaluation in evaluations]
    assert "seeds 3, 5" in errors[1][0]
    there = subject.completion.filled & np.isfinite(run.frame.ground_truth)
    absolute = np.abs(subject.completion.depth - run.frame.ground_truth)[there]
    assert errors[0][5] == millimetres(float(np.percentile(absolute, 95)))
    # blocks
    by_block = evaluate_blocks(run.frame, subject.completion, run.blocks.labels)
    blocks = page.table("no.", "block", "pixels")
    assert [int(row[0]) for row in blocks] == sorted(subject.completion.results)
    for row in blocks:
        outcome = subject.completion.outcomes[int(row[0])]
        assert row[5:7] == [outcome.status, str(outcome.iterations)]
        assert row[7] == millimetres(outcome.sigma_i)
        assert row[9] == millimetres(by_block[outcome.label].rmse)
    # expected errors, each by its name
    figures = error_summary(subject.completion)
    for name, figure in (("Expected error, RMS", figures.rms), ("Expected error, median", figures.median)):
        assert page.words[page.words.index(name) + 1] == f"{millimetres(figure)} mm"
    heads = [cell for table in page.tables for cell in table[0] if "expected error" in cell.lower() and "mm" in cell]
    assert set(heads) == {"Expected error, RMS [mm]"}
    # parameters, curves, kept runs, files
    assert page.table("parameter", "name", "value") == [["Max. iterations", "max_iterations", "25"]]
    assert page.table("no.", "block", "own parameters")[0][2] == "smoothness 3 x"
    curves = [row[1:3] for row in page.table("curve", "no.")]
    assert curves == [[row[0], row[1]] for row in sorted(blocks, key=lambda row: -int(row[4]))]
    assert page.table("no.", "run")[0][7:] == ["12.3", "–"]
    assert page.table("no.", "run")[0][1].count(NASTY) == 2
    assert {run.frame.inputs.rgb.sha256, run.frame.inputs.depth.sha256} <= set(page.words)


def test_what_is_not_there_is_said(tmp_path):
    depth = np.tile(np.linspace(1, 2, 60, dtype=np.float32), (40, 1))
    depth[10:20, 10:30] = np.nan
    bare = ilf.RGBDFrame(np.zeros((40, 60, 3), np.uint8), depth, name="bare")
    nothing = Run(bare, np.zeros((40, 60), np.int32))
    many = Run(bare, (np.arange(40)[:, None] // 4 * 10 + np.arange(60) // 6 + 1).astype(np.int32))
    subjects = [
        Subject(nothing.complete()),
        Subject(replace(nothing.complete(), run=many)),
        Unreadable(NASTY, f"{NASTY} is not there."),
    ]
    page = Page(report(subjects, title=NASTY, hidden=HoldOutTest()))
    alone(page)
    assert page.text.count(NASTY) == 6  # title, heading, and name and reason in the index and in its place
    for words in ("The frame has no blocks.", "No block has been run.", "No block was iterated."):
        assert words in page.text
    assert len(page.table("no.", "block")) == 100
    index = page.table("", "frame")
    assert [row[1] for row in index] == ["bare", "bare", NASTY]
    assert index[0][3:5] == ["8.3%", "8.3%"]
    assert "truth [mm]" not in page.text  # none of them has one
    assert page.values["href"] == ["#frame-1", "#frame-2", "#frame-3", *["#frames"] * 3]
    short = Run(bare, np.ones((40, 60), np.int32), ilf.preset("paper", max_iterations=2))
    alone(Page(report([Subject(short.complete())])))  # far from its criterion
    with pytest.raises(InputError, match="no frame"):
        report([])


def test_a_stored_frame_is_reported_with_its_results_and_names(run, subject):
    results = {1: subject.completion.results[1]}
    blocks = Blocks(
        run.blocks.labels, {1: BlockInfo("Wall", (1, 2, 3))}, {1: {"smoothness": 9.0}}, extraction=run.blocks.extraction
    )
    state = FrameState("a1", run.frame, blocks, run.parameters, results, extrapolate=True, note="by the window")
    page = Page(report([Subject.of_state(state, "ilf project replay all.ilf")]))
    first, second = page.table("no.", "block", "pixels")
    assert first[1] == "Wall"
    assert first[5] == "values changed"  # it was run with another smoothness than is set now
    assert second[5] == "not run"
    assert "by the window" in page.text
    assert "is extrapolated" not in page.text  # it is wished for, but has not been done
    assert "ilf project replay all.ilf" in page.text


def test_paths_that_are_no_text_are_told_as_far_as_they_are(run, subject, tmp_path):
    odd = replace(run, frame=replace(run.frame, name="caf\udce9"))
    content = run_to_end(report_steps([replace(subject, completion=replace(subject.completion, run=odd))], 1))
    write_report(tmp_path / "page.html", content)
    assert "<h1>caf?</h1>" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_the_command_line_reports_on_projects(run, subject, tmp_path, monkeypatch, cli):
    monkeypatch.chdir(tmp_path)
    frame = replace(run.frame, name="first")
    blocks = Blocks(run.blocks.labels, own={1: {"smoothness": 3.0}})
    state = FrameState("a1", frame, blocks, run.parameters, subject.completion.results)
    files = frame.inputs
    options = ReadingOptions(depth_units=files.depth_units, intrinsics=files.intrinsics)
    source = FrameRef(files.rgb.path, files.depth.path, options=options)
    project = Project((
        ProjectFrame("a1", "first", source, FrameSummary(Stage.RUN), has_state=True),
        ProjectFrame("b2", "second", source, FrameSummary(Stage.EXTRACTED), has_state=False),
    ))  # fmt: skip
    save_project("work.ilf", project, [state])
    assert main(["report", "work.ilf"]) == 0
    page = Page(Path("first-report.html").read_text(encoding="utf-8"))
    alone(page)
    rows = page.table("no.", "block", "pixels")
    assert [row[5] for row in rows] == ["completed"] * len(rows)
    assert rows[0][7] == millimetres(subject.completion.outcomes[1].sigma_i)
    assert "ilf project replay" in page.text
    assert "leave out --preset" in cli("report", "work.ilf", "--preset", "paper", status=2).err
    # set since the frame was stored: its note, and the parameters of all frames
    noted = replace(project.frames[0], summary=FrameSummary(Stage.RUN, note="set later"))
    save_project("work.ilf", replace(project, frames=(noted,), common=ilf.preset("paper"), for_all=True), [state])
    assert main(["report", "work.ilf", "--out", "again.html"]) == 0
    page = Page(Path("again.html").read_text(encoding="utf-8"))
    assert "set later" in page.text
    assert "Filter: preset paper." in page.text
    assert page.table("no.", "block", "pixels")[1][5] == "values changed"
    save_project("empty.ilf", Project())
    assert "no frame with edits or results" in cli("report", "empty.ilf", status=1).err


def test_the_command_line_reports_on_frames_and_records(tmp_path, monkeypatch, cli):
    monkeypatch.chdir(tmp_path)
    files = [str(path) for path in write_small_frame(tmp_path / "in")]
    assert main(["report", *files, "--max-iterations", "25", "--hold-out", "random", "--seeds", "1"]) == 0
    page = Page(Path("in-report.html").read_text(encoding="utf-8"))
    alone(page)
    assert "(random; seed 0)" in page.text
    assert main(["complete", *files, "--max-iterations", "25", "--out", "done", "--quiet"]) == 0
    assert main(["report", "done", "done/run.json", "nowhere", "--out", "both.html"]) == 2  # a third is no folder
    assert "nowhere.json is not in the report" in cli("report", "done", "nowhere.json", "--out", "both.html").err
    page = Page(Path("both.html").read_text(encoding="utf-8"))
    assert len(page.table("", "frame")) == 2
    assert f"ilf complete --replay {shlex.quote(str(tmp_path / 'done' / 'run.json'))}" in page.text
    for wrong, words in (
        (["done", "--smoothness", "3"], "leave out --smoothness"),
        (["done", "--out", "page.pdf"], "must end in .html"),
        (["done", "--seeds", "2"], "add --hold-out"),
        ([], "Give a colour and a depth file"),
    ):
        assert words in cli("report", *wrong, status=2).err
