"""What profiles say of servo drives: described, strict, and the same after a round trip."""

from dataclasses import fields

import pytest

from drivers.cia402.settings import Cia402Settings, DriveSettings
from drivers.odrive.settings import (
    OdriveAxisSettings,
    OdriveBusSettings,
    OdriveEndpoints,
    OdriveSettings,
)
from drivers.servos.axis_settings import AxisSettings
from rig.config.docstrings import parameter_texts
from rig.config.settings import adapter

ALL = (
    AxisSettings,
    DriveSettings,
    Cia402Settings,
    OdriveAxisSettings,
    OdriveBusSettings,
    OdriveEndpoints,
    OdriveSettings,
)


@pytest.mark.parametrize("settings", ALL)
def test_every_field_is_described_where_it_is_defined_or_inherited(settings):
    texts = parameter_texts(settings)
    for field in fields(settings):
        assert texts.get(field.name), f"{settings.__name__}.{field.name}"


def test_a_profile_may_write_units():
    made = adapter(Cia402Settings).validate_python(
        {
            "joints": {
                "q1": {
                    "node": 1,
                    "counts_per_turn": 131072,
                    "gear": 100,
                    "limits": ["-90 deg", "90 deg"],
                    "max_speed": "60 deg/s",
                    "deceleration": "4 rad/s^2",
                    "following_time": "50 ms",
                }
            },
            "mode": "csv",
            "feedback": ["velocity"],
        }
    )
    joint = made.joints["q1"]
    assert joint.limits == pytest.approx((-1.5707963, 1.5707963))
    assert joint.max_speed == pytest.approx(1.0471976)
    assert joint.following_time == pytest.approx(0.05)
    assert made.feedback == ("velocity",)
    assert joint.counts_per_radian == pytest.approx(131072 * 100 / 6.283185307)


@pytest.mark.parametrize(
    ("settings", "document"),
    [
        (Cia402Settings, {"joints": {}}),
        (Cia402Settings, {"joints": {"q1": {"node": 1}}}),
        (Cia402Settings, {"joints": {"q1": {"node": 200, "counts_per_turn": 1}}}),
        (Cia402Settings, {"joints": {"q1": {"node": 1, "counts_per_turn": 1}}, "mode": "pp"}),
        (OdriveSettings, {"joints": {"q1": {"axis": 63}}}),
        (OdriveSettings, {"joints": {"q1": {"axis": 1, "gears": 2.0}}}),
        (OdriveSettings, {"joints": {"q1": {"axis": 1}}, "watchdog": 0.0}),
        (OdriveSettings, {"joints": {"q1": {"axis": 1}}, "watchdog": None}),
    ],
)
def test_what_cannot_be_is_refused(settings, document):
    with pytest.raises(ValueError, match="validation error"):
        adapter(settings).validate_python(document)
