"""From the flags of ``lobex wear`` and ``lobex severity`` to what ``march_wear`` takes."""

from typing import Any

from lobex import _checks
from lobex.shell.from_flags import rod_modes_of
from lobex.shell.wear_arguments import DEFAULTS, LAWS, ContactFlags


def law_numbers(flags: ContactFlags) -> dict[str, float]:
    """The numbers of the chosen law; ValueError for those of another law, and for missing ones."""
    _checks.choice("law", flags.law, tuple(LAWS))
    own = LAWS[flags.law]
    given: dict[str, Any] = {name: value for name, value in vars(flags).items() if name != "law" and value is not None}
    for name, value in given.items():
        if name not in own:
            raise ValueError(f"{name} = {value} has no meaning with --law {flags.law}; drop it")
    numbers = {name: given.get(name, DEFAULTS.get(name)) for name in own}
    for name, value in numbers.items():
        if value is None:
            raise ValueError(f"{name} is missing; --law {flags.law} needs --{name.replace('_', '-')}")
    return {name: float(value) for name, value in numbers.items() if value is not None}


def march_of(flags: Any) -> dict[str, Any]:
    """``modes``, ``casing`` and ``law`` of the flags, or of the file that they name and flags of what it leaves out.

    Raises:
        ValueError: for flags that say what the file says, and what the models refuse.
    """
    from lobex.contact.casing import Casing
    from lobex.contact.laws import KINDS

    casing = Casing(**vars(flags.casing))
    law = KINDS[flags.contact.law](**law_numbers(flags.contact))
    if flags.blade_file is None:
        return {"modes": rod_modes_of(flags.blade), "casing": casing, "law": law}
    from lobex.processes.blade_file import carried, read_blade_file

    found = read_blade_file(flags.blade_file, "lobex.read_wear")
    said = {"blade": found.modes, "casing": found.casing, "contact": found.law}
    for group, value in said.items():
        own, usual = vars(getattr(flags, group)), vars(type(getattr(flags, group))())
        given = [name for name in own if own[name] != usual[name]]
        if given and value is not None:
            raise ValueError(f"blade = {flags.blade_file!r} says what flags of {given[0]} say; drop one of the two")
    casing = casing if found.casing is None else found.casing
    return {
        "modes": found.modes,
        "casing": carried(casing, found.ring),
        "law": law if found.law is None else found.law,
    }
