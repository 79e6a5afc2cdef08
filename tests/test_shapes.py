"""The shapes that signatures state: true of all that the verbs call, and stated by every module."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import lobex

ROOT = Path(lobex.__file__).parent


@pytest.mark.slow
def test_shapes_are_true_of_what_every_verb_calls():
    script = Path(__file__).with_name("checked_shapes.py")
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=500)
    assert run.returncode == 0, run.stderr[-3000:]
    assert run.stdout.split() == ["multipliers", "charts", "limits", "measured", "marches", "refusals"]


def shapeless(tree):
    """Names of arrays that are another word for anything."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Name) and node.value.id == "Any":
            yield from (target.id for target in node.targets if "Array" in getattr(target, "id", ""))


def test_no_module_takes_anything_for_an_array():
    assert {file.name for file in ROOT.rglob("*.py") if any(shapeless(ast.parse(file.read_text())))} == set()
    assert [*shapeless(ast.parse("from typing import Any\n\nArray = Any"))] == ["Array"]
