"""Writes the matrices of an example blade, that of howto/blade.toml in three elements: howto/blade_*.mtx."""

import tomllib
from pathlib import Path

import numpy as np
import scipy.io
from scipy import sparse

import lobex
from lobex.processes.blade_file import LENGTHS
from lobex.processes.tables_of_file import in_metres

HOWTO = Path(__file__).parent / "howto"
# Radial, tangential and axial.
DIRECTIONS = np.eye(3)


def blade() -> tuple[lobex.Beam, float]:
    """The beam of the file, and the place along its chord that rubs, m."""
    said = tomllib.loads((HOWTO / "blade.toml").read_text())
    beam = in_metres(said["beam"], LENGTHS) | {"elements": 3}
    return lobex.Beam.rectangular(**beam), in_metres(said["contact"], LENGTHS)["chord"]


def parts() -> dict[str, np.ndarray]:
    """Its matrices, (24, 24) each, and what its tip moves by in each direction, (24, 3)."""
    beam, chord = blade()
    tip = [beam.contact(normal=along, chord=chord)[0] for along in DIRECTIONS]
    return {**beam.matrices()._asdict(), "tip": np.concatenate(tip, axis=1)}


if __name__ == "__main__":
    kinds = {"gyroscopic": "skew-symmetric", "tip": "general"}
    for name, part in parts().items():
        # Rounding beside entries that are zero.
        part = np.where(np.abs(part) > 1e-14 * np.abs(part).max(), part, 0.0)
        shown = part if name == "tip" else sparse.coo_array(part)
        scipy.io.mmwrite(HOWTO / f"blade_{name}.mtx", shown, precision=17, symmetry=kinds.get(name, "symmetric"))
