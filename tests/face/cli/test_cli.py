"""The command line: documents, exit codes, what goes to which stream."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from tests.conftest import data_file
from tests.plate import PLATE, edited
from vcmm.face.cli import GROUPS, VERBS, run
from vcmm.physics import ALL

HEAD = {"schema", "version", "seed", "inputs", "warnings", "warning_texts"}
LISTS = ("scenarios", "effects", "features", "strategies", "characteristics", "laws", "aliases", "units")


def document(capsys, *words: str) -> dict:
    """Run with --json: exactly one document on stdout, exit code 0."""
    code = run([*words, "--json"])
    out, err = capsys.readouterr()
    assert code == 0, err
    found = json.loads(out)  # one document and nothing else
    assert set(found) >= HEAD
    assert isinstance(found["warnings"], list)
    return found


def machine_file(folder, more: str = "") -> str:
    body = PLATE[PLATE.index("[machine]\n") + 10 : PLATE.index("[part]\n")].replace("[machine.", "[")
    path = folder / "m.toml"
    path.write_text(f'vcmm = "machine/1"\n{body}{more}')
    return str(path)


def test_field_on_a_grid(tmp_path, capsys):
    path = machine_file(tmp_path)
    found = document(capsys, "field", path, "--nodes", "3")
    assert set(found) == HEAD | {"engine", "points", "tip_error_mm", "summary", "not_mapped"} | {
        "U_mm",
        "u_mm",
        "within_mm",
        "not_in_U",
    }
    assert found["schema"] == "vcmm.field/1"
    assert found["engine"] == "first-order"
    assert "expansion" in " ".join(found["not_mapped"])  # 20 degC on a bare grid
    assert found["points"] == len(found["tip_error_mm"]) == 27
    assert set(found["summary"]) == {"max_mm", "mean_mm", "max_xyz_mm", "body_diagonals_mm"}
    # squareness C0Y = 3 urad over 500 mm: 1.5 um in X at most; nothing in Y and Z (compensated scales at 20 degC)
    assert found["summary"]["max_mm"] == pytest.approx(1.5e-3)
    assert found["summary"]["max_xyz_mm"] == pytest.approx([1.5e-3, 0.0, 0.0], abs=1e-12)
    # body diagonal (0 0 -400)-(600 500 0): -3e-6 x 500 x 600 / sqrt(600^2 + 500^2 + 400^2) = -1.02564 um
    diagonals = found["summary"]["body_diagonals_mm"]
    assert len(diagonals) == 4
    assert set(diagonals[0]) == {"from", "to", "length_error"}
    assert diagonals[0]["from"] == [0.0, 0.0, -400.0]
    assert diagonals[0]["to"] == [600.0, 500.0, 0.0]
    assert diagonals[0]["length_error"] == pytest.approx(-1.02564e-3, abs=1e-8)
    assert [f["file"] for f in found["inputs"]] == [path]
    assert len(found["inputs"][0]["sha256"]) == 64


@pytest.mark.parametrize("name", ["bridge_cmm", "trunnion_5axis", "bridge_cmm_large_errors"])
def test_field_on_the_reference_machines(capsys, name):
    root = data_file("reference/kinematics.json")
    case = next(c for c in json.loads(root.read_text())["cases"] if name in c["machine"].split("/"))
    words = ["field", str(root.parent / case["machine"]), "--at", str(root.parent / case["positions"])]
    exact = document(capsys, *words, "--exact")
    assert exact["engine"] == "exact"
    assert np.abs(np.array(exact["tip_error_mm"]) - case["tip_error_mm"]).max() < 1e-9
    assert len(exact["inputs"]) == 3  # machine, its error table, positions
    if case["first_order_applies"]:
        linear = document(capsys, *words)
        assert np.abs(np.array(linear["tip_error_mm"]) - case["tip_error_mm"]).max() < 5e-6


def test_field_says_which_line_is_outside(tmp_path, capsys):
    path = machine_file(tmp_path)
    at = tmp_path / "at.csv"
    at.write_text("# two points\nX_mm,Y_mm,Z_mm\n\n1,2,-3\n601,2,-3\n")
    assert run(["field", path, "--at", str(at), "--json"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert f"vcmm: {at}:5: axis X = 601 mm is outside its travel 0 to 600 mm" in err


@pytest.mark.thorough
def test_field_writes_a_folder(tmp_path, capsys):
    folder = tmp_path / "out" / "field"
    assert run(["field", machine_file(tmp_path), "--nodes", "2", "--out", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert "wrote" in err
    assert "wrote" not in out
    assert "largest tip error" in out
    assert sorted(p.name for p in folder.iterdir()) == ["field.csv", "field.html", "field.json"]
    assert json.loads((folder / "field.json").read_text())["points"] == 8
    assert (
        (folder / "field.csv")
        .read_text()
        .startswith("Y_mm,X_mm,Z_mm,error_x_um,error_y_um,error_z_um,U_x_um,U_y_um,U_z_um\n")
    )


def test_check_of_both_kinds(tmp_path, capsys):
    machine = document(capsys, "check", machine_file(tmp_path))
    assert set(machine) == HEAD | {"file", "kind", "understood", "spoilt"}
    assert machine["kind"] == "machine"
    assert machine["understood"]["axis X"] == "travel 0 to 600 mm"
    scenario = document(capsys, "check", str(edited(tmp_path)))
    assert scenario["kind"] == "scenario"
    assert scenario["understood"]["plan"] == "31 touches in 3 steps, all within the travels"
    assert scenario["understood"]["input squareness[C0Y].angle"] == "normal, redraw machine"


def test_measure(tmp_path, capsys):
    found = document(capsys, "measure", str(edited(tmp_path)))
    assert set(found) == HEAD | {"characteristics", "points"}
    assert found["seed"] is None
    assert set(found["characteristics"][0]) == {"name", "type", "nominal_mm", "value_mm"}
    assert [c["name"] for c in found["characteristics"]] == [
        "bore diameter",
        "bore square to top",
        "bore to front",
    ]
    assert set(found["points"][0]) == {"feature", "nominal_mm", "measured_mm", "error_mm"}
    assert len(found["points"]) == 31
    # the only known error that shows in the diameter: the part is 1.2 K warm: 30 x 11.5e-6 x 1.2 = 0.414 um
    assert found["characteristics"][0]["value_mm"] == pytest.approx(30.000414, abs=2e-6)


def test_measure_draws_with_a_seed(tmp_path, capsys):
    path = str(edited(tmp_path))
    first, again, other = (document(capsys, "measure", path, "--seed", s) for s in ("1", "1", "2"))
    assert first == again
    assert first["seed"] == 1
    assert first["characteristics"] != other["characteristics"]


def test_measure_writes_angles_in_rad(tmp_path, capsys):
    angle = '[[part.characteristics]]\nname = "corner"\ntype = "angle"\nbetween = ["top", "front"]\n[pose]\n'
    found = document(capsys, "measure", str(edited(tmp_path, ("[pose]\n", angle))))
    assert set(found["characteristics"][3]) == {"name", "type", "nominal_rad", "value_rad"}
    assert found["characteristics"][3]["nominal_rad"] == pytest.approx(np.pi / 2)


def test_measure_writes_a_folder(tmp_path, capsys):
    assert run(["measure", str(edited(tmp_path)), "--out", str(tmp_path / "m")]) == 0
    assert sorted(p.name for p in (tmp_path / "m").iterdir()) == ["measure.json", "points.csv"]
    rows = (tmp_path / "m" / "points.csv").read_text().splitlines()
    assert (
        rows[0]
        == "feature,measured_x_mm,measured_y_mm,measured_z_mm,nominal_x_mm,nominal_y_mm,nominal_z_mm,nx,ny,nz,error_um"
    )
    assert len(rows) == 32


@pytest.mark.parametrize("what", LISTS)
def test_list(capsys, what):
    found = document(capsys, "list", what)
    assert set(found) == HEAD | {"what", "items"}
    assert found["what"] == what
    assert found["items"]
    assert all(all(isinstance(v, str) for v in item.values()) for item in found["items"])
    assert run(["list", what]) == 0
    assert len(capsys.readouterr().out.splitlines()) >= len(found["items"])


def test_list_says_what_there_is(capsys):
    names = {item["effect"] for item in document(capsys, "list", "effects")["items"]}
    assert names == {e.name for e in ALL}
    strategies = document(capsys, "list", "strategies")["items"]
    assert ("cylinder", "levels") in {(i["feature"], i["strategy"]) for i in strategies}


@pytest.mark.parametrize("effect", [e.name for e in ALL])
def test_explain(capsys, effect):
    found = document(capsys, "explain", effect)
    assert found["text"]
    assert set(found) == HEAD | {
        "effect",
        "text",
        "sign",
        "per",
        "needs",
        "cites",
        "parameters",
        "places",
        "keys",
    }
    assert found["effect"] == effect
    assert found["sign"] in ("tip error: actual - nominal", "reading: indicated - true")
    assert found["parameters"]
    assert run(["explain", effect]) == 0
    out = capsys.readouterr().out
    assert "keys of the [[effects]] table" in out
    assert found["cites"] in out


def test_explain_knows_errors_by_any_name(capsys):
    """xty, TXY and EYX are one error: X is not straight, and departs towards Y."""
    for word in ("EYX", "xty"):
        found = document(capsys, "explain", word)
        assert (found["error"], found["text"], found["unit"]) == ("EYX", "straightness of X in Y", "um")
        assert found["sign"] == "+ is a motion towards +Y"
    square = document(capsys, "explain", "C0Y")
    assert (square["text"], square["unit"], square["effect"]) == (
        "squareness of Y to X",
        "urad",
        "squareness",
    )
    assert square["sign"] == "+ is a right-hand rotation about Z"
    assert document(capsys, "explain", "A0C")["effect"] == "rotary_location"
    assert run(["explain", "EXX"]) == 0
    out = capsys.readouterr().out
    assert "positioning of X" in out
    assert 'component = "EXX"' in out


def test_explain_knows_figures_and_their_former_symbols(capsys):
    for word in ("E0_MPE", "MPE_E"):
        (one,) = document(capsys, "explain", word)["meanings"]
        assert (one["symbol"], one["source"]) == ("E0_MPE", "ISO 10360-2:2009")
    meanings = document(capsys, "explain", "E")["meanings"]  # of an axis, and formerly of a measured length
    assert [m["source"] for m in meanings] == ["ISO 10360-2:2009", "ISO 230-2:2014"]
    assert run(["explain", "MPE_E"]) == 0
    assert "also      MPE_E" in capsys.readouterr().out
    assert run(["explain", "EQX"]) == 2
    assert "figures such as E0_MPE" in capsys.readouterr().err


def test_explain_knows_readings(capsys):
    assert document(capsys, "explain", "part_expansion")["sign"].startswith("reading")
    assert document(capsys, "explain", "backlash")["sign"].startswith("tip error")


@pytest.mark.parametrize("kind", ["machine", "scenario", "part", "plan"])
def test_schema(tmp_path, capsys, kind):
    assert run(["schema", kind]) == 0
    printed = capsys.readouterr().out
    assert json.loads(printed)["title"] == f"vcmm {kind}/1"
    assert run(["schema", kind, "--out", str(tmp_path)]) == 0
    assert json.loads((tmp_path / f"{kind}.schema.json").read_text()) == json.loads(printed)


def test_doctor(capsys, monkeypatch):
    monkeypatch.setattr("vcmm.face.cli.doctor._rendering", lambda: ["off-screen OpenGL", "not tried", "ok"])
    found = document(capsys, "doctor")
    assert set(found) == HEAD | {"checks", "ok"}
    assert found["ok"] is True
    assert {"vcmm", "Python", "numpy", "scipy", "cores"} <= {c["what"] for c in found["checks"]}


def test_doctor_compiles_nothing_that_it_cannot_keep(capsys, monkeypatch):
    monkeypatch.setattr("vcmm.face.cli.doctor._rendering", lambda: ["off-screen OpenGL", "not tried", "ok"])
    monkeypatch.setattr("vcmm.core._compile_kernels.KEPT", False)
    rows = {row["what"]: row for row in document(capsys, "doctor", "--warm")["checks"]}
    assert rows["kernels compiled"]["found"] == "no"
    assert "NUMBA_CACHE_DIR" in rows["kernels compiled"]["state"]


def test_doctor_with_something_missing(capsys, monkeypatch):
    monkeypatch.setattr("vcmm.face.cli.doctor._rendering", lambda: ["off-screen OpenGL", "not tried", "ok"])
    monkeypatch.setattr("vcmm.face.cli.doctor.REQUIRED_PACKAGES", ("numpy", "no-such-package"))
    assert run(["doctor"]) == 3
    assert "missing: pip install no-such-package" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["chek"], 'unknown command "chek". Did you mean "check"? Allowed: demo, new, check'),
        (["uncertanty", "x.toml"], 'Did you mean "uncertainty"'),
        (["check", "plate.toml", "--jsn"], "Did you mean --json?"),
        (["field", "m.toml", "--exct"], "Did you mean --exact?"),
        (["list", "effcts"], 'Did you mean "effects"?'),
        (["schema", "machin"], 'Did you mean "machine"?'),
        (["explain", "backlsh"], 'unknown effect "backlsh". Did you mean "backlash"'),
        (["measure", "x.toml", "--seed", "abc"], 'unable to convert "abc" into int'),
        (["uncertainty", "x.toml", "--trials", "1.5"], 'unable to convert "1.5" into int'),
        (["measure", "x.toml", "--seed=0.5"], 'unable to convert "0.5" into int'),
        (["audit", "x.toml", "--parts", "1.0e999"], 'unable to convert "1.0e999" into int'),
        (["uncertainty", "x.toml", "--trials", "2.0"], "x.toml"),
        (["check"], "requires an argument"),
    ],
)
def test_wrong_command_lines(capsys, words, message):
    code = run(words)
    out, err = capsys.readouterr()
    assert code == 2
    assert out == ""
    assert err.startswith("vcmm: ")
    assert message in err


def test_help_names_every_verb(capsys):
    run(["--help"])
    out = capsys.readouterr().out
    for verb, text in VERBS.items():
        assert f" {verb} " in out
        assert text.split()[0] in out
    assert sorted(" ".join(GROUPS.values()).split()) == sorted(VERBS)  # each in one group
    assert all(out.index(one) < out.index(other) for one, other in zip([*GROUPS][:-1], [*GROUPS][1:]))


def test_interrupted(tmp_path, capsys, monkeypatch):
    def interrupt(*_args, **_kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("vcmm.files.own.scenario.load_scenario", interrupt)
    assert run(["measure", str(edited(tmp_path)), "--json"]) == 130
    out, err = capsys.readouterr()
    assert out == ""
    assert "interrupted" in err


def test_our_bug(tmp_path, capsys, monkeypatch):
    def fail(*_args, **_kwargs):
        raise RuntimeError("inner")

    monkeypatch.setattr("vcmm.files.own.scenario.load_scenario", fail)
    assert run(["measure", str(edited(tmp_path)), "--json"]) == 70
    out, err = capsys.readouterr()
    assert out == ""
    assert "RuntimeError: inner" in err
    assert "this is our bug" in err


def test_numbers_that_are_not_finite_become_null_with_a_warning():
    from vcmm.show.console.documents import document as frame

    found = frame("vcmm.test/1", {"a": {"u_mm": float("inf")}, "b": [1.0, float("nan")]}, warnings=["first"])
    assert found["a"]["u_mm"] is None
    assert found["b"] == [1.0, None]
    assert found["warning_texts"] == ["first", "a.u_mm is inf", "b[1] is nan"]
    assert [w["severity"] for w in found["warnings"]] == ["warning", "error", "error"]


def test_record_of_inputs_names_every_file_once(tmp_path):
    from vcmm.show.console.documents import sources

    (tmp_path / "a.toml").write_text('x = "b.toml"\ny = ["c.csv", "nowhere.csv", "c.csv"]\n')
    (tmp_path / "b.toml").write_text('back = "a.toml"\n')  # a circle does not hang
    (tmp_path / "c.csv").write_text("")
    (tmp_path / "d.toml").write_text("not toml")
    assert [p.name for p in sources(tmp_path / "a.toml")] == ["a.toml", "b.toml", "c.csv"]
    assert [p.name for p in sources(tmp_path / "d.toml")] == ["d.toml"]


def test_as_a_program(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", "from vcmm.face.cli import main; main()", "check", str(edited(tmp_path)), "--json"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0
    assert json.loads(done.stdout)["schema"] == "vcmm.check/1"
    assert done.stderr == ""


def test_a_reader_that_stops_early(tmp_path):
    """vcmm ... | head -1 ends without a complaint."""
    command = f'{sys.executable} -c "from vcmm.face.cli import main; main()" field {machine_file(tmp_path)} --nodes 12 --json | head -c 20'
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.stdout.startswith("{")
    assert done.stderr == ""


@pytest.mark.thorough
def test_undecided_by_exit_code(tmp_path, capsys):
    """U of the diameter is 0.76 um: a reading 0.1 um inside its limit is undecided, which --require tells by exit code 1."""
    from vcmm.files.own.library import example

    plate = tmp_path / "plate.toml"
    plate.write_bytes(example("plate").read_bytes())
    values = tmp_path / "values.csv"
    values.write_text("characteristic,value_mm\nbore diameter,30.0109\n")
    words = ["evaluate", str(plate), "--values", str(values), "--trials", "1000", "--json"]
    assert run(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert [c["decision"] for c in found["characteristics"]] == ["undecided"]
    assert run([*words, "--require", "conforms"]) == 1
    assert json.loads(capsys.readouterr().out)["characteristics"] == found["characteristics"]
    values.write_text("characteristic,value_mm\nbore diameter,30.004\n")
    assert run([*words, "--require", "conforms"]) == 0
    capsys.readouterr()
    assert run(["uncertainty", str(plate), "--shard", "1/2", "--require", "conforms"]) == 2
