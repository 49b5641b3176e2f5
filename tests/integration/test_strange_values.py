"""What a package offers may be of the right type and still not be usable: said with its name."""

import json
import random
import shutil
from pathlib import Path

import pytest
from broken_package import CONFIGS, GOOD

CRANK, CELL = ("rig.mechanisms", "crank"), ("rig.drivers", "load-cell")
RUN = ("run", "crank-turns", "--on", "sim", "--set", "reference.speeds=[5 rad/s]")
SHORT = (*RUN, "--no-report")


def manifest():
    (path,) = Path("runs").glob("*/manifest.json")
    return json.loads(path.read_text())


def law(body):
    return (
        "class Odd(laws.CrossCoupled):\n"
        "    def update(self, state, reference):\n"
        f"        if state.t > {random.Random(body).uniform(0.1, 2.0)}:\n"
        f"            {body}\n"
        "        return super().update(state, reference)\n"
        "PARTS = crank_with(controllers='Odd')"
    )


@pytest.mark.parametrize("raised", ["SystemExit(0)", "SystemExit('enough')", "KeyboardInterrupt"])
def test_a_law_that_wants_to_end_the_program_ends_the_run_safe(plug_in, raised):
    exit_code, said, module = plug_in(*CRANK, law(f"raise {raised}"), *SHORT)
    assert exit_code == 2
    assert f"{module}, line" in said and "wants to end the program" in said
    ended = manifest()
    assert ended["status"] == "crashed" and module in ended["message"]
    (events,) = Path("runs").glob("*/events.jsonl")
    kinds = {json.loads(line)["kind"] for line in events.read_text().splitlines()}
    assert "unsafe" not in kinds


@pytest.mark.parametrize(
    ("returned", "wanted"),
    [
        ("[1.0, 2.0]", "CrankCommand"),
        ("None", "CrankCommand"),
        ("reference._replace(positions=(1j, 0.0))", "CrankCommand"),
        ("reference.positions", "CrankCommand"),
    ],
)
def test_a_command_of_another_shape_names_the_law(plug_in, returned, wanted):
    exit_code, said, module = plug_in(*CRANK, law(f"return {returned}"), *SHORT)
    assert exit_code == 2
    assert f"{module}.Odd.update returned" in said and f"and no {wanted}" in said
    assert manifest()["exit_code"] == 2


@pytest.mark.parametrize(
    "row",
    ["super().row(*all)[:-1]", "(*super().row(*all), 1.0)", "list(map(str, super().row(*all)))"],
)
def test_a_row_of_another_shape_names_the_mechanism(plug_in, row):
    code = (
        f"class View(mechanism.Crank):\n    def row(self, *all):\n        return {row}\n"
        "PARTS = crank(view='View')"
    )
    exit_code, said, module = plug_in(*CRANK, code, *SHORT)
    assert exit_code == 2
    assert f"{module}.View.row returned" in said and "tuple of 18 numbers" in said


def test_a_truth_of_another_length_names_the_plant(plug_in):
    code = (
        "from crank_rig.crank import plant\n"
        "class Odd(plant.CrankPlant):\n    truth = lambda self: (1.0,)\n"
        "model = dataclasses.replace(parts.PARTS.plants['crank'], plant=f'{__name__}:Odd')\n"
        "PARTS = dataclasses.replace(parts.PARTS, plants={'crank': model})"
    )
    exit_code, said, module = plug_in(*CRANK, code, *SHORT)
    assert exit_code == 2
    assert f"{module}.Odd.truth returned (1.0,), and no tuple of 3 numbers" in said


@pytest.mark.parametrize("length", [0, 2])
def test_log_values_of_another_length_name_the_device(plug_in, length):
    code = (
        "from crank_rig.load_cell import device as cells, parts as cell\n"
        f"class Odd(cells.LoadCell):\n    log_values = lambda self: (0.5,) * {length}\n"
        "PARTS = dataclasses.replace(cell.PARTS, device=f'{__name__}:Odd')"
    )
    command = ("virtual" if word == "sim" else word for word in SHORT)
    exit_code, said, module = plug_in(*CELL, code, *command)
    assert exit_code == 2
    assert f"{module}.Odd.log_values returned" in said and "tuple of 1 numbers" in said


def test_a_unit_that_does_not_exist_is_named_with_its_key(plug_in):
    code = (
        "from typing import Annotated\nfrom annotated_types import Unit\n"
        "from crank_rig.crank import settings\n"
        "@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)\n"
        "class Odd(settings.CrankSettings):\n    arm: Annotated[float, Unit('furlong')] = 1.0\n"
        "PARTS = crank(settings='Odd')"
    )
    exit_code, said, module = plug_in(*CRANK, code, "check", "crank")
    assert exit_code == 2
    assert f"{module}:Odd: Odd.arm: 'furlong' is not a unit" in said


MEASURE = (
    "from rig.experiment.measure import Measure\n"
    "TABLE = {{'turning_rms': Measure({compute}, 'rad', 'x'),"
    " 'rod_twist': Measure(lambda _: 0.0, 'rad', 'x')}}\n"
    "PARTS = crank_with(measures='TABLE')"
)


def test_a_measure_that_is_no_number_keeps_no_bound(plug_in):
    code = MEASURE.format(compute="lambda windows: float('nan')")
    assert plug_in(*CRANK, code, *SHORT)[0] == 1
    (path,) = Path("runs").glob("*/metrics.json")
    (first, second) = json.loads(path.read_text())["metrics"]
    assert (first["value"], first["pass"]) == (None, False)
    assert second["pass"]


@pytest.mark.parametrize("ask", ["column('reading.torsion')", "columns('reading.torsion_')"])
def test_a_column_that_no_run_records_is_said_before_it_moves(plug_in, ask):
    code = MEASURE.format(compute=f"lambda windows: windows[0].{ask}.max()")
    exit_code, said, module = plug_in(*CRANK, code, "check", "crank-turns")
    assert exit_code == 2
    assert "turning_rms" in said and module in said and "reading.torsion" in said
    assert not Path("runs").exists()


@pytest.mark.parametrize("seconds", ["inf", "nan", "-1e-3", "1e9", "-inf"])
def test_a_motion_without_an_end_is_refused_at_the_check(plug_in, seconds):
    code = (
        f"class Odd(references.TurningCranks):\n    duration = float('{seconds}')\n"
        "class View(mechanism.Crank):\n"
        "    plan = classmethod(lambda cls, s, r, *_: Odd(r, s.rod_zero))\n"
        "PARTS = crank(view='View')"
    )
    exit_code, said, module = plug_in(*CRANK, code, "check", "crank-turns")
    assert exit_code == 2
    assert f"{module}.Odd.duration is {float(seconds):g} s" in said


def test_a_segment_beyond_the_end_is_refused_at_the_check(plug_in):
    late = random.Random(7).uniform(20.0, 90.0)
    code = (
        "from rig.hal import Segment\n"
        f"class Odd(references.TurningCranks):\n    segments = (Segment('late', 1.0, {late}),)\n"
        "class View(mechanism.Crank):\n"
        "    plan = classmethod(lambda cls, s, r, *_: Odd(r, s.rod_zero))\n"
        "PARTS = crank(view='View')"
    )
    exit_code, said, _ = plug_in(*CRANK, code, "check", "crank-turns")
    assert exit_code == 2
    assert f"'late' lasts from 1 to {late:g} s" in said


@pytest.mark.parametrize("name", ["crank", "cylinder"])
def test_a_name_that_two_packages_took_fails_where_it_is_used(plug_in, name):
    also = (("rig.mechanisms", name, "crank_rig.crank.parts:PARTS"),)
    using, other = ("crank", "cylinder-tecno") if name == "crank" else ("cylinder-tecno", "crank")
    exit_code, said, _ = plug_in(*CELL, "", "check", using, value=GOOD_CELL, also=also)
    assert exit_code == 2
    assert f"the name {name!r} is taken twice" in said
    assert said.count("entry point") + said.count("this program") == 2
    assert plug_in(*CELL, "", "check", other, value=GOOD_CELL, also=also)[0] == 0


GOOD_CELL = "crank_rig.load_cell.parts:PARTS"


NAME_MORE = ("--set", "additions=[more]")


def test_additions_of_one_name_concern_who_names_them(plug_in):
    code = "PARTS = Additions(mechanism='cylinder', controllers={'third': 'x:Y'})"
    twice = (("rig.additions", "more", "crank_rig.extras.parts:FOR_ARM"),)
    added = ("rig.additions", "more", code)
    assert plug_in(*added, "check", "tecno-sine", also=twice)[0] == 0
    exit_code, said, _ = plug_in(*added, "check", "crank", *NAME_MORE, also=twice)
    assert exit_code == 2
    assert "the name 'more' is taken twice" in said


def test_a_measure_that_two_packages_have_fails_where_it_is_used(plug_in):
    code = (
        "from rig.experiment.measure import Measure\n"
        "TABLE = {'rod_twist': Measure(lambda _: 0.0, 'rad', 'x')}\n"
        "PARTS = Additions(mechanism='crank', measures=(f'{__name__}:TABLE',))"
    )
    more = ("rig.additions", "more", code)
    exit_code, said, module = plug_in(*more, "check", "crank-turns", *NAME_MORE)
    assert exit_code == 2
    assert "two packages have a measure 'rod_twist'" in said
    assert module in said and "CRANK_MEASURES" in said
    assert plug_in(*more, "check", "crank-turns")[0] == 0
    assert plug_in(*more, "check", "crank", *NAME_MORE)[0] == 0
    without = (*NAME_MORE, "--set", "metrics.rod_twist=null")
    assert plug_in(*more, "check", "crank-turns", *without)[0] in (0, 2)


@pytest.mark.parametrize(
    ("mechanism", "path", "code"),
    [
        ("crank", "crank_rig.crank.calibration:RodZero", "class Odd(RodZero):\n    pass"),
        ("cylinder", "rig.mechanisms.cylinder.calibration.procedures:leak", "Odd = leak"),
    ],
)
def test_a_procedure_that_two_packages_have_is_refused(plug_in, mechanism, path, code):
    module, _, name = path.partition(":")
    rig = "cylinder-tecno" if mechanism == "cylinder" else mechanism
    code = (
        f"from {module} import {name}\n{code}\n"
        f"PARTS = Additions(mechanism={mechanism!r}, procedures=(f'{{__name__}}:Odd', PATH))"
    )
    more = ("rig.additions", "more")
    name = ("--set", f"additions=[more{', pi-for-cylinder' if mechanism == 'cylinder' else ''}]")
    for asked in (name, ("--all", *name), ("of-its-own", *name)):
        exit_code, said, mine = plug_in(*more, f"PATH = {path!r}\n{code}", "calibrate", rig, *asked)
        assert exit_code == 2
        assert (
            f"two packages have a procedure {PROCEDURES[mechanism]!r}: {path} and {mine}:Odd"
            in said
        )
    assert plug_in(*more, f"PATH = {path!r}\n{code}", "check", rig, *name)[0] == 0
    same = code.replace("f'{__name__}:Odd', PATH", "PATH,")
    exit_code, said, _ = plug_in(*more, f"PATH = {path!r}\n{same}", "calibrate", rig, *name)
    assert exit_code == 0, said


PROCEDURES = {"crank": "rod-zero", "cylinder": "leak"}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("values={'rod_zero': '3 furlong'}", "'furlong' is not a unit"),
        ("values={'rod_zero': '3 mm'}", "is not in rad"),
        ("values={'rod_zreo': '3 mrad'}", "unknown key 'rod_zreo'"),
        ("unit='furlong'", "'furlong' is not a unit"),
        ("target='crnak'", "did you mean crank"),
    ],
)
def test_what_the_profile_does_not_take_is_no_calibration(plug_in, tmp_path, change, words):
    folder = tmp_path / "configs"
    shutil.copytree(CONFIGS, folder, ignore=shutil.ignore_patterns("calibration", "commissioning"))
    code = (
        "from crank_rig.crank import calibration\n"
        "class Odd(calibration.RodZero):\n    def identify(self, *all):\n"
        f"        return [f._replace({change}) for f in super().identify(*all)]\n"
        "PARTS = crank_with(procedures='Odd')"
    )
    command = ("calibrate", "crank", "rod-zero", "--yes", "--on", "sim")
    exit_code, said, module = plug_in(*CRANK, code, *command, configs=folder)
    assert exit_code == 2
    assert f"{module}.Odd.identify" in said and words in said
    assert not (folder / "calibration").exists()


def test_a_rig_without_procedures_says_so(plug_in):
    code = "PARTS = dataclasses.replace(parts.PARTS, procedures=())"
    exit_code, said, _ = plug_in(*CRANK, code, "calibrate", "crank")
    assert exit_code == 0
    assert "there is no procedure for crank" in said


def test_a_channel_that_the_plant_has_not_is_refused(plug_in):
    option = ("--set", "devices.rod-force.measures=rood")
    exit_code, said, _ = plug_in(*CELL, "", *SHORT, *option, value=GOOD_CELL)
    assert exit_code == 2
    assert "rod-force: the plant has no channel rood; it has left, right, rod" in said


def test_a_figure_that_fails_is_named_and_the_others_are_drawn(plug_in):
    code = (
        "from crank_rig.crank import figures\nfrom rig.report.figure import FigureKind\n"
        "def draw(run):\n    return 1 / 0\n"
        "TABLE = {**figures.CRANK_FIGURES, 'broken': FigureKind(draw, 'never seen')}\n"
        "PARTS = crank_with(figures='TABLE')"
    )
    command = (*RUN, "--set", "figures=[broken, twist]")
    exit_code, said, module = plug_in(*CRANK, code, *command)
    sentence = f"the figure broken ({module}.draw) cannot be drawn: ZeroDivisionError"
    assert exit_code == 0
    assert sentence in said
    (page,) = Path("runs").glob("*/report.html")
    assert sentence in page.read_text()
    assert "Twist of the rod" in page.read_text()
    assert (page.parent / "figures" / "twist.png").exists()


def test_a_fact_that_is_no_number_is_refused(plug_in):
    code = (
        "from rig.hal.motion import Fact\n"
        "class Odd(references.TurningCranks):\n"
        "    facts = {'turns': Fact(float('nan'), '', '')}\n"
        "class View(mechanism.Crank):\n"
        "    plan = classmethod(lambda cls, s, r, *_: Odd(r, s.rod_zero))\n"
        "PARTS = crank(view='View')"
    )
    exit_code, said, module = plug_in(*CRANK, code, "check", "crank-turns")
    assert exit_code == 2
    assert f"{module}.Odd.facts: 'turns' is not a number" in said


def test_a_package_that_is_not_installed_is_asked_for(plug_in, monkeypatch):
    exit_code, said, _ = plug_in(*CELL, "", "check", "crank", value="nowhere:PARTS")
    assert exit_code == 2
    assert "entry point 'load-cell' of rig.drivers" in said
    monkeypatch.setitem(GOOD, "rig.mechanisms", {})
    exit_code, said, _ = plug_in("rig.additions", "more", EMPTY, "check", "crank")
    assert exit_code == 2
    assert "no mechanism is called 'crank'" in said
    assert "is the package installed that it is of?" in said


EMPTY = "PARTS = Additions(mechanism='cylinder')"


@pytest.mark.parametrize("seconds", ["inf", "nan", "-0.5", "1e4"])
def test_a_stop_that_never_ends_is_refused_at_the_check(plug_in, seconds):
    code = (
        f"class View(mechanism.Crank):\n    stopping_time = float('{seconds}')\n"
        "PARTS = crank(view='View')"
    )
    exit_code, said, module = plug_in(*CRANK, code, "check", "crank-turns")
    assert exit_code == 2
    assert f"{module}.View.stopping_time is {float(seconds):g} s" in said
