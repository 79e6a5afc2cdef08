"""Measured frequency responses, as receptances by direction of response and reference."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Complex, Float

from lobex import _checks
from lobex._by_name import by_name
from lobex.limits.measurement import MEASURED, named
from lobex.limits.receptance import Receptance
from lobex.limits.receptance_matrix import ReceptanceMatrix

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lobex.measured.modal_fit import ModalFit
    from lobex.structures.modes import Modes

_LEAST = 8
# Rounding of a coherence.
_ABOVE_ONE = 1e-3


@dataclass(frozen=True, eq=False, repr=False)
class Frf:
    """Frequency responses of a structure: displacement over force, for the time dependence e^{jωt}.

    Attributes:
        frequency: increasing frequencies above zero, (n,), n ≥ 8, Hz.
        matrix: receptances, (n, r, p), m/N, of r responses to forces along p references; NaN throughout for a pair that
            was not measured.
        responses: names of the directions of the responses, (r,), such as "x"; with the number of a point before it
            where there are several, "12 x".
        references: names of those of the forces, (p,).
        coherence: of each, (n, r, p); None where there is none.
        measured: what was measured over force, "displacement", "velocity" or "acceleration": noise is about as large at
            all frequencies in that, so that fits weigh by it.
        source: of which file they are.
        notes: how the file was read.

    Raises:
        ValueError: for frequencies that are not increasing and above zero, fewer than 8, shapes that do not agree,
            names that occur twice, pairs of which a part of the values is not finite, or all are zero, and coherence
            that is not from 0 to 1.
    """

    frequency: Float[np.ndarray, " n"]
    matrix: Complex[np.ndarray, "n r p"]
    responses: tuple[str, ...] = ("x",)
    references: tuple[str, ...] = ("x",)
    coherence: Float[np.ndarray, "n r p"] | None = None
    measured: str = "displacement"
    source: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _checks.choice("measured", self.measured, MEASURED)
        frequency = _checks.grid("frequency", self.frequency, "Hz") if np.size(self.frequency) else np.zeros(0)
        _checks.positive("frequency", frequency, "Hz")
        if len(frequency) < _LEAST:
            raise ValueError(f"frequency has {len(frequency)} lines above 0 Hz; give at least {_LEAST}")
        matrix: np.ndarray = np.asarray(self.matrix, dtype=complex)
        if matrix.ndim in (1, 2):
            matrix = np.expand_dims(matrix, tuple(range(matrix.ndim, 3)))
        object.__setattr__(self, "frequency", frequency)
        object.__setattr__(self, "matrix", matrix)
        for name in ("responses", "references"):
            given = getattr(self, name)
            names = (given,) if isinstance(given, str) else tuple(given)
            if len(set(names)) != len(names):
                raise ValueError(f"{name} = {_checks.brief(names)} has a name twice; give each direction one")
            object.__setattr__(self, name, names)
        shape = len(frequency), len(self.responses), len(self.references)
        if matrix.shape != shape:
            raise ValueError(
                f"matrix has shape {matrix.shape}; give (frequencies, responses, references), {shape} of these names"
            )
        if self.coherence is not None and np.shape(self.coherence) != shape:
            raise ValueError(f"coherence has shape {np.shape(self.coherence)}; give that of matrix, {shape}")
        known = np.asarray(np.nan if self.coherence is None else self.coherence, dtype=float)
        if np.any((known < 0) | (known > 1 + _ABOVE_ONE)):
            worst = known.ravel()[np.nanargmax(np.abs(known - 0.5))]
            raise ValueError(
                f"coherence has {worst:.4g}, and is a share from 0 to 1; divide per cent by 100, or leave it out, in "
                "read_frf by 'unused' among columns"
            )
        for response, reference in self._all_pairs():
            values = self._values(response, reference)
            if np.isnan(values).all():
                continue
            if not np.isfinite(values).all():
                raise ValueError(
                    f"matrix has NaN or infinite values among those of {response} to {reference}; leave their "
                    "frequencies out, or give NaN throughout for a pair that was not measured"
                )
            if not np.any(values):
                raise ValueError(f"matrix is zero throughout for {response} to {reference}; give NaN if not measured")
        if not self.pairs:
            raise ValueError("matrix has no values; give receptances in m/N")

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Every pair of response and reference that was measured."""
        return tuple(pair for pair in self._all_pairs() if not np.isnan(self._values(*pair)[0]))

    @property
    def driving_points(self) -> tuple[str, ...]:
        """Directions in which both response and force were measured."""
        return tuple(response for response, reference in self.pairs if response == reference)

    def values(self, response: str | None = None, reference: str | None = None) -> Complex[np.ndarray, " n"]:
        """The receptance of one response to one reference, (n,), m/N; the only one, or that at a driving point.

        Args:
            response: name of its direction; None for the only one.
            reference: name of that of the force; None for that of the response.

        Raises:
            ValueError: for names that are none of these, a pair that was not measured, and no names where there are
                several.
        """
        if response is None:
            if len(self.pairs) > 1:
                raise ValueError(f"response = None of several, {self._named()}; name one")
            response, only = next(iter(self.pairs))
            reference = only if reference is None else reference
        pair = (response, response if reference is None else reference)
        if pair not in self.pairs:
            raise ValueError(
                f"response = {pair[0]!r} to reference = {pair[1]!r} was not measured; there are {self._named()}"
            )
        return self._values(*pair)

    def between(self, low: float, high: float) -> "Frf":
        """The lines from ``low`` to ``high``, Hz, such as those with coherence.

        Raises:
            ValueError: for ends that are not increasing, and fewer than 8 lines between them.
        """
        ends = _checks.grid("low, high", [low, high], "Hz")
        inside = (self.frequency >= ends[0]) & (self.frequency <= ends[1])
        coherence = None if self.coherence is None else self.coherence[inside]
        return replace(self, frequency=self.frequency[inside], matrix=self.matrix[inside], coherence=coherence)

    def receptance(self, response: str | None = None, reference: str | None = None) -> Receptance:
        """The samples of one pair as a ``Receptance``, from which limits come without any fit; names as of ``values``.

        Raises:
            ValueError: as ``values``, and for samples that are zero.

        Warns:
            LobexWarning: where they cannot be those of a driving point.
        """
        return Receptance(self.frequency, self.values(response, reference))

    def receptance_matrix(self) -> ReceptanceMatrix:
        """All driving points with what links them, for limits of milling without a fit.

        A cross receptance that was measured one way alone stands for both, as in any structure that does not turn; one
        that was not measured is zero.

        Raises:
            ValueError: without a driving point, and for samples of one that are zero.
        """
        names = sorted(self.driving_points)
        if not names:
            raise ValueError(
                f"there is no driving point among {self._named()}; measure force and response in one direction"
            )
        matrix = np.zeros((len(self.frequency), len(names), len(names)), complex)
        for i, response in enumerate(names):
            for j, reference in enumerate(names):
                pair = next((p for p in ((response, reference), (reference, response)) if p in self.pairs), None)
                matrix[:, i, j] = 0 if pair is None else self._values(*pair)
        return ReceptanceMatrix(self.frequency, matrix)

    def modes(self, order: int | None = None, band: Sequence[float] | None = None, real: bool = True) -> "Modes":
        """The modes that ``fit`` finds, without its report."""
        return self.fit(order, band, real).modes

    def fit(self, order: int | None = None, band: Sequence[float] | None = None, real: bool = True) -> "ModalFit":
        """Modes fitted to all responses together, with their misfit and uncertainty.

        Poles of least-squares complex frequency-domain estimates of growing order (Guillaume, Verboven, Vanlanduit, Van
        der Auweraer and Peeters, A poly-reference implementation of the least-squares complex frequency-domain
        estimator, IMAC XXI, 2003) that stay where they are from order to order are modes; frequencies, damping and
        residues are then those of least squares, with a term below the band and one above it for the modes there. Lines
        of less coherence than half of them have weigh less, by what it says of their noise.

        Args:
            order: number of modes of each group of directions that cross responses link; None for as many as the data
                tell: those that are stable and explain more than noise does, by Schwarz' criterion (1978).
            band: lowest and highest frequency, Hz; None for all.
            real: modes whose points move in phase, as those with little damping do, and which all processes take;
                False for complex modes.

        Returns:
            A ``ModalFit`` with ``modes`` in as many directions as were measured.

        Raises:
            ValueError: for a band without frequencies enough, no driving point, so that shapes have no scale, and where
                no pole is stable.

        Warns:
            LobexWarning: for a misfit that noise does not explain.
        """
        from lobex.measured.modal_fit import fitted

        return fitted(self, order, band, real)

    def plot(self) -> "Figure":
        """Magnitude and phase of every pair, and coherence where there is one; returns the figure."""
        return by_name("plots.frf_picture.plot_frf")(self)

    def __repr__(self) -> str:
        low, high = self.frequency[[0, -1]]
        step = (high - low) / (len(self.frequency) - 1)
        lines = [
            f"Frf of {self.source or 'samples'}: {len(self.frequency)} lines",
            f"  frequency        {low:.6g} to {high:.6g} Hz, {step:.4g} Hz apart",
            f"  pairs            {self._named()}",
            f"  measured         {named(self.measured)}, held as receptance in m/N",
        ]
        if self.coherence is not None:
            lines.append(f"  coherence        {np.nanmean(self.coherence):.3g} in the mean")
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])

    def _all_pairs(self) -> list[tuple[str, str]]:
        return [(response, reference) for reference in self.references for response in self.responses]

    def _values(self, response: str, reference: str) -> np.ndarray:
        return self.matrix[:, self.responses.index(response), self.references.index(reference)]

    def _named(self) -> str:
        return ", ".join(f"{response} to {reference}" for response, reference in self.pairs)


def names_of(name: str, given: Any) -> tuple[str, ...] | None:
    """Names of directions as an argument gives them, one or several.

    Raises:
        ValueError: for what is no text.
    """
    if given is None:
        return None
    names: tuple[Any, ...] = (given,) if isinstance(given, str) else tuple(given) if isinstance(given, Sequence) else ()
    if not names or not all(isinstance(one, str) and one.strip("-") for one in names):
        raise ValueError(f"{name} = {_checks.brief(given)} is no direction; give such as 'x', '-x' or ('x', 'y')")
    return names
