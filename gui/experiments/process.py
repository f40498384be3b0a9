"""Experiments run in a process of their own: the window stays fluid, and they can be stopped at any moment."""

from __future__ import annotations

import tempfile
import traceback
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from ilf.errors import ExportError, IlfError, cause
from ilf.experiments import EXPERIMENTS, Progress, Settings, run_experiment, write_result
from ilf.experiments.sources import find_sources
from ilf.io.folders import made_folder
from ilf.lifeline import live_by
from ilf.processes import ProcessContext

_POLL_S = 0.1
"""Longest time until a wish to stop is noticed."""


@dataclass(frozen=True)
class Writing:
    """An experiment has been run; its files are being written."""

    experiment: str


@dataclass(frozen=True)
class Written:
    """An experiment's files are all there."""

    experiment: str


Message = Progress | Writing | Written


def run_apart(names: Sequence[str], settings: Settings, folder: Path) -> Generator[Message | None, None, None]:
    """Run experiments one after the other in another process, which writes their files into a folder.

    Closing the generator stops the process; files that are being written are finished first.

    Parameters
    ----------
    names : sequence of str
    settings : Settings
        `jobs` must be 1: a process that may be stopped has no others below it.
    folder : Path
        Made if it is not there.

    Yields
    ------
    Progress, Writing, Written or None
        None when there has been nothing to say for a while.

    Raises
    ------
    IlfError, OSError
        What the run ended on. A process that breaks off without a word is an IlfError too.
    """
    context = ProcessContext()
    receiving, sending = context.Pipe(duplex=False)
    lifeline, held = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(tuple(names), settings, folder, sending, lifeline), daemon=True)
    process.start()
    sending.close()
    lifeline.close()
    writing = False
    try:
        while True:
            if not receiving.poll(_POLL_S):
                yield None
                continue
            try:
                message = receiving.recv()
            except EOFError:
                break
            if isinstance(message, Exception):
                raise message
            writing = isinstance(message, Writing)
            yield message
        process.join()
        if process.exitcode:
            raise IlfError(
                f"The process that ran the experiments broke off (exit code {process.exitcode}). Memory may have run "
                "out: close other programs, or choose a quick run or fewer frames."
            )
    finally:
        receiving.close()  # so that a process that goes on to write ends right after it
        if not writing:
            process.terminate()
        process.join()
        process.close()
        held.close()


def _work(
    names: tuple[str, ...], settings: Settings, folder: Path, connection: Connection, lifeline: Connection
) -> None:
    live_by(lifeline.recv_bytes)
    try:
        # what is wrong with data or folder is said before anything is run
        if any(EXPERIMENTS[name].needs_frames for name in names):
            find_sources(settings)
        _check_writable(made_folder(folder))
        for name in names:
            connection.send(Progress(name, 0, 0))
            result = run_experiment(name, settings, connection.send)
            connection.send(Writing(name))
            write_result(result, EXPERIMENTS[name], folder)
            connection.send(Written(name))
    except BrokenPipeError:
        return  # nobody waits for it any more
    except (IlfError, OSError) as error:
        connection.send(error)
    except Exception as error:
        traceback.print_exc()
        connection.send(IlfError(f"{type(error).__name__}: {error}"))


def _check_writable(folder: Path) -> None:
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise ExportError(f"{folder} cannot be written into: {cause(error)}. Choose another folder.") from error
