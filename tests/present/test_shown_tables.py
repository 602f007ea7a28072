"""Tables of notebooks and of the page of a motion: each cell is the number of its row and head."""

from __future__ import annotations

import html
import re

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.present.run_page import run_page
from painleve_sym.present.style import event_label
from painleve_sym.study.scenario import Scenario

ROD = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


def plain(cell):
    """Return the text of a cell; a number with a power of ten as Python writes it."""
    text = re.sub(r"[\s\xa0]*·[\s\xa0]*10<sup>(.*?)</sup>", r"e\1", html.unescape(cell))
    return re.sub(r"<[^>]*>", "", text).strip().replace("\u2212", "-")


def tables(page):
    """Return the tables of HTML as lists of rows by head."""
    listed = []
    for table in re.findall(r"<table.*?</table>", page, re.S):
        head, *rows = [
            [plain(c) for c in re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, re.S)]
            for row in re.findall(r"<tr[^>]*>(.*?)</tr>", table, re.S)
        ]
        listed.append([dict(zip(head, row, strict=True)) for row in rows])
    return listed


def near(cell, value, digits=1e-5):
    return float(cell) == pytest.approx(value, rel=digits, abs=1e-300)


@pytest.fixture(scope="module")
def run():
    return ps.simulate("rod", "bilinear-hertz", ROD, t_end=0.01)


def test_a_notebook_shows_the_events_of_a_motion(run):
    (rows,) = tables(run._repr_html_())
    assert len(rows) == len(run.events) > 3
    for row, event in zip(rows, run.events, strict=True):
        assert near(row["time (s)"], event.time) and row["event"] == event.kind
        assert row["mode after"] == event.mode_after
        assert near(row["F_n (N)"], event.normal_force, 1e-3)
        assert near(row["F_t (N)"], event.tangential_force, 1e-3)
    forces = [(e.normal_force, e.tangential_force) for e in run.events]
    assert len(set(forces)) > 2 and all(n != t for n, t in forces[:2])


def test_a_notebook_shows_the_solutions_of_a_state():
    one = ps.classify("rod", {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0})
    (rows,) = tables(one._repr_html_())
    assert len(rows) == len(one.solutions) == 2
    for row, s in zip(rows, one.solutions, strict=True):
        assert row["mode"] == s.mode
        columns = ("F_n (N)", "F_t (N)", "a_n (m/s²)", "a_t (m/s²)")
        values = (s.normal_forces, s.tangential_forces)
        values += (s.normal_accelerations, s.tangential_accelerations)
        for name, value in zip(columns, values, strict=True):
            assert near(row[name], value.item()), name


def test_a_notebook_shows_the_phases_of_a_jump():
    jump = ps.evaluate_jump("rod", "poisson", {"theta": 1.0, "x_A_dot": -1.0, "y_A_dot": -0.2})
    phases, velocities = tables(jump._repr_html_())
    for row, phase in zip(phases, jump.phases, strict=True):
        shown = {
            "P_n (N s)": phase.normal_impulse,
            "P_t (N s)": phase.tangential_impulse[0],
            "energy gained (J)": phase.stored_energy,
            "v_t (m/s)": phase.slip_velocity[0],
            "v_n (m/s)": phase.normal_velocity,
        }
        assert row["phase"] == phase.name
        assert all(near(row[name], value) for name, value in shown.items())
    for row in velocities:
        assert near(row["before"], jump.velocity_before[row["velocity"]])
        assert near(row["after"], jump.velocity[row["velocity"]])


def test_a_notebook_shows_the_parameters_of_a_mechanism():
    rod = ps.models.rod(mu=1.25)
    _, parameters, _ = tables(rod._repr_html_())
    assert {row["parameter"]: float(row["default"]) for row in parameters} == rod.parameters


def test_the_page_of_a_motion_has_its_numbers(run):
    scenario = Scenario(
        "rod", law="bilinear-hertz", state=ROD, t_end=0.01, where="test"
    ).with_owned_parameters()
    page = tables(run_page(scenario, run).html())
    by_head = {tuple(rows[0]): rows for rows in page if rows}
    events = next(rows for head, rows in by_head.items() if head[:2] == ("time (s)", "event"))
    assert len(events) == len(run.events)
    for row, event in zip(events, run.events, strict=True):
        normal, tangential = (row[k] for k in list(row)[4:6])
        assert near(row["time (s)"], event.time, 1e-8) and row["event"] == event_label(event.kind)
        assert near(normal, event.normal_force) and near(tangential, event.tangential_force)
    ends = next(
        rows for head, rows in by_head.items() if head == ("symbol", "name", "value", "unit")
    )
    final = {**run.final, **run.final_outputs}
    for row in ends:
        assert float(row["value"]) == pytest.approx(final[row["name"]], rel=1e-8, abs=1e-12)
    given = next(rows for head, rows in by_head.items() if head[-1] == "meaning" and len(head) == 5)
    values = {row["name"]: float(row["value"]) for row in given}
    assert values.items() >= {**ROD, **run.parameters}.items()
    balance = next(rows for head, rows in by_head.items() if head[0] == "term (J)")
    terms = run.energies(np.array([0.0, run.final_time]))
    for row in balance:
        first, last = terms[row["term (J)"].replace(" ", "_")]
        assert near(row["start"], first, 1e-8) and near(row["end"], last, 1e-8)
        assert near(row["change"], last - first, 1e-8)
    text = plain(run_page(scenario, run).html())
    assert f"changes by {run.energy_residual:.2g} of" in text
