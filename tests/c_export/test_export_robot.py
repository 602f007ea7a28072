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
    assert "ideal torque control" in header and "QUADRUPED_LF_FOOT_JOINTS = 11" in header
    printed = subprocess.run([built(tmp_path / "c")], capture_output=True, text=True).stdout
    *W, mu_P, direction = map(float, printed.split())
    risk = one.risk()
    np.testing.assert_allclose(np.reshape(W, (3, 3)), risk.W, rtol=0, atol=1e-13)
    assert mu_P == pytest.approx(risk.mu_P, rel=1e-12)
    assert direction == pytest.approx(risk.direction, abs=1e-12)


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
