"""Running a Sinumerik program: sections, jumps, loops, repeated parts, subprograms, variables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from vcmm.core.errors import did_you_mean
from vcmm.program.expressions import Value, evaluate, number
from vcmm.program.faults import BlockFault, ProgramFault
from vcmm.program.moves import Source
from vcmm.program.reading import read_bytes
from vcmm.program.recorder import Recorder
from vcmm.program.repeating import LATEST, own_states
from vcmm.program.search import find_file, folders_of
from vcmm.program.sinumerik.blocks import Item, SinumerikBlock
from vcmm.program.sinumerik.heads import SinumerikFlow
from vcmm.program.sinumerik.memory import SinumerikMemory, Variable
from vcmm.program.sinumerik.sections import Section, sections_of
from vcmm.program.sinumerik.text import VariableValue
from vcmm.program.sinumerik.traces import cuts_of
from vcmm.program.trace import ExecutedBlock, Tracing

LONGEST = 2_000_000  # blocks executed again before a program counts as endless
IDLE = 500_000  # the same without any motion between
UNSURE = 100_000  # the same where loops hang on values that are not known
DEEPEST = 16  # nested subprograms, as on the control


class MissingTarget(BlockFault):
    """A jump to a label that the program has not."""


# executes the items of a block; True ends the program or subprogram
Work = Callable[["SinumerikRunner", SinumerikBlock], bool]


@dataclass(eq=False)
class SinumerikRunner:
    """Executes sections. It is the environment of expressions."""

    recorder: Recorder
    sections: dict[str, Section]
    work: Work
    short: Callable[[SinumerikBlock], bool] | None = None  # executes a plain block
    memory: SinumerikMemory = field(init=False)
    blocks_run: int = 0
    last_motion: tuple[int, int] = (0, 0)  # moves made, and blocks executed when the last was seen
    missing: set[str] = field(default_factory=set)  # subprograms that are nowhere
    nesting: int = 0  # repeated parts inside one another
    has_ended: bool = False
    current: Section | None = None  # the one whose blocks are being executed

    def __post_init__(self) -> None:
        self.memory = SinumerikMemory(self.recorder)

    @cached_property
    def block_count(self) -> int:
        """Number of blocks of the program in its present form."""
        return sum(len(s.blocks) for s in self.sections.values())

    # -- environment --
    @property
    def parameters(self) -> dict[int, float]:
        """R parameters."""
        return self.memory.parameters

    @property
    def scopes(self) -> list[dict[str, Variable]]:
        """Variables of the program and of the subprograms under way."""
        return self.memory.scopes

    def parameter(self, index: int) -> float:
        return self.memory.parameter(index)

    def variable(self, name: str, column: int) -> Any:
        return self.memory.variable(name, column)

    def element(self, name: str, index: tuple[Any, ...], column: int) -> Any:
        return self.memory.element(name, index, column)

    def function(self, name: str, arguments: list[Any], column: int, message: str) -> Any:
        return self.memory.function(name, arguments, column, message)

    def is_defined(self, name: str) -> bool:
        return self.memory.is_defined(name)

    def assign(self, item: Item) -> None:
        """Assign R5=..., R[..]=..., name=..., name[..]=..."""
        if item.value is None and not item.text:
            raise BlockFault(item.first, f"{item.name} takes a number")
        value = item.text if item.value is None else evaluate(item.value, self)
        index = tuple(i(self) if callable(i) else i for i in item.indices)
        if item.number is not None:
            self.parameters[item.number(self)] = 0.0 if value is None or isinstance(value, str) else value
        else:
            self.memory.store(item.name, index, value, item.first)

    # -- execution --
    def run(self, section: Section) -> None:
        self.part(section, 0, len(section.blocks) - 1)

    def part(self, section: Section, first: int, last: int) -> bool:
        """Run blocks first to last; True where the section has ended by M17, RET or the end of the program."""
        with own_states(self.recorder):
            return self._part(section, first, last)

    def _part(self, section: Section, first: int, last: int) -> bool:
        at, self.current = first, section
        while first <= at <= last:
            block = section.blocks[at]
            section.furthest = max(section.furthest, at)
            self.recorder.source = Source(block.line, block.first, block.last)
            self._count()
            before = at
            try:
                at, over = self._step(section, at, block)
                if at <= before and not over and self._endless(at):
                    at = before + 1
            except BlockFault as fault:
                if not self.passes_over(fault):
                    raise ProgramFault(
                        self.recorder.file, block.line, max(fault.column, 1), fault.text
                    ) from None
                at, over = at + 1, False
            except ProgramFault as fault:
                if fault.line != block.line or not self.passes_over(fault):
                    raise
                at, over = at + 1, False
            if over or self.has_ended:
                return True
        if at != last + 1:
            self.recorder.fault("a jump leads out of a repeated part of the program; jump inside it only")
        return False

    def _endless(self, at: int) -> bool:
        """Return whether a jump back to a block finds everything as an earlier one found it, and what it waits for is taken as reached."""
        r, memory = self.recorder, self.memory

        def values() -> object:
            return (dict(memory.parameters), [dict(v.elements) for v in memory.scopes[-1].values()])

        def whole() -> object:
            return (values(), self, getattr(self.work, "__self__", None), r.moves[-LATEST:])

        repeats = r.states.is_repetition((at, r.p, r.q, r.rotary), values, whole)
        return repeats and r.states.leave_wait(r, r.source.first, memory.sure)

    def passes_over(self, fault: BlockFault | ProgramFault) -> bool:
        """Return whether a block that cannot be executed hangs on values that only caller or machine know: told, and passed over."""
        if self.memory.sure or isinstance(fault, MissingTarget):
            return False
        self.recorder.assume(
            "blocks that hang on values which only the caller or the machine knows", "passed over"
        )
        return True

    def _count(self) -> None:
        self.blocks_run += 1
        if len(self.recorder.moves) != self.last_motion[0]:
            self.last_motion = len(self.recorder.moves), self.blocks_run
        if self.blocks_run > UNSURE + self.block_count and not self.memory.sure:
            self.recorder.assume(
                "the end of a loop, which hangs on values that only the caller or the machine knows",
                "the program is read no further",
            )
            self.has_ended = True
        if self.blocks_run > LONGEST + self.block_count:
            self.recorder.fault(
                f"more than {LONGEST} blocks have been executed again; the program seems to be endless, check its loops and jumps"
            )
        if self.blocks_run > IDLE + self.last_motion[1] + self.block_count:
            self.recorder.fault(
                f"{IDLE} blocks have been executed again without a motion; the program seems to be endless, check its loops and jumps"
            )

    def _step(self, section: Section, at: int, block: SinumerikBlock) -> tuple[int, bool]:
        if block.skipped and self.recorder.setup.block_delete:
            return at + 1, False
        if self.recorder.tracer is not None:
            self._note(self.recorder.tracer, block)
        if block.plain and self.short is not None and self.short(block):
            return at + 1, False
        if block.items and self.work(self, block):
            return at + 1, True
        if block.flow is None:
            return at + 1, False
        if block.flow.kind == "RET":
            return at + 1, True
        return self._flow(section, at, block.flow), False

    def _note(self, tracer: Tracing, block: SinumerikBlock) -> None:
        """Note the block in its executed form, for rewriting the program."""
        call = len(self.scopes) - 1
        cuts = cuts_of(self, block, tracer.lines[block.line - 1], call)
        tracer.step(ExecutedBlock(self.recorder.file, block.line, block.line, call, tuple(cuts)))

    def _flow(self, section: Section, at: int, flow: SinumerikFlow) -> int:
        kind, data, partner = flow.kind, flow.data, section.partner.get(at, at)
        if self.has_ended:
            return at + 1
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
        if kind == "LOOP" and at in section.endless:
            raise BlockFault(
                flow.column,
                "this loop is endless: nothing up to its ENDLOOP leads out of it; give it a jump (GOTOF) or an end (M30), or write FOR",
            )
        if kind in ("REPEAT_PART", "REPEATB"):
            self._repeat(section, at, flow)
        elif kind == "DEF":
            self.memory.define(data[0], data[1], self)
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
        if kind == "FOR":
            self.bound_repetitions(number(end, self) - value, head.column)
        inside, outside = (at + 1, partner + 1) if kind == "FOR" else (partner + 1, at + 1)
        return inside if value <= number(end, self) else outside

    def _jump(
        self, section: Section, at: int, column: int, kind: str, target: str, condition: Value | None
    ) -> int:
        if condition is not None and not number(condition, self):
            return at + 1
        if kind == "GOTOS":
            return 0
        if self.is_defined(target):  # the text of a variable
            target = str(self.variable(target, column)).upper()
        goal = self._seek(section, at, kind, target)
        if goal is None and kind == "GOTOC":
            return at + 1
        if goal is None:
            where = {"GOTOF": "further down", "GOTOB": "further up"}.get(kind, "in this program")
            names = [b.label for b in section.blocks if b.label]
            raise MissingTarget(
                column, f"there is no {target} {where} to jump to.{did_you_mean(target, names)}"
            )
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
        now = evaluate(value, self)
        for constant, kind, target in cases:
            same = constant is None or self.same(evaluate(constant, self), now)
            if same:
                return self._jump(section, at, flow.column, kind, target, None)
        return at + 1

    @staticmethod
    def bound_repetitions(times: float, column: int) -> int:
        """Return the repetitions; counts without a practical end are refused at once."""
        if times > LONGEST:
            raise BlockFault(
                column, f"{times:.6g} repetitions are more than {LONGEST} blocks; check their number"
            )
        return round(times)

    @staticmethod
    def same(a: Any, b: Any) -> bool:
        """Return whether two numbers or texts are equal."""
        return a == b if isinstance(a, str) or isinstance(b, str) else abs((a or 0.0) - (b or 0.0)) < 1e-9

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
        if first <= at <= last or self.nesting >= DEEPEST:
            raise BlockFault(
                flow.column,
                "the repeated part holds its own REPEAT; end it before, with ENDLABEL: or a second label",
            )
        self.nesting += 1
        for _ in range(self.bound_repetitions(number(times, self), flow.column)):
            if self.part(section, first, last):
                break
        self.nesting -= 1

    # -- subprograms --
    def folders(self) -> list[Path]:
        """Return the folders searched for subprograms."""
        return folders_of(Path(self.recorder.file), self.recorder.setup.subprograms)

    def find(self, name: str) -> Section | None:
        """Return a subprogram of this file, or of a file beside it; None: there is none."""
        if name not in self.sections:
            path = (
                None
                if name in self.missing
                else find_file(self.folders(), [f"{name}.spf", name, f"_N_{name}_SPF"])
            )
            if path is None:
                self.missing.add(name)
                return None
            first, *others = sections_of(read_bytes(path), str(path))
            for section in (first, *others):
                section.file = str(path)
                self.sections.setdefault(section.name or name, section)
            self.sections.setdefault(name, first)
        return self.sections[name]

    def call(self, item: Item, times: int = 1) -> None:
        """Call a subprogram, by name; VAR parameters are copied back."""
        section = self.sections[item.name]
        arguments = item.arguments or ()
        if len(arguments) > len(section.parameters):
            raise BlockFault(
                item.first, f"{item.name} takes {len(section.parameters)} arguments, got {len(arguments)}"
            )
        if len(self.scopes) > DEEPEST:
            raise BlockFault(
                item.first, f"subprograms are nested deeper than {DEEPEST}; does {item.name} call itself?"
            )
        r = self.recorder
        source, file = r.source, r.file
        r.file = section.file or file
        caller = self.current
        for _ in range(self.bound_repetitions(times, item.first)):
            self.scopes.append(self._scope(section, arguments))
            self.run(section)
            self._back(section, arguments, self.scopes.pop())
        r.source, r.file, self.current = source, file, caller

    def _scope(self, section: Section, arguments: Sequence[Value | None]) -> dict[str, Variable]:
        """Return the parameters of a call."""
        scope: dict[str, Variable] = {}
        for k, p in enumerate(section.parameters):
            value = arguments[k] if k < len(arguments) and arguments[k] is not None else p.default
            scope[p.name] = Variable(p.kind)
            scope[p.name].store((), None if value is None else evaluate(value, self))
        return scope

    def _back(self, section: Section, arguments: Sequence[Value | None], scope: dict[str, Variable]) -> None:
        for p, value in zip(section.parameters, arguments):
            if not p.by_reference or not isinstance(value, VariableValue):
                continue
            if value.parameter is not None:
                self.parameters[value.parameter(self)] = scope[p.name].value(())
            else:
                self.memory.store(value.name, value.indices(self), scope[p.name].value(()), value.column)

    def run_alone(self, section: Section) -> None:
        """Run a main program; of a subprogram on its own the arguments are zero, with a remark."""
        for p in section.parameters:
            self.scopes[0][p.name] = Variable(p.kind)
            self.scopes[0][p.name].store((), None if p.default is None else evaluate(p.default, self))
            if p.default is None:
                self.memory.guess(
                    f"the argument {p.name} of the subprogram {section.name}", "0",
                    f"the variable {p.name} is not defined; add DEF {p.kind} {p.name} at the start of the program.",
                )  # fmt: skip
        self.run(section)
