"""The C code of a robot's contact: the numbers of the package, without warnings, and quick."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.c_export.robot import export_risk
from painleve_sym.errors import InputError
from painleve_sym.problem.risk import slip_angle

DOG = Path(__file__).parents[2] / "examples" / "robots" / "quadruped.urdf"
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror")

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="needs cc")


def contact(**options):
    return ps.robot(DOG).contact("LF_foot", pose="standing", locked="RH_KFE", **options)


def built(folder, level="-O0"):
    sources = sorted(map(str, folder.glob("*.c")))
    program = folder / "example"
    command = ["cc", *FLAGS, level, "-o", str(program), *sources, "-lm"]
    answer = subprocess.run(command, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
    return program


def test_code_has_the_numbers_of_the_package(tmp_path):
    one = contact(normal=(0.3, -0.2, 1.0))
    files = export_risk(one, tmp_path / "c")
    assert files == ("quadruped_lf_foot.h", "quadruped_lf_foot.c", "main.c")
    header = (tmp_path / "c" / files[0]).read_text()
    assert "contact: LF_foot, point (0, 0, 0) m" in header and "locked: RH_KFE" in header
    assert "ideal torque control" in header and "QUADRUPED_LF_FOOT_JOINTS = 11" in header
    printed = subprocess.run([built(tmp_path / "c")], capture_output=True, text=True).stdout
    *W, mu_P, direction = map(float, printed.split())
    risk = one.risk()
    np.testing.assert_allclose(np.reshape(W, (3, 3)), risk.W, rtol=0, atol=1e-13)
    assert mu_P == pytest.approx(risk.mu_P, rel=1e-12)
    assert direction == pytest.approx(slip_angle(risk.direction), abs=1e-12)
    # The sector of directions, at frictions below and above.
    (tmp_path / "c" / "main.c").write_text(
        '#include <stdio.h>\n#include "quadruped_lf_foot.h"\nint main(void) {\n'
        "  quadruped_lf_foot_risk risk = {0};\n  int k;\n  risk.mu_P = 0.8;\n"
        "  for (k = 1; k < 9; ++k)\n"
        '    printf("%.17g\\n", quadruped_lf_foot_half_angle(&risk, 0.25 * k));\n'
        "  return 0;\n}\n"
    )
    printed = subprocess.run([built(tmp_path / "c")], capture_output=True, text=True).stdout
    expected = [math.acos(0.8 / mu) if mu > 0.8 else 0.0 for mu in np.arange(1, 9) / 4]
    np.testing.assert_allclose(list(map(float, printed.split())), expected, rtol=1e-14)


def test_stuck_feet_and_a_turned_base_are_in_the_code(tmp_path):
    feet = ps.robot(DOG).contact("LF_foot,RF_foot", pose="standing", others="stuck")
    feet.values["base_pitch"] = 0.4
    export_risk(feet, tmp_path / "c")
    printed = subprocess.run([built(tmp_path / "c")], capture_output=True, text=True).stdout
    assert float(printed.split()[9]) == pytest.approx(feet.risk().mu_P, rel=1e-12)


def test_one_evaluation_takes_less_than_20_microseconds(tmp_path):
    folder = tmp_path / "c"
    export_risk(contact(), folder)
    main = (folder / "main.c").read_text()
    # Another pose each time, so that nothing is computed once for all.
    varied = re.sub(
        r"(for \(k = 0; k < repeat; \+\+k\)) (.*;)", r"\1 { joints[k % 11] += 1e-7; \2 }", main
    )
    assert varied != main
    (folder / "main.c").write_text(
        varied.replace("#include <stdlib.h>", "#include <stdlib.h>\n#include <time.h>").replace(
            "  for (k = 0; k < 9",
            '  fprintf(stderr, "%.9g", (double)clock() / CLOCKS_PER_SEC);\n  for (k = 0; k < 9',
        )
    )
    answer = subprocess.run([built(folder, "-O2"), "20000"], capture_output=True, text=True)
    assert float(answer.stderr) / 20000 < 20e-6
    assert all(map(math.isfinite, map(float, answer.stdout.split())))


def test_folder_that_holds_something_is_an_error(tmp_path):
    (tmp_path / "notes").write_text("mine")
    with pytest.raises(InputError, match="is not empty"):
        export_risk(contact(), tmp_path)


def half_angles(folder, name, pairs):
    """Return what the function of the half angle gives for thresholds and friction coefficients."""
    rows = "\n".join(
        f'r.mu_P = {p!r}; printf("%.17g\\n", {name}_half_angle(&r, {mu!r}));' for p, mu in pairs
    )
    (folder / "main.c").write_text(
        f'#include <stdio.h>\n#include "{name}.h"\n'
        f"int main(void) {{ {name}_risk r;\n{rows}\nreturn 0; }}\n"
    )
    answer = subprocess.run([built(folder)], capture_output=True, text=True)
    return list(map(float, answer.stdout.split()))


def test_half_angle_is_where_friction_times_its_cosine_is_the_threshold(tmp_path):
    folder = tmp_path / "c"
    export_risk(contact(), folder)
    pairs = [(0.5, 0.4), (0.5, 0.5), (0.5, 1.0), (0.7, 0.8)]
    angles = half_angles(folder, "quadruped_lf_foot", pairs)
    assert angles[:2] == [0.0, 0.0]
    for angle, (mu_P, mu) in zip(angles[2:], pairs[2:], strict=True):
        assert mu * math.cos(angle) == pytest.approx(mu_P, rel=1e-12)


@pytest.mark.parametrize("name", ["3dof", "_x", "ж b-c", "9" * 300])
def test_any_name_of_a_robot_compiles(tmp_path, name):
    path = tmp_path / "robot.urdf"
    path.write_text(DOG.read_text().replace('name="quadruped"', f'name="{name}"', 1), "utf-8")
    foot = ps.robot(path).contact("LF_foot", joints={"LF_HFE": 0.7, "LF_KFE": -1.4})
    files = export_risk(foot, tmp_path / "c")
    assert all(len(file) < 64 and file[0].isalpha() for file in files)
    printed = subprocess.run([built(tmp_path / "c")], capture_output=True, text=True).stdout
    assert float(printed.split()[9]) == pytest.approx(foot.risk().mu_P, rel=1e-12)


def test_robot_with_all_joints_locked_compiles(tmp_path):
    foot = ps.robot(DOG).contact("LF_foot", pose="standing", locked="all")
    export_risk(foot, tmp_path / "c")
    assert "_JOINTS = 0" in (tmp_path / "c" / "quadruped_lf_foot.h").read_text()
    printed = subprocess.run([built(tmp_path / "c")], capture_output=True, text=True).stdout
    assert float(printed.split()[9]) == pytest.approx(foot.risk().mu_P, rel=1e-12)


def test_joint_with_the_name_of_a_normal_is_a_joint_in_the_code(tmp_path):
    text = DOG.read_text().replace("LF_KFE", "normal_x").replace("LF_HFE", "t&quot;&#10;")
    path = tmp_path / "robot.urdf"
    path.write_text(text, "utf-8")
    robot = ps.robot(path)
    other = next(name for name in robot.joints if name.startswith("t"))
    joints = {"normal_x": -1.4, other: 0.7}
    foot = robot.contact("LF_foot", joints=joints)
    export_risk(foot, tmp_path / "c")
    printed = subprocess.run([built(tmp_path / "c")], capture_output=True, text=True).stdout
    plain = ps.robot(DOG).contact("LF_foot", joints={"LF_KFE": -1.4, "LF_HFE": 0.7})
    assert float(printed.split()[9]) == pytest.approx(plain.risk().mu_P, rel=1e-12)


def test_threshold_of_rounding_is_infinite_in_the_code(tmp_path):
    path = tmp_path / "slider.urdf"
    inertial = """<inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"""
    path.write_text(
        f"""<robot name="slider"><link name="world"/><link name="foot">{inertial}</link>
    <joint name="z" type="prismatic"><parent link="world"/><child link="foot"/>
    <axis xyz="1e-14 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""
    )
    export_risk(ps.robot(path).contact("foot"), tmp_path / "c")
    printed = subprocess.run([built(tmp_path / "c")], capture_output=True, text=True).stdout
    assert printed.split()[9:] == ["inf", "0"]


def test_folder_that_cannot_be_written_leaves_nothing(tmp_path, monkeypatch):
    written = []

    def full(self, text, encoding):
        if written:
            raise OSError(28, "No space left on device")
        written.append(self.write_bytes(text.encode(encoding)))

    one = contact()
    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(InputError, match=r"cannot be written: No space left on device"):
        export_risk(one, tmp_path / "new" / "c")
    assert written and list(tmp_path.iterdir()) == []
