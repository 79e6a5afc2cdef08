"""A stability limit with its uncertainty."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, overload

import numpy as np

from lobex import _checks
from lobex._by_name import by_name
from lobex.results.limit import Limit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class Band:
    """First-order uncertainty of a stability limit K: standard deviations of ln K, per speed.

    The numbers vary independently and by little. Within about a standard deviation of a cusp between two lobes the
    limit is not smooth: there the lower lobe wins, and the true mean lies below the curve.

    Attributes:
        limit: the limit, over n speeds.
        names: of the uncertain numbers, p of them.
        deviation: their relative standard deviations, (p,).
        contribution: the part of each in the standard deviation of ln K, |d ln K/d ln p| σ_p/p, (n, p).
    """

    limit: Limit
    names: tuple[str, ...]
    deviation: np.ndarray
    contribution: np.ndarray

    @property
    def relative(self) -> np.ndarray:
        """Standard deviation of ln K, which is the relative one of K, (n,); NaN where there is no limit."""
        return np.sqrt(np.sum(self.contribution**2, axis=1))

    @property
    def standard_deviation(self) -> np.ndarray:
        """Standard deviation of K, (n,), in units of the gain."""
        return np.abs(self.limit.gain) * self.relative

    def interval(self, deviations: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
        """K exp(∓ k σ), the lower and the upper edge ``deviations`` k away, each (n,)."""
        _checks.positive("deviations", deviations)
        _checks.scalar("deviations", deviations)
        gain = np.asarray(self.limit.gain)
        edges = gain * np.exp(-deviations * self.relative), gain * np.exp(deviations * self.relative)
        return np.minimum(*edges), np.maximum(*edges)

    def __repr__(self) -> str:
        spread = self.relative[np.isfinite(self.relative)]
        lines = [
            f"Band of the limit of {self.limit.process['type']}: {len(self.relative)} speeds",
            "  relative standard deviation  "
            + (f"{spread.min():.3g} to {spread.max():.3g}" if spread.size else "no limit"),
        ]
        share = np.nan_to_num(self.contribution) ** 2
        total = max(float(share.sum()), np.finfo(float).tiny)
        for i in np.argsort(-share.sum(axis=0), kind="stable")[:5]:
            part = 100 * float(share[:, i].sum()) / total
            lines.append(f"  {self.names[i]:<28} {self.deviation[i]:.3g}, {part:.0f} % of the variance")
        return "\n".join(lines)

    @overload
    def plot(
        self, ax: "Axes", speed_unit: str | None = None, *, deviations: float = 2.0, label: str | None = None
    ) -> "Axes": ...
    @overload
    def plot(
        self,
        ax: None = None,
        speed_unit: str | None = None,
        *,
        deviations: float = 2.0,
        axes: "Sequence[Axes] | None" = None,
    ) -> "Figure": ...
    def plot(
        self,
        ax: "Axes | None" = None,
        speed_unit: str | None = None,
        *,
        deviations: float = 2.0,
        axes: "Sequence[Axes] | None" = None,
        label: str | None = None,
    ) -> "Figure | Axes":
        """The limit's picture with the band of ``deviations`` standard deviations on either side shaded.

        ``ax``, ``axes``, ``speed_unit`` and ``label`` as ``Limit.plot`` takes them.
        """
        band = (*self.interval(deviations), f"± {deviations:g} standard deviations")
        return by_name("plots.limit_picture.plot_limit")(self.limit, ax, axes, speed_unit, label, band)
