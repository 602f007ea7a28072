"""Sphinx configuration of the documentation site; `make docs` builds it into out/site."""

import re
import sys
import tomllib
from pathlib import Path

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
sys.path[:0] = [str(DOCS / "_ext"), str(ROOT)]

import class_pages  # noqa: E402
import gallery  # noqa: E402
import reference_pages  # noqa: E402
from pygments.lexer import RegexLexer  # noqa: E402
from pygments.token import Generic  # noqa: E402

import painleve_sym  # noqa: E402
from painleve_sym.doors import public_names  # noqa: E402
from tools import references  # noqa: E402

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]

project = PROJECT["name"]
author = copyright = PROJECT["authors"][0]["name"]
version = release = painleve_sym.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "sphinx_last_updated_by_git",
    "sphinx-mathjax-offline",
    "sphinxcontrib.bibtex",
]
templates_path = ["_templates"]
exclude_patterns = ["_ext", "_static", "_templates", "_generated"]
exclude_patterns += ["gallery/**/*.ipynb", "gallery/**/*.py"]
exclude_patterns += ["**/sg_execution_times.rst", "sg_execution_times.rst"]
suppress_warnings = ["config.cache", "git.subprocess_error", "git.too_shallow"]

# Every unresolved link is a warning, and `make docs` makes warnings errors.
nitpicky = True
default_role = "py:obj"
# A block without a language is text, not Python.
highlight_language = "none"

# ---- Markdown and notebooks ----

myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
nb_execution_mode = "force"
# Sliders need a running kernel; their script would be loaded from the network.
nb_ipywidgets_js = {}
nb_execution_timeout = 120
nb_execution_raise_on_error = True
# Redoing the paper takes minutes; the notebook is shown without its outputs.
nb_execution_excludepatterns = ["notebooks/regenerate-the-paper.ipynb"]

# ---- the literature ----

# The page shows notes on what is unconfirmed, as every export does.
EXPORTED = DOCS / "_generated" / "references.bib"
EXPORTED.parent.mkdir(exist_ok=True)
LITERATURE = references.exported_bibliography(references.read_bibliography())
for work in references.read_bibliography():
    if not work.authors:
        # The style asks for the authors of an article.
        plain = work.bibtex.replace("@article", "@misc").replace("  journal =", "  howpublished =")
        LITERATURE = LITERATURE.replace(work.bibtex, plain)
EXPORTED.write_text(LITERATURE, "utf-8")
bibtex_bibfiles = [EXPORTED.relative_to(DOCS).as_posix()]
bibtex_default_style = "plain"
bibtex_cite_id = "{key}"

# ---- the Python interface ----

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
# Not preserved: signatures of runs have arguments that the source does not name one by one.
autodoc_preserve_defaults = False
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
# reference/api/Trajectory.html is easier to find than reference/api/painleve_sym.Trajectory.html.
autosummary_filename_map = {
    f"{door}.{name}": name for name, door in public_names().items()
}
autosummary_context = {"bases": reference_pages.python_bases()}

# ---- the gallery ----

sphinx_gallery_conf = gallery.settings(DOCS)

# ---- HTML ----

html_theme = "furo"
html_title = f"{project} {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = [("site.js", {"defer": "defer"})]
html_favicon = "_static/rod.svg"
html_extra_path = ["_generated/site"]
html_show_sourcelink = False
html_last_updated_fmt = f"%Y-%m-%d (version {release})"
html_theme_options = {
    # Some pages are generated: their source is not a file of the repository.
    "top_of_page_buttons": [],
}
copybutton_prompt_text = r"\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True


class ConsoleLexer(RegexLexer):
    """A terminal: what is typed behind ``$``, and what is printed, which has no grammar."""

    name = "Console"
    tokens = {  # noqa: RUF012
        "root": [(r"^\$ ", Generic.Prompt, "typed"), (r".*\n", Generic.Output)],
        "typed": [(r".*\n", Generic.Strong, "#pop")],
    }


def link_folders_outside(app, docname, source):
    """Show a link to a folder of the repository outside docs/ as its path: it has no page."""
    page = Path(app.env.doc2path(docname)).parent

    def shown(match):
        path = (page / match[2]).resolve()
        outside = path.is_dir() and not path.is_relative_to(DOCS)
        return f"{match[1]} (`{path.relative_to(ROOT).as_posix()}`)" if outside else match[0]

    source[0] = re.sub(r"(?<!!)\[([^]!]*)\]\((?!https?:)([^)#\s]+)\)", shown, source[0])


def write_links_and_bars(app, kind, name, public, options, lines):
    """Make a link of a page that a docstring names, and keep |F_n| an absolute value."""
    for number, line in enumerate(lines):
        if not line.lstrip().startswith((">>>", "...")):
            line = re.sub(r"`?\bdocs/([\w/-]+)\.md\b`?", r":doc:`/\1`", line)
            parts = re.split(r"(``.*?``)", line)
            lines[number] = "".join(
                part if part.startswith("``") else part.replace("|", r"\|") for part in parts
            )


def link_works(app, env):
    """Let links such as references.md#keller1986 lead to the entries of the bibliography."""
    anchors = env.metadata["references"].setdefault("myst_slugs", {})
    for citation in env.get_domain("cite").citations:
        anchors[citation.citation_id] = (0, citation.citation_id, citation.key)


def setup(app):
    """Write the generated pages before Sphinx reads any, and resolve names of the package."""
    app.add_lexer("console", ConsoleLexer)
    # Before numpydoc, whose priority is 500.
    app.connect("autodoc-process-docstring", class_pages.begin_with_example, priority=400)
    app.connect("autodoc-process-signature", class_pages.hide_constructor, priority=400)
    app.connect("autodoc-process-docstring", write_links_and_bars, priority=900)
    app.connect("config-inited", lambda app, config: reference_pages.write(DOCS / "_generated"))
    app.connect("config-inited", class_pages.sign_typed_dicts)
    app.connect("source-read", link_folders_outside)
    app.connect("env-updated", link_works)
    app.connect("missing-reference", reference_pages.resolve)
    app.connect("doctree-resolved", gallery.name_thumbnails)
