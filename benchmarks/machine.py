"""What the tables say of the machine that made them."""

import os
import platform
from pathlib import Path

import jax
import numpy as np


def machine() -> str:
    """Processor, cores and versions, in words."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return (
        f"{names[0] if names else platform.machine()}, {os.cpu_count()} cores, {platform.system()}; "
        f"Python {platform.python_version()}, jax {jax.__version__}, NumPy {np.__version__}"
    )
