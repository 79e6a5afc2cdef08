"""Modal tables and lists of cuts from files."""

import zipfile

import numpy as np
import openpyxl
import pytest

import lobex
from refusals import refused

WANTED = lobex.Modes.from_table(
    frequency=[563.6, 1240.0, 516.2],
    damping_ratio=[0.056, 0.03, 0.025],
    stiffness=[1.88e7, 6.2e7, 1.26e7],
    direction=["x", "x", "y"],
)
MASS = np.array([1.88e7, 6.2e7, 1.26e7]) / (2 * np.pi * np.array([563.6, 1240.0, 516.2])) ** 2
HEAD = ["mode", "Frequency [Hz]", "Damping [%]", "Stiffness [N/um]", "Direction"]
ROWS = [[1, 563.6, 5.6, 18.8, "x"], [2, 1240.0, 3.0, 62.0, "X"], [3, 516.2, 2.5, 12.6, "y"]]
FREQUENCIES, RATIOS, STIFFNESSES = [563.6, 1240.0, 516.2], [0.056, 0.03, 0.025], [1.88e7, 6.2e7, 1.26e7]


def rows(head, *columns, separator=","):
    lines = [separator.join(map(str, row)) for row in zip(*columns, strict=True)]
    return "\n".join([head, *lines, ""])


PER_CENT, SHARES = [5.6, 3, 2.5], RATIOS
TEXTS = {
    "commas": rows(
        "mode,Frequency [Hz],Damping [%],Stiffness [N/um],Direction",
        "123",
        FREQUENCIES,
        PER_CENT,
        [18.8, 62, 12.6],
        "xxy",
    ),
    "decimal commas": rows(
        "Frequenz [kHz];ξ [1];k [N/mm];Achse",
        ["0,5636", "1,24", "0,5162"],
        ["0,056", "0,03", "0,025"],
        [18800, 62000, 12600],
        "xxy",
        separator=";",
    ),
    "tabs": "# of a tap test\n"
    + rows("f (Hz)\tzeta (%)\tk (kN/mm)\taxis", FREQUENCIES, PER_CENT, [18.8, 62, 12.6], "xxy", separator="\t"),
    "units in a row of their own": rows(
        "Frequency,Damping,Stiffness,Direction\n[Hz],[%],[N/um],", FREQUENCIES, PER_CENT, [18.8, 62, 12.6], "xxy"
    ),
    "masses": rows("f [Hz],damping [1],mass [kg],axis", FREQUENCIES, SHARES, MASS.tolist(), "xxy"),
    "vectors": rows(
        "f [Hz],damping [%],k [N/m],shape x,shape y", FREQUENCIES, PER_CENT, STIFFNESSES, [2, 1, 0], [0, 0, 1]
    ),
    "shapes": rows(
        "f [Hz],damping [%],shape x [1/√kg],shape y [1/√kg]",
        FREQUENCIES,
        PER_CENT,
        *np.asarray(WANTED.shape).T.tolist(),
    ),
}


@pytest.fixture
def file(tmp_path):
    def write(text, name="table.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def assert_same(modes):
    np.testing.assert_allclose(modes.angular_frequency, WANTED.angular_frequency, rtol=1e-14)
    np.testing.assert_allclose(modes.damping_ratio, WANTED.damping_ratio, rtol=1e-14)
    np.testing.assert_allclose(modes.shape, WANTED.shape, rtol=1e-13)


@pytest.mark.parametrize("kind", TEXTS)
def test_modal_tables_of_every_kind_hold_the_same_modes(kind, file):
    assert_same(lobex.read_modes(file(TEXTS[kind])))


def sheet(path, rows):
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    book.save(path)
    return path


def test_modal_tables_of_a_sheet(tmp_path):
    path = sheet(tmp_path / "table.xlsx", [["Tap test of 3 June"], [], [None, *HEAD], *([None, *row] for row in ROWS)])
    with refused("row 1 below the head"):
        lobex.read_modes(sheet(tmp_path / "cut.xlsx", [HEAD, [*ROWS[0][:2], "?", *ROWS[0][3:]]]))
    assert_same(lobex.read_modes(path))


@pytest.mark.parametrize("read", [lobex.read_modes, lobex.read_cuts])
def test_a_sheet_that_unpacks_to_more_than_a_table_is_not_opened(read, tmp_path):
    path = sheet(tmp_path / "bomb.xlsx", [HEAD, *ROWS])
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive, archive.open("xl/more.xml", "w") as part:
        for _ in range(80):
            part.write(bytes(2**20))
    assert path.stat().st_size < 2**18
    with refused(f"path = {str(path)!r} cannot be read as .xlsx (it unpacks to 80 MiB; give a file of up to 64 MiB)"):
        read(path)


def test_one_direction_without_a_column_for_it(file):
    modes = lobex.read_modes(file("f [Hz],damping [%],k [N/m]\n450,3,1.5e7\n"))
    single = lobex.Modes.single(frequency=450.0, damping_ratio=0.03, stiffness=1.5e7)
    np.testing.assert_allclose(modes.shape, single.shape, rtol=1e-15)


def test_damping_in_no_unit_is_refused_or_told(file):
    path = file("f [Hz],damping ratio,k [N/m]\n450,3,1.5e7\n")
    with refused("whether 'damping ratio' is in per cent or a share of 1; write 'damping ratio [%]' or"):
        lobex.read_modes(path)
    assert lobex.read_modes(path, damping_unit="%").damping_ratio == pytest.approx([0.03])
    with refused("damping_unit = 'percent' is unknown"):
        lobex.read_modes(path, damping_unit="percent")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty; give a modal table"),
        ("nothing", "is no table; give a modal table in columns"),
        ("1,2,3\n4,5,6\n", "has no head with rows below it"),
        ("f [Hz],damping [%],k [N/m]\n", "has no head with rows below it"),
        ("f [Hz],damping [%],k\n450,3,1.5e7\n", "has no unit above 'k'; write one of N/m"),
        ("f [Hz],damping [%],k [psi]\n450,3,1.5e7\n", "has the unit 'psi' above 'k'"),
        ("f,damping [%],k [N/m]\n450,3,1.5e7\n", "has no unit above 'f'; write one of Hz"),
        ("f [Hz],damping [%]\n450,3\n", "no column of the stiffness or the mass"),
        ("f [Hz],k [N/m]\n450,3\n", "no column of the damping among 'f', 'k'; name it 'damping [%]'"),
        ("f [Hz],damping [%],k [N/m],m [kg]\n450,3,1e7,1\n", "has stiffness and mass"),
        ("f [Hz],damping [%],shape x\n450,3,1\n", "has shapes without a scale"),
        ("f [Hz],damping [%],k [N/m],axis\n450,3,1e7,r\n", "direction 'r' is none of x, y and z"),
        ("f [Hz],damping [%],k [N/m]\n450,three,1e7\n", "column 'damping': 'three' is no number"),
        ("f [Hz],damping [%],k [N/m]\n450,3,1e7\n450,3\n", "row 2 below the head: 2 cells, where the head has 3"),
        ("f [Hz],frequency [Hz],damping [%],k [N/m]\n450,450,3,1e7\n", "has 'f' and 'frequency' for the frequency"),
        ('f [Hz],damping [%],k [N/m]\n"1,450",3,1e7\n', "as in '1,450'; write 1.450 or 1450"),
        ("f [Hz];damping [%];k [N/m]\n1.450;2,5;10000\n", "has numbers with a point, '1.450', and with a comma, '2,5'"),
        ("f [Hz];damping [%];k [N/m]\n450;2,5;1.000.000\n", "'1.000.000' is no number: write it without signs between"),
        ("f [Hz],damping [%],k [N/m]\n450,3,-1e7\n", "stiffness = [-1e+07] must be positive"),
    ],
)
def test_modal_tables_that_cannot_be_are_refused(text, words, file):
    with refused(words):
        lobex.read_modes(file(text))


CUTS = np.array([[100.0, 1e-3, 0], [120.0, 2.5e-3, 1], [140.0, 3e-3, 0]])
LISTS = [
    "speed [rpm],depth [mm],chatter\n6000,1,no\n7200,2.5,yes\n8400,3,no\n",
    "spindle speed [Hz];ap [um];stable\n100;1000;1\n120;2500;0\n140;3000;1\n",
    "n [1/min]\tb [m]\toutcome\tnote\n6000\t1e-3\tstable\t\n7200\t2.5e-3\tchatter\tloud\n8400\t3e-3\tstable\t\n",
    'speed [rpm],depth [mm],chatter,note\n6000,1,no,"good, quiet"\n7200,2.5,yes,"loud, at exit"\n8400,3,no,\n',
    '"speed [rpm]","depth [mm]","chatter"\n"6000","1,0","no"\n"7200","2,5","yes"\n"8400","3,0","no"\n',
    "speed [rpm],depth [mm],stability\n6000,1,stable\n7200,2.5,unstable\n8400,3,stable\n",
]


@pytest.mark.parametrize("text", LISTS)
def test_cuts_of_every_kind_are_the_same(text, file):
    np.testing.assert_allclose(lobex.read_cuts(file(text)), CUTS, rtol=1e-14)


def test_cuts_are_what_a_chart_compares(tmp_path):
    path = sheet(
        tmp_path / "cuts.xlsx", [["speed [rpm]", "depth [mm]", "chatter"], [6600, 0.5, True], [8800, 2.6, False]]
    )
    cuts = lobex.read_cuts(path)
    np.testing.assert_allclose(cuts, [[110.0, 5e-4, 1.0], [8800 / 60, 2.6e-3, 0.0]], rtol=1e-14)
    turning = lobex.Turning(lobex.Modes.single(frequency=146.5, damping_ratio=0.03, mass=2.573), radial=2e8)
    chart = lobex.sweep(turning, [100.0, 160.0], [0.0, 4e-3])
    assert chart.compare(cuts).hits + chart.compare(cuts).misses == 2


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("speed,depth [mm],chatter\n6000,1,no\n", "has no unit above 'speed'; write one of rpm"),
        ("speed [rpm],depth,chatter\n6000,1,no\n", "has no unit above 'depth'; write one of mm"),
        ("speed [rpm],depth [mm]\n6000,1\n", "no column of the chatter among 'speed', 'depth'"),
        ("speed [rpm],depth [mm],chatter\n6000,1,no\n0,1,no\n", "row 2 below the head: the speed is 0 in SI units"),
        ("speed [rpm];depth [mm];chatter\n6,000;1;no\n", "as in '6,000'; write 6.000 or 6000"),
        (
            "speed [rpm];depth [mm];chatter\n6.000;1,5;no\n",
            "write all with one decimal sign, and none between thousands",
        ),
        ("speed [rpm],depth [mm],chatter\n6000,-1,no\n", "the depth or stiffness is -0.001 in SI units"),
        ("speed [rpm],depth [mm],chatter\n6000,1,perhaps\n", "'perhaps' does not say whether the cut chattered"),
    ],
)
def test_cuts_that_do_not_say_what_they_were_are_refused(text, words, file):
    with refused(words):
        lobex.read_cuts(file(text))
