"""Certificates forged so that all that they say agrees with itself: none proves another claim."""

from __future__ import annotations

import copy
import itertools
import json
import time

import pytest

from painleve_sym.certify.checker import MAX_PIECES, Rejected, check, digest
from painleve_sym.cli.certify import MAX_BYTES
from tests.cli.cli_helpers import run, run_json

pytest.importorskip("flint", reason="needs the extra certify (python-flint)")

BOX = ("--over", "theta=0.5:1.38,mu=1.0:1.2")
PROVED = ("certify", "rod", *BOX)
SWAPPED = ("certify", "rod", "--over", "theta=1.0:1.2,mu=0.5:1.38")
"""The rod has a paradox from mu = 4/3 on, so that this is false."""
ARM = ("robot", "tests/robots/files/two_link.urdf", "--contact", "tip", "--certify", "--mu", "0.9")
POSES = ("theta_1=-0.6:-0.5", "theta_2=-1.2:-1.1")
"""With the ranges of both exchanged, this is false."""


def certificate_by(capsys, folder, *command):
    """Return the certificate that a command writes."""
    file = folder / "written.json"
    assert run_json(capsys, *command, "--out", str(file))["verdict"] == "proved"
    return json.loads(file.read_text())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("forgeries")


@pytest.fixture
def genuine(capsys, folder):
    return certificate_by(capsys, folder, *PROVED)


def checked(capsys, folder, content, *command):
    """Return exit status and text of a command that verifies a certificate with this content."""
    file = folder / "checked.json"
    file.write_text(content if isinstance(content, str) else json.dumps(content))
    code, out, err = run(capsys, *command, "--check", str(file))
    return code, " ".join((out + err).split())


def sealed(content):
    return content | {"sha256": digest(content)}


def test_names_exchanged_in_the_box_do_not_prove_the_other_box(capsys, folder, genuine):
    assert run(capsys, *SWAPPED)[0] == 1
    (theta, *first), (mu, *second) = genuine["over"]
    assert (theta, mu) == ("theta", "mu")
    for over in ([["mu", *first], ["theta", *second]], [["theta", *second], ["mu", *first]]):
        forged = sealed(genuine | {"over": over})
        code, said = checked(capsys, folder, forged, *SWAPPED)
        assert (code, said.startswith("rejected: its program")) == (1, True) or "confirmed" in said
    # Format 2 had a mapping.
    mapping = sealed(genuine | {"over": {"mu": first, "theta": second}})
    assert checked(capsys, folder, mapping, *SWAPPED)[0] == 1


def test_honest_certificate_is_verified_in_every_order(capsys, folder, genuine):
    other = ("certify", "rod", "--over", "mu=1.0:1.2,theta=0.5:1.38")
    backwards = dict(reversed(genuine.items()))
    whole = genuine | {"over": [genuine["over"][0], ["mu", 1, 1.2]]}
    texts = [
        json.dumps(genuine, sort_keys=True),
        json.dumps(backwards, indent=1),
        json.dumps(whole),
        json.dumps(certificate_by(capsys, folder, *other)),
    ]
    for text, command in itertools.product(texts, (PROVED, other)):
        code, said = checked(capsys, folder, text, *command)
        assert code == 0 and said.startswith("verified: ")


def test_consistent_exchange_of_the_inputs_is_the_same_claim(capsys, folder, genuine):
    exchanged = copy.deepcopy(genuine)
    exchanged["over"].reverse()
    exchanged["tree"] = [1 - n if isinstance(n, int) else n for n in exchanged["tree"]]
    code, said = checked(capsys, folder, sealed(exchanged), *PROVED)
    assert code == 1 and said.startswith("rejected: its program is not")
    own = certificate_by(capsys, folder, "certify", "rod", "--over", "mu=1.0:1.2,theta=0.5:1.38")
    assert [name for name, *_ in own["over"]] == ["mu", "theta"] and own["program"] != genuine[
        "program"
    ]


def constant(content):
    """Give a certificate functions that are 1 everywhere, and the bounds of those."""
    count = len(content["conditions"])
    content["program"] = [["const", 0, [(1.0).hex()]], *(["output", k, [0]] for k in range(count))]
    content["tree"] = [[(0.5).hex()] * count]


def fewer(content):
    """Leave out the first condition, its result and its bounds."""
    content["conditions"].pop(0)
    program = [s for s in content["program"] if s[0] != "output" or s[1] != 0]
    content["program"] = [[n, p - 1 if n == "output" else p, t] for n, p, t in program]
    content["tree"] = [n if isinstance(n, int) else n[1:] for n in content["tree"]]


def halved(content):
    """Halve each piece once more: bounds of a piece hold on both halves."""
    nodes = [[n] if isinstance(n, int) else [0, n, n] for n in content["tree"]]
    content["tree"] = [node for group in nodes for node in group]


def weaker(content):
    """Divide the bounds by two: less is claimed."""
    content["tree"] = [
        n if isinstance(n, int) else [(float.fromhex(b) / 2).hex() for b in n]
        for n in content["tree"]
    ]


def stronger(content, k):
    leaf = next(n for n in content["tree"] if isinstance(n, list))
    leaf[k] = (50.0).hex()


FORGED = {
    "format": (lambda c: c.update(format="painleve-certificate 2"), "its format is not"),
    "claim of another parameter": (
        lambda c: c.update(claim=c["claim"].replace("l = ", "l = 2")),
        "its claim is not",
    ),
    "claim of everything": (lambda c: c.update(claim="everything"), "its claim is not"),
    "no claim": (lambda c: c.pop("claim"), "its claim is not"),
    "other words of a condition": (
        lambda c: c["conditions"].__setitem__(0, "x > 0"),
        "its conditions is not",
    ),
    "order of conditions": (lambda c: c["conditions"].reverse(), "its conditions is not"),
    "a condition fewer": (fewer, "its conditions is not"),
    "wider box": (lambda c: c["over"][0].__setitem__(2, 1.5), "its over is not"),
    "narrower box": (lambda c: c["over"][0].__setitem__(1, 0.6), "its over is not"),
    "another quantity": (lambda c: c["over"][1].__setitem__(0, "alpha"), "its over is not"),
    "a quantity fewer": (lambda c: c["over"].pop(), "its over is not"),
    "a quantity more": (lambda c: c["over"].append(["g", 9.0, 10.0]), "its over is not"),
    "a quantity twice": (lambda c: c["over"].append(["mu", 1.0, 1.2]), "each name once"),
    "ends as words": (lambda c: c["over"][0].__setitem__(1, "0.5"), "ends finite"),
    "an infinite end": (lambda c: c["over"][0].__setitem__(1, float("-inf")), "ends finite"),
    "another degree": (lambda c: c.update(degree=c["degree"] - 1), "its degree is not"),
    "degree as a truth": (lambda c: c.update(degree=True), "its degree is not"),
    "functions that are 1": (constant, "its program is not"),
    "program without its last step": (lambda c: c["program"].pop(), "its program is not"),
    "another constant": (
        lambda c: next(s for s in c["program"] if s[0] == "const")[2].__setitem__(0, (0.5).hex()),
        "its program is not",
    ),
    "a remark": (lambda c: c.update(remark="it holds for every mu"), "its remark is not"),
    "bound of the first condition": (lambda c: stronger(c, 0), "not confirmed"),
    "bound of the last condition": (lambda c: stronger(c, -1), "not confirmed"),
    "a piece fewer": (lambda c: c["tree"].pop(), "do not cover"),
    "side that is none": (lambda c: c["tree"].__setitem__(0, -1), "halves side -1"),
    "truth as a side": (lambda c: c["tree"].__setitem__(0, True), "damaged"),
}


@pytest.mark.parametrize("name", FORGED)
def test_forged_field_is_rejected_with_all_else_consistent(capsys, folder, genuine, name):
    change, reason = FORGED[name]
    change(genuine)
    code, said = checked(capsys, folder, sealed(genuine), *PROVED)
    assert code == 1 and said.startswith("rejected: ") and reason in said


@pytest.mark.parametrize("change", [constant, fewer])
def test_checker_alone_verifies_what_is_written_and_no_model(capsys, folder, genuine, change):
    # Which is why the command derives the functions again.
    change(genuine)
    assert check(sealed(genuine)) >= 1
    assert checked(capsys, folder, sealed(genuine), *PROVED)[0] == 1


@pytest.mark.parametrize("change", [halved, weaker])
def test_other_proof_of_the_same_claim_is_verified(capsys, folder, genuine, change):
    pieces = check(genuine)
    change(genuine)
    code, said = checked(capsys, folder, sealed(genuine), *PROVED)
    assert code == 0 and said.startswith("verified: ")
    assert check(sealed(genuine)) == pieces * (2 if change is halved else 1)


def test_hash_is_that_of_the_content(capsys, folder, genuine):
    weaker(genuine)
    code, said = checked(capsys, folder, genuine, *PROVED)
    assert code == 1 and said == "rejected: its content does not have the hash that it names"


MODELS = [
    PROVED,
    ("certify", "rod", *BOX, "--set", "g=9"),
    ("certify", "rod", *BOX, "--set", "l=2"),
    ("certify", "rod-3d", *BOX),
    ("certify", "rod", "--over", "theta=0.5:1.3,mu=1.0:1.2"),
]


def test_mixture_of_certificates_is_none(capsys, folder):
    """Fields of two certificates together prove the claim of neither, unless they are equal."""
    written = [certificate_by(capsys, folder, *command) for command in MODELS]
    first, fields = written[0], ("claim", "conditions", "over", "degree", "program")
    for other, command in zip(written[1:], MODELS[1:], strict=True):
        differ = [key for key in fields if first[key] != other[key]]
        assert differ
        for count in range(len(differ)):
            for taken in itertools.combinations(differ, count):
                mixed = sealed(other | {key: first[key] for key in taken})
                code, said = checked(capsys, folder, mixed, *PROVED)
                assert code == 1 and said.startswith("rejected: its "), (command, taken)


def test_robot_with_names_exchanged_is_rejected(capsys, folder):
    genuine = certificate_by(capsys, folder, *ARM, "--over", ",".join(POSES))
    (one, *first), (two, *second) = genuine["over"]
    for command in (POSES, POSES[::-1]):
        said = checked(capsys, folder, genuine, *ARM, "--over", ",".join(command))
        assert said[0] == 0 and said[1].startswith("verified: ")
    swapped = f"{one}={second[0]}:{second[1]},{two}={first[0]}:{first[1]}"
    assert run(capsys, *ARM, "--over", swapped)[0] == 1
    for over in ([[two, *first], [one, *second]], [[one, *second], [two, *first]]):
        forged = sealed(genuine | {"over": over})
        code, said = checked(capsys, folder, forged, *ARM, "--over", swapped)
        assert code == 1 and said.startswith("rejected: ")


def test_answer_to_a_certificate_says_of_what_it_is(capsys, folder):
    genuine = certificate_by(capsys, folder, *ARM, "--over", ",".join(POSES))
    file = folder / "arm.json"
    file.write_text(json.dumps(genuine))
    data = run_json(capsys, *ARM, "--over", ",".join(POSES), "--check", str(file))
    proof = run_json(capsys, *ARM, "--over", ",".join(POSES))
    for key in ("robot", "contact", "over", "notices", "pieces"):
        assert data[key] == proof[key]
    assert data["verdict"] == "verified" and data["notices"]


# ---- work ----


def test_tree_with_more_pieces_than_a_proof_has_is_refused_at_once(capsys, folder, genuine):
    leaf = next(n for n in genuine["tree"] if isinstance(n, list))
    # A complete tree of 65536 pieces, in the order of a walk.
    tree = [leaf]
    for _ in range(16):
        tree = [0, *tree, *tree]
    begun = time.perf_counter()
    code, said = checked(capsys, folder, sealed(genuine | {"tree": tree}), *PROVED)
    assert time.perf_counter() - begun < 5
    assert code == 1 and said == (
        f"rejected: its tree has 131071 entries, need at most {2 * MAX_PIECES - 1}"
    )


def test_file_of_any_length_is_one_sentence(capsys, folder):
    long = "[" * 100_000
    code, said = checked(capsys, folder, long, *PROVED)
    assert code == 2 and "not JSON" in said
    code, said = checked(capsys, folder, " " * (MAX_BYTES + 1), *PROVED)
    assert code == 2 and f"got more than {MAX_BYTES} bytes" in said
    code, said = checked(capsys, folder, '{"claim": 1, "claim": 2}', *PROVED)
    assert code == 2 and "a key is there twice" in said
    for text in ("[]", "7", "null", '"a"', "{}"):
        code, said = checked(capsys, folder, text, *PROVED)
        assert code == 1 and "rejected: its format is not" in said


def test_lists_in_place_of_anything_are_one_sentence(capsys, folder, genuine):
    for key, value in itertools.product(genuine, ([[]] * 50, {}, None, 0, "", [[[0]]])):
        code, said = checked(capsys, folder, sealed(genuine | {key: value}), *PROVED)
        assert (code == 1 and said.startswith("rejected: ")) or key == "sha256"


def test_verification_ends_after_its_processor_time(genuine):
    with pytest.raises(Rejected, match="more processor time"):
        check(genuine, max_seconds=0.0)


def test_file_is_not_written_where_one_is_verified(capsys, folder, genuine):
    file = folder / "kept.json"
    file.write_text(json.dumps(genuine))
    code, _, err = run(capsys, *PROVED, "--check", str(file), "--out", str(folder / "new.json"))
    assert code == 2 and "--out: --check writes no certificate" in err
