"""``lobex explore``: the page of the explorer, served until Ctrl-C."""

from importlib.util import find_spec

from lobex import _checks
from lobex.shell.explore_arguments import Explore

_KINDS = ("rub", "turning", "milling", "blading")


def run_explore(command: Explore) -> None:
    """Check everything, then serve."""
    _checks.choice("process", command.process, _KINDS)
    if command.tool_file is not None and command.frf_file is not None:
        raise ValueError("tool and frf both say what vibrates; drop one of the two")
    if command.tool_file is not None and command.process in ("rub", "blading"):
        raise ValueError(f"tool = {command.tool_file!r} is of turning or milling; say which")
    files = {"tool": command.tool_file, "frf": command.frf_file}
    paths = {name: _checks.place(name, path) for name, path in files.items() if path is not None}
    for name, path in paths.items():
        if not path.is_file():
            raise ValueError(f"{name} = {str(path)!r} is no file; give the path of one")
    for package in ("panel", "bokeh"):
        if find_spec(package) is None:
            raise ValueError(f"explore takes {package}, which is not installed; run pip install 'lobex[explore]'")

    # JAX is slow to import: only now.
    from lobex.shell.environment import prepare_jax

    prepare_jax()
    from lobex.explorer.files_read import UNITS, of_response, of_tool
    from lobex.explorer.serving import serve
    from lobex.explorer.state import STARTS

    state = STARTS[command.process]
    if "tool" in paths:
        state = of_tool(paths["tool"], state)
    if "frf" in paths:
        state, report = of_response(paths["frf"], state, command.frf_unit or UNITS[0])
        print(report)
    serve(state, command.port, command.show)
