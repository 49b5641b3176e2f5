"""What Wireshark's dissectors make of a log of frames."""

import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest

needs_tshark = pytest.mark.skipif(shutil.which("tshark") is None, reason="tshark is not installed")


def dissect(log: Path) -> Counter:
    """Return how often each service of CANopen was found, and each trouble.

    A frame that the dissector does not know as CANopen counts as ``not CANopen``; one that it
    cannot take apart, or of a service or state that it does not know, under its own text.
    """
    result = subprocess.run(
        [
            "tshark", "-r", str(log), "-d", "can.subdissector,canopen", "-T", "fields",
            "-e", "_ws.col.Protocol", "-e", "_ws.col.Info", "-e", "_ws.expert",
        ],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    found = Counter()
    for line in result.stdout.splitlines():
        protocol, info, expert = [*line.split("\t"), "", ""][:3]
        trouble = expert or "malformed" in info.lower() or "unknown" in info.lower()
        if protocol != "CANopen":
            found["not CANopen"] += 1
        elif trouble:
            found[f"trouble: {info} {expert}".strip()] += 1
        else:
            found[info.split(":")[0].split("(")[0].split("[")[0].strip()] += 1
    return found


def troubles(found: Counter) -> dict:
    """Return what the dissector did not understand."""
    return {
        what: count
        for what, count in found.items()
        if what.startswith("trouble") or what == "not CANopen"
    }
