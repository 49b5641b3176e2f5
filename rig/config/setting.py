"""A setting with the words in which somebody wrote it, for messages."""


class Setting(str):
    """An ``a.b=c`` option that was not written as ``--set``.

    Parameters
    ----------
    option : str
        As ``--set`` takes it.
    written : str
        As it was written: ``--vary a.b=c``, or ``set={'a.b': 1}``.
    """

    written: str

    def __new__(cls, option: str, written: str = "") -> "Setting":
        """Return the option as a text that knows where it came from."""
        setting = super().__new__(cls, option)
        setting.written = written
        return setting


def written(option: str) -> str:
    """Return an option as somebody wrote it."""
    return option.written if isinstance(option, Setting) else f"--set {option}"
