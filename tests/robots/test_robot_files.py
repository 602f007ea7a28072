"""Files of robots that are wrong, hostile or made up: one sentence, nothing opened, no crash."""

from __future__ import annotations

import random
import socket
from pathlib import Path

import pytest

import painleve_sym as ps
from painleve_sym.errors import InputError

FILES = Path(__file__).parent / "files"
DOG = Path(__file__).parents[2] / "examples" / "robots" / "quadruped.urdf"
SEEDS = [DOG, DOG.with_name("desk_arm.xml"), *sorted(FILES.glob("*.*"))]
ROUND = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
LINK = f'<link name="{{}}">{ROUND}</link>'
JOINT = '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>{4}</joint>'


def written(tmp_path, text, name="robot.urdf"):
    path = tmp_path / name
    path.write_text(text, "utf-8")
    return path


def urdf(*parts):
    return f'<robot name="r">{"".join(parts)}</robot>'


def links(*names):
    return "".join(map(LINK.format, names))


def inertial(mass, moments, product=0.0):
    x, y, z = moments
    return (
        f'<link name="a"><inertial><mass value="{mass}"/><inertia ixx="{x}" ixy="{product}" '
        f'iyy="{y}" izz="{z}"/></inertial></link>'
    )


def body(inner, before=""):
    return f'<mujoco>{before}<worldbody><body name="b">{inner}</body></worldbody></mujoco>'


HINGE = '<joint name="j"/><geom type="sphere" size="1"/>'
BOMB = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]>'
FAULTS = {
    "bomb": (BOMB + "<robot name='r'>&b;</robot>", "has a document type"),
    "external": (
        '<!DOCTYPE r SYSTEM "http://127.0.0.1:9/r.dtd"><robot name="r"/>',
        "has a document type",
    ),
    "file": (
        '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="r">&x;</robot>',
        "has a document type",
    ),
    "cut": ('<robot name="r"><link', "not well-formed XML"),
    "other": ("<svg/>", "the root element is <svg>, need <robot>"),
    "encoding": ('<?xml version="1.0" encoding="klingon"?><robot/>', "not well-formed|no link"),
    "empty": (urdf(), "the robot has no link"),
    "deep": ("<robot>" + "<a>" * 300 + "</a>" * 300 + "</robot>", "more than 200 deep"),
    "broad": ("<robot>" + "<a/>" * 100_001 + "</robot>", "more than 100000 elements"),
    "many": (urdf(links(*(f"l{i}" for i in range(1001)))), "got 1001 links, need at most 1000"),
    "cycle": (
        urdf(links("a", "b"), JOINT.format("j", "fixed", "a", "b", ""),
             JOINT.format("k", "fixed", "b", "a", "")),
        "form a cycle through link 'a'",
    ),
    "island": (
        urdf(links("r", "a", "b"), JOINT.format("j", "fixed", "a", "b", ""),
             JOINT.format("k", "fixed", "b", "a", "")),
        "form a cycle through link 'a'",
    ),
    "two parents": (
        urdf(links("a", "b", "c"), JOINT.format("j", "fixed", "a", "c", ""),
             JOINT.format("k", "fixed", "b", "c", "")),
        "link 'c' is the child of two joints",
    ),
    "two roots": (urdf(links("a", "b")), "links 'a' and 'b' have no parent"),
    "self": (urdf(links("a"), JOINT.format("j", "fixed", "a", "a", "")), "form a cycle"),
    "twice": (urdf(links("a", "a")), "got two elements <link name='a'>"),
    "unknown link": (
        urdf(links("hip"), JOINT.format("j", "fixed", "hip", "hop", "")),
        "unknown link 'hop'. Did you mean 'hip'",
    ),
    "no child": (urdf(links("a"), '<joint name="j"><parent link="a"/></joint>'), "has no child"),
    "no name": (urdf("<link/>"), "<link> has no name"),
    "type": (
        urdf(links("a", "b"), JOINT.format("j", "planar", "a", "b", "")),
        "is of type 'planar', need revolute",
    ),
    "axis": (
        urdf(links("a", "b"), JOINT.format("j", "revolute", "a", "b", '<axis xyz="0 0 0"/>')),
        "need one of positive length",
    ),
    "words": (
        urdf(links("a", "b"), JOINT.format("j", "revolute", "a", "b", '<axis xyz="0 x 0"/>')),
        "xyz = '0 x 0', need 3 finite numbers",
    ),
    "limits": (
        urdf(links("a", "b"),
             JOINT.format("j", "revolute", "a", "b", '<limit lower="1" upper="-1"/>')),
        "need lower <= upper",
    ),
    "mimic": (
        urdf(links("a", "b"),
             JOINT.format("j", "revolute", "a", "b", '<mimic joint="j"/>')),
        "<joint name='j'> mimics itself",
    ),
    "infinite": (urdf(inertial("inf", (1, 1, 1))), "value = 'inf', need a finite number"),
    "negative mass": (urdf(inertial(-1, (1, 1, 1))), "has mass -1 kg, need a number >= 0"),
    "indefinite": (urdf(inertial(1, (1, 1, 1), 2)), "has an inertia with the principal moments"),
    "half": (
        urdf('<link name="a"><inertial><mass value="1"/></inertial></link>'),
        "inertial needs mass and inertia",
    ),
    "no inertia": (
        urdf(links("a"), '<link name="b"/>', JOINT.format("j", "revolute", "a", "b", "")),
        "joint 'j' moves links without mass",
    ),
    "include": ('<mujoco><include file="/etc/passwd"/></mujoco>', "includes another file"),
    "ball": (body('<joint type="ball"/><geom size="1"/>'), "type 'ball', need hinge or slide"),
    "mesh": (body('<joint/><geom type="mesh" mesh="m"/>'), "takes its inertia from a mesh"),
    "size": (body('<joint/><geom type="box" size="1"/>'), "need 3 numbers > 0"),
    "shape": (body('<joint/><geom type="spere" size="1"/>'), "Did you mean 'sphere'"),
    "class": (body('<joint class="leg"/><geom size="1"/>'), "unknown default class 'leg'"),
    "quaternion": (
        body('<joint/><geom size="1" quat="0 0 0 0"/>'),
        "need one of unit length",
    ),
    "sequence": (body(HINGE, '<compiler eulerseq="abc"/>'), "need three of x, y, z"),
    "replicate": (body(HINGE + '<replicate count="9"/>'), "makes bodies that are not written"),
    "same joints": (body(HINGE + '<body name="c">' + HINGE + "</body>"), "are called 'j'"),
    "same bodies": (body(HINGE + '<body name="b"/>'), "two bodies are called 'b'"),
    "keyframe": (
        '<mujoco><worldbody><body><joint/><geom size="1"/></body></worldbody>'
        '<keyframe><key qpos="0 1"/></keyframe></mujoco>',
        "qpos has 2 numbers, need 1",
    ),
    "two robots": (
        '<mujoco><worldbody><body><freejoint/><geom size="1"/></body>'
        '<body><freejoint/><geom size="1"/></body></worldbody></mujoco>',
        "2 bodies of the world move, need one robot",
    ),
    "armature": (body('<joint armature="-1"/><geom size="1"/>'), "armature -1, need >= 0"),
}  # fmt: skip


@pytest.fixture
def no_network(monkeypatch):
    def rejected(*_):
        raise AssertionError("a robot's file opened a connection")

    monkeypatch.setattr(socket.socket, "connect", rejected)


@pytest.mark.parametrize("case", FAULTS)
def test_fault_of_a_file_is_one_sentence(tmp_path, case, no_network):
    text, expected = FAULTS[case]
    path = written(tmp_path, text)
    with pytest.raises(InputError, match="|".join(expected.split("|"))) as caught:
        robot = ps.robot(path)
        robot.contact(robot.frames[-1])
    assert "Traceback" not in str(caught.value) and len(str(caught.value)) < 2100


def test_file_whose_lists_and_chains_are_long_is_read_or_rejected_at_once(tmp_path):
    numbers = f'<default><geom size="{"1 " * 200_000}"/></default>'
    geoms = '<geom size="0.1"/>' * 2000
    with pytest.raises(InputError, match="size = '1 1"):
        ps.robot(written(tmp_path, body(HINGE + "<geom/>" + geoms, numbers)))
    names = [f"l{k}" for k in range(300)]
    follows = '<limit lower="-1" upper="1"/><mimic joint="j{}"/>'
    chain = [JOINT.format("j1", "revolute", *names[:2], "")]
    for k in range(2, 300):
        ends = (names[k - 1], names[k], follows.format(k - 1))
        chain.append(JOINT.format(f"j{k}", "revolute", *ends))
    assert list(ps.robot(written(tmp_path, urdf(links(*names), *chain))).joints) == ["j1"]


def test_file_that_is_absent_binary_or_endless(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        ps.robot(tmp_path / "absent.urdf")
    (tmp_path / "noise.urdf").write_bytes(bytes(range(256)))
    with pytest.raises(InputError, match="not well-formed XML"):
        ps.robot(tmp_path / "noise.urdf")
    with pytest.raises(InputError, match="more than 16000000 bytes"):
        ps.robot("/dev/zero")


def test_inertia_that_is_nearly_that_of_a_body_is_a_notice(tmp_path):
    robot = ps.robot(written(tmp_path, urdf(inertial(1, (1, 1, 3)))))
    assert "miss the triangle inequality" in robot.tree.notices[0]
    robot = ps.robot(written(tmp_path, urdf(inertial(0, (1, 1, 1)))))
    assert "has an inertia without mass" in robot.tree.notices[0]


@pytest.mark.parametrize(
    ("text", "asked", "floating", "sentence"),
    [
        (urdf(links("a")), None, True, "root link 'a' has an inertia and URDF does not say"),
        (urdf('<link name="a"/>'), None, False, "root link 'a' has no inertia and URDF does"),
        (urdf(links("world")), None, False, "is fixed: the root link is called 'world'"),
        (urdf(links("a")), False, False, "link 'a', is fixed as asked"),
        (body(HINGE), None, False, "is fixed: no body of the file has a free joint"),
        (
            body('<freejoint/><geom size="1"/>'),
            None,
            True,
            "<body name='b'> of the file has a free",
        ),
        (body('<geom size="1"/><body><joint/><geom size="1"/></body>'), True, True, "as asked"),
    ],
)
def test_robot_says_how_its_base_was_decided(tmp_path, text, asked, floating, sentence):
    tree = ps.robot(written(tmp_path, text), floating=asked).tree
    assert tree.floating is floating and sentence in tree.base


def test_closed_chain_is_a_notice(tmp_path):
    text = body(HINGE, '<equality><connect body1="b"/></equality>')
    notice = ps.robot(written(tmp_path, text)).tree.notices[0]
    assert "that of the open tree" in notice and notice.endswith(": <connect> of b.")
    for off in (' active="false"', ""):
        before = "" if off else '<option><flag equality="disable"/></option>'
        text = body(HINGE, f'{before}<equality><connect body1="b"{off}/></equality>')
        assert ps.robot(written(tmp_path, text)).tree.notices == ()


WORDS = [
    "0",
    "-1",
    "nan",
    "inf",
    "1e308",
    "1e400",
    "",
    "x",
    "0 0 0",
    "1 2",
    "true",
    "..",
    "\\u0000",
]
TAGS = ["body", "joint", "link", "geom", "inertial", "frame", "default", "freejoint", "include"]


def mangled(text, draw):
    """Return a file with a few changes of the kinds that accidents and attackers make."""
    for _ in range(draw.randint(1, 4)):
        kind = draw.randrange(8)
        at, other = sorted(draw.randrange(len(text) + 1) for _ in range(2))
        if kind == 0:
            text = text[:at] + text[other:]
        elif kind == 1:
            text = text[:other] + text[at:other] + text[other:]
        elif kind == 2:
            text = text[:at] + chr(draw.choice((0, 9, 38, 60, 62, 34, 233, 0x2028))) + text[at:]
        elif kind == 3:
            quoted = text.split('"')
            if len(quoted) > 2:
                quoted[draw.randrange(1, len(quoted), 2)] = draw.choice(WORDS)
                text = '"'.join(quoted)
        elif kind == 4:
            quoted = text.split('"')
            if len(quoted) > 4:
                quoted[draw.randrange(1, len(quoted), 2)] = quoted[
                    draw.randrange(1, len(quoted), 2)
                ]
                text = '"'.join(quoted)
        elif kind == 5:
            lines = text.splitlines(keepends=True)
            draw.shuffle(lines)
            text = "".join(lines)
        elif kind == 6:
            lines = text.splitlines(keepends=True)
            k = draw.randrange(len(lines))
            text = "".join([*lines[:k], f"<{draw.choice(TAGS)}/>\n", *lines[k:]])
        else:
            lines = text.splitlines(keepends=True)
            del lines[draw.randrange(len(lines))]
            text = "".join(lines)
        if not text:
            break
    return text


def read_mangled(tmp_path, first, last):
    sources, errors, robots = [p.read_text("utf-8") for p in SEEDS], 0, 0
    for seed in range(first, last):
        draw = random.Random(seed)
        path = written(tmp_path, mangled(draw.choice(sources), draw))
        try:
            robot = ps.robot(path)
            robots += len(robot.tree.merged.bodies) > 0
            if seed % 20 == 0 and robot.joints:
                robot.contact(robot.frames[-1]).risk(0.5)
        except InputError as error:
            errors += 1
            assert str(error).startswith(("robot", "SRDF"))
    return errors, robots


def test_mangled_files_are_robots_or_errors(tmp_path, no_network):
    errors, robots = read_mangled(tmp_path, 0, 150)
    assert errors > 20 and robots > 10


@pytest.mark.slow
def test_five_thousand_mangled_files_are_robots_or_errors(tmp_path, no_network):
    errors, robots = read_mangled(tmp_path, 0, 5000)
    assert errors > 1000 and robots > 300
