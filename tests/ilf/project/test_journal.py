"""The journal keeps a commit as a whole or not at all, whatever becomes of the program, the disk or the file."""

from __future__ import annotations

import contextlib
import os
import random
import shutil
import sqlite3
import stat
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ilf.errors import ExportError, InputError
from ilf.project.journal import SCHEMA, Journal, JournalHeader, JournalInUse
from ilf.project.packing import labels_from_bytes, labels_to_bytes
from ilf.project.recovery import find_recoverable_work

_NAMES = st.sampled_from([f"arrays/{number}.png" for number in range(6)])
_CONTENTS = st.lists(st.sampled_from([b"....IDAT", b"1" * 900, b"2" * 2000, b""]), max_size=5).map(b"".join)
_COMMITS = st.lists(st.tuples(st.dictionaries(_NAMES, _CONTENTS), st.sets(_NAMES)), max_size=8)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "autosave" / "work.journal"


@pytest.fixture
def journal(path: Path) -> Iterator[Journal]:
    journal = Journal(path)
    yield journal
    journal.close()


@settings(max_examples=25)
@given(commits=_COMMITS)
def test_holds_what_was_put_and_not_dropped(tmp_path_factory: pytest.TempPathFactory, commits) -> None:
    path = tmp_path_factory.mktemp("journal") / "work.journal"
    expected: dict[str, bytes] = {}
    with contextlib.closing(Journal(path)) as journal:
        for put, drop in commits:
            journal.commit(put, drop)
            expected = {name: content for name, content in expected.items() if name not in drop} | put
    with contextlib.closing(Journal(path)) as again:
        assert {name: again.read(name) for name in again.names()} == expected


def test_what_has_not_changed_of_an_image_is_not_written_again(journal: Journal) -> None:
    labels = np.random.default_rng(0).integers(0, 9, (320, 200)).astype(np.int32)
    before, _ = labels_to_bytes(labels)
    labels[40:44, 10:20] = 3
    after, _ = labels_to_bytes(labels)
    journal.commit({"arrays/1.png": before})
    log = journal.path.with_name(journal.path.name + "-wal")
    size = log.stat().st_size
    journal.commit({"arrays/2.png": after}, drop=["arrays/1.png"])
    assert log.stat().st_size - size < len(after) / 2
    assert journal.read("arrays/2.png") == after
    assert np.array_equal(labels_from_bytes("arrays/2.png", after, labels.shape), labels)
    journal.commit({}, drop=["arrays/2.png"])
    assert journal._database.execute("SELECT count(*) FROM pieces").fetchone() == (0,)


def test_says_whose_work_it_is(journal: Journal, path: Path) -> None:
    note = JournalHeader("/projects/häuser.ilf", unsaved=False)
    journal.commit({}, note=note)
    with pytest.raises(JournalInUse, match="Another window"):
        Journal(path)
    changed = journal.note.changed
    journal.close()
    again = Journal(path)
    assert again.note == JournalHeader(**{**vars(note), "changed": changed})
    assert (again.note.process, again.note.unsaved) == (os.getpid(), False)
    again.discard()
    assert list(path.parent.iterdir()) == []


@pytest.mark.parametrize(
    "spoil",
    [
        "UPDATE note SET content = 'no json'",
        "UPDATE note SET content = '[]'",
        "UPDATE note SET content = '{}'",
        "UPDATE note SET content = json_set(content, '$.started', 'never')",
        "UPDATE note SET content = json_set(content, '$.wonders', 1)",
        "UPDATE note SET content = json_remove(content, '$.frames')",
        "DROP TABLE note",
    ],
)
def test_work_whose_note_is_damaged_is_unsaved_work_of_nobody(journal: Journal, path: Path, spoil: str) -> None:
    journal.commit({"frames/a1.json": b"{}"}, note=JournalHeader("/projects/room.ilf", unsaved=False))
    journal._database.execute(spoil)
    journal.close()
    changed = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
    os.utime(path, (changed.timestamp(), changed.timestamp()))
    (left,) = find_recoverable_work(path.parent)  # nobody knows that it is saved: it is not taken away
    assert left.note == JournalHeader("", True, "", 0, "", changed, changed)


def test_a_full_disk_leaves_what_was_there_and_can_be_tried_again(journal: Journal) -> None:
    journal.commit({"frames/1.json": b"old", "arrays/1.png": b"1" * 5000})
    journal._database.execute("PRAGMA max_page_count = 20")
    with pytest.raises(ExportError, match="the disk is full"):
        journal.commit({"frames/1.json": b"new", "arrays/2.png": b"2" * 50_000}, drop=["arrays/1.png"])
    assert journal.names() == {"frames/1.json", "arrays/1.png"}
    assert journal.read("frames/1.json") == b"old"
    journal._database.execute("PRAGMA max_page_count = 1000000")
    journal.commit({"frames/1.json": b"new", "arrays/2.png": b"2" * 50_000}, drop=["arrays/1.png"])
    assert journal.names() == {"frames/1.json", "arrays/2.png"}


def test_a_file_that_was_taken_away_is_noticed_and_can_still_be_read(journal: Journal, path: Path) -> None:
    journal.commit({"frames/1.json": b"old"})
    shutil.rmtree(path.parent)
    with pytest.raises(ExportError, match="no longer exists"):
        journal.commit({"frames/1.json": b"new"})
    assert not journal.is_there
    assert journal.read("frames/1.json") == b"old"
    Journal(path).discard()  # its place is free for another


def test_a_damaged_file_gives_what_can_be_read_and_nothing_that_is_wrong(journal: Journal, path: Path) -> None:
    contents = {f"arrays/{number}.png": random.Random(number).randbytes(200 * number) for number in range(40)}
    journal.commit(contents)
    journal.close()
    whole = path.read_bytes()
    read_all = 0
    for seed in range(40):
        chance = random.Random(seed)
        spoilt, place = bytearray(whole), chance.randrange(len(whole))
        spoilt[place : place + 300] = chance.randbytes(len(spoilt[place : place + 300]))
        path.write_bytes(spoilt)
        read = 0
        with contextlib.suppress(InputError), contextlib.closing(Journal(path)) as damaged:
            for name in damaged.names():
                with contextlib.suppress(InputError):
                    assert damaged.read(name) == contents[name]
                    read += 1
        read_all += read
    assert read_all > 40 * 40 * 0.75


def _mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.skipif(os.name != "posix", reason="asks for permissions")
def test_no_other_user_may_read_it(journal: Journal, path: Path) -> None:
    journal.commit({"frames/1.json": b"{}"})
    log = path.with_name(f"{path.name}-wal")
    assert [_mode(made) for made in (path.parent, path, log)] == [0o700, 0o600, 0o600]


def test_what_is_taken_out_is_gone_from_the_file(journal: Journal, path: Path) -> None:
    secret = random.Random(0).randbytes(200)
    journal.commit({"arrays/1.png": secret * 50, "arrays/2.png": b"2" * 5000})
    journal.commit({}, drop=["arrays/1.png"])
    journal.close()
    assert secret not in path.read_bytes()


def test_names_that_are_none_are_passed_over(journal: Journal) -> None:
    journal.commit({"frames/1.json": b"{}"})
    journal._database.execute("INSERT INTO parts VALUES (NULL, 0, ''), (X'ff', 0, '')")
    assert journal.names() == {"frames/1.json"}


@pytest.mark.parametrize(
    "statement",
    [
        "CREATE TRIGGER more AFTER INSERT ON parts BEGIN DELETE FROM pieces; END",
        "CREATE VIEW other AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i FROM n",
        "ALTER TABLE parts ADD COLUMN more GENERATED ALWAYS AS (zeroblob(900000000))",
        "CREATE VIRTUAL TABLE other USING fts5(a)",
    ],
)
def test_a_journal_has_plain_tables_only(journal: Journal, path: Path, statement: str) -> None:
    journal.commit({"frames/1.json": b"{}"})
    journal._database.execute(statement)
    journal.close()
    with pytest.raises(InputError, match="Only plain tables are supported"):
        Journal(path)


def test_a_journal_whose_query_would_not_end_is_damaged(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ilf.io.sqlite_files._SECONDS", 0.0)
    monkeypatch.setattr("ilf.io.sqlite_files._SECONDS_PER_BYTE", 0.0)
    monkeypatch.setattr("ilf.io.sqlite_files.STEPS", 1)
    with pytest.raises(InputError, match="takes too long"):
        Journal(path)


def test_a_piece_that_is_used_a_million_times_fills_no_memory(
    journal: Journal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ilf.project.journal.MAX_FILE_BYTES", 10_000)
    journal.commit({"arrays/1.png": b"1" * 9000})
    assert journal.read("arrays/1.png") == b"1" * 9000
    journal._database.execute("UPDATE parts SET pieces = CAST(pieces || pieces AS BLOB)")
    with pytest.raises(InputError, match="is damaged"):
        journal.read("arrays/1.png")


def test_damage_that_is_no_text_is_told_of(journal: Journal, path: Path) -> None:
    journal.close()
    content = path.read_bytes()
    assert b"CREATE TABLE pieces" in content
    path.write_bytes(content.replace(b"CREATE TABLE pieces", b"CREATE TABLE \xffieces"))
    with pytest.raises(InputError, match="the file is damaged"):
        Journal(path)


def test_what_is_no_journal_is_said_and_left_as_it_is(path: Path) -> None:
    path.parent.mkdir()
    for content in (b"no journal at all" * 100, _of_another_program(path), *_of_other_schemas(path)):
        path.write_bytes(content)
        mode = path.stat().st_mode
        with pytest.raises(InputError, match=r"not a journal|has schema [02]; .* reads schema 1 only"):
            Journal(path)
        assert (path.read_bytes(), path.stat().st_mode) == (content, mode)
    path.unlink()
    path.mkdir()
    with pytest.raises(InputError, match="Could not read"):
        Journal(path)


def _of_another_program(path: Path) -> bytes:
    with contextlib.closing(sqlite3.connect(path)) as database:
        database.execute("CREATE TABLE notes (content TEXT)")
    content = path.read_bytes()
    path.unlink()
    return content


def _of_other_schemas(path: Path) -> Iterator[bytes]:
    for schema in (SCHEMA - 1, SCHEMA + 1):
        journal = Journal(path)
        journal._database.execute(f"PRAGMA user_version = {schema}")
        journal.close()
        yield path.read_bytes()
        path.unlink()
