"""Contact mechanics of mechanisms with dry friction where rigid bodies have no answer, or two.

Names are loaded when first used, so that importing the package stays quick. `models` and `laws`
hold the named mechanisms and contact laws as functions.
"""

from __future__ import annotations

import importlib
from functools import partial
from typing import TYPE_CHECKING, Any

from painleve_sym.hooks import register
from painleve_sym.version import __version__ as __version__

if TYPE_CHECKING:
    from painleve_sym import laws as laws
    from painleve_sym import models as models
    from painleve_sym.at.cases import classify as classify
    from painleve_sym.at.classification import Classification as Classification
    from painleve_sym.at.jump import JumpPhase as JumpPhase
    from painleve_sym.at.jump import JumpResult as JumpResult
    from painleve_sym.at.jump import evaluate_jump as evaluate_jump
    from painleve_sym.at.tangential import TangentialImpact as TangentialImpact
    from painleve_sym.at.tangential import tangential_impact as tangential_impact
    from painleve_sym.automata.automaton import HybridAutomaton as HybridAutomaton
    from painleve_sym.c_export.export import Export as Export
    from painleve_sym.c_export.export import export_c as export_c
    from painleve_sym.choices import EngineName as EngineName
    from painleve_sym.choices import Friction as Friction
    from painleve_sym.choices import Policy as Policy
    from painleve_sym.choices import Record as Record
    from painleve_sym.choices import Reload as Reload
    from painleve_sym.choices import Restitution as Restitution
    from painleve_sym.codegen.named_mechanisms import model as model
    from painleve_sym.errors import EventKind as EventKind
    from painleve_sym.errors import InputError as InputError
    from painleve_sym.errors import ModelError as ModelError
    from painleve_sym.errors import PainleveError as PainleveError
    from painleve_sym.errors import PainleveWarning as PainleveWarning
    from painleve_sym.errors import StopReason as StopReason
    from painleve_sym.explorer.page import Page as Page
    from painleve_sym.explorer.page import explore as explore
    from painleve_sym.laws.catalogue import LawsByContact as LawsByContact
    from painleve_sym.laws.catalogue import law as law
    from painleve_sym.laws.closed_forms import closed_forms as closed_forms
    from painleve_sym.laws.compliance import Branch as Branch
    from painleve_sym.laws.compliance import Exit as Exit
    from painleve_sym.laws.contact_law import ContactLaw as ContactLaw
    from painleve_sym.laws.rigid_contact import RigidLaw as RigidLaw
    from painleve_sym.mechanics.bodies import Body as Body
    from painleve_sym.mechanics.bodies import Load as Load
    from painleve_sym.mechanics.bodies import Mode as Mode
    from painleve_sym.mechanics.bodies import NaturalPeriod as NaturalPeriod
    from painleve_sym.mechanics.bodies import Spring as Spring
    from painleve_sym.mechanics.coefficients import ContactCoefficients as ContactCoefficients
    from painleve_sym.mechanics.contact import Contact as Contact
    from painleve_sym.mechanics.declarations import Coordinate as Coordinate
    from painleve_sym.mechanics.declarations import DomainBound as DomainBound
    from painleve_sym.mechanics.declarations import Parameter as Parameter
    from painleve_sym.mechanics.formulas.formula import Formula as Formula
    from painleve_sym.mechanics.formulas.formula import ImpulsePhase as ImpulsePhase
    from painleve_sym.mechanics.formulas.formula import Section as Section
    from painleve_sym.mechanics.impact.impact_class import ImpactClass as ImpactClass
    from painleve_sym.mechanics.materials import Material as Material
    from painleve_sym.mechanics.materials import material as material
    from painleve_sym.mechanics.mechanism import Mechanism as Mechanism
    from painleve_sym.mechanics.mechanism import Place as Place
    from painleve_sym.mechanics.quaternions import Quaternion as Quaternion
    from painleve_sym.mechanics.shapes import Shape as Shape
    from painleve_sym.mechanics.shapes import ShapeKind as ShapeKind
    from painleve_sym.mechanics.spatial_bodies import Orientation as Orientation
    from painleve_sym.mechanics.spatial_bodies import SpatialBody as SpatialBody
    from painleve_sym.mechanics.system import TIME as TIME
    from painleve_sym.mechanics.system import LagrangianSystem as LagrangianSystem
    from painleve_sym.mechanics.toml.mechanism_file import load_mechanism as load_mechanism
    from painleve_sym.motion.batch.result import BatchResult as BatchResult
    from painleve_sym.motion.energy_gains import EnergyGain as EnergyGain
    from painleve_sym.motion.finite_stiffness import CorrectedJump as CorrectedJump
    from painleve_sym.motion.finite_stiffness import CorrectedJumpRule as CorrectedJumpRule
    from painleve_sym.motion.finite_stiffness import CorrectedPhase as CorrectedPhase
    from painleve_sym.motion.finite_stiffness import (
        evaluate_corrected_jump as evaluate_corrected_jump,
    )
    from painleve_sym.motion.frozen_impact import FrozenEnd as FrozenEnd
    from painleve_sym.motion.frozen_impact import FrozenImpactSolver as FrozenImpactSolver
    from painleve_sym.motion.records import EventRecord as EventRecord
    from painleve_sym.motion.records import Film as Film
    from painleve_sym.motion.records import Segment as Segment
    from painleve_sym.motion.rigidity import BodyPeriod as BodyPeriod
    from painleve_sym.motion.runs import simulate as simulate
    from painleve_sym.motion.runs import simulate_batch as simulate_batch
    from painleve_sym.motion.sensitivity.result import EventSensitivity as EventSensitivity
    from painleve_sym.motion.sensitivity.result import SensitiveTrajectory as SensitiveTrajectory
    from painleve_sym.motion.simulator import Simulator as Simulator
    from painleve_sym.motion.singular_limit import LimitKind as LimitKind
    from painleve_sym.motion.singular_limit import ReverseChatter as ReverseChatter
    from painleve_sym.motion.singular_limit import SingularLimit as SingularLimit
    from painleve_sym.motion.trajectory import Trajectory as Trajectory
    from painleve_sym.papers.registry import Reproduction as Reproduction
    from painleve_sym.papers.registry import reproduce as reproduce
    from painleve_sym.problem.coefficients import NormalCoefficients as NormalCoefficients
    from painleve_sym.problem.coefficients import Sector as Sector
    from painleve_sym.problem.complementarity.lcp import LCP as LCP
    from painleve_sym.problem.complementarity.uniqueness import Uniqueness as Uniqueness
    from painleve_sym.problem.contact_problem import ContactProblem as ContactProblem
    from painleve_sym.problem.friction_set import Brake as Brake
    from painleve_sym.problem.friction_set import Disc as Disc
    from painleve_sym.problem.friction_set import Interval as Interval
    from painleve_sym.problem.impact.chatter import Chatter as Chatter
    from painleve_sym.problem.impact.one_contact import Impact as Impact
    from painleve_sym.problem.impact.one_contact import ImpactEnd as ImpactEnd
    from painleve_sym.problem.impact.one_contact import (
        invariant_directions as invariant_directions,
    )
    from painleve_sym.problem.impact.one_contact import solve_impact as solve_impact
    from painleve_sym.problem.impact.path import ImpactPhase as ImpactPhase
    from painleve_sym.problem.impact.spatial import InvariantDirection as InvariantDirection
    from painleve_sym.problem.modes import ContactMode as ContactMode
    from painleve_sym.problem.one_contact import contact as contact
    from painleve_sym.problem.solution import ContactCase as ContactCase
    from painleve_sym.problem.solution import ContactSolution as ContactSolution
    from painleve_sym.progress import show_progress as show_progress
    from painleve_sym.references import Reference as Reference
    from painleve_sym.references import citation as citation
    from painleve_sym.robots.contact_risk import ContactRisk as ContactRisk
    from painleve_sym.robots.contact_risk import LeastRisk as LeastRisk
    from painleve_sym.robots.robot_contact import RobotContact as RobotContact
    from painleve_sym.robots.robot_model import Robot as Robot
    from painleve_sym.robots.robot_model import robot as robot
    from painleve_sym.study.comparisons.comparison import Comparison as Comparison
    from painleve_sym.study.comparisons.comparison import compare as compare
    from painleve_sym.study.critical.bisection import Border as Border
    from painleve_sym.study.critical.bisection import CriticalForce as CriticalForce
    from painleve_sym.study.critical.bisection import CriticalForceFinder as CriticalForceFinder
    from painleve_sym.study.critical.bisection import Outcome as Outcome
    from painleve_sym.study.critical.bisection import critical_force as critical_force
    from painleve_sym.study.critical.gradient import ForceDerivative as ForceDerivative
    from painleve_sym.study.critical.gradient import (
        critical_force_gradient as critical_force_gradient,
    )
    from painleve_sym.study.critical.sliding_solution import SlidingSolution as SlidingSolution
    from painleve_sym.study.fitting.data import FitData as FitData
    from painleve_sym.study.fitting.data import read_fit_data as read_fit_data
    from painleve_sym.study.fitting.problem import FitProblem as FitProblem
    from painleve_sym.study.fitting.problem import fit as fit
    from painleve_sym.study.fitting.result import FitResult as FitResult
    from painleve_sym.study.maps.region_map import RegionMap as RegionMap
    from painleve_sym.study.maps.region_map import region_map as region_map
    from painleve_sym.study.sweeps.runner import sweep as sweep
    from painleve_sym.study.sweeps.sweep import Sweep as Sweep

_NAMES = {
    "c_export.export": ("Export", "export_c"),
    "choices": ("EngineName", "Friction", "Policy", "Record", "Reload", "Restitution"),
    "codegen.named_mechanisms": ("model",),
    "problem.complementarity.lcp": ("LCP",),
    "problem.complementarity.uniqueness": ("Uniqueness",),
    "problem.impact.chatter": ("Chatter",),
    "at.classification": ("Classification",),
    "at.cases": ("classify",),
    "problem.friction_set": ("Brake", "Disc", "Interval"),
    "at.jump": ("JumpPhase", "JumpResult", "evaluate_jump"),
    "problem.impact.one_contact": ("Impact", "ImpactEnd", "invariant_directions", "solve_impact"),
    "problem.impact.path": ("ImpactPhase",),
    "problem.impact.spatial": ("InvariantDirection",),
    "at.tangential": ("TangentialImpact", "tangential_impact"),
    "problem.modes": ("ContactMode",),
    "problem.one_contact": ("contact",),
    "problem.coefficients": ("NormalCoefficients", "Sector"),
    "problem.contact_problem": ("ContactProblem",),
    "problem.solution": ("ContactCase", "ContactSolution"),
    "errors": (
        "EventKind",
        "InputError",
        "ModelError",
        "PainleveError",
        "PainleveWarning",
        "StopReason",
    ),
    "explorer.page": ("Page", "explore"),
    "automata.automaton": ("HybridAutomaton",),
    "laws.catalogue": ("LawsByContact", "law"),
    "laws.closed_forms": ("closed_forms",),
    "laws.compliance": ("Branch", "Exit"),
    "laws.contact_law": ("ContactLaw",),
    "laws.rigid_contact": ("RigidLaw",),
    "mechanics.bodies": ("Body", "Load", "Mode", "NaturalPeriod", "Spring"),
    "mechanics.coefficients": ("ContactCoefficients",),
    "mechanics.contact": ("Contact",),
    "mechanics.declarations": ("Coordinate", "DomainBound", "Parameter"),
    "mechanics.formulas.formula": ("Formula", "ImpulsePhase", "Section"),
    "mechanics.impact.impact_class": ("ImpactClass",),
    "mechanics.materials": ("Material", "material"),
    "mechanics.mechanism": ("Mechanism", "Place"),
    "mechanics.shapes": ("Shape", "ShapeKind"),
    "mechanics.quaternions": ("Quaternion",),
    "mechanics.spatial_bodies": ("Orientation", "SpatialBody"),
    "mechanics.system": ("LagrangianSystem", "TIME"),
    "mechanics.toml.mechanism_file": ("load_mechanism",),
    "motion.batch.result": ("BatchResult",),
    "motion.energy_gains": ("EnergyGain",),
    "motion.finite_stiffness": (
        "CorrectedJump",
        "CorrectedJumpRule",
        "CorrectedPhase",
        "evaluate_corrected_jump",
    ),
    "motion.frozen_impact": ("FrozenEnd", "FrozenImpactSolver"),
    "motion.rigidity": ("BodyPeriod",),
    "motion.sensitivity.result": ("EventSensitivity", "SensitiveTrajectory"),
    "motion.runs": ("simulate", "simulate_batch"),
    "motion.simulator": ("Simulator",),
    "motion.singular_limit": ("LimitKind", "ReverseChatter", "SingularLimit"),
    "motion.records": ("EventRecord", "Film", "Segment"),
    "motion.trajectory": ("Trajectory",),
    "papers.registry": ("Reproduction", "reproduce"),
    "progress": ("show_progress",),
    "references": ("Reference", "citation"),
    "robots.contact_risk": ("ContactRisk", "LeastRisk"),
    "robots.robot_model": ("Robot", "robot"),
    "robots.robot_contact": ("RobotContact",),
    "study.comparisons.comparison": ("Comparison", "compare"),
    "study.critical.bisection": (
        "Border",
        "CriticalForce",
        "CriticalForceFinder",
        "Outcome",
        "critical_force",
    ),
    "study.critical.gradient": ("ForceDerivative", "critical_force_gradient"),
    "study.critical.sliding_solution": ("SlidingSolution",),
    "study.fitting.data": ("FitData", "read_fit_data"),
    "study.fitting.problem": ("FitProblem", "fit"),
    "study.fitting.result": ("FitResult",),
    "study.maps.region_map": ("RegionMap", "region_map"),
    "study.sweeps.runner": ("sweep",),
    "study.sweeps.sweep": ("Sweep",),
}
_UPPER = {
    "animate": ("present.animation", "animated"),
    "explore": ("explorer.page", "explore_motion"),
    "html": ("present.notebook", "html"),
    "plot": ("present.trajectory_figure", "trajectory_figure"),
    "sensitivities": ("motion.sensitivity.variational", "differentiated"),
}
"""Functions to which methods of lower stages hand their work; see `hooks`."""
_HOMES = {name: home for home, names in _NAMES.items() for name in names}
_MODULES = ("laws", "models")

__all__ = sorted([*_HOMES, *_MODULES, "__version__"])


def _load(home: str, name: str) -> Any:
    return getattr(importlib.import_module(f"painleve_sym.{home}"), name)


for _method, _place in _UPPER.items():
    register(_method, partial(_load, *_place))


# Type checkers see the names above alone, so that they report a name that does not exist.
if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        if name in _MODULES:
            return importlib.import_module(f"painleve_sym.{name}")
        home = _HOMES.get(name)
        if home is None:
            raise AttributeError(f"module 'painleve_sym' has no attribute {name!r}")
        value = globals()[name] = _load(home, name)
        return value


def __dir__() -> list[str]:
    return __all__
