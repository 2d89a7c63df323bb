"""What a study's sentences say of the thesis's claims: of each the verdict, and how many there are of each kind."""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Self

VERDICTS = ("holds", "does not hold", "cannot be told")
_VERDICT = re.compile(rf"^(?P<claim>.+?): (?P<verdict>{'|'.join(VERDICTS)})(?P<evidence>[ ,;.(].*)?$", re.DOTALL)


@dataclass(frozen=True)
class Statement:
    """A sentence in its parts; without a verdict it is all claim."""

    claim: str
    verdict: str | None = None  # one of VERDICTS
    evidence: str = ""

    @classmethod
    def read(cls, sentence: str) -> Self:
        """The parts of a sentence: 'PCA beats Glorot: holds (difference +1, ...).' has all three."""
        found = _VERDICT.match(sentence)
        if found is None:
            return cls(sentence)
        return cls(found["claim"], found["verdict"], _strip(found["evidence"] or ""))


def count_verdicts(sentences: Iterable[str]) -> dict[str, int]:
    """How many sentences there are of each verdict."""
    found = Counter(Statement.read(sentence).verdict for sentence in sentences)
    return {verdict: found[verdict] for verdict in VERDICTS}


def conclude(counts: dict[str, int]) -> str:
    """The counts as one sentence."""
    holds, fails, open_ = (counts[verdict] for verdict in VERDICTS)
    total = holds + fails + open_
    if not total:
        return "No claim of the thesis was tested."
    claims = "1 claim" if total == 1 else f"{total} claims"
    return (
        f"Of {claims} tested, {holds} {'holds' if holds == 1 else 'hold'}, "
        f"{fails} {'does' if fails == 1 else 'do'} not hold, and {open_} cannot be told."
    )


def _strip(evidence: str) -> str:
    """Without the signs that join it to the verdict: ' (difference +1).' -> 'difference +1'."""
    text = evidence.strip().lstrip(",;.: ").strip()
    whole = re.fullmatch(r"\(([^()]*)\)\.?", text)
    return whole[1] if whole else text
