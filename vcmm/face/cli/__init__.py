"""The command line: one verb per file, imported when it is called, so that `vcmm --help` starts at once."""

from __future__ import annotations

import contextlib
import gc
import os
import re
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, get_args

from vcmm import __version__
from vcmm.core.errors import UsageError, VcmmError, choose_from

if TYPE_CHECKING:
    from cyclopts import App, ArgumentCollection, Token

VERBS = {  # the lines of `vcmm --help`: here, so that help imports no verb
    "demo": "Virtually measure a ring gauge: value, U, decision, main contributor, a report (start here).",
    "new": "Write a commented scenario that you can edit.",
    "check": "Check a machine, scenario or set-up file: all problems at once, each with file, line and fix.",
    "field": "Compute the volumetric error map: tip errors, maxima, body diagonals.",
    "measure": "Measure the part once, virtually.",
    "uncertainty": "Evaluate the task-specific uncertainty: value, U, interval, decision, budget.",
    "evaluate": "Estimate true values from measured points or values: intervals, decisions, budgets.",
    "audit": "Count how often the intervals of this very task hold the true value, on sampled parts and machines.",
    "certificate": "Find the value of a certificate for a part: U by prior and by fact, coverage counted.",
    "routes": "Evaluate the same task by independent routes: virtual CMM, calibrated part, several positions; do they agree?",
    "rerun": "Run an evidence pack (--evidence) again and compare every number.",
    "place": "Find the best pose: gain, map, flatness, certificate, and the reason.",
    "diagnose": "Find the physics in a recording that the machine file lacks.",
    "calibrate": "Find the errors of a machine from recordings of instruments; plan the set-ups.",
    "track": "Follow a machine in time: its numbers today with their uncertainty, what changed and since when.",
    "test": "Predict the figures of an acceptance test (ISO 230, ISO 10360-2) with uncertainty, or evaluate a recorded one.",
    "compare": "Compare simulation and recording for any machine files, side by side.",
    "nc": "Read an NC program: moves, lengths, times, extents.",
    "cut": "Machine a part virtually: deviations of its features, U, main contributors, cycle time.",
    "loop": "From a measured part to the program of the next one: cut, compare, diagnose, compensate, prove by a cut.",
    "compensate": "Rewrite an NC program so that the machine with its known errors cuts the part right.",
    "convert": "Make vcmm files of a STEP, QIF, DMIS or DCC file, or of what PC-DMIS or CALYPSO exported.",
    "view": "Show a machine or a measuring task in a window, or as a picture.",
    "serve": "Serve a task as a live page on this machine: knobs, and U, decision and budget moving with them.",
    "merge": "Put the shards of a job together (--shard): the document that one computer would have given.",
    "list": "List scenarios, effects, features, strategies, characteristics, laws, aliases, units.",
    "explain": "Explain an effect: formula, sign, parameters, needed columns, source.",
    "doctor": "Check the installation.",
    "schema": "Print the JSON Schema of a file format.",
}
GROUPS = {  # of `vcmm --help`
    "Start": "demo new check list explain doctor schema",
    "Measure": "measure uncertainty evaluate audit certificate routes place serve view",
    "Machine": "field calibrate track test diagnose compare",
    "Cut": "nc cut compensate loop",
    "Data": "convert merge rerun",
}
SUBCOMMANDS = {"calibrate": "vcmm.face.cli.calibrate_jobs:app"}  # verbs that are several jobs
_NUMBER = re.compile(
    r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]{1,3})?"
)  # as docs/scale.md says, and finite
BUG, INTERRUPTED, WRONG, ENVIRONMENT = 70, 130, 2, 3


def build_app() -> App:
    """Return the cyclopts application; verbs are import paths, resolved on use."""
    from cyclopts import App, Group

    app = App(
        name="vcmm",
        help=ABOUT,
        version=f"vcmm {__version__}",
        version_flags=["--version"],
        suppress_keyboard_interrupt=False,  # `run` says what happened
        config=_check_numbers,
        help_epilogue=CODES,
    )
    groups = {v: group for group in map(Group.create_ordered, GROUPS) for v in GROUPS[group.name].split()}
    for verb in VERBS:
        where = SUBCOMMANDS.get(verb, f"vcmm.face.cli.{verb}:{verb}_command")
        app.command(where, name=verb, group=groups[verb], help=VERBS[verb])
    app.register_install_completion_command(name="--install-completion")
    return app


ABOUT = "Virtual CMM and virtual machining: from machine errors to task-specific measurement uncertainty. Start with: vcmm demo"
CODES = (
    "Exit codes: 0 done, 1 a requirement failed, 2 wrong input, 3 environment, 70 our bug, 130 interrupted."
)
WIDEST = 110  # of a line of help


def help_text() -> str:
    """Return the text of `vcmm --help`: the verbs in groups. Written here, since the parser takes ten times as long to load."""
    import shutil
    import textwrap

    width = min(shutil.get_terminal_size().columns, WIDEST)
    column = max(map(len, VERBS)) + 4
    lines = ["Usage: vcmm COMMAND [OPTIONS]", "", *textwrap.wrap(ABOUT, width)]
    for group, verbs in GROUPS.items():
        lines += ["", group]
        for verb in verbs.split():
            first, *rest = textwrap.wrap(VERBS[verb], max(width - column, 30))
            lines += [f"  {verb:<{column - 2}}{first}", *(" " * column + line for line in rest)]
    also = "vcmm COMMAND --help says what a command takes. --version, --install-completion (of your shell)."
    return "\n".join([*lines, "", *textwrap.wrap(also, width), *textwrap.wrap(CODES, width)])


def _check_numbers(app: App, commands: tuple[str, ...], arguments: ArgumentCollection) -> None:
    """Refuse a fraction where a whole number is expected: cyclopts would round `--trials 1.5` without a word. 2.0 and 1.5e6 are whole.

    Also refuse numbers that only Python accepts (1_000, 0x10, digits of other scripts), and empty values, as from a
    variable of the shell that is not set: `--out ""` is no place.
    """
    from cyclopts import CoercionError

    for argument in arguments:
        if any(token.value == "" and _is_typed(token) for token in argument.tokens):
            raise UsageError(f'{argument.name} "" is empty; give it a value or leave it out')
        kinds = {argument.hint, *get_args(argument.hint)}
        if not kinds & {int, float}:
            continue
        for token in argument.tokens:
            if not _NUMBER.fullmatch(token.value) and _python_takes(token.value):
                raise UsageError(
                    f"{argument.name} {token.value} is no number; write it out, for example 1000000 or 0.25"
                )
            if int not in kinds:
                continue
            with contextlib.suppress(ValueError):  # no number at all: cyclopts says so
                if "." in token.value and not float(token.value).is_integer():
                    raise CoercionError(token=token, argument=argument, target_type=int)


def _is_typed(token: Token) -> bool:
    """Return whether a value was to be typed: flags, --no-flag too, bring their own."""
    return not isinstance(token.implicit_value, bool) and not token.implicit_value


def _python_takes(text: str) -> bool:
    """Return whether Python converts a text to a number."""
    for convert in (float, lambda written: int(written, 0)):
        try:
            convert(text)
        except ValueError:
            continue
        return True
    return False


def main(arguments: list[str] | None = None) -> None:
    """Entry point of the `vcmm` command; exits with the documented codes."""
    # matrices here are small: threads of the matrix library cost more than they give, most of all on a busy machine
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    words = sys.argv[1:] if arguments is None else arguments
    if sys.stderr is None:  # closed by who started us, who wants no notes
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - as long as the process
    if sys.stdout is None:  # closed by who started us: an opened file would take its place
        if sys.stderr is not None:
            print("vcmm: stdout is closed; give it a place to go, for example > out.txt", file=sys.stderr)
        os._exit(ENVIRONMENT)
    import logging

    from vcmm.show.console.streams import in_plain_letters

    in_plain_letters()
    logging.getLogger("matplotlib").setLevel(
        logging.ERROR
    )  # where its folder cannot be written it uses another
    if arguments is not None:  # called by a program, which has a memory of its own
        sys.exit(run(words))
    # imports make 10^5 objects that all stay: to look for rings among them, then and at the end, is a seventh of a short command
    gc.set_threshold(100_000, 20, 10)
    code = run(words)
    gc.freeze()
    sys.exit(code)


def run(words: list[str]) -> int:
    """Run one command line and return its exit code; messages of errors go to stderr."""
    from vcmm.core.own_files import command_files

    try:
        with command_files():
            code = _dispatch(words)
        sys.stdout.flush()
        return code
    except VcmmError as error:
        from vcmm.show.console.complaints import list_problems

        problems = getattr(error, "problems", (str(error),))
        print(list_problems((*problems, *_where_to_get_it(problems))), file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt as error:
        notes = ("interrupted; nothing was half-written", *getattr(error, "__notes__", ()))
        print(f"vcmm: {'; '.join(notes)}", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader has closed the pipe (| head): Python must not try to flush it again
        _silence()
        return 0
    except OSError as error:
        where = f" ({error.filename})" if error.filename else ""
        print(
            f"vcmm: the computer refuses: {error.strerror}{where}; nothing was half-written", file=sys.stderr
        )
        _silence()
        return ENVIRONMENT
    except MemoryError as error:
        print(
            f"vcmm: this job needs more memory than there is ({str(error) or 'no size stated'}); reduce its points or rows",
            file=sys.stderr,
        )
        return ENVIRONMENT
    except Exception as error:
        import traceback

        traceback.print_exc()
        print(
            f"vcmm: this is our bug ({type(error).__name__}); please report it with the lines above",
            file=sys.stderr,
        )
        return BUG


def _where_to_get_it(problems: Sequence[str]) -> list[str]:
    """Return what to do where a file is missing that has the name of an example: a user may follow a page without its first line."""
    missing = (
        re.fullmatch(r"(?:\S*/)?(\w+)\.toml does not exist\.?", problems[0]) if len(problems) == 1 else None
    )
    if missing is None:
        return []
    from vcmm.files.own.library import scenarios

    return [f"vcmm new {missing[1]} writes an example of this name"] if missing[1] in scenarios() else []


def _silence() -> None:
    """Discard the buffer of stdout that cannot be written, so that Python does not try again at its end."""
    with contextlib.suppress(OSError, AttributeError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _dispatch(words: list[str]) -> int:
    if words and not words[0].startswith("-") and words[0] not in VERBS:
        raise UsageError(f'unknown command "{words[0]}".{choose_from(words[0], VERBS)}')
    if words in ([], ["--help"], ["-h"]):
        print(help_text())
        return 0
    if words == ["--version"]:
        print(f"vcmm {__version__}")
        return 0
    if len(words) in (2, 3) and words[-1] in ("--help", "-h"):
        from vcmm.face.cli.verb_help import verb_help

        if (page := verb_help(words[:-1], CODES)) is not None:
            print(page)
            return 0
    if words[0] in VERBS:
        from vcmm.face.cli.inputs import check_inputs

        check_inputs(words)
    from cyclopts import CycloptsError
    from rich.console import Console

    app = build_app()
    try:
        code = app(words, exit_on_error=False, print_error=False, result_action="return_value")
    except CycloptsError as error:
        from vcmm.show.console.complaints import list_problems

        text = _refusal(error, words)
        Console(stderr=True, highlight=False, soft_wrap=True).print(list_problems((text,)), markup=False)
        return WRONG
    return code if isinstance(code, int) else 0


def _refusal(error: Exception, words: list[str]) -> str:
    """Return the message for a line that the parser of the command line refuses, and what to do."""
    if unused := getattr(error, "unused_tokens", None):
        options = (
            f"; vcmm new {unused[0]} --from {words[1]} copies {words[1]} under that name"
            if words[0] == "new" and not words[1].startswith("-")
            else ""
        )
        return f'"{" ".join(unused)}" is one argument too many{options}; vcmm {words[0]} --help says what it takes'
    if str(error).endswith("into int."):
        return str(error).removesuffix(".") + "; write it out, for example 1000000"
    return str(error)
