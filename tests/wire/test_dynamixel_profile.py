"""The sections of a profile that speak of Dynamixel servos and of the arm's plant."""

import math

import pytest

from drivers.dynamixel.settings import DynamixelSettings, SerialBusSettings
from drivers.sim.plants.arm_settings import ArmPlantSettings
from rig.config.diagnostics import Problems, ProfileError
from rig.config.located import Source
from rig.config.settings import build
from rig.config.yaml_loader import parse


def read(kind, text):
    problems = Problems()
    made = build(kind, parse(Source("rig.yaml", text), problems), problems)
    problems.raise_if_any()
    return made


def test_a_chain_of_legs_is_read_with_its_units():
    settings = read(
        DynamixelSettings,
        """
        model: xm430-w350
        max_temperature: 65 degC
        watchdog: 40 ms
        gains: {position_p: 900}
        joints:
          right_knee:
            id: 4
            reversed: true
            offset: 10 deg
            limits: [-100 deg, 100 deg]
            max_speed: 45 rpm
          left_knee: {id: 10}
        """,
    )
    knee = settings.joints["right_knee"]
    assert knee.offset == pytest.approx(math.radians(10.0))
    assert knee.max_speed == pytest.approx(1.5 * math.pi)
    assert settings.max_temperature == pytest.approx(338.15)
    assert settings.watchdog == 0.04
    assert settings.gains.position_p == 900


@pytest.mark.parametrize(
    ("kind", "text", "words"),
    [
        (DynamixelSettings, "joints: {a: {id: 253}}", "252"),
        (DynamixelSettings, "joints: {a: {id: 1}, b: {id: 1}}", "a and b have the same id"),
        (DynamixelSettings, "joints: {a: {id: 1}}\nmodel: xm430-w351", "xm430-w350"),
        (DynamixelSettings, "joints: {a: {id: 1, node: 2}}", "node"),
        (SerialBusSettings, "port: /dev/ttyUSB0\nbaudrate: 5 Mbit/s", "baudrate"),
        (SerialBusSettings, "baudrate: 1 Mbit/s", "port"),
        (ArmPlantSettings, "links: {payload: -1}", "payload"),
    ],
)
def test_mistakes_are_named(kind, text, words):
    with pytest.raises(ProfileError) as refused:
        read(kind, text)
    assert words in str(refused.value)


def test_a_bus_and_a_plant_are_read():
    bus = read(SerialBusSettings, "port: /dev/ttyUSB0\nbaudrate: 4 Mbit/s")
    assert bus.baudrate == 4_000_000
    plant = read(
        ArmPlantSettings, "start: [0, 30 deg, 115 deg, 30 deg, -50 deg, 0]\nlinks: {payload: 1 kg}"
    )
    assert plant.start[2] == pytest.approx(math.radians(115.0))
