"""The command robot: its output, files and errors."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from tests.cli.cli_helpers import rejected, run, run_json

ROOT = Path(__file__).parents[2]
DOG = str(ROOT / "examples" / "robots" / "quadruped.urdf")
ARM = str(ROOT / "tests" / "robots" / "files" / "two_link.urdf")
FOOT = ("robot", DOG, "--contact", "LF_foot", "--pose", "standing", "--poses", "2")
KEYS = [
    "subject",
    "mu",
    "W",
    "mu_P",
    "direction",
    "sector",
    "worst_direction",
    "least_over_normals",
    "gradient",
    "impact",
]
KEYS += ["least", "share_at_risk", "notices"]


def test_json_has_the_numbers_of_the_contact(capsys):
    data = run_json(capsys, *FOOT, "--mu", "2")
    assert list(data) == KEYS
    W = np.array(data["W"])
    w = W[1:, 0]
    assert data["mu_P"] == pytest.approx(W[0, 0] / np.linalg.norm(w))
    assert data["direction"] == pytest.approx((w / np.linalg.norm(w)).tolist())
    assert data["sector"]["direction"] == data["direction"]
    assert data["sector"]["half_angle"] == pytest.approx(math.acos(data["mu_P"] / 2))
    np.testing.assert_allclose(data["worst_direction"], [*(w / np.linalg.norm(w)), 0])
    low, _, high = np.linalg.eigvalsh(W)
    assert data["least_over_normals"] == pytest.approx(2 * math.sqrt(low * high) / (high - low))
    assert set(data["gradient"]) == set(data["least"]["joints"]) and len(data["gradient"]) == 12
    assert data["least"]["mu_P"] < data["mu_P"] and 0 <= data["share_at_risk"] <= 1
    assert "ideal torque control" in data["notices"][0]
    impact = data["impact"]
    assert impact["restitution"] == "energetic" and impact["energy_change"] < 0
    assert impact["normal_impulse"] > 0 and impact["velocity"][0] > 0


def test_an_answer_says_of_what_it_is(capsys, tmp_path):
    call = (*FOOT, "--joints", "LF_KFE=-1.3", "--locked", "RH_KFE", "--normal", "0,0.6,0.8")
    call += ("--point", "0,0,-0.01", "--radius", "2 cm", "--contact", "LF_foot,RF_foot")
    call += ("--others", "stuck", "--armature", "LF_KFE=0.1")
    subject = run_json(capsys, *call)["subject"]
    assert subject["file"] == DOG and subject["robot"] == "quadruped"
    assert subject["base"] == "floating" and "has an inertia" in subject["base_reason"]
    assert subject["contact"] == "LF_foot" and subject["others"] == {"RF_foot": "stuck"}
    assert subject["point"] == [0, 0, -0.01] and subject["radius"] == 0.02
    assert subject["normal"] == [0, 0.6, 0.8]
    assert subject["tangents"] == [[1, 0, 0], [0, 0.8, -0.6]]
    assert subject["pose"] == "standing" and len(subject["joints"]) == 12
    assert subject["joints"]["LF_KFE"] == -1.3 and subject["joints"]["RF_HFE"] == 0.7
    assert subject["locked"] == ["RH_KFE"] and subject["armature"] == {"LF_KFE": 0.1}
    assert subject["base_angles"] == [0, 0, 0] and subject["gravity"] == [0, 0, -9.81]
    page = tmp_path / "page.html"
    code, out, _ = run(capsys, *call, "--report", str(page))
    assert code == 0
    for text in (" ".join(out.split()), page.read_text()):
        for part in (DOG, "URDF does not say", "(0, 0.6, 0.8) in the world", "LF_KFE = -1.3"):
            assert part in text
        assert "RF_foot stuck" in text and "RH_KFE" in text and "point (0, 0, -0.01) m" in text
        assert "standing: LF_HAA" in text and "radius 0.02 m" in text and "LF_KFE = 0.1" in text
    fixed = run_json(capsys, *FOOT, "--base", "fixed")["subject"]
    assert fixed["base"] == "fixed" and "as asked" in fixed["base_reason"]
    assert fixed["base_angles"] is None and fixed["locked"] == []


@pytest.mark.parametrize("command", ["classify", "jump", "contrast"])
def test_other_commands_say_of_what_they_are(capsys, command):
    options = ("--stiffness", "1e7") if command == "contrast" else ()
    subject = run_json(capsys, command, *PLACE, *SLIP, *options)["notices"][0]
    assert subject.startswith(f"Robot of {DOG}. The base is taken to float")
    assert "Contact LF_foot, point (0, 0, 0) m of its frame; normal (0, 0, 1)" in subject
    assert "Other contacts" not in subject and "Locked" not in subject


def test_other_commands_name_other_contacts_and_locked_joints(capsys):
    more = ("--contact", "LF_foot,RF_foot", "--others", "stuck", "--locked", "RH_KFE")
    subject = run_json(capsys, "classify", *PLACE, *more)["notices"][0]
    assert "Other contacts: RF_foot stuck. Locked: RH_KFE." in subject


def test_rounding_is_no_number(capsys, tmp_path):
    """A planar arm whose normal and slip are coupled by rounding alone."""
    text = GANTRY.replace('<axis xyz="1 0 0"/>', '<axis xyz="0.6 0.8 0"/>')
    text = text.replace('<axis xyz="0 0 1"/>', '<axis xyz="1e-14 0 1"/>')
    path, page = tmp_path / "gantry.urdf", tmp_path / "page.html"
    path.write_text(text)
    call = ("robot", str(path), "--contact", "foot", "--mu", "3", "--poses", "4")
    data = run_json(capsys, *call)
    assert data["mu_P"] is data["sector"] is None
    assert data["worst_direction"] == [None] * 3 and data["direction"] == [None] * 2
    assert set(data["gradient"].values()) == {None} and data["least_over_normals"] == 0
    # A planar arm has a W of rank two, whose least eigenvalue is rounding.
    bent = ("--joints", "theta_1=-0.6,theta_2=-1.1", "--normal", "0.3,0.6,0.8", "--poses", "2")
    assert run_json(capsys, "robot", ARM, "--contact", "tip", *bent)["least_over_normals"] == 0
    code, out, _ = run(capsys, *call, "--report", str(page))
    assert code == 0
    for shown in (out, page.read_text()):
        assert not re.search(r"\de[-+]\d\d", shown), shown
        assert "infinite" in shown or "mu_P = inf" in shown


def test_share_and_quantiles_are_those_of_the_poses(capsys, tmp_path):
    page = tmp_path / "page.html"
    call = (*FOOT[:-1], "101", "--mu", "1.5")
    _, out, _ = run(capsys, *call, "--report", str(page))
    foot = ps.robot(DOG).contact("LF_foot", pose="standing")
    values = np.sort(foot.thresholds(foot.random_poses(101)))
    low, middle, high = re.search(r"5, 50 and 95 %: (.*), (.*), (.*)", out).groups()
    # The numbers 6, 51 and 96 of 101.
    assert [low, middle, high] == [f"{values[k]:.4g}" for k in (5, 50, 95)]
    share = float(np.mean(values < 1.5))
    assert 0.1 < share < 0.9 and abs(share - 0.5) > 0.02
    assert f"share of poses at risk: {100 * share:.3g} %" in out
    cell = re.search(r"share of random poses with μ_P &lt; μ</td><td>([^<]*)<", page.read_text())
    assert float(cell[1]) == pytest.approx(share)


def test_log_reaches_text_json_and_page(capsys, tmp_path):
    log, page = tmp_path / "log.csv", tmp_path / "page.html"
    log.write_text("t,LF_KFE,force\n0,-1.4,0\n1,-1.3,20\n3,-1.2,20\n")
    call = (*FOOT, "--mu", "2", "--trajectory", str(log), "--touching", "force>5")
    data = run_json(capsys, *call)["trajectory"]
    assert data["closed"] == [False, True, True] and data["share_closed"] == pytest.approx(5 / 6)
    assert data["share_at_risk"] == pytest.approx(5 / 6) and data["rest"] == 0.02
    assert data["time_of_least"] in (1.0, 3.0)
    code, out, _ = run(capsys, *call, "--report", str(page))
    assert code == 0 and "the contact touches 83.3 % of the time" in " ".join(out.split())
    assert "share of time at risk: 83.3 %" in out
    text = page.read_text()
    assert text.count("<svg") == 2 and "the time at risk is shaded" in text
    assert re.search(r"share of the time at risk</td><td>0\.8333", text)
    code, _, err = run(capsys, *FOOT, "--touching", "force>5")
    assert code == 2 and "--touching: belongs to --trajectory" in err
    code, _, err = run(capsys, *call[:-1], "force>five")
    assert code == 2 and "--touching: got 'force>five', need a column" in err
    assert "Did you mean 'force'?" in rejected(capsys, *call[:-1], "forse>5")


def test_without_friction_there_is_no_share(capsys):
    data = run_json(capsys, *FOOT)
    assert data["share_at_risk"] is None and data["sector"] is None
    assert data["impact"] is None
    assert run_json(capsys, *FOOT, "--mu", "0.5")["impact"] is None


@pytest.mark.slow
def test_options_reach_the_contact(capsys):
    plain = run_json(capsys, *FOOT)["mu_P"]
    changes = [
        ("--joints", "LF_KFE=-1"),
        ("--normal", "0.2,0,1"),
        ("--point", "0,0.1,0"),
        ("--radius", "5 cm"),
        ("--armature", "0.1"),
        ("--armature", "LF_KFE=0.1,LF_HFE=0.2"),
        ("--locked", "LF_KFE,LF_HFE"),
        ("--base", "fixed"),
    ]
    others = [run_json(capsys, *FOOT, *change)["mu_P"] for change in changes]
    assert len({round(v, 9) for v in (plain, *others)}) == 1 + len(changes)
    feet = ("robot", DOG, "--contact", "LF_foot,RH_foot", "--pose", "standing", "--poses", "2")
    assert run_json(capsys, *feet)["mu_P"] == plain
    assert run_json(capsys, *feet, "--others", "stuck")["mu_P"] != plain


def test_figure_and_page_are_written(capsys, tmp_path):
    code, out, err = run(
        capsys,
        *FOOT,
        "--mu",
        "2",
        "--out",
        f"{tmp_path}/risk.svg",
        "--report",
        f"{tmp_path}/p.html",
    )
    assert (code, err) == (0, "")
    lines = " ".join(out.split())
    assert "share of poses at risk" in lines and f"written: {tmp_path}/risk.svg" in lines
    assert (tmp_path / "risk.svg").read_text().startswith("<?xml")
    page = (tmp_path / "p.html").read_text()
    assert page.count("<svg") == 1 and "LF_KFE" in page
    for caveat in ("ideal torque control", "taken as rigid", "The contact is one point"):
        assert caveat in page and caveat in " ".join(out.split())


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--contact", "LF_fot"), "unknown frame 'LF_fot'. Did you mean 'LF_foot'?"),
        (("--contact", "LF_foot,LF_foot"), "need different frames"),
        (("--joints", "LF_KFE=9"), "joint LF_KFE: got 9 rad, need a value within its limits -2.4"),
        (("--joints", "LF_KFEE=0"), "unknown joint 'LF_KFEE'. Did you mean 'LF_KFE'?"),
        (("--pose", "sitting"), "unknown pose 'sitting'"),
        (("--normal", "0,0,0"), "need one of positive length"),
        (("--normal", "0,1"), "need three numbers"),
        (("--mu", "-1"), "mu: got -1.0, need a finite number >= 0"),
        (("--radius", "-1"), "radius: got -1.0"),
        (("--locked", "knee"), "unknown joint 'knee'"),
        (("--locked", "all", "--base", "fixed"), "nothing moves"),
        (("--others", "held"), "unknown choice 'held'"),
        (("--base", "flying"), "unknown base 'flying'"),
        (("--armature", "-1"), "armature: got -1.0, need a finite number >= 0"),
        (("--srdf", "absent.srdf"), "No such file"),
        (("--report", "page.pdf"), "need one of .html"),
    ],
)
def test_bad_input_is_one_sentence(capsys, arguments, expected):
    assert expected in rejected(capsys, *FOOT, *arguments)


def test_contact_that_cannot_move_along_the_normal_is_an_error(capsys):
    err = rejected(capsys, "robot", ARM, "--contact", "tip", "--normal", "0,1,0")
    assert "cannot move along the normal" in err


def test_file_is_named_in_errors(capsys, tmp_path):
    (tmp_path / "r.urdf").write_text("<robot name='a'><link name='b'></robot>")
    err = rejected(capsys, "robot", f"{tmp_path}/r.urdf", "--contact", "b")
    assert "r.urdf: not well-formed XML" in err and json.dumps(str(tmp_path)).strip('"') in err


# ---- the contact as a mechanism for classify and jump ----

PLACE = (DOG, "--contact", "LF_foot", "--pose", "standing", "--set", "mu=2")
SLIP = ("--contact-velocity", "0,1,0")


def keys_of(value, where=""):
    """Return the paths of all keys but names of states, parameters and contacts."""
    if isinstance(value, list):
        return {k for inner in value for k in keys_of(inner, where)}
    if not isinstance(value, dict) or where.endswith(("velocity", "state", "parameters")):
        return {where}
    named = where.endswith("contacts")
    paths = ((where if named else f"{where}.{key}", inner) for key, inner in value.items())
    return {k for path, inner in paths for k in keys_of(inner, path)}


@pytest.mark.parametrize("command", ["classify", "jump"])
def test_json_of_a_robot_has_the_keys_of_a_mechanism_in_space(capsys, command):
    robot = run_json(capsys, command, *PLACE, *SLIP)
    named = run_json(capsys, command, "rod-3d", "--state", "theta=1,x_A_dot=-1")
    assert keys_of(robot) - {".notices"} == keys_of(named) - {".notices"}
    assert robot["mechanism"] == "quadruped" and "ideal torque control" in robot["notices"][-1]


def test_jump_of_a_robot_is_that_of_python(capsys):
    import painleve_sym as ps

    data = run_json(capsys, "jump", *PLACE, *SLIP, "--restitution", "0.5", "--rule", "poisson")
    foot = ps.robot(DOG).contact("LF_foot", pose="standing")
    jump = foot.jump("poisson", 2.0, 0.5, contact_velocity=(0.0, 1.0, 0.0))
    assert data["final"]["velocity"] == jump.velocity
    assert data["initial"]["velocity"] == jump.velocity_before
    assert data["phases"] == json.loads(json.dumps([p.to_dict() for p in jump.phases]))
    code, out, _ = run(capsys, "jump", *PLACE, *SLIP)
    assert code == 0 and "LF_KFE_dot [rad/s]" in out and "torque_" not in out


def test_scenario_file_holds_the_contact_of_a_robot(capsys, tmp_path):
    file = tmp_path / "slip.toml"
    file.write_text(
        f"""model = {DOG!r}
contact = "LF_foot,RF_foot"
parameters = {{ mu = 2.0, torque_LF_KFE = "3 N m" }}
contact_velocity = [0, "1 m/s", 0]
restitution = 0.5

[robot]
pose = "standing"
normal = [0.1, 0, 1]
others = "stuck"
radius = "1 cm"
"""
    )
    options = ("--normal", "0.1,0,1", "--others", "stuck", "--radius", "1 cm", *SLIP)
    options += ("--contact", "LF_foot,RF_foot", "--set", "torque_LF_KFE=3", "--restitution", "0.5")
    assert run_json(capsys, "jump", file) == run_json(capsys, "jump", *PLACE, *options)
    options = options[:-2]
    given = run_json(capsys, "classify", file, "--normal", "0,0,1")
    assert given == run_json(capsys, "classify", *PLACE, *options, "--normal", "0,0,1")
    file.write_text(file.read_text().replace("standing", "sitting"))
    code, _, err = run(capsys, "jump", file)
    assert code == 2 and "line 7, robot: robot quadruped: unknown pose 'sitting'" in err
    file.write_text(file.read_text() + "floating = 3\nfeet = 4\n")
    err = rejected(capsys, "jump", file)
    assert "floating: got 3, need true or false" in err and "'feet'" in err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("jump", *PLACE), "at rest there is no impact without collision"),
        (("jump", *PLACE[:-2], *SLIP), "mu: missing, need the friction coefficient >= 0"),
        (("jump", DOG, "--set", "mu=2", *SLIP), "no contact of the robot"),
        (("jump", DOG, "--contact", "LF_fot", "--set", "mu=2"), "unknown frame 'LF_fot'"),
        (("jump", *PLACE[:-1], "mu=-1", *SLIP), "need a finite number with 0 <= mu"),
        (("jump", *PLACE, *SLIP, "--restitution", "2"), "0 <= e_energetic <= 1"),
        (("jump", *PLACE, *SLIP, "--rule", "bouncy"), "unknown restitution law 'bouncy'"),
        (("jump", *PLACE, "--contact-velocity", "0,1"), "need 3 finite numbers along n, t1, t2"),
        (("jump", *PLACE, "--contact-velocity", "1"), "need numbers along n and t"),
        (("jump", *PLACE, "--contact-velocity", "0,a,0"), "--contact-velocity: got 'a'"),
        (("jump", *PLACE, *SLIP, "--state", "LF_KFE=9"), "need a value within its limits"),
        (("jump", *PLACE, *SLIP, "--close", "base_z"), "numbers in space but no formulas"),
        (("jump", "rod", "--pose", "standing"), "got pose with the mechanism 'rod'"),
        (("classify", *PLACE, "--contact-velocity=-1,0,0"), "normal velocity -1 m/s, need 0"),
        (("contrast", *PLACE, *SLIP, "--solvers", "lemke"), "unknown solver 'lemke'"),
        (("derive", DOG), "take robots: robot, and with --contact classify, contrast, jump."),
        (("simulate", DOG, "--law", "hertz"), "the file of a robot, which has no formulas"),
        (("classify", "absent.urdf", "--contact", "foot"), "No such file"),
    ],
)
def test_bad_contact_of_a_robot_is_one_sentence(capsys, words, expected):
    assert expected in rejected(capsys, *words)


GANTRY = """<robot name="gantry"><link name="base"/>
<link name="slide"><inertial><mass value="2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="foot"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="slide"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="z" type="prismatic"><parent link="slide"/><child link="foot"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


def test_a_contact_that_no_friction_moves_along_its_normal_is_never_at_risk(capsys, tmp_path):
    path = tmp_path / "gantry.urdf"
    path.write_text(GANTRY)
    call = ("robot", str(path), "--contact", "foot", "--poses", "5", "--mu", "3")
    code, out, err = run(capsys, *call)
    assert (code, err) == (0, "") and "nan" not in out
    assert "a sliding contact has one answer here, whatever its friction" in out
    assert "search over joint limits reached: inf" in out and "95 %: inf, inf, inf" in out
    data = run_json(capsys, *call)
    assert data["mu_P"] is None and data["least"]["mu_P"] is None and data["share_at_risk"] == 0
    assert set(data["gradient"].values()) == {None}
    page = tmp_path / "gantry.html"
    assert run(capsys, *call, "--report", str(page))[0] == 0
    assert "Whatever its friction" in page.read_text() and "nan" not in page.read_text()
    code, _, err = run(capsys, *call, "--out", str(tmp_path / "gantry.png"))
    assert code == 2 and "got none with a finite mu_P" in err
    log = tmp_path / "log.csv"
    log.write_text("t,x,z\n0,0,0\n1,0.1,0.2\n")
    code, out, _ = run(capsys, *call, "--trajectory", str(log))
    assert code == 0 and "share of time at risk: 0 %" in out
    picture = ("--trajectory", str(log), "--out", str(tmp_path / "along.png"))
    assert "along the motion: got none that is finite" in rejected(capsys, *call, *picture)


def test_a_search_goes_past_poses_that_are_never_at_risk(tmp_path):
    # The rails are tilted by up to 0.1 rad: level ones do not couple both directions.
    link = "<link name='rail'><inertial><mass value='1'/>" + GANTRY.split('<mass value="2"/>')[1]
    link = link.split("</link>")[0] + "</link>"
    joint = """<joint name="tilt" type="revolute"><parent link="base"/><child link="rail"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>"""
    text = GANTRY.replace('<parent link="base"/>', '<parent link="rail"/>')
    text = text.replace('lower="-1" upper="1"', 'lower="-1e-9" upper="1e-9"')
    path = tmp_path / "tilted.urdf"
    path.write_text(text.replace("</robot>", f"{link}{joint}</robot>"))
    foot = ps.robot(path).contact("foot")
    still = np.zeros(2)
    poses = {"tilt": np.array([0.0, 0.05]), "x": still, "z": still}
    assert foot.thresholds(poses)[0] == math.inf
    # W turned by 0.1 has the mobilities 1/kg along the rails' normal, 1/3 along them.
    c, s = math.cos(0.1), math.sin(0.1)
    wanted = (c**2 + s**2 / 3) / (c * s * (1 - 1 / 3))
    least = foot.least(poses)
    assert least.mu_P == pytest.approx(wanted, rel=1e-6)
    assert least.joints["tilt"] == pytest.approx(0.1)
