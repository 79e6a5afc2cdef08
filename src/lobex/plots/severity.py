"""How far blades move over speed and penetration, as marches find it, with what their lobes foretell drawn over it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex.plots.frame import one_of
from lobex.results.limit import Limit
from lobex.studies.study import Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_QUANTITIES = {
    "amplitude": ("tip motion in the last revolution", 1e6, "µm"),
    "wear": ("cross-section removed", 1e6, "mm²"),
}
_UNSTABLE = "#12436d"


def severity(
    study: Study,
    limit: Limit | None = None,
    stiffness: float | None = None,
    *,
    of: str = "amplitude",
    ax: "Axes | None" = None,
) -> "Axes":
    """Draw what marches over speed and the initial penetration end in, and where the lobes foretell chatter.

    A study of wear over "casing.amplitude" says by how much its bumps reach beyond the clearance: ``march_wear(…,
    over={"casing.amplitude": …})``. The prediction is that of permanent contact, whatever the penetration: hatched are
    speeds at which the contact is stiffer than the limit.

    Args:
        study: of ``march_wear`` over one further axis, the height of the bumps, m.
        limit: the stability limit of the same blade over speed, such as ``exact_limit(Rub(modes), speed)``; None for
            none.
        stiffness: that of the contact law, N/m, which the limit is held against.
        of: "amplitude", the largest motion of a tip in the last revolution, or "wear", the cross-section that all
            revolutions removed.
        ax: axes to draw into.

    Returns:
        The axes.

    Raises:
        ValueError: for a study of another kind or over other axes, a limit without a stiffness, fewer than two speeds
            or penetrations, and speeds that change.
    """
    from matplotlib.patches import Patch

    from lobex.plots.wear_pictures import COLOURS

    if not isinstance(study, Study) or study.verb != "march_wear" or list(study.over) != ["casing.amplitude"]:
        raise ValueError(
            f"study = {_checks.brief(study)} is no study of march_wear over casing.amplitude alone; give one"
        )
    _checks.choice("of", of, tuple(_QUANTITIES))
    if (limit is None) != (stiffness is None):
        raise ValueError(f"limit and stiffness = {_checks.brief(stiffness)} go together; give both or none")
    depth, speed = study.over["casing.amplitude"] - _clearance(study), study.speed
    if len(depth) < 2 or len(np.unique(speed)) < 2:
        raise ValueError(f"study has {len(depth)} penetrations and {len(speed)} speeds; give two or more of each")
    order = np.argsort(speed)
    name, scale, unit = _QUANTITIES[of]
    values = _over_lanes(study, of)[:, order] * scale
    ax = one_of(ax, 7.0, 4.2)
    mesh = ax.pcolormesh(speed[order], depth * 1e6, values, cmap=COLOURS, vmin=0, shading="nearest", rasterized=True)
    ax.figure.colorbar(mesh, ax=ax, pad=0.02).set_label(f"{name} ({unit})")
    ax.set_xlabel("rotational frequency (Hz)")
    ax.set_ylabel("initial penetration (µm)")
    if depth.min() >= 0:
        # Half a cell of the first one lies below.
        ax.set_ylim(bottom=max(0.0, ax.get_ylim()[0]))
    if limit is not None and stiffness is not None:
        _checks.positive("stiffness", stiffness, "N/m")
        along = np.argsort(limit.speed)
        unstable = ~(np.asarray(limit.gain)[along] >= stiffness) & ~np.isnan(np.asarray(limit.gain)[along])
        ax.fill_between(
            limit.speed[along],
            *ax.get_ylim(),
            where=unstable.tolist(),
            facecolor="none",
            edgecolor=_UNSTABLE,
            hatch="//",
            linewidth=0.6,
        )
        handle = Patch(facecolor="none", edgecolor=_UNSTABLE, hatch="//", label="lobes foretell chatter")
        ax.legend(handles=[handle], loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False, fontsize="small")
        ax.set_xlim(speed.min(), speed.max())
    return ax


def _clearance(study: Study) -> float:
    found: Any = study.at(0)
    casing = found.model["casing"]
    return float((casing[0] if isinstance(casing, list) else casing)["clearance"])


def _over_lanes(study: Study, of: str) -> Any:
    """(penetrations, speeds): the last revolution's largest motion of all contacts, or the wear of all of them."""
    found = study[of]
    values = found.isel(revolution=-1) if of == "amplitude" else found.sum("revolution")
    for dim in ("contact", "track"):
        if dim in values.dims:
            values = values.max(dim) if of == "amplitude" else values.sum(dim)
    return values.transpose("casing.amplitude", "speed").to_numpy()
