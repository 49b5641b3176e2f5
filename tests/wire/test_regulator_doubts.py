"""Which channel of a regulator module is doubted when the rig gets out of bounds."""

from cia401_bench import VENTED, Regulators


def doubt_after(setpoints, cycles):
    """Command pressures that are not followed; a fault needs 50 kPa for 0.1 s."""
    valves = Regulators()
    valves.start()
    for _ in range(cycles):
        valves.run(VENTED, "701#05", setpoints=setpoints)
    return valves.driver.doubt(valves.clock.now())


def test_a_module_is_not_doubted_while_it_follows():
    assert doubt_after((0.0, 0.0), 10) is None
    assert doubt_after((24e3, 24e3), 300) is None  # half of the deviation is 25 kPa


def test_the_channel_that_is_furthest_off_is_doubted():
    said = doubt_after((45e3, 30e3), 300)
    assert said == (
        "valves: the pressure of agonist is -45 kPa off what its setpoint asks for: its regulator "
        "may be stuck"
    )
    assert "the pressure of antagonist is -45 kPa off" in doubt_after((30e3, 45e3), 300)
    assert "the pressure of antagonist is -30 kPa off" in doubt_after((0.0, 30e3), 300)
