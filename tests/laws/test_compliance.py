"""Compression laws: energy balance on every branch, continuity at every exit, the paper's work."""

from __future__ import annotations

import dataclasses
import math

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.errors import InputError, ModelError
from painleve_sym.laws.catalogue import COMPLIANT_LAWS, law
from painleve_sym.laws.compliance import (
    DELTA,
    DELTA_DOT,
    DELTA_MAX,
    K_E,
    SEPARATED,
    Branch,
    Exit,
    hertz_stiffness,
    ramp,
    without_ramps,
)
from painleve_sym.laws.compliant_laws import bilinear_hertz, hertz
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.mechanics.simplify import readable

D, D_MAX = sp.symbols("D D_max", positive=True)
VARIANTS = [law(name) for name in COMPLIANT_LAWS]
VARIANTS += [law(name, reload="virgin") for name in COMPLIANT_LAWS if name.startswith("bilinear")]
IDS = ["-".join((v.name, *v.choices.values())) for v in VARIANTS]
BRANCHES = [(v, b) for v in VARIANTS for b in v.branches]
BRANCH_IDS = [f"{i}-{b.name}" for v, i in zip(VARIANTS, IDS, strict=True) for b in v.branches]
EXITS = [(v, b, e) for v in VARIANTS for b in v.branches for e in b.exits]
EXIT_IDS = [
    f"{i}-{b.name}-{k}-{e.kind}"
    for v, i in zip(VARIANTS, IDS, strict=True)
    for b in v.branches
    for k, e in enumerate(b.exits)
]


def _plain(expr: sp.Expr, contact_law: ContactLaw) -> sp.Expr:
    """Return an expression inside the contact, with e² for its floored definition."""
    known = {}
    for symbol, value in contact_law.definitions.items():
        if isinstance(value, sp.Max):
            known[symbol] = next(part for part in value.args if not part.is_number)
        elif value.is_Symbol:
            known[symbol] = value
    return without_ramps(sp.sympify(expr)).subs(known).subs({DELTA: D, DELTA_MAX: D_MAX})


def _zero(expr: sp.Expr) -> bool:
    return sp.simplify(sp.powsimp(sp.expand(sp.simplify(expr)))) == 0


@pytest.mark.parametrize(("contact_law", "branch"), BRANCHES, ids=BRANCH_IDS)
def test_branch_power_is_stored_or_dissipated(contact_law, branch):
    force, stored, lost = (
        _plain(e, contact_law)
        for e in (branch.force, branch.stored_energy, branch.dissipated_power)
    )
    assert _zero(force * DELTA_DOT - sp.diff(stored, D) * DELTA_DOT - lost)


def _at_exit(exit_: Exit, contact_law: ContactLaw) -> list[dict[sp.Symbol, sp.Expr]]:
    """Return the values at which the guard vanishes."""
    guard = _plain(exit_.guard, contact_law)
    unknown = DELTA_DOT if guard.has(DELTA_DOT) else D
    free = sp.Symbol("root", real=True)
    return [{unknown: root} for root in sp.solve(guard.subs(unknown, free), free)]


@pytest.mark.parametrize(("contact_law", "branch", "exit_"), EXITS, ids=EXIT_IDS)
def test_exit_keeps_force_and_stored_energy(contact_law, branch, exit_):
    points = _at_exit(exit_, contact_law)
    assert points
    force, stored = (_plain(e, contact_law) for e in (branch.force, branch.stored_energy))
    if exit_.target == SEPARATED:
        # A dashpot releases before δ = 0 is reached; without one, both guards are this.
        still = {s: 0 for s in force.free_symbols if s.name == "c"} if exit_.guard == DELTA else {}
        assert all(_zero(force.subs(p).subs(still)) for p in points)
        if not exit_.guard.has(DELTA_DOT):
            assert all(_zero(stored.subs(p)) for p in points)
        return
    target = contact_law.branch(exit_.target)
    memory = {DELTA_MAX: D_MAX, **exit_.memory}
    new = {D_MAX: sp.sympify(memory[DELTA_MAX]).subs({DELTA: D, DELTA_MAX: D_MAX})}
    after = [_plain(e, contact_law).subs(new) for e in (target.force, target.stored_energy)]
    same = [
        _zero((x - y).subs(p)) for p in points for x, y in zip((force, stored), after, strict=True)
    ]
    virgin = contact_law.choices.get("reload") == "virgin" and exit_.kind == "reload"
    assert not any(same) if virgin else all(same)


def test_exit_virgin_reload_raises_the_force():
    contact_law = bilinear_hertz(reload="virgin")
    unloading, loading = contact_law.branch("restitution"), contact_law.loading
    n, _, e = (p.symbol for p in contact_law.parameters[-3:])
    jump = _plain(loading.force, contact_law) - _plain(unloading.force, contact_law)
    values = {e: 0.75, n: 1.764, D: 0.8, D_MAX: 1.0, K_E: 1.0}
    assert jump.subs(values) > 0


@pytest.mark.parametrize("reload", ["elastic", "virgin"])
def test_bilinear_works_are_those_of_the_paper(reload):
    contact_law = bilinear_hertz(reload=reload)
    n, _, e = (p.symbol for p in contact_law.parameters[-3:])
    depth = sp.Symbol("depth", positive=True)
    loading = _plain(contact_law.loading.force, contact_law)
    work_in = sp.integrate(loading, (D, 0, D_MAX))
    assert _zero(work_in - K_E * D_MAX ** (n + 1) / (n + 1))
    unloading = _plain(contact_law.branch("restitution").force, contact_law)
    in_depth = sp.expand_power_base(sp.simplify(unloading.subs(D, depth + D_MAX * (1 - e**2))))
    # δ − δ_p falls from e² δ_max to 0. The antiderivative is taken by hand: e may be 0.
    antiderivative = in_depth * depth / (n + 1)
    assert _zero(sp.diff(antiderivative, depth) - in_depth)
    span = sp.Symbol("span", positive=True)
    work_out = -antiderivative.subs(depth, span).subs(span, e**2 * D_MAX)
    values = {n: 1.764, e: 0.75, D_MAX: 2.3, K_E: 5.0}
    assert math.isclose(work_out.subs(values), -((0.75) ** 2) * work_in.subs(values), rel_tol=1e-13)
    stored = _plain(contact_law.loading.stored_energy, contact_law).subs(D, D_MAX)
    assert _zero(stored - e**2 * work_in)


@pytest.mark.parametrize("contact_law", VARIANTS, ids=IDS)
def test_law_scales_describe_its_loading_curve(contact_law):
    force = _plain(contact_law.loading.force, contact_law).subs(DELTA_DOT, 0)
    scaled = _plain(contact_law.stiffness, contact_law) * D**contact_law.exponent
    assert _zero(force - scaled)


@pytest.mark.parametrize("contact_law", VARIANTS, ids=IDS)
def test_law_defaults_are_valid_and_explained(contact_law):
    for parameter in contact_law.parameters:
        assert parameter.fault(parameter.default) is None
        assert parameter.meaning and parameter.unit
    assert contact_law.title and contact_law.source


@settings(max_examples=30)
@given(
    n=st.floats(1.0, 3.0),
    e=st.floats(0.1, 1.0),
    deepest=st.floats(1e-8, 1e-2),
    part=st.floats(0.0, 1.0),
)
def test_bilinear_unloading_lies_below_loading_and_above_zero(n, e, deepest, part):
    contact_law = bilinear_hertz()
    values = dict(zip((p.symbol for p in contact_law.parameters[-3:]), (n, 1.0, e), strict=True))
    permanent = deepest * (1 - e**2)
    delta = permanent + part * (deepest - permanent)
    values |= {D: delta, D_MAX: deepest, K_E: 1e9}
    loading, unloading = (
        complex(_plain(b.force, contact_law).subs(values)).real
        for b in (contact_law.loading, contact_law.branch("restitution"))
    )
    # At δ_p the depth is a difference of equal numbers: the ramp removes its round-off.
    assert -1e-9 * loading <= unloading <= loading * (1 + 1e-9)


@settings(max_examples=25)
@given(
    index=st.integers(0, len(VARIANTS) - 1), delta=st.floats(1e-6, 1.0), rate=st.floats(0.0, 5.0)
)
def test_loading_loses_no_energy_to_the_mechanism(index, delta, rate):
    contact_law = VARIANTS[index]
    values = {p.symbol: p.default for p in contact_law.parameters}
    values |= {D: delta, DELTA_DOT: rate, K_E: 1e6}
    branch = contact_law.loading
    for expr in (branch.force, branch.stored_energy, branch.dissipated_power):
        assert _plain(expr, contact_law).subs(values) >= 0


def test_stiffness_of_the_paper_contact():
    contact_law = bilinear_hertz()
    values = {p.symbol: p.default for p in contact_law.parameters}
    values[contact_law.parameters[0].symbol] = 20.9e14
    assert math.isclose(contact_law.definitions[K_E].subs(values), 1.2297e14, rel_tol=5e-5)


@pytest.mark.parametrize("name", [name for name in COMPLIANT_LAWS if name != "linear"])
def test_stiffness_has_the_unit_of_a_force_over_a_length_to_the_n(name):
    """With lengths in units λ times as small and moduli as they follow, K_e is λ^−n times."""
    contact_law = law(name)
    stiffness = contact_law.definitions[K_E]
    scale = sp.Symbol("lambda", positive=True)
    powers = {"Pa": -2, "m": 1, "1/m": -1, "1": 0, "s/m": -1}
    scaled = {p.symbol: p.symbol * scale ** powers[p.unit] for p in contact_law.parameters}
    ratio = sp.simplify(stiffness.subs(scaled, simultaneous=True) / stiffness)
    n = next(p.symbol for p in contact_law.parameters if p.name == "n")
    assert sp.simplify(ratio * scale**n) == 1


def test_reference_length_is_where_the_force_is_hertzs_and_has_no_effect_on_hertzs_law():
    contact_law = bilinear_hertz()
    *body, n, l_0, _ = contact_law.parameters
    stiffness = contact_law.definitions[K_E]
    own = {p.symbol: sp.Float(p.default, 30) for p in contact_law.parameters}
    there = hertz_stiffness(body) * l_0.symbol ** sp.Rational(3, 2)
    assert sp.simplify(stiffness * l_0.symbol**n.symbol / there) == 1
    hertzian = stiffness.subs(n.symbol, sp.Rational(3, 2))
    assert not hertzian.has(l_0.symbol)
    assert sp.simplify(hertzian - hertz_stiffness(body)) == 0
    assert stiffness.subs(own).subs(l_0.symbol, 1) == hertz_stiffness(body).subs(own)


def test_stiffness_of_two_equal_bodies_on_a_plane_is_that_of_one():
    one, two = bilinear_hertz(), bilinear_hertz(bodies=2)
    left = one.definitions[K_E].subs({p.symbol: p.default for p in one.parameters})
    right = two.definitions[K_E].subs({p.symbol: p.default for p in two.parameters})
    assert math.isclose(left, right, rel_tol=1e-14)


def test_ramp_is_zero_below_and_the_argument_above():
    assert ramp(D) == D
    assert without_ramps(ramp(DELTA) ** 2) == DELTA**2
    assert ramp(DELTA).diff(DELTA) == sp.Heaviside(DELTA, 0)


@pytest.mark.parametrize("name", COMPLIANT_LAWS)
def test_what_is_known_of_a_law_before_its_formulas_is_what_they_say(name):
    renamed = law(name).with_friction("stribeck").of_contact("A")
    assert "branches" not in vars(renamed)
    before = renamed.loading_name, renamed.unloading
    assert before == (renamed.branches[0].name, renamed._make().unloading)


def test_law_unknown_names_suggest_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'hertz'"):
        law("herz")
    with pytest.raises(InputError, match=r"unknown choice 'relaod'.*Did you mean 'reload'"):
        law("bilinear-hertz", relaod="virgin")
    with pytest.raises(InputError, match="unknown reload rule 'plastic'"):
        law("bilinear-hertz", reload="plastic")
    with pytest.raises(InputError, match="bodies: got 3"):
        hertz(bodies=3)


def test_law_faults_are_reported_together():
    stray = sp.Symbol("stray")
    good = hertz()
    bad = Branch("compression", stray, sp.Integer(0), sp.Integer(0), (Exit("yield", DELTA, "no"),))
    with pytest.raises(ModelError) as caught:
        dataclasses.replace(good, branches=(bad, bad), unloading="compression")
    text = str(caught.value)
    assert "contact law 'hertz'" in text
    assert "branch 'compression' is declared twice" in text
    assert "unknown branch 'no'" in text
    assert "unknown symbol 'stray'" in text


def test_formulas_of_a_named_law_are_made_when_first_asked_for():
    lazy, whole = law("bilinear-hertz"), law("bilinear-hertz")
    assert "branches" not in vars(lazy)
    assert lazy.parameters and lazy.choices == {"reload": "elastic"}
    assert "branches" not in vars(lazy)
    assert lazy.loading.name == "compression"
    assert lazy == whole == dataclasses.replace(whole)
    with pytest.raises(AttributeError, match="curvature"):
        _ = lazy.curvature


@pytest.mark.parametrize("contact_law", VARIANTS, ids=IDS)
def test_definitions_are_written_as_short_as_they_can_be(contact_law):
    """Automata take them as they stand."""
    assert all(readable(v) == v for v in contact_law.definitions.values())


def test_definitions_tell_named_laws_from_changed_ones():
    named = [law("bilinear-hertz"), law("bilinear-hertz", reload="virgin")]
    named += [law("bilinear-hertz-two-bodies"), law("hertz"), law("linear")]
    softer = dataclasses.replace(named[0].parameters[0], default=1e9)
    changed = dataclasses.replace(named[0], parameters=(softer, *named[0].parameters[1:]))
    texts = [one.definition for one in (*named, changed)]
    assert len(set(texts)) == len(texts)
    assert texts == [law("bilinear-hertz").definition, *texts[1:]]
