"""``lobex``: arguments in, files, pictures and a short summary out."""

import contextlib
import io
import os
import re
import sys
import warnings
from typing import NoReturn

import tyro

from lobex.shell.arguments import Limit, Lobes
from lobex.shell.march_arguments import March
from lobex.shell.reproduce_arguments import Reproduce
from lobex.shell.store_arguments import Store
from lobex.shell.wear_arguments import Wear


def main() -> None:
    """Entry point of the ``lobex`` command; bad input is one line on standard error and exit code 2."""
    try:
        command = _parse()
        from lobex.shell.limit import run_limit
        from lobex.shell.lobes import run_lobes
        from lobex.shell.march import run_march
        from lobex.shell.reproduce import run_reproduce
        from lobex.shell.store import run_store
        from lobex.shell.wear import run_wear

        warnings.showwarning = _one_line_warning
        if isinstance(command, Limit):
            run_limit(command)
        elif isinstance(command, March):
            run_march(command)
        elif isinstance(command, Wear):
            run_wear(command)
        elif isinstance(command, Reproduce):
            run_reproduce(command)
        elif isinstance(command, Store):
            run_store(command)
        else:
            run_lobes(command)
    except BrokenPipeError:
        # The reader of a pipe, such as head, has seen enough; Python would complain again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except ValueError as error:
        _refuse(str(error))
    except KeyboardInterrupt as stop:
        print(f"lobex: interrupted; {stop.args[0] if stop.args else 'nothing was written'}", file=sys.stderr)
        raise SystemExit(130) from None


def _parse() -> Lobes | Limit | March | Wear | Store | Reproduce:
    errors = io.StringIO()
    try:
        with contextlib.redirect_stderr(errors):
            return tyro.extras.subcommand_cli_from_dict(
                {"lobes": Lobes, "limit": Limit, "march": March, "wear": Wear, "store": Store, "reproduce": Reproduce},
                prog="lobex",
                description=(
                    "Stability lobe diagrams and time marches of delayed systems: blade rub, turning and milling.\n\n"
                    "Example: lobex lobes rub --speed 50:400:351 --gain 4.5e4:4.5e6:401 --out rub"
                ),
                args=sys.argv[1:] or ["--help"],
            )
    except SystemExit as stop:
        if stop.code in (0, None):
            raise
        _refuse(_first_sentence(errors.getvalue()))


def _first_sentence(box: str) -> str:
    """The message at the top of the parser's framed error, as one line."""
    lines = []
    for line in re.sub(r"\x1b\[[0-9;]*m", "", box).splitlines():
        text = line.strip(" │")
        if text.startswith("──") and lines:
            break
        if text and not text.startswith(("╭", "╰", "──")):
            lines.append(text)
    commands = [word for word in sys.argv[1:3] if not word.startswith("-")]
    return f"{' '.join(lines)}; see {' '.join(['lobex', *commands])} --help"


def _refuse(message: str) -> NoReturn:
    print(f"lobex: error: {message}", file=sys.stderr)
    raise SystemExit(2) from None


def _one_line_warning(message: object, *_: object, **__: object) -> None:
    print(f"lobex: warning: {message}", file=sys.stderr)


if __name__ == "__main__":
    main()
