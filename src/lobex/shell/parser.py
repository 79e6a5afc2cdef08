"""From the words of a command line to one command, and the parser's complaints as one line."""

import contextlib
import io
import re
from collections.abc import Sequence
from typing import Any, get_args

import tyro
from tyro.constructors import ConstructorRegistry, PrimitiveConstructorSpec, PrimitiveTypeInfo

from lobex import _checks

_DESCRIPTION = """Stability lobe diagrams and time marches of delayed systems: blade rub, turning and milling.

Example: lobex lobes rub --speed 50:400:351 --gain 4.5e4:4.5e6:401 --out rub

lobex --version tells the version.
"""


_RULE = re.compile(r"[╭╰]|[─-]{3,}$")


def parse(commands: dict[str, Any], words: Sequence[str]) -> Any:
    """The command that the words ask for; SystemExit after --help and --version.

    Raises:
        ValueError: for words that are no command, in one line.
    """
    if list(words) == ["--version"]:
        from lobex import __version__

        print(f"lobex {__version__}")
        raise SystemExit(0)
    errors = io.StringIO()
    try:
        with contextlib.redirect_stderr(errors), _numbers():
            return tyro.extras.subcommand_cli_from_dict(
                commands, prog="lobex", description=_DESCRIPTION, args=list(words) or ["--help"]
            )
    except SystemExit as stop:
        if stop.code in (0, None):
            raise
        named = [word for word in words[:2] if not word.startswith("-")]
        raise ValueError(f"{_first_sentence(errors.getvalue())}; see {' '.join(['lobex', *named])} --help") from None


def _first_sentence(box: str) -> str:
    """The message of the parser's framed error, as one line: what stands between its first rule and the next.

    The title stands in the first rule or, where the terminal has no characters for frames, above it.
    """
    parts: list[list[str]] = [[]]
    for line in re.sub(r"\x1b\[[0-9;]*m", "", box).splitlines():
        text = line.strip(" │")
        if _RULE.match(text):
            parts.append([])
        elif text:
            parts[-1].append(text)
    return " ".join(next((part for part in parts[1:] if part), parts[0]))


def _numbers() -> ConstructorRegistry:
    """How numbers are read, also those that may be left out: each complaint names the word and what it should be."""
    registry = ConstructorRegistry()

    @registry.primitive_rule
    def _(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
        kind: Any = next((part for part in get_args(info.type) if part is not type(None)), info.type)
        optional = type(None) in get_args(info.type)
        if kind not in _KINDS or not (optional or info.type is kind):
            return None
        metavar, what = _KINDS[kind]

        def read(words: list[str]) -> Any:
            try:
                return kind(words[0])
            except ValueError:
                raise ValueError(f"{_checks.brief(words[0])} is not {what}") from None

        return PrimitiveConstructorSpec(
            nargs=1,
            metavar=metavar,
            instance_from_str=read,
            is_instance=lambda value: isinstance(value, kind) or (optional and value is None),
            str_from_instance=lambda value: [str(value)],
        )

    return registry


_KINDS = {int: ("INT", "a whole number"), float: ("FLOAT", "a number")}
