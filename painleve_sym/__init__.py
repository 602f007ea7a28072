"""Contact mechanics of mechanisms with dry friction where rigid bodies have no answer, or two.

Names are loaded when first used, so that importing the package stays quick. `models` and `laws`
hold the named mechanisms and contact laws as functions.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from painleve_sym import laws as laws
    from painleve_sym import models as models
    from painleve_sym.c_export.export import export_c as export_c
    from painleve_sym.choices import EngineName as EngineName
    from painleve_sym.choices import Friction as Friction
    from painleve_sym.choices import Policy as Policy
    from painleve_sym.choices import Record as Record
    from painleve_sym.choices import Reload as Reload
    from painleve_sym.choices import Restitution as Restitution
    from painleve_sym.codegen.named_mechanisms import model as model
    from painleve_sym.complementarity.lcp import LCP as LCP
    from painleve_sym.contacts.classify import Classification as Classification
    from painleve_sym.contacts.classify import classify as classify
    from painleve_sym.contacts.impact.jump import JumpResult as JumpResult
    from painleve_sym.contacts.impact.jump import evaluate_jump as evaluate_jump
    from painleve_sym.contacts.impact.one_contact import Impact as Impact
    from painleve_sym.contacts.impact.one_contact import solve_impact as solve_impact
    from painleve_sym.contacts.impact.tangential import tangential_impact as tangential_impact
    from painleve_sym.contacts.problem import ContactCase as ContactCase
    from painleve_sym.contacts.problem import ContactProblem as ContactProblem
    from painleve_sym.errors import EventKind as EventKind
    from painleve_sym.errors import InputError as InputError
    from painleve_sym.errors import ModelError as ModelError
    from painleve_sym.errors import PainleveError as PainleveError
    from painleve_sym.errors import PainleveWarning as PainleveWarning
    from painleve_sym.errors import StopReason as StopReason
    from painleve_sym.explorer.page import explore as explore
    from painleve_sym.hybrid.automaton import HybridAutomaton as HybridAutomaton
    from painleve_sym.laws.catalogue import LawsByContact as LawsByContact
    from painleve_sym.laws.catalogue import law as law
    from painleve_sym.laws.closed_forms import closed_forms as closed_forms
    from painleve_sym.laws.contact_law import ContactLaw as ContactLaw
    from painleve_sym.laws.rigid_contact import RigidLaw as RigidLaw
    from painleve_sym.mechanics.bodies import Body as Body
    from painleve_sym.mechanics.bodies import Load as Load
    from painleve_sym.mechanics.bodies import Spring as Spring
    from painleve_sym.mechanics.coefficients import ContactCoefficients as ContactCoefficients
    from painleve_sym.mechanics.contact import Contact as Contact
    from painleve_sym.mechanics.declarations import Coordinate as Coordinate
    from painleve_sym.mechanics.declarations import Parameter as Parameter
    from painleve_sym.mechanics.materials import Material as Material
    from painleve_sym.mechanics.materials import material as material
    from painleve_sym.mechanics.mechanism import DomainBound as DomainBound
    from painleve_sym.mechanics.mechanism import Mechanism as Mechanism
    from painleve_sym.mechanics.system import TIME as TIME
    from painleve_sym.mechanics.system import LagrangianSystem as LagrangianSystem
    from painleve_sym.mechanics.toml.mechanism_file import load_mechanism as load_mechanism
    from painleve_sym.motion.batch.result import BatchResult as BatchResult
    from painleve_sym.motion.finite_stiffness import CorrectedJump as CorrectedJump
    from painleve_sym.motion.finite_stiffness import CorrectedJumpRule as CorrectedJumpRule
    from painleve_sym.motion.finite_stiffness import (
        evaluate_corrected_jump as evaluate_corrected_jump,
    )
    from painleve_sym.motion.frozen_impact import FrozenImpactSolver as FrozenImpactSolver
    from painleve_sym.motion.sensitivity.result import SensitiveTrajectory as SensitiveTrajectory
    from painleve_sym.motion.simulate import simulate as simulate
    from painleve_sym.motion.simulate import simulate_batch as simulate_batch
    from painleve_sym.motion.simulator import Simulator as Simulator
    from painleve_sym.motion.trajectory import Trajectory as Trajectory
    from painleve_sym.papers.registry import Reproduction as Reproduction
    from painleve_sym.papers.registry import reproduce as reproduce
    from painleve_sym.references import Reference as Reference
    from painleve_sym.references import citation as citation
    from painleve_sym.study.compare.comparison import Comparison as Comparison
    from painleve_sym.study.compare.comparison import compare as compare
    from painleve_sym.study.critical.bisection import Border as Border
    from painleve_sym.study.critical.bisection import CriticalForce as CriticalForce
    from painleve_sym.study.critical.bisection import CriticalForceFinder as CriticalForceFinder
    from painleve_sym.study.critical.bisection import critical_force as critical_force
    from painleve_sym.study.critical.gradient import (
        critical_force_gradient as critical_force_gradient,
    )
    from painleve_sym.study.fitting.data import FitData as FitData
    from painleve_sym.study.fitting.data import read_fit_data as read_fit_data
    from painleve_sym.study.fitting.problem import FitProblem as FitProblem
    from painleve_sym.study.fitting.problem import fit as fit
    from painleve_sym.study.fitting.result import FitResult as FitResult
    from painleve_sym.study.maps.region_map import RegionMap as RegionMap
    from painleve_sym.study.maps.region_map import region_map as region_map
    from painleve_sym.study.sweeps.runner import sweep as sweep
    from painleve_sym.study.sweeps.sweep import Sweep as Sweep

__version__ = "0.4.0"

_HOMES = {
    "BatchResult": "motion.batch.result",
    "Body": "mechanics.bodies",
    "Border": "study.critical.bisection",
    "Classification": "contacts.classify",
    "Comparison": "study.compare.comparison",
    "Contact": "mechanics.contact",
    "ContactCase": "contacts.problem",
    "ContactCoefficients": "mechanics.coefficients",
    "ContactLaw": "laws.contact_law",
    "ContactProblem": "contacts.problem",
    "Coordinate": "mechanics.declarations",
    "CorrectedJump": "motion.finite_stiffness",
    "CorrectedJumpRule": "motion.finite_stiffness",
    "CriticalForce": "study.critical.bisection",
    "CriticalForceFinder": "study.critical.bisection",
    "DomainBound": "mechanics.mechanism",
    "EngineName": "choices",
    "Friction": "choices",
    "EventKind": "errors",
    "FitData": "study.fitting.data",
    "FitProblem": "study.fitting.problem",
    "FitResult": "study.fitting.result",
    "FrozenImpactSolver": "motion.frozen_impact",
    "HybridAutomaton": "hybrid.automaton",
    "Impact": "contacts.impact.one_contact",
    "InputError": "errors",
    "JumpResult": "contacts.impact.jump",
    "LCP": "complementarity.lcp",
    "LagrangianSystem": "mechanics.system",
    "LawsByContact": "laws.catalogue",
    "Load": "mechanics.bodies",
    "Material": "mechanics.materials",
    "Mechanism": "mechanics.mechanism",
    "ModelError": "errors",
    "PainleveError": "errors",
    "PainleveWarning": "errors",
    "Parameter": "mechanics.declarations",
    "Policy": "choices",
    "Record": "choices",
    "Reference": "references",
    "RegionMap": "study.maps.region_map",
    "Reload": "choices",
    "Reproduction": "papers.registry",
    "Restitution": "choices",
    "RigidLaw": "laws.rigid_contact",
    "SensitiveTrajectory": "motion.sensitivity.result",
    "Simulator": "motion.simulator",
    "Spring": "mechanics.bodies",
    "StopReason": "errors",
    "Sweep": "study.sweeps.sweep",
    "TIME": "mechanics.system",
    "Trajectory": "motion.trajectory",
    "citation": "references",
    "classify": "contacts.classify",
    "closed_forms": "laws.closed_forms",
    "compare": "study.compare.comparison",
    "critical_force": "study.critical.bisection",
    "critical_force_gradient": "study.critical.gradient",
    "evaluate_corrected_jump": "motion.finite_stiffness",
    "evaluate_jump": "contacts.impact.jump",
    "explore": "explorer.page",
    "export_c": "c_export.export",
    "fit": "study.fitting.problem",
    "law": "laws.catalogue",
    "load_mechanism": "mechanics.toml.mechanism_file",
    "material": "mechanics.materials",
    "model": "codegen.named_mechanisms",
    "read_fit_data": "study.fitting.data",
    "region_map": "study.maps.region_map",
    "reproduce": "papers.registry",
    "simulate": "motion.simulate",
    "simulate_batch": "motion.simulate",
    "solve_impact": "contacts.impact.one_contact",
    "sweep": "study.sweeps.runner",
    "tangential_impact": "contacts.impact.tangential",
}
_MODULES = ("laws", "models")

__all__ = sorted([*_HOMES, *_MODULES, "__version__"])


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"painleve_sym.{name}")
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'painleve_sym' has no attribute {name!r}")
    module = importlib.import_module(f"painleve_sym.{home}")
    value = getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
