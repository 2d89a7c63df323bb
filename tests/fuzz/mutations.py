"""Random damage to a file that remembers where each byte came from; a number makes the same damage again."""

import struct
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

MAGIC = 8  # bytes of magic at either end of an .mcap
CHANGED = -1


@dataclass(frozen=True, eq=False)
class Bytes:
    """The bytes of a damaged file, and of each the place in the original that it came from unchanged."""

    values: np.ndarray  # (N,) uint8
    origin: np.ndarray  # (N,) int64; CHANGED where the byte is another, or new

    @classmethod
    def of(cls, content: bytes) -> "Bytes":
        """An undamaged file."""
        return cls(np.frombuffer(content, np.uint8), np.arange(len(content)))

    def whole(self, start: int, length: int) -> bool:
        """Whether a stretch of the original is in the file somewhere, unbroken."""
        wanted = np.arange(start, start + length)
        return any(np.array_equal(self.origin[at : at + length], wanted) for at in np.flatnonzero(self.origin == start))

    def splice(self, start: int, stop: int, new: np.ndarray) -> "Bytes":
        """The file with other bytes in the place of a stretch; a byte that stays as it was is unchanged."""
        origin = np.full(len(new), CHANGED)
        if len(new) == stop - start:
            origin = np.where(new == self.values[start:stop], self.origin[start:stop], CHANGED)
        return self.take(slice(0, start)).then(Bytes(new, origin)).then(self.take(slice(stop, None)))

    def take(self, where: slice) -> "Bytes":
        return Bytes(self.values[where], self.origin[where])

    def then(self, other: "Bytes") -> "Bytes":
        return Bytes(np.concatenate([self.values, other.values]), np.concatenate([self.origin, other.origin]))


def mutate(content: bytes, number: int) -> tuple[Bytes, list[str], str]:
    """A damaged copy of an .mcap, the kinds of damage done to it, and the same in words; one in four gets several."""
    rng = np.random.default_rng(number)
    undamaged = damaged = Bytes.of(content)
    kinds = [list(KINDS)[number % len(KINDS)]]
    if rng.random() < 0.25:
        kinds += list(rng.choice(list(KINDS), size=rng.integers(1, 3)))
    kinds.sort(key=lambda kind: kind not in _OF_RECORDS)  # these know the records of an undamaged file only
    records, words = find_records(content), []
    for kind in kinds:
        if kind in _OF_RECORDS and damaged is not undamaged:
            continue
        damaged, what = KINDS[kind](damaged, records, rng)
        words.append(what)
    return damaged, kinds, ", then ".join(words)


def find_records(content: bytes) -> list[tuple[int, int]]:
    """Start and end of every record of an undamaged .mcap, but of those within chunks."""
    records, start = [], MAGIC
    while start < len(content) - MAGIC:
        end = start + 9 + struct.unpack_from("<Q", content, start + 1)[0]
        records.append((start, end))
        start = end
    return records


Records = list[tuple[int, int]]
Mutation = Callable[[Bytes, Records, np.random.Generator], tuple[Bytes, str]]


def _place(file: Bytes, records: Records, rng: np.random.Generator) -> int:
    """A place anywhere, or, as often, where a record begins: most bytes are points, most trouble is in the headers."""
    if rng.random() < 0.5:
        return int(rng.integers(len(file.values)))
    start, end = records[rng.integers(len(records))]
    return min(start + int(rng.integers(min(400, end - start))), len(file.values) - 1)


def _length(rng: np.random.Generator, most: int) -> int:
    """A number of bytes: as likely between 1 and 10 as between 100 and 1000."""
    return int(np.exp(rng.uniform(0, np.log(most + 1))))


def _cut(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    at = _place(file, records, rng)
    return file.take(slice(0, at)), f"cut at {at}"


def _behead(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    at = _place(file, records, rng)
    return file.take(slice(at, None)), f"the first {at} bytes lost"


def _flip(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    places = [_place(file, records, rng) for _ in range(_length(rng, 8))]
    for at in places:
        file = file.splice(at, at + 1, file.values[at : at + 1] ^ np.uint8(1 << rng.integers(8)))
    return file, f"bits flipped at {', '.join(map(str, places))}"


def _overwrite(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    at, length = _place(file, records, rng), _length(rng, 3000)
    stop = min(at + length, len(file.values))
    return file.splice(at, stop, _rubbish(file, stop - at, rng)), f"{stop - at} bytes overwritten at {at}"


def _zero(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    at, length = _place(file, records, rng), _length(rng, len(file.values) // 2)
    stop = min(at + length, len(file.values))
    return file.splice(at, stop, np.zeros(stop - at, np.uint8)), f"{stop - at} bytes zeroed at {at}"


def _insert(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    at, length = _place(file, records, rng), _length(rng, 3000)
    return file.splice(at, at, _rubbish(file, length, rng)), f"{length} bytes inserted at {at}"


def _delete(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    at, length = _place(file, records, rng), _length(rng, len(file.values) // 2)
    return file.splice(at, at + length, np.empty(0, np.uint8)), f"{length} bytes deleted at {at}"


def _append(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    length = _length(rng, 3000)
    return file.then(Bytes(_rubbish(file, length, rng), np.full(length, CHANGED))), f"{length} bytes appended"


def _swap(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    (a, b), (c, d) = sorted(records[i] for i in rng.choice(len(records), 2, replace=False))
    parts = [slice(0, a), slice(c, d), slice(b, c), slice(a, b), slice(d, None)]
    return _join(file, parts), f"the records at {a} and {c} swapped"


def _duplicate(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    start, end = records[rng.integers(len(records))]
    at = records[rng.integers(len(records))][0]
    return _join(file, [slice(0, at), slice(start, end), slice(at, None)]), f"the record at {start} again at {at}"


def _remove(file: Bytes, records: Records, rng: np.random.Generator) -> tuple[Bytes, str]:
    start, end = records[rng.integers(len(records))]
    return _join(file, [slice(0, start), slice(end, None)]), f"the record at {start} lost"


def _join(file: Bytes, parts: list[slice]) -> Bytes:
    taken = [file.take(part) for part in parts]
    return Bytes(np.concatenate([p.values for p in taken]), np.concatenate([p.origin for p in taken]))


def _rubbish(file: Bytes, length: int, rng: np.random.Generator) -> np.ndarray:
    """Random bytes or, as often, a stretch of the file itself, which looks like records."""
    if rng.random() < 0.5 and length < len(file.values):
        start = int(rng.integers(len(file.values) - length))
        return file.values[start : start + length]
    return rng.integers(0, 256, length, dtype=np.uint8)


KINDS: dict[str, Mutation] = {
    "cut": _cut, "behead": _behead, "flip": _flip, "overwrite": _overwrite, "zero": _zero, "insert": _insert,
    "delete": _delete, "append": _append, "swap": _swap, "duplicate": _duplicate, "remove": _remove,
}  # fmt: skip
_OF_RECORDS = ("swap", "duplicate", "remove")
