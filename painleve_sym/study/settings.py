"""The settings of a case, each said once: key of a scenario file, option of commands, unit, help.

Nothing that computes is imported here, since a page of help needs none of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

from painleve_sym.choices import (
    EngineLike,
    EngineName,
    ImpactFriction,
    ImpactFrictionLike,
    Restitution,
    RestitutionLike,
)


class Setting(NamedTuple):
    """A field of `CaseSettings`: its type without None, and the option of the commands of `group`.

    `bounds` of a number are those of `checks.number`. What a file alone can say has no option.
    """

    type: str
    option: str
    metavar: str
    help: str
    group: str
    unit: str | None
    bounds: Mapping[str, float]


def _of(
    group: str, text: str, default: Any = None, unit: str | None = None, **bounds: float
) -> Any:
    """Return a field whose option is described by ``METAVAR: help``."""
    given: Any = {"default_factory": dict} if default is dict else {"default": default}
    return field(**given, metadata={"option": (*text.split(": ", 1), group, unit, bounds)})


@dataclass(frozen=True)
class CaseSettings:
    """Settings of a case, from a file or the command line; None stands for the default."""

    model: str
    state: Mapping[str, float] | None = _of(
        "case",
        "NAME=VALUE,...: such as theta=1,theta_dot=5, others 0; by default the mechanism's own"
        " start",
    )
    parameters: Mapping[str, float] = _of(
        "case", "NAME=VALUE,...: parameters of the mechanism, such as mu=1.2,m=0.2", dict
    )
    material: str | None = _of(
        "case", "NAME: sets what it provides (`painleve materials`): steel, or two"
    )
    contact: str | None = _of("case", "NAME: of several contacts, consider this one alone")
    close: str | None = _of(
        "case", "COORDINATE: solve gap = 0 for it; of several contacts CONTACT:COORDINATE"
    )
    law: str | None = _of("law", "NAME: contact law (`painleve laws` lists them)")
    law_parameters: Mapping[str, float] = _of(
        "law",
        "NAME=VALUE,...: parameters and choices of the law, such as E=209e9,reload=elastic",
        dict,
    )
    law_choices: Mapping[str, str] = field(default_factory=dict)
    t_end: float | None = _of("motion", "TIME: end time, s", unit="s", above=0.0)
    until: tuple[str, ...] = _of(
        "motion",
        "EVENT,...: end at the first event of these kinds, such as separation; before_touchdown"
        " ends before it",
        (),
    )
    watch: Sequence[str] = _of(
        "motion",
        "EVENT,...: record these, too: apex, apex(y), peak(normal_force), section(FORMULA),"
        " strobe(PERIOD,OFFSET)",
        (),
    )
    initial_force: float | None = _of(
        "motion", "N: start compressed so that the contact carries this force, N", unit="N", lower=0
    )
    phases: tuple[Mapping[str, Any], ...] = _of(
        "motion",
        "TIME:NAME=VALUE,...;...: from these times on, s, other parameters (or law=NAME,"
        " contacts=A+B)",
        (),
    )
    inputs: Mapping[str, Any] = _of(
        "motion",
        "NAME=FILE,...: inputs or parameters as functions of time, from CSV files; held,"
        " or FILE:linear, FILE:cubic",
        dict,
    )
    rtol: float | None = _of("motion", "X: relative tolerance, from 1e-15 up to 1")
    max_steps: int | None = _of("motion", "N: stop after N steps, by default 1e6")
    max_events: int | None = _of("motion", "N: stop after N events, by default 1e5")
    engine: EngineLike = _of(  # noqa: RUF009 - a field
        "run", "NAME: auto (default), compiled, taylor or erk", EngineName.AUTO
    )
    samples: int | None = _of("run", "N: also give state and forces at N evenly spaced times")
    contact_velocity: tuple[float, ...] | None = _of(
        "jump",
        "N,T: m/s along n and t, in space n, t1, t2: velocities of the state are changed for it",
    )
    restitution: float | None = _of(
        "jump", "E: coefficient in [0, 1], by default 0.75", lower=0.0, upper=1.0
    )
    rule: RestitutionLike = _of(  # noqa: RUF009 - a field
        "jump", f"RULE: {', '.join(Restitution)}; energetic by default", Restitution.ENERGETIC
    )
    impact_friction: ImpactFrictionLike = _of(  # noqa: RUF009 - a field
        "jump",
        "SLIP: that friction opposes: path, of each moment (default), or final_slip, by newton",
        ImpactFriction.PATH,
    )
    robot: Mapping[str, Any] = field(default_factory=dict)
    csv: Mapping[str, Any] = field(default_factory=dict)
    title: str = ""


_OPTIONS = {"parameters": "--set", "law_parameters": "--law-set"}
"""Options that have another name than the field."""
SETTINGS: Mapping[str, Setting] = {
    f.name: Setting(
        f.type.removesuffix(" | None"),
        _OPTIONS.get(f.name, f"--{f.name.replace('_', '-')}"),
        *f.metadata.get("option", ("", "", "", None, {})),
    )
    for f in fields(CaseSettings)
}
"""The settings by the names of their fields."""
