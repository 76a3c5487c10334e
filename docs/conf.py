"""Settings of the documentation. Build: `sphinx-build -W --keep-going -n -b html docs docs/build/html`; no network."""

import os
import sys
from html import escape
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path[:0] = [str(Path(__file__).parent / "_ext"), str(Path(__file__).parents[1])]

import pam_ident  # noqa: E402

project = "pam-ident"
author = "The pam-ident developers"
project_copyright = author
version = release = pam_ident.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "pages", "sphinx.ext.napoleon", "matplotlib.sphinxext.mathmpl"]
exclude_patterns = ["build", "_ext", "_static"]
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(?!pam_ident\.).*"),  # types of other packages: their pages are on the network
    ("py:class", r"pam_ident\..*\.(T|Task|Result)"),  # type variables
]
suppress_warnings = ["config.cache"]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 3

default_role = "literal"
napoleon_numpy_docstring = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_class_signature = "mixed"
python_use_unqualified_type_names = True
add_module_names = False
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = f"pam-ident {release}"
html_show_sourcelink = False
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["formulas.css"]
mathmpl_fontsize = 15.0
mathmpl_srcset = ["2x"]


def setup(app):
    """Formulas as pictures made here, with their LaTeX to be read out: what Sphinx does by itself asks the network for
    MathJax."""
    from matplotlib.sphinxext import mathmpl

    picture = mathmpl.latex2html

    def told(node, source):
        return picture(node, source).replace("<img ", f'<img alt="{escape(node["latex"])}" ', 1)

    mathmpl.latex2html = told
    app.add_directive("math", mathmpl.MathDirective, override=True)
