"""What the chunks of a study warn of, said once."""

import re
from collections import Counter
from collections.abc import Iterable

from lobex._warnings import Warned, warn

_NUMBER = re.compile(r"[-+]?\d[\d.]*(?:e[-+]?\d+)?(?:, …)?")


class Collected:
    """Warnings that differ in their numbers alone count as one."""

    def __init__(self) -> None:
        self.first: dict[Warned, str] = {}
        self.count = Counter[Warned]()

    def add(self, warned: Iterable[Warned]) -> None:
        """Of a chunk."""
        for category, text in warned:
            kind = category, _NUMBER.sub("#", text)
            self.first.setdefault(kind, text)
            self.count[kind] += 1

    def say(self, chunks: int) -> None:
        """Warn now, of each kind once, with its first text."""
        for kind, text in self.first.items():
            count = self.count[kind]
            more = f" (the first of {count} such warnings in {chunks} chunks)" if count > 1 else ""
            warn(text + more, kind[0])
