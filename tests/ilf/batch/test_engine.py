"""What holds for every sink, a folder, shards, and shards at an address: nothing is done twice, nothing is lost."""

from pathlib import Path

import pytest

import ilf
from ilf.cli import main
from ilf.sources.opening import close_all

from ..batch_frames import contents
from .test_batch import FLAGS

fsspec = pytest.importorskip("fsspec")
parquet = pytest.importorskip("pyarrow.parquet")

KEYS = [f"rgb/000{number}" for number in range(5)]


class Out:
    """A place for results, and the command that completes frames into it."""

    def __init__(self, kind: str, folder: Path) -> None:
        self.kind = kind
        self.place = f"memory://{folder.name}/out" if kind == "address" else str(folder / "out")

    def command(self, source: Path, *more: str) -> list[str]:
        """Quiet, and the same settings each time."""
        where = ["--out", self.place] if self.kind == "folder" else ["--shards", self.place, "--per-shard", "2"]
        return ["batch", str(source), *where, "--quiet", *FLAGS[:-1], *more]

    def results(self) -> dict[str, bytes]:
        """The results of completed frames, which are the same however often the work was interrupted."""
        if self.kind == "address":
            store = fsspec.filesystem("memory")
            return {path.rpartition("/")[2]: store.cat(path) for path in store.glob(f"{self.place[8:]}/*.tar")}
        found = contents(Path(self.place))
        return {name: data for name, data in found.items() if name.endswith((".png", ".npy", ".tar"))}

    def rows(self) -> list[tuple[str, str]]:
        """The frames with their statuses, from the manifest or from the tables."""
        store = fsspec.filesystem("memory" if self.kind == "address" else "file")
        place = self.place[8:] if self.kind == "address" else self.place
        if self.kind == "folder":
            lines = store.cat(f"{place}/manifest.csv").decode().splitlines()[1:]
            return [(line.split(",")[0], line.split(",")[3]) for line in lines]
        found = []
        for path in sorted(store.glob(f"{place}/shard-*.parquet")):
            with store.open(path) as file:
                found += [(row["key"], row["status"]) for row in parquet.read_table(file).to_pylist()]
        return found


@pytest.fixture(params=["folder", "shards", "address"])
def kind(request):
    return str(request.param)


@pytest.fixture
def out(kind, tmp_path):
    yield Out(kind, tmp_path)
    fsspec.filesystem("memory").store.clear()
    close_all()


@pytest.fixture
def alone(kind, source, tmp_path, begun):
    """The results of a batch that nothing has disturbed."""
    out = Out(kind, tmp_path / "alone")
    assert main(out.command(source)) == 0
    begun.clear()
    return out.results()


def test_what_is_done_is_not_done_again(source, out, begun, alone):
    assert main(out.command(source, "--shard", "1/2")) == 0
    first = list(begun)
    assert 0 < len(first) < 5
    assert main(out.command(source)) == 0
    assert sorted(begun) == KEYS
    assert begun[: len(first)] == first
    assert main(out.command(source)) == 0
    assert len(begun) == 5
    assert out.results() == alone
    assert out.rows() == [(key, "completed") for key in KEYS]


def test_of_two_batches_in_one_place_with_other_settings_one_ends(source, out, begun, monkeypatch, capsys):
    complete, store = ilf.Run.complete, fsspec.filesystem("memory" if out.kind == "address" else "file")

    def disturbed(run, **how):
        """Another batch has seen nothing there, either."""
        monkeypatch.setattr(ilf.Run, "complete", complete)
        place = out.place.removeprefix("memory://")
        store.rm(f"{place}/{'batch' if out.kind == 'folder' else 'shards'}.json")
        assert main(out.command(source, "--extrapolate")) == 0
        return complete(run, **how)

    monkeypatch.setattr(ilf.Run, "complete", disturbed)
    assert main(out.command(source)) == 1
    assert "Another batch has begun in " in capsys.readouterr().err


def test_failed_frames_are_told_and_tried_again_on_request(source, out, begun, alone, capsys):
    damaged = source / "depth" / "0001.png"
    good = damaged.read_bytes()
    damaged.write_bytes(good[:40])
    assert main(out.command(source)) == 1
    assert "1 of 5 frames failed. rgb/0001: " in capsys.readouterr().err
    assert main(out.command(source)) == 1
    assert "1 of 5 frames failed." in capsys.readouterr().err
    assert begun == KEYS, "they wait for --retry-failed"
    assert out.rows() == [(key, "failed" if key == "rgb/0001" else "completed") for key in KEYS]
    assert main(out.command(source, "--retry-failed")) == 1
    assert begun[5:] == ["rgb/0001"]
    damaged.write_bytes(good)
    assert main(out.command(source, "--retry-failed")) == 0
    assert begun[6:] == ["rgb/0001"]
    assert out.results() == alone
