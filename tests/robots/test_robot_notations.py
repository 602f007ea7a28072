"""Notations of robot files with consequences: names, bases, macros, encodings, mimics, remedies."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.cli import main
from painleve_sym.errors import InputError
from painleve_sym.robots.formats import WRITTEN_BY_MUJOCO
from painleve_sym.robots.mjcf_settings import to_z
from painleve_sym.robots.tree import quaternion_of, rotation_quaternion, rotation_rpy

INERTIAL = (
    '<inertial><origin xyz="{1} 0 0"/><mass value="{0}"/>'
    '<inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial>'
)
XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


def read(tmp_path, text, name="robot.urdf", **options):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    return ps.robot(path, **options)


def link(name, mass=1.0, center=0.1):
    return f'<link name="{name}">{INERTIAL.format(mass, center)}</link>'


def joint(name, parent, child, inner="", kind="revolute"):
    limit = '<limit lower="-3" upper="3"/>' if kind in ("revolute", "prismatic") else ""
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{limit}{inner}</joint>'


def chain(*inner, kinds="", end=""):
    """Return a chain of links of 0.2 m, turning about y, with what else each joint has."""
    parts = ['<link name="world"/>', *(link(f"l{k}") for k in range(len(inner)))]
    names = ["world", *(f"l{k}" for k in range(len(inner)))]
    for k, more in enumerate(inner):
        axis = "" if "<axis" in more else '<axis xyz="0 1 0"/>'
        placed = f'<origin xyz="{0.2 * (k > 0)} 0 0"/>' if "<origin" not in more else ""
        parts.append(joint(f"j{k}", names[k], names[k + 1], axis + placed + more))
    return f'<robot name="r">{"".join(parts)}{end}</robot>'


def test_chained_mimics_are_one_factor_and_one_offset(tmp_path):
    one = '<mimic joint="j0" multiplier="2" offset="0.1"/>'
    two = '<mimic joint="j1" multiplier="0.5" offset="-0.3"/>'
    tree = read(tmp_path, chain("", one, two)).tree
    assert list(tree.joints) == ["j0"]
    mimics = [body.joint.mimic for body in tree.bodies if body.joint and body.joint.mimic]
    assert [(m.joint, m.factor, m.offset) for m in mimics] == [
        ("j0", 2.0, 0.1),
        ("j0", 1.0, pytest.approx(-0.25)),
    ]


def test_mobility_of_chained_mimics_is_that_of_one_freedom(tmp_path):
    # Three links of 0.2 m about y, at q, q and q/2: the mass of one velocity by hand.
    mimics = ('<mimic joint="j0"/>', '<mimic joint="j1" multiplier="0.5"/>')
    contact = read(tmp_path, chain("", *mimics)).contact("l2", joints={"j0": 0.4})
    q = np.array([0.4, 0.8, 1.0])
    rates = np.array([1.0, 2.0, 2.5])
    along = np.array([np.cos(q), -np.sin(q)]).T
    across = np.array([-np.sin(q), -np.cos(q)]).T * rates[:, None]
    mass, start = 0.0, np.zeros(2)
    for k in range(3):
        velocity = start + 0.1 * across[k]
        mass += velocity @ velocity + 0.01 * rates[k] ** 2
        origin = start
        start = start + 0.2 * across[k]
    assert along.shape == (3, 2)
    J = np.array([origin[1], origin[0], 0.0])
    np.testing.assert_allclose(contact.mobility(), np.outer(J, J) / mass, atol=1e-12)


def test_mimics_in_a_circle_are_an_error(tmp_path):
    text = chain('<mimic joint="j1"/>', '<mimic joint="j0"/>')
    with pytest.raises(InputError, match="mimics itself"):
        read(tmp_path, text)
    text = chain("", '<mimic joint="j1"/>').replace('joint="j1"', 'joint="end"')
    fixed = link("tip") + joint("end", "l1", "tip", kind="fixed")
    with pytest.raises(InputError, match="need a joint that moves"):
        read(tmp_path, text.replace("</robot>", fixed + "</robot>"))


def test_joint_of_a_urdf_without_axis_turns_about_x(tmp_path):
    text = chain("").replace('<axis xyz="0 1 0"/>', "")
    assert read(tmp_path, text).joints["j0"].axis.tolist() == [1, 0, 0]
    text = chain("").replace('<axis xyz="0 1 0"/>', "<axis/>")
    assert read(tmp_path, text).joints["j0"].axis.tolist() == [1, 0, 0]


def test_damper_of_a_urdf_takes_part(tmp_path):
    tree = read(tmp_path, chain('<dynamics damping="0.7"/>')).tree
    assert tree.joints["j0"].damping == (0.7,) and tree.notices == ()


def test_quaternion_of_a_urdf_is_that_of_its_angles(tmp_path):
    w, x, y, z = quaternion_of(rotation_rpy(0.3, -0.4, 0.5))
    first = chain('<origin xyz="1 2 3" rpy="0.3 -0.4 0.5"/>')
    second = chain(f'<origin xyz="1 2 3" quat_xyzw="{x} {y} {z} {w}"/>')
    bodies = [read(tmp_path, text).tree.bodies[1] for text in (first, second)]
    np.testing.assert_allclose(bodies[0].rotation, bodies[1].rotation, atol=1e-15)
    both = chain('<origin rpy="0 0 1" quat_xyzw="0 0 0 1"/>')
    with pytest.raises(InputError, match="has rpy and quat_xyzw, need one"):
        read(tmp_path, both)


@pytest.mark.parametrize("angles", [(0, 0, 0), (3, 0.1, 0), (0.1, 0, 3), (2, 1.5, -3), (0, 3, 0)])
def test_quaternion_turns_as_its_rotation(angles):
    R = rotation_rpy(*angles)
    quaternion = quaternion_of(R)
    assert np.linalg.norm(quaternion) == pytest.approx(1)
    np.testing.assert_allclose(rotation_quaternion(quaternion, ""), R, atol=1e-15)


def test_quaternion_of_any_length_is_scaled_exactly():
    # 1 % from unit length has another length than an orientation.
    q = 1.009 * np.array([0.8, 0.0, 0.6, 0.0])
    R = rotation_quaternion(q, "")
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(R @ [0, 0, 1], [0.96, 0, 0.28], atol=1e-15)


def test_smallest_turn_to_a_direction():
    for z in ([0, 0, 1], [0, 0, -1], [0.6, 0, 0.8], [0, -0.6, -0.8]):
        R = to_z(np.array(z, float))
        np.testing.assert_allclose(R @ [0, 0, 1], z, atol=1e-15)
        assert np.linalg.det(R) == pytest.approx(1)


def floating_text(inner="", root=""):
    rest = link("base") + link("arm") + joint("j", "base", "arm", '<axis xyz="0 1 0"/>')
    first = f'<link name="odom">{root}</link>'
    return f'<robot name="r">{first}{rest}{joint("f", "odom", "base", inner, "floating")}</robot>'


def test_floating_joint_of_a_urdf_is_the_base(tmp_path):
    tree = read(tmp_path, floating_text('<origin xyz="0 0 1" rpy="0.2 0.3 0.4"/>')).tree
    assert tree.floating and "<joint name='f'> of the file is floating" in tree.base
    assert list(tree.frames) == ["base", "arm"] and list(tree.joints) == ["j"]
    turned = rotation_quaternion(tree.orientation, "")
    np.testing.assert_allclose(turned, rotation_rpy(0.2, 0.3, 0.4), atol=1e-15)
    fixed = read(tmp_path, floating_text('<origin rpy="0.2 0.3 0.4"/>'), floating=False).tree
    assert not fixed.floating
    np.testing.assert_allclose(fixed.bodies[0].rotation, turned, atol=1e-15)
    with pytest.raises(InputError, match="a floating one only from a root link without inertia"):
        read(tmp_path, floating_text(root=INERTIAL.format(1, 0)))


def test_body_that_is_free_stands_as_its_file_has_it(tmp_path):
    text = (
        '<mujoco><worldbody><frame euler="0 30 0"><body name="b" euler="0 20 0"><freejoint/>'
        '<geom name="g" type="box" size="0.3 0.2 0.1"/><site name="s" pos="0.3 0 -0.1"/></body>'
        "</frame></worldbody></mujoco>"
    )
    tilted = read(tmp_path, text, "r.xml").contact("s")
    flat = text.replace("0 30 0", "0 0 0").replace("0 20 0", "0 0 0")
    level = read(tmp_path, flat, "r.xml").contact("s")
    slope = (-math.sin(math.radians(50)), 0, math.cos(math.radians(50)))
    against = read(tmp_path, flat, "r.xml").contact("s", normal=slope)
    assert tilted.risk().mu_P == pytest.approx(against.risk().mu_P, rel=1e-12)
    assert tilted.risk().mu_P != pytest.approx(level.risk().mu_P, rel=1e-3)


def test_answer_names_the_armature_of_a_free_joint(tmp_path):
    joint = '<joint type="free" armature="0.25"/>'
    text = mjcf(joint + '<geom name="g" size="0.1"/>')
    subject = read(tmp_path, text, "r.xml").contact("g").subject
    assert subject.to_dict()["armature"] == {"floating base": 0.25}
    assert "floating base = 0.25" in dict(subject.rows)["armature"]


def test_free_joint_has_a_linear_damper_and_a_notice_of_further_ones(tmp_path):
    for damping, notices in (("0.7", 0), ("0.7 0 0", 0), ("0.7 0.1", 1)):
        joint = f'<joint name="j" type="free" damping="{damping}"/>'
        tree = read(tmp_path, mjcf(joint + '<geom size="0.1"/>'), "r.xml").tree
        assert tree.base_damping == 0.7 and len(tree.notices) == notices
        assert all("taken as linear" in text and "'j'" in text for text in tree.notices)


AMBIGUOUS = (
    '<mujoco><worldbody><body name="leg"><joint axis="0 1 0"/><geom name="foot" size="0.05" '
    'pos="0.1 0 -0.3"/><site name="foot" pos="{0} 0 -0.3"/></body></worldbody></mujoco>'
)


def test_name_of_a_geom_and_a_site_is_ambiguous(tmp_path):
    robot = read(tmp_path, AMBIGUOUS.format(0.2), "r.xml")
    with pytest.raises(InputError, match="Fix: name one of geom:foot, site:foot"):
        robot.contact("foot")
    assert {"geom:foot", "site:foot"} <= set(robot.frames)
    mobility = [robot.contact(f"{kind}:foot").mobility() for kind in ("geom", "site")]
    assert mobility[0][0, 0] == pytest.approx(mobility[1][0, 0] / 4)
    same = read(tmp_path, AMBIGUOUS.format(0.1), "r.xml")
    assert "foot" in same.frames and "geom:foot" not in same.frames
    with pytest.raises(InputError, match="two geoms are called 'foot'"):
        read(tmp_path, AMBIGUOUS.format(0.1).replace("site ", "geom size='1' "), "r.xml")


@pytest.mark.parametrize("tag", ["macro name='m'", "property name='a' value='1'", "arg name='x'"])
@pytest.mark.parametrize("space", ["http://www.ros.org/wiki/xacro", "http://wiki.ros.org/xacro"])
def test_element_of_xacro_is_an_error_with_the_command(tmp_path, tag, space):
    text = f'<robot name="r" xmlns:xacro="{space}">{link("a")}<xacro:{tag}/></robot>'
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert "is a macro of xacro" in str(caught.value)
    assert "xacro FILE > robot.urdf" in str(caught.value)
    inside = text.replace("</link>", f"<xacro:{tag}/></link>").replace(
        f"<xacro:{tag}/></robot>", ""
    )
    with pytest.raises(InputError, match="is a macro of xacro"):
        read(tmp_path, inside + ("" if inside.endswith("</robot>") else "</robot>"))


def test_traces_of_xacro_in_numbers_and_prefixes_name_it(tmp_path):
    text = f'<robot name="r">{link("a").replace("1.0", "${m}")}</robot>'
    with pytest.raises(InputError, match=r"need a finite number.* Fix: expand it"):
        read(tmp_path, text)
    for old, new in (('name="a"', 'name="${p}_a"'), ("1.0", "$(arg m)")):
        with pytest.raises(InputError, match=r"Fix: expand it"):
            read(tmp_path, f'<robot name="r">{link("a").replace(old, new)}</robot>')
    for old_form in ('<macro name="m"/>', '<property name="p"/>', '<include filename="f"/>'):
        with pytest.raises(InputError, match=r"macro of xacro without its namespace.*expand it"):
            read(tmp_path, f'<robot name="r">{link("a")}{old_form}</robot>')
    with pytest.raises(InputError, match=r"unbound prefix.*Fix: expand it"):
        read(tmp_path, '<robot name="r"><xacro:include filename="x"/></robot>')


def test_expanded_file_that_only_declares_xacro_is_read(tmp_path):
    assert read(tmp_path, f'<robot name="r" {XACRO}>{link("a")}</robot>').frames == ("a",)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "iso-8859-1"])
def test_file_is_read_in_the_encoding_that_it_declares(tmp_path, encoding):
    declared = encoding.removesuffix("-sig")
    text = f'<?xml version="1.0" encoding="{declared}"?><robot name="Käfer">{link("füß")}</robot>'
    robot = read(tmp_path, text.encode(encoding))
    assert robot.frames == ("füß",) and robot.tree.name == "Käfer"


def test_mark_of_utf_16_and_namespace_of_a_whole_file_change_nothing(tmp_path):
    text = f'<?xml version="1.0" encoding="utf-8"?><robot name="r" xmlns="u">{link("a")}</robot>'
    for encoding in ("utf-8", "utf-16"):
        robot = read(tmp_path, text.encode(encoding))
        assert robot.frames == ("a",) and robot.tree.notices == ()


@pytest.mark.parametrize(
    "tag", ["inertial", "mass", "axis", "limit", "dynamics", "mimic", "origin"]
)
def test_part_of_a_urdf_that_is_there_twice_is_an_error(tmp_path, tag):
    text = chain("", '<mimic joint="j0"/><dynamics damping="1"/>')
    form = r"<inertial>.*?</inertial>" if tag == "inertial" else rf"<{tag} .*?/>"
    whole = re.search(form, text)
    with pytest.raises(InputError, match=f"has several <{tag}>, need one"):
        read(tmp_path, text.replace(whole[0], whole[0] * 2, 1))


def mjcf(inner, before=""):
    return f'<mujoco>{before}<worldbody><body name="b">{inner}</body></worldbody></mujoco>'


MESH = '<geom type="mesh" mesh="m"/>'


def test_mesh_of_a_body_that_cannot_move_needs_no_inertia(tmp_path):
    arm = '<body name="arm"><joint axis="0 1 0"/><geom size="0.1" pos="0.2 0 0"/>{}</body>'
    robot = read(tmp_path, mjcf(MESH + arm.format('<site name="s" pos="0.3 0 0"/>')), "r.xml")
    # A ball of radius 0.1 m, 0.2 m from the axis; its site is 0.3 m from it.
    mass = 1000 * 4 / 3 * math.pi * 1e-3
    expected = 0.3**2 / (mass * (0.2**2 + 0.4 * 0.01))
    assert robot.contact("s").mobility()[0, 0] == pytest.approx(expected)
    for text in (
        mjcf(MESH + arm.format(MESH)),
        mjcf("<joint/>" + MESH),
        mjcf("<freejoint/>" + MESH),
        mjcf(MESH + arm.format(""), before='<compiler settotalmass="3"/>'),
    ):
        with pytest.raises(InputError) as caught:
            read(tmp_path, text, "r.xml")
        assert "takes its inertia from a mesh" in str(caught.value)
        assert "saveinertial" in str(caught.value)


def test_remedy_is_one_command_of_python():
    code = WRITTEN_BY_MUJOCO.split('python -c "')[1].split('"')[0]
    compile(code, "remedy", "exec")
    assert "saveinertial = True" in code and "to_xml" in code


def test_free_joint_within_a_body_is_an_error(tmp_path):
    inner = '<geom size="0.1"/><body><freejoint/><geom size="0.1"/></body>'
    with pytest.raises(InputError, match="free joint within another body"):
        read(tmp_path, mjcf("<joint/>" + inner), "r.xml")


def test_two_orientations_of_one_element_are_an_error(tmp_path):
    text = mjcf('<joint/><geom size="0.1" quat="1 0 0 0" euler="0 0 1"/>')
    with pytest.raises(InputError, match="has quat and euler, need one orientation"):
        read(tmp_path, text, "r.xml")


def test_capitals_of_eulerseq_are_fixed_axes(tmp_path):
    def end(sequence):
        text = mjcf(
            '<joint/><geom size="0.1"/><site name="s" euler="90 90 0"/>',
            before=f'<compiler eulerseq="{sequence}"/>',
        )
        return read(tmp_path, text, "r.xml").tree.frames["s"].rotation @ [0, 0, 1]

    # z turns to -y, and the fixed y leaves it; the turned y is z, about which z turns to x first.
    np.testing.assert_allclose(end("XYZ"), [0, -1, 0], atol=1e-15)
    np.testing.assert_allclose(end("xyz"), [1, 0, 0], atol=1e-15)


def test_range_without_autolimits_is_no_limit(tmp_path):
    inner = '<joint name="j" range="-10 20"{}/><geom size="0.1" pos="1 0 0"/>'
    for before, limited, bounded in (
        ("", "", True),
        ('<compiler autolimits="false"/>', "", False),
        ('<compiler autolimits="false"/>', ' limited="true"', True),
        ("", ' limited="false"', False),
    ):
        tree = read(tmp_path, mjcf(inner.format(limited), before), "r.xml").tree
        assert math.isfinite(tree.joints["j"].upper) is bounded
        if bounded:
            assert tree.joints["j"].upper == pytest.approx(math.radians(20))


def test_capsule_has_the_moment_of_a_tube_and_two_half_balls(tmp_path):
    r, half = 0.3, 0.5
    text = mjcf(f'<joint/><geom type="capsule" size="{r} {half}" density="1"/>')
    body = read(tmp_path, text, "r.xml").tree.bodies[-1]
    # By slices across the axis: discs of radius s.
    z = np.linspace(-half - r, half + r, 200_001)
    s2 = r**2 - np.maximum(np.abs(z) - half, 0) ** 2
    area = np.pi * np.maximum(s2, 0)
    step = z[1] - z[0]
    assert body.mass == pytest.approx(area.sum() * step, rel=1e-6)
    across = (area * (s2 / 4 + z**2)).sum() * step
    assert body.inertia[0, 0] == pytest.approx(across, rel=1e-6)
    assert body.inertia[2, 2] == pytest.approx((area * s2 / 2).sum() * step, rel=1e-6)


def test_spring_of_a_joint_pulls_the_contact(tmp_path):
    # A point mass of 2 kg on a slide with a spring of 100 N/m: its free acceleration by hand.
    text = mjcf(
        '<joint name="z" type="slide" axis="0 0 1" stiffness="100" springref="0.3" damping="5"/>'
        '<geom name="g" size="0.1" mass="2"/>'
    )
    contact = read(tmp_path, text, "r.xml").contact("g", joints={"z": 0.1})
    answer = contact.classify(0.5, torques={"z": 1.0})
    assert answer.case.value == "liftoff"
    expected = -9.81 + (100 * 0.2 + 1.0) / 2
    assert answer.solutions[0].acceleration[0] == pytest.approx(expected)


def test_open_chain_says_so_in_its_title(tmp_path, capsys):
    text = mjcf('<joint axis="0 1 0"/><geom name="g" size="0.1" pos="0.2 0 0.1"/>')
    loop = '<equality><connect body1="b" anchor="0 0 0"/></equality></mujoco>'
    tree = read(tmp_path, text.replace("</mujoco>", loop), "r.xml").tree
    assert tree.opened and tree.title.endswith("of the open tree")
    assert not read(tmp_path, text, "s.xml").tree.opened
    assert main(["robot", str(tmp_path / "r.xml"), "--contact", "g"]) == 0
    out = capsys.readouterr().out
    assert "of the open tree" in out.splitlines()[0]
