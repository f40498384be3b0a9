"""The pages of the site: instructions run as pasted, and all public names have their place. `.ci/site` builds it."""

import re
import shlex
import textwrap
from itertools import groupby
from pathlib import Path

import matplotlib
import matplotlib.pyplot
import pytest

import ilf
from ilf.cli import main

from .batch_frames import work_in_this_process
from .phone_files import write_record3d
from .test_readme import DOCS, thin
from .tiny_onnx import node, write_network

INSTRUCTIONS = {
    "start": (DOCS / "start.md").read_text(encoding="utf-8"),
    **{part.partition("\n")[0]: part for part in (DOCS / "howto.md").read_text(encoding="utf-8").split("\n## ")[1:]},
}
"""A page, and each part of "How to ..." by its heading."""


def code(text: str) -> list[str]:
    """The blocks of code of a text, also those of its lists, without their indent."""
    lines = text.splitlines()
    # a blank line continues a block if an indented one follows
    kept = [
        line if line.strip() or not following.startswith("    ") else "    "
        for line, following in zip(lines, [*lines[1:], ""], strict=True)
    ]
    groups = groupby(kept, key=lambda line: line.startswith("    "))
    return [textwrap.dedent("\n".join(group)).strip("\n") for indented, group in groups if indented]


@pytest.mark.parametrize("name", INSTRUCTIONS)
@pytest.mark.timeout(300)
def test_instructions_run_as_pasted(name, tmp_path, monkeypatch):
    """In a folder with the sample, thinned to every fourth pixel, a phone's scan, and a network."""
    monkeypatch.chdir(tmp_path)
    work_in_this_process(monkeypatch)
    matplotlib.use("agg")
    assert main(["sample", "room"]) == 0
    thin(Path("room"))
    write_record3d(Path("scan.r3d"))
    write_network(Path("net.onnx"), [node("ReduceMean", ["image"], "strength", axes=[1], keepdims=1)])
    blocks = [block for block in code(INSTRUCTIONS[name]) if block]
    assert blocks
    names: dict[str, object] = {}
    for block in blocks:
        if block.startswith("ilf-gui"):
            continue
        if not block.startswith("ilf "):
            exec(compile(block, name, "exec"), names)
            continue
        for line in block.splitlines():
            if not line.startswith("ilf sample"):
                assert main(shlex.split(line)[1:]) == 0, line
    matplotlib.pyplot.close("all")


def test_every_public_name_is_on_one_page_once():
    text = "\n".join(page.read_text(encoding="utf-8") for page in (DOCS / "reference").glob("*.md"))
    listed = re.findall(r"^\.\. (?:auto\w+|py:data):: (\w+)$", text, re.MULTILINE)
    assert sorted(listed) == sorted(set(dir(ilf)) - {"__version__"})
