"""Uses of each element and attribute of URDF and MJCF: read, a notice, rejected, no effect.

No effect have those that change neither mass matrix, free acceleration, mobility nor the place of a
contact: pictures, sensors, settings of solvers and of contacts. What a file has beside these lists
is named in a notice.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from xml.etree.ElementTree import Element

from painleve_sym.errors import InputError, shortened
from painleve_sym.robots.xml_text import EXPAND_XACRO, label

WRITTEN_BY_MUJOCO = (
    'Fix: have MuJoCo write the whole file, with inertias: python -c "import mujoco; '
    "s = mujoco.MjSpec.from_file('IN.xml'); s.compiler.saveinertial = True; s.compile(); "
    "open('OUT.xml', 'w').write(s.to_xml())\"; mj_saveLastXML needs "
    '<compiler saveinertial="true"/> for this.'
)
MAX_NAMES = 5
"""Elements that one notice names."""
_ENDS = tuple(f"{kind}{k}" for kind in ("body", "site", "joint", "tendon") for k in (1, 2))


class Use(StrEnum):
    """Use that a reader makes of an element or attribute."""

    READ = "read"
    NOTICE = "notice"
    REJECTED = "rejected"
    NONE = "no effect"


@dataclass(frozen=True)
class Rule:
    """Use of an element or attribute.

    Attributes
    ----------
    use : Use
    sentence : str
        The notice or error, with ``{names}`` for the elements that it concerns.
    neutral : str
        Value of the attribute that changes nothing, as no attribute does.
    flag : str
        Flag of MJCF that switches it off.
    """

    use: Use
    sentence: str = ""
    neutral: str = ""
    flag: str = ""


Attributes = Mapping[str, Rule]
Table = Mapping[str, Rule | Attributes]
"""Rules by path: of a whole element, or of each of its attributes."""

_READ, _NONE = Rule(Use.READ), Rule(Use.NONE)


def _element(read: str = "", none: str = "", **others: Rule) -> Attributes:
    known = dict.fromkeys(read.split(), _READ) | dict.fromkeys(none.split(), _NONE)
    return known | others


def _notice(sentence: str, neutral: str = "", flag: str = "") -> Rule:
    return Rule(Use.NOTICE, sentence, neutral, flag)


def _rejected(sentence: str, neutral: str = "") -> Rule:
    return Rule(Use.REJECTED, sentence, neutral)


_TURN = "quat axisangle euler xyaxes zaxis"
_FRICTION = _notice(
    "Dry friction of joints is not part of the numbers, which are those of joints that move "
    "freely; the other limit, joints that their friction holds, is --locked: {names}.",
    "0",
    "frictionloss",
)
_MADE = _rejected("{names} makes bodies that are not written in the file. " + WRITTEN_BY_MUJOCO)
_PLUGIN = _notice("Forces of plugins are not read: {names}.")
_FLUID = _notice("The forces of a fluid around the robot are not read: {names}.", "0")
_TENDON_MASS = _notice(
    "The armature of tendons is not read; mass matrix and mobility are without it: {names}.", "0"
)
_TENDON_FORCE = _notice(
    "Forces of tendons are not read; free accelerations are without them: {names}.", "0"
)
_ALIGNED = _notice(
    "MuJoCo moves the frame of a free body to its centre of mass here; this answer has it where "
    "the file puts it: {names}.",
    "false",
)
_OPEN = _notice(
    "Constraints of <equality> close chains or couple joints. Every number here is that of the "
    "open tree, without them, and may be far from that of the closed one: {names}.",
    flag="equality",
)
_ACTUATORS = _notice(
    "Forces of actuators are not read; the torques of joints are those that are given, or 0: "
    "{names}."
)
_VELOCITY = _notice("Velocities of keyframes are not read; poses are at rest: {names}.", "0")
_TENDON = _element(
    none="name class group limited range margin material width rgba user springlength springyield "
    "solreflimit solimplimit solreffriction solimpfriction actuatorfrclimited actuatorfrcrange",
    armature=_TENDON_MASS,
    stiffness=_TENDON_FORCE,
    damping=_TENDON_FORCE,
    frictionloss=_TENDON_FORCE,
)
_EQUALITIES = ("connect", "weld", "joint", "tendon", "flex", "flexstrain")
DRIVES = (
    *("general", "motor", "position", "velocity", "intvelocity", "orientation", "pid", "damper"),
    *("cylinder", "muscle", "adhesion", "dcmotor", "plugin"),
)
"""Elements of actuators; they share their defaults."""
_DRIVE = (
    "name class group user tendon cranksite slidersite cranklength site refsite body jointinparent "
    "ctrllimited ctrlrange forcelimited forcerange actlimited actrange actdim actearly lengthrange "
    "delay interp nsample inheritrange input velrange ffrange posrange kp kv ki kd imax slewmax "
    "dampratio timeconst dyntype gaintype biastype dynprm gainprm biasprm area diameter bias "
    "force scale lmin lmax vmax fpmax fvmax range gain cogging controller inductance lugre "
    "motorconst nominal resistance saturation thermal plugin instance tausmooth"
)

MJCF: Table = {
    "mujoco": _element("model"),
    "compiler": _element(
        "angle autolimits eulerseq inertiafromgeom inertiagrouprange balanceinertia boundmass "
        "boundinertia settotalmass fusestatic",
        "assetdir conflict discardvisual fitaabb meshdir passthrough savecanonical "
        "savecompiled saveinertial strippath texturedir usethread convexhull exactmeshinertia",
        alignfree=_ALIGNED,
        coordinate=_rejected(
            "compiler: coordinate is not local, which MuJoCo dropped.", neutral="local"
        ),
    ),
    "compiler/lengthrange": _NONE,
    "option": _element(
        "gravity",
        "actuatorgroupdisable ccd_iterations ccd_tolerance cone impratio integrator iterations "
        "jacobian ls_iterations ls_tolerance magnetic noslip_iterations noslip_tolerance "
        "o_friction o_margin o_solimp o_solref sdf_initpoints sdf_iterations sleep_tolerance "
        "solver timestep tolerance wind apirate collision mpr_iterations mpr_tolerance",
        density=_FLUID,
        viscosity=_FLUID,
    ),
    "option/flag": _element(
        "equality frictionloss constraint gravity spring damper passive",
        "actuation autoreset clampctrl contact diagexact energy eulerdamp filterparent fwdinv "
        "invdiscrete ipc island limit midphase multiccd nativeccd override refsafe sensor sleep "
        "speculative warmstart sensornoise",
    ),
    "size": _NONE,
    "statistic": _NONE,
    "visual": _NONE,
    # Defaults count where an element takes them.
    "default": _READ,
    "extension": _NONE,
    # Meshes matter where a body takes its inertia from one, which is rejected there.
    "asset": _NONE,
    "worldbody": _element(),
    "body": _element(
        f"name pos childclass gravcomp {_TURN}",
        "simple fuse sleep user",
        mocap=_notice("A mocap body stands where the file puts it: {names}.", "false"),
    ),
    "body/frame": _element(f"name pos childclass {_TURN}"),
    "body/inertial": _element(f"pos mass diaginertia fullinertia {_TURN}"),
    "body/joint": _element(
        "name class type pos axis range limited ref armature stiffness springref damping",
        "group user margin solreflimit solimplimit solreffriction solimpfriction "
        "actuatorfrclimited actuatorfrcrange",
        frictionloss=_FRICTION,
        springdamper=_notice(
            "Time constants of joints (springdamper) are not read; free accelerations are without "
            "their springs and dampers: {names}.",
            "0",
        ),
        springyield=_notice("Springs that yield are taken as elastic: {names}.", "0"),
        actuatorgravcomp=_notice(
            "Gravity compensation by actuators is taken as exact, without limits of force: "
            "{names}.",
            "false",
        ),
    ),
    # A joint of the type free; its springs depend on the place of the base.
    "body/free": _element(
        "name class type armature damping",
        "pos axis range limited ref group user margin solreflimit solimplimit solreffriction "
        "solimpfriction actuatorfrclimited actuatorfrcrange springref springdamper springyield "
        "actuatorgravcomp",
        stiffness=_notice("Springs of free joints are not read: {names}.", "0"),
        frictionloss=_notice("Dry friction of free joints is not read: {names}.", "0"),
    ),
    "body/freejoint": _element("name", "group", align=_ALIGNED),
    "body/geom": _element(
        f"name class type pos size fromto mass density mesh group shellinertia {_TURN}",
        "castshadow conaffinity condim contype fitscale fluidcoef fluidshape friction gap hfield "
        "margin material priority rgba solimp solmix solref user",
        adhesion=_notice("Adhesion of contacts is not read: {names}.", "0"),
        surfacevel=_notice("Surfaces that move on their geoms are taken at rest: {names}.", "0"),
    ),
    "body/geom/plugin": _PLUGIN,
    "body/site": _element(
        f"name class type pos size fromto mesh {_TURN}", "group material rgba user"
    ),
    "body/camera": _NONE,
    "body/light": _NONE,
    "body/plugin": _PLUGIN,
    "body/attach": _MADE,
    "body/flexcomp": _MADE,
    "body/composite": _MADE,
    "body/replicate": _MADE,
    "deformable": _notice("Deformable bodies are not read, neither mass nor forces: {names}."),
    "contact": _NONE,
    "tendon": _element(),
    "tendon/spatial": _TENDON,
    "tendon/spatial/site": _NONE,
    "tendon/spatial/geom": _NONE,
    "tendon/spatial/pulley": _NONE,
    "tendon/fixed": _TENDON,
    "tendon/fixed/joint": _NONE,
    "equality": _element(),
    **{f"equality/{tag}": _OPEN for tag in _EQUALITIES},
    "actuator": _element(),
    "actuator/motor": _element("armature damping gear joint", _DRIVE),
    **{
        f"actuator/{tag}": _element("armature damping gear joint", _DRIVE, **{"": _ACTUATORS})
        for tag in DRIVES
        if tag != "motor"
    },
    "actuator/plugin/config": _NONE,
    "sensor": _NONE,
    "custom": _NONE,
    "keyframe": _element(),
    "keyframe/key": _element("name qpos", "act ctrl mpos mquat plastic time", qvel=_VELOCITY),
    "include": _rejected("includes another file, which is not read. " + WRITTEN_BY_MUJOCO),
}
"""MuJoCo 4, with what older files have. In bodies, paths begin with ``body``, however deep."""

_POSE = "xyz rpy quat_xyzw"
_GAZEBO = _notice("Elements of Gazebo are not read: {names}.")
_GAZEBO_FORCES = (
    "springReference springStiffness implicitSpringDamper dampingFactor turnGravityOff gravity "
    "kinematic static plugin joint link gripper velocity_decay"
)
_GAZEBO_CONTACT = (
    "material visual sensor collision selfCollide self_collide maxContacts mu mu1 mu2 kp kd fdir1 "
    "minDepth maxVel laserRetro provideFeedback preserveFixedJoint disableFixedJointLumping "
    "disable_fixed_joint_lumping stopCfm stopErp cfmDamping fudgeFactor"
)
_XACRO = _rejected("{names} is a macro of xacro without its namespace. " + EXPAND_XACRO)
URDF: Table = {
    "robot": _element("name", "version"),
    "robot/link": _element("name", "type"),
    "robot/link/inertial": _element(),
    "robot/link/inertial/origin": _element(_POSE),
    "robot/link/inertial/mass": _element("value"),
    "robot/link/inertial/inertia": _element("ixx ixy ixz iyy iyz izz"),
    "robot/link/visual": _NONE,
    "robot/link/collision": _NONE,
    "robot/link/contact": _notice("Elements of Bullet are not read: {names}."),
    "robot/link/sensor": _NONE,
    "robot/joint": _element("name type"),
    "robot/joint/origin": _element(_POSE),
    "robot/joint/parent": _element("link"),
    "robot/joint/child": _element("link"),
    "robot/joint/axis": _element("xyz"),
    "robot/joint/limit": _element("lower upper", "effort velocity acceleration deceleration jerk"),
    "robot/joint/dynamics": _element("damping", friction=_FRICTION),
    "robot/joint/mimic": _element("joint multiplier offset"),
    "robot/joint/calibration": _NONE,
    "robot/joint/safety_controller": _NONE,
    "robot/material": _NONE,
    "robot/macro": _XACRO,
    "robot/property": _XACRO,
    "include": _XACRO,
    "robot/transmission": _NONE,
    "robot/sensor": _NONE,
    "robot/ros2_control": _NONE,
    "robot/gazebo": _element("reference"),
    **dict.fromkeys((f"robot/gazebo/{tag}" for tag in _GAZEBO_CONTACT.split()), _NONE),
    **dict.fromkeys((f"robot/gazebo/{tag}" for tag in _GAZEBO_FORCES.split()), _GAZEBO),
    "robot/mujoco": _notice(
        "Settings of MuJoCo are not read, neither bounds of inertias nor total mass: {names}."
    ),
}
"""URDF 1.0 to 1.2, with the extensions that files have."""


def rule(table: Table, path: str, attribute: str = "") -> Rule | None:
    """Return the rule of an element, or of one of its attributes; None outside the lists.

    An element without rules of its own has that of the element that it is in.
    """
    own = table.get(path)
    while own is None and "/" in path:
        path = path.rpartition("/")[0]
        above = table.get(path)
        own = above if isinstance(above, Rule) else None
    if own is None or isinstance(own, Rule):
        return own
    return own.get(attribute) if attribute else own.get("", _READ)


def paths(root: Element, table: Table) -> Iterator[tuple[str, Element, Element]]:
    """Yield each element with its path and parent, except inside elements of whole rules."""
    waiting = [(root.tag, root, root)]
    while waiting:
        path, element, parent = waiting.pop()
        yield path, element, parent
        if isinstance(table.get(path), Mapping):
            waiting += ((child_path(path, e.tag), e, element) for e in reversed(element))


def child_path(path: str, tag: str) -> str:
    """Return the path of an element in another one."""
    if path == "mujoco" or tag == "include":
        return tag
    if path in ("worldbody", "body", "body/frame"):
        return "body" if tag == "body" else f"body/{tag}"
    return f"{path}/{tag}"


def review(
    elements: Iterable[tuple[str, Element, str]], table: Table, where: str, off: Iterable[str] = ()
) -> tuple[str, ...]:
    """Return the notices on elements; InputError for the first one that is rejected.

    Parameters
    ----------
    elements : iterable of (str, Element, str)
        Path, element with its defaults, and what messages call it.
    table : Table
    where : str
        Begins messages.
    off : iterable of str
        Flags of what the file switches off.
    """
    concerned: dict[str, dict[str, None]] = {}
    unknown: dict[str, None] = {}
    for path, element, name in elements:
        whole = rule(table, path)
        if whole is None:
            unknown[f"<{_short(element.tag)}>"] = None
            continue
        rules = [(whole, name)]
        if isinstance(table.get(path), Mapping):
            for key, value in element.attrib.items():
                own = rule(table, path, key)
                if own is None:
                    unknown[f"{_short(key)} of <{_short(element.tag)}>"] = None
                elif not _same(value, own.neutral):
                    rules.append((own, f"{name} ({key} = {shortened(value, 40)})"))
        for own, said in rules:
            if own.flag and own.flag in off:
                continue
            if own.use is Use.REJECTED:
                raise InputError(f"{where}: {own.sentence.format(names=name)}")
            if own.use is Use.NOTICE:
                concerned.setdefault(own.sentence, {})[said] = None
    notices = [s.format(names=_listed(names)) for s, names in concerned.items()]
    if unknown:
        notices.append(f"Not read, since it is part of no list of the format: {_listed(unknown)}.")
    return tuple(notices)


def _short(tag: str) -> str:
    """Return a tag without the address of its namespace."""
    return shortened(tag.rpartition("}")[2], 80)


def _listed(names: Iterable[str]) -> str:
    names = list(names)
    more = f" and {len(names) - MAX_NAMES} more" * (len(names) > MAX_NAMES)
    return ", ".join(names[:MAX_NAMES]) + more


def _same(value: str, neutral: str) -> bool:
    """Return whether a value is the neutral one; of several numbers, whether all are."""
    if not neutral:
        return False
    if value.strip() == neutral:
        return True
    try:
        return all(float(word) == float(neutral) for word in value.split())
    except ValueError:
        return False


def called(element: Element) -> str:
    """Return the label of an element in notices: its name, else the elements that it connects."""
    if (name := element.get("name")) is not None:
        return f"{element.tag} {shortened(name, 80)!r}"
    ends = [shortened(element.get(key, ""), 80) for key in _ENDS if key in element.attrib]
    return f"{label(element)} of {' and '.join(ends)}" if ends else label(element)
