"""The journal: an autosave file with the parts of a project, which survives a crash of the program."""

from __future__ import annotations

import hashlib
import json
import os
import socket
import sqlite3
import threading
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Self
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import MAX_FILE_BYTES, parse_json
from .._runtime.installation import __version__
from .._runtime.schema import check_schema, converted
from .._runtime.writing import private_file, remedy
from ..errors import ExportError, FormatError, InputError
from ..io.sqlite_files import DEFINITIONS, LimitedConnection, check_plain
from .packing import chunks

# Deduplication: the parts of a journal consist of pieces; equal pieces are stored once.

Numbers = NDArray[np.int64]
"""Numbers of the pieces of a part, in order."""


@dataclass(frozen=True, eq=False)
class Change:
    """A change of the pieces when parts are added, replaced and removed.

    Attributes
    ----------
    parts : dict of str to ndarray of int64
        The added and replaced parts, with the numbers of their pieces.
    made : dict of int to bytes
        New pieces.
    gone : frozenset of int
        Pieces that no part uses any more.
    """

    parts: dict[str, Numbers]
    made: dict[int, bytes]
    gone: frozenset[int]
    _dropped: frozenset[str]
    _numbers: dict[bytes, int]
    _uses: Counter[int]


class Pieces:
    """The index of the pieces of all parts.

    Parameters
    ----------
    parts : mapping of str to ndarray of int64
        The existing parts; their pieces are not compared with new ones.

    Examples
    --------
    >>> pieces = Pieces()
    >>> change = pieces.change({"a": b"one", "b": b"one", "c": b"two"}, drop=[])
    >>> sorted(change.made.values())
    [b'one', b'two']
    >>> pieces.take(change)
    >>> sorted(pieces.change({"a": b"two"}, drop=["b"]).gone) == [int(change.parts["a"][0])]
    True
    """

    def __init__(self, parts: Mapping[str, Numbers] | None = None) -> None:
        self._parts = dict(parts or {})
        self._uses = Counter(number for numbers in self._parts.values() for number in numbers.tolist())
        self._numbers: dict[bytes, int] = {}
        """Digest of a piece's content -> its number."""
        self._next = max(self._uses, default=0) + 1

    def change(self, put: Mapping[str, bytes], drop: Collection[str]) -> Change:
        """Return the change for new and removed parts; `take` applies it."""
        dropped = frozenset(drop) - put.keys()
        uses: Counter[int] = Counter()
        for name in dropped | put.keys():
            uses.subtract(self._parts[name].tolist() if name in self._parts else ())
        made: dict[int, bytes] = {}
        numbers: dict[bytes, int] = {}
        parts = {}
        for name, content in put.items():
            parts[name] = np.array([self._number(piece, made, numbers) for piece in _cut(name, content)], np.int64)
            uses.update(parts[name].tolist())
        gone = frozenset(number for number, more in uses.items() if self._uses[number] + more <= 0)
        return Change(parts, made, gone, dropped, numbers, uses)

    def take(self, change: Change) -> None:
        """Apply a change."""
        for name in change._dropped:
            self._parts.pop(name, None)
        self._parts |= change.parts
        self._numbers |= change._numbers
        self._uses.update(change._uses)
        self._next += len(change.made)
        if change.gone:
            self._numbers = {digest: number for digest, number in self._numbers.items() if number not in change.gone}
            for number in change.gone:
                del self._uses[number]

    def _number(self, piece: bytes, made: dict[int, bytes], numbers: dict[bytes, int]) -> int:
        digest = hashlib.blake2b(piece, digest_size=20).digest()
        known = self._numbers.get(digest) or numbers.get(digest)
        if known is not None:
            return known
        number = numbers[digest] = self._next + len(made)
        made[number] = piece
        return number


def _cut(name: str, content: bytes) -> Iterator[bytes]:
    return chunks(content) if name.endswith(".png") else iter([content] if content else [])


SCHEMA = 1
_APPLICATION = 0x494C464A  # "ILFJ"
_WAIT_S = 2.0
# small pages, since changes are small; the log is merged from 4 MB on; deleted content is overwritten
_SETTINGS = """
    PRAGMA page_size = 1024;
    PRAGMA locking_mode = EXCLUSIVE;
    PRAGMA secure_delete = ON;
    PRAGMA wal_autocheckpoint = 4000;
    PRAGMA journal_size_limit = 8000000;
    PRAGMA synchronous = FULL;
    PRAGMA fullfsync = ON;
"""
_TABLES = f"""
    BEGIN IMMEDIATE;
    CREATE TABLE parts (name TEXT PRIMARY KEY, checksum INTEGER NOT NULL, pieces BLOB NOT NULL);
    CREATE TABLE pieces (id INTEGER PRIMARY KEY, content BLOB NOT NULL);
    CREATE TABLE note (content TEXT NOT NULL);
    PRAGMA application_id = {_APPLICATION};
    PRAGMA user_version = {SCHEMA};
    COMMIT;
"""
_REASONS = {
    "SQLITE_FULL": "the disk is full. Free some space",
    "SQLITE_READONLY": "writing is not permitted there",
    "SQLITE_CANTOPEN": "its folder does not exist, or writing is not permitted in it",
    "SQLITE_IOERR": "the drive reports an error",
    "SQLITE_CORRUPT": "the file is damaged",
    "SQLITE_NOTADB": "the file is damaged or not a journal",
    "SQLITE_INTERRUPT": "the file is damaged, and reading it takes too long",
}


class JournalInUse(InputError):
    """The journal is in use by another window."""


def _now() -> datetime:
    return datetime.now(UTC)


@dataclass(frozen=True)
class JournalHeader:
    """Origin and times of the work in a journal.

    Attributes
    ----------
    project : str
        Path of the project file; "" if there is none yet.
    unsaved : bool
        Whether the journal contains work that the project file does not.
    frames : tuple of str or None
        Ids of the frames with such work; None if not recorded.
    host : str
        Name of the machine that the window runs on.
    process : int
        Process id of the window.
    program : str
        Version of the program.
    started, changed : datetime
        Creation of the journal, and the last commit.
    """

    project: str = ""
    unsaved: bool = True
    host: str = field(default_factory=socket.gethostname)
    process: int = field(default_factory=os.getpid)
    program: str = __version__
    started: datetime = field(default_factory=_now)
    changed: datetime = field(default_factory=_now)
    frames: tuple[str, ...] | None = None

    def to_json(self) -> str:
        """Encode as JSON for `from_json`."""
        times = {"started": self.started.isoformat(), "changed": self.changed.isoformat()}
        return json.dumps({**asdict(self), **times})

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Decode the JSON of `to_json`; raises FormatError, ValueError or TypeError for anything else."""
        values = parse_json(text, "The journal's note")
        return cls(**values | vars(converted(values, cls, "journal's note")))  # refuses unknown names


class Journal:
    """A window's SQLite file with the parts of a project; commits are atomic.

    Images that differ in a few strips share the other strips, so unchanged strips are not written again. The file is
    locked while it is open; the lock ends with the process. Thread-safe.

    Parameters
    ----------
    path : path-like
        Created with its folders if missing. Only the user may read it.

    Raises
    ------
    JournalInUse
        If another window, of this process or another, has it open.
    InputError
        If the file is not a journal, is damaged, or has another schema.
    ExportError
        If it cannot be created or written.

    Examples
    --------
    >>> journal = Journal("work.journal")
    >>> journal.commit({"frames/1.json": b"{}", "arrays/2.png": b"..."})
    >>> journal.commit({"frames/1.json": b"[]"}, drop=["arrays/2.png"])
    >>> sorted(journal.names()), journal.read("frames/1.json")
    (['frames/1.json'], b'[]')
    >>> journal.discard()
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path).absolute()
        self._lock = threading.RLock()
        self._pieces: Pieces | None = None
        """Index of the stored pieces; read before the first commit."""
        there = self.path.exists()
        # wait for a brief lock on a new file, but not for a window that uses an existing one
        wait = 0.0 if there else _WAIT_S
        with self._translated_errors(reading=there):
            private_file(self.path)
            self._database = sqlite3.connect(
                self.path, timeout=wait, isolation_level=None, check_same_thread=False, factory=LimitedConnection
            )
        try:
            with self._translated_errors(reading=True):
                self._open()
            self._file = _identity(self.path)
        except BaseException:
            self._database.close()
            raise

    def _open(self) -> None:
        database = self._database
        database.executescript(_SETTINGS)
        (application,), (schema,) = (
            database.execute(f"PRAGMA {name}").fetchone() for name in ("application_id", "user_version")
        )
        if application == 0 and not database.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
            with self._translated_errors(reading=False):
                database.execute("PRAGMA journal_mode = WAL")
                database.executescript(_TABLES)
            self.note = JournalHeader()
            return
        if application != _APPLICATION:
            raise InputError(f"{self.path} is not a journal of this program.")
        check_schema({"schema": schema}, SCHEMA, f"journal {self.path}")
        check_plain(self.path, database.execute(DEFINITIONS))
        self.note = self._read_note()

    def _read_note(self) -> JournalHeader:
        try:
            row = self._database.execute("SELECT content FROM note").fetchone()
            return JournalHeader() if row is None else JournalHeader.from_json(row[0])
        except (sqlite3.DatabaseError, FormatError, ValueError, TypeError):
            changed = datetime.fromtimestamp(self.path.stat().st_mtime, UTC)
            return JournalHeader("", True, "", 0, "", changed, changed)

    @property
    def is_there(self) -> bool:
        """Whether the path still leads to the open file."""
        try:
            return _identity(self.path) == self._file
        except OSError:
            return False

    def names(self) -> frozenset[str]:
        """Return all names; of a damaged file those that can be read."""
        with self._lock:
            return frozenset(self._names())

    def _names(self) -> Iterator[str]:
        # each query stops at the damage; together they find the names before and after it, and those in the index
        for way in ("ORDER BY rowid", "ORDER BY rowid DESC", "ORDER BY name"):
            try:
                for (name,) in self._database.execute(f"SELECT name FROM parts {way}"):
                    if isinstance(name, str):  # a damaged file may contain other types
                        yield name
            except sqlite3.DatabaseError:
                continue
            return

    def read(self, name: str) -> bytes:
        """Read the bytes of a part; raises InputError if there is no such part or it is damaged."""
        with self._lock:
            row = self._row(name)
            content = None if row is None else self._joined(row[1])
        if row is None:
            raise InputError(f"{self.path} has no part {name}.")
        if content is None or crc32(content) != row[0]:
            raise InputError(f"The part {name} of {self.path} is damaged.")
        return content

    def _row(self, name: str) -> tuple[int, bytes] | None:
        """Return checksum and pieces of a part."""
        damaged = None
        for found in ("name = ?", "+name = ?"):  # by the index, or by a full scan
            try:
                row: tuple[int, bytes] | None
                row = self._database.execute(f"SELECT checksum, pieces FROM parts WHERE {found}", (name,)).fetchone()
                return row
            except sqlite3.DatabaseError as error:
                damaged = error
        raise InputError(f"The part {name} of {self.path} is damaged.") from damaged

    def _joined(self, pieces: bytes) -> bytes | None:
        """Join the content of pieces; None if one cannot be read, or the result exceeds the maximum file size."""
        try:
            numbers, read = np.frombuffer(pieces, np.int64).tolist(), self._database.execute
            content = bytearray()
            for number in numbers:
                content += read("SELECT content FROM pieces WHERE id = ?", (number,)).fetchone()[0]
                if len(content) > MAX_FILE_BYTES:  # a small file may repeat the same piece a million times
                    return None
            return bytes(content)
        except (sqlite3.DatabaseError, TypeError, ValueError):
            return None

    def commit(self, put: Mapping[str, bytes], drop: Collection[str] = (), note: JournalHeader | None = None) -> None:
        """Store and remove parts and update the note, atomically, even on a power cut.

        Raises
        ------
        ExportError
            If the journal cannot be written; its content is then unchanged.
        """
        if not self.is_there:
            raise ExportError(f"{self.path} no longer exists: it was moved or deleted, or its drive was removed.")
        note = replace(self.note if note is None else note, changed=_now())
        with self._lock, self._translated_errors(reading=False):
            if self._pieces is None:
                rows = self._database.execute("SELECT name, pieces FROM parts")
                self._pieces = Pieces({name: np.frombuffer(numbers, np.int64) for name, numbers in rows})
            change = self._pieces.change(put, drop)
            self._write(change, put, drop, note)
            self._pieces.take(change)
        self.note = note

    def _write(self, change: Change, put: Mapping[str, bytes], drop: Collection[str], note: JournalHeader) -> None:
        with _transaction(self._database) as database:
            gone = [(name,) for name in {*drop} - put.keys()]
            database.executemany("DELETE FROM parts WHERE name = ?", gone)
            database.executemany("DELETE FROM pieces WHERE id = ?", [(piece,) for piece in change.gone])
            database.executemany("INSERT INTO pieces VALUES (?, ?)", change.made.items())
            rows = [(name, crc32(put[name]), numbers.tobytes()) for name, numbers in change.parts.items()]
            database.executemany("INSERT OR REPLACE INTO parts VALUES (?, ?, ?)", rows)
            database.execute("DELETE FROM note")
            database.execute("INSERT INTO note VALUES (?)", (note.to_json(),))

    def close(self) -> None:
        """Close the file; parts can no longer be read."""
        with self._lock:
            self._database.close()

    def discard(self) -> None:
        """Close and delete the file."""
        there = self.is_there
        self.close()
        if there:
            for path in (self._log, self.path):
                path.unlink(missing_ok=True)

    @property
    def _log(self) -> Path:
        """Path of SQLite's write-ahead log beside the file, which has the file's permissions."""
        return self.path.with_name(f"{self.path.name}-wal")

    @contextmanager
    def _translated_errors(self, reading: bool) -> Iterator[None]:
        """Translate errors of SQLite and the file system into errors with a message for the user."""
        try:
            yield
        except (sqlite3.Error, UnicodeDecodeError) as error:
            # the library's message may contain a damaged name that cannot be decoded
            is_no_text = isinstance(error, UnicodeDecodeError)
            name = "SQLITE_CORRUPT" if is_no_text else getattr(error, "sqlite_errorname", "")
            if name.startswith(("SQLITE_BUSY", "SQLITE_LOCKED")):
                raise JournalInUse(f"Another window is using {self.path}.") from error
            reason = next((text for code, text in _REASONS.items() if name.startswith(code)), str(error))
            kind, what = (InputError, "read") if reading else (ExportError, "write")
            raise kind(f"Could not {what} {self.path}: {reason}.") from error
        except OSError as error:
            raise ExportError(f"Could not write {self.path}: {remedy(error)}.") from error


@contextmanager
def _transaction(database: sqlite3.Connection) -> Iterator[sqlite3.Connection]:
    database.execute("BEGIN IMMEDIATE")
    try:
        yield database
        database.execute("COMMIT")
    except BaseException:
        if database.in_transaction:  # some errors have ended it already
            database.execute("ROLLBACK")
        raise


def _identity(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_dev, status.st_ino
