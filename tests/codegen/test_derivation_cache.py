"""The derivation cache: exact reuse, and a new derivation after a change or damage."""

from __future__ import annotations

import functools
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
import sympy as sp

from painleve_sym import cache as caching
from painleve_sym.at.cases import classify
from painleve_sym.at.delassus import Delassus
from painleve_sym.automata.automaton import Choice, HybridAutomaton, Mode
from painleve_sym.automata.compliant import CompliantContact
from painleve_sym.automata.derivation import ContactDerivation
from painleve_sym.automata.rigid import RigidContact
from painleve_sym.automata.signature import Outline
from painleve_sym.cache import read_entry, write_entry
from painleve_sym.codegen import derivation_cache, quantities
from painleve_sym.codegen.compile import compiler_mark
from painleve_sym.codegen.derivation_cache import entry_key
from painleve_sym.engines import source
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.factory import make_engine
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.errors import CompilerMissing
from painleve_sym.laws.catalogue import law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import LagrangianSystem
from painleve_sym.motion.runs import simulate_batch
from painleve_sym.motion.simulator import Simulator
from painleve_sym.plain_data import of_plain, to_plain

Y = Coordinate("y", "height", "m")
X = Coordinate("x", "place", "m")
M = Parameter("m", 1.0, "kg", "mass", 0.0, lower_closed=False)
MU = Parameter("mu", 0.3, "1", "friction", 0.0)
G = Parameter("g", 9.8, "m/s^2", "gravity", 0.0)
START = {"x_dot": 1.0, "y": 0.01}


def sledge(kinetic=None, potential=None, forces=None, parameters=(M, MU, G), gap=None):
    """Return a mass point above level ground, some part of it changed."""
    x_dot, y_dot = X.rate, Y.rate
    system = LagrangianSystem(
        "sledge",
        (X, Y),
        parameters,
        M.symbol * (x_dot**2 + y_dot**2) / 2 if kinetic is None else kinetic,
        M.symbol * G.symbol * Y.symbol if potential is None else potential,
        forces or {},
    )
    contact = Contact("foot", system, Y.symbol if gap is None else gap, x_dot, MU.symbol)
    return Mechanism("sledge", "", "", system, (contact,))


@pytest.fixture
def cache(cache):
    quantities._stored.cache_clear()
    yield cache
    quantities._stored.cache_clear()


def entries(cache):
    return sorted(cache.glob("*.json"))


def simulators():
    softened = Simulator(sledge(), law("hertz"))
    return (softened, Simulator(sledge(), RigidLaw("newton")))


def softened_run():
    return simulators()[0].run(START, t_end=0.2)


def rigid_run():
    return simulators()[1].run(START, t_end=0.2)


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    """Return a function that calls another one once, in an empty cache, and copies that cache."""

    @functools.cache
    def once(first):
        folder = tmp_path_factory.mktemp("filled") / "cache"
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("PAINLEVE_CACHE", str(folder))
            quantities._stored.cache_clear()
            return folder, first()

    def result(first, cache):
        folder, result = once(first)
        shutil.copytree(folder, cache)
        quantities._stored.cache_clear()
        return result

    return result


def without_derivation(monkeypatch):
    """Let every derivation fail, here and in what it begins with."""

    def refuse(*_):
        raise AssertionError("this should have come from the cache")

    for kind in (CompliantContact, RigidContact):
        monkeypatch.setattr(kind, "automaton", property(refuse))
    monkeypatch.setattr(Mechanism, "coefficients", property(refuse))
    monkeypatch.setattr(LagrangianSystem, "mass_matrix", property(refuse))
    monkeypatch.setattr(source, "source", refuse)
    quantities._stored.cache_clear()


@pytest.mark.parametrize("run", [softened_run, rigid_run])
def test_second_time_nothing_is_derived_and_every_bit_is_the_same(cache, filled, monkeypatch, run):
    first = filled(run, cache)
    without_derivation(monkeypatch)
    again = run()
    assert first.events
    assert again.events == first.events
    for name in ("step_time", "step_rows", "step_memory", "step_mode", "final_state", "constants"):
        assert np.array_equal(getattr(again, name), getattr(first, name)), name
    assert again.counters == first.counters
    times = np.linspace(0, 0.2, 31)
    assert np.array_equal(
        again.outputs(times)["kinetic_energy"], first.outputs(times)["kinetic_energy"]
    )
    for name in ("state_names", "memory_names", "mode_names", "output_names", "stop_reason"):
        assert getattr(again, name) == getattr(first, name), name


def test_second_time_a_state_is_classified_without_derivation(cache, monkeypatch):
    state = {"x_dot": 1.0}
    first = classify(sledge(), state)
    without_derivation(monkeypatch)
    assert classify(sledge(), state).to_dict() == first.to_dict()


def test_second_time_nothing_is_derived_where_there_is_no_series(cache, monkeypatch):
    bent = sledge(forces={"x": -sp.Abs(X.rate) * X.rate})

    def run():
        simulator = Simulator(bent, law("hertz"))
        return simulator, simulator.run(START, t_end=0.05)

    _, first = run()
    assert first.engine == "compiled"
    without_derivation(monkeypatch)
    assert np.array_equal(run()[1].final_state, first.final_state)


@pytest.mark.parametrize("kind", [TaylorEngine, CompiledEngine])
def test_second_time_the_c_of_an_engine_is_not_derived(cache, monkeypatch, kind):
    first = [kind.code_of(s.contact) for s in simulators()]
    without_derivation(monkeypatch)
    assert [kind.code_of(s.contact) for s in simulators()] == first


def test_batch_after_a_run_derives_nothing(cache, filled, monkeypatch):
    filled(softened_run, cache)
    without_derivation(monkeypatch)
    batch = simulate_batch(sledge(), law("hertz"), {"x_dot": [1.0, 2.0], "y": 0.01}, t_end=0.01)
    assert batch["stop_reason"].tolist() == ["t_end", "t_end"]


def test_coefficients_stay_at_hand_beside_a_cached_engine(cache, filled):
    filled(softened_run, cache)
    simulator = simulators()[0]
    simulator.run(START, t_end=0.01)
    assert simulator.mechanism.coefficients.W_nn == 1 / M.symbol
    outline = Outline.of(simulator.automaton)
    assert simulator.outline == outline
    assert of_plain(Outline, json.loads(json.dumps(to_plain(outline)))) == outline


def changed():
    y, y_dot, m = Y.symbol, Y.rate, M.symbol
    return {
        "T": sledge(kinetic=m * (X.rate**2 + 2 * y_dot**2) / 2),
        "V": sledge(potential=m * G.symbol * y + y**2),
        "Q": sledge(forces={"x": -X.rate}),
        "gap": sledge(gap=y - sp.Rational(1, 8)),
        "name": replace(sledge(), name="sleigh"),
    }


@pytest.mark.parametrize("part", changed())
def test_key_changes_with_the_mechanism(part):
    keys = {
        entry_key("engine", ContactDerivation(m, (law("hertz"),)))
        for m in (sledge(), changed()[part])
    }
    assert len(keys) == 2


def test_key_does_not_change_with_the_default_of_a_parameter():
    other = Parameter("m", 2.0, "kg", "mass", 0.0, lower_closed=False)
    alike = [sledge(), sledge(parameters=(other, MU, G)), sledge().with_parameters(mu=0.1)]
    assert len({entry_key("engine", ContactDerivation(m, (law("hertz"),))) for m in alike}) == 1


def test_key_changes_with_the_law_and_its_choices():
    builders = [
        ContactDerivation(sledge(), (law(n),)) for n in ("hertz", "linear", "bilinear-hertz")
    ]
    builders.append(ContactDerivation(sledge(), (law("bilinear-hertz", reload="elastic"),)))
    builders.append(ContactDerivation(sledge(), (law("bilinear-hertz", reload="virgin"),)))
    builders += [
        ContactDerivation(sledge(), (RigidLaw(restitution, policy),))
        for restitution in ("newton", "poisson", "energetic")
        for policy in ("liftoff", "slip", "impact")
    ]
    keys = [entry_key("engine", b) for b in builders]
    # One of the reload rules is the default.
    assert len(set(keys)) == len(keys) - 1
    assert entry_key("engine", ContactDerivation(sledge(), (law("hertz"),))) == keys[0]


def test_thing_without_a_definition_has_no_key():
    assert entry_key("engine", lambda: None) is None


def test_builder_without_a_definition_is_derived_each_time(cache):
    class Bare:
        title = "sledge on a Hertz contact"
        automaton = ContactDerivation(sledge(), (law("hertz"),)).automaton

    assert make_engine(Bare()).outline == Outline.of(Bare.automaton)
    assert entries(cache) == []


DAMAGES = {
    "empty": lambda text: b"",
    "half": lambda text: text[: len(text) // 2],
    "flipped": lambda text: text[:-40] + bytes([text[-40] ^ 1]) + text[-39:],
    "no text": lambda text: b"\xff\xfe" + text,
    "other": lambda text: b"{}",
}


@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(d, id=n, marks=() if n in ("half", "flipped") else pytest.mark.slow)
        for n, d in DAMAGES.items()
    ],
)
def test_damaged_entry_is_made_anew(cache, filled, damage):
    first = filled(softened_run, cache)
    numbers = Delassus.of(sledge()).contact_quantities
    whole = {path: path.read_bytes() for path in entries(cache)}
    assert len(whole) == 3  # the engine and its C, the numbers of its contact
    for path, text in whole.items():
        path.write_bytes(damage(text))
    quantities._stored.cache_clear()
    again = softened_run()
    assert np.array_equal(again.final_state, first.final_state)
    assert Delassus.of(sledge()).contact_quantities.names == numbers.names
    assert {path: path.read_bytes() for path in entries(cache)} == whole


@dataclass(frozen=True)
class Decay:
    """A builder of the smallest automaton there is: quick to compile."""

    rate: int
    title: ClassVar[str] = "decay"

    @property
    def automaton(self):
        mode = Mode("decay", {Y.symbol: -self.rate * Y.symbol}, (), {"height": Y.symbol})
        return HybridAutomaton("decay", (Y.symbol,), (), (), {}, (mode,), (Choice("decay"),))

    def end(self):
        options = RunOptions(1.0, 1e-11, np.array([1e-11]))
        run = CompiledEngine.of_builder(self).run(np.ones(1), np.empty(0), options)
        return float(run.state[0])


def test_any_builder_that_is_a_dataclass_is_known_again(cache, monkeypatch):
    ends = [Decay(rate).end() for rate in (1, 2)]
    assert ends == pytest.approx(np.exp([-1, -2]), rel=1e-9)
    monkeypatch.setattr(Decay, "automaton", None)
    assert [Decay(rate).end() for rate in (1, 2)] == ends


def decay():
    return Decay(1).end()


def gone(path):
    path.unlink()


def broken(path):
    path.unlink()
    path.write_bytes(b"\x7fELF")


@pytest.mark.parametrize("damage", [gone, broken])
def test_library_that_is_gone_or_damaged_is_compiled_anew(cache, filled, damage):
    filled(decay, cache)
    first = decay()
    (library,) = cache.glob("*.so")
    # In its place, not over it: this process still runs the first one.
    damage(library)
    assert decay() == first
    (again,) = cache.glob("*.so")
    assert again.stat().st_size > 1000


def test_entry_of_another_compiler_is_not_used(cache, filled, tmp_path, monkeypatch):
    filled(decay, cache)
    mark = compiler_mark()
    own = tmp_path / "own-cc"
    own.write_text('#!/bin/sh\nexec cc "$@"\n')
    own.chmod(0o755)
    monkeypatch.setenv("CC", str(own))
    assert compiler_mark() != mark
    decay()
    assert len(entries(cache)) == 3  # one C, two libraries


def test_no_compiler_is_told_also_where_the_cache_has_the_engine(cache, filled, monkeypatch):
    filled(decay, cache)
    monkeypatch.setenv("CC", "/nonexistent/cc")
    assert compiler_mark() is None
    with pytest.raises(CompilerMissing, match="/nonexistent/cc"):
        decay()


def test_entry_comes_back_as_it_was_and_leaves_nothing_beside_it(cache):
    entry = {"number": 0.1, "names": ["a", "ä"], "none": None}
    write_entry("k" * 40, entry)
    assert read_entry("k" * 40) == entry
    assert [p.name for p in cache.iterdir()] == ["painleve-" + "k" * 40 + ".json"]
    assert read_entry("l" * 40) is None


def test_cache_that_cannot_be_written_is_no_failure(cache, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    write_entry("k" * 40, {})
    assert list(cache.iterdir()) == []


RACE = """
import sys, pathlib, time
from painleve_sym import model, law, Simulator
mine, other = map(pathlib.Path, sys.argv[1:])
mine.touch()
while not other.exists():
    time.sleep(0.001)
block = Simulator(model("block"), law("linear"))
end = block.run({"x_A_dot": 1.0, "theta": 0.5}, t_end=1e-3)
print(end.final_state.tobytes().hex())
"""


@pytest.mark.slow
def test_two_processes_may_derive_at_once(cache, tmp_path):
    marks = [str(tmp_path / "a"), str(tmp_path / "b")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    running = [
        subprocess.Popen(
            [sys.executable, "-c", RACE, *pair], env=environment, stdout=subprocess.PIPE
        )
        for pair in (marks, marks[::-1])
    ]
    ends = {process.communicate(timeout=280)[0] for process in running}
    assert [process.returncode for process in running] == [0, 0]
    assert len(ends) == 1
    assert len(entries(cache)) == 3  # the description of the named mechanism, the engine, its C
    assert all(read_entry(path.stem.removeprefix("painleve-")) for path in entries(cache))


def test_entry_depends_on_the_folders_that_derive_it(monkeypatch):
    changed = dict.fromkeys(("mechanics", "automata", "engines", "motion"), "")
    monkeypatch.setattr(caching, "code_mark", lambda folder: changed.get(folder, folder))
    of = {
        "mechanism": derivation_cache.MECHANISM,
        "formulas": derivation_cache.FORMULAS,
        "engine": derivation_cache.ENGINE,
    }
    deriving = {
        "mechanics": {"mechanism", "formulas", "engine"},
        "automata": {"formulas", "engine"},
        "engines": {"engine"},
        "motion": set(),
    }
    keys = {name: entry_key("title", by=folders) for name, folders in of.items()}
    for folder, again in deriving.items():
        monkeypatch.setitem(changed, folder, "changed")
        others = {name for name in of if entry_key("title", by=of[name]) != keys[name]}
        monkeypatch.setitem(changed, folder, "")
        assert others == again, folder
