"""The page served to this machine alone."""

import socket
from typing import Any

from lobex import _checks
from lobex.explorer.state import State

ADDRESS = "127.0.0.1"
# Of a message from the browser, bytes: files come in as one, a third longer than they are.
_MOST_MESSAGE = 12_000_000
_HIGHEST_PORT = 65535


def serve(state: State, port: int = 0, show: bool = True, **more: Any) -> Any:
    """Serve the page on 127.0.0.1, and stay until it is ended.

    Args:
        state: that a page begins with whose link says nothing else.
        port: to listen at; 0 for any that is free.
        show: open it in the browser.
        more: of ``panel.serve``, for tests.

    Raises:
        ValueError: for a port that is taken, or none.
    """
    import panel as pn

    from lobex.explorer.addresses import query_of, state_of_query
    from lobex.explorer.page import Explorer

    chosen = free_port(port)

    def page() -> Any:
        query = pn.state.location.search if pn.state.location is not None else ""
        told = ""
        try:
            begun = state_of_query(query) if query else state
        except ValueError as error:
            begun, told = state, str(error)
        explorer = Explorer(begun)
        if told:
            explorer.status.say(told)
        pn.state.on_session_destroyed(lambda _: explorer.close())
        return explorer

    pn.extension("tabulator", notifications=False)
    print(f"lobex explore: http://{ADDRESS}:{chosen}/?{query_of(state)}", flush=True)
    return pn.serve(
        {"/": page},
        port=chosen,
        address=ADDRESS,
        websocket_origin=[f"{ADDRESS}:{chosen}", f"localhost:{chosen}"],
        websocket_max_message_size=_MOST_MESSAGE,
        show=show,
        title="lobex explore",
        **{"verbose": False, **more},
    )


def free_port(port: int) -> int:
    """The port, or one that nobody listens at.

    Raises:
        ValueError: for a port that is taken, or none.
    """
    if not isinstance(port, int) or not 0 <= port <= _HIGHEST_PORT:
        raise ValueError(
            f"port = {_checks.brief(port)} is none; give 1024 to {_HIGHEST_PORT}, or 0 for any that is free"
        )
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((ADDRESS, port))
        except OSError as error:
            raise ValueError(f"port = {port} cannot be listened at ({error.strerror}); give another, or 0") from None
        return probe.getsockname()[1]
