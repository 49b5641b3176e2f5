"""Thousands of broken profiles: each loads or is refused with a located error."""

import random

import pytest
from config_fakes import CALIBRATION, EXPERIMENT, PROFILE

from rig.config.dump import dump_resolved
from rig.hal import ConfigurationError

VALUES = [
    "", "~", "true", "yes", "on", "-1", "0", "1e308", "-1e308", "1e999", ".nan", ".inf", "9" * 400,
    "0x" + "F" * 16, "0x" + "F" * 40, "007", "1_000", "2026-11-21", "12:30", "[]", "{}",
    "[1, 2, 3]",
    "{a: {b: [c]}}", "35 kPa", "5 furlong", "3 m^9/(s", "1e999999999 m", "1e-999999999 m", "&a x",
    "*a", "!!python/object:os.system x", "'", '"', "|", ">-", "- x", "a: b", "é\u2028x", "\t", "%x",
    "'" + "x" * 5000 + "'", "[" * 60, "{a: " * 60, "1e5000 km", "-0.0", "4.9e-324 m", '"\\uD800"',
]  # fmt: skip
KEYS = ["<<", "extends", "mechanism", "driver", "joint", "", "? x", "1", "null", "[a]", "../x", "ü"]


def mutate(text: str, rng: random.Random) -> bytes:
    lines = text.split("\n")
    for _ in range(rng.choice([1, 1, 1, 2, 3, 6])):
        kind = rng.randrange(11)
        at = rng.randrange(len(lines))
        line = lines[at]
        key, colon, _ = line.partition(":")
        if kind == 0:
            del lines[at]
        elif kind == 1:
            lines.insert(rng.randrange(len(lines)), line)
        elif kind == 2 and colon:
            name = rng.choice([*KEYS, key.strip()[:-1], key.strip() + "x", key.strip()[::-1]])
            lines[at] = line.replace(key.strip(), name, 1) if key.strip() else line
        elif kind == 3 and colon:
            lines[at] = f"{key}: {rng.choice(VALUES)}"
        elif kind == 4:
            other = rng.randrange(len(lines))
            lines[at], lines[other] = lines[other], line
        elif kind == 5:
            lines[at] = " " * rng.randrange(8) + line.lstrip()
        elif kind == 6 and line:
            cut = rng.randrange(len(line))
            lines[at] = line[:cut] + rng.choice(VALUES + list("{}[],:#&*!|>'\"%@`-?")) + line[cut:]
        elif kind == 7:
            units = ["mm", "kPa", "Hz", "N", "ms", "m"]
            lines[at] = line.replace(rng.choice(units), rng.choice([*units, "%", "deg", "x"]))
        elif kind == 8:
            lines = lines[: max(1, at)]
        elif kind == 9:
            lines[at] = line[: rng.randrange(len(line) + 1)]
        if not lines:
            lines = [""]
    content = bytearray("\n".join(lines).encode("utf-8"))
    if rng.random() < 0.2 and content:
        for _ in range(rng.choice([1, 2, 8])):
            content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    return bytes(content)


def check(load, path, text, seed):
    """Return whether a mutation was refused; anything but a refusal or an object is a bug."""
    path.write_bytes(mutate(text, random.Random(seed)))
    try:
        loaded = load()
    except ConfigurationError as error:
        message = str(error)
        assert message
        message.encode("utf-8")
        for diagnostic in getattr(error, "diagnostics", ()):
            assert 1 <= diagnostic.mark.line <= len(diagnostic.mark.source.lines), seed
        return True
    assert dump_resolved(loaded)
    return False


def run(configs, profiles, others):
    configs.calibrate()
    rig = configs.path / "rigs/bench.yaml"
    refused = sum(check(configs.profile, rig, PROFILE, seed) for seed in range(profiles))
    # Most mutations break something, and not everything is refused.
    assert 0.6 * profiles < refused < 0.99 * profiles
    rig.write_text(PROFILE)
    calibration = configs.path / "calibration/bench/encoder.yaml"
    assert any(check(configs.profile, calibration, CALIBRATION, seed) for seed in range(others))
    experiment = configs.path / "experiments/bench-sine.yaml"
    assert any(check(configs.experiment, experiment, EXPERIMENT, seed) for seed in range(others))


def test_mutated_files_are_refused_or_load(configs):
    run(configs, 2_000, 500)


@pytest.mark.slow
def test_many_more_mutated_files_are_refused_or_load(configs):
    run(configs, 10_000, 5_000)


def test_mutated_options_are_refused_or_load(configs):
    rng = random.Random(1)
    options = [f"{key}={value}" for key in ("loop.rate", "cylinder.gains.1", "devices.x.y", "plant")
               for value in VALUES]  # fmt: skip
    for option in options:
        text = "".join(rng.choice([c, c, c, c, c, "", ".", "=", "\x00"]) for c in option[:200])
        for tried in (option, text):
            try:
                configs.profile("bench", tried)
            except ConfigurationError as error:
                assert str(error)


@pytest.mark.parametrize("size", [2_000, 200_000])
def test_large_rubbish_is_refused_soon(configs, size):
    lines = size // 10  # what is read whole takes time in proportion; as the square, minutes
    for text in (
        "x" * size,
        "a: 1\n" * lines,
        "- 1\n" * lines,
        "a: &x\n" * lines,
        "[" * size,
        "a:\n " * lines,
        "'" * size,
    ):
        path = configs.write("rigs/large.yaml", text)
        with pytest.raises(ConfigurationError):
            configs.profile(path)
