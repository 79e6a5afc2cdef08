"""Changes of a page from the thread that computes: in the browser's session, or in a notebook's own thread."""

import asyncio
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import panel as pn


class Posts:
    """Changes that are made one after the other where the page lives: in the session it is made in, or a notebook."""

    def __init__(self, panes: Callable[[], Sequence[Any]]) -> None:
        """``panes()`` are those with figures, of which a notebook does not hear by itself."""
        document = pn.state.curdoc
        self._document: Any = document if document is not None and document.session_context is not None else None
        self._panes = panes
        self._waiting: deque[Callable[[], None]] = deque()
        self._loop = _running_loop() if self._document is None else None

    @property
    def in_browser(self) -> bool:
        """Whether the page is one of a server's, with an address."""
        return self._document is not None

    def post(self, show: Callable[[], None]) -> None:
        """Have ``show()`` called where the page lives, from any thread."""
        if self._document is None:
            self._waiting.append(show)
            if self._loop is None:
                self._show_waiting()
            else:
                self._loop.call_soon_threadsafe(self._show_waiting)
            return

        def at_once() -> None:
            # In one message, of which the browser makes one frame.
            self._document.hold("combine")
            try:
                show()
            finally:
                self._document.unhold()

        self._document.add_next_tick_callback(at_once)

    def settle(self) -> None:
        """Make what waits: a cell that waits keeps the notebook from it."""
        if self._waiting:
            self._show_waiting()

    def _show_waiting(self) -> None:
        """In a notebook: make the changes that wait, in its own thread, since messages of two would mix."""
        while self._waiting:
            self._waiting.popleft()()
        pn.io.push_notebook(*self._panes())


def _running_loop() -> asyncio.AbstractEventLoop | None:
    """That of a notebook, which runs while its cells do."""
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None
