"""The bracketed root finder where rounding leaves Newton's step no sense."""

import jax.numpy as jnp
import pytest

from lobex._roots import bracketed_root


@pytest.mark.parametrize(
    ("value", "slope", "start"),
    [
        # x³ at its root, where the slope is zero; and a zero to rounding whose slope points out of the bracket.
        (lambda x: x**3, lambda x: 3 * x**2, 0.0),
        (lambda x: jnp.where(jnp.abs(x) < 0.125, 1e-7, x), lambda x: jnp.where(jnp.abs(x) < 0.125, -1.0, 1.0), 0.0625),
    ],
)
def test_a_zero_to_rounding_is_kept_where_newton_s_step_would_leave_the_bracket(value, slope, start):
    root = bracketed_root(
        lambda x: (value(x), slope(x)),
        *(jnp.float32(end) for end in (-1.0, 3.0)),
        rising=jnp.asarray(True),
        start=jnp.float32(start),
        tolerance=jnp.float32(1e-6),
    )
    assert float(root) == pytest.approx(start, abs=1e-6)
