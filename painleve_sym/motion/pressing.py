"""Whether a contact law holds: depth of the contact against its radius, pressure against yield."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from painleve_sym.laws.catalogue import Law, OwnLaw
from painleve_sym.mechanics.materials import Material
from painleve_sym.motion.records import EventRecord

DEPTH = 0.1
"""Part of the radius: at this depth the contact is a third of the radius wide, no half-space."""
YIELD = 1.6
"""Pressure in the middle of a circular contact over the yield strength at which a body yields.

Johnson (1985), section 6.1, for Poisson's ratio 0.3."""
_ELASTIC = ("hertz", "hunt-crossley")
"""Laws of a contact that stays elastic: others have the yielding in their curves."""


@dataclass(frozen=True)
class ContactSurface:
    """Surface of a compliant contact: its radius, m, and the yield strength of its material, Pa.

    The yield strength is that of the softer body, `material`; 0 where it is not known, or where the
    law is not elastic.
    """

    contact: str
    radius: float
    yield_strength: float = 0.0
    material: str = ""


def contact_surfaces(
    contacts: Sequence[str],
    laws: Sequence[Law],
    own_laws: Sequence[OwnLaw],
    values: Mapping[str, float],
    materials: Sequence[Material] = (),
) -> tuple[ContactSurface, ...]:
    """Return the surface of every contact whose law has a radius.

    Parameters
    ----------
    contacts : sequence of str
    laws, own_laws : sequence of Law
        One for all contacts, or one for each; and those of each contact in its own symbols.
    values : mapping of str to float
        Parameters of the own laws.
    materials : sequence of Material
        Of both bodies; empty where they are not known.
    """
    surfaces = []
    for i, (contact, own) in enumerate(zip(contacts, own_laws, strict=True)):
        law = laws[min(i, len(laws) - 1)]
        names = {p.name: q.name for p, q in zip(law.parameters, own.parameters, strict=False)}
        curvature = sum(values[names[k]] for k in ("kappa_1", "kappa_2") if k in names)
        if "R" in names:
            curvature = 1 / values[names["R"]]
        if not curvature > 0:
            continue
        known = [m for m in materials if "yield_strength" in m.properties]
        if law.name not in _ELASTIC or not known:
            surfaces.append(ContactSurface(contact, 1 / curvature))
            continue
        softer = min(known, key=lambda m: m.yield_strength)
        strength = softer.yield_strength
        surfaces.append(ContactSurface(contact, 1 / curvature, strength, softer.name))
    return tuple(surfaces)


def pressing_notices(
    surfaces: Sequence[ContactSurface], events: Sequence[EventRecord], final: Mapping[str, float]
) -> tuple[str, ...]:
    """Return a sentence for each contact that is pressed deeper or harder than its law holds for.

    `final` are the outputs at the end. Depths and pressures are those at events and at the end.
    """
    sentences = []
    for surface in surfaces:
        end = f"_{surface.contact}" if f"gap_{surface.contact}" in final else ""
        pairs = [
            (e.compression, e.normal_force)
            for e in events
            if e.contact in ("", surface.contact) and e.normal_force > 0
        ]
        pairs.append((-final[f"gap{end}"], final[f"normal_force{end}"]))
        depth = max(d for d, _ in pairs)
        name, radius = surface.contact, surface.radius
        if depth > DEPTH * radius:
            sentences.append(
                f"Contact {name} is pressed {depth:.3g} m deep, {depth / radius:.2g} times its "
                f"radius of {radius:.3g} m: the law holds for depths up to a tenth of it."
            )
        # The circle of contact has the radius sqrt(R depth), the pressure is Hertz's.
        pressure = max((1.5 * f / (math.pi * radius * d) for d, f in pairs if d > 0), default=0.0)
        strength = surface.yield_strength
        if 0 < YIELD * strength < pressure:
            sentences.append(
                f"The pressure in contact {name} reaches {pressure:.2g} Pa, and {surface.material} "
                f"yields from {YIELD * strength:.2g} Pa ({YIELD} times its yield strength): the "
                "contact is not elastic there."
            )
    return tuple(sentences)
