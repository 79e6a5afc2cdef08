"""Named arrays of NumPy and MATLAB files, none of which may run code."""

import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from lobex.measured.unpacked import check_archive, check_unpacked


def arrays_of(path: Path) -> dict[str, np.ndarray]:
    """The arrays of numbers and the texts of a .npz, .npy or .mat file, by name; that of a .npy file has none.

    Raises:
        ValueError: for a file that cannot be read, that holds objects of Python, or more than 512 MiB of numbers.
    """
    try:
        if path.suffix.lower() == ".mat":
            return _matlab(path)
        with open(path, "rb") as file:
            if path.suffix.lower() == ".npy":
                return {"": np.load(file, allow_pickle=False)}
            if zipfile.is_zipfile(file):
                check_archive(file)
            file.seek(0)
            with np.load(file, allow_pickle=False) as stored:
                if isinstance(stored, np.ndarray):
                    return {"": stored}
                return {name: stored[name] for name in stored.files}
    except (ValueError, OSError, EOFError, zipfile.BadZipFile, KeyError) as error:
        if "pickle" in str(error):
            raise ValueError(
                f"path = {str(path)!r} holds objects of Python, or is no file of NumPy; a file that could run code is "
                "not opened: save arrays of numbers, by np.savez"
            ) from None
        why = str(error).partition("\n")[0] or type(error).__name__
        raise ValueError(
            f"path = {str(path)!r} cannot be read as {path.suffix.lower()} ({why}); save it again"
        ) from None
    except MemoryError:
        raise ValueError(f"path = {str(path)!r} says that it holds more than fits in memory; save it again") from None


def _matlab(path: Path) -> dict[str, np.ndarray]:
    """Variables of a MATLAB file, of version 5 by SciPy and of 7.3, which is HDF5, by h5py."""
    import h5py
    import scipy.io

    if h5py.is_hdf5(path):
        return _matlab_hdf5(path)
    try:
        # Complex numbers have 16 bytes, and none has more.
        check_unpacked(16 * math.prod(shape) for _, shape, _ in scipy.io.whosmat(path))
        found = scipy.io.loadmat(path, squeeze_me=False)
    except Exception as error:
        # Its reader tells of damaged files in many ways.
        raise ValueError(str(error)) from None
    return {
        name: value for name, value in found.items() if isinstance(value, np.ndarray) and value.dtype.kind in "fiucU"
    }


def _matlab_hdf5(path: Path) -> dict[str, np.ndarray]:
    import h5py

    with h5py.File(path, "r") as file:
        found = {}
        check_unpacked(stored.nbytes for stored in file.values() if isinstance(stored, h5py.Dataset))
        for name, stored in file.items():
            if not isinstance(stored, h5py.Dataset):
                continue
            value: Any = stored[()]
            # MATLAB runs through the first index first.
            value = np.asarray(value).T
            if value.dtype.names == ("real", "imag"):
                found[name] = value["real"] + 1j * value["imag"]
            elif stored.attrs.get("MATLAB_class") == b"char":
                found[name] = np.array("".join(map(chr, value.ravel(order="F"))))
            elif value.dtype.kind in "fiu":
                found[name] = value
    return found
