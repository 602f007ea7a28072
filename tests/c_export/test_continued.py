"""Motions of an export that are cut and continued: they equal Python's, and the motion not cut."""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import painleve_sym as ps
from painleve_sym.codegen.compile import find_compiler
from tests.support.exports import address, run

EXAMPLES = Path(__file__).parents[2] / "examples" / "mechanisms"
SLIDING = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
FALLING = {"y_A": 0.1, "theta": 0.9}
TWO_FEET = {"y_A": 0.01, "theta": 0.02, "x_A_dot": 1.0}
SHAKEN = str(EXAMPLES / "oscillating-table.toml")
MOTIONS = {
    "compliant": ("rod", "bilinear-hertz", SLIDING, 0.02),
    "rigid": ("rod", "rigid", FALLING, 0.5),
    "time": (SHAKEN, "rigid", {"y": 0.05, "x_dot": 0.3, "t": 0.02}, 0.3),
    "rigid feet": ("block-two-feet", "rigid", TWO_FEET, 0.4),
    "both kinds": ("block-two-feet", {"A": "rigid", "B": "hertz"}, TWO_FEET, 0.1),
}
SLOW = ("time", "rigid feet", "both kinds")


class Exported:
    """An export as a shared library, with the structures of its header."""

    def __init__(self, done):
        flags = ("-O0", "-march=native", "-ffp-contract=off", "-fPIC", "-shared")
        sources = sorted(done.folder.glob(f"{done.name}_*.c"))
        run(*find_compiler().command, *flags, "-o", "mine.so", *sources, "-lm", cwd=done.folder)
        self.name, self.trajectory = done.name, done.trajectory
        self.c = ctypes.CDLL(str(done.folder / "mine.so"))
        names = self.trajectory.names
        nx, nz, no = len(names.states), len(names.memory), len(names.outputs)
        kinds = len(self.trajectory.record.simulator.outline.kinds)
        double, long, integer = ctypes.c_double, ctypes.c_long, ctypes.c_int

        class Options(ctypes.Structure):
            _fields_ = (
                *((n, double) for n in ("t_start", "t_end", "rtol")),
                ("atol", double * nx),
                *((n, double) for n in ("first_step", "max_step")),
                *((n, long) for n in ("max_steps", "max_events")),
                ("until", ctypes.c_ubyte * kinds),
                ("keep_steps", integer),
            )

        class Run(ctypes.Structure):
            _fields_ = (
                ("time", double),
                *((n, integer) for n in ("mode", "stop")),
                ("state", double * nx),
                ("memory", double * max(1, nz)),
                ("outputs", double * no),
                *((n, long) for n in ("accepted", "rejected", "fields", "event_count")),
            )

        for name in ("simulate", "simulate_from"):
            getattr(self.c, f"{self.name}_{name}").restype = ctypes.POINTER(Run)
        self.options, self.kept = Options(), Run
        order = self.trajectory.record.simulator.outline.parameter_names
        self.p = np.array([self.trajectory.parameters[name] for name in order])
        self.x = np.array(self.trajectory.record.start.state)

    def call(self, name, *arguments):
        return getattr(self.c, f"{self.name}_{name}")(*arguments)

    def begin(self, t_end):
        """Set the options that the package takes from the start."""
        end, rtol = ctypes.c_double(t_end), ctypes.c_double(self.trajectory.rtol)
        options = ctypes.byref(self.options)
        self.call("default_options", address(self.p), address(self.x), end, rtol, options)

    def simulated(self, t_end):
        self.options.t_start, self.options.t_end = 0.0, t_end
        return self._copied("simulate", address(self.p), address(self.x))

    def from_end(self, before, t_end, inputs=None, p=None):
        self.options.t_start, self.options.t_end = before.time, t_end
        u = None if inputs is None else address(np.array(inputs))
        p = self.p if p is None else p
        place = address(p), before.state, before.memory, before.mode, u
        return self._copied("simulate_from", *place)

    def _copied(self, name, *arguments):
        ran = self.call(name, *arguments, ctypes.byref(self.options))
        copy = self.kept.from_buffer_copy(ran.contents)
        self.call("free", ran)
        return copy


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return a function that exports and compiles a motion, each once."""

    @functools.cache
    def library_of(name, inputs=()):
        mechanism, law, state, t_end = MOTIONS[name]
        folder = tmp_path_factory.mktemp("c") / "c"
        done = ps.export_c(
            mechanism, law, state, folder=folder, name="mine", t_end=t_end, inputs=inputs
        )
        return Exported(done)

    return library_of


def assert_same(c, trajectory):
    """Check that a run of C is one of the package, to the last bit."""
    assert c.time == trajectory.final_time
    if len(trajectory.names.contacts) == 1:  # else what contacts do is in the memory
        assert c.mode == trajectory.final_mode
    assert list(c.state) == trajectory.final_state.tolist()
    assert list(c.memory)[: len(trajectory.final_memory)] == trajectory.final_memory.tolist()
    assert c.event_count == len(trajectory.events)


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n in SLOW else ()) for n in MOTIONS]
)
@settings(max_examples=4)
@given(part=st.floats(0.02, 0.98))
def test_a_motion_cut_anywhere_and_continued_in_c_is_pythons_and_the_whole_one(
    exported, name, part
):
    c, (mechanism, law, state, t_end) = exported(name), MOTIONS[name]
    c.begin(t_end)
    first = c.simulated(part * t_end)
    rest = c.from_end(first, t_end)
    python = ps.simulate(mechanism, law, state, t_end=part * t_end)
    assert_same(first, python)
    assert_same(rest, python.continued(t_end))
    whole = c.trajectory.final_state
    scale = np.maximum(np.abs(whole), 1e-3)
    assert rest.time == t_end
    assert np.max(np.abs(np.array(rest.state) - whole) / scale) < 1e-7


def test_an_input_is_held_in_place_of_the_parameter(exported):
    """Inputs that are the parameters change nothing; others are Python's changed parameters."""
    c, (mechanism, law, state, t_end) = exported("rigid", ("mu", "g")), MOTIONS["rigid"]
    c.begin(t_end)
    first = c.simulated(0.2)
    python = ps.simulate(mechanism, law, state, t_end=0.2)
    mu, g = (c.trajectory.parameters[name] for name in ("mu", "g"))
    assert_same(c.from_end(first, t_end, inputs=[mu, g]), python.continued(t_end))
    other = python.continued(t_end, parameters={"g": 2.0 * g}, atol=np.array(c.options.atol))
    assert_same(c.from_end(first, t_end, inputs=[mu, 2.0 * g]), other)
    assert c.from_end(first, t_end).state[:] == c.from_end(first, t_end, inputs=[mu, g]).state[:]


def test_no_step_is_what_happens_at_the_start(exported):
    c = exported("rigid")
    c.begin(0.5)
    c.options.max_steps = 0
    start = c.simulated(0.5)
    assert start.time == 0 and list(start.state) == c.x.tolist() and start.accepted == 0
    assert c.trajectory.mode_names[start.mode] == "flight"


def test_other_parameters_move_gaps_and_slips_of_an_export(tmp_path):
    """A belt that runs faster from a cut on, as in Python; its direction may not turn."""
    belt = str(EXAMPLES / "belt-oscillator.toml")
    c = Exported(ps.export_c(belt, "rigid", folder=tmp_path / "c", name="mine", t_end=0.6))
    c.begin(0.6)
    first = c.simulated(0.5)
    p, x = c.p.copy(), np.array(first.state)
    names = list(c.trajectory.parameters)
    p[names.index("u")] = 0.4
    assert c.call("change_parameters", address(c.p), address(p), address(x)) == -1
    first.state[:] = x.tolist()
    atol = np.array(c.options.atol)
    python = ps.simulate(belt, "rigid", t_end=0.5).continued(0.6, parameters={"u": 0.4}, atol=atol)
    assert_same(c.from_end(first, 0.6, p=p), python)
    p[names.index("u")] = -1.0
    before = x.copy()
    assert c.call("change_parameters", address(c.p), address(p), address(x)) == 0
    assert x.tolist() == before.tolist()


@pytest.mark.parametrize(
    ("inputs", "sentence"),
    [
        (["nu"], "unknown parameter 'nu'"),
        (["mu", "mu"], "need each parameter once"),
        ([1], "inputs: got"),
    ],
)
def test_inputs_that_are_no_parameters_are_one_sentence(tmp_path, inputs, sentence):
    with pytest.raises(ps.InputError, match=sentence):
        ps.export_c("rod", "rigid", folder=tmp_path / "c", inputs=inputs)
    assert list(tmp_path.iterdir()) == []
