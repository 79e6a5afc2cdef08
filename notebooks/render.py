"""Execute the notebooks and write what they show to docs/notebooks, as Markdown with small pictures.

    python notebooks/render.py                # all of them
    python notebooks/render.py 1_quickstart   # or some

Needs jupytext, nbconvert and ipykernel: ``pip install 'lobex[notebooks]'``.
"""

import io
import sys
from pathlib import Path

import jupytext
from nbclient import NotebookClient
from nbconvert import MarkdownExporter
from nbconvert.preprocessors import CoalesceStreamsPreprocessor
from PIL import Image

FOLDER = Path(__file__).parent
RENDERED = FOLDER.parent / "docs" / "notebooks"
# Maps have some hundred shades: fewer show as bands.
COLOURS = 128
SHARES = (1.0, 0.85, 0.7)
MOST_BYTES = 80_000


def names() -> list[str]:
    """All notebooks beside this file, without their endings."""
    return sorted(path.stem for path in FOLDER.glob("[0-9]_*.py"))


def render(name: str) -> None:
    """Write one notebook's page and its pictures."""
    notebook = jupytext.read(FOLDER / f"{name}.py")
    NotebookClient(notebook, timeout=900, kernel_name="python3").execute()
    exporter = MarkdownExporter()
    exporter.register_preprocessor(CoalesceStreamsPreprocessor, enabled=True)
    page, resources = exporter.from_notebook_node(notebook, {"output_files_dir": f"{name}_files"})
    note = f"<!-- Made by notebooks/render.py from notebooks/{name}.py: edit that. -->\n\n"
    RENDERED.mkdir(exist_ok=True)
    (RENDERED / f"{name}_files").mkdir(exist_ok=True)
    for old in (RENDERED / f"{name}_files").glob("*.png"):
        old.unlink()
    for file, data in resources["outputs"].items():
        (RENDERED / file).write_bytes(small(data))
    lines = (line.rstrip() for line in page.strip().splitlines())
    (RENDERED / f"{name}.md").write_text(note + "\n".join(lines) + "\n")


def small(png: bytes) -> bytes:
    """The picture with a palette of its own, and smaller where that is not enough."""
    image = Image.open(io.BytesIO(png)).convert("RGB")
    out = io.BytesIO()
    for share in SHARES:
        size = round(share * image.width), round(share * image.height)
        out = io.BytesIO()
        resized = image.resize(size, Image.Resampling.LANCZOS)
        resized.quantize(COLOURS, dither=Image.Dither.NONE).save(out, "png", optimize=True)
        if len(out.getvalue()) < MOST_BYTES:
            return out.getvalue()
    raise ValueError(f"a picture has {len(out.getvalue())} bytes, more than {MOST_BYTES}; draw it smaller")


if __name__ == "__main__":
    for each in sys.argv[1:] or names():
        print(each, flush=True)
        render(each)
