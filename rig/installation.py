"""What the installation lacks: packages that this program needs, and who cannot do without them."""

from typing import Final

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
    "aiohttp": "'rig-controller[watch]'",
    "distributed": "'rig-controller[dask]'",
    "evdev": "'rig-controller[gamepad]'",
    "msgpack": "'python-can[multicast]'",
    "pyarrow": "'rig-controller[parquet]'",
}
"""What pip installs, by the name of what is imported."""


def missing_package(error: BaseException) -> str | None:
    """Say which package is not installed, and what installs it; None for any other error.

    A package of which only a part is missing is another version, which pip would call installed.
    """
    name = error.name if isinstance(error, ModuleNotFoundError) else None
    if name not in PACKAGES:
        return None
    return f"{name} is not installed here: pip install {PACKAGES[name]}"
