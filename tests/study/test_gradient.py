"""The gradient of the critical force through the events, against differences of bisections."""

from __future__ import annotations

import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, PainleveWarning
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.critical.bisection import Border, CriticalForceFinder
from painleve_sym.study.critical.gradient import critical_force_gradient
from tests.support.paper_law import paper_law

TABLE_4 = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
HARD = {"E": 20.9e14}


@pytest.fixture(scope="module")
def finder() -> CriticalForceFinder:
    return CriticalForceFinder(Simulator(model("rod"), paper_law(reload="virgin")))


@pytest.mark.parametrize("border", list(Border))
def test_both_methods_agree(finder, border):
    names = ["theta", "mu"]
    both = [
        critical_force_gradient(
            finder, TABLE_4, names, parameters=HARD, border=border, method=method
        )
        for method in ("differences", "sensitivities")
    ]
    for name in names:
        assert both[1][name].value == pytest.approx(both[0][name].value, rel=1e-6)
        assert both[1][name].error < 1e-5 * abs(both[1][name].value)


def test_an_unknown_method_is_named(finder):
    with pytest.raises(InputError, match="unknown method 'saltation'"):
        critical_force_gradient(finder, TABLE_4, ["mu"], parameters=HARD, method="saltation")
    with pytest.raises(InputError, match="unknown quantity 'thta'"):
        critical_force_gradient(finder, TABLE_4, ["thta"], parameters=HARD)


@pytest.mark.slow
def test_an_event_that_is_met_tangentially_is_named(finder):
    """At this stiffness the motion turns where it is next to the sliding solution."""
    soft = {"e_energetic": 1e-3, "E": 2e19}
    with (
        pytest.warns(PainleveWarning, match="'max_compression'.* is met tangentially"),
        pytest.raises(InputError, match="ends in max_compression without a derivative, need sep"),
    ):
        critical_force_gradient(finder, TABLE_4, ["mu"], parameters=soft, method="sensitivities")
