"""Cases at arrays of states: those of each state alone, of all kinds of mechanisms."""

from __future__ import annotations

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.errors import InputError

SMALL = (-1.0, 0.0, 1.0)


def alone(mechanism, state, parameters):
    """Return the case of one state, and what its error says instead."""
    try:
        return ps.classify(mechanism, state, parameters=parameters).case.value
    except InputError as error:
        return str(error)


SAID = {
    "inside": "starts inside the ground",
    "impact": "",
    "apart": "",
    "outside": "need ",
}
"""Part of the message of `classify` for states that have no contact problem."""


FRICTION = (0.0, 0.5, 1.5, 3.0)
CASES = {
    "rod": {"theta": (0.0, 0.5, 1.0, np.pi / 2, 4.0), "y_A": (0.0, 0.0, -0.1, 0.1)},
    "block-two-feet": {
        **{"theta": (0.0, 0.0, 0.1), "theta_dot": (0.0,)},
        **{"x_A_dot": SMALL, "y_A_dot": (0.0, 0.0, -1.0, 1.0)},
    },
    "painleve-klein": {"phi": (1.2,), "phi_dot": (0.0,), "x_dot": SMALL},
    "rod-3d": {"theta": (0.5, 1.0), "x_A_dot": SMALL, "y_A_dot": SMALL},
    "examples/mechanisms/tumbling-brick.toml": {},
}


@pytest.mark.parametrize("name", CASES)
def test_every_state_has_the_case_that_it_has_alone(name):
    states, n = CASES[name], 40
    mechanism, rng = ps.model(name), np.random.default_rng(7)
    rates = [v for v in mechanism.outline.velocity_names if v not in states]
    drawn = {v: rng.choice(SMALL, n) for v in rates if not v.startswith(("y", "z"))}
    drawn |= {v: rng.choice(values, n) for v, values in states.items()}
    drawn = mechanism.start | drawn if "toml" in name else drawn
    coefficients = [p for p in mechanism.parameters if p.startswith("mu")]
    given = {p: rng.choice(FRICTION, n) for p in coefficients}
    table = ps.classify_batch(mechanism, drawn, parameters=given)
    rows = {v: np.broadcast_to(a, n) for v, a in (drawn | given).items()}
    for i, case in enumerate(table["case"].tolist()):
        own = {v: float(a[i]) for v, a in rows.items()}
        state = {v: own[v] for v in drawn}
        single = alone(mechanism, state, {p: own[p] for p in given})
        assert single == case or (case in SAID and SAID[case] in single and " " in single), (i, own)
    assert len(set(table["case"].tolist())) > 1


def test_coefficients_are_those_of_each_classification():
    start = {"theta": [0.5, 1.0, 1.2], "theta_dot": [1.0, 5.0, 0.0], "x_A_dot": [-1.0, -1.0, 1.0]}
    table = ps.classify_batch("rod", start, parameters={"mu": 1.5})
    for i, one in enumerate(table):
        assert one == table[i] == ps.classify("rod", table_row(start, i), parameters={"mu": 1.5})
        for name in ("A", "B", "A_stick", "B_stick"):
            assert table[name][i] == pytest.approx(getattr(one, name), rel=1e-14)
    assert len(table) == 3 and table.counts() == {"slip": 2, "indeterminate": 1}


def table_row(start, i):
    return {name: values[i] for name, values in start.items()}


def test_arrays_broadcast_and_close_each_state():
    start = {"theta": np.linspace(0.3, 1.2, 4)[:, None], "theta_dot": [1.0, 2.0], "x_A_dot": -1.0}
    table = ps.classify_batch("rod", start | {"y_A": 0.3}, close="y_A")
    assert table.shape == table["case"].shape == (4, 2)
    assert (table["gap"] == 0).all() and (table.inputs["y_A"] == 0).all()
    assert table[2, 1].state["theta"] == start["theta"][2, 0]


def test_a_large_table_is_one_evaluation(monkeypatch):
    def refuse(*_):
        raise AssertionError("a state was classified alone")

    monkeypatch.setattr("painleve_sym.at.classification_table._case_of_row", refuse)
    n = 20_000
    rng = np.random.default_rng(3)
    start = {"theta": rng.uniform(0.2, 1.4, n), "theta_dot": rng.normal(size=n), "x_A_dot": -1.0}
    counts = ps.classify_batch("rod", start, parameters={"mu": 1.6}).counts()
    assert sum(counts.values()) == n and {"slip", "inconsistent"} <= set(counts)


def test_a_data_frame_has_what_varies_and_every_quantity():
    pytest.importorskip("pandas")
    table = ps.classify_batch("block-two-feet", {"x_A_dot": [1.0, -1.0]})
    frame = table.to_dataframe()
    assert frame.columns[0] == "x_A_dot" and {"case", "gap_A", "slip_velocity_B"} <= set(
        frame.columns
    )
    assert frame.attrs["units"]["slip_velocity_B"] == "m/s" and len(frame) == 2
    assert table.to_dataframe("case").columns.tolist() == ["x_A_dot", "case"]


def test_wrong_input_is_one_sentence():
    with pytest.raises(InputError, match="arrays of states are for classify_batch"):
        ps.classify("rod", {"theta": np.array([0.5, 1.0])})
    with pytest.raises(InputError, match="unknown state 'thta'"):
        ps.classify_batch("rod", {"thta": [1.0]})
    with pytest.raises(InputError, match="shapes do not fit"):
        ps.classify_batch("rod", {"theta": [1.0, 2.0], "theta_dot": [1.0, 2.0, 3.0]})
    table = ps.classify_batch("rod", {"theta": [1.0, 1.1], "y_A": [0.0, 1.0]})
    assert table["case"].tolist()[1] == "apart"
    with pytest.raises(InputError, match="the contact is open, gap = 1 m"):
        table[1]
    for wrong in (2, "thta", 1.5, slice(None)):
        with pytest.raises(InputError):
            table[wrong]
