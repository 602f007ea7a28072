"""The table of what readers do with elements and attributes, against the formats' own lists."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.errors import InputError
from painleve_sym.robots.formats import DRIVES, MJCF, URDF, Rule, Use, rule
from painleve_sym.robots.report import risk_report

HERE = Path(__file__).parent
SCHEMA = dict(
    line.split(":", 1) for line in (HERE / "mjcf_schema.txt").read_text("utf-8").splitlines()
)
# The elements of the schema of urdfdom, and what URDF 1.2 adds.
POSE = "xyz rpy quat_xyzw"
URDF_SCHEMA = {
    "robot": "name version",
    "robot/link": "name type",
    "robot/link/inertial": "",
    "robot/link/inertial/origin": POSE,
    "robot/link/inertial/mass": "value",
    "robot/link/inertial/inertia": "ixx ixy ixz iyy iyz izz",
    "robot/link/visual": "name",
    "robot/link/visual/geometry/capsule": "radius length",
    "robot/link/visual/material/texture": "filename",
    "robot/link/collision": "name",
    "robot/link/collision/origin": POSE,
    "robot/link/collision/geometry/mesh": "filename scale",
    "robot/link/collision/verbose": "value",
    "robot/joint": "name type",
    "robot/joint/origin": POSE,
    "robot/joint/parent": "link",
    "robot/joint/child": "link",
    "robot/joint/axis": "xyz",
    "robot/joint/calibration": "reference_position rising falling",
    "robot/joint/dynamics": "damping friction",
    "robot/joint/limit": "lower upper effort velocity acceleration deceleration jerk",
    "robot/joint/safety_controller": "soft_lower_limit soft_upper_limit k_position k_velocity",
    "robot/joint/mimic": "joint multiplier offset",
    "robot/transmission": "name type",
    "robot/transmission/rightActuator": "mechanicalReduction name",
    "robot/material/color": "rgba",
}
SOLID = '<geom name="g" size="0.1" pos="0.2 0 0"/>'
HINGE = '<joint name="j" axis="0 1 0"{}/>'
TENDON = "<tendon><{0}{1}>{2}</{0}></tendon>"
ENDS = '<joint joint="j" coef="2"/>'
EQUALITY = {"joint": ' joint1="j"', "tendon": ' tendon1="t"', "flex": "", "flexstrain": ""}


def mjcf(body, before="", after=""):
    return f'<mujoco>{before}<worldbody><body name="b">{body}</body></worldbody>{after}</mujoco>'


def file_of(path, attribute, value):
    """Return an MJCF file with an attribute of the element with this path."""
    given = f' {attribute}="{value}"' if attribute else ""
    section, _, tag = path.partition("/")
    hinge = HINGE.format("") + SOLID
    if path in ("compiler", "option"):
        return mjcf("<freejoint/>" + SOLID, before=f"<{path}{given}/>")
    if path == "body":
        return mjcf(hinge).replace("<body ", f"<body{given} ")
    if path == "body/joint":
        return mjcf(HINGE.format(given) + SOLID)
    if path == "body/free":
        return mjcf(f'<joint name="j" type="free"{given}/>' + SOLID)
    if path == "body/freejoint":
        return mjcf(f"<freejoint{given}/>" + SOLID)
    if path == "body/geom":
        return mjcf(HINGE.format("") + SOLID.replace("/>", f"{given}/>"))
    if path == "body/geom/plugin":
        return mjcf(HINGE.format("") + SOLID.replace("/>", "><plugin/></geom>"))
    if section == "body":
        return mjcf(f"{hinge}<{tag}{given}/>")
    if section == "tendon":
        return mjcf(hinge, after=TENDON.format(tag, given, ENDS if tag == "fixed" else ""))
    if section == "equality":
        own = EQUALITY.get(tag, ' body1="b"')
        return mjcf(hinge, after=f"<equality><{tag}{own}/></equality>")
    if section == "actuator":
        return mjcf(hinge, after=f'<actuator><{tag} name="a" joint="j"{given}/></actuator>')
    if section == "keyframe":
        return mjcf(hinge, after=f'<keyframe><key name="k" qpos="0"{given}/></keyframe>')
    return mjcf(hinge, after=f"<{path}{given}/>")


def read(tmp_path, text, name="robot.xml", **options):
    path = tmp_path / name
    path.write_text(text, "utf-8")
    return ps.robot(path, **options)


def cases(use):
    for path, rules in MJCF.items():
        own = {"": rules} if isinstance(rules, Rule) else rules
        for attribute, one in own.items():
            if one.use is use:
                yield pytest.param(path, attribute, one, id=f"{path} {attribute}")


def test_every_element_and_attribute_of_mujoco_has_a_use():
    places = {"joint": "body/joint", "geom": "body/geom", "site": "body/site"}
    places |= {"tendon": "tendon/spatial", "equality": "equality/joint"}
    places |= {tag: f"actuator/{tag}" for tag in DRIVES}
    assert len(SCHEMA) == 171
    for path, attributes in SCHEMA.items():
        own = path.replace("(world)", "")
        if path.startswith("default/"):
            own = places.get(path.split("/")[1], "default")
        missing = [name for name in attributes.split() if rule(MJCF, own, name) is None]
        assert rule(MJCF, own) is not None and not missing, (path, missing)


def test_every_element_and_attribute_of_urdf_has_a_use():
    for path, attributes in URDF_SCHEMA.items():
        assert rule(URDF, path) is not None, path
        assert all(rule(URDF, path, name) is not None for name in attributes.split()), path


def test_table_has_no_element_that_no_format_has():
    older = {"body/composite", "body/replicate", "body/free", "body/frame", "include"}
    known = {path.replace("(world)", "") for path in SCHEMA} | older | {"worldbody"}
    assert set(MJCF) - known == set()
    sections = {name for path in URDF_SCHEMA for name in (path, path.rsplit("/", 1)[0])}
    extensions = {"robot/gazebo", "robot/mujoco", "robot/ros2_control", "robot/sensor"}
    extensions |= {"robot/link/contact", "robot/link/sensor", "robot/material"}
    extensions |= {"robot/macro", "robot/property", "include"}
    own = {path for path in URDF if not path.startswith("robot/gazebo/")}
    assert own - sections - extensions == set()


@pytest.mark.parametrize(("path", "attribute", "one"), list(cases(Use.NOTICE)))
def test_notice_names_the_element(tmp_path, path, attribute, one):
    count = 2 if attribute == "springdamper" else 1
    value = "true" if one.neutral == "false" else " ".join(["1"] * count)
    notices = read(tmp_path, file_of(path, attribute, value)).tree.notices
    begin = one.sentence.split("{")[0]
    assert [text for text in notices if text.startswith(begin)] == list(notices)
    assert len(notices) == 1
    if attribute:
        assert f"({attribute} = {value})" in notices[0]
    if one.neutral:
        for neutral in (one.neutral, "0.0" if one.neutral == "0" else "false"):
            text = file_of(path, attribute, " ".join([neutral] * count))
            assert read(tmp_path, text).tree.notices == ()


@pytest.mark.parametrize(("path", "attribute", "one"), list(cases(Use.REJECTED)))
def test_rejected_element_is_an_error(tmp_path, path, attribute, one):
    with pytest.raises(InputError) as caught:
        read(tmp_path, file_of(path, attribute, "global"))
    assert one.sentence.split("{names}")[-1] in str(caught.value)


def test_remedy_has_mujoco_write_inertias():
    rejected = [one.values[2].sentence for one in cases(Use.REJECTED)]
    assert sum("saveinertial" in text for text in rejected) == len(rejected) - 1


READ = {
    ("body/joint", "stiffness"): ("3", "4"),
    ("body/joint", "damping"): ("3", "0 1"),
    ("body/joint", "armature"): ("1", "2"),
    ("body/joint", "ref"): ("10", "20"),
    ("body/joint", "pos"): ("1 0 0", "0 1 1"),
    ("body/joint", "type"): ("hinge", "slide"),
    ("body/free", "armature"): ("1", "2"),
    ("body/free", "damping"): ("1", "2"),
    ("body/geom", "mass"): ("1", "2"),
    ("body/geom", "density"): ("1", "2"),
    ("body", "gravcomp"): ("1", "0.5"),
    ("body", "pos"): ("0 0 1", "0 0 2"),
    ("body", "euler"): ("0 0 10", "0 20 0"),
    ("actuator/motor", "armature"): ("1", "2"),
    ("actuator/motor", "damping"): ("1", "2"),
    ("option", "gravity"): ("0 0 -1", "0 0 -2"),
    ("compiler", "settotalmass"): ("1", "2"),
    ("compiler", "boundmass"): ("90", "91"),
    ("compiler", "boundinertia"): ("90", "91"),
    ("compiler", "inertiafromgeom"): ("false", "true"),
    ("compiler", "inertiagrouprange"): ("0 1", "1 2"),
}


@pytest.mark.parametrize(("key", "values"), READ.items(), ids=lambda v: " ".join(v))
def test_attribute_that_is_read_changes_what_dynamics_is_derived_from(tmp_path, key, values):
    assert rule(MJCF, *key).use is Use.READ
    first, second = (read(tmp_path, file_of(*key, v)).tree.definition for v in values)
    assert first != second


def test_list_with_one_number_is_a_notice(tmp_path):
    (notice,) = read(tmp_path, file_of("tendon/fixed", "stiffness", "0 1 0")).tree.notices
    assert "(stiffness = 0 1 0)" in notice


def test_what_no_list_has_is_named(tmp_path):
    text = mjcf(HINGE.format(' wobble="1"') + SOLID + "<wheel/>")
    (notice,) = read(tmp_path, text).tree.notices
    assert "wobble of <joint>, <wheel>" in notice
    link = '<link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
    text = f'<robot name="r" xmlns:drake="d">{link}<drake:rotor/></link><gazebo reference="a">'
    text += "<mu1>1</mu1><turnGravityOff>true</turnGravityOff></gazebo></robot>"
    notices = read(tmp_path, text, "r.urdf").tree.notices
    assert any("<rotor>" in notice for notice in notices)
    assert any("Gazebo are not read: <turnGravityOff> of a." in notice for notice in notices)
    plain = text.replace("<turnGravityOff>true</turnGravityOff>", "").replace("<drake:rotor/>", "")
    assert read(tmp_path, plain, "r.urdf").tree.notices == ()


@pytest.mark.parametrize("flag", ["frictionloss", "constraint"])
def test_flag_switches_dry_friction_off(tmp_path, flag):
    text = mjcf(HINGE.format(' frictionloss="2"') + SOLID)
    assert "other limit" in read(tmp_path, text).tree.notices[0]
    off = f'<option><flag {flag}="disable"/></option>'
    text = mjcf(HINGE.format(' frictionloss="2"') + SOLID, before=off)
    assert read(tmp_path, text).tree.notices == ()


def test_dry_friction_of_a_urdf_is_a_notice_with_both_limits(tmp_path):
    notices = ps.robot(HERE / "files" / "mimics.urdf").tree.notices
    assert len(notices) == 1 and "joint 'close' (friction = 0.02)" in notices[0]
    assert "freely" in notices[0] and "--locked" in notices[0]


def test_report_has_both_limits_of_dry_friction(tmp_path):
    free = '<joint name="a" axis="0 1 0"/><joint name="z" type="slide" axis="0 0 1"/>'
    dry = '<joint name="s" axis="0 1 0" frictionloss="{}"/><geom name="h" size="0.1" mass="2" '
    text = mjcf(f'{free}{SOLID}<body pos="0.2 0 -0.1">{dry}pos="0.1 0 -0.3"/></body>')
    robot = read(tmp_path, text.format(1))
    contact = robot.contact("h")
    free, held = contact.risk().mu_P, robot.contact("h", locked="s").risk().mu_P
    notice = risk_report(contact, None, 10).notices[-2]
    assert f"mu_P = {free:.6g} where they move freely" in notice
    assert notice.endswith(f"holds them, mu_P = {held:.6g}.") and held != free
    assert len(risk_report(robot.contact("h", locked="s"), None, 10).notices) == 2
    assert len(risk_report(read(tmp_path, text.format(0)).contact("h"), None, 10).notices) == 1


def test_total_mass_with_fused_bodies_is_an_error(tmp_path):
    before = '<compiler settotalmass="8"{}/>'
    still = HINGE.format("") + SOLID + '</body><body name="c"><geom size="0.2"/>'
    fused = before.format(' fusestatic="true"')
    masses = [body.mass for body in read(tmp_path, mjcf(still, before.format(""))).tree.bodies]
    assert sum(masses) == pytest.approx(8) and masses[-1] == pytest.approx(8 * masses[2])
    with pytest.raises(InputError, match="settotalmass counts what stands still"):
        read(tmp_path, mjcf(still, fused))
    for body in (HINGE.format("") + SOLID, "<freejoint/>" + SOLID):
        tree = read(tmp_path, mjcf(body, fused)).tree
        assert sum(body.mass for body in tree.bodies) == pytest.approx(8)


def test_flags_switch_gravity_and_passive_forces_off(tmp_path):
    body = HINGE.format(' stiffness="1" damping="2"') + SOLID
    for flags, stiffness, damping, falls, held in (
        ('gravity="disable"', (1.0,), (2.0,), False, True),
        ('spring="disable"', (), (2.0,), True, True),
        ('damper="disable"', (1.0,), (), True, True),
        ('spring="disable" damper="disable"', (), (), True, False),
        ('passive="disable"', (), (), True, False),
    ):
        text = mjcf(body, before=f"<option><flag {flags}/></option>")
        tree = read(tmp_path, text.replace("<body ", '<body gravcomp="1" ')).tree
        assert (tree.joints["j"].stiffness, tree.joints["j"].damping) == (stiffness, damping)
        assert tree.gravity.any() == falls
        assert any(one.compensated.any() for one in tree.bodies) == held


def test_lists_of_classes_are_completed_and_orientations_replaced(tmp_path):
    classes = '<default><joint damping="1 2"/><geom type="capsule" size="0.1 0.2" quat="1 1 0 0"/>'
    classes += '<default class="a"><joint damping="7"/></default></default>'
    body = '<joint name="j" class="a"/><geom name="g" size="0.3" euler="0 0 90"/>'
    tree = read(tmp_path, mjcf(body, before=classes)).tree
    assert tree.joints["j"].damping == (7.0, 2.0)
    np.testing.assert_allclose(tree.frames["g"].rotation @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    volume = np.pi * 0.09 * 0.4 + 4 / 3 * np.pi * 0.027
    assert tree.bodies[-1].mass == pytest.approx(1000 * volume)


def test_table_says_read_of_whole_elements_only_for_defaults():
    whole = {path for path, one in MJCF.items() if isinstance(one, Rule) and one.use is Use.READ}
    assert whole == {"default"}
    assert all(isinstance(one, Rule | Mapping) for one in (*MJCF.values(), *URDF.values()))
