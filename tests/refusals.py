"""What is refused, is in one line."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest


@contextmanager
def refused(words: str = "", match: str | None = None) -> Iterator[pytest.ExceptionInfo[ValueError]]:
    """A ValueError of one line, with these words, and that matches a regular expression, if one is given."""
    with pytest.raises(ValueError, match=match) as error:
        yield error
    assert words in str(error.value)
    assert "\n" not in str(error.value)
