"""Every number of every shipped profile, absurd: refused, or listed with why it harms nobody."""

import math
import re
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import get_args, get_type_hints

import pytest

import rig
from rig.assembly import REGISTRY, check_profile
from rig.cli import invoke
from rig.config import load_profile
from rig.config.dump import dump_resolved, plain_of
from rig.experiment.plan import load_plan
from rig.hal import ConfigurationError, RigError

CONFIGS = Path(rig.__file__).parents[1] / "configs"
PROFILES = sorted(path.stem for path in (CONFIGS / "rigs").glob("*.yaml"))
FIRST = ("cylinder", "joint", "arm", "arm-odrive", "legs", "legs-can")

_NOTHING = {"0", "1e-12"}
HARMLESS = [
    (r"(plant|simulation)\..*", {"0", "-v", "1e-12", "1e6 v"},
     "of the simulated world, which hurts nobody; each keeps within its own bounds"),
    (r"controllers\..*", {"0", "-v", "1e-12", "1e6 v"},
     "a law's commands are clipped and its motion watched by limits that are bounded"),
    (r"loop\.cpu", {"0"}, "the first processor"),
    (r"devices\..*\.(serial|vendor|product)", {"0", "1e6 v"}, "a device that is not there"),
    (r"(cylinder|joint)\.regulator_response\.full_scale", {"1e6 v"},
     "ten bar, a regulator's range; the alarm of its share is held to what may be set"),
    (r"devices\..*\.(velocity|acceleration)_units", {"1e6 v"},
     "a drive's own units, of which a turn has millions"),
    (r"devices\..*\.profile_velocity", {"0", "1e-12"}, "the servo draws no profile of its own"),
    (r"devices\..*\.gains\.\w+", {"0"}, "a servo that follows less, which is watched"),
    (r"devices\..*\.preset_offset", {"0", "-v", "1e6 v"},
     "what the device itself must say, which is compared"),
    (r"(cylinder|joint)\.valves\.loop\.learning", _NOTHING,
     "nothing is learnt of a valve, or hardly; more than a bound is refused"),
    (r"loop\.priority", {"0"}, "no real-time priority, which the loop says"),
    (r"loop\.safe_within", _NOTHING, "a rig that takes any time to be safe is told to have failed"),
    (r"buses\..*\.max_refused", {"0"}, "the first refused frame is a fault"),
    (r"buses\..*\.turnaround", _NOTHING, "a load that is counted a little too small"),
    (r"devices\..*\.(voltage\.0|profile_acceleration)", _NOTHING, "the drive's own bound holds"),
    (r"devices\..*\.(sub|node|axis|index|id)", {"0", "-v"}, "it does not answer"),
    (r"devices\..*\.monitor\.(raw|voltage|current|pressure)\.0", _NOTHING | {"-v"},
     "another scale, which calibration finds; counts and signal still rise"),
    (r"devices\..*\.setpoint\.(raw|voltage|current|pressure)\.0", _NOTHING | {"-v"},
     "another scale, which calibration finds; counts and signal still rise"),
    (r"devices\..*\.(wire_break|overtravel|response|vented|turnaround)", _NOTHING,
     "the narrowest that an alarm can be, or none is needed"),
    (r"devices\..*\.(offset|zero|x|y|z|translation|rotation|position|orientation)(\.\d+)*",
     _NOTHING | {"-v"}, "another zero, which calibration finds"),
    (r"devices\..*\.limits\.\d", _NOTHING | {"-v"}, "less room to move"),
    (r"devices\..*\.(intrinsics\.\w+|latency|dark_level|position_\w+\.\d|rotation_\w+\.\d)",
     _NOTHING | {"-v"}, "another camera: it disagrees with the encoders, which is a fault"),
    (r"devices\..*\.stop_contact\.bit", {"0"}, "another input of the drive"),
    (r"(arm|joint|legs)\.(geometry|metrology|wire_offsets|jig)\..*", _NOTHING | {"-v"},
     "another drawing of the mechanism, of lengths that are bounded"),
    (r".*\.(tilt_excess|seat_margin|grace|time)", _NOTHING, "the narrowest that an alarm can be"),
    (r".*\.(base_pressure|coulomb|viscous|breakaway|dead_volume|dead_time|monitor_time|spread|ball|ring|wire)",
     _NOTHING, "a model without it: alarms become narrower"),
    (r"(cylinder|joint)\.valves\.(supply\.critical_ratio|loop\.(lag|preview)|nominal\.\w+)",
     _NOTHING | {"-v"}, "another valve, which calibration finds; the pressures' alarms watch it"),
    (r".*\.(pressure|position|tension|position_min|position_max)\.\d", _NOTHING, "less room"),
    (r"legs\.cell_inset", _NOTHING, "load cells at the sole's very edge"),
    (r"devices\..*\.cells\.\w+\.(raw|force)\.\d", _NOTHING | {"-v"},
     "another scale: a foot that weighs what the legs do not is disbelieved"),
    (r"devices\..*\.(roll_zero|pitch_zero)", _NOTHING | {"-v"}, "another zero"),
    (r"legs\.stabiliser\.(recovery|shift)", _NOTHING, "a stabiliser that moves nothing"),
    (r"legs\.stabiliser\.response", _NOTHING, "no averaging: the shift and its rate are bounded"),
    (r"legs\.sag\.fade", _NOTHING, "brought in within a cycle, at no more than the joints' rate"),
]  # fmt: skip


KEYS = {"settings": ()}
"""What stands under another key in a file than in the loaded profile: of a device, beside it."""
NO_SETTINGS = ("provenance", "replaced", "uncalibrated", "calibration", "tunings")


EXPERIMENTS = sorted(path.stem for path in (CONFIGS / "experiments").glob("*.yaml"))
HARMLESS_MOTIONS = [
    (r"metrics\..*\.(min|max)", {"0", "-v", "1e-12", "1e6 v"},
     "a bound that is always or never missed, which the report shows beside the value"),
    (r"reference\..*", {"0", "-v", "1e-12"},
     "another way, or none: every motion is held to the rig's limits before it begins"),
    (r"reference\.direction\.\d", {"1e6 v"}, "where it points counts, not how long it is"),
    (r"reference\.tones\.\d+\.laps", {"1e6 v"}, "reference.laps counts where it is said"),
    (r"approach", {"0"}, "the reference begins where the rig is"),
]  # fmt: skip


def leaves(value, path=()):
    """Yield the path and value of every number."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            if key not in ("provenance", "replaced"):
                yield from leaves(item, (*path, str(key)))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path, value


def unset(settings, path=()):
    """Yield the path, and a number in the place of the value, of every number that is left out."""
    if isinstance(settings, dict | list | tuple):
        for key, item in settings.items() if isinstance(settings, dict) else enumerate(settings):
            yield from unset(item, (*path, str(key)))
    elif is_dataclass(settings):
        hints = get_type_hints(type(settings))
        for field in fields(settings):
            value, name = getattr(settings, field.name), KEYS.get(field.name, (field.name,))
            if field.name == "mechanism_settings":
                name = (settings.mechanism,)
            if value is None and (whole := {int, float} & set(get_args(hints[field.name]))):
                yield (*path, *name), 1 if int in whole else 1.0
            elif field.name not in NO_SETTINGS:
                yield from unset(value, (*path, *name))


def absurd(value):
    """Yield what a number is set to, and what that is called."""
    whole = isinstance(value, int)
    for name, other in (("0", 0), ("-v", -value), ("1e-12", 1e-12), ("1e6 v", 1_000_000 * value),
                        ("1e12", 1e12), ("1e300", 1e300), ("inf", math.inf)):  # fmt: skip
        if other != value:
            text = ".inf" if other == math.inf else repr(other)
            yield name, str(int(other)) if whole and name in ("0", "-v", "1e6 v") else text


@cache
def search():
    return (CONFIGS,)


def is_listed(name, how):
    return any(re.fullmatch(pattern, name) and how in hows for pattern, hows, _ in HARMLESS)


def accepted(profile, folder):
    """Return the settings that are accepted though they are not listed."""
    loaded = load_profile(profile, REGISTRY, (), search())
    file = folder / "resolved.yaml"
    file.write_text(dump_resolved(loaded))
    found = []
    for path, value in (*leaves(plain_of(loaded)), *unset(loaded)):
        for how, text in absurd(value):
            name = ".".join(path)
            try:
                check_profile(load_profile(file, REGISTRY, (f"{name}={text}",), search()))
            except RigError as error:
                assert isinstance(error, ConfigurationError) and str(error)
            else:
                if not is_listed(name, how):
                    found.append(f"{name} = {text} ({how} of {value})")
    return found


@pytest.mark.parametrize("profile", FIRST[:1])
def test_an_absurd_number_of_the_smallest_rig_is_refused(profile, tmp_path):
    assert accepted(profile, tmp_path) == []


def taken(experiment):
    """Return the settings of an experiment that are taken though they are not listed."""
    found = []
    for path, value in leaves(plain_of(load_plan(experiment, [], configs=CONFIGS).experiment)):
        for how, text in absurd(value):
            name = ".".join(path)
            try:
                load_plan(experiment, [f"{name}={text}"], configs=CONFIGS)
            except RigError as error:
                assert isinstance(error, ConfigurationError) and str(error)
            else:
                if not any(re.fullmatch(pattern, name) and how in hows
                           for pattern, hows, _ in HARMLESS_MOTIONS):  # fmt: skip
                    found.append(f"{name} = {text} ({how} of {value})")
    return found


def test_an_absurd_number_of_a_motion_is_refused():
    assert taken("cylinder-sine") == []


@pytest.mark.parametrize("frequency", [100, 500, 1000, 2000, 123_456])
def test_a_motion_faster_than_its_limit_is_refused_though_it_stands_in_every_cycle(frequency):
    for experiment, rounds in (("cylinder-sine", "periods"), ("joint-circle", "laps")):
        tone = f"reference.tones=[{{frequency: {frequency} Hz, {rounds}: 50}}]"
        with pytest.raises(ConfigurationError, match=r"moves at .* limits\.speed"):
            load_plan(experiment, [tone, "metrics={}"], configs=CONFIGS)


def test_rounds_by_the_million_are_refused():
    with pytest.raises(ConfigurationError, match=r"a rod moves at .* limits\.speed is 0\.5 m/s"):
        load_plan("joint-range", ["reference.turns=8000000"], configs=CONFIGS)


@pytest.mark.slow
@pytest.mark.lengthy
@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_an_absurd_number_of_any_shipped_motion_is_refused(experiment):
    assert taken(experiment) == []


@pytest.mark.slow
@pytest.mark.sampled(4)
@pytest.mark.parametrize("profile", PROFILES)
def test_an_absurd_number_of_any_shipped_rig_is_refused(profile, tmp_path):
    assert accepted(profile, tmp_path) == []


def test_every_reason_is_one():
    assert all(len(why) > 8 for _, _, why in HARMLESS)
    assert not any("1e12" in hows or "1e300" in hows or "inf" in hows for _, hows, _ in HARMLESS)


@pytest.mark.parametrize(
    ("setting", "words"),
    [("limits.speed=9 m/s", "limits.speed.*could never trip, as no more than"),
     ("limits.following=60 mm", "limits.following.*could never trip"),
     ("limits.mismatch=7 cm", "limits.mismatch.*could never trip"),
     ("alarms.pressure.deviation=500 kPa", "alarms.pressure.deviation.*could never trip"),
     ("alarms.pressure.offset=0.7 MPa", "alarms.pressure.offset.*could never trip"),
     ("alarms.frozen.distance=60 mm", "alarms.frozen.distance.*could never trip"),
     ("bore=16", "bore is 16, expected at most 500 mm"),
     ("limits.reading_age=2 s", "reading_age is '2 s', expected at most 1 s")],
)  # fmt: skip
def test_an_alarm_that_could_never_trip_is_told(setting, words):
    with pytest.raises(ConfigurationError, match=words):
        load_profile("cylinder", REGISTRY, (f"cylinder.{setting}",), search())


@pytest.mark.parametrize(
    ("rig", "device"),
    [("arm", "drives"), ("arm-odrive", "drives"), ("legs", "servos"), ("legs-can", "right-leg")],
)
def test_a_serial_number_for_several_drives_is_a_sentence(rig, device, capsys):
    assert invoke(["check", rig, "--set", f"devices.{device}.serial=5"]) == 2
    assert f"error: {device}: " in capsys.readouterr().err


@pytest.mark.parametrize("gear", ["5e-324", "1e-300", "1e300"])
def test_a_gear_that_is_none_is_refused(gear):
    setting = f"devices.drives.joints.q1.gear={gear}"
    with pytest.raises(ConfigurationError, match=r"gear is .*, expected at (least|most)"):
        load_profile("arm-odrive", REGISTRY, (setting,), search())
