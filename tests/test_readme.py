"""The README's code runs, and says what it says."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from commands import Shell

README = (Path(__file__).parents[1] / "README.md").read_text()
PYTHON = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
SHELL = [line for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL) for line in block.splitlines()]


def test_python_blocks_run_in_order_and_print_what_they_say(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in PYTHON:
        exec(compile(block, "README.md", "exec"), names)
    printed = capsys.readouterr().out
    claim = re.search(r"# (\[0\..*\])", PYTHON[0])
    assert claim is not None
    assert claim.group(1) in printed
    assert np.isfinite(names["rough"]).sum() > 20
    assert names["limit"].gain == pytest.approx([920209.5963, 1134071.001, 328021.9409], rel=1e-8)
    assert {p.name for p in tmp_path.iterdir()} == {
        "rub.png",
        "rub.nc",
        "limit.png",
        "band.png",
        "wear.png",
        "spectrum.png",
        "study",
    }
    assert names["march"].growth == pytest.approx([0.69889149, 1.20569362], rel=1e-4)
    worst = names["wear"].speed[np.argmax(names["wear"].volume)]
    assert 1 < worst / names["critical"][1] < 1.15


@pytest.mark.parametrize("line", [line for line in SHELL if line.startswith("lobex ")])
def test_shell_lines_run_on_a_coarser_grid(line, shell, tmp_path):
    if line.startswith("lobex store"):
        (before,) = (other for other in SHELL if f"--store {line.split()[-1]} " in other)
        _run(before, shell)
    _run(line, shell)
    assert {p.suffix for p in tmp_path.rglob("*.*")} >= {".nc", ".png"}


def _run(line: str, shell: Shell) -> None:
    # Every figure has its turn in test_gallery.
    words = [re.sub(r":\d+$", ":5", word) for word in shlex.split(line)[1:] if not word.startswith("fig-")]
    assert shell(*words, *_small_grid(words)).code == 0, shell.err


def _small_grid(words: list[str]) -> list[str]:
    if words[0] == "reproduce":
        return ["fig-1.2", "fig-3.1"]
    if "--store" in words:
        return ["--speed", "50:400:5", "--gain", "4.5e4:4.5e6:5"]
    return ["--speed", "0.1:0.3:3", "--gain", "-1:1:3"] if "mathieu" in words else []


def test_make_lines_name_targets_of_the_makefile():
    makefile = (Path(__file__).parents[1] / "Makefile").read_text()
    targets = [line.split()[1] for line in SHELL if line.startswith("make ")]
    assert targets == ["demo", "test", "test-slow", "test-all", "figures", "docs"]
    for target in targets:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE)
