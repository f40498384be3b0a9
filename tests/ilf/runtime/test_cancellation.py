"""Work that is to stop stops, in all its threads, and writes nothing."""

import threading

import pytest

import ilf
from ilf._runtime import writing as being_written
from ilf._runtime.long_work import (
    acquired,
    cancelled_by,
    check_cancelled,
    run_beside,
    run_in_parallel,
    set_cancel_events,
)
from ilf._runtime.writing import move_into_place, remove_temporary_files, removed_on_exit, staging, write_bytes
from ilf.run.writing import write


@pytest.fixture
def cancel_event():
    return threading.Event()


def test_an_event_cancels_within_its_block_alone(cancel_event):
    with cancelled_by(cancel_event):
        check_cancelled()
        cancel_event.set()
        with pytest.raises(ilf.Cancelled):
            check_cancelled()
        with cancelled_by(threading.Event()), pytest.raises(ilf.Cancelled):
            check_cancelled()
    check_cancelled()


def test_work_beside_a_block_is_cancelled_with_it_and_its_error_is_raised_at_the_end(cancel_event):
    def until_cancelled():
        while not cancel_event.wait(0.001):
            pass
        check_cancelled()

    with cancelled_by(cancel_event), pytest.raises(ilf.Cancelled), run_beside(until_cancelled):
        cancel_event.set()
    with run_beside(lambda: 3) as found:
        pass
    assert found.result() == 3


def test_an_event_cancels_the_threads_that_share_the_work(cancel_event):
    begun, went_on = threading.Semaphore(0), threading.Event()

    def task():
        yield 0
        begun.release()
        while True:
            check_cancelled()
            went_on.wait(0.001)

    def stop():
        for _ in range(2):
            assert begun.acquire(timeout=20)
        cancel_event.set()

    stopping = threading.Thread(target=stop)
    stopping.start()
    with cancelled_by(cancel_event), pytest.raises(ilf.Cancelled):
        list(run_in_parallel([task(), task()], 2))
    stopping.join()


def test_whoever_waits_for_a_lock_stops_waiting(cancel_event):
    lock, ended = threading.Lock(), []

    def wait():
        set_cancel_events(cancel_event)
        try:
            with acquired(lock):
                pass
        except ilf.Cancelled:
            ended.append(True)

    with lock:
        thread = threading.Thread(target=wait)
        thread.start()
        cancel_event.set()
        thread.join(20)
        assert ended
    with acquired(lock):
        assert lock.locked()
    assert not lock.locked()


def test_nothing_is_written_by_what_is_to_stop(tmp_path, cancel_event):
    path = tmp_path / "notes.txt"
    write_bytes(path, b"before")
    cancel_event.set()
    with cancelled_by(cancel_event):
        with pytest.raises(ilf.Cancelled):
            write_bytes(path, b"after")
        with pytest.raises(ilf.Cancelled):
            _write_set(tmp_path / "new" / "folder")
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]


def _write_set(target):
    with staging(target) as folder:
        (folder / "a").touch()
        move_into_place(folder, target, ["a"])


def test_an_export_that_is_to_stop_leaves_the_set_before(tmp_path, small_frame, small_labels):
    run = ilf.Run(small_frame, small_labels, ilf.preset(max_iterations=2, correction=False))
    completion = run.complete()
    write(tmp_path, completion)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    for looks in range(0, 22, 6):
        with cancelled_by(_Late(looks)), pytest.raises(ilf.Cancelled):
            write(tmp_path, completion)
        assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    with cancelled_by(_Late(1000)):
        write(tmp_path, completion)


class _Late(threading.Event):
    """Is set after so many looks at it."""

    def __init__(self, looks):
        super().__init__()
        self._looks = looks

    def is_set(self):
        self._looks -= 1
        return self._looks < 0


def test_what_is_being_written_is_taken_away_at_a_sudden_end(tmp_path, monkeypatch):
    monkeypatch.setattr(being_written, "_moving", threading.Lock())
    made, kept = tmp_path / "made", tmp_path / "kept.txt"
    kept.touch()
    (made / "half").mkdir(parents=True)
    with removed_on_exit(made / "half", made), removed_on_exit(tmp_path / "half.txt"):
        (made / "half" / "depth.png").touch()
        (tmp_path / "half.txt").touch()
        remove_temporary_files()
    assert list(tmp_path.iterdir()) == [kept]
    assert being_written._moving.locked(), "nothing is moved any more"
