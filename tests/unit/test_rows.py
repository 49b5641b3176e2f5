"""Rows of other packages: what is not as declared is said with its name, and others go on."""

import pytest

from rig.assembly.contract_check import check_row
from rig.assembly.offered import MECHANISMS
from rig.assembly.rows import load
from rig.hal import ConfigurationError
from rig.hal.parts import Additions, DriverParts, MechanismParts, PlantModel


@pytest.mark.parametrize("path", MECHANISMS.values())
def test_our_own_rows_are_as_declared(path):
    check_row(path, load(path))


@pytest.mark.parametrize(
    ("row", "said"),
    [
        (Additions(mechanism="arm", controllers="pi"), "controllers is 'pi', and no Mapping"),
        (Additions(mechanism="arm", plants={"p": "a:b"}), "plants is {'p': 'a:b'}, and no Mapping"),
        (Additions(mechanism="arm", plants={"p": PlantModel("a:b", None)}), "plants is"),
        (Additions(mechanism="arm", plants={"p": PlantModel("a:b", "c:d", 5)}), "plants is"),
        (Additions(mechanism="arm", measures="a:b"), "measures is 'a:b', and no tuple"),
        (Additions(mechanism="arm", measures=(3,)), "measures is"),
        (Additions(mechanism="arm", measures=None), "measures is None, and no tuple"),
        (MechanismParts(mechanism="m", settings="", view="a:b"), "settings is '', and no str"),
        (MechanismParts(mechanism=None, settings="a:b", view="a:b"), "mechanism is None"),
        (DriverParts(settings=7, device="a:b"), "settings is 7, and no str"),
        (DriverParts(settings="a:b", device="a:b", simulation=3), "simulation is 3"),
        (DriverParts(settings="a:b", device="a:b", on_bus="yes"), "on_bus is 'yes', and no bool"),
    ],
)
def test_what_is_of_another_type_is_named(row, said):
    with pytest.raises(ConfigurationError) as caught:
        check_row("the package x", row)
    assert str(caught.value).startswith("the package x: " + said)
