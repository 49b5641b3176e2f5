"""A package to begin with: a law, a driver or a mechanism, with its test and an experiment."""

import keyword
import re
from importlib.resources import files
from pathlib import Path
from typing import Final, Literal

from rig.config.plain_dump import plain_text
from rig.hal import ConfigurationError
from rig.hal.files import reason_unwritten
from rig.scaffolding.names import Spelling, spell
from rig.whole_file import whole_folder, write_whole

PackageKind = Literal["controller", "driver", "mechanism"]

_TEMPLATES: Final = "rig.scaffolding.templates"
_PLACEHOLDER: Final = {
    "controller": spell("my-law"),
    "driver": spell("my-sensor"),
    "mechanism": spell("my-rig"),
}
_ENTRY: Final = {
    "controller": """\
[project.entry-points."rig.additions"]
{0}-for-cylinder = "{1}.parts:FOR_CYLINDER"
""",
    "driver": """\
[project.entry-points."rig.drivers"]
{0} = "{1}.parts:PARTS"
""",
    "mechanism": """\
[project.entry-points."rig.mechanisms"]
{0} = "{1}.parts:PARTS"
""",
}
_PROFILE: Final = {
    "controller": """\
extends: cylinder
description: The pair of cylinders, with a law of our own beside the others
additions: [{0}-for-cylinder]   # without it no code of your package runs
controllers:
  {1}:                      # the settings of your law
    proportional: 5e7 Pa/m
    integral: 2e8 Pa/(m s)
    derivative: 2.5e6 Pa s/m
""",
    "driver": """\
extends: cylinder
description: The pair of cylinders, with a sensor of our own that is logged
loop:
  rate: 500 Hz              # at 1 kHz one more node is too much for the bus
devices:
  {1}:
    driver: {1}
    bus: can0
    node: 0x30
    full_scale: 100         # what 32767 counts are, in ...
    offset: 0               # what 0 counts are
    unit: N                 # ... the sensor's unit, which the log says: N, degC, bar
    measures: agonist       # simulated, it shows this channel: of a cylinder its wire's tension, N
""",
    "mechanism": """\
description: A mechanism of our own, on a CiA 402 drive
mechanism: {1}
loop:
  rate: 250 Hz
buses:
  can0: {{interface: socketcan, channel: can0, bitrate: 1 Mbit/s}}
devices:
  drives:
    driver: cia402          # or dynamixel, odrive: `rig explain cia402` says what each takes
    bus: can0
    joints:
      axis:
        node: 1
        counts_per_turn: 65536
        gear: 20
        limits: [-3.2 rad, 3.2 rad]
        max_speed: 6 rad/s
{1}:
  servos: [drives]
  limits: {{following: 0.1 rad, reading_age: 30 ms, acceleration: 40 rad/s^2}}
controllers:
  trimmed: {{}}
plant:
  model: {1}
""",
}
_SINE: Final = """\
description: A slow sine, as a first run of {0}
rig: {0}-rig
controller: {1}
reference: {{kind: sine, amplitude: 5 mm, tones: [{{frequency: 0.25 Hz, periods: 2}}]}}
metrics:
  tracking_rms: {{max: 3 mm}}
figures: [tracking, error, pressures{2}]
"""
_TURNS: Final = """\
description: There and back, as a first run of {0}
rig: {0}-rig
controller: {1}
reference: {{kind: {0}-turns, angle: 90 deg}}
approach: 1 s
figures: [timing]
"""
_FIRST: Final = {
    "controller": ("sine", "{0}", _SINE),
    "driver": ("sine", "cascade", _SINE),
    "mechanism": ("turns", "trimmed", _TURNS),
}
"""Of the first experiment: what it is called after, the law, and the file."""
_CLASS: Final = re.compile(r"\b[A-Z]\w+\b")
_PROJECT: Final = """\
[build-system]
requires = ["hatchling>=1.26"]
build-backend = "hatchling.build"

[project]
name = "{0}"
version = "0.1.0"
requires-python = ">=3.11"
dependencies = ["rig-controller"]

[project.optional-dependencies]
test = ["pytest>=8"]

# Also where this folder lies in another project, whose options would be taken otherwise.
[tool.pytest.ini_options]
testpaths = ["tests"]

# The name on the left is the one that profiles use; behind it stands the row in parts.py.
{1}
[tool.hatch.build.targets.wheel]
packages = ["src/{2}"]
"""


def package_files(kind: PackageKind, name: str) -> dict[Path, str]:
    """Return the files of a package, by their paths in its folder.

    Raises
    ------
    ConfigurationError
        Nothing can be called so.
    """
    spelling = spell(name)
    _refuse_hiding(kind, spelling)
    source = Path("src", spelling.module)
    made = {Path("pyproject.toml"): _project(kind, spelling)}
    for file, template in _templates(kind).items():
        text = _renamed(kind, template, spelling)
        if file == "suite.py":
            made[Path("tests", f"test_{spelling.module}.py")] = text
        else:
            made[source / file] = text
    made[Path("configs", "rigs", f"{profile_of(name)}.yaml")] = _PROFILE[kind].format(
        name, plain_text(name)
    )
    _, law, text = _FIRST[kind]
    column = f", device.{spelling.module}_value" if kind == "driver" else ""
    made[Path("configs", "experiments", f"{first_experiment(kind, name)}.yaml")] = text.format(
        name, plain_text(law.format(name)), column
    )
    if kind != "driver":
        made[Path("tests", "conftest.py")] = (
            '"""The suites of the rig controller, for this package."""\n\n'
            'pytest_plugins = "rig.testing.plugin"\n'
        )
    return made


def _templates(kind: PackageKind) -> dict[str, str]:
    """Return the text of each file of Python of a kind."""
    return {
        template.name: template.read_text(encoding="utf-8")
        for template in files(f"{_TEMPLATES}.{kind}").iterdir()
        if template.name.endswith(".py")
    }


def _refuse_hiding(kind: PackageKind, spelling: Spelling) -> None:
    """Refuse a name whose classes would hide others that the files use: a law called ``law``.

    Or that are no names of classes: ``True`` is a word of Python's own, and ``true`` is not.

    Raises
    ------
    ConfigurationError
        With the first such class.
    """
    old, new = _PLACEHOLDER[kind].class_name, spelling.class_name
    for file, text in _templates(kind).items():
        classes = set(_CLASS.findall(text))
        own = {found for found in classes if old in found}
        for found in sorted(own):
            made = found.replace(old, new)
            if keyword.iskeyword(made):
                raise ConfigurationError(
                    f"{spelling.dashed}: its class {made} would be a word of Python's own; choose "
                    f"another name, as my-{spelling.dashed}"
                )
            if made in classes - own:
                raise ConfigurationError(
                    f"{spelling.dashed}: its class {made} would hide another one that {file} uses; "
                    f"choose another name, as my-{spelling.dashed}"
                )


def first_experiment(kind: PackageKind, name: str) -> str:
    """Return what the experiment of a package is called."""
    return f"{name}-{_FIRST[kind][0]}"


def profile_of(name: str) -> str:
    """Return what the profile of a package is called."""
    return f"{name}-rig"


def write_files(folder: Path, made: dict[Path, str]) -> None:
    """Write files below a folder that is not there yet: all of them, or none.

    Raises
    ------
    ConfigurationError
        It is there already, or cannot be written.
    """
    if folder.exists():
        raise ConfigurationError(f"{folder} is there already; nothing was written")
    try:
        with whole_folder(folder) as beside:
            for path, text in made.items():
                target = beside / path
                target.parent.mkdir(parents=True, exist_ok=True)
                write_whole(target, text)
    except OSError as error:
        raise ConfigurationError(
            f"cannot write {folder}: {reason_unwritten(folder, error)}"
        ) from error


def _project(kind: PackageKind, spelling: Spelling) -> str:
    entry = _ENTRY[kind].format(spelling.dashed, spelling.module)
    return _PROJECT.format(spelling.dashed, entry, spelling.module)


def _renamed(kind: PackageKind, text: str, spelling: Spelling) -> str:
    text = text.replace(f"{_TEMPLATES}.{kind}", spelling.module)
    for old, new in zip(_PLACEHOLDER[kind], spelling, strict=True):
        text = text.replace(old, new)
    return text
