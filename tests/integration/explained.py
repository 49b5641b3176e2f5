"""What `rig explain` says."""

from rig.cli.commands import invoke


def said(capsys, *words):
    code = invoke(["explain", *words])
    captured = capsys.readouterr()
    return code, captured.out, captured.err
