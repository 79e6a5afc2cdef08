"""Fig. 2.5: a turning tool in a stable and in an unstable cut."""

from typing import TYPE_CHECKING

import numpy as np

import lobex
from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPEED = 5000 / 60
DEPTHS = (5e-5, 2e-4)
FEED = 1e-4
REVOLUTIONS = 100
_STEPS = 500


def compute(share: float = 1.0) -> Results:
    """Two cuts from the first chip on, and the same motions without loss of contact. Always of full length."""
    cut = lobex.simulate_turning(models.tool(), lobex.Linear(models.RADIAL), SPEED, DEPTHS, FEED, REVOLUTIONS, _STEPS)
    process = models.turning()
    # Around the steady deflection K_r b h₀/k, with which the tool meets the whole feed at first.
    modes = process.modes
    compliance = float(np.sum((np.asarray(modes.shape)[:, 0] / np.asarray(modes.angular_frequency)) ** 2))
    steady = models.RADIAL * np.asarray(DEPTHS) * FEED * compliance
    march = lobex.march_delay(
        process, SPEED, DEPTHS, lambda time: np.broadcast_to(-steady[:, None], time.shape), REVOLUTIONS, _STEPS
    )
    return {"cut": cut, "linear": march}


def draw(results: Results) -> "Figure":
    """The displacement of each cut on its own scale, and both forces."""
    cut = results["cut"]
    figure, axes = style.panels(3, 6.6, sharex=True)
    for ax, motion, depth, name in zip(axes, cut.displacement, DEPTHS, ("stable", "unstable"), strict=False):
        look = style.LOOKS[0] if name == "stable" else style.LOOKS[1]
        ax.plot(cut.phase, motion * 1e6, color=look["color"], linewidth=0.8)
        ax.set_ylabel("displacement (µm)")
        ax.set_title(f"{name}: $b$ = {depth * 1e3:g} mm", fontsize="small", loc="left")
    cut.plot(axes[2], "force")
    figure.align_ylabels(axes)
    return figure


def _central_differences(depths: np.ndarray) -> np.ndarray:
    """(2.12) by the thesis' finite differences, (1.16), from the first chip on, (lanes, samples)."""
    modes = models.tool()
    omega, ratio = float(np.asarray(modes.angular_frequency)[0]), float(np.asarray(modes.damping_ratio)[0])
    mass = 1 / float(np.asarray(modes.shape)[0, 0]) ** 2
    step = 1 / (SPEED * _STEPS)
    q = np.zeros((len(depths), (REVOLUTIONS + 1) * _STEPS + 1))
    damping = ratio * omega * step
    for i in range(_STEPS, q.shape[1] - 1):
        force = models.RADIAL * depths * (FEED + q[:, i - _STEPS] - q[:, i]) / mass
        inertia = 2 * q[:, i] - (1 - damping) * q[:, i - 1]
        q[:, i + 1] = (inertia + step**2 * (force - omega**2 * q[:, i])) / (1 + damping)
    return q[:, _STEPS:]


def findings(results: Results) -> list[Finding]:
    """Growth, and where it ends."""
    cut, march = results["cut"], results["linear"]
    predicted = lobex.sweep(models.turning(), [SPEED], DEPTHS).spectral_radius[0]
    free = [int(np.argmax(force == 0)) if (force == 0).any() else len(force) for force in cut.force]
    differences = _central_differences(np.asarray(DEPTHS))
    apart = max(
        float(np.abs(motion[:end] - other[:end]).max() / np.abs(motion[:end]).max())
        for motion, other, end in zip(cut.displacement, differences, free, strict=True)
    )
    left = free[1] / _STEPS
    share = float(cut.separation[1])
    return [
        Finding(
            "A stable cut calms down and an unstable one vibrates more and more.",
            "tool motion in stable and unstable conditions, no parameters given",
            f"at 5000 rpm per revolution: {march.growth[0]:.4f} at {DEPTHS[0] * 1e3:g} mm and {march.growth[1]:.4f} at "
            f"{DEPTHS[1] * 1e3:g} mm, where the multipliers say {predicted[0]:.4f} and {predicted[1]:.4f}",
            bool(march.growth[0] < 1 < march.growth[1]),
            "Tool and cut are ours: §3.4's tool, K_r = 200 N/mm², a feed of 0.1 mm.",
            {
                "stable": float(march.growth[0]),
                "unstable": float(march.growth[1]),
                "error": float(np.max(np.abs(march.growth / predicted - 1))),
            },
        ),
        Finding(
            "Different time integrations give the same motion and forces.",
            "explicit Euler, finite differences and dde23: the same",
            f"the exponential steps of lobex and the thesis' finite differences differ by {apart:.1e} of the motion "
            "until the tool first leaves the cut",
            apart < 0.05,
            "What is left is the phase error of the finite differences, with 500 steps per revolution.",
            {"apart": apart},
        ),
        Finding(
            "Chatter grows.",
            "'vibrations grow'",
            f"until the tool leaves the cut in revolution {left:.0f}; it ends with ±{cut.amplitude[1] * 1e6:.0f} µm, "
            f"out of the cut for {100 * share:.0f} % of a revolution",
            share > 0,
            "By (2.12) alone it would grow for ever; here the force is zero out of the cut.",
            {"out_of_cut": share, "amplitude": float(cut.amplitude[1])},
        ),
    ]


FIGURE = Reproduction(
    "fig-2.5",
    "Chatter in turning",
    "Below the limit the tool's vibration dies out, above it grows.",
    compute,
    draw,
    findings,
)
