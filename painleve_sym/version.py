"""The version of the package: that of a release, or of a development build with its commit.

It is a local version of PEP 440 such as ``0.8.0.dev0+g1a2b3c4d``: numbers that a development build
computed name the commit from which they come. A clone asks its git folder, a source archive its
``PKG-INFO``, and an installed package the name of its metadata. The module imports nothing of the
package, because setuptools loads it alone.
"""

import os

RELEASE = "0.8.0.dev0"
"""The version without its commit: with ``.dev``, of the builds before that release."""

_ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
_DIGITS = 8


def _text(*path: str) -> str:
    """Return the text of a file, or none where it cannot be read."""
    try:
        with open(os.path.join(*path), encoding="utf-8") as file:
            return file.read().strip()
    except (OSError, UnicodeDecodeError):
        return ""


def _commit(root: str) -> str:
    """Return the commit that is checked out in a clone, or an empty text where there is none."""
    folder = os.path.join(root, ".git")
    if link := _text(folder).removeprefix("gitdir: "):  # a work tree, or a submodule
        folder = os.path.join(root, link)
    head = _text(folder, "HEAD")
    if not head.startswith("ref: "):
        return head
    name = head.removeprefix("ref: ")
    shared = os.path.join(folder, _text(folder, "commondir"))
    packed = (line.split() for line in _text(shared, "packed-refs").splitlines())
    named = [words[0] for words in packed if words[1:] == [name]]
    return _text(folder, name) or _text(shared, name) or "".join(named[:1])


def _installed(root: str) -> str:
    """Return the version that the metadata of an archive or of an installed package have."""
    for line in _text(root, "PKG-INFO").splitlines():
        if line.startswith("Version: "):
            return line.removeprefix("Version: ")
    start, end = "painleve_sym-", ".dist-info"
    for name in os.listdir(root):
        if name.startswith(start) and name.endswith(end):
            return name.removeprefix(start).removesuffix(end)
    return RELEASE


def _version(root: str) -> str:
    """Return the version of the package in a folder."""
    if ".dev" not in RELEASE:
        return RELEASE
    if not os.path.exists(os.path.join(root, "pyproject.toml")):
        return _installed(root)
    commit = _commit(root)
    return f"{RELEASE}+g{commit[:_DIGITS]}" if commit else _installed(root)


__version__ = _version(_ROOT)
