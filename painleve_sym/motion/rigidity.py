"""Whether bodies may count as rigid in an impact: contact durations against natural periods."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from painleve_sym.codegen.quantities import quantities
from painleve_sym.errors import EventKind
from painleve_sym.mechanics.materials import Material
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.records import EventRecord

RIGID_PERIODS = 10
"""A contact of this many periods leaves at most a tenth of the static deflection in vibration.

Half a sine of duration τ leaves 2 r/(1 − r²) of it, r = T/(2 τ)."""
_MATERIAL_ARGUMENTS = ("density_of_material", "modulus_of_material")


@dataclass(frozen=True)
class BodyPeriod:
    """A natural period of a body of a motion, s; where not `modelled`, the body is rigid in it.

    The material is that from which the period follows; empty where the mechanism says it.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> run = ps.simulate("rod", "bilinear-hertz", t_end=1e-2, material="steel")
    >>> period = run.body_periods[0]
    >>> f"{period.body}, {period.mode}: {period.period:.4f} s"
    'rod, first bending mode: 0.0990 s'
    """

    body: str
    mode: str
    period: float
    modelled: bool
    material: str = ""


def body_periods(
    mechanism: Mechanism, values: Mapping[str, float], material: Material | None = None
) -> tuple[BodyPeriod, ...]:
    """Return the natural periods of the bodies with these parameters.

    Of modes that the mechanism has, the shortest period of each kind; of a rigid body the longest.
    Without the material of the bars nothing is known of them.
    """
    declared = mechanism.outline.periods
    known = [p for p in declared if material is not None or not p.of_material]
    if not known:
        return ()
    names = (*(p.name for p in mechanism.outline.parameters), *_MATERIAL_ARGUMENTS)

    def formulas() -> tuple[Mapping[str, Any], Sequence[Any]]:
        from painleve_sym.mechanics.bodies import DENSITY, MODULUS

        every = {f"period_{i}": p.period for i, p in enumerate(mechanism.natural_periods)}
        return every, (*(p.symbol for p in mechanism.system.parameters), DENSITY, MODULUS)

    # The definition of a mechanism does not have its periods, from which no motion is derived.
    text = "\n".join((mechanism.definition, *(p.formula for p in declared)))
    of_material = (material.density, material.young_modulus) if material else (1.0, 1.0)
    given = {**values, **dict(zip(_MATERIAL_ARGUMENTS, of_material, strict=True))}
    numbers = quantities("natural periods", text, names, formulas)(given)
    periods: dict[tuple[str, str], BodyPeriod] = {}
    for p, period in zip(declared, numbers.values(), strict=True):
        if p not in known:
            continue
        name = material.name if material is not None and p.of_material else ""
        own = BodyPeriod(p.body, p.mode, period, p.modelled, name)
        before = periods.get((p.body, p.mode))
        if before is None or own.period < before.period:
            periods[p.body, p.mode] = own
    return tuple(periods.values())


def contact_durations(events: Iterable[EventRecord]) -> dict[str, float]:
    """Return for each contact the shortest time from its beginning to its end; s.

    A contact begins at the start of the motion or where it touches down, and ends where its normal
    force falls to zero. Impacts of rigid contacts have no duration, and one that lasts to the end
    of the motion does not count.
    """
    began: dict[str, float] = {}
    closed: dict[str, bool] = {}
    shortest: dict[str, float] = {}
    for event in events:
        name = event.contact
        if event.kind is EventKind.TOUCHDOWN:
            began[name], closed[name] = event.time, True
        elif event.kind is EventKind.SEPARATION and closed.get(name, True):
            duration = event.time - began.get(name, 0.0)
            shortest[name] = min(duration, shortest.get(name, duration))
            closed[name] = False
    return {name: duration for name, duration in shortest.items() if duration > 0}


def rigidity_notices(
    durations: Mapping[str, float], periods: Sequence[BodyPeriod]
) -> tuple[str, ...]:
    """Return a sentence for each body whose vibration an impact excites and the motion leaves out.

    The durations, s, are those of the shortest contact by the contact's name.
    """
    if not durations:
        return ()
    contact, duration = min(durations.items(), key=lambda pair: pair[1])
    lasts = f"The contact {contact} lasts {duration:.2g} s"
    sentences = []
    for p in periods:
        ratio = duration / p.period
        if p.modelled and ratio < 1:
            sentences.append(
                f"{lasts}, and the {p.mode} of {p.body} in this mechanism have periods down to "
                f"{p.period:.2g} s: further modes take part. Fix: take more of them."
            )
        elif not p.modelled and ratio < RIGID_PERIODS:
            of_bar = f" of a {p.material} bar of this mass and length" if p.material else ""
            verdict = (
                f"{p.body} is not rigid in this impact"
                if ratio < 1
                else f"the vibration of {p.body} that is left out is more than a tenth of its "
                "deflection"
            )
            sentences.append(
                f"{lasts}; the period of the {p.mode}{of_bar} is {p.period:.2g} s: {verdict}. "
                "A body with modes, such as rod-bending, has this vibration."
            )
    return tuple(sentences)
