"""What a page says of itself: whether it computes, and what was refused or is doubtful."""

from collections.abc import Callable
from html import escape
from threading import Timer
from typing import Any

import panel as pn

# s: what takes less than some tenths of a second is not announced.
_ANNOUNCED = 0.3
_READY, BUSY = "ready", "computing …"


class StatusLine:
    """Two panes of the head of a page.

    Attributes:
        busy: the words for it while something is computed.
        doubting: whether the message tells of a doubt.
        state, message: the panes.
    """

    def __init__(self, post: Callable[[Callable[[], None]], None]) -> None:
        """``post(show)`` has ``show()`` called where the page lives."""
        self.busy, self.doubting = BUSY, False
        self.state: Any = pn.pane.HTML(_READY, width=300, margin=(8, 8), name="status")
        self.message: Any = pn.pane.HTML("", sizing_mode="stretch_width", margin=(0, 8), name="message")
        self._post, self._words = post, _READY
        self._announced: Timer | None = None

    def say(self, text: str, doubt: bool = False) -> None:
        """Show a line: what was refused, or what is doubtful; nothing for no text."""
        self.doubting = doubt
        colour = "#8a5a00" if doubt else "#a3142b"
        self.message.object = f'<span style="color:{colour}">{escape(text)}</span>' if text else ""

    def failed(self, error: Exception) -> None:
        """Show what a thread ended with."""
        text = str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
        self._post(lambda: self.say(text))

    def tell(self, busy: bool) -> None:
        """Announce that something is computed, if it takes a while, or no longer is; from any thread."""
        if busy and self._announced is None:
            self._announced = Timer(_ANNOUNCED, lambda: self._post(lambda: self.show(self.busy)))
            self._announced.daemon = True
            self._announced.start()
        elif not busy and self._announced is not None:
            self._announced.cancel()
            self._announced = None
            if self._words != _READY:
                self._post(lambda: self.show(_READY))

    def show(self, words: str) -> None:
        """Show words for what the page does."""
        self._words = words
        colour = "#3b7a3b" if words == _READY else "#8a5a00"
        self.state.object = f'<span style="color:{colour}">● {words}</span>'
