"""Errors a user can act on. Each carries the exit code of the command line."""


class PamError(Exception):
    """Base of all errors that are the user's to put right; the message says what to do."""

    exit_code = 1


class UsageError(PamError):
    """A command or call asks for something that does not exist or does not fit together."""

    exit_code = 2


class FitError(PamError):
    """The fit is not valid: it did not converge, or the record does not identify the model."""

    exit_code = 3


class DataError(PamError):
    """A record or specimen file cannot be read as what it should be."""

    exit_code = 4
