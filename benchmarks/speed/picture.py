"""The measured times as bars on logarithmic axes, one panel for each kind of work."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.speed.page import Section, figures

COLOURS = {"ours": "#c03020", "hand": "#4070a0", "peer": "#909090", "floor": "#d0d0d0"}
WORDS = {
    "ours": "Backsolve",
    "hand": "written by hand",
    "peer": "other libraries",
    "floor": "writing the outputs",
}


def draw(sections: Sequence[Section], path: Path) -> None:
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    panels = [panel for section in sections for panel in section.bars]
    figure = Figure(figsize=(11, 4.4 * ((len(panels) + 1) // 2)), layout="constrained")
    for axes, (title, unit, bars) in zip(
        figure.subplots(-(-len(panels) // 2), 2).flat, panels, strict=False
    ):
        bars = sorted(bars, key=lambda bar: -bar[1])
        places = range(len(bars))
        numbers = [number for _, number, _ in bars]
        axes.barh(places, numbers, color=[COLOURS[kind] for *_, kind in bars], height=0.72)
        axes.set_xscale("log")
        axes.set_xlim(min(numbers) / 2, max(numbers) * 6)
        axes.set_yticks(places, [name for name, *_ in bars], fontsize=8)
        axes.set_title(f"{title}, {unit}", fontsize=10, loc="left")
        axes.tick_params(axis="x", labelsize=8)
        axes.spines[["top", "right"]].set_visible(False)
        for place, number in zip(places, numbers, strict=True):
            axes.text(number * 1.08, place, figures(number), va="center", fontsize=8)
    kinds = [kind for kind in COLOURS if any(bar[2] == kind for *_, bars in panels for bar in bars)]
    figure.legend(
        handles=[Patch(color=COLOURS[kind], label=WORDS[kind]) for kind in kinds],
        loc="outside lower center",
        ncols=len(kinds),
        fontsize=9,
        frameon=False,
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=100)
