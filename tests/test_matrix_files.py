"""Matrices from files: Matrix Market, and Nastran's DMIG in all its fields."""

import gzip

import numpy as np
import pytest
import scipy.io
import scipy.sparse

import lobex
from refusals import refused

MASS = np.array([[2.0, 0.0, 0.5], [0.0, 1.5, 0.0], [0.5, 0.0, 1.0]])
STIFFNESS = np.array([[3e6, -1e6, 0.0], [-1e6, 3e6, -1e6], [0.0, -1e6, 2e6]])
SKEW = np.array([[0.0, -2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
# Grid point 7 with two displacements, and 12 with a rotation.
DOF = [[7, 1], [7, 3], [12, 5]]


def small(name, matrix, form):
    """In small fields, two terms a line in continuations."""
    yield f"{'DMIG':8}{name:8}{0:8}{form:8}{2:8}{0:8}"
    for j, (point, component) in enumerate(DOF):
        terms = [(i, matrix[i, j]) for i in range(3) if matrix[i, j] and (form == 1 or i >= j)]
        fields = [f"{DOF[i][0]:8}{DOF[i][1]:8}{value:8.6g}{'':8}" for i, value in terms]
        if fields:
            yield f"{'DMIG':8}{name:8}{point:8}{component:8}{'':8}{fields[0]}"
            for start in range(1, len(fields), 2):
                yield f"{'+':8}{''.join(fields[start : start + 2])}"


def large(name, matrix, form):
    """As punched, one term a line, with the exponents of double precision."""
    yield f"{'DMIG':8}{name:8}{0:8}{form:8}{2:8}{0:8}{'':8}{3:8}"
    for j, (point, component) in enumerate(DOF):
        yield f"{'DMIG*':8}{name:16}{point:16}{component:16}{'':16}"
        for i in range(3):
            if matrix[i, j] and (form == 1 or i >= j):
                value = f"{matrix[i, j]:.9E}".replace("E", "D")
                yield f"{'*':8}{DOF[i][0]:16}{DOF[i][1]:16}{value:>16}"


def free(name, matrix, form):
    """With commas, and exponents without a letter."""
    yield f"dmig,{name},0,{form},1,0"
    for j, (point, component) in enumerate(DOF):
        terms = [(i, matrix[i, j]) for i in range(3) if matrix[i, j] and (form == 1 or i >= j)]
        for i, value in terms:
            short = f"{value:.6e}".replace("e+0", "+").replace("e-0", "-")
            yield f"DMIG,{name},{point},{component},,{DOF[i][0]},{DOF[i][1]},{short}"


@pytest.mark.parametrize("fields", [small, large, free])
def test_matrices_at_grid_points_come_back(fields, tmp_path):
    path = tmp_path / "blade.pch"
    parts = [("MAAX", MASS, 6), ("KAAX", STIFFNESS, 6), ("BAAX", SKEW, 1)]
    lines = ["$ a reduced model", "GRID           7               0.      1.      0."]
    lines += [line for part in parts for line in fields(*part)]
    path.write_text("\n".join([*lines, "ENDDATA", ""]))
    found = lobex.read_dmig(path)
    assert found.dof.tolist() == DOF
    assert list(found.matrices) == ["MAAX", "KAAX", "BAAX"]
    for name, matrix, _ in parts:
        assert found.matrices[name].toarray() == pytest.approx(matrix, rel=1e-6)
    contact = (found.dof == [12, 5]).all(axis=1)
    modes = lobex.Modes.from_matrices(
        found.matrices["MAAX"], found.matrices["KAAX"], contact.astype(float), 0.01, gyroscopic=found.matrices["BAAX"]
    )
    expected = np.sqrt(np.linalg.eigvals(np.linalg.solve(MASS, STIFFNESS)).real)
    assert modes.angular_frequency == pytest.approx(np.sort(expected), rel=1e-5)


def test_a_matrix_market_file_comes_back(tmp_path):
    path = tmp_path / "stiffness.mtx"
    scipy.io.mmwrite(path, scipy.sparse.coo_array(STIFFNESS), symmetry="symmetric")
    assert lobex.read_matrix_market(path).toarray() == pytest.approx(STIFFNESS)
    scipy.io.mmwrite(path, MASS)
    assert lobex.read_matrix_market(path).toarray() == pytest.approx(MASS)
    # As Fortran writes them.
    path.write_text("%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 1.5D+03\n2 2 2.5d-01\n")
    assert lobex.read_matrix_market(path).toarray().tolist() == [[1500.0, 0.0], [0.0, 0.25]]


HEAD = "DMIG,K,0,6,1,0\n"
COORDINATES = "%%MatrixMarket matrix coordinate real general\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("GRID,1,,0.,0.,0.\n", "has no DMIG entries"),
        ("", "has no DMIG entries"),
        ("DMIG,K,7,1,,7,1,3.0\n", "line 1: matrix K has an entry before its head"),
        ("DMIG,K,0,2,1,0\n", "line 1: matrix K has the form 2; give square (1) or symmetric (6) ones"),
        ("DMIG,K,0,6,3,0\n", "line 1: matrix K has the type 3, which is complex"),
        ("DMIG,K,0,six,1,0\n", "line 1: form = 'six' is no whole number"),
        (HEAD + "DMIG,K,7,1,,7,1,stiff\n", "line 2: value = 'stiff' is no number"),
        (HEAD + "DMIG,K,7,x,,7,1,1.0\n", "line 2: component = 'x' is no whole number"),
        (HEAD + "DMIG,K,7,1,,7,1,nan\n", "line 2: value = 'nan' is no number"),
        (HEAD + "DMIG,K,7,1,,7,1,1+999\n", "line 2: value = '1+999' is no number"),
        (HEAD + "DMIG,K,7,7,,7,1,1.0\n", "line 2: component = 7 is none; give 0 to 6"),
        (HEAD + "DMIG,K,-7,1,,7,1,1.0\n", "line 2: grid point = -7 is none; give 1 to 99999999"),
        (HEAD + f"DMIG,K,7,1,,{10**30},1,1.0\n", f"line 2: grid point = {10**30} is none"),
        (HEAD + "DMIG,K,7,1,,7,1,1.0,,7,2,2.0\n", "line 2: '2' lies beyond the 10 fields of a line"),
        (HEAD + HEAD, "line 2: matrix K has a second head"),
        (HEAD, "has no DMIG entries"),
        (HEAD + "DMIG,K,7,1,,7,2,1.0\nDMIG,K,7,2,,7,1,1.0\n", "line 3: matrix K has two entries of row (7, 1)"),
    ],
)
def test_entries_are_refused_in_one_line(text, words, tmp_path):
    path = tmp_path / "bad.pch"
    path.write_text(text)
    with refused(words):
        lobex.read_dmig(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is no Matrix Market"),
        ("mass and stiffness\n", "is no Matrix Market"),
        ("%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1\n", "is no Matrix Market"),
        (COORDINATES + "2 2 99999999999\n1 1 1.0\n", "is no Matrix Market (Unable to allocate"),
        (COORDINATES + "1 1 1\n1 1 nan\n", "line 3: 'nan' is no number"),
        (COORDINATES + "1 1 1\n1 1 1,5\n", "line 3: ',5' is no number, or part of none"),
        (COORDINATES + "1 1 2\n1 1 1.0\n1 1 2.0\n", "has two entries of a row and column"),
        (
            "%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n",
            "has a pattern without numbers; give a real",
        ),
        ("%%MatrixMarket  matrix coordinate Pattern symmetric\n% 1\n1 1 1\n1 1\n", "has a pattern without numbers"),
        ("%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 1.0 2.0\n", "has a complex matrix"),
        (
            "%%MatrixMarket matrix array real general\n1 2\n1.0\n2.0\n",
            "has a matrix of shape (1, 2); give a square one",
        ),
    ],
)
def test_files_of_a_matrix_are_refused_in_one_line(text, words, tmp_path):
    path = tmp_path / "bad.mtx"
    path.write_text(text)
    with refused(words):
        lobex.read_matrix_market(path)


@pytest.mark.parametrize("read", ["read_dmig", "read_matrix_market"])
def test_what_is_no_file_is_refused(read, tmp_path):
    for path in (tmp_path / "none.mtx", tmp_path, 3):
        with pytest.raises(ValueError, match=r"^path = .*(cannot be read|is no path|is no Matrix Market)"):
            getattr(lobex, read)(path)
    binary = tmp_path / "results.op2"
    binary.write_bytes(bytes(range(128, 256)))
    with pytest.raises(ValueError, match=r"is no (text|Matrix Market)"):
        getattr(lobex, read)(binary)


def test_a_packed_matrix_that_is_damaged_is_refused(tmp_path):
    path = tmp_path / "mass.mtx.gz"
    packed = gzip.compress(b"%%MatrixMarket matrix array real general\n1 1\n1.0\n")
    path.write_bytes(packed)
    assert lobex.read_matrix_market(path).toarray() == [[1.0]]
    for damaged in (packed[:-9], packed[:10] + bytes(range(255, 0, -1)), b"mass"):
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"^path = .* cannot be read"):
            lobex.read_matrix_market(path)
