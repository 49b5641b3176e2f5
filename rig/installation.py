"""What the installation lacks: packages that this program needs, and who cannot do without them."""

import re
import shlex
from importlib.metadata import PackageNotFoundError, requires
from importlib.util import find_spec
from pathlib import Path
from typing import Final

_CLONE: Final = Path(__file__).parents[1]
_EXTRAS: Final = {
    "aiohttp": "watch",
    "distributed": "dask",
    "evdev": "gamepad",
    "pyarrow": "parquet",
}
"""Which extra of ours brings what is imported by a name."""


def installing(name: str) -> str:
    """Return the command that installs what is imported by a name and comes with an extra of ours.

    A clone is installed as the pages say, from wherever that is asked for. Elsewhere the package
    itself is named: no index need have ours.
    """
    if not (_CLONE / "pyproject.toml").is_file():
        return f"pip install {name}"
    return f"pip install -e {shlex.quote(f'{_CLONE}[{_EXTRAS[name]}]')}"


PACKAGES: Final = {
    "annotated_types": "annotated-types",
    "can": "python-can",
    "canopen": "canopen",
    "click": "click",
    "cma": "cma",
    "cv2": "opencv-python-headless",
    "fastcrc": "fastcrc",
    "filterpy": "filterpy",
    "matplotlib": "matplotlib",
    "mcap": "mcap",
    "mujoco": "mujoco",
    "numba": "numba",
    "numpy": "numpy",
    "pydantic": "pydantic",
    "rich": "rich",
    "scipy": "scipy",
    "serial": "pyserial",
    "yaml": "pyyaml",
    "aiohttp": "aiohttp",
    "distributed": "distributed",
    "evdev": "evdev",
    "msgpack": "'python-can[multicast]'",
    "pyarrow": "pyarrow",
}
"""What pip installs, by the name of what is imported."""


BENEATH: Final = {
    "PIL": "matplotlib",
    "contourpy": "matplotlib",
    "cycler": "matplotlib",
    "dateutil": "matplotlib",
    "fontTools": "matplotlib",
    "kiwisolver": "matplotlib",
    "packaging": "matplotlib",
    "pyparsing": "matplotlib",
    "six": "matplotlib",
    "typing_extensions": "pydantic",
    "pydantic_core": "pydantic",
    "typing_inspection": "pydantic",
    "llvmlite": "numba",
    "lz4": "mcap",
    "zstandard": "mcap",
    "wrapt": "can",
    "markdown_it": "rich",
    "mdurl": "rich",
    "pygments": "rich",
    "glfw": "mujoco",
    "websockets": "mujoco",
    "OpenGL": "mujoco",
    "tzdata": "filterpy",
}
"""What comes with one of these, by the name of what is imported: pip knows which version of it."""


_CALLED: Final = {"PIL": "pillow", "dateutil": "python-dateutil"}
"""What pip calls some of those."""


def missing_package(error: BaseException) -> str | None:
    """Say which package is not installed, and what installs it; None for any other error.

    A package of which only a part is missing is another version, which pip would call installed.
    """
    name = error.name if isinstance(error, ModuleNotFoundError) else None
    if name in BENEATH:
        above = BENEATH[name]
        return f"{name}, which {above} needs, is not installed here: pip install {PACKAGES[above]}"
    if name not in PACKAGES:
        return None
    command = installing(name) if name in _EXTRAS else f"pip install {PACKAGES[name]}"
    return f"{name} is not installed here: {command}"


def need(*names: str) -> None:
    """Find out whether packages are there, before anything moves for what they are to do.

    None is imported: that would take its time. What comes with one of them has to be there, too.

    Raises
    ------
    ModuleNotFoundError
        One is not; `missing_package` says so in a sentence.
    """
    for name in names:
        for wanted in (name, *(beneath for beneath, above in BENEATH.items() if above == name)):
            if find_spec(wanted) is None and (wanted == name or _requires(name, wanted)):
                raise ModuleNotFoundError(f"No module named {wanted!r}", name=wanted)


def _requires(name: str, beneath: str) -> bool:
    """Return whether the version that is installed still requires a package."""
    try:
        wanted = requires(PACKAGES[name]) or ()
    except PackageNotFoundError:
        return False
    called = _CALLED.get(beneath, beneath).lower()
    return any(re.match(rf"{called}\b(?!-)", line.lower()) and "extra ==" not in line
               for line in wanted)  # fmt: skip
