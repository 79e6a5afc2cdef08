"""``lobex``: arguments in, files, pictures and a short summary out."""

import os
import sys
from collections.abc import Callable
from functools import partial
from typing import Any, NoReturn

_MOST = 650


def main() -> None:
    """Entry point of the ``lobex`` command; bad input is one line on standard error and exit code 2."""
    # Before NumPy is imported: JAX has a thread per core already.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Nothing slow is imported before Ctrl-C is looked after.
    from lobex.shell.quitting import ended_at_once

    try:
        with ended_at_once():
            run = _chosen()
        run()
    except BrokenPipeError:
        # The reader of a pipe, such as head, has seen enough; Python would complain again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except ValueError as error:
        _refuse(str(error))
    except OSError as error:
        # A disk that is full, a folder that went away.
        named = f"{error.filename!r}: " if error.filename is not None else ""
        _refuse(f"{named}{error.strerror or error}")
    except MemoryError as error:
        _refuse(f"memory is short ({error}); give fewer points, steps or elements, or --store DIR")
    except KeyboardInterrupt as stop:
        print(f"lobex: interrupted; {stop.args[0] if stop.args else 'nothing was written'}", file=sys.stderr)
        raise SystemExit(130) from None


def _chosen() -> Callable[[], None]:
    """What the command line asks for, ready to run."""
    import warnings

    from lobex.shell.arguments import Lobes
    from lobex.shell.cut_arguments import Orbit, Recommend
    from lobex.shell.cut_command import run_orbit, run_recommend
    from lobex.shell.explore_arguments import Explore
    from lobex.shell.explore_command import run_explore
    from lobex.shell.limit_arguments import Limit
    from lobex.shell.limit_command import run_limit
    from lobex.shell.lobes_command import run_lobes
    from lobex.shell.march_arguments import March
    from lobex.shell.march_command import run_march
    from lobex.shell.parser import parse
    from lobex.shell.reproduce_arguments import Reproduce
    from lobex.shell.reproduce_command import run_reproduce
    from lobex.shell.severity_arguments import Severity
    from lobex.shell.severity_command import run_severity
    from lobex.shell.store_arguments import Store
    from lobex.shell.store_command import run_store
    from lobex.shell.wear_arguments import Wear
    from lobex.shell.wear_command import run_wear

    runs: dict[type, Callable[[Any], None]] = {
        Lobes: run_lobes,
        Limit: run_limit,
        March: run_march,
        Orbit: run_orbit,
        Recommend: run_recommend,
        Wear: run_wear,
        Severity: run_severity,
        Explore: run_explore,
        Reproduce: run_reproduce,
        Store: run_store,
    }
    # A terminal that knows no Greek gets an escape, and not an exception once the files are written.
    sys.stdout.reconfigure(errors="backslashreplace")  # pyright: ignore[reportAttributeAccessIssue]
    command = parse({kind.__name__.lower(): kind for kind in runs}, sys.argv[1:])
    warnings.showwarning = _one_line_warning
    return partial(runs[type(command)], command)


def _refuse(message: str) -> NoReturn:
    line = " ".join(message.split())
    # Of a word without end, its beginning is enough; the remedy stands last.
    print(f"lobex: error: {line if len(line) < _MOST else f'{line[:400]} … {line[-200:]}'}", file=sys.stderr)
    raise SystemExit(2) from None


def _one_line_warning(message: object, *_: object, **__: object) -> None:
    print(f"lobex: warning: {' '.join(str(message).split())}", file=sys.stderr)


if __name__ == "__main__":
    main()
