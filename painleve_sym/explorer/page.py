"""The explorer as one HTML file that opens from disk: modules, style, names and code inlined."""

from __future__ import annotations

import base64
import gzip
import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from painleve_sym.at.inputs import inside, place_of
from painleve_sym.checks import StateLike, by_name, number
from painleve_sym.codegen.named_mechanisms import MechanismLike, as_mechanism
from painleve_sym.engines.protocol import DEFAULT_RTOL
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.escape import html_json, html_text
from painleve_sym.explorer.prebuilt import Laws, default_law, stored_module
from painleve_sym.explorer.presets import presets
from painleve_sym.explorer.script import script, web_text, words
from painleve_sym.files import write_beside
from painleve_sym.laws.catalogue import LawsByContact, LawsLike, as_law
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.energy_balance import open_from
from painleve_sym.motion.joined import JoinedRecord
from painleve_sym.motion.run_record import StoredRecord
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.units import Value, in_si
from painleve_sym.version import __version__

if TYPE_CHECKING:
    from painleve_sym.explorer.notebook import ExplorerWidget

# Nothing may be loaded, from anywhere.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; "
    "style-src 'unsafe-inline'; img-src data:"
)

_PAGE = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>{title}</title>
<style>
{style}
html {{ background: light-dark(#ffffff, #16181a); }}
body {{ margin: 0; }}
</style>
</head>
<body>
<main id="explorer"><p>The page is being prepared.</p></main>
<noscript><p>This page computes in the browser and needs JavaScript with WebAssembly;
<code>painleve simulate</code> computes the same numbers.</p></noscript>
<script type="application/json" id="data">{data}</script>
<script type="module">
{script}
const root = document.getElementById("explorer");
const data = JSON.parse(document.getElementById("data").textContent);
modules["page.js"].mount(root, data).catch((error) => {{
  root.textContent = `The page cannot compute: ${{error.message}}.`;
}});
</script>
</body>
</html>
"""


@dataclass(frozen=True, eq=False)
class Page(Compared):
    """An explorer page: names of mechanism, law and engines of the motions, and all it is made of.

    An engine is ``taylor``, or ``compiled`` where a mode has no Taylor series. A prebuilt module
    was taken from the package, so that no compiler was needed; `module_bytes` is the size of the
    WebAssembly. `data` are names, module, presets and first numbers, as plain data.
    """

    mechanism: str
    law: str
    engines: tuple[str, ...]
    prebuilt: bool
    module_bytes: int
    data: Mapping[str, Any] = field(repr=False)

    @property
    def html(self) -> str:
        """The whole page."""
        return _PAGE.format(
            policy=_POLICY,
            title=html_text(f"{self.mechanism}: explorer"),
            style=web_text("style.css"),
            data=html_json(self.data),
            script=script(),
        )

    def widget(self) -> ExplorerWidget:
        """Return the page as a widget of notebooks; InputError where anywidget is not installed."""
        if importlib.util.find_spec("anywidget") is None:
            raise InputError(
                "explorer widget: needs anywidget. Fix: pip install 'painleve-sym[notebook]'."
            )
        from painleve_sym.explorer.notebook import ExplorerWidget

        return ExplorerWidget(data=dict(self.data))

    def save(self, path: str | Path) -> None:
        """Write the file whole, or not at all; InputError where the folder cannot be written."""
        write_beside(path, lambda file: file.write(self.html.encode()))


def explore(
    mechanism: MechanismLike,
    law: LawsLike | None = None,
    state: StateLike | None = None,
    *,
    parameters: Mapping[str, Value] | None = None,
    law_parameters: Mapping[str, Value] | None = None,
    initial_force: Value | None = None,
    t_end: Value | None = None,
    close: str | None = None,
    docs: str | None = None,
    out: str | Path | None = None,
) -> Page:
    """Return a page in which the contact mechanics of a mechanism is computed live.

    One file without references to others: the motions with the law, and rigid ones beside a
    compliant law, are WebAssembly in it. That of the rod with its default law is part of the
    package; others are compiled once and kept in the cache.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
    law : ContactLaw or RigidLaw, or its name, or mapping of contact to these, optional
        By default bilinear Hertz, or rigid where a contact holds from both sides.
    state : mapping of str to (float or str), optional
        Coordinates and velocities at first; the mechanism's `start` where no state is given.
    parameters, law_parameters, initial_force
        At first, as for `simulate`.
    t_end : float, optional
        End of the motions at first; s.
    close : str, optional
        A coordinate for which gap = 0 is solved; see `closed_state`.
    docs : str, optional
        Address of the documentation site, absolute or from the page: panels then link to it.
    out : path, optional
        File to write.

    Raises
    ------
    InputError
        Input that `simulate` rejects; a file that cannot be written.
    CompilerMissing
        The module is not part of the package and there is no compiler for WebAssembly.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> page = ps.explore("rod")
    >>> page.prebuilt, len(page.html) < 400_000
    (True, True)
    """
    mechanism = as_mechanism(mechanism)
    given: Any = default_law(mechanism) if law is None else as_law(law)
    laws: Laws = LawsByContact(given) if isinstance(given, Mapping) else given
    stored = stored_module(mechanism, laws)
    notes: list[str] = []
    if stored is None:
        # What derives and compiles is not loaded for a stored module.
        from painleve_sym.explorer.exact_start import exact_start
        from painleve_sym.explorer.source import ModuleSource
        from painleve_sym.explorer.wasm import described_module

        description, compiled = described_module(ModuleSource(mechanism, laws))
        outline = mechanism.outline
        given = (
            None if state is None else outline.named_state(f"state of {mechanism.name!r}", state)
        )
        if close is None and given in (None, mechanism.start):
            state, notes = exact_start(mechanism)
    else:
        packed, description = stored
    initial = _initial(
        mechanism, laws, description, state, parameters, law_parameters, initial_force, t_end, close
    )
    if stored is None:
        packed = packed_module(compiled())
    data = {
        "description": description,
        "module": base64.b64encode(packed).decode("ascii"),
        "presets": presets(description),
        "initial": initial,
        "words": words(),
        "tolerances": {"rtol": DEFAULT_RTOL, "openFrom": open_from(DEFAULT_RTOL)},
        "docs": docs,
        "notes": notes,
        "version": __version__,
    }
    page = Page(
        mechanism=mechanism.name,
        law=laws.name,
        engines=tuple(motion["engine"] for motion in description["motions"]),
        prebuilt=stored is not None,
        module_bytes=len(gzip.decompress(packed)),
        data=data,
    )
    if out is not None:
        page.save(out)
    return page


def explore_motion(run: Trajectory) -> ExplorerWidget:
    """Return the explorer of a motion as a widget of notebooks; see `Trajectory.explore`."""
    record = run.record
    if isinstance(record, StoredRecord):
        raise InputError(
            "explorer: the trajectory comes from a file or another process, which do not keep "
            "the mechanism. Fix: call painleve_sym.explore with mechanism, law and state."
        )
    if isinstance(record, JoinedRecord):
        raise InputError(
            "explorer: the motion has phases or inputs, and a page computes one with the same laws "
            "and parameters from start to end. Fix: explore a motion without them."
        )
    simulator, start = record.simulator, record.start
    if start.time:
        raise InputError(
            f"explorer: the motion continues another one from t = {start.time:g} s on, and a page "
            "begins with a state at t = 0. Fix: explore the first motion."
        )
    mechanism, used = simulator.mechanism, start.place.parameters
    return explore(
        mechanism,
        simulator.law,
        dict(zip(mechanism.state_names, start.state.tolist(), strict=False)),
        parameters={n: used[n] for n in mechanism.parameters},
        law_parameters={p.name: used[p.name] for p in simulator.own_parameters},
        t_end=run.final_time,
    ).widget()


def packed_module(code: bytes) -> bytes:
    """Return a module as a gzip file that holds no date."""
    return gzip.compress(code, 9, mtime=0)


def _initial(
    mechanism: Mechanism,
    laws: Laws,
    description: Mapping[str, Any],
    state: StateLike | None,
    parameters: Mapping[str, Value] | None,
    law_parameters: Mapping[str, Value] | None,
    initial_force: Value | None,
    t_end: Value | None,
    close: str | None,
) -> dict[str, Any]:
    """Return the numbers that a page begins with, checked as those of a motion."""
    where = f"explorer of {mechanism.name!r}"
    place = inside(place_of(mechanism, state, parameters, close, where=where))
    own = by_name(law_parameters, f"{where}: law_parameters", "{'E': 2e11}")
    values = place.values | _of_law(where, laws, description, own)
    initial: dict[str, Any] = {"values": values}
    if "reload" in laws.choices:
        initial["reload"] = laws.choices["reload"]
    if t_end is not None:
        initial["end"] = number(t_end, "t_end", where=where, unit="s", above=0.0)
    if initial_force is not None:
        if not description["motions"][0]["pressable"]:
            raise InputError(
                f"{where}: initial_force: need one compliant contact. Fix: leave it out."
            )
        initial["force"] = number(initial_force, "initial force", where=where, unit="N", lower=0.0)
    return initial


def _of_law(
    where: str, laws: Laws, description: Mapping[str, Any], given: Mapping[str, Value]
) -> dict[str, float]:
    """Return the law's parameters by their names on the page: those given, else its defaults."""
    own = [p["name"] for p in description["parameters"] if p["of"] == "law"]
    defaults = {p.name: p.default for p in laws.parameters}
    given = in_si(given, {p.name: p.unit for p in laws.parameters}, f"{where}: law")
    values = {}
    for name, value in (defaults | given).items():
        here = f"{name}_law" if f"{name}_law" in own else name
        if here in own:
            values[here] = float(value)
        elif name in given:
            raise InputError(f"{where}: law: unknown parameter {name!r}. Known: {', '.join(own)}.")
    return values
