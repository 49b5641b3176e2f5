"""What a plug-in lacks is a sentence with its name, and no bug of this program."""

from types import SimpleNamespace

import pytest

from rig.assembly import registry
from rig.hal import ConfigurationError

MECHANISM, DRIVER, ADDITIONS = (
    ("rig.mechanisms", "crank"),
    ("rig.drivers", "tecno-regulator"),
    ("rig.additions", "pi-for-cylinder"),
)
BARE = "class View(mechanism.Crank):\n"
CASES = {
    "row of the wrong type": (MECHANISM, "PARTS = 3", ("crank", "is a int, not a MechanismParts")),
    "row whose module fails": (MECHANISM, "1 / 0", ("entry point 'crank'", "division by zero")),
    "row that is no Python": (MECHANISM, "def (", ("entry point 'crank'", "invalid syntax")),
    "view in a missing module": (
        MECHANISM,
        "PARTS = dataclasses.replace(parts.PARTS, view='nowhere:View')",
        ("nowhere:View cannot be imported",),
    ),
    "view without plan": (
        MECHANISM,
        "from rig.mechanisms.servo.axes import ServoAxes\n"
        "class View(ServoAxes):\n"
        "    columns = ()\n"
        "    assemble = approach = model_of = classmethod(lambda cls, *_: None)\n"
        "    def row(self, *_):\n        return ()\n"
        "PARTS = crank(view='View')",
        ("mechanism crank", "View", "it has no plan"),
    ),
    "view without columns": (
        MECHANISM,
        f"{BARE}    pass\ndel mechanism.Crank.columns\nPARTS = crank(view='View')",
        ("the mechanism crank", "it has no columns"),
    ),
    "view that is no class": (
        MECHANISM,
        "View = 3\nPARTS = crank(view='View')",
        ("crank", "is a int, and no class"),
    ),
    "settings that are no dataclass": (
        MECHANISM,
        "class Plain:\n    pass\nPARTS = crank(settings='Plain')",
        ("mechanism crank", "Plain is no dataclass"),
    ),
    "law without Settings": (
        MECHANISM,
        "class Bare:\n    pass\nPARTS = crank_with(controllers='Bare')",
        ("Bare.Settings cannot be imported", "no attribute 'Settings'"),
    ),
    "law without update": (
        MECHANISM,
        "class Half:\n    Settings = laws.CrossCoupledSettings\n"
        "    def compile(self): ...\n    def reset(self, state): ...\n"
        "PARTS = crank_with(controllers='Half')",
        ("controller crank/cross-coupled", "Half", "it has no update"),
    ),
    "measures that are no mapping": (
        MECHANISM,
        "TABLE = [1]\nPARTS = crank_with(measures='TABLE')",
        ("measures", "TABLE is a list, and no mapping of names to Measure"),
    ),
    "a figure that is none": (
        MECHANISM,
        "TABLE = {'twist': print}\nPARTS = crank_with(figures='TABLE')",
        ("figures", "'twist'", "no FigureKind"),
    ),
    "motion without segments": (
        MECHANISM,
        "class Way:\n    waits, has_torque, facts, duration = False, True, {}, 1.0\n"
        "    watches, foreseen, see = False, None, print\n    real_time, remarks = False, ()\n"
        "    def at(self, t): ...\n    def attach(self, devices): ...\n"
        f"{BARE}    plan = classmethod(lambda cls, *_: Way())\nPARTS = crank(view='View')",
        ("motion", "the mechanism crank", "it has no segments"),
    ),
    "constructor that raises": (
        MECHANISM,
        f"{BARE}    def __init__(self, *_):\n        raise KeyError('shaft')\n"
        "PARTS = crank(view='View')",
        ("broken_", "line", "KeyError: 'shaft'"),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_mechanism_that_lacks_something(plug_in, case):
    (group, name), code, words = CASES[case]
    exit_code, said, _ = plug_in(group, name, code, "check", "crank-turns")
    assert exit_code == 2, said
    assert [word for word in words if word not in said] == [], said


def test_an_entry_point_to_a_missing_module(plug_in):
    exit_code, said, _ = plug_in(*MECHANISM, "", "check", "crank-turns", value="nowhere.parts:X")
    assert exit_code == 2
    assert "entry point 'crank' of rig.mechanisms" in said
    assert "nowhere" in said


def test_a_driver_without_make_safe(plug_in):
    code = (
        "class Device:\n    def __init__(self, *_, **__): ...\n"
        "    connect = arm = listen = check = doubt = close = log_values = lambda *_: None\n"
        "    log_columns = ()\n"
        "PARTS = dataclasses.replace(tecno.PARTS, device=f'{__name__}:Device')"
    )
    exit_code, said, _ = plug_in(*DRIVER, code, "check", "cylinder-tecno")
    assert exit_code == 2
    assert "driver tecno-regulator" in said
    assert "it has no identity, make_safe, show_in, unsafe, written" in said


def test_an_addition_that_cannot_be_loaded_is_named_where_its_law_is_missed(plug_in):
    exit_code, said, _ = plug_in(*ADDITIONS, "1 / 0", "check", "cylinder-tecno")
    assert exit_code == 2
    assert "'pi-for-cylinder'" in said
    assert "division by zero" in said


def test_a_procedure_without_identify(plug_in):
    code = (
        "from rig.calibration.procedure import Procedure\n"
        "class Half(Procedure):\n    name = title = 'half'\n"
        "PARTS = crank_with(procedures='Half')"
    )
    exit_code, said, _ = plug_in(*MECHANISM, code, "calibrate", "crank")
    assert exit_code == 2
    assert "Half" in said and "it has no identify" in said


def test_a_package_that_is_broken_leaves_other_rigs_alone(plug_in):
    exit_code, said, _ = plug_in(*MECHANISM, "1 / 0", "check", "cylinder-tecno")
    assert exit_code == 0, said


def test_a_measure_of_the_same_name_as_another_mechanisms_is_its_own(plug_in):
    code = (
        "from rig.experiment.measure import Measure\n"
        "TABLE = {name: Measure(len, 'rad', name) for name in"
        " ('turning_rms', 'rod_twist', 'tracking_rms')}\n"
        "PARTS = crank_with(measures='TABLE')"
    )
    assert plug_in(*MECHANISM, code, "check", "crank-turns")[0] == 0
    # In metres, as the cylinder's own is and the crank's is not.
    option = ("--set", "metrics.tracking_rms.max=2 mm")
    assert plug_in(*MECHANISM, code, "check", "tecno-sine", *option)[0] == 0


@pytest.mark.parametrize("wrong", [5, ("a", "b"), len], ids=["number", "pair", "function"])
def test_what_is_no_path_in_a_row_is_said(monkeypatch, wrong):
    """A plant's ``hazards=5``, say."""
    plants = {"crank": SimpleNamespace(hazards=wrong)}
    monkeypatch.setattr(registry, "additions", lambda: [SimpleNamespace(plants=plants)])
    with pytest.raises(ConfigurationError, match=r"where a path, 'module:name', belongs"):
        registry.REGISTRY.hazards("crank")
