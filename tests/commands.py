"""Running ``lobex``: as a user does, in a process of its own, or within the tests' up to where computing begins."""

import subprocess
import sys
import warnings

from lobex._warnings import LobexWarning
from lobex.shell import environment
from lobex.shell.main import main


def run(*arguments, cwd=None, timeout=300):
    """Run ``lobex`` in a process of its own."""
    command = [sys.executable, "-m", "lobex.shell.main", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, cwd=cwd)


class Shell:
    """``lobex`` without a process of its own, in the folder of the test: ``code``, ``out`` and ``err`` of a command."""

    def __init__(self, folder, patch, capture):
        self.folder, self.patch, self.capture = folder, patch, capture
        patch.chdir(folder)
        # The settings of the tests' own process stay.
        patch.setattr(environment, "prepare_jax", lambda: None)
        patch.setattr(warnings, "showwarning", warnings.showwarning)

    def __call__(self, *arguments):
        self.patch.setattr(sys, "argv", ["lobex", *arguments])
        self.capture.readouterr()
        self.code = 0
        with warnings.catch_warnings():
            # A user is told of them; here they are errors otherwise.
            warnings.simplefilter("always", LobexWarning)
            try:
                main()
            except SystemExit as stop:
                self.code = stop.code or 0
            finally:
                self.out, self.err = self.capture.readouterr()
        return self

    def refuses(self, *arguments):
        """Whether a command ends as bad input must: exit code 2, one line, no file. Returns the line.

        What can hardly be meant may have been told before it.
        """
        self(*arguments)
        assert (self.code, self.out) == (2, "")
        told = [line for line in self.err.splitlines(keepends=True) if not line.startswith("lobex: warning: ")]
        assert len(told) == 1
        assert told[0].startswith("lobex: error: ")
        assert list(self.folder.iterdir()) == []
        return told[0]
