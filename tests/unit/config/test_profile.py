"""Profiles: what they become, and what they say when they are wrong."""

import subprocess
import sys
import time
from pathlib import Path

import pytest
from config_fakes import CylinderSettings, EncoderSettings, Friction

import rig.config
from rig.config import ProfileError, dump_resolved
from rig.hal import ConfigurationError


def errors(load):
    """Return "line: message | hint" of every diagnostic."""
    with pytest.raises(ProfileError) as caught:
        load()
    return [f"{d.mark.line}: {d.message} | {d.hint}" for d in caught.value.diagnostics]


def test_a_profile_is_plain_data_in_si(configs):
    profile = configs.profile()
    assert profile.name == "bench"
    assert (profile.loop.rate, profile.loop.priority, profile.loop.cpu) == (500.0, 70, 1)
    assert profile.loop.period == 2e-3
    assert profile.buses["can0"].settings.bitrate == 1_000_000
    valves = profile.devices["valves"]
    assert (valves.driver, valves.bus, valves.serial, valves.calibration) == (
        "valve-module", "can0", None, None,
    )  # fmt: skip
    assert valves.settings.node == 16
    assert valves.settings.watchdog == 0.02
    assert valves.settings.channels["antagonist"].setpoint == (0x6411, 2)
    assert profile.mechanism_settings == CylinderSettings(
        "valves", "encoder", 16e-3, 181.5e-6, Friction(3.0, 4.5, 25.0), (-9e-3, 9e-3),
        (1.0, 2.5, 1e-3),
    )  # fmt: skip
    assert profile.controllers["pid"].dither == 40.0
    assert profile.plant.settings.conductance == 3e-10
    assert profile.simulation.frame_loss == 0.25
    assert [fault.at for fault in profile.simulation.faults] == [0.5, 2.0]
    assert all(type(gain) is float for gain in profile.mechanism_settings.gains)


def test_all_errors_at_once_with_line_caret_bound_and_nearest_key(configs):
    configs.edit("rate: 500 Hz", "rate: 9 kHz")
    configs.edit("watchdog: 20 ms", "watchdgo: 20 ms")
    configs.edit("bus: can0\n    serial", "bus: cna0\n    serial")
    configs.edit("node: 33", "node: 128")
    configs.edit("bore: 16 mm", "bore: 16 N")
    configs.edit("breakaway: 4.5 N", "breakaway: 2 N")
    configs.edit("seals: low-speed", "seals: lowspeed")
    configs.edit("device: encoder, fault", "device: encodr, fault")
    with pytest.raises(ProfileError) as caught:
        configs.profile()
    text = str(caught.value)
    file = configs.path / "rigs/bench.yaml"
    assert (
        f"{file}:5:14: loop.rate is '9 kHz', expected at most 5 kHz (5000 Hz)\n"
        "    loop: {rate: 9 kHz, priority: 70, cpu: 1}\n"
        "                 ^\n"
    ) in text
    assert "unknown key 'watchdgo'" in text
    assert "did you mean watchdog?" in text
    assert "no bus is called 'cna0'" in text
    assert "did you mean can0?" in text
    assert "node is 128, expected at most 127" in text
    assert "bore: '16 N' is not in m; units that would do: m, cm, mm, µm" in text
    assert f"{file}:36:3: breakaway is below coulomb." in text
    assert "did you mean low-speed?" in text
    assert "no device or bus is called 'encodr'" in text
    assert text.endswith("8 errors")
    assert len(caught.value.diagnostics) == 8


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("mechanism: cylinder", "mechanism: cilinder",
         "4: no mechanism is called 'cilinder' | did you mean cylinder?"),
        ("mechanism: cylinder\n", "", "2: key 'mechanism' is missing"),
        ("driver: linear-encoder", "driver: linear-encode",
         "no driver is called 'linear-encode' | did you mean linear-encoder?"),
        ("    driver: linear-encoder\n", "", "22: key 'driver' is missing"),
        ("model: antagonistic-pair", "model: pair", "no plant is called 'pair'"),
        ("  cascade:", "  cascad:", "no controller is called 'cascad' | did you mean cascade?"),
        ("loop: {rate: 500 Hz, ", "loop: {", "5: key 'rate' is missing | it takes a number in Hz"),
        ("rate: 500 Hz", "rate: true", "loop.rate is true, expected a number in Hz"),
        ("rate: 500 Hz", "rate: .nan", "expected a finite number"),
        ("rate: 500 Hz", "rate: 1e999", "expected a finite number"),
        ("rate: 500 Hz", "rate: [500]", "loop.rate is a list"),
        ("priority: 70", "priority: 70.5", "loop.priority is 70.5, expected a whole number"),
        ("priority: 70", "priority: true", "loop.priority is true, expected a whole number"),
        ("priority: 70", "spin: yes", "loop.spin is 'yes', expected true or false"),
        ("priority: 70", "spin: 1", "loop.spin is 1, expected true or false"),
        ("bitrate: 1 Mbit/s", "bitrate: 1.5 bit/s", "whole number"),
        ("channel: bench", "channel: 5", "channel is 5, expected text"),
        ("[-9 mm, 9 mm]", "[-9 mm]", "position"),
        ("[-9 mm, 9 mm]", "[-9 mm, 9 mm, 0]", "position is a list, expected at most 2 values"),
        ("[-9 mm, 9 mm]", "[9 mm, -9 mm]", "29: position: the lower limit is not below"),
        ("[-9 mm, 9 mm]", "[9 mm, 2 N]", "position.1: '2 N' is not in m"),
        ("gains: [1, 2.5, 1e-3]", "gains: [1, -2.5]", "gains.1 is -2.5, expected at least 0"),
        ("gains: [1, 2.5, 1e-3]", "gains: ['1']", "gains.0 is '1', expected a number"),
        ("cylinder:\n", "cylindr:\n", "key 'cylinder' is missing"),
        ("cylinder:\n", "cylindr:\n", "unknown key 'cylindr' | did you mean cylinder?"),
        ("devices:\n", "devices: 3\nvices:\n", "devices is 3, expected a mapping"),
        ("  can0:\n    interface", "  ../x:\n    interface", "'../x' cannot be a name in buses"),
        ("serial: 4711", "serial: -1", "serial is -1, expected at least 0"),
        ("serial: 4711", "calibration: 5", "calibration is 5, expected true or false"),
        ("serial: 4711", "calibration: true",
         "encoder has no calibration calibration/bench/encoder.yaml"),
        ("name: bench", "name: ../bench", "name is '../bench'"),
    ],
)  # fmt: skip
def test_one_error(configs, old, new, expected):
    configs.edit(old, new)
    assert any(expected in error for error in errors(configs.profile)), errors(configs.profile)


def test_overflow_in_a_rule_of_a_dataclass_is_an_error_of_the_file(configs, monkeypatch):
    monkeypatch.setattr(Friction, "__post_init__", lambda self: self.coulomb**2000 and None)
    assert any("cannot be used together" in error for error in errors(configs.profile))


class TestExtends:
    def test_mappings_merge_and_lists_replace(self, configs):
        configs.write(
            "rigs/fast.yaml",
            "extends: bench\nloop: {rate: 1 kHz}\ncylinder: {gains: [7]}\n"
            "plant: {seals: standard}\n",
        )
        profile, base = configs.profile("fast"), configs.profile()
        assert (profile.name, profile.description) == ("fast", "")
        assert (profile.loop.rate, profile.loop.priority) == (1000.0, 70)
        assert profile.mechanism_settings.gains == (7.0,)
        assert profile.mechanism_settings.friction == base.mechanism_settings.friction
        assert [path.name for path in profile.files] == ["fast.yaml", "bench.yaml"]

    def test_another_driver_replaces_the_device(self, configs):
        configs.write(
            "rigs/fast.yaml",
            "extends: ./bench.yaml\ndevices: {valves: {driver: linear-encoder, node: 5}}\n",
        )
        assert configs.profile("fast").devices["valves"].settings == EncoderSettings(5)

    def test_errors_of_a_base_point_at_the_base(self, configs):
        configs.edit("node: 33", "node: 333")
        configs.write("rigs/fast.yaml", "extends: bench\nloop: {rate: 0 Hz}\n")
        with pytest.raises(ProfileError) as caught:
            configs.profile("fast")
        assert {d.mark.source.name.rpartition("/")[2] for d in caught.value.diagnostics} == {
            "bench.yaml", "fast.yaml",
        }  # fmt: skip

    def test_chain_cycle_and_unknown_base(self, configs):
        configs.write("rigs/a.yaml", "extends: b\n")
        configs.write("rigs/b.yaml", "extends: bench\nloop: {cpu: 3}\n")
        assert configs.profile("a").loop.cpu == 3
        configs.write("rigs/b.yaml", "extends: a\n")
        assert any(
            "extends this file in turn" in error for error in errors(lambda: configs.profile("a"))
        )
        configs.write("rigs/b.yaml", "extends: bnech\n")
        assert any("did you mean bench?" in error for error in errors(lambda: configs.profile("a")))
        configs.write("rigs/b.yaml", "extends: 5\n")
        assert any(
            "expected a name or path" in error for error in errors(lambda: configs.profile("a"))
        )


class TestOverrides:
    def test_values_go_through_the_same_validation(self, configs):
        profile = configs.profile(
            "bench", "loop.rate=1 kHz", "cylinder.gains=[3, 4]", "cylinder.position.1=5 mm",
            "controllers.pid={integral: 2}", "devices.encoder.inverted=true", "loop.cpu=null",
        )  # fmt: skip
        assert (profile.loop.rate, profile.loop.cpu) == (1000.0, None)
        assert profile.mechanism_settings.gains == (3.0, 4.0)
        assert profile.mechanism_settings.position == (-9e-3, 5e-3)
        assert profile.controllers["pid"].integral == 2.0
        assert profile.devices["encoder"].settings.inverted is True

    @pytest.mark.parametrize(
        ("option", "expected"),
        [
            ("loop.rate=fast", "--set:1:11: loop.rate: 'fast' does not start with a number"),
            ("loop.rate=[1", "--set:1:"),
            ("loop.raet=5", "--set:1:1: unknown key 'raet'"),
            ("loop", "--set:1:1: an option is a path of keys"),
            ("=5", "--set:1:1: an option is a path of keys"),
            ("loop.rate=", "--set:1:10: there is no value"),
            ("loop.rate.x=5", "--set:1:1: x cannot be set: what holds it is '500 Hz'"),
            ("cylinder.gains.9=5", "there is no position 9: the list has 3"),
            ("cylinder.gains.x=5", "x is not a position in a list"),
            ("loop=rate: 5", "write a mapping as {a: 1}"),
            ("loop.rate=&x 5", "--set:1:11: anchor &x is not allowed"),
            ("a." * 500 + "b=1", "an option is a path of keys"),
        ],
    )
    def test_errors_point_at_the_option(self, configs, option, expected):
        with pytest.raises(ProfileError) as caught:
            configs.profile("bench", option)
        text = str(caught.value)
        assert expected in text
        assert f"    {option[:40]}" in text
        assert len(caught.value.diagnostics) == 1


def test_a_resolved_profile_loads_to_an_equal_one(configs):
    configs.calibrate()
    profile = configs.profile("bench", "loop.rate=333.3 Hz", "simulation.bus_latency=1e-5")
    path = configs.write("runs/1/profile.yaml", dump_resolved(profile))
    again = configs.profile(path)
    assert again == profile
    assert dump_resolved(again) == dump_resolved(profile)


@pytest.mark.parametrize(
    "text",
    [
        "on",
        "1e-3",
        "0x10",
        "null",
        "~",
        " a ",
        "a: b",
        "#x",
        "é\n  x",
        "-",
        "'",
        '"',
        "\u2028",
        "😀",
        "",
    ],
)
def test_any_text_survives_the_round_trip(configs, text):
    import dataclasses

    profile = dataclasses.replace(configs.profile(), description=text, name="x")
    path = configs.write("runs/1/profile.yaml", dump_resolved(profile))
    assert configs.profile(path) == profile


def test_names_and_paths(configs, tmp_path):
    assert configs.profile(configs.path / "rigs/bench.yaml") == configs.profile()
    assert configs.profile(str(configs.path / "rigs/bench.yaml")) == configs.profile()
    with pytest.raises(ConfigurationError, match="no rig is called 'bnch'; did you mean bench"):
        configs.profile("bnch")
    with pytest.raises(ConfigurationError, match="No such file"):
        configs.profile("./nowhere.yaml")


def test_loading_takes_milliseconds_of_processor_time(configs):
    configs.profile()
    start = time.process_time()
    for _ in range(10):
        configs.profile()
    assert (time.process_time() - start) / 10 < 0.05


def test_nothing_heavy_is_imported_for_the_names():
    code = (
        "import sys, rig.config, rig.config.names, rig.config.models, rig.config.quantities\n"
        "rig.config.find_configs; rig.config.Profile\n"
        "assert not {'pydantic', 'yaml', 'numpy'} & set(sys.modules), sorted(sys.modules)\n"
        "assert all(getattr(rig.config, name) for name in rig.config.__all__)"
    )
    subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=Path(rig.config.__file__).parents[2]
    )
