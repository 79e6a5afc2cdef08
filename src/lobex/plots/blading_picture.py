"""Blading wear as a picture: how far each blade moves over speed."""

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import Normalize

from lobex.plots.frame import one_of
from lobex.plots.pooling import speed_order

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.blading_wear import BladingWear

# More lines than a legend can name are told apart by a scale of colours.
_NAMED = 8


def plot_blading(march: "BladingWear", ax: "Axes | None") -> "Axes":
    """Draw the largest motion of every contact over speed, and their mean where there are several."""
    order = speed_order("march", march.speed, ", or see of(contact).plot_history()")
    ax = one_of(ax, 7.0, 4.2)
    speed, peak = march.speed[order], march.peak[order] * 1e6
    contacts = peak.shape[1]
    colours = plt.get_cmap("viridis")(np.linspace(0, 0.9, contacts))
    several = contacts // march.blades > 1
    for contact, colour in enumerate(colours):
        name = f"blade {march.blade[contact] + 1}" + (f", track {march.track[contact] + 1}" if several else "")
        label = name if contacts <= _NAMED else None
        ax.plot(speed, peak[:, contact], color=colour, linewidth=1.0, label=label)
    ax.plot(speed, peak.mean(axis=1), color="k", linewidth=1.6, linestyle="--", label="mean of all")
    if contacts > _NAMED:
        scale = plt.cm.ScalarMappable(Normalize(1, march.blades), plt.get_cmap("viridis", march.blades))
        ax.figure.colorbar(scale, ax=ax, pad=0.02).set_label("blade")
    ax.set_xlim(speed[0], speed[-1])
    ax.set_ylim(bottom=0)
    ax.set_xlabel("rotational frequency (Hz)")
    ax.set_ylabel("largest tip motion (µm)")
    ax.legend(fontsize="small", ncols=2, frameon=False)
    return ax
