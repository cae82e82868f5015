"""XML as plain nodes with line numbers, by the parser of the standard library (expat).

No document type is accepted, so no entity can grow ("billion laughs"), nothing outside the file is read, and what a
file may hold is bounded. Namespaces are dropped from names: `dcc:quantity` is `quantity`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.core.text import brief, is_usual, raw_bytes, to_number

DEEPEST = 200  # nested elements: the deepest of the published QIF, DCC and STEP-XML samples has 16
LARGEST = 200_000_000  # bytes


@dataclass(eq=False)
class Node:
    """An element: name without namespace, attributes, the text between its tags, children in order, line of its tag."""

    name: str
    attributes: dict[str, str]
    at: str  # file:line
    text: str = ""
    children: list[Node] = field(default_factory=list)

    def one(self, path: str) -> Node | None:
        """Return the first descendant along names "A/B", or None."""
        node: Node | None = self
        for name in path.split("/"):
            node = next((c for c in node.children if c.name == name), None) if node else None
        return node

    def many(self, path: str) -> list[Node]:
        """Return all descendants along names "A/B"."""
        nodes = [self]
        for name in path.split("/"):
            nodes = [c for node in nodes for c in node.children if c.name == name]
        return nodes

    def words(self, path: str, default: str = "") -> str:
        """Return the text of the first descendant along a path, stripped."""
        node = self.one(path)
        return default if node is None else node.text.strip()

    def below(self) -> Iterator[Node]:
        """Yield all descendants, depth first."""
        for child in self.children:
            yield child
            yield from child.below()


def read_xml(path: str | Path) -> Node:
    """Read the root of a file. Raises DataError with file and line: not XML, a document type, too deep or too large."""
    from xml.parsers import expat

    path = Path(path)
    raw = raw_bytes(path)
    if len(raw) > LARGEST:
        raise DataError(f"{path}:1: {len(raw) / 1e6:.0f} MB of XML; at most {LARGEST / 1e6:.0f} MB are read")
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
    builder = _Builder(path, parser)
    parser.StartElementHandler, parser.EndElementHandler = builder.start, builder.end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = builder.data, builder.doctype
    try:
        parser.Parse(raw, True)
    except expat.ExpatError as error:
        raise DataError(
            f"{path}:{error.lineno}: no well-formed XML ({expat.errors.messages[error.code]}); export the file again"
        ) from None
    except (LookupError, ValueError) as error:  # an unknown encoding, or one that expat does not read
        raise DataError(f"{path}:1: {brief(str(error))}; export the file in UTF-8") from None
    return builder.root.children[0]


class _Builder:
    """Collects nodes as the parser meets them."""

    def __init__(self, path: Path, parser: object) -> None:
        self.path, self.parser = path, parser
        self.root = Node("", {}, f"{path}:1")
        self.open = [self.root]

    def _at(self) -> str:
        return f"{self.path}:{self.parser.CurrentLineNumber}"  # type: ignore[attr-defined]

    def start(self, name: str, attributes: dict[str, str]) -> None:
        if len(self.open) > DEEPEST:
            raise DataError(
                f"{self._at()}: elements are nested deeper than {DEEPEST}; nothing that measures is"
            )
        node = Node(_local(name), {_local(k): v for k, v in attributes.items()}, self._at())
        self.open[-1].children.append(node)
        self.open.append(node)

    def end(self, _name: str) -> None:
        self.open.pop()

    def data(self, text: str) -> None:
        self.open[-1].text += text

    def doctype(self, *_: object) -> None:
        raise DataError(
            f"{self._at()}: a document type (<!DOCTYPE ...>) is not read, because entities could make any size of it; delete it"
        )


def _local(name: str) -> str:
    return name.rpartition(" ")[2]


def numbers(node: Node, count: int) -> list[float]:
    """Return the finite numbers of a node, exactly so many. Raises DataError."""
    cells = node.text.split()
    if len(cells) != count:
        raise DataError(f"{node.at}: <{node.name}> holds {len(cells)} numbers; expected {count}")
    return [_finite(cell, node) for cell in cells]


def number(node: Node) -> float:
    """Return the one number of a node."""
    return numbers(node, 1)[0]


def series(node: Node, per_row: int = 1) -> Array:
    """Return all numbers of a node, (n, per_row). Raises DataError where they do not fill rows."""
    cells = node.text.split()
    if not cells or len(cells) % per_row:
        raise DataError(
            f"{node.at}: <{node.name}> holds {len(cells)} numbers, which is no multiple of {per_row}"
        )
    return np.array([_finite(c, node) for c in cells]).reshape(-1, per_row)


def _finite(cell: str, node: Node) -> float:
    try:
        value = to_number(cell)
    except ValueError:
        value = math.nan
    if not is_usual(value):
        raise DataError(f'{node.at}: "{brief(cell)}" in <{node.name}> is not a finite number of usual size')
    return value
