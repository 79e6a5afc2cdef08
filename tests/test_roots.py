"""The bracketed root finder where rounding leaves Newton's step no sense."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lobex._roots import bracketed_root


def cube(_, x):
    """x³ at its root, where the slope is zero."""
    return x**3, 3 * x**2


def hidden(_, x):
    """A zero to rounding whose slope points out of the bracket."""
    lib = np if isinstance(x, np.ndarray) else jnp
    near = lib.abs(x) < 0.125
    return lib.where(near, 1e-7, x), lib.where(near, -1.0, 1.0)


@pytest.mark.parametrize(("function", "start"), [(cube, 0.0), (hidden, 0.0625)])
def test_a_zero_to_rounding_is_kept_where_newton_s_step_would_leave_the_bracket(function, start):
    def root(first, last, start):
        return bracketed_root(function, (), first, last, True, start, 1e-6)

    ends = [np.float32([end]) for end in (-1.0, 3.0, start)]
    assert root(*ends) == pytest.approx([start], abs=1e-6)
    assert np.asarray(jax.jit(jax.vmap(root))(*ends)) == pytest.approx([start], abs=1e-6)


def test_lanes_end_each_in_their_own_time():
    """Roots of x² − a by Newton's method from far off, by bisection where the slope is none, and one not wanted."""

    def square(a, x):
        flat = a > 50.0
        return x**2 - a, (2 * x) * ~flat

    a = np.array([2.0, 1e-6, 90.0, 3.0])
    first, last, start = np.zeros(4), np.full(4, 10.0), np.array([9.0, 9.0, 9.0, 7.0])
    wanted = np.array([True, True, True, False])

    def root(*lanes):
        return bracketed_root(square, *lanes[:3], True, lanes[3], 1e-15, lanes[4])

    with jax.enable_x64(True):
        mapped = jax.jit(jax.vmap(root))(a, first, last, start, wanted)
    expected = np.append(np.sqrt(a[:3]), 7.0)
    np.testing.assert_allclose(root(a, first, last, start, wanted), expected, rtol=1e-14)
    np.testing.assert_allclose(mapped, expected, rtol=1e-14)
    assert root(*(part[:0] for part in (a, first, last, start, wanted))).shape == (0,)
