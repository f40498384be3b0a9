"""Processes that the program starts of itself, where a packager has made one program of it and Python.

Such a program is a script here, which is called as the program is, whatever its arguments.
"""

import os
import sys

import pytest

from ilf._runtime.children import run_in_child, run_in_processes
from ilf._runtime.installation import optional
from ilf.errors import InputError

pytestmark = pytest.mark.skipif(os.name != "posix", reason="scripts that are programs")

_PROGRAM = """#!{python} -P
import sys

sys.frozen, sys.executable = True, __file__
sys.path[:0] = {path}
if __name__ == "__main__":
    from {room} import main

    sys.exit(main())
"""


def _frozen(folder, room):
    program = folder / "program"
    program.write_text(_PROGRAM.format(python=sys.executable, path=[path for path in sys.path if path], room=room))
    program.chmod(0o700)
    return str(program)


@pytest.mark.parametrize("room", ["ilf.cli", "gui.app.start"])
def test_a_frozen_program_tries_readers_in_a_child_and_shares_work_among_processes(tmp_path, monkeypatch, room):
    monkeypatch.setattr(sys, "executable", _frozen(tmp_path, room))
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    assert run_in_child(divmod, 7, 2, file="seven") == (3, 1)
    assert run_in_child(os.write, 1, b"what a library prints", file="seven") == 21
    ((_, group),) = run_in_processes(os.getpgid, [0], jobs=2)
    assert group != os.getpgid(0)


def test_a_frozen_program_names_what_it_does_not_contain(monkeypatch):
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    with pytest.raises(InputError, match=r"no_such_module, which is not part of this app.*ilf-studio.cloud"):
        optional("no_such_module", "ilf-studio[cloud]", "A test")
