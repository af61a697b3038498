"""Exit statuses of the command line."""

OK, FAILURES, WRONG_USAGE, INTERRUPTED, PIPE_CLOSED = 0, 1, 2, 130, 141
"""All went well; something could not be done or is not as it should be; the order makes no sense; Ctrl-C; whoever read
the output has gone."""
