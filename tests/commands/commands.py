"""One call of the command line."""

from dshpm_jax.__main__ import main


def command(capsys, *arguments):
    """Exit status, standard output, and standard error, which is at most a line for each trouble."""
    try:
        status = main([str(a) for a in arguments])
    except SystemExit as stop:  # argparse
        status = stop.code
    out, err = capsys.readouterr()
    assert "Traceback" not in err
    return status, out, err
