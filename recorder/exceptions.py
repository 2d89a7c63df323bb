"""Wrong input, told in one sentence: what it concerns, what is wrong, what to do about it."""

from pathlib import Path


class ScanError(Exception):
    """Root of every error a user can mend; the command prints it in one line and exits with status 2."""

    def __init__(self, subject: str | Path, problem: str, remedy: str) -> None:
        super().__init__(f"{subject}: {problem}; {remedy}")
        self.subject = str(subject)
        self.problem = problem
        self.remedy = remedy

    def __reduce__(self) -> tuple:
        """Rebuild from the three parts, so that an error crosses a process boundary whole."""
        return type(self), (self.subject, self.problem, self.remedy)


class UnknownFormat(ScanError):
    """A source whose format cannot be recognised, or could be several."""


class UnreadableCloud(ScanError):
    """A file that holds no readable point cloud."""


class UnreadableRecording(ScanError):
    """A file that is no scan recording, or holds no view that can be read."""


class InvalidPose(ScanError):
    """A pose that is no rigid motion, or a pose file that does not fit its clouds."""


class InvalidOption(ScanError):
    """An option whose value makes no sense for this input."""


class UnwritableOutput(ScanError):
    """A place where the output cannot be written."""


class MissingLibrary(ScanError):
    """A library that cannot be loaded on this machine."""


class ProcessingFailed(ScanError):
    """A recording whose processing ended before its results; other recordings go on."""
