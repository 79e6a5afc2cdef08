"""The manifest of a store: which study it holds, and how that is cut into chunks."""

import hashlib
import json
from importlib.metadata import version
from typing import Any

import numpy as np

from lobex import _checks
from lobex.studies.plan import Plan
from lobex.studies.variation import check_name

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
    _check(body)
    return manifest


def plan_in(manifest: dict[str, Any]) -> Plan:
    """The chunks that a manifest lays down."""
    axes = {name: np.asarray(values, dtype=np.float64) for name, values in manifest["over"].items()}
    return Plan(axes, len(manifest["speed"]), manifest[_LAYOUT])


def identity(manifest: dict[str, Any]) -> str:
    """What every chunk of the study carries: the manifest's checksum."""
    return manifest[_SEAL]


def first_difference(stored: dict[str, Any], wanted: dict[str, Any]) -> str | None:
    """What tells another study apart, in words, or None for the same one."""
    skip = (_LAYOUT, _SEAL)
    return _difference("", *({k: v for k, v in m.items() if k not in skip} for m in (stored, json_copy(wanted))))


def json_copy(value: Any) -> Any:
    """As a file would give it back: tuples are lists."""
    return json.loads(json.dumps(value))


def _seal(body: dict[str, Any]) -> str:
    text = json.dumps(body, ensure_ascii=False, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _difference(path: str, stored: Any, wanted: Any) -> str | None:
    if isinstance(stored, dict) and isinstance(wanted, dict):
        for name in [*wanted, *(n for n in stored if n not in wanted)]:
            where = f"{path}.{name}" if path else str(name)
            if name not in stored or name not in wanted:
                return f"{where} is {'missing' if name not in stored else 'given'} in the store"
            found = _difference(where, stored[name], wanted[name])
            if found:
                return found
        return None
    if isinstance(stored, list) and isinstance(wanted, list):
        if len(stored) != len(wanted):
            return f"{path} has {len(stored)} values in the store and {len(wanted)} here"
        pairs = enumerate(zip(stored, wanted, strict=True))
        return next(filter(None, (_difference(f"{path}[{i}]", *pair) for i, pair in pairs)), None)
    # NaN is the same as NaN here: both are written alike.
    same = type(stored) is type(wanted) and json.dumps(stored) == json.dumps(wanted)
    return None if same else f"{path} = {_checks.brief(stored)} in the store and {_checks.brief(wanted)} here"


def _check(body: dict[str, Any]) -> None:
    """Require what a sealed manifest must hold: anybody can seal."""
    verb, lanes, over, layout = (body.get(name) for name in ("verb", "speed", "over", _LAYOUT))
    if not isinstance(verb, str) or not isinstance(body.get("settings"), dict):
        raise ValueError("does not name its verb")
    if not isinstance(over, dict) or not isinstance(lanes, list) or not lanes:
        raise ValueError("does not name its axes")
    for name, values in over.items():
        check_name(name, verb)
        _checks.grid(f"over[{name!r}]", values)
    numbers = _checks.as_numbers("speed", lanes)
    if numbers is None or numbers.ndim not in (1, 2):
        raise ValueError("has speeds of a shape that no study has")
    _checks.integer(_LAYOUT, layout, 1)
