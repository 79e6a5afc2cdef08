"""What the thesis gets wrong or leaves open, with the effect that each has on results, computed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg

import lobex
from lobex.gallery import models

Numbers = dict[str, float]


@dataclass(frozen=True)
class Erratum:
    """One slip or gap.

    Attributes:
        place: where in the thesis.
        printed: what it says.
        right: what holds instead, or what lobex takes.
        effect: on results, in words, from the numbers of ``effects`` and of the gallery ("fig-4.12/caption_85").
        matters: whether it changes a result.
    """

    place: str
    printed: str
    right: str
    effect: Callable[[Numbers], str]
    matters: bool = True


def effects() -> Numbers:
    """The numbers that no figure of the gallery has."""
    return {**_sign(), **_damping(), **_directions(), **_start(), **_stored()}


def _sign() -> Numbers:
    """The stiffness of chapter 1's rod, and its least eigenvalue with +K_e h on the tip's right-hand side."""
    rod = lobex.Rod(10)
    mass, stiffness, _ = (np.array(matrix) for matrix in rod.matrices())
    tip = float(1 / np.linalg.inv(stiffness)[-1, -1])
    stiffness[-1, -1] -= models.CONTACT_STIFFNESS[1]
    return {"tip_stiffness": tip, "least_eigenvalue": float(scipy.linalg.eigvalsh(stiffness, mass)[0])}


def _damping() -> Numbers:
    """The least limits with the text's damping ratio and with Appendix B's."""
    text, code = (models.least(models.rub(damping_ratio=ratio))[0] for ratio in (0.03, 0.0177))
    return {"least_of_the_text": text, "least_of_the_code": code}


def _directions() -> Numbers:
    """Share of §3.4's map of milling that is stable in one direction and unstable in the other."""
    speed, depth = np.linspace(6000, 12000, 31)[:, None] / 60, np.linspace(2e-4, 5e-3, 17)
    down, up = (
        lobex.spectral_radius(
            lobex.Milling(models.tool(), 1, tangential=5.5e8, normal=2e8, radial_immersion=0.5, direction=direction),
            speed,
            depth,
            lobex.Chebyshev(24),
        )
        for direction in ("down", "up")
    )
    return {"changed_by_direction": float(np.mean((down < 1) != (up < 1)))}


def _start() -> Numbers:
    """The rate at which 1.0005 per step grows, by the step: 1/s."""
    return {f"rate_of_{us}_us": float(np.log(1.0005) / (us * 1e-6)) for us in (1, 2)}


def _stored() -> Numbers:
    """How far the first unstable value of Appendix B's 401 gains may lie above the limit."""
    low, high = models.CONTACT_STIFFNESS
    step = (high - low) / 400
    return {"gain_step": step, "share_of_the_least": step / models.least(models.rub(damping_ratio=0.0177))[0]}


ERRATA = (
    Erratum(
        "(1.12)–(1.15)",
        "the contact force +K_e(q − h) stands on the right-hand side",
        "the reaction on the tip is −K_e h",
        lambda n: (
            f"as printed the contact is a negative stiffness. Beyond the rod's own {n['tip_stiffness'] / 1e6:.2f} MN/m "
            f"the blade has no rest: at 4.5 MN/m its least ω² is "
            f"−{-n['least_eigenvalue'] / 1e6:.2f}·10⁶ s⁻². Such a contact softens, and Fig. 1.3 shows stiffening."
        ),
    ),
    Erratum(
        "§1.4",
        "the order of wear and force within a step is open",
        "force from the cell as it is, then the step, then the wear of that cell",
        lambda n: "worn before its force is evaluated, no cell ever meets the tip: h ≤ 0, no force, no vibration.",
    ),
    Erratum(
        "chapter 1",
        "no K_e, clearance, profile or time step is given for Figs. 1.2 to 1.4",
        "cos² bumps of 0.1 mm, no clearance, 4.5 MN/m, ξ = 0.03, 20 revolutions",
        lambda n: (
            f"wear peaks at {n['fig-1.3/peak6']:.0f}, {n['fig-1.3/peak4']:.0f} and {n['fig-1.3/peak2']:.0f} Hz; "
            "places agree, heights cannot be compared."
        ),
    ),
    Erratum(
        "(3.4)",
        "delayed feedback −K_e[q(t) − q(t − τ)] without a condition",
        "a variation around a steady feed: h₀ + q(t) − q(t − τ) > 0",
        lambda n: (
            "limits are those of small motion and hold. Larger ones leave the contact: the turning tool of Fig. 2.5 is "
            f"out of the cut for {100 * n['fig-2.5/out_of_cut']:.0f} % of a revolution in the end."
        ),
    ),
    Erratum(
        "chapter 4, Appendix B",
        "ξ = 0.03 in the text, 0.0177 in the code; figures do not say which",
        "0.03 by default",
        lambda n: (
            f"the least limit is {n['least_of_the_text'] / 1e6:.3f} MN/m with the text's and "
            f"{n['least_of_the_code'] / 1e6:.3f} MN/m with the code's: "
            f"{100 * (1 - n['least_of_the_code'] / n['least_of_the_text']):.0f} % less."
        ),
    ),
    Erratum(
        "Fig. 4.13, caption",
        "1.35·10⁵ N/m is the unstable case",
        "1.35·10⁶ N/m, as in the text",
        lambda n: (
            f"at 1.35·10⁵ N/m max|μ| is {n['fig-4.12/caption_85']:.3f} (85 Hz) and {n['fig-4.12/caption_112']:.3f} "
            "(112 Hz): stable."
        ),
    ),
    Erratum(
        "§2.2.2",
        "up- and down-milling are exchanged",
        "Appendix A is right: down from arccos(2a − 1) to π, up from 0 to arccos(1 − 2a)",
        lambda n: (
            f"at half immersion, 6,000 to 12,000 rpm and depths to 5 mm {100 * n['changed_by_direction']:.0f} % of the "
            "points change sides: the lobes of the two directions lie at different speeds."
        ),
    ),
    Erratum(
        "§3.4, Fig. 3.2",
        "Chebyshev collocation and semi-discretization are equally precise",
        "one interval of polynomials cannot follow the jump of K_s(t); pieces that end there can",
        lambda n: (
            f"max|μ| errs by {n['fig-3.2/chebyshev']:.1e} in the median with 40 nodes in one interval, by "
            f"{n['fig-3.2/semi_discretization']:.1e} with semi-discretization; "
            f"{100 - 100 * n['fig-3.2/verdict_chebyshev']:.1f} % of the map's points change sides."
        ),
    ),
    Erratum(
        "(4.3)",
        "the start grows by 1.0005 per time step",
        "q₀ exp(t ln(1.0005)/1 µs)",
        lambda n: (
            f"as printed the start depends on the step: {n['rate_of_1_us']:.0f} s⁻¹ with 1 µs, "
            f"{n['rate_of_2_us']:.0f} s⁻¹ with 2 µs. Growth afterwards does not."
        ),
    ),
    Erratum(
        "§4.2, Fig. 4.3",
        "that vibration ends past f₁ confirms the lobe diagram",
        "two phenomena: resonance with bumps at f₁/k, and regenerative instability",
        lambda n: (
            f"the lobe of highest speed is lowest at {n['fig-4.3/first_lobe']:.0f} Hz = "
            f"{n['fig-4.3/first_lobe_ratio']:.2f} f₁, where chapter 1 shows no wear."
        ),
    ),
    Erratum(
        "§4.3.3",
        "damping does not affect the natural frequencies, so that lobes do not shift",
        "chatter is at ω_n√(1 + 2ξ), not at ω_n",
        lambda n: (
            f"from ξ = 0.03 to 0.04 lobes shift by {100 * n['fig-4.11/least_shift']:.1f} to "
            f"{100 * n['fig-4.11/largest_shift']:.1f} %: too little to be seen."
        ),
    ),
    Erratum(
        "Appendices A and B",
        "the first unstable gain of the grid is stored as the limit, and its last one where none is unstable; the "
        "speed is stored as 0",
        "interpolated or polished; NaN and a status where there is no limit",
        lambda n: (
            f"limits are up to {n['gain_step'] / 1e3:.1f} kN/m too high, {100 * n['share_of_the_least']:.1f} % of the "
            "least one; and where there is no limit, the top of the grid passes for one."
        ),
    ),
    Erratum(
        "chapter 4",
        "K_e in N/m²",
        "K_e is in N/m; milling's K_t and K_n are in N/m²",
        lambda n: "none: numbers are those of N/m.",
        matters=False,
    ),
    Erratum(
        "§3.2",
        "T_j(x_j) = arccos(j x_j); c_i = 2 for i = 1 and m",
        "T_j(x) = cos(j arccos x); c_i = 2 for i = 0 and m",
        lambda n: (
            f"the matrix as printed differentiates x⁵ with an error of {n['fig-3.1/as_printed']:.1f}; the codes "
            f"are right ({n['fig-3.1/corrected']:.0e})."
        ),
        matters=False,
    ),
    Erratum(
        "chapter 3, appendices",
        "m + 1 nodes in the text; Φ in (3.8)–(3.9); (3.21) of size n(k + 1); dtr = 2π/k; Fi = D_S·Fi left out; h_i",
        "m nodes in the codes; κ; n(k + 2); 2π/(N k); Fi = D_S·Fi; K_s",
        lambda n: "none on the figures; a reader who types the printed code in gets another or no diagram.",
        matters=False,
    ),
)
