"""Random mutations of files, with some knowledge of their format."""

import copy
import io
import json
import re
import sqlite3
import zipfile
import zlib
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from typing import Any

import numpy as np

Rng = np.random.Generator
Mutation = Callable[[Rng, Sequence[bytes]], bytes]
"""Makes a damaged file from valid ones of the same format."""

_NUMBERS = (
    0, 1, 2, 7, 8, 127, 128, 255, 256, 32767, 65535, 65536, 2**24, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**64 - 1,
)  # fmt: skip
_WORDS = (
    b"", b"0", b"-1", b"1e-300", b"1e308", b"1e400", b"nan", b"inf", b"-inf", b"9" * 400, b"9" * 5000, b"0x7f",
    b"3.4e38", b"65535", b"4294967296", b"x" * 5000, b"../../../etc/passwd", b"a\nb", b"\0", b"\xff\xfe", b"-0.0",
    b"1e-45", b"\xc3\xa9",
)  # fmt: skip
_VALUES: tuple[Any, ...] = (
    None, True, False, 0, 1, -1, 0.5, -0.0, 2**31, 2**63, 2**64, 10**400, -(10**400), 1e-300, 1e308, 3.5e38,
    float("nan"), float("inf"), "", "x" * 5000, "../../../etc/passwd", "/dev/zero", "a\nb", "\0", "\ud800",
    "<b>bold</b>", "nan", [], {}, [[]], [0] * 1000, {"": None}, ["x"], [1e308, 1e308], "1" * 5000, 65535, 65536,
    1e10, 255.5,
)  # fmt: skip
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_PNG_HEAD = 8


def of_bytes(rng: Rng, seeds: Sequence[bytes]) -> bytes:
    """Flips, cuts, copies, fields with special numbers, numbers in text, and splices of two files."""
    content = bytearray(_one(rng, seeds))
    for _ in range(int(rng.integers(1, 5))):
        content = _OPERATIONS[int(rng.integers(len(_OPERATIONS)))](rng, content, seeds)
    return bytes(content)


def of_png(rng: Rng, seeds: Sequence[bytes]) -> bytes:
    """Like `of_bytes`, also inside compressed chunks, mostly with checksums that match the changed chunks."""
    if rng.random() < 0.3:
        return _with_other_pixels(rng, _one(rng, seeds))
    content = of_bytes(rng, seeds)
    return _with_checksums(content) if rng.random() < 0.7 else content


def of_json(rng: Rng, seeds: Sequence[bytes]) -> bytes:
    """Exchanged, missing, repeated or deeply nested values; or like `of_bytes`."""
    chance = rng.random()
    seed = _one(rng, seeds)
    if chance < 0.25:
        return of_bytes(rng, seeds)
    if chance < 0.27:
        depth = int(rng.choice([100, 900, 5000, 100_000]))
        at = int(rng.integers(len(seed)))
        return seed[:at] + b"[" * depth + b"]" * depth + seed[at:]
    tree = json.loads(seed)
    for _ in range(int(rng.integers(1, 4))):
        tree = _changed(rng, tree)
    return json.dumps(tree).encode()


def of_text(rng: Rng, seeds: Sequence[bytes]) -> bytes:
    """Exchanged, missing or repeated words; or like `of_bytes`."""
    if rng.random() < 0.3:
        return of_bytes(rng, seeds)
    words = re.split(rb"(\s+)", _one(rng, seeds))
    for _ in range(int(rng.integers(1, 4))):
        at, other = (int(rng.integers(max(len(words), 1))) for _ in range(2))
        word = _WORDS[int(rng.integers(len(_WORDS)))]
        words[at : at + 1] = ([word], [], words[at : at + 1] * 3, words[other : other + 1])[int(rng.integers(4))]
    return b"".join(words)


def of_zip(inner: Callable[[str], Mutation]) -> Mutation:
    """Mutation of archives: mostly damages one member and packs it again with a matching checksum.

    Parameters
    ----------
    inner : callable
        Returns the mutation for a member's name.
    """

    def mutate(rng: Rng, seeds: Sequence[bytes]) -> bytes:
        if rng.random() < 0.3:
            return of_bytes(rng, seeds)
        with zipfile.ZipFile(io.BytesIO(_one(rng, seeds))) as archive:
            members = {item.filename: (item.compress_type, archive.read(item)) for item in archive.infolist()}
        name = list(members)[int(rng.integers(len(members)))]
        kind, content = members[name]
        members[name] = kind, inner(name)(rng, [content]) if content else b"x"
        chance = rng.random()
        if chance < 0.1:
            del members[name]
        elif chance < 0.15:
            members[str(rng.choice(["../" + name, name * 50, "/" + name, ""]))] = members.pop(name)
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as archive:
            for name, (kind, content) in members.items():
                archive.writestr(zipfile.ZipInfo(name), content, kind)
        return packed.getvalue()

    return mutate


def of_sql(rng: Rng, seeds: Sequence[bytes]) -> bytes:
    """Mutation of SQLite files by statements on tables, values and definitions; the pages stay valid."""
    content = bytearray(_one(rng, seeds))
    content[18:20] = b"\1\1"  # a file with a log cannot be loaded into memory
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as database:
        database.deserialize(bytes(content))
        # some read tables that an earlier statement made endless
        database.set_progress_handler(lambda: True, 2_000_000)
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, 2**26)
        database.execute("PRAGMA writable_schema = ON")
        for _ in range(int(rng.integers(1, 4))):
            statements = _SQL[int(rng.integers(len(_SQL)))]
            with suppress(sqlite3.Error, ValueError):  # no table or column is left
                words = _sql_words(rng, database)
                for statement in statements:
                    database.execute(statement.format(**words))
        return database.serialize()


_ENDLESS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)"
_SQL_VALUES = (
    "NULL", "-1", "0", "9223372036854775807", "1e308", "9e999", "''", "x''", "x'ff'", "'nan'", "'../../x'",
    "zeroblob(5000000)", "CAST(zeroblob(100000) AS TEXT)", "char(0, 27, 10)",
)  # fmt: skip
_SQL = (
    ("DROP TABLE {table}", "CREATE VIEW {table} AS " + _ENDLESS + " SELECT i AS {column} FROM n"),
    ("DROP TABLE {table}", "CREATE VIEW {table} AS " + _ENDLESS + " SELECT max(i) AS {column} FROM n"),
    ("ALTER TABLE {table} RENAME TO kept", "CREATE VIEW {table} AS SELECT * FROM kept"),
    ("ALTER TABLE {table} DROP COLUMN {column}", "ALTER TABLE {table} ADD COLUMN {column} AS (zeroblob(900000000))"),
    ("ALTER TABLE {table} DROP COLUMN {column}", "ALTER TABLE {table} ADD COLUMN {column} AS ({value})"),
    ("DROP TABLE {table}", "CREATE VIRTUAL TABLE {table} USING fts5({column})"),
    ("CREATE TRIGGER more AFTER INSERT ON {table} BEGIN DELETE FROM {table}; END",),
    ("INSERT INTO {table} ({columns}) SELECT {columns} FROM {table}, (" + _ENDLESS + " SELECT i FROM n LIMIT 20000)",),
    ("UPDATE {table} SET {column} = {value}",),
    ("UPDATE {table} SET {column} = {value} WHERE rowid = (SELECT min(rowid) FROM {table})",),
    ("UPDATE {table} SET {column} = {value} WHERE rowid = (SELECT max(rowid) FROM {table})",),
    ("UPDATE {table} SET {column} = (SELECT {column} FROM {table} ORDER BY rowid DESC)",),
    ("DELETE FROM {table}",),
    ("DROP TABLE {table}",),
    ("ALTER TABLE {table} RENAME COLUMN {column} TO other",),
    ("ALTER TABLE {table} DROP COLUMN {column}",),
    ("UPDATE sqlite_master SET rootpage = {number} WHERE name = '{table}'",),
    ("UPDATE sqlite_master SET sql = CAST(replace(sql, '{column}', '{column} AS ({value})') AS BLOB)",),
    ("UPDATE sqlite_master SET sql = replace(sql, 'NOT NULL', 'COLLATE other') WHERE name = '{table}'",),
    ("CREATE TABLE more AS SELECT * FROM {table}", "CREATE INDEX some ON {table} (length({column}))"),
    ("ANALYZE", "UPDATE sqlite_stat1 SET stat = '{number} {number}'"),
    ("PRAGMA user_version = {number}",),
)
"""Sequences of statements about a table and one of its columns."""


def _sql_words(rng: Rng, database: sqlite3.Connection) -> dict[str, object]:
    """Values for the placeholders in `_SQL`."""

    def one(of: Sequence[Any]) -> Any:
        return of[int(rng.integers(len(of)))]

    table = one([row[0] for row in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")])
    columns = [(row[1], row[5]) for row in database.execute(f"PRAGMA table_info({table})")]
    return {
        "table": table,
        "column": one(columns)[0],
        "columns": ", ".join(name for name, is_key in columns if not is_key),
        "value": one(_SQL_VALUES),
        "number": one((0, 1, 2, 3, 4, 5, 99, 2**31 - 1)),
    }


def _one(rng: Rng, seeds: Sequence[bytes]) -> bytes:
    return seeds[int(rng.integers(len(seeds)))]


def _place(rng: Rng, content: bytearray) -> int:
    """Random position, half of the time near the beginning, where headers are."""
    most = min(len(content), 256) if rng.random() < 0.5 else len(content)
    return int(rng.integers(max(most, 1)))


def _flip(rng: Rng, content: bytearray, seeds: Sequence[bytes]) -> bytearray:
    for _ in range(int(rng.integers(1, 9)) if content else 0):
        content[_place(rng, content)] ^= 1 << int(rng.integers(8))
    return content


def _cut(rng: Rng, content: bytearray, seeds: Sequence[bytes]) -> bytearray:
    return content[: _place(rng, content)] if rng.random() < 0.5 else content[: -int(rng.integers(1, 17))]


def _drop(rng: Rng, content: bytearray, seeds: Sequence[bytes]) -> bytearray:
    at = _place(rng, content)
    del content[at : at + int(rng.integers(1, 65))]
    return content


def _repeat(rng: Rng, content: bytearray, seeds: Sequence[bytes]) -> bytearray:
    at = _place(rng, content)
    piece = content[at : at + int(rng.integers(1, 65))]
    content[at:at] = piece * int(rng.choice([1, 2, 30]))
    return content


def _fill(rng: Rng, content: bytearray, seeds: Sequence[bytes]) -> bytearray:
    at, size = _place(rng, content), int(rng.integers(1, 33))
    content[at : at + size] = rng.bytes(size) if rng.random() < 0.5 else bytes([int(rng.choice([0, 255, 127]))]) * size
    return content


def _field(rng: Rng, content: bytearray, seeds: Sequence[bytes]) -> bytearray:
    """A number of 1 to 8 bytes in either byte order."""
    at, size = _place(rng, content), int(rng.choice([1, 2, 4, 8]))
    value = _NUMBERS[int(rng.integers(len(_NUMBERS)))] & (256**size - 1)
    content[at : at + size] = value.to_bytes(size, "little" if rng.random() < 0.5 else "big")
    return content


def _near(rng: Rng, content: bytearray, seeds: Sequence[bytes]) -> bytearray:
    """Change a byte slightly, as in lengths and counts."""
    if content:
        at = _place(rng, content)
        content[at] = (content[at] + int(rng.choice([-2, -1, 1, 2]))) % 256
    return content


def _text_number(rng: Rng, content: bytearray, seeds: Sequence[bytes]) -> bytearray:
    found = list(_NUMBER.finditer(content[:100_000]))
    if not found:
        return _field(rng, content, seeds)
    match = found[int(rng.integers(len(found)))]
    content[match.start() : match.end()] = _WORDS[int(rng.integers(len(_WORDS)))]
    return content


def _splice(rng: Rng, content: bytearray, seeds: Sequence[bytes]) -> bytearray:
    other = _one(rng, seeds)
    return content[: _place(rng, content)] + other[int(rng.integers(len(other))) :]


_OPERATIONS = (_flip, _flip, _cut, _drop, _repeat, _fill, _field, _field, _near, _text_number, _splice)


def _with_other_pixels(rng: Rng, content: bytes) -> bytes:
    """Damage the rows of a PNG with their filters, and pack them again."""
    begin = content.find(b"IDAT") - 4
    end = begin + 12 + int.from_bytes(content[begin : begin + 4], "big")
    if begin < 0:  # not a PNG: a format may have several file types
        return of_bytes(rng, [content])
    try:
        rows = zlib.decompress(content[begin + 8 : end - 4])
    except zlib.error:  # its rows lie in several chunks
        return of_bytes(rng, [content])
    packed = zlib.compress(of_bytes(rng, [rows]))
    chunk = len(packed).to_bytes(4, "big") + b"IDAT" + packed + bytes(4)
    return _with_checksums(content[:begin] + chunk + content[end:])


def _with_checksums(content: bytes) -> bytes:
    at, out = _PNG_HEAD, bytearray(content[:_PNG_HEAD])
    while at + 12 <= len(content):
        size = int.from_bytes(content[at : at + 4], "big")
        chunk = content[at + 4 : at + 8 + size]
        if at + 12 + size > len(content):
            break
        out += content[at : at + 4] + chunk + zlib.crc32(chunk).to_bytes(4, "big")
        at += 12 + size
    return bytes(out + content[at:])


def _changed(rng: Rng, tree: Any) -> Any:
    """The same JSON with one value exchanged, removed, repeated or renamed."""
    if isinstance(tree, dict | list) and tree and rng.random() < 0.85:
        keys = list(tree) if isinstance(tree, dict) else list(range(len(tree)))
        key = keys[int(rng.integers(len(keys)))]
        chance = rng.random()
        if chance < 0.8:
            tree[key] = _changed(rng, tree[key])
        elif chance < 0.9:
            del tree[key]
        elif isinstance(tree, list):
            tree.insert(key, tree[key])
        else:
            tree[keys[int(rng.integers(len(keys)))]] = copy.deepcopy(tree[key])
        return tree
    return copy.deepcopy(_VALUES[int(rng.integers(len(_VALUES)))])
