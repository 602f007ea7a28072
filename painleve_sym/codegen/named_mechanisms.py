"""Mechanisms by name, described from the cache: their formulas are made when first asked for."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path

from painleve_sym.cache import read_entry, write_entry
from painleve_sym.codegen.derivation_cache import MECHANISM, entry_key
from painleve_sym.errors import InputError, NoFormulas, received, unknown_name
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import COUNTS, NAMED
from painleve_sym.mechanics.outline import MechanismOutline
from painleve_sym.plain_data import of_plain, to_plain
from painleve_sym.units import Value

_TEXTS = (
    *("name", "title", "source", "sketch", "start", "locked"),
    *("definition", "drawing_definition"),
)

ROBOT_FILES = (".urdf", ".xml", ".mjcf")
"""Suffixes of files of robots, whose contacts are mechanisms."""

MechanismLike = Mechanism | str | Path
"""A mechanism, its name, or the path of a mechanism file."""


def model(name: str | Path, **parameters: Value) -> Mechanism:
    """Return the named mechanism, or the one a mechanism file ending in .toml describes.

    Parameters
    ----------
    name : str or path
        A named mechanism is made once. ``rod-bending:5,3`` has five bending and three axial modes.
    **parameters : float
        Other defaults of its parameters; see `Mechanism.with_parameters`.

    Raises
    ------
    InputError
        Suggests the nearest name; for a file, what is wrong and in which line.

    Examples
    --------
    >>> from painleve_sym import model
    >>> model("rod", mu=1.5).parameters["mu"]
    1.5
    """
    if not isinstance(name, str | Path):
        raise InputError(f"mechanism: got {received(name)}, need a name or the path of a file.")
    name = str(name)
    if is_robot_file(name):
        raise NoFormulas(
            f"mechanism: got {name}, the file of a robot, which has no formulas. "
            "Fix: give the name or the file of a mechanism; robot(path).contact(frame) in Python "
            "has the numbers of a contact."
        )
    if name.endswith(".toml"):
        from painleve_sym.mechanics.toml.mechanism_file import load_mechanism

        mechanism = load_mechanism(name)
    else:
        mechanism = _named(name)
    return mechanism.with_parameters(**parameters) if parameters else mechanism


def is_robot_file(name: str) -> bool:
    """Whether this names the file of a robot, URDF or MJCF."""
    return name.endswith(ROBOT_FILES)


def as_mechanism(given: MechanismLike) -> Mechanism:
    """Return the mechanism itself, or the one of that name or file; see `model`."""
    if isinstance(given, Mechanism):
        return given
    if isinstance(given, str | Path):
        return model(given)
    raise InputError(f"mechanism: got {received(given)}, need a mechanism, its name or its file.")


def _maker(name: str) -> Callable[[], Mechanism]:
    """Return the function that makes a named mechanism, with the counts behind its name."""
    head, colon, text = name.partition(":")
    if head not in NAMED:
        raise InputError(unknown_name("model", name, NAMED))
    if not colon:
        return NAMED[head]
    counted, given = COUNTS.get(head, ()), text.split(",")
    if not counted:
        raise InputError(f"model {head!r}: got {text!r} behind the name, where nothing is counted.")
    if len(given) != len(counted) or not all(g.isascii() and g.isdigit() for g in given):
        example = ",".join("3" for _ in counted)
        raise InputError(
            f"model {head!r}: got {text!r} behind the name, need the numbers of "
            f"{' and '.join(counted)}, such as {head}:{example}."
        )
    return functools.partial(NAMED[head], *(int(g[:9]) for g in given))


@functools.lru_cache(maxsize=256)
def _named(name: str) -> Mechanism:
    return described(name, _maker(name))


def described(name: str, make: Callable[[], Mechanism]) -> Mechanism:
    """Return a mechanism of the package as the cache describes it; its formulas are made later.

    `make`, a function of the folders `MECHANISM`, makes all of it, and the name distinguishes it.
    """
    key = entry_key(f"mechanism {name}", by=MECHANISM)
    entry = read_entry(key) if key else None
    if entry is not None:
        outline = of_plain(MechanismOutline, entry["outline"])
        return Mechanism.deferred(make, outline=outline, **{text: entry[text] for text in _TEXTS})
    mechanism = make()
    texts = {text: getattr(mechanism, text) for text in _TEXTS}
    if key:
        write_entry(key, {"outline": to_plain(mechanism.outline), **texts})
    return mechanism
