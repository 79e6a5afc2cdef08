"""What moves in a march: the modes of blades and of a casing, at the speeds of its lanes."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.structures.blading import Blading
from lobex.structures.modes import Modes, check_modes
from lobex.structures.modes_over_speed import ModesOverSpeed


@pytree()
class Body:
    """Modes of equal or mistuned blades, or of a casing. Axes that all blades or lanes share have length 1.

    Attributes:
        frequency, damping_ratio: ω, rad/s, and ξ, (modes, blades, lanes).
        shape: φ of what is seen, the contacts first, (modes, seen, blades, lanes), 1/√kg.
        force_shape: ψ of the contacts, (modes, contacts, blades, lanes); None where it is ``shape``.
        quadrature, force_quadrature: χ and χ̂ of complex modes, as ``shape`` and ``loading``; both or None.
        coupling: ω_c² of springs between the modes of neighbours, (modes, 1, 1), rad²/s², or None.
    """

    frequency: Float[AnyArray, "modes *#columns"]
    damping_ratio: Float[AnyArray, "modes *#columns"]
    shape: Float[AnyArray, "modes seen *#columns"]
    force_shape: Float[AnyArray, "modes contacts *#columns"] | None = None
    quadrature: Float[AnyArray, "modes seen *#columns"] | None = None
    force_quadrature: Float[AnyArray, "modes contacts *#columns"] | None = None
    coupling: Float[AnyArray, "modes 1 1"] | None = None

    @property
    def count(self) -> int:
        """Number of modes of each blade."""
        return self.frequency.shape[0]

    @property
    def blades(self) -> int:
        """Number of blades that are told apart."""
        return self.frequency.shape[1]

    @property
    def loading(self) -> Float[AnyArray, "modes contacts *#columns"]:
        """ψ of the contacts."""
        return self.shape if self.force_shape is None else self.force_shape


def in_lanes(body: Body, blades: int, lanes: int) -> Body:
    """Blades that nothing couples as so many lanes each, the lanes of the first, of the second, and so on."""

    def one(part: Float[AnyArray, "*some #blades #lanes"]) -> Float[AnyArray, "*some 1 #columns"]:
        if part.shape[-2:] == (1, 1):
            return part
        return jnp.broadcast_to(part, (*part.shape[:-2], blades, lanes)).reshape(*part.shape[:-2], 1, -1)

    return jax.tree.map(one, body)


class Structure:
    """One blade, all of a blading, or a casing: its body at any speeds.

    Args:
        name: of the argument, for messages.
        given: ``Modes``, those that follow the speed, or a ``Blading`` of them.
        contacts: how many of the directions, the first, are contacts; what others are is only watched.
    """

    def __init__(self, name: str, given: Any, contacts: int | None = None) -> None:
        blade = getattr(given, "blade", given)
        check_modes(blade, over_speed=True, name=name)
        self.given, self.blade = given, blade
        self.blades = given.count if blade is not given else 1
        self.contacts = blade.directions if contacts is None else contacts
        self.follows_speed = hasattr(blade, "check_speed")
        self._known: dict[float, Modes] = {}

    def learn(self, speeds: Float[np.ndarray, "..."]) -> None:
        """Find the modes at all speeds at which they will be asked for, each mode going on from one to the next."""
        if not self.follows_speed:
            return
        every = np.unique(speeds)
        self.blade.check_speed(every)
        table = self.blade.over(every) if hasattr(self.blade, "over") else self.blade
        if isinstance(table, Modes | ModesOverSpeed):
            self._known = {float(one): table.at(one) for one in every}
            return
        rows = [table.at(one) for one in every]
        self._known = dict(zip(every.tolist(), rows, strict=True))

    def at(self, speed: float) -> Modes:
        """The modes of a blade at a speed, Hz."""
        return self._known[float(speed)] if self.follows_speed else self.blade

    def body(self, speeds: Float[np.ndarray, " lanes"]) -> Body:
        """The modes at the speeds of the lanes, which have been learnt."""
        lanes = [self.at(one) for one in speeds] if self.follows_speed else [self.blade]
        frequency, damping_ratio, shape = (
            _stacked([getattr(one, name) for one in lanes]) for name in ("angular_frequency", "damping_ratio", "shape")
        )
        loading, *aside = (
            None if getattr(lanes[0], name) is None else _stacked([getattr(one, name) for one in lanes])
            for name in ("force_shape", "quadrature", "force_quadrature")
        )
        if lanes[0].complex:
            aside = [np.zeros_like(shape) if side is None else side for side in aside]
            aside[1] = aside[1][:, : self.contacts]
        coupling = None
        if isinstance(self.given, Blading):
            # Of blades that are alike one frequency serves all.
            if self.given.mistuning is not None:
                frequency = frequency * np.asarray(self.given.detuned).T[:, :, None]
            if self.given.coupling is not None:
                coupling = np.asarray(self.given.coupling_stiffness).reshape(-1, 1, 1)
        if loading is None and self.contacts < shape.shape[1]:
            loading = shape
        loading = None if loading is None else loading[:, : self.contacts]
        return Body(frequency, damping_ratio, shape, loading, aside[0], aside[1], coupling)


def _stacked(parts: Sequence[Any]) -> Float[np.ndarray, "modes ... lanes"]:
    """Of all lanes, with one blade: (modes, 1, lanes) or (modes, directions, 1, lanes)."""
    return np.stack([np.asarray(part, dtype=float) for part in parts], axis=-1)[..., None, :]
