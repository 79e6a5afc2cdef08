"""Stores: chunks that are whole or not there, damage, full and read-only disks, other studies, and no way out."""

import errno
import hashlib
import io
import json
import os
import re
import resource
import shutil
import signal
import sys
from pathlib import Path

import h5py
import jax
import numpy as np
import pytest
import xarray

import lobex
from lobex.studies import charts
from lobex.studies import store as stores
from lobex.studies.manifest import decode, encode
from lobex.studies.slabs import checksum, from_bytes, to_bytes
from lobex.studies.store import Damage, Store
from lobex.studies.study import Study

METHOD = lobex.Chebyshev(16)
SPEED, GAIN = np.linspace(300, 700, 5), np.linspace(0, 4e6, 4)
RUB = lobex.Rub(lobex.Rod(2).modes(0.03))
OVER = {"modes.damping_ratio": [0.01, 0.02, 0.03, 0.05, 0.08, 0.1]}


def run(folder, **changes):
    """The study of this file, in a store."""
    arguments = {"speed": SPEED, "gain": GAIN, "method": METHOD, "over": OVER} | changes
    return lobex.sweep(RUB, arguments.pop("speed"), arguments.pop("gain"), **arguments, store=folder)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("finished") / "s"
    run(folder)
    return folder


@pytest.fixture
def folder(finished, tmp_path):
    """A copy of the finished store."""
    return Path(shutil.copytree(finished, tmp_path / "s"))


def contents(folder):
    """Every file by name: the names carry the checksums."""
    return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def chunks(folder):
    return sorted(Path(folder).glob("0*.nc"))


def test_a_store_is_the_same_to_the_byte_when_it_is_made_again(finished, tmp_path):
    run(tmp_path / "again")
    assert contents(tmp_path / "again") == contents(finished)
    assert len(contents(finished)) == 7
    for path in chunks(finished):
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        assert re.fullmatch(rf"\d{{8}}-{digest[:16]}\.nc", path.name)


def test_every_chunk_is_a_result_of_its_own(finished):
    charts = [lobex.load(path) for path in chunks(finished)]
    study = Study.open(finished)
    for i, chart in enumerate(charts):
        np.testing.assert_array_equal(chart.multiplier, study["multiplier"][i])
        assert chart.process["modes"]["damping_ratio"] == [OVER["modes.damping_ratio"][i]] * 2


def test_a_finished_store_is_read_and_not_computed(finished, monkeypatch):
    before = contents(finished)
    monkeypatch.setattr(charts.grids, "sweep", None)
    again = run(finished)
    assert contents(finished) == before
    assert again["multiplier"].shape == (6, 5, 4)


@pytest.mark.parametrize("kind", ["flip", "truncate", "empty", "remove", "swap"])
def test_damaged_chunks_are_found_and_made_again(kind, folder, finished):
    victim, other = chunks(folder)[2], chunks(folder)[4]
    content = bytearray(victim.read_bytes())
    random = np.random.default_rng(3)
    if kind == "flip":
        for path in (victim, other):
            content = bytearray(path.read_bytes())
            content[random.integers(len(content))] ^= 1 << random.integers(8)
            path.write_bytes(content)
    elif kind == "truncate":
        victim.write_bytes(content[: len(content) // 2])
    elif kind == "empty":
        victim.write_bytes(b"")
    elif kind == "swap":
        shutil.copy(other, victim)
    else:
        victim.unlink()
    if kind == "remove":
        with pytest.raises(ValueError, match="5 of 6 chunks"):
            Study.open(folder)
        run(folder)
    else:
        with pytest.raises(Damage, match=r"chunk [24] .* is damaged"):
            np.asarray(Study.open(folder)["multiplier"])
        with pytest.warns(lobex.SweepWarning, match=f"{1 + (kind == 'flip')} of 6 chunks .* damaged .* first chunk 2"):
            run(folder)
    assert contents(folder) == contents(finished)


def test_a_chunk_of_another_store_is_no_chunk_of_this_one(folder, tmp_path):
    run(tmp_path / "other", gain=GAIN + 1)
    victim = chunks(folder)[3]
    victim.unlink()
    stranger = chunks(tmp_path / "other")[3]
    shutil.copy(stranger, folder)
    with pytest.raises(Damage, match="of another study"):
        np.asarray(Study.open(folder)["multiplier"])


def test_a_chunk_that_lacks_a_field_is_told(folder):
    victim = chunks(folder)[2]
    content = to_bytes(from_bytes(victim.read_bytes()).drop_vars("speed"))
    victim.unlink()
    (folder / f"00000002-{checksum(content)}.nc").write_bytes(content)
    study = Study.open(folder)
    with pytest.raises(Damage, match=r"chunk 2 .* is damaged \(it has no variable 'speed'"):
        study.at(2)


@pytest.mark.parametrize("place", ["x" * 300, 5, 2.5, b"study", ["study"], "a\0b", ""])
def test_a_store_that_is_no_path_is_refused_in_one_line(place):
    for call in (run, Study.open):
        with pytest.raises(ValueError, match=r"^store = .*; give the (path of a )?folder") as error:
            call(place)
        assert "\n" not in str(error.value)


def test_a_chunk_under_another_number_is_not_taken_for_it(folder):
    first, second = chunks(folder)[:2]
    content = second.read_bytes()
    first.unlink()
    (folder / f"00000000-{checksum(content)}.nc").write_bytes(content)
    store = Store.open(folder)
    with pytest.raises(Damage, match="another chunk"):
        store.read(0, store.present())


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"gain": GAIN * 1.5}, "settings.gain[1] = "),
        ({"speed": SPEED[:-1]}, "number of values in speed = 5 in the store and 4 here"),
        ({"method": lobex.Chebyshev(18)}, "settings.method.nodes = 16 in the store and 18 here"),
        ({"over": {"modes.damping_ratio": [0.01, 0.02, 0.03, 0.05, 0.08, 0.2]}}, "over.modes.damping_ratio[5] = 0.1"),
        ({"over": {"modes.shape[0,0]": [1.0]}}, "over.modes.shape[0,0] is missing"),
    ],
)
def test_another_study_is_refused_by_its_first_difference(changes, words, folder):
    before = contents(folder)
    with pytest.raises(ValueError) as error:
        run(folder, **changes)
    assert "holds another study" in str(error.value)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
    assert contents(folder) == before


def test_another_model_verb_or_version_is_refused(folder, monkeypatch):
    heavier = lobex.Rub(lobex.Rod(2, density=5000.0).modes(0.03))
    with pytest.raises(ValueError, match=r"model.first.modes.angular_frequency\[0\] = "):
        lobex.sweep(heavier, SPEED, GAIN, METHOD, over=OVER, store=folder)
    with pytest.raises(ValueError, match="verb = 'sweep' in the store and 'critical_gain' here"):
        lobex.critical_gain(RUB, SPEED, (0.0, 1.0), METHOD, over=OVER, store=folder)
    monkeypatch.setattr("lobex.studies.manifest.version", lambda name: "0.0.1")
    with pytest.raises(ValueError, match=r"versions.lobex = "):
        run(folder)


def test_a_model_that_cannot_be_told_is_refused(tmp_path):
    @jax.tree_util.register_static
    class Method:
        def operator(self, system):
            return METHOD.operator(system)

    with pytest.raises(ValueError, match="cannot be told in plain numbers"):
        run(tmp_path / "s", method=Method())
    assert not (tmp_path / "s").exists()


def test_a_store_without_its_manifest_is_refused(folder):
    (folder / stores.MANIFEST).unlink()
    for call in (lambda: run(folder), lambda: Study.open(folder)):
        with pytest.raises(ValueError, match=r"has no manifest\.json; restore that file"):
            call()
    assert len(chunks(folder)) == 6


def test_a_changed_byte_of_the_manifest_is_never_another_study(folder):
    path = folder / stores.MANIFEST
    whole = path.read_bytes()
    meant = json.loads(whole)
    random = np.random.default_rng(5)
    refused = 0
    for place in random.integers(len(whole), size=200):
        content = bytearray(whole)
        content[place] ^= 1 << random.integers(7)
        path.write_bytes(content)
        try:
            opened = Store.open(folder)
        except ValueError:
            refused += 1
        else:
            # White space may change.
            assert opened.manifest == meant
    assert refused > 100
    path.write_bytes(b"[" * 100_000)
    with pytest.raises(ValueError, match="no JSON text"):
        run(folder)


def test_other_files_are_not_mixed_with_a_store(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ValueError, match="is not empty"):
        run(tmp_path)
    with pytest.raises(ValueError, match="is not a folder"):
        run(tmp_path / "notes.txt")
    with pytest.raises(ValueError, match=r"cannot be written"):
        run(tmp_path / "notes.txt" / "s")
    with pytest.raises(ValueError, match=r"cannot be written"):
        run("/proc/lobex/s")
    assert [p.name for p in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize("call", ["fsync", "replace"])
@pytest.mark.parametrize("when", [0, 2, 5])
def test_a_full_disk_stops_with_one_line_and_the_store_goes_on(call, when, finished, tmp_path, monkeypatch):
    folder = tmp_path / "s"
    original, calls = getattr(os, call), []

    def full(*arguments):
        calls.append(arguments)
        if len(calls) > when:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return original(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(stores.os, call, full)
        with pytest.raises(
            ValueError, match=r"cannot be written.*No space left on device.*run the same again"
        ) as error:
            run(folder)
    assert "\n" not in str(error.value)
    assert not list(folder.glob(".*"))
    run(folder)
    assert contents(folder) == contents(finished)


def test_a_file_that_the_system_cuts_short_is_not_a_chunk(finished, tmp_path):
    """The system itself stops the writing in the midst of a file."""
    folder = tmp_path / "s"
    largest = max(len(content) for name, content in contents(finished).items() if name != stores.MANIFEST)
    run(folder, over=OVER)
    for path in chunks(folder)[3:]:
        path.unlink()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest // 2, hard))
        with pytest.raises(ValueError, match=r"cannot be written.*File too large"):
            run(folder)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)
    assert len(chunks(folder)) == 3
    assert not list(folder.glob(".*"))
    run(folder)
    assert contents(folder) == contents(finished)


def test_a_read_only_folder_is_refused_before_computing_and_can_be_read(folder, monkeypatch):
    chunks(folder)[1].unlink()

    def read_only(*_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "touch", read_only)
        patch.setattr(charts.grids, "sweep", None)
        with pytest.raises(ValueError, match=r"cannot be written.*Read-only file system"):
            run(folder)
    run(folder)
    monkeypatch.setattr(Path, "touch", read_only)
    monkeypatch.setattr(stores, "_write", read_only)
    assert np.isfinite(run(folder)["spectral_radius"]).all()


def test_an_interruption_waits_for_the_chunk_and_keeps_it(finished, tmp_path, monkeypatch):
    folder, swept = tmp_path / "s", []
    sweep = charts.grids.sweep

    def interrupted(*arguments, **settings):
        swept.append(arguments)
        if len(swept) == 3:
            signal.raise_signal(signal.SIGINT)
        return sweep(*arguments, **settings)

    handler = signal.getsignal(signal.SIGINT)
    with monkeypatch.context() as patch:
        patch.setattr(charts.grids, "sweep", interrupted)
        with pytest.raises(KeyboardInterrupt, match=r"3 of 6 chunks are in .*; run the same again to go on"):
            run(folder)
    assert signal.getsignal(signal.SIGINT) is handler
    assert len(chunks(folder)) == 3
    run(folder)
    assert contents(folder) == contents(finished)


def test_the_second_interruption_does_not_wait(tmp_path, monkeypatch):
    def twice(*_, **__):
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        raise AssertionError("went on")

    monkeypatch.setattr(charts.grids, "sweep", twice)
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "s")
    assert chunks(tmp_path / "s") == []


def test_unfinished_files_of_ended_processes_are_dropped(folder):
    chunks(folder)[0].unlink()
    host = os.uname().nodename
    # No process has a number above the system's largest.
    ended = folder / f".00000000-aa.{host}.{2**30}.partial"
    living = folder / f".00000000-aa.{host}.{os.getpid()}.partial"
    elsewhere = folder / f".00000000-aa.other.host.{2**30}.partial"
    for path in (ended, living, elsewhere):
        path.write_bytes(b"part")
    run(folder)
    assert not ended.exists()
    assert living.exists()
    assert elsewhere.exists()
    assert len(chunks(folder)) == 6


def test_a_process_that_began_at_the_same_time_leaves_its_layout(folder, monkeypatch):
    """Chunks of another size, as a machine with less memory would choose: the store's own are kept."""
    chunks(folder)[1].unlink()
    monkeypatch.setattr(charts, "_BY_OPERATORS", 2 * len(GAIN))
    study = run(folder)
    assert study.to_xarray().chunks["speed"] == (5,)
    assert len(chunks(folder)) == 6


def _sealed(manifest, **changes):
    """A manifest with a checksum that holds, as anybody can make one."""
    body = {k: v for k, v in (manifest | changes).items() if k != "sha256"}
    text = json.dumps(body, ensure_ascii=False, sort_keys=True, separators=(",", ":"))
    return encode(body | {"sha256": hashlib.sha256(text.encode()).hexdigest()})


@pytest.mark.parametrize(
    "changes",
    [
        {"over": {"../../etc": [1.0]}},
        {"over": {"a": ["os.system"]}},
        {"over": {"a": [2.0, 1.0]}},
        {"over": [1.0]},
        {"speed": []},
        {"speed": "fast"},
        {"speed": [float("nan")]},
        {"lanes_per_chunk": 0},
        {"lanes_per_chunk": 1.5},
        {"lanes_per_chunk": "../.."},
        {"verb": 3},
        {"settings": None},
        {"format": "another"},
    ],
)
def test_a_made_up_manifest_is_refused(changes, folder):
    content = _sealed(json.loads((folder / stores.MANIFEST).read_bytes()), **changes)
    with pytest.raises(ValueError):
        decode(content)
    (folder / stores.MANIFEST).write_bytes(content)
    with pytest.raises(ValueError, match="restore that file"):
        Study.open(folder)


@pytest.mark.slow
def test_a_store_goes_to_zarr_chunk_by_chunk_with_checksums(finished, tmp_path, shell):
    zarr = pytest.importorskip("zarr")
    done = shell("store", "export", str(finished), "--to", "zarr", "--out", "s.zarr")
    assert done.code == 0, done.err
    assert [path.name for path in tmp_path.iterdir()] == ["s.zarr"]
    study, group = Study.open(finished), zarr.open_group("s.zarr", mode="r")
    for name, array in group.arrays():
        assert array.metadata.zarr_format == 3
        assert type(array.metadata.codecs[-1]).__name__ == "Crc32cCodec"
        if name != "attributes":
            np.testing.assert_array_equal(array[...], study[name])
    assert group["multiplier"].chunks == (1, 5, 4)
    assert json.loads(group["attributes"][3].item())["process"] == json.dumps(study.chart(3).process)
    with xarray.open_zarr("s.zarr", consolidated=False) as again:
        xarray.testing.assert_identical(again["multiplier"].load(), study["multiplier"].load())
    victim = tmp_path / "s.zarr/multiplier/c/4/0/0"
    content = bytearray(victim.read_bytes())
    content[7] ^= 1
    victim.write_bytes(content)
    with pytest.raises(ValueError, match="checksum"):
        group["multiplier"][4]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--to", "hdf"), "to = 'hdf' is unknown"),
        (("--to", "zarr", "--out", "s.nc"), "out = 's.nc' does not end in .zarr"),
        (("--out", "s.txt"), "ends in '.txt'"),
        (("--to", "zarr"), "pip install 'lobex[zarr]'"),
    ],
)
def test_what_a_store_cannot_go_to_is_refused(words, told, finished, shell, monkeypatch):
    monkeypatch.setitem(sys.modules, "zarr", None)
    assert told in shell.refuses("store", "export", str(finished), *words)
    assert [path.name for path in finished.parent.iterdir()] == ["s"]


def test_links_lead_nowhere(folder, tmp_path):
    secret = tmp_path / "secret.h5"
    with h5py.File(secret, "w") as file:
        file["key"] = np.arange(3.0)
    for make in (
        lambda file: file.__setitem__("key", h5py.ExternalLink(str(secret), "key")),
        lambda file: file.__setitem__("key", h5py.SoftLink("/elsewhere")),
        lambda file: file.create_dataset("key", (3,), "f8", external=[(str(secret), 0, 24)]),
        lambda file: file.create_virtual_dataset("key", _virtual(secret)),
        lambda file: file.create_group("key"),
    ):
        buffer = io.BytesIO()
        with h5py.File(buffer, "w") as file:
            make(file)
        with pytest.raises(ValueError, match="'key' is"):
            from_bytes(buffer.getvalue())
    victim = chunks(folder)[0]
    victim.rename(tmp_path / "moved.nc")
    victim.symlink_to(tmp_path / "moved.nc")
    with pytest.raises(ValueError, match="5 of 6 chunks"):
        Study.open(folder)
    (folder / stores.MANIFEST).rename(tmp_path / "m")
    (folder / stores.MANIFEST).symlink_to(tmp_path / "m")
    with pytest.raises(ValueError, match="restore that file"):
        Study.open(folder)


def _virtual(path):
    layout = h5py.VirtualLayout((3,), "f8")
    layout[:] = h5py.VirtualSource(str(path), "key", (3,))
    return layout


def test_bytes_of_a_dataset_come_back(finished):
    dataset = from_bytes(chunks(finished)[0].read_bytes())
    assert to_bytes(dataset) == to_bytes(dataset.copy(deep=True))
    assert from_bytes(to_bytes(dataset)).identical(dataset)
    with pytest.raises(ValueError, match="no readable NetCDF-4"):
        from_bytes(b"plain text")


def test_nothing_that_runs_code_is_imported():
    source = Path(lobex.__file__).parent
    modules = r"\b(import|from) (c?pickle|dill|joblib|marshal|shelve|yaml)\b"
    words = re.compile(rf"{modules}|\ballow_pickle\b(?!=False)|\beval\(|\bexec\(")
    found = [path.name for path in source.rglob("*.py") if words.search(path.read_text())]
    assert found == []
    assert words.search("import pickle")
    assert words.search("np.load(path, allow_pickle=True)")
