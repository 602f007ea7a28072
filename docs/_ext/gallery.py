"""Gallery of the scripts in examples/: which are executed, and how their figures are shown."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

SECTIONS = {
    "first_steps": "First steps",
    "paradox": "The paradox",
    "studies": "Studies, not executed here: they run for minutes or take options",
}

THUMBNAILS = {
    "bench_rod": "examples/studies/bench_rod/bench-rod.png",
    "corrected_jump": "docs/figures/corrected-jump.png",
    "study": "docs/figures/critical-force-convergence.png",
    "fit_noisy_impacts": "docs/figures/fit-force.png",
    "sensitive_impact": "docs/figures/sensitive-impact.png",
    "sticking_feet": "docs/figures/sticking-feet.png",
    "growth": "examples/studies/reverse_chatter/growth.png",
    "tangential_compliance": "docs/figures/tangential-compliance.png",
    "fates": "examples/studies/singular_point/fates.png",
}
"""Figures of scripts that are not executed."""


def stage(examples: Path, folder: Path) -> None:
    """Copy the scripts, one folder per section; the first line of a docstring becomes the title."""
    shutil.rmtree(folder, ignore_errors=True)
    for section, title in SECTIONS.items():
        (folder / section).mkdir(parents=True)
        header = f"{title}\n{'-' * len(title)}\n"
        (folder / section / "GALLERY_HEADER.rst").write_text(header, "utf-8")
        for script in sorted((examples / section).rglob("*.py")):
            text = script.read_text("utf-8")
            question = re.match(r'"""(.+)', text)
            assert question, f"{script}: no docstring"
            line = "=" * len(question[1])
            text = text.replace(question[1], f"\n{line}\n{question[1]}\n{line}", 1)
            if script.stem in THUMBNAILS:
                text += f"# sphinx_gallery_thumbnail_path = '../{THUMBNAILS[script.stem]}'\n"
            (folder / section / script.name).write_text(text, "utf-8")
    header = "Gallery\n=======\n\nOne question per script; each is in the folder ``examples``.\n"
    (folder / "GALLERY_HEADER.rst").write_text(header, "utf-8")


class FigureScraper:
    """Shows the figures that a block of a script made; the package draws without pyplot."""

    def __call__(self, block, block_vars, gallery_conf):
        """Save new `Figure` objects among the globals of the script; return their reST."""
        shown = block_vars.setdefault("shown_figures", set())
        paths = []
        for value in block_vars["example_globals"].values():
            if isinstance(value, Figure) and id(value) not in shown:
                shown.add(id(value))
                path = next(block_vars["image_path_iterator"])
                value.savefig(path, dpi=150)
                paths.append(path)
        return figure_rst(paths, gallery_conf["src_dir"])


def settings(docs: Path, repository: str) -> dict:
    """Return the configuration of sphinx-gallery, after the scripts are staged."""
    stage(docs.parent / "examples", docs / "_generated" / "examples")
    return {
        "examples_dirs": ["_generated/examples"],
        "gallery_dirs": ["gallery"],
        "filename_pattern": r"examples/(first_steps|paradox)/",
        "image_scrapers": (FigureScraper(),),
        "download_all_examples": False,
        "show_memory": False,
        "min_reported_time": 1,
        "plot_gallery": True,
        "abort_on_example_error": True,
    }
