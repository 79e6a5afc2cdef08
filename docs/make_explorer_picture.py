"""Draws docs/images/explore.png anew: the explorer in Chromium, with a milling tool and a point.

python docs/make_explorer_picture.py    takes chromium, chromium-driver and lobex[test]
"""

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import matplotlib.image

from lobex.explorer.addresses import query_of
from lobex.explorer.state import STARTS, MillingNumbers, Mode, Point, Table, Tooth

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

import browsers  # noqa: E402

SIZE = 1500, 980
SHOWN = replace(
    STARTS["milling"],
    structure=Table((Mode(563.6, 0.0558, 1.4986), Mode(516.21, 0.025, 1.199, 0.0, 1.0))),
    numbers=MillingNumbers(
        tangential=6.79e8, normal=1.73824e8, feed_per_tooth=1e-4, diameter=0.01905, teeth=(Tooth(180.0),) * 2
    ),
    view=replace(STARTS["milling"].view, speed_low=75.0, speed_high=350.0, gain_high=5e-3),
    deviation=(("damping_ratio", 0.1), ("tangential", 0.05)),
    point=Point(240.0, 1e-3),
)


def main() -> None:
    """Take the picture once nothing is computed any more."""
    with browsers.served("milling") as address, browsers.browser(size=SIZE) as driver:
        driver.get(f"{address.partition('?')[0]}?{query_of(SHOWN)}")
        for name, column in (("limit", "gain"), ("band", "xs"), ("samples", "x")):
            code = f"return model.data.{column}.length"
            browsers.until(driver, lambda: browsers.model(driver, f"source of {name}", code), name, 900)  # noqa: B023
        # What is computed ahead begins a while after the rest is done.
        for _ in range(2):
            browsers.until(driver, lambda: "computing" not in browsers.text_of(driver), "end", 900)
            time.sleep(4)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "explore.png"
            driver.save_screenshot(str(path))
            matplotlib.image.imsave(HERE / "images" / "explore.png", matplotlib.image.imread(path)[..., :3])


if __name__ == "__main__":
    main()
