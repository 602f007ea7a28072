"""Sphinx configuration of the documentation site; `make docs` builds it into out/site."""

import re
import sys
import tomllib
from pathlib import Path

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
sys.path[:0] = [str(DOCS / "_ext"), str(ROOT)]

import gallery  # noqa: E402
import reference_pages  # noqa: E402

import painleve_sym  # noqa: E402

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
REPOSITORY = PROJECT["urls"]["Repository"]

project = PROJECT["name"]
author = copyright = PROJECT["authors"][0]["name"]
version = release = painleve_sym.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "sphinx_copybutton",
    "sphinx-mathjax-offline",
]
exclude_patterns = ["_ext", "_static", "_generated", "gallery/**/*.ipynb", "gallery/**/*.py"]
exclude_patterns += ["**/sg_execution_times.rst", "sg_execution_times.rst"]
suppress_warnings = ["config.cache"]

# Every unresolved link is a warning, and `make docs` makes warnings errors.
nitpicky = True
default_role = "py:obj"

# ---- Markdown and notebooks ----

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 4
nb_execution_mode = "force"
# Sliders need a running kernel; their script would be loaded from the network.
nb_ipywidgets_js = {}
nb_execution_timeout = 120
nb_execution_raise_on_error = True
# Redoing the paper takes minutes; the notebook is shown without its outputs.
nb_execution_excludepatterns = ["notebooks/regenerate-the-paper.ipynb"]

# ---- the Python interface ----

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

# ---- the gallery ----

sphinx_gallery_conf = gallery.settings(DOCS, REPOSITORY)

# ---- HTML ----

html_theme = "furo"
html_title = f"{project} {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_favicon = "_static/rod.svg"
html_extra_path = ["_generated/site"]
html_show_sourcelink = False
html_theme_options = {
    # Some pages are generated: their source is not a file of the repository.
    "top_of_page_buttons": [],
}
copybutton_prompt_text = r"\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True


def link_files_outside(app, docname, source):
    """Turn links to files of the repository outside docs/ into links to their home."""
    page = Path(app.env.doc2path(docname)).parent

    def linked(match):
        path = (page / match[2]).resolve()
        if path.exists() and not path.is_relative_to(DOCS) and path.is_relative_to(ROOT):
            kind = "tree" if path.is_dir() else "blob"
            return f"{match[1]}{REPOSITORY}/{kind}/main/{path.relative_to(ROOT).as_posix()}"
        return match[0]

    source[0] = re.sub(r"((?<!!)\[[^]!]*\]\()(?!https?:)([^)#\s]+)", linked, source[0])


def escape_bars(app, kind, name, public, options, lines):
    """Keep |F_n| of docstrings an absolute value: reST would take it for a substitution."""
    parts = [re.split(r"(``.*?``)", line) for line in lines]
    lines[:] = [
        line
        if line.lstrip().startswith((">>>", "..."))
        else "".join(p if p.startswith("``") else p.replace("|", r"\|") for p in part)
        for line, part in zip(lines, parts, strict=True)
    ]


def setup(app):
    """Write the generated pages before Sphinx reads any, and resolve names of the package."""
    app.connect("autodoc-process-docstring", escape_bars, priority=900)
    app.connect("config-inited", lambda app, config: reference_pages.write(DOCS / "_generated"))
    app.connect("source-read", link_files_outside)
    app.connect("missing-reference", reference_pages.resolve)
