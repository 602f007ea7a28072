"""Recipes of the page Architecture, followed literally in a copy of the package."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import painleve_sym

PACKAGE = Path(painleve_sym.__file__).parent


@pytest.fixture
def copy(tmp_path):
    """Return a copy of the package that is added to, and run."""
    folder = tmp_path / "painleve_sym"
    shutil.copytree(PACKAGE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    return Copy(folder)


class Copy:
    """A copy of the package."""

    def __init__(self, folder):
        self.folder = folder

    def write(self, path, text):
        """Write a file of the package."""
        (self.folder / path).write_text(text, "utf-8")

    def append(self, path, text):
        """Add to the end of a file of the package."""
        with (self.folder / path).open("a", encoding="utf-8") as file:
            file.write(text)

    def replace(self, path, old, new):
        """Replace what stands once in a file of the package."""
        text = (self.folder / path).read_text("utf-8")
        assert text.count(old) == 1
        self.write(path, text.replace(old, new))

    def run(self, *words):
        """Run a command of the copy."""
        return self.python("-m", "painleve_sym", *words)

    def python(self, *words):
        """Run Python with the copy as package."""
        return subprocess.run(
            [sys.executable, *words],
            cwd=self.folder.parent,
            env=os.environ | {"PYTHONPATH": str(self.folder.parent)},
            capture_output=True,
            text=True,
            check=False,
        )


COMMAND = '''"""Command that adds forces."""

from __future__ import annotations

import argparse


def total(arguments: argparse.Namespace) -> int:
    """Print the sum of the forces."""
    print(f"{arguments.name}: {sum(arguments.forces):g} N")
    return 0
'''
ENTRY = """
command(
    "total",
    "total",
    "add forces",
    text("name NAME", "name of the sum"),
    text("--forces F,...", "forces that are added, N", in_unit(read_positive, "N")),
    details="Forces are positive.",
)
"""


def test_command_is_a_function_and_one_entry(copy):
    copy.write("cli/total.py", COMMAND)
    copy.append("cli/commands.py", ENTRY)
    done = copy.run("total", "load", "--forces", "1,2.5")
    assert (done.returncode, done.stdout, done.stderr) == (0, "load: 3.5 N\n", "")
    assert "add forces" in copy.run("-h").stdout
    page = copy.run("total", "-h").stdout
    assert "--forces F,..." in page and page.rstrip().endswith("Forces are positive.")
    wrong = copy.run("total", "load", "--forces", "-1")
    assert wrong.returncode == 2 and "--forces: got -1, need numbers > 0" in wrong.stderr


LAW = '''

@_registered()
def cubic(**parameters: float) -> ContactLaw:
    """Return the spring F_n = k δ³."""
    return _law(
        parameters,
        _cubic,
        "cubic",
        name="cubic",
        title="cubic spring",
        source="a test",
        parameters=(Parameter("k", 1e8, "N/m^3", "stiffness", 0.0, lower_closed=False),),
    )


def _cubic(known: Mapping[str, Any]) -> ContactLaw:
    import sympy as sp

    from painleve_sym.laws.compliance import K_E

    (k,) = known["parameters"]
    return _viscoelastic(known, {K_E: k.symbol}, sp.Integer(3), sp.Integer(0), ())
'''
MECHANISM = '''"""A point that falls on the ground."""

from __future__ import annotations

from painleve_sym.mechanics.bodies import Body
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, positive
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models.common import friction, gravity
from painleve_sym.mechanics.system import LagrangianSystem


def point() -> Mechanism:
    """Return a point mass above level ground."""
    x, y = Coordinate("x", "position", "m"), Coordinate("y", "height", "m")
    m, g, mu = positive("m", 1.0, "kg", "mass"), gravity(), friction(0.5)
    at = (x.symbol, y.symbol)
    system = LagrangianSystem.of_bodies(
        "point", (x, y), (m, g, mu), [Body(m.symbol, at)], gravity=g.symbol
    )
    return Mechanism(
        name="point",
        title="point mass",
        source="a test",
        system=system,
        contacts=(Contact.of_point("point", system, at, mu.symbol),),
        sketch="o",
    )
'''


@pytest.mark.slow
def test_law_and_mechanism_are_their_functions_and_a_name_each(copy):
    """A point with speed v compresses the spring until k δ⁴/4 = m v²/2."""
    laws, models = "laws/compliant_laws.py", "mechanics/models/__init__.py"
    copy.append(laws, LAW)
    copy.replace(laws, '"hunt_crossley", "linear"]', '"hunt_crossley", "linear", "cubic"]')
    copy.write("mechanics/models/points.py", MECHANISM)
    copy.replace(
        models,
        '    "strut": partial(',
        '    "point": partial(_imported, "points", "point"),\n    "strut": partial(',
    )
    copy.replace(models, '    "strut": "pivoted', '    "point": "mass",\n    "strut": "pivoted')
    assert "cubic spring" in copy.run("laws").stdout and "point  " in copy.run("models").stdout
    given = "--state", "y_dot=-2", "--set", "g=0,m=3", "--law-set", "k=5e6", "--t-end", "1"
    done = copy.run(
        *("simulate", "point", "--law", "cubic", "--until", "max_compression", "--json"), *given
    )
    assert done.returncode == 0, done.stderr
    motion = json.loads(done.stdout)
    assert motion["events"][-1]["compression"] == pytest.approx((2 * 3 * 2**2 / 5e6) ** 0.25)
    assert motion["engine"] == "taylor"


RESTITUTION = '''def returned_energy() -> RestitutionLaw:
    """Return the law E_r = −η E_c."""
    return RestitutionLaw(
        name="returned_energy",
        title="part of the energy that is returned",
        source="a test",
        parameter=Parameter("eta", 0.5, "1", "part of the energy", 0.0, 1.0),
        measure=Measure.WORK,
        power=1,
        note="energetic",
    )


RESTITUTIONS = '''


@pytest.fixture
def with_restitution_law(copy):
    """Return a copy with a law of restitution."""
    laws = "newton(), poisson(), energetic()"
    copy.replace("laws/restitution.py", "RESTITUTIONS = ", RESTITUTION)
    copy.replace("laws/restitution.py", f"({laws})", f"({laws}, returned_energy())")
    own = 'ENERGETIC = "energetic"\n    RETURNED_ENERGY = "returned_energy"'
    copy.replace("choices.py", 'ENERGETIC = "energetic"', own)
    return copy


IMPACTS = """
import numpy as np, painleve_sym as ps
from painleve_sym.engines.impacts import solve_simultaneous_impact
law = "returned_energy", 0.64
print(ps.solve_impact([[2, 0], [0, 1]], 0.3, (-1, 0.2), *law).velocity[0])
print(ps.solve_impact(np.diag([2, 1, 3]), 0.3, (-1, 0.2, 0.7), *law).velocity[0])
for n in (1, 2):
    mu, v = [0.3] * n, [-1, 0.2] * n
    print(solve_simultaneous_impact(np.eye(2 * n), mu, v, *law).velocities[0])
"""


def test_restitution_law_is_its_function_and_a_name(with_restitution_law):
    """Half of W_nn P_n² is returned but for η, so that v_n⁺ = −√η v_n⁻ in central impacts."""
    copy = with_restitution_law
    done = copy.python("-c", IMPACTS)
    assert [float(v) for v in done.stdout.split()] == pytest.approx([0.8] * 4), done.stderr
    assert "part of the energy that is returned" in copy.run("laws").stdout
    given = "jump", "rod", "--state", "theta=1,x_A_dot=-1,y_A_dot=-1", "--json"
    own = json.loads(copy.run(*given, "--rule", "returned_energy", "--restitution", "0.64").stdout)
    same = json.loads(copy.run(*given, "--rule", "energetic", "--restitution", "0.8").stdout)
    assert own["phases"][-1]["velocity"] == pytest.approx(same["phases"][-1]["velocity"])


BOUNCES = """
import painleve_sym as ps
law = ps.RigidLaw("returned_energy", e=0.64)
level = {"beta": 0, "mu_A": 0, "mu_B": 0}
for name, theta, given in (("rod", "90 deg", {}), ("block-two-feet", 0, level)):
    state = {"y_A": 0.1, "theta": theta}
    run = ps.Simulator(name, law).run(state, parameters=given, t_end=0.2)
    print(run.final_state[run.state_names.index("y_A_dot")])
"""


@pytest.mark.slow
def test_restitution_law_is_that_of_runs(with_restitution_law):
    """A mass falls from 0.1 m and rises with √η times its speed."""
    done = with_restitution_law.python("-c", BOUNCES)
    down = (2 * 0.1 / 9.8) ** 0.5
    rises = 0.8 * 9.8 * down - 9.8 * (0.2 - down)
    assert [float(v) for v in done.stdout.split()] == pytest.approx([rises] * 2), done.stderr


KIND = Path(__file__).with_name("support") / "film.py"
FILM = """
from dataclasses import fields
import painleve_sym as ps
from painleve_sym.laws.contact_kind import ContactKind
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.mechanics.declarations import Parameter
from painleve_sym.mechanics.models.points import point

class Film(ContactLaw):
    kind = ContactKind.FILM

spring = ps.laws.linear()
own = {f.name: getattr(spring, f.name) for f in fields(spring)}
own["parameters"] += (Parameter("film", 2.0, "N s/m", "viscous friction"),)
start = {"y": -9.8 / spring.parameters[0].default, "x_dot": 3.0}
run = ps.Simulator(point(), Film(**own)).run(start, t_end=0.5)
for name in ("x_dot", "friction_dissipation"):
    print(run.final_state[run.state_names.index(name)])
"""


@pytest.mark.slow
def test_contact_kind_is_a_file_a_name_an_entry_and_a_law(copy):
    """A mass of 1 kg on a film slows down by F_t = −c v_t, and what it loses is dissipated."""
    copy.write("automata/film.py", KIND.read_text("utf-8"))
    spring, kinds = 'SPRING = "spring"', "automata/plural_contacts.py"
    copy.replace("laws/contact_kind.py", spring, f'FILM = "film"\n    {spring}')
    entry = "    ContactKind.SPRING: SpringInterface,\n"
    copy.replace(kinds, entry, f"{entry}    ContactKind.FILM: FilmInterface,\n")
    source = "from painleve_sym.automata.guide import"
    copy.replace(kinds, source, f"from painleve_sym.automata.film import FilmInterface\n{source}")
    copy.write("mechanics/models/points.py", MECHANISM)
    done = copy.python("-c", FILM)
    v = 3.0 * math.exp(-2.0 * 0.5)
    energy = (3.0**2 - v**2) / 2
    assert [float(n) for n in done.stdout.split()] == pytest.approx([v, energy]), done.stderr


BALL = '''


@dataclass(frozen=True)
class Drilling(Interval):
    """Friction about the normal of a disc of contact with one pressure, 2 μ r F_n/3."""

    mu: float = field(init=False)
    coefficient: float
    radius: float

    def __post_init__(self) -> None:
        """Give the radius of the ball."""
        object.__setattr__(self, "mu", 2 * self.coefficient * self.radius / 3)
        super().__post_init__()
'''
SPINS = """
from painleve_sym.problem import ContactProblem, Disc, Drilling
m, J, g, mu, r = 2.0, 0.25, 9.8, 0.5, 0.2
W = [[1 / m, 0, 0, 0], [0, 1 / m, 0, 0], [0, 0, 1 / m, 0], [0, 0, 0, 1 / J]]
for spin, load in ((5.0, 0.0), (0.0, 0.9), (0.0, 2.0)):
    balls = Disc(mu), Drilling(mu, r)
    problem = ContactProblem(W, [-g, 0, 0, load / J], [balls], [0, 0, spin])
    [solution] = problem.solutions()
    print(solution.accelerations[3])
"""


def test_ball_of_friction_is_its_class_and_a_name(copy):
    """A body that spins on a disc slows down by 2 μ r m g/3, which holds smaller torques."""
    copy.append("problem/friction_set.py", BALL)
    old = "from dataclasses import dataclass"
    copy.replace("problem/friction_set.py", old, f"{old}, field")
    listed = "from painleve_sym.problem.friction_set import Drilling as Drilling\n"
    copy.append("problem/__init__.pyi", listed)
    done = copy.python("-c", SPINS)
    torque = 2 * 0.5 * 0.2 * 2.0 * 9.8 / 3
    expected = [-torque / 0.25, 0.0, (2.0 - torque) / 0.25]
    assert [float(n) for n in done.stdout.split()] == pytest.approx(expected), done.stderr
