"""The tests' files in kernels of their own, as many at a time as there are processors for them."""

import asyncio
import os
import signal
import sys
from pathlib import Path

PROCESSOR = "VCAN_PROCESSOR"
"""The variable that says on which processor of the host a kernel runs."""
_NO_TESTS = 5  # pytest's, of a file in which none was chosen
_LONGEST = "test_commissioning_socketcan.py"
_HERE = Path(__file__).parent


def each_file(options: list[str], processors: list[int]) -> int:
    """Run every file; show what it said when it has ended.

    Parameters
    ----------
    options : list of str
        Pytest's.
    processors : list of int
        Of the host.

    Returns
    -------
    int
        The largest of pytest's codes; a file without a chosen test counts if all are such.
    """
    files = sorted(_HERE.glob("test_*.py"), key=lambda path: (path.name != _LONGEST, path.name))
    ran = [code for code in asyncio.run(_all(files, options, processors)) if code != _NO_TESTS]
    return max(ran, default=_NO_TESTS)


async def _all(files: list[Path], options: list[str], processors: list[int]) -> list[int]:
    task = asyncio.current_task()
    assert task is not None
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, task.cancel)
    codes: list[int] = []
    async with asyncio.TaskGroup() as group:
        for processor in processors:
            group.create_task(_work(files, options, processor, codes))
    return codes


async def _work(files: list[Path], options: list[str], processor: int, codes: list[int]) -> None:
    """Take one file after the other, until none is left."""
    while files:
        process = await asyncio.create_subprocess_exec(
            sys.executable, str(_HERE), *options, str(files.pop(0)),
            env={**os.environ, PROCESSOR: str(processor)},
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
        )  # fmt: skip
        try:
            said, _ = await process.communicate()
        finally:
            if process.returncode is None:
                process.terminate()
                await process.wait()
        codes.append(process.returncode)
        sys.stdout.buffer.write(said)
        sys.stdout.flush()
