"""The emulated ODrive in the words of somebody else's DBC: what it sends, and what it obeys."""

import pytest
from servo_bench import LaggedJoints

pytest.importorskip("cantools")
odrive_can = pytest.importorskip("odrive_can")

from drivers.sim.nodes.odrive import EmulatedOdrive, OdriveBuild  # noqa: E402

NODE = 3
SERIAL = 0x3957_1234_5678


class Talk:
    """One axis, spoken to with the DBC's encoder and heard with its decoder."""

    def __init__(self):
        self.dbc = odrive_can.get_dbc("odrive-cansimple-0.6.10")
        self.plant = LaggedJoints(1, start=0.25)
        self.axis = EmulatedOdrive(
            "axis",
            NODE,
            self.plant,
            0,
            OdriveBuild(
                gear=6.283185307179586, serial=SERIAL, heartbeat=0.02, encoder_period=0.005
            ),
        )
        self.heard = []
        self.axis.send = lambda can_id, data: self.heard.append((can_id, data))
        self.time = 0.0

    def tell(self, name, **signals):
        message = self.dbc.get_message_by_name(f"Axis{NODE}_{name}")
        self.axis.receive(message.frame_id, message.encode(signals, strict=False), self.time)

    def ask(self, name):
        message = self.dbc.get_message_by_name(f"Axis{NODE}_{name}")
        self.heard.clear()
        self.axis.receive(message.frame_id, b"", self.time, remote=True)
        ((can_id, data),) = self.heard
        assert can_id == message.frame_id
        return message.decode(data, decode_choices=False)

    def run(self, seconds):
        """Let time pass; return what was heard, decoded, as (name, signals)."""
        self.heard.clear()
        end = self.time + seconds
        while self.axis.due <= end:
            self.time = max(self.axis.due, self.time)
            self.plant.advance(self.time)
            self.axis.tick(self.time)
        self.time = end
        self.plant.advance(end)
        found = []
        for can_id, data in self.heard:
            message = self.dbc.get_message_by_frame_id(can_id)
            assert len(data) == message.length
            found.append((message.name, message.decode(data, decode_choices=False)))
        return found


@pytest.fixture
def talk():
    made = Talk()
    made.run(0.001)
    return made


def test_cyclic_messages_come_at_their_rates(talk):
    names = [name for name, _ in talk.run(0.1)]
    assert names.count("Axis3_Heartbeat") == 5
    assert names.count("Axis3_Get_Encoder_Estimates") == 20


def test_answers_to_remote_frames(talk):
    version = talk.ask("Get_Version")
    assert (version["Fw_Version_Major"], version["Fw_Version_Minor"]) == (0, 6)
    assert talk.ask("Address") == {"Node_ID": NODE, "Serial_Number": SERIAL}
    assert talk.ask("Get_Error") == {"Active_Errors": 0, "Disarm_Reason": 0}
    assert talk.ask("Heartbeat")["Axis_State"] == 1
    estimates = talk.ask("Get_Encoder_Estimates")
    assert estimates["Pos_Estimate"] == pytest.approx(0.25, abs=1e-4)
    assert estimates["Vel_Estimate"] == 0.0


def test_it_closes_its_loop_and_follows(talk):
    talk.tell("Set_Controller_Mode", Control_Mode=3, Input_Mode=1)
    talk.tell("Set_Limits", Velocity_Limit=50.0, Current_Limit=10.0)
    talk.tell("Set_Axis_State", Axis_Requested_State=8)
    talk.tell("Set_Input_Pos", Input_Pos=0.5, Vel_FF=0.0, Torque_FF=0.0)
    heard = talk.run(0.1)
    beats = [signals for name, signals in heard if name.endswith("Heartbeat")]
    assert {beat["Axis_State"] for beat in beats} == {8}
    assert talk.plant.angles[0] == pytest.approx(0.5, abs=1e-3)
    talk.tell("Set_Controller_Mode", Control_Mode=2, Input_Mode=1)
    talk.tell("Set_Input_Vel", Input_Vel=-0.2, Input_Torque_FF=0.0)
    talk.run(0.5)
    assert talk.ask("Get_Encoder_Estimates")["Vel_Estimate"] == pytest.approx(-0.2, abs=0.01)
    assert talk.plant.angles[0] == pytest.approx(0.4, abs=0.01)


def test_it_reports_why_it_was_disarmed_and_forgets_when_told(talk):
    talk.tell("Set_Axis_State", Axis_Requested_State=8)
    talk.tell("Estop")
    assert talk.ask("Get_Error") == {"Active_Errors": 0x02000000, "Disarm_Reason": 0x02000000}
    talk.tell("Set_Axis_State", Axis_Requested_State=8)
    assert talk.ask("Heartbeat")["Axis_State"] == 1, "not with an error"
    talk.tell("Clear_Errors", Identify=0)
    talk.tell("Set_Axis_State", Axis_Requested_State=8)
    assert talk.ask("Heartbeat")["Axis_State"] == 8
    talk.tell("Reboot", Action=0)
    assert talk.ask("Heartbeat")["Axis_State"] == 1
