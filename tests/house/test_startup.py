"""`import vcmm` and `vcmm --help` start at once: no numerical or drawing library is loaded."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

HEAVY = ("numpy", "scipy", "numba", "trimesh", "pyvista", "vtk", "pydantic", "matplotlib")
REPORT = f"import json, sys; print(json.dumps([m for m in {HEAVY!r} if m in sys.modules]), file=sys.stderr)"


def run(code: str) -> tuple[subprocess.CompletedProcess[str], list[str]]:
    """The finished process and the heavy libraries it had loaded."""
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\n{REPORT}"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done, json.loads(done.stderr.splitlines()[-1])


def test_import_loads_nothing_heavy():
    done, loaded = run("import vcmm\nprint(vcmm.__version__)\nprint(*dir(vcmm))")
    assert loaded == []
    assert "uncertainty" in done.stdout


def test_the_probe_itself_sees_numpy():
    assert run("import numpy")[1] == ["numpy"]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--help"], "uncertainty"),
        (["--version"], "vcmm "),
        (["uncertainty", "--help"], "--engine"),
        (["field", "--help"], "--exact"),
    ],
)
def test_help_loads_nothing_heavy(words: list[str], text: str):
    done, loaded = run(f"from vcmm.face.cli import run\nassert run({words!r}) == 0")
    assert loaded == []
    assert text in done.stdout


def test_help_of_every_verb_is_read_from_its_source():
    """No verb is imported for its help, so verbs are free to import what they need at their heads."""
    code = (
        "from vcmm.face.cli import VERBS, run\nimport sys\n"
        "assert all(run([verb, '--help']) == 0 for verb in VERBS)\n"
        "assert not [v for v in VERBS if f'vcmm.face.cli.{v}' in sys.modules]"
    )
    assert run(code)[1] == []


@pytest.mark.thorough
def test_public_names_are_found_on_first_use():
    _, loaded = run(
        "import vcmm\nmissing = [n for n in vcmm.__all__ if not hasattr(vcmm, n)]\nassert not missing, missing"
    )
    assert "numpy" in loaded  # the names are real objects, not promises


@pytest.mark.thorough
def test_public_names_stay_what_they_are_when_modules_are_imported():
    """Importing vcmm.x sets the attribute x of the package, so no public name may also be a module that is in use."""
    run(
        "import importlib, pkgutil, vcmm\n"
        "for found in pkgutil.iter_modules(vcmm.__path__):\n"
        "    if not found.name.startswith('_'): importlib.import_module(f'vcmm.{found.name}')\n"
        "hidden = [n for n in vcmm.__all__ if getattr(getattr(vcmm, n), '__name__', '') == f'vcmm.{n}']\n"
        "assert not hidden, f'modules hide these public names: {hidden}'"
    )


def test_a_mistyped_name_is_answered_with_the_closest():
    run(
        "import vcmm\ntry:\n    vcmm.mesure\nexcept AttributeError as error:\n    assert 'Did you mean \"measure\"?' in str(error)"
    )


def test_the_command_ends_with_its_exit_code():
    done = subprocess.run(
        [sys.executable, "-c", "from vcmm.face.cli import main; main(['--help'])"],
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0
    done = subprocess.run(
        [sys.executable, "-c", "from vcmm.face.cli import main; main(['mesure'])"],
        capture_output=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == b""


def seconds_of(*words: str, times: int = 5) -> float:
    """Seconds of processor that a command takes, the least of some: what others do on the machine adds to it."""
    import resource

    least = float("inf")
    for _ in range(times):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *words], capture_output=True, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        least = min(least, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return least


@pytest.mark.parametrize(
    "code",
    [
        "import vcmm",
        "from vcmm.face.cli import main; main(['--help'])",
        "from vcmm.face.cli import main; main(['uncertainty', '--help'])",
        "from vcmm.face.cli import main; main(['calibrate', 'fit', '--help'])",
    ],
)
def test_it_starts_in_less_than_ten_starts_of_python(code: str):
    assert seconds_of("-c", code) < 10 * seconds_of("-c", "pass")


@pytest.mark.parametrize("verb", ["measure", "uncertainty"])
def test_a_job_of_measuring_loads_no_room_of_cutting_or_learning(verb: str, tmp_path):
    """A part that is measured is neither cut nor learnt from."""
    made = subprocess.run(
        [sys.executable, "-m", "vcmm", "new", "ring_gauge", "--out", str(tmp_path)],
        capture_output=True,
        check=False,
    )
    assert made.returncode == 0
    code = (
        "from vcmm.face.cli import run\nimport sys\n"
        f"assert run(['{verb}', {str(tmp_path / 'ring_gauge.toml')!r}, '--seed', '3', '--json']) == 0\n"
        "others = [m for m in sys.modules if m.startswith(('vcmm.learn.', 'vcmm.compensation.', 'vcmm.shop'))]\n"
        "assert not others, others"
    )
    run(code)


@pytest.mark.parametrize("verb", ["nc", "cut", "compensate"])
def test_a_job_of_programs_loads_no_room_of_learning(verb: str):
    """What a control does with a program is no diagnosis: tables that say both import the words of a diagnosis where they are shown."""
    code = (
        f"import sys, vcmm.face.cli.{verb}\n"
        "import vcmm.show.tables.answers_machine\n"
        "others = [m for m in sys.modules if m.startswith('vcmm.learn.')]\n"
        "assert not others, others"
    )
    run(code)
