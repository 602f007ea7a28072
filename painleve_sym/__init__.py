"""Contact mechanics of mechanisms with dry friction where rigid bodies have no answer, or two.

Names are loaded when first used, so that importing the package stays quick.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "BilateralClassification": "simulate.bilateral",
    "BilateralContact": "hybrid.bilateral",
    "BilateralProblem": "complementarity.bilateral",
    "Classification": "simulate.classify",
    "Contact": "mechanics.contact",
    "ContactCoefficients": "mechanics.coefficients",
    "ContactLaw": "laws.compliance",
    "Coordinate": "mechanics.system",
    "DomainBound": "mechanics.models",
    "HybridAutomaton": "hybrid.automaton",
    "InputError": "errors",
    "LCP": "complementarity.lcp",
    "LagrangianSystem": "mechanics.system",
    "ManyResult": "simulate.many_result",
    "Mechanism": "mechanics.models",
    "ModelError": "errors",
    "PainleveError": "errors",
    "PainleveWarning": "errors",
    "Parameter": "mechanics.system",
    "RigidContact": "hybrid.rigid",
    "RigidSimulator": "simulate.rigid",
    "SeveralContacts": "complementarity.several",
    "SoftenedContact": "hybrid.softened",
    "SoftenedSimulator": "simulate.compliant",
    "StopReason": "errors",
    "Trajectory": "simulate.trajectory",
    "classify": "simulate.classify",
    "evaluate_jump": "simulate.jump",
    "law": "laws.compliance",
    "load_mechanism": "mechanics.files",
    "model": "mechanics.models",
    "simulate_many": "simulate.many",
    "simulate_rigid": "simulate.rigid",
    "simulate_softened": "simulate.compliant",
    "solve_impact": "simulate.impact",
    "tangential_impact": "simulate.bilateral",
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
