"""Scene files: defaults, round trip, and one message per fault that names key, value and expectation."""

import copy
import math
import tomllib

import numpy as np
import pytest

import feed
import warp_origami as wo
from warp_origami.scene.files import load_scene

MINIMAL = {
    "name": "square",
    "analysis": {"kind": "dynamic", "duration": 4.0},
    "pattern": {"kind": "sheet"},
    "material": {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4},
}
FULL = """
# every kind of table
name = "everything"
[analysis]
kind = "dynamic"
duration = 4
[pattern]
kind = "leaf_in"
refine = 2
initial = { stretch = [1.0004, 1] }
[material]
density = 1420
youngs_modulus = 2.5e9
poisson_ratio = 0.34
thickness = 5e-4
s2 = 1e-3
[contact]
method = "sts"
[[support]]
name = "rim"
at = { boundary = true }
fix = "zx"
[[driver]]
name = "corner"
at = { near = [0.3, 0.3] }
translate = [0.1, 0.1, 0.0]
rotate = { axis = [0, 0, 1], angle = 0.01 }
profile = { table = [[0, 0], [1, 1.5]] }
[[driver]]
at = { circle = [0.3, 0.3, 1] }
translate_to = "deployed"
profile = { kind = "trapezoid", start = 0.5 }
[[load]]
kind = "gravity"
acceleration = [0, 0, -9.81]
profile = { kind = "linear", end = 1 }
[[load]]
kind = "initial_velocity"
value = [0, 0, 1]
at = { box = [[0, 0], [1, 1]] }
[output]
fps = "steps"
[[probe]]
at = [0, 0]
[[probe]]
name = "A"
at = [0.1, 0.1]
"""


@pytest.fixture
def full(tmp_path):
    path = tmp_path / "full.toml"
    path.write_text(FULL)
    return path


def minimal(**tables):
    values = copy.deepcopy(MINIMAL)
    for key, value in tables.items():
        values[key] = {**values.get(key, {}), **value} if isinstance(value, dict) else value
    return wo.Scene(**values)


def test_defaults_are_those_of_the_documentation():
    scene = minimal(contact={}, driver=[{"at": {"near": [0, 0]}, "translate": [0, 0, 1]}])
    assert (scene.material.model, scene.material.s1, scene.material.s2) == ("srm", 1e-4, 1e-4)
    assert (scene.material.mass_damping, scene.material.stiffness_damping) == (0.0, 0.0)
    assert scene.contact.method == "mixed"
    assert scene.contact.thickness == scene.material.thickness
    assert scene.integrator.constraints == "eliminate"
    assert (scene.integrator.spectral_radius, scene.integrator.tolerance, scene.integrator.step) == (0.3, 1e-4, "auto")
    assert scene.output.fps == 60.0
    assert scene.output.fields == ("von_mises", "state")
    profile = scene.driver[0].profile
    assert (profile.kind, profile.start, profile.end) == ("smooth", 0.0, 4.0)
    assert minimal().contact is None


def test_initial_state_is_stowed_where_the_pattern_has_one(tmp_path):
    assert minimal().pattern.initial == "flat"
    assert minimal(pattern={"nx": 2, "creases_x": [1], "opening": 0.1}).pattern.initial == "stowed"
    assert minimal(pattern={"kind": "leaf_in"}).pattern.initial == "stowed"
    for stowed, initial in ((None, "flat"), (90.0, "stowed")):
        feed.write_fold(tmp_path / "x.fold", stowed)
        assert minimal(pattern={"kind": "fold", "file": str(tmp_path / "x.fold")}).pattern.initial == initial


def test_loads_act_on_the_whole_sheet_all_the_time_unless_said_otherwise():
    scene = minimal(
        load=[{"kind": "gravity", "acceleration": [0, 0, -1]}, {"kind": "initial_velocity", "value": [1, 0, 0]}]
    )
    assert scene.load[0].profile.factor()(3.0) == 1.0
    assert scene.load[1].at.kind == "all"


def test_written_scene_reads_back_equal_and_complete(full, tmp_path):
    scene = load_scene(full)
    written = tmp_path / "elsewhere" / "scene.toml"
    written.parent.mkdir()
    written.write_text(scene.to_toml())
    assert load_scene(written) == scene
    tables = tomllib.loads(scene.to_toml())
    assert tables["integrator"]["spectral_radius"] == 0.3
    assert tables["contact"]["thickness"] == 5e-4
    assert tables["driver"][1] == {
        "at": {"circle": [0.3, 0.3, 1.0], "tol": 1e-6},
        "translate_to": "deployed",
        "overstretch": 0.0,
        "axes": "xyz",
        "profile": {"kind": "trapezoid", "start": 0.5, "end": 4.0},
    }
    assert tables["pattern"]["corner_distance"] == pytest.approx(0.312)
    assert [probe["name"] for probe in tables["probe"]] == ["probe0", "A"]


def test_numbers_survive_the_round_trip_to_the_last_bit(tmp_path):
    scene = minimal(material={"thickness": math.pi * 1e-5}, probe=[{"at": [1 / 3, -2e-17]}])
    (tmp_path / "s.toml").write_text(scene.to_toml())
    assert load_scene(tmp_path / "s.toml").material.thickness == math.pi * 1e-5
    assert load_scene(tmp_path / "s.toml").probe[0].at == (1 / 3, -2e-17)


def test_numpy_values_are_as_good_as_python_ones():
    scene = minimal(material={"thickness": np.float64(1e-3)}, pattern={"nx": np.int64(3), "origin": np.zeros(2)})
    assert scene.pattern.parameters()["nx"] == 3
    assert scene == minimal(material={"thickness": 1e-3}, pattern={"nx": 3, "origin": [0, 0]})


def test_fold_file_is_relative_to_the_scene_file(tmp_path, monkeypatch):
    folder = tmp_path / "scenes"
    folder.mkdir()
    feed.write_fold(folder / "x.fold")
    scene = minimal(pattern={"kind": "fold", "file": str(folder / "x.fold")})
    (folder / "s.toml").write_text(scene.to_toml().replace(str(folder / "x.fold"), "x.fold"))
    monkeypatch.chdir(tmp_path)
    read = load_scene("scenes/s.toml")
    assert read == scene
    (tmp_path / "copy.toml").write_text(read.to_toml())
    assert load_scene("copy.toml") == scene


def test_overrides_take_toml_values(full):
    scene = load_scene(
        full,
        [
            "material.thickness=1e-4",
            "driver.1.profile.end=2",
            "contact.method=nts",
            'contact.method = "mixed"',
            "integrator.step=auto",
            "driver.0.translate=[1, 2, 3]",
        ],
    )
    assert scene.material.thickness == 1e-4
    assert scene.driver[1].profile.end == 2.0
    assert scene.contact.method == "mixed"
    assert scene.driver[0].translate == (1.0, 2.0, 3.0)


FAULTS = [
    # override, key, part of what is found, part of what is wanted
    ("material.thickness=0", "material.thickness", "0", "> 0"),
    ("material.thickness=-1.0", "material.thickness", "-1.0", "> 0"),
    ('material.thickness="1e-4"', "material.thickness", '"1e-4"', "a number"),
    ("material.thickness=true", "material.thickness", "true", "a number"),
    ("material.thickness=nan", "material.thickness", "nan", "> 0"),
    ("material.youngs_modulus=inf", "material.youngs_modulus", "inf", "Pa"),
    ("material.density=0", "material.density", "0", "kg/m^3"),
    ("material.poisson_ratio=0.5", "material.poisson_ratio", "0.5", "between -1 and 0.5"),
    ("material.poisson_ratio=-1", "material.poisson_ratio", "-1", "between -1 and 0.5"),
    ("material.s1=0", "material.s1", "0", "> 0 and <= 1"),
    ("material.s2=1.5", "material.s2", "1.5", "> 0 and <= 1"),
    ("material.mass_damping=-1", "material.mass_damping", "-1", ">= 0"),
    ("material.stiffness_damping=-1", "material.stiffness_damping", "-1", ">= 0"),
    ("material.model=hooke", "material.model", '"hooke"', '"srm"'),
    ("material.colour=red", "material.colour", "unknown key", "youngs_modulus"),
    ("colour=red", "colour", "unknown key", "integrator"),
    ("material=3", "material", "3", "a table"),
    ("name=3", "name", "3", "a name"),
    ('name="../x"', "name", "../x", "folder"),
    ("analysis.kind=buckling", "analysis.kind", '"buckling"', '"static"'),
    ("analysis.kind=static", "analysis.duration", "unknown key", "load_steps"),
    ("analysis={kind='modal',count=0}", "analysis.count", "0", ">= 1"),
    ("analysis={kind='static',load_steps=0}", "analysis.load_steps", "0", ">= 1"),
    ("analysis.duration=0", "analysis.duration", "0", "> 0"),
    ("analysis={kind='dynamic'}", "analysis.duration", "nothing", "simulated time, s"),
    ("pattern.kind=waterbomb", "pattern.kind", '"waterbomb"', '"leaf_in"'),
    ("pattern={}", "pattern.kind", "nothing", '"sheet"'),
    ("pattern.refine=0", "pattern.refine", "0", ">= 1"),
    ("pattern.refine=1.0", "pattern.refine", "1.0", "an integer"),
    ("pattern.refine=true", "pattern.refine", "true", "an integer"),
    ("pattern.nx=3", "pattern.nx", "unknown key", "corner_distance"),
    ("pattern.initial=folded", "pattern.initial", '"folded"', '"stowed"'),
    ("pattern.initial={stretch=[1,0]}", "pattern.initial.stretch.1", "0", "> 0"),
    ("pattern={kind='sheet',initial='stowed'}", "pattern.initial", '"stowed"', "opening"),
    ("pattern={kind='sheet',opening=4}", "pattern.opening", "4", "<= pi"),
    ("pattern={kind='fold'}", "pattern.file", "nothing", "FOLD"),
    ("pattern={kind='fold',file='no.fold'}", "pattern.file", "no.fold", "readable FOLD file"),
    ("contact.method=penalty", "contact.method", '"penalty"', '"mixed"'),
    ("contact.sts_stiffness=0", "contact.sts_stiffness", "0", "N/m^3"),
    ("contact.thickness=0", "contact.thickness", "0", "> 0"),
    ("support.0.fix=xx", "support.0.fix", '"xx"', "at most once"),
    ('support.0.fix=""', "support.0.fix", '""', "some of the letters"),
    ("driver.0.axes=xw", "driver.0.axes", '"xw"', "x, y, z"),
    ("support.0.at={}", "support.0.at", "empty", "exactly one of near"),
    ("support.0.at={all=true,near=[0,0]}", "support.0.at", "near, all", "exactly one"),
    ("support.0.at={all=false}", "support.0.at.all", "false", "true"),
    ("support.0.at={near=[0,0,0]}", "support.0.at.near", "[0, 0, 0]", "[x, y]"),
    ("support.0.at={near=[0]}", "support.0.at.near.1", "nothing", "[x, y]"),
    ("support.0.at={near=[0,0],tol=1e-3}", "support.0.at.tol", "0.001", "circle"),
    ("support.0.at={circle=[0,0,0]}", "support.0.at.circle.2", "0", "radius > 0"),
    ("support.0.at={box=[[1,0],[0,1]]}", "support.0.at.box", "[1.0, 0.0]", "x0 <= x1"),
    ("support.0.at={vertices=[]}", "support.0.at.vertices", "[]", "vertex numbers"),
    ("support.0.at={vertices=[-1]}", "support.0.at.vertices.0", "-1", "vertex numbers"),
    ("support.0.at={vertices=[1.5]}", "support.0.at.vertices.0", "1.5", "vertex numbers"),
    ("support.0={fix='x'}", "support.0.at", "nothing", "a selector"),
    ("support.0.name=corner", "driver.0.name", "'corner'", "support.0 has it"),
    ('support.0.name="a,b"', "support.0.name", '"a,b"', "letters, digits"),
    ("driver.1.name=corner", "driver.1.name", "'corner'", "driver.0 has it"),
    ("probe.0.name=A", "probe.1.name", "'A'", "probe.0 has it"),
    ('probe.0.name="a.b"', "probe.0.name", '"a.b"', "letters, digits"),
    ("probe.0.at=[nan,0]", "probe.0.at.0", "nan", "[x, y]"),
    ("driver.0.rotate.axis=[0,0,0]", "driver.0.rotate.axis", "[0.0, 0.0, 0.0]", "not zero"),
    ("driver.0.rotate={axis=[0,0,1]}", "driver.0.rotate.angle", "nothing", "rad"),
    ("driver.0.translate_to=deployed", "driver.0.translate", "translate_to", "either"),
    ("driver.0.translate_to=stowed", "driver.0.translate_to", '"stowed"', '"deployed"'),
    ("driver.0.overstretch=1e-4", "driver.0.overstretch", "0.0001", "translate_to"),
    ("driver.1.overstretch=-1", "driver.1.overstretch", "-1", "> -1"),
    ("driver.0={at={all=true}}", "driver.0", "no motion", "translate, rotate or translate_to"),
    ("driver.0.profile={kind='cubic'}", "driver.0.profile.kind", '"cubic"', '"smooth"'),
    ("driver.0.profile={kind='constant'}", "driver.0.profile", "factor 1", "factor 0 at time 0"),
    ("driver.0.profile={start=-1}", "driver.0.profile", "at time 0", "factor 0 at time 0"),
    ("driver.0.profile={table=[[0,0.5],[1,1]]}", "driver.0.profile", "factor 0.5", "factor 0 at time 0"),
    ("driver.0.profile={table=[[0,0]]}", "driver.0.profile.table", "[0.0]", "two or more rows"),
    ("driver.0.profile={table=[[0,0],[0,1]]}", "driver.0.profile.table", "[0.0, 0.0]", "increasing"),
    ("driver.0.profile={table=[[0,0],[1]]}", "driver.0.profile.table.1.1", "nothing", "rows"),
    ("driver.0.profile={table=[[0,0],[1,1]],end=2}", "driver.0.profile.end", "2", "no end"),
    ("driver.0.profile={start=2,end=2}", "driver.0.profile.end", "start 2.0, end 2.0", "start before end"),
    ("driver.0.profile={start=5}", "driver.0.profile.start", "start 5.0, end 4.0", "start before end"),
    ("load.0.kind=wind", "load.0.kind", '"wind"', '"pressure"'),
    ("load.0={kind='pressure'}", "load.0.value", "nothing", "Pa"),
    ("load.0={kind='pressure',value=1,follower=1}", "load.0.follower", "1", "true or false"),
    ("load.0={kind='force',value=1}", "load.0.value", "1", "[x, y, z], N"),
    ("load.0={}", "load.0.kind", "nothing", '"gravity", "pressure", "force"'),
    ("load.0={kind='gravity'}", "load.0.acceleration", "nothing", "m/s^2"),
    ("load.1.profile={kind='linear'}", "load.1.profile", "unknown key", "value"),
    ("load=3", "load", "3", "[[load]]"),
    ("integrator.spectral_radius=1.1", "integrator.spectral_radius", "1.1", "from 0"),
    ("integrator.tolerance=0", "integrator.tolerance", "0", "> 0"),
    ("integrator.step=0", "integrator.step", "0", '"auto" or a number > 0'),
    ("integrator.step=fast", "integrator.step", '"fast"', '"auto" or a number > 0'),
    ("integrator.constraints=penalty", "integrator.constraints", '"penalty"', '"multipliers"'),
    ("integrator.linear_solver=magic", "integrator.linear_solver", '"magic"', '"scipy"'),
    ("output.fps=0", "output.fps", "0", '"steps"'),
    ("output.fields=[s3]", "--set output.fields", "'[s3]'", "a TOML value"),
    ("output.fields=['s3']", "output.fields.0", '"s3"', "von_mises"),
    ("output.fields=['s1','s1']", "output.fields", "twice", "once"),
    ("driver.2.axes=xy", "--set driver.2.axes=xy", "'2'", "from 0 to 1"),
    ("driver.corner.axes=xy", "--set driver.corner.axes=xy", "'corner'", "from 0 to 1"),
    ("material.thickness.x=1", "--set material.thickness.x", "material.thickness = 0.0005", "tables"),
    ("material.thickness", "--set", "'material.thickness'", "key.path=value"),
]


@pytest.mark.parametrize(("override", "key", "got", "wants"), FAULTS, ids=[fault[0] for fault in FAULTS])
def test_a_fault_is_told_in_one_line_with_key_value_and_expectation(full, override, key, got, wants):
    with pytest.raises(wo.InputError) as caught:
        load_scene(full, [override])
    message = str(caught.value)
    assert "\n" not in message
    assert caught.value.key == key
    assert message.startswith(f"{key}: got ")
    assert got in str(caught.value.got)
    assert wants in caught.value.wants


def test_each_required_key_is_missed():
    required = [("name",), ("analysis", "kind"), ("analysis", "duration"), ("pattern", "kind")]
    required += [("material", key) for key in ("density", "youngs_modulus", "poisson_ratio", "thickness")]
    for path in required:
        values = copy.deepcopy(MINIMAL)
        table = values
        for part in path[:-1]:
            table = table[part]
        del table[path[-1]]
        with pytest.raises(wo.InputError, match="got nothing") as caught:
            wo.Scene(**values)
        assert caught.value.key == ".".join(path)


def test_several_faults_are_told_a_line_each(full):
    with pytest.raises(wo.InputError) as caught:
        load_scene(full, ["material.thickness=0", "driver.1.axes=w"])
    first, second = str(caught.value).split("\n")
    assert first.startswith("material.thickness: got 0")
    assert second.startswith('driver.1.axes: got "w"')


def test_syntax_errors_name_file_and_line(tmp_path):
    path = tmp_path / "broken.toml"
    path.write_text('name = "x"\n[analysis\n')
    with pytest.raises(wo.InputError, match=r"broken\.toml.*line 2"):
        load_scene(path)
    path.write_text('name = "x"\nname = "y"\n')
    with pytest.raises(wo.InputError, match="line 2"):
        load_scene(path)
    path.write_bytes(b'name = "\xff"')
    with pytest.raises(wo.InputError, match="UTF-8"):
        load_scene(path)


@pytest.mark.parametrize(("line", "hint"), [("[[driver]]", True), ("[driver]", True), ("[material]", False)])
def test_tables_that_come_several_times_have_two_brackets(tmp_path, line, hint):
    path = tmp_path / "s.toml"
    first = line.replace("[[", "[").replace("]]", "]")
    path.write_text(f'name = "s"\n{first}\nkind = "x"\n\n{line}\nkind = "y"\n')
    with pytest.raises(wo.InputError, match="line 5") as caught:
        load_scene(path)
    assert ("written [[driver]], with two brackets" in str(caught.value)) == hint


def test_a_key_without_its_table_is_told_where_it_stands():
    with pytest.raises(wo.InputError) as caught:
        load_scene("leaf_in", ["thickness=1e-4"])
    assert caught.value.key == "--set thickness" and "material.thickness=..." in caught.value.wants
    with pytest.raises(wo.InputError, match=r"driver\.0\.translate_to"):
        load_scene("leaf_in", ["translate_to=1"])
    with pytest.raises(wo.InputError, match=r"^colour: got an unknown key"):
        load_scene("leaf_in", ["colour=1"])
    assert load_scene("leaf_in", ["name=other"]).name == "other"


@pytest.mark.parametrize(
    ("given", "meant"),
    [("leafin", "leaf_in"), ("leaf-in.toml", "leaf_in"), ("ikarus", "ikaros"), ("drum", "verification/drum")],
)
def test_unknown_scene_proposes_those_of_a_similar_name(given, meant):
    with pytest.raises(wo.InputError, match=rf"did you mean {meant}( or .*)?\? `warp-origami list`") as caught:
        load_scene(given)
    assert len(str(caught.value)) < 200


def test_fold_file_is_no_scene(tmp_path):
    with pytest.raises(wo.InputError, match=r'kind = "fold", file = "a\.fold".*draw'):
        load_scene(tmp_path / "a.fold")


def test_unknown_scene_names_what_there_is():
    with pytest.raises(wo.InputError, match="bundled scene"):
        load_scene("no_such_scene")
    with pytest.raises(wo.InputError, match=r"'no\.toml'"):
        load_scene("no.toml")
