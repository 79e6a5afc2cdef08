"""What the results of all wear marches hold: speeds, the casing's cells, sampling, and the model."""

from typing import Any

import numpy as np

from lobex import _checks
from lobex.results.fields import Array, Attribute, Coordinate, field
from lobex.results.result import Result


class OfWear(Result):
    """What a wear march over n lanes of speeds leaves; see ``WearMap`` and ``BladingWear``."""

    speed: np.ndarray = field(Coordinate("speed", "rotational frequency", "Hz"))
    speed_history: np.ndarray = field(
        Array("speed revolution", "rotational frequency of every revolution", "Hz", known=True)
    )
    angle: np.ndarray = field(Coordinate("angle", "casing position", "rad", increasing=True))
    samples_per_revolution: int
    lag: int
    usable_orders: int
    natural_frequency: np.ndarray = field(Array("mode", "natural frequency", "Hz", known=True))
    nodal_diameters: int
    radius: float
    axial_width: float
    model: dict[str, Any] = field(Attribute(lambda stored, name: stored.descriptions(name, "modes", "casing", "law")))
    seconds: float
    compiling: float
    failed: int

    @property
    def revolutions(self) -> int:
        """Number of revolutions."""
        return self.speed_history.shape[1]

    @property
    def steady(self) -> bool:
        """Whether every lane kept its speed."""
        return bool(np.all(self.speed_history == self.speed[:, None]))

    def time(self, lane: int) -> np.ndarray:
        """Times of the samples of ``displacement`` in a lane of constant speed, s, (samples,)."""
        if np.any(self.speed_history[lane] != self.speed[lane]):
            raise ValueError(f"lane = {lane} changes its speed; its samples lie at equal angles, not at equal times")
        samples = np.arange(self.samples_per_revolution * self.revolutions) - self.lag
        return samples / (self.samples_per_revolution * self.speed[lane])

    def nearest(self, speed: float) -> int:
        """The lane whose first speed is nearest to ``speed``, Hz."""
        _checks.positive("speed", speed, "Hz")
        _checks.scalar("speed", speed)
        return int(np.argmin(np.abs(self.speed - speed)))


def open_share(given: np.ndarray, lost: np.ndarray) -> np.ndarray:
    """What a balance leaves open, as a share of what is given."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(given == lost, 0.0, (given - lost) / given)
