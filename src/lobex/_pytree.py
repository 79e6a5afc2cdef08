"""Frozen dataclasses that JAX sees as pytrees, and the check of what others bring."""

import dataclasses
from collections.abc import Callable
from typing import Any, TypeVar, dataclass_transform

import jax
import numpy as np

from lobex import _checks

T = TypeVar("T", bound=type)


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
def pytree(*, static: tuple[str, ...] = ()) -> Callable[[T], T]:
    """Make a class a frozen dataclass and a pytree; the fields named in ``static`` are compile-time constants.

    ``jax.tree_util.register_dataclass`` would call the constructor for every tree that JAX rebuilds, and so
    run the argument checks on tracers and on the placeholders of ``vmap``; here rebuilding skips them.
    """

    def register(cls: T) -> T:
        frozen: Any = dataclasses.dataclass(frozen=True)(cls)
        # What is constant of a class is so of those that are made from it.
        constant = tuple(dict.fromkeys((*getattr(cls, "_constant", ()), *static)))
        frozen._constant = constant
        traced = tuple(f.name for f in dataclasses.fields(frozen) if f.name not in constant)

        def flatten(tree: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
            return tuple(getattr(tree, n) for n in traced), tuple(getattr(tree, n) for n in constant)

        def flatten_with_keys(tree: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
            leaves, sizes = flatten(tree)
            keys = (jax.tree_util.GetAttrKey(n) for n in traced)
            return tuple(zip(keys, leaves, strict=True)), sizes

        def unflatten(sizes: tuple[Any, ...], leaves: Any) -> Any:
            tree = object.__new__(frozen)
            for name, value in (*zip(traced, leaves, strict=True), *zip(constant, sizes, strict=True)):
                object.__setattr__(tree, name, value)
            return tree

        jax.tree_util.register_pytree_with_keys(frozen, flatten_with_keys, unflatten, flatten)
        return frozen

    return register


def check_pytree(name: str, value: Any) -> None:
    """Require a pytree of real numbers; a measured response, which is complex, has looked at itself."""
    if jax.tree_util.all_leaves([value]):
        raise ValueError(
            f"{name} = {_checks.brief(value)} is unknown to JAX; make its class a frozen dataclass, and register it "
            "by @jax.tree_util.register_dataclass"
        )
    for path, leaf in jax.tree_util.tree_flatten_with_path(value, is_leaf=is_measured)[0]:
        if is_measured(leaf):
            continue
        if not isinstance(leaf, int | float | complex | np.ndarray | np.generic | jax.Array):
            raise ValueError(
                f"{name}{jax.tree_util.keystr(path)} = {_checks.brief(leaf)} is no number; "
                "name the field in meta_fields of jax.tree_util.register_dataclass"
            )
        if np.iscomplexobj(leaf):
            # Sums with real numbers would drop the imaginary parts without a word.
            raise ValueError(
                f"{name}{jax.tree_util.keystr(path)} is complex; give real numbers, such as real and imaginary part"
            )


def is_measured(node: Any) -> bool:
    """Whether it is a measured response, in whose place there are no equations."""
    return hasattr(node, "response")
