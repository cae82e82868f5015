"""Write the set-up file that a program needs, with blanks for the data that the program does not hold and the machine must know."""

from __future__ import annotations

from collections.abc import Sequence

from vcmm.program.levels import toml_text
from vcmm.program.moves import Program

BLANK = '"?"'  # refused by the reader of set-up files, with its line, until somebody fills it in


def blank_setup(program: Program, file: str) -> str:
    """Return TOML of setup/1. Keys with "?" are needed; those behind # are optional."""
    head = [
        'vcmm = "setup/1"', f"# for {file}: write a number with its unit for every {BLANK}",
        '# machine = "machine.toml"', f'dialect = "{program.dialect}"',
    ]  # fmt: skip
    head += [
        f"{a.blank.key} = {a.blank.example}   # line {a.line}: {a.what}"
        for a in program.assumed
        if a.blank and not a.blank.table
    ]
    stock = ["# [stock]", '# box = ["100 mm", "60 mm", "30 mm"]']
    return "\n".join([*head, "", *_offsets(program), *_tools(program), *stock]) + "\n"


def _offsets(program: Program) -> list[str]:
    used = dict.fromkeys(m.offset for m in program.moves)
    rows = [f'"{name}" = ["0 mm", "0 mm", "0 mm"]' for name in used or ["G54"]]
    return ["[offsets]                # machine position of the work zero", *rows, ""]


def _tools(program: Program) -> list[str]:
    """Return every tool that is called: the missing keys as blanks, length and diameter else as remarks."""
    wanted_values: dict[int, list[tuple[str, str, int]]] = {}
    names: dict[int, str] = {}
    for a in program.assumed:
        if a.blank is not None and a.blank.table.startswith("tools."):
            name = a.blank.table.removeprefix("tools.")
            if name.isdigit():
                wanted_values.setdefault(int(name), []).append((a.blank.key, a.blank.example, a.line))
                if a.blank.name:
                    names[int(name)] = a.blank.name
    out: list[str] = []
    numbers: list[int] = sorted({*program.tools, *wanted_values} - {0})
    for number in numbers:
        out.append(f"[tools.{number}]                # {program.tools.get(number, 'named by a register')}")
        if number in names:
            out.append(f"name = {toml_text(names[number])}")
        out += [
            f"{key} = {BLANK}   # line {line}; for example {example}"
            for key, example, line in wanted_values.get(number, [])
        ]
        keys = {key for key, _, _ in wanted_values.get(number, [])}
        out += [f"# {key} = {example}" for key, example in _OPTIONAL if key not in keys]
        out.append("")
    return out


_OPTIONAL: Sequence[tuple[str, str]] = (("length", '"80 mm"'), ("diameter", '"10 mm"'))
