"""Wrong input, told in one sentence: what it concerns, what is wrong, what to do about it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from string import Formatter
from typing import Any, Self

Values = Mapping[str, Any]  # of settings, by their names in Python; None where one is named without a value


def as_keywords(settings: Values) -> str:
    """Settings as Python writes them: `units='mm', axes`."""
    values = {name: str(value) if isinstance(value, str | Path) else value for name, value in settings.items()}
    return ", ".join(name if value is None else f"{name}={value!r}" for name, value in values.items())


class Wording(str):
    """Words that speak of settings: a text as Python writes it, from which a command can write its own.

    Each `{name}` of the template is a setting, with its value where one is given: the text of `Wording("pass {units}",
    units="mm")` is `pass units='mm'`, and a command names its flag instead.
    """

    parts: tuple[str | Values, ...]

    def __new__(cls, template: str, **values: Any) -> Self:
        parts: list[str | Values] = []
        for text, name, _, _ in Formatter().parse(template):
            parts += [text, {name: values.get(name)}] if name else [text]
        return cls.of(*parts)

    @classmethod
    def of(cls, *parts: str | Values) -> Self:
        """A wording of texts and of settings, one or several together."""
        wording = super().__new__(cls, _spell(parts, as_keywords))
        wording.parts = parts
        return wording

    def __reduce__(self) -> tuple:
        """Rebuild from the parts, so that an error crosses a process boundary whole."""
        return type(self).of, self.parts


def _spell(parts: Iterable[str | Values], spell: Callable[[Values], str]) -> str:
    return "".join(part if isinstance(part, str) else spell(part) for part in parts)


def spelled(text: str, spell: Callable[[Values], str]) -> str:
    """The text, in which `spell` has written the settings, where it is a Wording."""
    return _spell(text.parts, spell) if isinstance(text, Wording) else text


def setting(name: str, value: Any = None) -> Wording:
    """One setting alone, as the subject of an error."""
    return Wording.of({name: value})


class ScanError(Exception):
    """Root of every error a user can mend; the command prints it in one line and exits with status 2."""

    def __init__(self, subject: str | Path, problem: str, remedy: str) -> None:
        super().__init__(f"{subject}: {problem}; {remedy}")
        self.subject = str(subject) if isinstance(subject, Path) else subject
        self.problem = problem
        self.remedy = remedy

    def __reduce__(self) -> tuple:
        """Rebuild from the three parts, so that an error crosses a process boundary whole."""
        return type(self), (self.subject, self.problem, self.remedy)

    def spelled(self, spell: Callable[[Values], str]) -> str:
        """The sentence, its settings written as `spell` does."""
        subject, problem, remedy = (spelled(part, spell) for part in (self.subject, self.problem, self.remedy))
        return f"{subject}: {problem}; {remedy}"


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
