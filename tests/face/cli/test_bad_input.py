"""Bad input: one clear message per mistake with file, line, what is allowed and the fix; nothing half-written."""

from __future__ import annotations

import json

import pytest

from tests.plate import PLATE, edited, line_of
from vcmm.face.cli import run

GRID = 'points = { strategy = "grid", n = [3, 3], margin = "5 mm" }'
LEVELS = 'points = { strategy = "levels", at = ["5 mm", "15 mm"], n = 8 }'
TOP = 'top   = { type = "plane", point = "0 0 20 mm", normal = [0, 0, 1], size = "80 80 mm" }'

# (what is typed, what stands there afterwards, words that the message must hold); the line is that of the new text
MISTYPED = [
    # limits that hold the nominal value; a feature against itself
    ('limits = ["0 mm", "0.021 mm"]', 'limits = ["29.990 mm", "30.011 mm"]', ["limits count from the nominal value (30 mm)", 'limits = ["-0.01 mm", "0.011 mm"]']),
    ('between = ["front", "bore"]', 'between = ["bore", "bore"]', ['it compares "bore" with itself']),
    # keys in every table
    ('name = "bridge CMM"', 'nmae = "bridge CMM"', ['[machine] unknown key "nmae". Did you mean "name"?']),
    ('structure = "w b Y X Z t"', 'structur = "w b Y X Z t"', ['Did you mean "structure"']),
    ('travel = ["0 mm", "600 mm"]', 'travle = ["0 mm", "600 mm"]', ['[machine.axes.X] unknown key "travle". Did you mean "travel"?']),
    ('scale = "0.7 um"', 'scal = "0.7 um"', ['[machine.repeatability] unknown key "scal". Did you mean "scale"?']),
    ("u_sensor =", "u_senser =", ['[machine.environment.scales] unknown key "u_senser". Did you mean "u_sensor"?']),
    ('angle = "3 urad"', 'angel = "3 urad"', ['unknown key "angel" of effect squareness. Did you mean "angle"?']),
    ('redraw = "machine"', 'redrw = "machine"', ['unknown key "redrw" of an input. Did you mean "redraw"?']),
    ('u_expansion = "1 um/(m K)"', 'u_expension = "1 um/(m K)"', ['[part] unknown key "u_expension". Did you mean "u_expansion"?']),
    (TOP, TOP.replace("normal", "norml"), ['unknown key "norml". Did you mean "normal"?']),
    ("inside = true", "insid = true", ['[part.features.bore] unknown key "insid". Did you mean "inside"?']),
    ('datums = ["top"]', 'datum = ["top"]', ['[part.characteristics 2] unknown key "datum". Did you mean "datums"?']),
    ('turn = "0 0 30 deg"', 'trun = "0 0 30 deg"', ['[pose] unknown key "trun". Did you mean "turn"?']),
    ('origin = "bore"', 'orign = "bore"', ['[plan.alignment] unknown key "orign". Did you mean "origin"?']),
    ('clearance = "20 mm"', 'clearence = "20 mm"', ['[plan.touch] unknown key "clearence". Did you mean "clearance"?']),
    ("tip_diameter", "tip_diamter", ['[plan.styli.down] unknown key "tip_diamter". Did you mean "tip_diameter"?']),
    (GRID, GRID.replace("margin", "margn"), ['unknown key "margn" of strategy grid. Did you mean "margin"?']),
    (GRID, GRID.replace("strategy", "stratgy"), ['"stratgy" is there; rename it to "strategy"']),
    ('temperature = { part = "21.2', 'temperature = { prat = "21.2', ['unknown key "prat". Did you mean "part"?']),
    ("trials = 20000", "trails = 20000", ['[job] unknown key "trails". Did you mean "trials"?']),
    ("[pose]", "[poes]", ['unknown key "poes". Did you mean "pose"?']),
    # values
    ('kind = "cmm"', 'kind = "cnm"', ['kind = "cnm" is not allowed. Did you mean "cmm"?']),
    ('law = "t"', 'law = "student"', ["Allowed: normal, t"]),
    ('type = "size"', 'type = "sise"', ['unknown characteristic type "sise". Did you mean "size"?']),
    ('type = "perpendicularity"', 'type = "perpendicular"', ['Did you mean "perpendicularity"?']),
    (TOP, TOP.replace('"plane"', '"plain"'), ['has the unknown type "plain". Did you mean "plane"?']),
    ('strategy = "levels"', 'strategy = "level"', ['A cylinder has no strategy "level". Did you mean "levels"?']),
    ('datums = ["top"]', 'datums = ["topp"]', ['names the unknown feature "topp". Did you mean "top"?']),
    ('between = ["front", "bore"]', 'between = ["fornt", "bore"]', ['unknown feature "fornt". Did you mean "front"?']),
    ('feature = "front"', 'feature = "frnt"', ['unknown feature "frnt". Did you mean "front"?']),
    ('plane = "top"', 'plane = "tpo"', ['the alignment names "tpo"', 'Did you mean "top"?']),
    ('parameter = "angle"', 'parameter = "angel"', ['squareness has no parameter "angel". Did you mean "angle"?']),
    ('redraw = "machine"', 'redraw = "machin"', ['redraw = "machin" is no label. Did you mean "machine"?']),
    ('rule = "probability 95 %"', 'rule = "probabilty 95 %"', ['Did you mean "probability 95 %"?']),
    # units
    ('["0 mm", "600 mm"]', '["0 mm", "600 mmm"]', ['unknown unit "mmm" in "mmm". Did you mean "mm"?']),
    ('speed = "5 mm/s"', 'speed = "5 mm/sec"', ['"sec"', 'is no unit: write s']),
    ('["0 mm", "600 mm"]', '["0 mm", "600 kg"]', ['travel = "600 kg" is not a length']),
    ('["0 mm", "600 mm"]', '["0", "600"]', ['travel = "0" has no unit; write for example travel = "0 mm"']),
    ('["0 mm", "600 mm"]', "[0, 600]", ['travel = [0, 600] must be two values with units', '["0 mm", "600 mm"]']),
    ('angle = "3 urad"', "angle = 3", ['angle = 3 has no unit; write for example angle = "3 urad"']),
    ('angle = "3 urad"', 'angle = "3 um"', ['angle = "3 um" is not an angle']),
    ('part = "0.1 K"', 'part = "0.1 degC"', ["is a temperature difference and takes K"]),
    ('part = "21.2 degC"', 'part = "21.2 K"', ["is a temperature and takes degC"]),
    ('offset = "0 0 -120 mm"', "offset = [0, 0, -120]", ['write for example offset = "0 0 -120 mm"']),
    ('offset = "0 0 -120 mm"', 'offset = "-120 mm"', ["has 1 number, expected three"]),
    ('zone = "0.01 mm"', "zone = 0.01", ["zone = 0.01 must be a text in quotes", 'zone = "0.01 mm"']),
    # structure
    ('"w b Y X Z t"', '"w b Y X X t"', ["names axis X 2 times; each axis once"]),
    ('"w b Y X Z t"', '"w b C C t"', ["names axis C 2 times; each axis once: number them, C1 and C2"]),
    ('"w b Y X Z t"', '"w b Y X t"', ['axis Z is not in structure = "w b Y X t"']),
    ('"w b Y X Z t"', '"w b Y X Z C t"', ["names axis C, but there is no [axes.C]"]),
    ('"w b Y X Z t"', '"w Y b X Z t"', ["take a prime"]),
    ('"w b Y X Z t"', '"b Y X Z"', ["must start with w, end with t"]),
    # numbers
    ('["0 mm", "600 mm"]', '["600 mm", "0 mm"]', ["the first end must be the lower one"]),
    ('["0 mm", "600 mm"]', '["0 mm", "nan mm"]', ["is not finite"]),
    ('scale = "0.7 um"', 'scale = "inf um"', ["is not finite"]),
    ("normal = [0, 0, 1], size", "normal = [0, 0, nan], size", ["must be three plain finite numbers"]),
    ("normal = [0, 0, 1], size", "normal = [0, 0, 0], size", ["has no direction"]),
    ('diameter = "30 mm"', 'diameter = "-30 mm"', ['diameter = "-30 mm" must be positive']),
    ('speed = "5 mm/s"', 'speed = "0 mm/s"', ['speed = "0 mm/s" must be positive']),
    ('scale = "0.7 um"', 'scale = "-0.7 um"', ["must be not negative"]),
    ('limits = ["0 mm", "0.021 mm"]', 'limits = ["0.021 mm", "0 mm"]', ["the lower limit is not below the upper one; exchange them"]),
    ('zone = "0.01 mm"', 'limits = ["0.005 mm", "0.01 mm"]', ["has no lower limit but zero", 'write zone = "0.01 mm"']),
    ("dof = 6", "dof = 0", ["dof = 0 must be 1 or more"]),
    ("dof = 6", "dof = nan", ["dof = nan"]),
    # plan
    ("n = [3, 3]", "n = [1, 2]", ["a plane needs at least 3 points, got 2"]),
    ("n = 8", "n = 2", ["a cylinder needs at least 5 points, got 4"]),
    ("n = 8", "n = 8.5", ["n = 8.5 must be a whole number"]),
    ("n = [3, 3]", "n = 9", ["n = 9 must be 2 whole numbers", "n = [3, 3]"]),
    ('margin = "5 mm"', 'margin = "50 mm"', ["margin"]),
]  # fmt: skip


def _fails(capsys, *words: str) -> str:
    code = run(list(words))
    out, err = capsys.readouterr()
    assert code == 2, err
    assert out == ""
    assert "Traceback" not in err
    assert all(line.startswith(("vcmm: ", "    ")) for line in err.splitlines())
    return err


@pytest.mark.parametrize(("old", "new", "words"), MISTYPED, ids=[new[:40] for _, new, _ in MISTYPED])
def test_mistake_in_the_scenario(tmp_path, capsys, old, new, words):
    path = edited(tmp_path, (old, new))
    err = _fails(capsys, "check", str(path))
    assert all(word in err for word in words), err
    where = "[machine.axes.Z]" if "axis Z is not in structure" in words[0] else new
    line = line_of(path.read_text(), where)
    assert f"vcmm: {path}:{line}: " in err, err


@pytest.mark.parametrize("verb", ["check", "measure", "uncertainty"])
def test_every_verb_says_the_same_and_nothing_on_stdout(tmp_path, capsys, verb):
    path = edited(tmp_path, ("[pose]", "[poes]"))
    err = _fails(capsys, verb, str(path), "--json")
    assert f'{path}:{line_of(path.read_text(), "[poes]")}: unknown key "poes". Did you mean "pose"?' in err


def test_all_problems_of_a_file_at_once(tmp_path, capsys):
    edits = [
        ('kind = "cmm"', 'kind = "cnm"'), ('["0 mm", "500 mm"]', '["0 mm", "500 kg"]'), ('pair = "C0Y"\nangle', 'pair = "COY"\nangle'),
        ('u_expansion = "1 um/(m K)"', 'u_expansion = "-1 um/(m K)"'), (TOP, TOP.replace('"plane"', '"plain"')),
        ('type = "distance"', 'type = "distanse"'), ('turn = "0 0 30 deg"', 'turn = "0 0 30"'), ('speed = "5 mm/s"', "speed = 5"),
        ('u_temperature = { part = "0.1 K" }', 'u_temperature = { part = "0.1" }'), ("trials = 20000", "trials = 20"),
    ]  # fmt: skip
    path = edited(tmp_path, *edits)
    err = _fails(capsys, "check", str(path))
    lines = {int(text.removeprefix(f"vcmm: {path}:").split(":")[0]) for text in err.splitlines()}
    wanted = {line_of(path.read_text(), new.split("\n")[0]) for _, new in edits}
    assert wanted <= lines, err
    assert len(err.splitlines()) == len(edits)  # and nothing that only follows from them


@pytest.mark.parametrize(
    ("edits", "expected"),
    [
        (
            [('pair = "C0Y"\nangle', 'pairs = "C0Y"\nangle')],
            2,
        ),  # unknown key, missing key; not the input that needs it
        ([("top   = {", "topp  = {")], 1),  # one wrong name, not every place where it is used
        ([("[part.features]", "[part.feature]")], 1),
        ([("[machine.axes.X]\n", "[machine.axes.x]\n")], 2),
        ([('law = "t"', 'law = "q"')], 1),
    ],
)
def test_no_complaints_that_only_follow(tmp_path, capsys, edits, expected):
    err = _fails(capsys, "check", str(edited(tmp_path, *edits)))
    assert len(err.splitlines()) == expected, err


def test_inside_inline_tables_and_lists_over_several_lines(tmp_path, capsys):
    steps = PLATE[PLATE.index("[[plan.steps]]") : PLATE.index("[environment]")]
    listed = (
        'steps = [\n  { feature = "top", stylus = "down", points = { strategy = "grid", n = [3,\n    3] } },\n'
        '  { feature = "bore", stylus = "down", points = { strategy = "levels", at = [\n'
        '    "5 mm",\n    "15 kg",\n  ], n = 8 } },\n'
        '  { feature = "frnt", stylus = "down", points = { strategy = "grid", n = [3, 2] } },\n]\n'
    )
    path = edited(tmp_path, (steps, listed))
    text = path.read_text()
    err = _fails(capsys, "check", str(path))
    assert f'{path}:{line_of(text, "frnt")}: [plan.steps 3] unknown feature "frnt"' in err
    assert f'{path}:{line_of(text, "at = [")}: [plan.steps 2.points] at = "15 kg" is not a length' in err


def test_empty_plan(tmp_path, capsys):
    steps = PLATE[PLATE.index("[[plan.steps]]") : PLATE.index("[environment]")]
    path = edited(tmp_path, (steps, ""))
    assert "the plan is empty; add [[plan.steps]]" in _fails(capsys, "check", str(path))


def test_travel_exceeded_and_points_outside_the_machine(tmp_path, capsys):
    path = edited(tmp_path, ('shift = "300 250 -300 mm"', 'shift = "590 250 -300 mm"'))
    line = line_of(path.read_text(), "[pose]")
    for verb in ("check", "measure", "uncertainty"):
        err = _fails(capsys, verb, str(path))
        assert "axis X = " in err
        assert "is outside its travel 0 to 600 mm" in err
        assert "(a point on " in err
        assert "move the part or the pose" in err
        if verb != "uncertainty":
            assert f"{path}:{line}: " in err


def test_outside_the_residual_field(tmp_path, capsys):
    nodes = ", ".join(f'"{x} {y} {z} mm"' for x in (0, 600) for y in (0, 500) for z in (-400, -200))
    field = f'[[machine.effects]]\neffect = "residual_field"\nnodes = [{nodes}]\n[part]\n'
    path = edited(tmp_path, ("[part]\n", field), ('shift = "300 250 -300 mm"', 'shift = "300 250 -210 mm"'))
    err = _fails(capsys, "check", str(path))
    assert "outside the hull of the grid of nodes" in err
    assert f"{path}:{line_of(path.read_text(), '[pose]')}: " in err


def test_a_column_that_nobody_gives(tmp_path, capsys):
    load = '[[machine.effects]]\neffect = "part_load"\naxis = "X"\ndirection = "z"\nc = "0.05 um/(m kg)"\n[part]\n'
    err = _fails(capsys, "check", str(edited(tmp_path, ("[part]\n", load))))
    assert "load_kg" in err


def test_rotations_above_one_milliradian(tmp_path, capsys):
    (tmp_path / "errors.csv").write_text("X EBX\n0 0.002\n600 0.002\n")
    path = edited(
        tmp_path,
        ("[machine.repeatability]", '[machine.errors]\ntable = "errors.csv"\n[machine.repeatability]'),
    )
    err = _fails(capsys, "check", str(path))
    assert "a rotation of 2 mrad of link X exceeds 1 mrad" in err
    assert "--exact" in err
    machine = tmp_path / "m.toml"
    body = PLATE[PLATE.index("[machine]\n") + 10 : PLATE.index("[machine.repeatability]")].replace(
        "[machine.", "["
    )
    machine.write_text(f'vcmm = "machine/1"\n{body}[errors]\ntable = "errors.csv"\n')
    assert "exceeds 1 mrad" in _fails(capsys, "field", str(machine), "--json")
    assert run(["field", str(machine), "--exact", "--json", "--nodes", "2"]) == 0
    assert json.loads(capsys.readouterr().out)["engine"] == "exact"


@pytest.mark.parametrize("dof", [1, 2])
def test_few_degrees_of_freedom_are_no_mistake(tmp_path, capsys, dof):
    path = edited(tmp_path, ("dof = 6", f"dof = {dof}"))
    assert run(["check", str(path)]) == 0
    assert "u is infinite for nu <= 2; the coverage interval is given" in " ".join(
        capsys.readouterr().out.split()
    )


def test_few_degrees_of_freedom_give_an_interval(tmp_path, capsys):
    path = edited(tmp_path, ("dof = 6", "dof = 2"))
    assert run(["uncertainty", str(path), "--json", "--trials", "4000"]) in (0, 1)
    found = json.loads(capsys.readouterr().out)
    size = found["characteristics"][0]
    assert size["u_mm"] is None
    assert size["interval_mm"][0] < size["value_mm"] < size["interval_mm"][1]
    assert any("u_mm" in text or "infinite" in text for text in found["warning_texts"])


@pytest.mark.parametrize("verb", ["measure", "uncertainty"])
def test_folder_that_cannot_be_written(tmp_path, capsys, verb):
    (tmp_path / "file").write_text("in the way")
    code = run([verb, str(edited(tmp_path)), "--out", str(tmp_path / "file" / "sub"), "--json"])
    out, err = capsys.readouterr()
    assert code == 3
    assert out == ""
    assert "cannot be written" in err
    assert "choose another with --out" in err


def test_nothing_half_written(tmp_path, capsys, monkeypatch):
    path = edited(tmp_path, ('shift = "300 250 -300 mm"', 'shift = "590 250 -300 mm"'))
    _fails(capsys, "measure", str(path), "--out", str(tmp_path / "new" / "folder"))
    assert not (tmp_path / "new").exists()  # the failing command leaves no folder
    from vcmm.show.console import files

    written = []

    def fail(self, *_args, **_kwargs):
        written.append(self.name)
        if len(written) == 2:
            raise OSError(28, "No space left on device")
        return original(self, *_args, **_kwargs)

    original = files.Path.write_text
    monkeypatch.setattr(files.Path, "write_text", fail)
    with pytest.raises(files.Environment, match="No space left on device"):
        files.write_files(tmp_path / "out", {"a.txt": "a", "b.txt": "b"})
    monkeypatch.undo()
    assert list((tmp_path / "out").iterdir()) == []


def test_a_file_that_is_not_there(tmp_path, capsys):
    edited(tmp_path)
    err = _fails(capsys, "check", str(tmp_path / "plat.toml"))
    assert 'plat.toml does not exist. Did you mean "plate.toml"?' in err
    path = edited(
        tmp_path, ('points = { strategy = "grid", n = [3, 2], margin = "4 mm" }', 'points = "nowhere.csv"')
    )
    line = line_of(path.read_text(), "nowhere.csv")
    err = _fails(capsys, "check", str(path))
    assert f"{path}:{line}: [plan.steps 3] {tmp_path}/nowhere.csv does not exist" in err


def test_not_toml(tmp_path, capsys):
    path = edited(tmp_path, ('scale = "0.7 um"', "scale = 0.7 um"))
    err = _fails(capsys, "check", str(path))
    assert f"{path}:{line_of(path.read_text(), 'scale = 0.7 um')}: not valid TOML" in err
    assert "texts need quotes" in err


@pytest.mark.parametrize(
    ("text", "hint"),
    [("", 'must be vcmm = "scenario/1"'), ('vcm = "scenario/1"\n', '"vcm" is there; rename it to "vcmm"'), ('vcmm = "scenaro/1"\n', 'Did you mean "scenario"')],
)  # fmt: skip
def test_unknown_kind_of_file(tmp_path, capsys, text, hint):
    path = tmp_path / "x.toml"
    path.write_text(text)
    assert hint in _fails(capsys, "check", str(path))


def _mutants():
    """Every key of the scenario with a value of a wrong kind."""
    import tomllib

    def paths(value, at=()):
        items = (
            value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        )
        for key, inner in items:
            yield (*at, key), inner
            yield from paths(inner, (*at, key))

    wrong = ("true", "[]", "{}", '"rubbish"', "nan")
    for i, (at, _) in enumerate(p for p in paths(tomllib.loads(PLATE)) if p[0] != ("vcmm",)):
        yield at, wrong[i % len(wrong)]


@pytest.mark.thorough
def test_wrong_kinds_of_values_are_never_our_bug(tmp_path, capsys):
    """A systematic walk: no key of the scenario, whatever stands there, ends in a traceback."""
    import tomllib

    path = tmp_path / "m.toml"
    bad = []
    for at, text in _mutants():
        data = tomllib.loads(PLATE)
        place = data
        for key in at[:-1]:
            place = place[key]
        place[at[-1]] = tomllib.loads(f"x = {text}")["x"]
        path.write_text(_toml(data))
        code = run(["check", str(path)])
        out, err = capsys.readouterr()
        located = all(line.startswith(f"vcmm: {path}:") or "    " in line[:4] for line in err.splitlines())
        if code not in (0, 2) or (code == 2 and (out or not err or not located)):
            bad.append((at, text, code, err[-200:]))
    assert bad == []


def _toml(data: dict) -> str:
    """A document on one line per top-level key: inline tables all the way down."""

    def text(value) -> str:
        if isinstance(value, dict):
            return "{ " + ", ".join(f"{json.dumps(k)} = {text(v)}" for k, v in value.items()) + " }"
        if isinstance(value, list):
            return "[" + ", ".join(text(v) for v in value) + "]"
        if isinstance(value, float) and value != value:
            return "nan"
        return json.dumps(value)

    return "\n".join(f"{json.dumps(k)} = {text(v)}" for k, v in data.items()) + "\n"
