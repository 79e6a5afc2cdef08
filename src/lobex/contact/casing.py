"""The casing that a blade rubs: its abradable surface over one revolution, before any wear."""

from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float, Real

from lobex import _checks
from lobex._by_name import by_name
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_BUMPS = 100_000

BUMPS = ("cosine", "gaussian", "ovoid")


@pytree(static=("nodal_diameters", "bump"))
class Casing:
    """An abradable casing that comes inwards ``nodal_diameters`` times per revolution, §1.2.2.

    The profile is the surface seen from the tip's rest position, positive outwards, m:

        profile(θ) = clearance − amplitude · bump(s),   s = θ · nodal_diameters/2π mod 1 − 1/2

    so that the tip starts, at θ = 0, midway between two bumps. With s the distance from a bump's middle in
    pitches and w = ``bump_width``, bump is

        "cosine"    cos²(π s/w) for |s| < w/2, else 0
        "gaussian"  exp(−(s/w)²)
        "ovoid"     an ellipse of semi-axes radius − amplitude and radius; two nodal diameters only

    Attributes:
        nodal_diameters: bumps per revolution, at least 1.
        amplitude: height of the bumps, m.
        clearance: gap between the tip at rest and the casing between the bumps, m.
        bump: "cosine", "gaussian" or "ovoid".
        bump_width: w, in pitches.
        radius: radius of the casing, m; 0.5 in the thesis.
        axial_width: axial length of the rub track, m, for volumes; 1 gives them per metre.
        surface: a profile of your own in place of the bumps, shape (cells,), m, starting at θ = 0. It may be
            negative everywhere, for permanent contact.
        structure: of a flexible casing its modes as the contacts meet them, outwards as the tip's: a ``Ring``, whose
            waves go past any number of contacts; or ``Modes``, or those that follow the speed, of one direction for
            each contact, those of all blades at the first place of a blade, then at the next. None of a rigid one.

    Raises:
        ValueError: for values that are not finite, negative or zero where that has no meaning, an unknown bump,
            an ovoid without two nodal diameters, and a surface that is not one-dimensional.
    """

    nodal_diameters: int = 2
    amplitude: Number = 1e-4
    clearance: Number = 0.0
    bump: str = "cosine"
    bump_width: Number = 0.5
    radius: Number = 0.5
    axial_width: Number = 1.0
    surface: Real[AnyArray, " cells"] | None = None
    structure: Any = None

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "nodal_diameters", _checks.integer("nodal_diameters", self.nodal_diameters, 1, _MOST_BUMPS)
        )
        _checks.not_negative("amplitude", self.amplitude, "m")
        _checks.not_negative("clearance", self.clearance, "m")
        _checks.choice("bump", self.bump, BUMPS)
        for name, unit in (("bump_width", "pitches"), ("radius", "m"), ("axial_width", "m")):
            _checks.positive(name, getattr(self, name), unit)
        for name in ("amplitude", "clearance", "bump_width", "radius", "axial_width"):
            _checks.scalar(name, getattr(self, name))
        if self.bump == "ovoid" and self.nodal_diameters != 2:
            raise ValueError(f"nodal_diameters = {self.nodal_diameters}: an ovoid has 2; give 2 or another bump")
        self._check_sizes()

    def _check_sizes(self) -> None:
        width, amplitude, radius = (_checks.as_numbers("", v) for v in (self.bump_width, self.amplitude, self.radius))
        if width is not None and self.bump == "cosine" and width > 1:
            raise ValueError(f"bump_width = {width:.6g} pitches makes cosine bumps overlap; give at most 1")
        if amplitude is not None and radius is not None and amplitude >= radius:
            raise ValueError(f"amplitude = {amplitude:.6g} m is not below radius = {radius:.6g} m; check the units")
        if self.surface is not None:
            _checks.as_numbers("surface", self.surface, "m")
            if len(np.shape(self.surface)) != 1 or np.shape(self.surface)[0] == 0:
                raise ValueError(f"surface has shape {np.shape(self.surface)}; give one value per cell, (cells,)")

    @in_float64
    def profile(self, cells: int) -> Float[AnyArray, " {cells}"]:
        """The profile at the angles 2π c/cells, c = 0, 1, …, shape (cells,), m.

        Raises:
            ValueError: where ``surface`` has another number of cells.
        """
        cells = _checks.integer("cells", cells, 1)
        lib = namespace(self)
        if self.surface is not None:
            if np.shape(self.surface)[0] != cells:
                raise ValueError(
                    f"surface has {np.shape(self.surface)[0]} cells and {cells} are asked for; give as many cells as "
                    "steps per revolution, such as by np.interp"
                )
            return lib.asarray(self.surface, dtype=lib.result_type(float))
        turn = lib.arange(cells) / cells
        if self.bump == "ovoid":
            short = self.radius - self.amplitude
            angle = 2 * lib.pi * turn
            ellipse = short * self.radius / lib.hypot(short * lib.cos(angle), self.radius * lib.sin(angle))
            return self.clearance + ellipse - self.radius
        s = (turn * self.nodal_diameters) % 1 - 0.5
        if self.bump == "gaussian":
            shape = lib.exp(-((s / self.bump_width) ** 2))
        else:
            shape = lib.where(lib.abs(s) < self.bump_width / 2, lib.cos(lib.pi * s / self.bump_width) ** 2, 0.0)
        return self.clearance - self.amplitude * shape

    def plot(self, ax: "Axes | None" = None, magnification: float | None = None) -> "Axes":
        """The profile in polar form, exaggerated by ``magnification`` (said in the picture); returns the axes."""
        return by_name("plots.casing_pictures.plot_casing")(self, ax, magnification)


def check_casing(casing: Any) -> None:
    """Require a casing."""
    if not isinstance(casing, Casing):
        raise ValueError(f"casing = {_checks.brief(casing)} is no casing; give lobex.Casing(…)")
