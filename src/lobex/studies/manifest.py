"""The manifest of a store: which study it holds, and how that is cut into chunks."""

import hashlib
import json
from collections.abc import Iterator
from importlib.metadata import version
from typing import Any

import numpy as np

from lobex import _checks
from lobex.studies.plan import Plan
from lobex.studies.variation import axes_of

FORM = "lobex store 1"

# What the chunks are cut into does not tell studies apart: memory decides it where the store is begun.
_LAYOUT = "lanes_per_chunk"
_SEAL = "sha256"


def manifest_of(plan: Plan, verb: str, model: Any, settings: dict[str, Any], speed: np.ndarray) -> dict[str, Any]:
    """What ties a store to its study, sealed with a checksum of its own."""
    body = {
        "format": FORM,
        "versions": {name: version(name) for name in ("lobex", "jax", "numpy")},
        "verb": verb,
        "settings": settings,
        "over": {name: values.tolist() for name, values in plan.axes.items()},
        "speed": speed.tolist(),
        "model": model,
        _LAYOUT: plan.lanes_per_chunk,
    }
    try:
        return {**body, _SEAL: _seal(body)}
    except TypeError:
        raise ValueError(
            "the model or the method cannot be told in plain numbers, which a store needs; make it a frozen dataclass"
        ) from None


def encode(manifest: dict[str, Any]) -> bytes:
    """As a text file."""
    return (json.dumps(manifest, ensure_ascii=False, indent=1) + "\n").encode()


def decode(content: bytes) -> dict[str, Any]:
    """The manifest of a text file. ValueError where that is damaged, or makes no sense."""
    try:
        manifest = json.loads(content)
    except (ValueError, RecursionError):
        raise ValueError("is no JSON text") from None
    if not isinstance(manifest, dict) or manifest.get("format") != FORM:
        raise ValueError(f"is not of the format {FORM!r}")
    body = {name: value for name, value in manifest.items() if name != _SEAL}
    if manifest.get(_SEAL) != _seal(body):
        raise ValueError("does not agree with its own checksum")
    # Anybody can seal.
    plan_in(manifest)
    return manifest


def plan_in(manifest: dict[str, Any]) -> Plan:
    """The chunks that a manifest lays down. ValueError where it makes no sense."""
    verb, lanes = (manifest.get(name) for name in ("verb", "speed"))
    if not isinstance(verb, str) or not isinstance(manifest.get("settings"), dict):
        raise ValueError("does not name its verb")
    numbers = _checks.as_numbers("speed", lanes)
    if not isinstance(lanes, list) or not lanes or numbers is None or numbers.ndim not in (1, 2):
        raise ValueError("has speeds of a shape that no study has")
    axes = axes_of(manifest.get("over") or None, verb)
    return Plan(axes, len(lanes), _checks.integer(_LAYOUT, manifest.get(_LAYOUT), 1))


def identity(manifest: dict[str, Any]) -> str:
    """What every chunk of the study carries: the manifest's checksum."""
    return manifest[_SEAL]


def first_difference(stored: dict[str, Any], wanted: dict[str, Any]) -> str | None:
    """What tells another study apart, in words, or None for the same one."""
    there, here = (dict(_leaves("", {**manifest, _LAYOUT: 0, _SEAL: ""})) for manifest in (stored, wanted))
    for path in {**here, **there}:
        if path not in there or path not in here:
            return f"{path} is {'given' if path in there else 'missing'} in the store"
        # As text, in which NaN is the same as NaN, and 1 another than 1.0.
        if json.dumps(there[path]) != json.dumps(here[path]):
            return f"{path} = {_checks.brief(there[path])} in the store and {_checks.brief(here[path])} here"
    return None


def _seal(body: dict[str, Any]) -> str:
    text = json.dumps(body, ensure_ascii=False, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Every number and text by its path, and of every list how many values it has."""
    if isinstance(value, dict):
        for name, part in value.items():
            yield from _leaves(f"{path}.{name}" if path else name, part)
    elif isinstance(value, list | tuple):
        yield f"number of values in {path}", len(value)
        for number, part in enumerate(value):
            yield from _leaves(f"{path}[{number}]", part)
    else:
        yield path, value
