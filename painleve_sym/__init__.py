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
    "Body": "mechanics.bodies",
    "Classification": "simulate.classify",
    "Contact": "mechanics.contact",
    "ContactCoefficients": "mechanics.coefficients",
    "ContactLaw": "laws.compliance",
    "Coordinate": "mechanics.system",
    "CorrectedJumpRule": "simulate.corrected_jump",
    "CriticalForceFinder": "simulate.critical_force",
    "DomainBound": "mechanics.models",
    "FrozenImpactSolver": "codegen.frozen_impact",
    "FitData": "study.fit_data",
    "FitProblem": "study.fit",
    "FitResult": "study.fit_result",
    "HybridAutomaton": "hybrid.automaton",
    "InputError": "errors",
    "LCP": "complementarity.lcp",
    "LagrangianSystem": "mechanics.system",
    "Load": "mechanics.bodies",
    "ManyResult": "simulate.many_result",
    "Mechanism": "mechanics.models",
    "ModelError": "errors",
    "PainleveError": "errors",
    "PainleveWarning": "errors",
    "Parameter": "mechanics.system",
    "RigidContact": "hybrid.rigid",
    "RigidSimulator": "simulate.rigid",
    "SensitiveTrajectory": "simulate.sensitivity",
    "SeveralContacts": "complementarity.several",
    "SoftenedContact": "hybrid.softened",
    "SoftenedSimulator": "simulate.compliant",
    "Spring": "mechanics.bodies",
    "StopReason": "errors",
    "Trajectory": "simulate.trajectory",
    "classify": "simulate.classify",
    "critical_force_gradient": "study.critical_force",
    "evaluate_corrected_jump": "simulate.corrected_case",
    "evaluate_jump": "simulate.jump",
    "law": "laws.compliance",
    "load_mechanism": "mechanics.files",
    "model": "mechanics.models",
    "read_fit_data": "study.fit_data",
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
