"""A driver of another package without a simulation: it runs, and its readings are logged."""

import pytest

from rig.assembly import REGISTRY, Backend, build_rig, offered
from rig.assembly.decoding import make_decoders
from rig.assembly.survey import expected_on
from rig.cli import invoke
from rig.config import find_configs, load_profile
from rig.hal import ConfigurationError
from rig.runtime.log import read_log

CONFIGS = find_configs()
PROFILE = """\
extends: cylinder
devices:
  regulators: {echo: false}       # there is no room for both on one bus at 1 kHz
  oil:
    driver: thermometer
    bus: can0
    node: 0x30
    serial: 77
"""


@pytest.fixture
def profile(tmp_path, monkeypatch):
    monkeypatch.setitem(offered.DRIVERS, "thermometer", "foreign_thermometer:PARTS")
    caches = (offered.drivers,)
    for cache in caches:
        cache.cache_clear()
    yield lambda *options: load_profile(write(tmp_path), REGISTRY, options, CONFIGS)
    monkeypatch.undo()
    for cache in caches:
        cache.cache_clear()


def write(folder):
    path = folder / "oily.yaml"
    path.write_text(PROFILE)
    return path


def test_it_is_found_decoded_and_counted_by_what_it_describes(profile):
    made = profile()
    assert [a.number for a in expected_on(made, "can0") if a.name == "oil"] == [0x30]
    decoded = make_decoders(made)["can0"].decode(0x1B0, (250).to_bytes(2, "little"))
    assert (decoded.device, decoded.service) == ("oil", "TPDO1")
    (value,) = decoded.values
    assert (value.name, value.unit, value.value) == ("temperature", "K", pytest.approx(298.15))


@pytest.mark.parametrize("backend", [Backend.VIRTUAL, Backend.SIM])
def test_its_device_is_simulated_from_its_description(profile, backend):
    with build_rig(profile(), backend) as rig:
        rig.arm()
        oil = rig.devices["oil"]
        for _ in range(20):
            now = rig.clock.now()
            for bus in rig.buses.values():
                bus.receive(now)
            oil.check(now)
            for bus in rig.buses.values():
                bus.transmit(now)
            rig.clock.sleep_until(now + 1e-3)
        (column,) = oil.log_columns
        assert (column.name, column.unit) == ("device.oil_temperature", "K")
        # No channel of this plant has a temperature: it reads 0, to a step of its converter.
        assert oil.log_values() == pytest.approx((0.0,), abs=0.1)


@pytest.mark.parametrize("backend", [Backend.VIRTUAL, Backend.SIM])
def test_without_a_description_the_error_says_what_to_add(profile, backend):
    with pytest.raises(ConfigurationError, match=r"oil: nothing says .*DriverParts\.simulation"):
        build_rig(profile("devices.oil.silent=true"), backend)


def test_an_eds_describes_it_as_well(profile, tmp_path):
    eds = tmp_path / "thermometer.eds"
    module = (CONFIGS[0] / "eds" / "cia401-analogue.eds").read_text()
    eds.write_text(module.replace("0x000F0191", "0x000F0194"))  # of CiA 404
    with build_rig(profile(f"devices.oil.eds={eds}"), Backend.VIRTUAL) as rig:
        assert rig.devices["oil"]._node.read(0x6443, 1, "u8") == 1  # the file's default


def test_a_run_logs_its_readings(profile, tmp_path, capfd):
    profile()
    experiment = tmp_path / "step.yaml"
    experiment.write_text(f"extends: cylinder-step\nrig: {tmp_path / 'oily.yaml'}\n")
    out = tmp_path / "runs"
    arguments = ["run", str(experiment), "--on", "virtual", "--out", str(out), "--no-report"]
    assert invoke(arguments) == 0, capfd.readouterr().err
    (path,) = out.glob("*/*.mcap")
    log = read_log(path)
    assert log.column("device.oil_temperature")[-1] == pytest.approx(0.0, abs=0.1)
    assert log.names("device.") == ("device.oil_temperature",)
