"""The command animate: a motion drawn as a film."""

from __future__ import annotations

import argparse

from painleve_sym.cli.case import read_case
from painleve_sym.cli.options import given_options, output_file, read_count
from painleve_sym.cli.output import number, print_json, show
from painleve_sym.cli.run import ending, exit_code, show_case
from painleve_sym.quantities import counted


def animate(arguments: argparse.Namespace) -> int:
    """Integrate the motion and write its film."""
    from painleve_sym.present.animation import FORMATS, Animation, check_encoder

    out = output_file("--out", arguments.out, FORMATS)
    check_encoder(out.suffix.lower())
    given = given_options(arguments, "duration")
    if arguments.width is not None:
        given["width"] = read_count("--width", arguments.width)
    scenario = read_case(arguments)
    mechanism, run = scenario.mechanism(), scenario.simulate()
    film = Animation(run, mechanism, **given)
    film.save(out)
    frames = len(film.scene.times)
    if arguments.json:
        data = {"mechanism": mechanism.name, "law": run.law, "events": len(run.events)}
        end = {"time": run.final_time, "stop_reason": run.stop_reason.label}
        print_json({**data, **end, "frames": frames, "files": {"out": str(out)}})
    else:
        show_case(mechanism, scenario)
        show(f"law {run.law}, {counted(len(run.events), 'event')}")
        show(ending(run))
        show(f"{frames} frames, {number(film.duration)} s at {film.rate} per second")
        show(f"film written to {out}")
    return exit_code(run)
