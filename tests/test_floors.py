"""Every import between folders goes down, those for type checkers and those within functions included."""

import ast
from collections import Counter
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import lobex
from lobex._by_name import by_name

ROOT = Path(lobex.__file__).parent
TOP = Path(__file__).parents[1]
FILES = sorted(ROOT.rglob("*.py"))


def place(module):
    """The folder of a module of lobex, or a file beside the folders."""
    first = module.split(".")[1]
    return first if (ROOT / first).is_dir() else f"{first}.py"


def imported(file):
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            yield from (f"lobex.{name.name}" for name in node.names) if module == "lobex" else (module,)


def floors(files):
    """What each folder imports from others; the package itself, which names all, is none of them."""
    below: dict[str, set[str]] = {}
    for file in files:
        inside = file.relative_to(ROOT).parts
        if inside == ("__init__.py",):
            continue
        modules = [module for module in imported(file) if module.startswith("lobex.")]
        below.setdefault(inside[0], set()).update({place(module) for module in modules} - {inside[0]})
    return below


def test_no_two_folders_know_each_other():
    order = list(TopologicalSorter(floors(FILES)).static_order())
    assert {"structures", "systems", "processes", "operators", "floquet", "grids", "limits", "marches"} <= set(order)
    # The flow of the physics, as the folders name it.
    assert [name for name in order if name in ("systems", "processes", "grids", "limits", "studies", "shell")] == [
        *("systems", "processes", "grids", "limits", "studies", "shell")
    ]


def test_a_circle_would_be_found(tmp_path, monkeypatch):
    monkeypatch.setattr("test_floors.ROOT", tmp_path)
    for name, other in (("one", "two"), ("two", "one")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "file.py").write_text(f"def f():\n    from lobex.{other}.file import g\n")
    with pytest.raises(CycleError):
        list(TopologicalSorter(floors(tmp_path.rglob("*.py"))).static_order())


def names_upwards():
    for file in FILES:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "by_name":
                yield file, ast.literal_eval(node.args[0])


def test_ways_up_lead_somewhere_and_are_taken_where_an_import_would_close_a_circle():
    ways = list(names_upwards())
    assert len(ways) > 10
    below = floors(FILES)
    for file, name in ways:
        assert callable(by_name(name))
        mine, there = file.relative_to(ROOT).parts[0], place(f"lobex.{name}")
        with pytest.raises(CycleError):
            list(TopologicalSorter({**below, mine: {*below[mine], there}}).static_order())


def test_a_file_name_occurs_once():
    others = [file for folder in ("benchmarks", "docs", "notebooks", "tests") for file in (TOP / folder).glob("*.py")]
    count = Counter(file.name for file in (*FILES, *others) if file.name != "__init__.py")
    assert {name for name, times in count.items() if times > 1} == set()


def test_no_name_of_lobex_is_that_of_a_folder_or_file_which_would_take_its_place_once_imported():
    inside = {path.stem for path in ROOT.iterdir() if path.is_dir() or path.suffix == ".py"}
    assert set(lobex.__all__) & inside == set()
