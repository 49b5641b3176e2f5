"""Whatever an attribute of a package is, of a wrong type it is said with its name."""

import random
import re
import textwrap

import pytest

from rig.assembly import contract_check
from rig.experiment import post_mortem
from rig.hal import ContractBroken

WRONG = (
    "None", "3", "-2.5", "True", "'text'", "b'12'", "[1.0, 2.0]", "(1.0,)", "(1.0,) * 9", "(1j,)",
    "{'a': 1}", "{}", "()", "float('nan')", "float('inf')", "object()", "print", "int", "1j",
    "('a', 'b')", "[None, None]", "(None,) * 4",
)  # fmt: skip
CRANK, CELL, ADDED = (
    ("rig.mechanisms", "crank"),
    ("rig.drivers", "load-cell"),
    ("rig.additions", "pi-for-cylinder"),
)
RUN = ("run", "crank-turns", "--on", "sim", "--no-report")
SHORT = (*RUN, "--set", "reference.speeds=[5 rad/s]", "--set", "approach=50 ms")


def _row(name):
    return f"PARTS = dataclasses.replace(parts.PARTS, {name}=WRONG)"


def _view(name, what="WRONG"):
    return f"class View(mechanism.Crank):\n    {name} = {what}\nPARTS = crank(view='View')"


def _method(name):
    return _view(name, "lambda *_, **__: WRONG")


def _static(name):
    return _view(name, "staticmethod(lambda *_, **__: WRONG)")


def _law(name, what="lambda *_: WRONG"):
    return (
        f"class Odd(laws.CrossCoupled):\n    {name} = {what}\nPARTS = crank_with(controllers='Odd')"
    )


def _motion(name, what):
    return (
        f"class Odd(references.TurningCranks):\n    {name} = {what}\n"
        "class View(mechanism.Crank):\n"
        "    plan = classmethod(lambda cls, s, r, *_: Odd(r, s.rod_zero))\n"
        "PARTS = crank(view='View')"
    )


def _plant(name, what):
    return (
        "from crank_rig.crank import plant\n"
        f"class Odd(plant.CrankPlant):\n    {name} = {what}\n"
        "model = dataclasses.replace(parts.PARTS.plants['crank'], plant=f'{__name__}:Odd')\n"
        "PARTS = dataclasses.replace(parts.PARTS, plants={'crank': model})"
    )


def _cell(name, what):
    return (
        "from crank_rig.load_cell import parts as cell, device as cells\n"
        "from drivers.sim import described_wiring\n"
        f"class Odd(cells.LoadCell):\n    {name} = {what}\n"
        "PARTS = dataclasses.replace(cell.PARTS, device=f'{__name__}:Odd')"
    )


def _cell_settings(name):
    return (
        "from crank_rig.load_cell import parts as cell, settings\n"
        "@dataclasses.dataclass(frozen=True, slots=True)\n"
        f"class Odd(settings.LoadCellSettings):\n"
        f"    def {name}(self, *_, **__):\n        return WRONG\n"
        "PARTS = dataclasses.replace(cell.PARTS, settings=f'{__name__}:Odd')"
    )


def _measure(fields):
    return (
        "from rig.experiment.measure import Measure\n"
        f"TABLE = {{'turning_rms': Measure({fields}), 'rod_twist': Measure(len, 'rad', 'x')}}\n"
        "PARTS = crank_with(measures='TABLE')"
    )


VIRTUAL = tuple("virtual" if word == "sim" else word for word in SHORT)
LIES = "lambda *_, **__: WRONG"
CASES = {
    **{
        f"row.{name}": (CRANK, _row(name), SHORT)
        for name in (
            "mechanism",
            "settings",
            "view",
            "controllers",
            "references",
            "plants",
            "measures",
            "figures",
            "comparisons",
            "procedures",
        )
    },
    **{
        f"view.{name}": (CRANK, _view(name), SHORT)
        for name in ("columns", "law", "stopping_time", "brakes_itself")
    },
    **{
        f"view.{name}()": (CRANK, _static(name), SHORT)
        for name in (
            "assemble",
            "wiring",
            "geometry_of",
            "limits_of",
            "expected_of",
            "unfit",
            "model_of",
            "plan",
            "approach",
            "slow_down",
        )
    },
    **{
        f"view.{name}()": (CRANK, _method(name), SHORT)
        for name in (
            "read",
            "resting_command",
            "energised_command",
            "balanced_command",
            "released_command",
            "blend",
            "limit",
            "row",
            "reference_of",
            "worst_margin",
            "limit_hits",
            "stop_input",
            "pose_held",
            "check",
            "start_limiting",
            "write",
        )
    },
    "view.check, shown": (CRANK, _static("limits_of"), ("check", "crank")),
    "view.expected, shown": (CRANK, _static("expected_of"), ("check", "crank")),
    "law.Settings": (CRANK, _law("Settings", "WRONG"), SHORT),
    "law.update()": (CRANK, _law("update"), SHORT),
    "law.reset()": (CRANK, _law("reset"), SHORT),
    **{
        f"motion.{name}": (CRANK, _motion(name, "WRONG"), SHORT)
        for name in ("duration", "segments", "facts", "waits", "has_torque")
    },
    "motion.at()": (CRANK, _motion("at", LIES), SHORT),
    **{
        f"plant.{name}": (CRANK, _plant(name, "WRONG"), SHORT)
        for name in ("truth_columns", "channel_names", "known_faults")
    },
    **{
        f"plant.{name}()": (CRANK, _plant(name, LIES), SHORT)
        for name in ("truth", "channel_value", "joint_position", "joint_velocity", "joint_torque")
    },
    "device.log_columns": (
        CELL,
        _cell("log_columns", "property(lambda self: WRONG, lambda self, value: None)"),
        VIRTUAL,
    ),
    **{
        f"device.{name}()": (CELL, _cell(name, LIES), VIRTUAL)
        for name in ("log_values", "unsafe", "doubt", "connect", "check", "make_safe", "close")
    },
    **{
        f"settings.{name}()": (CELL, _cell_settings(name), VIRTUAL)
        for name in ("channel_names", "addresses", "describe_nodes", "acts_after")
    },
    "measure()": (CRANK, _measure(f"{LIES}, 'rad', 'x'"), SHORT),
    "measure.unit": (CRANK, _measure("len, WRONG, 'x'"), SHORT),
    "measure.compute": (CRANK, _measure("WRONG, 'rad', 'x'"), SHORT),
}


ELSEWHERE = {
    "row.plants": "no plant is called 'crank'",
    "row.figures": "no figure is called 'rod-twist'",
    "view.assemble()": "the mechanism crank is no rig.hal.mechanism.Mechanism",
    "view.geometry_of()": "the plant crank: crank_rig.crank.plant.CrankPlant cannot be made",
    "view.model_of()": "crank_rig.crank.laws, line",
    "view.plan()": "the motion that the mechanism crank has planned is no",
    "view.write()": "was sent and does not go is",
    "plant.channel_names": "the plant has no channel left, right",
    "plant.joint_position()": "from where it was sent is",
    "plant.joint_velocity()": "drives joint left: it still moves",
    "device.unsafe()": "not made safe: text",
    "measure.unit": "its bound is in rad, turning_rms is in text",
    "measure.compute": "the measure turning_rms (builtins.int)",
}
"""What names it where the type is right, or shows only in what the rest makes of it."""
OWNERS = (
    "the mechanism crank", "entry point 'crank' of rig.mechanisms", "the plant crank", "rod-force:",
)  # fmt: skip
"""Who is named beside the attribute where the class is not."""


def _errors(said):
    """Return what was said without progress, paths and the lines of files that are shown."""
    lines = said[re.search(r"^(error|faulted|failed)", said, re.MULTILINE).start() :].splitlines()
    return [re.sub(r"\S*/\S*", "", line) for line in lines if not line.startswith("    ")]


def is_named(case, said, module):
    """Return whether one of the errors names the attribute that is wrong, or whose it is."""
    attribute = case.partition(",")[0].partition(".")[2].removesuffix("()")
    if case == "view.expected, shown":
        attribute = "expected_of"
    if case == "view.check, shown":
        attribute = "limits_of"
    of_its_owner = rf"(?:{'|'.join(map(re.escape, OWNERS))})[^\n]*\b{attribute}\b"
    return any(
        f"{module}." in line
        or f"{module}:" in line
        or (attribute and re.search(of_its_owner, line))
        or ELSEWHERE.get(case, module) in line
        or (case.startswith(("device.", "settings.")) and "rod-force (node 0x11): " in line)
        for line in _errors(said)
    )


@pytest.mark.parametrize(
    "drawn", [1, pytest.param(6, marks=[pytest.mark.slow, pytest.mark.lengthy])]
)
@pytest.mark.parametrize("case", CASES)
def test_a_wrong_type_is_no_bug_of_ours(plug_in, case, drawn):
    (group, name), code, command = CASES[case]
    for wrong in random.Random(f"{case} {drawn}").sample(WRONG, drawn):
        code_of_it = textwrap.dedent(f"WRONG = {wrong}\n{code}")
        exit_code, said, module = plug_in(group, name, code_of_it, *command)
        is_a_miss = exit_code == 1 and case == "measure()"  # a number that keeps no bound
        if exit_code != 0 and not is_a_miss:
            assert is_named(case, said, module), (wrong, said)


def _blame_the_law(rig, plan, run):
    yield post_mortem._Asked(plan.controller, "update", None, "command")


def _name_another(what, protocol, method, thing, *arguments):
    try:
        return contract_check.ask(what, protocol, method, thing, *arguments)
    except ContractBroken as error:
        raise ContractBroken(str(error).replace(method, "columns")) from None


MUTANTS = {
    **dict.fromkeys(
        ("view.row()", "view.approach()", "view.released_command()", "motion.at()"),
        ("rig.experiment.post_mortem._answers", _blame_the_law),
    ),
    **dict.fromkeys(
        ("view.wiring()", "view.expected_of()", "settings.channel_names()"),
        ("rig.assembly.answers.ask", _name_another),
    ),
    **dict.fromkeys(
        ("row.view", "row.procedures"), ("rig.assembly.rows._whose", lambda point: "a package")
    ),
}


@pytest.mark.parametrize("case", MUTANTS)
def test_a_sentence_that_names_another_is_noticed(plug_in, monkeypatch, case):
    monkeypatch.setattr(*MUTANTS[case])
    (group, name), code, command = CASES[case]
    exit_code, said, module = plug_in(group, name, f"WRONG = 3\n{code}", *command)
    assert exit_code == 2
    assert not is_named(case, said, module), said
