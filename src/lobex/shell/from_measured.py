"""From the flags of a measurement to its modes."""

from typing import Any

from lobex import _checks
from lobex.shell.measured_arguments import Measured


def modes_measured(flags: Any) -> Any:
    """The modes fitted to the files that the flags name, None where they name none; tells of the fit.

    Raises:
        ValueError: for flags without a file, and as ``read_frf`` and ``Frf.fit`` do.
    """
    measured = flags.measured
    if measured.file is None:
        if given := [name for name, value in vars(measured).items() if value is not None]:
            flag = "frf-y" if given[0] == "across" else f"frf-{given[0]}"
            raise ValueError(f"{flag} = {getattr(measured, given[0])!r} has no use without a file; give --frf FILE")
        return None
    if getattr(flags, "sensitivity", False):
        raise ValueError(f"frf = {measured.file!r} has no use with --sensitivity; ask lobex.sensitivities")
    import lobex

    modes = _fitted(measured, measured.file, flags)
    across = getattr(measured, "across", None)
    if across is None:
        return modes
    if modes.directions != 1:
        raise ValueError(f"frf_y = {across!r}, where {measured.file!r} has {modes.directions} directions; drop one")
    return lobex.Modes.plane(x=modes, y=_fitted(measured, across, flags))


def _fitted(measured: Measured, path: str, flags: Any) -> Any:
    import lobex

    columns = None if measured.columns is None else tuple(measured.columns.split(","))
    band = None
    if measured.band is not None:
        ends = measured.band.split(":")
        try:
            band = [float(end) for end in ends]
        except ValueError:
            band = []
        if len(band) != 2:
            raise ValueError(f"frf_band = {_checks.brief(measured.band)} is not low:high; give such as 50:2000")
    fit = lobex.read_frf(path, unit=measured.unit, columns=columns).fit(measured.modes, band)
    if not flags.output.quiet:
        print(fit)
    return fit.modes
