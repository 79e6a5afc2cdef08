"""Shapes of modes at the contact: what it sees of them and how it loads them."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._shapes import AnyArray

SHAPES = ("shape", "force_shape", "quadrature", "force_quadrature")
"""Of modes at the contact: what it sees of them and how it loads them, in phase and in quadrature."""


@in_float64
def together(parts: Sequence[tuple[Any, Any]]) -> tuple[Any, ...]:
    """Fields of all modes, their shapes times what goes with each part: (n, 1) times a direction, or a sign."""
    lib = namespace(parts)
    fields = [lib.concatenate([getattr(m, name) for m, _ in parts]) for name in ("angular_frequency", "damping_ratio")]
    for name in SHAPES:
        sides = shapes_of([modes for modes, _ in parts], name)
        scaled = None if sides is None else [side * by for side, (_, by) in zip(sides, parts, strict=True)]
        fields.append(None if scaled is None else lib.concatenate(scaled))
    return tuple(fields)


def shapes_of(modes: Sequence[Any], name: str) -> list[Any] | None:
    """What each of several modes has of one of ``SHAPES``, zeros where it has none; None where none of them has."""
    if all(getattr(one, name) is None for one in modes):
        return None
    lib = namespace(modes)
    sides = [one.loading if name == "force_shape" else getattr(one, name) for one in modes]
    return [
        lib.zeros(np.shape(one.shape)) if side is None else lib.asarray(side)
        for side, one in zip(sides, modes, strict=True)
    ]


@in_float64
def in_contact(
    modes: Any, normal: Float[AnyArray, "#m r"], loading: Float[AnyArray, "#m r"] | None
) -> dict[str, Float[AnyArray, "n m"] | None]:
    """By name the shapes that modes have where contacts see them along a normal each and load them along another
    direction, if that is given.
    """
    if loading is not None:
        lib, count = namespace(normal, loading), max(np.shape(normal)[0], np.shape(loading)[0])
        normal, loading = (lib.broadcast_to(part, (count, np.shape(part)[1])) for part in (normal, loading))

    def along(side: Any, vectors: Any) -> Any:
        return None if side is None else namespace(side, vectors).asarray(side) @ vectors.T

    acting = normal if loading is None else loading
    same = loading is None and modes.force_shape is None
    sides = {name: getattr(modes, name) for name in SHAPES if hasattr(modes, name)}
    sides["force_shape"] = None if same else modes.loading
    return {name: along(side, acting if "force" in name else normal) for name, side in sides.items()}


@in_float64
def seen_at(vectors: Any, contact: Any) -> Float[AnyArray, "n r"]:
    """Shapes of vectors (dof, n) along combinations of the degrees of freedom, (dof,) or (dof, r)."""
    lib = namespace(vectors, contact)
    directions = lib.asarray(contact, dtype=lib.result_type(float))
    return lib.asarray(vectors).T @ directions.reshape(directions.shape[0], -1)
