"""The comparison with a file of reference numbers: what agrees, what does not, and what cannot be expressed."""

import copy
import json

import pytest

import references

# A titanium blade, its contact inclined by 30 degrees: by D-subdivision, and by Newton on the characteristic equation.
BLADE = {
    "beam": {
        **{"E": 110e9, "rho": 4430.0, "L": 0.2, "width": 0.05, "thickness": 0.004},
        **{"bending": 4, "axial": 1, "xi": 0.01},
    },
    "beta": [1.8751040687119611, 4.694091132974174, 7.854757438237613, 10.995540734875467, 14.13716839104647],
    "casing": {"frequency_Hz": 350.0, "xi": 0.02, "m": 1.5, "nd": 2, "alpha_deg": 30, "friction": 0.15},
    "cases": [
        {
            **{"case": "beam", "speed_Hz": 60.0, "alpha_deg": 30, "friction": 0.0},
            **{"critical_K": 6719.30290802, "chatter_Hz": 91.4978024017, "rel_diff": 3.8e-13},
            "points": [
                {"K": 3360.0, "mu": [-0.7650971479, 0.279171795972], "spectral_radius": 0.814438786768},
                {"K": 13440.0, "mu": [-1.09424914267, 0.95458441984], "spectral_radius": 1.45210626362},
            ],
        }
    ],
}


def tool(*pitch):
    """Two modes, along the feed and across it."""
    modes = [
        {"axis": axis, "frequency_Hz": frequency, "damping_ratio": ratio, "modal_mass_kg": mass}
        for axis, frequency, ratio, mass in (("x", 563.6, 0.0558, 1.4986), ("y", 516.21, 0.025, 1.199))
    ]
    return {"modes": modes, "pitch_deg": pitch, "Kt_N_per_m2": 679000000.0, "Kn_N_per_m2": 173824000.0}


# Motions of cutters by collocation of the pencil and by steps of order eight: with runout, and of pitch that repeats.
MOTION = {
    "tools": {"uneven": tool(82, 88, 92, 98), "twice": tool(70, 110, 70, 110)},
    "straight": [
        {
            **{"tool": "uneven", "radial_immersion": 0.5, "direction": "down", "rpm": 6000, "depth_m": 0.001},
            **{"feed_per_tooth_m": 0.0001, "runout_m": [1e-05, 0.0, 0.0, 0.0], "spectral_radius": 0.2379287072},
            **{"x_min_m": -1.424609898e-06, "x_max_m": 3.132940002e-06, "peak_x_m": 3.132940002e-06},
            **{"y_min_m": -4.570854296e-06, "y_max_m": 1.121807698e-05, "peak_y_m": 1.121807698e-05},
            "y_at_surface_m": [3.406082376e-06, 4.897075414e-06, 2.257490222e-06, -1.014699838e-06],
            "rel_diff": 2.1e-11,
        },
        # Its radius is that of the whole revolution, of which the teeth repeat after half.
        {
            **{"tool": "twice", "radial_immersion": 0.5, "direction": "down", "rpm": 5000, "depth_m": 0.0015},
            **{"feed_per_tooth_m": 0.0001, "runout_m": None, "spectral_radius": 0.3063422534},
            **{"x_min_m": -2.747514731e-06, "x_max_m": 5.303996408e-06, "peak_x_m": 5.303996408e-06},
            **{"y_min_m": -1.258018173e-05, "y_max_m": 2.723033009e-05, "peak_y_m": 2.723033009e-05},
            "y_at_surface_m": [-1.777794809e-06, 2.06996597e-05, -1.777794809e-06, 2.06996597e-05],
            "rel_diff": 1e-10,
        },
    ],
}


def compared(path, content, capsys):
    path.write_text(json.dumps({"conventions": {"general": "SI units"}} | content))
    code = references.main([str(path)])
    return code, [line.split() for line in capsys.readouterr().out.splitlines()[1:]]


def test_numbers_that_agree_and_one_that_does_not(tmp_path, capsys):
    code, rows = compared(tmp_path / "good.json", {"g": BLADE}, capsys)
    assert code == 0
    assert [row[:5] for row in rows] == [["g", "beam", "limit", "1", "0"], ["g", "beam", "mu", "2", "0"]]
    assert all(float(row[5]) < 1e-10 for row in rows)
    wrong = copy.deepcopy(BLADE)
    wrong["cases"][0]["points"][1]["mu"][1] *= 1 + 1e-6
    wrong["cases"][0]["critical_K"] *= 1 + 1e-6
    code, rows = compared(tmp_path / "wrong.json", {"g": wrong}, capsys)
    assert code == 1
    assert [row[3:5] for row in rows] == [["1", "1"], ["2", "1"]]
    assert rows[1][-1] == "K=13440"
    assert float(rows[0][5]) == pytest.approx(1e-6, rel=0.1)
    # What a case says its own number to be good to is enough.
    wrong["cases"][0]["rel_diff"] = 2e-6
    assert compared(tmp_path / "coarse.json", {"g": wrong}, capsys)[1][0][4] == "0"


@pytest.mark.slow
def test_motions_agree_to_the_digits_printed(tmp_path, capsys):
    code, rows = compared(tmp_path / "motion.json", {"f": MOTION}, capsys)
    assert code == 0
    assert rows[0][:4] == ["f", "straight", "2", "0"]
    assert float(rows[0][4]) < 2e-9


def test_what_cannot_be_expressed_is_counted_and_named(tmp_path, capsys):
    case = {"tool": "x922", "helix_deg": 30, "rpm": 12000, "depth_m": 5e-4, "mu": [-0.3764, 0.6615]}
    code, rows = compared(tmp_path / "new.json", {"new": {"cases": [case]}}, capsys)
    assert code == 1
    assert rows[0][:5] == ["new", "cases", "1", "-", "-"]
    assert " ".join(rows[0][5:]) == "not expressible: is a group without a builder"


def test_changes_of_another_number_order_or_kind_are_wrong():
    found = [(0.5, "unstable"), (0.7, "stable")]
    limit = type("Found", (), {"status": ["found"], "gain": [0.5], "kind": ["hopf"], "chatter_frequency": [80.0]})

    def error(*changes, **others):
        task = references.Limits("c", "", None, 1.0, (0.1, 1.0), 65, list(changes), None, 0.0, **others)
        return references.of_limit(task, found[: 1 if len(changes) < 2 else 2], limit, 0)

    assert error((0.5, "unstable", "hopf")) == 0
    assert error((0.5, "unstable", "flip")) == float("inf")
    assert error((0.5, "stable", "hopf")) == float("inf")
    assert error() == float("inf")
    assert error((0.5, "unstable", None), (0.7, "unstable", None)) == float("inf")
