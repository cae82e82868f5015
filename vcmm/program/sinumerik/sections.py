"""The sections of a Sinumerik text: main program and subprograms, with the heads and ends of their loops paired."""

from __future__ import annotations

from dataclasses import dataclass, field

from vcmm.program.faults import BlockFault, ProgramFault
from vcmm.program.moves import Source
from vcmm.program.recorder import Recorder
from vcmm.program.sinumerik.blocks import SinumerikBlock, parse_line, plain_block
from vcmm.program.sinumerik.heads import Parameter
from vcmm.program.sinumerik.text import line_tokens
from vcmm.program.tokens import split_lines

_OPENERS = {"IF": "ENDIF", "WHILE": "ENDWHILE", "FOR": "ENDFOR", "LOOP": "ENDLOOP", "REPEAT": "UNTIL"}


@dataclass(eq=False)
class Section:
    """A main program or subprogram. partner: IF -> ELSE or ENDIF, ELSE -> ENDIF, a loop's head <-> its end.

    saves: modal functions are those of the caller again behind it. file: where it stands, "" in the main file. endless: LOOPs that
    nothing leads out of.
    """

    name: str
    blocks: list[SinumerikBlock] = field(default_factory=list)
    parameters: tuple[Parameter, ...] = ()
    partner: dict[int, int] = field(default_factory=dict)
    saves: bool = False
    file: str = ""
    endless: set[int] = field(default_factory=set)
    furthest: int = -1  # the last block that was executed

    def tell_rest(self, r: Recorder) -> None:
        """Note the first block behind an end of the program (outside of IF and loops) that no label makes a target, once that end was reached."""
        spans = [*self.partner.items()]
        over = True  # the block before ends the program
        for k in range(self.furthest + 1, len(self.blocks)):
            block = self.blocks[k]
            if over and block.label:
                over = False
            if over and not any(head < k - 1 < end for head, end in spans):
                r.source = Source(block.line, block.first, block.last)
                r.remark(
                    "the text after the end of the program is not read; a subprogram begins with PROC, or is in a file of its own"
                )
                return
            over = _ends(block)


def sections_of(text: str, file: str) -> list[Section]:
    """Return the main program first. A new section begins at %_N_NAME_MPF (SPF) and at PROC."""
    sections = [Section("")]
    for line, written in enumerate(split_lines(text), 1):
        plain = plain_block(written, line)
        if plain is not None:
            sections[-1].blocks.append(plain)
            continue
        tokens = line_tokens(written)
        if not tokens:
            continue
        if tokens[0].text == "%":
            _header(sections, "".join(t.text for t in tokens[1:]))
            continue
        try:
            blocks = parse_line(tokens, line)
        except BlockFault as fault:
            raise ProgramFault(file, line, max(fault.column, 1), fault.text) from None
        flow = blocks[0].flow
        if flow is not None and flow.kind == "PROC":
            _header(sections, flow.data[0])
            sections[-1].parameters, sections[-1].saves = flow.data[1], flow.data[2]
        sections[-1].blocks += blocks
    for section in sections:
        _match(section, file)
    return sections


def _header(sections: list[Section], name: str) -> None:
    name = name.upper().removeprefix("_N_")
    for ending in ("_MPF", "_SPF"):
        name = name.removesuffix(ending)
    if sections[-1].blocks:
        sections.append(Section(name))
    elif name:
        sections[-1].name = name


def _match(section: Section, file: str) -> None:
    """Pair the heads and ends of loops and IF."""
    stack: list[tuple[str, int]] = []

    def fail(block: SinumerikBlock, text: str) -> ProgramFault:
        column = block.flow.column if block.flow is not None else 1
        return ProgramFault(file, block.line, column, text)

    for k, block in enumerate(section.blocks):
        kind = block.flow.kind if block.flow is not None else ""
        if kind in _OPENERS:
            stack.append((_OPENERS[kind], k))
        elif kind == "ELSE":
            if not stack or stack[-1][0] != "ENDIF":
                raise fail(block, "ELSE has no IF; write IF condition in a block of its own before it")
            section.partner[stack[-1][1]] = k
            stack[-1] = ("ENDIF", k)
        elif kind in _OPENERS.values():
            if not stack or stack[-1][0] != kind:
                open_one = (
                    f"; expected {stack[-1][0]} first"
                    if stack
                    else f"; write its beginning ({next(o for o, e in _OPENERS.items() if e == kind)}) before it"
                )
                raise fail(block, f"{kind} closes nothing{open_one}")
            head = stack.pop()[1]
            section.partner[head], section.partner[k] = k, head
            if kind == "ENDLOOP" and not any(map(_leads_on, section.blocks[head + 1 : k])):
                section.endless.add(head)
    if stack:
        raise fail(section.blocks[stack[-1][1]], f"this is never closed; add {stack[-1][0]}")


def _ends(block: SinumerikBlock) -> bool:
    """Return whether a block is the end of a program or subprogram."""
    if block.plain:
        return False
    ends = ("2", "02", "17", "30")
    return (block.flow is not None and block.flow.kind == "RET") or any(
        i.name == "M" and i.text in ends for i in block.items
    )


def _leads_on(block: SinumerikBlock) -> bool:
    """Return whether a block may end a loop: a jump, an M function, a subprogram or whatever else is called."""
    if block.flow is not None and block.flow.kind in ("JUMP", "CASE", "RET"):
        return True
    return any(item.name in ("M", "L", "P") or item.value is None for item in block.items)
