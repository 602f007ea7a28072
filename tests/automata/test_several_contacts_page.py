"""The formulas and numbers of docs/several-contacts.md."""

import sympy as sp

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.mechanics.contact_set import ContactSet


def test_ladder_has_the_determinant_of_the_page():
    ladder = model("ladder")
    contacts = ContactSet(ladder)
    mu_f, mu_w, m, l, theta = sp.symbols("mu_f mu_w m l theta", positive=True)
    c, s = sp.cos(theta), sp.sin(theta)
    normals = sp.Matrix([[0, 1, l * c], [1, 0, -l * s]])
    forces = sp.Matrix([[-mu_f, 1, l * (c - mu_f * s)], [1, mu_w, -l * (s + mu_w * c)]])
    inverse = sp.diag(1 / m, 1 / m, 3 / (m * l**2))
    A = normals * inverse * forces.T
    # The entries of the page, its determinant, and the package's own entries.
    entries = sp.Matrix(
        [
            [1 + 3 * c * (c - mu_f * s), mu_w - 3 * c * (s + mu_w * c)],
            [-mu_f - 3 * s * (c - mu_f * s), 1 + 3 * s * (s + mu_w * c)],
        ]
    )
    assert sp.simplify(m * A - entries) == sp.zeros(2)
    determinant = 4 - 2 * mu_f * mu_w - 6 * (mu_f - mu_w) * s * c
    assert sp.simplify(m**2 * A.det() - determinant) == 0
    names = {"m": m, "l": l, "theta": theta, "mu_floor": mu_f, "mu_wall": mu_w}
    W, (floor, wall) = contacts.W, contacts.mu
    # Rows and columns (n, t) of the floor and of the wall, whose tangents point out and down.
    directions = sp.Matrix([[1, 0], [-floor, 0], [0, 1], [0, -wall]])
    own = sp.Matrix([W.row(0), W.row(2)]) * directions
    own = own.subs({x: names[x.name] for x in own.free_symbols if x.name in names})
    assert sp.simplify(m * own - entries) == sp.zeros(2)
