"""Every exception, warning, stop reason and kind of event of the package."""

from __future__ import annotations

import difflib
import enum
from collections import Counter
from collections.abc import Iterable
from typing import Any, Self

MAX_MESSAGE, MAX_FAULT = 2000, 500
"""Characters of a message, and of one fault of a model: they may quote input of any size."""
MAX_NAME, MAX_COMPARED = 100, 1000
"""Length of a name, and number of names, among which the nearest to a mistyped one is sought."""
_NEAR = 0.6
"""Least ratio of `difflib` of two names of which one may be the other, mistyped."""
MAX_SHOWN = 80
"""Characters of a value in a message about its type."""
MAX_FAULTS, MAX_LISTED = 20, 4000
"""Faults that a message lists, and their characters in all; `ModelError.faults` has all of them."""


def shortened(message: str, limit: int = MAX_MESSAGE) -> str:
    """Return a message of about `limit` characters at most: its begin and its end.

    The begin names the place and the fault, the end the remedy; only the middle is left out.
    """
    if len(message) <= limit:
        return message
    begin, end = 2 * limit // 3, limit // 3
    left_out = len(message) - begin - end
    return f"{message[:begin]} ... ({left_out} characters left out) ... {message[-end:]}"


def received(value: Any) -> str:
    """Return what a message says of a value of another type than needed: type and begin."""
    if value is None or isinstance(value, bool | int | float | str):
        return shortened(repr(value), MAX_SHOWN)
    return f"{type(value).__name__} {shortened(' '.join(repr(value).split()), MAX_SHOWN)}"


class PainleveError(Exception):
    """Base of every exception the package raises on purpose; its message has a limited length."""

    def __init__(self, message: str = "") -> None:
        super().__init__(shortened(message))


class InputError(PainleveError, ValueError):
    """Invalid input; the message gives the place, the value received, and how to correct it."""


class NotPlanar(InputError):
    """A mechanism with contacts in space, where contacts in the plane are needed."""


class NoFormulas(InputError):
    """The file of a robot, whose contacts are numbers, where formulas of a mechanism are needed."""


class ModelError(InputError):
    """A mechanism, contact or law is ill-defined; the message lists all faults.

    Attributes
    ----------
    where : str
        What is ill-defined.
    faults : tuple of str
        One sentence per fault; the message has the first `MAX_FAULTS`, each of a limited length.
    """

    def __init__(self, where: str, faults: Iterable[str]) -> None:
        self.where = where
        self.faults = tuple(faults)
        listed = [shortened(fault, MAX_FAULT) for fault in self.faults[:MAX_FAULTS]]
        while sum(map(len, listed)) > MAX_LISTED:
            listed.pop()
        rest = len(self.faults) - len(listed)
        if rest:
            listed.append(f"And {rest} more.")
        # The parts are limited one by one, so that no sentence is cut by the others.
        Exception.__init__(self, f"{shortened(where)}: " + " ".join(listed))

    def __reduce__(self) -> tuple[type[ModelError], tuple[str, tuple[str, ...]], dict[str, Any]]:
        # An exception is pickled by its message alone, which is not what makes this one.
        return type(self), (self.where, self.faults), self.__dict__


def refuse_faulty(where: str, faults: Iterable[str]) -> None:
    """Raise ModelError where something has any fault."""
    every = tuple(faults)
    if every:
        raise ModelError(where, every)


class TranslationError(PainleveError):
    """A symbolic expression has no counterpart in generated code."""


class NoRecurrence(PainleveError):
    """An operation on the states has no recurrence of Taylor coefficients."""


class CompileError(PainleveError):
    """The C compiler rejected the generated source.

    Attributes
    ----------
    compiler_text : str
        Text of the compiler itself, which the message leaves out.
    """

    def __init__(self, message: str = "", compiler_text: str = "") -> None:
        super().__init__(message)
        self.compiler_text = compiler_text


class CompilerMissing(PainleveError):
    """There is no working C compiler."""


class DerivationTimeout(PainleveError):
    """Closed forms were not derived within the time allowed (`time_limit`)."""


class PainleveWarning(UserWarning):
    """A notice: the result is right, but something is not as the user may expect."""

    def __init__(self, message: str = "") -> None:
        super().__init__(shortened(message))


class Explained(enum.StrEnum):
    """Texts, each with a `sentence` on what it means or which change may help."""

    label: str
    sentence: str

    def __new__(cls, label: str, sentence: str = "") -> Self:
        """Return the member that is the text `label`."""
        member = str.__new__(cls, label)
        member._value_ = member.label = label
        member.sentence = sentence
        return member


class EventKind(Explained):
    """Kind of an event; `sentence` describes it in words."""

    SLIP_STOP = "slip_stop", "the slip velocity comes to zero"
    SLIP_START = "slip_start", "sticking needs more than friction can give"
    MAX_COMPRESSION = "max_compression", "compression ends, restitution begins"
    RELOAD = "reload", "compression begins again before separation"
    YIELD = "yield", "reloading passes the former maximum"
    SEPARATION = "separation", "the normal force falls to zero"
    LIFTOFF = "liftoff", "the gap opens"
    TOUCHDOWN = "touchdown", "the gap closes"
    LEFT_DOMAIN = "left_domain", "the mechanism leaves the domain of its model"
    CONTACT = "contact", "the contact problem was solved"
    IMPACT = "impact", "an impact begins"
    IMPACT_SLIP_STOP = "impact_slip_stop", "the slip ends within an impact"
    IMPACT_MAX_COMPRESSION = "impact_max_compression", "the compression of an impact ends"
    IMPACT_END = "impact_end", "an impact ends"
    SETTLE = "settle", "bounces have died out"
    SINGULAR = "singular", "A = 0 is met, the force grows without bound"
    JAM = "jam", "the impulse of an impact has no end"
    FORCE_REVERSAL = "force_reversal", "the force of the guide changes its side"
    TANGENTIAL_IMPACT = "tangential_impact", "a guide that jams stops the slip at once"
    APEX = "apex", "the rate of a gap or coordinate falls through zero, where it is watched"
    PEAK = "peak", "a state or output that is watched has a maximum"
    SECTION = "section", "a formula that is watched falls through zero"
    STROBE = "strobe", "a period that is watched is over"


class StopReason(Explained):
    """Reason for the end of an integration; `sentence` says which change may help."""

    T_END = ("t_end", "the end time was reached")
    UNTIL = ("until", "the event asked for happened")
    LEFT_DOMAIN = (
        "left_domain",
        "the mechanism left the domain its model is valid in; start elsewhere or end earlier",
    )
    STEP_LIMIT = ("step_limit", "max_steps was used up; raise max_steps or loosen rtol")
    EVENT_LIMIT = (
        "event_limit",
        "max_events was used up; raise max_events or end earlier (bounces of e = 1 never end)",
    )
    ACCUMULATION = (
        "accumulation",
        "events accumulate at a finite time (see the last event times); "
        "stop before it or use a law with a contact of finite duration",
    )
    NON_FINITE = (
        "non_finite",
        "the state or its rate became infinite or nan; check the parameters and the start",
    )
    STEP_UNDERFLOW = (
        "step_underflow",
        "the step size fell below round-off; loosen rtol or check for a singular state",
    )
    FORCE_JUMP = (
        "force_jump",
        "a force of the mechanism jumps where a velocity is 0 and holds the motion there; "
        "make the force continuous",
    )
    SINGULAR = (
        "singular",
        "the slip meets A = 0, where the rigid contact problem stops being regular; "
        "use a compliant contact or another policy to continue",
    )
    DYNAMIC_JAM = (
        "dynamic_jam",
        "the slip runs into A = B = 0, where the rigid contact force grows without bound (see "
        "limit for when and where); use a compliant contact to continue",
    )
    JAM = (
        "jam",
        "the contact impulse grows without end: the rigid impact has no exit; "
        "use a compliant contact",
    )
    VARYING_FRICTION = (
        "varying_friction",
        "a rigid impact slides under a friction that varies with the slip velocity, for which its "
        "path has no law here; use a compliant contact",
    )
    INVALID_START = (
        "invalid_start",
        "the contact law does not admit the start: inside the ground of a rigid contact, off its "
        "guide, or compressed as well as under an initial force; start elsewhere",
    )
    NO_MODE = (
        "no_mode",
        "no mode of the automaton admits the state; check the start state against the law",
    )

    @classmethod
    def from_label(cls, label: str) -> StopReason:
        """Return the member whose `label` this is; raise InputError for an unknown one."""
        by_label = {member.label: member for member in cls}
        refuse_unknown("stop reason", label, by_label)
        return by_label[label]


def repeated(names: Iterable[str]) -> list[str]:
    """Return the names that occur more than once, in alphabetical order."""
    return sorted(name for name, count in Counter(names).items() if count > 1)


def refuse_unknown(kind: str, name: object, known: Iterable[str], where: str = "") -> None:
    """Raise InputError for a name that is not one of those known; `where` begins the message."""
    names = list(known)
    if name not in names:
        raise InputError(f"{where}: " * bool(where) + unknown_name(kind, name, names))


def unknown_name(kind: str, name: object, known: Iterable[str]) -> str:
    """Return sentences on an unknown name, the nearest known one and all that are known.

    Where it is the text of a known symbol, the symbols differ by their assumptions.
    """
    name = name if isinstance(name, str) else repr(name)
    names = sorted(map(str, known))
    if name in names:
        return (
            f"{kind} {name!r} is another symbol than the declared one of this name: its "
            f"assumptions differ, as those of Symbol({name!r}) without real=True do. Fix: take "
            "the `symbol` of the declaration."
        )
    # Comparing takes the product of both lengths, too long for names of a thousand letters.
    compared = [n for n in names if len(n) <= MAX_NAME] if len(name) <= MAX_NAME else []
    near = difflib.get_close_matches(name, compared[:MAX_COMPARED], n=1, cutoff=_NEAR)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    listed = shortened(", ".join(names)) if names else "none"
    return f"unknown {kind} {shortened(repr(name), MAX_NAME)}.{hint} Known: {listed}."
