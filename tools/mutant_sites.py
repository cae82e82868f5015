"""Where a source file can be broken in one place: operators, comparisons, signs, numbers, and/or, min/max, terms of a sum.

A change is a piece of text put in the place of another, so that all else of the file stays as it is. "formula" is a change
within arithmetic that computes a result; everything else (thresholds, guards, defaults, constants, indices) is "other".

Left out by rule, because no number can depend on it or a test would only repeat it:
    docstrings, annotations, decorators, `if TYPE_CHECKING`;
    raise, assert, f-strings and what is given to an exception: the words of messages;
    numbers of report/ and pages/ and of modules that draw (layout, pixels); their arithmetic counts as "other";
    numbers within an index or a slice, arguments that name an axis or a shape (AXES, SHAPES), and 0;
    `+ - * /` of texts, lists and paths.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass, replace
from pathlib import Path

DRAWING = re.compile(r"vcmm/show/(report|pages|charts)/|_page\.py$")
AXES = {"axis", "ndmin", "ndim", "decimals", "digits", "indent", "width", "maxiter", "maxfun", "keepdims"}
SHAPES = {"range", "reshape", "zeros", "ones", "empty", "eye", "full", "round", "zeros_like", "expand_dims", "swapaxes", "repeat", "tile"}  # fmt: skip
MESSAGES = re.compile(r"(Error|Limit|Warning|Exit|warn|print|write|join|format|report|progress)$")
OPERATORS = {ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*")}
COMPARISONS = {
    ast.Lt: ("<", ">="), ast.LtE: ("<=", ">"), ast.Gt: (">", "<="), ast.GtE: (">=", "<"), ast.Eq: ("==", "!="), ast.NotEq: ("!=", "=="),
    ast.Is: ("is", "is not"), ast.IsNot: ("is not", "is"), ast.In: ("in", "not in"), ast.NotIn: ("not in", "in"),
}  # fmt: skip
OTHERS = {
    "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "argmin": "argmax", "argmax": "argmin",
    "nanmin": "nanmax", "nanmax": "nanmin", "fmin": "fmax", "fmax": "fmin",
}  # fmt: skip
ARITHMETIC = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.MatMult)


@dataclass(frozen=True)
class Site:
    """One change: bytes start to end of `file` become `after`. line, before_line, after_line: for people
    (`shown`). owner: the function it stands in, "" at module level; kind: operator, term, comparison,
    sign, number, logic, extreme.
    """

    file: str
    start: int
    end: int
    before: str
    after: str
    kind: str
    formula: bool
    owner: str
    line: int = 0
    before_line: str = ""
    after_line: str = ""

    @property
    def key(self) -> str:
        return f"{self.file} | {self.before_line} -> {self.after_line}"

    def applied(self, source: bytes) -> bytes:
        return source[: self.start] + self.after.encode() + source[self.end :]


@dataclass(frozen=True)
class _Place:
    """What surrounds a node on the way down."""

    owner: str = ""
    arithmetic: bool = False  # within + - * / ** @
    guard: bool = False  # a test, a comparison, a default, a constant of the module
    index: bool = False


class _Reader:
    def __init__(self, file: str, source: bytes) -> None:
        self.file, self.source, self.sites = file, source, list[Site]()
        self.starts = [0]
        for line in source.split(b"\n"):
            self.starts.append(self.starts[-1] + len(line) + 1)
        self.drawing = bool(DRAWING.search(file))

    def at(self, node: ast.AST, end: bool = False) -> int:
        """Byte at which a node begins or ends."""
        line, column = (node.end_lineno, node.end_col_offset) if end else (node.lineno, node.col_offset)  # type: ignore[attr-defined]
        return self.starts[line - 1] + column

    def add(self, start: int, end: int, after: str, kind: str, place: _Place, formula: bool) -> None:
        formula = formula and bool(place.owner) and not (place.guard or place.index or self.drawing)
        before = self.source[start:end].decode()
        self.sites.append(Site(self.file, start, end, before, after, kind, formula, place.owner))

    def between(self, left: ast.AST, right: ast.AST, token: str) -> tuple[int, int] | None:
        """Where an operator stands between two nodes."""
        start, end = self.at(left, True), self.at(right)
        gap = re.sub(rb"#[^\n]*", lambda m: b" " * len(m[0]), self.source[start:end])
        word = rb"\b" if token[0].isalpha() else b""
        pattern = word + re.escape(token.encode()).replace(rb"\ ", rb"\s+") + word
        found = re.search(pattern, gap)
        return (start + found.start(), start + found.end()) if found else None

    # ------------------------------------------------------------------ the way down

    def visit(self, node: ast.AST, place: _Place) -> None:
        handler = getattr(self, f"_{type(node).__name__}", None)
        if handler is not None:
            handler(node, place)
        else:
            self.children(node, place)

    def children(self, node: ast.AST, place: _Place) -> None:
        for child in ast.iter_child_nodes(node):
            self.visit(child, place)

    def _skip(self, node: ast.AST, place: _Place) -> None:
        del node, place

    _Raise = _Assert = _JoinedStr = _Import = _ImportFrom = _arg = _skip

    def _FunctionDef(self, node: ast.FunctionDef, place: _Place) -> None:
        inner = f"{place.owner}.<locals>.{node.name}" if place.owner else f"{self.of_class}{node.name}"
        for default in (*node.args.defaults, *(d for d in node.args.kw_defaults if d)):
            self.visit(default, replace(place, guard=True))
        for statement in node.body:
            self.visit(statement, _Place(owner=inner))

    of_class = ""

    def _ClassDef(self, node: ast.ClassDef, place: _Place) -> None:
        outer, self.of_class = self.of_class, f"{self.of_class}{node.name}."
        for statement in node.body:
            self.visit(statement, replace(place, guard=True))
        self.of_class = outer

    def _AnnAssign(self, node: ast.AnnAssign, place: _Place) -> None:
        if node.value is not None:
            self.visit(node.value, place)

    def _If(self, node: ast.If | ast.While, place: _Place) -> None:
        if "TYPE_CHECKING" not in ast.unparse(node.test):
            self.visit(node.test, replace(place, guard=True))
            for statement in (*node.body, *node.orelse):
                self.visit(statement, place)

    _While = _If

    def _IfExp(self, node: ast.IfExp, place: _Place) -> None:
        self.visit(node.test, replace(place, guard=True))
        self.visit(node.body, place)
        self.visit(node.orelse, place)

    def _Subscript(self, node: ast.Subscript, place: _Place) -> None:
        self.visit(node.value, place)
        self.visit(node.slice, replace(place, index=True))

    def _Call(self, node: ast.Call, place: _Place) -> None:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if MESSAGES.search(name):
            return
        if name in OTHERS:
            end = self.at(node.func, True)
            self.add(end - len(name), end, OTHERS[name], "extreme", place, True)
        self.visit(node.func, place)
        inner = replace(place, index=place.index or name in SHAPES)
        for argument in node.args:
            self.visit(argument, inner)
        for keyword in node.keywords:
            if keyword.arg not in AXES:
                self.visit(keyword.value, inner)

    def _BinOp(self, node: ast.BinOp, place: _Place) -> None:
        inner = replace(place, arithmetic=place.arithmetic or isinstance(node.op, ARITHMETIC))
        pair = OPERATORS.get(type(node.op))
        where = self.between(node.left, node.right, pair[0]) if pair else None
        if pair and where and not _no_number(node.left) and not _no_number(node.right):
            self.add(*where, pair[1], "operator", place, True)
            if isinstance(node.op, ast.Add | ast.Sub):
                end = self.source.rfind(b"", where[0], self._closed(node.right))
                self.add(self._opened(node.left, where[0]), end, "", "term", place, True)
        self.visit(node.left, inner)
        self.visit(node.right, inner)

    def _opened(self, left: ast.AST, operator: int) -> int:
        """Where a term with its operator begins: after the left operand and the brackets that close it."""
        begin = self.at(left, True)
        gap = self.source[begin:operator]
        return begin + (gap.rfind(b")") + 1)

    def _closed(self, right: ast.AST) -> int:
        """Where a term ends: after the brackets that were opened before it."""
        end, opened = self.at(right, True), 0
        before = self.source[: self.at(right)].rstrip()
        while before.endswith(b"("):
            opened, before = opened + 1, before[:-1].rstrip()
        for _ in range(opened):
            end = self.source.index(b")", end) + 1
        return end

    def _UnaryOp(self, node: ast.UnaryOp, place: _Place) -> None:
        start, operand = self.at(node), self.at(node.operand)
        if isinstance(node.op, ast.USub) and not place.index:
            self.add(
                start, operand, "" if self.source[start:operand].strip() == b"-" else "(", "sign", place, True
            )
        elif isinstance(node.op, ast.Not):
            self.add(start, operand, "", "logic", place, False)
        self.visit(node.operand, place)

    def _Compare(self, node: ast.Compare, place: _Place) -> None:
        inner = replace(place, guard=True)
        for left, op, right in zip([node.left, *node.comparators], node.ops, node.comparators):
            token, other = COMPARISONS[type(op)]
            where = self.between(left, right, token)
            if where:
                self.add(*where, other, "comparison", place, False)
        self.children(node, inner)

    def _BoolOp(self, node: ast.BoolOp, place: _Place) -> None:
        token, other = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        for left, right in zip(node.values, node.values[1:]):
            where = self.between(left, right, token)
            if where:
                self.add(*where, other, "logic", place, False)
        self.children(node, replace(place, guard=True))

    def _Constant(self, node: ast.Constant, place: _Place) -> None:
        value = node.value
        if isinstance(value, bool) or not isinstance(value, int | float) or value == 0 or place.index:
            return
        if self.drawing or (value == 1 and isinstance(value, int) and not place.arithmetic):
            return
        tiny = abs(value) < 1e-6  # guards against rounding
        after = str(value + 1) if isinstance(value, int) and value < 4 else repr(value * 2)
        self.add(self.at(node), self.at(node, True), after, "number", place, place.arithmetic and not tiny)


def _no_number(node: ast.AST) -> bool:
    """Texts, lists and paths, as far as they can be told."""
    if isinstance(node, ast.JoinedStr | ast.List | ast.ListComp | ast.Tuple | ast.Dict | ast.Set):
        return True
    if isinstance(node, ast.Constant):
        return isinstance(node.value, str | bytes)
    if isinstance(node, ast.BinOp):
        return _no_number(node.left) or _no_number(node.right)
    if isinstance(node, ast.Call):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        return name in {"join", "str", "list", "tuple", "Path", "replace", "strip", "format", "repr", "ljust"}
    name = node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")
    return bool(re.search(r"(?i)path|folder|^root$|text|lines|words|^out$|html|label|message", name))


def sites(root: Path, file: str) -> list[Site]:
    """All changes of one file (path within root); some of them may not parse."""
    source = (root / file).read_bytes()
    reader = _Reader(file, source)
    for node in ast.parse(source).body:
        reader.visit(node, _Place(guard=True))
    return reader.sites


def shown(root: Path, site: Site) -> Site | None:
    """The change with its lines before and after; None where it does not parse or changes nothing."""
    source = (root / site.file).read_bytes()
    broken = site.applied(source)
    try:
        if ast.dump(ast.parse(broken)) == ast.dump(ast.parse(source)):
            return None
    except SyntaxError:
        return None
    first, last = source.rfind(b"\n", 0, site.start) + 1, source.find(b"\n", site.end)
    before, after = source[first:last], broken[first : len(broken) - (len(source) - last)]
    plain = [re.sub(r"\s+", " ", text.decode()).strip() for text in (before, after)]
    line = source.count(b"\n", 0, site.start) + 1
    return replace(site, line=line, before_line=plain[0], after_line=plain[1])
