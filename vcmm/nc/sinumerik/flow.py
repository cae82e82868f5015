"""Running a Sinumerik program: sections, jumps, loops, repeated parts, subprograms, variables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from vcmm.core.errors import did_you_mean
from vcmm.nc.expressions import Value, number
from vcmm.nc.faults import BlockFault, ProgramFault
from vcmm.nc.moves import Source
from vcmm.nc.recorder import Recorder
from vcmm.nc.sinumerik.blocks import Item, SinumerikBlock, SinumerikFlow, parse_block
from vcmm.nc.sinumerik.text import lines_of
from vcmm.nc.sinumerik.traces import cuts_of
from vcmm.nc.trace import ExecutedBlock, Tracing

LONGEST = 500_000  # blocks executed again before a program counts as endless
DEEPEST = 16  # nested subprograms, as on the control
_OPENERS = {"IF": "ENDIF", "WHILE": "ENDWHILE", "FOR": "ENDFOR", "LOOP": "ENDLOOP", "REPEAT": "UNTIL"}


@dataclass(eq=False)
class Section:
    """A main program or subprogram. partner: IF -> ELSE or ENDIF, ELSE -> ENDIF, a loop's head <-> its end."""

    name: str
    blocks: list[SinumerikBlock] = field(default_factory=list)
    parameters: tuple[tuple[str, str, Value | None], ...] = ()
    partner: dict[int, int] = field(default_factory=dict)


@dataclass(slots=True)
class Variable:
    """A variable of the program; kind: REAL, INT or BOOL."""

    kind: str
    value: float = 0.0

    def store(self, value: float) -> None:
        """A value of that kind."""
        kinds: dict[str, Callable[[float], float]] = {"INT": round, "BOOL": bool}
        self.value = float(kinds.get(self.kind, float)(value))


Work = Callable[
    ["SinumerikRunner", SinumerikBlock], bool
]  # executes the items of a block; True ends the program or subprogram


@dataclass(eq=False)
class SinumerikRunner:
    """Executes sections. It is the environment of expressions."""

    recorder: Recorder
    sections: dict[str, Section]
    work: Work
    parameters: dict[int, float] = field(default_factory=dict)
    scopes: list[dict[str, Variable]] = field(default_factory=lambda: [{}])
    executed: int = 0
    nested: int = 0  # repeated parts inside one another
    ended: bool = False

    @cached_property
    def written(self) -> int:
        """Blocks of the program as it stands."""
        return sum(len(s.blocks) for s in self.sections.values())

    # -- environment --
    def parameter(self, index: int) -> float:
        if index not in self.parameters:
            self.recorder.remark(f"R{index} is used before it is set; 0 is taken")
        return self.parameters.get(index, 0.0)

    def variable(self, name: str, column: int) -> float:
        return self._find(name, column).value

    def _find(self, name: str, column: int) -> Variable:
        for scope in (self.scopes[-1], self.scopes[0]):
            if name in scope:
                return scope[name]
        known = [*self.scopes[-1], *self.scopes[0]]
        raise BlockFault(
            column,
            f"the variable {name} is not defined; add DEF REAL {name} at the start of the program.{did_you_mean(name, known)}",
        )

    def defined(self, name: str) -> bool:
        return name in self.scopes[-1] or name in self.scopes[0]

    def assign(self, item: Item) -> None:
        """R5=..., R[..]=..., name=..."""
        if item.value is None:
            raise BlockFault(item.first, f"{item.name} takes a number")
        value = number(item.value, self)
        if item.number is not None:
            self.parameters[item.number(self)] = value
        else:
            self._find(item.name, item.first).store(value)

    # -- execution --
    def run(self, section: Section) -> None:
        self.part(section, 0, len(section.blocks) - 1)

    def part(self, section: Section, first: int, last: int) -> bool:
        """Blocks first to last; True where the section has ended by M17, RET or the end of the program."""
        at = first
        while first <= at <= last:
            block = section.blocks[at]
            self.recorder.source = Source(block.line, block.first, block.last)
            self._count()
            try:
                at, over = self._step(section, at, block)
            except BlockFault as fault:
                raise ProgramFault(self.recorder.file, block.line, max(fault.column, 1), fault.text) from None
            if over or self.ended:
                return True
        if at != last + 1:
            self.recorder.fault("a jump leads out of a repeated part of the program; jump inside it only")
        return False

    def _count(self) -> None:
        self.executed += 1
        if self.executed > LONGEST + self.written:
            self.recorder.fault(
                f"more than {LONGEST} blocks have been executed again; the program seems to be endless, check its loops and jumps"
            )

    def _step(self, section: Section, at: int, block: SinumerikBlock) -> tuple[int, bool]:
        if block.skipped and self.recorder.setup.block_delete:
            return at + 1, False
        if self.recorder.tracer is not None:
            self._note(self.recorder.tracer, block)
        if block.items and self.work(self, block):
            return at + 1, True
        if block.flow is None:
            return at + 1, False
        if block.flow.kind == "RET":
            return at + 1, True
        return self._flow(section, at, block.flow), False

    def _note(self, tracer: Tracing, block: SinumerikBlock) -> None:
        """The block as it is executed now, for whoever writes the program out."""
        call = len(self.scopes) - 1
        cuts = cuts_of(self, block, tracer.lines[block.line - 1], call)
        tracer.step(ExecutedBlock(self.recorder.file, block.line, block.line, call, tuple(cuts)))

    def _flow(self, section: Section, at: int, flow: SinumerikFlow) -> int:
        kind, data, partner = flow.kind, flow.data, section.partner.get(at, at)
        if kind in ("IF", "WHILE"):
            return at + 1 if number(data[0], self) else partner + 1
        if kind in ("ELSE", "ENDWHILE", "ENDLOOP"):
            return partner + 1 if kind == "ELSE" else partner
        if kind == "UNTIL":
            return at + 1 if number(data[0], self) else partner + 1
        if kind in ("FOR", "ENDFOR"):
            return self._for(section, at, partner, kind)
        if kind == "JUMP":
            return self._jump(section, at, flow.column, *data)
        if kind == "CASE":
            return self._case(section, at, flow)
        if kind in ("REPEAT_PART", "REPEATB"):
            self._repeat(section, at, flow)
        elif kind == "DEF":
            self._define(*data)
        return at + 1  # ENDIF, LOOP, REPEAT, PROC

    def _for(self, section: Section, at: int, partner: int, kind: str) -> int:
        head = section.blocks[at if kind == "FOR" else partner].flow
        assert head is not None
        target, start, end = head.data
        item = Item("R", head.column, 0, number=target) if callable(target) else Item(target, head.column, 0)
        now = (
            (self.parameter(target(self)) if callable(target) else self.variable(target, head.column))
            if kind == "ENDFOR"
            else 0.0
        )
        value = number(start, self) if kind == "FOR" else now + 1.0
        self.assign(item._replace(value=value))
        inside, outside = (at + 1, partner + 1) if kind == "FOR" else (partner + 1, at + 1)
        return inside if value <= number(end, self) else outside

    def _jump(
        self, section: Section, at: int, column: int, kind: str, target: str, condition: Value | None
    ) -> int:
        if condition is not None and not number(condition, self):
            return at + 1
        if kind == "GOTOS":
            return 0
        goal = self._seek(section, at, kind, target)
        if goal is None and kind == "GOTOC":
            return at + 1
        if goal is None:
            where = {"GOTOF": "further down", "GOTOB": "further up"}.get(kind, "in this program")
            names = [b.label for b in section.blocks if b.label]
            raise BlockFault(column, f"there is no {target} {where} to jump to.{did_you_mean(target, names)}")
        return goal

    def _seek(self, section: Section, at: int, kind: str, target: str) -> int | None:
        forward, backward = range(at + 1, len(section.blocks)), range(at, -1, -1)
        ways = {"GOTOF": (forward,), "GOTOB": (backward,)}.get(kind, (forward, backward))
        hits = (
            k for way in ways for k in way if target in (section.blocks[k].label, section.blocks[k].number)
        )
        return next(hits, None)

    def _case(self, section: Section, at: int, flow: SinumerikFlow) -> int:
        value, cases = flow.data
        now = number(value, self)
        for constant, kind, target in cases:
            if constant is None or abs(number(constant, self) - now) < 1e-9:
                return self._jump(section, at, flow.column, kind, target, None)
        return at + 1

    def _repeat(self, section: Section, at: int, flow: SinumerikFlow) -> None:
        labels, times = flow.data
        names = (labels,) if isinstance(labels, str) else labels
        ends = [self._seek(section, at, "GOTO" if flow.kind == "REPEATB" else "GOTOB", n) for n in names]
        if len(names) == 2 and ends[0] is None:
            ends = [self._seek(section, at, "GOTO", n) for n in names]
        for name, end in zip(names, ends):
            if end is None:
                raise BlockFault(
                    flow.column,
                    f"there is no label {name} to repeat from; write {name}: before the first block",
                )
        first = ends[0] or 0
        last = (
            first if flow.kind == "REPEATB" else ends[1] if len(ends) == 2 and ends[1] is not None else at - 1
        )
        closing = next((k for k in range(first, last) if section.blocks[k].label == "ENDLABEL"), None)
        last = closing if closing is not None and len(names) == 1 else last
        if first <= at <= last or self.nested >= DEEPEST:
            raise BlockFault(
                flow.column,
                "the repeated part holds its own REPEAT; end it before, with ENDLABEL: or a second label",
            )
        self.nested += 1
        for _ in range(round(number(times, self))):
            if self.part(section, first, last):
                break
        self.nested -= 1

    def _define(self, kind: str, names: Any) -> None:
        for name, value in names:
            variable = Variable(kind)
            if value is not None:
                variable.store(number(value, self))
            self.scopes[-1][name] = variable

    def call(self, item: Item) -> None:
        """A subprogram of this file, by name."""
        section = self.sections[item.name]
        given = item.arguments or ()
        if len(given) > len(section.parameters):
            raise BlockFault(
                item.first, f"{item.name} takes {len(section.parameters)} arguments, got {len(given)}"
            )
        if len(self.scopes) > DEEPEST:
            raise BlockFault(
                item.first, f"subprograms are nested deeper than {DEEPEST}; does {item.name} call itself?"
            )
        scope: dict[str, Variable] = {}
        for k, (kind, name, default) in enumerate(section.parameters):
            value = given[k] if k < len(given) else default
            scope[name] = Variable(kind)
            scope[name].store(0.0 if value is None else number(value, self))
        source = self.recorder.source
        self.scopes.append(scope)
        self.run(section)
        self.scopes.pop()
        self.recorder.source = source


def sections_of(text: str, file: str) -> list[Section]:
    """The main program first. A new section begins at %_N_NAME_MPF (SPF) and at PROC."""
    sections = [Section("")]
    for line, tokens in enumerate(lines_of(text), 1):
        if not tokens:
            continue
        if tokens[0].text == "%":
            _header(sections, "".join(t.text for t in tokens[1:]))
            continue
        try:
            block = parse_block(tokens, line)
        except BlockFault as fault:
            raise ProgramFault(file, line, max(fault.column, 1), fault.text) from None
        if block.flow is not None and block.flow.kind == "PROC":
            _header(sections, block.flow.data[0])
            sections[-1].parameters = block.flow.data[1]
        sections[-1].blocks.append(block)
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
    """Pairs the heads and ends of loops and IF."""
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
                    f"; {stack[-1][0]} is due first"
                    if stack
                    else f"; write its beginning ({next(o for o, e in _OPENERS.items() if e == kind)}) before it"
                )
                raise fail(block, f"{kind} closes nothing{open_one}")
            head = stack.pop()[1]
            section.partner[head], section.partner[k] = k, head
    if stack:
        raise fail(section.blocks[stack[-1][1]], f"this is never closed; add {stack[-1][0]}")
