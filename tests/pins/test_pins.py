import json
import os
import subprocess
import sys

import pytest

from . import commands, library
from .__main__ import ROOT, main

CHOSEN = [("hills", "best, everything"), ("wall", "best, neighbours")]

IN_A_PROCESS = """
import json, os, sys
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: int(sys.argv[1])])
from tests.pins import library
made = [library.completion(frame, library.COMPLETIONS[name]) for frame, name in json.loads(sys.argv[2])]
print(json.dumps(made))
"""


def made_in_a_process(seed: int, threads: int) -> list[dict[str, str]]:
    """Hashes of the chosen settings, made with a hash seed and a number of threads and cores."""
    of_libraries = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), str(threads))
    environment = os.environ | of_libraries | {"PYTHONHASHSEED": str(seed)}
    command = [sys.executable, "-c", IN_A_PROCESS, str(threads), json.dumps(CHOSEN)]
    done = subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def test_hashes_depend_neither_on_the_process_nor_on_its_threads():
    here = [library.completion(frame, library.COMPLETIONS[name]) for frame, name in CHOSEN]
    assert made_in_a_process(seed=1, threads=4) == here
    for hashes in here:
        assert {"blocks", "depth", "expected error", "curves", "run.json", "depth.png", "cloud.ply"} <= hashes.keys()


@pytest.mark.parametrize(
    ("change", "differing", "equal"),
    [
        ({"smoothness": 1.1}, {"depth", "curves", "expected error", "depth.npy", "mesh.glb", "run.json"}, {"blocks"}),
        ({"only": [2]}, {"blocks", "depth", "run.json"}, set()),
        ({"files": {"depth_units": 2000.0}}, {"depth.png", "run.json"}, {"depth", "depth.npy", "cloud.ply"}),
    ],
)
def test_a_change_changes_the_hashes_of_what_depends_on_it(change, differing, equal):
    before, now = library.completion("hills", {}), library.completion("hills", change)
    assert all(before[what] != now[what] for what in differing)
    assert all(before[what] == now[what] for what in equal)


@pytest.fixture
def _few(monkeypatch):
    monkeypatch.setattr(library, "FRAMES", {"wall": library.FRAMES["wall"]})
    monkeypatch.setattr(library, "COMPLETIONS", {"best": {}})
    monkeypatch.setattr(commands, "make", dict)


@pytest.mark.usefixtures("_few")
def test_a_difference_is_printed_and_is_the_exit_status(tmp_path, capsys):
    file = tmp_path / "table.json"
    assert main(["--write", str(file), "--only", "library"]) == 0
    assert main([str(file)]) == 0
    total = int(capsys.readouterr().out.split()[0])
    table = json.loads(file.read_text())
    hashes = table["library"]["wall: best"]
    hashes["depth"], hashes["old.png"] = "another", hashes.pop("depth.png")
    file.write_text(json.dumps(table))
    assert main([str(file)]) == 1
    *lines, summary = capsys.readouterr().out.splitlines()
    assert {line.removeprefix("library, wall: best, ") for line in lines} == {
        "depth differs",
        "depth.png is new",
        "old.png is gone",
    }
    assert summary == f"{total - 2} of {total + 1} hashes equal"


def test_a_table_without_what_is_asked_for_is_not_equal_to_nothing(tmp_path):
    file = tmp_path / "table.json"
    file.write_text('{"window": {}}')
    with pytest.raises(SystemExit) as ended:
        main([str(file), "--only", "library"])
    assert ended.value.code == 2
