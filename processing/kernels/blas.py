"""Matrix products on one thread: on several, sums are made in another order, and results differ in their last bits."""

from contextlib import ContextDecorator
from functools import cache
from typing import Any

from threadpoolctl import ThreadpoolController


class SingleThreaded(ContextDecorator):
    """A context, or a function's decorator, in which matrix products use one thread."""

    def __enter__(self) -> None:
        self._limit = _libraries().limit(limits=1, user_api="blas")
        self._limit.__enter__()

    def __exit__(self, *error: Any) -> None:
        self._limit.__exit__(*error)

    def _recreate_cm(self) -> "SingleThreaded":
        return SingleThreaded()  # calls may be nested


@cache
def _libraries() -> ThreadpoolController:
    """The libraries loaded, looked up once: that takes longer than a match."""
    return ThreadpoolController()
