"""A folder with a healthy file of every kind that a rig keeps, and what reads each of them."""

import json
import shutil
from pathlib import Path

import yaml
from mistakes import as_json, as_json_lines, as_sealed_yaml, as_yaml

from rig.assembly import REGISTRY
from rig.calibration.store import write
from rig.cli import invoke
from rig.commissioning.record import new_record, write_record
from rig.config import load_profile

ROOT = Path(__file__).parents[2]
SHORT = (
    "--set", "approach=0.2 s", "--set", "loop.rate=250 Hz", "--set", "reference.dwell=0.2 s",
    "--set", "reference.rise=0 s", "--set", "reference.size=1 mm",
)  # fmt: skip
DATE = "2026-01-01T00:00:00+00:00"
LATER = "2026-02-01T00:00:00+00:00"
CONFIGS = ("--configs", "configs")
RUN = "runs/mine"
SCENARIO = {
    "rig": "cylinder", "experiment": "cylinder-step", "fault": "encoder_alarm",
    "where": "encoder-agonist", "when": {"phase": "run", "after": "0.3 s"},
    "then": {"fault": "program_killed", "after": "0.2 s"}, "seed": 3,
}  # fmt: skip
SWEEP = {
    "experiment": "cylinder-step", "on": "sim", "rig": "cylinder",
    "set": {"approach": "0.2 s"}, "vary": {"controllers.pid.proportional": [1, 2]},
    "seeds": "0:3", "metric": "rise_time", "stop_when": "overshoot > 3", "budget": "2 points",
    "keep": 1, "workers": 1, "draw_seed": 3, "perturbation": {"friction": 0.1},
}  # fmt: skip
PLACES_OF_ARM = "x (mm),y (mm),z (mm)\n120,0,0\n60,0,20\n0,0,0\n-60,30,-20\n-100,80,0\n"
FOOTPRINTS = (
    "foot,x (mm),y (mm),heading (deg),lift (mm)\nright,32,-38,8,\nleft,56,47,16,15\n"
    "right,106,-15,20,\nleft,80,60,20,15\n"
)
TWISTS = (
    "t (s),vx (mm/s),vy (mm/s),vz (mm/s),wx (deg/s),wy (deg/s),wz (deg/s)\n"
    "0,0,1,0,1,-10,0\n1,-50,0,0,0,0,0\n2,0,0,0,0,0,0\n"
)
READINGS = "quantity,stretch,value\n"


def written_in_file(name, csv):
    """Return an experiment whose reference stands in a file beside it."""
    content = yaml.safe_load((ROOT / "configs" / "experiments" / f"{name}.yaml").read_text())
    reference = content["reference"]
    for key in ("points", "steps", "rows"):
        reference.pop(key, None)
    reference["file"] = csv
    return {**content, "name": f"my-{name}"}


def follow():
    """Do what `rig watch` does with a run that has ended, but for the sockets."""
    from rig.hal import RigError
    from rig.watching.followed_run import FollowedRun
    from rig.watching.studio import Studio

    def watch():
        try:
            run = FollowedRun(RUN)
            studio = Studio(run)
            ticks = iter(range(8))
            import asyncio

            asyncio.run(studio.work(lambda: next(ticks, None) is None))
            json.dumps([studio.described(), studio.status(), run.events], allow_nan=True)
        except RigError as error:
            print(repr(str(error)))  # noqa: T201 - what the command line would say
            return 2
        return 0

    return watch


def words(*given):
    """Return a call of the command line."""

    def call():
        return invoke(list(given))

    call.words = given
    return call


CALIBRATION = "configs/calibration/cylinder"
READERS = {
    "calibration": (
        f"{CALIBRATION}/encoder-agonist.yaml", as_sealed_yaml,
        [
            words("check", "cylinder", "--values", "devices", *CONFIGS),
            words("status", "cylinder", "--out", "runs", *CONFIGS),
            words("calibrate", "cylinder", "encoders", "--dry-run", *CONFIGS),
            words("calibrate", "cylinder", "--history", "encoder-agonist", *CONFIGS),
            words("calibrate", "cylinder", "--diff", "encoder-agonist", "encoder-antagonist",
                  *CONFIGS),
        ],
    ),
    "calibration of before": (
        f"{CALIBRATION}/history/encoder-agonist/2026-01-01T000000Z.yaml", as_sealed_yaml,
        [
            words("calibrate", "cylinder", "--history", "encoder-agonist", *CONFIGS),
            words("calibrate", "cylinder", "--restore", "encoder-agonist", *CONFIGS),
            words("calibrate", "cylinder", "--restore", "encoder-agonist/2026-01-01", *CONFIGS),
            words("calibrate", "cylinder", "--diff", "encoder-agonist",
                  "encoder-agonist/2026-01-01T000000Z", *CONFIGS),
        ],
    ),
    "gains": (
        f"{CALIBRATION}/controllers.pid.yaml", as_sealed_yaml,
        [
            words("check", "cylinder", "--values", "controllers", *CONFIGS),
            words("status", "cylinder", "--out", "runs", *CONFIGS),
            words("calibrate", "cylinder", "--history", "controllers.pid", *CONFIGS),
            words("list", "--configs", "configs", "--out", "runs"),
        ],
    ),
    "record": (
        "configs/commissioning/cylinder.yaml", as_sealed_yaml,
        [
            words("check", "cylinder", *CONFIGS),
            words("status", "cylinder", "--out", "runs", *CONFIGS),
            words("status", "cylinder", "--json", "--out", "runs", *CONFIGS),
            words("commission", "cylinder", "--dry-run", *CONFIGS),
        ],
    ),
    "answers": (
        "answers.yaml", as_yaml,
        ["answers"],
    ),
    "readings": (
        "readings.csv", None,
        ["readings"],
    ),
    "sweep": (
        "sweep.yaml", as_yaml,
        [words("check", "sweep.yaml", *CONFIGS), "sweep"],
    ),
    "journal": ("swept/points.jsonl", as_json_lines, ["journal"]),
    "scenario": ("case.yaml", as_yaml, ["scenario", words("check", "case.yaml", *CONFIGS)]),
    "path": ("path.csv", None, [words("check", "arm-path.yaml", *CONFIGS)]),
    "footprints": ("feet.csv", None, [words("check", "legs-footsteps.yaml", *CONFIGS)]),
    "twists": ("twists.csv", None, [words("check", "arm-twist.yaml", *CONFIGS)]),
    "urdf": (
        "arm.urdf", None,
        [
            words("new", "rig", "drawn", "--urdf", "arm.urdf", *CONFIGS),
            words("new", "rig", "drawn", "--urdf", "arm.urdf", "--tip", "tool0", *CONFIGS),
        ],
    ),
    "Denavit-Hartenberg": (
        "dh.yaml", as_yaml, [words("new", "rig", "drawn", "--dh", "dh.yaml", *CONFIGS)],
    ),
    "eds": (
        "device.eds", None,
        [words("check", "with-eds.yaml", *CONFIGS), words("status", "with-eds.yaml", *CONFIGS)],
    ),
    "interfaces": (
        "state/rig/interfaces", None,
        [
            words("check", "multicast.yaml", *CONFIGS),
            words("doctor", "multicast.yaml", *CONFIGS),
        ],
    ),
    **{
        f"profile {name}": (
            f"configs/rigs/{name}.yaml", as_yaml,
            [
                words("check", name, *CONFIGS),
                words("check", name, "--values", *CONFIGS),
                words("status", name, "--out", "runs", *CONFIGS),
                words("list", "rigs", *CONFIGS),
                words("new", "rig", "mine", "--like", name, *CONFIGS),
            ],
        )
        for name in ("cylinder-valves", "legs-balance", "arm-irb-120", "legs-can", "joint-fine")
    },
    "latch": (
        "state/rig/cylinder.fault", as_json,
        [
            words("status", "cylinder", "--out", "runs", *CONFIGS),
            words("status", "cylinder", "--json", "--out", "runs", *CONFIGS),
            words("reset", "cylinder", "--on", "sim", "--yes", "cylinder", *CONFIGS),
            words("doctor", "cylinder", *CONFIGS),
        ],
    ),
    **{
        f"run's {name}": (
            f"{RUN}/{name}", form,
            [
                words("list", "runs", "--out", "runs", *CONFIGS),
                words("explain", RUN, "--runs", "runs", *CONFIGS),
                words("status", "cylinder", "--out", "runs", *CONFIGS),
                words("diff", RUN, "runs/other"),
                words("replay", RUN, "--out", "replayed"),
                words("replay", RUN, "--frames"),
                words("export", RUN, "--format", "csv", "--out", "x.csv"),
                words("export", RUN, "--format", "mcap", "--out", "x.mcap"),
                words("monitor", "cylinder", "--frames", f"{RUN}/frames.log", *CONFIGS),
                follow(),
                words("report", RUN),
            ],
        )
        for name, form in {
            "manifest.json": as_json, "metrics.json": as_json, "evaluation.json": as_json,
            "timing.json": as_json, "events.jsonl": as_json_lines, "profile.yaml": as_yaml,
            "experiment.yaml": as_yaml, "log.mcap": None, "frames.log": None, "frames.ways": None,
        }.items()
    },
}  # fmt: skip
"""Of each kind of file: where it is, how data become one, and what reads it."""


def load_sweep_file():
    from rig.cli.sweep import sweep  # noqa: F401 - its import is no part of what is measured
    from rig.hal import RigError
    from rig.sweeping.sweep_file import is_sweep_file, load_sweep

    try:
        if is_sweep_file("sweep.yaml"):
            request = load_sweep(Path("sweep.yaml"))
            for axis in request.axes:
                len(axis.texts)
    except RigError as error:
        print(repr(str(error)))  # noqa: T201
        return 2
    return 0


def go_on_with_journal():
    from rig.hal import RigError
    from rig.sweeping.journal import Journal

    try:
        journal = Journal(Path("swept"))
        for name in ("ab" * 16, "cd" * 16):
            if name in journal:
                found = journal[name]
                [metric["name"] + metric["unit"] for metric in found["metrics"]]
                [float(metric["value"]) for metric in found["metrics"]]
        journal.close()
    except RigError as error:
        print(repr(str(error)))  # noqa: T201
        return 2
    return 0


def tell_scenario():
    from rig.cli.faults import _scenario_job
    from rig.hal import RigError

    try:
        _scenario_job(Path("case.yaml"), Path("configs"))
    except RigError as error:
        print(repr(str(error)))  # noqa: T201
        return 2
    return 0


def answers():
    from rig.commissioning.record import read_answers
    from rig.hal import RigError

    try:
        read_answers(Path("answers.yaml"))
    except RigError as error:
        print(repr(str(error)))  # noqa: T201
        return 2
    return 0


def readings():
    from rig.calibration.instrument_files import read_file
    from rig.calibration.instruments import Instrument
    from rig.hal import RigError

    try:
        read_file([Instrument("caliper agonist", "m", 1e-5, ("zero",), "x")], Path("readings.csv"))
    except RigError as error:
        print(repr(str(error)))  # noqa: T201
        return 2
    return 0


OWN = {
    "answers": answers,
    "readings": readings,
    "sweep": load_sweep_file,
    "journal": go_on_with_journal,
    "scenario": tell_scenario,
}


def make_lab(lab):
    """Fill a folder with a healthy file of every kind."""
    configs = lab / "configs"
    ignored = shutil.ignore_patterns("commissioning", "calibration")
    shutil.copytree(ROOT / "configs", configs, ignore=ignored)
    origin = {"procedure": "encoders", "operator": "me", "backend": "virtual", "seed": 0,
              "samples": 7500, "blocks": 15, "residual_rms": 8.6e-06, "residual_max": 1.5e-05,
              "residual_bound": 5e-05, "unit": "m", "valid_until": "2099-01-01",
              "software": "rig-controller 0.1.0", "log": "x/log.mcap", "log_sha256": "ab" * 32,
              "conditions": {"supply": "7 bar"}}  # fmt: skip
    measured = [
        {"name": name, "value": value, "unit": unit, "std": 1e-5, "procedure": "encoders",
         "interval": [value - 2e-5, value + 2e-5], "backend": "virtual", "date": DATE,
         "valid_until": "2099-01-01"}
        for name, value, unit in (("scale", 1.0001, "1"), ("offset", 2e-5, "m"))
    ]  # fmt: skip
    values = {"scale": 1.0001, "offset": "2e-5 m", "reversed": False}
    for date in (DATE, LATER):
        content = {"values": values, "measured": measured, "provenance": {**origin, "date": date}}
        for target in ("encoder-agonist", "encoder-antagonist"):
            write(configs, "cylinder", target, content)
    gains = {"proportional": 1.1, "integral": 2.2}
    known = load_profile("cylinder", REGISTRY, (), [configs]).controllers["pid"]
    gains = {name: getattr(known, name) for name in gains if hasattr(known, name)}
    tuned = [{"name": name, "value": value, "unit": "", "std": 0.0, "interval": [value, value],
              "procedure": "tune"} for name, value in gains.items()]  # fmt: skip
    told = {"procedure": "tune", "date": DATE, "operator": "me", "backend": "profile", "seed": 0,
            "valid_until": "2099-01-01", "software": "rig-controller 0.1.0",
            "conditions": {"code": "ab", "hunting": "0.1 mm"}}  # fmt: skip
    write(configs, "cylinder", "controllers.pid",
          {"values": gains, "measured": tuned, "provenance": told}, "tune")  # fmt: skip
    profile = load_profile("cylinder", REGISTRY, (), [configs])
    record = new_record(profile, "virtual", "me", "2099-01-01")
    record["steps"] = {
        "bus": {"passed": True, "date": DATE, "found": {"can0": [16, 32]}, "values": {"x": 1.0}},
        "identity": {"passed": False, "date": DATE, "reason": "no answer"},
    }
    write_record(configs, record)
    for name in ("mine", "other"):
        said = ["run", "cylinder-step", "--on", "virtual", "--frames=log", "--out", str(lab / "r"),
                "--no-report", "--seed", "1", *SHORT, "--configs", str(configs)]  # fmt: skip
        assert invoke(said) in (0, 1)
        (made,) = (lab / "r").iterdir()
        (lab / "runs").mkdir(exist_ok=True)
        made.rename(lab / "runs" / name)
    (lab / "answers.yaml").write_text(yaml.safe_dump({"emergency-stop": "yes", "gauge": "8 kPa"}))
    (lab / "readings.csv").write_text(READINGS + "caliper agonist,zero,30 mm\n")
    (lab / "sweep.yaml").write_text(yaml.safe_dump(SWEEP, sort_keys=False))
    (lab / "case.yaml").write_text(yaml.safe_dump(SCENARIO, sort_keys=False))
    (lab / "swept").mkdir()
    metrics = [{"name": "rise_time", "value": 0.028, "unit": "s", "bound": 1.0, "kind": "max"},
               {"name": "settling_time", "value": float("inf"), "unit": "s", "bound": None,
                "kind": None}]  # fmt: skip
    lines = [{"point": point * 16, "status": "ok", "reason": "", "metrics": metrics}
             for point in ("ab", "cd")]  # fmt: skip
    (lab / "swept" / "points.jsonl").write_bytes(as_json_lines(lines))
    for name, text, experiment in (
        ("path.csv", PLACES_OF_ARM, "arm-path"), ("feet.csv", FOOTPRINTS, "legs-footsteps"),
        ("twists.csv", TWISTS, "arm-twist"),
    ):  # fmt: skip
        (lab / name).write_text(text)
        content = written_in_file(experiment, name)
        (lab / f"{experiment}.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    arms = ROOT / "tests" / "data" / "arms"
    shutil.copyfile(arms / "irb-120.urdf", lab / "arm.urdf")
    shutil.copyfile(arms / "puma-560.yaml", lab / "dh.yaml")
    shutil.copyfile(configs / "eds" / "cia401-analogue.eds", lab / "device.eds")
    (lab / "with-eds.yaml").write_text(
        "extends: cylinder\nname: with-eds\ndevices:\n  regulators: {eds: device.eds}\n"
    )
    (lab / "multicast.yaml").write_text(
        "extends: cylinder\nname: multicast\nbuses:\n"
        '  can0: {interface: socketcan, channel: "239.74.163.2"}\n'
    )
    (lab / "state" / "rig").mkdir(parents=True)
    (lab / "state" / "rig" / "interfaces").write_text("udp_multicast 239.74.163.2\n")
    (lab / "state" / "rig" / "cylinder.fault").write_text(
        json.dumps({"fault": "limit", "since": DATE, "run": "runs/mine"}) + "\n"
    )
