"""``lobex store``: what a store holds, whether it is sound, and all of it as one file."""

from pathlib import Path
from typing import TYPE_CHECKING

from lobex import _checks
from lobex.shell.store_arguments import Export, Status, Store

if TYPE_CHECKING:
    from lobex.studies import store as stores


def run_store(command: Store) -> None:
    """Do what is asked; a damaged chunk ends with exit code 1."""
    from lobex.studies import store as stores

    action = command.action
    store = stores.Store.open(action.folder)
    if isinstance(action, Status):
        print(_status(store))
    elif isinstance(action, Export):
        _export(action)
    elif not _verify(store):
        raise SystemExit(1)


def _status(store: "stores.Store") -> str:
    manifest, plan = store.manifest, store.plan
    done = store.present()
    size = sum((store.folder / name).stat().st_size for name in done.values())
    axes = {**plan.axes, "speed": manifest["speed"]}
    made_by = ", ".join(f"{name} {number}" for name, number in manifest["versions"].items())
    lines = [
        f"Store of {manifest['verb']}: {' × '.join(f'{len(values)} {name}' for name, values in axes.items())}",
        f"  chunks           {len(done)} of {plan.chunks}, {100 * len(done) / plan.chunks:.0f} %",
        f"  size             {size / 1e6:.1f} MB",
        f"  made by          {made_by}",
        "  state            "
        + ("all chunks are there" if len(done) == plan.chunks else "run the same command again to go on"),
        f"  checksums        not compared; lobex store verify {store.folder} does that",
    ]
    return "\n".join(lines)


def _verify(store: "stores.Store") -> bool:
    from lobex.studies.store import Damage

    done = store.present()
    damaged = []
    for number in sorted(done):
        try:
            store.read(number, done)
        except Damage as damage:
            damaged.append(number)
            print(damage)
    missing = store.plan.chunks - len(done)
    print(f"{len(done) - len(damaged)} chunks are sound, {len(damaged)} damaged, {missing} missing")
    return not damaged


def _export(action: Export) -> None:
    from lobex.results.saving import ENDINGS
    from lobex.studies.study import Study

    if action.to is not None:
        _checks.choice("to", action.to, tuple(ending.removeprefix(".") for ending in ENDINGS))
    to, folder = action.to or "nc", Path(action.folder).resolve()
    target = _checks.writable("out", action.out if action.out is not None else f"{folder}.{to}")
    if action.to is not None and target.suffix.lower() != f".{to}":
        raise ValueError(f"out = {action.out!r} does not end in .{to}; drop one of --to and --out")
    study = Study.open(action.folder)
    (study if study.over else study.at()).save(target)
    print(f"{study!r}\n  written          {target}")
