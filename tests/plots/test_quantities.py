from __future__ import annotations

import pytest

from modelgen.plots.quantities import axis_label, definition, display, quantity_text, written


@pytest.mark.parametrize(
    ("unit", "largest", "shown", "factor"),
    [
        ("rad", 1e-4, "°", 57.29577951308232),
        ("N*m", 24134.0, "kN·m", 1e-3),
        ("N*m/rad", 1.05e7, "MN·m/rad", 1e-6),
        ("N/m", 2.46e9, "GN/m", 1e-9),
        ("m", 7.5e-5, "\N{MICRO SIGN}m", 1e6),
        ("m", 0.9999e-3, "mm", 1e3),
        ("m", 1e-15, "nm", 1e9),
        ("kg*m^2", 95e3, "kg·m²", 1.0),
        ("rad/s^2", 1e5, "rad/s²", 1.0),
        ("1", 1e5, "-", 1.0),
        ("J", 0.0, "J", 1.0),
        ("m^2", 1e-6, "m²", 1.0),
    ],
)
def test_units_suit_the_size(unit: str, largest: float, shown: str, factor: float) -> None:
    found = display(unit, largest)
    assert (found.unit, found.factor) == (shown, pytest.approx(factor))


def test_labels_say_what_and_in_which_unit() -> None:
    assert axis_label("coupling.twist", "°") == r"$\theta_a-\theta_b$ [°]"
    assert axis_label("pump.oil_film", "K") == "oil film [K]"
    assert definition("pump_mesh.force") == "mesh force along the line of action"
    assert definition("pump.oil_film") == "oil film"
    assert quantity_text(0.5, "1") == "0.5"
    assert written("N*m*s/rad") == "N·m·s/rad"
