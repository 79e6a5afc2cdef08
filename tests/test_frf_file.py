"""Files of analysers: what each holds comes out, and what is damaged or odd is refused in a helpful line."""

import io
import zipfile

import h5py
import numpy as np
import pytest
import pyuff
import scipy.io

import lobex
from lobex.measured.response_units import frequency_scale, response_unit
from refusals import refused
from tap_test import ACCELERANCE, FREQUENCY, OMEGA, POINT, RECEPTANCE, dataset, table, units

HEAD = "Frequency [Hz],Real [m/N],Imag [m/N]\n"
PARTS = FREQUENCY, POINT.real, POINT.imag
ROLES = ("frequency", "real", "imaginary")


@pytest.fixture
def file(tmp_path):
    def write(name, content, encoding="utf-8"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        return path

    return write


def same(frf, wanted=POINT, rel=1e-8):
    """Whether an Frf has the frequencies and the only, or the driving, receptance that are known."""
    np.testing.assert_allclose(frf.frequency, FREQUENCY, rtol=1e-9)
    np.testing.assert_allclose(frf.values(*frf.pairs[0]), wanted, rtol=rel)
    return True


def over_phase(values):
    return np.abs(values), np.rad2deg(np.angle(values))


TABLES = {
    "comma": table(*PARTS, head=HEAD),
    "decimal comma": table(*PARTS, head=HEAD.replace(",", ";"), separator=";", decimal=","),
    "tab and decimal comma": table(*PARTS, head=HEAD.replace(",", "\t"), separator="\t", decimal=","),
    "spaces": table(*PARTS, head="f(Hz) Re(m/N) Im(m/N)\n", separator="   "),
    "units in a row of their own": table(*PARTS, head="freq,real,imag\nHz,m/N,m/N\n"),
    "comments": table(*PARTS, head="# tap test of 3 June, unit: m/N\n# f [Hz],Re,Im\n"),
    "German names": table(
        FREQUENCY, POINT.real * 1e6, POINT.imag * 1e6, head="Frequenz [Hz],Realteil [µm/N],Imaginärteil [µm/N]\n"
    ),
    "degrees": table(FREQUENCY, *over_phase(POINT), head="f [Hz],|H| [m/N],Phase [deg]\n"),
    "radians": table(FREQUENCY, np.abs(POINT), np.angle(POINT), head="f [Hz],Magnitude [m/N],Phase [rad]\n"),
    "decibels": table(
        FREQUENCY, 20 * np.log10(np.abs(POINT)), over_phase(POINT)[1], head="f [Hz],Level dB (m/N),Phase [deg]\n"
    ),
    "angular frequency": table(OMEGA, *PARTS[1:], head="omega (rad/s),Re (m/N),Im (m/N)\n"),
    "accelerance in g": table(
        FREQUENCY,
        ACCELERANCE[:, 0, 0].real / 9.80665,
        ACCELERANCE[:, 0, 0].imag / 9.80665,
        head="Frequency [Hz],Real [g/N],Imag [g/N]\n",
    ),
    "mobility": table(
        FREQUENCY,
        (1j * OMEGA * POINT).real,
        (1j * OMEGA * POINT).imag,
        head="Frequency [Hz],Real [m/s/N],Imag [m/s/N]\n",
    ),
    "quotes around decimal commas": "\n".join(
        ",".join(f'"{cell}"' for cell in row.split(";"))
        for row in table(*PARTS, head=HEAD.replace(",", ";"), separator=";", decimal=",").splitlines()
    ),
    "H before directions": table(*PARTS, head="Frequency [Hz],Re(Hxx) [m/N],Im(Hxx) [m/N]\n"),
    "exponents of Fortran": HEAD + table(*PARTS).replace("e", "D"),
    "descending": table(*(part[::-1] for part in PARTS), head=HEAD),
    "a line at 0 Hz": table(*(np.r_[0.0, part] for part in PARTS), head=HEAD),
}


@pytest.mark.parametrize("kind", TABLES)
def test_tables_of_every_kind_hold_the_same_receptance(kind, file):
    assert same(lobex.read_frf(file("one.csv", TABLES[kind])))


def test_how_a_table_was_read_is_told(file):
    told = repr(lobex.read_frf(file("one.txt", TABLES["tab and decimal comma"])))
    for words in (
        "columns separated by tab, decimal comma",
        "x to x",
        "2.5 Hz apart",
        "a receptance",
        "m/N, as the file",
    ):
        assert words in told


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "latin-1"])
def test_text_of_other_encodings_is_read(encoding, file):
    assert same(lobex.read_frf(file("one.csv", TABLES["German names"], encoding)))


def test_cutpro_has_its_head_at_the_end_of_the_first_row(file):
    first, *rows = table(*PARTS, separator="\t").splitlines()
    words = "\tFreq\tHz\tReal\tm/N\tImag\tReal\t"
    assert same(lobex.read_frf(file("FRFX.frf", "\n".join([first + words, *rows]))))
    # Without these words its columns are the same.
    assert same(lobex.read_frf(file("plain.frf", "\n".join([first, *rows]))))


def test_directions_stand_above_the_columns(file):
    parts = [
        part
        for i, j in ((0, 0), (1, 0), (0, 1), (1, 1))
        for part in (RECEPTANCE[:, i, j].real, RECEPTANCE[:, i, j].imag)
    ]
    head = "Frequency [Hz]," + ",".join(
        f"{part} {pair} [m/N]" for pair in ("xx", "yx", "xy", "yy") for part in ("re", "im")
    )
    frf = lobex.read_frf(file("both.csv", table(FREQUENCY, *parts, head=head + "\n")))
    np.testing.assert_allclose(frf.matrix, RECEPTANCE, rtol=1e-8)
    assert (frf.responses, frf.references, frf.driving_points) == (("x", "y"), ("x", "y"), ("x", "y"))
    kept = lobex.read_frf(file("both.csv", table(FREQUENCY, *parts, head=head + "\n")), response="y", reference="y")
    np.testing.assert_allclose(kept.values(), RECEPTANCE[:, 1, 1], rtol=1e-8)


def test_coherence_comes_along(file):
    text = table(*PARTS, np.linspace(0.5, 1, len(FREQUENCY)), head=HEAD[:-1] + ",Coherence\n")
    frf = lobex.read_frf(file("one.csv", text))
    assert frf.coherence[:, 0, 0] == pytest.approx(np.linspace(0.5, 1, len(FREQUENCY)))
    assert "coherence        0.75 in the mean" in repr(frf)
    assert len(frf.plot().axes) == 3


@pytest.mark.parametrize("binary", [False, True])
def test_universal_files_say_what_they_hold(binary, file):
    # The second response was measured against its axis.
    content = b"".join(
        dataset(sign * ACCELERANCE[:, i, 0], response=direction, binary=binary)
        for i, sign, direction in ((0, 1, 1), (1, -1, -2))
    )
    frf = lobex.read_frf(file("one.uff", content))
    assert same(frf, rel=1e-10)
    np.testing.assert_allclose(frf.values("y", "x"), RECEPTANCE[:, 1, 0], rtol=1e-10)
    assert frf.measured == "acceleration"
    assert np.iscomplexobj(frf.matrix)


def test_units_of_a_universal_file_without_labels_are_those_of_dataset_164(file):
    # Millimetres and newtons: factors by which SI is multiplied.
    content = units(1e3, 1.0) + dataset(1e3 * ACCELERANCE[:, 0, 0], labels=("NONE", "NONE"))
    assert same(lobex.read_frf(file("one.unv", content)), rel=1e-10)
    # A universal file tells itself by how it begins.
    assert same(lobex.read_frf(file("one.txt", content)), rel=1e-10)


def test_coherence_and_points_of_a_universal_file(file):
    share = np.full(len(FREQUENCY), 0.75 + 0j)
    content = dataset(RECEPTANCE[:, 0, 0], labels=("m", "N"), kind=8) + dataset(share, function=6)
    frf = lobex.read_frf(file("one.uff", content))
    assert frf.coherence[:, 0, 0] == pytest.approx(0.75)
    content = b"".join(dataset(RECEPTANCE[:, i, 0], node=i + 1, labels=("m", "N"), kind=8) for i in range(2))
    assert lobex.read_frf(file("two.uff", content)).pairs == (("1 x", "1 x"), ("2 x", "1 x"))


def test_arrays_of_numpy_and_matlab(tmp_path):
    np.savez(tmp_path / "a.npz", frequency=FREQUENCY, receptance=RECEPTANCE, unit="m/N")
    np.save(tmp_path / "b.npy", np.column_stack([FREQUENCY, POINT]))
    np.save(tmp_path / "c.npy", np.column_stack(PARTS))
    scipy.io.savemat(tmp_path / "d.mat", {"omega": OMEGA, "H": POINT, "unit": "m/N"})
    with h5py.File(tmp_path / "e.mat", "w", userblock_size=512) as stored:
        stored["f"] = FREQUENCY[None]
        values = np.zeros(RECEPTANCE.T.shape, [("real", "f8"), ("imag", "f8")])
        values["real"], values["imag"] = RECEPTANCE.T.real, RECEPTANCE.T.imag
        stored["own"] = values
    assert same(lobex.read_frf(tmp_path / "a.npz", response=("x", "y")), rel=1e-15)
    assert same(lobex.read_frf(tmp_path / "b.npy", unit="m/N"), rel=1e-15)
    assert same(lobex.read_frf(tmp_path / "c.npy", unit="m/N", columns=ROLES), rel=1e-15)
    assert same(lobex.read_frf(tmp_path / "d.mat"), rel=1e-15)
    found = lobex.read_frf(
        tmp_path / "e.mat", unit="m/N", response=("x", "y"), columns={"f": "frequency", "own": "complex"}
    )
    np.testing.assert_array_equal(found.matrix, RECEPTANCE)


def objects(path):
    np.save(path, np.array([{"run": "code"}], dtype=object), allow_pickle=True)
    return path


ACCELEROMETER = table(FREQUENCY, ACCELERANCE[:, 0, 0].real, ACCELERANCE[:, 0, 0].imag, head=HEAD)
ROWS = TABLES["comma"].splitlines(keepends=True)
REFUSED = {
    "empty": ("a.csv", "", {}, "is empty; give a file of frequency responses"),
    "empty universal": ("a.uff", "", {}, "is empty; give a universal file"),
    "of another type": ("a.csv", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", {}, "is no text; give"),
    "words": ("a.csv", "lorem ipsum\ndolor sit\n", {}, "has no lines of 3 or more numbers"),
    "no head": ("a.csv", table(*PARTS), {}, "give columns=('frequency', 'real', 'imaginary')"),
    "no unit": ("a.csv", table(*PARTS), {"columns": ROLES}, "give unit=, such as 'm/N' of a receptance"),
    "a unit of something else": ("a.csv", ROWS[0] + ROWS[1], {"unit": "N/m"}, "unit = 'N/m' is no unit of a response"),
    "no phase": ("a.csv", table(FREQUENCY, POINT.real, OMEGA, head="f [Hz],|H| [m/N],Coh\n"), {}, "has magnitude and"),
    "phase in no unit": ("a.csv", table(*PARTS, head="f [Hz],|H| [m/N],Phase\n"), {}, "a column 'Phase' that is not"),
    "one direction missing": (
        "a.csv",
        table(*PARTS, POINT.real, head="f [Hz],re xx [m/N],im xx [m/N],re yx [m/N]\n"),
        {},
        "has real and no other part",
    ),
    "a chart": (
        "a.csv",
        table(FREQUENCY, POINT.real, POINT.imag, head="speed_Hz,multiplier_real,multiplier_imag\n"),
        {},
        "holds no frequency response but a table over speeds, such as that of a chart, a limit or a list of cuts",
    ),
    "another table": (
        "a.csv",
        table(*PARTS, head="time [s],x [m],y [m]\n"),
        {},
        "is not seen to hold a frequency response, which takes a column of frequencies and two of a response: its "
        "columns are 'time [s]', 'x [m]', 'y [m]'; give columns=",
    ),
    "a result": ("a.csv", b"\x89HDF\r\n\x1a\n" + bytes(100), {}, "such as of a result, which lobex.load reads, and no"),
    "cut short": ("a.csv", "".join(ROWS)[:-18], {}, f"line {len(ROWS)}: 2 numbers, where other lines have 3"),
    "a frequency twice": ("a.csv", ROWS[0] + ROWS[1] + "".join(ROWS[1:]), {}, "has 50 Hz in several lines"),
    "gaps": ("a.csv", table(FREQUENCY, POINT.real * np.nan, POINT.imag, head=HEAD), {}, "no number in 460 of its 460"),
    "two units": ("a.csv", table(*PARTS, head=HEAD.replace("Imag [m/N]", "Imag [um/N]")), {}, "'m/N' and 'um/N'"),
    "no universal file": ("a.uff", "58\nNONE\n", {}, "is no universal file"),
    "time responses": ("a.uff", dataset(POINT, function=1), {}, "but time responses; export those"),
    "universal, cut short": ("a.uff", dataset(POINT)[:-4000], {}, "is cut short: its last dataset has no end"),
    "58b, cut short": ("a.uff", dataset(POINT[:-9], binary=True, count=len(POINT)), {}, "says 460 values and has 451"),
    "universal, damaged": ("a.uff", dataset(POINT).replace(b"e-0", b"x-0", 3), {}, "is damaged"),
    "universal without units": ("a.uff", dataset(POINT, labels=("NONE", "NONE")), {}, "give unit="),
    "universal, twice the same": ("a.uff", 2 * dataset(POINT), {}, "has two responses of 'x' to 'x'"),
    "other frequencies": ("a.uff", dataset(POINT) + dataset(POINT[:-5], response=2), {}, "different frequencies"),
    "a direction that is not there": ("a.uff", dataset(POINT), {"response": "z"}, "response = 'z' is not in"),
    "thousands": (
        "a.csv",
        TABLES["decimal comma"].replace("1,002500000e+03", "1.002,5"),
        {},
        "line 383: '1.002,5' is no number: write it without signs between thousands; mend or remove that line",
    ),
    # All that is below 1000 would be read with a point.
    "thousands before decimal points": (
        "a.csv",
        TABLES["comma"].replace(",", ";").replace("1.002500000e+03", "1,002.5"),
        {},
        "line 383: '1,002.5' is no number: write it without signs between thousands",
    ),
    "commas of which nobody knows": (
        "a.csv",
        HEAD.replace(",", ";") + "".join(f"{i},000;{i + 5},125;-{i + 9},250\n" for i in range(1, 30)),
        {},
        "has commas that may stand before decimals or between thousands, as in '1,000'; write 1.000 or 1000",
    ),
    "both decimal signs": (
        "a.csv",
        HEAD.replace(",", ";") + "".join(f"{i},5;{i}.5e-7;-{i}.5e-7\n" for i in range(1, 30)),
        {},
        "and has numbers with a point, '1.5e-7', and with a comma, '1,5'; write all with one decimal sign",
    ),
    "complex numbers": (
        "a.csv",
        "f [Hz],H [m/N]\n" + "".join(f"{f},{h.real:e}{h.imag:+e}i\n" for f, h in zip(FREQUENCY, POINT, strict=True)),
        {},
        "but complex ones; save real and imaginary parts in columns of their own",
    ),
    "two columns": ("a.csv", table(*PARTS[:2], head="f [Hz],Re [m/N]\n"), {}, "table of frequencies and the two"),
    "words below": ("a.csv", TABLES["comma"] + "end of file\n", {}, "'end of file' is no number; mend or remove"),
    "CutPro with a column more": ("a.frf", table(*PARTS, PARTS[0]), {}, "says what its 4 columns are; give"),
    "58b of another byte order": (
        "a.uff",
        dataset(POINT, binary=True).replace(b"58b     1", b"58b     2"),
        {},
        "has numbers above 1e+30, and no response has",
    ),
    "no zip": ("a.npz", "PK no zip", {}, "holds objects of Python, or is no file of NumPy"),
    "no matlab": ("a.mat", "MATLAB" * 40, {}, "cannot be read as .mat"),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_what_is_damaged_is_refused_in_a_line_that_says_what_to_do(kind, file):
    name, content, arguments, words = REFUSED[kind]
    path = file(name, content)
    with refused(words):
        lobex.read_frf(path, **arguments)


def test_what_lobex_writes_is_no_frequency_response(tmp_path):
    rub = lobex.Rub(lobex.Rod(1).modes())
    limit, chart = lobex.exact_limit(rub, [80.0, 90.0, 100.0]), lobex.sweep(rub, [80.0, 90.0], [1e5, 1e6])
    for result, name in ((limit, "limit"), (chart, "chart")):
        for ending in ("csv", "nc"):
            result.save(tmp_path / f"{name}.{ending}")
            words = "table over speeds, such as that of a chart" if ending == "csv" else "which lobex.load reads"
            with refused(words):
                lobex.read_frf(tmp_path / f"{name}.{ending}")


def test_a_file_that_could_run_code_is_not_opened(tmp_path):
    with refused("a file that could run code is not opened"):
        lobex.read_frf(objects(tmp_path / "a.npy"), unit="m/N")
    with refused("there is no such file"):
        lobex.read_frf(tmp_path / "none.csv")


def test_arrays_that_do_not_say_what_they_are_are_refused(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, one=FREQUENCY, two=POINT)
    with refused("of which none can be the frequency array; give columns={"):
        lobex.read_frf(path)
    scipy.io.savemat(tmp_path / "a.mat", {"frf": {"f": FREQUENCY, "H": POINT}})
    with refused("has no arrays of numbers by themselves; save those of a structure each by its name, in MATLAB by"):
        lobex.read_frf(tmp_path / "a.mat")
    np.savez(path, f=FREQUENCY, H=np.abs(POINT))
    with refused("has 'H' without imaginary part"):
        lobex.read_frf(path)
    np.savez(path, f=FREQUENCY, H=POINT[:-1])
    with refused("of shape (459,) for 460 frequencies"):
        lobex.read_frf(path)
    np.savez(path, f=FREQUENCY, H=RECEPTANCE, unit="m/N")
    with refused("does not name the directions of its 2 responses; give response="):
        lobex.read_frf(path)


@pytest.mark.slow
def test_small_files_that_say_they_are_large_are_not_unpacked(tmp_path, file):
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (10**13,)})
    with refused("says that it holds more than fits in memory"):
        lobex.read_frf(file("a.npy", head.getvalue() + bytes(80)), unit="m/N")
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive, archive.open("f.npy", "w") as part:
        for _ in range(33):
            part.write(bytes(2**24))
    with refused("it unpacks to 528 MiB; give a file of up to 512 MiB"):
        lobex.read_frf(tmp_path / "a.npz", unit="m/N")
    with h5py.File(tmp_path / "a.mat", "w") as stored:
        stored.create_dataset("H", shape=(10**11,), dtype="f8", chunks=(10**6,))
    with refused("it unpacks to 762939 MiB"):
        lobex.read_frf(tmp_path / "a.mat", unit="m/N")
    for count in (2 * 10**9, 0, -5):
        with refused(f"a dataset says {count} values, in a file of"):
            lobex.read_frf(file("a.uff", dataset(POINT, count=count)))


@pytest.mark.parametrize(
    "content", [" ".join(["1.5"] * 20_000), "x" * 20_000 + ",Real,Imag\n" + "".join(ROWS[1:])], ids=["wide", "long"]
)
def test_messages_stay_short(content, file):
    with refused("give columns=") as error:
        lobex.read_frf(file("a.csv", content))
    assert len(str(error.value)) < 500


def test_a_coherence_in_per_cent_is_refused(file):
    for value, shown in ((98.5, "98.5"), (-0.2, "-0.2")):
        rows = table(*PARTS, np.full(len(FREQUENCY), value), head=HEAD.replace("\n", ",Coherence\n"))
        with refused(f"coherence has {shown}, and is a share from 0 to 1"):
            lobex.read_frf(file("a.csv", rows))
    roles = ("frequency", "real", "imaginary", "unused")
    assert same(lobex.read_frf(file("a.csv", rows), columns=roles))


# At 16 bytes a line.
STRAY = {
    "at the end": 0,
    "before the last number": 8,
    "in the middle": 16 * 200,
    "at the beginning": 16 * len(FREQUENCY),
}


@pytest.mark.parametrize("stray", [b"\n", b"\r\n", b" " * 40])
@pytest.mark.parametrize("place", STRAY)
def test_a_stray_newline_in_58b_does_no_harm_or_is_refused(place, stray, file):
    content = dataset(ACCELERANCE[:, 0, 0], binary=True)
    at = len(content) - 7 - STRAY[place]
    path = file("a.uff", content[:at] + stray + content[at:])
    if STRAY[place]:
        with refused(f"a dataset 58b with more than the {16 * len(FREQUENCY)} bytes of numbers that its head says"):
            lobex.read_frf(path)
    else:
        assert same(lobex.read_frf(path), rel=1e-10)


# That leaves its file open.
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("spaced", [0, 1])
@pytest.mark.parametrize("binary", [0, 1])
def test_what_another_program_writes_is_read(spaced, binary, tmp_path):
    path = tmp_path / "a.uff"
    written = {
        "type": 58,
        "binary": binary,
        "func_type": 4,
        "rsp_node": 1,
        "rsp_dir": -1,
        "ref_node": 1,
        "ref_dir": 1,
        "data": -ACCELERANCE[:, 0, 0] / 9.80665,
        "x": FREQUENCY,
        "num_pts": len(FREQUENCY),
        "abscissa_spacing": spaced,
        "abscissa_spec_data_type": 18,
        "ordinate_spec_data_type": 12,
        "orddenom_spec_data_type": 13,
        "ordinate_axis_units_lab": "g",
        "orddenom_axis_units_lab": "N",
    }
    pyuff.UFF(str(path)).write_sets([written], mode="add")
    assert same(lobex.read_frf(path), rel=1e-9)


@pytest.mark.parametrize("gap", ["NaN", "-nan(ind)", "1.#QNAN", "#DIV/0!", "*****", ""])
def test_lines_with_gaps_are_left_out_with_a_warning(gap, file):
    text = TABLES["comma"].replace(ROWS[11], f"{FREQUENCY[10]},{gap},{gap}\n")
    with pytest.warns(lobex.LobexWarning, match="no number in 1 of 460 lines, which are left out"):
        frf = lobex.read_frf(file("a.csv", text))
    np.testing.assert_allclose(frf.values(), np.delete(POINT, 10), rtol=1e-8)


def test_an_accelerance_called_receptance_is_warned_of_with_what_mends_it(file):
    path = file("a.csv", ACCELEROMETER)
    with pytest.warns(lobex.LobexWarning, match="an accelerance is read by unit='m/s\\^2/N'"):
        lobex.read_frf(path)
    with pytest.warns(lobex.LobexWarning, match="is taken, where a.csv says 'm/N'"):
        mended = lobex.read_frf(path, unit="m/s^2/N")
    assert same(mended)


def test_a_sensor_against_the_force_and_another_sign_of_time_are_warned_of(file):
    against = file("a.csv", table(FREQUENCY, -POINT.real, -POINT.imag, head=HEAD))
    with pytest.warns(lobex.LobexWarning, match="that pointed against the force by response='-x'"):
        lobex.read_frf(against)
    assert same(lobex.read_frf(against, response="-x"))
    other = file("b.csv", table(FREQUENCY, POINT.real, -POINT.imag, head=HEAD))
    with pytest.warns(lobex.LobexWarning, match="is read by conjugate=True"):
        lobex.read_frf(other)
    assert same(lobex.read_frf(other, conjugate=True))


def test_a_sensor_said_to_point_against_its_axis_that_does_not_is_warned_of(file):
    path = file("a.csv", TABLES["comma"])
    with pytest.warns(lobex.LobexWarning, match="of a sensor that pointed against the force by response='x'"):
        lobex.read_frf(path, response="-x")


def test_a_response_without_imaginary_part_is_warned_of(file):
    path = file("a.csv", table(FREQUENCY, np.abs(POINT), 0 * FREQUENCY, head=HEAD))
    with pytest.warns(lobex.LobexWarning, match="as a magnitude without phase; export real and imaginary parts"):
        lobex.read_frf(path)


def test_angular_frequencies_without_a_unit_are_warned_of(file):
    path = file("a.csv", table(OMEGA, *PARTS[1:], head="frequency,Re [m/N],Im [m/N]\n"))
    with pytest.warns(lobex.LobexWarning, match="2π times 2.5, and are taken for Hz; give frequency_unit='rad/s'"):
        lobex.read_frf(path)
    assert same(lobex.read_frf(path, frequency_unit="rad/s"))


def test_frequencies_that_can_only_be_khz_are_warned_of(file):
    path = file("a.csv", table(FREQUENCY / 1e3, *PARTS[1:], head="frequency,Re [m/N],Im [m/N]\n"))
    with pytest.warns(lobex.LobexWarning, match="end at 1.1975, and are taken for Hz; give frequency_unit='kHz'"):
        lobex.read_frf(path)
    assert same(lobex.read_frf(path, frequency_unit="kHz"))


def test_columns_are_told_by_name_or_in_order(file):
    path = file("a.csv", table(*PARTS, POINT.real, head="A,B,C,D\n"))
    assert same(lobex.read_frf(path, unit="m/N", columns=(*ROLES, "unused")))
    assert same(lobex.read_frf(path, unit="m/N", columns=dict(zip("ABC", ROLES, strict=True))))
    for columns, words in (
        (ROLES, "columns has 3 roles, and"),
        ((*ROLES, "level"), "columns = 'level' is unknown; choose one of 'frequency'"),
        ({"E": "real"}, "columns names 'E'; path ="),
        (("real", *ROLES), "has two columns 'real' of one response"),
    ):
        with refused(words):
            lobex.read_frf(path, unit="m/N", columns=columns)


@pytest.mark.parametrize(
    ("text", "measured", "scale"),
    [
        ("m/N", "displacement", 1.0),
        ("µm / N", "displacement", 1e-6),
        ("in/lbf", "displacement", 0.0254 / 4.4482216152605),
        ("mm/s/N", "velocity", 1e-3),
        ("m/(N s)", "velocity", 1.0),
        ("m/s**2/N", "acceleration", 1.0),
        ("(m/s²)/N", "acceleration", 1.0),
        ("m/Ns^2", "acceleration", 1.0),
        ("m·s⁻²·N⁻¹", "acceleration", 1.0),
        ("g/kN", "acceleration", 9.80665e-3),
        ("1/kg", "acceleration", 1.0),
    ],
)
def test_units_as_people_write_them(text, measured, scale):
    found = response_unit(text)
    assert found is not None
    assert (found.measured, found.scale) == (measured, pytest.approx(scale, rel=1e-14))


@pytest.mark.parametrize("text", ["", "N/m", "m", "m/s", "N", "m/N^2", "bananas/N", "m s/N", "/"])
def test_what_is_no_unit_of_a_response(text):
    assert response_unit(text) is None


def test_units_of_frequency():
    assert [frequency_scale(text) for text in ("Hz", "kHz", "rpm", "Hertz")] == [1.0, 1e3, 1 / 60, None]
    assert frequency_scale("rad/s") == pytest.approx(1 / (2 * np.pi))
    with refused("frequency_unit = 'Hertz' is unknown; give 'Hz'"):
        lobex.read_frf(__file__, frequency_unit="Hertz")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: lobex.Frf(FREQUENCY[::-1], POINT), "frequency = [1197.5, 1195, 1192.5, 1190, …] is not strictly"),
        (lambda: lobex.Frf(FREQUENCY[:7], POINT[:7]), "frequency has 7 lines above 0 Hz; give at least 8"),
        (lambda: lobex.Frf(FREQUENCY, RECEPTANCE), "matrix has shape (460, 2, 2); give (frequencies, responses"),
        (lambda: lobex.Frf(FREQUENCY, np.r_[np.nan, POINT[1:]]), "among those of x to x; leave their frequencies out"),
        (lambda: lobex.Frf(FREQUENCY, 0 * POINT), "matrix is zero throughout for x to x"),
        (lambda: lobex.Frf(FREQUENCY, np.nan * POINT), "matrix has no values"),
        (lambda: lobex.Frf(FREQUENCY, RECEPTANCE, ("x", "x"), ("x", "y")), "has a name twice"),
        (lambda: lobex.Frf(FREQUENCY, RECEPTANCE, "xy", "xy"), "matrix has shape"),
        (lambda: lobex.Frf(FREQUENCY, POINT).values("y"), "'y' to reference = 'y' was not measured; there are x to x"),
        (lambda: lobex.Turning(lobex.Frf(FREQUENCY, POINT), radial=1e8), "give the modes fitted to it, by modes()"),
    ],
)
def test_samples_that_are_none_are_refused(make, words):
    with refused(words):
        make()


def test_a_pair_as_a_receptance_has_limits_without_a_fit():
    receptance = lobex.Frf(FREQUENCY, RECEPTANCE, ("x", "y"), ("x", "y")).receptance("y")
    np.testing.assert_array_equal(receptance.response, RECEPTANCE[:, 1, 1])
    assert np.isfinite(lobex.exact_limit(lobex.Turning(receptance, radial=1e8), [100.0]).gain).all()
