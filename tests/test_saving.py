"""Files of every kind of result: they come back, and what is missing or wrong in them is told in one line."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
import xarray
from scipy.io import loadmat

import lobex
from cases import assert_same_fields
from lobex.files import made_of
from lobex.results import fields as declare
from lobex.results.matlab import legal
from lobex.results.result import Result
from lobex.results.saving import in_parts, write_netcdf
from lobex.results.stored import Stored
from refusals import refused
from small_results import RESULTS

ALONE = [name for name in RESULTS if not name.startswith("study")]
WITHOUT_TABLE = {"wear map", "blading wear", "study of wear", "recommendation"}


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """The datasets of all results' files, by name."""
    folder = tmp_path_factory.mktemp("saved")
    datasets = {}
    for name, make in RESULTS.items():
        make().save(folder / "r.nc")
        with xarray.open_dataset(folder / "r.nc", engine="h5netcdf") as stored:
            datasets[name] = stored.load()
    return datasets


def refusal(source):
    """The one line in which a file, or what was read from one, is refused."""
    path = "r.nc" if isinstance(source, xarray.Dataset) else source
    with pytest.raises(ValueError) as error:
        lobex.load(path) if path is source else made_of(source, "path = 'r.nc'")
    text = str(error.value)
    assert text.startswith(f"path = {str(path)!r}")
    assert "\n" not in text
    return text


def fields(dataset):
    """Every variable and attribute."""
    return [*map(str, dataset.variables), *map(str, dataset.attrs)]


@pytest.mark.parametrize("name", ALONE)
def test_a_result_comes_back(name, tmp_path):
    result = RESULTS[name]()
    result.save(tmp_path / "r.NC")
    again = lobex.load(tmp_path / "r.NC")
    assert type(again) is type(result)
    if name == "boundary":
        for curve, other in zip(again, result, strict=True):
            assert_same_fields(curve, other)
    elif name == "sensitivities":
        np.testing.assert_array_equal(again.derivative, result.derivative)
        assert_same_fields(again.limit, result.limit)
    else:
        assert_same_fields(again, result)
    assert repr(again) == repr(result)
    assert [p.name for p in tmp_path.iterdir()] == ["r.NC"]


@pytest.mark.parametrize("name", ALONE)
def test_a_file_holds_what_xarray_would_write(name, saved, tmp_path):
    labelled = in_parts(RESULTS[name]().to_xarray())
    write_netcdf(labelled, tmp_path / "r.nc")
    with xarray.open_dataset(tmp_path / "r.nc", engine="h5netcdf") as stored:
        xarray.testing.assert_identical(saved[name], stored.load())


@pytest.mark.parametrize("name", RESULTS)
def test_every_field_is_missed(name, saved):
    dataset = saved[name]
    assert len(fields(dataset)) > 8 or name.startswith("study") or name == "spectrum"
    for field in fields(dataset):
        if field in dataset.attrs:
            less = dataset.copy()
            del less.attrs[field]
        else:
            less = dataset.drop_vars(field)
        text = refusal(less)
        assert repr(field) in text or (field == "format" and "not a lobex result" in text), (field, text)


@pytest.mark.parametrize("name", RESULTS)
def test_a_field_of_another_kind_is_refused(name, saved):
    dataset = saved[name]
    for field in map(str, dataset.variables):
        variable = dataset.variables[field]
        values = variable.to_numpy()
        other = values.astype(np.float32) if values.dtype.kind == "f" else np.zeros(values.shape)
        changed = dataset.drop_vars(field).assign({field: xarray.Variable(variable.dims, other, variable.attrs)})
        text = refusal(changed)
        assert f"variable {field!r} of type" in text
        # A dimension of that name would be a coordinate.
        dims = tuple(f"other_{i}" for i in range(variable.ndim))
        moved = dataset.drop_vars(field).assign_coords({field: xarray.Variable(dims, values)})
        assert repr(field) in refusal(moved)
        # The axes of a study go by name.
        if variable.ndim > 1 and not name.startswith("study"):
            turned = dataset.drop_vars(field).assign_coords({field: variable.transpose()})
            assert f"variable {field!r} over" in refusal(turned)
    for field, value in dataset.attrs.items():
        wrong = "words" if not isinstance(value, str) else 3.5
        text = refusal(dataset.assign_attrs({field: wrong}))
        assert repr(field) in text or field == "format", text


@pytest.mark.parametrize("name", [name for name in RESULTS if name != "spectrum"])
def test_cut_off_json_is_told(name, saved):
    dataset = saved[name]
    told = [k for k, v in dataset.attrs.items() if isinstance(v, str) and v[:1] in "[{"]
    assert told
    for field in told:
        for text in (dataset.attrs[field][:-1], "", "null", '"words"', "[1.5]", "{}", "[" * 10**5):
            assert repr(field) in refusal(dataset.assign_attrs({field: text}))


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("chart", lambda d: d.assign_coords(speed=[60.0, 50.0, 70.0]), "variable 'speed' that does not increase"),
        ("chart", lambda d: d.assign_coords(gain=[1.0, np.nan]), "variable 'gain' with NaN"),
        ("chart", lambda d: d.assign(status=d["status"] + 4), "variable 'status' with values other than 0, 1, 2, 3"),
        ("wear map", lambda d: d.assign_attrs(failed=-1), "attribute 'failed' = -1"),
        ("chart", lambda d: d.assign_attrs(speed_unit="rad/s"), "attribute 'speed_unit' = 'rad/s'"),
        ("chart", lambda d: d.assign_attrs(process='{"modes": 3}'), "attribute 'process' that describes no model"),
        ("limit", lambda d: d.assign(kind=("speed", np.array([1, 0, 7], np.int8))), "variable 'kind' with values"),
        ("limit", lambda d: d.assign(status=("speed", np.array([-1, 0, 0], np.int8))), "variable 'status'"),
        ("limit", lambda d: d.assign_attrs(bounds=[1.0, 2.0, 3.0]), "attribute 'bounds' that is not 2 numbers"),
        ("limit", lambda d: d.isel(edge=[0]), "'stable_interval' with other than 2"),
        ("limit", lambda d: d.assign_attrs(quantity=_scaled(d.attrs["quantity"])), "attribute 'quantity' with a bad"),
        ("sensitivities", lambda d: d.assign_coords(parameter=["a", "b"]), "other names than"),
        ("boundary", lambda d: d.assign(curve=("vertex", np.zeros(7, np.int32))), "variable 'curve' that does not"),
        ("march", lambda d: d.assign_attrs(lanes="[3]"), "attribute 'lanes' = [3]"),
        ("cut", lambda d: d.assign_attrs(lanes="[-2]"), "attribute 'lanes'"),
        ("wear map", lambda d: d.assign_attrs(model='{"modes": {"type": "Modes"}}'), "does not describe modes"),
        ("study", lambda d: d.assign_coords({"modes.damping_ratio": [0.2, 0.1]}), "'modes.damping_ratio' that does"),
        ("study", lambda d: _told(d, 0, "quantity"), "no attribute 'quantity'"),
        ("study", lambda d: _told(d, 1, "quantity"), "combination 1"),
        ("study", lambda d: d.assign(attributes=(d["attributes"].dims, ["{", "{"])), "no whole JSON text"),
        ("chart", lambda d: d.assign_attrs(format="lobex chart 2"), "'lobex chart 2', and this version"),
    ],
)
def test_what_makes_no_sense_is_refused(name, change, words, saved):
    assert words in refusal(change(saved[name]))


def _scaled(quantity):
    return json.dumps(json.loads(quantity) | {"scale": 0.0})


def _told(dataset, number, field):
    """A study of which one combination lacks a field."""
    texts = [json.loads(text) for text in dataset["attributes"].values]
    del texts[number][field]
    return dataset.assign(attributes=(dataset["attributes"].dims, [json.dumps(text) for text in texts]))


@pytest.mark.parametrize(("name", "field"), [("chart", "speed"), ("limit", "speed"), ("wear map", "angle")])
def test_a_file_that_lost_a_coordinate_is_refused(name, field, saved, tmp_path):
    saved[name].drop_vars(field).to_netcdf(tmp_path / "less.nc", engine="h5netcdf")
    assert f"has no variable {field!r}" in refusal(tmp_path / "less.nc")


def test_a_cut_off_file_is_refused(tmp_path):
    RESULTS["chart"]().save(tmp_path / "chart.nc")
    content = (tmp_path / "chart.nc").read_bytes()
    for size in (len(content) // 2, 100, 0):
        (tmp_path / "chart.nc").write_bytes(content[:size])
        assert "no readable NetCDF-4" in refusal(tmp_path / "chart.nc")


def test_text_of_every_make_is_read():
    for dtype in (object, "U1"):
        dataset = xarray.Dataset(coords={"parameter": np.array(["a", "b"], dtype=dtype)})
        assert list(Stored(dataset, "here").array("parameter", "parameter", kind="U")) == ["a", "b"]


class Wobble(Result, form="lobex wobble 1"):
    """A result of one's own."""

    speed: np.ndarray = declare.field(declare.Coordinate("*lane", "rotational frequency", "Hz"))
    tilt: np.ndarray = declare.field(
        declare.Array("*lane end=2", lambda told: f"tilt by {told.law}", "rad", name="angle")
    )
    law: str
    turns: int

    @property
    @declare.derived(declare.Array("*lane", "largest tilt", "rad"), after="speed")
    def largest(self):
        """Of both ends."""
        return self.tilt.max(axis=-1)


def test_fields_declared_once_are_labelled_and_read():
    wobble = Wobble(np.array([[50.0], [60.0]]), np.arange(4.0).reshape(2, 1, 2), "sine", 3)
    dataset = wobble.to_xarray()
    assert list(dataset.variables) == ["largest", "angle", "speed"]
    assert dataset["angle"].dims == ("lane", "end")
    assert dataset["angle"].attrs == {"long_name": "tilt by sine", "units": "rad"}
    assert list(dataset.coords) == ["speed"]
    assert dataset.attrs == {"format": "lobex wobble 1", "lanes": "[2, 1]", "law": "sine", "turns": 3}
    assert_same_fields(declare.read(Wobble, Stored(dataset, "it")), wobble)
    for name in dataset.variables:
        with pytest.raises(ValueError, match=f"^it has no variable {name!r}"):
            declare.read(Wobble, Stored(dataset.drop_vars(name), "it"))


def test_a_boundary_without_curves_comes_back(tmp_path):
    replace(RESULTS["boundary"](), curves=()).save(tmp_path / "none.nc")
    assert len(lobex.load(tmp_path / "none.nc")) == 0


def test_a_cluster_that_is_gone_keeps_no_result_from_its_file(tmp_path):
    dask = pytest.importorskip("dask")
    result = RESULTS["chart"]()
    # So a client leaves it that lost its scheduler.
    with dask.config.set(scheduler="dask.distributed"):
        result.save(tmp_path / "r.nc")
        loaded = lobex.load(tmp_path / "r.nc")
    assert_same_fields(loaded, result)


# --- MATLAB and tables


@pytest.mark.parametrize("name", RESULTS)
def test_matlab_has_every_array_and_its_unit(name, saved, tmp_path):
    result = RESULTS[name]()
    result.save(tmp_path / "r.mat")
    assert [p.name for p in tmp_path.iterdir()] == ["r.mat"]
    content = loadmat(tmp_path / "r.mat", simplify_cells=True)
    dataset = result.to_xarray()
    names = legal(map(str, dataset.variables))
    assert set(content) - {"__header__", "__version__", "__globals__"} == {*names.values(), "about", "attributes"}
    for original, own in names.items():
        values = dataset[original].to_numpy()
        stored = np.asarray(content[own])
        # MATLAB has no arrays of one dimension or of none.
        np.testing.assert_array_equal(stored.reshape(values.shape), values)
        assert np.iscomplexobj(stored) == np.iscomplexobj(values)
        about = content["about"][own]
        assert about["name"] == original
        assert about["dimensions"] == ", ".join(dataset[original].dims)
        assert about.get("units") == dataset[original].attrs.get("units")
    assert content["attributes"]["format"] == dataset.attrs["format"]
    if "process" in dataset.attrs:
        assert json.loads(content["attributes"]["process"])["type"] == "Rub"


def test_names_are_those_that_matlab_takes():
    made = legal(["modes.shape[0,0]", "modes.shape[0.0]", "end", "μ", "3d", "_x", "while", "a" * 70, "a" * 80, "speed"])
    assert len(set(made.values())) == len(made)
    assert all(own.isidentifier() and own.isascii() and len(own) <= 63 for own in made.values())
    assert not any(own.startswith("_") for own in made.values())
    assert made["speed"] == "speed"
    assert made["modes.shape[0,0]"] == "modes_shape_0_0_"
    assert made["end"] == "x_end"


def table(path):
    """Head and rows of a file."""
    with open(path, newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return {name: np.array(column) for name, column in zip(head, zip(*rows, strict=True), strict=True)}


@pytest.mark.parametrize("name", ["chart", "sensitivities", "march"])
def test_zarr_holds_all_labelled_arrays_and_the_model(name, tmp_path):
    pytest.importorskip("zarr")
    RESULTS[name]().save(tmp_path / "r.zarr")
    assert [p.name for p in tmp_path.iterdir()] == ["r.zarr"]
    labelled = RESULTS[name]().to_xarray()
    with xarray.open_zarr(tmp_path / "r.zarr", consolidated=False) as again:
        xarray.testing.assert_equal(again.load(), labelled)
    assert again.attrs["process"] == labelled.attrs["process"]
    (tmp_path / "file.zarr").touch()
    for taken in ("r.zarr", "file.zarr"):
        with refused(f"{taken}' exists, and no Zarr takes its place"):
            RESULTS[name]().save(tmp_path / taken)


@pytest.mark.parametrize("name", [name for name in RESULTS if name not in WITHOUT_TABLE])
def test_tables_have_numbers_to_the_last_digit_and_units(name, saved, tmp_path):
    RESULTS[name]().save(tmp_path / "r.csv")
    assert [p.name for p in tmp_path.iterdir()] == ["r.csv"]
    columns = table(tmp_path / "r.csv")
    dataset = saved[name].drop_vars(["attributes", "closed"], errors="ignore")
    # Parts of a quantity side by side; xarray and pandas make the rows.
    apart = dataset.isel({d: 0 for d in PARTS if d in dataset.dims})
    rows = apart.to_dataframe(dim_order=ROWS.get(name)).reset_index()
    for field in map(str, dataset.variables):
        variable = dataset[field]
        own = [d for d in variable.dims if d in PARTS]
        if variable.dtype.kind != "f" or (name == "study of limits" and own):
            continue
        unit = variable.attrs.get("units", "1")
        first = "_".join([field, *(["1", "low"] if "edge" in own else ["1"] * len(own))])
        values = columns[first if unit == "1" else f"{first}_{unit}"].astype(float)
        np.testing.assert_array_equal(values, rows[field].to_numpy(), err_msg=field)


PARTS = ("interval", "edge", "output", "component", "mode", "direction", "tooth", "height")
ROWS = {
    "march": ["lane", "phase"],
    "cut": ["lane", "phase"],
    "chart": ["speed", "gain"],
    "spectrum": ["speed", "order"],
}
ROWS |= {"sensitivities": ["speed", "parameter"], "study": ["modes.damping_ratio", "speed", "gain"]}


def test_rows_and_words_of_a_table(tmp_path):
    RESULTS["limit"]().save(tmp_path / "limit.csv")
    columns = table(tmp_path / "limit.csv")
    assert list(columns)[:4] == ["speed_Hz", "gain_N/m", "chatter_frequency_Hz", "lobe"]
    assert list(columns["kind"]) == ["hopf", "none", "flip"]
    assert list(columns["status"]) == ["found", "none in range", "tie"]
    assert list(columns["stable_interval_2_low_N/m"]) == ["180000.0", "nan", "nan"]
    RESULTS["chart"]().save(tmp_path / "chart.csv")
    columns = table(tmp_path / "chart.csv")
    assert list(columns)[:2] == ["speed_Hz", "gain_N/m"]
    assert list(columns["gain_N/m"]) == ["100000.0", "200000.0"] * 3
    RESULTS["boundary"]().save(tmp_path / "boundary.csv")
    columns = table(tmp_path / "boundary.csv")
    assert list(columns["closed"]) == ["0"] * 4 + ["1"] * 3
    RESULTS["study"]().save(tmp_path / "study.csv")
    assert list(table(tmp_path / "study.csv"))[:3] == ["modes.damping_ratio", "speed_Hz", "gain_N/m"]
    RESULTS["march"]().save(tmp_path / "march.csv")
    assert list(table(tmp_path / "march.csv")["lane"]) == ["0"] * 3 + ["1"] * 3


@pytest.mark.parametrize("name", sorted(WITHOUT_TABLE))
def test_what_has_no_common_rows_has_no_table(name, tmp_path):
    with pytest.raises(ValueError, match=r"have no common rows.*give \.nc or \.mat") as error:
        RESULTS[name]().save(tmp_path / "r.csv")
    assert "\n" not in str(error.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", RESULTS)
@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("r.h5", "path = 'r.h5' ends in '.h5'; give .nc (which lobex.load reads back), .zarr, .mat or .csv"),
        ("r", "path = 'r' has no ending"),
        ("r.nc.", "give .nc"),
        ("", "path = '' is not a file name"),
        (5, "path = 5 is no path"),
        (b"r.nc", "path = b'r.nc' is no path"),
        ("x" * 300 + ".nc", "path = a str cannot be used (File name too long)"),
        ("no/r.mat", "there is no folder 'no'"),
    ],
)
def test_other_endings_and_places_are_refused_in_one_line(name, file, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = RESULTS[name]()
    with refused(words):
        result.save(file)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("file", [5, b"r.nc", "x" * 300, "a\0b"])
def test_what_is_no_path_is_not_loaded(file):
    with pytest.raises(ValueError, match=r"path = .*; give the path of a file"):
        lobex.load(file)
