"""A process that has package and tests in memory and puts one change after another to some tests, each in a fork of its own.

    python tools/mutant_worker.py      (in the tree whose files are broken; a line of JSON in, a line of JSON out)

Out first: ready. In: file, owner, tests, arguments, seconds. The file stands broken on disk; in the fork every function of that name gets the code
of the broken file, so that nothing has to be imported again. Out: code (of pytest, -24 when the time ran out, null where
the function cannot be exchanged: compiled loops and what a module computes when it is imported) and output.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import io
import json
import os
import pkgutil
import resource
import sys
import tempfile
from pathlib import Path
from types import CodeType, FunctionType

import pytest

ROOT = Path(__file__).resolve().parents[1]
Functions = dict[tuple[str, str], list[FunctionType]]


def main() -> None:
    lines, answers = os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    _load()
    known = functions_in_memory(ROOT / "vcmm")
    os.chdir(ROOT)
    gc.freeze()
    print(f"{len(known)} functions in memory", flush=True)
    print("ready", file=answers, flush=True)
    for line in lines:
        print(json.dumps(_answer(known, json.loads(line))), file=answers, flush=True)


def _load() -> None:
    """Every module of the package and every file of tests, imported once."""
    import vcmm

    for module in pkgutil.walk_packages(vcmm.__path__, "vcmm."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    with contextlib.redirect_stdout(io.StringIO()):
        pytest.main(["--collect-only", "-q", "-p", "no:cacheprovider", "tests"])


def _answer(known: Functions, order: dict[str, object]) -> dict[str, object]:
    file, name = ROOT / str(order["file"]), str(order["owner"]).split(".<locals>")[0]
    functions, code = known.get((str(file), name), []), code_of(file, name)
    if (
        not functions
        or code is None
        or any(len(f.__closure__ or ()) != len(code.co_freevars) for f in functions)
    ):
        return {"code": None, "output": ""}
    with tempfile.TemporaryFile("w+") as output:
        child = os.fork()
        if child == 0:
            _run(functions, code, order, output.fileno())
        _, status = os.waitpid(child, 0)
        output.seek(0)
        return {"code": os.waitstatus_to_exitcode(status), "output": output.read()[-4000:]}


def _run(functions: list[FunctionType], code: CodeType, order: dict[str, object], output: int) -> None:
    """The fork: exchanges the code, runs the tests and ends."""
    os.setpgid(0, 0)
    os.dup2(output, 1)
    os.dup2(output, 2)
    seconds = int(str(order["seconds"]))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    try:
        for function in functions:
            function.__code__ = code
        ended = int(pytest.main([*order["arguments"], *order["tests"]]))  # type: ignore[misc]
    except BaseException as problem:
        print(problem)
        ended = 70
    sys.stdout.flush()
    os._exit(ended)


def functions_in_memory(folder: Path) -> Functions:
    """Functions that were defined in files of a folder, by file and qualified name; none of compiled loops."""
    out: Functions = {}
    gc.unfreeze()  # the command line keeps its modules from being looked through
    for one in gc.get_objects():
        if isinstance(one, FunctionType):
            file = one.__code__.co_filename
            if file.startswith(str(folder)) and not file.endswith("_kernels.py"):
                out.setdefault((file, one.__code__.co_qualname), []).append(one)
    return out


def code_of(file: Path, name: str) -> CodeType | None:
    """The code of a function as the file has it now."""
    left = [compile(file.read_bytes(), str(file), "exec", dont_inherit=True)]
    while left:
        one = left.pop()
        if one.co_qualname == name:
            return one
        left += [constant for constant in one.co_consts if isinstance(constant, CodeType)]
    return None


if __name__ == "__main__":
    main()
