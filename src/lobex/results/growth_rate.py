"""How fast a vibration grows beside a stability limit."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex.results.limit import Limit

# First order holds until the second has this share of it.
_SHARE = 0.1


@dataclass(frozen=True, eq=False, repr=False)
class GrowthRate:
    """Growth of the vibration that a limit K is of, at gains beside it: the real part of its characteristic root.

    At the gain K (1 + x) the vibration goes as e^{σt}, and from one pass to the next it is multiplied by e^{στ}.

    Attributes:
        limit: the limit, over n speeds.
        rate: dσ/d ln K at the limit, (n,), 1/s; NaN where there is no limit, and where ``error`` is more than half of
            it.
        bend: d²σ/d(ln K)² there, (n,), 1/s.
        drift: d ln ω/d ln K there, (n,): how the chatter frequency moves with the gain.
        error: of ``rate``, (n,), 1/s: of a measurement, what taking every second line alone changes; of modes,
            rounding.
        delay: τ between two passes, (n,), s; of teeth at unequal angles the mean.
    """

    limit: Limit
    rate: Float[np.ndarray, " n"]
    bend: Float[np.ndarray, " n"]
    drift: Float[np.ndarray, " n"]
    error: Float[np.ndarray, " n"]
    delay: Float[np.ndarray, " n"]

    @property
    def per_pass(self) -> Float[np.ndarray, " n"]:
        """d ln|μ|/d ln K at the limit, (n,): percent of growth in a pass per percent of gain above the limit."""
        return self.rate * self.delay

    @property
    def reach(self) -> Float[np.ndarray, " n"]:
        """Relative distance from the limit, (n,), within which the second order is at most a tenth of the first."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.expm1(np.minimum(2 * _SHARE * np.abs(self.rate / self.bend), np.log(2.0)))

    def at(self, excess: float) -> Float[np.ndarray, " n"]:
        """σ at the gain K (1 + ``excess``) to second order, (n,), 1/s; NaN farther than ``reach`` from the limit.

        Raises:
            ValueError: for an excess of −1 or less, or that is no number.
        """
        _checks.as_numbers("excess", excess)
        _checks.scalar("excess", excess)
        if not excess > -1:
            raise ValueError(f"excess = {excess:.6g} leaves no gain; give such as 0.05, 5 % above the limit")
        x = np.log1p(excess)
        return np.where(abs(excess) <= self.reach, self.rate * x + self.bend * x**2 / 2, np.nan)

    def __repr__(self) -> str:
        there = np.isfinite(self.rate)
        lines = [f"GrowthRate at the limit of {self.limit.process['type']}: {len(self.rate)} speeds"]
        if not there.any():
            return "\n".join([*lines, "  no limit"])
        rate, reach, passes = self.rate[there], self.reach[there], self.per_pass[there]
        lines += [
            f"  d sigma/d ln K   {rate.min():.4g} to {rate.max():.4g} 1/s",
            f"  d ln|mu|/d ln K  {passes.min():.4g} to {passes.max():.4g} in a pass",
            f"  holds within     {100 * reach.min():.2g} % of the limit, or more",
        ]
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.nanmax(self.error[there] / np.abs(rate)) if np.isfinite(self.error[there]).any() else np.nan
        return "\n".join([*lines, f"  estimated error  {off:.1e} relative, at most"])
