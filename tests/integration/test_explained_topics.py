"""Every fault and every refusal that the program raises has a topic, and each says what to do."""

import ast
import re
from pathlib import Path

import pytest
from explained import said

import rig
from rig.cli.command_table import COMMANDS
from rig.cli.commands import invoke
from rig.explaining.faults import fault_topics, refusal_of, refusal_topics, topic_of

ROOT = Path(rig.__file__).parents[1]
FAULTS = {
    "DeviceFault", "ConnectionFailed", "LimitExceeded", "SafetyError", "StaleReading",
    "EmergencyStop", "LoopStalled",
}  # fmt: skip
REFUSALS = {
    "InfeasibleMotion", "ConfigurationError", "ProfileError", "OutOfRange", "TooShort",
    "CalibrationRefused",
}  # fmt: skip
CONFIGS = ["--configs", str(ROOT / "configs")]


def test_every_topic_says_what_a_person_needs():
    names = [topic.name for topic in (*fault_topics(), *refusal_topics())]
    assert len(names) == len(set(names))
    for topic in (*fault_topics(), *refusal_topics()):
        for label, text in topic.remarks():
            assert text.strip(), (topic.name, label)
        for name in re.findall(r"`rig (\w+)", " ".join(text for _, text in topic.remarks())):
            assert name in COMMANDS, topic.name


def sentences(path, kinds=FAULTS):
    """Return the longest literal text of each fault that a file raises, and its line."""
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.Call) or getattr(node.func, "id", "") not in kinds:
            continue
        whole = "".join(
            part.value if isinstance(part, ast.Constant) else "X"
            for argument in node.args
            if isinstance(argument, ast.Constant | ast.JoinedStr)
            for part in (argument.values if isinstance(argument, ast.JoinedStr) else [argument])
            if not isinstance(part, ast.Constant) or isinstance(part.value, str)
        )
        told = whole.partition("[")[0]
        if len(re.findall("[a-z]{2,}", told)) > 2:  # else it is put together from parts
            yield node.lineno, told


@pytest.mark.parametrize(
    ("message", "kind"),
    [
        ("drives joint q3 (node 0x03): the drive left OPERATION ENABLED by itself: status word "
         "0x0260 (SWITCH ON DISABLED) [object 0x6041:00]", "torque_off"),
        ("axes joint q2 (node 0x02): the axis left its closed loop by itself: idle", "torque_off"),
        ("servos (node 0x0A): left_knee (id 10) does not get its setpoints, or gets them late "
         "[object Goal Position (116), value -1 counts behind]", "setpoints_lost"),
        ("drives joint q3: the drive reports a following error: following error too large "
         "(0x8611)", "following"),
        ("drives joint q3: the drive reports a fault: following error too large (0x8611)",
         "following"),
        ("drives joint q3: the drive left its mode of operation, status word 0x0237 [value mode "
         "1, bound mode 8 (csp)]", "wrong_mode"),
        ("servos: left_hip_roll (id 8) jumped; somebody moved its zero, or the joint was struck "
         "[object Present Position (132), bound 0.0531 rad in 5.0 ms]", "struck"),
    ],
)  # fmt: skip
def test_what_drives_say_has_a_kind_of_its_own(message, kind):
    """These are put together by drivers from parts, which no search for sentences finds."""
    assert topic_of(message).name == kind


def test_every_fault_that_the_program_raises_has_a_topic():
    untold = [
        f"{path.relative_to(ROOT)}:{line}: {text}"
        for folder in ("drivers", "rig/mechanisms", "rig/runtime", "rig/assembly")
        for path in sorted((ROOT / folder).rglob("*.py"))
        if "sim" not in path.relative_to(ROOT).parts
        for line, text in sentences(path)
        if topic_of(text) is None
    ]
    assert untold == []


def test_every_refusal_that_the_program_raises_has_a_topic():
    untold = [
        f"{path.relative_to(ROOT)}:{line}: {text}"
        for folder in ("controllers", "drivers", "rig")
        for path in sorted((ROOT / folder).rglob("*.py"))
        for line, text in sentences(path, REFUSALS)
        if refusal_of(text) is None
    ]
    assert untold == []


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        (["run", "cylinder-sin"], "no_such_name"),
        (["run", "cylinder", "--on", "sim"], "no_such_name"),
        (["report", "no-such-run"], "no_such_name"),
        (["calibrate", "cylinder", "no-such-procedure"], "no_such_name"),
        (["check", "cylinder-sine", "--set", "reference.amplitud=2 mm"], "unknown_key"),
        (["check", "cylinder-sine", "--set", "reference.amplitude=2 s"], "unit"),
        (["check", "cylinder-sine", "--set", "loop.rate=-5 Hz"], "beyond_bounds"),
        (["check", "cylinder-sine", "--set", "reference.amplitude=200 mm"], "beyond_bounds"),
        (["check", "cylinder", "--set", "loop.rate=5 kHz"], "bus_load"),
        (["export", "run", "--format", "xls"], "wrong_option"),
        (["sweep", "cylinder-sine"], "wrong_option"),
        (["new", "rig", "cylinder"], "name_taken"),
        (["run", "cylinder-sine", "--on", "sim", "--runs", "/proc/none"], "unwritable"),
        (["check", "arm-elbow-turnback", "--set", "reference.speed=9 m/s"], "too_fast"),
        (["check", "arm-path", "--set", "reference.points=[[9 m,0 m,0 m],[8 m,0 m,0 m]]"],
         "arm_reach"),
        (["check", "arm-path", "--set", "law=dls", "--set", "reference.speed=1e-9 m/s"],
         "beyond_bounds"),
        (["check", "legs-walk", "--set", "reference.step=300 mm"], "leg_reach"),
        (["check", "legs-walk", "--set", "reference.sway=0.1"], "tips_over"),
        (["check", "legs-walk", "--set", "reference.speed=80"], "too_fast"),
        (["check", "legs-stairs", "--set", "reference.lift=8 mm"], "foot_scrapes"),
    ],
)  # fmt: skip
def test_what_is_refused_is_explained_in_the_words_that_it_was_told_in(capsys, words, kind):
    code = invoke([*words, *([] if words[0] in ("report", "export") else CONFIGS)])
    message = capsys.readouterr().err
    assert code == 2, message
    assert refusal_of(message).name == kind, message
    error = next(line for line in message.splitlines() if line.lower().startswith("error:"))
    code, out, _ = said(capsys, error)
    assert code == 0 and out.startswith("kind: ")
    assert all(f"\n{label}: " in out for label in ("means", "causes", "check", "mend"))


@pytest.mark.parametrize(
    ("message", "kind"),
    [
        ("pair force is limited", "limited"),
        ("valves: the valve of ch2 is stuck or off, or its monitor is off [ch2", "regulator_stuck"),
        ("regulators: the regulator of ch2 is stuck, slow or off, or its [ch2", "regulator_stuck"),
        (
            "regulators: the chamber of antagonist leaks behind its tube, or its monitor is off, "
            "or the carriage is pushed or held: 9 N are not those of the pressures",
            "pulls_disagree",
        ),
        (
            "the last second fits best: chamber of antagonist: it pulls as with 128 kPa less than "
            "its monitor says; it leaks behind its tube, or the monitor is off",
            "pulls_disagree",
        ),
        (
            "way of the pair ch1, ch3 that nothing pushes is 3 mm, outside -3 … 3 mm",
            "moves_unasked",
        ),
        ("way of the rod of ch2 while nothing controls it is 4 mm", "moves_unasked"),
        (
            "following error of the rod of ch1 that its own motion brought about is 6.04 mm, "
            "outside -6 … 6 mm",
            "following",
        ),
        (
            "the pair was up to 7.3 mm off its reference, beyond the 4 mm of `limits.following`, "
            "for less than 0.3 s",
            "following",
        ),
        (
            "the wire of ch2 or the wire of ch4 is caught, or encoder-2 or encoder-4 is off",
            "wires_disagree",
        ),
        ("can0: the controller went bus-off [value bus-off]", "bus_off"),
        ("can0: the controller is error passive; look at cable and termination", "bus_off"),
        ("drive (node 0x21): EMCY 0x8140 (recovered from bus-off)", "emergency_message"),
    ],
)
def test_a_message_of_events_and_runs_has_its_kind(capsys, message, kind):
    code, out, _ = said(capsys, message)
    assert code == 0
    assert out.startswith(f"kind: {kind}\n")
    assert all(f"\n{label}: " in out for label in ("means", "causes", "check", "mend"))
