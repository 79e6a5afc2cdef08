"""Compute all figures of the gallery and all reference cases, and write validation.json, the pictures and the pages.

    python docs/make_validation.py

takes some minutes. The documentation is built from what it wrote, and tests/test_docs.py computes a part anew.
"""

import os

# Before NumPy: docs/sharp_bits.md says why.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import io
import json
import platform
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import errata
import numpy as np
import pages
import reference_rows
from PIL import Image
from tqdm import tqdm

import lobex
from lobex.gallery.registry import figures
from lobex.gallery.reproduction import Reproduction
from lobex.shell.environment import prepare_jax

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FOLDER = Path(__file__).parent
_DIGITS = 12
_DOTS_PER_INCH = 90
_COLOURS = 128


def make() -> None:
    """Write all of it."""
    prepare_jax()
    import jax
    import matplotlib

    matplotlib.use("Agg")
    (FOLDER / "gallery").mkdir(exist_ok=True)
    content: dict[str, Any] = {
        "made_with": {
            "lobex": lobex.__version__,
            "python": platform.python_version(),
            "jax": jax.__version__,
            "numpy": np.__version__,
        },
        "figures": {figure.name: _figure(figure) for figure in tqdm(figures(), unit="figure")},
        "multipliers": reference_rows.multipliers(),
        "limits": reference_rows.limits(),
        "errata": errata.effects(),
    }
    text = json.dumps(_rounded(content), indent=1, ensure_ascii=False)
    (FOLDER / "validation.json").write_text(text + "\n")
    pages.write(FOLDER)


def _figure(figure: Reproduction) -> dict[str, Any]:
    """Draw one figure; its claims and findings."""
    import matplotlib.pyplot as plt

    begun = time.perf_counter()
    results = figure.compute(1.0)
    drawn = figure.draw(results)
    (FOLDER / "gallery" / f"{figure.name}.png").write_bytes(_small(drawn))
    plt.close(drawn)
    findings = [asdict(finding) for finding in figure.findings(results)]
    tqdm.write(f"{figure.name}: {time.perf_counter() - begun:.1f} s", file=sys.stderr)
    return {"title": figure.title, "claim": figure.claim, "findings": findings}


def _small(drawn: "Figure") -> bytes:
    """The figure as a PNG of few colours, without the version of its maker in it."""
    whole, small = io.BytesIO(), io.BytesIO()
    drawn.savefig(whole, dpi=_DOTS_PER_INCH)
    # A palette that keeps rare colours: thin lines over a map have few pixels.
    few = Image.open(whole).convert("RGB").quantize(_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(small, "PNG", optimize=True)
    return small.getvalue()


def _rounded(value: Any) -> Any:
    """Numbers to as many digits as other machines repeat."""
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}")
    return bool(value) if isinstance(value, np.bool_) else value


if __name__ == "__main__":
    make()
