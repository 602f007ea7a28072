"""The command fit: parameters from measured motions, with confidence intervals."""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Mapping
from typing import Any

from painleve_sym.cli.case import read_case
from painleve_sym.cli.options import figure_file, given_options, read_look, read_quantities
from painleve_sym.cli.output import draw, number, print_json, quantity, show, show_table
from painleve_sym.errors import InputError, PainleveWarning
from painleve_sym.motion.simulator import Simulator
from painleve_sym.quantities import counted
from painleve_sym.study.fitting.data import FitData, read_fit_data
from painleve_sym.study.fitting.problem import FitProblem, known_constants
from painleve_sym.study.fitting.result import FitResult


def fit(arguments: argparse.Namespace) -> int:
    """Estimate, write the figure asked for and print the result."""
    look = read_look(arguments)
    out = figure_file("--out", arguments.out, look) if arguments.out is not None else None
    if arguments.estimate is None:
        raise InputError("--estimate: missing. Fix: name parameters, such as e_energetic,mu,E.")
    scenario = read_case(arguments)
    simulator = Simulator(
        scenario.mechanism(), scenario.contact_law(), scenario.engine, scenario.watch
    )
    parameters = {**scenario.parameters, **scenario.law_parameters}
    form = {**scenario.csv, **_csv_options(arguments, scenario.csv)}
    constants = known_constants(simulator, parameters, arguments.estimate)
    data = read_fit_data(arguments.data, scenario.mechanism(), form, constants)
    units = {**scenario.mechanism().state_units, **data.units}
    given = [arguments.sigma] if arguments.sigma else []
    sigma = read_quantities("--sigma", given, lambda: units)
    limits = {} if scenario.max_steps is None else {"max_steps": scenario.max_steps}
    limits |= given_options(arguments, "max_evaluations", "level")
    if data.times is None and scenario.state is None and scenario.close is None:
        # Motions row by row have starts of their own.
        start = scenario.mechanism().start
        start = {name: value for name, value in start.items() if name not in data.starts}
    else:
        start = dict(scenario.start())
    problem = FitProblem(
        simulator=simulator,
        data=data,
        estimate=arguments.estimate,
        state=start,
        parameters=parameters,
        until=scenario.until or (),
        t_end=1.0 if scenario.t_end is None else scenario.t_end,
        sigma=sigma,
        phases=scenario.phases,
        inputs=scenario.inputs,
        **limits,
    )
    fit_result = problem.solve()
    if out is not None:
        draw("fit_figure", out, look, fit_result, units)
    if arguments.json:
        written = {"files": [str(out)]} if out else {}
        print_json(
            {"mechanism": scenario.model, "law": scenario.law, **fit_result.to_dict()} | written
        )
        return 0
    _show(fit_result, data, units)
    if out is not None:
        show(f"drawn: {out}")
    return 0


def _csv_options(arguments: argparse.Namespace, of_file: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of the CSV file that are given as options."""
    given = given_options(arguments, "skip", "separator", "decimal")
    if arguments.column is None:
        return given
    columns = dict(of_file.get("columns", {}))
    for text in arguments.column:
        name, equals, formula = (part.strip() for part in text.partition("="))
        if not (equals and name and formula):
            raise InputError(f"--column: got {text!r}, need NAME=FORMULA, such as 'end y_dot=c2'.")
        columns[name] = formula
    return given | {"columns": columns}


def _show(fit_result: FitResult, data: FitData, units: dict[str, str]) -> None:
    kind = "history" if data.times is not None else "motion row by row"
    values = fit_result.freedom + len(fit_result.names)
    unknowns = counted(len(fit_result.names), "unknown")
    show(f"{kind}, {counted(values, 'measured value')}, {unknowns}")
    show()
    percent = f"{100 * fit_result.level:g} %"
    rows = [
        (
            one["name"],
            number(one["start"]),
            number(one["estimate"], 7),
            number(one["standard_error"], 3),
            " to ".join(number(end, 7) for end in one["interval"]),
            "" if one["unit"] == "1" else one["unit"],
        )
        for one in fit_result.to_dict()["estimates"]
    ]
    head = ("", "start", "estimate", "std. error", f"{percent} interval", "unit")
    show_table(head, rows, left=(0, 5), indent=0)
    show()
    origin = "given" if fit_result.noise_given else "from the residuals"
    noise = ", ".join(f"{n} {quantity(s, units[n], 3)}" for n, s in fit_result.noise.items())
    show(f"standard deviations, {origin}: {noise}")
    if len(fit_result.names) > 1:
        size = len(fit_result.names)
        pairs = [(i, j) for i in range(size) for j in range(i)]
        i, j = max(pairs, key=lambda p: abs(fit_result.correlation[p]))
        value = number(float(fit_result.correlation[i, j]), 3)
        show(f"largest correlation: {fit_result.names[j]} with {fit_result.names[i]}, {value}")
    show(f"{counted(fit_result.evaluations, 'evaluation')}; {fit_result.message}")
    if fit_result.condition > 1e4:
        warnings.warn(
            "the parameters are poorly identifiable "
            f"(condition number {fit_result.condition:.1e}).",
            PainleveWarning,
            stacklevel=2,
        )
