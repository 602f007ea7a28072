"""The rod in Siconos: a Lagrangian system with a planar frictional contact, Moreau-Jean."""

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import siconos.kernel as sk
import siconos.numerics as sn
from rod import MU, G, J, L, M, report

SOURCE = f"""
#include <math.h>
typedef unsigned int n;
void gap(n size, const double *q, n rows, double *y, n other, double *z)
{{ y[0] = q[1] - {L!r} * sin(q[2]); }}
/* Rows of the normal and the tangential velocity, column after column. */
void jacobian(n size, const double *q, n rows, double *J, n other, double *z)
{{ J[0] = 0; J[1] = 1; J[2] = 1; J[3] = 0; J[4] = -{L!r} * cos(q[2]); J[5] = {L!r} * sin(q[2]); }}
"""


def compile_relation(folder):
    """Compile the gap of A as a plugin of Siconos, which looks for it in the current folder."""
    (folder / "EndPlugin.c").write_text(SOURCE, "utf-8")
    command = ["cc", "-shared", "-fPIC", "-o", "EndPlugin.so", "EndPlugin.c", "-lm"]
    subprocess.run(command, check=True, cwd=folder)
    os.chdir(folder)


def maker(solver, restitution):
    """Return a function that makes the simulation with a solver of the contact problem."""

    def make(h, q, u):
        system = sk.LagrangianDS(q, u, np.diag([M, M, J]))
        system.setFExtPtr([0.0, -M * G, 0.0])
        law = sk.NewtonImpactFrictionNSL(restitution, 0.0, MU, 2)
        relation = sk.LagrangianScleronomousR("./EndPlugin:gap", "./EndPlugin:jacobian")
        contact = sk.Interaction(law, relation)
        model = sk.NonSmoothDynamicalSystem(0.0, 1.0)
        model.insertDynamicalSystem(system)
        model.link(contact, system)
        problem = sk.FrictionContact(2, solver)
        problem.setKeepLambdaAndYState(True)
        times, scheme = sk.TimeDiscretisation(0.0, h), sk.MoreauJeanOSI(0.5)
        simulation = sk.TimeStepping(model, times, scheme, problem)
        # Python would free what only C++ refers to.
        kept = (system, law, relation, contact, model, problem, times, scheme)

        def step():
            assert kept
            simulation.computeOneStep()
            simulation.nextStep()
            return system.q().tolist(), system.velocity().tolist()

        return step

    return make


def version():
    """Return the version of Debian's package, since the module does not name its own."""
    command = ["dpkg-query", "-W", "-f", "${Version}", "python3-siconos"]
    done = subprocess.run(command, capture_output=True, text=True)
    return f"{done.stdout} (Debian)" if done.stdout else "unknown"


if __name__ == "__main__":
    settings = {
        "Moreau-Jean, Lemke, e = 0": maker(sn.SICONOS_FRICTION_2D_LEMKE, 0.0),
        "Moreau-Jean, Lemke, e = 0.75": maker(sn.SICONOS_FRICTION_2D_LEMKE, 0.75),
        "Moreau-Jean, Gauss-Seidel, e = 0": maker(sn.SICONOS_FRICTION_2D_NSGS, 0.0),
    }
    with tempfile.TemporaryDirectory() as folder:
        compile_relation(Path(folder))
        report("Siconos", version(), settings)
