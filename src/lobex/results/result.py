"""What all results can do: become labelled arrays, and files."""

import os
from dataclasses import KW_ONLY
from typing import TYPE_CHECKING, Any, ClassVar

from lobex.processes.quantity import Quantity
from lobex.results.fields import Attribute, Fields, Parts, field, write
from lobex.results.stored import Stored

if TYPE_CHECKING:
    import xarray


class Result(Fields):
    """What a verb hands back; ``form`` is the name and number of its files' format."""

    form: ClassVar[str]

    def __init_subclass__(cls, form: str = "") -> None:
        super().__init_subclass__()
        cls.form = form

    def to_xarray(self) -> "xarray.Dataset":
        """The result as a labelled dataset, with units, and with the model in its attributes."""
        import xarray

        return xarray.Dataset(*self._parts())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result to a file, all at once or not at all; its ending says which: .nc (NetCDF-4), which
        ``lobex.load`` reads back, .zarr (a new folder of Zarr 3, packed and with checksums; it takes ``lobex[zarr]``),
        .mat (MATLAB) or .csv (one row per point, where all its arrays share rows).

        Raises:
            ValueError: for any other ending, a place that cannot be written, and a .csv file of arrays that share none.
        """
        from lobex.results.saving import checked, in_one_step, save_dataset

        target = checked(path)
        if target.suffix.lower() != ".nc":
            return save_dataset(self.to_xarray(), path)
        from lobex.results.netcdf import write_arrays

        in_one_step(target, lambda file: write_arrays(file, self._parts()))

    def _parts(self) -> Parts:
        parts = Parts({}, {}, {"format": self.form})
        write(self, parts)
        return parts


class OfProcess(Result):
    """What a verb finds of a process: what its gain is, how speeds are shown, the model, and the time that it took."""

    _: KW_ONLY
    quantity: Quantity
    speed_unit: str = field(Attribute(Stored.unit))
    process: dict[str, Any]
    seconds: float
    compiling: float
