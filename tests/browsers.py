"""A headless Chromium for the pages of the explorer, as Debian has it, with a profile of its own."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
DRIVER = "chromedriver"
_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--hide-scrollbars",
    "--force-device-scale-factor=1",
)
# Bokeh's widgets are in shadow roots, one within another.
_FOUND = """
const all = (root, out) => {
  for (const one of root.querySelectorAll("*")) {
    if (one.matches(arguments[0])) out.push(one);
    if (one.shadowRoot) all(one.shadowRoot, out);
  }
  return out;
};
return all(document, []);
"""

_TEXT = """
const text = (root) => Array.from(root.childNodes, (one) => one.nodeType === Node.TEXT_NODE ? one.data
  : ["STYLE", "SCRIPT"].includes(one.tagName) ? ""
  : (one.shadowRoot ? text(one.shadowRoot) : "") + text(one)).join(" ");
return document.body ? text(document.body) : "";
"""
WITHIN = """
const within = (root) => {
  for (const one of [root, ...root.querySelectorAll("*")]) {
    if (one.matches && one.matches(arguments[1])) return one;
    const inner = one.shadowRoot && within(one.shadowRoot);
    if (inner) return inner;
  }
  return null;
};
return within(arguments[0]);
"""
"""The first element within another that a CSS selector names."""


def missing():
    """What of browser, driver and selenium is not here, in words; "" where all are."""
    from importlib.util import find_spec

    if not any(map(shutil.which, BROWSERS)):
        return "no Chromium is installed"
    if not shutil.which(DRIVER):
        return "no chromedriver is installed"
    absent = [name for name in ("selenium", "panel") if find_spec(name) is None]
    return f"{absent[0]} is not installed" if absent else ""


@contextmanager
def browser(downloads=None, size=(1600, 1000)):
    """A driver of a browser that has seen nothing; what is downloaded goes to a folder."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    with tempfile.TemporaryDirectory(prefix="lobex-browser-", ignore_cleanup_errors=True) as profile:
        options = webdriver.ChromeOptions()
        options.binary_location = next(filter(None, map(shutil.which, BROWSERS)))
        for flag in (*_FLAGS, f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        driver = webdriver.Chrome(options=options, service=Service(shutil.which(DRIVER)))
        try:
            driver.set_script_timeout(60)
            if downloads is not None:
                where = {"behavior": "allow", "downloadPath": str(downloads)}
                driver.execute_cdp_cmd("Browser.setDownloadBehavior", where)
            yield driver
        finally:
            driver.quit()


@contextmanager
def served(*words, environment=None):
    """The address of the page that ``lobex explore`` serves."""
    command = [sys.executable, "-m", "lobex.shell.main", "explore", *words, "--no-show"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env={**os.environ, **(environment or {})}
    )
    try:
        assert process.stdout is not None
        for line in process.stdout:
            if found := re.search(r"http://\S+", line):
                yield found[0]
                return
        raise AssertionError(f"{' '.join(command)} ended with {process.wait()}")
    finally:
        process.terminate()
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.stdout is not None:
            process.stdout.close()


def found(driver, selector):
    """All elements that a CSS selector names, in shadow roots, too."""
    return driver.execute_script(_FOUND, selector)


def text_of(driver):
    """All that is written on the page, in shadow roots, too."""
    return driver.execute_script(_TEXT)


def model(driver, name, code, *more):
    """What JavaScript returns of ``model``, that of Bokeh with a name, and of ``more``."""
    script = (
        "const model = Bokeh.documents[0] && Bokeh.documents[0].get_model_by_name(arguments[0]);"
        f"const more = Array.from(arguments).slice(1); if (!model) return null; {code}"
    )
    return driver.execute_script(script, name, *more)


def until(driver, check, what, seconds=240):
    """Wait until ``check()`` is true; returns that."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if result := check():
            return result
        time.sleep(0.05)
    if path := os.environ.get("LOBEX_BROWSER_PICTURE"):
        driver.save_screenshot(path)
    raise AssertionError(f"in {seconds} s there was no {what}")


def downloaded(folder, name, seconds=60):
    """The file of a name once it is whole."""
    path, end = Path(folder) / name, time.monotonic() + seconds
    while time.monotonic() < end:
        if path.exists() and path.stat().st_size:
            return path
        time.sleep(0.05)
    raise AssertionError(f"{name} was not downloaded; there is {[p.name for p in Path(folder).iterdir()]}")
