"""Numbers as texts: three digits, units with prefixes, no power of ten."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from peg_on_hole_ros.number_text import NOT_DETERMINED, bounded, number, quantity


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (-0.0, "0"), (464.41, "464"), (10755.0, "10800"), (0.2, "0.2"),
        (0.0293, "0.0293"), (0.99961, "1"), (-3.456, "-3.46"), (np.float64(2.5), "2.5"),
        (None, NOT_DETERMINED), (float("nan"), NOT_DETERMINED), (float("inf"), NOT_DETERMINED),
    ],
)  # fmt: skip
def test_a_number_has_three_digits_and_no_power_of_ten(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (464.41, "N", "464 N"), (0.0354e-3, "rad", "0.0354 mrad"), (0.28, "N m", "0.28 N m"),
        (0.019, "N m", "0.019 N m"), (1e-4, "m", "0.1 mm"), (83e-6, "s", "83 us"),
        (8e-5, "Hz", "0.08 mHz"), (3.7e-10, "N", "0 mN"), (3.7e-10, "", "0"), (0.17, "", "0.17"),
        (1.4e3, "", "1400"), (None, "N", NOT_DETERMINED), (float("nan"), "N", NOT_DETERMINED),
    ],
)  # fmt: skip
def test_a_quantity_has_the_prefix_that_suits_it(value, unit, text):
    assert quantity(value, unit) == text


def test_a_bound_that_says_nothing_leaves_no_number():
    assert bounded(461.3, 187.0, "N") == "461 ± 190 N"
    assert bounded(2e-4, 1e-3, "rad") == "0.2 ± 1 mrad"
    assert bounded(0.4, 50.0, "rad", most=np.pi) == NOT_DETERMINED
    assert bounded(0.4, float("inf"), "rad") == NOT_DETERMINED
    assert bounded(0.4, None, "rad") == NOT_DETERMINED


# Above, a float is no exact integer of three digits and zeros.
@given(st.floats(-1e15, 1e15), st.sampled_from(["", "N", "m", "rad"]))
def test_whatever_its_size_it_is_read_at_a_glance(value, unit):
    text = quantity(value, unit)
    assert re.fullmatch(r"-?\d+(\.\d+)?( m?u?(N|m|rad))?", text), text
    digits = re.sub(r"[^\d]", "", text.split()[0]).strip("0")
    assert len(digits) <= 3
