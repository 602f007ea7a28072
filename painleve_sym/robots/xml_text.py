"""Elements and numbers of XML files, which are data of unknown origin.

A document type, with which entities and external files would come, ends the reading at once, as do
too many elements and elements nested too deeply. Nothing but the file itself is opened.
"""

from __future__ import annotations

import codecs
import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from painleve_sym.checks import LARGEST
from painleve_sym.errors import InputError, shortened
from painleve_sym.files import read_bytes

MAX_BYTES, MAX_ELEMENTS, MAX_DEPTH = 16_000_000, 100_000, 200
"""Sizes of a file, a hundred times those of robots with every finger."""
MAX_LIST = 1000
"""Characters of a list of numbers, of which none but positions of joints is long."""
EXPAND_XACRO = (
    "Fix: expand it, with ROS by xacro FILE > robot.urdf, without by pip install xacrodoc and "
    "xacrodoc FILE -o robot.urdf."
)


class _Guarded(ElementTree.TreeBuilder):
    """Builder of XML elements that rejects document types, and too many or too deep elements."""

    def __init__(self, where: str) -> None:
        super().__init__()
        self.where, self.elements, self.depth = where, 0, 0

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        """Stop: a document type declares entities, which can grow without limit or name files."""
        raise InputError(
            f"{self.where}: has a document type (<!DOCTYPE ...>), through which entities could "
            "read other files or fill the memory. Fix: remove it; no robot needs one."
        )

    def start(self, tag: Any, attrs: Any) -> Element:
        """Add an element, within the limits of number and depth."""
        self.elements, self.depth = self.elements + 1, self.depth + 1
        if self.elements > MAX_ELEMENTS or self.depth > MAX_DEPTH:
            raise InputError(
                f"{self.where}: got more than {MAX_ELEMENTS} elements, or elements more than "
                f"{MAX_DEPTH} deep. Fix: give a file of one robot."
            )
        return super().start(tag, attrs)

    def end(self, tag: str) -> Element:
        """Close an element."""
        self.depth -= 1
        return super().end(tag)


def read_elements(path: str | Path, where: str) -> Element:
    """Return the root element of an XML file, in the encoding that it declares.

    Raises
    ------
    InputError
        Not readable, not XML, too large, or with a document type. `where` begins the message.
    """
    content = read_bytes(path, where, MAX_BYTES, "URDF or MJCF file")
    parser = ElementTree.XMLParser(target=_Guarded(where))
    try:
        # The mark of UTF-16 counts, whatever encoding is declared: a shell may have changed it.
        marked = content[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
        parser.feed(content.decode("utf-16") if marked else content)
        root = parser.close()
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        if isinstance(error, InputError):
            raise
        fix = f" {EXPAND_XACRO}" if "prefix" in str(error) and b"xacro:" in content else ""
        raise InputError(f"{where}: not well-formed XML: {error}.{fix}") from error
    assert isinstance(root, Element)
    _refuse_macros(root, where)
    space = root.tag.rpartition("}")[0] + "}"
    for element in root.iter() if len(space) > 1 else ():
        # A namespace of the whole file changes no meaning.
        element.tag = element.tag.removeprefix(space)
    return root


def _refuse_macros(root: Element, where: str) -> None:
    """InputError where a file has elements of xacro, which are to be expanded before."""
    for element in root.iter():
        space, _, tag = element.tag.rpartition("}")
        if "xacro" in space:
            raise InputError(
                f"{where}: <xacro:{shortened(tag, 80)}> is a macro of xacro, which is not part of "
                f"a robot's description. {EXPAND_XACRO}"
            )


def label(element: Element) -> str:
    """Return an element as messages call it: its tag, with its name where it has one."""
    name = element.get("name")
    return f"<{element.tag}>" if name is None else f"<{element.tag} name={shortened(name, 80)!r}>"


def number_list(
    element: Element, key: str, where: str, default: Sequence[float] | None, length: int = 0
) -> list[float]:
    """Return the numbers of an attribute; any count of them where the length is 0.

    InputError where they are not finite numbers of this count, or are missing without a default.
    """
    text = element.get(key)
    if text is None:
        if default is None:
            raise InputError(f"{where}: {label(element)} has no {key}.")
        return list(default)
    try:
        # Each of many elements may have the list of its class.
        few = len(text) <= MAX_LIST or key == "qpos"
        values = [float(word) for word in text.split()] if few else [math.nan]
    except ValueError:
        values = [math.nan]
    wrong = not all(abs(v) <= LARGEST for v in values) or (length and len(values) != length)
    if wrong:
        need = f"{length} finite numbers" if length > 1 else "a finite number"
        need = need if length else "finite numbers"
        fix = f" {EXPAND_XACRO}" if _is_macro(text) else ""
        raise InputError(
            f"{where}: {label(element)}: {key} = {shortened(text, 80)!r}, need {need}.{fix}"
        )
    return values


def one_number(element: Element, key: str, where: str, default: float | None = None) -> float:
    """Return the number of an attribute; InputError where it is not one."""
    return number_list(element, key, where, None if default is None else [default], 1)[0]


def name_of(element: Element, where: str, key: str = "name") -> str:
    """Return a name that must be there; InputError where it is missing or empty."""
    name = element.get(key, "").strip()
    if not name:
        raise InputError(f"{where}: {label(element)} has no {key}.")
    if _is_macro(name):
        raise InputError(
            f"{where}: {label(element)}: {key} = {shortened(name, 80)!r} is an expression of "
            f"xacro. {EXPAND_XACRO}"
        )
    return name


def _is_macro(text: str) -> bool:
    return "${" in text or "$(" in text
