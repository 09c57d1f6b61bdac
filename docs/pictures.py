"""Draw the pictures of docs/pictures, and write the printable worksheet: python docs/pictures.py.

A picture of a gallery is the figure that the code above it returns; each file has its code in
its metadata, by which a test notices that a picture is older than its page.
"""

import ast
import base64
import inspect
import re
from io import BytesIO
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt


DOCS = Path(__file__).parent
PICTURES = DOCS / "pictures"
GALLERIES = (DOCS / "gallery.md", DOCS / "related-bodies.md")
COLOURS = 48
STYLE = """
@page { size: A4; margin: 16mm 18mm; }
body { font: 11pt/1.45 system-ui, sans-serif; max-width: 46em; margin: 0 auto; padding: 0 1em; }
h1 { font-size: 17pt; }
article + article { break-before: page; margin-top: 3em; }
h2 { font-size: 13pt; break-after: avoid; }
img { max-width: 100%; max-height: 8.5cm; }
pre { font-size: 9pt; background: #f3f4f6; padding: 0.6em; }
table { border-collapse: collapse; } td, th { border: 1px solid #bbb; padding: 0.2em 0.8em; }
article:first-of-type li {
  break-inside: avoid; padding-bottom: 3.2em; border-bottom: 1px dotted #aaa; margin-bottom: 0.8em;
}
"""


def momentum() -> Any:
    """Draw the inclination and the components of the angular momentum of the canonical top."""
    import numpy as np
    from matplotlib.figure import Figure

    import tippetop as tt

    rows = tt.run("inverting", until=8.0).trajectory
    figure = Figure(figsize=(7, 4.4), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    top.plot(rows.time, np.degrees(rows.theta), color="0.2", lw=0.7)
    top.set(ylabel="θ (degrees)", yticks=[0, 90, 180])
    L_z = rows.L.sel(xyz="z")
    L_3 = (rows.L * rows.axis).sum("xyz")
    bottom.plot(rows.time, L_z / L_z[0], label="$L_z$")
    bottom.plot(rows.time, L_3 / L_z[0], label="$L_3$")
    bottom.set(xlabel="t (s)", ylabel="relative to $L_z$ at the start")
    bottom.legend(loc="lower left")
    return figure


def through_contact() -> Any:
    """Draw the inclination of `flying` with the band of a change of mu by 0.1 %."""
    import numpy as np
    from matplotlib.figure import Figure

    import tippetop as tt

    wrt = ["friction.mu"]
    made = tt.derivatives.sensitivities("flying", wrt, until=12.0, output_step=0.004)
    rows = made.run.trajectory
    change = 1e-3 * made.run.attributes["friction"]["mu"]
    theta = np.degrees(rows.theta)
    half = np.degrees(change * abs(made.trajectory.theta.sel(parameter="friction.mu")))
    figure = Figure(figsize=(7, 5), layout="constrained")
    top, bottom = figure.subplots(2, 1)
    top.fill_between(rows.time, theta - half, theta + half, color="C1", alpha=0.5, lw=0)
    top.plot(rows.time, theta, color="0.2", lw=0.7)
    top.set(xlim=(7.5, 9.5), ylim=(40, 180), ylabel="θ (degrees)")
    bottom.semilogy(rows.time, half, color="C1", lw=0.7)
    bottom.set(xlim=(0, 12), ylim=(1e-5, 30), xlabel="t (s)", ylabel="width to each side (degrees)")
    return figure


OWN = momentum, through_contact
"""Pictures whose code is here; each is called as its function."""


def blocks(page: Path) -> list[tuple[str, str]]:
    """Return the Python of a page, each block with the name of the picture below it, or ""."""
    text = page.read_text(encoding="utf-8")
    pattern = r"```python\n(.*?)```\n(?:\n!\[[^\]]*\]\(pictures/([\w-]+)\.png\))?"
    return [(code, name) for code, name in re.findall(pattern, text, flags=re.S)]


def sources() -> dict[str, str]:
    """Return the code of each picture by its name."""
    named = {name: code for page in GALLERIES for code, name in blocks(page) if name}
    return named | {one.__name__: inspect.getsource(one) for one in OWN}


def save(figure: Any, name: str, source: str) -> None:
    """Write a figure as a small PNG."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    memory, about = BytesIO(), PngInfo()
    figure.savefig(memory, format="png", dpi=80)
    about.add_itxt("Source", source)
    image = Image.open(memory).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    image.save(PICTURES / f"{name}.png", optimize=True, pnginfo=about)


def draw() -> None:
    """Draw all pictures."""
    PICTURES.mkdir(exist_ok=True)
    for one in OWN:
        save(one(), one.__name__, inspect.getsource(one))
    for page in GALLERIES:
        draw_page(page)


def draw_page(page: Path) -> None:
    """Draw the pictures of a gallery."""
    names: dict[str, Any] = {}
    for code, name in blocks(page):
        *before, last = ast.parse(code).body
        if not name:
            before.append(last)
        exec(compile(ast.Module(before, []), name, "exec"), names)
        if name:
            assert isinstance(last, ast.Expr)
            figure = eval(compile(ast.Expression(last.value), name, "eval"), names)
            save(figure, name, code)


def worksheet() -> str:
    """Return the lesson and the handout as one HTML file to print."""
    pages = DOCS / "tutorials"
    render = MarkdownIt().enable("table").render
    texts = [(pages / name).read_text(encoding="utf-8") for name in ("lesson.md", "handout.md")]
    body = "".join(f"<article>{render(text)}</article>\n" for text in texts)

    def embedded(found: re.Match) -> str:
        data = base64.b64encode((pages / found[1]).read_bytes()).decode()
        return f'src="data:image/png;base64,{data}"'

    body = re.sub(r'src="([^"]+\.png)"', embedded, body)
    return (
        '<!doctype html>\n<html lang="en">\n<meta charset="utf-8">\n'
        f"<title>A lesson: the tippe top</title>\n<style>{STYLE}</style>\n{body}</html>\n"
    )


if __name__ == "__main__":
    draw()
    (DOCS / "tutorials" / "worksheet.html").write_text(worksheet(), encoding="utf-8")
