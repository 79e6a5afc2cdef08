"""Forces of a cut: their parts by an angle, the tangent of Kienzle's, and what edges push."""

import jax
import numpy as np
import pytest

import lobex
from problems import PLANE
from refusals import refused


def test_a_force_at_an_angle_has_both_its_parts():
    force = lobex.CuttingForce.from_angle(7e8, 68.0)
    assert float(np.hypot(force.tangential, force.normal)) == pytest.approx(7e8, rel=1e-14)
    assert float(force.tangential / force.normal) == pytest.approx(np.tan(np.radians(68.0)), rel=1e-12)
    assert force.edge is None


def test_kienzle_s_tangent_touches_the_force_at_the_mean_chip():
    chip, pair = 8e-5, {"tangential": (1.6e9, 0.25), "normal": (7e8, 0.4), "axial": (3e8, 0.0)}
    force = lobex.CuttingForce.kienzle(chip, **pair)
    for name, (size, exponent) in pair.items():
        # Specific forces are of a chip 1 mm thick.
        curve, step = lambda h, size=size, exponent=exponent: size * (h / 1e-3) ** -exponent * h, 1e-4 * chip
        slope = (curve(chip + step) - curve(chip - step)) / (2 * step)
        assert getattr(force, name) == pytest.approx(slope, rel=1e-7)
        assert getattr(force, name) * chip + getattr(force, f"{name}_edge") == pytest.approx(curve(chip), rel=1e-12)
    with jax.enable_x64(True):
        by_chip = jax.grad(lambda h: lobex.CuttingForce.kienzle(h, tangential=(1.6e9, 0.25), normal=(7e8, 0.4)).normal)
        assert float(by_chip(chip)) == pytest.approx(-0.4 * force.normal / chip, rel=1e-12)


def test_processes_take_a_force_in_place_of_its_numbers():
    force = lobex.CuttingForce(6e8, 2e8, axial=1e8, tangential_edge=2e4, normal_edge=1e4)
    by_force = lobex.Milling(PLANE, 4, force=force, radial_immersion=0.5)
    by_number = lobex.Milling(PLANE, 4, 6e8, 2e8, 0.5, axial=1e8, edge=[2e4, 1e4, 0.0])
    for found, given in zip(jax.tree.leaves(by_force), jax.tree.leaves(by_number), strict=True):
        assert np.asarray(found) == pytest.approx(np.asarray(given), rel=0)
    assert lobex.Turning(lobex.Modes.single(frequency=50.0, damping_ratio=0.1, mass=1.0), force=force).radial == 2e8


def test_edges_push_and_answer_no_motion():
    plain, edged = (
        lobex.Milling(PLANE, 4, 6e8, 2e8, 1.0, feed_per_tooth=1e-4, edge=edge) for edge in (None, [3e4, 1e4, 0])
    )
    phase = (np.arange(8) + 0.5) / 8
    with jax.enable_x64(True):
        systems = [process.system(50.0, 2e-3) for process in (plain, edged)]
        present = [np.asarray(system.at(phase).present) for system in systems]
        pushed = np.asarray(systems[1].forcing[0].coefficient.at(phase))[..., 0]
    assert len(systems[1].forcing) == len(systems[0].forcing) + 1
    assert present[0] == pytest.approx(present[1], rel=0)
    # Two teeth cut, a quarter of a turn apart.
    angle = np.pi / 2 * phase[:, None] + np.array([0.0, np.pi / 2])
    sine, cosine = np.sin(angle).sum(1), np.cos(angle).sum(1)
    wanted = -2e-3 * np.stack([3e4 * cosine + 1e4 * sine, 1e4 * cosine - 3e4 * sine], axis=1)
    assert pushed == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: lobex.CuttingForce(-6e8, 2e8), "tangential = -6e\\+08 must be positive"),
        (lambda: lobex.CuttingForce(6e8, 2e8, axial=[1.0, 2.0]), r"axial has shape \(2,\); give one number"),
        (lambda: lobex.CuttingForce(6e8, 2e8, normal_edge=np.inf), "normal_edge = inf has NaN or infinite"),
        (lambda: lobex.CuttingForce.from_angle(7e8, 95.0), "angle_degrees = 95; give the angle from the normal"),
        (
            lambda: lobex.CuttingForce.kienzle(0.0, tangential=(1e9, 0.2), normal=(1e9, 0.2)),
            "chip = 0 must be positive",
        ),
        (
            lambda: lobex.CuttingForce.kienzle(1e-4, tangential=(1e9, 1.2), normal=(1e9, 0.2)),
            r"tangential = .* give k_c1.1 in N/m², above 0, and m",
        ),
        (lambda: lobex.Milling(PLANE, 4, 6e8, 2e8, 0.5, force=lobex.CuttingForce(6e8, 2e8)), "force is given beside"),
        (lambda: lobex.Milling(PLANE, 4, radial_immersion=0.5, force=6e8), "force = .* give lobex.CuttingForce"),
        (lambda: lobex.Milling(PLANE, 4, 6e8, 2e8, 0.5, edge=[1.0, 2.0]), r"edge has shape \(2,\); give 3 numbers"),
        (lambda: lobex.Turning(PLANE), "radial = None, force = None: give one of them"),
    ],
)
def test_what_is_no_force_is_refused_in_one_line(call, message):
    with refused(match=message):
        call()
