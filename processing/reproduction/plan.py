"""How large a reproduction is, and where it is kept."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from orbitscan.recorder.exceptions import InvalidOption, setting

Progress = Callable[[Iterable[Any], int, str], Iterator[Any]]


def silent(items: Iterable[Any], total: int, what: str) -> Iterator[Any]:
    """The items themselves: no progress is shown."""
    return iter(items)


@dataclass(frozen=True)
class Plan:
    """What all studies of a reproduction share. Raises InvalidOption for a fraction or runs out of range."""

    folder: Path
    runs: int = 10  # thesis: 10 of each structure (table 5.1), 20 of each initialisation (table 5.4)
    fraction: float = 1.0  # of the thesis's views
    dataset: Path | None = None  # the Washington RGB-D Object dataset; None: the virtual corpus
    device: str = "cpu"
    precision: Literal["float32", "bfloat16"] = "float32"  # of the networks
    workers: int = 1  # runs at the same time, a thread each
    progress: Progress = silent

    def __post_init__(self) -> None:
        if not 0 < self.fraction <= 1:
            raise InvalidOption(setting("fraction", self.fraction), "is not a share of the views", "give 0.01 to 1")
        if self.runs < 1:
            raise InvalidOption(setting("runs", self.runs), "leaves nothing to show", "give 1 or more")

    @property
    def every(self) -> int:
        """Every n-th view of a circle is used: this is n."""
        return max(1, round(1 / self.fraction))

    @property
    def seeds(self) -> range:
        """The seed of each run, the same in all studies, so that runs are compared in pairs."""
        return range(self.runs)
