"""The examples in the library's docstrings run, and every public function has one."""

import doctest
import importlib
import inspect
from pathlib import Path

import numpy as np
import pytest

import ilf

ROOT = Path(ilf.__file__).parent
MODULES = sorted(
    ".".join(("ilf", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__")
    for path in ROOT.rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name, tmp_path, monkeypatch):
    """In an empty folder; numpy prints as it does by default."""
    monkeypatch.chdir(tmp_path)
    runner = doctest.DocTestRunner(optionflags=OPTIONS)
    with np.printoptions():
        for test in doctest.DocTestFinder().find(importlib.import_module(name)):
            if test.examples:  # every run looks at all files that are remembered for tracebacks
                runner.run(test)
    assert runner.tries > 0
    assert runner.failures == 0, "see above"


def test_the_package_shows_its_public_names_and_no_others():
    assert dir(ilf) == ilf.__all__
    assert {"complete", "load_frame", "PRESETS", "write_depth", "evaluate_hold_out", "open_project"} <= set(dir(ilf))
    assert 25 <= len(dir(ilf)) <= 39
    assert not any(inspect.ismodule(getattr(ilf, name)) for name in dir(ilf))


def test_types_are_seen_by_those_who_check_theirs():
    assert (ROOT / "py.typed").is_file()


def has_examples(public):
    """Functions, and classes but for those of errors, which are raised and not called."""
    return inspect.isfunction(public) or (inspect.isclass(public) and not issubclass(public, Exception))


@pytest.mark.parametrize("name", [name for name in ilf.__all__ if has_examples(getattr(ilf, name))])
def test_every_public_name_has_an_example(name):
    examples = doctest.DocTestFinder(recurse=False).find(getattr(ilf, name), name)
    assert any(test.examples for test in examples), f"ilf.{name} has no example in its docstring"
