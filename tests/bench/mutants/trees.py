"""Copies of the tree in which faults are made and tests are run."""

import hashlib
import os
import shutil
import subprocess
from collections.abc import Callable, Iterable
from pathlib import Path

PACKAGES = ("ilf", "gui")
"""The program."""


def take_tree(root: Path, folder: Path) -> Path:
    """Copy the tracked and untracked files that git does not ignore; the tree may change afterwards."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=root, capture_output=True, text=True, check=True,
    )  # fmt: skip
    for name in listed.stdout.split("\0"):
        if name and (root / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(root / name, folder / name)
    return folder


def copy_tree(tree: Path, folder: Path) -> Path:
    """Make another copy, without bytecode."""
    shutil.copytree(tree, folder, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def python_files(tree: Path, targets: Iterable[str]) -> list[str]:
    """Return the non-empty Python files among files and folders of a copy, relative to its root.

    Raises
    ------
    ValueError
        If there is no such file or folder.
    """
    files = []
    for target in targets:
        path = tree / target
        if not path.exists():
            raise ValueError(f"{target}: the tree has no such file or folder.")
        found = [path] if path.is_file() else sorted(path.rglob("*.py"))
        files += [file.relative_to(tree).as_posix() for file in found if file.stat().st_size]
    return files


def tree_hash(tree: Path, counts: Callable[[str], bool] = bool) -> str:
    """SHA-256 over names and contents of all or selected Python files of a copy."""
    digest = hashlib.sha256()
    for name in filter(counts, sorted(python_files(tree, ["."]))):
        digest.update(f"{name}\0{file_hash(tree, name)}\0".encode())
    return digest.hexdigest()


def file_hash(tree: Path, path: str) -> str:
    """SHA-256 of a file's content."""
    return hashlib.sha256((tree / path).read_bytes()).hexdigest()


def put(tree: Path, path: str, source: str) -> None:
    """Write a file of a copy and delete its bytecode, because size and time may equal those of the last fault."""
    (tree / path).write_text(source, encoding="utf-8")
    for stale in (tree / path).parent.glob(f"__pycache__/{Path(path).stem}.*.pyc"):
        stale.unlink()


def environment(tree: Path) -> dict[str, str]:
    """Environment of tests on a copy: without a display, and deterministic."""
    return os.environ | {
        "PYTHONPATH": str(tree),
        "PYTHONHASHSEED": "0",
        "QT_QPA_PLATFORM": "offscreen",
        "CI": "1",
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
        "COVERAGE_CORE": "ctrace",
    }
