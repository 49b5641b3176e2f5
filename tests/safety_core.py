"""The files that decide on safety, and the unit tests that prove each of them on their own.

``python tests/safety_core.py [WORD...]`` measures which lines and branches of each file (or of
those whose path has one of the words) its own tests run, and ends with 1 if any is left out. It
needs `coverage`.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
_LOOP = ("runtime/test_cycle.py", "runtime/test_loop.py", "runtime/test_loop_ways.py")
SAFETY_CORE = {
    # The loop: its states, what it sends, how it stops.
    "rig/runtime/states.py": ("runtime/test_states_and_limits.py",),
    "rig/runtime/limits.py": (
        "runtime/test_states_and_limits.py",
        "runtime/test_limiter_bounds.py",
    ),
    "rig/runtime/loop.py": _LOOP,
    "rig/runtime/cycle.py": _LOOP,
    "rig/runtime/pace.py": ("runtime/test_pace.py", *_LOOP),
    "rig/runtime/phases.py": ("runtime/test_phases.py", *_LOOP),
    "rig/runtime/braking.py": ("runtime/test_braking.py",),
    "rig/runtime/stop.py": ("runtime/test_states_and_limits.py",),
    "rig/runtime/stop_recording.py": _LOOP,
    "rig/runtime/bus_watch.py": ("runtime/test_bus_watch.py",),
    # Whether it may run at all, and what its end says of it.
    "rig/experiment/ending.py": ("experiment/test_ending.py",),
    "rig/experiment/fault_latch.py": ("experiment/test_fault_latch_file.py",),
    "rig/experiment/permission.py": ("experiment/test_permission.py",),
    "rig/cli/reset.py": ("cli/test_reset.py",),
    # What a mechanism watches, and what it lets through.
    "rig/mechanisms/stop_contact.py": ("mechanisms/test_stop_contact.py",),
    "rig/mechanisms/pneumatic/alarms/pressures.py": (
        "mechanisms/test_pneumatic_vented.py",
        "mechanisms/test_pneumatic_usual_pressures.py",
        "mechanisms/test_pneumatic_stray_pressures.py",
        "mechanisms/test_pneumatic_pressure_alarm.py",
        "mechanisms/test_pneumatic_pressure_moves.py",
        "mechanisms/test_pneumatic_pressure_words.py",
        "mechanisms/test_pneumatic_strange_means.py",
    ),
    "rig/mechanisms/pneumatic/alarms/answers.py": (
        "mechanisms/test_pneumatic_stray_pressures.py",
        "mechanisms/test_pneumatic_pressure_alarm.py",
        "mechanisms/test_pneumatic_pressure_learnt.py",
        "mechanisms/test_pneumatic_pressure_moves.py",
        "mechanisms/test_pneumatic_pressure_words.py",
        "mechanisms/test_pneumatic_strange_means.py",
    ),
    "rig/mechanisms/pneumatic/alarms/frozen.py": ("mechanisms/test_pneumatic_frozen_monitor.py",),
    "rig/mechanisms/pneumatic/alarms/jumped.py": ("mechanisms/test_pneumatic_jumped_monitor.py",),
    "rig/mechanisms/pneumatic/alarms/vented.py": ("mechanisms/test_pneumatic_vented.py",),
    "rig/mechanisms/servo/stuck.py": ("mechanisms/test_servo_stuck.py",),
    "rig/mechanisms/legs/fall.py": ("mechanisms/test_legs_fall.py",),
    "rig/mechanisms/pneumatic/alarms/dead_time.py": ("mechanisms/test_pneumatic_dead_time.py",),
    "rig/mechanisms/pneumatic/alarms/ways.py": ("mechanisms/test_pneumatic_pressure_ways.py",),
    "rig/mechanisms/pneumatic/alarms/work.py": ("mechanisms/test_pneumatic_work_alarm.py",),
    "rig/mechanisms/pneumatic/alarms/rests.py": ("mechanisms/test_pneumatic_rod_rests.py",),
    "rig/mechanisms/pneumatic/alarms/tracking.py": (
        "mechanisms/test_pneumatic_straying.py",
        "mechanisms/test_pneumatic_tracking_alarm.py",
        "mechanisms/test_pneumatic_sticking.py",
        "mechanisms/test_pneumatic_starts.py",
    ),
    "rig/mechanisms/pneumatic/alarms/turns.py": (
        "mechanisms/test_pneumatic_tracking_alarm.py",
        "mechanisms/test_pneumatic_sticking.py",
    ),
    "rig/mechanisms/pneumatic/alarms/swinging.py": ("mechanisms/test_pneumatic_swinging.py",),
    "rig/mechanisms/pneumatic/alarms/scatter.py": ("mechanisms/test_pneumatic_scatter.py",),
    "rig/mechanisms/pneumatic/alarms/runs_off.py": (
        "mechanisms/test_pneumatic_runs_off.py",
        "mechanisms/test_pneumatic_straying.py",
    ),
    "rig/mechanisms/pneumatic/alarms/missing.py": (
        "mechanisms/test_pneumatic_pull_balance.py",
        "mechanisms/test_pneumatic_pulled_back.py",
        "mechanisms/test_pneumatic_unseen_pull.py",
    ),
    "rig/mechanisms/pneumatic/alarms/balance.py": (
        "mechanisms/test_pneumatic_pull_balance.py",
        "mechanisms/test_pneumatic_unseen_pull.py",
        "mechanisms/test_pneumatic_pulled_back.py",
        "mechanisms/test_pneumatic_starts.py",
    ),
    "rig/mechanisms/pneumatic/cut_wire.py": ("mechanisms/test_pneumatic_cut_wire.py",),
    "rig/mechanisms/pneumatic/devices.py": (
        "mechanisms/test_pneumatic_devices.py",
        "mechanisms/test_controller_commands.py",
    ),
    "rig/mechanisms/cylinder/watch.py": (
        "mechanisms/test_cylinder_causes.py",
        "mechanisms/test_cylinder_pulls.py",
        "mechanisms/test_cylinder_limits.py",
        "mechanisms/test_cylinder_watch.py",
        "mechanisms/test_pneumatic_starts.py",
        "mechanisms/test_pneumatic_unseen_pull.py",
    ),
    "rig/mechanisms/cylinder/mechanism.py": (
        "mechanisms/test_cylinder_commands.py",
        "mechanisms/test_cylinder_duties.py",
        "mechanisms/test_cylinder_limits.py",
    ),
    "rig/mechanisms/joint/watch.py": (
        "mechanisms/test_joint_causes.py",
        "mechanisms/test_joint_other_pair.py",
        "mechanisms/test_joint_compiling.py",
        "mechanisms/test_joint_watch.py",
        "mechanisms/test_pneumatic_unseen_pull.py",
    ),
    "rig/mechanisms/joint/mechanism.py": (
        "mechanisms/test_joint_commands.py",
        "mechanisms/test_joint_compiling.py",
        "mechanisms/test_joint_duties.py",
        "mechanisms/test_joint_readings.py",
    ),
    "rig/mechanisms/joint/alarms/wires.py": (
        "mechanisms/test_joint_compiling.py",
        "mechanisms/test_joint_wire_alarm.py",
        "mechanisms/test_joint_wire_blame.py",
        "mechanisms/test_joint_wire_lead.py",
        "mechanisms/test_joint_wire_offsets.py",
    ),
    "rig/mechanisms/joint/alarms/runs.py": ("mechanisms/test_joint_rod_runs.py",),
    "rig/mechanisms/joint/alarms/unpushed.py": ("mechanisms/test_joint_unpushed.py",),
    "rig/mechanisms/joint/following.py": ("mechanisms/test_joint_following.py",),
    "rig/mechanisms/joint/alarms/camera.py": ("mechanisms/test_joint_camera_alarm.py",),
    "rig/mechanisms/servo/wiring.py": ("mechanisms/test_servo_wiring.py",),
    "rig/mechanisms/servo/axes.py": (
        "mechanisms/test_servo_axis_checks.py",
        "mechanisms/test_servo_axis_commands.py",
        "mechanisms/test_servo_slip.py",
        "mechanisms/test_controller_commands.py",
    ),
    "rig/mechanisms/servo/asked.py": ("mechanisms/test_controller_commands.py",),
    # What a bus and its nodes say of themselves.
    "drivers/can/cyclic.py": ("drivers/test_cyclic_bus.py",),
    "drivers/can/errors.py": ("drivers/test_bus_errors.py",),
    "drivers/canopen/node.py": ("drivers/test_canopen_node.py",),
    "drivers/canopen/heartbeat.py": ("drivers/test_heartbeat_watch.py",),
    "drivers/canopen/emergency.py": ("drivers/test_emergency_names.py",),
}
"""Each file, and its own tests below ``tests/unit``."""


def _python(*words: str) -> int:
    return subprocess.run([sys.executable, "-m", *words], cwd=ROOT, check=False).returncode


def measure(path: str) -> bool:
    """Return whether a file's own tests pass and run every line and branch of it."""
    tests = [f"tests/unit/{name}" for name in SAFETY_CORE[path]]
    pytest = ("pytest", "-n", "0", "-q", "-p", "no:randomly", *tests)
    with tempfile.TemporaryDirectory() as folder:
        data = f"--data-file={folder}/coverage"
        ran = _python("coverage", "run", "--branch", data, f"--include={path}", "-m", *pytest)
        return _python("coverage", "report", data, "-m", "--fail-under=100") + ran == 0


def main(words: list[str]) -> int:
    """Measure the files whose path has one of the words, or all."""
    paths = [path for path in SAFETY_CORE if not words or any(word in path for word in words)]
    missed = [path for path in paths if not measure(path)]
    sys.stdout.writelines(f"not proven: {path}\n" for path in missed)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
