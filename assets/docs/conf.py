"""The site: `sphinx-build -W assets/docs build/site`. Its pages are the documents of this folder and those in `PAGES`.

Written by the build, and ignored by git: `gallery` (the scripts of `examples`, run, with their pictures and notebooks).
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
from itertools import zip_longest
from pathlib import Path

import matplotlib
from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx

import ilf
from ilf.cli.commands import COMMANDS, build_parser

matplotlib.use("agg")

HERE = Path(__file__).parent
ROOT = HERE.parents[1]

PAGES = {
    ROOT / "README.md": HERE / "index.md",
    ROOT / ".github" / "CONTRIBUTING.md": HERE / "contributing.md",
    ROOT / ".github" / "SECURITY.md": HERE / "security.md",
    ROOT / "assets" / "models" / "README.md": HERE / "networks.md",
    ROOT / "assets" / "models" / "bsds500" / "README.md": HERE / "networks.md",
    ROOT / "assets" / "plugins" / "napari-ilf" / "README.md": HERE / "plugins.md",
    HERE / "decisions": HERE / "decisions" / "index.md",
    HERE / "measurements": HERE / "measurements" / "README.md",
    HERE / "examples": HERE / "gallery" / "index.rst",
    HERE / "examples" / "paper": HERE / "gallery" / "paper" / "index.rst",
    **{
        script: HERE / "gallery" / script.relative_to(HERE / "examples").with_suffix(".rst")
        for script in (HERE / "examples").rglob("*.py")
    },
}
"""What documents link to -> the page that has its content."""

project, author, version = "ILF Studio", "The ILF Studio developers", ilf.__version__
copyright = f"2026 {author}"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["examples/*", "paper/*", "gallery/uses/*"]
highlight_language = "default"

myst_enable_extensions = ["deflist"]
myst_heading_anchors = 3

default_role = "py:obj"
autodoc_typehints = "none"
autodoc_member_order = "groupwise"
toc_object_entries_show_parents = "hide"
napoleon_use_ivar = True
napoleon_google_docstring = False

html_theme = "pydata_sphinx_theme"
html_title = project
html_logo = html_favicon = "../icons/ilf-studio.png"
html_copy_source = False
html_theme_options = {
    "logo": {"text": project},
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "header_links_before_dropdown": 7,
}
html_context = {"default_mode": "auto"}

# scripts run beside their copies, so that what they write is not among the sources
SCRIPTS = ROOT / "build" / "examples"
shutil.rmtree(SCRIPTS, ignore_errors=True)
shutil.copytree(HERE / "examples", SCRIPTS)

sphinx_gallery_conf = {
    "examples_dirs": str(SCRIPTS),
    "gallery_dirs": "gallery",
    "filename_pattern": "/",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "capture_repr": ("_repr_html_", "__repr__"),
    "download_all_examples": False,
    "show_signature": False,
    "write_computation_times": False,
    "reference_url": {"ilf": None},
    "doc_module": ("ilf",),
    "backreferences_dir": "gallery/uses",
}


# Links of documents: to files of the repository as they are displayed there, to pages here.


def with_links_to_pages(text: str, document: Path, page: Path) -> str:
    """Return the text of a document with the relative links that its page needs.

    Parameters
    ----------
    text : str
    document : Path
        The file that the links in the text are relative to.
    page : Path
        The file of the page that shows the text.
    """

    def link(match: re.Match[str]) -> str:
        name, hash_, anchor = match[1].partition("#")
        target = Path(os.path.normpath(document.parent / name))
        target = PAGES.get(target, target)
        return f"]({os.path.relpath(target, page.parent)}{hash_}{anchor})"

    return re.sub(r"\]\((?!https?:|mailto:|#)([^)\s]+)\)", link, text)


def read_page(app: Sphinx, name: str, content: list[str]) -> None:
    """Prepare a page's text: its links, and what is derived from the program."""
    path = Path(app.env.doc2path(name))
    if path.suffix == ".md":
        text = with_links_to_pages(content[0], path, path)
        content[0] = text.replace("<!-- all commands -->", commands_as_markdown())


def read_included(app: Sphinx, path: Path, name: str, content: list[str]) -> None:
    """Prepare the text of a document that a page includes."""
    content[0] = with_links_to_pages(content[0], Path(os.path.normpath(HERE / path)), Path(app.env.doc2path(name)))


# The command line, from its parsers.


def commands_as_markdown() -> str:
    """Describe all commands with their arguments: a section for each command."""
    parser = build_parser(tuple(COMMANDS))
    return "\n\n".join(command_as_markdown(command, 2) for command in subcommands(parser))


def command_as_markdown(parser: argparse.ArgumentParser, level: int) -> str:
    """Describe a command and the commands below it."""
    parts = [f"{'#' * level} {parser.prog}", escaped(parser.description or "")]
    for group in parser._action_groups:
        shown = [
            action for action in group._group_actions if action.help != argparse.SUPPRESS and action.nargs != "A..."
        ]
        if shown and group.title not in ("options", "positional arguments"):
            parts.append(f"**{escaped(group.title or '')}**")
        parts += [argument_as_markdown(parser, action) for action in shown]
    parts += [command_as_markdown(command, level + 1) for command in subcommands(parser)]
    return "\n\n".join(parts)


def argument_as_markdown(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    """Describe an argument: an entry of a list of definitions."""
    formatter = parser.formatter_class(parser.prog)
    text = formatter._expand_help(action) if action.help else ""
    return f"`{formatter._format_action_invocation(action)}`\n: {escaped(' '.join(text.split()))}"


def subcommands(parser: argparse.ArgumentParser) -> list[argparse.ArgumentParser]:
    """Return the parsers of a parser's commands."""
    actions = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    return [command for action in actions for command in action.choices.values()]


def escaped(text: str) -> str:
    """Return plain text as Markdown, with options and what is in backticks as code."""
    parts = re.split(r"(`[^`]*`|(?<![\w-])--[a-z][\w-]*)", text)
    plain = [re.sub(r"([\\*_<>\[\]|#~])", r"\\\1", part) for part in parts[::2]]
    code = [f"`{part.strip('`')}`" for part in parts[1::2]]
    return "".join(map("".join, zip_longest(plain, code, fillvalue="")))


# Types in docstrings: "array_like of bool, shape (H, W)" has words that are names of attributes, too.


def without_links_of_words(app: Sphinx, page: nodes.document) -> None:
    """Keep links in types of parameters to classes only, whose names are not in lower case."""
    for link in list(page.findall(pending_xref)):
        if link.get("refspecific") and link["reftarget"].islower():
            link.replace_self(link.children)


def setup(app: Sphinx) -> None:
    """Connect the reading of pages."""
    app.connect("source-read", read_page)
    app.connect("include-read", read_included)
    app.connect("doctree-read", without_links_of_words)
