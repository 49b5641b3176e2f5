"""Compiled kernels in files, of which none runs that is not whole.

Machine code is what such a file holds: a bit that has flipped in one would end the process, or give
wrong numbers. Numba reads what is there; here a digest stands behind each file's contents. It is
the one module that plants and laws share: it knows nothing of either.
"""

import contextlib
import hashlib
import io
import logging
import os
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final, TypeVar, cast

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache

Function = TypeVar("Function", bound=Callable[..., object])

_LOG: Final = logging.getLogger(__name__)
_LENGTH: Final = hashlib.sha256().digest_size
_LEFT: Final = 3600.0
"""A file that is not whole after so long is of a process that was killed, s."""


def kept_kernel(function: Function) -> Function:
    """Compile a function when it is called, from its file if that can be trusted.

    Where no file can be written it is compiled in each process.
    """
    kernel = numba.njit(error_model="numpy")(function)
    try:
        kernel._cache = _KernelCache(function)
    except RuntimeError:  # numba found no folder that it may write to
        kernel._cache = _NoFiles()
    return cast(Function, kernel)


class _KernelCache(FunctionCache):  # type: ignore[misc]
    """Numba's cache of a function, which may be damaged, and fill the disk."""

    def __init__(self, function: Callable[..., object]) -> None:
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = _CheckedFiles(self._cache_path, self._impl.filename_base, stamp)

    def load_overload(self, sig: object, target_context: object) -> object:
        found = super().load_overload(sig, target_context)
        if found is None:  # then it is compiled, which takes seconds: whoever waits may hear of it
            _LOG.info("compiling kernels for this machine, once")
        return found

    def save_overload(self, sig: object, data: object) -> None:
        # A disk that is full, or not writable any more, must not end what the kernel is for; nor
        # need anybody be warned of a kernel that numba keeps none of, compiled as it was told to.
        with contextlib.suppress(OSError), warnings.catch_warnings():
            warnings.simplefilter("ignore", numba.NumbaWarning)
            super().save_overload(sig, data)


class _NoFiles(NullCache):  # type: ignore[misc]
    """Says that a kernel is compiled, and by each process anew."""

    def load_overload(self, sig: object, target_context: object) -> object:
        _LOG.info("compiling kernels, which no folder here can keep")
        return super().load_overload(sig, target_context)


class _CheckedFiles(IndexDataCacheFile):  # type: ignore[misc]
    """Numba's index of a function and its files of machine code; what is damaged is not there.

    Pickle reads no further than its own end, so the digest behind it is in nobody's way.
    """

    def load(self, key: object) -> object:
        entry = super().load(key)
        # Processes that began together, or one that was killed, may have left another kernel there.
        return entry[1] if entry is not None and entry[0] == self._mark(key) else None

    def save(self, key: object, data: object) -> None:
        super().save(key, (self._mark(key), data))

    def _mark(self, key: object) -> tuple[object, ...]:
        return self._version, self._source_stamp, key

    def _load_index(self) -> object:
        if not _is_whole(self._index_path):
            return {}
        try:
            return super()._load_index()
        except Exception:  # written with another numpy, say, whose types cannot be had here
            return {}

    def _load_data(self, name: str) -> object:
        path = self._data_path(name)
        if not _is_whole(path):
            raise FileNotFoundError(path)  # numba goes on as if there were none
        try:
            return super()._load_data(name)
        except Exception as error:
            raise FileNotFoundError(path) from error

    @contextlib.contextmanager
    def _open_for_write(self, path: str) -> Iterator[io.BytesIO]:
        content = io.BytesIO()
        yield content
        with contextlib.suppress(OSError):
            # A file is not moved over a folder. One with something in it is somebody's: it stays,
            # and each process compiles.
            os.rmdir(path)  # noqa: PTH106
        with super()._open_for_write(path) as file:
            file.write(content.getvalue() + _digest(path, content.getvalue()))
        _clear_left_over(Path(path))


def _clear_left_over(written: Path) -> None:
    """Take away what processes that were killed had begun beside a file that was just written."""
    with contextlib.suppress(OSError):
        now = written.stat().st_mtime
        for path in written.parent.glob("*.nb[ci].tmp.*"):
            with contextlib.suppress(OSError):  # another one takes it away as well
                if now - path.lstat().st_mtime > _LEFT:
                    path.unlink()


def _is_whole(path: str) -> bool:
    """Return whether a file is as it was written; a pipe, which would make it wait, is not read."""
    try:
        content = Path(path).read_bytes() if Path(path).is_file() else b""
    except OSError:
        return False
    return content[-_LENGTH:] == _digest(path, content[:-_LENGTH])


def _digest(path: str, content: bytes) -> bytes:
    """Return the digest of a file and its name: one under another's name is not that one."""
    return hashlib.sha256(Path(path).name.encode() + content).digest()
