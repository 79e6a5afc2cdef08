"""The flags of ``lobex store``."""

from dataclasses import dataclass
from typing import Annotated

import tyro

Folder = Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="DIR")]


@dataclass(frozen=True)
class Status:
    """Which study a store holds, and how much of it is done; whether its chunks are sound, verify says.

    Example: lobex store status study
    """

    folder: Folder
    """Folder of the store."""


@dataclass(frozen=True)
class Verify:
    """Read every chunk and compare its checksum; exit code 1 if any is damaged.

    Example: lobex store verify study
    """

    folder: Folder
    """Folder of the store."""


@dataclass(frozen=True)
class Export:
    """Write a complete store to one file: NetCDF-4, which lobex.load reads, or a folder of Zarr 3, MATLAB or a table.

    Example: lobex store export study --to zarr
    """

    folder: Folder
    """Folder of the store."""
    to: Annotated[str | None, tyro.conf.arg(metavar="nc|zarr|mat|csv", help_behavior_hint="(default: nc)")] = None
    """Format of the file, if its path does not tell. Zarr takes lobex[zarr]."""
    out: Annotated[str | None, tyro.conf.arg(metavar="PATH", help_behavior_hint="(default: DIR.nc)")] = None
    """Path of the file, whose ending is its format."""


@dataclass(frozen=True)
class Store:
    """Look at a store, check it, or write it to one file."""

    action: tyro.conf.OmitSubcommandPrefixes[
        tyro.conf.OmitArgPrefixes[
            Annotated[Status, tyro.conf.subcommand("status")]
            | Annotated[Verify, tyro.conf.subcommand("verify")]
            | Annotated[Export, tyro.conf.subcommand("export")]
        ]
    ]
