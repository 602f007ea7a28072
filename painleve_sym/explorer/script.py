"""The modules of the page in the browser as one script, and its other files."""

from __future__ import annotations

import re
import tomllib
from importlib import resources

MODULES = (
    "settings.js",
    "small_events.js",
    "engine.js",
    "draw.js",
    "controls.js",
    "clock.js",
    "scene.js",
    "problem.js",
    "map.js",
    "motion.js",
    "page.js",
)
"""Each imports only those before it."""

_IMPORT = re.compile(r'^import \{([^}]*)\} from "\./([\w.]+)";\n', re.M)
_EXPORT = re.compile(r"^export ((?:async )?(?:function|class|const) (\w+))", re.M)

# Comments that fill whole lines, and indentation: a quarter of the modules.
_UNREAD = re.compile(r"^ *(?://[^\n]*\n|/\*\*(?:(?!\*/).)*\*/\n| +)", re.M | re.S)


def web_text(name: str) -> str:
    """Return a file of the page's modules."""
    return resources.files(__package__).joinpath("web", name).read_text("utf-8")


def words() -> dict[str, str]:
    """Return words of the glossary that a page uses, each with its meaning."""
    text = resources.files(__package__).joinpath("words.toml").read_text("utf-8")
    meanings: dict[str, str] = tomllib.loads(text)
    return meanings


def script() -> str:
    """Return all modules as one script that fills the object ``modules``.

    Each keeps names of its own: what it exports is returned from a function.
    """
    return "const modules = {};\n" + "\n".join(map(_as_function, MODULES))


def _as_function(name: str) -> str:
    text = _UNREAD.sub("", web_text(name))
    exported = [own for _, own in _EXPORT.findall(text)]
    text = _IMPORT.sub(r'const {\1} = modules["\2"];\n', text)
    text = _EXPORT.sub(r"\1", text)
    return f'modules["{name}"] = (() => {{\n{text}return {{ {", ".join(exported)} }};\n}})();'
