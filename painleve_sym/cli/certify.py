"""The command certify: a proof that a contact has no paradox on a box of states and parameters."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from painleve_sym.cli.case import chosen_mechanism
from painleve_sym.cli.options import output_file, read_quantities, read_ranges
from painleve_sym.cli.output import number, print_json, show, show_notices
from painleve_sym.contacts.positive import NO_PARADOX, PositiveFunction, positive_function
from painleve_sym.errors import InputError
from painleve_sym.files import read_text, write_beside
from painleve_sym.quantities import counted

if TYPE_CHECKING:
    from painleve_sym.certify.checker import Side
    from painleve_sym.certify.proof import Proof

MAX_BYTES = 500_000_000
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
    positive = positive_function(mechanism, over, held)
    return answer(arguments, mechanism.name, {"mechanism": mechanism.name}, over, positive)


def claim_of(contact: str, values: Mapping[str, float]) -> str:
    """Return what a certificate claims of a contact, for the values of what does not vary."""
    fixed = ", ".join(f"{n} = {v!r}" for n, v in sorted(values.items()))
    return f"{contact}: {NO_PARADOX}, where {fixed}"


def answer(
    arguments: argparse.Namespace,
    title: str,
    data: dict[str, str],
    over: dict[str, Side],
    positive: PositiveFunction,
    notices: Sequence[str] = (),
) -> int:
    """Say whether functions are positive on a box, or whether a certificate proves it.

    `data` comes first in JSON, `title` first in text, notices last. 0 where it is proved or
    verified, else 1.
    """
    from painleve_sym.certify.proof import Verdict, prove_positive

    claim = claim_of(title, positive.fixed)
    if arguments.check is not None:
        return _check(arguments, claim, over, positive)
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
    return 0 if proof.verdict is Verdict.PROVED else 1


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


def _check(
    arguments: argparse.Namespace, claim: str, over: dict[str, Side], positive: PositiveFunction
) -> int:
    """Verify a certificate against the formulas of this command, derived again."""
    from painleve_sym.certify.checker import Rejected, check
    from painleve_sym.certify.proof import certificate_of

    where = f"certificate {arguments.check}"
    try:
        given = json.loads(read_text(Path(arguments.check), where, MAX_BYTES, "certificate"))
        # Before the pieces are verified: a file may not choose what is computed.
        function, conditions, _ = positive
        own = certificate_of(function, conditions, over, claim, given["degree"], given["tree"])
        for key in ("claim", "conditions", "over", "program"):
            if own[key] != given[key]:
                return _verdict(arguments, f"rejected: its {key} is not that of this command", None)
        pieces = check(given)
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{where}: not JSON: {error}.") from error
    except (KeyError, TypeError) as error:
        return _verdict(arguments, f"rejected: it is damaged: {type(error).__name__}", None)
    except Rejected as error:
        return _verdict(arguments, f"rejected: {error}", None)
    return _verdict(arguments, f"verified: {counted(pieces, 'piece')}", pieces)


def _verdict(arguments: argparse.Namespace, text: str, pieces: int | None) -> int:
    if arguments.json:
        print_json({"verdict": text.partition(":")[0], "pieces": pieces, "reason": text})
    else:
        show(text)
    return 1 if pieces is None else 0
