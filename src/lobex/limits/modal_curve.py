"""The receptance of modes along the frequency axis, and the grid that shows all of its features."""

from jaxtyping import Bool, Complex, Float, Int

from lobex._namespace import namespace, still
from lobex._shapes import AnyArray, Number
from lobex.limits.receptance_curve import clustered
from lobex.limits.sections import Sections, modal_response

# Grid of a mode: points on either side of it, and up to what multiple of the highest frequency they go.
_POINTS = 32
_REACH = 100.0


class ModalCurve:
    """The receptance of modes: one row per mode, from halfway to the one below (or from zero) to halfway to the next.

    A mode without damping is given ξ = ε², ε the rounding unit: its pole becomes a resonance narrower than
    any rounding of ω, and everything else stays as it is.
    """

    def __init__(self, sections: Sections, turn: Number = 0.0) -> None:
        lib = namespace(sections)
        angular_frequency = lib.asarray(sections.angular_frequency, dtype=lib.result_type(float))
        order = lib.argsort(still(angular_frequency))
        damping_ratio = lib.asarray(sections.damping_ratio, dtype=angular_frequency.dtype)[order]
        floor = lib.finfo(angular_frequency.dtype).eps ** 2
        self.undamped = damping_ratio < floor
        raised = still(lib.maximum(damping_ratio, floor) - damping_ratio)
        self.anchor = angular_frequency[order]
        weight = lib.asarray(sections.weight)[order]
        rate = None if sections.rate is None else lib.asarray(sections.rate)[order]
        self.sections = Sections(self.anchor, damping_ratio + raised, weight, rate)
        self.turn = turn
        self.open_ended = True
        # Of Re G, its slope and the bend of arg G: degrees in ω² of their numerators, which are at most 4n, and of
        # complex weights, where these are not even, in ω.
        self.most_breaks = (8 if lib.iscomplexobj(weight) else 4) * len(self.anchor)

    def grid(self) -> tuple[Int[AnyArray, " points"], Float[AnyArray, " points"]]:
        lib = namespace(self.sections)
        anchor, width = self.anchor, self.anchor * self.sections.damping_ratio
        apart = lib.abs(anchor[:, None] - anchor)
        # The finest feature as seen from each mode, which may be a neighbour's resonance.
        finest = lib.min(lib.maximum(width, apart), axis=1)
        top = _REACH * lib.max(anchor + 2 * width)
        # Neighbouring rows overlap by a little more than rounding, so that nothing falls between them.
        half = lib.diff(anchor) / 2 + 8 * lib.finfo(anchor.dtype).eps * anchor[1:]
        # Below the first mode Re G > 0 at a driving point, but not where displacement and force differ.
        below = lib.concatenate([anchor[:1], half])
        above = lib.concatenate([half, top[None]])
        steps = lib.arange(1, _POINTS + 1) / _POINTS
        left, right = (clustered(finest[:, None], reach[:, None], steps) for reach in (below, above))
        offset = lib.concatenate([-left[:, ::-1], lib.zeros((len(anchor), 1), anchor.dtype), right], axis=1)
        return lib.repeat(lib.arange(len(anchor)), offset.shape[1]), offset.ravel()

    def at(
        self, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
    ) -> tuple[Complex[AnyArray, " *points"], Complex[AnyArray, " *points"], Complex[AnyArray, " *points"]]:
        anchor = self.anchor[row]
        return modal_response(self.sections, self._distance(row, offset), anchor + offset)

    def undamped_at(
        self, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
    ) -> Bool[AnyArray, " *points"]:
        lib = namespace(self.sections, row, offset)
        close = lib.abs(self._distance(row, offset)) <= lib.finfo(self.anchor.dtype).eps ** 1.5 * self.anchor
        return lib.any(close & self.undamped, axis=-1)

    def _distance(
        self, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
    ) -> Float[AnyArray, "*points n"]:
        return (self.anchor - self.anchor[row][..., None]) - offset[..., None]
