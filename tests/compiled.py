"""What a test run compiles: programs by file, told at its end, so that a test that compiles much is seen."""

import collections

import jax
import pytest

_COMPILED = "/jax/core/compile/backend_compile_duration"
_FOUND = "/jax/compilation_cache/cache_hits"
_NAME = "compiled"
_SHOWN = 5


class Counter:
    """Programs and seconds of this process since the last look; those that the cache held are none."""

    def __init__(self) -> None:
        self.programs, self.seconds = 0, 0.0
        jax.monitoring.register_event_duration_secs_listener(self._compiled)
        jax.monitoring.register_event_listener(self._found)

    def _compiled(self, event: str, duration: float, **_: object) -> None:
        if event == _COMPILED:
            self.programs, self.seconds = self.programs + 1, self.seconds + duration

    def _found(self, event: str, **_: object) -> None:
        if event == _FOUND:
            self.programs -= 1

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_teardown(self, item: pytest.Item) -> None:
        """The report of a test's end carries what it compiled, from any worker."""
        item.user_properties.append((_NAME, (self.programs, self.seconds)))
        self.programs, self.seconds = 0, 0.0

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """The files that compiled most."""
        files: collections.Counter[str] = collections.Counter()
        programs: collections.Counter[str] = collections.Counter()
        for report in (r for reports in terminalreporter.stats.values() for r in reports):
            if getattr(report, "when", None) == "teardown":
                count, seconds = dict(report.user_properties).get(_NAME, (0, 0.0))
                file = report.nodeid.partition("::")[0]
                files[file] += seconds
                programs[file] += count
        if programs.total():
            terminalreporter.section("programs compiled")
            for file, seconds in files.most_common(_SHOWN):
                terminalreporter.line(f"{programs[file]:6} in {seconds:6.1f} s  {file}")
            terminalreporter.line(f"{programs.total():6} in {files.total():6.1f} s  together")
