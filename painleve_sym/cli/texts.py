"""Texts of the help that belong to no single command."""

from __future__ import annotations

PROGRAM = "painleve"
DERIVE_FORMATS = ("text", "latex", "python", "json")
AUTOMATON_FORMATS = ("text", "mermaid", "graphviz", "json")

OPENING = """\
Dry-friction contact where rigid-body theory has no solution, or several.

commands:
"""

EXAMPLES = """\
examples:
  painleve classify rod --state theta=1,theta_dot=1,x_A_dot=-1
  painleve simulate rod --state theta=1,theta_dot=1,x_A_dot=-1 \\
      --law bilinear-hertz --law-set E=209e9 --t-end 0.01 --until separation
  painleve jump rod --state theta=1,theta_dot=1,x_A_dot=-1 --restitution 0.75

`painleve COMMAND --help` shows the options of a command. SI units and radians;
with pint installed values may have others: --state theta=30deg --set m=200g.

exit codes: 0 done; 1 failure; 2 bad input; 3 the run stopped early (see
simulate); 130 interrupted; 141 the reader of the output went away (a broken
pipe, as in `| head`)."""

WORDS = ("policy", "reload", "virgin curve", "yield", "settle")
"""Words of options that the help explains."""


def meanings() -> dict[str, str]:
    """Return the meaning of `WORDS`, as in the glossary."""
    from painleve_sym.explorer.script import words

    every = words()
    return {word: every[word] for word in WORDS}
