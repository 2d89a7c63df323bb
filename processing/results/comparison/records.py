"""What a comparison says of a view, a session, a batch: what each is in A and in B, which is better. All frozen."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

from orbitscan.processing.results.status import METHODS, Method

Verdict = Literal["worse", "changed", "better", "same"]  # in the order in which they are told
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)


@dataclass(frozen=True)
class Difference:
    """A quantity in A and in B, and the change that is no more than chance."""

    a: float
    b: float
    floor: float

    @property
    def verdict(self) -> Verdict:
        """Of an error: less is better."""
        if abs(self.b - self.a) <= self.floor:
            return "same"
        return "worse" if self.b > self.a else "better"

    @property
    def size(self) -> float:
        """The change in floors."""
        return abs(self.b - self.a) / self.floor


@dataclass(frozen=True)
class ViewComparison:
    """A view by one method in A and in B."""

    method: Method
    view: int
    status_a: str
    status_b: str
    errors: Mapping[str, Difference]  # by name; empty where they are not judged
    moved_m: float | None  # how far apart A and B put the object's centre; None where one does not place the view
    moved_deg: float | None
    floor_m: float | None  # of the motion; None where it is not judged
    verdict: Verdict
    size: float  # of the change: infinite for a status, else in floors


@dataclass(frozen=True)
class Category:
    """What a session, or one of its views alone, is taken for; `unknown` where the model does not know it."""

    a: str
    b: str
    verdict: Verdict


@dataclass(frozen=True)
class Totals:
    """A method over all views that are in A and in B, in A and in B."""

    failed: tuple[int, int]  # views that are not ok
    center_error_m: tuple[float, float] | None  # the largest, of views that are not ok too; None without truth
    seconds: tuple[float, float] | None  # of all its stages; they count for nothing


@dataclass(frozen=True)
class SessionComparison:
    """A session in A and in B."""

    name: str
    notes: tuple[str, ...]  # what else differs: the input, settings, methods, views
    identical: bool  # the same results to the byte
    views: tuple[ViewComparison, ...] = ()  # those in both, by every method in both
    methods: Mapping[Method, Totals] = field(default_factory=dict)  # those in both, worst to best
    category: Category | None = None
    view_categories: Mapping[int, Category] = field(default_factory=dict)  # that differ; they count for nothing

    @property
    def verdict(self) -> Verdict:
        """Worse where anything is."""
        found = {view.verdict for view in self.views} | ({self.category.verdict} if self.category else set())
        return next(verdict for verdict in VERDICTS if verdict in {*found, "same"})

    @property
    def changed_views(self) -> list[ViewComparison]:
        """Worst first, then what is neither, then the better ones; each by the size of the change."""
        changed = [view for view in self.views if view.verdict != "same"]
        return sorted(changed, key=lambda v: (VERDICTS.index(v.verdict), -v.size, -METHODS.index(v.method), v.view))

    def count(self, verdict: Verdict) -> int:
        """How many views, each by each method, have a verdict."""
        return sum(view.verdict == verdict for view in self.views)


@dataclass(frozen=True)
class Comparison:
    """All that A and B have, worst first."""

    sessions: tuple[SessionComparison, ...]
    only_a: tuple[str, ...] = ()  # sessions that B lacks: lost
    only_b: tuple[str, ...] = ()

    def count(self, verdict: Verdict) -> list[SessionComparison]:
        """The sessions of a verdict."""
        return [session for session in self.sessions if session.verdict == verdict]

    @property
    def is_worse(self) -> bool:
        """Whether B is worse anywhere, or lost a session."""
        return bool(self.only_a or self.count("worse"))
