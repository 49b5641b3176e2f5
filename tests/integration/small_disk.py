"""A disk of some bytes, in a mount name space of its own."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]


def on_a_small_disk(size, disk, kept, words):
    """Run in a mount name space of its own, on a disk of some bytes; keep what is left on it."""
    script = (
        f'mount -t tmpfs -o size={size} none "{disk}" && "$@"; code=$?; '
        f'cp -a "{disk}/." "{kept}"; exit $code'
    )
    return subprocess.run(
        ["unshare", "-rm", "sh", "-c", script, "sh", *words],
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip


def may_mount(folder):
    return on_a_small_disk("1m", folder, folder, ["true"]).returncode == 0
