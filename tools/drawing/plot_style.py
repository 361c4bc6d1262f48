"""Style of all plots: Okabe and Ito's colours, which colour-blind readers can distinguish, with a marker each."""

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from asddpg.atomic_write import write_whole
from tasks.physics import FloatArray

DPI = 120
Values = Sequence[float] | FloatArray


@dataclass(frozen=True)
class Style:
    """Name, colour and marker of a curve."""

    name: str
    colour: str
    marker: str

    def named(self, name: str) -> "Style":
        """The same style under another name."""
        return replace(self, name=name)

    def line(self, axes: Axes, x: Values, y: Iterable[float | None], size: int = 4) -> None:
        """Draw a curve with markers of that size, points; None leaves a gap."""
        values = np.array(list(y), dtype=float)
        axes.plot(x, values, color=self.colour, marker=self.marker, ms=size, label=self.name)

    def band(self, axes: Axes, x: Values, estimates: Iterable[Iterable[float | None]]) -> None:
        """Draw a curve of values with a band around it, each estimate being value, low and high."""
        value, low, high = np.array(list(estimates), dtype=float).reshape(-1, 3).T
        axes.fill_between(x, low, high, color=self.colour, alpha=0.15, linewidth=0)
        self.line(axes, x, value)


ACTOR = Style("actor alone", "#0072B2", "o")
SWITCHED = Style("switched policy", "#009E73", "s")
CONTROLLER = Style("controller alone", "#D55E00", "^")
THIRD = Style("", "#CC79A7", "D")
FOURTH = Style("", "#000000", "v")
QUARTER_COLOURS = ("#FDE0A6", "#F4A582", "#B5557E", "#4B2E83")  # light to dark: early to late
SHARES = LinearSegmentedColormap.from_list("shares", [ACTOR.colour, "#F0F0F0", CONTROLLER.colour])


class Sheet:
    """Panels in a grid, row by row in `axes`."""

    def __init__(self, title: str, columns: int, rows: int = 1, panel: tuple[float, float] = (3.6, 3.5)) -> None:
        """Lay out panels of `panel` inches (width, height)."""
        # Points; readable where a page shows the picture 740 px wide.
        rcParams.update({"font.size": 11, "axes.titlesize": 11, "figure.titlesize": 12})
        self.figure = Figure(figsize=(columns * panel[0], rows * panel[1]), layout="constrained")
        FigureCanvasAgg(self.figure)
        self.figure.suptitle(title)
        grid = self.figure.subplots(rows, columns, squeeze=False)
        self.axes: list[Axes] = list(grid.ravel())
        for axes in self.axes:
            axes.grid(visible=True, color="0.9", linewidth=0.6)
            axes.set_axisbelow(True)
            axes.spines[["top", "right"]].set_visible(False)

    def legend_below(self) -> None:
        """One legend for all panels."""
        handles, names = self.axes[0].get_legend_handles_labels()
        self.figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 3), frameon=False)

    def save(self, path: Path) -> None:
        """Write a PNG that does not depend on versions or the clock."""
        content = io.BytesIO()
        self.figure.savefig(content, dpi=DPI, metadata={"Software": None}, pil_kwargs={"optimize": True})
        write_whole(path, content.getbuffer())
