"""What the chunks of a study warn of, said once."""

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from lobex._warnings import LobexWarning

_NUMBER = re.compile(r"[-+]?\d[\d.]*(?:e[-+]?\d+)?(?:, …)?")


class Collected:
    """Warnings that differ in their numbers alone count as one."""

    def __init__(self) -> None:
        self.first: dict[tuple[type[Warning], str], str] = {}
        self.count: dict[tuple[type[Warning], str], int] = {}

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Hold back what is warned of within."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", LobexWarning)
            yield
        for warning in caught:
            kind = warning.category, _NUMBER.sub("#", str(warning.message))
            self.first.setdefault(kind, str(warning.message))
            self.count[kind] = self.count.get(kind, 0) + 1

    def say(self, chunks: int, stacklevel: int) -> None:
        """Warn now, of each kind once, with its first text."""
        for (category, _), text in self.first.items():
            count = self.count[category, _NUMBER.sub("#", text)]
            more = f" (the first of {count} such warnings in {chunks} chunks)" if count > 1 else ""
            warnings.warn(text + more, category, stacklevel=stacklevel + 1)
