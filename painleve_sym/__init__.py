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

__version__ = "0.7.0"

_NAMES = {
    "c_export.export": ("export_c",),
    "choices": ("EngineName", "Friction", "Policy", "Record", "Reload", "Restitution"),
    "codegen.named_mechanisms": ("model",),
    "complementarity.lcp": ("LCP",),
    "contacts.classify": ("Classification", "classify"),
    "contacts.impact.jump": ("JumpResult", "evaluate_jump"),
    "contacts.impact.one_contact": ("Impact", "solve_impact"),
    "contacts.impact.tangential": ("tangential_impact",),
    "contacts.problem": ("ContactCase", "ContactProblem"),
    "errors": (
        "EventKind",
        "InputError",
        "ModelError",
        "PainleveError",
        "PainleveWarning",
        "StopReason",
    ),
    "explorer.page": ("explore",),
    "hybrid.automaton": ("HybridAutomaton",),
    "laws.catalogue": ("LawsByContact", "law"),
    "laws.closed_forms": ("closed_forms",),
    "laws.contact_law": ("ContactLaw",),
    "laws.rigid_contact": ("RigidLaw",),
    "mechanics.bodies": ("Body", "Load", "Spring"),
    "mechanics.coefficients": ("ContactCoefficients",),
    "mechanics.contact": ("Contact",),
    "mechanics.declarations": ("Coordinate", "Parameter"),
    "mechanics.materials": ("Material", "material"),
    "mechanics.mechanism": ("DomainBound", "Mechanism"),
    "mechanics.system": ("LagrangianSystem", "TIME"),
    "mechanics.toml.mechanism_file": ("load_mechanism",),
    "motion.batch.result": ("BatchResult",),
    "motion.finite_stiffness": ("CorrectedJump", "CorrectedJumpRule", "evaluate_corrected_jump"),
    "motion.frozen_impact": ("FrozenImpactSolver",),
    "motion.sensitivity.result": ("SensitiveTrajectory",),
    "motion.simulate": ("simulate", "simulate_batch"),
    "motion.simulator": ("Simulator",),
    "motion.trajectory": ("Trajectory",),
    "papers.registry": ("Reproduction", "reproduce"),
    "references": ("Reference", "citation"),
    "study.compare.comparison": ("Comparison", "compare"),
    "study.critical.bisection": (
        "Border",
        "CriticalForce",
        "CriticalForceFinder",
        "critical_force",
    ),
    "study.critical.gradient": ("critical_force_gradient",),
    "study.fitting.data": ("FitData", "read_fit_data"),
    "study.fitting.problem": ("FitProblem", "fit"),
    "study.fitting.result": ("FitResult",),
    "study.maps.region_map": ("RegionMap", "region_map"),
    "study.sweeps.runner": ("sweep",),
    "study.sweeps.sweep": ("Sweep",),
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names}
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
