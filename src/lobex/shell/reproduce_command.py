"""``lobex reproduce``: the thesis' figures as pictures, numbers, and findings beside the thesis' claims."""

import os
import textwrap
import time
from pathlib import Path

from lobex import _checks
from lobex.gallery.registry import figures
from lobex.gallery.reproduction import Finding, Reproduction
from lobex.shell.reproduce_arguments import Reproduce

_WIDTH = 110


def run_reproduce(command: Reproduce) -> None:
    """Check names and files, then compute, save, draw and report one figure after the other."""
    chosen = figures(command.names)
    if command.show:
        print("\n".join(f"{figure.name:<9} {figure.title}" for figure in chosen))
        return
    endings = (".nc", ".png", *((".pdf",) if command.pdf else ()))
    folder = _folder(command.out)
    files = {
        figure.name: [_checks.writable("out", folder / f"{figure.name}{end}") for end in endings] for figure in chosen
    }

    # JAX and Matplotlib are slow to import: only now.
    from lobex.shell.environment import prepare_jax

    prepare_jax()
    import matplotlib

    matplotlib.use("Agg")
    from tqdm import tqdm

    written = 0
    begun = time.perf_counter()
    try:
        with tqdm(chosen, unit="figure", disable=command.quiet, leave=False) as bar:
            for figure in bar:
                bar.set_description(figure.name)
                findings = _make(figure, files[figure.name])
                written += 1
                if not command.quiet:
                    with tqdm.external_write_mode():
                        print(_report(figure, findings), flush=True)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"{written} of {len(chosen)} figures are in {folder}") from None
    if not command.quiet:
        plural = "figure" if written == 1 else "figures"
        print(f"{written} {plural} in {folder}, {time.perf_counter() - begun:.1f} s")


def _folder(out: str) -> Path:
    """The folder to write into, made if only itself is missing."""
    folder = _checks.place("out", out, "a folder")
    if not out or (folder.exists() and not folder.is_dir()):
        raise ValueError(f"out = {out!r} is not a folder; give the path of one, such as figures")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        why = error.strerror or str(error)
        raise ValueError(
            f"out = {out!r} cannot be made ({why}); create the folders above it, or choose another"
        ) from None
    if not os.access(folder, os.W_OK):
        raise ValueError(f"out = {out!r} is write-protected; choose another folder")
    return folder


def _make(figure: Reproduction, files: list[Path]) -> list[Finding]:
    """Compute a figure and write its files."""
    import matplotlib.pyplot as plt

    from lobex.gallery.numbers import save_numbers

    results = figure.compute(1.0)
    save_numbers(figure, results, files[0])
    drawn = figure.draw(results)
    for path in files[1:]:
        drawn.savefig(path, dpi=150)
    plt.close(drawn)
    return figure.findings(results)


def _report(figure: Reproduction, findings: list[Finding]) -> str:
    """Title and findings of a figure, each in a few lines."""
    lines = [f"{figure.name}  {figure.title}"]
    for finding in findings:
        lines += _block("agrees" if finding.agrees else "differs", finding.claim)
        lines += _block("", f"thesis: {finding.thesis}") + _block("", f"here: {finding.ours}")
        lines += _block("", finding.why) if finding.why else []
    return "\n".join(lines)


def _block(head: str, text: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH, initial_indent=f"  {head:<9}", subsequent_indent=" " * 11)
