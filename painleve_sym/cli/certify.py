"""The command certify: a proof that a contact has no paradox on a box of states and parameters."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from painleve_sym.at.positive import NO_PARADOX, PositiveFunction, positive_function
from painleve_sym.cli.case import chosen_mechanism
from painleve_sym.cli.options import output_file, read_quantities, read_ranges
from painleve_sym.cli.output import number, print_json, show, show_notices
from painleve_sym.errors import InputError
from painleve_sym.files import read_text, write_beside
from painleve_sym.quantities import counted

if TYPE_CHECKING:
    from painleve_sym.certify.checker import Side
    from painleve_sym.certify.proof import Proof

MAX_BYTES = 30_000_000
"""Of a certificate."""
BOX = "0.2:1.4"
"""Ends that a message shows as an example."""


def certify(arguments: argparse.Namespace) -> int:
    """Prove or refute A > 0 on a box, or verify a certificate of it; 0 where it is proved."""
    mechanism = chosen_mechanism(arguments.model, arguments.contact)

    def units() -> dict[str, str]:
        return dict(mechanism.units)

    over = read_ranges("--over", arguments.over, units, BOX)
    held = read_quantities("--state", arguments.state, units)
    held |= read_quantities("--set", arguments.set, units)

    def derive(over: Mapping[str, Side]) -> PositiveFunction:
        return positive_function(mechanism, over, held)

    return answer(arguments, mechanism.name, {"mechanism": mechanism.name}, over, derive)


def claim_of(contact: str, values: Mapping[str, float]) -> str:
    """Return what a certificate claims of a contact, for the values of what does not vary."""
    fixed = ", ".join(f"{n} = {v!r}" for n, v in sorted(values.items()))
    return f"{contact}: {NO_PARADOX}, where {fixed}"


def answer(
    arguments: argparse.Namespace,
    title: str,
    data: dict[str, Any],
    over: dict[str, Side],
    derive: Callable[[Mapping[str, Side]], PositiveFunction],
    notices: Sequence[str] = (),
) -> int:
    """Say whether functions are positive on a box, or whether a certificate proves it.

    `derive` returns them for the quantities of a box in their order. `data` comes first in JSON,
    `title` first in text, notices last. 0 where it is proved or verified, else 1.
    """
    from painleve_sym.certify.proof import Decision, prove_positive

    positive = derive(over)
    if arguments.check is not None:
        if arguments.out:
            raise InputError("--out: --check writes no certificate. Fix: leave out one of the two.")
        text, pieces = _checked(arguments.check, title, over, derive)
        return _verdict(arguments, {**data, "over": over}, text, pieces, notices)
    claim = claim_of(title, positive.fixed)
    target = output_file("--out", arguments.out, (".json",)) if arguments.out else None
    proof = prove_positive(positive.function, positive.conditions, over, claim)
    written = target is not None and proof.certificate is not None
    if target is not None and written:
        content = (json.dumps(proof.certificate) + "\n").encode()
        write_beside(target, lambda file: file.write(content))
    if arguments.json:
        print_json({**data, "over": over, **proof.to_dict(), "notices": list(notices)})
    else:
        _show(title, over, proof)
        if written:
            show(f"written: {target}")
        show_notices(notices)
    return 0 if proof.verdict is Decision.PROVED else 1


def _show(title: str, over: dict[str, Side], proof: Proof) -> None:
    ends = (f"{n} from {number(a)} to {number(b)}" for n, (a, b) in over.items())
    show(f"{title}, {', '.join(ends)}")
    if proof.piece is None:
        show(f"proved: {NO_PARADOX}, on {counted(proof.pieces, 'piece')}")
        return
    piece = ", ".join(f"{n} from {a!r} to {b!r}" for n, (a, b) in proof.piece.items())
    reason = {
        "refuted": "which fails in the middle of this piece",
        "undecided": "whose bounds stay too wide on this piece",
    }[proof.verdict.value]
    show(f"{proof.verdict.value}: need {proof.condition}, {reason}: {piece}")


def _checked(
    path: str,
    title: str,
    over: dict[str, Side],
    derive: Callable[[Mapping[str, Side]], PositiveFunction],
) -> tuple[str, int | None]:
    """Return what became of a certificate in words, and its pieces where it is verified.

    Everything that it says is compared with what this command derives, before its pieces are
    verified: a file may not choose what is computed.
    """
    from painleve_sym.certify.checker import Rejected, check, refuse_other_form

    where = f"certificate {path}"
    text = read_text(path, where, MAX_BYTES, f"certificate of at most {MAX_BYTES} bytes")
    try:
        given = json.loads(text, object_pairs_hook=_without_twice)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where}: not JSON: {error}.") from error
    try:
        refuse_other_form(given)
        if key := _other_part(given, title, over, derive):
            return f"rejected: its {key} is not that of this command", None
        pieces = check(given)
    except Rejected as error:
        return f"rejected: {error}", None
    return f"verified: {counted(pieces, 'piece')}", pieces


def _without_twice(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object of JSON; ValueError where it has a key twice, of which readers see one."""
    content = dict(pairs)
    if len(content) < len(pairs):
        raise ValueError("a key is there twice")
    return content


def _other_part(
    given: Mapping[str, Any],
    title: str,
    over: dict[str, Side],
    derive: Callable[[Mapping[str, Side]], PositiveFunction],
) -> str:
    """Return the key of a certificate that differs from those of this command; empty for none.

    Its quantities may have another order: that of the inputs of its program.
    """
    from painleve_sym.certify.proof import certificate_of, degree_for

    order = [name for name, _, _ in given["over"]]
    if sorted(order) != sorted(over):
        return "over"
    over = {name: over[name] for name in order}
    function, conditions, fixed = derive(over)
    claim, degree = claim_of(title, fixed), degree_for(len(over))
    own = certificate_of(function, conditions, over, claim, degree, given["tree"])
    # Its hash is verified with its content.
    keys = [key for key in dict.fromkeys((*own, *given)) if key != "sha256"]
    return next((key for key in keys if own.get(key) != given.get(key)), "")


def _verdict(
    arguments: argparse.Namespace,
    data: dict[str, Any],
    text: str,
    pieces: int | None,
    notices: Sequence[str],
) -> int:
    if arguments.json:
        verdict = {"verdict": text.partition(":")[0], "pieces": pieces, "reason": text}
        print_json({**data, **verdict, "notices": list(notices)})
    else:
        show(text)
        show_notices(notices)
    return 1 if pieces is None else 0
