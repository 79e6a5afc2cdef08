"""A store: the folder that holds a study, one file per chunk, and its manifest.

A chunk is written beside its place, brought to the disk, and renamed: ``00000012-8c1f….nc``, the chunk's number and
its checksum. A file of that name is whole, whenever the writer ended.
"""

import errno
import os
import re
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import xarray

from lobex import _checks
from lobex.results.saving import joined
from lobex.studies import manifest as manifests
from lobex.studies.slabs import checksum, from_bytes, to_bytes

MANIFEST = "manifest.json"

_CHUNK = re.compile(r"(\d{8,})-([0-9a-f]{16})\.nc")
_NO_LINKS = (errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK)
_PARTIAL = re.compile(r"\.(?:[^.]+)\.(?P<host>.+)\.(?P<process>\d+)\.partial")


class Damage(ValueError):
    """A chunk that is not what its name says."""


@dataclass(frozen=True)
class Place:
    """Where the chunks of a study go to, for whoever computes them.

    Attributes:
        folder: of the store, from the root on.
        study: what every chunk of it carries.
    """

    folder: Path
    study: str

    def write(self, number: int, dataset: xarray.Dataset) -> None:
        """Put a chunk in its place, whole and on the disk."""
        content = to_bytes(dataset.assign_attrs(study=self.study, chunk=number))
        with _writing(self.folder):
            if not (self.folder / MANIFEST).is_file():
                raise FileNotFoundError(errno.ENOENT, f"{socket.gethostname()} does not see it")
            _write(self.folder / f"{number:08d}-{checksum(content)}.nc", content)

    def content(self, name: str) -> bytes:
        """The bytes of a chunk's file; ValueError where they are not those of its name."""
        content = (self.folder / name).read_bytes()
        if not name.endswith(f"-{checksum(content)}.nc"):
            raise ValueError("its checksum is another")
        return content

    def intact(self, name: str) -> bool:
        """Whether a chunk's file is what its name says."""
        try:
            self.content(name)
        except (OSError, ValueError):
            return False
        return True


class Store:
    """An open store: ``Store.open`` for what is there, ``Store.begin`` for a study that is to be computed."""

    def __init__(self, folder: Path, manifest: dict[str, Any]) -> None:
        self.folder, self.manifest = folder, manifest
        self.plan = manifests.plan_in(manifest)
        self.place = Place(folder.absolute(), manifests.identity(manifest))

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> "Store":
        """The store in a folder; ValueError where there is none."""
        place = _checks.place("store", folder, "a folder")
        if not str(folder) or not place.is_dir():
            raise ValueError(f"store = {str(folder)!r} is not a folder; give the folder of a store")
        path = place / MANIFEST
        if not path.is_file() or path.is_symlink():
            raise ValueError(
                f"store = {str(folder)!r} has no {MANIFEST}; restore that file, or begin in an empty folder"
            )
        try:
            manifest = manifests.decode(path.read_bytes())
        except (OSError, ValueError) as error:
            why = f"cannot be read ({error.strerror})" if isinstance(error, OSError) else error
            raise ValueError(
                f"store = {str(folder)!r}: {MANIFEST} {why}; restore that file, or begin in an empty folder"
            ) from None
        return cls(place, manifest)

    @classmethod
    def begin(cls, folder: str | os.PathLike[str], manifest: dict[str, Any]) -> "Store":
        """The store of a study: begun in a new or empty folder, or gone on with where it holds that study.

        Raises:
            ValueError: for a folder that holds another study (the message names the first difference) or other files,
                and where it cannot be written.
        """
        place = _checks.place("store", folder, "a folder")
        if not str(folder) or (place.exists() and not place.is_dir()):
            raise ValueError(f"store = {str(folder)!r} is not a folder; give the folder that the study goes to")
        with _writing(place):
            place.mkdir(parents=True, exist_ok=True)
            if not (place / MANIFEST).exists():
                others = [name for name in os.listdir(place) if not _PARTIAL.fullmatch(name) and name != MANIFEST]
                if others:
                    raise ValueError(
                        f"store = {str(folder)!r} is not empty and has no {MANIFEST}; restore that file, or give a "
                        "new or empty folder"
                    )
                _write_once(place / MANIFEST, manifests.encode(manifest))
        # What is there now may be another process', which began at the same time.
        store = cls.open(place)
        difference = manifests.first_difference(store.manifest, manifest)
        if difference:
            raise ValueError(
                f"store = {str(folder)!r} holds another study: {difference}; give another folder or the same study"
            )
        return store

    def present(self) -> dict[int, str]:
        """The file of every chunk that is there, by number. Of a chunk that two processes wrote, one."""
        found: dict[int, str] = {}
        with os.scandir(self.folder) as entries:
            for entry in entries:
                named = _CHUNK.fullmatch(entry.name)
                # Nothing here leads out of the folder.
                if named and entry.is_file(follow_symlinks=False) and int(named[1]) < self.plan.chunks:
                    found[int(named[1])] = min(entry.name, found.get(int(named[1]), entry.name))
        return found

    def reader(self) -> Callable[[int], xarray.Dataset]:
        """What reads the result of any chunk; ValueError where some are missing."""
        names = self.present()
        if len(names) < self.plan.chunks:
            raise ValueError(
                f"store = {str(self.folder)!r} holds {len(names)} of {self.plan.chunks} chunks; run the same study "
                "again to complete it"
            )
        return partial(self.read, names=names)

    def read(self, number: int, names: dict[int, str]) -> xarray.Dataset:
        """The result of a chunk, of the file that ``present`` tells, its checksum compared and its fields looked at.
        ``Damage`` where it is not what it was."""
        from lobex.results.register import result_of

        try:
            dataset = from_bytes(self.place.content(names[number]))
            if dataset.attrs.pop("study", None) != self.place.study:
                raise ValueError("it is of another study")
            if dataset.attrs.pop("chunk", None) != number:
                raise ValueError("it is another chunk")
            result_of(dataset, "it")
        except (OSError, ValueError) as error:
            why = f"chunk {number} of the store {str(self.folder)!r} is damaged ({error})"
            raise Damage(f"{why}; run the study again") from error
        return joined(dataset)

    def remove(self, name: str) -> None:
        """Drop the file of a damaged chunk."""
        with _writing(self.folder):
            (self.folder / name).unlink(missing_ok=True)

    def check_writable(self) -> None:
        """Require, before anything is computed, that chunks can be written."""
        probe = self.folder / f".probe.{socket.gethostname()}.{os.getpid()}.partial"
        with _writing(self.folder):
            probe.touch()
            probe.unlink()

    def tidy(self) -> None:
        """Drop the unfinished files of processes of this machine that have ended."""
        for path in self.folder.iterdir():
            named = _PARTIAL.fullmatch(path.name)
            if named and named["host"] == socket.gethostname() and not _alive(int(named["process"])):
                with suppress(OSError):
                    path.unlink(missing_ok=True)


def _write(target: Path, content: bytes, *, once: bool = False) -> None:
    """Write a file in one step: beside its place, to the disk, then renamed."""
    partial = target.with_name(f".{target.stem}.{socket.gethostname()}.{os.getpid()}.partial")
    try:
        with open(partial, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        if once:
            # A link, unlike a renaming, fails where the name is taken.
            os.link(partial, target)
        else:
            os.replace(partial, target)
        _sync_folder(target.parent)
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def _write_once(target: Path, content: bytes) -> None:
    """Write a file that only one of several processes may begin."""
    try:
        _write(target, content, once=True)
    except FileExistsError:
        return
    except OSError as error:
        if error.errno not in _NO_LINKS:
            raise
        # A file system without links: two that begin in the same instant write the same but for the layout.
        if not target.exists():
            _write(target, content)


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except OSError as error:
        # Another user's is none of ours to signal, and alive.
        return not isinstance(error, ProcessLookupError)
    return True


@contextmanager
def _writing(folder: Path) -> Iterator[None]:
    """Where a store cannot be written within, one line says so."""
    try:
        yield
    except OSError as error:
        raise ValueError(
            f"store = {str(folder)!r} cannot be written ({error.strerror or error}); the chunks that are there are "
            "kept: make room or choose a place that can be written, and run the same again"
        ) from error
