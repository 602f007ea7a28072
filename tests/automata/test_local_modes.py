"""In every memory of a contact one row of its table of local modes holds, and says what it does."""

from dataclasses import replace

import pytest
import sympy as sp

from painleve_sym.automata.compliant import CompliantInterface
from painleve_sym.automata.contact_forces import Known
from painleve_sym.automata.model import CONTACT
from painleve_sym.automata.plural_contacts import PluralContacts
from painleve_sym.automata.rigid import RigidInterface
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator

ZERO, GIVEN, UNKNOWN = Known
# Local mode: normal force, friction, whether gap and slip velocity move.
RIGID = {
    "flight": (ZERO, ZERO, True, True),
    "touch": (ZERO, ZERO, False, True),
    "slip": (UNKNOWN, GIVEN, False, True),
    "stick": (UNKNOWN, UNKNOWN, False, False),
    "bound": (UNKNOWN, GIVEN, False, False),
}
COMPLIANT = {
    "flight": (ZERO, ZERO, True, True),
    "slip": (GIVEN, GIVEN, True, True),
    "stick": (GIVEN, UNKNOWN, True, False),
    "bound": (GIVEN, GIVEN, True, False),
}
SPRING = COMPLIANT | {name: (GIVEN, GIVEN, True, True) for name in ("slip", "stick")}


CASES = {
    "rigid": ("rigid", {}, RIGID),
    "guide": ("rigid", {}, RIGID),
    "compliant": ("bilinear-hertz", {}, COMPLIANT),
    "compliant beside rigid": ("A=hertz,B=rigid", {"friction": "static"}, COMPLIANT),
    "spring": ("linear", {"friction": "spring"}, SPRING),
}


def memories(contact):
    """Yield names of local modes with memory of each, which is 0 where it is not named."""
    sign, sticks = contact.sign, contact.sticks
    match contact:
        case RigidInterface():
            yield "touch", {sticks: 1}
            closed = [{contact.closed: 1}]
        case CompliantInterface():
            closed = [{contact.flags[branch]: 1} for branch in contact.branches]
        case _:
            closed = [{}]
    if closed != [{}]:
        yield "flight", {}
    for own in closed:
        yield "stick", own | {sticks: 1}
        for slip in (-1, 1):
            yield "slip", own | {sign: slip}
            if contact.target == CONTACT:
                yield "bound", own | {sign: slip, sticks: 1}


@pytest.mark.parametrize("case", CASES)
def test_one_row_of_the_table_holds_in_each_local_mode(case):
    name, choices, expected = CASES[case]
    block = model("block-two-feet")
    first, second = block.contacts
    block = replace(block, contacts=(replace(first, bilateral=case == "guide"), second))
    contact = PluralContacts(Simulator(block, law(name, **choices)).contact).interfaces[0]
    unset = dict.fromkeys(contact.memory, 0) | {
        contact.row.contact.friction: 1,
        "static_ratio": 1.2,
    }
    for name, memory in memories(contact):
        flags = [sp.sympify(mode.flag).subs(unset | memory) for mode in contact.forces.table]
        assert sorted(flags) == [0] * (len(flags) - 1) + [1], name
        assert tuple(contact.forces.table[flags.index(1)][1:]) == expected[name], name
