"""Print `vcmm VERB --help`, read from the source of the verb: loading the parser takes as long as ten starts of Python.

tests/face/cli/test_verb_help.py holds the words, choices and defaults of every verb to what the parser takes.
"""

from __future__ import annotations

import ast
import shutil
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

WIDEST = 110  # of a line
COLUMN = 26  # where descriptions begin
TYPE_WORDS = {"int": "INT", "float": "NUMBER", "str": "TEXT", "Path": "PATH"}
READS = ("InputFile", "InputPath", "InputName")  # of vcmm.face.cli.options
HERE = Path(__file__).parent


@dataclass(frozen=True)
class HelpOption:
    """One parameter of a verb. default: as it is typed, empty where there is none; is_word: by its place, without a name.

    takes_all: every word up to the next option. reads: the name of its type where it is an input (`READS`), else empty.
    """

    parameter: str  # of the function
    name: str
    kind: str
    choices: tuple[str, ...]
    default: str
    is_word: bool
    is_many: bool
    is_required: bool
    off: str  # --no-...
    takes_all: bool = False
    reads: str = ""


def verb_help(words: list[str], codes: str) -> str | None:
    """Return the page of `VERB` or `VERB JOB`; None where the source is not available or has no such job."""
    verb, *job = words
    jobs = HERE / f"{verb}_jobs.py"
    try:
        if job:
            tree = ast.parse(jobs.read_text(encoding="utf-8"))
            return _page(words, tree, f"{job[0]}_command", [], codes)
        tree = ast.parse((HERE / f"{verb}.py").read_text(encoding="utf-8"))
        return _page(words, tree, f"{verb}_command", list(_jobs(jobs)), codes)
    except (OSError, StopIteration):
        return None


def _jobs(path: Path) -> Iterator[tuple[str, str]]:
    """Return names and first lines of the jobs that a verb consists of."""
    if not path.is_file():
        return
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name.endswith("_command"):
            yield node.name.removesuffix("_command"), (ast.get_docstring(node) or "").splitlines()[0]


def options_of(tree: ast.Module, name: str) -> list[HelpOption]:
    """Return the parameters of a verb. StopIteration: there is no function of this name."""
    command = _function(tree, name)
    aliases = _aliases(tree) | _aliases(ast.parse((HERE / "options.py").read_text(encoding="utf-8")))
    arguments = command.args
    first = [*arguments.posonlyargs, *arguments.args]
    defaults = [None] * (len(first) - len(arguments.defaults)) + list(arguments.defaults)
    out = [_option(a, d, aliases, is_word=True) for a, d in zip(first, defaults, strict=True)]
    if arguments.vararg is not None:
        out.append(_option(arguments.vararg, ast.Constant(None), aliases, is_word=True, is_many=True))
    return out + [
        _option(a, d, aliases) for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
    ]


def _function(tree: ast.Module, name: str) -> ast.FunctionDef:
    return next(n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == name)


def _aliases(tree: ast.Module) -> dict[str, ast.expr]:
    """Return the types with names of their own: Seed = Annotated[int, ...]."""
    return {
        n.targets[0].id: n.value
        for n in tree.body
        if isinstance(n, ast.Assign) and isinstance(n.targets[0], ast.Name)
    }


def _option(
    argument: ast.arg,
    default: ast.expr | None,
    aliases: dict[str, ast.expr],
    is_word: bool = False,
    is_many: bool = False,
) -> HelpOption:
    nodes = list(_parts(argument.annotation, aliases))
    given = {k.arg: k.value for n in nodes if isinstance(n, ast.Call) for k in n.keywords}
    name = _text(given["name"]) if "name" in given else "--" + argument.arg.replace("_", "-")
    names = [n.id for n in nodes if isinstance(n, ast.Name)]
    is_flag = "bool" in names
    is_on = is_flag and isinstance(default, ast.Constant) and default.value is True
    return HelpOption(
        parameter=argument.arg,
        name=argument.arg.upper().replace("_", "-") if is_word else name,
        kind="" if is_flag else next((TYPE_WORDS[n] for n in names if n in TYPE_WORDS), "TEXT"),
        choices=tuple(dict.fromkeys(c for n in nodes for c in _choices(n))),
        default="" if is_flag or default is None else _text(default),
        is_word=is_word,
        is_many=is_many or "list" in names,
        is_required=default is None,
        off=f"--no-{name[2:]}" if is_on and "negative" not in given else "",
        takes_all="consume_multiple" in given,
        reads=next((n for n in names if n in READS), ""),
    )


def _parts(node: ast.expr | None, aliases: dict[str, ast.expr]) -> Iterator[ast.AST]:
    """Yield all of a type, with the targets of its names."""
    for part in ast.walk(node) if node is not None else ():
        yield part
        if isinstance(part, ast.Name) and part.id in aliases:
            yield from _parts(aliases[part.id], aliases)


def _choices(node: ast.AST) -> list[str]:
    if not (
        isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id == "Literal"
    ):
        return []
    return [str(c.value) for c in ast.walk(node.slice) if isinstance(c, ast.Constant)]


def _text(node: ast.expr) -> str:
    """Return a default as one types it; empty for None, "" and values that are no constants."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Path":
        return _text(node.args[0]) if node.args else "."
    if not isinstance(node, ast.Constant) or node.value is None:
        return ""
    return str(node.value)


def _describe(text: str) -> tuple[str, dict[str, str]]:
    """Return the text before the parameters, and the words of each (numpydoc)."""
    before, _, after = text.partition("Parameters\n----------\n")
    words: dict[str, str] = {}
    name = ""
    for line in after.splitlines():
        if line and not line[0].isspace():
            name = line.strip()
        elif name and line.strip():
            words[name] = f"{words.get(name, '')} {line.strip()}".strip()
    return before.strip(), words


def _page(words: list[str], tree: ast.Module, name: str, jobs: list[tuple[str, str]], codes: str) -> str:
    width = min(shutil.get_terminal_size().columns, WIDEST)
    about, of_options = _describe(ast.get_docstring(_function(tree, name)) or "")
    options = options_of(tree, name)
    typed = [_type_of(o) for o in options if o.is_word]
    usage = " ".join(["Usage: vcmm", *words, *(["[JOB]"] if jobs else []), *typed, "[OPTIONS]"])
    lines = [usage]
    for paragraph in about.split("\n\n"):
        lines += ["", *textwrap.wrap(" ".join(paragraph.split()).replace("`", ""), width)]
    if jobs:
        lines += ["", "Jobs (each with the options it has: --help)", *_rows(jobs, width)]
    for title, some in (("Arguments", [o for o in options if o.is_word]), ("Options", [o for o in options if not o.is_word])):  # fmt: skip
        if some:
            rows = [(_label_of(o), _words(o, of_options)) for o in some]
            lines += ["", title, *_rows(rows, width)]
    return "\n".join([*lines, "", *textwrap.wrap(codes, width)])


def _type_of(o: HelpOption) -> str:
    name = f"{o.name}..." if o.is_many else o.name
    return name if o.is_required else f"[{name}]"


def _label_of(o: HelpOption) -> str:
    if o.is_word:
        return o.name
    many = " (repeated)" if o.is_many else ""
    return " ".join(filter(None, (o.name, o.off, "CHOICE" if o.choices else o.kind))) + many


def _words(o: HelpOption, words: dict[str, str]) -> str:
    """Return description, choices and default."""
    text = words.get(o.parameter, "").replace("`", "")
    choices = f" [choices: {', '.join(o.choices)}]" if o.choices else ""
    default = f" [default: {o.default}]" if o.default else ""
    return f"{text}{choices}{default}".strip()


def _rows(rows: list[tuple[str, str]], width: int) -> list[str]:
    """Return two columns; a long name has a line of its own."""
    out = []
    for name, text in rows:
        lines = textwrap.wrap(text, max(width - COLUMN, 30)) or [""]
        if len(name) > COLUMN - 4:
            out.append(f"  {name}")
        else:
            out.append(f"  {name:<{COLUMN - 2}}{lines.pop(0)}".rstrip())
        out += [" " * COLUMN + line for line in lines]
    return out
