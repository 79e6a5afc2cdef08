"""What a file unpacks to: a small one may say that it holds any number of bytes."""

import zipfile
from collections.abc import Iterable
from os import PathLike
from typing import IO

# MiB, of arrays.
_MOST = 512


def check_unpacked(bytes_of_parts: Iterable[int], most: int = _MOST) -> None:
    """Require at most so many MiB of all parts together."""
    size = sum(bytes_of_parts) / 2**20
    if size > most:
        raise ValueError(f"it unpacks to {size:.0f} MiB; give a file of up to {most} MiB")


def check_archive(file: IO[bytes] | PathLike[str], most: int = _MOST) -> None:
    """The same of what the head of a zip archive says, beyond which no part of it is read."""
    with zipfile.ZipFile(file) as archive:
        check_unpacked((part.file_size for part in archive.infolist()), most)
