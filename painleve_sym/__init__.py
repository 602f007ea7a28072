"""Contact mechanics of mechanisms with dry friction where rigid bodies have no answer, or two.

Names are loaded when first used, so that importing the package stays quick.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "BilateralContact": "contacts.guide",
    "Body": "mechanics.bodies",
    "Classification": "contacts.classify",
    "Contact": "mechanics.contact",
    "ContactCoefficients": "mechanics.coefficients",
    "ContactLaw": "laws.contact_law",
    "ContactProblem": "contacts.problem",
    "Coordinate": "mechanics.declarations",
    "CorrectedJumpRule": "simulate.finite_stiffness",
    "CriticalForceFinder": "study.critical.bisection",
    "DomainBound": "mechanics.mechanism",
    "FrozenImpactSolver": "simulate.frozen_impact",
    "FitData": "study.fitting.data",
    "FitProblem": "study.fitting.problem",
    "FitResult": "study.fitting.result",
    "HybridAutomaton": "hybrid.automaton",
    "InputError": "errors",
    "LCP": "complementarity.lcp",
    "LagrangianSystem": "mechanics.system",
    "Load": "mechanics.bodies",
    "ManyResult": "simulate.batch.result",
    "Mechanism": "mechanics.mechanism",
    "ModelError": "errors",
    "PainleveError": "errors",
    "PainleveWarning": "errors",
    "Parameter": "mechanics.declarations",
    "RigidContact": "contacts.rigid",
    "SensitiveTrajectory": "simulate.sensitivity.result",
    "SoftenedContact": "contacts.compliant",
    "Simulator": "simulate.simulator",
    "Spring": "mechanics.bodies",
    "StopReason": "errors",
    "TIME": "mechanics.system",
    "Trajectory": "simulate.trajectory",
    "classify": "contacts.classify",
    "closed_forms": "laws.closed_forms",
    "critical_force_gradient": "study.critical.gradient",
    "evaluate_corrected_jump": "simulate.finite_stiffness",
    "evaluate_jump": "contacts.impact.jump",
    "law": "laws.catalogue",
    "load_mechanism": "mechanics.toml.mechanism_file",
    "model": "codegen.named_mechanisms",
    "read_fit_data": "study.fitting.data",
    "simulate_many": "simulate.batch.run",
    "simulate_rigid": "simulate.simulator",
    "simulate_softened": "simulate.simulator",
    "solve_impact": "contacts.impact.one_contact",
    "tangential_impact": "contacts.impact.tangential",
}

__all__ = sorted([*_HOMES, "__version__"])


def __getattr__(name: str) -> Any:
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'painleve_sym' has no attribute {name!r}")
    module = importlib.import_module(f"painleve_sym.{home}")
    value = getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
