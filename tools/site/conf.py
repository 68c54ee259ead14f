"""How Sphinx renders the pages that `build` has laid out."""

project = "Corroborate"
author = "the authors of Corroborate"
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
root_doc = "README"
html_theme = "furo"
html_title = "Corroborate"
html_show_copyright = False
html_copy_source = False
html_show_sourcelink = False
# Headings are linked to as on GitHub, so that one link works in both places.
myst_heading_anchors = 6
# Captions of pages are not numbered, and quotes stay as they are typed: they may be code.
smartquotes = False
# Languages of blocks that no highlighter knows are shown as they are.
highlight_language = "none"
# Headings begin where a page's do; a page may begin at the second level.
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
