"""The result of a search for the stability limit."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from lobex._by_name import by_name
from lobex.processes.quantity import hertz
from lobex.results.codes import Kind, Status
from lobex.results.description import in_words, wall_time
from lobex.results.fields import Array, Attribute, Codes, Coordinate, derived, field, in_gain, in_hertz
from lobex.results.result import OfProcess
from lobex.results.units import shown_gain, shown_range, shown_speed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lobex.results.band import Band
    from lobex.results.growth_rate import GrowthRate
    from lobex.results.sensitivities import Sensitivities


class Limit(OfProcess, form="lobex limit 3"):
    """The stability limit over speeds: the lowest gain at which a process turns from stable to unstable.

    Attributes:
        speed: (n,), Hz.
        gain: (n,), in ``quantity.unit``; NaN where no limit was found, see ``status``. NaN is not "stable".
        chatter_frequency: frequency of the vibration at the limit, Hz, (n,).
        kind_code, status_code: members of ``Kind`` and ``Status``, (n,).
        intervals: every stable interval of gains within the bounds, (n, k, 2), NaN past the last of a speed;
            an interval that begins or ends at a bound goes on beyond it, as far as is known.
        mode: the number of the mode that takes the largest part in the vibration at the limit, (n,), from 1 in the
            order of the structure's, those of a casing after those of the blade; 0 where it is not told, as of an
            equation that does not say its modes.
        nodal_diameter: k of a stage of N equal blades that vibrate as e^{i(ωt − 2πkj/N)}, (n,), each by k/N of a period
            after the one before it: k waves go around the disc, or N − k the other way; −1 where there are none.
        error: estimated error of the gain, of a finer discretisation, (n,).
        bounds: lowest and highest gain looked at.
        quantity: what the gain is.
        speed_unit: "Hz", "rpm", or "1" of a process without units, for axes.
        process, method: the model and the method, as plain dictionaries.
        seconds: wall time, compiling included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
    """

    speed: Any = field(Coordinate("speed", "rotational frequency", in_hertz))
    gain: Any = field(Array("speed", lambda limit: f"critical {limit.quantity.name}", in_gain))
    chatter_frequency: Any = field(Array("speed", "chatter frequency", in_hertz))
    kind_code: Any = field(
        Codes("speed", "how the dominant multiplier leaves the unit circle", name="kind", codes=Kind)
    )
    status_code: Any = field(Codes("speed", "what became of the search", name="status", codes=Status))
    intervals: Any = field(
        Array("speed interval edge=2", "stable intervals within the bounds", in_gain, name="stable_interval")
    )
    mode: Any = field(Array("speed", "number of the mode that chatters, 0 where not told", dtype=np.int64))
    nodal_diameter: Any = field(Array("speed", "waves of blades around the disc, -1 for none", dtype=np.int64))
    error: Any = field(Array("speed", "estimated error of the gain", in_gain))
    bounds: tuple[float, float] = field(Attribute(lambda stored, name: stored.numbers(name, 2)))
    method: dict[str, Any]

    @property
    def kind(self) -> np.ndarray:
        """ "hopf", "flip", "fold", or "" where there is no limit, (n,)."""
        return Kind.words_of(self.kind_code)

    @property
    def status(self) -> np.ndarray:
        """What became of the search, in words, (n,): "found", "none in range", "unstable at the lower bound",
        "not converged", "tie" (a limit at which two multipliers of different frequency cross at once, so
        that kind, frequency and derivatives are those of one of them), "beyond the measured frequencies" (no limit in
        the band of a ``Receptance``; one outside it is not seen), "undefined" (a vibration without damping neither
        grows nor dies out, whatever the gain), "stable at any gain" (from the lowest on no characteristic root comes
        to the imaginary axis, however large the gain: below its critical speed process damping does that; told of
        constant coefficients), or "more intervals than kept" (of a study or a store, which have room for
        (scan + 1) // 2 stable intervals, the lowest; the limit is what it would be else)."""
        return Status.words_of(self.status_code)

    @property
    @derived(
        Array("speed", "whole waves between two passes, -1 where there is no limit", dtype=np.int64),
        after="chatter_frequency",
    )
    def lobe(self) -> np.ndarray:
        """Whole waves between two passes, which numbers the lobes, (n,); -1 where there is no limit."""
        waves = np.asarray(self.chatter_frequency) / np.asarray(self._pass_frequency())
        return np.where(np.isfinite(waves), np.floor(np.nan_to_num(waves) + 1e-9), -1).astype(int)

    def _pass_frequency(self) -> Any:
        return self.speed * self.process.get("teeth", 1)

    def __repr__(self) -> str:
        counts = [f"{np.sum(np.asarray(self.status_code) == s)} {s.words}" for s in Status]
        lines = [
            f"Limit of {self.process['type']}: {len(self.speed)} speeds, "
            + shown_range(*(shown_speed(end(self.speed), self.speed_unit) for end in (np.min, np.max))),
            f"  bounds           {shown_range(*(shown_gain(bound, self.quantity) for bound in self.bounds))}"
            f" ({self.quantity.name} {self.quantity.symbol})",
            f"  status           {', '.join(c for c in counts if not c.startswith('0 '))}",
            f"  method           {in_words(self.method)}",
            f"  wall time        {wall_time(self, len(self.speed), 'speed')}",
        ]
        gain = np.asarray(self.gain)
        if not np.isfinite(gain).any():
            lines.insert(3, "  smallest limit   none")
        else:
            i = int(np.nanargmin(gain))
            lines.insert(
                3,
                f"  smallest limit   {self.quantity.symbol} = {shown_gain(gain[i], self.quantity, 8)} at "
                f"{shown_speed(self.speed[i], self.speed_unit)}, {self.kind[i]} at "
                f"{self.chatter_frequency[i]:.6g}{hertz(self.speed_unit)}",
            )
            if np.isfinite(self.error).any():
                above = np.abs(gain) > 0
                worst = np.max(np.asarray(self.error)[above] / np.abs(gain[above]), initial=0.0)
                lines.insert(4, f"  estimated error  {worst:.1e} relative, at most")
        return "\n".join(lines)

    def sensitivities(self) -> "Sensitivities":
        """How much the limit moves with each number of its process, d ln K/d ln p, as ``lobex.sensitivities`` tells it.

        Of limits of every verb, those of ``zero_order_limit`` and ``multi_frequency_limit`` too: of the equations that
        these solve, with the harmonics that are kept, so that samples of a measurement have theirs.

        Raises:
            ValueError: for a limit that does not tell its process (found under ``jit`` or ``grad``, or of a class that
                is not lobex's own).
        """
        return by_name("limits.sensitivity.sensitivities_of")(self)

    def band(self, relative_standard_deviation: Mapping[str, float], correlation: Any = None) -> "Band":
        """The first-order uncertainty of the limit for uncertain numbers of its process.

        σ²(ln K) = Σ (d ln K/d ln p · σ_p/p)² over independent numbers p, which are named as in
        ``lobex.sensitivities``: "tangential", "modes.damping_ratio[0]". A name without index stands for
        each of its numbers, every mode and every entry of a shape independent of the others. For numbers
        that the process was made from, take ``lobex.sensitivities(function, …, at=…).band``.

        Args:
            relative_standard_deviation: σ_p/p by name, such as ``{"modes.damping_ratio": 0.1}``.
            correlation: of those numbers in that order, (p, p), where they vary together, such as those of a
                ``ModalFit``; each is then named by itself.

        Raises:
            ValueError: for unknown names, negative standard deviations, what is no correlation, and a limit that does
                not tell its process (found under ``jit`` or ``grad``, or of a class that is not lobex's own).
        """
        return self.sensitivities().band(relative_standard_deviation, correlation)

    def growth(self) -> "GrowthRate":
        """How fast the vibration grows above the limit, and dies out below it, from frequency responses alone.

        For limits of one frequency response, of modes or measured, those of ``exact_limit`` with one contact, and for
        those of ``zero_order_limit`` and ``multi_frequency_limit``. The root iω of 1 + K L(s) moves by
        ds/d ln K = −L/L′, with the loop L = G(s) (1 − e^{−sτ}), or the eigenvalue of it that is −1/K, whose derivative
        by s is from that of the responses along the frequency axis; a second derivative tells how far that holds.

        Raises:
            ValueError: for other limits, such as those of ``critical_gain``, and one that does not tell its process.

        Warns:
            LobexWarning: for rates of a measurement whose noise hides them, and which are NaN.
        """
        return by_name("limits.growth_beside.growth_of")(self)

    @overload
    def plot(self, ax: "Axes", speed_unit: str | None = None, *, label: str | None = None) -> "Axes": ...
    @overload
    def plot(
        self, ax: None = None, speed_unit: str | None = None, *, axes: "Sequence[Axes] | None" = None
    ) -> "Figure": ...
    def plot(
        self,
        ax: "Axes | None" = None,
        speed_unit: str | None = None,
        *,
        axes: "Sequence[Axes] | None" = None,
        label: str | None = None,
    ) -> "Figure | Axes":
        """The limit with its stable region, kinds and lobe numbers, over the chatter frequencies; returns the figure.

        With ``ax`` the limit alone, drawn over what is there, a chart, measured cuts or other limits, whose ends are
        left as they are; returns these axes.

        Args:
            ax: axes for the limit alone.
            speed_unit: "Hz" or "rpm", by default what the process is usually drawn in.
            axes: two axes to draw into, for the limit and for its chatter frequency.
            label: with ``ax``, a name in the legend: the limit is then one of several, in a colour of its own.

        Raises:
            ValueError: for both of ``ax`` and ``axes``, and a ``label`` without ``ax``.
        """
        return by_name("plots.limit_picture.plot_limit")(self, ax, axes, speed_unit, label)
