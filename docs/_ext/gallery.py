"""Gallery of the scripts in examples/: which are executed, and how their figures are shown."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from docutils import nodes
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

SECTIONS = {
    "first_steps": "First steps",
    "paradox": "The paradox",
    "studies": "Studies",
}
STUDIES = "They run for minutes or take options; the figure of each was made by the script.\n"

PICTURES = {
    "bench_rod": "examples/studies/bench_rod/bench-rod.png",
    "block_on_belt": "docs/figures/block-on-belt.png",
    "corrected_jump": "docs/figures/corrected-jump.png",
    "fates": "examples/studies/singular_point/fates.png",
    "fit_noisy_impacts": "docs/figures/fit-force.png",
    "growth": "examples/studies/reverse_chatter/growth.png",
    "impact_energy": "docs/figures/impact-energy.png",
    "impact_in_space": "docs/figures/impact-in-space.png",
    "landing": "examples/studies/rigid_rod/landing.png",
    "optimal_control": "docs/figures/optimal-control.png",
    "paradox_in_space": "examples/studies/paradox_in_space/paradox-in-space.png",
    "rigid_rod": "examples/studies/rigid_rod/rigid-rod.png",
    "run_all": "docs/figures/peers.png",
    "sensitive_impact": "docs/figures/sensitive-impact.png",
    "sticking_feet": "docs/figures/sticking-feet.png",
    "study": "docs/figures/critical-force-convergence.png",
    "tangential_compliance": "docs/figures/tangential-compliance.png",
    "woodpecker": "docs/figures/woodpecker.png",
}
"""Figures of the scripts that are not executed; a study without one is not in the gallery."""

DOCSTRING = re.compile(r'"""(.+?)("""|\n(.*?)""")', re.DOTALL)
"""The question of a script, and the text below it."""


def stage(root: Path, folder: Path) -> None:
    """Copy the scripts, one folder per section, in the form that sphinx-gallery reads.

    The first line of a docstring becomes the title and the alternative text of the figures.
    """
    shutil.rmtree(folder, ignore_errors=True)
    for section, title in SECTIONS.items():
        (folder / section).mkdir(parents=True)
        text = STUDIES if section == "studies" else ""
        header = f"{title}\n{'-' * len(title)}\n\n{text}"
        (folder / section / "GALLERY_HEADER.rst").write_text(header, "utf-8")
        for script in sorted((root / "examples" / section).rglob("*.py")):
            picture = PICTURES.get(script.stem, "") if section == "studies" else None
            if picture is None or (root / picture).is_file():
                (folder / section / script.name).write_text(staged(script, picture), "utf-8")
    header = "Gallery\n=======\n\nOne question per script; each is in the folder ``examples``.\n"
    (folder / "GALLERY_HEADER.rst").write_text(header, "utf-8")


def staged(script: Path, picture: str | None) -> str:
    """Return a script with its title as a heading and, where it is not executed, its figure."""
    text = script.read_text("utf-8")
    docstring = DOCSTRING.match(text)
    assert docstring, f"{script}: no docstring"
    question, rest = docstring[1].strip(), (docstring[3] or "").strip()
    line = "=" * len(question)
    shown, end = [line, question, line, "", rest, ""], ""
    if picture:
        shown += [f".. image:: /../{picture}", f"   :alt: {question}", ""]
        end = f"\n# sphinx_gallery_thumbnail_path = '../{picture}'\n"
    return '"""\n' + "\n".join(shown) + '"""' + text[docstring.end() :] + end


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
        question = Path(block_vars["src_file"]).read_text("utf-8").splitlines()[2]
        return figure_rst(paths, gallery_conf["src_dir"], fig_titles=question)


def name_thumbnails(app, tree, docname):
    """Give the picture of each thumbnail the title of its script, which is the link behind it."""
    picture = None
    for node in tree.findall():
        if isinstance(node, nodes.image) and "_thumb." in node["uri"]:
            picture = node
        elif picture is not None and isinstance(node, nodes.reference):
            picture["alt"], picture = node.astext(), None


def settings(docs: Path) -> dict:
    """Return the configuration of sphinx-gallery, after the scripts are staged."""
    stage(docs.parent, docs / "_generated" / "examples")
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
